//! The paper that the model is from (K. Larsson, *Numerical modelling of the tyre/road contact*, Chalmers): its figures
//! 2 to 6 and its statements on performance, each recomputed and compared.
//!
//! 1. everything without rolling: mobilities, the road;
//! 2. one run with the scene's laws, kept for the patch's forces, the spectra and the search; the other laws of tread
//!    and slices beside it;
//! 3. equation 4 and the local law with ever smaller time steps, the axle held;
//! 4. influence functions: some of the sums, and a fit.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::counters::{Progress, Stage};
use crate::plan::Plan;
use crate::run::RunError;
use crate::scene::{LoadedScene, Scene};
use crate::study::trial::{SETTLING, Trials};
use serde::Serialize;

use super::equation_4::Equation4;
use super::influence::InfluenceShare;
use super::mobility::MobilityFigure;
use super::patch_force::{PatchForces, Recorder};
use super::road::RoadFigure;
use super::search::{SearchFigure, Solves};
use super::slice::SliceFigure;
use super::statement::Statement;
use super::tread_laws::TreadLaws;

/// Extent of the computation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct PaperOptions {
    /// Elements round the tyre of the runs that are drawn.
    pub elements: usize,
    /// Simulated time of each of them after the warm-up \[s\].
    pub duration: f64,
    /// Elements of the runs whose steps are halved.
    pub coarse_elements: usize,
    /// Simulated time of each of those \[s\].
    pub coarse_duration: f64,
    /// How often their steps are halved.
    pub halvings: u32,
    /// Highest frequency compared \[Hz\].
    pub highest: f64,
    /// Frequencies of the mobilities from 50 Hz to 3 kHz, 6 or more.
    pub frequencies: u32,
    /// Slices of the road whose spread is looked at.
    pub slices: usize,
    /// Sums of influence functions that are timed.
    pub sums: usize,
}

impl Default for PaperOptions {
    /// Options that take a minute or less on two cores.
    fn default() -> Self {
        Self {
            elements: 512,
            duration: 4.0,
            coarse_elements: 256,
            coarse_duration: 1.0,
            halvings: 4,
            highest: 1000.0,
            frequencies: 120,
            slices: 1000,
            sums: 256,
        }
    }
}

/// All figures and statements.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Paper {
    /// Extent of the computation.
    pub options: PaperOptions,
    /// Figure 2.
    pub mobility: MobilityFigure,
    /// Figure 3.
    pub road: RoadFigure,
    /// Figure 4.
    pub slice: SliceFigure,
    /// Figure 5.
    pub patch_forces: PatchForces,
    /// Figure 6.
    pub tread_laws: TreadLaws,
    /// Solves of the contact search.
    pub search: SearchFigure,
    /// Equation 4 with ever smaller steps.
    pub equation_4: Equation4,
    /// Share of the influence functions.
    pub influence: InfluenceShare,
    /// Every statement of the paper beside the finding.
    pub statements: Vec<Statement>,
}

/// Recomputes the paper's figures and statements for a scene's tyre and road.
///
/// # Errors
/// Errors of the road and of any of the runs; [`RunError::Interrupted`].
pub(super) fn recompute(
    loaded: &LoadedScene,
    options: &PaperOptions,
    stop: &AtomicBool,
    progress: &mut dyn Progress,
) -> Result<Paper, RunError> {
    let PaperOptions { highest, halvings, coarse_duration, .. } = *options;
    let rolled = loaded.scene.rolling.warm_up + loaded.scene.rolling.duration;
    let scene = drawn(&loaded.scene, options);
    let loaded = LoadedScene::from_scene(&scene, "paper")?;
    let plan = Plan::of(&loaded)?;
    progress.stage(Stage::Influence);
    let mobility = MobilityFigure::of(&plan.decisions.tyre, options.frequencies);
    progress.stage(Stage::Road);
    let road = RoadFigure::of(&loaded)?;

    let of_laws = 6.0 * (scene.rolling.warm_up + scene.rolling.duration);
    let refined = 3.0 * f64::from(halvings + 1) * (SETTLING + coarse_duration);
    let mut trials = Trials::new(of_laws + refined, stop, progress);
    let (elastic, recorder) = trials.roll_with(&scene, Recorder::new(&plan))?;
    let patch_forces = recorder.finish(&elastic.plan);
    let tread_laws = TreadLaws::of((&scene, &elastic), highest, &mut trials)?;
    let slice = SliceFigure::of(&loaded, options.slices, &elastic, highest, &mut trials)?;

    let mut coarse = scene.clone();
    coarse.numerics.elements = options.coarse_elements;
    let held = trials.held(&coarse, coarse_duration)?;
    let (equation_4, search) = Equation4::of(&held, halvings, highest, &mut trials)?;
    if stop.load(Ordering::Relaxed) {
        return Err(RunError::Interrupted { kept: None });
    }
    trials.finish();
    let local = Solves::of(&elastic);
    let search = SearchFigure { equation_4: search.unwrap_or_else(|| local.clone()), local };

    progress.stage(Stage::Fit);
    let whole = elastic.plan.steps as f64 * elastic.plan.time_step;
    let influence = InfluenceShare::of(&scene, (rolled, elastic.seconds / whole), options.sums, stop)?;
    progress.finish();
    let mut statements = Vec::new();
    statements.extend(mobility.statements());
    statements.push(road.statement());
    statements.push(slice.statement());
    statements.push(patch_forces.statement());
    statements.extend(tread_laws.statements());
    statements.extend(search.statements());
    statements.extend(influence.statements());
    statements.push(equation_4.statement());
    Ok(Paper {
        options: *options,
        mobility,
        road,
        slice,
        patch_forces,
        tread_laws,
        search,
        equation_4,
        influence,
        statements,
    })
}

/// Scene of the runs that are drawn, without outputs of vibration.
fn drawn(scene: &Scene, options: &PaperOptions) -> Scene {
    let mut scene = scene.clone();
    scene.numerics.forget_wishes();
    scene.numerics.elements = options.elements;
    scene.rolling.duration = options.duration;
    scene.outputs.vibration = None;
    scene
}
