//! What is kept on disk beside the results: whole files, sealed ones, the states of runs and a cache.
//!
//! - [`pending_file`]: files that are whole or not there;
//! - [`sealed_file`]: the one binary format, for checkpoints and cache entries alike;
//! - [`cache`]: results that take long, kept for the next run;
//! - [`state`]: a saved state against what it is restored into.
//!
//! None of them knows what the bytes mean: a type that is kept says so by deriving serde's traits.

pub mod cache;
pub mod pending_file;
pub mod sealed_file;
pub mod state;

pub use cache::{Cache, CacheEntry, CacheError, Cached, Kind};
pub use pending_file::PendingFile;
pub use sealed_file::{Format, Unusable};
pub use state::StateError;
