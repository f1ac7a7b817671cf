//! Influence functions between cells: by wave for the history, summed for the instant of the force.
//!
//! ```text
//! u_ij = sum_n sum_m (1/L)(2/B) exp(i kx (x_i - x_i')) sinc^2(kx dx/2) s_m(y_j) s_m(y_j') C_zz(kx_n, ky_m, s) F_i'j'
//! ```
//!
//! over all n and m (1/B for m = 0). Aliases n + p N fall on the same cells and are folded. Across each m stands for
//! itself, since sides and strip are no multiple of a cell; but for waves so short that they do not feel the sides,
//! which may then be moved to where m and 2 B/dy - m are the same on cells ([`CellGrid::width_in_cells`]).
//!
//! With 2 s s' = sinc^2(ky dy/2) (cos ky(y - y') +- cos ky(y + y')) the sum depends on j - j' and on j + j' alone: the
//! free field and the images in the sides, [`CellInfluence`].
//!
//! The instant's sum is taken explicitly up to [`LOBES`] lobes of sinc^2 in both directions; above, sin^2 cos is
//! replaced by its mean (1/2 for a cell itself, -1/4 for its neighbours, else 0) and C_zz by the half-space's, in
//! quadrature. From the wavenumber on where a wave does not feel the tread's thickness C_zz is the half-space's
//! throughout. The change that curvature makes to those waves, 1e-3 of C_zz, is left out.
//!
//! With rotation, C_zz(kx, ky) = E + i O and C_zz(-kx, ky) = E - i O, both real functions of s (see `folded_sum`).
//! The odd part adds, with i - i' as it stands,
//!
//! ```text
//! - sum_n sum_m (1/L)(2/B) sin(kx (x_i - x_i')) sinc^2(kx dx/2) s_m(y_j) s_m(y_j') O(kx_n, ky_m, s) F_i'j'
//! ```
//!
//! Waves that do not feel the tread's thickness are those of the tyre at rest, and O = 0: for the default tyre at 250
//! km/h, waves up to 1.6 times as short then lack no more than 3e-4 (even) and 4e-4 (odd) of a cell's influence on
//! itself within an instant, and 4e-4 and 2e-4 of it up to 3 kHz (a test that measures adds up sizes).

use std::f64::consts::PI;

use num_complex::Complex64;
use pulp::{Simd, WithSimd};
use rayon::prelude::*;

use super::cell_grid::CellGrid;
use super::cell_influence::{CellInfluence, Rows};
use super::cell_waves::{CellRow, CellTruncation, CellWave, WaveBand};
use super::kernel::{Field, Kernel, KernelAt, LaneKernel};
use super::lane_sum::FaceValues;
use super::parts::Parts;
use crate::numeric::lanes::dispatch;
use crate::numeric::{MOST_LANES, Ring, legendre};
use crate::scene::Tyre;
use crate::tyre::layers::surface_asymptote::{LARGEST_ARGUMENT, closed_form, series, thickness_limit};

/// Lobes of sinc^2 in which the instant's sum is taken wave by wave.
const LOBES: usize = 8;
/// Gauss points of the tail's quadrature.
const TAIL_POINTS: usize = 24;
/// Relative change of a half-space's C_zz by the thickness that is tolerated.
pub(super) const THICKNESS_TOLERANCE: f64 = 1e-7;

/// Influence functions of cells.
#[derive(Clone, Debug)]
pub struct CellSums {
    pub(super) kernel: Kernel,
    pub(super) grid: CellGrid,
    pub(super) truncation: CellTruncation,
    turns: bool,
    /// Text of all that the sums depend on.
    identity: String,
}

/// The influence functions' kernel at one s.
#[derive(Clone, Debug)]
pub struct CellSumsAt(pub(super) KernelAt);

impl CellSums {
    /// Sums of a tyre on the grid's ring for |s| up to `largest_s` \[1/s\]; compliances within a relative `tolerance`.
    pub fn new(tyre: &Tyre, grid: CellGrid, truncation: CellTruncation, tolerance: f64, largest_s: f64) -> Self {
        let turns = tyre.turns() && tyre.curvature;
        let identity = format!("{:?} {grid:?} {truncation:?} {tolerance:?} {largest_s:?}", tyre.levelled());
        let kernel = Kernel::on_ring(tyre, grid.waves(), largest_s, tolerance);
        Self { kernel, grid, truncation, turns, identity }
    }

    /// All that the sums depend on, to the last bit, as text.
    pub(super) fn identity(&self) -> &str {
        &self.identity
    }

    /// True if waves that run forwards and backwards differ: odd parts are then not zero.
    pub fn turns(&self) -> bool {
        self.turns
    }

    /// Cells of the contact strip.
    pub fn grid(&self) -> &CellGrid {
        &self.grid
    }

    /// Kernel at s \[1/s\].
    pub fn at(&self, s: Complex64) -> CellSumsAt {
        CellSumsAt(self.kernel.at(s))
    }

    /// Waves of a band, by lateral number.
    pub fn waves(&self, band: WaveBand) -> Vec<CellRow> {
        band.rows(&self.grid, self.truncation)
    }

    /// Appends the values of a wave's function at each s of a list to `values`, as many lanes at a time as there are.
    pub(crate) fn values<'a>(
        &self,
        wave: &CellWave,
        at: impl IntoIterator<Item = &'a CellSumsAt>,
        values: &mut Vec<FaceValues>,
    ) {
        let at: Vec<&KernelAt> = at.into_iter().map(|CellSumsAt(at)| at).collect();
        dispatch(WaveSum { wave, turns: self.turns, at: &at, values });
    }

    /// Largest n and m that the instant's sum takes wave by wave.
    pub(super) fn last_of_instant(&self) -> (i64, usize) {
        let (grid, waves) = (&self.grid, self.grid.waves());
        let lobes = |length: f64, unit: f64| (LOBES as f64 * 2.0 * PI / (length * unit)).round() as usize;
        let last_around = match self.truncation.aliases {
            Some(aliases) => (aliases * grid.elements() + grid.elements() / 2) as i64,
            None => lobes(grid.length(), waves.kx(1)) as i64,
        };
        (last_around, self.truncation.lateral_terms.unwrap_or_else(|| lobes(grid.pitch(), waves.ky(1))))
    }

    /// Influence between cells at a real s \[1/s\], up to `columns` along.
    pub fn instant(&self, s: f64, columns: usize) -> CellInfluence {
        let at = RealInstant::new(self, s);
        self.summed(columns, self.last_of_instant(), at.tail.as_ref(), at.turns, &|n, m| at.compliance(n, m))
    }

    /// Influence between cells at rest of waves beyond the numbers `last`.
    pub(super) fn short_waves(&self, columns: usize, last: (i64, usize)) -> CellInfluence {
        let at = RealInstant::new(self, 0.0);
        let compliance = |n: i64, m: usize| if n <= last.0 && m <= last.1 { [0.0; 2] } else { at.compliance(n, m) };
        self.summed(columns, self.last_of_instant(), at.tail.as_ref(), false, &compliance)
    }

    /// Influence between cells at a real s \[1/s\] of this tyre, where waves beyond the numbers `last` have nothing but
    /// the modulus of the tread at that s: without inertia. Of the others the part `share` of (kx, ky) has the
    /// compliance of another tyre.
    pub(super) fn blended_instant(
        &self,
        s: f64,
        columns: usize,
        last: (i64, usize),
        (other, share): (&Self, &(dyn Fn(f64, f64) -> f64 + Sync)),
    ) -> CellInfluence {
        let [at, of_other, rest] = [(self, s), (other, s), (self, 0.0)].map(|(sums, s)| RealInstant::new(sums, s));
        let inverse_shear = |at: &RealInstant<'_>| at.at.tread().inverse_shear.re;
        let waves = self.grid.waves();
        let compliance = |n: i64, m: usize| {
            if n > last.0 {
                return [0.0; 2];
            }
            let share = share(waves.kx(n), waves.ky(m));
            let [even, odd] = at.compliance(n, m);
            let other = if share > 0.0 { of_other.compliance(n, m) } else { [0.0; 2] };
            [(1.0 - share) * even + share * other[0], (1.0 - share) * odd + share * other[1]]
        };
        let mut influence = self.cached_short_waves(columns, last);
        influence *= inverse_shear(&at) / inverse_shear(&rest);
        // A sum's last wave counts without its mirror: it is one that has no compliance.
        let last = (last.0 + 1, last.1);
        influence += &self.summed(columns, last, None, at.turns || of_other.turns, &compliance);
        influence
    }

    /// The same tyre on other cells.
    pub(crate) fn on_grid(&self, grid: CellGrid) -> Self {
        let identity = format!("{} {grid:?}", self.identity);
        Self { grid, identity, ..self.clone() }
    }

    /// Influence between cells of waves up to the numbers `last` with the even and odd parts of a compliance
    /// \[m^3/N\], and of a half-space beyond them.
    fn summed(
        &self,
        columns: usize,
        (last_around, last_m): (i64, usize),
        tail: Option<&HalfSpace>,
        turns: bool,
        compliance: &(dyn Fn(i64, usize) -> [f64; 2] + Sync),
    ) -> CellInfluence {
        let grid = &self.grid;
        let elements = grid.elements();
        let waves = grid.waves();
        let numbers: Vec<usize> = grid.lateral_numbers().take_while(|&m| m <= last_m).collect();
        let closed = tail.filter(|_| self.truncation.aliases.is_none() && !grid.fades());
        let around = Around { grid, last: last_around, truncated: closed.is_none(), columns };
        // For each m: the sum over n at each distance along, and the tail above the last n.
        let of_number = |ring: &mut Ring, m: usize| {
            let weight = grid.lateral_weight(m);
            let mut odd = if turns { vec![0.0; elements / 2 + 1] } else { Vec::new() };
            let mut row = around.sum(ring, |n| {
                let carried = grid.carried(n, m);
                if carried <= 0.0 {
                    return 0.0;
                }
                let [even, odd_part] = compliance(n, m).map(|part| carried * part);
                if turns {
                    around.fold_odd(&mut odd, n, weight * odd_part);
                }
                weight * even
            });
            if let Some(tail) = closed {
                add_mean(&mut row, weight * tail.rest(&around, waves.ky(m)));
            }
            (row, turns.then(|| ring.odd_elements_of(|n| odd[n])[..columns].to_vec()))
        };
        let (even, odd): (Vec<_>, Vec<_>) =
            numbers.par_iter().map_init(|| Ring::new(elements), |ring, &m| of_number(ring, m)).unzip();
        // The sum over m between cells, and the tail above the last m.
        let rows = Rows { numbers, even, odd: odd.into_iter().flatten().collect() };
        let mut influence = rows.together(grid, columns);
        if let Some(tail) = closed.filter(|_| self.truncation.lateral_terms.is_none()) {
            let last = rows.numbers.last().map_or(0.0, |&m| waves.ky(m)) + 0.5 * waves.ky(1);
            tail.add_lateral_rest(&mut influence, &around, last);
        }
        influence
    }
}

/// The kernel at one real s.
struct RealInstant<'a> {
    sums: &'a CellSums,
    at: KernelAt,
    tail: Option<HalfSpace>,
    /// True if waves forwards and backwards differ; odd parts vanish at s = 0, too.
    turns: bool,
}

impl<'a> RealInstant<'a> {
    fn new(sums: &'a CellSums, s: f64) -> Self {
        let kernel = &sums.kernel;
        let at = if s > 0.0 { kernel.at(Complex64::new(s, 0.0)) } else { kernel.at_rest() };
        Self { sums, tail: HalfSpace::of(kernel, &at), at, turns: sums.turns && s > 0.0 }
    }

    /// Even and odd part of a wave's compliance \[m^3/N\].
    fn compliance(&self, n: i64, m: usize) -> [f64; 2] {
        let (waves, at) = (self.sums.grid.waves(), &self.at);
        match &self.tail {
            Some(tail) if waves.kx(n).hypot(waves.ky(m)) > tail.from => {
                [tail.compliance(waves.kx(n), waves.ky(m)), 0.0]
            }
            _ if self.turns => {
                let Parts { even, odd } = at.normal_parts(n, m, Field::Surface);
                [even.re, odd.re]
            }
            _ => [at.normal(n, m, Field::Surface).re, 0.0],
        }
    }
}

/// The tread as a half-space, at one real s.
struct HalfSpace {
    /// Wavenumber from which on the tread is a half-space \[1/m\].
    from: f64,
    kappa: f64,
    /// Q/mu.
    ratio: f64,
    inverse_shear: f64,
    series: Vec<f64>,
}

/// Adds means of sin^2 cos times a sum at the distances 0 and 1.
pub(super) fn add_mean(row: &mut [f64], mean: f64) {
    for (value, share) in row.iter_mut().zip([0.5, -0.25]) {
        *value += share * mean;
    }
}

impl HalfSpace {
    fn of(kernel: &Kernel, at: &KernelAt) -> Option<Self> {
        let thickness = kernel.tread()?.thickness;
        let tread = at.tread();
        let from = thickness_limit(thickness, THICKNESS_TOLERANCE);
        Some(Self {
            from,
            kappa: tread.modulus_ratio,
            ratio: tread.inertia_over_shear().re,
            inverse_shear: tread.inverse_shear.re,
            series: series(tread.modulus_ratio).to_vec(),
        })
    }

    fn compliance(&self, kx: f64, ky: f64) -> f64 {
        let k_squared = kx * kx + ky * ky;
        let x = self.ratio / k_squared;
        let phi = if x < LARGEST_ARGUMENT {
            self.series.iter().rev().fold(0.0, |sum, &c| sum * x + c)
        } else {
            closed_form(self.kappa, Complex64::new(x, 0.0)).re
        };
        phi * self.inverse_shear / k_squared.sqrt()
    }

    /// Sum over |kx| > K of (1/L) 4/(kx dx)^2 C: 4/(pi dx^2) int dkx/kx^2 C, with kx = K/u.
    fn rest(&self, around: &Around<'_>, ky: f64) -> f64 {
        let (length, highest) = (around.grid.length(), around.highest());
        let integral: f64 = on_unit().map(|[u, weight]| weight * self.compliance(highest / u, ky)).sum();
        4.0 / (PI * length * length * highest) * integral
    }

    /// Adds the waves beyond the last lateral number, ky > `last` \[1/m\], with the same quadrature across.
    fn add_lateral_rest(&self, influence: &mut CellInfluence, around: &Around<'_>, last: f64) {
        let (grid, across) = (around.grid, influence.across);
        let factor = 4.0 / (PI * grid.pitch() * grid.pitch() * last);
        let mut ring = Ring::new(grid.elements());
        for [u, weight] in on_unit() {
            let ky = last / u;
            let mut row = around.sum(&mut ring, |n| self.compliance(grid.waves().kx(n), ky));
            add_mean(&mut row, self.rest(around, ky));
            for (cells, value) in influence.toeplitz.chunks_exact_mut(across).zip(row) {
                add_mean(cells, factor * weight * value);
            }
        }
    }
}

/// Gauss nodes and weights on (0, 1).
pub(super) fn on_unit() -> impl Iterator<Item = [f64; 2]> {
    legendre::gauss(TAIL_POINTS).into_iter().map(|[x, weight]| [0.5 * (1.0 + x), 0.5 * weight])
}

/// Sum over the wavenumbers round the tyre.
pub(super) struct Around<'a> {
    pub(super) grid: &'a CellGrid,
    /// Largest n of the explicit sum.
    pub(super) last: i64,
    /// True if the sum ends with `last`, which then counts once: without its mirror -n and without a tail.
    pub(super) truncated: bool,
    pub(super) columns: usize,
}

impl Around<'_> {
    /// Wavenumber at which the explicit sum ends, between two waves \[1/m\].
    pub(super) fn highest(&self) -> f64 {
        self.grid.waves().kx(self.last) + 0.5 * self.grid.waves().kx(1)
    }

    /// Sum over n of (1/L) sinc^2(kx dx/2) cos(kx i dx) of a compliance, i = 0..columns.
    pub(super) fn sum(&self, ring: &mut Ring, mut compliance: impl FnMut(i64) -> f64) -> Vec<f64> {
        let elements = self.grid.elements();
        let mut folded = vec![0.0; elements / 2 + 1];
        for n in 0..=self.last {
            let place = n as usize % elements;
            let place = place.min(elements - place);
            // The ring counts each of its numbers twice, but 0 and N/2 once; a compliance counts for n and -n.
            let alone = place == 0 || place == elements / 2;
            let once = n == 0 || self.truncated && n == self.last;
            let value = self.grid.longitudinal_weight(n) * compliance(n);
            folded[place] += if alone && !once { 2.0 * value } else { value };
        }
        ring.elements_of(|n| folded[n])[..self.columns].to_vec()
    }

    /// Adds the odd part O of a wave n >= 0 to the number of the ring onto which it folds. Numbers 0 and N/2 stand for
    /// both signs, whose odd parts cancel.
    pub(super) fn fold_odd(&self, folded: &mut [f64], n: i64, odd: f64) {
        let elements = self.grid.elements();
        let place = n as usize % elements;
        let mirrored = elements - place;
        let value = self.grid.longitudinal_weight(n) * odd;
        match place {
            0 => {}
            _ if place < mirrored => folded[place] += value,
            _ if place > mirrored => folded[mirrored] -= value,
            _ => {}
        }
    }
}

/// Values of a wave at many s. A type, not a closure: see `lane_sum`.
struct WaveSum<'a> {
    wave: &'a CellWave,
    turns: bool,
    at: &'a [&'a KernelAt],
    values: &'a mut Vec<FaceValues>,
}

impl WithSimd for WaveSum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for group in self.at.chunks(S::F64_LANES) {
            let members: [_; MOST_LANES] = std::array::from_fn(|lane| group[lane.min(group.len() - 1)]);
            let kernel = LaneKernel::new(simd, members);
            let mut sums = [FaceValues::default(); MOST_LANES];
            if self.turns {
                // Odd parts of a wave that is its own mirror cancel.
                let sides = if self.wave.is_mirror { 0.0 } else { 1.0 };
                for &(n, m, weight) in &self.wave.terms {
                    let faces = kernel.driven_parts(n.abs(), m, true);
                    let [surface, bottom] = faces.map(|face| [face.even.to_array(), face.odd.to_array()]);
                    let odd_weight = weight * sides * n.signum() as f64;
                    for (lane, sum) in sums.iter_mut().enumerate() {
                        sum.driven += weight * surface[0][lane];
                        sum.bottom += weight * bottom[0][lane];
                        sum.odd[0] += odd_weight * surface[1][lane];
                        sum.odd[1] += odd_weight * bottom[1][lane];
                        sum.evaluations += 1;
                    }
                }
            } else {
                for &(n, m, weight) in &self.wave.terms {
                    let both = kernel.normal(n, m);
                    let faces = both.surface.to_array().into_iter().zip(both.bottom.to_array());
                    for (sum, (surface, bottom)) in sums.iter_mut().zip(faces) {
                        sum.driven += weight * surface;
                        sum.bottom += weight * bottom;
                        sum.evaluations += 1;
                    }
                }
            }
            self.values.extend_from_slice(&sums[..group.len()]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DEFAULT, Scene};
    use crate::tyre::influence::{InfluenceSum, Projection, Truncation};

    const ELEMENTS: usize = 32;
    const TIME_STEP: f64 = 2e-4;

    /// The default tyre at 250 km/h.
    fn turning() -> Tyre {
        let tyre = Scene::from_str(DEFAULT, "scene").unwrap().scene.tyre;
        Tyre { angular_velocity: -250.0 / 3.6 / tyre.radius(), ..tyre }
    }

    fn sums(tyre: &Tyre, across: usize, truncation: CellTruncation) -> CellSums {
        CellSums::new(tyre, CellGrid::new(tyre, ELEMENTS, across), truncation, 1e-8, 8.0 / TIME_STEP)
    }

    #[test]
    fn influence_when_turning_is_the_double_sum_over_signed_waves() {
        let (tyre, across, columns) = (turning(), 4, 9);
        let truncation = CellTruncation { lateral_terms: Some(6), aliases: Some(1) };
        let sums = sums(&tyre, across, truncation);
        let s = 1.5 / TIME_STEP;
        let influence = sums.instant(s, columns);
        let odd = influence.odd.as_ref().unwrap();
        let (grid, at) = (sums.grid(), sums.kernel.at(s.into()));
        let last = (ELEMENTS + ELEMENTS / 2) as i64;
        let exact = |distance: i64, j: usize, other: usize| {
            let mut sum = Complex64::ZERO;
            for n in -last..=last {
                let turn = Complex64::cis(grid.waves().kx(n) * grid.length() * distance as f64);
                // The last wave and its mirror are one on the ring: each counts half.
                let once = if n.abs() == last { 0.5 } else { 1.0 };
                for m in 0..=6 {
                    let shapes = grid.waves().lateral_norm(m) * grid.shape(m, j) * grid.shape(m, other);
                    sum += once * grid.longitudinal_weight(n) * shapes * turn * at.full(n, m)[2][2];
                }
            }
            sum
        };
        let (mut largest, scale) = (0.0_f64, exact(0, 1, 1).re);
        for (distance, j, other) in [(0_i64, 0, 0), (1, 0, 3), (-1, 0, 3), (3, 1, 2), (-3, 1, 2), (8, 3, 3), (-8, 3, 3)]
        {
            let (along, sign) = (distance.unsigned_abs() as usize, distance.signum() as f64);
            let [free, image] = [along * across + usize::abs_diff(j, other), along * (2 * across - 1) + j + other];
            let skew = sign * (odd.toeplitz[free] + odd.hankel[image]);
            let found = influence.toeplitz[free] + influence.hankel[image] + skew;
            let exact = exact(distance, j, other);
            assert!((found - exact).norm() < 1e-9 * scale, "{distance} {j} {other}: {found:e} {exact:e}");
            largest = largest.max(skew.abs() / scale);
        }
        println!("skew part {largest:.1e} of the influence of a cell on itself");
        assert!(largest > 1e-4, "{largest:e}");
        let still = Tyre { angular_velocity: 0.0, ..tyre.clone() };
        assert!(self::sums(&still, across, truncation).instant(s, columns).odd.is_none());
        assert!(sums.instant(0.0, columns).odd.is_none());
    }

    #[test]
    fn waves_of_one_cell_across_add_up_to_those_of_slices() {
        let tyre = turning();
        let first = CellGrid::new(&tyre, ELEMENTS, 1).waves().first_lateral_number();
        let sums = sums(&tyre, 1, CellTruncation { lateral_terms: Some(first + 6), aliases: Some(1) });
        let fixed = Truncation::Fixed { lateral_terms: Some(4), aliases: Some(1) };
        let slices = InfluenceSum::with(&tyre, Projection::new(&tyre, ELEMENTS), fixed, 1e-8, 8.0 / TIME_STEP);
        let rows = sums.waves(WaveBand::WHOLE);
        let mut odd_share = 0.0_f64;
        for s in [Complex64::new(1.5 / TIME_STEP, 0.0), Complex64::new(300.0, 2e3), Complex64::new(0.0, 2e4)] {
            for n in 0..=ELEMENTS / 2 {
                let slice = slices.value(n, &slices.at(s), Field::Surface);
                let mut cell = [Complex64::ZERO; 2];
                for row in &rows {
                    let mut values = Vec::new();
                    sums.values(&row.waves[n], [&sums.at(s)], &mut values);
                    let shape = sums.grid().shape(row.m, 0).powi(2);
                    cell[0] += shape * values[0].driven;
                    cell[1] += shape * values[0].odd[0];
                }
                let scale = 1e-10 * slice.value.norm();
                let [even, odd] = [cell[0] - slice.value, cell[1] - slice.odd].map(|error| error.norm());
                assert!(even < scale && odd < scale, "{n} {s}: {cell:?} {slice:?}");
                odd_share = odd_share.max(slice.odd.norm() / slice.value.norm());
                let ends = n == 0 || 2 * n == ELEMENTS;
                assert!(!ends || cell[1].norm() <= 0.0);
            }
        }
        assert!(odd_share > 1e-2, "{odd_share:e}");
    }

    #[test]
    fn waves_on_a_shorter_ring_are_as_long_as_those_of_the_tyre() {
        let (tyre, s) = (turning(), [Complex64::new(300.0, 2e3)]);
        // Every other wave of two thirds of the tyre is every third of the tyre.
        let [ring, whole] = [Some(32), None].map(|ring| {
            let grid = CellGrid::new(&tyre, 48, 4).on_ring(ring);
            CellSums::new(&tyre, grid, CellTruncation::default(), 1e-8, 8.0 / TIME_STEP)
        });
        let value = |sums: &CellSums, row: usize, n: usize| {
            let mut values = Vec::new();
            sums.values(&sums.waves(WaveBand::WHOLE)[row].waves[n], &s.map(|s| sums.at(s)), &mut values);
            [values[0].driven, values[0].odd[0]]
        };
        for (row, n) in [(3, 1), (3, 4), (5, 5), (7, 6)] {
            let (found, exact) = (value(&ring, row, 2 * n), value(&whole, row, 3 * n));
            for (found, exact) in found.into_iter().zip(exact) {
                assert!((found - 1.5 * exact).norm() <= 1e-9 * exact.norm(), "{row} {n}: {found:e} {exact:e}");
            }
            // Those between lie between.
            let near = [1, 2].map(|more| value(&whole, row, 3 * n + more)[0]);
            let (mean, apart) = (1.5 * (near[0] + near[1]) / 2.0, 1.5 * (near[0] - near[1]).norm());
            let found = value(&ring, row, 2 * n + 1)[0];
            assert!((found - mean).norm() < apart, "{row} {n}: {found:e} {mean:e} {apart:e}");
        }
    }

    #[test]
    #[ignore = "half a minute: prepares the waves of two tyres to 1e-12"]
    fn rotation_that_cells_leave_out_of_short_waves_is_small() {
        let tyre = turning();
        let still = Tyre { angular_velocity: 0.0, ..tyre.clone() };
        let (elements, across) = (512, 30);
        let time_step = tyre.circumference / elements as f64 / (250.0 / 3.6);
        let rate = 3.414 / time_step;
        // The curved kernel reaches shorter waves than the sums take with it.
        let kernels = [&tyre, &still].map(|tyre| Kernel::new(tyre, rate, 1e-12));
        let usual = Kernel::new(&tyre, rate, 1e-7).flat_from().unwrap();
        let longest = kernels[0].flat_from().unwrap();
        let grid = CellGrid::new(&tyre, elements, across);
        let waves = grid.waves();
        let (last_n, last_m) = ((longest / waves.kx(1)) as i64, (longest / waves.ky(1)) as usize);
        for s in [Complex64::new(rate, 0.0), Complex64::new(0.0, 2e3 * PI), Complex64::new(0.0, 6e3 * PI)] {
            let at = [&kernels[0], &kernels[1]].map(|kernel| kernel.at(s));
            let (mut even, mut odd, mut all) = (0.0, 0.0, Complex64::ZERO);
            for m in 0..=last_m {
                for n in (-last_n..=last_n).step_by(3) {
                    let k = waves.kx(n).hypot(waves.ky(m));
                    if k >= longest {
                        continue;
                    }
                    let weight = 3.0 * grid.longitudinal_weight(n) * grid.lateral_weight(m);
                    let resting = at[1].normal(n, m, Field::Surface);
                    all += weight * resting;
                    if k > usual {
                        let Parts { even: turning, odd: turning_odd } = at[0].normal_parts(n.abs(), m, Field::Surface);
                        even += weight * (turning - resting).norm();
                        odd += weight * turning_odd.norm();
                    }
                }
            }
            let [even, odd] = [even, odd].map(|size: f64| size / all.norm());
            println!("from {usual:.0} to {longest:.0}/m at {s:.0}: even {even:.1e}, odd {odd:.1e} of all");
            assert!(even < 5e-4 && odd < 5e-4, "{s}: {even:e} {odd:e}");
        }
    }
}
