//! Volume that a sidewall sweeps, piece by piece, for the sound of a body beside it.
//!
//! A point of the arc is given by how far it has turned from the belt's edge, x = (a_b - a)/(a_b - a_0), 0 at the belt
//! and 1 at the bead; at rest that is the fraction of the area passed, since a' = p R/C. With polynomials l_k(x) that
//! add up to 1 ([`SplitRule`]) the pieces are, since t' = -ka u,
//!
//! ```text
//! Q_k = int l_k u R dz = -int l_k (R/ka) t' dz        [m^3 per radian and motion of the edge]
//! ```
//!
//! Within a step t is approximated by the cubic Hermite polynomial, which has the values of t and t' at both ends of
//! the step. So Q_k is a sum over t and u at the ends of the steps, with weights that are equal for all waves. At rest
//! R/ka = C/p is constant, and the pieces together are exactly the -R_b N_b cos(a_b) w/p of the whole.

use super::meridian::{Meridian, MeridianPoint};
use crate::numeric::{SplitRule, legendre};

/// Weights of t and u at the end of a step, for each piece.
pub(super) type Weights = [[f64; 2]; SplitRule::POINTS];

/// Points of the quadrature within a step, or on either side of the split in it.
const POINTS: usize = 6;

/// Weights at the ends of so many equal steps, the bead excepted.
pub(super) fn weights(meridian: &Meridian, rule: &SplitRule, steps: usize) -> Vec<Weights> {
    let (length, [bead, belt]) = (meridian.length(), [meridian.edge().bead_angle, meridian.edge().angle]);
    let step = length / steps as f64;
    let turned = |angle: f64| ((belt - angle) / (belt - bead)).clamp(0.0, 1.0);
    let gauss = legendre::gauss(POINTS);
    let between = split_place(meridian, rule.split);
    let mut along = meridian.along();
    let mut sums: Vec<Weights> = vec![[[0.0; 2]; SplitRule::POINTS]; steps + 1];
    let (_, mut begin) = along(0.0);
    for index in 0..steps {
        // 1. Gauss points of the step, in two parts where the split lies within it: the polynomials jump there.
        let [from, to] = [index as f64, index as f64 + 1.0].map(|place| place * step);
        let cut = between.clamp(from, to);
        let parts = [[from, cut], [cut, to]].into_iter().filter(|[from, to]| to > from);
        let nodes: Vec<(f64, f64, f64, MeridianPoint)> = parts
            .flat_map(|[from, to]| {
                // Rising along the arc.
                let rule = gauss
                    .iter()
                    .rev()
                    .map(move |[node, weight]| (0.5 * ((from + to) + (to - from) * node), 0.5 * (to - from) * weight));
                rule.collect::<Vec<_>>()
            })
            .map(|(z, weight)| {
                let (angle, point) = along(z);
                (z, weight, angle, point)
            })
            .collect();
        let (_, end) = along(to);
        // 2. The integral by t and u at both ends of the step.
        for (z, weight, angle, point) in nodes {
            let x = (z - from) / step;
            // Slopes of the cubic by t at both ends, and by its slopes -ka u there.
            let by_t = 6.0 * x * (x - 1.0) / step;
            let by_slope = [(3.0 * x - 1.0) * (x - 1.0), x * (3.0 * x - 2.0)];
            let flow = weight * point.radius / point.curvature;
            for (k, value) in rule.polynomials(turned(angle)).into_iter().enumerate() {
                let flow = flow * value;
                let [[before, after], ends] = [[by_t, -by_t], [begin.curvature, end.curvature]];
                sums[index][k][0] -= flow * before;
                sums[index + 1][k][0] -= flow * after;
                sums[index][k][1] += flow * ends[0] * by_slope[0];
                sums[index + 1][k][1] += flow * ends[1] * by_slope[1];
            }
        }
        begin = end;
    }
    // At the bead t = u = 0.
    sums.remove(0);
    sums
}

/// z at which the arc has turned by the fraction `part` of its angle from the belt's edge \[m\].
fn split_place(meridian: &Meridian, part: f64) -> f64 {
    let (length, [bead, belt]) = (meridian.length(), [meridian.edge().bead_angle, meridian.edge().angle]);
    let wanted = belt - part * (belt - bead);
    let mut z = (1.0 - part) * length;
    for _ in 0..NEWTON_STEPS {
        let (angle, point) = meridian.along()(z);
        z = (z - (angle - wanted) / point.curvature).clamp(0.0, length);
    }
    z
}

/// Steps of Newton's method that reach rounding: the angle is nearly proportional to z.
const NEWTON_STEPS: usize = 6;
