//! Polynomials across the thickness of a curved layer, and the integrals of their products.
//!
//! On r = a ... b: two linear functions, each 1 on one face and 0 on the other, then (1 - x^2) q_j(x), x in (-1, 1),
//! which vanish on both and are orthonormal under the weight r (Stieltjes' recurrence on Gauss nodes).

use faer::Mat;

use crate::numeric::legendre::gauss;

/// Nodes beyond the degree: enough to integrate 1/r, which is smooth, to rounding.
const SPARE_NODES: usize = 6;

/// Integrals over r of products f_a g_b of the polynomials; rows a, columns b: the inner face, the outer face,
/// interior ones.
#[derive(Clone, Debug)]
pub(super) struct RadialProducts {
    /// f' g' r.
    pub slopes: Mat<f64>,
    /// f' g and f g'.
    pub slope_value: Mat<f64>,
    pub value_slope: Mat<f64>,
    /// f' g r and f g' r.
    pub slope_value_r: Mat<f64>,
    pub value_slope_r: Mat<f64>,
    /// f g/r.
    pub values_over_r: Mat<f64>,
    /// f g.
    pub values: Mat<f64>,
    /// f g r; the identity for interior ones.
    pub values_r: Mat<f64>,
}

impl RadialProducts {
    /// Bytes of the products of all degrees up to one: eight matrices each.
    pub(super) const fn bytes(highest: usize) -> f64 {
        let sizes = (highest + 1) * (highest + 2) * (2 * highest + 3) / 6;
        8.0 * 8.0 * sizes as f64
    }

    /// Polynomials up to a degree, at least 2, on a layer of a thickness \[m\] from the radius `from` \[m\] on.
    pub(super) fn new(from: f64, thickness: f64, degree: usize) -> Self {
        let rule = gauss(degree + SPARE_NODES);
        let half = 0.5 * thickness;
        let nodes = rule.len();
        let radius: Vec<f64> = rule.iter().map(|[x, _]| from + half * (1.0 + x)).collect();
        let weight: Vec<f64> = rule.iter().map(|[_, weight]| half * weight).collect();
        // 1. Values at the nodes and slopes by r of the two linear functions.
        let mut values = Mat::zeros(nodes, degree + 1);
        let mut slopes = Mat::zeros(nodes, degree + 1);
        for (i, [x, _]) in rule.iter().enumerate() {
            (values[(i, 0)], values[(i, 1)]) = (0.5 * (1.0 - x), 0.5 * (1.0 + x));
            (slopes[(i, 0)], slopes[(i, 1)]) = (-0.5 / half, 0.5 / half);
        }
        // 2. The others by Stieltjes' recurrence: q_j orthonormal under (1 - x^2)^2 r, values and slopes side by side.
        let measure = |i: usize| weight[i] * radius[i] * (1.0 - rule[i][0].powi(2)).powi(2);
        let (mut q, mut q_slope) = (vec![1.0; nodes], vec![0.0; nodes]);
        let (mut before, mut before_slope, mut beta) = (vec![0.0; nodes], vec![0.0; nodes], 0.0);
        for j in 0..=degree - 2 {
            let norm = (0..nodes).map(|i| measure(i) * q[i] * q[i]).sum::<f64>().sqrt();
            q.iter_mut().chain(&mut q_slope).for_each(|value| *value /= norm);
            if j > 0 {
                beta = norm;
            }
            for (i, [x, _]) in rule.iter().enumerate() {
                values[(i, j + 2)] = (1.0 - x * x) * q[i];
                slopes[(i, j + 2)] = ((1.0 - x * x) * q_slope[i] - 2.0 * x * q[i]) / half;
            }
            let alpha: f64 = (0..nodes).map(|i| measure(i) * rule[i][0] * q[i] * q[i]).sum();
            for (i, [x, _]) in rule.iter().enumerate() {
                let next = (x - alpha) * q[i] - beta * before[i];
                let next_slope = q[i] + (x - alpha) * q_slope[i] - beta * before_slope[i];
                (before[i], before_slope[i]) = (q[i], q_slope[i]);
                (q[i], q_slope[i]) = (next, next_slope);
            }
        }
        // 3. Products by quadrature.
        let product = |f: &Mat<f64>, g: &Mat<f64>, power: i32| {
            let weighted = Mat::from_fn(nodes, degree + 1, |i, b| weight[i] * radius[i].powi(power) * g[(i, b)]);
            f.transpose() * weighted
        };
        Self {
            slopes: product(&slopes, &slopes, 1),
            slope_value: product(&slopes, &values, 0),
            value_slope: product(&values, &slopes, 0),
            slope_value_r: product(&slopes, &values, 1),
            value_slope_r: product(&values, &slopes, 1),
            values_over_r: product(&values, &values, -1),
            values: product(&values, &values, 0),
            values_r: product(&values, &values, 1),
        }
    }
}
