//! Numerical building blocks that know no physics.

pub mod complex_field;
pub mod digest;
pub mod lanes;
pub mod matrix2;
pub mod nnls;
pub mod rational;
pub mod ring;
pub mod running_moments;
pub mod scaled_series;
pub mod straight_line;
pub mod tail_sum;
pub mod transform_length;
pub mod windowed_sinc;
pub mod windows;

pub use complex_field::ComplexField;
pub use lanes::{Lanes, MOST_LANES};
pub use matrix2::Matrix2;
pub use ring::Ring;
pub use running_moments::RunningMoments;
pub use straight_line::StraightLine;
pub use transform_length::{transform_length, transform_multiply_adds};
