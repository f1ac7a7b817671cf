//! Volume that blocks press into the voids beside them.
//!
//! Rubber keeps its volume: a block that its force F_b presses in by c_b F_b/A_b more than a tread without cuts bulges
//! into its voids by the volume c_b F_b. Nothing is fitted. A rib does that for each place of a block on it.

use super::blocks::{NO_BLOCK, TreadBlock, TreadBlocks};

/// Lists of cells, one per part of a block.
#[derive(Clone, Debug, PartialEq)]
struct Lists {
    /// Index of each part's first cell, and of the end.
    starts: Vec<u32>,
    cells: Vec<u32>,
}

impl Lists {
    /// From pairs of a part and a cell.
    fn new(pairs: &[[u32; 2]], parts: usize) -> Self {
        let mut starts = vec![0; parts + 1];
        for &[part, _] in pairs {
            starts[part as usize + 1] += 1;
        }
        for part in 0..parts {
            starts[part + 1] += starts[part];
        }
        let (mut next, mut cells) = (starts.clone(), vec![0; pairs.len()]);
        for &[part, cell] in pairs {
            cells[next[part as usize] as usize] = cell;
            next[part as usize] += 1;
        }
        Self { starts, cells }
    }

    fn of(&self, part: usize) -> &[u32] {
        &self.cells[self.starts[part] as usize..self.starts[part + 1] as usize]
    }

    fn counts(&self) -> Vec<u32> {
        self.starts.windows(2).map(|ends| ends[1] - ends[0]).collect()
    }
}

/// Blocks of a tread with the void cells that share a side with each.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Squeeze {
    /// Columns round the tyre.
    pub columns: usize,
    /// Cells across the strip.
    pub across: usize,
    /// Blocks of the tread.
    pub blocks: TreadBlocks,
    /// Volume by force that goes in at each cell of a block, and comes out at each void beside it, for each place
    /// where pressure is averaged; 0 where a block has no voids \[m^3/N\].
    pub shares: Vec<[f64; 2]>,
    block_cells: Lists,
    voids: Lists,
}

impl Squeeze {
    /// Voids beside the blocks of a tread with so many cells across. A cell beside a block that belongs to none is a
    /// void deep enough to divide blocks. It counts once for each part of a block beside it.
    pub(crate) fn new(blocks: &TreadBlocks, across: usize) -> Self {
        let (of_cell, count) = (&blocks.of_cell, blocks.cells.len());
        let columns = of_cell.len() / across;
        let (mut block_cells, mut voids) = (Vec::new(), Vec::new());
        for (cell, &part) in of_cell.iter().enumerate() {
            if part != NO_BLOCK {
                block_cells.push([part, cell as u32]);
                continue;
            }
            let (i, j) = (cell / across, cell % across);
            let [ahead, behind] = [(i + 1) % columns, (i + columns - 1) % columns].map(|i| i * across + j);
            let beside = [
                Some(ahead),
                Some(behind),
                (j + 1 < across).then(|| cell + 1),
                (j > 0).then(|| cell.saturating_sub(1)),
            ];
            let mut found: Vec<u32> =
                beside.into_iter().flatten().map(|next| of_cell[next]).filter(|part| *part != NO_BLOCK).collect();
            found.sort_unstable();
            found.dedup();
            voids.extend(found.into_iter().map(|part| [part, cell as u32]));
        }
        // Volume per force and cell; a place without voids presses nothing out.
        let (block_cells, voids) = (Lists::new(&block_cells, count), Lists::new(&voids, count));
        let volume = |block: &TreadBlock| {
            std::iter::repeat_n(block.compliance / f64::from(block.length), block.places() as usize)
        };
        let cells = blocks.averaged(&blocks.cells).into_iter().zip(blocks.averaged(&voids.counts()));
        let share = |(volume, (cells, voids)): (f64, (u32, u32))| match voids.min(cells) {
            0 => [0.0; 2],
            _ => [cells, voids].map(|cells| volume / f64::from(cells)),
        };
        let shares = blocks.blocks.iter().flat_map(volume).zip(cells).map(share).collect();
        Self { columns, across, blocks: blocks.clone(), shares, block_cells, voids }
    }

    /// Cells of a part of a block.
    pub(crate) fn block_cells(&self, part: usize) -> &[u32] {
        self.block_cells.of(part)
    }

    /// Void cells beside a part of a block; empty for one between sipes alone.
    pub(crate) fn voids(&self, part: usize) -> &[u32] {
        self.voids.of(part)
    }

    /// Number of blocks, and of those without a void beside them.
    pub(crate) fn counts(&self) -> [usize; 2] {
        let has_none = |block: &&TreadBlock| {
            let parts = block.first as usize..(block.first + block.parts) as usize;
            parts.into_iter().all(|part| self.voids(part).is_empty())
        };
        [self.blocks.blocks.len(), self.blocks.blocks.iter().filter(has_none).count()]
    }

    /// Largest distance in columns of a force on a block from the volume that it causes, in the block or its voids.
    pub(crate) fn reach(&self) -> usize {
        let of = |block: &TreadBlock| {
            let parts = block.first as usize..(block.first + block.parts) as usize;
            let part = parts.map(|part| self.extent(part)).max().unwrap_or(0);
            part + block.length as usize - 1
        };
        self.blocks.blocks.iter().map(of).max().unwrap_or(0)
    }

    /// Columns from the first to the last cell of a part and its voids, the shorter way round the tyre.
    fn extent(&self, part: usize) -> usize {
        let cells = self.block_cells(part).iter().chain(self.voids(part));
        let mut found: Vec<usize> = cells.map(|&cell| cell as usize / self.across).collect();
        found.sort_unstable();
        let (Some(first), Some(last)) = (found.first(), found.last()) else { return 0 };
        let behind = first + self.columns - last;
        let gap = found.windows(2).map(|pair| pair[1] - pair[0]).fold(behind, usize::max);
        self.columns - gap
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six columns of four cells: a block that spans the seam, one in the middle, a groove beside both, and a rib.
    fn squeeze() -> Squeeze {
        let rows: [[u32; 4]; 6] = [
            [NO_BLOCK, 0, 0, 2],
            [NO_BLOCK, NO_BLOCK, 0, 2],
            [NO_BLOCK, 1, 1, 2],
            [NO_BLOCK, 1, 1, 2],
            [NO_BLOCK, NO_BLOCK, NO_BLOCK, 2],
            [NO_BLOCK, 0, 0, 2],
        ];
        Squeeze::new(&TreadBlocks::whole(rows.concat(), &[1e-10, 2e-10, 3e-10]), 4)
    }

    #[test]
    fn voids_beside_a_block_share_a_side_with_it_round_the_seam_too() {
        let squeeze = squeeze();
        assert_eq!(squeeze.block_cells(0), [1, 2, 6, 21, 22]);
        // (0, 0), (1, 1) which two of its cells meet, (4, 1), (4, 2) and (5, 0).
        assert_eq!(squeeze.voids(0), [0, 5, 17, 18, 20]);
        assert_eq!(squeeze.voids(1), [5, 8, 12, 17, 18]);
        // A rib beside blocks and the end of one groove.
        assert_eq!(squeeze.voids(2), [18]);
        assert_eq!(squeeze.counts(), [3, 0]);
        // Columns 4 to 1 round the seam, 1 to 4, and all.
        assert_eq!([0, 1, 2].map(|block| squeeze.extent(block)), [3, 3, 5]);
        assert_eq!(squeeze.reach(), 5);
    }
}
