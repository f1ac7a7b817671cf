//! What the user writes: scene files, parsed and checked, with every complaint pointing into the file.

pub mod model;

pub use model::*;
