//! Maker of a zone of the contact: slices or cells.

use crate::contact::axle::MovingAxle;
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

    /// Makes the contact.
    ///
    /// # Errors
    /// [`RunError`].
    fn make(&self, window: Window<'_>, meter: &mut Meter, warnings: &mut Vec<String>) -> Result<Made, RunError>;
}
