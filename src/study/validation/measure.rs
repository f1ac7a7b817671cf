//! Measurement of a scene: its tyre standing, and rolling on the named roads.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};
use thiserror::Error;

use super::missing::Lacks;
use super::published::is_compared;
use super::road_case::RoadCase;
use crate::counters::Job;
use crate::planning::settled;
use crate::response::{BandLevel, LevelErrors, ThirdOctaveBand};
use crate::results::pass_by::PassBySummary;
use crate::results::sound::RatedLevel;
use crate::run::RunError;
use crate::scene::{DEFAULT, GRAVITY, LoadedScene, NamedTexture, Scene, SceneError, Setting};
use crate::sound::{SoundLevels, TotalLevel};
use crate::study::loads::LoadedTyre;
use crate::study::sweep::{Axes, SweepError, variants};
use crate::study::trial::{Trial, Trials};
use crate::tyre::modes::{Mode, ModesError, Motion, modes};

/// Distance rolled after the warm-up \[m\]: three passages of 46 m, each with the run-up of the detector. With 75 m,
/// one passage, maxima differ by up to 1.1 dB and third octaves by up to 1.3 dB.
const ROLLED: f64 = 165.0;
/// Distance rolled on each case of an uncertain road \[m\]: all on the same piece, so that their differences scatter
/// less than their levels.
const CASE_ROLLED: f64 = 22.0;
/// Seed of the roads.
const SEED: u64 = 1;
/// Loads under which the tyre stands \[N\]: 300, 350 and 400 kg.
const LOADS: [f64; 3] = [300.0 * GRAVITY, 350.0 * GRAVITY, 400.0 * GRAVITY];
/// Elements around the standing tyre: they resolve its patch in steps of 3.8 mm.
const STANDING_ELEMENTS: usize = 1024;
/// Highest frequency of the modes \[Hz\], and largest number of waves around the tyre.
const MODES: (f64, usize) = (700.0, 6);
/// Lowest frequency of the cavity's mode \[Hz\]: well above the tyre's structural mode n = 1.
const CAVITY: f64 = 150.0;

/// Speeds and roads of a validation.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Options {
    /// Speeds \[km/h\].
    pub speeds: Vec<f64>,
    /// Roads.
    pub textures: Vec<NamedTexture>,
    /// Constructed roads are also rolled as they may be.
    pub with_cases: bool,
}

/// Levels of a run at the receivers.
#[derive(Clone, Debug, Serialize)]
pub struct ValidationRun {
    /// Road of the run.
    pub texture: NamedTexture,
    /// Speed \[km/h\].
    pub speed_kmh: f64,
    /// Maximum of the coast-by, time weighting F \[dB(A)\].
    #[serde(serialize_with = "level_alone")]
    pub coast_by: Option<TotalLevel>,
    /// Passages of that maximum.
    #[serde(skip)]
    pub pass_by: Option<PassBySummary>,
    /// Level close to the tyre \[dB(A)\].
    #[serde(serialize_with = "level_alone")]
    pub cpx: Option<TotalLevel>,
    /// A-weighted valid third octaves along the coast-by line, by band number \[dB(A)\].
    pub coast_by_bands: BTreeMap<i32, f64>,
    /// The same for the level close to the tyre.
    pub cpx_bands: BTreeMap<i32, f64>,
    /// Numerical errors of the third octaves along the coast-by line, and close to the tyre, where known \[dB\].
    #[serde(skip)]
    pub band_errors: [BTreeMap<i32, f64>; 2],
    /// Rolling resistance \[N\], where the tread law has one.
    pub rolling_resistance: Option<f64>,
}

#[allow(clippy::ref_option)]
fn level_alone<S: Serializer>(total: &Option<TotalLevel>, serializer: S) -> Result<S::Ok, S::Error> {
    total.as_ref().map(|total| total.level).serialize(serializer)
}

impl ValidationRun {
    /// Level of a band along the coast-by line \[dB(A)\]; `None` if it is not valid.
    pub(crate) fn coast_by_band(&self, band: ThirdOctaveBand) -> Option<f64> {
        self.coast_by_bands.get(&band.0).copied()
    }

    /// The same with the mean along the coast-by line in place of the maximum, for a run too short for a passage.
    fn with_mean_coast_by(self, trial: &Trial) -> Self {
        let passed = trial.receiver_levels().into_iter().find(|(rated, _)| rated.passed);
        Self { coast_by: passed.and_then(|(_, levels)| TotalLevel::of(levels.a_weighted)), pass_by: None, ..self }
    }

    fn of(texture: NamedTexture, speed_kmh: f64, trial: &Trial) -> Self {
        let valid = |bands: &[BandLevel]| -> BTreeMap<i32, f64> {
            bands.iter().filter(|band| band.valid).map(|band| (band.band.0, band.level)).collect()
        };
        let levels = trial.receiver_levels();
        let of = |passed: bool| levels.iter().find(|(rated, _)| rated.passed == passed);
        let level = |passed| of(passed).and_then(|(rated, _)| rated.level.clone());
        let bands = |passed| of(passed).map_or_else(BTreeMap::new, |(_, levels)| valid(&levels.a_weighted));
        let errors = |passed| -> BTreeMap<i32, f64> {
            let known = levels.iter().zip(trial.receiver_errors()).find(|((rated, _), _)| rated.passed == passed);
            let of = |((_, levels), errors): (&(RatedLevel, SoundLevels), &LevelErrors)| {
                let valid = levels.a_weighted.iter().filter(|level| level.valid);
                valid.filter_map(|level| Some((level.band.0, errors.total(level.band)?))).collect()
            };
            known.map(of).unwrap_or_default()
        };
        Self {
            texture,
            speed_kmh,
            coast_by: level(true),
            pass_by: of(true).and_then(|(rated, _)| rated.pass_by.clone()),
            cpx: level(false),
            coast_by_bands: bands(true),
            cpx_bands: bands(false),
            band_errors: [errors(true), errors(false)],
            rolling_resistance: trial.results.rolling_resistance.map(|resistance| resistance.force),
        }
    }
}

/// A short run on a road as it may be.
#[derive(Clone, Debug)]
pub struct CaseRun {
    /// The case.
    pub(super) case: RoadCase,
    /// Levels; that of the coast-by is the mean along the line.
    pub(super) run: ValidationRun,
}

/// Properties of the standing tyre; `None` where they were not found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StandingTyre {
    /// Load over deflection at 350 kg \[N/m\].
    pub stiffness: Option<f64>,
    /// Length of the patch at 300, 350 and 400 kg \[m\].
    pub patches: [Option<f64>; 3],
    /// Frequency of the lowest radial mode of n = 1, ..., 6 \[Hz\].
    pub modes: [Option<f64>; 6],
    /// Frequency of the lowest radial mode of n = 0 \[Hz\].
    pub breathing: Option<f64>,
    /// Frequency of the cavity's mode, n = 1 \[Hz\].
    pub cavity: Option<f64>,
}

/// Measured values of a scene.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The standing tyre.
    pub tyre: StandingTyre,
    /// By road, then by speed.
    pub runs: Vec<ValidationRun>,
    /// Shorter runs on constructed roads as they may be, and as stated; empty where they were not rolled.
    pub cases: Vec<CaseRun>,
    /// Load \[N\].
    pub load: f64,
    /// Physics that the model lacks.
    pub lacks: Lacks,
}

/// Reasons why a scene cannot be measured.
#[derive(Debug, Error)]
pub(crate) enum ValidationError {
    /// The scene, or a run.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A variant of the roads and speeds.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// The tyre's modes.
    #[error(transparent)]
    Modes(#[from] ModesError),
}

/// The scene that is validated where none is named: the default scene with numerics for up to 2 kHz and the given
/// settings.
///
/// # Errors
/// Mistakes in the settings.
pub(crate) fn base_scene(settings: &[Setting]) -> Result<LoadedScene, SceneError> {
    // The numerics are the last table of the default scene: its choice for 1 kHz is replaced by a preset. A receiver
    // stands for those of the runs, so that settings of the radiation apply to something.
    let (physics, _) = DEFAULT.split_once("[numerics]").unwrap_or((DEFAULT, ""));
    let numerics = "[numerics]\npreset = \"standard\"\nfmax = 2000.0 # Hz\n";
    // All results of slices are compared, whatever their error; the limits of slices are among the reasons.
    let physics = physics.replacen("[contact]\n", "[contact]\nlargest_slice_error = \"60 dB\"\n", 1);
    let text = format!("{physics}{numerics}[[receiver]]\nstandard = \"coast-by\"\n");
    Scene::from_str_with(&text, "default", settings)
}

/// Measures a scene: the standing tyre, then runs on the roads at the speeds that a row needs, each over 165 m after
/// the warm-up, with a coast-by microphone and one close to the tyre; where wanted, 22 m on each case of an uncertain
/// road. Everything of the scene counts except road, receivers, speed and duration.
///
/// # Errors
/// [`ValidationError`]; [`RunError::Interrupted`] within it.
pub(crate) fn measure(loaded: &LoadedScene, options: &Options, job: Job<'_>) -> Result<Measured, ValidationError> {
    loaded.check_time_domain().map_err(RunError::from)?;
    let Some((load, _)) = loaded.scene.rolling.axle.load() else {
        let wrong = "the axle holds a height: levels and rolling resistance are published for loads";
        let problem = loaded.complain("rolling.axle", wrong, "{ load = ... }, in N");
        return Err(RunError::from(SceneError::from(problem)).into());
    };
    let settled = |loaded: LoadedScene| settled(loaded).map_err(RunError::from);
    let tyre = standing(&settled(loaded.clone())?.scene)?;
    let mut planned = Vec::new();
    for texture in &options.textures {
        for &speed in options.speeds.iter().filter(|speed| is_compared(*texture, **speed)) {
            let cases = if options.with_cases { RoadCase::of(*texture) } else { Vec::new() };
            let whole = (None, on_road(*texture, RoadCase::Stated, ROLLED * 3.6 / speed));
            let short = cases.into_iter().map(|case| (Some(case), on_road(*texture, case, CASE_ROLLED * 3.6 / speed)));
            for (case, settings) in std::iter::once(whole).chain(short) {
                let axes = Axes { speeds: vec![speed], points: vec![settings], ..Axes::default() };
                for variant in variants(loaded, &axes)? {
                    let scene = settled(variant.loaded)?.scene;
                    planned.push((*texture, speed, case, scene.rolling.warm_up + scene.rolling.duration, scene));
                }
            }
        }
    }
    let all = planned.iter().map(|(_, _, _, seconds, _)| seconds).sum();
    let mut trials = Trials::shared(all, job).with_sound().with_levels();
    let (mut runs, mut cases) = (Vec::new(), Vec::new());
    for (number, (texture, speed, case, seconds, scene)) in planned.iter().enumerate() {
        let of = case.map(RoadCase::text).unwrap_or_default();
        let road = texture.name();
        trials.announce(&format!("run {} of {}: {road}{of}, {speed} km/h", number + 1, planned.len()), *seconds);
        let trial = trials.roll(scene)?;
        let run = ValidationRun::of(*texture, *speed, &trial);
        match *case {
            None => runs.push(run),
            Some(case) => cases.push(CaseRun { case, run: run.with_mean_coast_by(&trial) }),
        }
    }
    trials.finish();
    Ok(Measured { tyre, runs, cases, load, lacks: Lacks::of(&loaded.scene) })
}

/// Settings of a run on a road over `duration` \[s\].
fn on_road(texture: NamedTexture, case: RoadCase, duration: f64) -> Vec<Setting> {
    let keys = case.keys();
    let texts = [
        format!("road={{ kind = \"made\", seed = {SEED}, texture = \"{}\"{keys} }}", texture.name()),
        "receiver=[{ standard = \"coast-by\" }, { standard = \"cpx\" }]".to_owned(),
        format!("rolling.duration={duration:?}"),
    ];
    texts.iter().flat_map(|text| Setting::parse(text)).collect()
}

fn standing(scene: &Scene) -> Result<StandingTyre, ValidationError> {
    let mut fine = scene.clone();
    fine.numerics.elements = STANDING_ELEMENTS;
    let tyre = LoadedTyre::new(&fine);
    let [light, middle, heavy] = LOADS;
    let under = |load: f64| tyre.under(load).map_err(RunError::from);
    let at = under(middle)?;
    let patches = [under(light)?.length, at.length, under(heavy)?.length];
    let (highest, largest_n) = MODES;
    let found = modes(&scene.tyre, largest_n, 1, highest)?;
    let lowest = |n: usize, above: f64| {
        let radial = |mode: &&Mode| mode.n == n && mode.motion == Motion::Radial && mode.frequency() > above;
        let frequencies = found.confirmed.iter().filter(radial).map(Mode::frequency);
        Some(frequencies.fold(f64::INFINITY, f64::min)).filter(|frequency| frequency.is_finite())
    };
    // Sidewalls have weaker modes below the belt's.
    let is_breathing = |mode: &&Mode| mode.n == 0 && mode.motion == Motion::Radial;
    let breathing = found.confirmed.iter().filter(is_breathing).max_by(|one, other| one.peak.total_cmp(&other.peak));
    let air = scene.tyre.cavity.is_some();
    Ok(StandingTyre {
        stiffness: Some(at.force / at.indentation),
        patches: patches.map(Some),
        modes: [1, 2, 3, 4, 5, 6].map(|n| lowest(n, 0.0)),
        breathing: breathing.map(Mode::frequency),
        cavity: if air { lowest(1, CAVITY) } else { None },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_differ_in_road_and_duration_alone() {
        let base = base_scene(&[]).unwrap();
        let default = Scene::from_str(DEFAULT, "default").unwrap().scene;
        let mut numerics_apart = base.scene.clone();
        numerics_apart.numerics = default.numerics.clone();
        numerics_apart.receivers.clear();
        assert_eq!(numerics_apart.contact.largest_slice_error.to_bits(), 60.0_f64.to_bits());
        numerics_apart.contact.largest_slice_error = default.contact.largest_slice_error;
        assert_eq!(numerics_apart, default);
        let axes = |speed, texture| Axes {
            speeds: vec![speed],
            points: vec![on_road(texture, RoadCase::Stated, ROLLED * 3.6 / speed)],
            ..Axes::default()
        };
        for (speed, texture) in [(50.0, NamedTexture::ChipSeal), (110.0, NamedTexture::Iso10844)] {
            let [variant] = &variants(&base, &axes(speed, texture)).unwrap()[..] else { panic!("one scene") };
            let scene = &variant.loaded.scene;
            let crate::scene::Road::Made(road) = &scene.road else { panic!("a made road") };
            assert_eq!((road.texture, road.seed, scene.receivers.len()), (Some(texture), SEED, 2));
            assert_eq!((&scene.tyre, &scene.numerics), (&base.scene.tyre, &base.scene.numerics));
            assert!(settled(variant.loaded.clone()).is_ok(), "the preset suits every speed");
            let rolled = scene.rolling.speed() * scene.rolling.duration;
            assert!((rolled - ROLLED).abs() < 1e-9, "{rolled}");
        }
    }
}
