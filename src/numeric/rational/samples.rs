//! Samples of the responses to be fitted.

use num_complex::Complex64;

use super::RationalError;

/// Samples of Q responses at common points.
#[derive(Clone, Debug, Default)]
pub(crate) struct Samples {
    /// s_k \[1/s\].
    pub points: Vec<Complex64>,
    /// Row q: H_q(s_k).
    pub responses: Vec<Vec<Complex64>>,
    /// One weight per response: the reciprocal of the error that counts as 1.
    pub weights: Vec<f64>,
    /// One weight per point, for all responses.
    pub point_weights: Vec<f64>,
}

impl Samples {
    /// Checks that responses are finite and samples enough for so many real unknowns.
    pub(super) fn check(&self, unknowns: usize, stage: &'static str) -> Result<(), RationalError> {
        if 2 * self.points.len() < unknowns {
            return Err(RationalError::TooFewSamples { samples: self.points.len(), unknowns });
        }
        let finite = self.responses.iter().flatten().all(|value| value.is_finite());
        if finite { Ok(()) } else { Err(RationalError::NotFinite { stage }) }
    }
}
