//! Power that the contact forces put into the tyre, from the displacements of the run itself.
//!
//! P_l = sum_e F_e v_e over the elements in contact. With backward differences v is the difference quotient of the rule
//! itself, so that in the mean P = sum_n Re(s H_n(s)) |F_n|^2 holds exactly with the rule's s. A Runge-Kutta rule has
//! its quadrature, P_l = sum_i b_i sum_e F_(e,i) v_(e,i) over its stages, with the rates of the stages,
//! v_i = (u_i - base_i)/(gamma dt), base_i made of the displacements at the step's beginning and of the stages before
//! (`RungeKutta::bases`): the same holds exactly with the rule's matrices (`stage_transfer`).
//!
//! Limits of the agreement with the power dissipated: the segments' window blurs Re(s H_n) by its width, and the
//! tyre stores what it has not yet dissipated when the record ends. The power is averaged with the square of the
//! segments' window, so that the mean pattern, which has most of it, is balanced without any of that. Measured, N =
//! 128, 2.5 s: smooth road 2e-7, rough road 2e-5 (`bdf2`), 5e-6 (`bdf1`). With `tread = "uncoupled"` the contact's
//! displacements are not those of the tyre under its forces, and nothing is balanced.

use crate::storage::state::evolving;
use crate::time_rule::{RungeKutta, TimeRule};

/// Power by step, with the displacements of the last two steps.
#[derive(Clone, Debug)]
pub(crate) struct ContactPower {
    rule: TimeRule,
    time_step: f64,
    columns: usize,
    /// Displacements at the ends of the last two steps, the latest first.
    earlier: [Window; 2],
}

/// Displacements of the elements in the window of a step, from `first` on.
#[derive(Clone, Debug)]
struct Window {
    first: i64,
    displacement: Vec<f64>,
}

impl Window {
    /// Displacement of an element; `None` outside the window.
    fn at(&self, element: i64) -> Option<f64> {
        let column = usize::try_from(element.checked_sub(self.first)?).ok()?;
        self.displacement.get(column).copied()
    }
}

evolving!(Window: first, displacement);

impl ContactPower {
    /// Everything at rest before the first step; windows of `columns` elements.
    pub(crate) fn new(rule: TimeRule, time_step: f64, columns: usize) -> Self {
        let window = Window { first: 0, displacement: vec![0.0; columns] };
        Self { rule, time_step, columns, earlier: [window.clone(), window] }
    }

    /// Power of a step \[W\] with these forces \[N\] and displacements \[m\], stage after stage, of the elements from
    /// `first` on. An element that was not in the window is taken as one that has not moved.
    pub(crate) fn push(&mut self, first: i64, forces: &[f64], displacement: &[f64]) -> f64 {
        let work = match self.rule.runge_kutta() {
            Some(method) => self.work_of_stages(method, first, forces, displacement),
            None => self.work(first, forces, displacement),
        };
        // The last stage is the step's end.
        let end = forces.len() - self.columns;
        self.earlier.swap(0, 1);
        let latest = &mut self.earlier[0];
        latest.first = first;
        latest.displacement.copy_from_slice(&displacement[end..]);
        work / self.time_step
    }

    /// sum_i b_i F_i v_i dt over the stages.
    fn work_of_stages(&self, method: RungeKutta, first: i64, forces: &[f64], displacement: &[f64]) -> f64 {
        let (columns, last) = (self.columns, &self.earlier[0]);
        let (bases, weights) = (method.bases(), method.weights());
        let mut work = 0.0;
        for (stage, forces) in forces.chunks_exact(columns).enumerate() {
            for (column, &force) in forces.iter().enumerate().filter(|(_, force)| **force != 0.0) {
                let Some(begin) = last.at(first + column as i64) else { continue };
                let at = |stage: usize| displacement[stage * columns + column];
                let [of_begin, of_stages @ ..] = bases[stage];
                let before = of_stages[..stage].iter().enumerate();
                let base = before.fold(of_begin * begin, |sum, (earlier, weight)| sum + weight * at(earlier));
                work += weights[stage] * force * (at(stage) - base) / method.gamma;
            }
        }
        work
    }

    /// Work in a step of a rule of one stage \[J\].
    fn work(&self, first: i64, forces: &[f64], displacement: &[f64]) -> f64 {
        let [last, before] = &self.earlier;
        let [of_now, of_one, of_two] = self.rule.backward_difference();
        let mut work = 0.0;
        for (column, (&force, &now)) in
            forces.iter().zip(displacement).enumerate().filter(|(_, (force, _))| **force != 0.0)
        {
            let [one, two] = [last, before].map(|window| window.at(first + column as i64).unwrap_or(now));
            work += force * (of_now * now + of_one * one + of_two * two);
        }
        work
    }
}

evolving!(ContactPower: earlier);
