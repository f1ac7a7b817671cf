//! By how much a slice yields to its texture: p(F), the part of its displacement that the element as a whole does not
//! make.
//!
//! The local law (docs/theory.md 6.3) asks for G0 F + p(F) = y with p concave and increasing from p(0) = 0. For any
//! c > 0 it is S^-1(c F) - c F of the curve S through the points (p + c F, c F): S is convex with slopes in 0 to 1 just
//! where p is concave and increasing. So c is a unit of the curve, and no result depends on it.
//!
//! Pressing gives p at some forces, nearly concave: neighbours that begin to carry may relieve a slice. Taken is the
//! least concave increasing curve above the points; how far it is above any of them is its error.

use serde::{Deserialize, Serialize};

use crate::road::slices::StiffnessCurve;

/// Steepest rise of a curve in units of the tread's compliance: a slice that its neighbours hold off begins to carry
/// there.
const STEEPEST: f64 = 1e3;
/// Least relative difference of two forces that count as different.
const CLOSEST: f64 = 1e-9;

/// Yielding of a slice.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(crate) struct Yielding {
    /// Height of the slice's highest point above z = 0, less the tread's crown there \[m\].
    pub peak: f64,
    /// Forces, increasing, all > 0 \[N\].
    pub forces: Vec<f64>,
    /// p at these forces \[m\].
    pub yields: Vec<f64>,
    /// Largest distance of p from the points that pressing gave \[m\].
    pub error: f64,
}

impl Yielding {
    /// Closest curve above `points` (force \[N\], p \[m\]), whose forces may come in any order. `spring` is the
    /// tread's compliance \[m/N\], a scale.
    pub(crate) fn above(peak: f64, points: &[[f64; 2]], spring: f64) -> Self {
        // 1. A rise that is too steep for a solver becomes a step.
        let points: Vec<[f64; 2]> =
            points.iter().map(|&[force, rise]| [force.max(rise / (STEEPEST * spring)), rise]).collect();
        let mut sorted = points.clone();
        sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        // 2. Upper hull, from the origin on.
        let mut hull = vec![[0.0, 0.0]];
        for point in sorted {
            let last = hull[hull.len() - 1];
            if point[0] <= last[0] * (1.0 + CLOSEST) {
                if hull.len() == 1 || point[1] <= last[1] {
                    continue;
                }
                hull.pop();
            }
            while let [.., a, b] = hull[..] {
                if (b[1] - a[1]) * (point[0] - a[0]) > (point[1] - a[1]) * (b[0] - a[0]) {
                    break;
                }
                hull.pop();
            }
            hull.push(point);
        }
        // 3. Past its highest point the curve stays level.
        let mut highest = 0.0_f64;
        for [_, rise] in &mut hull {
            highest = highest.max(*rise);
            *rise = highest;
        }
        let (forces, yields) = hull[1..].iter().map(|&[force, rise]| (force, rise)).unzip();
        let mut this = Self { peak, forces, yields, error: 0.0 };
        this.error = points.iter().map(|&[force, rise]| (this.at(force) - rise).abs()).fold(0.0, f64::max);
        this
    }

    /// A slice that no approach has reached, held off by its neighbours until p is `held` \[m\] at least: from there
    /// on it yields like the tread's spring.
    pub(crate) fn held_off(peak: f64, held: f64, spring: f64) -> Self {
        let held = held.max(1e-6);
        let first = held / (STEEPEST * spring);
        let second = first + held / spring;
        Self { peak, forces: vec![first, second], yields: vec![held, 2.0 * held], error: 0.0 }
    }

    /// dp/dF past the last force \[m/N\]: that of the last piece.
    fn last_slope(&self) -> f64 {
        let last = |values: &[f64]| match *values {
            [.., a, b] => b - a,
            [a] => a,
            [] => 0.0,
        };
        let step = last(&self.forces);
        if step > 0.0 { last(&self.yields) / step } else { 0.0 }
    }

    /// p at a force \[m\].
    pub(crate) fn at(&self, force: f64) -> f64 {
        let above = self.forces.partition_point(|&known| known < force);
        let point = |number: usize| (self.forces[number], self.yields[number]);
        let (from, rise) = above.checked_sub(1).map_or((0.0, 0.0), point);
        let slope = match self.forces.get(above) {
            Some(to) => (self.yields[above] - rise) / (to - from),
            None => self.last_slope(),
        };
        rise + slope * (force - from)
    }

    /// Curve of stiffness whose local law with the compliance `c` \[m/N\] has this p.
    ///
    /// Past the last point it has the slope of its last piece: 1 where p has ceased to grow, in full contact.
    pub(crate) fn curve(&self, c: f64) -> StiffnessCurve {
        let displacement = self.forces.iter().map(|force| c * force);
        let penetration = self.forces.iter().zip(&self.yields).map(|(force, rise)| rise + c * force);
        StiffnessCurve {
            peak: self.peak,
            penetration: penetration.collect(),
            displacement: displacement.collect(),
            final_slope: c / (c + self.last_slope()),
            // S changes by no more than the penetration does.
            error: self.error,
        }
    }

    /// True if the values make a curve: finite, increasing, not negative.
    pub(super) fn is_valid(&self) -> bool {
        let increasing = |values: &[f64]| values.windows(2).all(|pair| pair[0] <= pair[1]);
        self.forces.len() == self.yields.len()
            && self.peak.is_finite()
            && self.forces.iter().chain(&self.yields).all(|value| value.is_finite() && *value >= 0.0)
            && increasing(&self.forces)
            && increasing(&self.yields)
    }
}
