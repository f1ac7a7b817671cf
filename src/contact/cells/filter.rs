//! Product of a field of cells with a small even stencil: the neighbourhood of a cell in an inverse, for
//! preconditioners.

use std::ops::AddAssign;

use pulp::{Arch, Simd, WithSimd};

use crate::numeric::Element;

/// Vectors of a row that are summed together.
const TOGETHER: usize = 4;

/// Even stencil W with space for a product.
pub(crate) struct Filter<R> {
    arch: Arch,
    pub(super) across: usize,
    /// Cells on either side that the stencil reaches.
    pub(super) radius: usize,
    /// W by distance along and across, (radius + 1)^2.
    pub(super) stencil: Vec<R>,
    /// Row length of a field with its edges of zeros.
    stride: usize,
    /// A field with edges.
    edged: Vec<R>,
    /// Sums of two of its rows.
    lines: Vec<R>,
}

impl<R: Element + AddAssign> Filter<R> {
    /// Filter for fields of at most `columns` columns of `across` cells, with W by distance along and across,
    /// (radius + 1)^2.
    pub(crate) fn new([columns, across]: [usize; 2], radius: usize, stencil: Vec<R>) -> Self {
        let stride = across.next_multiple_of(TOGETHER * R::MOST_LANES) + 2 * radius;
        let zeros = |lines: usize| vec![R::default(); lines * stride];
        let (edged, lines) = (zeros(columns + 2 * radius), zeros(radius + 1));
        Self { arch: Arch::new(), across, radius, stencil, stride, edged, lines }
    }

    /// W times a field of whole columns, which may be fewer than those of [`Self::new`].
    pub(crate) fn apply(&mut self, field: &[R], out: &mut [R]) {
        let Self { arch, across, radius, stencil, stride, edged, lines } = self;
        let (across, radius, stride) = (*across, *radius, *stride);
        let inner = edged[radius * stride..].chunks_exact_mut(stride);
        for (line, row) in inner.zip(field.chunks_exact(across)) {
            line[radius..radius + across].copy_from_slice(row);
        }
        // What a longer field has left there is cleared.
        edged[(radius + field.len() / across) * stride..][..radius * stride].fill(R::default());
        arch.dispatch(Stencil { radius, weights: stencil, stride, across, edged, lines, out });
    }
}

struct Stencil<'a, R> {
    radius: usize,
    weights: &'a [R],
    stride: usize,
    across: usize,
    edged: &'a [R],
    /// By distance along: sum of the lines on either side.
    lines: &'a mut [R],
    out: &'a mut [R],
}

impl<R: Element + AddAssign> WithSimd for Stencil<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { radius, weights, stride, across, edged, lines, out } = self;
        let lanes = R::lanes::<S>();
        for (i, row) in out.chunks_exact_mut(across).enumerate() {
            let line = |number: usize| &edged[number * stride..][..stride];
            for (a, sum) in lines.chunks_exact_mut(stride).enumerate() {
                sum.copy_from_slice(line(i + radius - a));
                if a > 0 {
                    sum.iter_mut().zip(line(i + radius + a)).for_each(|(sum, other)| *sum += *other);
                }
            }
            for (number, out) in row.chunks_mut(TOGETHER * lanes).enumerate() {
                let first = number * TOGETHER * lanes;
                let mut sums = [R::splat(simd, R::default()); TOGETHER];
                for (a, line) in lines.chunks_exact(stride).enumerate() {
                    let (weights, line) = (&weights[a * (radius + 1)..][..=radius], &line[first..]);
                    for b in 0..=2 * radius {
                        let weight = R::splat(simd, weights[b.abs_diff(radius)]);
                        let vectors = R::vectors::<S>(&line[b..b + TOGETHER * lanes]);
                        for (sum, &vector) in sums.iter_mut().zip(vectors) {
                            *sum = R::mul_add(simd, weight, vector, *sum);
                        }
                    }
                }
                for (out, sum) in out.chunks_mut(lanes).zip(sums) {
                    R::store(simd, out, sum);
                }
            }
        }
    }
}
