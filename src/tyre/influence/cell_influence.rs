//! Tables of the influence between cells, and how sums over the waves along make them.

use std::ops::{AddAssign, MulAssign, SubAssign};

use serde::{Deserialize, Serialize};

use super::cell_grid::CellGrid;
use super::cell_waves::CellRow;
use crate::numeric::Ring;
use crate::scene::Sides;

/// Displacement of cell (i, j) per unit force on cell (i', j'):
/// `toeplitz[|i - i'|][|j - j'|] + hankel[|i - i'|][j + j']`.
///
/// With rotation, the same of `odd` is added, with its sign changed where i < i'.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct CellInfluence {
    /// Distances along in the table: 0..`columns` cells.
    pub columns: usize,
    /// Cells across the strip.
    pub across: usize,
    /// Free field, by j - j': rows of `across` numbers, one row per distance along \[m/N\].
    pub toeplitz: Vec<f64>,
    /// Images in the sides, by j + j': rows of 2 `across` - 1 numbers \[m/N\].
    pub hankel: Vec<f64>,
    /// Part that is odd along; `None` at rest.
    pub odd: Option<OddInfluence>,
}

/// Part of an influence between cells that is odd along: zeros at distance 0.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct OddInfluence {
    /// Free field, in rows as those of the even part \[m/N\].
    pub toeplitz: Vec<f64>,
    /// Images, in rows as those of the even part \[m/N\].
    pub hankel: Vec<f64>,
}

/// Values of waves at a real s \[m/N\], in the order of the rows and of their waves.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveValues {
    /// Even parts.
    pub even: Vec<f64>,
    /// Odd parts; empty at rest.
    pub odd: Vec<f64>,
}

impl CellInfluence {
    /// Sums the influence between cells from some waves alone, up to `columns` along. `waves`: for each ring, its
    /// number of cells, its rows, and the values of their waves in the same order.
    pub fn of_waves<'a>(
        grid: &CellGrid,
        columns: usize,
        waves: impl IntoIterator<Item = (usize, &'a [CellRow], &'a WaveValues)>,
    ) -> Self {
        let mut rows = Rows::default();
        for (cells, of_ring, WaveValues { even, odd }) in waves {
            let (mut ring, mut start) = (Ring::new(cells), 0);
            for CellRow { m, folded, first, waves } in of_ring {
                // Folded rows already hold the cells' weight: each stands for several lateral numbers.
                let cell_weight = grid.lateral_weight(*m) / grid.waves().lateral_norm(*m);
                let weight = if *folded { 1.0 } else { cell_weight };
                let range = start..start + waves.len();
                let value = |values: &[f64], n: usize| {
                    let place = n.checked_sub(*first).filter(|place| *place < waves.len());
                    place.map_or(0.0, |place| weight * values[range.start + place])
                };
                rows.numbers.push(*m);
                rows.even.push(ring.elements_of(|n| value(even, n))[..columns].to_vec());
                if !odd.is_empty() {
                    rows.odd.push(ring.odd_elements_of(|n| value(odd, n))[..columns].to_vec());
                }
                start = range.end;
            }
        }
        rows.together(grid, columns)
    }

    /// Combines every value with that of another influence.
    fn change(&mut self, other: &Self, change: impl Fn(&mut f64, f64)) {
        let all = |values: &mut [f64], other: &[f64]| {
            values.iter_mut().zip(other).for_each(|(value, other)| change(value, *other))
        };
        all(&mut self.toeplitz, &other.toeplitz);
        all(&mut self.hankel, &other.hankel);
        if let (Some(odd), Some(other)) = (&mut self.odd, &other.odd) {
            all(&mut odd.toeplitz, &other.toeplitz);
            all(&mut odd.hankel, &other.hankel);
        }
    }
}

impl AddAssign<&Self> for CellInfluence {
    fn add_assign(&mut self, other: &Self) {
        let zeros = |odd: &OddInfluence| OddInfluence {
            toeplitz: vec![0.0; odd.toeplitz.len()],
            hankel: vec![0.0; odd.hankel.len()],
        };
        self.odd = self.odd.take().or_else(|| other.odd.as_ref().map(zeros));
        self.change(other, |value, other| *value += other);
    }
}

impl MulAssign<f64> for CellInfluence {
    fn mul_assign(&mut self, factor: f64) {
        let odd = self.odd.iter_mut().flat_map(|odd| [&mut odd.toeplitz, &mut odd.hankel]);
        let tables = [&mut self.toeplitz, &mut self.hankel].into_iter().chain(odd);
        tables.flatten().for_each(|value| *value *= factor);
    }
}

impl SubAssign<&Self> for CellInfluence {
    fn sub_assign(&mut self, other: &Self) {
        self.change(other, |value, other| *value -= other);
    }
}

/// Influence of a force at each distance along, by lateral number.
#[derive(Default)]
pub(super) struct Rows {
    /// Lateral numbers m.
    pub(super) numbers: Vec<usize>,
    /// Part that is even along.
    pub(super) even: Vec<Vec<f64>>,
    /// Part that is odd along; empty at rest.
    pub(super) odd: Vec<Vec<f64>>,
}

impl Rows {
    /// The influence between cells across: the sum over m of the rows times cosines of the distance of the cells (free
    /// field) and of their images.
    pub(super) fn together(&self, grid: &CellGrid, columns: usize) -> CellInfluence {
        let (waves, across) = (grid.waves(), grid.across);
        let sign = if waves.sides == Sides::Guided { 1.0 } else { -1.0 };
        let cosines = |distance: f64| -> Vec<f64> {
            self.numbers.iter().map(|&m| 0.5 * (waves.ky(m) * distance).cos()).collect()
        };
        let free: Vec<Vec<f64>> = (0..across).map(|j| cosines(j as f64 * grid.pitch())).collect();
        let images: Vec<Vec<f64>> = (0..2 * across - 1)
            .map(|j| cosines(waves.width + grid.from_middle(0) * 2.0 + j as f64 * grid.pitch()))
            .collect();
        let both = |rows: &[Vec<f64>]| {
            let sum = |along: usize, cosines: &[f64]| {
                rows.iter().zip(cosines).map(|(row, cosine)| row[along] * cosine).sum::<f64>()
            };
            let (mut toeplitz, mut hankel) = (Vec::new(), Vec::with_capacity(columns * images.len()));
            for along in 0..columns {
                toeplitz.extend(free.iter().map(|cosines| sum(along, cosines)));
                hankel.extend(images.iter().map(|cosines| sign * sum(along, cosines)));
            }
            (toeplitz, hankel)
        };
        let (toeplitz, hankel) = both(&self.even);
        let odd = (!self.odd.is_empty()).then(|| both(&self.odd));
        let odd = odd.map(|(toeplitz, hankel)| OddInfluence { toeplitz, hankel });
        CellInfluence { columns, across, toeplitz, hankel, odd }
    }
}
