//! The road of a run: heights of the cells under elements, whatever their source.

use std::ops::RangeInclusive;

use super::error::RoadError;
use super::lattice::Lattice;
use super::piece_rows::PieceRows;
use super::report::{RoadNote, RoadReport};
use super::resample::Resampled;
use super::sources::Source;
use super::sources::grid_stream::{GridStream, LONG_GRID};
use super::sources::made::{PEAK_FACTOR, Patches, RoadDesign, Texture};
use super::texture::{self, wavenumber};
use crate::scene::{AtEnd, Road};

/// Deviation of a made road's level from the wanted one above which there is a note \[dB\]; all deviations are in the
/// report.
const WORTH_TELLING: f64 = 1.0;

/// Waves of the macrotexture that slices of the usual cells resolve, third octaves of 4 to 50 mm \[m\].
const MACROTEXTURE: RangeInclusive<f64> = 0.00355..=0.0562;

/// Limits for opening a road.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Most bytes of one file, and of working arrays.
    pub bytes: u64,
}

impl Default for Limits {
    /// 2 GB: a road larger than that is more likely a mistake.
    fn default() -> Self {
        Self { bytes: 2_000_000_000 }
    }
}

impl Limits {
    /// Refuses so many heights in memory if they need more than the limit.
    ///
    /// # Errors
    /// [`RoadError::TooManyHeights`] with both numbers of bytes.
    pub fn check(self, heights: f64) -> Result<(), RoadError> {
        let needed = (size_of::<f64>() as f64 * heights) as u64;
        if needed > self.bytes { Err(RoadError::TooManyHeights { needed, limit: self.bytes }) } else { Ok(()) }
    }
}

/// An opened road on the run's lattice.
pub struct RoadSurface {
    lattice: Lattice,
    heights: Heights,
    report: RoadReport,
}

enum Heights {
    Plane,
    Drawn { design: RoadDesign, texture: Box<Texture>, patches: Box<Patches> },
    Measured(Box<Resampled>),
}

impl RoadSurface {
    /// Opens a road: reads and checks its file, prepares resampling or synthesis; made roads are drawn later, as their
    /// heights are needed.
    ///
    /// Paths in `spec` are used as they are.
    ///
    /// # Errors
    /// See [`RoadError`]; nothing is repaired without a note: whatever is filled or left out is in [`Self::report`].
    pub fn open(spec: &Road, lattice: Lattice, limits: Limits) -> Result<Self, RoadError> {
        let mut report = RoadReport::default();
        if let Road::Grid(grid) = spec {
            let sizes = (LONG_GRID, limits.bytes);
            if let Some(stream) = GridStream::open(grid, lattice.width(), sizes, &mut report)? {
                return Self::in_pieces(lattice, stream, grid.at_end, report);
            }
        }
        let source = Source::read(spec, lattice, limits.bytes, &mut report)?;
        Self::on(lattice, source, limits, report)
    }

    /// A source on a lattice; `report` is that of its reading.
    pub(super) fn on(
        lattice: Lattice,
        source: Source,
        limits: Limits,
        mut report: RoadReport,
    ) -> Result<Self, RoadError> {
        let heights = match source {
            Source::Smooth => Heights::Plane,
            Source::Made(design) => {
                let texture = Texture::new(&design, lattice, limits.bytes)?;
                report.spacing = Some(design.spacing);
                report.lateral_spacing = Some(design.spacing);
                report.bands = texture.spectrum().band_fit().to_vec();
                report.shortest_wavelength = Some(design.target.shortest().max(2.0 * lattice.dx));
                let worst = report.bands.iter().max_by(|a, b| a.deviation().total_cmp(&b.deviation()));
                if let Some(band) = worst.filter(|band| band.deviation() > WORTH_TELLING) {
                    let (deviation, wavelength) = (band.deviation(), band.wavelength);
                    report.notes.push(RoadNote::NotRealisable { deviation, wavelength });
                }
                Heights::Drawn { design, texture: Box::new(texture), patches: Box::default() }
            }
            Source::Measured(map, at_end) => {
                if map.dy > 0.0 {
                    limits.check(map.rows() as f64 * lattice.columns as f64)?;
                }
                report.length = Some(map.end());
                report_spacings(&mut report, [map.dx, map.dy], lattice);
                if at_end == AtEnd::Repeat {
                    let (rows, columns) = (map.rows(), map.columns);
                    let ends = map.heights[..columns].iter().zip(&map.heights[(rows - 1) * columns..]);
                    let square: f64 = ends.map(|(first, last)| (last - first) * (last - first)).sum();
                    report.notes.push(RoadNote::Joint { step: (square / columns as f64).sqrt() });
                }
                Heights::Measured(Box::new(Resampled::new(map, lattice, at_end)))
            }
        };
        Ok(Self { lattice, heights, report })
    }

    /// A long grid, which is read in pieces.
    pub(super) fn in_pieces(
        lattice: Lattice,
        grid: GridStream,
        at_end: AtEnd,
        mut report: RoadReport,
    ) -> Result<Self, RoadError> {
        lattice.check()?;
        let (spacings, rows) = ([grid.spacing(), grid.lateral_spacing()], grid.rows() as i64);
        let pieces = PieceRows::new(grid, lattice, &mut report)?;
        let mut road = Resampled::in_pieces(pieces, spacings[0], lattice, at_end);
        report.length = Some((rows - 1) as f64 * spacings[0]);
        report_spacings(&mut report, spacings, lattice);
        if at_end == AtEnd::Repeat {
            let [first, last] = [road.profiles(0..1)?, road.profiles(rows - 1..rows)?].map(|ends| ends.concat());
            let square: f64 = first.iter().zip(&last).map(|(first, last)| (last - first).powi(2)).sum();
            report.notes.push(RoadNote::Joint { step: (square / first.len() as f64).sqrt() });
        }
        Ok(Self { lattice, heights: Heights::Measured(Box::new(road)), report })
    }

    /// The lattice on which it was opened.
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// True if the road is the plane z = 0.
    pub fn is_smooth(&self) -> bool {
        matches!(self.heights, Heights::Plane)
    }

    /// True if the road is made, of waves of known lengths.
    pub fn is_made(&self) -> bool {
        matches!(self.heights, Heights::Drawn { .. })
    }

    /// Findings and actions of opening the road.
    pub fn report(&self) -> &RoadReport {
        &self.report
    }

    /// Available road coordinates \[m\]; `None` for an endless road (smooth, made, repeated, mirrored).
    pub fn extent(&self) -> Option<(f64, f64)> {
        match &self.heights {
            Heights::Measured(road) => road.extent(),
            _ => None,
        }
    }

    /// First and last element that have road; `None` for an endless road.
    pub fn elements(&self) -> Option<(i64, i64)> {
        match &self.heights {
            Heights::Measured(road) => road.elements(),
            _ => None,
        }
    }

    /// Number of elements after which the road repeats, bit for bit; `None` if it does not.
    pub fn period(&self) -> Option<i64> {
        match &self.heights {
            Heights::Plane => Some(1),
            Heights::Measured(road) => road.period(),
            Heights::Drawn { .. } => None,
        }
    }

    /// Expected height of the highest point above z = 0 \[m\]: of a measured road the highest there is, of a made one
    /// five times the root-mean-square height.
    pub fn highest(&self) -> f64 {
        match &self.heights {
            Heights::Plane => 0.0,
            Heights::Measured(road) => road.highest(),
            Heights::Drawn { .. } => {
                let mean_square: f64 = self.report.bands.iter().map(|band| texture::mean_square(band.fitted)).sum();
                PEAK_FACTOR * mean_square.sqrt()
            }
        }
    }

    /// Mean wavenumber of the surface's texture \[rad/m\], see `wavenumber`: of a made road from its bands, of a
    /// measured one from its heights. `None` for a road without texture. Costs some transforms of a measured road's
    /// length.
    pub fn mean_wavenumber(&self) -> Option<f64> {
        match &self.heights {
            Heights::Plane => None,
            Heights::Drawn { .. } => Some(wavenumber::of_surface(wavenumber::of_bands(&self.report.bands)?, false)),
            Heights::Measured(road) => {
                let along = wavenumber::of_spectrum(road.spectrum())?;
                Some(wavenumber::of_surface(along, road.is_level_across()))
            }
        }
    }

    /// Root-mean-square height of the surface's macrotexture \[m\], waves of 4 to 50 mm: of a made road from its bands,
    /// of a measured one from its heights. `None` for a road without texture. Costs as [`Self::mean_wavenumber`], once
    /// for both.
    pub fn macrotexture(&self) -> Option<f64> {
        let mean_square = match &self.heights {
            Heights::Plane => return None,
            Heights::Drawn { .. } => {
                let bands = self.report.bands.iter().filter(|band| MACROTEXTURE.contains(&band.wavelength));
                bands.map(|band| texture::mean_square(band.fitted)).sum()
            }
            Heights::Measured(road) => road.spectrum().energy(1.0 / MACROTEXTURE.end(), 1.0 / MACROTEXTURE.start()),
        };
        (mean_square > 0.0).then(|| mean_square.sqrt())
    }

    /// The design of a made road.
    pub(super) fn design(&self) -> Option<&RoadDesign> {
        if let Heights::Drawn { design, .. } = &self.heights { Some(design) } else { None }
    }

    /// The heights of a measured road.
    pub(super) fn measured(&self) -> Option<&Resampled> {
        if let Heights::Measured(road) = &self.heights { Some(road) } else { None }
    }

    /// Checks that the road exists at the road coordinates `from`..`to` \[m\].
    ///
    /// # Errors
    /// [`RoadError::Short`] with the part needed and the part available.
    pub fn check_covers(&self, from: f64, to: f64) -> Result<(), RoadError> {
        match self.extent() {
            Some(available) if from < available.0 - 1e-9 || to > available.1 + 1e-9 || from.is_nan() || to.is_nan() => {
                Err(RoadError::Short { needed: (from, to), available })
            }
            _ => Ok(()),
        }
    }

    /// Writes the heights \[m\] of the cells of `elements` elements from `first` on into `out`, element by element, row
    /// by row.
    ///
    /// The heights of an element do not depend on the elements asked for before, after and with it, nor on the number
    /// of threads. Cost O(cells) for elements asked for in either order; a made road keeps the last few patches drawn.
    ///
    /// # Errors
    /// For elements outside a road that ends, and for a buffer of another size.
    pub fn heights(&mut self, first: i64, elements: usize, out: &mut [f64]) -> Result<(), RoadError> {
        let needed = elements * self.lattice.cells();
        if out.len() != needed {
            return Err(RoadError::BufferSize { needed, found: out.len() });
        }
        match &mut self.heights {
            Heights::Plane => out.fill(0.0),
            Heights::Measured(road) => {
                if let Some((lowest, highest)) = road.elements() {
                    let last = first.saturating_add(elements as i64 - 1);
                    if elements > 0 && (first < lowest || last > highest) {
                        let dx = self.lattice.dx;
                        let available = road.extent().unwrap_or((0.0, 0.0));
                        return Err(RoadError::Short { needed: (first as f64 * dx, last as f64 * dx), available });
                    }
                }
                road.heights(first * self.lattice.along as i64, out)?;
            }
            Heights::Drawn { texture, patches, .. } => {
                texture.rows(first * self.lattice.along as i64, patches, out);
            }
        }
        Ok(())
    }
}

/// Notes the spacings along and across \[m\] of a measured road; the latter is 0 for one that is level across.
fn report_spacings(report: &mut RoadReport, [dx, dy]: [f64; 2], lattice: Lattice) {
    report.spacing = Some(dx);
    report.lateral_spacing = (dy > 0.0).then_some(dy);
    report.shortest_wavelength = Some(2.0 * dx.max(lattice.dx));
    if dx > lattice.dx * (1.0 + 1e-9) {
        report.notes.push(RoadNote::Coarse { spacing: dx, run: lattice.dx });
    }
}
