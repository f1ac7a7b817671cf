//! Bringing a measured height map to the run's lattice, and continuing it past its end.
//!
//! 1. Across: each row of the map is resampled to the run's columns, once.
//! 2. Along: each of the run's rows of cells is a weighted sum of rows of the map, those past the end as `at_end` says
//!    (reflected, if the road must not be left).
//!
//! An axis on which the map already has the run's spacing and phase is copied, bit for bit. On any other, the kernel
//! is the windowed sinc of [`crate::numeric::windowed_sinc`], low-pass at the Nyquist wavenumber of the coarser of both
//! spacings.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use super::across::across;
use super::error::RoadError;
use super::lattice::{Lattice, same};
use super::piece_rows::{PieceRows, column_of, profile_columns};
use super::sources::height_map::{RoadHeightMap, reflected};
use super::texture::ProfileSpectrum;
use crate::numeric::windowed_sinc::WindowedSinc;
use crate::scene::AtEnd;

/// Rows x `stored` heights, at the map's rows and the run's columns.
#[derive(Clone, Debug)]
enum Rows {
    Stored(Arc<Vec<f64>>),
    Pieces(Box<PieceRows>),
}

impl Rows {
    /// Some rows of the continued map, in memory.
    fn view(&mut self, rows: Range<i64>, stored: usize, continued: Continuation) -> Result<View<'_>, RoadError> {
        Ok(match self {
            Self::Stored(heights) => {
                View { first: 0, heights: Cow::Borrowed(heights), stored, continued: Some(continued) }
            }
            Self::Pieces(pieces) => {
                let (first, inside) = (rows.start, rows.map(|row| continued.inside(row)));
                let heights = Cow::Owned(pieces.gather(&inside.collect::<Vec<_>>())?);
                View { first, heights, stored, continued: None }
            }
        })
    }
}

/// How a map of so many rows continues past its ends.
#[derive(Clone, Copy, Debug)]
struct Continuation {
    at_end: AtEnd,
    count: i64,
}

impl Continuation {
    /// Number within the map of a row of the continued map.
    fn inside(self, index: i64) -> usize {
        match self.at_end {
            AtEnd::Repeat => index.rem_euclid(self.count) as usize,
            AtEnd::Refuse | AtEnd::Mirror => reflected(index, self.count),
        }
    }
}

/// Rows of the continued map that are in memory.
struct View<'a> {
    /// Number of the first row in memory.
    first: i64,
    /// Rows x `stored`.
    heights: Cow<'a, [f64]>,
    stored: usize,
    /// Rows in memory for those asked for, where the map is there as a whole.
    continued: Option<Continuation>,
}

impl View<'_> {
    fn row(&self, index: i64) -> &[f64] {
        let inside = self.continued.map_or((index - self.first) as usize, |continued| continued.inside(index));
        &self.heights[inside * self.stored..(inside + 1) * self.stored]
    }

    /// Heights of successive rows of a road that is level across, as far as they lie side by side.
    fn line(&self, start: i64, count: usize) -> Option<&[f64]> {
        usize::try_from(start - self.first).ok().and_then(|from| self.heights.get(from..from + count))
    }
}

/// A measured road on the run's lattice.
#[derive(Clone, Debug)]
pub struct Resampled {
    lattice: Lattice,
    at_end: AtEnd,
    dx: f64,
    rows: Rows,
    /// Columns stored per row: 1 where the road is level across.
    stored: usize,
    kernel: WindowedSinc,
    /// First of the run's rows that is row 0 of the map, if all of them are rows of it.
    aligned: Option<i64>,
    /// Spectrum of the profiles along, computed when it is first needed.
    spectrum: OnceLock<ProfileSpectrum>,
}

impl Resampled {
    /// Resamples across; rows are resampled along on demand.
    pub fn new(map: RoadHeightMap, lattice: Lattice, at_end: AtEnd) -> Self {
        let kernel = WindowedSinc::resampling();
        let (aligned, dx) = (aligned(map.dx, &lattice), map.dx);
        let level_across = map.dy == 0.0;
        let stored = if level_across { 1 } else { lattice.columns };
        let rows = if level_across { map.heights } else { across(&map, &lattice, &kernel) };
        let rows = Rows::Stored(Arc::new(rows));
        Self { lattice, at_end, dx, rows, stored, kernel, aligned, spectrum: OnceLock::new() }
    }

    /// A grid that is read in pieces, each resampled across when it is read.
    pub(super) fn in_pieces(pieces: PieceRows, dx: f64, lattice: Lattice, at_end: AtEnd) -> Self {
        let (kernel, rows) = (WindowedSinc::resampling(), Rows::Pieces(Box::new(pieces)));
        let aligned = aligned(dx, &lattice);
        Self { lattice, at_end, dx, rows, stored: lattice.columns, kernel, aligned, spectrum: OnceLock::new() }
    }

    /// Number of rows of the map.
    pub(super) fn count(&self) -> i64 {
        match &self.rows {
            Rows::Stored(rows) => (rows.len() / self.stored) as i64,
            Rows::Pieces(pieces) => pieces.count() as i64,
        }
    }

    /// Available road coordinates \[m\]; `None` for a road that never ends.
    pub fn extent(&self) -> Option<(f64, f64)> {
        (self.at_end == AtEnd::Refuse).then(|| (0.0, (self.count() - 1) as f64 * self.dx))
    }

    /// Highest stored height \[m\], at least 0.
    pub fn highest(&self) -> f64 {
        match &self.rows {
            Rows::Stored(rows) => rows.iter().fold(0.0, |highest, &height| highest.max(height)),
            Rows::Pieces(pieces) => pieces.highest(),
        }
    }

    /// True if the road is level across.
    pub fn is_level_across(&self) -> bool {
        self.stored == 1
    }

    /// Spectrum of the profiles along, at the map's spacing, averaged over up to 16 columns spread evenly across, and
    /// over the pieces of a grid that is read in pieces.
    pub fn spectrum(&self) -> &ProfileSpectrum {
        match &self.rows {
            Rows::Stored(rows) => self.spectrum.get_or_init(|| self.find_spectrum(rows)),
            Rows::Pieces(pieces) => pieces.spectrum(),
        }
    }

    fn find_spectrum(&self, rows: &[f64]) -> ProfileSpectrum {
        let mut spectrum = ProfileSpectrum::new(self.count() as usize, self.dx);
        profile_columns(self.stored).for_each(|column| spectrum.add(&column_of(rows, column, self.stored)));
        spectrum
    }

    /// Profiles along, at the map's spacing, over some rows of the continued map: in up to 16 columns spread evenly
    /// across.
    ///
    /// # Errors
    /// Errors of a grid that is read in pieces.
    pub(super) fn profiles(&mut self, rows: Range<i64>) -> Result<Vec<Vec<f64>>, RoadError> {
        let (stored, continued) = (self.stored, self.continuation());
        let view = self.rows.view(rows.clone(), stored, continued)?;
        let profile = |column| rows.clone().map(|row| view.row(row)[column]).collect();
        Ok(profile_columns(stored).map(profile).collect())
    }

    fn continuation(&self) -> Continuation {
        Continuation { at_end: self.at_end, count: self.count() }
    }

    /// Spacing of the map's rows \[m\].
    pub(super) fn spacing(&self) -> f64 {
        self.dx
    }

    /// Number of elements after which the road repeats; `None` if it ends or its rows are not on the run's lattice.
    pub fn period(&self) -> Option<i64> {
        self.aligned?;
        let rows = match self.at_end {
            AtEnd::Repeat => self.count(),
            AtEnd::Mirror => (2 * (self.count() - 1)).max(1),
            AtEnd::Refuse => return None,
        };
        Some(rows / greatest_common_divisor(rows, self.lattice.along as i64))
    }

    /// First and last element on the road; `None` for a road that never ends.
    pub fn elements(&self) -> Option<(i64, i64)> {
        let (_, end) = self.extent()?;
        // Rounding must not lose the last row of a map at the run's spacing.
        Some((0, (end / self.lattice.dx * (1.0 + 1e-12) + 1e-9).floor() as i64))
    }

    /// Heights of the run's rows from `first` on, row-major; `out` must hold whole rows.
    ///
    /// # Errors
    /// Errors of a grid that is read in pieces.
    pub fn heights(&mut self, first: i64, out: &mut [f64]) -> Result<(), RoadError> {
        let continued = self.continuation();
        let Self { lattice, dx, rows: of_map, stored, kernel, aligned, .. } = self;
        let (columns, along) = (lattice.columns, Along { lattice: *lattice, dx: *dx, kernel });
        let last = first + (out.len() / columns) as i64 - 1;
        let rows = match *aligned {
            Some(zero) => first - zero..last - zero + 1,
            None => along.taps(first).start..along.taps(last).end,
        };
        let view = of_map.view(rows, *stored, continued)?;
        out.par_chunks_mut(columns).enumerate().with_min_len(16).for_each_init(Vec::new, |weights, (index, row)| {
            let number = first + index as i64;
            match *aligned {
                Some(zero) => spread(view.row(number - zero), row),
                None => along.interpolate(&view, number, weights, row),
            }
        });
        Ok(())
    }
}

/// Interpolation along.
struct Along<'a> {
    lattice: Lattice,
    dx: f64,
    kernel: &'a WindowedSinc,
}

impl Along<'_> {
    /// Writes the weights of the rows of the map for one of the run's rows; returns the first of them.
    fn weights(&self, number: i64, weights: &mut Vec<f64>) -> i64 {
        let ratio = (self.lattice.cell() / self.dx).max(1.0);
        self.kernel.weights(self.lattice.place(number, self.dx), ratio, weights)
    }

    /// Rows of the map for one of the run's rows.
    fn taps(&self, number: i64) -> Range<i64> {
        let mut weights = Vec::new();
        let start = self.weights(number, &mut weights);
        start..start + weights.len() as i64
    }

    fn interpolate(&self, view: &View<'_>, number: i64, weights: &mut Vec<f64>, out: &mut [f64]) {
        let start = self.weights(number, weights);
        if view.row(start).len() == 1 {
            let sum: f64 = match view.line(start, weights.len()) {
                Some(heights) => weights.iter().zip(heights).map(|(weight, height)| weight * height).sum(),
                None => weights.iter().enumerate().map(|(tap, weight)| weight * view.row(start + tap as i64)[0]).sum(),
            };
            out.fill(sum);
            return;
        }
        out.fill(0.0);
        for (tap, weight) in weights.iter().enumerate() {
            for (height, source) in out.iter_mut().zip(view.row(start + tap as i64)) {
                *height += weight * source;
            }
        }
    }
}

/// Copies a row, or the only height of one that is level across.
fn spread(source: &[f64], out: &mut [f64]) {
    if source.len() == 1 { out.fill(source[0]) } else { out.copy_from_slice(source) }
}

/// First of the run's rows that is row 0 of a map of a spacing, if all of them are rows of it.
fn aligned(dx: f64, lattice: &Lattice) -> Option<i64> {
    // With an even number of cells along an element none is at its middle.
    (same(dx, lattice.cell()) && lattice.along % 2 == 1).then_some((lattice.along / 2) as i64)
}

fn greatest_common_divisor(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;
    use std::path::PathBuf;

    use super::*;

    fn map(dx: f64, dy: f64, rows: usize, columns: usize, height: impl Fn(f64, f64) -> f64) -> RoadHeightMap {
        let first_y = -0.5 * (columns as f64 - 1.0) * dy;
        let heights =
            (0..rows * columns).map(|i| height((i / columns) as f64 * dx, first_y + (i % columns) as f64 * dy));
        RoadHeightMap {
            path: PathBuf::new(),
            dx,
            dy,
            first_y,
            columns,
            heights: heights.collect(),
            origins: Vec::new(),
        }
    }

    fn all(road: &Resampled, first: i64, rows: usize) -> Vec<f64> {
        let mut out = vec![f64::NAN; rows * road.lattice.columns];
        road.clone().heights(first, &mut out).unwrap();
        out
    }

    #[test]
    fn map_at_the_lattice_is_copied_bit_for_bit() {
        let source = map(0.0037, 0.002, 50, 7, |x, y| (1e3 * x).sin() * (y * 777.0).cos());
        let lattice = Lattice { dx: 0.0037, along: 1, dy: 0.002, columns: 7 };
        let road = Resampled::new(source.clone(), lattice, AtEnd::Refuse);
        assert_eq!(all(&road, 0, 50), source.heights);
        assert_eq!(road.elements(), Some((0, 49)));
        let narrower = Resampled::new(source.clone(), Lattice { columns: 5, ..lattice }, AtEnd::Refuse);
        assert_eq!(all(&narrower, 3, 1), source.heights[3 * 7 + 1..3 * 7 + 6]);
    }

    #[test]
    fn wave_below_nyquist_passes_along_and_across() {
        let wave = |x: f64, y: f64| (2.0 * PI * x / 0.03).sin() * (2.0 * PI * y / 0.025).cos();
        let source = map(0.001, 0.001, 2000, 201, wave);
        let lattice = Lattice { dx: 0.0041, along: 1, dy: 0.0025, columns: 20 };
        let road = Resampled::new(source, lattice, AtEnd::Refuse);
        let heights = all(&road, 100, 200);
        for (i, height) in heights.iter().enumerate() {
            let expected = wave((100 + i / 20) as f64 * 0.0041, lattice.y(i % 20));
            assert!((height - expected).abs() < 1e-3, "{height} for {expected}");
        }
    }

    #[test]
    fn wave_above_nyquist_does_not_alias() {
        // 0.7 of the coarse spacing's Nyquist wavelength: would fold to a long wave.
        let source = map(0.0005, 0.0, 8000, 1, |x, _| (2.0 * PI * x / 0.006).sin());
        let road = Resampled::new(source, Lattice { dx: 0.004, along: 1, dy: 0.2, columns: 1 }, AtEnd::Refuse);
        let worst = all(&road, 150, 600).iter().fold(0.0_f64, |worst, height| worst.max(height.abs()));
        assert!(worst < 2e-4, "{worst}");
    }

    #[test]
    fn finer_run_interpolates_the_same_wave() {
        let wave = |x: f64| (2.0 * PI * x / 0.05).sin();
        let source = map(0.01, 0.0, 400, 1, |x, _| wave(x));
        let road = Resampled::new(source, Lattice { dx: 0.0013, along: 1, dy: 0.2, columns: 1 }, AtEnd::Refuse);
        for (i, height) in all(&road, 700, 700).iter().enumerate() {
            assert!((height - wave((700 + i) as f64 * 0.0013)).abs() < 1e-3);
        }
    }

    #[test]
    fn repeated_road_has_its_period_and_mirrored_road_is_even() {
        let source = map(0.01, 0.0, 300, 1, |x, _| (17.0 * x).sin() + 0.3 * (40.0 * x).cos());
        let lattice = Lattice { dx: 0.004, along: 1, dy: 0.2, columns: 1 };
        let repeat = Resampled::new(source.clone(), lattice, AtEnd::Repeat);
        assert!(repeat.extent().is_none());
        for (a, b) in all(&repeat, -20, 100).iter().zip(&all(&repeat, -20 + 750, 100)) {
            assert!((a - b).abs() < 1e-9, "3 m later the same");
        }
        let mirror = Resampled::new(source, lattice, AtEnd::Mirror);
        let (left, right) = (all(&mirror, -50, 51), all(&mirror, 0, 51));
        for (a, b) in left.iter().rev().zip(&right) {
            assert!((a - b).abs() < 1e-12);
        }
    }
}
