//! Difference of a belt with free edges to one on guided sides with its sidewalls spread over the width, between waves
//! of one parity.
//!
//! With Y the compliance of the section without forces at its edges, o its waves, e the motions of its edges
//! (`super::edge_stiffness`) and those that springs hold (`super::section_compliance`), and K the forces there by
//! these motions, less the springs:
//!
//! ```text
//! Delta = Y_oo - Y_oe K (1 + Y_ee K)^-1 Y_eo,   less the diagonal of the guided waves.
//! ```
//!
//! Delta is symmetric and M/2 + 1 or less in rank. Waves above M stay guided ones: they do not reach the
//! belt, and the free edge of the tread, which is left out of them, changes their C by 0.4/m, motion that a strip some
//! thickness of the tread away from the edge does not meet.

use faer::Mat;
use num_complex::Complex64;

use super::edge_stiffness::EdgeForces;
use super::lateral_shapes::{LateralShapes, LateralWave};
use super::section_compliance::{MOTIONS, SectionCompliance};
use crate::numeric::sinc;

/// Difference between free edges and guided sides with spread sidewalls, for one n, parity, s.
#[derive(Clone, Debug)]
pub struct EdgeCorrection {
    width: f64,
    waves: Vec<LateralWave>,
    /// Amplitude of w on the tread of wave i per force on that of wave j \[m/(N/rad)\].
    amplitudes: Mat<Complex64>,
    /// Amplitudes on guided sides, the diagonal \[m/(N/rad)\].
    guided: Vec<Complex64>,
}

impl EdgeCorrection {
    pub(super) fn new(width: f64, shapes: &LateralShapes, compliance: &SectionCompliance, forces: &EdgeForces) -> Self {
        let whole = compliance.under(&forces.stiffness);
        let amplitudes = Mat::from_fn(shapes.waves.len(), shapes.waves.len(), |i, j| {
            let difference = if i == j { compliance.held[i] - compliance.guided[i] } else { Complex64::ZERO };
            whole[(MOTIONS + i, MOTIONS + j)] + difference
        });
        Self { width, waves: shapes.waves.clone(), amplitudes, guided: compliance.guided.clone() }
    }

    /// Lateral numbers m of the waves that the edges correct, rising.
    pub fn waves(&self) -> impl ExactSizeIterator<Item = usize> {
        self.waves.iter().map(|wave| wave.number)
    }

    /// Amplitude of w on the tread in the wave at one place of [`Self::waves`] per generalised force on the amplitude
    /// of another one \[m/(N/rad)\].
    pub fn amplitude(&self, place: usize, other: usize) -> Complex64 {
        self.amplitudes[(place, other)]
    }

    /// Compliance between two waves, int cos(k_i y') w dy for a normal load cos(k_j y') N/m per radian \[m^2/(N/rad)\];
    /// waves above the largest of [`Self::waves`], or of the other parity, get none.
    pub fn between(&self, m: usize, other: usize) -> Complex64 {
        let [Some(i), Some(j)] = self.places(m, other) else { return Complex64::ZERO };
        self.amplitudes[(i, j)] * (self.waves[i].norm * self.waves[j].norm)
    }

    fn places(&self, m: usize, other: usize) -> [Option<usize>; 2] {
        [m, other].map(|m| self.waves.iter().position(|wave| wave.number == m))
    }

    /// As [`Self::between`], of the whole belt: with the guided wave, where both are the same; `None` for a wave that
    /// the edges do not correct.
    pub fn compliance(&self, m: usize, other: usize) -> Option<Complex64> {
        let [Some(i), Some(j)] = self.places(m, other) else { return None };
        let guided = if i == j { self.guided[i] } else { Complex64::ZERO };
        Some((self.amplitudes[(i, j)] + guided) * (self.waves[i].norm * self.waves[j].norm))
    }

    /// Number to add to the sum over guided waves with spread sidewalls: mean of w over a centred strip of a width
    /// \[m\] for a unit force per radian, uniform over the strip \[m/(N/rad)\]. Waves of odd parity do not move it.
    pub fn strip(&self, strip: f64) -> Complex64 {
        let shares: Vec<f64> = self.waves.iter().map(|wave| strip_share(wave, self.width, strip)).collect();
        let mut sum = Complex64::ZERO;
        for (i, one) in shares.iter().enumerate() {
            for (j, other) in shares.iter().enumerate() {
                sum += self.amplitudes[(i, j)] * (one * other);
            }
        }
        sum
    }
}

/// Mean of cos(k_m y') over a centred strip.
fn strip_share(wave: &LateralWave, width: f64, strip: f64) -> f64 {
    (0.5 * wave.wavenumber * width).cos() * sinc(0.5 * wave.wavenumber * strip)
}
