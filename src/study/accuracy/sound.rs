//! Discretisation of the sound's transfer paths: the same forces radiated with different settings.
//!
//! 1. The scene with its own elements and steps is rolled once, its axle held; its forces are kept.
//! 2. The sound of a reference whose boundary elements, frequencies and lateral waves are finer than the scene's.
//! 3. Each of these knobs is swept with the others at the reference; then all at the scene's settings.
//!
//! Differences are of the A-weighted level and of third octaves, receiver by receiver.

use serde::Serialize;

use crate::counters::Unwatched;
use crate::counters::{Meter, Stage};
use crate::effects::Begin;
use crate::effects::sound::{HeardSound, SoundObserver};
use crate::plan::Plan;
use crate::results::sound::{BodySummary, ReceiverSpectrum};
use crate::run::RunError;
use crate::run::prepare::Prepared;
use crate::run::{Setup, Simulation};
use crate::scene::{LoadedScene, Radiation, RadiationQuality, Scene, Switch};
use crate::sound::{Compared, SoundLevels};
use crate::study::trial::{LOWEST_BAND, Trials, level_changes, upper_edge};

/// Nodes per wavelength of the reference over the scene's.
const FINER_ELEMENTS: f64 = 4.0 / 3.0;
/// The reference's frequency tolerance over the scene's, and its lateral waves.
const FINER_FREQUENCIES: f64 = 0.5;
const FINER_WAVES: usize = 2;
/// Settings that are swept, relative to the scene's; the last of each are the scene's.
const ELEMENTS: [f64; 3] = [0.6, 0.8, 1.0];
const FREQUENCIES: [f64; 3] = [10.0, 3.0, 1.0];
const WAVES: [f64; 3] = [0.25, 0.5, 1.0];

/// Difference of the sound at a receiver from the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SoundDifference {
    /// Name of the receiver.
    pub receiver: String,
    /// Largest difference of a third octave \[dB\].
    pub worst: f64,
    /// Nominal mid-frequency of its band \[Hz\].
    pub worst_band: f64,
    /// Difference of the A-weighted level over common bands, at the passage of the maximum \[dB(A)\]; absent without a
    /// passage.
    pub level_a: Option<f64>,
}

/// Settings of the transfer paths, and their difference from the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SoundPoint {
    /// The knob and its setting.
    pub label: String,
    /// By receiver; empty for the reference itself.
    pub differences: Vec<SoundDifference>,
    /// How the transfer functions were found.
    pub body: BodySummary,
    /// Time of the set-up \[s\]: cached transfer functions take none.
    pub seconds: f64,
}

impl SoundPoint {
    /// The receiver with the largest difference of a third octave.
    pub fn worst(&self) -> Option<&SoundDifference> {
        self.differences.iter().max_by(|a, b| a.worst.total_cmp(&b.worst))
    }

    /// Largest magnitude of the differences of the A-weighted level over the receivers \[dB(A)\], for a cell: a lower
    /// bound if that of some is not known, and `-` if that of all is not; empty for the reference.
    pub(crate) fn level_a(&self) -> String {
        largest_level_a(&self.differences)
    }
}

fn largest_level_a(differences: &[SoundDifference]) -> String {
    let known = || differences.iter().filter_map(|of| of.level_a).map(f64::abs);
    let least = if known().count() < differences.len() { "at least " } else { "" };
    match known().reduce(f64::max) {
        Some(largest) => format!("{least}{largest:.2}"),
        None if differences.is_empty() => String::new(),
        None => "-".to_owned(),
    }
}

/// Findings of the sound's part of a study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SoundStudy {
    /// With finer boundary elements, frequencies and lateral waves than the scene.
    pub reference: SoundPoint,
    /// Every knob's settings, then the scene's with all of them.
    pub points: Vec<SoundPoint>,
}

/// Name and settings of a transfer path.
type Way = (String, Radiation);

/// The reference, and what is compared with it.
fn ways(own: &Radiation) -> (Way, Vec<Way>) {
    let finest = Radiation {
        // A draft is compared with the full method, too.
        quality: RadiationQuality::Full,
        nodes_per_wavelength: FINER_ELEMENTS * own.nodes_per_wavelength,
        frequency_tolerance: FINER_FREQUENCIES * own.frequency_tolerance,
        lateral_waves: FINER_WAVES * own.lateral_waves,
        ..own.clone()
    };
    let with = |label: String, turn: &dyn Fn(&mut Radiation)| {
        let mut radiation = finest.clone();
        turn(&mut radiation);
        (label, radiation)
    };
    let mut ways = Vec::new();
    for share in ELEMENTS {
        let nodes = share * own.nodes_per_wavelength;
        ways.push(with(format!("nodes_per_wavelength {nodes:.1}"), &|way| way.nodes_per_wavelength = nodes));
    }
    for share in FREQUENCIES {
        let tolerance = share * own.frequency_tolerance;
        ways.push(with(format!("frequency_tolerance {tolerance:.2} dB"), &|way| way.frequency_tolerance = tolerance));
    }
    for share in WAVES {
        let waves = ((share * own.lateral_waves as f64) as usize).max(1);
        ways.push(with(format!("lateral_waves {waves}"), &|way| way.lateral_waves = waves));
    }
    ways.push(("the scene".to_owned(), own.clone()));
    let reference = format!(
        "nodes_per_wavelength {:.1}, frequency_tolerance {:.2} dB, lateral_waves {}",
        finest.nodes_per_wavelength, finest.frequency_tolerance, finest.lateral_waves
    );
    ((reference, finest), ways)
}

/// The forces of one run, and the run itself, whose models the transfer paths need.
struct Rolled<'a, 'b> {
    scene: Scene,
    run: Simulation,
    width: usize,
    forces: Vec<f64>,
    trials: &'a Trials<'b>,
}

/// Studies the sound of a scene up to `highest` \[Hz\]; `held` is the same scene with its axle held and without
/// receivers. `None` without receivers, or if the run is too short.
///
/// # Errors
/// Errors of a run; [`RunError::Interrupted`].
pub fn study(scene: &Scene, held: &Scene, highest: f64, trials: &Trials<'_>) -> Result<Option<SoundStudy>, RunError> {
    if scene.receivers.is_empty() {
        return Ok(None);
    }
    let mut heard = Scene { receivers: scene.receivers.clone(), ..held.clone() };
    heard.effects.radiation = Switch::Auto;
    // The transfer functions fall to zero over the last twentieth of their band.
    let fmax = scene.radiation.fmax.min(1.06 * upper_edge(highest));
    heard.radiation = Radiation { fmax, audio: false, ..scene.radiation.clone() };
    let mut rolled = Rolled::new(heard, trials)?;
    let ((label, finest), ways) = ways(&rolled.scene.radiation);
    let Some((reference, of_reference)) = rolled.point(label, &finest, None)? else { return Ok(None) };
    let mut points = Vec::new();
    for (label, radiation) in ways {
        points.extend(rolled.point(label, &radiation, Some(&of_reference))?.map(|(point, _)| point));
    }
    Ok(Some(SoundStudy { reference, points }))
}

impl<'a, 'b> Rolled<'a, 'b> {
    fn new(scene: Scene, trials: &'a Trials<'b>) -> Result<Self, RunError> {
        let loaded = LoadedScene::from_scene(&scene, "sound")?;
        let plan = Plan::of(&loaded)?.with_kept_model();
        plan.check(&loaded)?;
        let meter = Meter::default();
        let setup =
            Setup { stop: trials.stop(), meter, progress: &mut Unwatched, in_memory: true, without: &["sound"] };
        let mut run = Simulation::prepare(&loaded, &plan, setup)?;
        run.enter_steps();
        let (mut forces, mut width) = (Vec::new(), 0);
        while run.step()?.is_some() {
            if run.next_step() > plan.warm_up_steps {
                let instant = run.prepared.march.footprint().forces();
                width = instant.len();
                forces.extend_from_slice(instant);
            }
            trials.look()?;
        }
        Ok(Self { scene, run, width, forces, trials })
    }

    /// Sound with the given radiation settings, and its difference from a reference; `None` if the run is too short.
    fn point(
        &mut self,
        label: String,
        radiation: &Radiation,
        reference: Option<&HeardSound>,
    ) -> Result<Option<(SoundPoint, HeardSound)>, RunError> {
        let scene = Scene { radiation: radiation.clone(), ..self.scene.clone() };
        let loaded = LoadedScene::from_scene(&scene, "sound")?;
        let plan = Plan::of(&loaded)?.with_kept_model();
        let mut meter = Meter::default();
        let Prepared { contact, models, warnings, .. } = &mut self.run.prepared;
        let begun = SoundObserver::begin(&mut Begin {
            loaded: &loaded,
            plan: &plan,
            contact,
            models,
            in_memory: true,
            planned_memory: |plan| plan.amounts().memory_on(1),
            warnings,
            stop: self.trials.stop(),
            progress: &mut Unwatched,
            meter: &mut meter,
        })?;
        let Some(mut recorder) = begun else { return Ok(None) };
        for forces in self.forces.chunks_exact(self.width) {
            recorder.take(forces, None, &mut meter);
        }
        let heard = recorder.heard()?;
        let differences = reference.map_or(Vec::new(), |reference| differences(&heard, reference));
        let seconds = meter.whole(Stage::Radiation).seconds();
        Ok(Some((SoundPoint { label, differences, body: heard.body.clone(), seconds }, heard)))
    }
}

fn differences(found: &HeardSound, reference: &HeardSound) -> Vec<SoundDifference> {
    let levels = |of: &ReceiverSpectrum| SoundLevels::of(&of.spectrum, LOWEST_BAND / 1.2..f64::INFINITY);
    let rated = found.rated.iter().zip(&reference.rated);
    let level_a = rated
        .map(|(found, reference)| Some(Compared::difference(found.level.as_ref()?, reference.level.as_ref()?).ok()?.0));
    let one = |((found, reference), level_a): ((&ReceiverSpectrum, &ReceiverSpectrum), Option<f64>)| {
        let (here, there) = (levels(found), levels(reference));
        let changes = level_changes(&here.third_octaves, &there.third_octaves);
        let worst = changes
            .filter(|(band, change)| band.valid && change.is_finite())
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let (worst, worst_band) = worst.map_or((0.0, 0.0), |(band, by)| (by.abs(), band.band.nominal_frequency()));
        SoundDifference { receiver: reference.name.clone(), worst, worst_band, level_a }
    };
    found.receivers.iter().zip(&reference.receivers).zip(level_a).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_that_is_not_known_is_not_0() {
        let of = |level_a| SoundDifference { receiver: String::new(), worst: 1.0, worst_band: 100.0, level_a };
        let cell = |levels: &[Option<f64>]| largest_level_a(&levels.iter().map(|level| of(*level)).collect::<Vec<_>>());
        assert_eq!([cell(&[]), cell(&[None, None])], ["", "-"]);
        assert_eq!([cell(&[Some(0.1), Some(-0.25)]), cell(&[None, Some(0.25)])], ["0.25", "at least 0.25"]);
    }
}
