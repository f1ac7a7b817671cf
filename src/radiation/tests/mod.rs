//! Tests against closed-form and independent solutions, and of convergence.

mod flank;
mod reference;
mod set_up;
mod sphere;
mod tyre;
