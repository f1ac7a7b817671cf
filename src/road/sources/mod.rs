//! Sources of roads, and the lattice that suits them.
//!
//! Files are read within a bound of memory, [`missing`] heights separated from measured ones. A `profile`, a `grid` and
//! an `opencrg` road become a [`height_map`], from which [`conditioning`] removes spikes and slopes, whatever the kind;
//! a long grid does so piece by piece ([`grid_stream`]). A [`made`] one, or an isotropic one with a profile's levels,
//! is a design, drawn as it is needed.

mod columns;
pub(super) mod conditioning;
mod erd;
mod grid;
pub(crate) mod grid_stream;
pub(crate) mod height_map;
pub(crate) mod made;
mod missing;
pub(super) mod opencrg;
pub(super) mod profile;
mod raster;
mod rounded;
mod signature;
mod table;
mod titles;

use std::path::PathBuf;

use super::error::{RoadError, positive};
use super::file_fault::FileFault;
use super::lattice::{Lattice, same};
use super::report::{RoadNote, RoadReport};
use super::texture::{ProfileSpectrum, bands_between};
use crate::scene::{AtEnd, Lateral, Levelling, ProfileRoad, Road};
use height_map::RoadHeightMap;
use made::{HeightShape, RoadDesign, TargetSpectrum};

/// Spacing of isotropic surfaces made after a profile \[m\].
const ISOTROPIC_SPACING: f64 = 0.001;
/// Longest wavelength taken from a profile \[m\], and as a part of its length: a band of fewer lines is unreliable.
const ISOTROPIC_LONGEST: (f64, f64) = (0.2819, 1.0 / 6.0);

/// Files that a road's file includes, as far as they can be followed within `limit` bytes a file; a failure is reported
/// when the road is read.
pub(crate) fn included(road: &Road, limit: u64) -> Vec<PathBuf> {
    match road {
        Road::OpenCrg(road) => opencrg::included(&road.file, limit),
        Road::Smooth | Road::Made(_) | Road::Profile(_) | Road::Grid(_) => Vec::new(),
    }
}

/// A road as its scene and its file describe it, independent of a run's lattice.
#[derive(Clone)]
pub(super) enum Source {
    /// The plane z = 0.
    Smooth,
    /// A texture to be drawn.
    Made(RoadDesign),
    /// A measured piece, and its continuation past its end.
    Measured(RoadHeightMap, AtEnd),
}

impl Source {
    /// Reads the road of a scene; of a wide road only the strip that the lattice covers.
    ///
    /// # Errors
    /// Errors of the road's file and of the spectrum asked for.
    pub(super) fn read(spec: &Road, lattice: Lattice, bytes: u64, report: &mut RoadReport) -> Result<Self, RoadError> {
        lattice.check()?;
        let (mut map, at_end, level, longest) = match spec {
            Road::Smooth => return Ok(Self::Smooth),
            Road::Made(made) => {
                let [skewness, kurtosis] = made.moments();
                let shape = HeightShape::new(skewness, kurtosis)?;
                let target = TargetSpectrum::of(made)?;
                if let Some(texture) = made.texture {
                    let ([depth, within], origin) = (texture.depth(), texture.origin());
                    report.notes.push(RoadNote::NamedTexture { texture: texture.name(), depth, within, origin });
                } else if made.named().is_some() {
                    report.notes.push(RoadNote::DefaultTexture);
                }
                return Ok(Self::Made(RoadDesign { target, shape, spacing: made.spacing, seed: made.seed }));
            }
            Road::Profile(profile) if profile.lateral == Lateral::Isotropic => {
                return isotropic(profile, bytes, report).map(Self::Made);
            }
            Road::Profile(road) => {
                (profile::read(road, bytes, report)?, road.at_end, road.level, road.longest_wavelength)
            }
            Road::OpenCrg(road) => {
                let map = opencrg::read(road, lattice.width(), bytes, report)?;
                (map, road.at_end, road.level, road.longest_wavelength)
            }
            Road::Grid(road) => {
                (grid::read(road, lattice.width(), bytes, report)?, road.at_end, road.level, road.longest_wavelength)
            }
        };
        conditioning::condition(&mut map, level, longest, report)?;
        let may_be_plane = level == Levelling::Off || matches!(spec, Road::OpenCrg(_));
        map.check_smoothness(may_be_plane, &mut report.notes)?;
        Ok(Self::Measured(map, at_end))
    }
}

/// Surface with the levels of a profile.
fn isotropic(spec: &ProfileRoad, bytes: u64, report: &mut RoadReport) -> Result<RoadDesign, RoadError> {
    let mut map = profile::read(spec, bytes, report)?;
    conditioning::condition(&mut map, spec.level, spec.longest_wavelength, report)?;
    map.check_smoothness(false, &mut report.notes)?;
    let spacing = ISOTROPIC_SPACING.max(map.dx);
    let longest = (map.end() * ISOTROPIC_LONGEST.1).min(ISOTROPIC_LONGEST.0);
    let shortest = spacing / 0.45;
    if bands_between(longest, shortest).next().is_none() {
        if bands_between(ISOTROPIC_LONGEST.0, shortest).next().is_none() {
            let fault = FileFault::TooCoarse { spacing, longest: ISOTROPIC_LONGEST.0 };
            return Err(RoadError::file(&spec.file, fault));
        }
        let needed = (8.0 * shortest / map.dx / ISOTROPIC_LONGEST.1).ceil() as usize;
        return Err(RoadError::file(&spec.file, FileFault::TooFewPoints { found: map.heights.len(), needed }));
    }
    let mut spectrum = ProfileSpectrum::new(map.heights.len(), map.dx);
    spectrum.add(&map.heights);
    let levels = spectrum.levels(longest, shortest);
    if levels.is_empty() {
        return Err(RoadError::file(&spec.file, FileFault::Flat));
    }
    let target = TargetSpectrum::measured(&levels)?;
    report.notes.push(RoadNote::MadeIsotropic { longest: target.longest(), shortest: target.shortest() });
    Ok(RoadDesign { target, shape: None, spacing, seed: spec.seed })
}

impl Lattice {
    /// Chooses the lattice for a road: cells across and along as the scene says; else those of a grid that covers the
    /// contact width exactly, with an odd number of its rows on an element, so that one is at its middle; one column
    /// for roads that are level across; else cells of about [`Road::cell`].
    ///
    /// # Errors
    /// A grid's file that cannot be read (its header is needed); dx or width not positive.
    pub fn choose(
        road: &Road,
        dx: f64,
        contact_width: f64,
        cells_across: Option<usize>,
        cells_along: Option<usize>,
    ) -> Result<Self, RoadError> {
        positive("element length", dx)?;
        positive("tyre.contact_width", contact_width)?;
        for (key, cells) in [("contact.cells_across", cells_across), ("contact.cells_along", cells_along)] {
            positive(key, cells.unwrap_or(1) as f64)?;
        }
        let (across, along) = (Self::across(contact_width, road.cell()), Road::cells(dx, road.cell()));
        let (columns, along) = match road {
            Road::Smooth => (1, 1),
            Road::Profile(ProfileRoad { lateral: Lateral::Extruded, .. }) => (1, along),
            Road::Grid(spec) => match grid::lattice(spec)? {
                Some((columns, row, column)) => {
                    let rows = (dx / row).round();
                    let whole = same(rows * row, dx) && rows as i64 % 2 == 1;
                    let fits = whole && same(column * columns as f64, contact_width);
                    if fits { (columns, rows as usize) } else { (across, along) }
                }
                None => (across, along),
            },
            _ => (across, along),
        };
        let columns = cells_across.unwrap_or(columns);
        Ok(Self { dx, along: cells_along.unwrap_or(along), dy: contact_width / columns as f64, columns })
    }
}
