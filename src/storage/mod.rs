//! Files beside the results: sealed ones, the states of runs, a cache, and tables that are read.
//!
//! - [`mod@array`]: `.npy` arrays that are read;
//! - [`input`]: files that are read as a whole: regular ones of a bounded size;
//! - [`pending_file`]: files that are complete or absent;
//! - [`sealed_file`]: the one binary format, for checkpoints and cache entries alike;
//! - [`cache`]: results that take long, stored for the next run;
//! - [`flat_folder`]: listing, access and removal of a folder of files;
//! - [`separated`]: tables of cells separated by commas, semicolons or tabs;
//! - [`state`]: the part of a run that evolves, saved and restored in place.
//!
//! None of them knows what the bytes mean: types that are stored derive serde's traits.

pub(crate) mod array;
pub(crate) mod cache;
pub(crate) mod flat_folder;
pub(crate) mod input;
pub(crate) mod pending_file;
pub(crate) mod sealed_file;
pub(crate) mod separated;
pub(crate) mod state;

pub use cache::Cached;
pub(crate) use cache::{Cache, CacheError, CacheKind};
pub(crate) use input::InputError;
pub(crate) use pending_file::PendingFile;
pub(crate) use sealed_file::Format;
pub use sealed_file::Unusable;
pub(crate) use state::StateError;
