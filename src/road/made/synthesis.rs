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

use pulp::Arch;
use rayon::prelude::*;
use rustfft::{Fft, FftPlanner, num_complex::Complex64};

use super::noise::{Interpolation, LateralSum, Taps, normal_pairs};
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
        let (mut taps, mut weights, mut row_taps) = (Vec::new(), Vec::new(), Vec::with_capacity(rows));
        for row in 0..rows {
            let start = self.interpolation.weights(position(row), 1.0, &mut taps);
            weights.extend_from_slice(&taps);
            row_taps.push(Taps { start: (start - first_sample) as usize, end: weights.len() });
        }
        let length = self.forward.len();
        let arch = Arch::new();
        let components: Vec<Vec<[f64; 2]>> = (0..self.filters.len())
            .into_par_iter()
            .map_init(
                || Workspace {
                    parts: [vec![0.0; length], vec![0.0; length]],
                    line: vec![Complex64::default(); length],
                    scratch: vec![Complex64::default(); self.forward.get_inplace_scratch_len()],
                },
                |work, stream| {
                    self.filtered_noise(stream, first_sample, work);
                    let [real, imaginary] = &work.parts;
                    arch.dispatch(Interpolation { rows: &row_taps, weights: &weights, real, imaginary })
                },
            )
            .collect();
        let mut heights = vec![0.0; rows * columns];
        const BLOCK: usize = 16;
        heights.par_chunks_mut(BLOCK * columns).enumerate().for_each(|(block, heights)| {
            let (components, shapes) = (&components, &self.shapes);
            arch.dispatch(LateralSum { heights, columns, first: block * BLOCK, components, shapes });
        });
        heights
    }

    /// Noise of one stream from sample `first` on, filtered, in the work's parts; valid from `reach` samples inside.
    fn filtered_noise(&self, stream: usize, first: i64, work: &mut Workspace) {
        let Workspace { parts: [real, imaginary], line: noise, scratch } = work;
        normal_pairs(self.seed, stream as u64, first, real, imaginary);
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
        for ((sample, re), im) in noise.iter().zip(real).zip(imaginary) {
            (*re, *im) = (sample.re, sample.im);
        }
    }
}

/// Arrays of one thread.
struct Workspace {
    parts: [Vec<f64>; 2],
    line: Vec<Complex64>,
    scratch: Vec<Complex64>,
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
