//! Results of a run: a folder with a summary, arrays, spectra and plots.
//!
//! `folder` decides when and under which name the rest appears, `placing` gives it that name and finds it again where a
//! run is unfinished; `checkpoint` stores the state of such a run beside it; `npy` streams arrays during the run,
//! `arrays` checks them when it is resumed; `summary`, `spectra`, `vibration` and `plots` are written at its end, into
//! the folder or, by `files`, into memory; `inputs` are the files that a scene reads, `table` formats tables and reads
//! those of a folder, `trace` is the timeline of a run, `tread_pattern` shows a tread. `cost` records the times and
//! work of a run and shows them on the terminal.

pub(crate) mod arrays;
pub(crate) mod checkpoint;
pub(crate) mod cost;
mod disk;
pub(crate) mod error;
pub(crate) mod files;
pub(crate) mod folder;
pub(crate) mod growing_table;
pub(crate) mod inputs;
pub(crate) mod npy;
pub(crate) mod pass_by;
pub(crate) mod placing;
pub(crate) mod plots;
pub(crate) mod sections;
pub(crate) mod sound;
pub(crate) mod spectra;
pub(crate) mod summary;
pub(crate) mod table;
pub(crate) mod trace;
pub(crate) mod tread_pattern;
pub(crate) mod vibration;

pub use checkpoint::{CheckpointError, CheckpointFault};
pub use error::ResultsError;
pub(crate) use files::ResultFiles;
pub(crate) use folder::ResultsFolder;
pub use inputs::Input;
pub use plots::PlotError;
pub use sound::{RatedLevel, ReceiverSpectrum, ReceiverSummary, SoundError, SoundSummary};
pub use summary::{AxleMotion, CellsSummary, ContactQuality, LoadResult, Outcome, RollingResistance, Summary};
pub use vibration::{VelocityPlace, VelocitySpectrum};
