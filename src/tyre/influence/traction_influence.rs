//! Influence between cells of all three components of traction on all three of displacement.
//!
//! Components are x forward, y to the left, z into the tyre. A force b on the cell (i', j') moves the cell (i, j) along
//! a by
//!
//! ```text
//! G_ab = T_ab[i - i'][j - j'] + H_ab[i - i'][j + j'] - delta_by D_a[i - i'][j] - delta_ay O_b[i - i'][j']
//! ```
//!
//! T is the free field, H the images of the tyre's sides. D and O are there with guided sides alone: they take the mean
//! across off the lateral waves, which a uniform motion stands for.

use serde::{Deserialize, Serialize};

/// Components of traction and of displacement.
pub(crate) const COMPONENTS: usize = 3;

/// Tables of one pair of components; empty tables are zero.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub(crate) struct PairTables {
    /// Free field T, rows of 2 `across` - 1 numbers for j - j' = 1 - across ..., by i - i' = 1 - columns ... \[m/N\].
    pub toeplitz: Vec<f64>,
    /// Images H, rows of 2 `across` - 1 numbers for j + j' = 0 ..., likewise \[m/N\].
    pub hankel: Vec<f64>,
}

/// Parts of lateral waves that a uniform lateral motion stands for; rows of `across` numbers \[m/N\].
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub(crate) struct UniformTables {
    /// D_a by i - i' and j, for each displacement a.
    pub driven: [Vec<f64>; COMPONENTS],
    /// O_b by i - i' and j', for each force b.
    pub observed: [Vec<f64>; COMPONENTS],
}

/// Influence between the cells of a window, for all components.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(crate) struct TractionInfluence {
    /// Cells along.
    pub columns: usize,
    /// Cells across.
    pub across: usize,
    /// Tables of displacement a by force b, at 3 a + b.
    pub pairs: Vec<PairTables>,
    /// Parts that a uniform lateral motion stands for.
    pub uniform: Option<Box<UniformTables>>,
}

impl TractionInfluence {
    /// Makes a table of zeros.
    pub(crate) fn zeros(columns: usize, across: usize) -> Self {
        let pairs = vec![PairTables::default(); COMPONENTS * COMPONENTS];
        Self { columns, across, pairs, uniform: None }
    }

    /// Returns the same between the cells of a window of fewer columns.
    pub(crate) fn narrowed(&self, columns: usize) -> Self {
        let cut = |table: &[f64], width: usize| -> Vec<f64> {
            let first = (self.columns - columns) * width;
            table.get(first..first + (2 * columns - 1) * width).unwrap_or(&[]).to_vec()
        };
        let (width, across) = (self.width(), self.across);
        let of_pair =
            |pair: &PairTables| PairTables { toeplitz: cut(&pair.toeplitz, width), hankel: cut(&pair.hankel, width) };
        let uniform = self.uniform.as_ref().map(|tables| {
            let UniformTables { driven, observed } = &**tables;
            let [driven, observed] = [driven, observed].map(|tables| tables.each_ref().map(|table| cut(table, across)));
            Box::new(UniformTables { driven, observed })
        });
        Self { columns, across, pairs: self.pairs.iter().map(of_pair).collect(), uniform }
    }

    /// Counts the numbers of a row of T or H.
    pub(crate) fn width(&self) -> usize {
        2 * self.across - 1
    }

    /// Counts the distances along.
    pub(crate) fn distances(&self) -> usize {
        2 * self.columns - 1
    }

    /// Counts the cells of the window.
    pub(crate) fn cells(&self) -> usize {
        self.columns * self.across
    }

    /// Returns the influence of the forces on cell `b` on the displacements of cell `a`.
    pub(crate) fn block(&self, a: usize, b: usize) -> [[f64; COMPONENTS]; COMPONENTS] {
        let across = self.across;
        let row = a / across + self.columns - 1 - b / across;
        let (ja, jb) = (a % across, b % across);
        let free = row * self.width() + ja + across - 1 - jb;
        let image = row * self.width() + ja + jb;
        let at = |table: &[f64], place: usize| table.get(place).copied().unwrap_or(0.0);
        let mut block = [[0.0; COMPONENTS]; COMPONENTS];
        for (entry, pair) in block.as_flattened_mut().iter_mut().zip(&self.pairs) {
            *entry = at(&pair.toeplitz, free) + at(&pair.hankel, image);
        }
        if let Some(uniform) = &self.uniform {
            for (row_of_block, driven) in block.iter_mut().zip(&uniform.driven) {
                row_of_block[1] -= at(driven, row * across + ja);
            }
            for (entry, observed) in block[1].iter_mut().zip(&uniform.observed) {
                *entry -= at(observed, row * across + jb);
            }
        }
        block
    }
}
