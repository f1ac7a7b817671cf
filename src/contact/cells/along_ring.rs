//! Transforms of many rows along a ring of cells.
//!
//! Rows are real. Two of them, as the real and the imaginary part of one complex sequence, are a pair; pairs stand in
//! the lanes of vectors, so that a transform takes as many of them as a vector has numbers. Row r of a field and row
//! r + height/2 are one. A pair's spectrum X holds A_n = (X_n + conj X_-n)/2 and B_n = (X_n - conj X_-n)/(2 i).

use std::ops::Range;

use num_complex::Complex;
use pulp::{Arch, Simd, WithSimd};

use super::transform::{Transform, lanes, waves};
use crate::numeric::{Aligned, Element};

/// One lateral number: a row, and its waves.
#[derive(Clone, Copy)]
pub(super) struct RingRow {
    /// Place of its waves in the list of all.
    pub start: usize,
    /// Number of the first one on the ring.
    pub first: usize,
    /// Number of waves.
    pub count: usize,
}

/// Transforms of one length, with space for one vector of pairs.
pub(super) struct AlongRing<R> {
    arch: Arch,
    /// Pairs to a vector.
    width: usize,
    transform: Transform<R>,
    arrays: [Aligned<R>; 2],
}

impl<R: Element> AlongRing<R> {
    pub(super) fn new(ring: usize) -> Self {
        let arch = Arch::new();
        let width = lanes::<R>(arch);
        let array = || Aligned::new(numbers(ring, width));
        Self { arch, width, transform: Transform::new(ring), arrays: [array(), array()] }
    }

    /// Rows of a field with space for `rows`: whole vectors of pairs.
    pub(super) fn height(&self, rows: usize) -> usize {
        2 * rows.div_ceil(2).next_multiple_of(self.width)
    }

    /// Transforms rows, stored column by column from place `first` of the ring on, to their waves.
    pub(super) fn forward(&mut self, first: usize, rows: &[RingRow], field: &[R], spectrum: &mut [Complex<R>]) {
        let (arch, height) = (self.arch, self.height(rows.len()));
        arch.dispatch(Forward { along: self, first, rows, field, height, spectrum });
    }

    /// Transforms waves to rows, likewise; of a wave that is its own mirror only the real part counts.
    pub(super) fn inverse(&mut self, first: usize, rows: &[RingRow], spectrum: &[Complex<R>], field: &mut [R]) {
        let (arch, height) = (self.arch, self.height(rows.len()));
        arch.dispatch(Inverse { along: self, first, rows, spectrum, field, height });
    }
}

/// Numbers in a sequence of pairs, or in the waves of both rows.
const fn numbers(ring: usize, width: usize) -> usize {
    4 * (ring / 2 + 1) * width
}

/// Rows that exist in a vector of pairs: lane, place in the pair, row.
fn pairs_of(
    rows: &[RingRow],
    block: Range<usize>,
    pairs: usize,
) -> impl Iterator<Item = (usize, usize, RingRow)> + Clone + use<'_> {
    let both = block.enumerate().flat_map(move |(lane, row)| [(lane, 0, row), (lane, 1, pairs + row)]);
    both.filter_map(|(lane, which, row)| Some((lane, which, *rows.get(row)?)))
}

struct Forward<'a, R> {
    along: &'a mut AlongRing<R>,
    first: usize,
    rows: &'a [RingRow],
    field: &'a [R],
    height: usize,
    spectrum: &'a mut [Complex<R>],
}

impl<R: Element> WithSimd for Forward<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { along: AlongRing { width, transform, arrays, .. }, first, rows, field, height, spectrum } = self;
        let (width, ring, pairs) = (*width, transform.length(), height / 2);
        let [one, other] = arrays.each_mut().map(|array| array.part(0, numbers(ring, width)));
        let half = R::splat(simd, R::rounded(0.5));
        for block in (0..pairs).step_by(width) {
            // 1. Pairs of rows, one to a lane, to their places on the ring.
            one.fill(R::default());
            let sequence = waves::<R, S>(one);
            for (column, values) in field.chunks_exact(height).enumerate() {
                sequence[(first + column) % ring] =
                    [R::load(simd, &values[block..]), R::load(simd, &values[pairs + block..])];
            }
            // 2. Spectrum X, and A_n and B_n from X_n and X_-n.
            let [result, parted] = transform.run(simd, one, other);
            let lanes = pairs_of(rows, block..block + width, pairs);
            let end = lanes.clone().map(|(.., row)| row.first + row.count).max().unwrap_or(0);
            let (result, parts) = (&*waves::<R, S>(result), waves::<R, S>(parted).as_chunks_mut::<2>().0);
            for (n, parts) in parts.iter_mut().enumerate().take(end) {
                let ([re, im], [mirror_re, mirror_im]) = (result[n], result[(ring - n) % ring]);
                *parts = [
                    [R::mul(simd, half, R::add(simd, re, mirror_re)), R::mul(simd, half, R::sub(simd, im, mirror_im))],
                    [R::mul(simd, half, R::add(simd, im, mirror_im)), R::mul(simd, half, R::sub(simd, mirror_re, re))],
                ];
            }
            // 3. From the lanes to the waves of each row.
            for (lane, which, row) in lanes {
                let out = spectrum[row.start..row.start + row.count].iter_mut();
                for (out, wave) in out.zip(parted[4 * width * row.first..].chunks_exact(4 * width)) {
                    *out = Complex::new(wave[2 * which * width + lane], wave[(2 * which + 1) * width + lane]);
                }
            }
        }
    }
}

struct Inverse<'a, R> {
    along: &'a mut AlongRing<R>,
    first: usize,
    rows: &'a [RingRow],
    spectrum: &'a [Complex<R>],
    field: &'a mut [R],
    height: usize,
}

impl<R: Element> WithSimd for Inverse<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { along: AlongRing { width, transform, arrays, .. }, first, rows, spectrum, field, height } = self;
        let (width, ring, pairs) = (*width, transform.length(), height / 2);
        let [one, other] = arrays.each_mut().map(|array| array.part(0, numbers(ring, width)));
        for block in (0..pairs).step_by(width) {
            // 1. Waves of each row to the lanes.
            let lanes = pairs_of(rows, block..block + width, pairs);
            let end = lanes.clone().map(|(.., row)| row.first + row.count).max().unwrap_or(0);
            other[..4 * width * end].fill(R::default());
            for (lane, which, row) in lanes {
                let values = spectrum[row.start..row.start + row.count].iter();
                let waves = other[4 * width * row.first..].chunks_exact_mut(4 * width);
                for ((n, value), wave) in (row.first..).zip(values).zip(waves) {
                    let is_mirror = n == 0 || 2 * n == ring;
                    wave[2 * which * width + lane] = value.re;
                    wave[(2 * which + 1) * width + lane] = if is_mirror { R::default() } else { value.im };
                }
            }
            one.fill(R::default());
            // 2. X_n = A_n + i B_n and X_-n. Real and imaginary parts are exchanged, before and after: the transform
            //    is then the inverse one.
            let (sequence, parts) = (waves::<R, S>(one), waves::<R, S>(other).as_chunks::<2>().0);
            for (n, [[a_re, a_im], [b_re, b_im]]) in parts.iter().copied().enumerate().take(end) {
                sequence[n] = [R::add(simd, a_im, b_re), R::sub(simd, a_re, b_im)];
                sequence[(ring - n) % ring] = [R::sub(simd, b_re, a_im), R::add(simd, a_re, b_im)];
            }
            let [result, _] = transform.run(simd, one, other);
            let result = &*waves::<R, S>(result);
            // 3. From places on the ring to the columns.
            for (column, values) in field.chunks_exact_mut(height).enumerate() {
                let [im, re] = result[(first + column) % ring];
                R::store(simd, &mut values[block..], re);
                R::store(simd, &mut values[pairs + block..], im);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::cells::transform::unit;

    fn value(row: usize, place: usize) -> f64 {
        ((3 * row + 1) as f64 + 1.7 * (place * place) as f64).sin()
    }

    fn field<R: Element>(height: usize, rows: usize, columns: usize) -> Vec<R> {
        let of = |place: usize| if place % height < rows { value(place % height, place / height) } else { 0.0 };
        (0..height * columns).map(|place| R::rounded(of(place))).collect()
    }

    fn agrees<R: Element>(tolerance: f64) {
        for (ring, columns, rows) in [(1, 1, 1), (2, 2, 3), (7, 5, 4), (12, 12, 1), (22, 9, 40), (64, 30, 17)] {
            // Of every row some waves, the highest one with others.
            let mut start = 0;
            let rows: Vec<RingRow> = (0..rows)
                .map(|row| {
                    let first = row % 3 % (ring / 2 + 1);
                    let count = ring / 2 + 1 - first - if first == 1 { row % 2 } else { 0 };
                    start += count;
                    RingRow { start: start - count, first, count }
                })
                .collect();
            let mut along = AlongRing::<R>::new(ring);
            let height = along.height(rows.len());
            let field = field::<R>(height, rows.len(), columns);
            let zero = Complex::new(R::default(), R::default());
            let (mut spectrum, mut back) = (vec![zero; start], field.clone());
            let place = 5 % ring;
            let wave = |n: usize, c: usize| -> [f64; 2] { unit(n * c, ring) };
            along.forward(place, &rows, &field, &mut spectrum);
            along.inverse(place, &rows, &spectrum, &mut back);
            for (index, row) in rows.iter().enumerate() {
                let mut displaced = vec![0.0; columns];
                for (n, found) in (row.first..).zip(&spectrum[row.start..row.start + row.count]) {
                    let mut sum = [0.0; 2];
                    for column in 0..columns {
                        let [cosine, minus_sine] = wave(n, (place + column) % ring);
                        let value = field[column * height + index].double();
                        sum = [sum[0] + value * cosine, sum[1] + value * minus_sine];
                    }
                    let error = (found.re.double() - sum[0]).hypot(found.im.double() - sum[1]);
                    assert!(error < tolerance * ring as f64, "{ring}, row {index}, wave {n}: {error:e}");
                    let [times, im] = if n == 0 || 2 * n == ring { [1.0, 0.0] } else { [2.0, sum[1]] };
                    for (column, displaced) in displaced.iter_mut().enumerate() {
                        let [cosine, minus_sine] = wave(n, (place + column) % ring);
                        *displaced += times * (sum[0] * cosine + im * minus_sine);
                    }
                }
                for (column, displaced) in displaced.into_iter().enumerate() {
                    let error = (back[column * height + index].double() - displaced).abs();
                    assert!(
                        error < tolerance * (ring * ring) as f64,
                        "{ring}, row {index}, column {column}: {error:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn waves_and_rows_are_those_of_the_sums_of_any_ring() {
        agrees::<f64>(1e-14);
        agrees::<f32>(1e-6);
    }
}
