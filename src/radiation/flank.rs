//! Flank of a tyre's body, which moves beside the tread: the shoulder, and the flat side down to the bead.
//!
//! A place on it is given by the fraction of its area between it and the tread's edge, as places of a sidewall are
//! (`crate::sidewall`); rings at the points of a [`SplitRule`] whose panels are shoulder and side represent all of it.

use std::f64::consts::FRAC_PI_2;

use super::body::{BodyShape, RadiatingBody};
use super::chart::Chart;
use crate::numeric::SplitRule;

/// Flank of a body: the shoulder, and the flat side down to a bead.
#[derive(Clone, Debug, PartialEq)]
pub struct Flank {
    /// Radius of the bead \[m\].
    pub bead: f64,
    /// Quadrature rule over its area from the tread's edge to the bead.
    pub rule: SplitRule,
    shoulder: Shoulder,
}

/// A ring of the flank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlankRing {
    /// Chart of the shoulder or of the side.
    pub chart: Chart,
    /// Meridian coordinate of the ring on this chart.
    pub meridian: f64,
    /// Area that it represents, per radian \[m^2\].
    pub area: f64,
}

/// Part of the shoulder that belongs to the flank.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shoulder {
    charts: [Chart; 2],
    /// Radius of the body at the shoulder's end, and radius of the shoulder \[m\].
    inner: f64,
    radius: f64,
    /// Angle at its end \[rad\].
    end: f64,
}

impl Shoulder {
    /// Area from the tread's edge to an angle, per radian \[m^2\].
    fn area(&self, angle: f64) -> f64 {
        self.radius * (self.inner * angle + self.radius * angle.sin())
    }

    /// Angle up to which the area from the tread's edge is `area`, by Newton's method.
    fn angle(&self, area: f64) -> f64 {
        let mut angle = self.end * area / self.area(self.end);
        for _ in 0..NEWTON_STEPS {
            let slope = self.radius * (self.inner + self.radius * angle.cos());
            angle -= (self.area(angle) - area) / slope;
        }
        angle
    }
}

/// Enough for the accuracy of rounding: the area is nearly proportional to the angle.
const NEWTON_STEPS: usize = 6;

impl Flank {
    /// Flank down to the radius of a bead \[m\]; `None` for a body that is no tyre, or whose bead is not below the
    /// tread.
    pub fn new(body: &RadiatingBody, bead: f64) -> Option<Self> {
        let BodyShape::Tyre { radius, shoulder, .. } = body.shape() else { return None };
        if !(bead > 0.0 && bead < radius) {
            return None;
        }
        let [_, round, side] = Chart::of_tyre(body)?;
        let inner = radius - shoulder;
        // A bead within the shoulder ends it.
        let end = if bead > inner { (1.0 - (radius - bead) / shoulder).acos() } else { FRAC_PI_2 };
        let shoulder = Shoulder { charts: [round, side], inner, radius: shoulder, end };
        let (round, flat) = (shoulder.area(end), flat(inner, bead));
        Some(Self { bead, rule: SplitRule::new(round / (round + flat)), shoulder })
    }

    /// Rings of the flank, from the tread to the bead.
    pub fn rings(&self) -> [FlankRing; SplitRule::POINTS] {
        let Shoulder { charts: [round, side], inner, end, .. } = self.shoulder;
        let shoulder = self.shoulder.area(end);
        let all = shoulder + flat(inner, self.bead);
        std::array::from_fn(|place| {
            let (passed, area) = (all * self.rule.points[place], all * self.rule.weights[place]);
            if place < SplitRule::FIRST {
                let meridian = if shoulder > 0.0 { self.shoulder.angle(passed) } else { 0.0 };
                return FlankRing { chart: round, meridian, area };
            }
            let meridian = (inner * inner - 2.0 * (passed - shoulder)).sqrt();
            FlankRing { chart: side, meridian, area }
        })
    }
}

/// Area of a flat side between two radii, per radian \[m^2\]; 0 if the inner radius is the larger one.
fn flat(outer: f64, inner: f64) -> f64 {
    0.5 * (outer * outer - inner * inner).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_represent_all_of_the_flanks_area() {
        let shape = |shoulder| BodyShape::Tyre { radius: 0.31, width: 0.176, shoulder };
        for (shoulder, bead) in [(0.02, 0.193), (0.0, 0.193), (0.08, 0.26)] {
            let body = RadiatingBody::new(shape(shoulder), Some(0.305)).unwrap();
            let flank = Flank::new(&body, bead).unwrap();
            // Numerically, by points of its meridian.
            let end: f64 = if bead > 0.31 - shoulder { (1.0 - (0.31 - bead) / shoulder).acos() } else { FRAC_PI_2 };
            let [_, round, side] = Chart::of_tyre(&body).unwrap();
            let sum = |chart: Chart, from: f64, to: f64| {
                let middle = |index: usize| from + (to - from) * (index as f64 + 0.5) / 2000.0;
                (0..2000).map(|index| chart.point(middle(index), 1.0).area).sum::<f64>() * (to - from).abs() / 2000.0
            };
            let (arc, rim) = (sum(round, 0.0, end), 0.31 - shoulder * (1.0 - end.cos()));
            let all = arc + sum(side, rim, bead);
            let found: f64 = flank.rings().iter().map(|ring| ring.area).sum();
            assert!((found - all).abs() < 1e-6 * all, "{shoulder}, {bead}: {found} {all}");
            let stand_for_some = flank.rings().into_iter().zip(flank.rule.points).filter(|(ring, _)| ring.area > 0.0);
            for (ring, passed) in stand_for_some {
                let before = match ring.chart {
                    Chart::Shoulder { .. } => sum(round, 0.0, ring.meridian),
                    _ => arc + sum(side, rim, ring.meridian),
                };
                assert!((before - passed * all).abs() < 1e-6 * all, "{shoulder}, {bead}: {ring:?}");
            }
        }
        assert_eq!(Flank::new(&RadiatingBody::new(BodyShape::Sphere { radius: 1.0 }, None).unwrap(), 0.2), None);
        assert_eq!(Flank::new(&RadiatingBody::new(shape(0.02), None).unwrap(), 0.4), None);
    }
}
