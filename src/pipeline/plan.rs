//! What a scene will take, before anything is allocated.

use std::f64::consts::PI;

use serde::Serialize;

use crate::contact::factors::largest_memory;
use crate::contact::history::modes::INSTANTS;
use crate::scene::{Axle, History, LoadedScene, Numerics, Resolution, Road, Rolling, Scene, SceneError};
use crate::tyre::surface_asymptote::{LARGEST_ARGUMENT, thickness_limit};

/// Sizes, memory and work of a run. Estimates count the large arrays and the inner loops only.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Speed V \[m/s\].
    pub speed: f64,
    /// Element length dx = L/N \[m\].
    pub element: f64,
    /// Time step dt = dx/(q V) \[s\].
    pub time_step: f64,
    /// Time steps before anything counts.
    pub warm_up_steps: u64,
    /// All time steps.
    pub steps: u64,
    /// Lags of the history, lag 0 included.
    pub lags: usize,
    /// Largest memory \[bytes\].
    pub memory: f64,
    /// Result arrays \[bytes\].
    pub result_bytes: f64,
    /// Evaluations of the compliance.
    pub evaluations: f64,
    /// Multiply-adds of history and search.
    pub multiply_adds: f64,
    /// Rough computing time on one core \[s\]: 0.4 us an evaluation, 0.1 ns a multiply-add, 2 us a step, 40 us a row of a rough road.
    pub core_seconds: f64,
}

/// Widest contact that is expected when nothing is known yet, as a share of the circumference.
const EXPECTED_PATCH: f64 = 0.1;
/// Compliance evaluations of a fit and its poles for a wavenumber, conjugates counted, both rounded up: they hardly depend on anything.
const FIT_EVALUATIONS: f64 = 2e6;
const POLES: f64 = 45.0;
/// Arrays of the streamed spectrum, in segments.
const SPECTRUM_ARRAYS: f64 = 8.0;
/// Segments of the averaged spectrum \[s\].
pub(super) const SEGMENT: f64 = 0.5;

/// What a way to carry the past takes.
struct PastEstimate {
    evaluations: f64,
    /// For a step.
    multiply_adds: f64,
    /// Numbers kept.
    numbers: f64,
}

impl Plan {
    /// The plan of a scene.
    pub fn new(scene: &Scene) -> Self {
        let Scene { tyre, rolling, numerics, .. } = scene;
        let Rolling { duration, warm_up, speed_kmh, .. } = rolling;
        let speed = speed_kmh / 3.6;
        let elements = numerics.elements as f64;
        let element = tyre.circumference / elements;
        let time_step = element / (numerics.substeps as f64 * speed);
        // Casts of huge values saturate; the memory estimate below works in f64 and refuses them.
        let steps_of = |time: f64| (time / time_step).round();
        let warm_up_steps = steps_of(*warm_up);
        let steps = warm_up_steps + steps_of(*duration).max(1.0);
        let lags = (steps_of(numerics.memory) + 1.0).min(steps + 1.0).max(2.0);

        let columns = (EXPECTED_PATCH * elements).clamp(8.0, elements);
        let contour = 2.0 * lags;
        let wavenumbers = elements / 2.0 + 1.0;
        let tread = &tyre.layers[tyre.layers.len() - 1];
        let shear_speed =
            (tread.material.modulus / (2.0 * (1.0 + tread.material.poisson) * tread.material.density)).sqrt();
        let cut_off = thickness_limit(tread.thickness, numerics.influence_tolerance)
            .max(2.0 / (time_step * shear_speed * LARGEST_ARGUMENT.sqrt()));
        let lateral = numerics.lateral_terms.map_or(cut_off * tyre.width / (2.0 * PI), |terms| terms as f64);
        let aliases = match (numerics.lateral_terms, numerics.wavenumber_aliases) {
            (_, Some(aliases)) => 2.0 * aliases as f64 + 1.0,
            (Some(_), None) => 100.0,
            (None, None) => (2.0 * cut_off * element / (2.0 * PI)).max(1.0),
        };
        let points = columns / 2.0;
        let past = match numerics.history {
            History::Direct => PastEstimate {
                evaluations: wavenumbers * contour / 2.0 * lateral.max(1.0) * aliases,
                multiply_adds: lags * columns * columns / 2.0,
                numbers: wavenumbers * lags + lags * (2.0 * columns + 9.0) + lags * columns + 75.0 * contour / 2.0,
            },
            History::Modal => PastEstimate {
                evaluations: FIT_EVALUATIONS,
                multiply_adds: 10.0 * POLES * wavenumbers + INSTANTS as f64 / 2.0 * points * columns,
                numbers: 10.0 * POLES * wavenumbers + 6.0 * INSTANTS as f64 * elements,
            },
        };
        // A factorisation for every second step, a solution, and the sums of guess and displacement.
        let search = points.powi(3) / 12.0 + points * points + 4.0 * points * columns;
        let multiply_adds = steps * (past.multiply_adds + search);
        let rows = if matches!(scene.road, Road::Smooth) { 0.0 } else { steps / numerics.substeps as f64 };
        let memory = 8.0
            * (past.numbers + SPECTRUM_ARRAYS * (SEGMENT / time_step).min(2.0 * steps) + wavenumbers * 24.0 * 14.0)
            + largest_memory(numerics.cached_factors, columns as usize) as f64;
        Self {
            speed,
            element,
            time_step,
            warm_up_steps: warm_up_steps as u64,
            steps: steps as u64,
            lags: lags as usize,
            memory,
            result_bytes: if scene.outputs.arrays { 8.0 * steps * (columns + 3.0) } else { 0.0 },
            evaluations: past.evaluations,
            multiply_adds,
            core_seconds: 4e-7 * past.evaluations + 1e-10 * multiply_adds + 2e-6 * steps + 4e-5 * rows,
        }
    }

    /// Refuses a plan that needs more memory or time than the scene allows, and what cannot be simulated at all.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with a complaint that points into the scene.
    pub fn check(&self, loaded: &LoadedScene) -> Result<(), SceneError> {
        let numerics = &loaded.scene.numerics;
        let gigabytes = self.memory / 1e9;
        let rule = numerics.time_rule;
        let complaint = if numerics.history == History::Direct && !rule.is_multistep() {
            let why = if rule.runge_kutta().is_some() {
                "couples the stages of a step: its weights are matrices, which the direct sum does not keep"
            } else {
                "is no convolution quadrature: it needs the tyre's modes"
            };
            let wrong = format!("\"{}\" {why}", rule.name());
            loaded.complain("numerics.time_rule", wrong, "history = \"modal\", or a multistep rule such as \"bdf2\"")
        } else if gigabytes > numerics.memory_limit {
            loaded.complain(
                "numerics.elements",
                format!(
                    "{} elements, {} lags and {} steps need about {} of memory, more than numerics.memory_limit = {} GB",
                    numerics.elements,
                    self.lags,
                    self.steps,
                    bytes(self.memory),
                    numerics.memory_limit
                ),
                "fewer elements, a shorter memory, or a larger memory_limit",
            )
        } else if self.core_seconds / 3600.0 > numerics.time_limit {
            loaded.complain(
                "numerics.elements",
                format!(
                    "{} elements and {} steps need about {:.1e} core hours, more than numerics.time_limit = {} h",
                    numerics.elements,
                    self.steps,
                    self.core_seconds / 3600.0,
                    numerics.time_limit
                ),
                "fewer elements, a shorter run, or a larger time_limit",
            )
        } else {
            return Ok(());
        };
        Err(complaint.into())
    }

    /// Why elements and time step are what they are, for a scene with `fmax`.
    pub fn resolution_note(scene: &Scene) -> Option<String> {
        let Numerics { fmax, elements, substeps, time_rule, .. } = scene.numerics;
        let (highest, speed) = (fmax?, scene.rolling.speed());
        let resolution = Resolution { elements, substeps };
        let texture = resolution.texture_limit(scene.tyre.circumference, speed);
        let rule = resolution.rule_limit(scene.tyre.circumference, speed, time_rule);
        Some(format!(
            "fmax = {highest} Hz: {elements} elements ({:.1} per texture wavelength), {substeps} steps per element ({} stays within {} % in phase and damping up to {rule:.0} Hz)",
            2.0 * texture / highest,
            time_rule.name(),
            100.0 * Resolution::RULE_ERROR
        ))
    }

    /// The ramp of an axle that is held by its height, in steps.
    pub fn ramp_steps(&self, axle: &Axle) -> f64 {
        match axle {
            Axle::Indentation { ramp, .. } => ramp / self.time_step,
            Axle::Load { .. } | Axle::Mass { .. } => 0.0,
        }
    }
}

/// A number of bytes for people.
pub fn bytes(count: f64) -> String {
    match count {
        c if c < 1e3 => format!("{c:.0} B"),
        c if c < 1e6 => format!("{:.1} kB", c / 1e3),
        c if c < 1e9 => format!("{:.1} MB", c / 1e6),
        c if c < 1e12 => format!("{:.1} GB", c / 1e9),
        c => format!("{:.1e} GB", c / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::DEFAULT;

    #[test]
    fn the_estimate_knows_how_the_past_is_carried() {
        let text =
            DEFAULT.replace("elements = 512", "elements = 4096").replace("speed_kmh = 80.0", "speed_kmh = 250.0");
        let mut loaded = Scene::from_str(&text, "estimate").unwrap();
        loaded.scene.rolling.duration = 1.0;
        let modal = Plan::new(&loaded.scene);
        assert!(modal.check(&loaded).is_ok(), "{} core seconds", modal.core_seconds);
        loaded.scene.numerics.memory *= 2.0;
        assert_eq!(
            Plan::new(&loaded.scene).core_seconds.to_bits(),
            modal.core_seconds.to_bits(),
            "poles have no memory"
        );
        loaded.scene.numerics.history = History::Direct;
        let direct = Plan::new(&loaded.scene);
        assert!(direct.core_seconds > 1000.0 * modal.core_seconds && direct.memory > modal.memory);
        assert!(direct.check(&loaded).is_err());
    }
}
