//! The search for the points in contact: solves per step, and whether it is ever given up.

use std::collections::BTreeMap;

use crate::contact::complementarity::Residuals;
use crate::study::trial::Trial;
use serde::Serialize;

use super::statement::{Statement, Verdict};

/// Share of instants that may take more solves than the paper states.
const RARE: f64 = 0.01;
/// Largest relative residual at which the contact conditions count as satisfied.
const SOLVED: f64 = 1e-6;

/// Work of the search of a run.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Solves {
    /// Number of instants by number of solves.
    pub histogram: BTreeMap<u32, u64>,
    /// Share of the instants in contact that took one solve.
    pub one: f64,
    /// Share that took two or three solves.
    pub two_or_three: f64,
    /// Share that took more.
    pub more: f64,
    /// Instants in which the least-index fallback took over.
    pub fallbacks: u64,
    /// Largest residuals of the contact conditions, relative to the largest force and displacement.
    pub residuals: Residuals,
}

/// The local law, and the paper's equation 4.
#[derive(Clone, Debug, Serialize)]
pub(super) struct SearchFigure {
    /// The default law.
    pub local: Solves,
    /// Equation 4.
    pub equation_4: Solves,
}

impl Solves {
    pub(super) fn of(trial: &Trial) -> Self {
        Self::new(trial.results.search.solves_per_step(), trial.results.search.fallbacks, trial.results.residuals)
    }

    fn new(histogram: BTreeMap<u32, u64>, fallbacks: u64, residuals: Residuals) -> Self {
        let count = |solves: std::ops::Range<u32>| histogram.range(solves).map(|(_, steps)| *steps).sum::<u64>() as f64;
        let all = count(1..u32::MAX).max(1.0);
        let [one, two_or_three, more] = [1..2, 2..4, 4..u32::MAX].map(|solves| count(solves) / all);
        Self { one, two_or_three, more, histogram, fallbacks, residuals }
    }

    fn worst(&self) -> f64 {
        self.residuals.tension.max(self.residuals.penetration).max(self.residuals.complementarity)
    }

    fn words(&self) -> String {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        format!("one {}, two or three {}, more {}", percent(self.one), percent(self.two_or_three), percent(self.more))
    }
}

impl SearchFigure {
    pub(super) fn statements(&self) -> [Statement; 2] {
        let Self { local, equation_4 } = self;
        let fallbacks = local.fallbacks + equation_4.fallbacks;
        let worst = local.worst().max(equation_4.worst());
        [
            Statement {
                place: "contact search",
                subject: "solves in a step",
                paper: "one when the guess is right, one or two more otherwise",
                found: format!("local law: {}; equation 4: {}", local.words(), equation_4.words()),
                verdict: takes_few(local.more.max(equation_4.more)),
                why: format!("more than three solves in less than {} % of the instants", 100.0 * RARE),
            },
            Statement {
                place: "contact search",
                subject: "searches given up",
                paper: "a search may be given up: only positive forces are kept",
                found: format!("conditions of contact met to {worst:.0e}; {fallbacks} least-index fallbacks"),
                verdict: is_given_up(worst),
                why: format!("conditions of contact missed by more than {SOLVED:.0e}: only then is a search given up"),
            },
        ]
    }
}

fn takes_few(more: f64) -> Verdict {
    Verdict::of(more < RARE)
}

/// True if searches are given up as the paper says: then the contact conditions are violated.
fn is_given_up(worst: f64) -> Verdict {
    Verdict::of(worst > SOLVED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_are_shared_out_over_the_instants_in_contact() {
        let found = Solves::new([(0, 50), (1, 90), (2, 5), (3, 3), (4, 1), (11, 1)].into(), 0, Residuals::default());
        for (share, expected) in [(found.one, 0.9), (found.two_or_three, 0.08), (found.more, 0.02)] {
            assert!((share - expected).abs() < 1e-12, "{found:?}");
        }
        assert_eq!([takes_few(found.more), takes_few(0.001)], [Verdict::Disagrees, Verdict::Agrees]);
        assert_eq!([is_given_up(1e-12), is_given_up(0.1)], [Verdict::Disagrees, Verdict::Agrees]);
        let none = Solves::new(BTreeMap::new(), 0, Residuals::default());
        assert!(none.one.abs() + none.more.abs() < 1e-12);
    }
}
