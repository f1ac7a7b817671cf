//! Plan and run: the only place that knows the whole order.

pub mod progress;

pub use progress::{Progress, Unwatched};
