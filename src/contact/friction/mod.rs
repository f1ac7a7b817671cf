//! Contact over cells with friction: sticking, slipping and open cells, and their forces in three components.
//!
//! - [`product`]: displacements of all cells by the forces on all of them within an instant;
//! - [`conditions`]: contact and friction law of a cell, how far it is missed, and the linear equation that stands for
//!   it near a guess;
//! - [`linear`]: solution of the linear equations of all cells, preconditioned by the neighbourhood of each;
//! - [`sweeps`]: cell after cell, which converges where linear equations do not;
//! - [`search`]: the forces of an instant;
//! - [`modal`]: displacements by past forces, by poles, its `wave_group` and `late` channels;
//! - [`free_creep`]: creep of a wheel that rolls freely;
//! - [`law`]: coefficients of friction and bonds from step to step;
//! - [`zone`]: one step, from the history to the forces.

pub(crate) mod conditions;
pub(crate) mod free_creep;
mod late;
pub(crate) mod law;
mod linear;
pub(crate) mod modal;
pub(crate) mod product;
pub(crate) mod search;
mod sweeps;
pub(crate) mod wave_group;
pub(crate) mod zone;

#[cfg(test)]
mod modal_tests;
#[cfg(test)]
mod search_tests;
