//! Results in the formats of other programs.
//!
//! - [`mod@mat`]: one MATLAB file of all arrays and tables;
//! - [`mod@uff`]: one universal file of total force and spectra, data sets 58;
//! - [`vtk`]: the contact patch over time, for ParaView.
//!
//! Sound files are written by the run itself. HDF5 is left out: its writers in pure Rust, `hdf5-pure` and
//! `rust-hdf5`, have no stable version yet, and what such a file would hold is in the `.mat` file.
//!
//! A folder of results needs none of this in Python; numpy reads it, as [`PYTHON`] does:
//!
//! ```python
#![doc = include_str!("read_results.py")]
//! ```

mod error;
pub(crate) mod mat;
pub(crate) mod uff;
pub(crate) mod vtk;

pub(crate) use error::ExportError;
pub use mat::MAT_HEAD;
pub(crate) use mat::mat;
pub use uff::UFF_HEAD;
pub(crate) use uff::uff;
pub(crate) use vtk::Patch;
pub use vtk::VTK_HEAD;

/// Ten lines of Python that read a results folder.
pub const PYTHON: &str = include_str!("read_results.py");
