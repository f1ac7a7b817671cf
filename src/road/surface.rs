//! The road as the run sees it: heights of the cells under elements, whatever their source.

use super::error::RoadError;
use super::height_map::HeightMap;
use super::lattice::{Lattice, positive};
use super::made::{Patches, Shape, TargetSpectrum, Texture};
use super::opencrg::strip;
use super::report::{RoadNote, RoadReport};
use super::resample::Resampled;
use super::texture::{self, ProfileSpectrum, TextureLevel, bands_between};
use super::{grid, profile, wavenumber};
use crate::scene::{AtEnd, Lateral, ProfileRoad, Road};

/// Lattice of isotropic surfaces made after a profile \[m\].
const ISOTROPIC_SPACING: f64 = 0.001;
/// Longest wavelength taken from a profile \[m\], and as a share of its length: fewer lines in a band say little.
const ISOTROPIC_LONGEST: (f64, f64) = (0.2819, 1.0 / 6.0);

/// Deviation of a made road's level from the one asked for that is worth a note \[dB\]; all deviations are in the
/// report.
const WORTH_TELLING: f64 = 1.0;

/// What opening a road may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one file, and of working arrays.
    pub bytes: u64,
}

impl Default for Limits {
    /// 2 GB: a road larger than that is more likely a mistake.
    fn default() -> Self {
        Self { bytes: 2_000_000_000 }
    }
}

/// An opened road on the run's lattice.
pub struct RoadSurface {
    lattice: Lattice,
    source: Source,
    report: RoadReport,
}

enum Source {
    Smooth,
    Made { texture: Box<Texture>, patches: Box<Patches> },
    Measured(Box<Resampled>),
}

impl RoadSurface {
    /// Opens a road: reads and checks its file, prepares resampling or synthesis; made roads are drawn later, as they
    /// are asked for.
    ///
    /// Paths in `spec` are used as they are.
    ///
    /// # Errors
    /// See [`RoadError`]; nothing is repaired silently: what is filled or left out stands in [`Self::report`].
    pub fn open(spec: &Road, lattice: Lattice, limits: Limits) -> Result<Self, RoadError> {
        positive("element length", lattice.dx)?;
        positive("column spacing", lattice.dy)?;
        positive("contact.cells_across", lattice.columns as f64)?;
        positive("contact.cells_along", lattice.along as f64)?;
        let mut report = RoadReport::default();
        let source = match spec {
            Road::Smooth => Source::Smooth,
            Road::Made(made) => {
                let shape = Shape::new(made.skewness, made.kurtosis)?;
                let target = TargetSpectrum::of(made)?;
                made_source(&target, shape.as_ref(), made.spacing, made.seed, lattice, limits, &mut report)?
            }
            Road::Profile(profile) if profile.lateral == Lateral::Isotropic => {
                let (target, spacing) = isotropic(profile, limits, &mut report)?;
                made_source(&target, None, spacing, profile.seed, lattice, limits, &mut report)?
            }
            Road::Profile(ProfileRoad { at_end, .. }) => measured_source(spec, *at_end, lattice, limits, &mut report)?,
            Road::OpenCrg(road) => measured_source(spec, road.at_end, lattice, limits, &mut report)?,
            Road::Grid(road) => measured_source(spec, road.at_end, lattice, limits, &mut report)?,
        };
        Ok(Self { lattice, source, report })
    }

    /// The lattice that it was opened on.
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// Whether the road is the plane z = 0.
    pub fn is_smooth(&self) -> bool {
        matches!(self.source, Source::Smooth)
    }

    /// What was found and done while opening.
    pub fn report(&self) -> &RoadReport {
        &self.report
    }

    /// Available road coordinates \[m\]; `None` when the road is endless (smooth, made, repeated, mirrored).
    pub fn extent(&self) -> Option<(f64, f64)> {
        match &self.source {
            Source::Measured(road) => road.extent(),
            _ => None,
        }
    }

    /// Elements after which the road is the same again, bit for bit; `None` where that is not so.
    pub fn period(&self) -> Option<i64> {
        match &self.source {
            Source::Smooth => Some(1),
            Source::Measured(road) => road.period(),
            Source::Made { .. } => None,
        }
    }

    /// Highest point above z = 0 that is to be expected \[m\]: of a measured road the highest there is, of a made one
    /// five times the
    /// root-mean-square height.
    pub fn highest(&self) -> f64 {
        match &self.source {
            Source::Smooth => 0.0,
            Source::Measured(road) => road.highest(),
            Source::Made { .. } => {
                let mean_square: f64 = self.report.bands.iter().map(|band| texture::mean_square(band.fitted)).sum();
                5.0 * mean_square.sqrt()
            }
        }
    }

    /// Mean wavenumber of the surface's texture \[rad/m\], see [`wavenumber`]: of a made road from the bands that it
    /// has, of a measured one from its heights. `None` for a road without texture. Costs some transforms of a measured
    /// road's length.
    pub fn mean_wavenumber(&self) -> Option<f64> {
        match &self.source {
            Source::Smooth => None,
            Source::Made { .. } => Some(wavenumber::of_surface(wavenumber::of_bands(&self.report.bands)?, false)),
            Source::Measured(road) => {
                let along = wavenumber::of_spectrum(&road.spectrum())?;
                Some(wavenumber::of_surface(along, road.is_level_across()))
            }
        }
    }

    /// Checks that road coordinates `from`..`to` \[m\] are there.
    ///
    /// # Errors
    /// [`RoadError::Short`] with what is needed and what there is.
    pub fn check_covers(&self, from: f64, to: f64) -> Result<(), RoadError> {
        match self.extent() {
            Some(available) if from < available.0 - 1e-9 || to > available.1 + 1e-9 || from.is_nan() || to.is_nan() => {
                Err(RoadError::Short { needed: (from, to), available })
            }
            _ => Ok(()),
        }
    }

    /// Heights \[m\] of the cells of `elements` elements from `first` on into `out`, element by element, row by row.
    ///
    /// The same element has the same heights whatever is asked before, after and with it, and on any number of threads.
    /// Cost
    /// O(cells) for elements asked in either order; a made road keeps the last few patches that it has drawn.
    ///
    /// # Errors
    /// Elements outside a road that ends; a buffer of another size.
    pub fn heights(&mut self, first: i64, elements: usize, out: &mut [f64]) -> Result<(), RoadError> {
        let needed = elements * self.lattice.cells();
        if out.len() != needed {
            return Err(RoadError::BufferSize { needed, found: out.len() });
        }
        match &mut self.source {
            Source::Smooth => out.fill(0.0),
            Source::Measured(road) => {
                if let Some((lowest, highest)) = road.elements() {
                    let last = first.saturating_add(elements as i64 - 1);
                    if elements > 0 && (first < lowest || last > highest) {
                        let dx = self.lattice.dx;
                        let available = road.extent().unwrap_or((0.0, 0.0));
                        return Err(RoadError::Short { needed: (first as f64 * dx, last as f64 * dx), available });
                    }
                }
                road.heights(first * self.lattice.along as i64, out);
            }
            Source::Made { texture, patches } => {
                texture.rows(first * self.lattice.along as i64, patches, out);
            }
        }
        Ok(())
    }
}

fn made_source(
    target: &TargetSpectrum,
    shape: Option<&Shape>,
    spacing: f64,
    seed: u64,
    lattice: Lattice,
    limits: Limits,
    report: &mut RoadReport,
) -> Result<Source, RoadError> {
    let texture = Texture::new(target, shape, spacing, seed, lattice, limits.bytes)?;
    report.spacing = Some(spacing);
    report.lateral_spacing = Some(spacing);
    report.bands = texture.spectrum().band_fit().to_vec();
    report.shortest_wavelength = Some(target.shortest().max(2.0 * lattice.dx));
    let worst = report.bands.iter().max_by(|a, b| (a.fitted - a.target).abs().total_cmp(&(b.fitted - b.target).abs()));
    if let Some(band) = worst.filter(|band| (band.fitted - band.target).abs() > WORTH_TELLING) {
        let note =
            RoadNote::NotRealisable { deviation: (band.fitted - band.target).abs(), wavelength: band.wavelength };
        report.notes.push(note);
    }
    Ok(Source::Made { texture: Box::new(texture), patches: Box::default() })
}

fn measured_source(
    spec: &Road,
    at_end: AtEnd,
    lattice: Lattice,
    limits: Limits,
    report: &mut RoadReport,
) -> Result<Source, RoadError> {
    let Some(map) = measured_map(spec, lattice.width(), limits, report)? else { return Ok(Source::Smooth) };
    report.length = Some(map.end());
    report.spacing = Some(map.dx);
    report.lateral_spacing = (map.dy > 0.0).then_some(map.dy);
    report.shortest_wavelength = Some(2.0 * map.dx.max(lattice.dx));
    if map.dx > lattice.dx * (1.0 + 1e-9) {
        report.notes.push(RoadNote::Coarse { spacing: map.dx, run: lattice.dx });
    }
    if at_end == AtEnd::Repeat {
        let (rows, columns) = (map.rows(), map.columns);
        let ends = map.heights[..columns].iter().zip(&map.heights[(rows - 1) * columns..]);
        let square: f64 = ends.map(|(first, last)| (last - first) * (last - first)).sum();
        report.notes.push(RoadNote::Joint { step: (square / columns as f64).sqrt() });
    }
    Ok(Source::Measured(Box::new(Resampled::new(map, lattice, at_end))))
}

/// The height map behind a road, on its own lattice; `None` for roads that have none (smooth, made).
///
/// # Errors
/// As [`RoadSurface::open`].
pub(super) fn measured_map(
    spec: &Road,
    contact_width: f64,
    limits: Limits,
    report: &mut RoadReport,
) -> Result<Option<HeightMap>, RoadError> {
    match spec {
        Road::Smooth | Road::Made(_) => Ok(None),
        Road::Profile(spec) => profile::read(spec, limits.bytes, report).map(Some),
        Road::OpenCrg(spec) => strip::read(spec, contact_width, limits.bytes, report).map(Some),
        Road::Grid(spec) => grid::read(spec, contact_width, limits.bytes, report).map(Some),
    }
}

/// The target spectrum that a profile gives, and the lattice to make it on.
pub(super) fn isotropic(
    spec: &ProfileRoad,
    limits: Limits,
    report: &mut RoadReport,
) -> Result<(TargetSpectrum, f64), RoadError> {
    let map = profile::read(spec, limits.bytes, report)?;
    let spacing = ISOTROPIC_SPACING.max(map.dx);
    let longest = (map.end() * ISOTROPIC_LONGEST.1).min(ISOTROPIC_LONGEST.0);
    let shortest = spacing / 0.45;
    let mut spectrum = ProfileSpectrum::new(map.heights.len(), map.dx);
    spectrum.add(&map.heights);
    let levels: Vec<TextureLevel> =
        if bands_between(longest, shortest).next().is_some() { spectrum.levels(longest, shortest) } else { Vec::new() };
    if levels.is_empty() {
        let needed = (8.0 * shortest / map.dx / ISOTROPIC_LONGEST.1).ceil() as usize;
        return Err(RoadError::TooFewPoints { path: spec.file.clone(), found: map.heights.len(), needed });
    }
    let target = TargetSpectrum::measured(&levels)?;
    report.notes.push(RoadNote::MadeIsotropic { longest: target.longest(), shortest: target.shortest() });
    Ok((target, spacing))
}
