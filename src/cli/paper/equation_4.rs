//! Limit of the paper's equation 4 as the time step decreases, beside the local law.

use crate::run::RunError;
use crate::scene::{Scene, SliceCoupling};
use crate::study::accuracy::Richardson;
use crate::study::trial::{Common, Trials};
use serde::Serialize;

use super::search::Solves;
use super::statement::{Statement, Verdict};

/// The couplings that are refined.
const COUPLINGS: [(SliceCoupling, &str); 2] =
    [(SliceCoupling::Local, "local law"), (SliceCoupling::Explicit, "explicit")];

/// Convergence of one coupling with the time step.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Refined {
    /// Name of the coupling.
    pub name: &'static str,
    /// Differences between successive halvings of the step: root mean square of the force's difference over that of the
    /// force's variation.
    pub differences: Vec<f64>,
    /// Largest difference of a third octave between successive halvings \[dB\].
    pub levels: Vec<f64>,
    /// Order of the last halving: lg2 of the ratio of the last two differences; 0 where that is not defined.
    pub order: f64,
    /// Mean force with each step \[N\].
    pub mean_force: Vec<f64>,
}

/// Convergence of all couplings.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Equation4 {
    /// Elements around the tyre.
    pub elements: usize,
    /// Time steps \[s\], each half of the one before.
    pub steps: Vec<f64>,
    /// Local law, equation 4.
    pub couplings: Vec<Refined>,
}

impl Equation4 {
    /// Rolls a scene, its axle held, with 1, 2, 4, ... steps per element, `halvings` times; also returns the search of
    /// the explicit coupling with the longest steps.
    ///
    /// # Errors
    /// Errors of the runs.
    pub(super) fn of(
        held: &Scene,
        halvings: u32,
        highest: f64,
        trials: &mut Trials<'_>,
    ) -> Result<(Self, Option<Solves>), RunError> {
        let within = held.rolling.warm_up..held.rolling.warm_up + held.rolling.duration;
        let (mut steps, mut couplings, mut search) = (Vec::new(), Vec::new(), None);
        for (coupling, name) in COUPLINGS {
            let mut scene = held.clone();
            scene.contact.slice_coupling = coupling;
            let mut forces: Vec<Common> = Vec::new();
            steps.clear();
            for halving in 0..=halvings {
                scene.numerics.substeps = 1 << halving;
                let trial = trials.roll(&scene)?;
                steps.push(trial.plan.time_step);
                if coupling == SliceCoupling::Explicit && halving == 0 {
                    search = Some(Solves::of(&trial));
                }
                forces.push(Common::of(&trial, within.clone(), highest));
            }
            let found: Vec<_> = forces.windows(2).map(|pair| pair[0].difference(&pair[1])).collect();
            let differences: Vec<f64> = found.iter().map(|found| found.force).collect();
            couplings.push(Refined {
                name,
                order: order(&differences),
                levels: found.iter().map(|found| found.worst).collect(),
                mean_force: forces.iter().map(|force| force.mean_force).collect(),
                differences,
            });
        }
        Ok((Self { elements: held.numerics.elements, steps, couplings }, search))
    }

    pub(super) fn statement(&self) -> Statement {
        let words = |refined: &Refined| {
            let [first, .., last] = refined.differences.as_slice() else { return refined.name.to_owned() };
            format!("{} {first:.3} to {last:.3} (order {:.1})", refined.name, refined.order)
        };
        let of_4: Vec<&[f64]> = self.couplings.iter().skip(1).map(|refined| refined.differences.as_slice()).collect();
        Statement {
            place: "equation 4",
            subject: "change of the force by halving the time step",
            paper: "F = G0^-1 S(y)",
            found: self.couplings.iter().map(words).collect::<Vec<_>>().join("; "),
            verdict: judge(&of_4),
            why: "each halving changes the force less than the one before, towards a limit".to_owned(),
        }
    }
}

/// Order from the last two differences; 0 for fewer, or if one of them vanishes.
fn order(differences: &[f64]) -> f64 {
    match differences {
        [.., coarse, fine] if *fine > 0.0 && *coarse > 0.0 => (coarse / fine).log2(),
        _ => 0.0,
    }
}

/// True if every sequence of differences converges.
fn judge(all: &[&[f64]]) -> Verdict {
    let converges = |differences: &&[f64]| match differences {
        [.., coarse, fine] => Richardson::new(*coarse, *fine).converges,
        _ => false,
    };
    Verdict::of(!all.is_empty() && all.iter().all(converges))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_that_stay_have_no_limit() {
        let (falls, stays): ([f64; 3], [f64; 3]) = ([0.3, 0.08, 0.02], [0.36, 0.35, 0.37]);
        assert!((order(&falls) - 2.0).abs() < 1e-12 && order(&stays).abs() < 0.1 && order(&[0.1]).abs() < 1e-12);
        assert_eq!(judge(&[&falls]), Verdict::Agrees);
        assert_eq!(judge(&[&falls, &stays]), Verdict::Disagrees);
        assert_eq!(judge(&[&[0.1]]), Verdict::Disagrees);
        assert_eq!(judge(&[]), Verdict::Disagrees);
    }
}
