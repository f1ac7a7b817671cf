//! Levels of a finer mesh (`outputs.levels`): short runs over the run's mesh and over the finer one, and the correction
//! of the run's levels by what they find.

use crate::contact::geometry::Geometry;
use crate::counters::{Counters, Job};
use crate::effects::RunError;
use crate::plan::meshes::short_scenes;
use crate::plan::{MeshCorrections, Plan};
use crate::response::accumulator::FEWEST_SAMPLES;
use crate::response::{MeshCorrection, PowerSpectrum, SpectrumError};
use crate::results::spectra::LOWEST_FREQUENCY;
use crate::results::summary::FinerMesh;
use crate::run::simulation::{Results, Simulation};
use crate::scene::{LoadedScene, MeshLevels, Scene};

/// Times that are asked for beyond this factor of those of the first comparison lead to a second one.
const LONGER: f64 = 1.1;

/// A scene with all settings decided and its plan, with the corrections of its levels if it wants those of a finer
/// mesh: its run then lasts no longer than their standard error takes, unless its sound is listened to.
///
/// # Errors
/// [`RunError`] of the short runs.
pub(crate) fn corrected(
    loaded: LoadedScene,
    mut plan: Plan,
    job: &mut Job<'_>,
) -> Result<(LoadedScene, Plan), RunError> {
    let Some(levels) = plan.wanted_levels().cloned() else { return Ok((loaded, plan)) };
    let longest = plan.scene.rolling.duration;
    let highest = plan.valid_to;
    // 1. Both meshes over the shortest time, again over a longer one if the errors ask for that.
    let mut corrections = compare(&loaded, &plan, &levels, plan.compared_at_first(), job)?;
    let short = corrections.needed_comparison(highest, longest);
    if short > LONGER * corrections.mesh.seconds {
        corrections = compare(&loaded, &plan, &levels, short, job)?;
    }
    // 2. The run as long as it has to be.
    if !plan.sound().is_some_and(|sound| sound.is_stored()) {
        plan.shorten(corrections.needed_run(highest, longest));
    }
    plan.take_corrections(corrections);
    Ok((loaded.settled(plan.scene.clone()), plan))
}

/// Rolls both meshes of a planned run for some time after the warm-up \[s\].
fn compare(
    loaded: &LoadedScene,
    plan: &Plan,
    levels: &MeshLevels,
    seconds: f64,
    job: &mut Job<'_>,
) -> Result<MeshCorrections, RunError> {
    let [coarse, mut fine] = short_scenes(loaded, &plan.scene, levels, seconds)?;
    let [few, many] = [&coarse, &fine].map(|scene| scene.numerics.elements);
    job.progress.note(&format!("levels: {few} and {many} elements roll the same {seconds:.2} s"));
    let (coarse, geometry) = roll(loaded, &coarse, 1, job)?;
    // The same piece of road.
    fine.rolling.start = Some(geometry.start);
    let (fine, _) = roll(loaded, &fine, many / few, job)?;
    let between =
        |fine: &PowerSpectrum, coarse: &PowerSpectrum| MeshCorrection::between(fine, coarse, LOWEST_FREQUENCY);
    let forces = fine.spectrum.as_ref().zip(coarse.spectrum.as_ref());
    let too_short = || SpectrumError::TooShort { samples: coarse.steps as usize, needed: FEWEST_SAMPLES };
    let force = forces.map(|(fine, coarse)| between(fine, coarse)).ok_or_else(too_short)?;
    let receivers = fine.sound.iter().flat_map(|sound| &sound.receivers);
    let of_coarse_receivers = coarse.sound.iter().flat_map(|sound| &sound.receivers);
    let receivers = receivers.zip(of_coarse_receivers).map(|(fine, coarse)| between(&fine.spectrum, &coarse.spectrum));
    let MeshLevels { standard_error, segments, .. } = *levels;
    let mesh = FinerMesh { elements: many, seconds, standard_error, segments };
    Ok(MeshCorrections { force, receivers: receivers.collect(), mesh })
}

/// Rolls a scene with all settings decided; its spectra keep their transforms, in lengths that are multiples of
/// `multiple`.
fn roll(
    loaded: &LoadedScene,
    scene: &Scene,
    multiple: usize,
    job: &mut Job<'_>,
) -> Result<(Results, Geometry), RunError> {
    let loaded = loaded.clone().settled(scene.clone());
    let plan = Plan::of(&loaded)?.with_cached_model().keeping_transforms(multiple);
    plan.check(&loaded)?;
    let mut short = Job::new(job.stop, &mut *job.progress);
    let mut run = Simulation::prepare(&loaded, &plan, true, &["cells", "resistance"], &mut short)?;
    run.roll_to_end(&mut short)?;
    let geometry = run.prepared.march.geometry().clone();
    let results = run.finish();
    // Its times count for the run that it serves, its counts do not.
    let counts = job.meter.counters().counts;
    job.meter.resume(&Counters { counts, ..results.meter.counters() });
    Ok((results, geometry))
}
