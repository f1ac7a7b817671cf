//! Influence of all components of traction on all of displacement between cells, by wave and summed for an instant.
//!
//! ```text
//! u_a,ij = sum_n sum_m (1/L) norm_m exp(i kx (x_i - x_i')) sinc^2(kx dx/2) s^a_m(y_j) s^b_m(y_j') C_ab(n, m) F_b,i'j'
//! ```
//!
//! with x forward, y to the left and z into the tyre. Shapes are sines across for x and z and cosines for y with
//! supported sides, and the other way round with guided ones. With C(kx, ky) of waves exp(i (kx x + ky y)), outwards
//! along z (module `kernel`), supported sides have
//!
//! ```text
//! C_ab = l_a C(kx, ky)_ab r_b,    l = (1, -i, -1),    r = (1, i, -1)
//! ```
//!
//! and guided ones -i for i. C_xx, C_yy, C_zz, C_yz and C_zy are then real and even in n at real s of a tyre at rest,
//! the others imaginary and odd: they vanish at n = 0 and n = -N/2, which stand for both signs. With rotation each has
//! both parts, C_ab(n) = E + i O at n >= 0, see `folded_sum`.
//!
//! Lateral motion has a wave m = 0, uniform across, of shape 1 and weight 1/B: with supported sides in addition to
//! m = 1 ..., with guided sides in place of the mean of the sines: their shapes are sin(ky y) less that mean,
//! c_m = (1 - cos(m pi))/(m pi), so that a lateral force's mean across drives the uniform motion alone and nothing
//! else does.
//!
//! Sums are ended as those of normal forces (`cell_sums`): the mean of what is above the last lobe acts on C_xx, C_yy
//! and C_zz; of all others it is 0.

use std::f64::consts::PI;

use num_complex::Complex64;
use rayon::prelude::*;

use super::cell_grid::CellGrid;
use super::cell_sums::{Around, CellSums, CellSumsAt, THICKNESS_TOLERANCE, add_mean, on_unit};
use super::cell_waves::{CellRow, CellTruncation, CellWave, WaveBand};
use super::kernel::KernelAt;
use super::traction_influence::{COMPONENTS, PairTables, TractionInfluence, UniformTables};
use crate::numeric::{Ring, sinc};
use crate::scene::Sides;
use crate::tyre::layers::compliance::Matrix3;
use crate::tyre::layers::surface_asymptote::{HalfSpaceTraction, thickness_limit};

/// Number of pairs of components.
pub(crate) const PAIRS: usize = COMPONENTS * COMPONENTS;

/// Even and odd parts of a wave's compliance by pair, displacement a by force b at 3 a + b \[m/N\], or \[m/Pa\] before
/// weights.
#[derive(Clone, Copy, Debug)]
pub struct TractionParts {
    /// Even part E.
    pub even: [Complex64; PAIRS],
    /// Odd part O.
    pub odd: [Complex64; PAIRS],
}

impl TractionParts {
    /// True for pairs whose odd part is 0 at rest; of all others it is the even part.
    pub(crate) fn is_even_at_rest(pair: usize) -> bool {
        let is_along = |component: usize| component == 0;
        is_along(pair / COMPONENTS) == is_along(pair % COMPONENTS)
    }

    const ZERO: Self = Self { even: [Complex64::ZERO; PAIRS], odd: [Complex64::ZERO; PAIRS] };

    /// Parts of the waves n and -n, n >= 0, of a lateral number \[m/Pa\].
    fn of_wave(kernel: &KernelAt, sides: Sides, n: i64, m: usize) -> Self {
        let forwards = in_shapes(&kernel.full(n, m), sides);
        if n == 0 {
            return Self { even: forwards, ..Self::ZERO };
        }
        if kernel.turns() {
            let backwards = in_shapes(&kernel.full(-n, m), sides);
            let both = |pair: usize| (forwards[pair] + backwards[pair]) * 0.5;
            let apart = |pair: usize| (backwards[pair] - forwards[pair]) * Complex64::new(0.0, 0.5);
            return Self { even: std::array::from_fn(both), odd: std::array::from_fn(apart) };
        }
        let mut parts = Self::ZERO;
        for (pair, value) in forwards.into_iter().enumerate() {
            if Self::is_even_at_rest(pair) {
                parts.even[pair] = value
            } else {
                parts.odd[pair] = value * -Complex64::i()
            }
        }
        parts
    }

    /// Parts of a half-space's wave at a real s, kx >= 0 \[m/Pa\].
    fn of_half_space(half_space: &TractionHalfSpace, sides: Sides, kx: f64, ky: f64) -> Self {
        let k = kx.hypot(ky);
        let HalfSpaceTraction { along, mixed, outward, shear } =
            HalfSpaceTraction::new(half_space.kappa, half_space.ratio / (k * k));
        let scale = half_space.inverse_shear / k;
        let [x, y] = [kx / k, ky / k];
        let turned = if sides == Sides::Supported { 1.0 } else { -1.0 };
        let mut parts = Self::ZERO;
        let mut set = |pair: usize, value: f64| {
            let place = if Self::is_even_at_rest(pair) { &mut parts.even } else { &mut parts.odd };
            place[pair] = Complex64::new(scale * value, 0.0);
        };
        set(0, x * x * along + y * y * shear);
        set(4, y * y * along + x * x * shear);
        set(8, outward);
        set(1, turned * x * y * (along - shear));
        set(3, -turned * x * y * (along - shear));
        set(2, x * mixed);
        set(6, -x * mixed);
        set(5, turned * y * mixed);
        set(7, turned * y * mixed);
        parts
    }

    /// Adds parts by their weights; those that couple lateral with other components times `lateral`.
    fn add(&mut self, parts: &Self, lateral: f64, [even, odd]: [f64; 2]) {
        for pair in 0..PAIRS {
            let is_mixed = (pair / COMPONENTS == 1) != (pair % COMPONENTS == 1);
            let sign = if is_mixed { lateral } else { 1.0 };
            self.even[pair] += sign * even * parts.even[pair];
            self.odd[pair] += sign * odd * parts.odd[pair];
        }
    }
}

/// Compliance between shapes from that of waves exp(i (kx x + ky y)): the module's l and r, z inwards.
pub(super) fn in_shapes(full: &Matrix3, sides: Sides) -> [Complex64; PAIRS] {
    let turn = if sides == Sides::Supported { Complex64::i() } else { -Complex64::i() };
    let (left, right) = ([Complex64::ONE, -turn, -Complex64::ONE], [Complex64::ONE, turn, -Complex64::ONE]);
    std::array::from_fn(|pair| {
        let [a, b] = [pair / COMPONENTS, pair % COMPONENTS];
        left[a] * full[a][b] * right[b]
    })
}

/// Mean across of sin(m pi y/B).
fn mean_of_sine(m: usize) -> f64 {
    if m.is_multiple_of(2) { 0.0 } else { 2.0 / (m as f64 * PI) }
}

/// Mean over a cell j of the shape of a component in a wave m across.
pub fn traction_shape(grid: &CellGrid, component: usize, m: usize, j: usize) -> f64 {
    let sides = grid.waves().sides;
    if component != 1 {
        return if m == 0 && sides == Sides::Supported { 0.0 } else { grid.shape(m, j) };
    }
    if m == 0 {
        return 1.0;
    }
    let [phase, share] = lateral_phase(grid, m, j);
    match sides {
        Sides::Supported => phase.cos() * share,
        Sides::Guided => phase.sin() * share - mean_of_sine(m),
    }
}

/// As [`traction_shape`] for folded waves, without the mean over a cell; sides are supported.
pub(crate) fn folded_traction_shape(grid: &CellGrid, component: usize, m: usize, j: usize) -> f64 {
    if component == 1 { lateral_phase(grid, m, j)[0].cos() } else { grid.wave(m, j) }
}

/// ky y' of a cell's middle, and the ratio of the mean over the cell to the value there.
fn lateral_phase(grid: &CellGrid, m: usize, j: usize) -> [f64; 2] {
    let (waves, ky) = (grid.waves(), grid.waves().ky(m));
    [ky * (0.5 * waves.width + grid.from_middle(j)), sinc(0.5 * ky * grid.pitch())]
}

/// The tread as a half-space at one real s.
struct TractionHalfSpace {
    /// Wavenumber from which on the tread is a half-space \[1/m\].
    from: f64,
    kappa: f64,
    /// Q/mu \[1/m^2\].
    ratio: f64,
    inverse_shear: f64,
}

impl TractionHalfSpace {
    fn of(sums: &CellSums, at: &KernelAt) -> Option<Self> {
        let thickness = sums.kernel.tread()?.thickness;
        let tread = at.tread();
        Some(Self {
            from: thickness_limit(thickness, THICKNESS_TOLERANCE),
            kappa: tread.modulus_ratio,
            ratio: tread.inertia_over_shear().re,
            inverse_shear: tread.inverse_shear.re,
        })
    }

    /// C_xx, C_yy and C_zz \[m/Pa\].
    fn diagonal(&self, sides: Sides, kx: f64, ky: f64) -> [f64; COMPONENTS] {
        let parts = TractionParts::of_half_space(self, sides, kx, ky);
        [0, 4, 8].map(|pair| parts.even[pair].re)
    }

    /// Sums over |kx| above the last wave of (1/L) 4/(kx dx)^2 C_aa.
    fn rest(&self, around: &Around<'_>, sides: Sides, ky: f64) -> [f64; COMPONENTS] {
        let (length, highest) = (around.grid.length(), around.highest());
        let factor = 4.0 / (PI * length * length * highest);
        let mut rest = [0.0; COMPONENTS];
        for [u, weight] in on_unit() {
            let diagonal = self.diagonal(sides, highest / u, ky);
            rest.iter_mut().zip(diagonal).for_each(|(rest, diagonal)| *rest += factor * weight * diagonal);
        }
        rest
    }
}

/// Influence of a lateral number by pair and distance along, i - i' = 1 - columns ...; without the shapes across.
struct NumberRows {
    m: usize,
    rows: Vec<Vec<f64>>,
}

impl WaveBand {
    /// Waves that carry the history of tractions: those of normal forces, and on the whole tyre with supported sides
    /// the lateral motion that is uniform across. A band may be folded with supported sides only: the mean of the sines
    /// differs from number to number.
    pub fn traction_rows(self, grid: &CellGrid, truncation: CellTruncation) -> Vec<CellRow> {
        let mut rows = self.rows(grid, truncation);
        if grid.waves().sides == Sides::Supported && self.fades_in.is_none() {
            rows.insert(0, CellRow::whole(grid, 0, truncation.aliases.unwrap_or(1)));
        }
        rows
    }
}

impl CellSums {
    /// Waves of a band that carry the history of tractions.
    pub fn traction_rows(&self, band: WaveBand) -> Vec<CellRow> {
        band.traction_rows(&self.grid, self.truncation)
    }

    /// Parts of a wave's influence at s \[m/N\].
    pub fn traction_parts(&self, wave: &CellWave, CellSumsAt(at): &CellSumsAt) -> TractionParts {
        let mut sum = TractionParts::ZERO;
        // Odd parts of a wave that is its own mirror cancel.
        let sides = if wave.is_mirror { 0.0 } else { 1.0 };
        for &(n, m, weight) in &wave.terms {
            let parts = TractionParts::of_wave(at, self.grid.waves().sides, n.abs(), m);
            let lateral = if wave.is_reflected(m) { -1.0 } else { 1.0 };
            sum.add(&parts, lateral, [weight, weight * sides * n.signum() as f64]);
        }
        sum
    }

    /// Influence between cells at a real s \[1/s\], up to `columns` along.
    pub(crate) fn traction_instant(&self, s: f64, columns: usize) -> TractionInfluence {
        let at = if s > 0.0 { self.kernel.at(Complex64::new(s, 0.0)) } else { self.kernel.at_rest() };
        let (grid, tail) = (&self.grid, TractionHalfSpace::of(self, &at));
        let (elements, waves) = (grid.elements(), grid.waves());
        let (last, last_m) = self.last_of_instant();
        let closed = tail.as_ref().filter(|_| self.truncation.aliases.is_none());
        let around = Around { grid, last, truncated: closed.is_none(), columns };
        // 1. Parts of any wave: the half-space's where the thickness is not felt.
        let parts = |n: i64, m: usize| match &tail {
            Some(tail) if waves.kx(n).hypot(waves.ky(m)) > tail.from => {
                TractionParts::of_half_space(tail, waves.sides, waves.kx(n), waves.ky(m))
            }
            _ => TractionParts::of_wave(&at, waves.sides, n, m),
        };
        // 2. For each m: sums over n at each distance along, by pair.
        let of_number = |ring: &mut Ring, m: usize| {
            let values: Vec<TractionParts> = (0..=last).map(|n| parts(n, m)).collect();
            let norm = waves.lateral_norm(m);
            let rest = closed.map(|tail| tail.rest(&around, waves.sides, waves.ky(m)));
            let row = |pair: usize| {
                let mut even = around.sum(ring, |n| norm * values[n as usize].even[pair].re);
                if let (Some(rest), true) = (rest, pair.is_multiple_of(COMPONENTS + 1)) {
                    add_mean(&mut even, norm * rest[pair / COMPONENTS]);
                }
                let mut folded = vec![0.0; elements / 2 + 1];
                for (n, value) in values.iter().enumerate() {
                    around.fold_odd(&mut folded, n as i64, norm * value.odd[pair].re);
                }
                both_ways(&even, &ring.odd_elements_of(|n| folded[n])[..columns])
            };
            NumberRows { m, rows: (0..PAIRS).map(row).collect() }
        };
        let numbers: Vec<usize> = (0..=last_m).collect();
        let rows: Vec<NumberRows> =
            numbers.par_iter().map_init(|| Ring::new(elements), |ring, &m| of_number(ring, m)).collect();
        // 3. The sum over m between cells, and the tail above the last m.
        let mut influence = together(grid, columns, &rows);
        if let Some(tail) = closed.filter(|_| self.truncation.lateral_terms.is_none()) {
            add_lateral_rest(&mut influence, &around, tail, waves.ky(last_m) + 0.5 * waves.ky(1));
        }
        influence
    }
}

/// A row over all distances from one from distance 0 on; the odd part changes its sign at negative distances.
fn both_ways(even: &[f64], odd: &[f64]) -> Vec<f64> {
    let below = even.iter().zip(odd).skip(1).rev().map(|(even, odd)| even - odd);
    below.chain(even.iter().zip(odd).map(|(even, odd)| even + odd)).collect()
}

/// Adds the waves beyond the last lateral number, ky > `last` \[1/m\]: the mean of sin^2 cos, for a cell and its
/// neighbours.
fn add_lateral_rest(influence: &mut TractionInfluence, around: &Around<'_>, tail: &TractionHalfSpace, last: f64) {
    let (grid, across, columns) = (around.grid, influence.across, influence.columns);
    let (width, sides) = (influence.width(), grid.waves().sides);
    let factor = 4.0 / (PI * grid.pitch() * grid.pitch() * last);
    let mut ring = Ring::new(grid.elements());
    for [u, weight] in on_unit() {
        let ky = last / u;
        let rest = tail.rest(around, sides, ky);
        for (component, rest) in rest.into_iter().enumerate() {
            let mut row = around.sum(&mut ring, |n| tail.diagonal(sides, grid.waves().kx(n), ky)[component]);
            add_mean(&mut row, rest);
            let table = &mut influence.pairs[component * (COMPONENTS + 1)].toeplitz;
            for (distance, cells) in table.chunks_exact_mut(width).enumerate() {
                let value = factor * weight * row[distance.abs_diff(columns - 1)];
                cells[across - 1] += 0.5 * value;
                if across > 1 {
                    cells[across - 2] -= 0.25 * value;
                    cells[across] -= 0.25 * value;
                }
            }
        }
    }
}

/// The influence between cells across: the sum of lateral numbers times their shapes.
fn together(grid: &CellGrid, columns: usize, rows: &[NumberRows]) -> TractionInfluence {
    let (waves, across) = (grid.waves(), grid.across);
    let mut influence = TractionInfluence::zeros(columns, across);
    let (width, distances) = (influence.width(), influence.distances());
    let is_supported = waves.sides == Sides::Supported;
    let first = waves.width + 2.0 * grid.from_middle(0);
    for (pair, tables) in influence.pairs.iter_mut().enumerate() {
        let is_lateral = [pair / COMPONENTS == 1, pair % COMPONENTS == 1];
        // Products of shapes: 1/2 of functions of ky (y - y') and of ky (y + y').
        let number = |m: usize| -> Vec<[f64; 2]> {
            let share = sinc(0.5 * waves.ky(m) * grid.pitch()).powi(2);
            let product = |[free, image]: [f64; 2]| -> [f64; 2] {
                match (is_lateral, is_supported) {
                    ([true, true], _) if m == 0 => [1.0, 0.0],
                    _ if m == 0 && (is_lateral[0] || is_lateral[1] || is_supported) => [0.0; 2],
                    ([false, false], true) | ([true, true], false) => [0.5 * free.cos(), -0.5 * image.cos()],
                    ([false, false], false) | ([true, true], true) => [0.5 * free.cos(), 0.5 * image.cos()],
                    ([false, true], true) | ([true, false], false) => [0.5 * free.sin(), 0.5 * image.sin()],
                    ([true, false], true) | ([false, true], false) => [-0.5 * free.sin(), 0.5 * image.sin()],
                }
            };
            let place = |s: usize| {
                let free = (s as f64 + 1.0 - across as f64) * grid.pitch();
                let image = first + s as f64 * grid.pitch();
                product([free, image].map(|distance| waves.ky(m) * distance)).map(|value| share * value)
            };
            (0..width).map(place).collect()
        };
        let mut sums = vec![[0.0; 2]; distances * width];
        for NumberRows { m, rows } in rows {
            let shapes = number(*m);
            for (sums, value) in sums.chunks_exact_mut(width).zip(&rows[pair]) {
                for (sum, shape) in sums.iter_mut().zip(&shapes) {
                    sum[0] += value * shape[0];
                    sum[1] += value * shape[1];
                }
            }
        }
        *tables = PairTables {
            toeplitz: sums.iter().map(|sum| sum[0]).collect(),
            hankel: sums.iter().map(|sum| sum[1]).collect(),
        };
    }
    if !is_supported {
        take_mean_off(grid, &mut influence, rows);
    }
    influence
}

/// Removes the mean of sines from lateral shapes, in whose place the uniform motion stands.
fn take_mean_off(grid: &CellGrid, influence: &mut TractionInfluence, rows: &[NumberRows]) {
    let (across, distances, width) = (influence.across, influence.distances(), influence.width());
    let zeros = || vec![0.0; distances * across];
    let mut tables = UniformTables { driven: [zeros(), zeros(), zeros()], observed: [zeros(), zeros(), zeros()] };
    for NumberRows { m, rows } in rows.iter().filter(|rows| rows.m % 2 == 1) {
        let mean = mean_of_sine(*m);
        for component in 0..COMPONENTS {
            // The sine itself: the shape less its mean, plus the mean.
            let offset = if component == 1 { mean } else { 0.0 };
            let shape: Vec<f64> =
                (0..across).map(|j| mean * (traction_shape(grid, component, *m, j) + offset)).collect();
            for (table, pair) in [
                (&mut tables.driven[component], COMPONENTS * component + 1),
                (&mut tables.observed[component], COMPONENTS + component),
            ] {
                for (cells, value) in table.chunks_exact_mut(across).zip(&rows[pair]) {
                    cells.iter_mut().zip(&shape).for_each(|(cell, shape)| *cell += value * shape);
                }
            }
        }
        let lateral = &mut influence.pairs[COMPONENTS + 1].toeplitz;
        for (cells, value) in lateral.chunks_exact_mut(width).zip(&rows[COMPONENTS + 1]) {
            cells.iter_mut().for_each(|cell| *cell += value * mean * mean);
        }
    }
    influence.uniform = Some(Box::new(tables));
}

#[cfg(test)]
#[path = "traction_tests.rs"]
mod tests;
