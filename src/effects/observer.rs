//! Completed steps of a run, and the interface of their observers.

use std::any::Any;
use std::collections::VecDeque;

use ndarray::ArrayView2;

use super::error::RunError;
use crate::contact::footprint::Footprint;
use crate::contact::geometry::Geometry;
use crate::counters::{Meter, Stage};
use crate::plan::Plan;
use crate::response::{BandLevel, LevelErrors, SliceErrors};
use crate::results::files::ResultFiles;
use crate::results::plots::{SurfaceMap, ThirdOctavePlot};
use crate::results::sound::SoundSummary;
use crate::results::summary::Outcome;
use crate::results::vibration::VibrationSummary;
use crate::road::strip::RoadStrip;
use crate::scene::LoadedScene;
use crate::storage::state::{StateError, StateStream};

/// A completed step of a run.
#[derive(Clone, Copy)]
pub struct Step<'a> {
    /// Number of the step, from 0.
    pub number: u64,
    /// Time \[s\].
    pub time: f64,
    /// True after the warm-up: the step counts for results.
    pub counts: bool,
    /// Indentation of the rigid tyre into z = 0 \[m\].
    pub indentation: f64,
    /// Sum of the forces \[N\].
    pub total_force: f64,
    /// Power that the forces put into the tyre \[W\], where an observer needs it; from two steps before the end of the
    /// warm-up on, since backward differences need two earlier steps.
    pub power: Option<f64>,
    /// Length of the contact patch \[m\].
    pub contact_length: f64,
    /// Size of a point along and across \[m\].
    pub point_size: [f64; 2],
    /// Forces and displacements of the patch.
    pub footprint: &'a Footprint,
    /// Positions of the window's elements.
    pub geometry: &'a Geometry,
}

/// End of a run, for results over all of its steps.
pub(crate) struct End<'a> {
    /// Scene of the run.
    pub loaded: &'a LoadedScene,
    /// Plan of the run.
    pub plan: &'a Plan,
    /// Number of steps recorded.
    pub steps: u64,
    /// Highest frequency up to which levels of the force are valid \[Hz\].
    pub valid_to: f64,
    /// Errors of contact over slices, where they are known.
    pub slice_errors: Option<&'a SliceErrors>,
    /// Forces of the last step.
    pub footprint: &'a Footprint,
    /// Positions of the elements of that step.
    pub geometry: &'a Geometry,
    /// Road under the patch.
    pub road: &'a RoadStrip,
}

impl End<'_> {
    /// Draws values of the points of the patch, `across` per column, each of a length and width `size` \[m\].
    ///
    /// # Errors
    /// [`RunError`] of the picture, or of writing it.
    pub(crate) fn draw_points(
        &self,
        files: &dyn ResultFiles,
        [file, name, quantity]: [&str; 3],
        (values, across): (&[f64], usize),
        size: [f64; 2],
    ) -> Result<(), RunError> {
        let Ok(values) = ArrayView2::from_shape((values.len() / across, across), values) else { return Ok(()) };
        let title = format!("{name}: {}", self.loaded.title());
        let (along, first_position) = ("Along, from the axle", self.geometry.first_position());
        let map = SurfaceMap { title: &title, along, quantity, values, first_position, size };
        Ok(files.write_text(file, &map.to_svg()?)?)
    }
}

/// Draws named third octaves in one picture, unless there are none.
///
/// # Errors
/// [`RunError`] of the picture, or of writing it.
pub(crate) fn draw_third_octaves(
    loaded: &LoadedScene,
    [file, name, quantity]: [&str; 3],
    drawn: &[(String, Vec<BandLevel>)],
    errors: LevelErrors,
    files: &dyn ResultFiles,
) -> Result<(), RunError> {
    if drawn.iter().all(|(_, levels)| levels.is_empty()) {
        return Ok(());
    }
    let title = format!("{name}, third octaves: {}", loaded.title());
    let spectra = drawn.iter().map(|(name, levels)| (name.as_str(), levels.as_slice())).collect();
    Ok(files.write_text(file, &ThirdOctavePlot { title: &title, quantity, spectra, errors }.to_svg()?)?)
}

/// Results of a run's effects, for its summary.
#[derive(Debug, Default)]
pub(crate) struct Found {
    /// Figures after the warm-up.
    pub outcome: Outcome,
    /// Vibration of the tyre.
    pub vibration: Option<VibrationSummary>,
    /// Sound at the receivers.
    pub sound: Option<SoundSummary>,
    /// Pressures by order of the revolution, receiver by receiver, for a table of another effect.
    pub pressures_by_order: Vec<ReceiverOrders>,
    /// Warnings that the user should act on.
    pub warnings: Vec<String>,
}

/// Pressures at a receiver by order of the revolution.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ReceiverOrders {
    /// Name of the receiver in files.
    pub receiver: String,
    /// Root mean square at the receiver's first point \[Pa\], by order.
    pub pressures: Vec<f64>,
}

/// Observer of the steps of one run: see [`Simulation::with`](crate::Simulation::with).
pub trait Observer: Any + Send {
    /// True if it reads [`Step::power`], which is computed only then.
    fn needs_power(&self) -> bool {
        false
    }

    /// Takes the next step.
    ///
    /// # Errors
    /// [`RunError`]; the run cannot continue then.
    fn observe(&mut self, step: &Step<'_>, meter: &mut Meter) -> Result<(), RunError>;
}

/// Observer of an effect: it can resume with a stopped run, and computes results of the steps that it has taken.
pub(crate) trait EffectObserver: Observer {
    /// Saves or restores all that evolves, see [`Evolving`](crate::storage::state::Evolving).
    fn state(&mut self, _state: &mut StateStream<'_>) -> Result<(), StateError> {
        Ok(())
    }

    /// Observer of a segment of the run, `from` steps after its first one, for [`Self::join`]; `None` where the totals
    /// of the steps say all.
    fn of_segment(&self, _from: u64) -> Option<Box<dyn EffectObserver>> {
        None
    }

    /// Takes what the observer of the next segment has found.
    fn join(&mut self, _segment: Box<dyn EffectObserver>, _meter: &mut Meter) {}

    /// Rows of the table of sections, by section in the order of the road, which are taken from it once all observers
    /// have those of a section; `None` without any.
    fn section_rows(&mut self) -> Option<&mut VecDeque<String>> {
        None
    }

    /// Number of blocks of steps whose evaluation stops the march for long and is still to come, and its stage if one
    /// may come within so many steps.
    fn remaining_blocks(&self, _within: u64) -> (u64, Option<Stage>) {
        (0, None)
    }

    /// Adds the figures of the steps so far to the summary.
    fn report(&self, _end: &End<'_>, _found: &mut Found) {}

    /// Writes tables, pictures, sounds and maps of a complete run, and adds their summaries.
    ///
    /// # Errors
    /// Errors of the files and pictures.
    fn write(
        &self,
        _end: &End<'_>,
        _files: &dyn ResultFiles,
        _found: &mut Found,
        _meter: &mut Meter,
    ) -> Result<(), RunError> {
        Ok(())
    }
}
