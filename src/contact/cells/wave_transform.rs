//! Between the cells of the window and the waves of a ring.
//!
//! Across by a product with the waves' shapes, those that are even about the tyre's middle and those that are odd apart
//! from each other, which halves it; along by a transform for each lateral number, or, where a ring carries few of its
//! waves, by a product with these. Cells are material: a cell keeps its place on the ring.

use std::f64::consts::TAU;
use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::traits::{ComplexField, Conjugate};
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::{Complex, Complex64};
use realfft::{ComplexToReal, FftNum, RealFftPlanner, RealToComplex};

use crate::counters::Work;
use crate::numeric::{Element, transform_multiply_adds};
use crate::tyre::influence::{CellGrid, CellRow};

/// A number that waves are found in: single or double precision.
pub trait WaveNumber: Element + FftNum + ComplexField + Conjugate<Canonical = Self> {}

impl WaveNumber for f32 {}
impl WaveNumber for f64 {}

/// Lateral numbers whose shapes are all even, or all odd, about the middle.
struct Side<R> {
    /// Their rows.
    rows: Vec<Row<R>>,
    /// s_m(y_j), m by m, j below the middle; the wave itself where numbers are taken together.
    shapes: Vec<R>,
    /// Fields across \[rows or half of the cells\] x columns.
    cells: Vec<R>,
    waves: Vec<R>,
    /// Rows x real and imaginary parts of the ring's first waves, where they are found by a product.
    spectra: Vec<R>,
}

/// One lateral number.
struct Row<R> {
    /// Where its waves are in the list of all.
    start: usize,
    /// Number of the first one on the ring.
    first: usize,
    count: usize,
    field: Vec<R>,
    spectrum: Vec<Complex<R>>,
    scratch: Vec<Complex<R>>,
}

/// The first waves of a ring on the columns of a window.
struct Basis<R> {
    /// cos and -sin of 2 pi n c/R, bin by bin.
    values: Vec<R>,
    bins: usize,
    /// exp(-2 pi i k/R).
    turns: Vec<Complex<R>>,
}

impl<R: WaveNumber> Basis<R> {
    /// Multiply-adds of a transform that take the time of one of a product (measured).
    const WORTH: f64 = 2.5;

    /// Plans so many bins, if a product with them takes less time than a transform.
    fn new(ring: usize, columns: usize, bins: usize) -> Option<Self> {
        if bins == 0 || (2 * bins * columns) as f64 > Self::WORTH * transform_multiply_adds(ring) {
            return None;
        }
        let turn = |k: usize| Complex64::cis(-TAU * (k % ring) as f64 / ring as f64);
        let mut values = Vec::with_capacity(2 * bins * columns);
        for n in 0..bins {
            values.extend((0..columns).map(|c| R::rounded(turn(n * c).re)));
            values.extend((0..columns).map(|c| R::rounded(turn(n * c).im)));
        }
        let rounded = |k: usize| Complex::new(R::rounded(turn(k).re), R::rounded(turn(k).im));
        Some(Self { values, bins, turns: (0..ring).map(rounded).collect() })
    }

    fn matrix(&self) -> MatRef<'_, R> {
        let columns = self.values.len() / (2 * self.bins);
        MatRef::from_row_major_slice(&self.values, 2 * self.bins, columns)
    }

    /// exp(-2 pi i n first/R) of a row's waves.
    fn turns<'a>(&'a self, row: &Row<R>, first: usize) -> impl Iterator<Item = Complex<R>> + use<'a, R> {
        let ring = self.turns.len();
        (row.first..row.first + row.count).map(move |n| self.turns[n * first % ring])
    }

    /// Returns the weight of a wave in a real field: 2, or 1 for the waves that are their own mirror.
    fn times(&self, n: usize) -> R {
        R::rounded(if n == 0 || 2 * n == self.turns.len() { 1.0 } else { 2.0 })
    }
}

/// The transforms of one ring.
pub struct WaveTransform<R: FftNum = f64> {
    ring: usize,
    columns: usize,
    across: usize,
    waves: usize,
    even: Side<R>,
    odd: Side<R>,
    basis: Option<Basis<R>>,
    forward: Arc<dyn RealToComplex<R>>,
    inverse: Arc<dyn ComplexToReal<R>>,
}

impl<R: WaveNumber> WaveTransform<R> {
    /// Between windows of so many columns and the waves of rows on a ring of so many cells.
    pub fn new(grid: &CellGrid, ring: usize, columns: usize, rows: &[CellRow]) -> Self {
        let mut planner = RealFftPlanner::<R>::new();
        let (forward, inverse) = (planner.plan_fft_forward(ring), planner.plan_fft_inverse(ring));
        let scratch = forward.get_scratch_len().max(inverse.get_scratch_len());
        let half = grid.across.div_ceil(2);
        let empty = Vec::new;
        let side = || Side { rows: Vec::new(), shapes: empty(), cells: empty(), waves: empty(), spectra: empty() };
        let (mut even, mut odd, zero) = (side(), side(), R::default());
        let mut start = 0;
        for CellRow { m, folded, first, waves } in rows {
            // The ends of the strip tell even from odd; the middle one of an odd number of cells counts once.
            let shape = |j| R::rounded(if *folded { grid.wave(*m, j) } else { grid.shape(*m, j) });
            let is_even = (m % 2 == 0) == (grid.waves().first_lateral_number() == 0);
            let side = if is_even { &mut even } else { &mut odd };
            side.shapes.extend((0..half).map(shape));
            side.rows.push(Row {
                start,
                first: *first,
                count: waves.len(),
                field: forward.make_input_vec(),
                spectrum: forward.make_output_vec(),
                scratch: vec![Complex::new(zero, zero); scratch],
            });
            start += waves.len();
        }
        let bins = rows.iter().map(|row| row.first + row.waves.len()).max().unwrap_or(0);
        let basis = Basis::new(ring, columns, bins);
        for side in [&mut even, &mut odd] {
            side.cells = vec![zero; half * columns];
            side.waves = vec![zero; side.rows.len() * columns];
            side.spectra = vec![zero; basis.as_ref().map_or(0, |basis| side.rows.len() * 2 * basis.bins)];
        }
        Self { ring, columns, across: grid.across, waves: start, even, odd, basis, forward, inverse }
    }

    /// Cells of the window.
    pub fn cells(&self) -> usize {
        self.columns * self.across
    }

    /// Waves.
    pub fn waves(&self) -> usize {
        self.waves
    }

    /// Returns the work of one way: products across, and transforms or products along.
    pub fn work(&self) -> Work {
        let (mut multiply_adds, mut numbers) = (0.0, self.cells() + 2 * self.waves);
        for side in [&self.even, &self.odd] {
            let (rows, bins) = (side.rows.len(), self.basis.as_ref().map_or(0, |basis| basis.bins));
            multiply_adds += (rows * self.across.div_ceil(2) * self.columns + rows * 2 * bins * self.columns) as f64;
            if self.basis.is_none() {
                multiply_adds += 0.5 * rows as f64 * transform_multiply_adds(self.ring);
            }
            numbers += side.shapes.len() + 2 * side.cells.len() + 2 * side.waves.len() + 2 * side.spectra.len();
        }
        let basis = self.basis.as_ref().map_or(0, |basis| basis.values.len());
        Work { multiply_adds: multiply_adds as u64, bytes: ((numbers + basis) * size_of::<R>()) as u64 }
    }

    /// Phase of each wave from one element to the next.
    pub fn angles(&self) -> Vec<f64> {
        let mut angles = vec![0.0; self.waves];
        for row in self.even.rows.iter().chain(&self.odd.rows) {
            for (n, angle) in (row.first..).zip(&mut angles[row.start..row.start + row.count]) {
                *angle = TAU * n as f64 / self.ring as f64;
            }
        }
        angles
    }

    /// Forces on the cells of the window that begins with element `first_element`, column by column, to their waves.
    pub fn forward(&mut self, first_element: i64, forces: &[f64], spectrum: &mut [Complex<R>]) {
        let Self { ring, columns, across, even, odd, basis, forward, .. } = self;
        let (half, one) = (across.div_ceil(2), R::rounded(1.0));
        for (column, cells) in forces.chunks_exact(*across).enumerate() {
            for j in 0..half {
                let (near, far) = (R::rounded(cells[j]), R::rounded(cells[*across - 1 - j]));
                let middle = 2 * j + 1 == *across;
                even.cells[column * half + j] = if middle { near } else { near + far };
                odd.cells[column * half + j] = if middle { R::default() } else { near - far };
            }
        }
        let first = first_element.rem_euclid(*ring as i64) as usize;
        let before = (*ring - first).min(*columns);
        for side in [even, odd] {
            let rows = side.rows.len();
            let waves = MatMut::from_row_major_slice_mut(&mut side.waves, rows, *columns);
            let shapes = MatRef::from_row_major_slice(&side.shapes, rows, half);
            let cells = MatRef::from_column_major_slice(&side.cells, half, *columns);
            matmul(waves, Accum::Replace, shapes, cells, one, Par::Seq);
            if let Some(basis) = basis {
                let waves = MatRef::from_row_major_slice(&side.waves, rows, *columns);
                let spectra = MatMut::from_row_major_slice_mut(&mut side.spectra, rows, 2 * basis.bins);
                matmul(spectra, Accum::Replace, waves, basis.matrix().transpose(), one, Par::Seq);
                for (row, values) in side.rows.iter().zip(side.spectra.chunks_exact(2 * basis.bins)) {
                    let (values, _) = values[2 * row.first..].as_chunks::<2>();
                    let out = spectrum[row.start..row.start + row.count].iter_mut();
                    for ((out, &[re, im]), turn) in out.zip(values).zip(basis.turns(row, first)) {
                        *out = Complex::new(re, im) * turn;
                    }
                }
                continue;
            }
            let waves = &side.waves;
            side.rows.iter_mut().enumerate().for_each(|(index, row)| {
                row.field.fill(R::default());
                let (before_seam, behind_seam) = waves[index * *columns..][..*columns].split_at(before);
                row.field[first..first + before].copy_from_slice(before_seam);
                row.field[..behind_seam.len()].copy_from_slice(behind_seam);
                // Planned lengths: nothing to refuse.
                let _ = forward.process_with_scratch(&mut row.field, &mut row.spectrum, &mut row.scratch);
            });
            for row in &side.rows {
                spectrum[row.start..row.start + row.count].copy_from_slice(&row.spectrum[row.first..][..row.count]);
            }
        }
    }

    /// Adds what waves displace to the cells of the window.
    pub fn add_inverse(&mut self, spectrum: &[Complex<R>], first_element: i64, out: &mut [f64]) {
        let Self { ring, columns, across, even, odd, basis, inverse, .. } = self;
        let (half, one) = (across.div_ceil(2), R::rounded(1.0));
        let first = first_element.rem_euclid(*ring as i64) as usize;
        let before = (*ring - first).min(*columns);
        for side in [&mut *even, &mut *odd] {
            let rows = side.rows.len();
            if let Some(basis) = basis {
                side.spectra.fill(R::default());
                for (row, values) in side.rows.iter().zip(side.spectra.chunks_exact_mut(2 * basis.bins)) {
                    let (values, _) = values[2 * row.first..].as_chunks_mut::<2>();
                    let waves = spectrum[row.start..row.start + row.count].iter().zip(basis.turns(row, first));
                    for ((number, value), (wave, turn)) in (row.first..).zip(values).zip(waves) {
                        let turned = wave * basis.times(number) * turn.conj();
                        *value = [turned.re, turned.im];
                    }
                }
                let waves = MatMut::from_row_major_slice_mut(&mut side.waves, rows, *columns);
                let spectra = MatRef::from_row_major_slice(&side.spectra, rows, 2 * basis.bins);
                matmul(waves, Accum::Replace, spectra, basis.matrix(), one, Par::Seq);
            }
            for row in side.rows.iter_mut().filter(|_| basis.is_none()) {
                row.spectrum.fill(Complex::new(R::default(), R::default()));
                row.spectrum[row.first..][..row.count].copy_from_slice(&spectrum[row.start..][..row.count]);
                // The ends of the spectrum of a real field are real.
                let last = row.spectrum.len() - 1;
                (row.spectrum[0].im, row.spectrum[last].im) = (R::default(), R::default());
                let _ = inverse.process_with_scratch(&mut row.spectrum, &mut row.field, &mut row.scratch);
            }
            let transformed = side.rows.iter().zip(side.waves.chunks_exact_mut(*columns));
            for (row, waves) in transformed.filter(|_| basis.is_none()) {
                let (before_seam, behind_seam) = waves.split_at_mut(before);
                before_seam.copy_from_slice(&row.field[first..first + before]);
                behind_seam.copy_from_slice(&row.field[..behind_seam.len()]);
            }
            let cells = MatMut::from_column_major_slice_mut(&mut side.cells, half, *columns);
            let shapes = MatRef::from_row_major_slice(&side.shapes, rows, half);
            let waves = MatRef::from_row_major_slice(&side.waves, rows, *columns);
            matmul(cells, Accum::Replace, shapes.transpose(), waves, one, Par::Seq);
        }
        for (column, cells) in out.chunks_exact_mut(*across).enumerate() {
            for j in 0..half {
                let (symmetric, skew) = (even.cells[column * half + j], odd.cells[column * half + j]);
                cells[j] += (symmetric + skew).double();
                if 2 * j + 1 < *across {
                    cells[*across - 1 - j] += (symmetric - skew).double();
                }
            }
        }
    }
}
