//! Rational approximation of transfer functions H(s) with H(conj s) = conj H(s), sampled on the upper imaginary axis.
//!
//! - [`Samples`]: what is fitted;
//! - [`partial_fractions`]: sum of residues over poles, plus a constant: the form in which everything is handed on;
//! - `parts`: the same at many points at once;
//! - [`least_squares`]: Householder elimination, shared by all that follows;
//! - `basis`, `normal_equations`: the same by products of columns, where poles are only to be moved;
//! - [`aaa`]: adaptive Antoulas-Anderson, the start: finds how many poles are needed, and roughly where;
//! - [`vector_fitting`]: moves given poles to where several responses want them, stable by construction, and refits
//!   residues.

pub(crate) mod aaa;
mod basis;
pub(crate) mod least_squares;
mod normal_equations;
pub(crate) mod partial_fractions;
mod parts;
mod secular;
pub(crate) mod vector_fitting;

pub(crate) use partial_fractions::PartialFractions;
pub(crate) use parts::ComplexParts;

use num_complex::Complex64;
use thiserror::Error;

/// Errors of a rational fit.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum RationalError {
    /// Too few samples to determine the unknowns.
    #[error("{samples} samples cannot determine {unknowns} real unknowns")]
    TooFewSamples {
        /// Complex samples given.
        samples: usize,
        /// Real unknowns.
        unknowns: usize,
    },
    /// A sample or a result that is not finite.
    #[error("{stage} met a value that is not finite")]
    NotFinite {
        /// Stage of the fit.
        stage: &'static str,
    },
    /// The eigenvalue or singular value iteration did not converge.
    #[error("{stage}: the iteration for eigenvalues or singular values did not converge")]
    NoConvergence {
        /// Stage of the fit.
        stage: &'static str,
    },
}

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
    fn check(&self, unknowns: usize, stage: &'static str) -> Result<(), RationalError> {
        if 2 * self.points.len() < unknowns {
            return Err(RationalError::TooFewSamples { samples: self.points.len(), unknowns });
        }
        let finite = self.responses.iter().flatten().all(|value| value.is_finite());
        if finite { Ok(()) } else { Err(RationalError::NotFinite { stage }) }
    }
}
