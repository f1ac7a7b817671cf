//! Drawing a random surface piece by piece.
//!
//! Across, the surface is a Fourier series of period P (several longest wavelengths): z(x, y) = sum over m of
//! a_m(x) cos(2 pi m y/P) + b_m(x) sin(2 pi m y/P). For an isotropic Gaussian surface all a_m, b_m are independent
//! stationary Gaussian processes along x, the two-sided spectrum of each being 2 G_m(kx) (m = 0: G_0, no b),
//! G_m = integral of S(kx, ky) over the m-th cell of ky, 1/P wide: the profile spectrum along x is then exact whatever P.
//!
//! 1. White noise on a lattice of `spacing` h along x, a stream of its own for every m, addressable by sample: sample n of
//!    stream m is the same number whenever and by whomever it is asked for, also for negative n.
//! 2. The filter of stream m, sqrt(2 G_m/h) times the low-pass of the run's elements, is made once in the frequency domain,
//!    its impulse response cut softly to a reach of several longest wavelengths, its energy restored.
//! 3. A chunk of elements: noise around it, transform, multiply, transform back (overlap-save), then interpolation
//!    from the lattice to the elements by a windowed sinc; a_m and b_m ride as real and imaginary part.
//! 4. Columns: the series is summed at the columns' y, components beyond the lateral Nyquist wavenumber left out.
//!
//! The spectrum is scene data and the noise belongs to the lattice, so the road is the same at any number of elements, up to
//! what the elements can resolve. Chunks start at fixed elements: results do not depend on the order of access nor
//! on the number of threads. Cost per chunk: two transforms of length M per m, and rows x columns x 2 m_max
//! multiply-adds; memory 16 M bytes per thread, 8 M m_max for filters, 16 m_max rows for the components.

use std::f64::consts::PI;
use std::sync::Arc;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use rustfft::{Fft, FftPlanner, num_complex::Complex64};

use super::rings::RingSpectrum;
use super::target::TargetSpectrum;
use crate::numeric::windowed_sinc::WindowedSinc;
use crate::road::error::RoadError;
use crate::road::lattice::{Lattice, positive};

/// Lateral period and reach of the filters, in longest wavelengths.
const PERIOD_IN_WAVELENGTHS: f64 = 8.0;
/// Smallest lateral period \[m\].
const SMALLEST_PERIOD: f64 = 1.0;
/// Sub-cells of one lateral cell over which S is averaged.
const SUBCELLS: usize = 6;
/// Random words (32 bit) per complex sample: two 64-bit numbers.
const WORDS_PER_SAMPLE: u128 = 4;
/// Sample 0's place in its stream: far enough in for any negative coordinate.
const ORIGIN: i128 = 1 << 60;
/// Share of the Nyquist wavenumber below which the low-pass is flat; a raised cosine from there to it.
const PASS: f64 = 0.8;
/// Largest share of the lattice's sampling wavenumber that the spectrum may reach.
const LARGEST_SHARE: f64 = 0.45;

/// A random isotropic surface on a run's lattice.
pub struct Texture {
    spectrum: RingSpectrum,
    lattice: Lattice,
    spacing: f64,
    seed: u64,
    /// Elements per chunk.
    chunk_rows: usize,
    /// Samples on either side that a filtered sample depends on.
    reach: usize,
    forward: Arc<dyn Fft<f64>>,
    backward: Arc<dyn Fft<f64>>,
    /// Transfer function of stream m at lines 0 to half the length (it is real and even), scaled for the round trip.
    filters: Vec<Vec<f64>>,
    /// Cosine and sine at the columns, per m: `2 columns` entries.
    shapes: Vec<Vec<f64>>,
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
        positive("road.spacing", spacing)?;
        let (longest, shortest) = (target.longest(), target.shortest());
        let allowed = LARGEST_SHARE * shortest;
        if spacing > allowed * (1.0 + 1e-9) {
            return Err(RoadError::Spacing { spacing, shortest, allowed });
        }
        let lattice_width = lattice.width();
        let mut period = (PERIOD_IN_WAVELENGTHS * longest).max(SMALLEST_PERIOD);
        while period < 2.0 * lattice_width {
            period *= 2.0;
        }
        let share = spacing / shortest;
        let interpolation = WindowedSinc::new(share, 1.0 - share, 80.0);
        let reach = (PERIOD_IN_WAVELENGTHS * longest / spacing).ceil();
        let margin = 2.0 * (reach + interpolation.half_width() + 2.0);
        let length = (2.0 * margin).max(margin + 16.0 * lattice.dx / spacing).max(1024.0);
        let streams = (period / shortest).ceil() + 1.0;
        let chunk = ((length - margin) * spacing / lattice.dx).floor().max(1.0);
        let needed = length * streams * 8.0 + chunk * 2.0 * (16.0 * streams + 24.0 * lattice.columns as f64);
        if needed.is_nan() || needed > limit as f64 {
            return Err(RoadError::TextureTooLarge { longest, spacing, needed: needed as u64, limit });
        }
        let length = (length as usize).next_power_of_two();
        let reach = reach as usize;
        let chunk_rows = (((length as f64 - margin) * spacing / lattice.dx) as usize).max(1);
        let mut planner = FftPlanner::new();
        let (forward, backward) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
        let spectrum = RingSpectrum::fit(target);
        let lateral_nyquist = if lattice.columns > 1 { 0.5 / lattice.dy } else { f64::INFINITY };
        let streams = (0..)
            .take_while(|&m| (f64::from(m) - 0.5) / period < spectrum.highest().min(lateral_nyquist))
            .collect::<Vec<u32>>();
        let filters = streams
            .par_iter()
            .map(|&m| filter(&spectrum, m, period, spacing, lattice.dx, reach, &forward, &backward))
            .collect();
        let shape = |&m: &u32| {
            let wavenumber = f64::from(m) / period;
            let gain = low_pass(wavenumber, lateral_nyquist);
            let phases = (0..lattice.columns).map(move |column| 2.0 * PI * wavenumber * lattice.y(column));
            phases.clone().map(|phase| gain * phase.cos()).chain(phases.map(|phase| gain * phase.sin())).collect()
        };
        let shapes = streams.iter().map(shape).collect();
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

    /// Elements per chunk.
    pub fn chunk_rows(&self) -> usize {
        self.chunk_rows
    }

    /// The two-dimensional spectrum and how well it meets the target.
    pub fn spectrum(&self) -> &RingSpectrum {
        &self.spectrum
    }

    /// Heights \[m\] of chunk `chunk`: elements chunk * [`Self::chunk_rows`] and following, row-major, rows x columns.
    pub fn chunk(&self, chunk: i64) -> Vec<f64> {
        let rows = self.chunk_rows;
        let columns = self.lattice.columns;
        let ratio = self.lattice.dx / self.spacing;
        let first_element = chunk as f64 * rows as f64;
        let position = |row: usize| (first_element + row as f64) * ratio;
        let half_width = self.interpolation.half_width() as i64;
        let first_sample = position(0).floor() as i64 - half_width - self.reach as i64;
        let mut taps = Vec::new();
        let mut starts = Vec::with_capacity(rows);
        let mut weights = Vec::with_capacity(rows * (2 * half_width as usize + 1));
        let mut ends = Vec::with_capacity(rows);
        for row in 0..rows {
            let start = self.interpolation.weights(position(row), 1.0, &mut taps);
            starts.push((start - first_sample) as usize);
            weights.extend_from_slice(&taps);
            ends.push(weights.len());
        }
        let components: Vec<Vec<Complex64>> = (0..self.filters.len())
            .into_par_iter()
            .map_init(
                || (Vec::new(), vec![Complex64::default(); self.forward.get_inplace_scratch_len()]),
                |(noise, scratch), stream| {
                    self.filtered_noise(stream, first_sample, noise, scratch);
                    let mut begin = 0;
                    let interpolate = |(&start, &end): (&usize, &usize)| {
                        let row_weights = &weights[begin..end];
                        begin = end;
                        let samples = &noise[start..start + row_weights.len()];
                        samples.iter().zip(row_weights).map(|(sample, weight)| sample * weight).sum()
                    };
                    starts.iter().zip(&ends).map(interpolate).collect()
                },
            )
            .collect();
        let mut heights = vec![0.0; rows * columns];
        const BLOCK: usize = 16;
        heights.par_chunks_mut(BLOCK * columns).enumerate().for_each(|(block, out)| {
            for (component, shape) in components.iter().zip(&self.shapes) {
                let (cosines, sines) = shape.split_at(columns);
                for (row, amplitude) in out.chunks_exact_mut(columns).zip(&component[block * BLOCK..]) {
                    for ((height, cosine), sine) in row.iter_mut().zip(cosines).zip(sines) {
                        *height += amplitude.re * cosine + amplitude.im * sine;
                    }
                }
            }
        });
        heights
    }

    /// Noise of one stream from sample `first` on, filtered in place; valid from `reach` samples inside.
    fn filtered_noise(&self, stream: usize, first: i64, noise: &mut Vec<Complex64>, scratch: &mut [Complex64]) {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(stream as u64);
        random.set_word_pos((ORIGIN + i128::from(first)) as u128 * WORDS_PER_SAMPLE);
        noise.clear();
        noise.extend((0..self.forward.len()).map(|_| normal_pair(&mut random)));
        self.forward.process_with_scratch(noise, scratch);
        let filter = &self.filters[stream];
        let (lower, upper) = noise.split_at_mut(filter.len());
        for (line, gain) in lower.iter_mut().zip(filter).chain(upper.iter_mut().zip(filter[1..].iter().rev().skip(1))) {
            *line *= gain;
        }
        self.backward.process_with_scratch(noise, scratch);
    }
}

/// Two independent standard normal numbers (Box and Muller), from exactly two 64-bit random numbers.
fn normal_pair(random: &mut ChaCha8Rng) -> Complex64 {
    let unit = 1.0 / (1_u64 << 53) as f64;
    // In (0, 1], so that the logarithm is finite.
    let radius = (-2.0 * (((random.next_u64() >> 11) + 1) as f64 * unit).ln()).sqrt();
    Complex64::from_polar(radius, 2.0 * PI * (random.next_u64() >> 11) as f64 * unit)
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
    m: u32,
    period: f64,
    spacing: f64,
    dx: f64,
    reach: usize,
    forward: &Arc<dyn Fft<f64>>,
    backward: &Arc<dyn Fft<f64>>,
) -> Vec<f64> {
    let length = forward.len();
    let cell = 1.0 / period;
    let sides = if m == 0 { 1.0 } else { 2.0 };
    let density = |kx: f64| {
        let sum: f64 = (0..SUBCELLS)
            .map(|sub| (f64::from(m) - 0.5 + (sub as f64 + 0.5) / SUBCELLS as f64) * cell)
            .map(|ky| spectrum.density(kx * kx + ky * ky))
            .sum();
        sides * cell * sum / SUBCELLS as f64
    };
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
