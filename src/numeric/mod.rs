//! Numerical building blocks that know no physics.

pub mod aligned;
pub mod bounded_least_squares;
pub mod complex_field;
pub mod digest;
pub mod element;
pub mod in_parallel;
pub mod lagrange;
pub mod lanes;
pub mod largest;
pub mod legendre;
pub mod precision;
pub mod rational;
pub mod ring;
pub mod running_moments;
pub mod sinc;
pub mod split_rule;
pub mod straight_line;
pub mod student;
pub mod transform_length;
pub mod windowed_sinc;

pub use aligned::Aligned;
pub use complex_field::ComplexField;
pub use element::Element;
pub use lanes::{Lanes, MOST_LANES};
pub use largest::largest_or_zero;
pub use precision::{double, single};
pub use ring::Ring;
pub use running_moments::RunningMoments;
pub use sinc::sinc;
pub use split_rule::SplitRule;
pub use straight_line::StraightLine;
pub use student::quantile_of_student;
pub use transform_length::{transform_length, transform_multiply_adds};
