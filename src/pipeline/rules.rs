//! Time rules side by side for one scene: accuracy of modes, stability of the inverse, work against precision.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use num_complex::Complex64;
use realfft::RealFftPlanner;

use super::error::RunError;
use super::past::{contact_field, fetch, fit_options, refused};
use super::plan::Plan;
use super::prepare::prepare;
use crate::contact::ContactError;
use crate::contact::stability::Stability;
use crate::meter::{Meter, Watch};
use crate::scene::{Axle, History, LoadedScene, TimeRule};

/// Ramp of the axle in a comparison, and what is left out at its begin \[s\].
const SETTLING: f64 = 0.1;

/// What a rule is for a scene's tyre and time step.
#[derive(Clone, Debug)]
pub struct RuleReport {
    /// The rule.
    pub rule: TimeRule,
    /// Diagnosis of its inverse.
    pub stability: Stability,
}

/// Diagnosis of every rule at the scene's time step.
///
/// # Errors
/// A fit that was refused, or stopped by `stop`.
pub fn compare(loaded: &LoadedScene, stop: &AtomicBool) -> Result<Vec<RuleReport>, RunError> {
    let scene = &loaded.scene;
    let plan = Plan::new(scene);
    let field = contact_field(plan.decisions.tread);
    let model = fetch(&plan.decisions.tyre, &fit_options(scene, field), stop)
        .map_err(|error| refused(loaded, error, "another tolerance"))?;
    let time_step = plan.time_step;
    TimeRule::ALL
        .into_iter()
        .map(|rule| {
            let stability =
                Stability::of(&model.model, field, rule, time_step, 0.0).ok_or(ContactError::NoSuchField)?;
            Ok(RuleReport { rule, stability })
        })
        .collect()
}

/// One run of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct WorkPoint {
    /// The rule.
    pub rule: TimeRule,
    /// Steps per element.
    pub substeps: usize,
    /// Error of the total force up to the highest frequency, relative to its root mean square there.
    pub error: f64,
    /// Multiply-adds of the history.
    pub multiply_adds: u64,
    /// Linear solves.
    pub solves: u64,
    /// Wall time in history and search.
    pub wall: Duration,
}

/// A comparison.
#[derive(Clone, Debug)]
pub struct WorkPrecision {
    /// Runs, by rule and substeps.
    pub points: Vec<WorkPoint>,
    /// How far the two references (`sdirk2` and `bdf2` at `finest` substeps) are apart: what an error below this says nothing about.
    pub doubt: f64,
    /// Time compared \[s\].
    pub time: f64,
}

/// Rolls the scene at a fixed height with each rule and number of substeps and compares the forces up to `highest` \[Hz\] with those at `finest` substeps,
/// over `duration` \[s\]. The history is modal throughout. `stop` is looked at while a tyre is fitted, and between two runs.
///
/// # Errors
/// Of a run.
pub fn work_precision(
    loaded: &LoadedScene,
    rules: &[TimeRule],
    substeps: &[usize],
    finest: usize,
    highest: f64,
    duration: f64,
    stop: &AtomicBool,
) -> Result<WorkPrecision, RunError> {
    let mut loaded = loaded.clone();
    loaded.scene.numerics.history = History::Modal;
    loaded.scene.rolling.warm_up = SETTLING;
    loaded.scene.rolling.duration = duration;
    if loaded.scene.rolling.axle.load().is_some() {
        // The same height for every rule.
        let at_rest = prepare(&loaded, &Plan::new(&loaded.scene), stop, &mut Meter::default())?.at_rest;
        loaded.scene.rolling.axle = Axle::Indentation { indentation: at_rest.indentation, ramp: 0.5 * SETTLING };
    }
    let (reference, _) = rolled(&loaded, TimeRule::Sdirk2, finest, highest, stop)?;
    let (other, _) = rolled(&loaded, TimeRule::Bdf2, finest, highest, stop)?;
    let mut points = Vec::new();
    for &rule in rules {
        for &substeps in substeps {
            let (spectrum, point) = rolled(&loaded, rule, substeps, highest, stop)?;
            points.push(WorkPoint { error: difference(&spectrum, &reference), ..point });
        }
    }
    Ok(WorkPrecision { points, doubt: difference(&other, &reference), time: duration })
}

fn difference(a: &[Complex64], b: &[Complex64]) -> f64 {
    let square = |values: &mut dyn Iterator<Item = Complex64>| values.map(|value| value.norm_sqr()).sum::<f64>();
    let error = square(&mut a.iter().zip(b).map(|(a, b)| a - b));
    (error / square(&mut b.iter().copied())).sqrt()
}

/// The force spectrum up to a frequency (Hann window; the constant and its neighbours left out), and what it cost.
fn rolled(
    loaded: &LoadedScene,
    rule: TimeRule,
    substeps: usize,
    highest: f64,
    stop: &AtomicBool,
) -> Result<(Vec<Complex64>, WorkPoint), RunError> {
    let mut loaded = loaded.clone();
    (loaded.scene.numerics.time_rule, loaded.scene.numerics.substeps) = (rule, substeps);
    let plan = Plan::new(&loaded.scene);
    plan.check(&loaded)?;
    if stop.load(Ordering::Relaxed) {
        return Err(RunError::Interrupted { kept: None });
    }
    let mut meter = Meter::new(Watch::EVERY);
    let mut prepared = prepare(&loaded, &plan, stop, &mut meter)?;
    let columns = prepared.march.geometry().columns as i64;
    // Whole elements, so that every number of substeps sees the same stretch of time.
    let elements_of = |steps: u64| steps / substeps as u64;
    let skipped = elements_of(plan.warm_up_steps) * substeps as u64;
    let kept = (elements_of(plan.steps - plan.warm_up_steps).max(4) - 2) * substeps as u64;
    let mut force = Vec::with_capacity(kept as usize);
    for step in 0..skipped + kept {
        prepared.march.set_clocks(meter.begin_step(step));
        let first = prepared.march.geometry().first_element(step);
        prepared.road.reach(first, first + columns, &mut meter, None)?;
        let result = prepared.march.step(&prepared.axle, prepared.road.slices())?;
        if step >= skipped {
            force.push(result.total_force);
        }
    }
    let times = prepared.march.take_times();
    let parts = [times.history, times.transforms, times.search, times.factorisation];
    let (totals, counts) = (prepared.march.totals(), prepared.march.search_counts());
    let point = WorkPoint {
        rule,
        substeps,
        error: 0.0,
        multiply_adds: totals.history.sums.multiply_adds,
        solves: counts.solves,
        wall: parts.iter().map(|part| part.wall).sum(),
    };
    let length = force.len();
    let mean = force.iter().sum::<f64>() / length as f64;
    for (index, value) in force.iter_mut().enumerate() {
        let window = 0.5 - 0.5 * (2.0 * PI * index as f64 / length as f64).cos();
        *value = (*value - mean) * window / length as f64;
    }
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    let mut spectrum = transform.make_output_vec();
    // Planned lengths.
    let _ = transform.process(&mut force, &mut spectrum);
    let time = length as f64 * plan.time_step;
    let last = ((highest * time) as usize).min(spectrum.len() - 1);
    let mut spectrum: Vec<Complex64> = spectrum[..=last].to_vec();
    if rule.runge_kutta().is_some() {
        // A mean over the step that ends at l dt: half a step late, and lower by sin(x)/x.
        for (bin, value) in spectrum.iter_mut().enumerate().skip(1) {
            let half = PI * bin as f64 / length as f64;
            *value *= Complex64::from_polar(half / half.sin(), half);
        }
    }
    Ok((spectrum.split_off(3.min(last)), point))
}
