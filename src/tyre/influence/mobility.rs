//! Driving-point mobility of the tread surface at mid-width.
//!
//! Y = s sum_n sum_m (1/L) sinc^2(kx a/2) (2/B) a_m^2 C_zz for a square patch a x a, loaded uniformly, its mean
//! velocity observed (the paper's figures 1 and 2). C_zz at a wavenumber serves all patches at once. Below a cut-off
//! wavenumber it is evaluated; above, the tread is a half-space whose moments are summed per patch to [`LOBES`] lobes
//! of sinc^2. The rest is below 1/(2 pi LOBES)^2 of the local part: 1e-4 dB. What curvature does to waves beyond
//! `thickness_limit` is left out: 3e-4 dB at 5 mm and 3 kHz, less for larger patches and lower frequencies (measured).

use std::f64::consts::PI;

use num_complex::Complex64;

use super::kernel::{Field, Kernel};
use super::waves::Waves;
use crate::numeric::{in_parallel, sinc};
use crate::scene::Tyre;
use crate::tyre::layers::material::modulus_ratio;
use crate::tyre::layers::surface_asymptote::{LARGEST_ARGUMENT, TERMS, series, thickness_limit};

/// Lobes of sinc^2 along and across that are summed.
pub(crate) const LOBES: f64 = 24.0;

/// Relative accuracy at which the tread counts as a half-space.
const TOLERANCE: f64 = 1e-6;

/// Mobility of several patches over frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Mobility {
    /// Side lengths a \[m\], one per column.
    pub patches: Vec<f64>,
    /// Frequencies \[Hz\], one per row.
    pub frequencies: Vec<f64>,
    /// Y \[m/(N s)\]: one row per frequency, one column per patch.
    pub values: Vec<Vec<Complex64>>,
    /// Evaluations of the compliance used.
    pub evaluations: u64,
}

/// Weights of a patch: (1/L) sinc^2 for n = 0, 1, ... (negative n included) and (2/B) a_m^2 for the m that it excites.
struct PatchWeights {
    longitudinal: Vec<f64>,
    lateral: Vec<f64>,
}

/// Level of a mobility \[dB re 1 m/(N s)\].
pub(crate) fn level(value: Complex64) -> f64 {
    20.0 * value.norm().log10()
}

/// Phase of a mobility \[degrees\].
pub(crate) fn phase(value: Complex64) -> f64 {
    value.arg().to_degrees()
}

/// So many frequencies at equal ratios, lowest first; both ends exact.
pub(crate) fn frequencies(from: f64, to: f64, points: u32) -> Vec<f64> {
    let (last, ratio) = (points.saturating_sub(1), to / from);
    (0..points).map(|k| if k == last { to } else { from * ratio.powf(f64::from(k) / f64::from(last)) }).collect()
}

/// Driving-point mobility of square patches of the given side lengths \[m\] at frequencies \[Hz\]. A tread under
/// tension has no half-space limit; then every term up to the last lobe is evaluated.
pub fn driving_point(tyre: &Tyre, patches: &[f64], frequencies: &[f64]) -> Mobility {
    // 1. Weights of the patches up to their last lobe.
    let waves = Waves::new(tyre);
    let highest = patches.iter().fold(0.0_f64, |k, &a| k.max(2.0 * PI * LOBES / a));
    let weights: Vec<PatchWeights> = patches.iter().map(|&a| patch_weights(a, highest, waves)).collect();
    // 2. The cut-off: above it the tread is a half-space whose series converges at the highest frequency.
    let top = frequencies.iter().fold(0.0_f64, |a, &b| a.max(b));
    let kernel = Kernel::new(tyre, 2.0 * PI * top, TOLERANCE);
    let tread = kernel.tread();
    let at_top = kernel.at(Complex64::new(0.0, 2.0 * PI * top));
    let shear_wavenumber = at_top.tread().inertia_over_shear().norm().sqrt();
    let cut_off = match tread {
        Some(tread) => {
            thickness_limit(tread.thickness, TOLERANCE).max(shear_wavenumber / LARGEST_ARGUMENT.sqrt()).min(highest)
        }
        None => highest,
    };
    kernel.prepare(cut_off);
    let coefficients = tread.map_or([0.0; TERMS], |tread| series(modulus_ratio(tread.material.poisson)));
    // 3. Moments of the weights above the cut-off, by patch.
    let moments = in_parallel::map(&weights, |weights| moments(weights, waves, cut_off));

    let rows: Vec<(Vec<Complex64>, u64)> = in_parallel::map(frequencies, |&frequency| {
        let s = Complex64::new(0.0, 2.0 * PI * frequency);
        let at = kernel.at(s);
        // 4. At each frequency: explicit terms below the cut-off, for all patches at once, then the series.
        let mut sums = vec![Complex64::ZERO; patches.len()];
        let mut evaluations = 0;
        for (n, kx) in (0..).map(|n| (n, waves.kx(n))).take_while(|(_, kx)| *kx < cut_off) {
            let mut rows = vec![Complex64::ZERO; patches.len()];
            let lateral = waves.lateral_numbers().take_while(|&m| kx.hypot(waves.ky(m)) < cut_off);
            for (index, m) in lateral.enumerate() {
                let compliance = at.normal(n, m, Field::Surface);
                evaluations += 1;
                for (row, weights) in rows.iter_mut().zip(&weights) {
                    *row += compliance * weights.lateral.get(index).copied().unwrap_or(0.0);
                }
            }
            for ((sum, row), weights) in sums.iter_mut().zip(rows).zip(&weights) {
                *sum += row * weights.longitudinal.get(n as usize).copied().unwrap_or(0.0);
            }
        }
        // Half-space above the cut-off: sum of coefficient (Q/mu)^j/mu times moment j.
        let ratio = at.tread().inertia_over_shear();
        for (sum, moments) in sums.iter_mut().zip(&moments) {
            let mut power = at.tread().inverse_shear;
            for (coefficient, moment) in coefficients.iter().zip(moments) {
                *sum += power * (coefficient * moment);
                power *= ratio;
            }
        }
        (sums.into_iter().map(|sum| sum * s).collect(), evaluations)
    });
    Mobility {
        patches: patches.to_vec(),
        frequencies: frequencies.to_vec(),
        evaluations: rows.iter().map(|row| row.1).sum(),
        values: rows.into_iter().map(|row| row.0).collect(),
    }
}

/// Weights of a patch of side length `a` up to its last lobe, or to `highest` \[1/m\].
fn patch_weights(a: f64, highest: f64, waves: Waves) -> PatchWeights {
    let Waves { circumference: length, width, .. } = waves;
    let limit = (2.0 * PI * LOBES / a).min(highest);
    let columns = (limit * length / (2.0 * PI)) as usize + 1;
    let rows = (limit * width / (2.0 * PI)) as usize + 1;
    let square = |x: f64| sinc(x).powi(2);
    PatchWeights {
        // n and -n together.
        longitudinal: (0..columns)
            .map(|n| square(PI * n as f64 * a / length) / length * if n == 0 { 1.0 } else { 2.0 })
            .collect(),
        lateral: waves.lateral_numbers().take(rows).map(|m| waves.lateral_weight(m, a)).collect(),
    }
}

/// Moments sum weight k^-(2j+1) of a patch above the cut-off \[1/m\].
fn moments(weights: &PatchWeights, waves: Waves, cut_off: f64) -> [f64; TERMS] {
    let mut total = [0.0; TERMS];
    for (n, longitudinal) in (0..).zip(&weights.longitudinal) {
        for (m, lateral) in waves.lateral_numbers().zip(&weights.lateral) {
            let k_squared = waves.kx(n).powi(2) + waves.ky(m).powi(2);
            if k_squared >= cut_off * cut_off {
                super::moments::add(pulp::Scalar::new(), &mut total, longitudinal * lateral, k_squared);
            }
        }
    }
    total
}
