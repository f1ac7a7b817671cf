//! Against closed solutions and against itself.

mod flank;
mod reference;
mod set_up;
mod sphere;
mod tyre;
