//! Effects as the program lists them: each begins an observer for a run that calls for it.

use std::sync::atomic::AtomicBool;

use super::channel::Channel;
use super::error::RunError;
use super::observer::EffectObserver;
use super::section::{Figure, LevelTable, ReportError, Section};
use super::stored::Stored;
use crate::contact::cells::gaps::GapMap;
use crate::contact::footprint::WindowShape;
use crate::contact::geometry::Geometry;
use crate::contact::static_contact::StaticContact;
use crate::counters::{Meter, Progress};
use crate::plan::decisions::Row;
use crate::plan::{Amounts, Choice, Plan};
use crate::response::SliceErrors;
use crate::response::vibration::CarriedWaves;
use crate::scene::{LoadedScene, Scene, SceneError};
use crate::tyre::influence::CellInfluence;
use crate::tyre::poles::RationalModel;

/// Contact of a run that is about to begin.
#[derive(Clone, Debug)]
pub struct ContactFacts {
    /// Where the window's elements are.
    pub geometry: Geometry,
    /// Shape of the window.
    pub(crate) shape: WindowShape,
    /// Size of a point along and across \[m\].
    pub point_size: [f64; 2],
    /// Static contact on a smooth road.
    pub at_rest: StaticContact,
    /// Factor of the influence functions; 1 unless a bedding's carcass is scaled.
    pub scale: f64,
    /// Spring compliance per element \[m/N\]; 0 without springs.
    pub spring: f64,
    /// Highest frequency that levels are vouched for \[Hz\], apart from slices: the plan's, or the road's where that
    /// ends before.
    pub valid_to: f64,
    /// Errors of contact over slices, where they are known.
    pub(crate) slice_errors: Option<SliceErrors>,
    /// Gaps between tread and road at places of the run, where their air is heard.
    pub(crate) gaps: Vec<GapMap>,
}

impl ContactFacts {
    /// Returns the highest frequency that levels of force and vibration are vouched for \[Hz\].
    pub fn force_valid_to(&self) -> f64 {
        self.slice_errors.as_ref().map_or(f64::INFINITY, |errors| errors.force_valid_to).min(self.valid_to)
    }

    /// Returns the highest frequency that levels of sound are vouched for as far as the contact goes \[Hz\].
    pub fn sound_valid_to(&self) -> f64 {
        self.slice_errors.as_ref().map_or(f64::INFINITY, |errors| errors.sound_valid_to).min(self.valid_to)
    }
}

/// Models of the tyre that the contact has made, where an effect demands them.
#[derive(Default)]
pub struct TyreModels {
    /// The tyre's poles, where the past is carried by them.
    pub poles: Option<RationalModel>,
    /// The waves of cells, and the influence between cells at once beyond them.
    pub waves: Option<(Vec<CarriedWaves>, CellInfluence)>,
}

/// Ingredients of an observer.
pub struct Begin<'a> {
    /// The scene.
    pub loaded: &'a LoadedScene,
    /// Its plan.
    pub plan: &'a Plan,
    /// The contact.
    pub contact: &'a ContactFacts,
    /// Models of the tyre.
    pub models: &'a mut TyreModels,
    /// Flag of a run whose results stay in memory; such a run makes no pictures.
    pub in_memory: bool,
    /// Tells the memory that a plan needs on one thread \[bytes\].
    pub planned_memory: fn(&Plan) -> f64,
    /// Warnings that the user should act on.
    pub warnings: &'a mut Vec<String>,
    /// Flag that ends the work once it is set.
    pub stop: &'a AtomicBool,
    /// Watcher of the work.
    pub progress: &'a mut dyn Progress,
    /// Cost so far.
    pub meter: &'a mut Meter,
}

/// Effect that reads the steps of a run.
pub(crate) trait Effect: Sync {
    /// Returns the name, also of its part of a checkpoint.
    fn name(&self) -> &'static str;

    /// Returns the arrays that it gives, beside the files of its end.
    fn channels(&self) -> &'static [Channel] {
        &[]
    }

    /// Returns the rows of the plan's table, each with its decision and its switch.
    fn rows(&self) -> &'static [Row] {
        &[]
    }

    /// Tells whether it takes the models of the tyre that the contact makes, in a scene with every setting decided.
    fn takes_models(&self, _scene: &Scene) -> bool {
        false
    }

    /// Refuses wishes that a scene with every setting decided cannot give.
    ///
    /// # Errors
    /// [`SceneError::Invalid`].
    fn check(&self, _loaded: &LoadedScene, _scene: &Scene) -> Result<(), SceneError> {
        Ok(())
    }

    /// Tells a setting that it has chosen for a plan.
    fn choice(&self, _plan: &Plan) -> Option<Choice> {
        None
    }

    /// Lists what is known of a plan before its run, beside its decisions.
    fn notes(&self, _plan: &Plan) -> Vec<String> {
        Vec::new()
    }

    /// Notes in a plan what the user's cache holds for it.
    fn look_up(&self, _plan: &mut Plan) {}

    /// Adds its work and memory to those of a plan; none where it is off.
    fn add_amounts(&self, _plan: &Plan, _amounts: &mut Amounts) {}

    /// Lists the results that a run of a plan will not give.
    fn missing(&self, _plan: &Plan) -> Vec<String> {
        Vec::new()
    }

    /// Returns the tables of third octaves that it writes.
    fn levels(&self) -> &'static [LevelTable] {
        &[]
    }

    /// Tells its figures of a run whose folder is read again.
    fn figures(&self, _stored: &Stored) -> Vec<Figure> {
        Vec::new()
    }

    /// Shows its results of a run on a page that shows others beside.
    ///
    /// # Errors
    /// [`ReportError`].
    fn sections(&self, _stored: &Stored, _all: &[Stored]) -> Result<Vec<Section>, ReportError> {
        Ok(Vec::new())
    }

    /// Begins an observer; `None` where the scene does not call for it, or, with a warning, where the run is too short.
    ///
    /// # Errors
    /// [`RunError`].
    fn begin(&self, begin: &mut Begin<'_>) -> Result<Option<Box<dyn EffectObserver>>, RunError>;
}
