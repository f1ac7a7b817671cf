//! Bringing a measured height map to the run's lattice, and continuing it past its end.
//!
//! 1. Across: each row of the map is resampled to the run's columns, once.
//! 2. Along: each of the run's rows of cells is a weighted sum of rows of the map, those past the end as `at_end` says
//!    (reflected, if the road must not be left).
//!
//! An axis on which the map already has the run's spacing and phase is copied, bit for bit. On any other, the kernel
//! is the windowed sinc of [`crate::numeric::windowed_sinc`], low-pass at the Nyquist wavenumber of the coarser of both
//! spacings.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use super::lattice::{Lattice, same};
use super::sources::height_map::{RoadHeightMap, reflected};
use super::texture::ProfileSpectrum;
use crate::numeric::windowed_sinc::WindowedSinc;
use crate::scene::AtEnd;

/// Most columns of which profiles are taken: neighbouring ones hardly differ, and more add little.
pub(super) const PROFILES: usize = 16;

/// A measured road on the run's lattice.
#[derive(Clone, Debug)]
pub struct Resampled {
    lattice: Lattice,
    at_end: AtEnd,
    dx: f64,
    /// Rows x `stored` heights, at the map's rows and the run's columns.
    rows: Arc<Vec<f64>>,
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
        // With an even number of cells along an element none is at its middle.
        let aligned = (same(map.dx, lattice.cell()) && lattice.along % 2 == 1).then_some((lattice.along / 2) as i64);
        let dx = map.dx;
        let level_across = map.dy == 0.0;
        let stored = if level_across { 1 } else { lattice.columns };
        let rows = if level_across { map.heights } else { across(&map, &lattice, &kernel) };
        Self { lattice, at_end, dx, rows: Arc::new(rows), stored, kernel, aligned, spectrum: OnceLock::new() }
    }

    /// Number of rows of the map.
    fn count(&self) -> i64 {
        (self.rows.len() / self.stored) as i64
    }

    /// Available road coordinates \[m\]; `None` for a road that never ends.
    pub fn extent(&self) -> Option<(f64, f64)> {
        (self.at_end == AtEnd::Refuse).then(|| (0.0, (self.count() - 1) as f64 * self.dx))
    }

    /// Highest stored height \[m\], at least 0.
    pub fn highest(&self) -> f64 {
        self.rows.iter().fold(0.0, |highest, &height| highest.max(height))
    }

    /// True if the road is level across.
    pub fn is_level_across(&self) -> bool {
        self.stored == 1
    }

    /// Spectrum of the profiles along, at the map's spacing, averaged over up to 16 columns spread evenly across.
    pub fn spectrum(&self) -> &ProfileSpectrum {
        self.spectrum.get_or_init(|| self.find_spectrum())
    }

    fn find_spectrum(&self) -> ProfileSpectrum {
        let mut spectrum = ProfileSpectrum::new(self.count() as usize, self.dx);
        self.profiles(0..self.count()).for_each(|profile| spectrum.add(&profile));
        spectrum
    }

    /// Profiles along, at the map's spacing, over some rows of the continued map: in up to 16 columns spread evenly
    /// across.
    pub(super) fn profiles(&self, rows: Range<i64>) -> impl Iterator<Item = Vec<f64>> {
        let columns = (0..self.stored).step_by(self.stored.div_ceil(PROFILES));
        columns.map(move |column| rows.clone().map(|row| self.row(row)[column]).collect())
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
    pub fn heights(&self, first: i64, out: &mut [f64]) {
        let columns = self.lattice.columns;
        out.par_chunks_mut(columns).enumerate().with_min_len(16).for_each_init(Vec::new, |weights, (index, row)| {
            let number = first + index as i64;
            match self.aligned {
                Some(zero) => self.spread(self.row(number - zero), row),
                None => self.interpolate(number, weights, row),
            }
        });
    }

    fn interpolate(&self, number: i64, weights: &mut Vec<f64>, out: &mut [f64]) {
        let position = self.lattice.place(number, self.dx);
        let ratio = (self.lattice.cell() / self.dx).max(1.0);
        let start = self.kernel.weights(position, ratio, weights);
        if self.stored == 1 {
            let within = usize::try_from(start).ok().and_then(|from| self.rows.get(from..from + weights.len()));
            let sum: f64 = match within {
                Some(heights) => weights.iter().zip(heights).map(|(weight, height)| weight * height).sum(),
                None => weights.iter().enumerate().map(|(tap, weight)| weight * self.row(start + tap as i64)[0]).sum(),
            };
            out.fill(sum);
            return;
        }
        out.fill(0.0);
        for (tap, weight) in weights.iter().enumerate() {
            for (height, source) in out.iter_mut().zip(self.row(start + tap as i64)) {
                *height += weight * source;
            }
        }
    }

    fn spread(&self, source: &[f64], out: &mut [f64]) {
        if self.stored == 1 { out.fill(source[0]) } else { out.copy_from_slice(source) }
    }

    /// A row of the continued map.
    fn row(&self, index: i64) -> &[f64] {
        let count = self.count();
        let inside = match self.at_end {
            AtEnd::Repeat => index.rem_euclid(count) as usize,
            AtEnd::Refuse | AtEnd::Mirror => reflected(index, count),
        };
        &self.rows[inside * self.stored..(inside + 1) * self.stored]
    }
}

fn greatest_common_divisor(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// The map's rows at the run's columns.
fn across(map: &RoadHeightMap, lattice: &Lattice, kernel: &WindowedSinc) -> Vec<f64> {
    let place = |column: usize| (lattice.y(column) - map.first_y) / map.dy;
    let offset = place(0);
    let whole = offset.round();
    let aligned = same(map.dy, lattice.dy) && (offset - whole).abs() < 1e-6;
    let inside = whole >= 0.0 && whole as usize + lattice.columns <= map.columns;
    if aligned && inside {
        let first = whole as usize;
        let rows = map.heights.chunks_exact(map.columns);
        return rows.flat_map(|row| row[first..first + lattice.columns].iter().copied()).collect();
    }
    // A single column is a line, not a cell: no low-pass at its width.
    let ratio = if lattice.columns > 1 { (lattice.dy / map.dy).max(1.0) } else { 1.0 };
    let mut taps = Vec::new();
    // Positions of the samples of each column in a row, with their weights.
    let plans: Vec<Vec<(usize, f64)>> = (0..lattice.columns)
        .map(|column| {
            let first = kernel.weights(place(column), ratio, &mut taps);
            (first..).zip(&taps).map(|(index, &weight)| (reflected(index, map.columns as i64), weight)).collect()
        })
        .collect();
    let mut rows = vec![0.0; map.rows() * lattice.columns];
    rows.par_chunks_mut(lattice.columns).zip(map.heights.par_chunks(map.columns)).for_each(|(out, row)| {
        for (height, plan) in out.iter_mut().zip(&plans) {
            *height = plan.iter().map(|&(index, weight)| weight * row[index]).sum();
        }
    });
    rows
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
        road.heights(first, &mut out);
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
