//! The waves of a curved tyre, or of its short waves on a shorter ring, each prepared when it is first asked for, and
//! stored.
//!
//! Waves so short that they do not feel the tread's thickness are a flat layer's, as in the sums' tail: the same wave
//! is in the tail at one s and evaluated at another, and a difference would be a step in H_n(s). What that leaves out,
//! 1e-3 of C at 3 kHz, the sums add afterwards for all such waves together ([`super::short_waves`]).

use std::sync::OnceLock;

use super::short_waves::EXPECTED_WAVES;
use super::waves::Waves;
use crate::numeric::in_parallel;
use crate::scene::Tyre;
use crate::tyre::layers::cylinder::{Cylinder, CylinderWave};
use crate::tyre::layers::surface_asymptote::thickness_limit;

/// Tolerance of a wave over that of the sums: a tenth of the tolerance of poles. Even a coarse wave is smooth in s.
const COARSER: f64 = 10.0;

/// Prepared waves, by n and m.
#[derive(Debug)]
pub(super) struct CurvedWaves {
    pub(super) cylinder: Cylinder,
    tyre: Tyre,
    tolerance: f64,
    waves: Waves,
    /// Periods round the tyre of a wave of one period round the ring.
    periods: f64,
    /// Wavenumber from which on waves are a flat layer's \[1/m\].
    pub(super) below: f64,
    /// Number of lateral numbers m below it, at most.
    columns: usize,
    /// Row |n|, column m.
    prepared: Vec<OnceLock<Box<CylinderWave>>>,
}

/// Bytes per layer of a prepared wave (measured), and the excess where the tyre turns.
const LAYER_BYTES: f64 = 1.2e4;
const TURNING_LAYER_BYTES: f64 = 5.2e4;

fn flat_from(tyre: &Tyre, tolerance: f64) -> f64 {
    let thickness = tyre.layers.last().map_or(tyre.circumference, |tread| tread.thickness);
    thickness_limit(thickness, tolerance)
}

/// Bytes of the waves that sums within a relative `tolerance` prepare.
pub(crate) fn wave_bytes(tyre: &Tyre, tolerance: f64) -> f64 {
    let each = LAYER_BYTES + if tyre.turns() { TURNING_LAYER_BYTES } else { 0.0 };
    each * tyre.layers.len() as f64 * wave_count(tyre, tolerance)
}

/// Bytes of the products of polynomials that layers with cords, or orthotropic ones, need for all degrees: their waves
/// have steep displacements, and hardly two of them the same degree. Other layers need a few degrees.
pub(crate) fn steep_bytes(tyre: &Tyre) -> f64 {
    let steep = tyre.layers.iter().filter(|layer| tyre.curvature && !layer.is_isotropic()).count();
    steep as f64 * Cylinder::PRODUCT_BYTES
}

/// Number of waves that sums within a relative `tolerance` prepare, roughly; 0 for a flat tyre.
pub(crate) fn wave_count(tyre: &Tyre, tolerance: f64) -> f64 {
    if !tyre.curvature {
        return 0.0;
    }
    let (waves, limit) = (Waves::new(tyre), flat_from(tyre, tolerance));
    // A quarter of a disc over n and over every other m.
    let disc = 0.25 * std::f64::consts::PI * (limit / waves.kx(1) + 1.0) * (0.5 * limit / waves.ky(1) + 1.0);
    disc + EXPECTED_WAVES
}

impl CurvedWaves {
    /// For a ring's waves, |s| up to `largest_s` \[1/s\] and values within a relative `tolerance`.
    pub(super) fn new(tyre: &Tyre, waves: Waves, largest_s: f64, tolerance: f64) -> Self {
        let below = flat_from(tyre, tolerance);
        let columns = (below / waves.ky(1)) as usize + 1;
        let rows = (below / waves.kx(1)) as usize + 1;
        Self {
            cylinder: Cylinder::new(tyre, largest_s, COARSER * tolerance),
            tyre: tyre.clone(),
            tolerance,
            waves,
            periods: tyre.circumference / waves.circumference,
            below,
            columns,
            prepared: (0..rows * columns).map(|_| OnceLock::new()).collect(),
        }
    }

    /// The same waves for s = 0 alone: less work each.
    pub(super) fn at_rest(&self) -> Self {
        Self::new(&self.tyre, self.waves, 0.0, self.tolerance)
    }

    /// Prepares the waves below a wavenumber \[1/m\] whose m a centred strip excites, on all threads: for sums that
    /// would ask for the same waves from every thread.
    pub(super) fn prepare(&self, cut_off: f64) {
        in_parallel::each((cut_off / self.waves.kx(1)) as usize + 1, &|n| {
            let n = n as i64;
            let below = |m: &usize| self.waves.kx(n).hypot(self.waves.ky(*m)) < cut_off;
            for m in self.waves.lateral_numbers().take_while(below) {
                self.get(n, m);
            }
        });
    }

    /// True if the waves n and -n differ.
    #[inline(always)]
    pub(super) fn turns(&self) -> bool {
        self.tyre.turns()
    }

    /// The wave (|n|, m), which serves n and -n; `None`: a flat layer's serves.
    #[inline]
    pub(super) fn get(&self, n: i64, m: usize) -> Option<&CylinderWave> {
        if self.waves.kx(n).hypot(self.waves.ky(m)) >= self.below {
            return None;
        }
        let row = n.unsigned_abs() as usize;
        let wave = self.prepared.get(row * self.columns + m)?;
        Some(wave.get_or_init(|| Box::new(self.cylinder.wave_on_ring(row as f64 * self.periods, m))))
    }
}
