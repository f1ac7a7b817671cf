//! Interpolation along in rows of samples, in vectors.

use pulp::NullaryFnOnce;

/// Columns are padded to a multiple of this: whole vectors of any instruction set.
pub(super) const LANES: usize = 16;
/// A weighted sum of rows of samples, added to a row; all rows consist of whole vectors.
pub(super) struct Interpolation<'a> {
    /// The row that is added to.
    pub sums: &'a mut [[f32; LANES]],
    /// One weight for each row of samples.
    pub weights: &'a [f32],
    /// The samples from the first row on.
    pub samples: &'a [[f32; LANES]],
}

impl NullaryFnOnce for Interpolation<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { sums, weights, samples } = self;
        let vectors = sums.len();
        for (column, sum) in sums.iter_mut().enumerate() {
            let mut total = *sum;
            // By index: the iterator over rows is not inlined where nothing is optimised across units.
            for tap in 0..weights.len() {
                let (weight, samples) = (weights[tap], &samples[tap * vectors + column]);
                for lane in 0..LANES {
                    total[lane] += weight * samples[lane];
                }
            }
            *sum = total;
        }
    }
}
