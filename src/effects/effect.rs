//! Interface of the effects to the program: each begins an observer for a run that includes it.

use super::channel::Channel;
use super::error::RunError;
use super::observer::EffectObserver;
use super::section::{Figure, LevelTable, PageSection, ReportError};
use super::stored::Stored;
use crate::contact::cells::gaps::GapMap;
use crate::contact::footprint::WindowShape;
use crate::contact::geometry::Geometry;
use crate::contact::static_contact::StaticContact;
use crate::counters::Job;
use crate::plan::decisions::DecisionRow;
use crate::plan::{Amounts, Plan, PlannedSetting};
use crate::response::SliceErrors;
use crate::response::vibration::CarriedWaves;
use crate::road::RoadProfiles;
use crate::scene::{LoadedScene, Scene, SceneError};
use crate::tyre::influence::CellInfluence;
use crate::tyre::poles::RationalModel;

/// Contact of a run that is about to begin.
#[derive(Clone, Debug)]
pub struct ContactFacts {
    /// Positions of the window's elements.
    pub geometry: Geometry,
    /// Number of points along and across the window.
    pub(crate) shape: WindowShape,
    /// Size of a point along and across \[m\].
    pub point_size: [f64; 2],
    /// Static contact on a smooth road.
    pub at_rest: StaticContact,
    /// Factor of the influence functions; 1 unless a bedding's carcass is scaled.
    pub scale: f64,
    /// Spring compliance per element \[m/N\]; 0 without springs.
    pub spring: f64,
    /// Highest frequency up to which levels are valid \[Hz\], apart from slices: the plan's, or the road's where that
    /// is lower.
    pub valid_to: f64,
    /// Errors of contact over slices, where they are known.
    pub(crate) slice_errors: Option<SliceErrors>,
    /// Gaps between tread and road at places of the run, where sound needs their air.
    pub(crate) gaps: Vec<GapMap>,
}

impl ContactFacts {
    /// Highest frequency up to which levels of force and vibration are valid \[Hz\].
    pub fn force_valid_to(&self) -> f64 {
        self.slice_errors.as_ref().map_or(f64::INFINITY, |errors| errors.force_valid_to).min(self.valid_to)
    }

    /// Highest frequency up to which levels of sound are valid as far as the contact determines it \[Hz\].
    pub fn sound_valid_to(&self) -> f64 {
        self.slice_errors.as_ref().map_or(f64::INFINITY, |errors| errors.sound_valid_to).min(self.valid_to)
    }
}

/// Models of the tyre that the contact has computed, for effects that need them.
#[derive(Default)]
pub struct TyreModels {
    /// Poles of the tyre, where the history is carried by them.
    pub poles: Option<RationalModel>,
    /// Waves of cells that the history carries, and the instantaneous influence between cells beyond them.
    pub waves: Option<(Vec<CarriedWaves>, CellInfluence)>,
}

/// Input of the observers at the start of a run.
pub struct RunStart<'a> {
    /// Scene of the run.
    pub loaded: &'a LoadedScene,
    /// Plan of the run.
    pub plan: &'a Plan,
    /// Contact of the run.
    pub contact: &'a ContactFacts,
    /// Models of the tyre; an observer may take them.
    pub models: &'a mut TyreModels,
    /// Profiles of the road, where sections need them; an observer may take them. `None` for the plane.
    pub(crate) profiles: &'a mut Option<RoadProfiles>,
    /// True for a run whose results stay in memory; such a run makes no pictures.
    pub in_memory: bool,
    /// Work and memory of a plan.
    pub amounts: fn(&Plan) -> Amounts,
}

/// An effect, which reads the steps of a run.
pub(crate) trait Effect: Sync {
    /// Name, also of its part of a checkpoint.
    fn name(&self) -> &'static str;

    /// Arrays that it writes step by step, or at the end.
    fn channels(&self) -> &'static [Channel] {
        &[]
    }

    /// Rows of the plan's table, each with its decision and its switch.
    fn rows(&self) -> &'static [DecisionRow] {
        &[]
    }

    /// True if it uses the models of the tyre that the contact computes; the scene has every setting decided.
    fn takes_models(&self, _scene: &Scene) -> bool {
        false
    }

    /// Refuses requests that a scene with every setting decided cannot fulfil.
    ///
    /// # Errors
    /// [`SceneError::Invalid`].
    fn check(&self, _loaded: &LoadedScene, _scene: &Scene) -> Result<(), SceneError> {
        Ok(())
    }

    /// A setting that it has chosen for a plan.
    fn choice(&self, _plan: &Plan) -> Option<PlannedSetting> {
        None
    }

    /// Facts known about a plan before its run, in addition to its decisions.
    fn notes(&self, _plan: &Plan) -> Vec<String> {
        Vec::new()
    }

    /// Notes in a plan what the user's cache holds for it.
    fn look_up(&self, _plan: &mut Plan) {}

    /// Adds its work and memory to those of a plan; nothing where it is off.
    fn add_amounts(&self, _plan: &Plan, _amounts: &mut Amounts) {}

    /// Results that a run of a plan will not give.
    fn missing(&self, _plan: &Plan) -> Vec<String> {
        Vec::new()
    }

    /// Tables of third octaves that it writes.
    fn levels(&self) -> &'static [LevelTable] {
        &[]
    }

    /// Its figures of a run whose folder was read.
    fn figures(&self, _stored: &Stored) -> Vec<Figure> {
        Vec::new()
    }

    /// Sections on its results of a run, for a page on several runs.
    ///
    /// # Errors
    /// [`ReportError`].
    fn sections(&self, _stored: &Stored, _all: &[Stored]) -> Result<Vec<PageSection>, ReportError> {
        Ok(Vec::new())
    }

    /// Begins an observer; `None` where the scene does not include the effect, or, with a warning, where the run is too
    /// short.
    ///
    /// # Errors
    /// [`RunError`].
    fn begin(&self, begin: &mut RunStart<'_>, job: &mut Job<'_>) -> Result<Option<Box<dyn EffectObserver>>, RunError>;
}
