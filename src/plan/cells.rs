//! Numbers of contact over cells.

use std::f64::consts::{PI, TAU};

use super::Plan;
use crate::numeric::transform_multiply_adds;
use crate::tyre::influence::{CellGrid, CellTruncation, WaveBand};
use crate::tyre::poles::cells::CellFitOptions;

/// Wavenumbers times the tread's thickness between which waves are handed from the tyre's ring to a shorter one.
const HANDED_OVER: [f64; 2] = [6.0, 12.0];
/// How far the shorter ring reaches beyond the window, at least, in the longest waves on it over 2 pi: what has gone
/// round it has decayed by then.
const DECAYED: f64 = 40.0;

/// Residuals of the search for cells are no smaller than this part of the largest required displacement: its steps are
/// taken in single precision, and each round that brings the exact residual down costs as much as the first.
const LEAST_TOLERANCE: f64 = 3e-10;
/// Poles of a wave, conjugates counted, at a tolerance of 1e-5, and how many less for each factor of ten above it
/// (measured, N = 256 to 1024).
const POLES: [f64; 2] = [32.0, 5.0];
/// Bytes of a pole, conjugates counted: its model, its coefficients and its states.
const POLE_BYTES: f64 = 90.0;
/// Products in single precision that the search for an instant takes, with what goes with them (measured).
const PRODUCTS: f64 = 16.0;

/// What contact over cells is expected to take.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ExpectedCells {
    /// Cells of the window.
    pub cells: f64,
    /// Waves of all rings.
    pub waves: f64,
    /// Their poles, conjugates counted.
    pub poles: f64,
    /// Multiply-adds for each instant of the transforms between cells and waves.
    pub transforms: f64,
    /// Multiply-adds for each instant of the search.
    pub search: f64,
    /// Poles, states, weights, and fields of the window \[bytes\].
    pub bytes: f64,
}

impl Plan {
    /// Height of the tread above its middle, at a distance from there \[m\].
    pub fn crown(&self, from_middle: f64) -> f64 {
        self.scene.tyre.crown_radius.map_or(0.0, |radius| from_middle * from_middle / (2.0 * radius))
    }

    /// The bands of waves that carry the past of cells, seen through a window of so many columns. Finite sums are kept
    /// whole.
    pub fn wave_bands(&self, columns: usize) -> Vec<WaveBand> {
        let numerics = &self.scene.numerics;
        let finite = numerics.lateral_terms.is_some() || numerics.wavenumber_aliases.is_some();
        let Some(tread) = self.scene.tyre.layers.last().filter(|_| !finite) else { return vec![WaveBand::WHOLE] };
        let border = HANDED_OVER.map(|kh| kh / tread.thickness);
        let least = columns + (DECAYED / border[0] / self.element).ceil() as usize;
        let whole_rings = (1..=numerics.elements / least).filter(|part| numerics.elements.is_multiple_of(2 * part));
        match whole_rings.max() {
            Some(part) if part > 1 => vec![
                WaveBand { part: 1, fades_in: None, fades_out: Some(border) },
                WaveBand { part, fades_in: Some(border), fades_out: None },
            ],
            _ => vec![WaveBand::WHOLE],
        }
    }

    /// The cells round the tyre and across its strip.
    pub fn cell_grid(&self) -> CellGrid {
        let across = self.decisions.cells_across.unwrap_or(1);
        CellGrid::new(&self.decisions.tyre, self.scene.numerics.elements, across)
    }

    /// How far their sums go.
    pub fn cell_truncation(&self) -> CellTruncation {
        let numerics = &self.scene.numerics;
        CellTruncation { lateral_terms: numerics.lateral_terms, aliases: numerics.wavenumber_aliases }
    }

    /// How far a cell may be from where it is required to be, relative to the largest required displacement.
    pub fn cell_tolerance(&self) -> f64 {
        self.scene.numerics.contact_tolerance.max(LEAST_TOLERANCE)
    }

    /// What a window of so many columns is expected to take.
    pub(super) fn expected_cells(&self, columns: f64) -> ExpectedCells {
        let (grid, instants) = (self.cell_grid(), self.scene.numerics.time_rule.stages() as f64);
        let cells = columns * grid.across as f64;
        let of_wave = POLES[0] - POLES[1] * (self.fit.tolerance / 1e-5).log10();
        let mut expected = ExpectedCells { cells, ..ExpectedCells::default() };
        // Without listing them: there may be more than a machine can hold.
        let waves = grid.waves();
        let highest = TAU / grid.length().min(grid.pitch());
        for band in self.wave_bands(columns as usize) {
            let ring = grid.elements() / band.part;
            let around = (ring / 2 + 1) as f64;
            let (rows, count) = match (band.fades_out, self.cell_truncation().lateral_terms) {
                // A quarter of a disc.
                (Some([_, end]), _) => {
                    let rows = end / waves.ky(1);
                    (rows, 0.25 * PI * rows * around.min(end / waves.kx(1)))
                }
                (None, Some(terms)) => (terms as f64, terms as f64 * around),
                (None, None) => (highest / waves.ky(1), highest / waves.ky(1) * around),
            };
            expected.waves += count;
            // There and back: a transform along for each lateral number, a product across by halves.
            expected.transforms += rows * (transform_multiply_adds(ring) + cells);
        }
        expected.poles = of_wave * expected.waves;
        expected.search = PRODUCTS * transform_multiply_adds(4 * cells as usize);
        // Forces and displacements of a block of four steps, and the first weights of its instants.
        let block = expected.waves * 4.0 * instants * (32.0 + 8.0 * instants);
        expected.bytes = POLE_BYTES * expected.poles + block + 8.0 * cells * 40.0;
        expected
    }

    /// What the fits of the waves have to be.
    pub fn cell_fit(&self) -> CellFitOptions {
        CellFitOptions { top: self.fit.top, tolerance: self.fit.tolerance, most_poles: self.fit.most_poles }
    }
}
