//! Combinations of settings: which ones to run.
//!
//! Errors of single knobs are taken to add as independent ones do: e^2 is the sum of their squares, those of elements,
//! of rule and time step, of poles, of cells and of curves. Work is the plan's. Both are corrected by what the
//! combinations rolled so far have shown, the more the closer they are.

use serde::Serialize;

use crate::plan::Plan;
use crate::scene::{Scene, TimeRule};
use crate::study::accuracy::front::front;
use crate::study::accuracy::knobs::{Kind, Knob};
use crate::study::accuracy::lab::{Point, planned_march, planned_road};
use crate::study::accuracy::settings::Settings;
use crate::study::trial::least_rate;

/// Steps per element that are combined.
const SUBSTEPS: [usize; 6] = [1, 2, 3, 4, 6, 8];
/// A time step may lie outside those swept by at most this factor.
const BEYOND: f64 = 1.6;
/// Weight of "no correction" against that of a run with the same settings, which is 1.
const PRIOR: f64 = 0.25;
/// Combinations with a larger expected error are not considered \[dB\].
const LARGEST_ERROR: f64 = 10.0;

/// A combination and what is expected of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// Scene that would be rolled.
    #[serde(skip)]
    pub settings: Settings,
    /// Expected largest difference of a level \[dB\].
    #[serde(rename = "expected_error")]
    pub error: f64,
    /// Expected multiply-adds in a second rolled.
    #[serde(rename = "expected_multiply_adds")]
    pub multiply_adds: f64,
}

/// A combination that was rolled, with its expectation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Joint {
    /// Work and error as found.
    pub point: Point,
    /// Work and error as expected when it was chosen, corrections included.
    #[serde(flatten)]
    pub expected: Candidate,
    /// Error and work expected from single knobs alone, without corrections.
    #[serde(skip)]
    pub plain: (f64, f64),
}

/// All combinations of the swept settings, with error and work expected from single knobs: errors add as squares.
pub(crate) fn candidates(scene: &Scene, reference: &Settings, knobs: &[Knob], highest: f64) -> Vec<Candidate> {
    let steps = |name: &str| -> Vec<(Settings, f64)> {
        let knob = knobs.iter().find(|knob| knob.name == name && knob.kind == Kind::Error && knob.anchor.is_none());
        let known = knob.into_iter().flat_map(|knob| &knob.points);
        // The reference itself, whose error is none.
        known.map(|point| (point.settings.clone(), point.difference.worst)).chain([(reference.clone(), 0.0)]).collect()
    };
    // 1. Errors of single knobs, as they were swept; those of a rule over its time step.
    let elements = steps("elements");
    let (poles, cells, curves) = (steps("pole tolerance"), steps("cells"), steps("slice tolerance"));
    let rules: Vec<(TimeRule, Vec<(f64, f64)>)> = TimeRule::ALL
        .into_iter()
        .map(|rule| {
            let name = if rule == reference.numerics.time_rule { "substeps" } else { rule.name() };
            let known =
                steps(name).into_iter().filter(|(settings, error)| settings.numerics.time_rule == rule && *error > 0.0);
            (rule, known.map(|(settings, error)| (settings.time_step(scene), error)).collect())
        })
        .filter(|(_, known): &(TimeRule, Vec<_>)| known.len() > 1)
        .collect();
    let rolled = scene.rolling.warm_up + scene.rolling.duration;
    // 2. Work of every combination, from its plan with one step per element. All plans share the reference's static
    //    contact, their costly part.
    let of_reference = Plan::new(&reference.on(scene));
    let mut found = Vec::new();
    for (with_elements, of_elements) in &elements {
        for (with_cells, of_cells) in &cells {
            for (with_poles, of_poles) in &poles {
                for (rule, known) in &rules {
                    let base = reference.with(|Settings { numerics, contact, cell_length }| {
                        (numerics.elements, numerics.substeps) = (with_elements.numerics.elements, 1);
                        numerics.time_rule = *rule;
                        numerics.pole_tolerance = with_poles.numerics.pole_tolerance;
                        contact.cells_across = with_cells.contact.cells_across;
                        *cell_length = with_cells.cell_length;
                    });
                    let planned = Plan::new(&base.on(scene)).standing_as(&of_reference).amounts();
                    let (march, road) = (planned_march(&planned) / rolled, planned_road(&planned) / rolled);
                    for substeps in SUBSTEPS {
                        let settings = base.with(|settings| settings.numerics.substeps = substeps);
                        let time_step = settings.time_step(scene);
                        let Some(of_rule) = interpolated(known, time_step) else { continue };
                        if 1.0 / time_step < least_rate(highest) {
                            continue;
                        }
                        // 3. Errors of independent knobs add as squares; the march's work is proportional to the steps
                        //    per element.
                        for (with_curves, of_curves) in &curves {
                            let parts = [*of_elements, of_rule, *of_poles, *of_cells, *of_curves];
                            let error = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
                            let tolerance = with_curves.contact.slice_tolerance;
                            let settings = settings.with(|settings| settings.contact.slice_tolerance = tolerance);
                            let multiply_adds = march * substeps as f64 + road;
                            if error > 0.0 && error < LARGEST_ERROR {
                                found.push(Candidate { settings, error, multiply_adds });
                            }
                        }
                    }
                }
            }
        }
    }
    found
}

/// The candidate to roll next, or `None` if all were rolled: among those on the expected front together with `known`
/// (work, error) the one farthest from all known points, in logarithms. Errors below `floor` \[dB\] count as equal.
pub(crate) fn next(all: &[Candidate], tried: &[Joint], known: &[(f64, f64)], floor: f64) -> Option<Candidate> {
    let fresh = all.iter().filter(|candidate| tried.iter().all(|tried| tried.expected.settings != candidate.settings));
    // 1. Correct what is expected of each candidate by the runs so far.
    let expected: Vec<Candidate> = fresh
        .map(|candidate| {
            let (error, work) = correction(&candidate.settings, tried);
            Candidate {
                error: (candidate.error * error).max(floor),
                multiply_adds: candidate.multiply_adds * work,
                ..candidate.clone()
            }
        })
        .collect();
    // 2. Of those on the front together with the known points, take the farthest from the known ones.
    let known: Vec<(f64, f64)> = known.iter().map(|&(work, error)| (work, error.max(floor))).collect();
    let points: Vec<(f64, f64)> = known
        .iter()
        .copied()
        .chain(expected.iter().map(|candidate| (candidate.multiply_adds, candidate.error)))
        .collect();
    let distance = |candidate: &Candidate| {
        let from = |&(work, error): &(f64, f64)| {
            (candidate.multiply_adds / work).ln().abs().max((candidate.error / error).ln().abs())
        };
        known.iter().map(from).fold(f64::INFINITY, f64::min)
    };
    let on_front = front(&points).into_iter().filter_map(|index| expected.get(index.checked_sub(known.len())?));
    on_front.max_by(|a, b| distance(a).total_cmp(&distance(b))).cloned()
}

/// Factors of error and work that the runs so far suggest: geometric means of found over expected, weighted by
/// exp(-d^2) of the [`distance`] d, with the weight `PRIOR` of 1.
fn correction(settings: &Settings, tried: &[Joint]) -> (f64, f64) {
    let (mut error, mut work, mut weights) = (0.0, 0.0, PRIOR);
    for run in tried {
        let weight = (-distance(settings, &run.expected.settings).powi(2)).exp();
        let (found_work, found_error) = run.point.coordinates();
        error += weight * (found_error.max(1e-9) / run.plain.0).ln();
        work += weight * (found_work / run.plain.1).ln();
        weights += weight;
    }
    ((error / weights).exp(), (work / weights).exp())
}

/// Euclidean distance of settings in logarithms: a factor of two in elements, steps or cells, a decade in a tolerance
/// and another rule are 1 each.
fn distance(a: &Settings, b: &Settings) -> f64 {
    let ratio =
        |a: f64, b: f64| if a > 0.0 && b > 0.0 { (a / b).log2() } else { f64::from(u8::from((a - b).abs() > 0.0)) };
    let points = |settings: &Settings| settings.contact.cells_across.unwrap_or(1) as f64;
    let (of_a, of_b) = (&a.numerics, &b.numerics);
    [
        ratio(of_a.elements as f64, of_b.elements as f64),
        ratio(a.steps() as f64, b.steps() as f64),
        ratio(points(a), points(b)),
        ratio(of_a.pole_tolerance, of_b.pole_tolerance) / 10.0_f64.log2(),
        ratio(a.contact.slice_tolerance, b.contact.slice_tolerance) / 10.0_f64.log2(),
        f64::from(u8::from(of_a.time_rule != of_b.time_rule)),
    ]
    .iter()
    .map(|part| part * part)
    .sum::<f64>()
    .sqrt()
}

/// Interpolates between the points of a curve in the logarithms of both coordinates, and up to a factor `BEYOND`
/// outside.
fn interpolated(curve: &[(f64, f64)], x: f64) -> Option<f64> {
    let mut curve = curve.to_vec();
    curve.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (first, last) = (curve.first()?, curve.last()?);
    if curve.len() < 2 || x < first.0 / BEYOND || x > last.0 * BEYOND {
        return None;
    }
    let place = curve.iter().position(|point| point.0 >= x).unwrap_or(curve.len() - 1).max(1);
    let (low, high) = (curve[place - 1], curve[place]);
    let part = (x / low.0).ln() / (high.0 / low.0).ln();
    Some(low.1 * (high.1 / low.1).powf(part))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{PLATE, Scene};
    use crate::study::accuracy::lab::Cost;
    use crate::study::trial::Difference;

    fn settings(elements: usize) -> Settings {
        let scene = Scene::from_str(PLATE, "default").unwrap().scene;
        Settings::of(&scene).with(|settings| settings.numerics.elements = elements)
    }

    fn candidate(elements: usize, error: f64, multiply_adds: f64) -> Candidate {
        Candidate { settings: settings(elements), error, multiply_adds }
    }

    #[test]
    fn curves_are_followed_in_logarithms_and_not_far_beyond() {
        let square = [(1.0, 1.0), (2.0, 4.0), (8.0, 64.0)];
        for x in [0.8, 1.0, 1.5, 2.0, 4.0, 8.0, 10.0] {
            assert!((interpolated(&square, x).unwrap() / (x * x) - 1.0).abs() < 1e-12, "{x}");
        }
        assert_eq!((interpolated(&square, 0.5), interpolated(&square, 20.0)), (None, None));
        assert_eq!(interpolated(&square[..1], 1.0), None);
    }

    #[test]
    fn the_next_run_is_on_the_expected_front_far_from_what_is_known() {
        let all =
            [candidate(64, 4.0, 1.0), candidate(128, 2.0, 2.0), candidate(256, 3.0, 4.0), candidate(512, 0.5, 8.0)];
        // The known run is cheap: the accurate end is next; the dominated candidate never is.
        let chosen = next(&all, &[], &[(1.1, 3.9)], 0.1).unwrap();
        assert_eq!(chosen.settings.numerics.elements, 512);
        let tried = |candidate: &Candidate, (worst, multiply_adds)| Joint {
            point: Point {
                label: String::new(),
                settings: candidate.settings.clone(),
                difference: Difference { worst, ..Difference::default() },
                cost: Cost { multiply_adds, ..Cost::default() },
            },
            expected: candidate.clone(),
            plain: (candidate.error, candidate.multiply_adds),
        };
        let one = tried(&all[3], (0.5, 8.0));
        let next_one = next(&all, std::slice::from_ref(&one), &[(1.1, 3.9), (8.0, 0.5)], 0.1).unwrap();
        assert_eq!(next_one.settings.numerics.elements, 128);
        // A run close by corrects what is expected.
        let worse = tried(&all[1], (4.0, 3.0));
        let (error, work) = correction(&settings(128), &[worse]);
        assert!((error / 2.0_f64.powf(1.0 / (1.0 + PRIOR)) - 1.0).abs() < 1e-12, "{error}");
        assert!((work / 1.5_f64.powf(1.0 / (1.0 + PRIOR)) - 1.0).abs() < 1e-12, "{work}");
    }
}
