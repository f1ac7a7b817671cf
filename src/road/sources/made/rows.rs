//! Rows of heights interpolated along in rows of samples: the weights of all places between two samples from a table,
//! and the sum itself over vectors.

use pulp::NullaryFnOnce;

use crate::numeric::windowed_sinc::WindowedSinc;

/// Columns are padded to a multiple of this: whole vectors of any instruction set.
pub const LANES: usize = 16;
/// Places between two samples; linear between them, the error some 1e-5 of the height.
const PLACES: usize = 256;

/// Weights of the samples round a place.
#[derive(Clone, Debug)]
pub struct Weights {
    /// Samples on either side.
    reach: usize,
    /// Weights of 2 `reach` samples for each place, the last of them the next sample's own.
    table: Vec<f32>,
}

impl Weights {
    /// Of a kernel.
    pub fn new(kernel: &WindowedSinc) -> Self {
        let reach = kernel.half_width().ceil() as usize;
        let of = |place: usize| {
            let part = place as f64 / PLACES as f64;
            let at = move |tap: usize| kernel.at(tap as f64 - (reach as f64 - 1.0) - part);
            let sum: f64 = (0..2 * reach).map(at).sum();
            (0..2 * reach).map(move |tap| (at(tap) / sum) as f32)
        };
        Self { reach, table: (0..=PLACES).flat_map(of).collect() }
    }

    /// Samples on either side of a place that count.
    pub fn reach(&self) -> usize {
        self.reach
    }

    /// Weights, each times `factor`, of the samples from floor(place) - reach + 1 on.
    pub fn at(&self, place: f64, factor: f64, weights: &mut Vec<f32>) {
        let taps = 2 * self.reach;
        let fine = (place - place.floor()) * PLACES as f64;
        let number = (fine as usize).min(PLACES - 1);
        let (part, factor) = ((fine - number as f64) as f32, factor as f32);
        let (now, next) = self.table[number * taps..(number + 2) * taps].split_at(taps);
        weights.clear();
        weights.extend(now.iter().zip(next).map(|(now, next)| factor * (now + part * (next - now))));
    }
}

/// A weighted sum of rows of samples, added to a row; all rows of whole vectors.
pub struct Interpolation<'a> {
    /// The row.
    pub sums: &'a mut [[f32; LANES]],
    /// A weight for each row of samples.
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
            for (&weight, row) in weights.iter().zip(samples.chunks_exact(vectors)) {
                let samples = &row[column];
                for lane in 0..LANES {
                    total[lane] += weight * samples[lane];
                }
            }
            *sum = total;
        }
    }
}
