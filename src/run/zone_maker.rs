//! Constructor of a zone of the contact: slices or cells.

use crate::contact::axle::MovingAxle;
use crate::contact::cells::gaps::GapMap;
use crate::contact::geometry::Geometry;
use crate::contact::march::March;
use crate::contact::static_contact::StaticContact;
use crate::counters::Job;
use crate::effects::{RunError, TyreModels};
use crate::road::RoadSurface;
use crate::road::maker::SliceForm;

/// Window that a zone is made for.
pub(super) struct Window<'a> {
    /// Elements whose forces are reported.
    pub(super) output_window: Geometry,
    /// Columns by which the search window is longer at either end.
    pub(super) margin: usize,
    /// Columns of the search window.
    pub(super) columns: usize,
    /// Opened road.
    pub(super) surface: &'a RoadSurface,
    /// Static contact on a smooth road.
    pub(super) at_rest: StaticContact,
}

/// A run's path along its road, for the tyre standing at places of it.
pub(super) struct Standing<'a> {
    /// Opened road.
    pub(super) surface: &'a mut RoadSurface,
    /// First and last element of the road, if it ends.
    pub(super) elements: Option<(i64, i64)>,
    /// Road coordinate under the axle at the begin \[m\].
    pub(super) start: f64,
    /// Static contact on a smooth road.
    pub(super) at_rest: StaticContact,
    /// Largest distance of points that can touch from the contact's centre \[m\].
    pub(super) reach: f64,
}

/// Contact that is ready for its first step.
pub(super) struct Made {
    pub(super) march: March,
    /// Form in which the contact takes the road.
    pub(super) form: SliceForm,
    /// The axle, if it has a mass.
    pub(super) moving: Option<MovingAxle>,
    /// kappa of the local law \[m/Pa\], if slices follow it.
    pub(super) local_compliance: Option<f64>,
    /// Models of the tyre that effects may use.
    pub(super) models: TyreModels,
}

pub(super) trait ZoneMaker {
    /// Static contact on a smooth road under the scene's axle, and the factor of the influence functions.
    ///
    /// # Errors
    /// An axle that finds no height for its load.
    fn at_rest(&mut self) -> Result<(StaticContact, f64), RunError>;

    /// Warning if the road makes the zone's law pointless.
    fn law_warning(&self, _surface: &RoadSurface) -> Option<String> {
        None
    }

    /// Gaps between tread and road at places of the run, if their air radiates.
    ///
    /// # Errors
    /// An axle that finds no height for its load; the road's.
    fn gaps(&self, _standing: Standing<'_>) -> Result<Vec<GapMap>, RunError> {
        Ok(Vec::new())
    }

    /// Makes the contact.
    fn make(&self, window: Window<'_>, job: &mut Job<'_>) -> Result<Made, RunError>;
}
