//! Products of the influence between cells with the forces on all of them, wave by wave along.
//!
//! Across, the cells at y and -y are taken together, as sums and as differences, which a tyre that is even about its
//! middle does not mix. Along, transforms as long as there are distances: nothing wraps round, and windows are short
//! enough for products with cosines and sines.
//! 1. f+_j = f_j + f_-j and f-_j = f_j - f_-j, component by component; the middle cell counts once;
//! 2. F(k) of each row along;
//! 3. u^s_a(k, j) = sum over b, t, j' of W^st_ab(k, j, j') F^t_b(k, j'), real and imaginary parts of W apart, without
//!    blocks that are 0;
//! 4. back along, u_j = u+_j + u-_j, u_-j = u+_j - u-_j.
//!
//! Vectors hold waves along. Directions of linear equations take products in single precision.

use std::f64::consts::TAU;
use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use crate::contact::cells::wave_transform::WaveNumber;
use crate::counters::Work;
use crate::tyre::influence::{COMPONENTS, TractionInfluence};

/// Forces or displacements of a cell: forward, to the left, into the tyre.
pub(crate) type Vector = [f64; COMPONENTS];

/// Sums and differences.
const SIDES: usize = 2;
/// Part of the largest weight of a pair below which a block of it is rounding.
const ROUNDING: f64 = 1e-13;
/// Columns between the lengths of those parts of a window that have products.
const STRIDE: usize = 8;

/// G between the cells of a window, with products for parts of it, as long as they are needed.
pub(crate) struct WindowProduct {
    influence: TractionInfluence,
    /// By length of a part; made as needed. In double and in single precision.
    parts: Vec<Option<TractionProduct>>,
    rough: Vec<Option<TractionProduct<f32>>>,
    work: Work,
}

/// G in the waves of a window, with space for a product.
pub(crate) struct TractionProduct<R = f64> {
    columns: usize,
    across: usize,
    /// Waves along, in whole vectors.
    waves: usize,
    /// cos and -sin of the waves, columns x 2 waves.
    forward: Vec<R>,
    /// Inverse of these, 2 waves x columns.
    back: Vec<R>,
    blocks: Vec<Block>,
    /// Weights \[m/N\] by block, j, j' and wave.
    weights: Vec<R>,
    /// By component, side and j: columns; then waves of forces and displacements, real and imaginary parts.
    rows: Vec<R>,
    forces: Vec<R>,
    displacements: Vec<R>,
    arch: Arch,
}

/// Weights between one component and side of displacements and one of forces.
#[derive(Clone, Copy)]
struct Block {
    /// First rows.
    to: usize,
    from: usize,
    is_imaginary: bool,
}

/// u = G F within a part by the product of its length.
fn within<R: WaveNumber>(
    influence: &TractionInfluence,
    parts: &mut [Option<TractionProduct<R>>],
    work: &mut Work,
    part: &Range<usize>,
    (forces, out): (&[Vector], &mut [Vector]),
) {
    let columns = part.len() / influence.across;
    let make = || TractionProduct::new(&influence.narrowed(columns));
    let product = parts[(columns - 1) / STRIDE].get_or_insert_with(make);
    *work += product.work();
    product.displacement(&forces[part.clone()], &mut out[part.clone()]);
}

/// Number of a component and a side.
fn field(component: usize, side: usize) -> usize {
    component * SIDES + side
}

/// Waves along of a table whose rows stand for distances, wave by wave.
pub(super) fn transformed(table: &[f64], width: usize, columns: usize) -> Vec<Complex64> {
    let length = 2 * columns - 1;
    let turns: Vec<Complex64> = (0..length).map(|n| Complex64::cis(-TAU * n as f64 / length as f64)).collect();
    let mut out = vec![Complex64::ZERO; columns * width];
    for (wave, out) in out.chunks_exact_mut(width).enumerate() {
        for (row, values) in table.chunks_exact(width).enumerate() {
            let turn = turns[wave * (row + columns) % length];
            out.iter_mut().zip(values).for_each(|(out, value)| *out += turn * value);
        }
    }
    out
}

impl WindowProduct {
    pub(crate) fn new(influence: TractionInfluence) -> Self {
        let parts = influence.columns.div_ceil(STRIDE);
        let (exact, rough) = ((0..parts).map(|_| None).collect(), (0..parts).map(|_| None).collect());
        Self { influence, parts: exact, rough, work: Work::default() }
    }

    pub(crate) fn influence(&self) -> &TractionInfluence {
        &self.influence
    }

    /// Work of all products since the last call.
    pub(crate) fn take_work(&mut self) -> Work {
        std::mem::take(&mut self.work)
    }

    /// Columns of the shortest part that has a product and holds `columns` columns.
    fn length(&self, columns: usize) -> usize {
        self.influence.columns.min(columns.div_ceil(STRIDE).max(1) * STRIDE)
    }

    /// Cells of the shortest part that has a product and holds some columns.
    pub(crate) fn part(&self, columns: &Range<usize>) -> Range<usize> {
        let (across, length) = (self.influence.across, self.length(columns.len()));
        let first = columns.start.min(self.influence.columns - length);
        first * across..(first + length) * across
    }

    /// u = G F within a part.
    pub(crate) fn displacement(&mut self, part: &Range<usize>, forces: &[Vector], out: &mut [Vector]) {
        let Self { influence, parts, work, .. } = self;
        within(influence, parts, work, part, (forces, out));
    }

    /// u = G F within a part, in single precision.
    pub(crate) fn rough_displacement(&mut self, part: &Range<usize>, forces: &[Vector], out: &mut [Vector]) {
        let Self { influence, rough, work, .. } = self;
        within(influence, rough, work, part, (forces, out));
    }
}

impl<R: WaveNumber> TractionProduct<R> {
    /// Product with an influence, for its whole window.
    pub(crate) fn new(influence: &TractionInfluence) -> Self {
        let (columns, across) = (influence.columns, influence.across);
        let (half, waves) = (across.div_ceil(2), columns.next_multiple_of(R::MOST_LANES));
        let length = 2 * columns - 1;
        let turn = |wave: usize, column: usize| Complex64::cis(-TAU * (wave * column % length) as f64 / length as f64);
        let (mut forward, mut back) =
            (vec![R::default(); columns * 2 * waves], vec![R::default(); 2 * waves * columns]);
        for wave in 0..columns {
            // A wave and its conjugate.
            let times = if wave == 0 { 1.0 } else { 2.0 } / length as f64;
            for column in 0..columns {
                let turn = turn(wave, column);
                for (part, value) in [turn.re, turn.im].into_iter().enumerate() {
                    forward[(2 * column + part) * waves + wave] = R::rounded(value);
                    back[(part * waves + wave) * columns + column] = R::rounded(times * value);
                }
            }
        }
        let rows = COMPONENTS * SIDES * half;
        let zeros = || vec![R::default(); rows * 2 * waves];
        let mut this = Self {
            columns,
            across,
            waves,
            forward,
            back,
            blocks: Vec::new(),
            weights: Vec::new(),
            rows: vec![R::default(); rows * columns],
            forces: zeros(),
            displacements: zeros(),
            arch: Arch::new(),
        };
        for pair in 0..COMPONENTS * COMPONENTS {
            this.add_pair(influence, pair);
        }
        this
    }

    /// Adds the blocks of a pair of components, those that are 0 to rounding left out.
    fn add_pair(&mut self, influence: &TractionInfluence, pair: usize) {
        let (columns, across, waves) = (self.columns, self.across, self.waves);
        let (a, b, half, width) = (pair / COMPONENTS, pair % COMPONENTS, across.div_ceil(2), influence.width());
        let of = |table: &[f64], width: usize| {
            if table.is_empty() { Vec::new() } else { transformed(table, width, columns) }
        };
        let tables = &influence.pairs[pair];
        let [toeplitz, hankel] = [&tables.toeplitz, &tables.hankel].map(|table| of(table, width));
        let uniform = influence.uniform.as_deref();
        let driven = uniform.filter(|_| b == 1).map_or_else(Vec::new, |tables| of(&tables.driven[a], across));
        let observed = uniform.filter(|_| a == 1).map_or_else(Vec::new, |tables| of(&tables.observed[b], across));
        if [&toeplitz, &hankel, &driven, &observed].iter().all(|table| table.is_empty()) {
            return;
        }
        let entry = |wave: usize, i: usize, j: usize| {
            let at = |table: &[Complex64], width: usize, place: usize| {
                table.get(wave * width + place).copied().unwrap_or_default()
            };
            at(&toeplitz, width, i + across - 1 - j) + at(&hankel, width, i + j)
                - at(&driven, across, i)
                - at(&observed, across, j)
        };
        let of_block = |number: usize| {
            let (side, other) = (number / SIDES, number % SIDES);
            let sign = |side: usize| if side == 0 { 0.5 } else { -0.5 };
            let mut parts = [(); 2].map(|()| vec![0.0; half * half * waves]);
            for (place, wave) in (0..half * half).flat_map(|place| (0..columns).map(move |wave| (place, wave))) {
                let (i, j) = (place / half, place % half);
                let (far_i, far_j) = (across - 1 - i, across - 1 - j);
                let near = |j: usize| 0.5 * entry(wave, i, j) + sign(side) * entry(wave, far_i, j);
                let value = 0.5 * near(j) + sign(other) * near(far_j);
                (parts[0][place * waves + wave], parts[1][place * waves + wave]) = (value.re, value.im);
            }
            let [to, from] = [field(a, side), field(b, other)].map(|field| field * half);
            parts.into_iter().enumerate().map(move |(part, weights)| {
                let largest = weights.iter().fold(0.0_f64, |largest, weight| largest.max(weight.abs()));
                (Block { to, from, is_imaginary: part == 1 }, weights, largest)
            })
        };
        let all: Vec<(Block, Vec<f64>, f64)> = (0..SIDES * SIDES).flat_map(of_block).collect();
        let least = ROUNDING * all.iter().fold(0.0_f64, |most, (.., largest)| most.max(*largest));
        for (block, weights, _) in all.into_iter().filter(|(.., largest)| *largest > least) {
            self.blocks.push(block);
            self.weights.extend(weights.into_iter().map(R::rounded));
        }
    }

    /// Work of a product.
    pub(crate) fn work(&self) -> Work {
        let transforms = 2 * self.rows.len() * 2 * self.waves;
        let numbers = 2 * self.forward.len() + 4 * self.forces.len() + self.weights.len();
        Work { multiply_adds: (transforms + 2 * self.weights.len()) as u64, bytes: (size_of::<R>() * numbers) as u64 }
    }

    /// u = G F.
    pub(crate) fn displacement(&mut self, forces: &[Vector], out: &mut [Vector]) {
        let (columns, across, half) = (self.columns, self.across, self.across.div_ceil(2));
        for (column, cells) in forces.chunks_exact(across).enumerate() {
            for j in 0..half {
                let (near, far) = (cells[j], cells[across - 1 - j]);
                for component in 0..COMPONENTS {
                    let (near, far) = (near[component], far[component]);
                    let sides = if 2 * j + 1 == across { [near, 0.0] } else { [near + far, near - far] };
                    for (side, value) in sides.into_iter().enumerate() {
                        self.rows[(field(component, side) * half + j) * columns + column] = R::rounded(value);
                    }
                }
            }
        }
        let (count, width) = (COMPONENTS * SIDES * half, 2 * self.waves);
        matmul(
            MatMut::from_row_major_slice_mut(&mut self.forces, count, width),
            Accum::Replace,
            MatRef::from_row_major_slice(&self.rows, count, columns),
            MatRef::from_row_major_slice(&self.forward, columns, width),
            R::rounded(1.0),
            Par::Seq,
        );
        let arch = self.arch;
        arch.dispatch(Multiply { product: self, half });
        matmul(
            MatMut::from_row_major_slice_mut(&mut self.rows, count, columns),
            Accum::Replace,
            MatRef::from_row_major_slice(&self.displacements, count, width),
            MatRef::from_row_major_slice(&self.back, width, columns),
            R::rounded(1.0),
            Par::Seq,
        );
        for (column, cells) in out.chunks_exact_mut(across).enumerate() {
            for j in 0..half {
                let place = |component: usize, side: usize| (field(component, side) * half + j) * columns + column;
                let at = |component: usize, side: usize| self.rows[place(component, side)].double();
                // The difference of the middle cell is 0.
                cells[across - 1 - j] = std::array::from_fn(|component| at(component, 0) - at(component, 1));
                cells[j] = std::array::from_fn(|component| at(component, 0) + at(component, 1));
            }
        }
    }
}

/// Products of all waves.
struct Multiply<'a, R> {
    product: &'a mut TractionProduct<R>,
    half: usize,
}

impl<R: WaveNumber> WithSimd for Multiply<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { product: TractionProduct { waves, blocks, weights, forces, displacements, .. }, half } = self;
        let vectors = *waves / R::lanes::<S>();
        let (weights, forces) = (R::vectors::<S>(weights), R::vectors::<S>(forces));
        let out = R::vectors_mut::<S>(displacements);
        out.fill(R::splat(simd, R::default()));
        // Plain indices: adaptors of iterators are not inlined here.
        for (number, block) in blocks.iter().enumerate() {
            let weights = &weights[number * half * half * vectors..][..half * half * vectors];
            let forces = &forces[block.from * 2 * vectors..][..half * 2 * vectors];
            let out = &mut out[block.to * 2 * vectors..][..half * 2 * vectors];
            for j in 0..half {
                let weights = &weights[j * half * vectors..][..half * vectors];
                let out = &mut out[2 * j * vectors..][..2 * vectors];
                for v in 0..vectors {
                    let (mut re, mut im) = (out[v], out[vectors + v]);
                    for other in 0..half {
                        let weight = weights[other * vectors + v];
                        let (f_re, f_im) = (forces[2 * other * vectors + v], forces[(2 * other + 1) * vectors + v]);
                        if block.is_imaginary {
                            re = R::negate_mul_add(simd, weight, f_im, re);
                            im = R::mul_add(simd, weight, f_re, im);
                        } else {
                            re = R::mul_add(simd, weight, f_re, re);
                            im = R::mul_add(simd, weight, f_im, im);
                        }
                    }
                    (out[v], out[vectors + v]) = (re, im);
                }
            }
        }
    }
}
