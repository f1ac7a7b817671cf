//! Between the cells of the window and the waves of a ring.
//!
//! Across by a product with the waves' shapes, those that are even about the tyre's middle and those that are odd apart
//! from each other, which halves it; along by a transform for each lateral number, or, where a ring carries few of its
//! waves, by a product with these. Cells are material: a cell keeps its place on the ring.

use std::f64::consts::TAU;

use faer::linalg::matmul::matmul;
use faer::traits::{ComplexField, Conjugate};
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::{Complex, Complex64};
use realfft::FftNum;

use super::along_ring::{AlongRing, RingRow};
use crate::counters::Work;
use crate::numeric::{Element, transform_multiply_adds};
use crate::storage::state::Evolving;
use crate::tyre::influence::{CellGrid, CellRow};

/// A number that waves are found in: single or double precision.
pub trait WaveNumber: Element + Evolving + FftNum + ComplexField + Conjugate<Canonical = Self> {}

impl WaveNumber for f32 {}
impl WaveNumber for f64 {}

/// Lateral numbers whose shapes are all even, or all odd, about the middle.
struct Side<R> {
    rows: Vec<RingRow>,
    /// Rows of all fields: twice as many as there are pairs, see [`AlongRing`]. Those behind the last are zeros.
    height: usize,
    /// s_m(y_j), row by row, j below the middle; the wave itself where numbers are taken together.
    shapes: Vec<R>,
    /// Fields across \[half of the cells, or rows\], column by column.
    cells: Vec<R>,
    waves: Vec<R>,
    /// Rows x real and imaginary parts of the ring's first waves, where they are found by a product.
    spectra: Vec<R>,
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
    /// Multiply-adds of a product that take the time of one of a transform (measured).
    const WORTH: f64 = 2.5;

    /// Plans `bins` bins, if a product with them takes less time than a transform.
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
    fn turns<'a>(&'a self, row: &RingRow, first: usize) -> impl Iterator<Item = Complex<R>> + use<'a, R> {
        let ring = self.turns.len();
        (row.first..row.first + row.count).map(move |n| self.turns[n * first % ring])
    }

    /// Weight of a wave in a real field: 2, or 1 for the waves that are their own mirror.
    fn times(&self, n: usize) -> R {
        R::rounded(if n == 0 || 2 * n == self.turns.len() { 1.0 } else { 2.0 })
    }
}

/// The transforms of one ring.
pub struct WaveTransform<R = f64> {
    ring: usize,
    columns: usize,
    across: usize,
    waves: usize,
    even: Side<R>,
    odd: Side<R>,
    along: Along<R>,
}

/// Path between the columns of a window and the waves of a ring.
enum Along<R> {
    /// By products with the few waves that it carries.
    Basis(Basis<R>),
    /// By transforms.
    Ring(AlongRing<R>),
}

impl<R: WaveNumber> WaveTransform<R> {
    /// Plans transforms between windows of `columns` columns and the waves of rows on the grid's ring.
    pub fn new(grid: &CellGrid, columns: usize, rows: &[CellRow]) -> Self {
        let shape = |row: &CellRow, j: usize| if row.folded { grid.wave(row.m, j) } else { grid.shape(row.m, j) };
        // The ends of the strip decide which are even.
        let is_even = |m: usize| m.is_multiple_of(2) == (grid.waves().first_lateral_number() == 0);
        Self::with_shapes([grid.elements(), columns, grid.across], rows, shape, is_even)
    }

    /// Plans transforms between a ring, columns and cells across, with shapes by row and cell; `is_even` says of a
    /// lateral number whether its shape is even about the middle.
    pub(crate) fn with_shapes(
        [ring, columns, across]: [usize; 3],
        rows: &[CellRow],
        shape: impl Fn(&CellRow, usize) -> f64,
        is_even: impl Fn(usize) -> bool,
    ) -> Self {
        let half = across.div_ceil(2);
        let empty = Vec::new;
        let side =
            || Side { rows: Vec::new(), height: 0, shapes: empty(), cells: empty(), waves: empty(), spectra: empty() };
        let (mut even, mut odd, zero) = (side(), side(), R::default());
        let mut start = 0;
        for row in rows {
            // The middle one of an odd number of cells counts once.
            let side = if is_even(row.m) { &mut even } else { &mut odd };
            side.shapes.extend((0..half).map(|j| R::rounded(shape(row, j))));
            side.rows.push(RingRow { start, first: row.first, count: row.waves.len() });
            start += row.waves.len();
        }
        let bins = rows.iter().map(|row| row.first + row.waves.len()).max().unwrap_or(0);
        let along = match Basis::new(ring, columns, bins) {
            Some(basis) => Along::Basis(basis),
            None => Along::Ring(AlongRing::new(ring)),
        };
        for side in [&mut even, &mut odd] {
            let rows = side.rows.len();
            let (height, bins) = match &along {
                Along::Basis(basis) => (rows, basis.bins),
                Along::Ring(along) => (along.height(rows), 0),
            };
            side.height = height;
            side.shapes.resize(height * half, zero);
            side.cells = vec![zero; half * columns];
            side.waves = vec![zero; height * columns];
            side.spectra = vec![zero; rows * 2 * bins];
        }
        Self { ring, columns, across, waves: start, even, odd, along }
    }

    pub(super) fn across(&self) -> usize {
        self.across
    }

    /// Cells of the window.
    pub fn cells(&self) -> usize {
        self.columns * self.across
    }

    /// Number of waves.
    pub fn waves(&self) -> usize {
        self.waves
    }

    /// Work of one direction: products across, and transforms or products along.
    pub fn work(&self) -> Work {
        let (mut multiply_adds, mut numbers) = (0.0, self.cells() + 2 * self.waves);
        for Side { rows, height, shapes, cells, waves, spectra } in [&self.even, &self.odd] {
            multiply_adds += (height * self.across.div_ceil(2) * self.columns) as f64;
            multiply_adds += match &self.along {
                Along::Basis(basis) => (rows.len() * 2 * basis.bins * self.columns) as f64,
                Along::Ring(_) => 0.5 * *height as f64 * transform_multiply_adds(self.ring),
            };
            numbers += shapes.len() + 2 * cells.len() + 2 * waves.len() + 2 * spectra.len();
        }
        if let Along::Basis(basis) = &self.along {
            numbers += basis.values.len();
        }
        Work { multiply_adds: multiply_adds as u64, bytes: (numbers * size_of::<R>()) as u64 }
    }

    /// Phase of each wave from one element to the next \[rad\].
    pub fn angles(&self) -> Vec<f64> {
        let mut angles = vec![0.0; self.waves];
        for row in self.even.rows.iter().chain(&self.odd.rows) {
            for (n, angle) in (row.first..).zip(&mut angles[row.start..row.start + row.count]) {
                *angle = TAU * n as f64 / self.ring as f64;
            }
        }
        angles
    }

    /// Transforms forces \[N\] on the cells of the window that begins with element `first_element`, column by column,
    /// to their waves.
    pub fn forward(&mut self, first_element: i64, forces: &[f64], spectrum: &mut [Complex<R>]) {
        let Self { ring, columns, across, even, odd, along, .. } = self;
        let (half, one) = (across.div_ceil(2), R::rounded(1.0));
        // 1. Sums and differences about the middle: the parts that are even and odd across.
        let sides = even.cells.chunks_exact_mut(half).zip(odd.cells.chunks_exact_mut(half));
        for (cells, (even, odd)) in forces.chunks_exact(*across).zip(sides) {
            let pairs = cells.iter().zip(cells.iter().rev());
            for ((even, odd), (near, far)) in even.iter_mut().zip(odd).zip(pairs) {
                let (near, far) = (R::rounded(*near), R::rounded(*far));
                (*even, *odd) = (near + far, near - far);
            }
            if !across.is_multiple_of(2) {
                even[half - 1] = R::rounded(cells[half - 1]);
            }
        }
        let first = first_element.rem_euclid(*ring as i64) as usize;
        // 2. Products with the shapes across, then waves along.
        for Side { rows, height, shapes, cells, waves, spectra } in [even, odd] {
            let across_waves = MatMut::from_column_major_slice_mut(waves, *height, *columns);
            let shapes = MatRef::from_row_major_slice(shapes, *height, half);
            let cells = MatRef::from_column_major_slice(cells, half, *columns);
            matmul(across_waves, Accum::Replace, shapes, cells, one, Par::Seq);
            let basis = match along {
                Along::Basis(basis) => basis,
                Along::Ring(along) => {
                    along.forward(first, rows, waves, spectrum);
                    continue;
                }
            };
            let waves = MatRef::from_column_major_slice(waves, *height, *columns);
            let of_bins = MatMut::from_row_major_slice_mut(spectra, rows.len(), 2 * basis.bins);
            matmul(of_bins, Accum::Replace, waves, basis.matrix().transpose(), one, Par::Seq);
            for (row, values) in rows.iter().zip(spectra.chunks_exact(2 * basis.bins)) {
                let (values, _) = values[2 * row.first..].as_chunks::<2>();
                let out = spectrum[row.start..row.start + row.count].iter_mut();
                for ((out, &[re, im]), turn) in out.zip(values).zip(basis.turns(row, first)) {
                    *out = Complex::new(re, im) * turn;
                }
            }
        }
    }

    /// Adds the displacements of waves \[m\] to the cells of the window.
    pub fn add_inverse(&mut self, spectrum: &[Complex<R>], first_element: i64, out: &mut [f64]) {
        let Self { ring, columns, across, even, odd, along, .. } = self;
        let (half, one) = (across.div_ceil(2), R::rounded(1.0));
        let first = first_element.rem_euclid(*ring as i64) as usize;
        // 1. Along, then products with the shapes across, for the even and the odd part.
        for Side { rows, height, shapes, cells, waves, spectra } in [&mut *even, &mut *odd] {
            match along {
                Along::Ring(along) => along.inverse(first, rows, spectrum, waves),
                Along::Basis(basis) => {
                    spectra.fill(R::default());
                    for (row, values) in rows.iter().zip(spectra.chunks_exact_mut(2 * basis.bins)) {
                        let (values, _) = values[2 * row.first..].as_chunks_mut::<2>();
                        let waves = spectrum[row.start..row.start + row.count].iter().zip(basis.turns(row, first));
                        for ((number, value), (wave, turn)) in (row.first..).zip(values).zip(waves) {
                            let turned = wave * basis.times(number) * turn.conj();
                            *value = [turned.re, turned.im];
                        }
                    }
                    let waves = MatMut::from_column_major_slice_mut(waves, *height, *columns);
                    let spectra = MatRef::from_row_major_slice(spectra, rows.len(), 2 * basis.bins);
                    matmul(waves, Accum::Replace, spectra, basis.matrix(), one, Par::Seq);
                }
            }
            let cells = MatMut::from_column_major_slice_mut(cells, half, *columns);
            let shapes = MatRef::from_row_major_slice(shapes, *height, half);
            let waves = MatRef::from_column_major_slice(waves, *height, *columns);
            matmul(cells, Accum::Replace, shapes.transpose(), waves, one, Par::Seq);
        }
        // 2. Their sums and differences about the middle.
        let sides = even.cells.chunks_exact(half).zip(odd.cells.chunks_exact(half));
        for (cells, (even, odd)) in out.chunks_exact_mut(*across).zip(sides) {
            // The middle one of an odd number of cells belongs to the near half.
            let (near, far) = cells.split_at_mut(half);
            near.iter_mut().zip(even.iter().zip(odd)).for_each(|(out, (even, odd))| *out += (*even + *odd).double());
            let mirrored = far.iter_mut().rev().zip(even.iter().zip(odd));
            mirrored.for_each(|(out, (even, odd))| *out += (*even - *odd).double());
        }
    }
}
