//! Maker of a zone of the contact: slices or cells.

use crate::contact::axle::MovingAxle;
use crate::contact::cells::gaps::GapMap;
use crate::contact::geometry::Geometry;
use crate::contact::march::March;
use crate::contact::static_contact::StaticContact;
use crate::counters::Meter;
use crate::effects::RunError;
use crate::effects::TyreModels;
use crate::road::RoadSurface;
use crate::road::maker::SliceForm;

/// Window that a zone is made for.
pub(super) struct Window<'a> {
    /// Where the elements are whose forces are told.
    pub(super) told: Geometry,
    /// Columns by which the window in which contact is sought is longer, at either end.
    pub(super) margin: usize,
    /// Columns of that window.
    pub(super) columns: usize,
    /// The road.
    pub(super) surface: &'a RoadSurface,
    /// Static contact on a smooth road.
    pub(super) at_rest: StaticContact,
}

/// Way of a run along its road, at places of which the tyre stands.
pub(super) struct Standing<'a> {
    /// The road.
    pub(super) surface: &'a mut RoadSurface,
    /// Its first and last element, where it ends.
    pub(super) elements: Option<(i64, i64)>,
    /// Road coordinate under the axle at first \[m\].
    pub(super) start: f64,
    /// Static contact on a smooth road.
    pub(super) at_rest: StaticContact,
    /// Reach of what can touch from the contact's centre \[m\].
    pub(super) reach: f64,
}

/// Contact that is ready for its first step.
pub(super) struct Made {
    pub(super) march: March,
    /// Form of the road that it takes.
    pub(super) form: SliceForm,
    /// The axle's mass, where it has one.
    pub(super) moving: Option<MovingAxle>,
    /// kappa of the local law \[m/Pa\], where slices yield by it.
    pub(super) local_compliance: Option<f64>,
    /// Models of the tyre that effects may take.
    pub(super) models: TyreModels,
}

/// Maker of a zone.
pub(super) trait ZoneMaker {
    /// Finds the contact at rest on a smooth road under the scene's axle, and the factor of the influence functions.
    ///
    /// # Errors
    /// An axle that finds no height for its load.
    fn at_rest(&mut self) -> Result<(StaticContact, f64), RunError>;

    /// Tells what a road leaves of the zone's law.
    fn doubt(&self, _surface: &RoadSurface) -> Option<String> {
        None
    }

    /// Finds the gaps between tread and road at places of the run, where their air is heard.
    ///
    /// # Errors
    /// An axle that finds no height for its load; the road's.
    fn gaps(&self, _standing: Standing<'_>) -> Result<Vec<GapMap>, RunError> {
        Ok(Vec::new())
    }

    /// Makes the contact.
    ///
    /// # Errors
    /// [`RunError`].
    fn make(&self, window: Window<'_>, meter: &mut Meter, warnings: &mut Vec<String>) -> Result<Made, RunError>;
}
