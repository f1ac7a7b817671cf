//! Points at which the exact influence functions may be sampled, shared by all wavenumbers.
//!
//! On the imaginary axis a ladder of [`RUNGS`] + 1 angular frequencies, w_i = w0 ((1 + top/w0)^(i/RUNGS) - 1): linear
//! below w0, where a viscoelastic tyre is smooth, logarithmic above, where resonances have widths proportional to
//! frequency. On the positive real axis a short ladder, factors of 2^0.4 up to the top.

use std::f64::consts::PI;
use std::ops::Range;

use num_complex::Complex64;

use crate::numeric::rational::ComplexParts;

/// Intervals on the imaginary axis; a power of two, so that intervals can be halved.
pub(super) const RUNGS: usize = 2048;
/// Points on the positive real axis: odd ones, the top among them, for fits, even ones for checks; no check lies where
/// a fit would have to extrapolate.
const REAL_RUNGS: usize = 24;
/// Rungs on the positive real axis; those below are on the imaginary one.
pub(super) const REAL: Range<usize> = RUNGS + 1..RUNGS + 1 + REAL_RUNGS;
/// Angular frequency at which the ladder turns from linear to logarithmic \[rad/s\].
const KNEE: f64 = 2.0 * PI * 10.0;
/// Points above the top where passivity is checked, at factors of sqrt(2).
const BEYOND: usize = 20;

/// Both ladders, one after the other.
#[derive(Clone, Debug)]
pub(super) struct Ladder {
    /// Top of both \[rad/s\].
    pub top: f64,
    /// s on the imaginary axis, rising from 0, then on the positive real axis, rising: [`REAL`].
    pub points: Vec<Complex64>,
    /// Points of the passivity check: every eighth rung of the axis, and beyond the band.
    pub checked: Vec<Complex64>,
    /// `checked` as real and imaginary parts.
    pub checked_parts: ComplexParts,
}

impl Ladder {
    pub(super) fn new(top: f64) -> Self {
        let growth = (top / KNEE).ln_1p() / RUNGS as f64;
        let mut points: Vec<_> =
            (0..=RUNGS).map(|rung| Complex64::new(0.0, KNEE * (growth * rung as f64).exp_m1())).collect();
        let beyond = (1..=BEYOND).map(|i| Complex64::new(0.0, points[RUNGS].im * 2f64.powf(0.5 * i as f64)));
        let checked: Vec<_> = points.iter().skip(4).step_by(8).copied().chain(beyond).collect();
        let below_top = |rung: usize| 0.5_f64.powf(0.4 * (REAL.end - 1 - rung) as f64);
        points.extend(REAL.map(|rung| Complex64::new(top * below_top(rung), 0.0)));
        Self { top, checked_parts: ComplexParts::new(checked.iter().copied(), 1.0), points, checked }
    }
}
