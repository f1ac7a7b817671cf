//! From influence functions to what the contact needs: the first weight G0, and the kernels of the history.
//!
//! w_(p)(j) = sum over n = -N/2 ... N/2 - 1 of w_(n,p) exp(2 pi i n j/N): displacement of the element j further on, p steps after a unit force.
//!
//! Tread laws:
//! - `elastic`: influence functions of the tread surface;
//! - `uncoupled`: the same history, but within a step each point only feels itself (the diagonal of G0);
//! - `bedding`: influence functions of the carcass with the tread as mass on it, and one independent spring per element in series.

use super::error::ContactError;
use crate::numeric::Ring;
use crate::scene::Tread;
use crate::tyre::convolution_quadrature::Weights;

/// What the points in contact feel of each other within a step.
#[derive(Clone, Debug)]
pub struct ContactKernel {
    /// The tread law.
    pub law: Tread,
    /// G0 of the element j further on, j = 0..N (periodic) \[m/N\]; springs not included.
    pub instant: Vec<f64>,
    /// Spring compliance per element \[m/N\]; 0 without springs.
    pub spring: f64,
}

impl ContactKernel {
    /// From the first weights w_(n,0), n = 0..=N/2 \[m/N\], of N elements.
    ///
    /// # Errors
    /// [`ContactError::NotPositive`] unless all eigenvalues of the circulant G0 are positive.
    pub fn new(law: Tread, first_weights: &[f64], elements: usize, spring: f64) -> Result<Self, ContactError> {
        let eigenvalues = first_weights.iter().map(|weight| elements as f64 * weight + spring);
        let (smallest, largest) = eigenvalues.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
        if !(smallest > 0.0 && largest.is_finite()) {
            return Err(ContactError::NotPositive { smallest, largest });
        }
        Ok(Self { law, instant: Ring::new(elements).elements_of(|n| first_weights[n]).to_vec(), spring })
    }
}

/// Kernels of the direct history: influence in the contact frame, lag by lag.
#[derive(Clone, Debug)]
pub struct LagKernel {
    /// Rows by lag, see [`LagKernel::lag`].
    lags: Vec<f64>,
    /// Entries per lag.
    row: usize,
}

impl LagKernel {
    /// Transforms the weights of all wavenumbers to the elements a window of `columns` can see of itself, `substeps` steps per element.
    pub fn new(weights: &Weights, elements: usize, columns: usize, substeps: usize) -> Self {
        let mut ring = Ring::new(elements);
        let row = padded(columns) + columns + 1;
        let mut lags = vec![0.0; row * weights.lags];
        for (p, kernel) in lags.chunks_exact_mut(row).enumerate().skip(1) {
            let influence = ring.elements_of(|n| weights.of(n)[p]);
            let first = (p / substeps) as i64 - (columns as i64 - 1);
            for (i, value) in kernel.iter_mut().enumerate() {
                *value = influence[(first + i as i64).rem_euclid(elements as i64) as usize];
            }
        }
        Self { lags, row }
    }

    /// Number of lags, lag 0 included.
    pub fn lags(&self) -> usize {
        self.lags.len() / self.row
    }

    /// Kernel of lag p: entry r is the influence on the element r - (columns - 1) + floor(p/q) further on.
    pub fn lag(&self, p: usize) -> &[f64] {
        &self.lags[p * self.row..(p + 1) * self.row]
    }
}

/// Columns rounded up to whole vectors of eight.
pub fn padded(columns: usize) -> usize {
    columns.div_ceil(8) * 8
}
