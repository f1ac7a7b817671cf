//! Drawing a random surface piece by piece.
//!
//! Across, the surface is a Fourier series of period P (several longest wavelengths): z(x, y) = sum over m of
//! a_m(x) cos(2 pi m y/P) + b_m(x) sin(2 pi m y/P). For an isotropic Gaussian surface all a_m, b_m are independent
//! stationary Gaussian processes along x, the two-sided spectrum of each being 2 G_m(kx) (m = 0: G_0, no b),
//! G_m = integral of S(kx, ky) over the m-th cell of ky, 1/P wide: the profile spectrum along x is then exact whatever P.
//!
//! 1. White noise on a lattice of `spacing` h along x, a stream of its own for every m, addressable by sample: sample n of
//!    stream m is the same number whenever and by whomever it is asked for, also for negative n.
//! 2. The filter of stream m (of a single column: of all streams together, which are then one process: another draw of the same spectrum at a fraction of the cost), sqrt(2 G_m/h) times the low-pass of the run's elements, is made once in the frequency domain,
//!    its impulse response cut softly to a reach of several longest wavelengths, its energy restored.
//! 3. A chunk of elements: noise around it, transform, multiply, transform back (overlap-save); a_m and b_m ride as real and imaginary part.
//! 4. Columns: the series is summed at the columns' y, components beyond the lateral Nyquist wavenumber left out, still on the lattice along x: a product of matrices.
//! 5. Rows: interpolation from the lattice to the elements by a windowed sinc, of all columns at once: far fewer than components.
//!
//! The spectrum is scene data and the noise belongs to the lattice, so the road is the same at any number of elements, up to
//! what the elements can resolve. Chunks start at fixed elements: results do not depend on the order of access nor
//! on the number of threads. Cost per chunk: two transforms of length M per m, and samples x columns x 2 m_max
//! multiply-adds; memory 4 M m_max bytes for filters, 48 M per thread, M (1024 + 8 columns) for what a chunk is made from.

use std::f64::consts::PI;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use pulp::Arch;
use rayon::prelude::*;
use rustfft::{Fft, FftPlanner, num_complex::Complex64};

use super::noise::{Interpolation, Taps, normal_pairs};
use super::rings::RingSpectrum;
use super::sizes::{STREAMS, Sizes};
use super::target::TargetSpectrum;
use crate::numeric::windowed_sinc::WindowedSinc;
use crate::road::error::RoadError;
use crate::road::lattice::Lattice;

/// Sub-cells of one lateral cell over which S is averaged.
const SUBCELLS: usize = 6;
/// Share of the Nyquist wavenumber below which the low-pass is flat; a raised cosine from there to it.
const PASS: f64 = 0.8;
/// Rows that one thread takes at a time.
const BLOCK: usize = 128;

/// A random isotropic surface on a run's lattice.
pub struct Texture {
    spectrum: RingSpectrum,
    lattice: Lattice,
    spacing: f64,
    seed: u64,
    /// Rows per chunk.
    chunk_rows: usize,
    /// Samples on either side that a filtered sample depends on.
    reach: usize,
    forward: Arc<dyn Fft<f64>>,
    backward: Arc<dyn Fft<f64>>,
    /// Transfer function of stream m at lines 0 to half the length (it is real and even), scaled for the round trip.
    filters: Vec<Vec<f64>>,
    /// Cosines, then sines at the columns, m by m.
    shapes: Vec<f64>,
    interpolation: WindowedSinc,
}

impl Texture {
    /// Prepares a texture: `limit` bounds the bytes of its working arrays.
    ///
    /// # Errors
    /// A lattice `spacing` too coarse for the spectrum's shortest wavelength; working arrays beyond `limit`.
    pub fn new(
        target: &TargetSpectrum,
        spacing: f64,
        seed: u64,
        lattice: Lattice,
        limit: u64,
    ) -> Result<Self, RoadError> {
        let Sizes { period, reach, length, chunk_rows, interpolation, .. } =
            Sizes::new(target, spacing, lattice, limit)?;
        let mut planner = FftPlanner::new();
        let (forward, backward) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
        let spectrum = RingSpectrum::fit(target);
        let lateral_nyquist = if lattice.columns > 1 { 0.5 / lattice.dy } else { f64::INFINITY };
        let components = (0..)
            .take_while(|&m| (f64::from(m) - 0.5) / period < spectrum.highest().min(lateral_nyquist))
            .count() as u32;
        // In one column alone all components are one process along x.
        let together = if lattice.columns > 1 { 1 } else { components };
        let streams: Vec<Range<u32>> =
            (0..components).step_by(together.max(1) as usize).map(|m| m..m + together).collect();
        let filters = streams
            .par_iter()
            .map(|stream| {
                filter(&spectrum, stream.clone(), period, spacing, lattice.cell(), reach, &forward, &backward)
            })
            .collect();
        let shape = |stream: &Range<u32>| -> Vec<f64> {
            if lattice.columns == 1 {
                return vec![1.0, 0.0];
            }
            let wavenumber = f64::from(stream.start) / period;
            let gain = low_pass(wavenumber, lateral_nyquist);
            let phases = (0..lattice.columns).map(move |column| 2.0 * PI * wavenumber * lattice.y(column));
            phases.clone().map(|phase| gain * phase.cos()).chain(phases.map(|phase| gain * phase.sin())).collect()
        };
        let shapes = streams.iter().flat_map(shape).collect();
        Ok(Self {
            spectrum,
            lattice,
            spacing,
            seed,
            chunk_rows,
            reach,
            forward,
            backward,
            filters,
            shapes,
            interpolation,
        })
    }

    /// Rows per chunk.
    pub fn chunk_rows(&self) -> usize {
        self.chunk_rows
    }

    /// The two-dimensional spectrum and how well it meets the target.
    pub fn spectrum(&self) -> &RingSpectrum {
        &self.spectrum
    }

    /// Heights \[m\] of chunk `chunk`: rows chunk * [`Self::chunk_rows`] and following, row-major, rows x columns; `heights` is overwritten.
    pub fn chunk(&self, chunk: i64, work: &mut ChunkWork, heights: &mut Vec<f64>) {
        let columns = self.lattice.columns;
        let first_row = chunk * self.chunk_rows as i64;
        let position = |row: usize| self.lattice.place(first_row + row as i64, self.spacing);
        let half_width = self.interpolation.half_width() as i64;
        let first_sample = position(0).floor() as i64 - half_width;
        let ChunkWork { taps, weights, rows, amplitudes, lateral, spaces } = work;
        weights.clear();
        rows.clear();
        for row in 0..self.chunk_rows {
            let start = self.interpolation.weights(position(row), 1.0, taps);
            let begin = weights.len();
            weights.extend_from_slice(taps);
            rows.push(Taps { start: (start - first_sample) as usize, weights: begin..weights.len() });
        }
        let samples = rows.iter().map(|row| row.start + row.weights.len()).max().unwrap_or(0);
        amplitudes.resize(2 * samples * STREAMS.min(self.filters.len()), 0.0);
        lateral.clear();
        lateral.resize(samples * columns, 0.0);
        for (batch, filters) in self.filters.chunks(STREAMS).enumerate() {
            let amplitudes = &mut amplitudes[..2 * samples * filters.len()];
            amplitudes.par_chunks_mut(2 * samples).enumerate().for_each(|(stream, amplitudes)| {
                let mut space = lock(spaces).pop().unwrap_or_else(|| Workspace::new(&*self.forward));
                self.filtered_noise(batch * STREAMS + stream, first_sample, &mut space, amplitudes);
                lock(spaces).push(space);
            });
            let shapes = &self.shapes[2 * columns * STREAMS * batch..][..2 * columns * filters.len()];
            add_shapes(amplitudes, shapes, columns, lateral);
        }
        heights.resize(self.chunk_rows * columns, 0.0);
        let arch = Arch::new();
        heights.par_chunks_mut(BLOCK * columns).zip(rows.par_chunks(BLOCK)).for_each(|(heights, rows)| {
            arch.dispatch(Interpolation { heights, rows, weights, samples: lateral, columns });
        });
    }

    /// Noise of one stream from sample `first` on, filtered: as many real parts as fill half of `amplitudes`, then as many imaginary ones.
    fn filtered_noise(&self, stream: usize, first: i64, work: &mut Workspace, amplitudes: &mut [f64]) {
        let Workspace { parts: [real, imaginary], line: noise, scratch } = work;
        normal_pairs(self.seed, stream as u64, first - self.reach as i64, real, imaginary);
        for ((sample, &re), &im) in noise.iter_mut().zip(real.iter()).zip(imaginary.iter()) {
            *sample = Complex64::new(re, im);
        }
        self.forward.process_with_scratch(noise, scratch);
        let filter = &self.filters[stream];
        let (lower, upper) = noise.split_at_mut(filter.len());
        for (line, gain) in lower.iter_mut().zip(filter).chain(upper.iter_mut().zip(filter[1..].iter().rev().skip(1))) {
            *line *= gain;
        }
        self.backward.process_with_scratch(noise, scratch);
        let (real, imaginary) = amplitudes.split_at_mut(amplitudes.len() / 2);
        for ((sample, re), im) in noise[self.reach..].iter().zip(real).zip(imaginary) {
            (*re, *im) = (sample.re, sample.im);
        }
    }
}

/// Adds cosines and sines across, as high as the amplitudes of some streams, to rows of samples: a product of matrices.
fn add_shapes(amplitudes: &[f64], shapes: &[f64], columns: usize, lateral: &mut [f64]) {
    let (count, samples) = (shapes.len() / columns, lateral.len() / columns);
    let amplitudes = MatRef::from_column_major_slice(amplitudes, samples, count);
    let shapes = MatRef::from_row_major_slice(shapes, count, columns);
    lateral.par_chunks_mut(BLOCK * columns).enumerate().for_each(|(block, rows)| {
        let amplitudes = amplitudes.subrows(block * BLOCK, rows.len() / columns);
        let rows = MatMut::from_row_major_slice_mut(rows, amplitudes.nrows(), columns);
        matmul(rows, Accum::Add, amplitudes, shapes, 1.0, Par::Seq);
    });
}

/// Arrays of a chunk in the making, kept for the next one.
#[derive(Default)]
pub struct ChunkWork {
    taps: Vec<f64>,
    weights: Vec<f64>,
    rows: Vec<Taps>,
    /// Real and imaginary parts at the samples, of some streams.
    amplitudes: Vec<f64>,
    /// Heights at samples along and columns across, row-major.
    lateral: Vec<f64>,
    spaces: Mutex<Vec<Workspace>>,
}

/// Arrays of one stream in the making.
struct Workspace {
    parts: [Vec<f64>; 2],
    line: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

impl Workspace {
    fn new(transform: &dyn Fft<f64>) -> Self {
        let zeros = || vec![0.0; transform.len()];
        let scratch = vec![Complex64::default(); transform.get_inplace_scratch_len()];
        Self { parts: [zeros(), zeros()], line: vec![Complex64::default(); transform.len()], scratch }
    }
}

/// The content, whoever has panicked while holding it.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Flat to `PASS` of the Nyquist wavenumber, zero from it on.
fn low_pass(wavenumber: f64, nyquist: f64) -> f64 {
    let ratio = wavenumber / nyquist;
    if ratio <= PASS {
        1.0
    } else if ratio >= 1.0 {
        0.0
    } else {
        0.5 + 0.5 * (PI * (ratio - PASS) / (1.0 - PASS)).cos()
    }
}

#[expect(clippy::too_many_arguments, reason = "the quantities of one formula, called once")]
fn filter(
    spectrum: &RingSpectrum,
    components: Range<u32>,
    period: f64,
    spacing: f64,
    dx: f64,
    reach: usize,
    forward: &Arc<dyn Fft<f64>>,
    backward: &Arc<dyn Fft<f64>>,
) -> Vec<f64> {
    let length = forward.len();
    let cell = 1.0 / period;
    let density_of = |m: u32, kx: f64| {
        let sides = if m == 0 { 1.0 } else { 2.0 };
        let sum: f64 = (0..SUBCELLS)
            .map(|sub| (f64::from(m) - 0.5 + (sub as f64 + 0.5) / SUBCELLS as f64) * cell)
            .map(|ky| spectrum.density(kx * kx + ky * ky))
            .sum();
        sides * cell * sum / SUBCELLS as f64
    };
    let density = |kx: f64| components.clone().map(|m| density_of(m, kx)).sum::<f64>();
    let line = 1.0 / (length as f64 * spacing);
    let gain = |index: usize| {
        let kx = index.min(length - index) as f64 * line;
        (density(kx) / spacing).sqrt() * low_pass(kx, 0.5 / dx)
    };
    let half: Vec<f64> = (0..=length / 2).map(gain).collect();
    let mut response: Vec<Complex64> =
        (0..length).map(|index| Complex64::new(half[index.min(length - index)], 0.0)).collect();
    let wanted: f64 = response.iter().map(Complex64::norm_sqr).sum();
    backward.process(&mut response);
    for (index, value) in response.iter_mut().enumerate() {
        let distance = index.min(length - index);
        let taper = if distance < reach { (0.5 * PI * distance as f64 / reach as f64).cos() } else { 0.0 };
        *value *= taper / length as f64;
    }
    forward.process(&mut response);
    let kept: f64 = response.iter().map(Complex64::norm_sqr).sum();
    let restored = if kept > 0.0 { (wanted / kept).sqrt() } else { 0.0 };
    // 1/length: the transforms of the round trip are not normalised.
    response[..=length / 2].iter().map(|value| value.re * restored / length as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Batches of streams, the product of matrices and the order of summation change rounding only; so does noise that was filtered from another sample on.
    #[test]
    fn a_chunk_is_the_series_at_its_elements_interpolated_stream_by_stream() {
        let lattice = Lattice { dx: 0.0062, along: 2, dy: 0.004, columns: 7 };
        let texture = Texture::new(&TargetSpectrum::dense_asphalt(), 0.001, 11, lattice, 1 << 30).unwrap();
        assert!(texture.filters.len() > 2 * STREAMS);
        let (chunk, columns) = (-2, lattice.columns);
        let (mut work, mut heights) = (ChunkWork::default(), Vec::new());
        texture.chunk(chunk, &mut work, &mut heights);
        let rms = (heights.iter().map(|height| height * height).sum::<f64>() / heights.len() as f64).sqrt();
        let mut space = Workspace::new(&*texture.forward);
        let mut taps = Vec::new();
        for row in [0, 1, texture.chunk_rows / 2, texture.chunk_rows - 1] {
            let position = lattice.place(chunk * texture.chunk_rows as i64 + row as i64, texture.spacing);
            let start = texture.interpolation.weights(position, 1.0, &mut taps);
            let mut expected = vec![0.0; columns];
            for stream in 0..texture.filters.len() {
                let mut amplitudes = vec![0.0; 2 * taps.len()];
                texture.filtered_noise(stream, start, &mut space, &mut amplitudes);
                let (real, imaginary) = amplitudes.split_at(taps.len());
                let sum = |parts: &[f64]| parts.iter().zip(&taps).map(|(part, weight)| part * weight).sum::<f64>();
                let (a, b) = (sum(real), sum(imaginary));
                for (column, height) in expected.iter_mut().enumerate() {
                    let shape = &texture.shapes[2 * columns * stream + column..];
                    *height += a * shape[0] + b * shape[columns];
                }
            }
            for (column, (found, expected)) in heights[row * columns..].iter().zip(&expected).enumerate() {
                assert!((found - expected).abs() < 1e-12 * rms, "row {row}, column {column}: {found} for {expected}");
            }
        }
    }
}
