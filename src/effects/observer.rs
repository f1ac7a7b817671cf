//! Steps that are done, and the observers that read them.

use std::any::Any;

use ndarray::ArrayView2;

use super::error::RunError;
use crate::contact::footprint::Footprint;
use crate::contact::geometry::Geometry;
use crate::counters::Meter;
use crate::plan::Plan;
use crate::response::SliceErrors;
use crate::results::files::ResultFiles;
use crate::results::plots::PatchMap;
use crate::results::sound::SoundSummary;
use crate::results::summary::Outcome;
use crate::results::vibration::VibrationSummary;
use crate::road::strip::RoadStrip;
use crate::scene::LoadedScene;
use crate::storage::state::{StateError, StateReader, StateWriter};

/// Step of a run that is done.
#[derive(Clone, Copy)]
pub struct Step<'a> {
    /// Number of the step.
    pub number: u64,
    /// Time \[s\].
    pub time: f64,
    /// True after the warm-up.
    pub counts: bool,
    /// Indentation of the rigid tyre into z = 0 \[m\].
    pub indentation: f64,
    /// Sum of the forces \[N\].
    pub total_force: f64,
    /// Power that the forces put into the tyre \[W\], where an observer needs it, from two steps before those that
    /// count: backward differences look so far back.
    pub power: Option<f64>,
    /// Length of the contact \[m\].
    pub contact_length: f64,
    /// Size of a point along and across \[m\].
    pub point_size: [f64; 2],
    /// Forces and displacements.
    pub footprint: &'a Footprint,
    /// Where the window's elements are.
    pub geometry: &'a Geometry,
}

/// End of a run, as its effects look back on it.
pub(crate) struct End<'a> {
    /// The scene.
    pub loaded: &'a LoadedScene,
    /// Its plan.
    pub plan: &'a Plan,
    /// Steps recorded.
    pub steps: u64,
    /// Highest frequency that levels of the force are vouched for \[Hz\].
    pub valid_to: f64,
    /// Errors of contact over slices, where they are known.
    pub slice_errors: Option<&'a SliceErrors>,
    /// Forces of the last step.
    pub footprint: &'a Footprint,
    /// Where its elements are.
    pub geometry: &'a Geometry,
    /// The road under it.
    pub road: &'a RoadStrip,
}

impl End<'_> {
    /// Draws values of the points of the patch, `across` to a column, of a size along and across \[m\].
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
        let map = PatchMap { title: &title, quantity, values, first_position: self.geometry.first_position(), size };
        Ok(files.write_text(file, &map.to_svg()?)?)
    }
}

/// Findings of a run's effects, as its summary tells them.
#[derive(Debug, Default)]
pub(crate) struct Found {
    /// Figures after the warm-up.
    pub outcome: Outcome,
    /// Vibration of the tyre.
    pub vibration: Option<VibrationSummary>,
    /// Sound at the receivers.
    pub sound: Option<SoundSummary>,
    /// Pressures by order of the revolution, receiver by receiver, where a table has them.
    pub pressures_by_order: Vec<ReceiverOrders>,
    /// Warnings that the user should act on.
    pub warnings: Vec<String>,
}

/// Pressures at a receiver by order of the revolution.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ReceiverOrders {
    /// Receiver, as files name it.
    pub receiver: String,
    /// By order, root mean square at the receiver's first point \[Pa\].
    pub pressures: Vec<f64>,
}

/// Observer of the steps of one run: see [`Simulation::with`](crate::Simulation::with).
pub trait Observer: Any + Send {
    /// Tells whether it reads the power of a step.
    fn needs_power(&self) -> bool {
        false
    }

    /// Takes in a step.
    ///
    /// # Errors
    /// [`RunError`]; the run cannot go on then.
    fn observe(&mut self, step: &Step<'_>, meter: &mut Meter) -> Result<(), RunError>;
}

/// Observer of an effect: it goes on with a run that was stopped, and makes results of what it has seen.
pub(crate) trait EffectObserver: Observer {
    /// Takes the state down.
    ///
    /// # Errors
    /// [`StateError`].
    fn save(&self, _state: &mut StateWriter) -> Result<(), StateError> {
        Ok(())
    }

    /// Goes on from the state of an observer of the same run.
    ///
    /// # Errors
    /// [`StateError`].
    fn restore(&mut self, _state: &mut StateReader<'_>) -> Result<(), StateError> {
        Ok(())
    }

    /// Tells the figures of the steps so far.
    fn tell(&self, _end: &End<'_>, _found: &mut Found) {}

    /// Writes tables, pictures, sounds and maps of a complete run, and tells what they are summed up by.
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
