//! OpenCRG: curved regular grids of road elevation.
//!
//! `header` reads the sections, `data` the columns of numbers behind them, `file` follows includes and assembles the
//! grid, `strip` cuts out the part that a tyre needs.
//!
//! Format: ASAM OpenCRG 1.2, as far as elevations need it. Heights are functions of (u, v), the distance along the
//! reference line and the distance to its left; the course of the line in the plane has no effect on them.

mod data;
mod file;
mod header;
mod strip;

#[cfg(test)]
pub(in crate::road) use file::Crg;
pub(super) use file::included;
pub(crate) use strip::read;
