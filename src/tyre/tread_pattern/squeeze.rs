//! Volume that blocks press into the voids beside them.
//!
//! Rubber keeps its volume: a block that its force F_b presses in by c_b F_b/A_b more than a tread without cuts would
//! be, bulges into its voids by the volume c_b F_b. Nothing is fitted.

use super::blocks::{Blocks, NO_BLOCK};

/// Lists of cells, one for each block.
#[derive(Clone, Debug, PartialEq)]
struct Lists {
    /// Place of each block's first cell, and the end of all.
    starts: Vec<u32>,
    cells: Vec<u32>,
}

impl Lists {
    /// Sorts pairs of a block and a cell by blocks.
    fn new(pairs: &[[u32; 2]], blocks: usize) -> Self {
        let mut starts = vec![0; blocks + 1];
        for &[block, _] in pairs {
            starts[block as usize + 1] += 1;
        }
        for block in 0..blocks {
            starts[block + 1] += starts[block];
        }
        let (mut next, mut cells) = (starts.clone(), vec![0; pairs.len()]);
        for &[block, cell] in pairs {
            cells[next[block as usize] as usize] = cell;
            next[block as usize] += 1;
        }
        Self { starts, cells }
    }

    fn of(&self, block: usize) -> &[u32] {
        &self.cells[self.starts[block] as usize..self.starts[block + 1] as usize]
    }
}

/// Blocks of a tread with the void cells that share a side with each.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Squeeze {
    /// Columns round the tyre.
    pub columns: usize,
    /// Cells across.
    pub across: usize,
    /// Block of each cell round the tyre.
    pub of_cell: Vec<u32>,
    /// Volume by force of each block, c_b \[m^3/N\].
    pub compliance: Vec<f64>,
    own: Lists,
    voids: Lists,
}

impl Squeeze {
    /// Finds the voids beside the blocks of a tread with so many cells across. What is beside a block and belongs to
    /// none is a void that is deep enough to divide blocks.
    pub(crate) fn new(blocks: &Blocks, across: usize) -> Self {
        let (of_cell, count) = (blocks.of_cell.clone(), blocks.cells.len());
        let columns = of_cell.len() / across;
        let (mut own, mut voids) = (Vec::new(), Vec::new());
        for (cell, &block) in of_cell.iter().enumerate() {
            if block != NO_BLOCK {
                own.push([block, cell as u32]);
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
                beside.into_iter().flatten().map(|next| of_cell[next]).filter(|block| *block != NO_BLOCK).collect();
            found.sort_unstable();
            found.dedup();
            voids.extend(found.into_iter().map(|block| [block, cell as u32]));
        }
        let (own, voids) = (Lists::new(&own, count), Lists::new(&voids, count));
        Self { columns, across, of_cell, compliance: blocks.compliance.clone(), own, voids }
    }

    /// Returns the cells of a block.
    pub(crate) fn own(&self, block: usize) -> &[u32] {
        self.own.of(block)
    }

    /// Returns the void cells beside a block; none of one between sipes alone.
    pub(crate) fn voids(&self, block: usize) -> &[u32] {
        self.voids.of(block)
    }

    /// Counts the blocks, and those that have no void beside them.
    pub(crate) fn counts(&self) -> [usize; 2] {
        let blocks = self.compliance.len();
        [blocks, (0..blocks).filter(|&block| self.voids(block).is_empty()).count()]
    }

    /// Returns the most columns that cells of a block and of its voids are away from each other.
    pub(crate) fn reach(&self) -> usize {
        (0..self.compliance.len()).map(|block| self.extent(block)).max().unwrap_or(0)
    }

    /// Returns the columns from the first to the last cell of a block and its voids, round the tyre the shorter way.
    fn extent(&self, block: usize) -> usize {
        let cells = self.own(block).iter().chain(self.voids(block));
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

    /// Returns six columns of four cells: a block that spans the seam, one amid, a groove beside both, and a rib.
    fn squeeze() -> Squeeze {
        let rows: [[u32; 4]; 6] = [
            [NO_BLOCK, 0, 0, 2],
            [NO_BLOCK, NO_BLOCK, 0, 2],
            [NO_BLOCK, 1, 1, 2],
            [NO_BLOCK, 1, 1, 2],
            [NO_BLOCK, NO_BLOCK, NO_BLOCK, 2],
            [NO_BLOCK, 0, 0, 2],
        ];
        let cells = vec![5, 4, 6];
        Squeeze::new(&Blocks { of_cell: rows.concat(), compliance: vec![1e-10, 2e-10, 3e-10], cells }, 4)
    }

    #[test]
    fn voids_beside_a_block_share_a_side_with_it_round_the_seam_too() {
        let squeeze = squeeze();
        assert_eq!(squeeze.own(0), [1, 2, 6, 21, 22]);
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
