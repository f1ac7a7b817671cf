//! Complex Fourier transforms of several sequences side by side, one to a lane of the processor's vectors.
//!
//! Stockham's form: passes of radix 8, 4, 2, 3 and 5, and of the remaining factor of other lengths, between two
//! arrays, each of which leaves its part of the order right, so that nothing is permuted at the end. All lanes take
//! the same factors; nothing is moved between lanes.

use std::f64::consts::TAU;

use pulp::{Arch, Simd, WithSimd};

use crate::numeric::Element;

/// A complex number to a lane: real parts, imaginary parts.
pub(super) type Wave<R, S> = [<R as Element>::Vector<S>; 2];

/// Numbers as complex vectors.
#[inline(always)]
pub(super) fn waves<R: Element, S: Simd>(values: &mut [R]) -> &mut [Wave<R, S>] {
    R::vectors_mut::<S>(values).as_chunks_mut().0
}

/// Numbers that a vector holds on this machine.
pub(super) fn lanes<R: Element>(arch: Arch) -> usize {
    arch.dispatch(Width::<R>(std::marker::PhantomData))
}

struct Width<R>(std::marker::PhantomData<R>);

impl<R: Element> WithSimd for Width<R> {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        R::lanes::<S>()
    }
}

/// Radices for which there are butterflies.
const RADICES: [usize; 5] = [8, 4, 2, 3, 5];

struct Pass<R> {
    radix: usize,
    /// Butterflies with different factors.
    factors: usize,
    /// Neighbours that share them.
    stride: usize,
    /// exp(-2 pi i p k / n) for p = 1, ..., factors - 1 and k = 1, ..., radix - 1; exp(-2 pi i k / radix) of a radix
    /// without a butterfly.
    twiddles: Vec<[R; 2]>,
}

/// Transforms of one length.
pub(super) struct Transform<R> {
    length: usize,
    passes: Vec<Pass<R>>,
}

/// exp(-2 pi i numerator / denominator), the angle taken within one turn.
pub(super) fn unit<R: Element>(numerator: usize, denominator: usize) -> [R; 2] {
    let angle = TAU * (numerator % denominator) as f64 / denominator as f64;
    [R::rounded(angle.cos()), R::rounded(-angle.sin())]
}

/// a w for a factor w in all lanes.
#[inline(always)]
pub(super) fn times<R: Element, S: Simd>(simd: S, a: Wave<R, S>, [re, im]: [R; 2]) -> Wave<R, S> {
    let (re, im) = (R::splat(simd, re), R::splat(simd, im));
    product::<R, S>(simd, a, [re, im])
}

/// a b.
#[inline(always)]
pub(super) fn product<R: Element, S: Simd>(simd: S, a: Wave<R, S>, b: Wave<R, S>) -> Wave<R, S> {
    let cross = R::neg(simd, R::mul(simd, a[1], b[1]));
    [R::mul_add(simd, a[0], b[0], cross), R::mul_add(simd, a[0], b[1], R::mul(simd, a[1], b[0]))]
}

#[inline(always)]
pub(super) fn add<R: Element, S: Simd>(simd: S, a: Wave<R, S>, b: Wave<R, S>) -> Wave<R, S> {
    [R::add(simd, a[0], b[0]), R::add(simd, a[1], b[1])]
}

#[inline(always)]
pub(super) fn sub<R: Element, S: Simd>(simd: S, a: Wave<R, S>, b: Wave<R, S>) -> Wave<R, S> {
    [R::sub(simd, a[0], b[0]), R::sub(simd, a[1], b[1])]
}

/// -i a.
#[inline(always)]
fn turned<R: Element, S: Simd>(simd: S, a: Wave<R, S>) -> Wave<R, S> {
    [a[1], R::neg(simd, a[0])]
}

/// a + factor b.
#[inline(always)]
fn plus<R: Element, S: Simd>(simd: S, a: Wave<R, S>, factor: f64, b: Wave<R, S>) -> Wave<R, S> {
    let factor = R::splat(simd, R::rounded(factor));
    [R::mul_add(simd, factor, b[0], a[0]), R::mul_add(simd, factor, b[1], a[1])]
}

#[inline(always)]
fn scaled<R: Element, S: Simd>(simd: S, factor: f64, a: Wave<R, S>) -> Wave<R, S> {
    let factor = R::splat(simd, R::rounded(factor));
    [R::mul(simd, factor, a[0]), R::mul(simd, factor, a[1])]
}

#[inline(always)]
fn four<R: Element, S: Simd>(simd: S, a: [Wave<R, S>; 4]) -> [Wave<R, S>; 4] {
    let (even, other) = (add::<R, S>(simd, a[0], a[2]), sub::<R, S>(simd, a[0], a[2]));
    let (odd, quarter) = (add::<R, S>(simd, a[1], a[3]), turned::<R, S>(simd, sub::<R, S>(simd, a[1], a[3])));
    [
        add::<R, S>(simd, even, odd),
        add::<R, S>(simd, other, quarter),
        sub::<R, S>(simd, even, odd),
        sub::<R, S>(simd, other, quarter),
    ]
}

/// Transform of N numbers; none but the radices of [`RADICES`].
#[inline(always)]
fn butterfly<R: Element, S: Simd, const N: usize>(simd: S, a: [Wave<R, S>; N]) -> [Wave<R, S>; N] {
    let mut b = a;
    match N {
        2 => {
            b[0] = add::<R, S>(simd, a[0], a[1]);
            b[1] = sub::<R, S>(simd, a[0], a[1]);
        }
        3 => {
            let (sum, difference) = (add::<R, S>(simd, a[1], a[2]), sub::<R, S>(simd, a[1], a[2]));
            let middle = plus::<R, S>(simd, a[0], -0.5, sum);
            let side = turned::<R, S>(simd, scaled::<R, S>(simd, 0.75_f64.sqrt(), difference));
            b[0] = add::<R, S>(simd, a[0], sum);
            b[1] = add::<R, S>(simd, middle, side);
            b[2] = sub::<R, S>(simd, middle, side);
        }
        4 => b.copy_from_slice(&four::<R, S>(simd, [a[0], a[1], a[2], a[3]])),
        5 => {
            /// cos and sin of 2 pi/5 and 4 pi/5.
            const COSINES: [f64; 2] = [0.309_016_994_374_947_45, -0.809_016_994_374_947_5];
            const SINES: [f64; 2] = [0.951_056_516_295_153_5, 0.587_785_252_292_473_1];
            let (near, far) = (add::<R, S>(simd, a[1], a[4]), add::<R, S>(simd, a[2], a[3]));
            let (d_near, d_far) = (sub::<R, S>(simd, a[1], a[4]), sub::<R, S>(simd, a[2], a[3]));
            let (first, second) = (
                plus::<R, S>(simd, plus::<R, S>(simd, a[0], COSINES[0], near), COSINES[1], far),
                plus::<R, S>(simd, plus::<R, S>(simd, a[0], COSINES[1], near), COSINES[0], far),
            );
            let (s_first, s_second) = (
                turned::<R, S>(simd, plus::<R, S>(simd, scaled::<R, S>(simd, SINES[0], d_near), SINES[1], d_far)),
                turned::<R, S>(simd, plus::<R, S>(simd, scaled::<R, S>(simd, SINES[1], d_near), -SINES[0], d_far)),
            );
            b[0] = add::<R, S>(simd, a[0], add::<R, S>(simd, near, far));
            b[1] = add::<R, S>(simd, first, s_first);
            b[2] = add::<R, S>(simd, second, s_second);
            b[3] = sub::<R, S>(simd, second, s_second);
            b[4] = sub::<R, S>(simd, first, s_first);
        }
        8 => {
            let even = four::<R, S>(simd, [a[0], a[2], a[4], a[6]]);
            let odd = four::<R, S>(simd, [a[1], a[3], a[5], a[7]]);
            let half = 0.5_f64.sqrt();
            let one = odd[1];
            let three = odd[3];
            let odd = [
                odd[0],
                scaled::<R, S>(simd, half, [R::add(simd, one[0], one[1]), R::sub(simd, one[1], one[0])]),
                turned::<R, S>(simd, odd[2]),
                scaled::<R, S>(
                    simd,
                    half,
                    [R::sub(simd, three[1], three[0]), R::neg(simd, R::add(simd, three[0], three[1]))],
                ),
            ];
            for k in 0..4 {
                b[k] = add::<R, S>(simd, even[k], odd[k]);
                b[k + 4] = sub::<R, S>(simd, even[k], odd[k]);
            }
        }
        _ => {}
    }
    b
}

impl<R: Element> Pass<R> {
    #[inline(always)]
    fn run<S: Simd, const N: usize>(&self, simd: S, from: &[Wave<R, S>], to: &mut [Wave<R, S>]) {
        let (factors, stride) = (self.factors, self.stride);
        let from: [&[Wave<R, S>]; N] = std::array::from_fn(|t| &from[t * factors * stride..(t + 1) * factors * stride]);
        for (p, to) in to[..N * factors * stride].chunks_exact_mut(N * stride).enumerate() {
            let twiddles = if p == 0 { &[][..] } else { &self.twiddles[(p - 1) * (N - 1)..p * (N - 1)] };
            for q in 0..stride {
                let mut a = [from[0][p * stride + q]; N];
                for t in 1..N {
                    a[t] = from[t][p * stride + q];
                }
                let mut b = butterfly::<R, S, N>(simd, a);
                if p > 0 {
                    for k in 1..N {
                        b[k] = times::<R, S>(simd, b[k], twiddles[k - 1]);
                    }
                }
                for k in 0..N {
                    to[k * stride + q] = b[k];
                }
            }
        }
    }
}

impl<R: Element> Pass<R> {
    /// The last pass of a length with other prime factors, by definition.
    #[inline(always)]
    fn run_by_definition<S: Simd>(&self, simd: S, from: &[Wave<R, S>], to: &mut [Wave<R, S>]) {
        let Self { radix, stride, twiddles, .. } = self;
        for (k, to) in to.chunks_exact_mut(*stride).enumerate().take(*radix) {
            to.copy_from_slice(&from[..*stride]);
            for (t, from) in from.chunks_exact(*stride).enumerate().take(*radix).skip(1) {
                let factor = twiddles[k * t % radix];
                for (sum, value) in to.iter_mut().zip(from) {
                    *sum = add::<R, S>(simd, *sum, times::<R, S>(simd, *value, factor));
                }
            }
        }
    }
}

impl<R: Element> Transform<R> {
    /// Plans a length. The factor that remains without 2, 3 and 5 is one pass, whose work grows with its square.
    pub(super) fn new(length: usize) -> Self {
        let (mut remaining, mut stride, mut passes) = (length, 1, Vec::new());
        while remaining > 1 {
            let planned = RADICES.into_iter().find(|radix| remaining.is_multiple_of(*radix));
            let radix = planned.unwrap_or(remaining);
            let factors = remaining / radix;
            let twiddles = match planned {
                Some(radix) => (1..factors).flat_map(|p| (1..radix).map(move |k| unit(p * k, remaining))).collect(),
                None => (0..radix).map(|k| unit(k, radix)).collect(),
            };
            passes.push(Pass { radix, factors, stride, twiddles });
            remaining = factors;
            stride *= radix;
        }
        Self { length, passes }
    }

    pub(super) fn length(&self) -> usize {
        self.length
    }

    /// Sum of x_n exp(-2 pi i k n / length) of complex numbers in vectors; both arrays are overwritten, the result is
    /// the first one returned. The passes are not inlined: a product takes six transforms, and would contain them six
    /// times.
    #[inline(always)]
    pub(super) fn run<'a, S: Simd>(&self, simd: S, from: &'a mut [R], to: &'a mut [R]) -> [&'a mut [R]; 2] {
        simd.vectorize(Run { passes: &self.passes, from, to });
        if self.ends_where_it_begins() { [from, to] } else { [to, from] }
    }

    /// True if the result is where the numbers were, not in the other array.
    pub(super) fn ends_where_it_begins(&self) -> bool {
        self.passes.len().is_multiple_of(2)
    }
}

/// All passes of a transform, the last one's result where the next would begin.
struct Run<'a, R> {
    passes: &'a [Pass<R>],
    from: &'a mut [R],
    to: &'a mut [R],
}

impl<R: Element> WithSimd for Run<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let (mut from, mut to) = (waves::<R, S>(self.from), waves::<R, S>(self.to));
        for pass in self.passes {
            match pass.radix {
                8 => pass.run::<S, 8>(simd, from, to),
                4 => pass.run::<S, 4>(simd, from, to),
                2 => pass.run::<S, 2>(simd, from, to),
                3 => pass.run::<S, 3>(simd, from, to),
                5 => pass.run::<S, 5>(simd, from, to),
                _ => pass.run_by_definition(simd, from, to),
            }
            (from, to) = (to, from);
        }
    }
}
