//! Displacements of the cells by the forces of the same instant: free field and the images of the tyre's sides,
//!
//! G(ij, i'j') = T\[|i-i'|\]\[|j-j'|\] + H\[|i-i'|\]\[j+j'\].
//!
//! With rotation, G has a part that is odd along, whose T and H change their sign where i < i'. The whole of G is
//! then not symmetric; its symmetric part is positive definite (see `folded_sum`).

use std::borrow::Cow;

use pulp::{Arch, Simd, WithSimd};

use super::blocks::BlockTerm;
use super::product::CellProduct;
use crate::counters::Work;
use crate::numeric::{Element, transform_length};
use crate::tyre::influence::{CellGrid, CellInfluence};
use crate::tyre::tread_pattern::blocks::TreadBlocks;

/// G of the cells of a window \[m/N\].
pub struct InstantCells {
    influence: CellInfluence,
    arch: Arch,
    product: CellProduct<f64>,
    /// Products with the symmetric part; `None` at rest, where it is all.
    symmetric: Option<Box<CellProduct<f64>>>,
    /// Blocks of the tread that yield by themselves, if there are any.
    blocks: Option<Box<BlockTerm>>,
    /// Products in single precision, of windows as long as this one and of shorter ones, the longest first.
    single: Vec<CellProduct<f32>>,
    /// Work of all products so far.
    work: Work,
    /// Most by which a unit force lowers a cell so many columns away, at any place across \[m/N\].
    lowered: Vec<f64>,
    /// For cells with i >= i', the column of the force; of a tyre that turns then for those with i < i'.
    tables: Vec<SingleTables>,
}

/// Influences to single precision.
struct SingleTables {
    /// T for distances across from 1 - across to across - 1.
    mirrored: Vec<f32>,
    /// H.
    images: Vec<f32>,
}

impl SingleTables {
    /// Tables of the even part alone, or with an odd part times a sign.
    fn new(influence: &CellInfluence, sign: f64) -> Self {
        let CellInfluence { across, toeplitz, hankel, odd, .. } = influence;
        let [mut toeplitz, mut hankel] = [toeplitz, hankel].map(|even| Cow::Borrowed(even.as_slice()));
        if let Some(odd) = odd {
            for (both, odd) in [(&mut toeplitz, &odd.toeplitz), (&mut hankel, &odd.hankel)] {
                both.to_mut().iter_mut().zip(odd).for_each(|(both, odd)| *both += sign * odd);
            }
        }
        Self {
            mirrored: toeplitz
                .chunks_exact(*across)
                .flat_map(|row| row[1..].iter().rev().chain(row))
                .map(|&value| value as f32)
                .collect(),
            images: hankel.iter().map(|&value| value as f32).collect(),
        }
    }
}

/// Lengths of a window's parts, each about a tenth shorter than the previous one, that transforms are fast for; down
/// to a quarter of the window.
fn lengths(columns: usize) -> impl Iterator<Item = usize> {
    let shorter = |length: usize| (1..=9 * length / 10).rev().find(|part| transform_length(2 * part) == 2 * part);
    std::iter::successors(Some(columns), move |length| shorter(*length).filter(|part| 4 * part >= columns))
}

/// Most by which a unit force lowers a cell by distance along \[m/N\].
fn lowered(CellInfluence { columns, across, toeplitz, hankel, odd }: &CellInfluence) -> Vec<f64> {
    let most =
        |values: &[f64], size: fn(f64) -> f64| values.iter().fold(f64::NEG_INFINITY, |most, &v| most.max(size(v)));
    let of_column = |column: usize| {
        let (free, images) =
            (column * across..(column + 1) * across, column * (2 * across - 1)..(column + 1) * (2 * across - 1));
        let even = most(&toeplitz[free.clone()], |value| -value) + most(&hankel[images.clone()], |value| -value);
        let odd =
            odd.as_ref().map_or(0.0, |odd| most(&odd.toeplitz[free], f64::abs) + most(&odd.hankel[images], f64::abs));
        (even + odd).max(0.0)
    };
    (0..*columns).map(of_column).collect()
}

impl InstantCells {
    /// Products with an influence, for its window.
    pub fn new(influence: CellInfluence) -> Self {
        let CellInfluence { columns, across, toeplitz, hankel, odd } = &influence;
        let signs: &[f64] = if odd.is_some() { &[1.0, -1.0] } else { &[1.0] };
        let symmetric = || Box::new(CellProduct::new(*columns, *across, toeplitz, hankel));
        Self {
            arch: Arch::new(),
            product: CellProduct::whole(*columns, &influence),
            symmetric: odd.is_some().then(symmetric),
            blocks: None,
            single: lengths(*columns).map(|part| CellProduct::whole(part, &influence)).collect(),
            work: Work::default(),
            lowered: lowered(&influence),
            tables: signs.iter().map(|sign| SingleTables::new(&influence, *sign)).collect(),
            influence,
        }
    }

    /// Adds blocks of the tread that yield by themselves.
    #[must_use]
    pub fn with_blocks(mut self, blocks: Option<BlockTerm>) -> Self {
        self.blocks = blocks.map(Box::new);
        self
    }

    /// G of a window of the cells of a grid, whose blocks yield by themselves.
    pub(crate) fn on_blocks(influence: CellInfluence, grid: &CellGrid, blocks: Option<&TreadBlocks>) -> Self {
        let (face, cells) = (grid.length() * grid.pitch(), influence.columns * grid.across);
        Self::new(influence).with_blocks(blocks.map(|blocks| BlockTerm::new(blocks, face, grid.across, cells)))
    }

    /// Moves to the window that begins with an element of the tyre: its blocks are material.
    pub fn place(&mut self, first_element: i64) {
        if let Some(blocks) = &mut self.blocks {
            blocks.place(first_element);
        }
    }

    /// Restricts products in single precision to a part of the window that begins with a cell.
    pub(super) fn restrict_to(&mut self, start: usize) {
        if let Some(blocks) = &mut self.blocks {
            blocks.restrict_to(start);
        }
    }

    pub(super) fn blocks(&self) -> Option<&BlockTerm> {
        self.blocks.as_deref()
    }

    /// Cells along.
    pub fn columns(&self) -> usize {
        self.influence.columns
    }

    /// Cells across.
    pub fn across(&self) -> usize {
        self.influence.across
    }

    /// Cells of the window.
    pub fn cells(&self) -> usize {
        self.columns() * self.across()
    }

    /// True if G is not symmetric, as for a tyre that turns.
    pub fn turns(&self) -> bool {
        self.symmetric.is_some()
    }

    /// G between two cells: displacement of `a` per force on `b` \[m/N\].
    pub fn entry(&self, a: usize, b: usize) -> f64 {
        let across = self.across();
        let along = (a / across).abs_diff(b / across);
        let (ja, jb) = (a % across, b % across);
        let [free, image] = [along * across + ja.abs_diff(jb), along * (2 * across - 1) + ja + jb];
        let CellInfluence { toeplitz, hankel, odd, .. } = &self.influence;
        let of_block = self.blocks.as_ref().map_or(0.0, |blocks| blocks.entry(a, b));
        let even = toeplitz[free] + hankel[image] + of_block;
        let Some(odd) = odd else { return even };
        let sign = if a / across < b / across { -1.0 } else { 1.0 };
        even + sign * (odd.toeplitz[free] + odd.hankel[image])
    }

    /// T \[m/N\], row-major.
    pub fn free_field(&self) -> &[f64] {
        &self.influence.toeplitz
    }

    /// u = G F.
    pub fn displacement(&mut self, forces: &[f64], out: &mut [f64]) {
        self.work += self.product.work();
        self.product.displacement(forces, out);
        self.yield_in_blocks(forces, out);
    }

    /// Adds the displacements by which blocks yield.
    fn yield_in_blocks<R: Element>(&mut self, forces: &[R], out: &mut [R]) {
        if let Some(blocks) = &mut self.blocks {
            self.work += BlockTerm::work(forces.len());
            blocks.add(forces, out);
        }
    }

    /// u = G F with the symmetric part of G.
    pub fn symmetric_displacement(&mut self, forces: &[f64], out: &mut [f64]) {
        let product = self.symmetric.as_deref_mut().unwrap_or(&mut self.product);
        self.work += product.work();
        product.displacement(forces, out);
        self.yield_in_blocks(forces, out);
    }

    /// Least length of a part of the window, in columns, that holds `columns` and has products in single precision.
    pub fn part(&self, columns: usize) -> usize {
        self.single.iter().map(CellProduct::columns).rfind(|part| *part >= columns).unwrap_or(self.columns())
    }

    /// u = G F to single precision, on a part of the window of one of the lengths of [`Self::part`].
    pub fn single_displacement(&mut self, forces: &[f32], out: &mut [f32]) {
        let columns = forces.len() / self.across();
        if let Some(product) = self.single.iter_mut().find(|product| product.columns() == columns) {
            self.work += product.work();
            product.displacement(forces, out);
        }
        self.yield_in_blocks(forces, out);
    }

    /// Bound by which forces, given by column, lower a cell of a column \[m\].
    pub fn lowering(&self, column: usize, forces: impl Iterator<Item = (usize, f64)>) -> f64 {
        forces.map(|(other, force)| self.lowered[column.abs_diff(other)] * force).sum()
    }

    /// Adds the displacements by one force to u, to single precision, on the first cells of the window.
    pub fn add_single_force(&mut self, cell: usize, force: f32, out: &mut [f32]) {
        let cells = out.len() as u64;
        // Both tables, and what is added to.
        self.work += Work { multiply_adds: cells, bytes: 16 * cells };
        self.arch.dispatch(OneForce { cells: self, cell, force, out: &mut *out });
        if let Some(blocks) = &mut self.blocks {
            blocks.add_one(cell, force, out);
        }
    }

    /// Work of all products so far.
    pub fn work(&self) -> Work {
        self.work
    }

    pub(super) fn set_work(&mut self, work: Work) {
        self.work = work;
    }

    /// Bound of the norm of the symmetric part of G \[m/N\].
    pub fn norm_bound(&self) -> f64 {
        self.product.norm_bound + self.blocks.as_ref().map_or(0.0, |blocks| blocks.norm())
    }

    /// Middle of the inverse of T, (radius + 1) x (radius + 1) by distance along and across \[N/m\].
    pub fn inverse_stencil(&self, radius: usize) -> Vec<f32> {
        self.product.inverse_stencil(radius)
    }
}

struct OneForce<'a> {
    cells: &'a InstantCells,
    cell: usize,
    force: f32,
    out: &'a mut [f32],
}

impl WithSimd for OneForce<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { cells, cell, force, out } = self;
        let (across, tables) = (cells.across(), &cells.tables);
        let (column, j, lanes) = (cell / across, cell % across, S::F32_LANES);
        let (width, force) = (2 * across - 1, simd.splat_f32s(force));
        for (i, out) in out.chunks_exact_mut(across).enumerate() {
            let row = i.abs_diff(column) * width;
            let SingleTables { mirrored, images } = &tables[if i < column { tables.len() - 1 } else { 0 }];
            let free = &mirrored[row + across - 1 - j..][..across];
            let images = &images[row + j..][..across];
            for ((out, free), images) in out.chunks_mut(lanes).zip(free.chunks(lanes)).zip(images.chunks(lanes)) {
                let both = simd.add_f32s(f32::load(simd, free), f32::load(simd, images));
                let sum = simd.mul_add_e_f32s(force, both, f32::load(simd, out));
                f32::store(simd, out, sum);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tyre::influence::OddInfluence;

    #[test]
    fn products_are_those_with_the_entries() {
        let shapes = [(1, 1), (1, 7), (5, 1), (2, 3), (7, 9), (17, 33), (30, 25), (64, 60)];
        for ((columns, across), turns) in shapes.into_iter().flat_map(|shape| [(shape, false), (shape, true)]) {
            let value = |n: usize, m: usize, c: f64| (c * (n * m) as f64 + n as f64).sin() / (1 + n + m) as f64;
            let table =
                |width: usize, c: f64| (0..columns * width).map(|n| value(n / width, n % width, c)).collect::<Vec<_>>();
            let (toeplitz, hankel) = (table(across, 0.3), table(2 * across - 1, 0.7));
            let odd_table = |width: usize, c: f64| [vec![0.0; width], table(width, c)[width..].to_vec()].concat();
            let odd = || OddInfluence { toeplitz: odd_table(across, 0.4), hankel: odd_table(2 * across - 1, 0.9) };
            let odd = turns.then(odd);
            let mut cells = InstantCells::new(CellInfluence { columns, across, toeplitz, hankel, odd });
            assert_eq!(cells.turns(), turns);
            let forces: Vec<f64> = (0..cells.cells()).map(|n| (n as f64 * 1.3).cos()).collect();
            let single: Vec<f32> = forces.iter().map(|force| *force as f32).collect();
            let (mut u, mut single_u) = (vec![1.0; cells.cells()], vec![0.0; cells.cells()]);
            cells.displacement(&forces, &mut u);
            cells.single_displacement(&single, &mut single_u);
            let largest = u.iter().fold(1.0_f64, |largest, u| largest.max(u.abs()));
            for a in (0..cells.cells()).step_by(1 + cells.cells() / 100) {
                let expected: f64 = forces.iter().enumerate().map(|(b, force)| cells.entry(a, b) * force).sum();
                let error = (u[a] - expected).abs() / largest;
                assert!(error < 1e-14 * (1.0 + cells.cells() as f64).sqrt(), "{columns} x {across}: {error:e}");
                assert!((f64::from(single_u[a]) - expected).abs() < 1e-5 * largest);
            }
            // The symmetric part, and one force after the other.
            let mut symmetric_u = vec![0.0; cells.cells()];
            cells.symmetric_displacement(&forces, &mut symmetric_u);
            for cell in (0..cells.cells()).step_by(1 + cells.cells() / 50) {
                let symmetric = |b: usize| 0.5 * (cells.entry(cell, b) + cells.entry(b, cell));
                let expected: f64 = forces.iter().enumerate().map(|(b, force)| symmetric(b) * force).sum();
                let error = (symmetric_u[cell] - expected).abs() / largest;
                assert!(error < 1e-14 * (1.0 + cells.cells() as f64).sqrt(), "{columns} x {across}: {error:e}");
                single_u.fill(0.0);
                cells.add_single_force(cell, 2.0, &mut single_u);
                for (a, u) in single_u.iter().enumerate() {
                    assert!((f64::from(*u) - 2.0 * cells.entry(a, cell)).abs() < 1e-5, "{columns} x {across}");
                }
            }
        }
    }

    #[test]
    #[ignore = "measures"]
    fn time_of_products() {
        for (columns, across) in [(64, 60), (128, 120)] {
            let table = |width: usize| (0..columns * width).map(|n| (n as f64).sin()).collect::<Vec<_>>();
            let (toeplitz, hankel) = (table(across), table(2 * across - 1));
            let mut cells = InstantCells::new(CellInfluence { columns, across, toeplitz, hankel, odd: None });
            let forces = vec![1.0; cells.cells()];
            let single = vec![1.0; cells.cells()];
            let (mut u, mut single_u) = (vec![0.0; cells.cells()], vec![0.0; cells.cells()]);
            let best = |mut work: Box<dyn FnMut() + '_>| {
                (0..2000)
                    .map(|_| {
                        let begin = std::time::Instant::now();
                        work();
                        begin.elapsed()
                    })
                    .min()
            };
            let double = best(Box::new(|| cells.displacement(&forces, &mut u)));
            let single = best(Box::new(|| cells.single_displacement(&single, &mut single_u)));
            println!("{columns} x {across}: {double:?}, {single:?}");
        }
    }
}
