//! Charts: pieces of a body's surface as exact functions of two parameters.
//!
//! Each chart is a surface of revolution: `meridian` runs along its section, `turn` is an angle. For the sphere the
//! axis is z: meridian = angle from the south pole, turn = angle from +x towards +y. For the tyre the axis is y: turn =
//! theta, from the bottom (the contact's centre), increasing towards +x; meridian is y on the tread, the shoulder's
//! angle from the tread's edge on the shoulder, the radius on the side.

use super::body::{BodyShape, RadiatingBody, Vector};

/// A piece of surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Chart {
    /// A whole sphere; axis z.
    Sphere {
        /// Radius \[m\].
        radius: f64,
        /// Height of its middle \[m\].
        middle: f64,
    },
    /// The straight tread.
    Tread {
        /// Radius \[m\].
        radius: f64,
        /// Height of the axle over the cut \[m\].
        middle: f64,
        /// Height of the cut over the road \[m\].
        gap: f64,
    },
    /// The shoulder at y > 0.
    Shoulder {
        /// Radius of the tread \[m\].
        radius: f64,
        /// Radius of the shoulder \[m\].
        shoulder: f64,
        /// Half width of the straight tread \[m\].
        edge: f64,
        /// Height of the axle over the cut \[m\].
        middle: f64,
        /// Height of the cut over the road \[m\].
        gap: f64,
    },
    /// The flat side at y > 0.
    Sidewall {
        /// Half width of the body \[m\].
        half_width: f64,
        /// Height of the axle over the cut \[m\].
        middle: f64,
        /// Height of the cut over the road \[m\].
        gap: f64,
    },
    /// The underside between the treads' edges, at y > 0: meridian = y, turn = x \[m\].
    Underside {
        /// Height over the road \[m\].
        gap: f64,
    },
    /// The underside below the shoulder: meridian = the fraction from the tread's edge to the cut, turn = the angle
    /// whose sine is x over half the patch's length.
    UndersideEdge {
        /// Radius of the tread \[m\].
        radius: f64,
        /// Radius of the shoulder \[m\].
        shoulder: f64,
        /// Half width of the straight tread \[m\].
        edge: f64,
        /// Height of the axle over the cut \[m\].
        middle: f64,
        /// Height of the cut over the road \[m\].
        gap: f64,
    },
}

/// A point of the surface with its normal and area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Position \[m\].
    pub position: Vector,
    /// Unit normal, out of the body.
    pub normal: Vector,
    /// Area per unit of the two parameters.
    pub area: f64,
}

impl Chart {
    /// Charts of the tread, a shoulder and a side of a tyre; `None` for another body.
    pub fn of_tyre(body: &RadiatingBody) -> Option<[Self; 3]> {
        let BodyShape::Tyre { radius, width, shoulder } = body.shape() else { return None };
        let (middle, gap) = (body.height().unwrap_or(0.0), body.gap());
        let edge = 0.5 * width - shoulder;
        Some([
            Self::Tread { radius, middle, gap },
            Self::Shoulder { radius, shoulder, edge, middle, gap },
            Self::Sidewall { half_width: 0.5 * width, middle, gap },
        ])
    }

    /// Point at a meridian parameter and an angle.
    pub fn point(&self, meridian: f64, turn: f64) -> SurfacePoint {
        let (sin, cos) = turn.sin_cos();
        // A body of revolution about y: distance from the axle r, across y, the normal's radial and lateral component.
        let about_axle = |r: f64, y: f64, radial: f64, across: f64, middle: f64, along: f64| SurfacePoint {
            position: [r * sin, y, middle - r * cos],
            normal: [radial * sin, across, -radial * cos],
            area: along * r,
        };
        match *self {
            Self::Sphere { radius, middle } => {
                let (s, c) = meridian.sin_cos();
                let normal = [s * cos, s * sin, -c];
                let position = [radius * normal[0], radius * normal[1], middle + radius * normal[2]];
                SurfacePoint { position, normal, area: radius * radius * s }
            }
            Self::Tread { radius, middle, gap } => about_axle(radius, meridian, 1.0, 0.0, middle + gap, 1.0),
            Self::Shoulder { radius, shoulder, edge, middle, gap } => {
                let (s, c) = meridian.sin_cos();
                let r = radius - shoulder * (1.0 - c);
                about_axle(r, edge + shoulder * s, c, s, middle + gap, shoulder)
            }
            Self::Sidewall { half_width, middle, gap } => about_axle(meridian, half_width, 0.0, 1.0, middle + gap, 1.0),
            Self::Underside { gap } => {
                SurfacePoint { position: [turn, meridian, gap], normal: [0.0, 0.0, -1.0], area: 1.0 }
            }
            Self::UndersideEdge { radius, shoulder, edge, middle, gap } => {
                let half = half_length(radius, middle);
                let width = cut_width(radius, shoulder, middle, half, turn);
                SurfacePoint {
                    position: [half * sin, edge + meridian * width, gap],
                    normal: [0.0, 0.0, -1.0],
                    area: width * half * cos,
                }
            }
        }
    }

    /// Distance from the axis \[m\]: length per radian of turn.
    pub fn axis_distance(&self, meridian: f64) -> f64 {
        match *self {
            Self::Sphere { radius, .. } => radius * meridian.sin(),
            Self::Tread { radius, .. } => radius,
            Self::Shoulder { radius, shoulder, .. } => radius - shoulder * (1.0 - meridian.cos()),
            Self::Sidewall { .. } => meridian,
            Self::Underside { .. } => 1.0,
            Self::UndersideEdge { radius, middle, .. } => half_length(radius, middle),
        }
    }

    /// Length along the section per unit of its parameter \[m\].
    pub fn meridian_length(&self) -> f64 {
        match *self {
            Self::Sphere { radius, .. } => radius,
            Self::Tread { .. } | Self::Sidewall { .. } | Self::Underside { .. } => 1.0,
            Self::Shoulder { shoulder, .. } => shoulder,
            Self::UndersideEdge { radius, shoulder, middle, .. } => {
                cut_width(radius, shoulder, middle, half_length(radius, middle), 0.0)
            }
        }
    }

    /// Angle at which the road cuts this ring of a tyre; 0 where it does not reach it.
    pub fn cut_turn(&self, meridian: f64) -> f64 {
        match *self {
            Self::Sphere { .. } | Self::Underside { .. } | Self::UndersideEdge { .. } => 0.0,
            Self::Tread { middle, .. } | Self::Shoulder { middle, .. } | Self::Sidewall { middle, .. } => {
                (middle / self.axis_distance(meridian)).min(1.0).acos()
            }
        }
    }

    /// Meridian parameter at which the road cuts this section of a tyre.
    pub fn cut_meridian(&self, turn: f64) -> f64 {
        match *self {
            Self::Shoulder { radius, shoulder, middle, .. } => {
                (1.0 - (radius - middle / turn.cos()) / shoulder).clamp(-1.0, 1.0).acos()
            }
            Self::Sidewall { middle, .. } => middle / turn.cos(),
            _ => 0.0,
        }
    }
}

/// Half the length of the cut along the tread \[m\].
fn half_length(radius: f64, middle: f64) -> f64 {
    (radius * radius - middle * middle).max(0.0).sqrt()
}

/// Width of the cut below the shoulder beyond the tread's edge \[m\], at the angle whose sine is x over half the cut's
/// length.
fn cut_width(radius: f64, shoulder: f64, middle: f64, half: f64, turn: f64) -> f64 {
    let (sin, cos) = turn.sin_cos();
    // Radius less distance of the cut from the axle, without cancellation.
    let depth = (half * cos).powi(2) / (radius + middle.hypot(half * sin));
    (depth * (2.0 * shoulder - depth)).max(0.0).sqrt()
}
