//! Modes: free vibrations of waves of n periods round the tyre and of the lateral number m.
//!
//! A mode is a pole of the wave's compliance C(n, m, s). It rings at |Im s|/2 pi with the damping -Re s/|s|. For each
//! wave and each diagonal entry C_jj:
//!
//! 1. C_jj is sampled on a line just right of the imaginary axis, where it is finite also for a tyre without loss;
//! 2. an AAA approximation (see [`crate::numeric::rational::aaa`]) finds how many poles there are, and roughly where;
//! 3. the secant method on 1/C_jj moves each of them to a pole of C itself. All laws but the hysteretic one are
//!    analytic off the negative real axis, so C can be followed to the left of the imaginary axis;
//! 4. the residue of C, the difference of C on both sides of the pole, is the product of the mode's shape with itself:
//!    the largest motion, radially, round the tyre or across it, names the mode, and a pole that several entries share
//!    is listed once.
//!
//! With rotation, the waves n and -n differ, and both are analysed: C(-n, m, s) is sampled on the upper half of the
//! plane, too.
//!
//! A pole of step 2 that step 3 does not confirm, and that contributes to the samples, is reported as
//! [`Modes::unconfirmed`].
//!
//! Cost: samples times waves evaluations of C for all tractions, and about 10 for each mode.

use std::cell::Cell;
use std::f64::consts::TAU;

use num_complex::Complex64;
use serde::Serialize;
use thiserror::Error;

use super::influence::Waves;
use super::influence::kernel::Kernel;
use super::layers::compliance::Matrix3;
use super::poles::Direction;
use crate::numeric::in_parallel;
use crate::numeric::rational::RationalError;
use crate::numeric::rational::aaa::approximate;
use crate::scene::Tyre;

/// Number of samples up to the highest frequency.
const SAMPLES: usize = 200;
/// Samples go on beyond it by this factor, so that a mode near the end has them on both sides.
const BEYOND: f64 = 1.25;
/// Error of the approximation relative to the largest sample. Far below what a start needs: weak modes are then found,
/// too.
const TOLERANCE: f64 = 1e-10;
/// Most support points; ten modes of lossy layers need some twenty, and sidewalls have modes, too.
const MOST_POINTS: usize = 40;
const MOST_ON_SIDEWALLS: usize = 80;
/// Support points within which the error must halve: where it does not, the compliance is no more exact, and further
/// poles are those of its rounding.
const PATIENCE: usize = 8;
/// Damping above which nothing rings: it loses 97 % of its amplitude in a period.
const LARGEST_DAMPING: f64 = 0.5;
/// Part of the largest sample above which a pole counts.
const SIGNIFICANT: f64 = 1e-5;
/// The secant method: iterations, last step, and largest distance from its start, relative to |s|.
const ITERATIONS: usize = 40;
const LAST_STEP: f64 = 1e-12;
const LONGEST_WAY: f64 = 0.05;
/// Distance from a pole at which its residue is read, relative to |s|.
const BESIDE: f64 = 1e-4;
/// Fraction of radial motion from which on a mode is called radial. A quarter: a ring that moves as a whole, n = 1,
/// moves as much round itself as along its radius.
const RADIAL: f64 = 0.25;
/// Poles closer than this, relative to |s|, are the same.
const SAME: f64 = 1e-7;

/// Prevailing motion of a mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Motion {
    /// Along the radius, at least by a quarter: excited by roads, and radiating.
    Radial,
    /// Hardly along the radius, and most round the tyre: torsion for n = 0.
    Circumferential,
    /// Hardly along the radius, and most across the tyre.
    Lateral,
}

impl Motion {
    /// Name as in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Radial => "radial",
            Self::Circumferential => "circumferential",
            Self::Lateral => "lateral",
        }
    }
}

/// A mode of a wave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Periods round the tyre.
    pub n: usize,
    /// Direction of the wave, of a tyre that turns; `None` at rest and for n = 0, where both are the same.
    pub direction: Option<Direction>,
    /// Lateral number.
    pub m: usize,
    /// Prevailing motion of the tread's surface.
    pub motion: Motion,
    /// The pole, Im > 0 \[1/s\].
    pub pole: Complex64,
    /// Squared circumferential, lateral and radial motion of the tread's surface; their sum is 1.
    pub shares: [f64; 3],
    /// Contribution to the compliance at resonance, of the three directions together \[m/Pa\].
    pub peak: f64,
}

impl Mode {
    /// n of exp(i n theta' + s t), theta' rising with the elements, opposite to the rotation: negative of a wave that
    /// runs against the rotation.
    #[cfg(test)]
    pub(crate) fn signed_n(&self) -> i64 {
        signed(self.n, self.direction)
    }

    /// |Im s|/2 pi \[Hz\].
    pub fn frequency(&self) -> f64 {
        frequency(self.pole)
    }

    /// Damping ratio -Re s/|s|.
    pub fn damping(&self) -> f64 {
        damping(self.pole)
    }
}

fn frequency(pole: Complex64) -> f64 {
    pole.im.abs() / TAU
}

fn damping(pole: Complex64) -> f64 {
    -pole.re / pole.norm()
}

/// Modes of a tyre.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Modes {
    /// By n, of a tyre that turns by direction, then m, then frequency.
    pub confirmed: Vec<Mode>,
    /// Poles of an approximation, as (n, m, pole), that were not found in C itself.
    pub unconfirmed: Vec<(usize, usize, Complex64)>,
    /// Evaluations of the compliance used.
    pub evaluations: u64,
}

/// A wave whose modes cannot be found.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("modes of the wave n = {n}, m = {m}: {source}")]
pub struct ModesError {
    /// Periods round the tyre.
    pub n: usize,
    /// Lateral number.
    pub m: usize,
    /// Error of the approximation.
    pub(crate) source: RationalError,
}

/// Modes up to the frequency `highest` \[Hz\] of a tyre's waves n = 0..=`largest_n`, each with so many lateral
/// numbers,
/// the lowest that a centred load excites. An error for a compliance that is not finite, of the first such wave.
pub fn modes(tyre: &Tyre, largest_n: usize, lateral_count: usize, highest: f64) -> Result<Modes, ModesError> {
    let kernel = Kernel::new(tyre, BEYOND * TAU * highest, TOLERANCE);
    let lateral = Waves::new(tyre).lateral_numbers().take(lateral_count);
    let turns = tyre.turns();
    let directions = |n: usize| {
        let both = if turns && n > 0 { Direction::BOTH.map(Some).to_vec() } else { vec![None] };
        both.into_iter().map(move |direction| (n, direction))
    };
    let around = (0..=largest_n).flat_map(directions);
    let waves: Vec<_> =
        around.flat_map(|(n, direction)| lateral.clone().map(move |m| WaveOf { n, direction, m })).collect();
    let most = if tyre.sidewall.is_some() { MOST_ON_SIDEWALLS } else { MOST_POINTS };
    found(&waves, &Line::up_to(highest, most), |wave, s| kernel.at(s).full(wave.signed(), wave.m))
}

/// A wave, of one direction where these differ.
#[derive(Clone, Copy)]
struct WaveOf {
    n: usize,
    direction: Option<Direction>,
    m: usize,
}

impl WaveOf {
    /// n of exp(i n theta' + s t), theta' rising with the elements.
    fn signed(self) -> i64 {
        signed(self.n, self.direction)
    }
}

fn signed(n: usize, direction: Option<Direction>) -> i64 {
    if direction == Some(Direction::Backwards) { -(n as i64) } else { n as i64 }
}

/// Modes up to the frequency `highest` \[Hz\] of waves (n, m) with a compliance C(n, m, s): displacement per traction,
/// order circumferential, lateral, radial, C(conj s) = conj C(s).
pub fn modes_of(
    waves: &[(usize, usize)],
    highest: f64,
    compliance: impl Fn(usize, usize, Complex64) -> Matrix3 + Sync,
) -> Result<Modes, ModesError> {
    let waves: Vec<_> = waves.iter().map(|&(n, m)| WaveOf { n, direction: None, m }).collect();
    found(&waves, &Line::up_to(highest, MOST_POINTS), |wave, s| compliance(wave.n, wave.m, s))
}

fn found(
    waves: &[WaveOf],
    line: &Line,
    compliance: impl Fn(WaveOf, Complex64) -> Matrix3 + Sync,
) -> Result<Modes, ModesError> {
    let of_wave = |&of: &WaveOf| {
        let wave = Wave { of, compliance: |s| compliance(of, s) };
        wave.modes(line).map_err(|source| ModesError { n: of.n, m: of.m, source })
    };
    let found = in_parallel::map(waves, of_wave);
    let mut all = Modes::default();
    for wave in found {
        let wave = wave?;
        all.confirmed.extend(wave.confirmed);
        all.unconfirmed.extend(wave.unconfirmed);
        all.evaluations += wave.evaluations;
    }
    Ok(all)
}

/// Lateral number of the lowest wave, and |C_zz| \[m/Pa\] of the waves n = 0..=`largest_n` with it: one row per
/// frequency \[Hz\], one column per n.
pub fn radial_compliance(tyre: &Tyre, largest_n: usize, frequencies: &[f64]) -> (usize, Vec<Vec<f64>>) {
    let top = frequencies.iter().fold(0.0_f64, |a, &b| a.max(b));
    let kernel = Kernel::new(tyre, TAU * top, TOLERANCE);
    let m = Waves::new(tyre).first_lateral_number();
    let row = |&frequency: &f64| {
        let at = kernel.at(Complex64::new(0.0, TAU * frequency));
        (0..=largest_n).map(|n| at.full(n as i64, m)[2][2].norm()).collect()
    };
    (m, in_parallel::map(frequencies, row))
}

/// Line on which C is sampled: z + shift, z on the imaginary axis.
struct Line {
    points: Vec<Complex64>,
    shift: f64,
    highest: f64,
    most_points: usize,
}

impl Line {
    /// Evenly spaced points; as far right of the axis as the points are apart, so that no pole lies closer.
    fn up_to(highest: f64, most_points: usize) -> Self {
        let shift = TAU * highest / SAMPLES as f64;
        let count = (BEYOND * SAMPLES as f64) as usize;
        let points = (0..count).map(|k| Complex64::new(0.0, (k as f64 + 0.5) * shift)).collect();
        Self { points, shift, highest, most_points }
    }

    /// Poles of an approximation to a function's values on the line that ring within the band, each with whether it
    /// contributes to the values.
    fn poles(&self, values: &[Complex64]) -> Result<Vec<(Complex64, bool)>, RationalError> {
        let model = approximate(&self.points, values, TOLERANCE, [self.most_points, PATIENCE])?;
        let largest = values.iter().fold(0.0_f64, |a, value| a.max(value.norm()));
        let is_significant =
            |z: Complex64| residue(|z| model.evaluate(z), z).norm() > SIGNIFICANT * largest * z.re.abs();
        let poles = model.poles()?.into_iter().filter(|&z| self.rings(z + self.shift));
        Ok(poles.map(|z| (z + self.shift, is_significant(z))).collect())
    }

    fn rings(&self, pole: Complex64) -> bool {
        pole.im > 0.0 && frequency(pole) <= self.highest && damping(pole).abs() < LARGEST_DAMPING
    }
}

/// Residue of a simple pole: the regular part has the same value on both sides and cancels.
fn residue(f: impl Fn(Complex64) -> Complex64, pole: Complex64) -> Complex64 {
    let beside = BESIDE * pole.norm();
    (f(pole + beside) - f(pole - beside)) * (0.5 * beside)
}

/// Pole of f near a start, by the secant method on 1/f; `None` where it does not converge nearby.
fn polished(f: impl Fn(Complex64) -> Complex64, start: Complex64) -> Option<Complex64> {
    let (mut before, mut s) = (start * (1.0 + BESIDE), start);
    let (mut inverse_before, mut inverse) = (f(before).inv(), f(s).inv());
    for _ in 0..ITERATIONS {
        // At the pole itself 1/f is 0, or NaN where f has overflowed.
        let step = if inverse.norm() > 0.0 { inverse * (s - before) / (inverse - inverse_before) } else { 0.0.into() };
        (before, inverse_before) = (s, inverse);
        s -= step;
        if !s.is_finite() || (s - start).norm() > LONGEST_WAY * start.norm() {
            return None;
        }
        if step.norm() <= LAST_STEP * s.norm() {
            return Some(s);
        }
        inverse = f(s).inv();
    }
    None
}

struct Wave<F> {
    of: WaveOf,
    compliance: F,
}

impl<F: Fn(Complex64) -> Matrix3> Wave<F> {
    fn modes(&self, line: &Line) -> Result<Modes, RationalError> {
        let WaveOf { n, m, .. } = self.of;
        let evaluations = Cell::new(0);
        let compliance = |s: Complex64| {
            evaluations.set(evaluations.get() + 1);
            (self.compliance)(s)
        };
        // Step 1 of the head, then steps 2 to 4 for each diagonal entry.
        let sampled: Vec<Matrix3> = line.points.iter().map(|&z| compliance(z + line.shift)).collect();
        let mut modes = Modes::default();
        let mut unconfirmed = Vec::new();
        for entry in 0..3 {
            let values: Vec<Complex64> = sampled.iter().map(|compliance| compliance[entry][entry]).collect();
            for (start, is_significant) in line.poles(&values)? {
                let Some(pole) = polished(|s| compliance(s)[entry][entry], start) else {
                    unconfirmed.extend(is_significant.then_some(start));
                    continue;
                };
                if !line.rings(pole) {
                    continue;
                }
                let mode = self.mode(pole, entry, compliance);
                let is_new = |other: &Mode| other.motion != mode.motion || !same(other.pole, pole, SAME);
                if modes.confirmed.iter().all(is_new) {
                    modes.confirmed.push(mode);
                }
            }
        }
        // Another entry may have confirmed it.
        unconfirmed.retain(|&start| !modes.confirmed.iter().any(|mode| same(mode.pole, start, LONGEST_WAY)));
        modes.unconfirmed = unconfirmed.into_iter().map(|pole| (n, m, pole)).collect();
        modes.confirmed.sort_by(|a, b| a.pole.im.total_cmp(&b.pole.im).then(a.motion.cmp(&b.motion)));
        modes.evaluations = evaluations.get();
        Ok(modes)
    }

    /// Mode of a pole that was found in the entry jj. Its residue is v_i w_j, so that v_i w_i is R_ij R_ji/R_jj:
    /// another mode that happens to have the same pole does not enter.
    fn mode(&self, pole: Complex64, entry: usize, compliance: impl Fn(Complex64) -> Matrix3) -> Mode {
        let beside = BESIDE * pole.norm();
        let (right, left) = (compliance(pole + beside), compliance(pole - beside));
        let residue = |i: usize, j: usize| right[i][j] - left[i][j];
        let diagonal = residue(entry, entry);
        let part = |i: usize| {
            if i == entry { diagonal.norm() } else { (residue(i, entry) * residue(entry, i) / diagonal).norm() }
        };
        let parts: [f64; 3] = std::array::from_fn(part);
        let sum: f64 = parts.iter().sum();
        let shares = parts.map(|part| part / sum);
        // The residue is half of the difference times the distance.
        let peak = 0.5 * beside * sum / pole.re.abs();
        let [circumferential, lateral, radial] = shares;
        let motion = if radial >= RADIAL {
            Motion::Radial
        } else if circumferential >= lateral {
            Motion::Circumferential
        } else {
            Motion::Lateral
        };
        let WaveOf { n, direction, m } = self.of;
        Mode { n, direction, m, motion, pole, shares, peak }
    }
}

fn same(a: Complex64, b: Complex64, within: f64) -> bool {
    (a - b).norm() <= within * a.norm()
}

#[cfg(test)]
#[path = "modes_tests.rs"]
mod tests;
