//! C_zz of the tread's surface wave by wave, over frequency: for a field on the whole tread, where its mean over the
//! contact strip is not enough.
//!
//! A wave is evaluated at frequencies of equal distance in asinh(f/[`LINEAR_BELOW`]), and 1/C_zz is interpolated
//! between them by cubics: where the wave resonates C is sharp and 1/C, a stiffness, nearly a parabola. Between
//! resonances it is the other way round, but there C is small. With [`STEP`] the error is below 1e-3 of the wave's
//! largest value (measured; the test bounds it).
//!
//! With rotation, there is a second table, of -n: C_-n(i w) is conj C_n(-i w).

use std::convert::Infallible;

use num_complex::{Complex32, Complex64};
use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::flank_waves::{self, ByEdge, FlankWaves, PIECES};
use super::kernel::{Kernel, KernelAt, LaneKernel};
use super::parts::Parts;
use super::waves::Waves;
use crate::numeric::lagrange::uniform_cubic;
use crate::numeric::lanes::dispatch;
use crate::numeric::{Lanes, MOST_LANES, SplitRule};
use crate::scene::Tyre;
use crate::storage::{Cache, CacheKind, Cached, Format};
use crate::tyre::layers::curved::sidewall_waves;
use crate::tyre::layers::cylinder::EdgeMotion;

/// Frequency below which the points are at equal distances, above at equal ratios \[Hz\].
const LINEAR_BELOW: f64 = 100.0;
/// Distance of the points in asinh(f/[`LINEAR_BELOW`]).
const STEP: f64 = 0.02;

/// C_zz of the waves with n = 0..=`most_around` and some lateral numbers: those that a centred strip excites, or all.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(crate) struct SurfaceWaves {
    /// Wavenumbers of the waves.
    pub waves: Waves,
    /// Lateral numbers m.
    pub lateral: Vec<usize>,
    /// Number of waves round the tyre, n = 0 included.
    around: usize,
    /// Number of frequencies.
    points: usize,
    /// 1/C_zz by n, m, frequency \[Pa/m\].
    stiffnesses: Vec<Complex64>,
    /// Those of the waves -n; empty at rest.
    backwards: Vec<Complex64>,
    /// Flow of the sidewalls, if asked for.
    flank: Option<FlankWaves>,
}

impl SurfaceWaves {
    /// The first lateral numbers that a centred strip excites; else as [`Self::of`].
    #[cfg(test)]
    pub(crate) fn new(tyre: &Tyre, most_around: usize, lateral_waves: usize, highest: f64, tolerance: f64) -> Self {
        let lateral = Waves::new(tyre).lateral_numbers().take(lateral_waves).collect();
        Self::of(tyre, most_around, lateral, highest, tolerance)
    }

    /// For frequencies from 0 to `highest` \[Hz\]; compliances within a relative `tolerance`.
    #[cfg(test)]
    pub(crate) fn of(tyre: &Tyre, most_around: usize, lateral: Vec<usize>, highest: f64, tolerance: f64) -> Self {
        Self::with_flank(tyre, most_around, lateral, [highest, tolerance], None)
    }

    /// As `of`, with the flow of the sidewalls in pieces by a rule, for a tyre that has them as arcs.
    pub(crate) fn with_flank(
        tyre: &Tyre,
        most_around: usize,
        lateral: Vec<usize>,
        [highest, tolerance]: [f64; 2],
        rule: Option<&SplitRule>,
    ) -> Self {
        let points = frequencies(highest).len();
        let angular = |point: usize| std::f64::consts::TAU * frequency(point);
        let kernel = Kernel::new(tyre, angular(points), tolerance);
        let waves = Waves::new(tyre);
        let at: Vec<KernelAt> = (0..points).map(|point| kernel.at(Complex64::new(0.0, angular(point)))).collect();
        let around = most_around + 1;
        let width = lateral.len() * points;
        let mut stiffnesses = vec![Complex64::ZERO; around * width];
        let mut backwards = vec![Complex64::ZERO; if at[0].turns() { around * width } else { 0 }];
        let by_edge = rule.map(|rule| flank_waves::by_edge(&at, rule, most_around));
        let mut flank = by_edge.as_ref().map(|by_edge| FlankWaves::new(by_edge, lateral.len(), at[0].turns()));
        // One row of each table per n; rows that do not exist are None.
        let flows = flank.as_mut().map_or_else(Vec::new, FlankWaves::rows);
        let backwards_of_waves = backwards.chunks_mut(width).map(Some).chain(std::iter::repeat_with(|| None));
        let flows_of_waves = flows.into_iter().map(Some).chain(std::iter::repeat_with(|| None));
        let rows: Vec<_> = stiffnesses.chunks_mut(width).zip(backwards_of_waves).zip(flows_of_waves).collect();
        rows.into_par_iter().enumerate().for_each(|(n, ((rows, backwards), flows))| {
            let flank = by_edge.as_deref().zip(flows).map(|(by_edge, rows)| FlankRows { waves, by_edge, rows });
            let backwards = backwards.unwrap_or_default();
            dispatch(FieldRows { n: n as i64, lateral: &lateral, at: &at, rows, backwards, flank });
        });
        Self { waves, lateral, around, points, stiffnesses, backwards, flank }
    }

    /// From the cache, and true, if they are there; else computed and stored. Faults of the cache give warnings alone.
    pub(crate) fn fetch(
        cache: &Cache,
        tyre: &Tyre,
        most_around: usize,
        lateral: Vec<usize>,
        [highest, tolerance]: [f64; 2],
        rule: Option<&SplitRule>,
        warnings: &mut Vec<String>,
    ) -> (Self, bool) {
        let split = rule.map(|rule| rule.split);
        let key =
            crate::storage::cache::key::<Self>(&(tyre.levelled(), most_around, &lateral, highest, tolerance, split));
        let mut known = true;
        let make = || {
            known = false;
            Ok::<_, Infallible>(Self::with_flank(tyre, most_around, lateral, [highest, tolerance], rule))
        };
        let Ok(waves) = match key {
            Ok(key) => cache.fetch(&key, warnings, make),
            Err(_) => make(),
        };
        (waves, known)
    }

    /// Number of pieces of a sidewall whose flow is known; 0 without any.
    pub(crate) fn pieces(&self) -> usize {
        if self.flank.is_some() { PIECES } else { 0 }
    }

    /// Bytes of the flow of a tyre's sidewalls, for so many lateral numbers and a highest frequency \[Hz\].
    pub(crate) fn flank_bytes(tyre: &Tyre, most_around: usize, lateral: usize, highest: f64) -> f64 {
        let around = (most_around + 1).min(sidewall_waves(tyre));
        flank_waves::bytes(around, lateral, coordinate(highest) / STEP + 4.0, tyre.turns())
    }

    /// Bytes of a table on disk, with the flow of sidewalls where they are asked for; `highest` in Hz.
    pub(crate) fn stored_bytes(tyre: &Tyre, most_around: usize, lateral: usize, highest: f64, has_flow: bool) -> f64 {
        let points = coordinate(highest) / STEP + 3.0;
        let around = most_around + 1;
        let flows = if has_flow { PIECES * around.min(sidewall_waves(tyre)) } else { 0 };
        let values = around * size_of::<Complex64>() + flows * size_of::<Complex32>();
        let ways = if tyre.turns() { 2.0 } else { 1.0 };
        ways * (values * lateral) as f64 * points
    }

    /// Evaluations of the compliance that the table took; one gives n and -n.
    pub(crate) fn evaluations(&self) -> u64 {
        self.stiffnesses.len() as u64
    }

    /// Evaluations of the compliance that a table will take; `highest` in Hz.
    pub(crate) fn expected_evaluations(most_around: usize, lateral_waves: usize, highest: f64) -> f64 {
        (most_around as f64 + 1.0) * lateral_waves as f64 * (coordinate(highest) / STEP + 3.0)
    }

    /// Writes C_zz \[m/Pa\] of the lateral numbers of a wave of n periods, n of either sign, at a frequency \[Hz\] of
    /// either sign into `out`; zero for waves and frequencies beyond the table.
    pub(crate) fn at(&self, n: i64, frequency: f64, out: &mut [Complex64]) {
        let table = if self.run_backwards(n, frequency) { &self.backwards } else { &self.stiffnesses };
        let Some((n, first, weights)) = self.place(n, frequency) else {
            out.fill(Complex64::ZERO);
            return;
        };
        for (index, value) in out.iter_mut().enumerate() {
            let row = (n * self.lateral.len() + index) * self.points + first;
            let known = table[row..row + 4].iter().zip(weights);
            let compliance = known.map(|(value, weight)| value * weight).sum::<Complex64>().inv();
            *value = if frequency < 0.0 { compliance.conj() } else { compliance };
        }
    }

    /// True if a wave is in the table of -n: C_n(-i w) = conj C_-n(i w).
    fn run_backwards(&self, n: i64, frequency: f64) -> bool {
        (n < 0) != (frequency < 0.0) && !self.backwards.is_empty()
    }

    /// |n|, the first of the four frequencies about the one given, and their weights; `None` beyond the table.
    fn place(&self, n: i64, frequency: f64) -> Option<(usize, usize, [f64; 4])> {
        let n = n.unsigned_abs() as usize;
        let (first, weights) = neighbours(frequency.abs());
        (n < self.around && first + 4 <= self.points).then_some((n, first, weights))
    }

    /// Writes the flow of each piece of a sidewall, per radian and traction on the tread \[m^3/Pa\], for the lateral
    /// numbers of a wave whose C_zz are given, m by m, at a frequency \[Hz\] of either sign.
    pub(crate) fn flows_at(&self, n: i64, frequency: f64, compliances: &[Complex64], out: &mut [Complex64]) {
        let Some((flank, (wave, first, weights))) = self.flank.as_ref().zip(self.place(n, frequency)) else {
            out.fill(Complex64::ZERO);
            return;
        };
        let runs_backwards = self.run_backwards(n, frequency);
        for (index, (out, compliance)) in out.chunks_exact_mut(PIECES).zip(compliances).enumerate() {
            let ratios = flank.at([wave, index], runs_backwards, first, &weights);
            for (out, ratio) in out.iter_mut().zip(ratios) {
                *out = compliance * if frequency < 0.0 { ratio.conj() } else { ratio };
            }
        }
    }
}

impl Cached for SurfaceWaves {
    const KIND: CacheKind =
        CacheKind { extension: "waves", format: Format { magic: b"TWAVESRF", version: 1, name: "waves of a tread" } };

    fn is_valid(&self) -> bool {
        let numbers = self.around * self.lateral.len() * self.points;
        let values = self.stiffnesses.iter().chain(&self.backwards);
        self.stiffnesses.len() == numbers
            && [0, numbers].contains(&self.backwards.len())
            && values.into_iter().all(|value| !value.is_nan())
            && self.flank.as_ref().is_none_or(FlankWaves::is_valid)
    }
}

/// Frequency of a point \[Hz\].
fn frequency(point: usize) -> f64 {
    LINEAR_BELOW * (point as f64 * STEP).sinh()
}

/// Frequencies up to the first at or above a highest one, and two more for the cubics \[Hz\].
pub(super) fn frequencies(highest: f64) -> impl ExactSizeIterator<Item = f64> {
    (0..(coordinate(highest) / STEP).ceil() as usize + 3).map(frequency)
}

/// The first of the four frequencies about one that is not negative \[Hz\], and their weights.
pub(super) fn neighbours(frequency: f64) -> (usize, [f64; 4]) {
    let place = coordinate(frequency) / STEP;
    let first = (place as usize).saturating_sub(1);
    (first, uniform_cubic(place - first as f64))
}

/// asinh(f/[`LINEAR_BELOW`]) of a frequency that is not negative: the library's function is more exact for very small
/// ones only, and takes longer.
fn coordinate(frequency: f64) -> f64 {
    let ratio = frequency / LINEAR_BELOW;
    (ratio + (ratio * ratio + 1.0).sqrt()).ln()
}

/// All frequencies of the waves of one n. A type, not a closure: see `lane_sum`.
struct FieldRows<'a> {
    n: i64,
    lateral: &'a [usize],
    at: &'a [KernelAt],
    rows: &'a mut [Complex64],
    /// Those of -n; empty at rest.
    backwards: &'a mut [Complex64],
    flank: Option<FlankRows<'a>>,
}

/// Flow of the sidewalls in the waves of one n.
struct FlankRows<'a> {
    waves: Waves,
    /// By frequency.
    by_edge: &'a [ByEdge],
    rows: [&'a mut [Complex32]; 2],
}

impl WithSimd for FieldRows<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let points = self.at.len();
        for (group, at) in self.at.chunks(S::F64_LANES).enumerate() {
            let members: [_; MOST_LANES] = std::array::from_fn(|lane| &at[lane.min(at.len() - 1)]);
            let kernel = LaneKernel::new(simd, members);
            for (index, &m) in self.lateral.iter().enumerate() {
                let first = index * points + group * S::F64_LANES;
                if let Some(FlankRows { waves, by_edge, rows }) = &mut self.flank
                    && let Some(edge) = kernel.edge_both_ways(self.n, m)
                {
                    let motion = edge.map(|motion| {
                        let [surface, radial, circumferential] =
                            [motion.surface, motion.radial, motion.circumferential].map(Lanes::to_array);
                        std::array::from_fn(|lane| EdgeMotion {
                            surface: surface[lane],
                            radial: radial[lane],
                            circumferential: circumferential[lane],
                        })
                    });
                    let by_edge = &by_edge[group * S::F64_LANES..];
                    flank_waves::put(rows, *waves, [self.n as usize, m], first..first + at.len(), by_edge, motion);
                }
                if !self.backwards.is_empty() {
                    let [Parts { even, odd }, _] = kernel.driven_parts(self.n, m, true);
                    let parts = even.to_array().into_iter().zip(odd.to_array());
                    let rows = self.rows[first..].iter_mut().zip(&mut self.backwards[first..]);
                    for ((row, backwards), (even, odd)) in rows.zip(parts).take(at.len()) {
                        let turned = Complex64::i() * odd;
                        (*row, *backwards) = ((even + turned).inv(), (even - turned).inv());
                    }
                    continue;
                }
                let surface = kernel.normal(self.n, m).surface.to_array();
                for (row, compliance) in self.rows[first..first + at.len()].iter_mut().zip(surface) {
                    *row = compliance.inv();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DEFAULT, PLATE, Scene};

    #[test]
    fn interpolated_waves_are_those_of_the_kernel() {
        for (scene, angular_velocity) in [(PLATE, 0.0), (DEFAULT, 0.0), (DEFAULT, -100.0)] {
            let tyre = Scene::from_str(scene, "scene").unwrap().scene.tyre;
            let tyre = Tyre { angular_velocity, ..tyre };
            let table = SurfaceWaves::new(&tyre, 60, 3, 2500.0, 1e-7);
            let kernel = Kernel::new(&tyre, 2e4, 1e-7);
            let mut values = [Complex64::ZERO; 3];
            for n in [0, 1, 6, 60] {
                let largest: Vec<f64> = (0..3)
                    .map(|index| {
                        let row = (n * 3 + index) * table.points;
                        table.stiffnesses[row..row + table.points].iter().fold(0.0_f64, |a, b| a.max(b.inv().norm()))
                    })
                    .collect();
                let signs = if tyre.turns() { &[1, -1][..] } else { &[-1] };
                let frequencies = [0.0, 13.7, 67.9, 91.3, -108.8, 108.8, 333.3, 1001.7, -2499.0];
                for (n, frequency) in signs.iter().flat_map(|sign| frequencies.map(|f| (sign * n as i64, f))) {
                    table.at(n, frequency, &mut values);
                    let at = kernel.at(Complex64::new(0.0, std::f64::consts::TAU * frequency));
                    for ((value, &m), largest) in values.iter().zip(&table.lateral).zip(&largest) {
                        let exact = at.normal(n, m, crate::tyre::influence::Field::Surface);
                        let error = (value - exact).norm() / largest;
                        assert!(error < 1e-3, "{angular_velocity}/s, n = {n}, m = {m}, {frequency} Hz: {error:.1e}");
                    }
                }
            }
            table.at(61, 100.0, &mut values);
            assert_eq!(values, [Complex64::ZERO; 3]);
        }
    }

    #[test]
    fn the_size_on_disk_is_known_beforehand() {
        for angular_velocity in [0.0, -100.0] {
            let tyre = Tyre { angular_velocity, ..Scene::from_str(DEFAULT, "scene").unwrap().scene.tyre };
            let table = SurfaceWaves::new(&tyre, 20, 2, 900.0, 1e-4);
            let found = postcard::to_extend(&table, Vec::new()).unwrap().len() as f64;
            let planned = SurfaceWaves::stored_bytes(&tyre, 20, 2, 900.0, false);
            assert!((planned / found - 1.0).abs() < 0.02, "{planned} for {found}");
        }
    }
}
