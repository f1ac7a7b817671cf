//! Numerical building blocks that know no physics.

pub mod nnls;
pub mod windowed_sinc;
