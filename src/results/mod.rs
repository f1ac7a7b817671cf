//! Results of a run: a folder with a summary, arrays, spectra and plots.
//!
//! [`folder`] decides when and under which name the rest appears, `placing` gives it that name; [`checkpoint`] keeps
//! the state of an unfinished run beside it, [`mod@unfinished`] finds it again; [`npy`] streams arrays while the run
//! goes on, [`arrays`] checks them when it goes on again; [`summary`], [`spectra`], [`vibration`] and [`plots`] are
//! written at its end, into the folder or, by [`files`], into memory; [`profile_table`] is for the terminal,
//! [`mod@table`] says how tables look, [`read_table`] reads those of a folder again, [`mod@trace`] is the timeline of a
//! run. [`cost`] says what it took.

pub mod arrays;
pub mod checkpoint;
pub mod cost;
mod disk;
pub mod error;
pub mod files;
pub mod folder;
pub mod npy;
mod placing;
pub mod plots;
pub mod profile_table;
pub mod read_table;
pub mod sound;
pub mod spectra;
pub mod summary;
pub mod table;
pub mod trace;
pub mod unfinished;
pub mod vibration;

pub use checkpoint::CheckpointError;
pub use error::ResultsError;
pub use files::ResultFiles;
pub use folder::ResultsFolder;
pub use npy::{NpyWriter, Row};
pub use plots::PlotError;
pub use summary::Summary;
