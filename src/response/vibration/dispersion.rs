//! The tyre's own waves: frequencies of its poles over the wavenumber.
//!
//! A pole lambda of H_n is a free wave of n periods round the tyre, of frequency Im lambda/(2 pi) in the material, whose part in H_n peaks with |R|/(-Re lambda). Shown is what is a wave and
//! takes part: damped by less than [`MOST_DAMPING`] of critical, with a peak of at least [`LEAST_PEAK`] of the wavenumber's largest. Poles of neighbouring wavenumbers are joined to
//! branches (one for each lateral order and kind of wave) by the nearest continuation.

use std::f64::consts::PI;

use crate::tyre::influence::Field;
use crate::tyre::rational::RationalModel;

/// Largest part of critical damping of a wave that is shown.
pub const MOST_DAMPING: f64 = 0.2;
/// Smallest peak, as a part of the largest of the same wavenumber.
pub const LEAST_PEAK: f64 = 0.01;
/// How far a branch may lie beside its straight continuation, as a part of its frequency; a resonance of the tread's thickness, which wanders with the fit, is no branch.
const JUMP: f64 = 0.015;
/// The same for its second wavenumber, whose direction nobody knows.
const FIRST_JUMP: f64 = 0.08;
/// Frequency below which both are parts of this one \[Hz\].
const LOWEST: f64 = 100.0;
/// Fewest wavenumbers of a branch that is shown.
const SHORTEST: usize = 4;

/// A branch: integer wavenumbers n >= 0, rising by 1, and their frequencies in the material frame \[Hz\].
#[derive(Clone, Debug, PartialEq)]
pub struct DispersionBranch {
    /// First n.
    pub first: usize,
    /// Frequency at n = first... \[Hz\].
    pub frequencies: Vec<f64>,
}

impl DispersionBranch {
    /// Where the branch is expected to go on, and how far from there it may.
    fn next(&self) -> (f64, f64) {
        let last = self.frequencies.len() - 1;
        let (slope, jump) = match last {
            0 => (0.0, FIRST_JUMP),
            _ => (self.frequencies[last] - self.frequencies[last - 1], JUMP),
        };
        (self.frequencies[last] + slope, jump * self.frequencies[last].max(LOWEST))
    }
}

/// The branches below `highest` \[Hz\] as a field shows them; none if the model does not hold it.
pub fn dispersion_branches(model: &RationalModel, field: Field, highest: f64) -> Vec<DispersionBranch> {
    let (mut open, mut closed): (Vec<DispersionBranch>, Vec<DispersionBranch>) = (Vec::new(), Vec::new());
    for n in 0..=model.largest_wavenumber() {
        let mut waves = waves(model, n, field, highest);
        let mut kept = Vec::new();
        for mut branch in open {
            let (expected, jump) = branch.next();
            let nearest = waves
                .iter()
                .copied()
                .enumerate()
                .min_by(|a, b| (a.1 - expected).abs().total_cmp(&(b.1 - expected).abs()));
            match nearest {
                Some((index, frequency)) if (frequency - expected).abs() < jump => {
                    waves.swap_remove(index);
                    branch.frequencies.push(frequency);
                    kept.push(branch);
                }
                _ => closed.push(branch),
            }
        }
        waves.sort_by(f64::total_cmp);
        kept.extend(waves.into_iter().map(|frequency| DispersionBranch { first: n, frequencies: vec![frequency] }));
        open = kept;
    }
    closed.extend(open);
    closed.retain(|branch| branch.frequencies.len() >= SHORTEST);
    closed.sort_by(|a, b| a.first.cmp(&b.first).then(a.frequencies[0].total_cmp(&b.frequencies[0])));
    closed
}

/// Frequencies of the waves of n periods.
fn waves(model: &RationalModel, n: usize, field: Field, highest: f64) -> Vec<f64> {
    let Some(modes) = model.modes(n, field) else { return Vec::new() };
    let pairs = || {
        modes.poles[..modes.pairs].iter().zip(modes.residues).map(|(pole, residue)| (pole, residue.norm() / -pole.re))
    };
    let largest = pairs().fold(0.0_f64, |largest, (_, peak)| largest.max(peak));
    pairs()
        .filter(|(pole, peak)| -pole.re < MOST_DAMPING * pole.norm() && *peak >= LEAST_PEAK * largest)
        .map(|(pole, _)| pole.im / (2.0 * PI))
        .filter(|frequency| *frequency < highest)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DEFAULT, Scene};
    use crate::tyre::rational::{FitOptions, fit};

    #[test]
    fn the_belts_first_branch_begins_at_the_resonances_of_the_default_tyre() {
        let tyre = Scene::from_str(DEFAULT, "default").unwrap().scene.tyre;
        let model = fit(&tyre, &FitOptions::new(&tyre, 64, 20.0).with_tolerance(1e-4)).unwrap();
        let branches = dispersion_branches(&model, Field::Surface, 1500.0);
        let lowest = branches.iter().find(|branch| branch.first == 0).unwrap();
        // m = 1 resonances of the default tyre, n = 0..6 \[Hz\]: maxima of the compliance, the damped poles lie within 2 %.
        for (found, resonance) in lowest.frequencies.iter().zip([91.5, 95.8, 107.8, 125.5, 147.5, 172.5, 200.0]) {
            assert!((found / resonance - 1.0).abs() < 0.02, "{found} {resonance}");
        }
        assert!(lowest.frequencies.len() > 20 && branches.iter().all(|branch| branch.frequencies.len() >= SHORTEST));
        assert!(dispersion_branches(&model, Field::UnderTread, 1500.0).is_empty());
    }
}
