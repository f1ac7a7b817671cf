//! Numerical building blocks that know no physics.

pub mod complex_field;
pub mod lanes;
pub mod matrix2;
pub mod rational;
pub mod ring;
pub mod scaled_series;
pub mod straight_line;
pub mod tail_sum;

pub use complex_field::ComplexField;
pub use lanes::{Lanes, MOST_LANES};
pub use matrix2::Matrix2;
pub use ring::Ring;
pub use straight_line::StraightLine;
pub mod nnls;
pub mod windowed_sinc;
