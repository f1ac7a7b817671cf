//! Rows of a long grid at the run's columns, read in pieces, of which the last few stay in memory.

use std::collections::VecDeque;
use std::sync::Arc;

use super::across::across;
use super::error::RoadError;
use super::lattice::Lattice;
use super::report::RoadReport;
use super::sources::grid_stream::GridStream;
use super::texture::ProfileSpectrum;
use crate::numeric::windowed_sinc::WindowedSinc;

/// Most columns of which profiles are taken: neighbouring ones hardly differ, and more add little.
pub(super) const PROFILES: usize = 16;
/// Pieces in memory: rows asked for together may lie in two.
const MOST_KEPT: usize = 2;

/// Columns of which profiles are taken, of so many.
pub(super) fn profile_columns(count: usize) -> impl Iterator<Item = usize> {
    (0..count).step_by(count.div_ceil(PROFILES))
}

/// A column of rows of so many heights.
pub(super) fn column_of(rows: &[f64], column: usize, columns: usize) -> Vec<f64> {
    rows.iter().skip(column).step_by(columns).copied().collect()
}

/// A long grid at the run's columns.
#[derive(Clone, Debug)]
pub(crate) struct PieceRows {
    grid: GridStream,
    lattice: Lattice,
    kernel: WindowedSinc,
    /// Pieces by number.
    kept: VecDeque<(usize, Vec<f64>)>,
    highest: f64,
    spectrum: Arc<ProfileSpectrum>,
}

impl PieceRows {
    /// Reads the whole grid once, for its highest point and its spectrum.
    ///
    /// # Errors
    /// Errors of the file, and heights that no texture has.
    pub(super) fn new(grid: GridStream, lattice: Lattice, report: &mut RoadReport) -> Result<Self, RoadError> {
        let mut spectrum = ProfileSpectrum::new(grid.rows_of_piece(), grid.spacing());
        let kernel = WindowedSinc::resampling();
        let (mut highest, mut low, mut high) = (0.0_f64, f64::MAX, f64::MIN);
        let [mut sum, mut squares] = [0.0; 2];
        for number in 0..grid.pieces() {
            let map = grid.piece(number)?;
            for height in &map.heights {
                (low, high) = (low.min(*height), high.max(*height));
                (sum, squares) = (sum + height, squares + height * height);
            }
            let rows = across(&map, &lattice, &kernel);
            highest = rows.iter().fold(highest, |highest, height| highest.max(*height));
            // A last, shorter piece is left out.
            profile_columns(lattice.columns)
                .for_each(|column| spectrum.add(&column_of(&rows, column, lattice.columns)));
        }
        let count = report.points.max(1) as f64;
        let rms = (squares / count - (sum / count).powi(2)).max(0.0).sqrt();
        grid.check(high - low, rms, report)?;
        Ok(Self { grid, lattice, kernel, kept: VecDeque::new(), highest, spectrum: Arc::new(spectrum) })
    }

    /// Number of rows.
    pub(super) fn count(&self) -> usize {
        self.grid.rows()
    }

    /// Highest height \[m\], at least 0.
    pub(super) fn highest(&self) -> f64 {
        self.highest
    }

    /// Spectrum of the profiles, averaged over the pieces.
    pub(super) fn spectrum(&self) -> &ProfileSpectrum {
        &self.spectrum
    }

    /// Rows by their numbers, one after the other.
    ///
    /// # Errors
    /// Errors of the file.
    pub(super) fn gather(&mut self, rows: &[usize]) -> Result<Vec<f64>, RoadError> {
        let (columns, piece) = (self.lattice.columns, self.grid.rows_of_piece());
        let mut gathered = Vec::with_capacity(rows.len() * columns);
        for &row in rows {
            let (number, within) = (row / piece, row % piece * columns);
            let heights = match self.kept.iter().position(|(kept, _)| *kept == number) {
                Some(place) => &self.kept[place].1,
                None => {
                    let heights = across(&self.grid.piece(number)?, &self.lattice, &self.kernel);
                    if self.kept.len() == MOST_KEPT {
                        self.kept.pop_front();
                    }
                    self.kept.push_back((number, heights));
                    &self.kept[self.kept.len() - 1].1
                }
            };
            gathered.extend_from_slice(&heights[within..within + columns]);
        }
        Ok(gathered)
    }
}
