//! Figure 5: force over contact and time.

use crate::counters::Meter;
use crate::effects::{Observer, RunError, Step};
use crate::plan::Plan;
use ndarray::Array2;
use serde::Serialize;

use super::statement::{Statement, Verdict};

/// Length of the last part of the run that is kept \[s\].
const SHOWN: f64 = 0.04;

/// Forces of the elements in the window at the run's last steps.
#[derive(Clone, Debug, Serialize)]
pub(super) struct PatchForces {
    /// Time of each step \[s\].
    #[serde(skip)]
    pub time: Vec<f64>,
    /// First element of the window at each step.
    #[serde(skip)]
    pub first_element: Vec<i64>,
    /// Forces \[N\], \[steps, window\].
    #[serde(skip)]
    pub force: Array2<f64>,
    /// Length of an element \[m\].
    pub element: f64,
    /// Speed \[m/s\].
    pub speed: f64,
    /// Road coordinate under the axle at t = 0 \[m\].
    pub start: f64,
    /// Number of steps kept.
    pub steps: usize,
    /// Smallest force of an element \[N\]: not negative.
    pub smallest: f64,
    /// Largest force of an element \[N\].
    pub largest: f64,
    /// Mean force of those elements that carry one \[N\].
    pub mean: f64,
    /// Mean length of the patch \[m\].
    pub length: f64,
    /// Share of the patch's elements that carry no force.
    pub open: f64,
}

/// Recorder of the forces of a run's last steps.
#[derive(Clone, Debug)]
pub(super) struct Recorder {
    /// Number of steps of the run, and their length \[s\].
    steps: u64,
    time_step: f64,
    time: Vec<f64>,
    first_element: Vec<i64>,
    force: Vec<f64>,
    columns: usize,
    start: f64,
}

impl Recorder {
    pub(super) fn new(plan: &Plan) -> Self {
        let Plan { steps, time_step, .. } = *plan;
        let (time, first_element, force) = (Vec::new(), Vec::new(), Vec::new());
        Self { steps, time_step, time, first_element, force, columns: 0, start: 0.0 }
    }

    /// Forces of the kept steps, and their means.
    pub(super) fn finish(self, plan: &Plan) -> PatchForces {
        let steps = self.time.len();
        let (mut carried, mut inside) = (0_usize, 0_usize);
        for row in self.force.chunks(self.columns.max(1)) {
            let first = row.iter().position(|&force| force > 0.0);
            let last = row.iter().rposition(|&force| force > 0.0);
            carried += row.iter().filter(|force| **force > 0.0).count();
            inside += first.zip(last).map_or(0, |(first, last)| last + 1 - first);
        }
        let share = |part: f64, whole: usize| if whole > 0 { part / whole as f64 } else { 0.0 };
        PatchForces {
            element: plan.element,
            speed: plan.speed,
            start: self.start,
            steps,
            smallest: self.force.iter().copied().fold(0.0, f64::min),
            largest: self.force.iter().copied().fold(0.0, f64::max),
            mean: share(self.force.iter().sum(), carried),
            length: share(inside as f64 * plan.element, steps),
            open: share((inside - carried) as f64, inside),
            force: Array2::from_shape_vec((steps, self.columns), self.force).unwrap_or_default(),
            time: self.time,
            first_element: self.first_element,
        }
    }
}

impl Observer for Recorder {
    /// Keeps the step if it is one of those shown.
    fn observe(&mut self, step: &Step<'_>, _: &mut Meter) -> Result<(), RunError> {
        if ((self.steps - step.number) as f64) * self.time_step <= SHOWN {
            (self.columns, self.start) = (step.geometry.columns, step.geometry.start);
            self.time.push(step.time);
            self.first_element.push(step.footprint.first_element());
            self.force.extend_from_slice(step.footprint.column_mean());
        }
        Ok(())
    }
}

impl PatchForces {
    pub(super) fn statement(&self) -> Statement {
        Statement {
            place: "figure 5",
            subject: "force over contact and time",
            paper: "a picture",
            found: format!(
                "patch of {:.0} mm, {:.0} % of its elements in the air; {:.0} N on one that touches, {:.0} to {:.0} N",
                1e3 * self.length,
                100.0 * self.open,
                self.mean,
                self.smallest,
                self.largest
            ),
            verdict: Verdict::NotComparable,
            why: "the paper's road and load are not given in numbers".to_owned(),
        }
    }
}
