//! The points at which the exact influence functions may be sampled, shared by all wavenumbers.
//!
//! On the imaginary axis a ladder of [`RUNGS`] + 1 angular frequencies, w_i = w0 ((1 + top/w0)^(i/RUNGS) - 1): linear
//! below w0, where a viscoelastic tyre is smooth, logarithmic above, where resonances have widths proportional to
//! frequency. On the positive real axis a short ladder, factors of 2^0.4 up to the top. Moduli, cut-offs and asymptotes
//! depend on s only and are worked out once.

use std::f64::consts::PI;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::numeric::rational::Parts;
use crate::tyre::influence::{InfluenceSum, SumAt};

/// Intervals on the imaginary axis; a power of two, so that intervals can be halved.
pub const RUNGS: usize = 2048;
/// Points on the positive real axis: odd ones, the top among them, for fits, even ones for checks; nothing is checked
/// where a fit would have to extrapolate.
pub const REAL_RUNGS: usize = 24;
/// Where the ladder turns from linear to logarithmic \[rad/s\].
const KNEE: f64 = 2.0 * PI * 10.0;

/// Points beyond the band where passivity is checked: factors of sqrt(2) above the top.
const BEYOND: usize = 20;

/// The ladders and the stack on their rungs.
#[derive(Clone, Debug)]
pub struct Ladder {
    /// s on the imaginary axis, rising from 0.
    pub axis: Vec<Complex64>,
    /// s on the positive real axis, rising.
    pub real: Vec<Complex64>,
    /// The stack on the axis.
    pub axis_at: Vec<SumAt>,
    /// The stack on the positive real axis.
    pub real_at: Vec<SumAt>,
    /// Where passivity is checked: every eighth rung of the axis, and beyond the band.
    pub checked: Vec<Complex64>,
    /// The same in parts.
    pub checked_parts: Parts,
}

impl Ladder {
    /// The ladders up to an angular frequency `top` \[rad/s\].
    pub fn new(sum: &InfluenceSum, top: f64) -> Self {
        let growth = (top / KNEE).ln_1p() / RUNGS as f64;
        let axis: Vec<_> =
            (0..=RUNGS).map(|rung| Complex64::new(0.0, KNEE * (growth * rung as f64).exp_m1())).collect();
        let real: Vec<_> = (0..REAL_RUNGS)
            .map(|rung| Complex64::new(top * 0.5_f64.powf(0.4 * (REAL_RUNGS - 1 - rung) as f64), 0.0))
            .collect();
        let at = |points: &[Complex64]| points.par_iter().map(|&s| sum.at(s)).collect();
        let beyond = (1..=BEYOND).map(|i| Complex64::new(0.0, axis[RUNGS].im * 2f64.powf(0.5 * i as f64)));
        let checked: Vec<_> = axis.iter().skip(4).step_by(8).copied().chain(beyond).collect();
        let checked_parts = Parts::new(checked.iter().copied(), 1.0);
        Self { checked, checked_parts, axis_at: at(&axis), real_at: at(&real), axis, real }
    }
}
