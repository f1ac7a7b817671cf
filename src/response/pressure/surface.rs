//! G on the tread, and its integrals with the tread's waves.
//!
//! G is known as means over cells round the tyre, at Gauss points across half of the width, at some frequencies: its
//! even part, which is all that a centred contact strip meets, and, for forces that are resolved across, its odd part,
//! which waves that are odd about mid-width meet; and likewise on the rings of a flank that moves. With the delay r0/c
//! removed it is smooth over frequency and interpolated by cubics.
//!
//! Where air passes through the patch the field has steps of the grooves' widths there: on those cells it is known
//! strip by strip across the whole width, in place of the points.

use std::ops::Range;
use std::sync::Arc;

use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use rustfft::{Fft, FftPlanner};

use crate::numeric::{double, lagrange, legendre, sinc, single};
use crate::radiation::transfer::{across_points, contact_distance, half_tread};
use crate::radiation::{RadiatingBody, SurfaceTransfer, TransferSet};
use crate::response::vibration::SegmentLayout;
use crate::tyre::influence::Waves;

/// G of one receiver.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SurfaceGreen {
    /// Frequencies, rising \[Hz\].
    pub frequencies: Vec<f64>,
    /// Cells round the whole tyre; the first begins under the axle, the others follow in the rolling direction.
    pub around: usize,
    /// Distances from mid-width \[m\], rising; each part of G is the interpolation polynomial through its values there.
    pub across: Vec<f64>,
    /// Half of the tread's width \[m\].
    pub half_width: f64,
    /// Rings of the flank, whose rows follow those of the points across.
    pub rings: usize,
    /// G exp(i k r0) by frequency, point by point and ring by ring, cell by cell \[1/m\]: the even part, and after it
    /// the odd one where it is known.
    pub values: Vec<Vec<Complex32>>,
    /// G under the patch and beside it, where air goes through grooves.
    pub under_patch: Option<UnderPatch>,
}

/// G under an open patch, in place of that at the points across.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct UnderPatch {
    /// Number of cells to either side of the contact's centre where it holds.
    pub cells: usize,
    /// Ends of the strips across the whole width, rising \[m\].
    pub ends: Vec<f64>,
    /// G exp(i k r0) by frequency, cell by cell from the rearmost on, strip by strip \[1/m\].
    pub values: Vec<Vec<Complex32>>,
}

/// Shape across of a part of the tyre's motion that is a wave round the tyre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    /// The tread's wave of a lateral number.
    Tread(usize),
    /// A strip of the tread between two distances from mid-width \[m\], positive to the left, that moves as one.
    Strip([f64; 2]),
    /// Rings of a number on both sides, whose flow is equal or, if `odd`, opposite.
    Ring { number: usize, odd: bool },
}

impl SurfaceGreen {
    /// From the transfers of a body's tread to one receiver at rising frequencies \[Hz\], computed for one side or
    /// both.
    pub(crate) fn of(body: &RadiatingBody, known: impl IntoIterator<Item = (f64, SurfaceTransfer)>) -> Self {
        let half_width = half_tread(body);
        let (frequencies, across, values) = (Vec::new(), Vec::new(), Vec::new());
        let mut green = Self { frequencies, around: 0, across, half_width, rings: 0, values, under_patch: None };
        for (frequency, transfer) in known {
            if green.frequencies.is_empty() {
                green.around = transfer.grid.around;
                green.rings = transfer.rows() - transfer.grid.across;
                green.across = across_points(half_width, transfer.grid.across).into_iter().map(|[y, _]| y).collect();
            }
            let turn = Complex64::from_polar(1.0, transfer.wavenumber * contact_distance(body, transfer.receiver));
            let mut values = transfer.values;
            values.iter_mut().for_each(|value| *value = single(turn * double(*value)));
            if transfer.sides == 2 {
                let half = values.len() / 2;
                let (left, right) = values.split_at_mut(half);
                for (left, right) in left.iter_mut().zip(right) {
                    (*left, *right) = (0.5 * (*left + *right), 0.5 * (*left - *right));
                }
            }
            green.frequencies.push(frequency);
            green.values.push(values);
        }
        green
    }

    /// From a set of transfers, for each of its receivers.
    pub(crate) fn of_set(body: &RadiatingBody, set: TransferSet) -> Vec<Self> {
        let mut by_receiver = Vec::new();
        for found in set.into_frequencies() {
            by_receiver.resize_with(found.transfers.len(), Vec::new);
            for (known, transfer) in by_receiver.iter_mut().zip(found.transfers) {
                known.push((found.frequency, transfer));
            }
        }
        // Takes the set apart: each receiver's transfers become its values in place.
        by_receiver.into_par_iter().map(|known| Self::of(body, known)).collect()
    }
}

/// Weights of G: 1, and 1 - cos(theta) with the angle theta = 2 pi x/L from the contact. Each turns the wave n into the
/// waves n - 1, n and n + 1, times these factors.
pub(super) const WEIGHTS: [[f64; 3]; 2] = [[0.0, 1.0, 0.0], [-0.5, 1.0, -0.5]];

/// Int G exp(i kx_n x) cos(ky_m y) dS over the tread for the waves of a tyre, n by n, m by m, weight by weight; for
/// waves that are odd about mid-width with sin(ky_m y) \[m\]; for rings 2 Int G exp(i n theta) dtheta \[1/m\], for a
/// flow per radian; for strips the integral along of G's mean across \[1\], for a flow per length.
pub(super) struct WaveIntegrals {
    /// Largest |n|: as far as the cells distinguish waves.
    most_around: usize,
    /// By shape, the first row of G that it meets, and the weights of the rows from there on.
    shapes: Vec<(usize, Vec<f64>)>,
    /// By shape of the tread, its integrals over the strips of an open patch, or their shares of it; empty for rings,
    /// and for a sealed patch.
    strips: Vec<Vec<f64>>,
    /// Number of [`WEIGHTS`] in use.
    weights: usize,
    /// By n, the wave's mean over a cell that begins at x = 0, times the cell's length \[m\]; one n beyond the largest
    /// at either end.
    means: Vec<Complex64>,
    transform: Arc<dyn Fft<f64>>,
}

impl WaveIntegrals {
    /// Plans integrals with waves of these shapes and the first `weights` of [`WEIGHTS`], for every G with the cells
    /// and points of `green`.
    pub(super) fn new(green: &SurfaceGreen, waves: Waves, shapes: &[Shape], weights: usize) -> Self {
        let SurfaceGreen { around, across, half_width, rings, .. } = green;
        let rows = |odd: bool| if odd { across.len() + rings } else { 0 };
        let half = *around as i64 / 2;
        let length = waves.circumference / *around as f64;
        let mean = |n: i64| {
            let half = 0.5 * waves.kx(n) * length;
            Complex64::from_polar(length * sinc(half), half)
        };
        let strips = |shape: &Shape| match (shape, &green.under_patch) {
            (&Shape::Tread(m), Some(patch)) => strip_weights(!waves.is_even(m), &patch.ends, waves.ky(m)),
            (&Shape::Strip(ends), Some(patch)) => strip_shares(ends, &patch.ends),
            _ => Vec::new(),
        };
        Self {
            strips: shapes.iter().map(strips).collect(),
            most_around: around / 2 - 1,
            // The weights cover both halves of the width.
            shapes: shapes
                .iter()
                .map(|&shape| match shape {
                    Shape::Tread(m) => {
                        let odd = !waves.is_even(m);
                        let wave = if odd { f64::sin } else { f64::cos };
                        (rows(odd), wave_weights(wave, across, *half_width, waves.ky(m)))
                    }
                    Shape::Strip(ends) => (0, strip_means(ends, across, *rings)),
                    Shape::Ring { number, odd } => {
                        (rows(odd) + across.len() + number, vec![2.0 * std::f64::consts::TAU / waves.circumference])
                    }
                })
                .collect(),
            weights,
            means: (-half..=half).map(mean).collect(),
            transform: FftPlanner::new().plan_fft_inverse(*around),
        }
    }

    /// Largest |n|.
    pub(super) fn most_around(&self) -> usize {
        self.most_around
    }

    /// Largest |n| that the elements distinguish, too.
    pub(super) fn most_under(&self, layout: &SegmentLayout) -> usize {
        self.most_around.min(layout.elements / 2 - 1)
    }

    /// Integral of a wave over the first cell \[m\]; |n| may exceed the largest by one.
    pub(super) fn mean(&self, n: i64) -> Complex64 {
        self.means[(n + self.most_around as i64 + 1) as usize]
    }

    /// Number of integrals per wavenumber.
    pub(super) fn of_wave(&self) -> usize {
        self.shapes.len() * self.weights
    }

    /// Number of integrals per receiver and frequency.
    pub(super) fn count(&self) -> usize {
        (2 * self.most_around + 1) * self.of_wave()
    }

    /// Buffers for the work on a receiver: cells, scratch of their transform, and waves.
    pub(super) fn buffers(&self) -> [Vec<Complex64>; 3] {
        let scratch = self.transform.get_inplace_scratch_len();
        [self.transform.len(), scratch, self.means.len()].map(|length| vec![Complex64::ZERO; length])
    }

    /// Integrals of a receiver at G's frequency of an index.
    pub(super) fn of(
        &self,
        green: &SurfaceGreen,
        frequency: usize,
        [cells, scratch, waves]: &mut [Vec<Complex64>; 3],
        integrals: &mut [Complex32],
    ) {
        let half = green.around / 2;
        for index in 0..self.shapes.len() {
            // 1. Across the tread, then the transform round it.
            self.across(green, frequency, index, cells);
            self.transform.process_with_scratch(cells, scratch);
            // From n = -around/2 on: the transform has negative numbers behind the others.
            let turned = cells[half..].iter().chain(&cells[..=half]);
            for ((wave, mean), cell) in waves.iter_mut().zip(&self.means).zip(turned) {
                *wave = mean * cell;
            }
            // 2. Each weight combines neighbouring waves.
            for (out, near) in integrals.chunks_exact_mut(self.of_wave()).zip(waves.windows(3)) {
                let out = &mut out[index * self.weights..][..self.weights];
                for (out, factors) in out.iter_mut().zip(WEIGHTS) {
                    *out = single(near.iter().zip(factors).map(|(wave, factor)| wave * factor).sum());
                }
            }
        }
    }

    /// Int G cos(ky_m y) dy, or sin, across the tread of the shape of an index, cell by cell \[1\]; of a ring 2 G/R, of
    /// a strip G's mean across \[1/m\].
    pub(super) fn across(&self, green: &SurfaceGreen, frequency: usize, index: usize, cells: &mut [Complex64]) {
        cells.fill(Complex64::ZERO);
        let (first, weights) = &self.shapes[index];
        let part = green.values[frequency].chunks_exact(green.around).skip(*first);
        for (points, weight) in part.zip(weights) {
            for (cell, value) in cells.iter_mut().zip(points) {
                cell.re += weight * f64::from(value.re);
                cell.im += weight * f64::from(value.im);
            }
        }
        let strips = &self.strips[index];
        let Some(patch) = green.under_patch.as_ref().filter(|_| !strips.is_empty()) else { return };
        let first = green.around - patch.cells;
        for (place, values) in patch.values[frequency].chunks_exact(strips.len()).enumerate() {
            let sum = strips.iter().zip(values).map(|(weight, value)| weight * double(*value)).sum();
            cells[(first + place) % green.around] = sum;
        }
    }
}

/// Int cos(k y) dy, or sin, over each strip across \[m\].
fn strip_weights(odd: bool, ends: &[f64], k: f64) -> Vec<f64> {
    let strip = |ends: &[f64]| {
        let (middle, length) = (0.5 * (ends[0] + ends[1]), ends[1] - ends[0]);
        let wave = if odd { (k * middle).sin() } else { (k * middle).cos() };
        wave * sinc(0.5 * k * length) * length
    };
    ends.windows(2).map(strip).collect()
}

/// Share of each strip in the mean over an interval across.
fn strip_shares([right, left]: [f64; 2], ends: &[f64]) -> Vec<f64> {
    let share = |ends: &[f64]| (ends[1].min(left) - ends[0].max(right)).max(0.0) / (left - right);
    ends.windows(2).map(share).collect()
}

/// Weights of all rows of G whose sum is its mean over an interval across: of the polynomials through its even part, of
/// rings, zero, and of the polynomials through its odd part.
fn strip_means([right, left]: [f64; 2], points: &[f64], rings: usize) -> Vec<f64> {
    let odd = points.len() + rings;
    let mut sums = vec![0.0; odd + points.len()];
    // Polynomials in |y|: each side of mid-width separately.
    for [from, to] in [[right, left.min(0.0)], [right.max(0.0), left]] {
        if to <= from {
            continue;
        }
        for [node, weight] in legendre::gauss(points.len()) {
            let y = 0.5 * (from + to) + 0.5 * (to - from) * node;
            let weight = 0.5 * weight * (to - from) / (left - right);
            for (point, share) in lagrange::weights(points, y.abs()).enumerate() {
                sums[point] += weight * share;
                sums[odd + point] += weight * share * y.signum();
            }
        }
    }
    sums
}

/// Int cos(k y) L_j(y) dy, or sin, over the whole width, of the polynomials L_j that are 1 at one point and 0 at the
/// others: weights that are exact for the product of such a polynomial, even or odd in y as the wave is, with the wave.
fn wave_weights(wave: fn(f64) -> f64, points: &[f64], half_width: f64, k: f64) -> Vec<f64> {
    // The product oscillates as often as the wave does within half of the width.
    let order = 16 + points.len() + (k * half_width) as usize;
    let mut sums = vec![0.0; points.len()];
    for [node, weight] in legendre::gauss(order) {
        let y = 0.5 * half_width * (1.0 + node);
        for (sum, share) in sums.iter_mut().zip(lagrange::weights(points, y)) {
            *sum += half_width * weight * wave(k * y) * share;
        }
    }
    sums
}

/// Up to four neighbours of a frequency and the weights of the cubic through them; frequencies outside count as the
/// nearest end.
pub(super) fn interpolation(frequencies: &[f64], frequency: f64) -> (Range<usize>, Vec<f64>) {
    let within = frequency.clamp(frequencies[0], frequencies[frequencies.len() - 1]);
    let near = lagrange::cubic_neighbours(frequencies, within);
    (near.clone(), lagrange::weights(&frequencies[near], within).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Sides;

    #[test]
    fn integrals_of_a_wave_with_itself_and_of_others_are_known() {
        let waves = Waves { circumference: 2.0, width: 0.2, sides: Sides::Guided };
        let mut across: Vec<f64> = legendre::gauss(8).into_iter().map(|[node, _]| 0.05 * (1.0 + node)).collect();
        across.reverse();
        let around = 64;
        // Means over cells of exp(-i kx_5 x) cos(ky_2 y).
        let [kx, ky] = [waves.kx(5), waves.ky(2)];
        let length = 2.0 / around as f64;
        let mean = (0.5 * kx * length).sin() / (0.5 * kx * length);
        let values = across.iter().flat_map(|y| {
            let wave = |cell: usize| Complex64::from_polar(mean, -kx * (cell as f64 + 0.5) * length);
            (0..around).map(move |cell| wave(cell) * (ky * y).cos())
        });
        let values = values.map(|value| Complex32::new(value.re as f32, value.im as f32)).collect();
        let green = SurfaceGreen {
            frequencies: vec![100.0],
            around,
            across: across.clone(),
            half_width: 0.1,
            rings: 0,
            values: vec![values],
            under_patch: None,
        };
        let integrals = WaveIntegrals::new(&green, waves, &[Shape::Tread(0), Shape::Tread(2)], 1);
        let mut out = vec![Complex32::ZERO; integrals.count()];
        integrals.of(&green, 0, &mut integrals.buffers(), &mut out);
        for (row, n) in (-(integrals.most_around() as i64)..).zip(out.chunks_exact(2)).map(|(n, row)| (row, n)) {
            let expected = if n == 5 { mean * mean * 0.5 * 2.0 * 0.2 } else { 0.0 };
            assert!((row[1] - expected as f32).norm() < 1e-6, "n = {n}: {}", row[1]);
            assert!(row[0].norm() < 1e-6, "n = {n}, m = 0: {}", row[0]);
        }
    }

    #[test]
    fn integrals_over_the_angle_are_those_over_the_cells() {
        let (waves, around) = (Waves { circumference: 2.0, width: 0.2, sides: Sides::Guided }, 16);
        let values: Vec<Complex32> =
            (0..around).map(|cell| Complex32::new(1.0 + cell as f32 % 3.0, (cell as f32).sin())).collect();
        let (frequencies, across) = (vec![100.0], vec![0.05]);
        let values_of = vec![values.clone()];
        let green = SurfaceGreen {
            frequencies,
            around,
            across,
            half_width: 0.1,
            rings: 0,
            values: values_of,
            under_patch: None,
        };
        let integrals = WaveIntegrals::new(&green, waves, &[Shape::Tread(0)], 2);
        let mut out = vec![Complex32::ZERO; integrals.count()];
        integrals.of(&green, 0, &mut integrals.buffers(), &mut out);
        assert_eq!(out.len(), 2 * 15);
        let weights: [fn(f64) -> f64; 2] = [|_| 1.0, |angle| 1.0 - angle.cos()];
        for (n, found) in (-7..=7).zip(out.chunks_exact(2)) {
            for (weight, found) in weights.iter().zip(found) {
                let mut expected = Complex64::ZERO;
                for (cell, value) in values.iter().enumerate() {
                    for [node, share] in legendre::gauss(8) {
                        let angle = std::f64::consts::TAU * (cell as f64 + 0.5 + 0.5 * node) / around as f64;
                        let area = 0.5 * share * 2.0 / around as f64 * 0.2;
                        expected +=
                            area * weight(angle) * double(*value) * Complex64::from_polar(1.0, f64::from(n) * angle);
                    }
                }
                assert!((double(*found) - expected).norm() < 1e-6, "n = {n}: {found} {expected}");
            }
        }
    }

    #[test]
    fn cubics_are_met_and_frequencies_outside_are_the_nearest() {
        let frequencies = [40.0, 90.0, 120.0, 200.0, 300.0, 320.0];
        let cubic = |f: f64| 1.0 + f * (0.01 + f * (1e-4 - 3e-7 * f));
        for frequency in [40.0, 55.0, 199.0, 250.0, 310.0, 320.0] {
            let (near, weights) = interpolation(&frequencies, frequency);
            let value: f64 = weights.iter().zip(&frequencies[near]).map(|(w, &f)| w * cubic(f)).sum();
            assert!((value - cubic(frequency)).abs() < 1e-9, "{frequency}: {value}");
        }
        for (frequency, nearest) in [(1.0, 40.0), (500.0, 320.0)] {
            let (near, weights) = interpolation(&frequencies, frequency);
            let value: f64 = weights.iter().zip(&frequencies[near]).map(|(w, &f)| w * cubic(f)).sum();
            assert!((value - cubic(nearest)).abs() < 1e-9);
        }
        assert_eq!(interpolation(&[70.0], 10.0), (0..1, vec![1.0]));
    }

    #[test]
    fn strips_under_the_patch_integrate_as_points_do() {
        let waves = Waves { circumference: 2.0, width: 0.2, sides: Sides::Guided };
        let (around, cells, half_width) = (16, 3, 0.1);
        // 1 + 2 y + y^2 at three points of each half: its even and its odd part.
        let across = vec![0.02, 0.05, 0.09];
        let part = |value: fn(f64) -> f64| {
            let of = move |y: &f64| vec![Complex32::new(value(*y) as f32, 0.0); around];
            across.iter().flat_map(of).collect::<Vec<_>>()
        };
        let values = vec![[part(|y| 1.0 + y * y), part(|y| 2.0 * y)].concat()];
        let count = 2000;
        let ends: Vec<f64> = (0..=count).map(|end| half_width * (2.0 * end as f64 / count as f64 - 1.0)).collect();
        let strip = |ends: &[f64]| {
            let y = 0.5 * (ends[0] + ends[1]);
            Complex32::new((1.0 + 2.0 * y + y * y) as f32, 0.0)
        };
        let row: Vec<Complex32> = ends.windows(2).map(strip).collect();
        let frequencies = vec![100.0];
        let sealed = SurfaceGreen {
            frequencies,
            around,
            across: across.clone(),
            half_width,
            rings: 0,
            values,
            under_patch: None,
        };
        // Of three cells before and behind, all but one hold the same field as the points.
        let mut strips = row.repeat(2 * cells);
        strips[4 * count..5 * count].fill(Complex32::ZERO);
        let open =
            SurfaceGreen { under_patch: Some(UnderPatch { cells, ends, values: vec![strips] }), ..sealed.clone() };
        let shapes = [Shape::Tread(0), Shape::Tread(1), Shape::Tread(2)];
        let of = |green: &SurfaceGreen, shape: usize| {
            let mut cells = vec![Complex64::ZERO; around];
            WaveIntegrals::new(green, waves, &shapes, 1).across(green, 0, shape, &mut cells);
            cells
        };
        for shape in 0..3 {
            let (sealed, open) = (of(&sealed, shape), of(&open, shape));
            for (cell, (sealed, open)) in sealed.iter().zip(&open).enumerate() {
                // The fifth of six, counted from the rearmost.
                let expected = if cell == 1 { Complex64::ZERO } else { *sealed };
                assert!((open - expected).norm() < 1e-6, "shape {shape}, cell {cell}: {open} {expected}");
            }
            assert!(sealed[1].norm() > 1e-4, "{shape}");
        }
    }
}
