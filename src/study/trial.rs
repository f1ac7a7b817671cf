//! Short runs side by side: variants of a scene are rolled one after the other ([`Trials`]) and compared ([`Trial`],
//! [`Common`], [`RunDifference`]).
//!
//! Runs may differ in their time steps. Both forces are resampled to common instants by the same low-pass kernel, flat
//! up to the upper edge of the highest band and 80 dB down from 1.25 times that on; levels and differences are those of
//! the resampled forces.

use std::f64::consts::TAU;
use std::ops::Range;
use std::time::Instant;

use serde::Serialize;

use crate::counters::{Job, Unwatched, Watch};
use crate::effects::Observer;
use crate::numeric::windowed_sinc::WindowedSinc;
use crate::plan::Plan;
use crate::response::{BandLevel, LevelErrors, PowerSpectrum, ThirdOctaveBand};
use crate::results::sound::{RatedLevel, ReceiverSpectrum};
use crate::results::summary::{Outcome, RollingResistance};
use crate::run::end::impossible_energy;
use crate::run::meshes::corrected;
use crate::run::{Results, RunError, Simulation};
use crate::scene::{Axle, LoadedScene, Radiation, Scene, Switch, TimeRule};
use crate::sound::SoundLevels;

/// Steps between two checks of the flag, with an update of the progress.
const CHECK_EVERY: u64 = 256;
/// Ramp and settling of an axle that is held at a height, left out of a comparison \[s\]: the default tyre's modes
/// decay by 40 dB in it.
pub(crate) const SETTLING: f64 = 0.2;
/// Unit of the progress \[s\] of simulated time.
pub(crate) const UNIT: f64 = 1e-3;
/// Lowest band of a trial's levels \[Hz\].
const LOWEST_FREQUENCY: f64 = 20.0;
/// Lowest band that is compared \[Hz\].
pub(crate) const LOWEST_BAND: f64 = 100.0;
/// End of the kernel's pass band and begin of its stop band, in cycles per instant.
const PASS: f64 = 0.4;
const STOP: f64 = 0.5;
/// Attenuation of the kernel's stop band \[dB\].
const ATTENUATION: f64 = 80.0;
/// Length of the segments of the spectra \[s\].
const SEGMENT: f64 = 0.5;

/// One run of a comparison.
#[derive(Clone, Debug)]
pub(crate) struct Trial {
    /// Plan of the variant.
    pub plan: Plan,
    /// Time rule of the march.
    pub rule: TimeRule,
    /// Total force at every step, warm-up included \[N\].
    pub force: Vec<f64>,
    /// Indentation of the rigid tyre at the last step \[m\].
    pub indentation: f64,
    /// Means, meter and sound of the run.
    pub results: Results,
    /// Third-octave levels of the contact force from 20 Hz on; empty for a run that is too short for a spectrum.
    pub levels: Vec<BandLevel>,
    /// Wall time of the steps \[s\].
    pub seconds: f64,
}

impl Trial {
    /// Mean force after the warm-up \[N\]; 0 if the run did not get that far.
    pub(crate) fn mean_force(&self) -> f64 {
        self.results.mean_force.unwrap_or_default()
    }

    /// Mean length of the patch after the warm-up \[m\]; 0 if the run did not get that far.
    pub(crate) fn contact_length(&self) -> f64 {
        self.results.mean_contact_length.unwrap_or_default()
    }

    /// Rolling resistance after the warm-up \[N\], including that by slip; 0 where the tread law has none.
    pub(crate) fn rolling_resistance(&self) -> f64 {
        self.resistance().map_or(0.0, |resistance| resistance.force)
    }

    /// Rolling resistance by hysteresis and slip; `None` where the tread law has none.
    pub(crate) fn resistance(&self) -> Option<RollingResistance> {
        let by_hysteresis = self.results.rolling_resistance?;
        let Some(friction) = self.results.friction else { return Some(by_hysteresis) };
        let RollingResistance { coefficient, force, power } = by_hysteresis;
        Some(RollingResistance {
            coefficient: coefficient + friction.slip_resistance,
            force: force + friction.slip_resistance * self.mean_force(),
            power: power + friction.mean_slip_power,
        })
    }

    /// A-weighted levels at the receivers, by which runs are compared, and third octaves.
    pub(crate) fn receiver_levels(&self) -> Vec<(RatedLevel, SoundLevels)> {
        let receivers = self.results.sound.iter().flat_map(|sound| sound.rated.iter().zip(&sound.receivers));
        let levels = |receiver: &ReceiverSpectrum| SoundLevels::of(&receiver.spectrum, LOWEST_FREQUENCY..f64::INFINITY);
        receivers.map(|(rated, receiver)| (rated.clone(), levels(receiver))).collect()
    }

    /// Errors of third octaves at the receivers, in their order.
    pub(crate) fn receiver_errors(&self) -> impl Iterator<Item = &LevelErrors> {
        self.results.sound.iter().flat_map(|sound| &sound.level_errors)
    }

    /// Planned memory on the present threads, without the process itself \[bytes\].
    pub(crate) fn memory(&self) -> f64 {
        self.plan.amounts().memory_on(rayon::current_num_threads())
    }
}

/// Rolls one variant after the other.
pub(crate) struct Trials<'a> {
    /// True if the runs compute the sound at the receivers.
    with_sound: bool,
    with_levels: bool,
    job: Job<'a>,
    /// Simulated time, or expected wall time of the runs so far \[s\].
    done: f64,
    /// The present run, if progress is reported as a share of all work.
    shared: Option<Shared>,
}

/// A run as a share of all work.
struct Shared {
    /// Wall time that all runs are expected to take \[s\].
    all: f64,
    name: String,
    /// Wall time that it is expected to take \[s\].
    seconds: f64,
}

impl<'a> Trials<'a> {
    /// Runs of about `time` \[s\] of simulated time in all.
    pub(crate) fn new(time: f64, job: Job<'a>) -> Self {
        job.progress.march(0, (time / UNIT) as u64, UNIT);
        Self { with_sound: false, with_levels: false, job, done: 0.0, shared: None }
    }

    /// Runs that are expected to take about `all` \[s\] of wall time: progress is their share of it, see
    /// [`Self::announce`].
    pub(crate) fn shared(all: f64, job: Job<'a>) -> Self {
        let shared = Shared { all, name: String::new(), seconds: 0.0 };
        Self { with_sound: false, with_levels: false, job, done: 0.0, shared: Some(shared) }
    }

    /// Announces what is rolled or prepared next, and the wall time that it is expected to take \[s\].
    pub(crate) fn announce(&mut self, name: &str, seconds: f64) {
        if let Some(shared) = &mut self.shared {
            (shared.name, shared.seconds) = (name.to_owned(), seconds);
            self.report_share(0.0, 0.0);
        }
    }

    /// Reports progress: the `part` of the present run that is done, and its simulated time so far \[s\].
    fn report_share(&mut self, part: f64, rolled: f64) {
        match &self.shared {
            None => self.job.progress.step(((self.done + rolled) / UNIT) as u64),
            Some(Shared { all, name, seconds }) => {
                let share = (self.done + part * seconds) / all.max(f64::MIN_POSITIVE);
                self.job.progress.share(share.min(1.0), name);
            }
        }
    }

    /// The same, with the sound at the receivers.
    #[must_use]
    pub(crate) fn with_sound(self) -> Self {
        Self { with_sound: true, ..self }
    }

    /// The same, with the levels of a finer mesh where a scene wants them; else variants have those of their own.
    #[must_use]
    pub(crate) fn with_levels(self) -> Self {
        Self { with_levels: true, ..self }
    }

    /// Rolls a variant to its end. The road is made on another thread where there is one; the march has its thread to
    /// itself either way.
    ///
    /// # Errors
    /// Errors of the plan and of the run; [`RunError::Interrupted`].
    pub(crate) fn roll(&mut self, scene: &Scene) -> Result<Trial, RunError> {
        let (plan, run) = self.begin(scene)?;
        self.march(scene, (plan, run), &mut |_| {})
    }

    /// Rolls a variant as [`Self::roll`] does, with an additional observer; returns that in its state after the last
    /// step.
    ///
    /// # Errors
    /// As [`Self::roll`], and those of the observer.
    pub(crate) fn roll_with<O: Observer + Clone>(
        &mut self,
        scene: &Scene,
        mut observer: O,
    ) -> Result<(Trial, O), RunError> {
        let (plan, run) = self.begin(scene)?;
        let run = run.with(observer.clone());
        let trial = self.march(scene, (plan, run), &mut |run| {
            if let Some(rolled) = run.observer::<O>() {
                observer.clone_from(rolled);
            }
        })?;
        Ok((trial, observer))
    }

    fn begin(&self, scene: &Scene) -> Result<(Plan, Simulation), RunError> {
        let mut scene = scene.clone();
        scene.outputs.levels = scene.outputs.levels.filter(|_| self.with_levels);
        let loaded = LoadedScene::from_scene(&scene, "variant")?;
        let plan = Plan::of(&loaded)?.with_cached_model();
        plan.check(&loaded)?;
        let without: &[&str] = if self.with_sound { &[] } else { &["sound"] };
        let mut unwatched = Unwatched;
        let mut job = Job::new(self.job.stop, &mut unwatched).watched(Watch::EVERY);
        let (loaded, plan) = corrected(loaded, plan, &mut job)?;
        let run = Simulation::prepare(&loaded, &plan, true, without, &mut job)?;
        Ok((plan, run))
    }

    /// Rolls a prepared variant to its end, where `inspect` sees it.
    fn march(
        &mut self,
        scene: &Scene,
        (plan, mut run): (Plan, Simulation),
        inspect: &mut dyn FnMut(&Simulation),
    ) -> Result<Trial, RunError> {
        run.enter_steps();
        let begin = Instant::now();
        let mut force = Vec::with_capacity(plan.steps as usize);
        while let Some(step) = run.step()? {
            force.push(step.total_force);
            if run.next_step().is_multiple_of(CHECK_EVERY) {
                let steps = run.next_step() as f64;
                self.report_share(steps / plan.steps as f64, steps * plan.time_step);
                if self.job.is_stopped() {
                    return Err(RunError::Interrupted { partial: None });
                }
            }
        }
        let seconds = begin.elapsed().as_secs_f64();
        let rolled = plan.steps as f64 * plan.time_step;
        self.done += self.shared.as_ref().map_or(rolled, |shared| shared.seconds);
        let indentation = run.indentation(plan.steps - 1);
        inspect(&run);
        let results = run.finish();
        let outcome = Outcome {
            mean_force: results.mean_force,
            mean_contact_length: results.mean_contact_length,
            indentation: Some(indentation),
            rolling_resistance: results.rolling_resistance,
            friction: results.friction,
            ..Outcome::default()
        };
        // Other runs try laws and rules that may put energy in: they report what comes out.
        if let Some(shared) = &self.shared
            && let Some(why) = impossible_energy(&plan.scene, &outcome)
        {
            return Err(RunError::Impossible(format!("{}: {why}", shared.name)));
        }
        let spectrum = results.spectrum.as_ref();
        let levels = spectrum.map_or(Vec::new(), |spectrum| spectrum.third_octaves(LOWEST_FREQUENCY, 1.0));
        Ok(Trial { plan, rule: scene.numerics.time_rule, force, indentation, results, levels, seconds })
    }

    /// The scene for a comparison of its forces over `duration` \[s\]: its axle held where it carries the load at the
    /// scene's settings, found by rolling the warm-up; without outputs; with nothing left open that would be chosen
    /// anew for other settings.
    ///
    /// # Errors
    /// As [`Self::roll`].
    pub(crate) fn held(&mut self, scene: &Scene, duration: f64) -> Result<Scene, RunError> {
        let mut held = scene.clone();
        held.numerics.forget_wishes();
        held.outputs.vibration = None;
        (held.receivers, held.radiation, held.air_pumping) = (Vec::new(), Radiation::default(), None);
        let Scene { effects, rolling, .. } = &mut held;
        for switch in [
            &mut effects.tread_vibration,
            &mut effects.belt_vibration,
            &mut effects.tangential_motion,
            &mut effects.radiation,
            &mut effects.air_pumping,
        ] {
            *switch = Switch::Auto;
        }
        rolling.warm_up = rolling.warm_up.max(SETTLING);
        if rolling.axle.load().is_some() {
            let mut found = held.clone();
            // Just enough for the last correction of the height.
            found.rolling.duration = 1e-3;
            let indentation = self.roll(&found)?.indentation;
            held.rolling.axle = Axle::Indentation { indentation, ramp: 0.5 * SETTLING };
        }
        (held.rolling.warm_up, held.rolling.duration) = (SETTLING, duration);
        Ok(held)
    }

    /// Ends the progress.
    pub(crate) fn finish(self) {
        self.job.progress.finish();
    }
}

/// Quantities of a run that are compared.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Common {
    /// Distance of the instants \[s\].
    pub spacing: f64,
    /// Total force at the instants \[N\].
    pub force: Vec<f64>,
    /// Third-octave levels of the force from [`LOWEST_BAND`] to the highest \[dB re 1 N\].
    pub levels: Vec<BandLevel>,
    /// Mean force after the warm-up \[N\].
    pub mean_force: f64,
    /// Mean length of the patch after the warm-up \[m\].
    pub contact_length: f64,
    /// Rolling resistance \[N\]; 0 where the tread law has none.
    pub rolling_resistance: f64,
}

/// Difference of a run from another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RunDifference {
    /// Largest magnitude of the difference of a third-octave level \[dB\].
    pub worst: f64,
    /// Nominal mid-frequency of its band \[Hz\].
    pub worst_band: f64,
    /// Root mean square of the differences of all bands \[dB\].
    pub rms: f64,
    /// Root mean square of the force's difference over that of the other force's variation about its mean.
    pub force: f64,
    /// Relative difference of the mean force.
    pub mean_force: f64,
    /// Relative difference of the patch's length.
    pub contact_length: f64,
    /// Relative difference of the rolling resistance; 0 where the other has none.
    pub rolling_resistance: f64,
}

/// Band that contains a frequency \[Hz\].
fn band(frequency: f64) -> ThirdOctaveBand {
    ThirdOctaveBand::containing(frequency).unwrap_or(ThirdOctaveBand(0))
}

/// Lowest sampling frequency that contains all that is compared up to the band of `highest` \[Hz\], in Hz.
pub(crate) fn least_rate(highest: f64) -> f64 {
    2.0 * STOP / PASS * band(highest).upper_edge()
}

impl Common {
    /// Quantities of a run up to the band that contains `highest` \[Hz\], within a stretch of time \[s\] that is the
    /// same for all runs.
    pub(crate) fn of(trial: &Trial, within: Range<f64>, highest: f64) -> Self {
        let spacing = PASS / band(highest).upper_edge();
        let force = resampled(&trial.force, trial.plan.time_step, trial.rule.force_lead(), spacing, within);
        // A run too short for a spectrum has no levels.
        let spectrum = PowerSpectrum::of(&force, spacing, Some(SEGMENT)).ok();
        let spectrum =
            spectrum.map(|spectrum| spectrum.without(|f| trial.rule.mean_response(TAU * f * trial.plan.time_step)));
        let mut levels =
            spectrum.map_or(Vec::new(), |spectrum| spectrum.third_octaves(band(LOWEST_BAND).lower_edge(), 1.0));
        levels.retain(|level| level.band <= band(highest));
        let (mean_force, contact_length) = (trial.mean_force(), trial.contact_length());
        Self { spacing, force, levels, mean_force, contact_length, rolling_resistance: trial.rolling_resistance() }
    }

    /// Difference from another run with the same instants.
    pub(crate) fn difference(&self, other: &Self) -> RunDifference {
        let (mut worst, mut worst_band, mut squares, mut count) = (0.0_f64, 0.0, 0.0, 0.0);
        for (level, change) in level_changes(&self.levels, &other.levels).filter(|(_, change)| change.is_finite()) {
            if change.abs() > worst {
                (worst, worst_band) = (change.abs(), level.band.nominal_frequency());
            }
            squares += change * change;
            count += 1.0;
        }
        let relative = |a: f64, b: f64| if b == 0.0 { 0.0 } else { a / b - 1.0 };
        RunDifference {
            worst,
            worst_band,
            rms: (squares / f64::max(count, 1.0)).sqrt(),
            force: relative_difference(&self.force, &other.force),
            mean_force: relative(self.mean_force, other.mean_force),
            contact_length: relative(self.contact_length, other.contact_length),
            rolling_resistance: relative(self.rolling_resistance, other.rolling_resistance),
        }
    }
}

/// Change of the level of each band of `reference` \[dB\]: valid if both levels are, NaN if one of them has no sound or
/// missing.
pub(crate) fn level_changes<'a>(
    found: &'a [BandLevel],
    reference: &'a [BandLevel],
) -> impl Iterator<Item = (BandLevel, f64)> + 'a {
    reference.iter().map(move |band| {
        let other = found.iter().find(|other| other.band == band.band);
        let change = other.map_or(f64::NAN, |other| other.level - band.level);
        let valid = band.valid && other.is_some_and(|other| other.valid);
        (BandLevel { valid, ..*band }, if change.is_finite() { change } else { f64::NAN })
    })
}

/// Root mean square of a - b, both about their means, relative to that of b about its mean.
fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len().min(b.len());
    let (a, b) = (&a[..count], &b[..count]);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count.max(1) as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let variation: f64 = b.iter().map(|b| (b - mean_b).powi(2)).sum();
    let error: f64 = a.iter().zip(b).map(|(a, b)| (a - mean_a - b + mean_b).powi(2)).sum();
    if error > 0.0 { (error / variation).sqrt() } else { 0.0 }
}

/// Resamples a force whose sample l belongs to the time (l - lag) dt: low-passed, at instants `spacing` apart \[s\], as
/// many as have the whole kernel within the stretch `within` \[s\].
fn resampled(force: &[f64], time_step: f64, lag: f64, spacing: f64, within: Range<f64>) -> Vec<f64> {
    let kernel = WindowedSinc::new(PASS, STOP, ATTENUATION);
    // Two instants more than the kernel: a record ends up to a step and a half before its stretch does.
    let reach = (kernel.half_width + 2.0) * spacing;
    let count = ((within.end - within.start - 2.0 * reach) / spacing).max(0.0) as usize;
    // A run with fewer samples than instants is interpolated without the low-pass.
    let ratio = (spacing / time_step).max(1.0);
    let mut weights = Vec::new();
    let mut value = |index: usize| {
        let instant = within.start + reach + index as f64 * spacing;
        let first = kernel.weights(instant / time_step + lag, ratio, &mut weights);
        let sample = |index: i64| usize::try_from(index).ok().and_then(|index| force.get(index));
        let known = (first..).zip(&weights).filter_map(|(index, weight)| sample(index).map(|force| (weight, force)));
        let (sum, all) = known.fold((0.0, 0.0), |(sum, all), (weight, force)| (sum + weight * force, all + weight));
        sum / all
    };
    (0..count).map(&mut value).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::counters::Meter;
    use crate::effects::{RunError, Step};
    use crate::scene::PLATE;
    use crate::test_models::{edit, scene};

    #[derive(Clone, Default)]
    struct Forces(Vec<f64>);

    impl Observer for Forces {
        fn observe(&mut self, step: &Step<'_>, _: &mut Meter) -> Result<(), RunError> {
            self.0.push(step.total_force);
            Ok(())
        }
    }

    #[test]
    fn an_observer_comes_back_with_all_steps_of_the_same_run() {
        let small = [("numerics.elements", "64"), ("rolling.warm_up", "0.03"), ("rolling.duration", "0.02")];
        let scene = scene(&edit(PLATE, &small)).scene;
        let (stop, mut progress) = (AtomicBool::new(false), Unwatched);
        let mut trials = Trials::new(0.08, Job::new(&stop, &mut progress));
        let (trial, observed) = trials.roll_with(&scene, Forces::default()).unwrap();
        assert!(trial.force.len() as u64 == trial.plan.steps && observed.0 == trial.force);
        assert_eq!(trials.roll(&scene).unwrap().force, trial.force);
    }

    /// Two tones in the pass band and one beyond the stop band, sampled with a step.
    fn sampled(time_step: f64, lag: f64, amplitude: f64) -> Vec<f64> {
        let value = |t: f64| {
            300.0
                + amplitude * (TAU * 200.0 * t).sin()
                + 5.0 * (TAU * 900.0 * t + 1.0).sin()
                + 50.0 * (TAU * 1500.0 * t).sin()
        };
        (0..(1.0 / time_step) as usize).map(|l| value((l as f64 - lag) * time_step)).collect()
    }

    fn common(time_step: f64, lag: f64, amplitude: f64) -> Common {
        let spacing = PASS / band(1000.0).upper_edge();
        let force = resampled(&sampled(time_step, lag, amplitude), time_step, lag, spacing, 0.1..1.0);
        let levels = PowerSpectrum::of(&force, spacing, Some(SEGMENT)).unwrap().third_octaves(89.0, 1.0);
        Common { spacing, force, levels, mean_force: 300.0, contact_length: 0.1, rolling_resistance: 3.0 }
    }

    #[test]
    fn the_same_force_with_other_steps_is_the_same() {
        let reference = common(1e-4, 0.0, 10.0);
        for (time_step, lag) in [(3.3e-4, 0.0), (1.1e-4, 0.5), (0.7e-4, 0.0)] {
            assert!(1.0 / time_step > least_rate(1000.0));
            let found = common(time_step, lag, 10.0).difference(&reference);
            // The pass band is flat to 2e-4, the tone beyond it 80 dB down: 5e-4 of the rest.
            assert!(found.worst < 0.02 && found.force < 2e-3, "{time_step} {lag}: {found:?}");
        }
        assert_eq!(reference.difference(&reference), RunDifference::default());
    }

    #[test]
    fn differences_are_those_of_tones() {
        let (louder, reference) = (common(1.3e-4, 0.0, 20.0), common(1e-4, 0.0, 10.0));
        let found = louder.difference(&reference);
        // One tone doubled: 6.02 dB in its band; 10^2/2 of (10^2 + 5^2)/2. Bands without a tone contain leakage.
        let level = |of: &Common, frequency: f64| {
            of.levels.iter().find(|band| (band.band.nominal_frequency() - frequency).abs() < 1e-9).unwrap().level
        };
        assert!((level(&louder, 200.0) - level(&reference, 200.0) - 6.02).abs() < 0.05);
        assert!((level(&louder, 1000.0) - level(&reference, 1000.0)).abs() < 0.05);
        assert!(found.worst >= 6.0, "{found:?}");
        assert!((found.force - (100.0_f64 / 125.0).sqrt()).abs() < 5e-3, "{found:?}");
    }

    #[test]
    fn means_do_not_count_as_variation_and_silence_is_no_level() {
        assert!((relative_difference(&[2.0, 4.0, 6.0], &[1.0, 2.0, 3.0]) - 1.0).abs() < 1e-15);
        assert!(relative_difference(&[6.0, 7.0, 8.0], &[1.0, 2.0, 3.0]) < 1e-15);
        let level = |level| BandLevel { band: ThirdOctaveBand(0), mean_square: 1.0, level, valid: true };
        assert!(level_changes(&[level(f64::NEG_INFINITY)], &[level(3.0)]).all(|(_, change)| change.is_nan()));
        assert!(level_changes(&[], &[level(3.0)]).all(|(_, change)| change.is_nan()));
    }

    #[test]
    fn a_change_is_valid_where_both_levels_are() {
        let level = |valid| [BandLevel { band: ThirdOctaveBand(0), mean_square: 1.0, level: 0.0, valid }];
        for (found, reference) in [(true, true), (true, false), (false, true), (false, false)] {
            let valid = level_changes(&level(found), &level(reference)).all(|(band, _)| band.valid);
            assert_eq!(valid, found && reference);
        }
    }
}
