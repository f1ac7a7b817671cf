//! Results to look at and to compare: a self-contained page, and tables of differences.
//!
//! [`Stored`] reads a results folder again, `Comparison` compares several, [`page()`] makes one HTML file of one or
//! more of them: pictures, tables and sound inside, no network. `export` writes the formats of other programs. `html`
//! has the parts of pages.

pub(crate) mod compare;
pub(crate) mod export;
pub(crate) mod html;
mod measured_levels;
pub(crate) mod page;
mod plan;
pub(crate) mod radiation;
pub(crate) mod road;
mod sections;
pub(crate) mod slices;
mod stored;
pub(crate) mod sweep;
pub(crate) mod tyre;
pub(crate) mod validation;

pub use crate::effects::section::ReportError;
pub use crate::effects::stored::{Stored, StoredError};
pub(crate) use compare::Comparison;
pub(crate) use measured_levels::MeasuredLevels;
pub(crate) use page::PAGE_HEAD;
pub use page::page;
pub(crate) use plan::plan_record;
pub(crate) use sections::decision_table;
