//! Profiles along a road at the road's own spacing, piece by piece, for its texture measures.

use super::error::RoadError;
use super::lattice::Lattice;
use super::piece_rows::{PROFILES, column_of};
use super::report::RoadReport;
use super::resample::Resampled;
use super::sources::Source;
use super::surface::{Limits, RoadSurface};

/// Number of profiles of a made road, beside each other.
const DRAWN: usize = 8;

/// Profiles of a road.
pub(crate) struct RoadProfiles {
    spacing: f64,
    road: Road,
}

enum Road {
    Drawn(Box<RoadSurface>),
    Measured(Box<Resampled>),
}

/// Lattice of the profiles of a made road: neighbouring columns at the road's spacing. Further apart they would be
/// low-passed across like the cells of a run.
pub(super) fn lattice_of_profiles(spacing: f64) -> Lattice {
    Lattice { dx: spacing, along: 1, dy: spacing, columns: DRAWN }
}

impl RoadProfiles {
    /// Most profiles of a road.
    pub(crate) const MOST: usize = PROFILES;

    /// Profiles of an opened road, of a measured one in columns of the run; `None` for the plane.
    ///
    /// # Errors
    /// Working arrays of a made road beyond the limits.
    pub(crate) fn of(surface: &RoadSurface, limits: Limits) -> Result<Option<Self>, RoadError> {
        if let Some(road) = surface.measured() {
            return Ok(Some(Self { spacing: road.spacing(), road: Road::Measured(Box::new(road.clone())) }));
        }
        let Some(design) = surface.design() else { return Ok(None) };
        let (spacing, source) = (design.spacing, Source::Made(design.clone()));
        let surface = RoadSurface::on(lattice_of_profiles(spacing), source, limits, RoadReport::default())?;
        Ok(Some(Self { spacing, road: Road::Drawn(Box::new(surface)) }))
    }

    /// Distance of the heights along \[m\].
    pub(crate) fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Equally long profiles \[m\] of the road from one road coordinate up to before another \[m\].
    ///
    /// # Errors
    /// Errors of the road.
    pub(crate) fn between(&mut self, from: f64, to: f64) -> Result<Vec<Vec<f64>>, RoadError> {
        let [first, end] = [from, to].map(|place| (place / self.spacing - 1e-6).ceil() as i64);
        match &mut self.road {
            Road::Measured(road) => road.profiles(first..end),
            Road::Drawn(surface) => {
                let (columns, rows) = (surface.lattice().columns, (end - first).max(0) as usize);
                let mut heights = vec![0.0; rows * columns];
                surface.heights(first, rows, &mut heights)?;
                Ok((0..columns).map(|column| column_of(&heights, column, columns)).collect())
            }
        }
    }
}
