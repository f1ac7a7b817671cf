//! Answer of single waves to all components of traction over frequency: the outward motion that tangential forces
//! cause.
//!
//! The inverse of a wave's C, a stiffness, is tabulated at frequencies of equal distance in asinh(f), and interpolated
//! by cubics: where the wave resonates C is sharp and its inverse is smooth, as for one component (`surface_waves`).
//! The inner face follows the surface by D C^-1, which is smooth, too. Aliases of a wave on elements are short and
//! have no sharp resonance: their sum is interpolated directly. One alias on either side is enough: in waves so short
//! rubber, nearly incompressible, couples nothing.
//!
//! The frequencies stand for the s that a time rule has for them. Components and shapes are those of
//! [`super::traction_sums`]; -n is tabulated where the tyre turns, else it follows from n by the parity of the pairs.

use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use super::cell_grid::CellGrid;
use super::cell_sums::{CellSums, CellSumsAt};
use super::cell_waves::{CellRow, CellTruncation};
use super::kernel::{Kernel, KernelAt};
use super::surface_waves::{frequencies, neighbours};
use super::traction_influence::COMPONENTS;
use super::traction_sums::{PAIRS, TractionParts, in_shapes};
use super::waves::Waves;
use crate::numeric::{double, single};
use crate::scene::{Sides, Tyre};
use crate::tyre::layers::compliance::Matrix3;
use crate::tyre::layers::curved::inverse;

/// Aliases of a wave that are taken, on either side.
const ALIASES: usize = 1;

/// Answer of a wave to the forces on elements \[m/N\], or to tractions \[m/Pa\].
#[derive(Clone, Copy, Debug)]
pub(crate) struct TractionAnswer {
    /// Displacement a of the surface by force b, in row a.
    pub surface: Matrix3,
    /// Displacement of the inner face into the tyre by force b.
    pub bottom: [Complex64; COMPONENTS],
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    /// C^-1.
    stiffness: Matrix3,
    /// Displacement of the inner face into the tyre by displacement b of the surface: row 3 of D C^-1.
    transfer: [Complex64; COMPONENTS],
    /// Weighted sum of the aliases' C.
    aliases: Matrix3,
}

/// One wave over frequency: n, and -n where it differs.
pub(crate) struct TractionWave {
    /// By sign of n, then frequency.
    ways: Vec<Vec<Sample>>,
    /// Weight of C on elements.
    weight: f64,
    /// True if n and -n are the same on elements.
    is_mirror: bool,
}

/// Waves of a tyre on elements, of some lateral numbers, at the s that stand for a list of frequencies.
pub(crate) struct TractionLines {
    sums: CellSums,
    rows: Vec<CellRow>,
    at: Vec<CellSumsAt>,
}

/// C^-1 of the waves with n = 0..=`most_around` and some lateral numbers, at s = i w, for C_zx and C_zy.
#[derive(Clone, Debug)]
pub(crate) struct TractionWaves {
    lateral: usize,
    around: usize,
    points: usize,
    /// C^-1 by n, lateral number and frequency \[Pa/m\].
    forwards: Vec<[Complex32; PAIRS]>,
    /// The same of -n; empty at rest.
    backwards: Vec<[Complex32; PAIRS]>,
}

fn scaled(matrix: &Matrix3, factor: f64) -> Matrix3 {
    matrix.map(|row| row.map(|entry| factor * entry))
}

fn sum(one: &Matrix3, other: &Matrix3) -> Matrix3 {
    std::array::from_fn(|a| std::array::from_fn(|b| one[a][b] + other[a][b]))
}

fn matrix(pairs: [Complex64; PAIRS]) -> Matrix3 {
    std::array::from_fn(|a| std::array::from_fn(|b| pairs[COMPONENTS * a + b]))
}

/// C of the wave -n from that of n, of a tyre at rest.
fn mirrored(matrix: &Matrix3) -> Matrix3 {
    let sign = |a: usize, b: usize| if TractionParts::is_even_at_rest(COMPONENTS * a + b) { 1.0 } else { -1.0 };
    std::array::from_fn(|a| std::array::from_fn(|b| sign(a, b) * matrix[a][b]))
}

impl TractionAnswer {
    /// Answer of -n from that of n, of a tyre at rest.
    fn mirrored(&self) -> Self {
        let [x, y, z] = self.bottom;
        Self { surface: mirrored(&self.surface), bottom: [-x, y, z] }
    }

    fn mean(&self, other: &Self) -> Self {
        let surface = scaled(&sum(&self.surface, &other.surface), 0.5);
        Self { surface, bottom: std::array::from_fn(|b| 0.5 * (self.bottom[b] + other.bottom[b])) }
    }
}

impl Sample {
    fn of(at: &KernelAt, sides: Sides, n: i64, m: usize, aliases: Matrix3) -> Self {
        let [surface, bottom] = at.full_of_faces(n, m).map(|face| matrix(in_shapes(&face, sides)));
        let stiffness = inverse(surface);
        let transfer = std::array::from_fn(|b| (0..COMPONENTS).map(|c| bottom[2][c] * stiffness[c][b]).sum());
        Self { stiffness, transfer, aliases }
    }
}

impl TractionLines {
    /// Waves of a tyre on so many elements, of some lateral numbers, for frequencies up to a highest one \[Hz\];
    /// `symbol`: the s \[1/s\] of a frequency. Compliances within a relative `tolerance`.
    pub(crate) fn new(
        tyre: &Tyre,
        elements: usize,
        numbers: impl IntoIterator<Item = usize>,
        (highest, tolerance): (f64, f64),
        symbol: impl Fn(f64) -> Complex64,
    ) -> Self {
        let symbols: Vec<Complex64> = frequencies(highest).map(symbol).collect();
        let largest = symbols.iter().fold(1.0_f64, |largest, s| largest.max(s.norm()));
        let grid = CellGrid::new(tyre, elements, 1);
        let rows = numbers.into_iter().map(|m| CellRow::whole(&grid, m, ALIASES)).collect();
        let sums = CellSums::new(tyre, grid, CellTruncation::default(), tolerance, largest);
        let at = symbols.iter().map(|&s| sums.at(s)).collect();
        Self { sums, rows, at }
    }

    /// Wave n = 0..=N/2 of the lateral number at `index`.
    pub(crate) fn wave(&self, index: usize, n: usize) -> TractionWave {
        let (row, sides) = (&self.rows[index], self.sums.grid.waves().sides);
        let wave = &row.waves[n];
        let is_main = |term: &(i64, usize, f64)| term.0.unsigned_abs() as usize == n;
        let weight = wave.terms.iter().filter(|term| is_main(term)).map(|&(_, _, weight)| weight).sum();
        let mut others = wave.clone();
        others.terms.retain(|term| !is_main(term));
        let aliases: Vec<TractionParts> = self.at.iter().map(|at| self.sums.traction_parts(&others, at)).collect();
        let way = |sign: i64| {
            let sample = |(at, parts): (&CellSumsAt, &TractionParts)| {
                let turned = Complex64::new(0.0, sign as f64);
                let aliases = matrix(std::array::from_fn(|pair| parts.even[pair] + turned * parts.odd[pair]));
                Sample::of(&at.0, sides, sign * n as i64, row.m, aliases)
            };
            self.at.iter().zip(&aliases).map(sample).collect()
        };
        let signs: &[i64] = if self.sums.turns() { &[1, -1] } else { &[1] };
        TractionWave { ways: signs.iter().map(|&sign| way(sign)).collect(), weight, is_mirror: wave.is_mirror }
    }
}

impl TractionWave {
    /// Answers of the waves n and -n at a frequency that is not negative \[Hz\].
    pub(crate) fn at(&self, frequency: f64) -> [TractionAnswer; 2] {
        let (first, weights) = neighbours(frequency);
        let of = |samples: &Vec<Sample>| {
            let near = || samples[first..].iter().zip(weights);
            let zero = Matrix3::default();
            let stiffness = near().fold(zero, |all, (sample, weight)| sum(&all, &scaled(&sample.stiffness, weight)));
            let aliases = near().fold(zero, |all, (sample, weight)| sum(&all, &scaled(&sample.aliases, weight)));
            let compliance = scaled(&inverse(stiffness), self.weight);
            let transfer: [Complex64; COMPONENTS] =
                std::array::from_fn(|c| near().map(|(sample, weight)| weight * sample.transfer[c]).sum());
            let bottom = std::array::from_fn(|b| (0..COMPONENTS).map(|c| transfer[c] * compliance[c][b]).sum());
            TractionAnswer { surface: sum(&compliance, &aliases), bottom }
        };
        let forwards = of(&self.ways[0]);
        let backwards = self.ways.get(1).map_or_else(|| forwards.mirrored(), of);
        // Where n and -n are one wave the odd parts cancel.
        if self.is_mirror { [forwards.mean(&backwards); 2] } else { [forwards, backwards] }
    }
}

impl TractionWaves {
    /// For frequencies from 0 to `highest` \[Hz\]; compliances within a relative `tolerance`.
    pub(crate) fn new(tyre: &Tyre, most_around: usize, lateral: &[usize], [highest, tolerance]: [f64; 2]) -> Self {
        let angular: Vec<f64> = frequencies(highest).map(|frequency| std::f64::consts::TAU * frequency).collect();
        let kernel = Kernel::new(tyre, angular.iter().fold(0.0, |_, &last| last), tolerance);
        let at: Vec<KernelAt> = angular.iter().map(|&w| kernel.at(Complex64::new(0.0, w))).collect();
        let (points, sides) = (at.len(), Waves::new(tyre).sides);
        let of = |n: i64| {
            let numbers = lateral.iter().flat_map(|&m| at.iter().map(move |at| (m, at)));
            let stiffness = |(m, at): (usize, &KernelAt)| {
                let [surface, _] = at.full_of_faces(n, m);
                let stiffness = inverse(matrix(in_shapes(&surface, sides)));
                std::array::from_fn(|pair| single(stiffness[pair / COMPONENTS][pair % COMPONENTS]))
            };
            numbers.map(stiffness).collect::<Vec<_>>()
        };
        let all = |sign: i64| (0..=most_around as i64).into_par_iter().flat_map_iter(|n| of(sign * n)).collect();
        let backwards = if at[0].turns() { all(-1) } else { Vec::new() };
        Self { lateral: lateral.len(), around: most_around + 1, points, forwards: all(1), backwards }
    }

    /// Bytes of a table; `highest` in Hz.
    pub(crate) fn bytes(most_around: usize, lateral: usize, highest: f64, turns: bool) -> f64 {
        let ways = if turns { 2.0 } else { 1.0 };
        let numbers = (most_around + 1) * lateral * frequencies(highest).len();
        ways * (numbers * size_of::<[Complex32; PAIRS]>()) as f64
    }

    /// C_zx and C_zy \[m/Pa\] of a wave of n periods and the lateral number at `index`, at a frequency \[Hz\]; n and
    /// frequency of either sign; zero beyond the table.
    pub(crate) fn at(&self, n: i64, frequency: f64, index: usize) -> [Complex64; 2] {
        let is_backwards = (n < 0) != (frequency < 0.0);
        let wave = n.unsigned_abs() as usize;
        let (first, weights) = neighbours(frequency.abs());
        if wave >= self.around || first + 4 > self.points {
            return [Complex64::ZERO; 2];
        }
        let table = if is_backwards && !self.backwards.is_empty() { &self.backwards } else { &self.forwards };
        let near = &table[(wave * self.lateral + index) * self.points + first..][..4];
        let pair = |pair: usize| near.iter().zip(weights).map(|(known, weight)| weight * double(known[pair])).sum();
        let mut answer = inverse(matrix(std::array::from_fn(pair)));
        if is_backwards && self.backwards.is_empty() {
            answer = mirrored(&answer);
        }
        let [x, y, _] = answer[2];
        if frequency < 0.0 { [x.conj(), y.conj()] } else { [x, y] }
    }
}

#[cfg(test)]
#[path = "traction_wave_tests.rs"]
mod tests;
