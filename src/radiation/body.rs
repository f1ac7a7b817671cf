//! Rigid bodies whose boundary is known exactly: a sphere, a tyre; free or over a rigid road.
//!
//! Axes: x fore and aft, y across (the tyre's axle), z up. With a road (the plane z = 0) the middle of the body is at
//! (0, 0, height); without one at the origin. Both bodies are mirror-symmetric in x and in y.
//!
//! A body lower than its radius is cut by the road: the cut surface is sealed against it, there is no air between. The
//! tyre keeps its radius and its shoulders above the cut (no bulge), so that along the sides of the patch the shoulder
//! meets the road at an angle larger than the tread's at the leading edge, nowhere in a cusp.

use super::error::{RadiationError, positive};

/// A point or a direction in space \[m\].
pub type Vector = [f64; 3];

/// Shape of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BodyShape {
    /// A sphere.
    Sphere {
        /// Radius \[m\].
        radius: f64,
    },
    /// A body of revolution about the axle: a straight tread, shoulders that are quarter circles, flat closed sides.
    Tyre {
        /// Radius of the tread \[m\].
        radius: f64,
        /// Width of the body, shoulders included \[m\].
        width: f64,
        /// Radius of the shoulders \[m\].
        shoulder: f64,
    },
}

/// A body and its height over the road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadiatingBody {
    shape: BodyShape,
    height: Option<f64>,
    gap: f64,
}

/// Least clearance of a body that does not touch the road, relative to its radius.
const LEAST_CLEARANCE: f64 = 1e-4;

/// Smallest gap between patch and road \[m\].
const LEAST_GAP: f64 = 2e-5;

/// Radii of bodies, and widths of tyres, that are accepted \[m\]: from toys to earth movers, and far beyond.
const SIZES: [f64; 2] = [1e-3, 1e2];

/// Smallest radius of a round shoulder, relative to the tyre's radius.
const LEAST_SHOULDER: f64 = 1e-4;

/// Lowest middle of a body that is cut by the road, relative to its radius.
const LOWEST: f64 = 0.05;

impl RadiatingBody {
    /// A body whose middle is at `height` \[m\] over a rigid road, or without a road.
    ///
    /// # Errors
    /// Sizes that are not positive or out of range, a shoulder larger than the body or too small to be round, a middle
    /// below 5 % of the radius, a tyre that touches the road in a line (a patch of no length) and a clearance below
    /// 1e-4 of the radius.
    pub fn new(shape: BodyShape, height: Option<f64>) -> Result<Self, RadiationError> {
        let radius = match shape {
            BodyShape::Sphere { radius } => {
                size("the sphere's radius", radius)?;
                radius
            }
            BodyShape::Tyre { radius, width, shoulder } => {
                size("the tyre's radius", radius)?;
                size("the tyre's width", width)?;
                let least = LEAST_SHOULDER * radius;
                let round = shoulder >= least && shoulder <= 0.5 * width && shoulder < radius;
                if !(round || shoulder.abs() <= 0.0) {
                    return Err(RadiationError::Shoulder { shoulder, width, radius, least });
                }
                radius
            }
        };
        if let Some(height) = height {
            let refuse = |why| Err(RadiationError::Height { what: "a body", height, radius, why });
            if !height.is_finite() || height < LOWEST * radius {
                return refuse("its middle must be above the road by at least 5 % of the radius");
            }
            let clearance = (height - radius) / radius;
            let is_touching = clearance.abs() < LEAST_CLEARANCE;
            let exact = clearance.abs() < f64::EPSILON;
            if is_touching && !(exact && matches!(shape, BodyShape::Sphere { .. })) {
                return refuse("it must be cut by the road or clear of it by more than 1e-4 of the radius");
            }
        }
        Ok(Self { shape, height, gap: 0.0 })
    }

    /// A tyre standing on the road with a contact patch of half length a = `half_length` \[m\]: its axle is sqrt(R^2 -
    /// a^2) high.
    ///
    /// # Errors
    /// As [`Self::new`]; a patch as long as the tyre.
    pub fn standing_tyre(radius: f64, width: f64, shoulder: f64, half_length: f64) -> Result<Self, RadiationError> {
        positive("half the patch's length", half_length)?;
        positive("the tyre's radius", radius)?;
        let height = (radius * radius - half_length * half_length).max(0.0).sqrt();
        Self::new(BodyShape::Tyre { radius, width, shoulder }, Some(height))
    }

    /// The same tyre over a slit: the flat underside that the cut leaves is not sealed against the road but `gap` \[m\]
    /// above it, as over the hollows of a rough road; the whole body is raised by that. 0 is the sealed body.
    ///
    /// # Errors
    /// [`RadiationError::Gap`] where the gap is negative or no number, above a tenth of the patch's half length, below
    /// 20 micrometres (viscosity closes it), or for a body that is no tyre cut through its shoulders.
    pub fn with_gap(self, gap: f64) -> Result<Self, RadiationError> {
        let refuse = |why| Err(RadiationError::Gap { gap, why });
        if !(gap >= 0.0 && gap.is_finite()) {
            return refuse("it must be 0 or a positive number");
        }
        if gap <= 0.0 {
            return Ok(Self { gap: 0.0, ..self });
        }
        let BodyShape::Tyre { shoulder, radius, .. } = self.shape else {
            return refuse("only a tyre has a gap");
        };
        let Some(height) = self.height.filter(|height| *height < radius && radius - height < shoulder) else {
            return refuse("the road must cut the tread and must not reach above the shoulders");
        };
        if gap < LEAST_GAP {
            return refuse("a gap below 20 micrometres is closed by the air's viscosity: take 0");
        }
        if gap > 0.1 * (radius * radius - height * height).sqrt() {
            return refuse("it must be at most a tenth of the patch's half length");
        }
        Ok(Self { gap, ..self })
    }

    /// Height of the slit under the patch \[m\]; 0 where the patch is sealed.
    pub fn gap(&self) -> f64 {
        self.gap
    }

    /// Shape and sizes of the body.
    pub fn shape(&self) -> BodyShape {
        self.shape
    }

    /// Height of the middle over the road, or over the underside if there is a gap \[m\]; `None` without a road.
    pub fn height(&self) -> Option<f64> {
        self.height
    }

    /// True if there is a rigid road.
    pub fn on_road(&self) -> bool {
        self.height.is_some()
    }

    /// Height of the middle over the road \[m\], the gap included; 0 without a road.
    pub fn middle(&self) -> f64 {
        self.height.unwrap_or(0.0) + self.gap
    }

    /// Radius of the sphere or of the tread \[m\].
    pub fn radius(&self) -> f64 {
        match self.shape {
            BodyShape::Sphere { radius } | BodyShape::Tyre { radius, .. } => radius,
        }
    }

    /// Half the length of the contact patch \[m\]; 0 where the road does not cut the body.
    pub fn half_patch(&self) -> f64 {
        let radius = self.radius();
        self.height.map_or(0.0, |height| (radius * radius - height * height).max(0.0).sqrt())
    }

    /// Depth of a point below the body's surface \[m\], negative outside; the road is not part of the body.
    pub fn depth(&self, [x, y, z]: Vector) -> f64 {
        let z = z - self.middle();
        match self.shape {
            BodyShape::Sphere { radius } => radius - (x * x + y * y + z * z).sqrt(),
            BodyShape::Tyre { radius, width, shoulder } => {
                // Distance to a rounded box in the half plane of (distance from the axle, distance from the middle).
                let across = y.abs() - (0.5 * width - shoulder);
                let out = x.hypot(z) - (radius - shoulder);
                let outside = across.max(0.0).hypot(out.max(0.0));
                shoulder - outside - across.max(out).min(0.0)
            }
        }
    }

    /// Checks that a receiver is in the air.
    ///
    /// # Errors
    /// [`RadiationError::Point`] for a point that is not finite, in the body or below the road.
    pub fn check_receiver(&self, point: Vector) -> Result<(), RadiationError> {
        self.check_above(point)?;
        let in_slit = self.gap > 0.0 && point[2] < self.gap;
        if self.depth(point) > -1e-9 * self.radius() && !in_slit {
            return Err(refused(point, "is inside the body or on it"));
        }
        Ok(())
    }

    /// Checks that a point is on the surface, to 1e-3 of the radius, and not below the road.
    ///
    /// # Errors
    /// [`RadiationError::Point`].
    pub fn check_surface_point(&self, point: Vector) -> Result<(), RadiationError> {
        self.check_above(point)?;
        let near = (point[2] - self.gap).abs() < 1e-3 * self.radius();
        let underside = self.gap > 0.0 && near && self.depth(point) > 0.0;
        if self.depth(point).abs() > 1e-3 * self.radius() && !underside {
            return Err(refused(point, "is not on the body's surface"));
        }
        Ok(())
    }

    /// Checks that a point is finite and not below the road.
    fn check_above(&self, point: Vector) -> Result<(), RadiationError> {
        if !point.iter().all(|number| number.is_finite()) {
            return Err(refused(point, "is not finite"));
        }
        if self.on_road() && point[2] < 0.0 {
            return Err(refused(point, "is below the road"));
        }
        Ok(())
    }
}

/// Checks that a size is within [`SIZES`].
fn size(what: &'static str, value: f64) -> Result<(), RadiationError> {
    positive(what, value)?;
    let [least, most] = SIZES;
    if (least..=most).contains(&value) { Ok(()) } else { Err(RadiationError::Size { what, value, least, most }) }
}

fn refused([x, y, z]: Vector, why: &'static str) -> RadiationError {
    RadiationError::Point { x, y, z, why }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tyre(shoulder: f64) -> RadiatingBody {
        RadiatingBody::new(BodyShape::Tyre { radius: 0.32, width: 0.2, shoulder }, Some(0.305)).unwrap()
    }

    #[test]
    fn depths_are_those_below_tread_sidewall_and_shoulder() {
        for (position, distance) in [
            ([0.0, 0.0, 0.305], -0.1),
            ([0.0, 0.0, 0.305 + 0.4], 0.08),
            ([0.4, 0.05, 0.305], 0.08),
            ([0.1, 0.3, 0.305], 0.2),
            ([0.1, -0.3, 0.305], 0.2),
            ([0.29 + 0.03, 0.07 + 0.04, 0.305], 0.02),
            ([0.31, 0.0, 0.305], -0.01),
        ] {
            let depth = tyre(0.03).depth(position);
            assert!((depth + distance).abs() < 1e-12, "{position:?}: {depth}");
        }
    }

    #[test]
    fn a_receiver_is_neither_in_the_tyre_nor_below_the_road() {
        let why = |body: RadiatingBody, point| match body.check_receiver(point) {
            Err(RadiationError::Point { why, .. }) => why,
            other => panic!("{point:?}: {other:?}"),
        };
        // The rounding of a shoulder is air where a sharp corner would be tyre.
        let corner = [0.315, 0.095, 0.305];
        assert_eq!(tyre(0.03).check_receiver(corner), Ok(()));
        assert_eq!(why(tyre(0.0), corner), "is inside the body or on it");
        assert_eq!(tyre(0.03).check_receiver([5.0, 0.0, 0.0]), Ok(()));
        assert_eq!(why(tyre(0.03), [5.0, 0.0, -1e-6]), "is below the road");
        assert_eq!(why(tyre(0.03), [0.0, 0.0, 0.001]), "is inside the body or on it");
        assert_eq!(why(tyre(0.03), [0.0, 0.0, -0.001]), "is below the road");
    }
}
