//! Free waves of the tyre: frequencies of its poles over the wavenumber.
//!
//! A pole lambda of H_n is a free wave of n periods round the tyre, of frequency Im lambda/(2 pi) in the material
//! frame. In its resonance the velocity for unit force is about |lambda R|/(-Re lambda).
//!
//! 1. Poles damped by less than [`MOST_DAMPING`] of critical are waves. Those of neighbouring wavenumbers are joined to
//!    branches, one for each lateral order and kind of wave, the closest continuations first. The square of the
//!    frequency is nearly a polynomial of n^2, as that of a beam on springs, so it is extrapolated by a parabola, from
//!    n = 0 on by an even one.
//! 2. Of each branch the part is shown in which the peak is at least [`LEAST_PEAK`] of the largest of all waves.
//!
//! With rotation, waves with the rotation and against it differ: each direction has separate branches, of the poles
//! that have a residue in it (see [`WaveModes::residue`](crate::tyre::poles::WaveModes::residue)). The rotation Om
//! shifts a wave of an inextensional ring by +-2 n Om/(n^2 + 1), most of all n = 1: the parabola extrapolates the
//! frequency without that shift.
//!
//! The waves are those of the tyre itself. With a time rule that slows waves down, as `bdf2` does by (w dt)^2/3, the
//! ridges of a run's map lie lower by that.

use std::f64::consts::PI;

use crate::tyre::influence::Field;
use crate::tyre::poles::{Direction, RationalModel};

/// Largest damping of a wave that is shown, as a part of critical damping.
pub(crate) const MOST_DAMPING: f64 = 0.15;
/// Smallest velocity peak of a shown wave, as a part of the largest of all waves: 50 dB less.
pub(crate) const LEAST_PEAK: f64 = 0.003;
/// Largest distance of a wave from its branch's continuation, as a part of its frequency: fitted poles of weak waves
/// scatter by more than that, and form no branch.
const JUMP: f64 = 0.015;
/// The same for the second wavenumber, where the branch has no slope yet.
const FIRST_JUMP: f64 = 0.08;
/// Frequency below which both distances are relative to this one \[Hz\].
const LOWEST: f64 = 100.0;
/// Fewest wavenumbers of a branch that is shown.
const SHORTEST: usize = 8;

/// A branch: integer wavenumbers n >= 0, rising by 1, and their frequencies in the material frame \[Hz\].
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DispersionBranch {
    /// Direction, of a tyre that turns; `None`: at rest both are the same.
    pub direction: Option<Direction>,
    /// First n.
    pub first: usize,
    /// Frequency at n = first... \[Hz\].
    pub frequencies: Vec<f64>,
}

#[derive(Clone, Copy, Debug)]
struct Wave {
    frequency: f64,
    /// Velocity for unit force in the resonance \[m/(N s)\].
    peak: f64,
}

/// Waves joined to one branch.
struct Followed {
    first: usize,
    waves: Vec<Wave>,
    /// Frequency of the rotation, negative for waves against it \[Hz\].
    turning: f64,
}

/// Shift of an inextensional ring's wave of n periods by the rotation \[Hz\].
fn shift(n: usize, turning: f64) -> f64 {
    let n = n as f64;
    2.0 * n * turning / (n * n + 1.0)
}

impl Followed {
    /// Expected frequency of the next wavenumber, and the largest distance from it \[Hz\].
    fn next(&self) -> (f64, f64) {
        let next = self.first + self.waves.len();
        let numbers = (self.first..next).rev();
        let mut latest = self.waves.iter().rev().zip(numbers).map(|(wave, n)| wave.frequency - shift(n, self.turning));
        let last = latest.next().unwrap_or(0.0);
        let [now, before, earlier] = [Some(last), latest.next(), latest.next()].map(|f| f.map(|f| f * f));
        let (square, jump) = match (now, before, earlier) {
            (Some(now), Some(before), Some(earlier)) => (3.0 * (now - before) + earlier, JUMP),
            (Some(now), Some(before), None) if self.first == 0 => (4.0 * now - 3.0 * before, JUMP),
            (Some(now), Some(before), None) => (2.0 * now - before, 2.0 * JUMP),
            _ => (last * last, FIRST_JUMP),
        };
        // The square of the shift adds to a ring's frequency squared: most at one period.
        let split = 2.0 * shift(1, self.turning).powi(2) / last.max(LOWEST);
        (square.max(0.0).sqrt() + shift(next, self.turning), jump * last.max(LOWEST) + split)
    }

    /// Longest part with peaks of at least `least` and frequencies below `highest`; `None` if it is too short.
    fn shown(&self, direction: Option<Direction>, least: f64, highest: f64) -> Option<DispersionBranch> {
        let taken = |wave: &Wave| wave.peak >= least && wave.frequency < highest;
        let mut first = self.first;
        let mut parts = Vec::new();
        for part in self.waves.chunk_by(|a, b| taken(a) == taken(b)) {
            if part.len() >= SHORTEST && taken(&part[0]) {
                let frequencies = part.iter().map(|wave| wave.frequency).collect();
                parts.push(DispersionBranch { direction, first, frequencies });
            }
            first += part.len();
        }
        parts.into_iter().max_by_key(|part| part.frequencies.len())
    }
}

/// Branches below `highest` \[Hz\] as a field shows them; for a tyre that turns (`angular_velocity` \[rad/s\], negative
/// where elements are counted against it) those with the rotation, then those against it. None if the model does not
/// hold the field.
pub(crate) fn dispersion_branches(
    model: &RationalModel,
    angular_velocity: f64,
    field: Field,
    highest: f64,
) -> Vec<DispersionBranch> {
    if model.turns() {
        let turning = |direction| match direction {
            Direction::Forwards => angular_velocity / (2.0 * PI),
            Direction::Backwards => -angular_velocity / (2.0 * PI),
        };
        let towards = |direction| branches_towards(model, field, highest, Some(direction), turning(direction));
        Direction::BOTH.into_iter().flat_map(towards).collect()
    } else {
        branches_towards(model, field, highest, None, 0.0)
    }
}

/// Branches of one direction, or of both where they are the same.
fn branches_towards(
    model: &RationalModel,
    field: Field,
    highest: f64,
    direction: Option<Direction>,
    turning: f64,
) -> Vec<DispersionBranch> {
    let (mut open, mut closed): (Vec<Followed>, Vec<Followed>) = (Vec::new(), Vec::new());
    let mut largest = 0.0_f64;
    for n in 0..=model.largest_wavenumber() {
        // 1. Pairs of a branch and a wave near its continuation, the closest first.
        let waves = waves(model, n, field, direction);
        largest = waves.iter().fold(largest, |largest, wave| largest.max(wave.peak));
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (index, branch) in open.iter().enumerate() {
            let (expected, jump) = branch.next();
            let distances = waves.iter().map(|wave| (wave.frequency - expected).abs()).enumerate();
            let near = distances.filter(|(_, distance)| *distance < jump);
            pairs.extend(near.map(|(wave, distance)| (distance / waves[wave].frequency, index, wave)));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        // 2. Each branch and each wave is used once.
        let (mut continued, mut used) = (vec![false; open.len()], vec![false; waves.len()]);
        for (_, branch, wave) in pairs {
            if !continued[branch] && !used[wave] {
                (continued[branch], used[wave]) = (true, true);
                open[branch].waves.push(waves[wave]);
            }
        }
        // 3. Branches without a wave end; waves without a branch begin one.
        let mut followed = Vec::new();
        for (branch, continued) in open.into_iter().zip(continued) {
            if continued { followed.push(branch) } else { closed.push(branch) }
        }
        let new = waves.iter().zip(used).filter(|(_, used)| !used);
        followed.extend(new.map(|(&wave, _)| Followed { first: n, waves: vec![wave], turning }));
        open = followed;
    }
    let all = closed.into_iter().chain(open);
    let mut branches: Vec<_> =
        all.filter_map(|branch| branch.shown(direction, LEAST_PEAK * largest, highest)).collect();
    branches.sort_by(|a, b| a.first.cmp(&b.first).then(a.frequencies[0].total_cmp(&b.frequencies[0])));
    branches
}

/// Waves of n periods, of one direction.
fn waves(model: &RationalModel, n: usize, field: Field, direction: Option<Direction>) -> Vec<Wave> {
    let Some(modes) = model.modes(n, field) else { return Vec::new() };
    let direction = direction.unwrap_or(Direction::Forwards);
    modes.poles[..modes.pairs]
        .iter()
        .enumerate()
        .filter(|(index, pole)| -pole.re < MOST_DAMPING * pole.norm() && modes.belongs_to(direction, *index))
        .map(|(index, pole)| Wave {
            frequency: pole.im / (2.0 * PI),
            peak: pole.norm() * modes.residue(direction, index).norm() / -pole.re,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{PLATE, Scene};
    use crate::tyre::poles::{FitOptions, fit, turning_ring};

    #[test]
    fn each_direction_of_a_turning_ring_has_its_branch() {
        let turning = -70.0;
        let branches = dispersion_branches(&turning_ring::model(64, turning), turning, Field::Bottom, 1500.0);
        let resting = dispersion_branches(&turning_ring::model(64, 0.0), 0.0, Field::Bottom, 1500.0);
        assert_eq!(branches.len(), 2, "{branches:?}");
        assert_eq!((resting.len(), resting[0].direction), (1, None));
        for (branch, direction) in branches.iter().zip(Direction::BOTH) {
            assert_eq!((branch.direction, branch.first), (Some(direction), 0));
            assert_eq!(branch.frequencies.len(), 33);
            for (n, frequency) in branch.frequencies.iter().enumerate() {
                let exact = turning_ring::mode(64, n, turning).pole(direction).im / (2.0 * PI);
                assert!((frequency - exact).abs() < 1e-9, "{direction:?} {n}");
            }
        }
        // With the rotation they are slower.
        assert!((branches[0].frequencies[1] - resting[0].frequencies[1] + 70.0 / (2.0 * PI)).abs() < 1.0);
    }

    #[test]
    fn the_belts_first_branch_begins_at_the_plates_resonances() {
        let tyre = Scene::from_str(PLATE, "default").unwrap().scene.tyre;
        let model = fit(&tyre, &FitOptions::new(&tyre, 64, 20.0).with_tolerance(1e-4)).unwrap();
        let branches = dispersion_branches(&model, 0.0, Field::Surface, 1500.0);
        let lowest = branches.iter().find(|branch| branch.first == 0).unwrap();
        // m = 1 resonances of the default tyre, n = 0..6 \[Hz\]: maxima of the compliance. With damping up to 0.025 of
        // critical they lie 6e-4 below the pole at most, they are given to 5e-4, and the other modes' slope and the fit
        // shift them by about as much.
        for (found, resonance) in lowest.frequencies.iter().zip([91.5, 95.8, 107.8, 125.5, 147.5, 172.5, 200.0]) {
            assert!((found / resonance - 1.0).abs() < 2e-3, "{found} {resonance}");
        }
        // Up to the upper end of the band, and smooth: second differences are 8 Hz where the branch begins, and small
        // beside the frequency.
        assert_eq!(lowest.frequencies.len(), 31, "1500 Hz is between n = 30 and 31: {:?}", lowest.frequencies);
        for branch in &branches {
            assert!(branch.frequencies.len() >= SHORTEST);
            for three in branch.frequencies.windows(3) {
                let bend = three[0] - 2.0 * three[1] + three[2];
                assert!(bend.abs() < 8.0 + 0.01 * three[1], "{:?}", branch.frequencies);
            }
        }
        assert!(dispersion_branches(&model, 0.0, Field::UnderTread, 1500.0).is_empty());
    }
}
