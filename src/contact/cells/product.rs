//! Products with T\[|i-i'|\]\[|j-j'|\] + H\[|i-i'|\]\[j+j'\] through Fourier transforms.
//!
//! Along, P >= columns: T and H are even and the forces real, so the odd frequencies pi (2 m + 1/2)/P of a transform
//! of length 2 P hold all the information. With them nothing wraps round, and one complex transform of length P of x_n
//! exp(-i pi n/(2 P)) gives them all. Across, Q >= across: those waves are complex, and all 2 Q frequencies are
//! needed, the even ones by a transform of x_j, the odd ones by one of x_j exp(-i pi j/Q). There T is a product with a
//! real number, H one with the wave of the opposite frequency: sum over j' of H\[j + j'\] F_j' has the transform H(k)
//! F(-k).
//!
//! With rotation, both have a part that is odd along. Its transform is imaginary along: T(k) and H(k) become T +
//! i T' and H + i H', and a product takes no more transforms.
//!
//! Lanes hold cells across while the transforms run along, and waves along while they run across, so that no transform
//! moves anything between lanes; blocks of one vector's width are transposed in between.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::transform::{Transform, Wave, add, lanes, product, sub, times, unit, waves};
use crate::counters::Work;
use crate::numeric::{Aligned, Element, transform_length, transform_multiply_adds};
use crate::tyre::influence::CellInfluence;

/// Most numbers of a vector.
const MOST: usize = 16;

/// G in the waves of a window, with scratch for a product.
pub(crate) struct CellProduct<R> {
    columns: usize,
    across: usize,
    arch: Arch,
    along: Transform<R>,
    crosswise: Transform<R>,
    /// exp(-i pi n/(2 P)).
    shift_along: Vec<[R; 2]>,
    /// exp(-i pi j/Q).
    shift_across: Vec<[R; 2]>,
    /// Transform of T by block of waves along, even and odd frequencies, frequency across, wave.
    toeplitz: Aligned<R>,
    /// Imaginary part of the transform of T in the same order; `None` at rest.
    toeplitz_odd: Option<Aligned<R>>,
    /// Transform of H in the same order, real and imaginary parts.
    hankel: Aligned<R>,
    /// By block of cells across: waves along.
    spectrum: Aligned<R>,
    /// By block of waves along: cells across.
    turned: Aligned<R>,
    /// Two sequences.
    scratch: [Aligned<R>; 2],
    /// Transform of T, frequencies across to each wave along.
    free_field: Vec<f64>,
    /// Bound of the norm of the part that is even along.
    pub(super) norm_bound: f64,
}

impl<R: Element> CellProduct<R> {
    /// G from T, columns x across, and H, columns x (2 across - 1).
    pub(crate) fn new(columns: usize, across: usize, toeplitz: &[f64], hankel: &[f64]) -> Self {
        Self::with_odd(columns, across, [toeplitz, hankel], None)
    }

    /// The whole of an influence on the first `columns` columns of its window, including its part that is odd along.
    pub(crate) fn whole(columns: usize, influence: &CellInfluence) -> Self {
        let odd = influence.odd.as_ref().map(|odd| [&*odd.toeplitz, &*odd.hankel]);
        Self::with_odd(columns, influence.across, [&influence.toeplitz, &influence.hankel], odd)
    }

    /// G from T and H, and their parts that are odd along.
    fn with_odd(columns: usize, across: usize, [toeplitz, hankel]: [&[f64]; 2], odd: Option<[&[f64]; 2]>) -> Self {
        let half_length = |cells: usize, reach: usize| transform_length(cells + reach.min(cells)) / 2;
        let [reach_along, reach_across] = reach(across, [toeplitz, hankel], odd);
        let (p, q) = (half_length(columns, reach_along), half_length(across, reach_across));
        let arch = Arch::new();
        let width = lanes::<R>(arch);
        let (p_padded, padded) = (p.next_multiple_of(MOST), across.next_multiple_of(MOST));
        let array = |numbers: usize| Aligned::<R>::new(numbers);
        let (whole_t, whole_h) = (2 * q * p_padded, 4 * q * p_padded);
        let mut this = Self {
            columns,
            across,
            arch,
            along: Transform::new(p),
            crosswise: Transform::new(q),
            shift_along: (0..p.min(columns)).map(|n| unit(n, 4 * p)).collect(),
            shift_across: (0..q.min(across)).map(|j| unit(j, 2 * q)).collect(),
            toeplitz: array(whole_t),
            toeplitz_odd: odd.map(|_| array(whole_t)),
            hankel: array(whole_h),
            spectrum: array(2 * p_padded * padded),
            turned: array(2 * p_padded * padded),
            scratch: [array(2 * p.max(q) * MOST), array(2 * p.max(q) * MOST)],
            free_field: Vec::with_capacity(2 * p * q),
            norm_bound: 0.0,
        };
        // 1. Parts that are even along, and the bound of the norm.
        let folded = 2 * across - 1;
        let even_waves = |each: usize, values| along_waves(columns, p, each, values, even_factor);
        let waves = even_waves(across, toeplitz).zip(even_waves(folded, hankel));
        let scale = 1.0 / (2 * p * q) as f64;
        let cosines: Vec<[f64; 2]> = (0..2 * q).map(|n| unit(n, 2 * q)).collect();
        let place = |wave: usize, frequency: usize| (2 * (wave / width) + frequency % 2) * q + frequency / 2;
        let (t_out, h_out) = (this.toeplitz.part(0, whole_t), this.hankel.part(0, whole_h));
        for (wave, (t, h)) in waves.enumerate() {
            let lane = wave % width;
            for frequency in 0..2 * q {
                let even = across_even(&cosines, &t, frequency);
                let [re, im] = across_folded(&cosines, &h, frequency);
                // G is a part of a matrix with these transforms, whose norm is the largest of them.
                this.norm_bound = this.norm_bound.max(even.abs() + re.hypot(im));
                this.free_field.push(even);
                let place = place(wave, frequency);
                t_out[place * width + lane] = R::rounded(even * scale);
                h_out[2 * place * width + lane] = R::rounded(re * scale);
                h_out[(2 * place + 1) * width + lane] = R::rounded(im * scale);
            }
        }
        // 2. Parts that are odd along: T' beside T, and H + i H' in place of H.
        let (Some([toeplitz, odd_hankel]), Some(odd_out)) = (odd, &mut this.toeplitz_odd) else { return this };
        let odd_waves = |each: usize, values| along_waves(columns, p, each, values, odd_factor);
        let waves = odd_waves(across, toeplitz).zip(odd_waves(folded, odd_hankel)).zip(even_waves(folded, hankel));
        let odd_out = odd_out.part(0, whole_t);
        for (wave, ((t, odd), even)) in waves.enumerate() {
            let lane = wave % width;
            for frequency in 0..2 * q {
                let place = place(wave, frequency);
                let [re, im] = across_folded(&cosines, &even, frequency);
                let [odd_re, odd_im] = across_folded(&cosines, &odd, frequency);
                odd_out[place * width + lane] = R::rounded(across_even(&cosines, &t, frequency) * scale);
                h_out[2 * place * width + lane] = R::rounded((re - odd_im) * scale);
                h_out[(2 * place + 1) * width + lane] = R::rounded((im + odd_re) * scale);
            }
        }
        this
    }

    pub(crate) fn columns(&self) -> usize {
        self.columns
    }

    /// Work of a product: the transforms, and the products with those of T and H.
    pub(crate) fn work(&self) -> Work {
        let (p, q) = (self.along.length(), self.crosswise.length());
        let transforms =
            (2 * self.across) as f64 * transform_multiply_adds(p) + (4 * p) as f64 * transform_multiply_adds(q);
        let parts = 3 + usize::from(self.toeplitz_odd.is_some());
        // A complex number by a real one takes two multiply-adds, by a complex one four.
        let symbols = 2 * q * p * 2 * parts;
        let numbers = 2 * q * p * parts + 4 * 2 * p * self.across;
        Work { multiply_adds: transforms as u64 + symbols as u64, bytes: (numbers * size_of::<R>()) as u64 }
    }

    /// Middle of the inverse of T, (radius + 1) x (radius + 1) by distance along and across.
    pub(crate) fn inverse_stencil(&self, radius: usize) -> Vec<f32> {
        /// Floor of the waves of T, as a part of the norm.
        const FLOOR: f64 = 1e-3;
        let (p, q) = (self.along.length(), self.crosswise.length());
        let mut stencil = vec![0.0; (radius + 1) * (radius + 1)];
        for (m, waves) in self.free_field.chunks_exact(2 * q).enumerate() {
            for (k, &wave) in waves.iter().enumerate() {
                let inverse = wave.max(FLOOR * self.norm_bound).recip() / self.free_field.len() as f64;
                for (place, value) in stencil.iter_mut().enumerate() {
                    let [a, b] = [place / (radius + 1), place % (radius + 1)];
                    let [along, _]: [f64; 2] = unit(a * (4 * m + 1), 4 * p);
                    let [across, _]: [f64; 2] = unit(b * k, 2 * q);
                    *value += along * across * inverse;
                }
            }
        }
        stencil.into_iter().map(|value| value as f32).collect()
    }

    /// out = G F.
    pub(crate) fn displacement(&mut self, forces: &[R], out: &mut [R]) {
        let arch = self.arch;
        arch.dispatch(Multiply { product: self, forces, out });
    }
}

/// Largest distances along and across at which T is not 0; all count where there is an H.
fn reach(across: usize, [toeplitz, hankel]: [&[f64]; 2], odd: Option<[&[f64]; 2]>) -> [usize; 2] {
    let is_some = |values: &[f64]| values.iter().any(|value| value.abs() > 0.0);
    let parts = || [toeplitz].into_iter().chain(odd.map(|[toeplitz, _]| toeplitz));
    if is_some(hankel) || odd.is_some_and(|[_, hankel]| is_some(hankel)) {
        return [usize::MAX, usize::MAX];
    }
    let rows = parts().flat_map(|values| values.chunks_exact(across).enumerate());
    let (mut along, mut crosswise) = (0, 0);
    for (i, row) in rows {
        if let Some(last) = row.iter().rposition(|value| value.abs() > 0.0) {
            (along, crosswise) = (i.max(along), last.max(crosswise));
        }
    }
    [along, crosswise]
}

/// Values at distances 0, 1, ... along, `each` at every distance, as waves at the frequencies pi (2 m + 1/2)/p;
/// `factor` is that of a distance and its exp(-i phase).
fn along_waves(
    columns: usize,
    p: usize,
    each: usize,
    values: &[f64],
    factor: fn(usize, [f64; 2]) -> f64,
) -> impl Iterator<Item = Vec<f64>> {
    (0..p).map(move |m| {
        let mut sums = vec![0.0; each];
        for (n, values) in values.chunks_exact(each).take(columns).enumerate() {
            let factor = factor(n, unit(n * (4 * m + 1), 4 * p));
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value);
        }
        sums
    })
}

/// Factor of a part that is the same at a distance and its opposite.
fn even_factor(distance: usize, [cosine, _]: [f64; 2]) -> f64 {
    if distance == 0 { 1.0 } else { 2.0 * cosine }
}

/// Factor, over i, of a part that changes its sign at the opposite distance.
fn odd_factor(_: usize, [_, minus_sine]: [f64; 2]) -> f64 {
    2.0 * minus_sine
}

/// Wave at a frequency across of values that are even across; `cosines` with minus their sines.
fn across_even(cosines: &[[f64; 2]], values: &[f64], frequency: usize) -> f64 {
    let mut sum = values[0];
    for (j, value) in values.iter().enumerate().skip(1) {
        sum += 2.0 * value * cosines[j * frequency % cosines.len()][0];
    }
    sum
}

/// Wave at a frequency across of values that begin at place 0 and are not mirrored.
fn across_folded(cosines: &[[f64; 2]], values: &[f64], frequency: usize) -> [f64; 2] {
    let [mut re, mut im] = [0.0; 2];
    for (j, value) in values.iter().enumerate() {
        let [cosine, sine] = cosines[j * frequency % cosines.len()];
        re += value * cosine;
        im += value * sine;
    }
    [re, im]
}

struct Multiply<'a, R> {
    product: &'a mut CellProduct<R>,
    forces: &'a [R],
    out: &'a mut [R],
}

/// Exchanges real and imaginary parts, before and after an inverse transform.
#[inline(always)]
fn swapped<R: Element, S: Simd>([re, im]: Wave<R, S>) -> Wave<R, S> {
    [im, re]
}

/// Transposes rows and numbers: `from` holds blocks of `rows` x 2 x `width` numbers, and number l of row r of block b
/// becomes number r mod width of row b width + l of block r / width of `to`, whose blocks have `to_rows` rows.
#[inline(always)]
fn turn<R: Element, const WIDTH: usize>(from: &[R], rows: usize, to: &mut [R], to_rows: usize) {
    let (from, _) = from.as_chunks::<WIDTH>();
    let (to, _) = to.as_chunks_mut::<WIDTH>();
    for (b, from) in from.chunks_exact(2 * rows).enumerate() {
        for (r, from) in from.chunks_exact(2 * WIDTH).enumerate() {
            let to = &mut to[2 * (r * to_rows + b * WIDTH)..][..2 * WIDTH];
            for part in 0..2 {
                // A copy of the block: the compiler transposes it in registers.
                let block: [[R; WIDTH]; WIDTH] = std::array::from_fn(|c| from[2 * c + part]);
                for l in 0..WIDTH {
                    to[2 * l + part] = std::array::from_fn(|c| block[c][l]);
                }
            }
        }
    }
}

#[inline(always)]
fn turn_by<R: Element>(width: usize, from: &[R], rows: usize, to: &mut [R], to_rows: usize) {
    match width {
        16 => turn::<R, 16>(from, rows, to, to_rows),
        8 => turn::<R, 8>(from, rows, to, to_rows),
        4 => turn::<R, 4>(from, rows, to, to_rows),
        2 => turn::<R, 2>(from, rows, to, to_rows),
        _ => turn::<R, 1>(from, rows, to, to_rows),
    }
}

impl<R: Element> WithSimd for Multiply<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { product: this, forces, out } = self;
        let width = R::lanes::<S>();
        let (columns, across) = (this.columns, this.across);
        let (p, q) = (this.along.length(), this.crosswise.length());
        let (p_padded, padded) = (p.next_multiple_of(MOST), across.next_multiple_of(MOST));
        let [first, second] = &mut this.scratch;
        let numbers = 2 * p.max(q) * width;
        let (first, second) = (first.part(0, numbers), second.part(0, numbers));
        let zero = R::splat(simd, R::default());
        let spectrum = this.spectrum.part(0, 2 * p_padded * padded);
        // 1. Transforms along of the forces, cells across in the lanes.
        for (block, spectrum) in spectrum.chunks_exact_mut(2 * p_padded * width).enumerate() {
            let j = block * width;
            if j >= across {
                break;
            }
            // The transform ends where the waves are stored.
            let (stored, scratch) = (&mut spectrum[..2 * p * width], &mut first[..2 * p * width]);
            let [begin, end] = if this.along.ends_where_it_begins() { [stored, scratch] } else { [scratch, stored] };
            let from = waves::<R, S>(begin);
            let (near, far) = forces.split_at(forces.len().min(p * across));
            for ((row, &[re, im]), from) in near.chunks_exact(across).zip(&this.shift_along).zip(&mut *from) {
                let force = R::load(simd, &row[j..]);
                *from = [R::mul(simd, R::splat(simd, re), force), R::mul(simd, R::splat(simd, im), force)];
            }
            from[columns.min(p)..p].fill([zero; 2]);
            for ((row, &[re, im]), from) in far.chunks_exact(across).zip(&this.shift_along).zip(&mut *from) {
                // A quarter of a turn further on: times -i.
                let force = R::load(simd, &row[j..]);
                *from = [
                    R::mul_add(simd, R::splat(simd, im), force, from[0]),
                    R::mul_add(simd, R::neg(simd, R::splat(simd, re)), force, from[1]),
                ];
            }
            this.along.run(simd, begin, end);
        }
        let turned = this.turned.part(0, 2 * p_padded * padded);
        turn_by(width, spectrum, p_padded, turned, padded);

        let toeplitz = R::vectors::<S>(this.toeplitz.part(0, 2 * q * p_padded));
        let hankel = R::vectors::<S>(this.hankel.part(0, 4 * q * p_padded)).as_chunks::<2>().0;
        let toeplitz_odd = match &mut this.toeplitz_odd {
            Some(odd) => R::vectors::<S>(odd.part(0, 2 * q * p_padded)),
            None => &[],
        };
        // 2. Transforms across, products with T and H, and back; waves along in the lanes.
        let symbols = toeplitz.chunks_exact(2 * q).zip(hankel.chunks_exact(2 * q));
        for (block, (turned, (toeplitz, hankel))) in
            turned.chunks_exact_mut(2 * padded * width).zip(symbols).enumerate()
        {
            let symbol = |frequencies: Range<usize>| Symbol::<R, S> {
                toeplitz: &toeplitz[frequencies.clone()],
                hankel: &hankel[frequencies.clone()],
                odd: toeplitz_odd.chunks_exact(2 * q).nth(block).map(|odd| &odd[frequencies]),
            };
            let cells = &mut waves::<R, S>(turned)[..across];
            // The odd frequencies first: the cells are still needed for the even ones.
            let from = waves::<R, S>(first);
            let (near, far) = cells.split_at_mut(across.min(q));
            for ((from, &cell), &shift) in from.iter_mut().zip(&*near).zip(&this.shift_across) {
                *from = times::<R, S>(simd, cell, shift);
            }
            from[near.len()..q].fill([zero; 2]);
            for ((from, &cell), &shift) in from.iter_mut().zip(&*far).zip(&this.shift_across) {
                *from = sub::<R, S>(simd, *from, times::<R, S>(simd, cell, shift));
            }
            let [result, other] = this.crosswise.run(simd, first, second);
            respond::<R, S>(simd, &mut waves(result)[..q], symbol(q..2 * q), q - 1);
            let [result, other] = this.crosswise.run(simd, result, other);
            let (odd, even) = (waves::<R, S>(result), waves::<R, S>(other));
            // The even ones in the remaining space, the odd ones' result stored among the cells.
            even[..near.len()].copy_from_slice(near);
            even[near.len()..q].fill([zero; 2]);
            for (even, &cell) in even.iter_mut().zip(&*far) {
                *even = add::<R, S>(simd, *even, cell);
            }
            for ((cell, &odd), &[re, im]) in near.iter_mut().zip(&*odd).zip(&this.shift_across) {
                *cell = times::<R, S>(simd, swapped::<R, S>(odd), [re, R::rounded(-im.double())]);
            }
            let [result, other] = this.crosswise.run(simd, other, result);
            respond::<R, S>(simd, &mut waves(result)[..q], symbol(0..q), q);
            let [even, _] = this.crosswise.run(simd, result, other);
            for ((cell, &odd), &[im, re]) in far.iter_mut().zip(&*near).zip(&*waves::<R, S>(even)) {
                *cell = sub::<R, S>(simd, [re, im], odd);
            }
            for (cell, &[im, re]) in near.iter_mut().zip(&*waves::<R, S>(even)) {
                *cell = add::<R, S>(simd, *cell, [re, im]);
            }
        }
        turn_by(width, turned, padded, spectrum, p_padded);

        // 3. Back along.
        for (block, spectrum) in spectrum.chunks_exact_mut(2 * p_padded * width).enumerate() {
            let j = block * width;
            if j >= across {
                break;
            }
            for (from, &wave) in waves::<R, S>(first).iter_mut().zip(&waves::<R, S>(spectrum)[..p]) {
                *from = swapped::<R, S>(wave);
            }
            let [result, _] = this.along.run(simd, first, second);
            let result = &*waves::<R, S>(result);
            let (near, far) = out.split_at_mut(out.len().min(p * across));
            for ((row, &[re, im]), &[sine, cosine]) in near.chunks_exact_mut(across).zip(&this.shift_along).zip(result)
            {
                // The real part of the wave times exp(+i pi n/(2 P)).
                let cosine = R::mul(simd, R::splat(simd, re), cosine);
                let u = R::mul_add(simd, R::splat(simd, im), sine, cosine);
                R::store(simd, &mut row[j..], u);
            }
            for ((row, &[re, im]), &[sine, cosine]) in far.chunks_exact_mut(across).zip(&this.shift_along).zip(result) {
                // Minus the imaginary part.
                let sine = R::mul(simd, R::neg(simd, R::splat(simd, re)), sine);
                let u = R::mul_add(simd, R::splat(simd, im), cosine, sine);
                R::store(simd, &mut row[j..], u);
            }
        }
    }
}

/// T and H at frequencies across.
struct Symbol<'a, R: Element, S: Simd> {
    toeplitz: &'a [R::Vector<S>],
    hankel: &'a [Wave<R, S>],
    /// Imaginary part of `toeplitz`; `None` at rest.
    odd: Option<&'a [R::Vector<S>]>,
}

/// T F + H F', real and imaginary parts exchanged.
#[inline(always)]
fn answer<R: Element, S: Simd>(
    simd: S,
    wave: Wave<R, S>,
    other: Wave<R, S>,
    toeplitz: R::Vector<S>,
    hankel: Wave<R, S>,
) -> Wave<R, S> {
    let [re, im] = product::<R, S>(simd, hankel, other);
    [R::mul_add(simd, toeplitz, wave[1], im), R::mul_add(simd, toeplitz, wave[0], re)]
}

/// U(k) = T(k) F(k) + H(k) F(-k), in place, with real and imaginary parts exchanged for the inverse transform; -k is
/// at `mirror` - m.
#[inline(always)]
fn respond<R: Element, S: Simd>(
    simd: S,
    waves: &mut [Wave<R, S>],
    Symbol { toeplitz, hankel, odd }: Symbol<'_, R, S>,
    mirror: usize,
) {
    let length = waves.len();
    for m in 0..length {
        let other = (mirror - m) % length;
        if m <= other {
            let (wave, opposite) = (waves[m], waves[other]);
            let mut answers = [
                answer::<R, S>(simd, wave, opposite, toeplitz[m], hankel[m]),
                answer::<R, S>(simd, opposite, wave, toeplitz[other], hankel[other]),
            ];
            if let Some(odd) = odd {
                let [first, second] = answers;
                answers =
                    [with_odd::<R, S>(simd, first, wave, odd[m]), with_odd::<R, S>(simd, second, opposite, odd[other])];
            }
            [waves[m], waves[other]] = answers;
        }
    }
}

/// Adds i T' F, real and imaginary parts exchanged.
#[inline(always)]
fn with_odd<R: Element, S: Simd>(simd: S, [im, re]: Wave<R, S>, wave: Wave<R, S>, odd: R::Vector<S>) -> Wave<R, S> {
    [R::mul_add(simd, odd, wave[0], im), R::mul_add(simd, R::neg(simd, odd), wave[1], re)]
}
