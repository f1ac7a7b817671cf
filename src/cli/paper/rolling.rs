//! Figures and statements from rolling: slices by both laws (figure 4), forces in the patch (figure 5), tread laws
//! (figure 6), solves of the contact search, and the limit of equation 4.

use std::collections::BTreeMap;

use crate::contact::complementarity::Residuals;
use crate::counters::Meter;
use crate::effects::{Observer, RunError, Step};
use crate::report::slices::pictures;
use crate::response::LevelErrors;
use crate::results::plots::{ForceMap, ThirdOctavePlot};
use crate::results::spectra::FORCE_LEVEL;
use crate::scene::{LoadedScene, Scene, SliceCoupling, Tread};
use crate::study::slices::{LAWS, Sample, Spread, spread};
use crate::study::trial::{Common, Trial, Trials};
use ndarray::ArrayView2;
use serde_json::{Value, json};

use super::subject::{Change, INSIGNIFICANT, Subject, Verdict, changes, largest};
use crate::cli::error::CliError;

/// Road coordinate of the slice that is drawn \[m\], and number of slices in the statistics from there on.
const PLACE: f64 = 0.5;
const SLICES: usize = 1000;
/// How often the steps of equation 4 are halved, and the time of each of these runs after the warm-up \[s\].
pub(super) const HALVINGS: u32 = 4;
pub(super) const HALVED_DURATION: f64 = 1.0;
/// Least order of convergence that counts as such.
const LEAST_ORDER: f64 = 0.5;
/// Length of the last part of the run whose forces are drawn \[s\].
const SHOWN: f64 = 0.04;
/// Frequency at which the paper finds the largest effect of the bedding: the contact resonance \[Hz\].
const RESONANCE: f64 = 800.0;
/// The largest change counts as being there within this factor in frequency: two third octaves.
const NEAR: f64 = 1.6;
/// Finest tolerance of the poles of the carcass under a bedding: with 512 elements they reach 1.2e-3.
const BEDDING_POLES: f64 = 2e-3;
/// Share of instants that may take more solves than the paper states.
const RARE: f64 = 0.01;
/// Largest relative residual at which the contact conditions count as satisfied.
const SOLVED: f64 = 1e-6;

/// Recorder of the elements' forces at the steps of a run from `from` \[s\] on.
#[derive(Clone, Debug, Default)]
pub(super) struct Recorder {
    from: f64,
    time: Vec<f64>,
    first_element: Vec<i64>,
    /// \[N\], step by step.
    force: Vec<f64>,
    columns: usize,
    /// Road coordinate under the axle at t = 0 \[m\].
    start: f64,
}

impl Recorder {
    pub(super) fn new(scene: &Scene) -> Self {
        Self { from: scene.rolling.warm_up + scene.rolling.duration - SHOWN, ..Self::default() }
    }
}

impl Observer for Recorder {
    fn observe(&mut self, step: &Step<'_>, _: &mut Meter) -> Result<(), RunError> {
        if step.time >= self.from {
            (self.columns, self.start) = (step.geometry.columns, step.geometry.start);
            self.time.push(step.time);
            self.first_element.push(step.footprint.first_element());
            self.force.extend_from_slice(step.footprint.column_mean());
        }
        Ok(())
    }
}

/// The run of a scene, and runs beside it.
pub(super) struct Rolling<'a, 'b> {
    pub loaded: &'a LoadedScene,
    /// The run with the scene's laws: an elastic tread, springs under the slices.
    pub run: Trial,
    /// Highest frequency compared \[Hz\].
    pub highest: f64,
    pub trials: &'a mut Trials<'b>,
}

impl Rolling<'_, '_> {
    fn with(&mut self, change: impl Fn(&mut Scene)) -> Result<Trial, RunError> {
        let mut scene = self.loaded.scene.clone();
        change(&mut scene);
        self.trials.roll(&scene)
    }

    /// Figure 4: a slice, the spread of S over the road by both laws, and what the law does to the force; also returns
    /// the run by equation 4.
    pub(super) fn slices(&mut self) -> Result<(Subject, Trial), CliError> {
        let sample = Sample::of(self.loaded, PLACE, SLICES)?;
        let curves = sample.curves(self.loaded.scene.contact.slice_tolerance)?;
        let spread = spread(&curves, &sample.depths());
        let explicit = |scene: &mut Scene| scene.contact.slice_coupling = SliceCoupling::Explicit;
        let half_space = |scene: &mut Scene| scene.contact.slices = LAWS[1].0;
        let local = self.with(half_space)?;
        let paper = self.with(explicit)?;
        let both = self.with(|scene| {
            explicit(scene);
            half_space(scene);
        })?;
        let pairs = [("local", &self.run, &local), ("equation_4", &paper, &both)];
        let mut subject = Subject::new("Figure 4", "slice", json!({ "slices": curves[0].len(), "spread": spread }));
        let [local, equation_4] = pairs.map(|(key, springs, half_space)| {
            let changes = changes(half_space, springs, self.highest);
            let largest = largest(&changes, f64::abs);
            let mean_force = [springs, half_space].map(Trial::mean_force);
            subject.numbers[key] = json!({ "mean_force": mean_force, "changes": changes, "largest": largest });
            largest
        });
        let displacement = |of: &Spread| format!("{:.0} % at {:.1} mm", 100.0 * of.difference, 1e3 * of.penetration);
        let ends: Vec<String> = spread.first().into_iter().chain(spread.last()).map(displacement).collect();
        let why = format!("third octaves of the force by equation 4 within {INSIGNIFICANT} dB");
        subject.state(
            ["springs or half-space under a slice", "no significant difference between the two"],
            format!("force: {equation_4} by equation 4, {local} by the local law; S: {}", ends.join(", ")),
            (Verdict::of(equation_4.change.abs() <= INSIGNIFICANT), why),
        );
        if let Some(view) = sample.view([&curves[0][0], &curves[1][0]])? {
            let caption = "Profile, pressure, displacement S and normalised stiffness s of a slice, by both laws.";
            let drawn = pictures("A slice of the road", &view);
            subject.pictures.extend(drawn.into_iter().map(|(file, svg)| ([file, caption], svg)));
        }
        Ok((subject, paper))
    }

    /// Figure 5: force over contact and time.
    pub(super) fn patch_forces(&self, recorder: &Recorder) -> Result<Subject, CliError> {
        let Recorder { time, first_element, force, columns, start, .. } = recorder;
        let (element_length, speed) = (self.run.plan.element, self.run.plan.speed);
        let carrying: Vec<f64> = force.iter().copied().filter(|force| *force > 0.0).collect();
        let mean = carrying.iter().sum::<f64>() / carrying.len().max(1) as f64;
        let [smallest, largest] = [f64::min, f64::max].map(|of| force.iter().copied().fold(0.0, of));
        let length = self.run.contact_length();
        let numbers = json!({ "smallest": smallest, "largest": largest, "mean": mean, "length": length });
        let mut subject = Subject::new("Figure 5", "patch_forces", numbers);
        let patch = format!("patch of {:.0} mm", 1e3 * length);
        subject.state(
            ["force over contact and time", "a picture"],
            format!("{patch}; {mean:.0} N on an element that touches, {smallest:.0} to {largest:.0} N"),
            (Verdict::NotComparable, "the paper's road and load are not given in numbers"),
        );
        if let Ok(force) = ArrayView2::from_shape((time.len(), *columns), force) {
            let (title, start, shown) = ("Force over contact and time", *start, 0.0..f64::INFINITY);
            let map = ForceMap { title, time, first_element, force, element_length, speed, start, shown };
            let names = ["patch_force.svg", "Forces of the elements while they pass the patch."];
            subject.pictures.push((names, map.to_svg()?));
        }
        Ok(subject)
    }

    /// Figure 6: third octaves of the contact force by the tread laws, at the same static contact stiffness.
    pub(super) fn tread_laws(&mut self) -> Result<Subject, CliError> {
        let bedding = self.with(|Scene { contact, numerics, .. }| {
            contact.tread = Tread::Bedding;
            numerics.pole_tolerance = numerics.pole_tolerance.max(BEDDING_POLES);
        })?;
        let uncoupled = self.with(|Scene { contact, .. }| {
            (contact.tread, contact.equal_stiffness) = (Tread::Uncoupled, true);
        })?;
        let laws = [("elastic", &self.run), ("bedding", &bedding), ("uncoupled", &uncoupled)];
        let of_laws = laws.map(|(_, trial)| changes(trial, &self.run, self.highest));
        let [_, of_bedding, of_uncoupled] = &of_laws;
        let above = of_bedding.iter().filter(|of| of.change > 0.0).count();
        let mean = of_bedding.iter().map(|of| of.change).sum::<f64>() / of_bedding.len() as f64;
        let (most, within) = (largest(of_bedding, |change| change), largest(of_uncoupled, f64::abs).change.abs());
        let mut numbers: Vec<Value> = Vec::new();
        for ((name, trial), changes) in laws.iter().zip(&of_laws) {
            numbers.push(json!({ "name": name, "mean_force": trial.mean_force(), "changes": changes }));
        }
        let numbers = json!({ "laws": numbers, "mean_of_bedding": mean, "most": most });
        let mut subject = Subject::new("Figure 6", "tread_laws", numbers);
        let mean_change = format!("{mean:+.1} dB in the mean, higher in {above} of {} third octaves", of_bedding.len());
        subject.state(
            ["bedding beside the elastic tread, same contact stiffness", "the bedding shows higher levels"],
            format!("{mean_change}; the uncoupled tread within {within:.2} dB"),
            (Verdict::of(mean >= INSIGNIFICANT), format!("in the mean {INSIGNIFICANT} dB higher or more")),
        );
        subject.state(
            ["where the bedding is highest above the elastic tread", "near 800 Hz, the contact resonance"],
            most.to_string(),
            (is_near_the_resonance(most), format!("the largest rise within two third octaves of {RESONANCE} Hz")),
        );
        let plot = ThirdOctavePlot {
            title: "Contact force by tread laws",
            quantity: FORCE_LEVEL,
            spectra: laws.iter().map(|(name, trial)| (*name, trial.levels.as_slice())).collect(),
            errors: LevelErrors::default(),
        };
        let caption = "Contact force by three laws of the tread at the same static contact stiffness.";
        subject.pictures.push((["tread_laws.svg", caption], plot.to_svg()?));
        Ok(subject)
    }

    /// Solves of the search for the points in contact, by the local law and by equation 4, whose run is given.
    pub(super) fn search(&self, equation_4: &Trial) -> Subject {
        let mut subject = Subject::new("Contact search", "search", json!({}));
        let (mut solves, mut most, mut fallbacks, mut worst) = (Vec::new(), 0.0_f64, 0, 0.0_f64);
        for (name, key, of) in
            [("local law", "local", &self.run.results), ("equation 4", "equation_4", &equation_4.results)]
        {
            let histogram = of.search.solves_per_step();
            let [one, two_or_three, more] = shares(&histogram);
            subject.numbers[key] = json!({
                "histogram": histogram, "one": one, "two_or_three": two_or_three, "more": more,
                "fallbacks": of.search.fallbacks, "residuals": of.residuals,
            });
            let percent = [one, two_or_three, more].map(|share| format!("{:.1} %", 100.0 * share));
            solves.push(format!("{name}: one {}, two or three {}, more {}", percent[0], percent[1], percent[2]));
            let Residuals { tension, penetration, complementarity } = of.residuals;
            worst = worst.max(tension).max(penetration).max(complementarity);
            (most, fallbacks) = (most.max(more), fallbacks + of.search.fallbacks);
        }
        let why = format!("more than three solves in less than {} % of the instants", 100.0 * RARE);
        subject.state(
            ["solves in a step", "one when the guess is right, one or two more otherwise"],
            solves.join("; "),
            (Verdict::of(most < RARE), why),
        );
        let why = format!("conditions of contact missed by more than {SOLVED:.0e}: only then is a search given up");
        subject.state(
            ["searches given up", "a search may be given up: only positive forces are kept"],
            format!("conditions of contact met to {worst:.0e}; {fallbacks} least-index fallbacks"),
            (Verdict::of(worst > SOLVED), why),
        );
        subject
    }

    /// Limit of equation 4 as the time step decreases, beside the local law: the axle held, half of the elements.
    pub(super) fn equation_4(&mut self) -> Result<Subject, CliError> {
        let mut coarse = self.loaded.scene.clone();
        coarse.numerics.elements /= 2;
        let mut scene = self.trials.held(&coarse, HALVED_DURATION)?;
        let within = scene.rolling.warm_up..scene.rolling.warm_up + HALVED_DURATION;
        let (mut numbers, mut found, mut converge) = (Vec::new(), Vec::new(), true);
        for (name, coupling) in [("local law", SliceCoupling::Local), ("explicit", SliceCoupling::Explicit)] {
            scene.contact.slice_coupling = coupling;
            // 1. Forces with 1, 2, 4, ... steps per element.
            let (mut steps, mut forces) = (Vec::new(), Vec::new());
            for halving in 0..=HALVINGS {
                scene.numerics.substeps = 1 << halving;
                let trial = self.trials.roll(&scene)?;
                steps.push(trial.plan.time_step);
                forces.push(Common::of(&trial, within.clone(), self.highest));
            }
            // 2. Differences between successive ones: root mean square relative to the force's variation.
            let differences: Vec<f64> = forces.windows(2).map(|pair| pair[0].difference(&pair[1]).force).collect();
            let (order, converges) = limit(&differences);
            converge &= converges;
            let [first, last] = [differences[0], differences[differences.len() - 1]];
            found.push(format!("{name} {first:.3} to {last:.3} (order {order:.1})"));
            numbers.push(json!({ "name": name, "steps": steps, "differences": differences, "order": order }));
        }
        let numbers = json!({ "elements": scene.numerics.elements, "couplings": numbers });
        let mut subject = Subject::new("Equation 4", "equation_4", numbers);
        subject.state(
            ["change of the force by halving the time step", "F = G0^-1 S(y)"],
            found.join("; "),
            (Verdict::of(converge), "each halving changes the force less than the one before, towards a limit"),
        );
        Ok(subject)
    }
}

fn is_near_the_resonance(most: Change) -> Verdict {
    Verdict::of(most.change > 0.0 && (RESONANCE / NEAR..=RESONANCE * NEAR).contains(&most.frequency))
}

/// Shares of the instants in contact that took one solve, two or three, and more, by the number of instants for each
/// number of solves.
fn shares(histogram: &BTreeMap<u32, u64>) -> [f64; 3] {
    let count = |solves: std::ops::Range<u32>| histogram.range(solves).map(|(_, steps)| *steps).sum::<u64>() as f64;
    let all = count(1..u32::MAX).max(1.0);
    [1..2, 2..4, 4..u32::MAX].map(|solves| count(solves) / all)
}

/// Order of the last halving, lg2 of the ratio of the last two differences, and whether they converge.
fn limit(differences: &[f64]) -> (f64, bool) {
    let [.., coarse, fine] = differences else { return (0.0, false) };
    let order = (coarse / fine).log2();
    (order, order >= LEAST_ORDER)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bedding_must_be_highest_near_the_resonance() {
        let near = |frequency, change| is_near_the_resonance(Change { frequency, change }) == Verdict::Agrees;
        assert!(near(800.0, 6.0) && near(500.0, 1.0) && near(1250.0, 1.0));
        assert!(!near(400.0, 6.0) && !near(1600.0, 6.0) && !near(800.0, -1.0) && !near(f64::NAN, f64::NAN));
    }

    #[test]
    fn solves_are_shared_out_over_the_instants_in_contact() {
        let found = shares(&[(0, 50), (1, 90), (2, 5), (3, 3), (4, 1), (11, 1)].into());
        for (share, expected) in found.iter().zip([0.9, 0.08, 0.02]) {
            assert!((share - expected).abs() < 1e-12, "{found:?}");
        }
        assert!(shares(&BTreeMap::new()).iter().sum::<f64>().abs() < 1e-12);
    }

    #[test]
    fn differences_that_stay_have_no_limit() {
        let (order, converges) = limit(&[0.3, 0.08, 0.02]);
        assert!(converges && (order - 2.0).abs() < 1e-12, "{order}");
        let (order, converges) = limit(&[0.36, 0.35, 0.37]);
        assert!(!converges && order.abs() < 0.1, "{order}");
        assert!(!limit(&[0.1]).1 && !limit(&[]).1 && !limit(&[0.0, 0.0]).1);
    }
}
