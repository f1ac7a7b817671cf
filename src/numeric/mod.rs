//! Numerical building blocks that know no physics.

pub mod bounded_least_squares;
pub mod complex_field;
pub mod digest;
pub mod lanes;
pub mod legendre;
pub mod rational;
pub mod ring;
pub mod running_moments;
pub mod straight_line;
pub mod transform_length;
pub mod windowed_sinc;

pub use complex_field::ComplexField;
pub use lanes::{Lanes, MOST_LANES};
pub use ring::Ring;
pub use running_moments::RunningMoments;
pub use straight_line::StraightLine;
pub use transform_length::{transform_length, transform_multiply_adds};
