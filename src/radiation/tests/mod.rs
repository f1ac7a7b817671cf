//! Against closed solutions and against itself.

mod set_up;
mod sphere;
mod tyre;
