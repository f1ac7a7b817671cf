//! Tables of the influence between cells: what they hold, and how sums over the waves along make them.

use std::ops::{AddAssign, SubAssign};

use serde::{Deserialize, Serialize};

use super::cell_grid::CellGrid;
use super::cell_waves::CellRow;
use crate::numeric::Ring;
use crate::scene::Sides;

/// Influence between cells: of (i', j') on (i, j) `toeplitz[|i - i'|][|j - j'|] + hankel[|i - i'|][j + j']`.
///
/// With rotation, the same of `odd` is added, with its sign changed where i < i'.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct CellInfluence {
    /// Cells along that are told.
    pub columns: usize,
    /// Cells across.
    pub across: usize,
    /// Rows of `across` numbers \[m/N\].
    pub toeplitz: Vec<f64>,
    /// Rows of 2 `across` - 1 numbers \[m/N\].
    pub hankel: Vec<f64>,
    /// The part that is odd along; `None` at rest.
    pub odd: Option<OddInfluence>,
}

/// The part of an influence between cells that is odd along: zeros at distance 0.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct OddInfluence {
    /// Rows as those of the even part \[m/N\].
    pub toeplitz: Vec<f64>,
    /// Likewise \[m/N\].
    pub hankel: Vec<f64>,
}

/// Values of waves at a real s \[m/N\].
#[derive(Clone, Debug, PartialEq)]
pub struct WaveValues {
    /// Even parts.
    pub even: Vec<f64>,
    /// Odd parts; empty at rest.
    pub odd: Vec<f64>,
}

impl CellInfluence {
    /// Sums the influence between cells by some waves alone, up to `columns` along, on rings that are the tyre's length
    /// over a number: that number, the rows, and values of their waves in the same order.
    pub fn of_waves<'a>(
        grid: &CellGrid,
        columns: usize,
        waves: impl IntoIterator<Item = (usize, &'a [CellRow], &'a WaveValues)>,
    ) -> Self {
        let mut rows = Rows::default();
        for (part, of_ring, WaveValues { even, odd }) in waves {
            let (mut ring, mut start) = (Ring::new(grid.elements() / part), 0);
            for CellRow { m, folded, first, waves } in of_ring {
                // Weights of numbers that are taken together hold what cells take of them.
                let own_weight = grid.lateral_weight(*m) / grid.waves().lateral_norm(*m);
                let weight = if *folded { 1.0 } else { own_weight };
                let own = start..start + waves.len();
                let value = |values: &[f64], n: usize| {
                    let place = n.checked_sub(*first).filter(|place| *place < waves.len());
                    place.map_or(0.0, |place| weight * values[own.start + place])
                };
                rows.numbers.push(*m);
                rows.even.push(ring.elements_of(|n| value(even, n))[..columns].to_vec());
                if !odd.is_empty() {
                    rows.odd.push(ring.odd_elements_of(|n| value(odd, n))[..columns].to_vec());
                }
                start = own.end;
            }
        }
        rows.together(grid, columns)
    }

    /// Changes all values by those of another.
    fn change(&mut self, other: &Self, change: impl Fn(&mut f64, f64)) {
        let all =
            |own: &mut [f64], other: &[f64]| own.iter_mut().zip(other).for_each(|(own, other)| change(own, *other));
        all(&mut self.toeplitz, &other.toeplitz);
        all(&mut self.hankel, &other.hankel);
        if let (Some(own), Some(other)) = (&mut self.odd, &other.odd) {
            all(&mut own.toeplitz, &other.toeplitz);
            all(&mut own.hankel, &other.hankel);
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
        self.change(other, |own, other| *own += other);
    }
}

impl SubAssign<&Self> for CellInfluence {
    fn sub_assign(&mut self, other: &Self) {
        self.change(other, |own, other| *own -= other);
    }
}

/// The influence of a force at each distance along, lateral number by lateral number.
#[derive(Default)]
pub(super) struct Rows {
    /// m.
    pub(super) numbers: Vec<usize>,
    /// Part that is even along.
    pub(super) even: Vec<Vec<f64>>,
    /// Part that is odd along; empty at rest.
    pub(super) odd: Vec<Vec<f64>>,
}

impl Rows {
    /// Sums them between cells across.
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
