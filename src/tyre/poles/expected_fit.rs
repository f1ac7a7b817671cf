//! Expected cost and poles of a fit, before it is done: from those of the flat car tyre.

use crate::scene::{Layer, Tyre};
use crate::tyre::poles::ladder::REAL;

/// By resolution N: poles of the default tyre at 1e-5, and time of its fit relative to N = 512 (measured).
const FITS: [(f64, f64, f64); 7] = [
    (128.0, 3940.0, 0.93),
    (256.0, 7309.0, 0.92),
    (512.0, 11_101.0, 1.0),
    (1024.0, 18_437.0, 1.12),
    (2048.0, 30_141.0, 1.42),
    (4096.0, 49_604.0, 2.08),
    (8192.0, 88_053.0, 4.46),
];
/// Time of a fit by decade of its tolerance, from 1e-3, relative to 1e-5.
const BY_TOLERANCE: [f64; 5] = [0.46, 0.65, 1.0, 1.6, 4.1];
/// Growth of the number of poles with a decade of tolerance.
const POLES_BY_DECADE: f64 = 1.25;
/// Growth of a fit's time with the number of layers: exponent, relative to two.
const BY_LAYERS: f64 = 0.37;
/// Evaluations of the compliance in a fit.
pub(crate) const EVALUATIONS: f64 = 2e6;
/// Points at which the tyre's kernel is held.
pub(crate) const POINTS: usize = REAL.end;
/// Bytes held for each thread.
pub(crate) const BYTES: f64 = 26e6;
/// Fraction of them that the allocator retains afterwards (measured).
pub(crate) const RETAINED: f64 = 0.3;

/// Cost of a curved tyre's fit over the flat one's: its waves are prepared first (measured).
const CURVED: f64 = 6.0;
/// Cost of one evaluation of a curved tyre over that of a flat one, in lanes (measured).
pub(crate) const CURVED_EVALUATION: f64 = 3.3;
/// Cost of a curved tyre with cords over one without (measured: 2.0 to 2.5).
const CORDS: f64 = 2.2;
/// Share of a fit's time that the sums take; the rest fits their poles (measured: 0.87 to 0.89).
pub(crate) const SUMS: f64 = 0.88;
/// Time of a tyre that turns over that at rest: waves of both directions, and more for each to prepare (measured).
const TURNING: f64 = 2.1;

/// Cost of a wave prepared for s = 0 alone, in evaluations of a flat tyre (measured).
pub(crate) const WAVE_AT_REST: f64 = 1400.0;

/// Expected number of poles, conjugates counted, of a fit with so many elements to a tolerance.
pub(crate) fn poles(elements: f64, tolerance: f64) -> f64 {
    of_elements(elements).0 * POLES_BY_DECADE.powf(-tolerance.log10() - 5.0)
}

/// Expected time relative to that of the default tyre with 512 elements to 1e-5.
pub(crate) fn share(elements: f64, tolerance: f64, tyre: &Tyre) -> f64 {
    of_elements(elements).1 * growth(tolerance, tyre)
}

/// Ratio of a fit's time, for a tyre to a tolerance, to that for two flat layers at rest to 1e-5.
pub(crate) fn growth(tolerance: f64, tyre: &Tyre) -> f64 {
    let times = |holds: bool, factor: f64| if holds { factor } else { 1.0 };
    let has_cords = tyre.curvature && !tyre.layers.iter().all(Layer::is_isotropic);
    let shape = times(tyre.curvature, CURVED) * times(tyre.turns(), TURNING) * times(has_cords, CORDS);
    let place = (-tolerance.log10() - 3.0).clamp(0.0, BY_TOLERANCE.len() as f64 - 1.0);
    let low = (place as usize).min(BY_TOLERANCE.len() - 2);
    let (a, b) = (BY_TOLERANCE[low], BY_TOLERANCE[low + 1]);
    a * (b / a).powf(place - low as f64) * (0.5 * tyre.layers.len() as f64).powf(BY_LAYERS) * shape
}

/// Poles and time at a resolution: interpolation between the lines of the table, linear in the logarithms; beyond its
/// ends by the last two.
fn of_elements(elements: f64) -> (f64, f64) {
    let place = FITS.iter().position(|entry| entry.0 > elements).unwrap_or(FITS.len() - 1).max(1);
    let (low, high) = (FITS[place - 1], FITS[place]);
    let part = (elements / low.0).ln() / (high.0 / low.0).ln();
    let between = |a: f64, b: f64| a * (b / a).powf(part);
    (between(low.1, high.1), between(low.2, high.2))
}
