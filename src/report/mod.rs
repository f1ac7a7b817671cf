//! Results to open and to compare: a page that needs nothing but a browser, and tables of differences.
//!
//! [`Stored`] reads a results folder again, [`Comparison`] holds several against each other, [`page()`] makes one HTML
//! file of one or more of them: pictures, tables and sound inside, no network. [`mod@export`] puts one into formats of
//! other programs. [`html`] is what pages are made of.

pub mod compare;
pub mod export;
pub mod html;
pub mod mobility;
pub mod page;
mod picture;
mod plan;
pub mod radiation;
pub mod road;
mod sections;
pub mod slices;
mod stored;
pub mod tyre;
pub mod validation;

pub use crate::effects::ReportError;
pub use crate::effects::stored::{Stored, StoredArray, StoredError};
pub use compare::Comparison;
pub use page::{PAGE_HEAD, page};
pub use plan::plan_record;
pub use sections::decision_table;
