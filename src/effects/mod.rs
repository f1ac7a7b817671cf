//! Effects of a run: each reads the completed steps and computes results from them. Whatever changes the problem
//! itself, such as rotation or friction, is physics and no effect.
//!
//! An effect is a folder and a line in [`EFFECTS`]. It states its rows of the plan's table, its work and memory before
//! a run, and its arrays as [`Channel`]s. It begins an [`Observer`] for a run that includes it, summarises at the end,
//! and shows its results as [`PageSection`]s of a page. An effect that is off has no observer, no array, no memory.
//!
//! - [`force`]: the total force, its spectrum and the patch's forces: part of every run;
//! - [`resistance`]: rolling resistance from the power put in;
//! - [`cells`]: area, pressure and force across of a contact of cells;
//! - [`friction`]: tangential forces, moment and slip of a contact with friction;
//! - [`tread_pattern`]: map of the tread's depths, force and sound by order of the revolution;
//! - [`vibration`]: velocities of belt and tread;
//! - [`sections`]: levels and texture of each section of the road;
//! - [`sound`]: pressures at the receivers, levels and files to listen to.

pub(crate) mod cells;
pub(crate) mod channel;
pub(crate) mod effect;
mod error;
pub(crate) mod force;
pub(crate) mod friction;
pub(crate) mod observer;
pub(crate) mod resistance;
pub(crate) mod section;
pub(crate) mod sections;
pub(crate) mod sound;
pub(crate) mod stored;
pub(crate) mod tread_pattern;
pub(crate) mod vibration;

pub(crate) use channel::{Arrays, Channel, KeptArray};
pub(crate) use effect::{ContactFacts, Effect, RunStart, TyreModels};
pub use error::RunError;
pub(crate) use observer::{EffectObserver, End, Found, Observer, Step};
pub(crate) use section::{Figure, GREY, LevelTable, PageSection, ReportError, SectionBlock};

/// All effects, in the order of their work.
pub(crate) static EFFECTS: [&dyn Effect; 8] = [
    &force::ForceEffect,
    &resistance::ResistanceEffect,
    &cells::CellsEffect,
    &friction::FrictionEffect,
    &tread_pattern::TreadPatternEffect,
    &vibration::VibrationEffect,
    &sections::SectionsEffect,
    &sound::SoundEffect,
];

/// Channel of an array by its file's name without the extension; several maps may share one.
pub fn channel(name: &str) -> Option<&'static Channel> {
    let exact = channels().find(|channel| channel.name == name);
    exact.or_else(|| channels().find(|channel| channel.is_written_at_the_end() && name.starts_with(channel.name)))
}

/// All channels, effect by effect.
pub fn channels() -> impl Iterator<Item = &'static Channel> {
    EFFECTS.into_iter().flat_map(Effect::channels)
}
