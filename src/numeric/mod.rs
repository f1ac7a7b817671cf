//! Numerical building blocks without physics.

pub(crate) mod aligned;
pub(crate) mod background;
pub(crate) mod bounded_least_squares;
pub(crate) mod complex_field;
pub(crate) mod digest;
pub(crate) mod element;
pub(crate) mod in_parallel;
pub(crate) mod lagrange;
pub(crate) mod lanes;
pub(crate) mod largest;
pub(crate) mod legendre;
pub(crate) mod rational;
pub(crate) mod ring;
pub(crate) mod statistics;
pub(crate) mod symmetric_matrix;
pub(crate) mod transform_length;
pub(crate) mod windowed_sinc;

pub use aligned::Aligned;
pub(crate) use complex_field::{ComplexField, double, single};
pub(crate) use element::Element;
pub(crate) use lanes::{Lanes, MOST_LANES};
pub(crate) use largest::{largest_above, largest_or_zero};
pub(crate) use legendre::SplitRule;
pub use ring::Ring;
pub(crate) use statistics::{RunningMoments, StraightLine, quantile_of_student};
pub(crate) use symmetric_matrix::{ComplexSymmetricMatrix, SymmetricMatrix};
pub(crate) use transform_length::{transform_length, transform_multiply_adds};
pub(crate) use windowed_sinc::sinc;
