//! Influence between cells of all three components of traction on all three of displacement.
//!
//! Components are x forward, y to the left, z into the tyre. A force b on the cell (i', j') moves the cell (i, j) along
//! a by
//!
//! ```text
//! G_ab = T_ab[i - i'][j - j'] + H_ab[i - i'][j + j'] - delta_by D_a[i - i'][j] - delta_ay O_b[i - i'][j']
//! ```
//!
//! T is the free field, H the images of the tyre's sides. D and O exist with guided sides alone: they remove from the
//! lateral waves the mean across, in whose place a uniform motion stands.

use serde::{Deserialize, Serialize};

/// Number of components of traction and of displacement.
pub const COMPONENTS: usize = 3;

/// Tables of one pair of components; an empty table is zero.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub(crate) struct PairTables {
    /// Free field T \[m/N\]: a row of 2 `across` - 1 numbers for j - j' = 1 - across ... per distance i - i' = 1 -
    /// columns ...
    pub toeplitz: Vec<f64>,
    /// Images H \[m/N\]: a row of 2 `across` - 1 numbers for j + j' = 0 ... per distance i - i' = 1 - columns ...
    pub hankel: Vec<f64>,
}

/// Parts of lateral waves for which a uniform lateral motion stands; rows of `across` numbers \[m/N\].
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub(crate) struct UniformTables {
    /// D_a by i - i' and j, one table per displacement a.
    pub driven: [Vec<f64>; COMPONENTS],
    /// O_b by i - i' and j', one table per force b.
    pub observed: [Vec<f64>; COMPONENTS],
}

/// Influence between the cells of a window, for all components.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(crate) struct TractionInfluence {
    /// Cells along the window.
    pub columns: usize,
    /// Cells across the window.
    pub across: usize,
    /// Tables of displacement a by force b, at 3 a + b.
    pub pairs: Vec<PairTables>,
    /// D and O; `None` with supported sides.
    pub uniform: Option<Box<UniformTables>>,
}

impl TractionInfluence {
    /// All tables empty: an influence of zero.
    pub(crate) fn zeros(columns: usize, across: usize) -> Self {
        let pairs = vec![PairTables::default(); COMPONENTS * COMPONENTS];
        Self { columns, across, pairs, uniform: None }
    }

    /// The influence between the cells of a window of fewer columns.
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

    /// Numbers in a row of T or H.
    pub(crate) fn width(&self) -> usize {
        2 * self.across - 1
    }

    /// Number of distances along, of both signs.
    pub(crate) fn distances(&self) -> usize {
        2 * self.columns - 1
    }

    /// Number of cells of the window.
    pub(crate) fn cells(&self) -> usize {
        self.columns * self.across
    }

    /// Displacements of cell `a` by forces on cell `b` \[m/N\], row a, column b of the module's G_ab.
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
