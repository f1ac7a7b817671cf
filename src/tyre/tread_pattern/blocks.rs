//! Blocks between the cuts of a tread, and by how much each yields more than the tread without cuts.
//!
//! Layers have no cuts. A block is pressed as a pad of depth d, shape factor S and modulus E between faces that do not
//! let it slide, where the layer beside it would be pressed by its modulus of one-dimensional compression M:
//!
//! ```text
//! c_b = d (1/E_pad - 1/M),   1/E_pad = 1/(a E) + 1/M
//! a = 1 + 2 S^2              of a block
//! a = (4/3) (1 + S^2)        of a long rib
//! S = A_b/(2 d perimeter)    of the sides that are cut
//! ```
//!
//! so that c_b = d/(a E). It applies to the block's mean pressure: u_i += (c_b/A_b) sum of the block's forces. A block
//! longer than 3 d yields locally, like the mean over all its parts of that length.

use std::collections::{BTreeMap, VecDeque};

use super::map::{Cut, TreadMap};
use crate::scene::{BlockModel, Scene, TreadPattern};
use crate::tyre::layers::material;

/// Frequency at which the tread's modulus is taken \[Hz\], as in the local law of slices.
const MODULUS_FREQUENCY: f64 = 100.0;
/// Least depth of a dividing cut, over the tread's thickness.
const DEEP: f64 = 1.0 / 3.0;
/// Length of a block, in depths, over which its pressure is averaged.
const LENGTH: f64 = 3.0;
/// Length over width from which on a block is a long rib.
const RIB: f64 = 3.0;

/// Mark of a cell that belongs to no block.
pub const NO_BLOCK: u32 = u32::MAX;

/// A block, or a rib, which is longer than its pressure is averaged over. A rib has one part per column and yields
/// like the mean over all blocks of `length` parts, wherever they begin: without cuts it yields the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreadBlock {
    /// Index of the first part.
    pub first: u32,
    /// Number of parts; 1 of a block.
    pub parts: u32,
    /// Number of parts over which pressure is averaged.
    pub length: u32,
    /// True if the last part is followed by the first, round the tyre.
    pub is_ring: bool,
    /// Compliance c_b of the mean pressure \[m/Pa\].
    pub compliance: f64,
}

impl TreadBlock {
    /// Number of places where pressure is averaged: on a ring, one per part; else also those that the ends cut.
    pub(crate) fn places(&self) -> u32 {
        if self.is_ring { self.parts } else { self.parts + self.length - 1 }
    }
}

/// Blocks of a tread.
#[derive(Clone, Debug, PartialEq)]
pub struct TreadBlocks {
    /// Part of each cell, or [`NO_BLOCK`].
    pub of_cell: Vec<u32>,
    /// Number of cells of each part.
    pub cells: Vec<u32>,
    /// Blocks and ribs, in the order of their parts.
    pub blocks: Vec<TreadBlock>,
}

/// A connected piece of the tread between cuts.
#[derive(Default)]
struct Piece {
    /// Cells with their columns, counted on beyond a revolution.
    cells: Vec<(usize, i64)>,
    /// True if it runs round the tyre.
    is_ring: bool,
    /// Extent of the cut sides, along and across \[m\].
    sides: BTreeMap<Cut, [f64; 2]>,
    /// Sum of depth times length of the sides, and of the lengths.
    depth: [f64; 2],
}

impl Piece {
    fn side(&mut self, cut: Cut, depth: f64, extent: [f64; 2]) {
        let side = self.sides.entry(cut).or_default();
        let length = extent[0] + extent[1];
        side.iter_mut().zip(extent).for_each(|(sum, extent)| *sum += extent);
        self.depth[0] += depth * length;
        self.depth[1] += length;
    }

    /// Length of all sides \[m\], given the cuts. A slanted one is a staircase on cells, whose steps along are its
    /// extent across times its slope; any excess is an end.
    fn perimeter(&self, cuts: &[[f64; 2]]) -> f64 {
        let of = |(&cut, &[along, across]): (&Cut, &[f64; 2])| {
            let slope = cuts.get(cut as usize).map_or(0.0, |[_, slope]| slope.abs());
            across * slope.hypot(1.0) + (along - across * slope).max(0.0)
        };
        self.sides.iter().map(of).sum()
    }
}

/// c_b \[m/Pa\] of a block: its area \[m^2\], the perimeter of its cut sides and their depth \[m\], Young's modulus
/// \[Pa\].
pub(crate) fn compliance(area: f64, perimeter: f64, depth: f64, is_rib: bool, modulus: f64) -> f64 {
    let shape = area / (2.0 * depth * perimeter);
    let stiffer = if is_rib { 4.0 / 3.0 * (1.0 + shape * shape) } else { 1.0 + 2.0 * shape * shape };
    depth / (stiffer * modulus)
}

impl TreadBlocks {
    /// Blocks of a scene's tread; `None` where they are no softer than the tread without cuts.
    pub(crate) fn new(map: &TreadMap, pattern: &TreadPattern, scene: &Scene) -> Option<Self> {
        let tread = scene.tyre.layers.last().filter(|_| pattern.blocks == BlockModel::Compliant)?;
        let poisson = tread.material.poisson;
        let modulus = material::effective_modulus(&tread.material, MODULUS_FREQUENCY) * (1.0 - poisson * poisson);
        let blocks = Self::of(map, tread.thickness, modulus, pattern.block_compliance);
        blocks.blocks.iter().any(|block| block.compliance > 0.0).then_some(blocks)
    }

    /// Blocks of a tread of a thickness \[m\] and a Young's modulus \[Pa\], or of a given compliance \[m/Pa\].
    fn of(map: &TreadMap, thickness: f64, modulus: f64, given: Option<f64>) -> Self {
        let (across, [dx, dy]) = (map.across, map.size);
        let mut blocks = Self { of_cell: vec![NO_BLOCK; map.depths.len()], cells: Vec::new(), blocks: Vec::new() };
        for piece in pieces(map, DEEP * thickness) {
            let perimeter = piece.perimeter(&map.cuts);
            if perimeter <= 0.0 {
                continue;
            }
            // 1. Extent, mean lengths and compliance of the piece.
            let depth = piece.depth[0] / piece.depth[1];
            let of = |places: &mut dyn Iterator<Item = i64>| {
                let (mut first, mut last) = (i64::MAX, i64::MIN);
                places.for_each(|place| (first, last) = (first.min(place), last.max(place)));
                (first, last - first + 1)
            };
            let (from, mut columns) = of(&mut piece.cells.iter().map(|cell| cell.1));
            let (right, rows) = of(&mut piece.cells.iter().map(|cell| (cell.0 % across) as i64));
            if piece.is_ring {
                columns = map.columns as i64;
            }
            let area = piece.cells.len() as f64 * dx * dy;
            // Mean lengths: slanted ends do not lengthen a piece.
            let along = if piece.is_ring { columns as f64 * dx } else { area / (rows as f64 * dy) };
            let lengths = [along, rows as f64 * dy];
            let longest = lengths[0].max(lengths[1]);
            let is_rib = piece.is_ring || longest > RIB * area / longest;
            let compliance = given.unwrap_or_else(|| compliance(area, perimeter, depth, is_rib, modulus));
            // 2. Parts: one per column of a long piece, in ribs side by side if it is wide.
            let parts = lengths.map(|length: f64| (length / (LENGTH * depth)).round().max(1.0) as i64);
            let is_long = piece.is_ring || parts[0] > 1;
            let length = if is_long { ((LENGTH * depth / dx).round().max(1.0) as u32).min(columns as u32) } else { 1 };
            let count = if is_long { columns } else { 1 };
            let first = blocks.cells.len();
            for rib in 0..parts[1] {
                blocks.blocks.push(TreadBlock {
                    first: (first as i64 + rib * count) as u32,
                    parts: count as u32,
                    length,
                    is_ring: piece.is_ring,
                    compliance,
                });
            }
            blocks.cells.resize(first + (parts[1] * count) as usize, 0);
            // 3. The part of each cell.
            for &(cell, column) in &piece.cells {
                let along = match (is_long, piece.is_ring) {
                    (false, _) => 0,
                    (true, true) => (cell / across) as i64,
                    (true, false) => column - from,
                };
                let rib = ((cell % across) as i64 - right) * parts[1] / rows;
                let part = first + (rib * count + along) as usize;
                blocks.of_cell[cell] = part as u32;
                blocks.cells[part] += 1;
            }
        }
        blocks
    }

    /// Blocks of given compliances \[m/Pa\], none of which is a rib.
    pub fn whole(of_cell: Vec<u32>, compliances: &[f64]) -> Self {
        let mut cells = vec![0; compliances.len()];
        of_cell.iter().filter(|block| **block != NO_BLOCK).for_each(|&block| cells[block as usize] += 1);
        let block =
            |(first, &compliance): (u32, &f64)| TreadBlock { first, parts: 1, length: 1, is_ring: false, compliance };
        Self { of_cell, cells, blocks: (0..).zip(compliances).map(block).collect() }
    }

    /// A number by part, summed over each place where pressure is averaged, block by block.
    pub(crate) fn averaged(&self, by_part: &[u32]) -> Vec<u32> {
        let of = |block: &TreadBlock| {
            let parts = by_part[block.first as usize..][..block.parts as usize].to_vec();
            let (count, length, is_ring) = (block.parts as usize, block.length as usize, block.is_ring);
            (0..block.places() as usize).map(move |place| match is_ring {
                true => (place..place + length).map(|part| parts[part % count]).sum(),
                false => parts[(place + 1).saturating_sub(length)..(place + 1).min(count)].iter().sum(),
            })
        };
        self.blocks.iter().flat_map(of).collect()
    }

    /// Number of cells over which pressure is averaged in the smallest block; `None` without blocks.
    pub(crate) fn smallest(&self) -> Option<u32> {
        let of = |block: &TreadBlock| {
            let cells: u32 = self.cells[block.first as usize..][..block.parts as usize].iter().sum();
            (f64::from(cells * block.length) / f64::from(block.parts)).round() as u32
        };
        self.blocks.iter().map(of).min()
    }
}

/// Pieces of the tread between cuts deeper than `deep` \[m\], in the order of their first cells.
fn pieces(map: &TreadMap, deep: f64) -> Vec<Piece> {
    let TreadMap { columns, across, size: [dx, dy], depths, groove_of, sipes, cuts, .. } = map;
    let (columns, across) = (*columns, *across);
    let mut reached: Vec<Option<i64>> = vec![None; depths.len()];
    let (mut pieces, mut queue) = (Vec::new(), VecDeque::new());
    for first in 0..depths.len() {
        if depths[first] > deep || reached[first].is_some() {
            continue;
        }
        // Flood fill from the first cell of the piece: sides are collected by cut, and a known cell that is met in
        // another column closes a ring.
        let mut piece = Piece::default();
        reached[first] = Some((first / across) as i64);
        queue.push_back(first);
        while let Some(cell) = queue.pop_front() {
            let Some(column) = reached[cell] else { continue };
            piece.cells.push((cell, column));
            let (i, j) = (cell / across, cell % across);
            let [ahead, behind] = [(i + 1) % columns, (i + columns - 1) % columns].map(|i| i * across + j);
            let beside = [
                (Some((ahead, column + 1)), sipes[0][cell], [0.0, *dy]),
                (Some((behind, column - 1)), sipes[0][behind], [0.0, *dy]),
                ((j + 1 < across).then(|| (cell + 1, column)), sipes[1][cell], [*dx, 0.0]),
                ((j > 0).then(|| (cell - 1, column)), if j > 0 { sipes[1][cell - 1] } else { 0 }, [*dx, 0.0]),
            ];
            for (next, sipe, extent) in beside {
                // The edge of the strip is no cut: the tread continues.
                let Some((next, its_column)) = next else { continue };
                let [sipe_depth, _] = cuts[sipe as usize];
                if depths[next] > deep {
                    piece.side(groove_of[next], depths[next], extent);
                } else if sipe_depth > deep {
                    piece.side(sipe, sipe_depth, extent);
                } else if let Some(known) = reached[next] {
                    piece.is_ring |= known != its_column;
                } else {
                    reached[next] = Some(its_column);
                    queue.push_back(next);
                }
            }
        }
        pieces.push(piece);
    }
    pieces
}

#[cfg(test)]
#[path = "blocks_tests.rs"]
mod tests;
