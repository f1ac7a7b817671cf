//! The contact that a plan expects: that of the tyre pressed onto a smooth road, with a few hundred elements.

use serde::Serialize;

use super::feasible::COARSE_TOLERANCE;
use crate::contact::ContactError;
use crate::contact::static_contact::{StaticContact, StaticTyre, window_reach};
use crate::road::sources::made::TargetSpectrum;
use crate::scene::{Axle, Road, Scene, Tyre};
use crate::tyre::influence::{Field, InfluenceSum, Projection};

/// Elements of the static solution from which patch and window are estimated.
const COARSE: usize = 384;
/// Assumed height of the peaks of a measured road above its plane \[m\], which only its file has: those of a chip seal.
const PEAKS: f64 = 1e-2;

/// Expected contact on a smooth road.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Expected {
    /// Number of points in contact.
    pub points: f64,
    /// Number of columns of the window.
    pub columns: f64,
    /// Length of the patch \[m\].
    pub length: f64,
}

/// Static contact of a tyre on a smooth road.
///
/// # Errors
/// As [`StaticTyre::under`].
pub(super) fn standing(tyre: &Tyre, axle: &Axle) -> Result<StaticContact, ContactError> {
    let sum = InfluenceSum::coarse_at_rest(tyre, Projection::new(tyre, COARSE), COARSE_TOLERANCE);
    let row = sum.static_row(Field::Surface);
    StaticTyre { influence: &row, circumference: tyre.circumference }.under(axle)
}

impl Expected {
    /// Expected contact of a scene whose tyre, of radius `radius` \[m\], has this static contact, with elements of
    /// length `element` \[m\].
    pub(super) fn of(scene: &Scene, standing: Option<StaticContact>, radius: f64, element: f64) -> Self {
        let elements = scene.numerics.elements as f64;
        let (depth, length) = standing.map_or((0.01, 0.1), |found| (found.indentation, found.length));
        let peaks = match &scene.road {
            Road::Smooth => 0.0,
            // A road that cannot be generated is refused when it is opened.
            Road::Made(made) => TargetSpectrum::of(made).map_or(0.0, |target| target.highest()),
            Road::Profile(_) | Road::OpenCrg(_) | Road::Grid(_) => PEAKS,
        };
        let reach = window_reach(&scene.rolling.axle, depth, peaks, radius, element);
        Self {
            points: (length / element).clamp(1.0, elements),
            columns: (2.0 * (reach / element).ceil() + 2.0).clamp(4.0, elements),
            length,
        }
    }
}
