//! The extension module of the Python package, `tyrewave._native`: a thin layer over what any program can use of this
//! library. Dictionaries, units and whatever else is specific to Python are made in `python/tyrewave`.
//!
//! Everything that takes time goes through [`work`]: without the interpreter's lock, on a separate pool of threads, and
//! stopped by Ctrl-C. Arrays are handed over without copying.

mod contact;
mod error;
mod road;
mod run;
mod scene;
mod signal;
mod study;
mod tyre;
mod work;

use pyo3::prelude::*;

/// Functions that the package `tyrewave` is built on.
#[pymodule]
mod _native {
    #[pymodule_export]
    use super::contact::{indent, slice_curve};
    #[pymodule_export]
    use super::error::{Complaint, RunError, SceneError};
    #[pymodule_export]
    use super::road::{heights, road_description, slice_displacements};
    #[pymodule_export]
    use super::run::{channels, plan, resume, run_in_memory, run_to_folder};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::signal::{read_sound, third_octaves};
    #[pymodule_export]
    use super::study::{effects, radiation, sweep, tyre};
    #[pymodule_export]
    use super::tyre::{compliance, influence, influence_spectrum, mobility};
}
