//! Elements: p x p Gauss nodes on an exactly mapped patch, not connected with their neighbours.
//!
//! The unknown pressure is a polynomial of degree p - 1 in each of the patch's two coordinates on (-1, 1), through its
//! values at the Gauss nodes; the nodes' weights are also the quadrature of pairs that are far apart. Nodes lie inside
//! their patch, so every node sees a smooth surface, and patches need not meet corner to corner.

use super::body::Vector;
use super::chart::{Chart, SurfacePoint};
use crate::numeric::legendre::gauss;

/// Bending of one side of a patch's rectangle of parameters by the road's cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cut {
    /// None: the ranges are the chart's parameters.
    None,
    /// `turn` is a fraction from the cut's angle at this meridian (0) to `end` (1).
    Turn {
        /// Angle at fraction 1.
        end: f64,
    },
    /// `meridian` is a fraction from the cut's parameter at this angle (0) to `end` (1).
    Meridian {
        /// Meridian parameter at fraction 1.
        end: f64,
    },
}

/// A patch: a rectangle of parameters of a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePatch {
    /// Surface of which it is a part.
    pub chart: Chart,
    /// Range of the meridian parameter, or of the fraction that replaces it.
    pub meridian: [f64; 2],
    /// Range of the angle, or of the fraction that replaces it.
    pub turn: [f64; 2],
    /// Side along the road, if it is bent.
    pub cut: Cut,
}

impl SurfacePatch {
    /// Local coordinates in (-1, 1)^2 of a point of its chart; `None` outside of the patch.
    pub fn local(&self, meridian: f64, turn: f64) -> Option<[f64; 2]> {
        let at = match self.cut {
            Cut::None => [meridian, turn],
            Cut::Turn { end } => {
                let start = self.chart.cut_turn(meridian);
                [meridian, (turn - start) / (end - start)]
            }
            Cut::Meridian { end } => {
                let start = self.chart.cut_meridian(turn);
                [(meridian - start) / (end - start), turn]
            }
        };
        let ranges = [self.meridian, self.turn];
        let within = |([from, to], at): (&[f64; 2], f64)| from.min(*to) <= at && at <= from.max(*to);
        let local = |place: usize| {
            (2.0 * at[place] - ranges[place][0] - ranges[place][1]) / (ranges[place][1] - ranges[place][0])
        };
        ranges.iter().zip(at).all(within).then(|| [local(0), local(1)])
    }

    /// Point at local coordinates in (-1, 1)^2; `area` is per unit of these.
    pub fn point(&self, [u, v]: [f64; 2]) -> SurfacePoint {
        let between = |[from, to]: [f64; 2], at: f64| 0.5 * ((to + from) + (to - from) * at);
        let (m, t) = (between(self.meridian, u), between(self.turn, v));
        let stretch = 0.25 * (self.meridian[1] - self.meridian[0]).abs() * (self.turn[1] - self.turn[0]).abs();
        let (m, t, bend) = match self.cut {
            Cut::None => (m, t, 1.0),
            Cut::Turn { end } => {
                let start = self.chart.cut_turn(m);
                (m, start + t * (end - start), (end - start).abs())
            }
            Cut::Meridian { end } => {
                let start = self.chart.cut_meridian(t);
                (start + m * (end - start), t, (end - start).abs())
            }
        };
        let mut point = self.chart.point(m, t);
        point.area *= stretch * bend;
        point
    }
}

/// Nodes, weights and Lagrange polynomials of p Gauss points on (-1, 1).
#[derive(Clone, Debug)]
pub struct ElementBasis {
    /// Gauss points on (-1, 1), rising.
    pub nodes: Vec<f64>,
    /// Quadrature weights of the nodes; they sum to 2.
    pub weights: Vec<f64>,
    barycentric: Vec<f64>,
}

impl ElementBasis {
    /// Basis of `order` points.
    pub fn new(order: usize) -> Self {
        let mut rule = gauss(order);
        rule.reverse();
        let nodes: Vec<f64> = rule.iter().map(|[x, _]| *x).collect();
        let barycentric = (0..order)
            .map(|i| (0..order).filter(|&j| j != i).map(|j| nodes[i] - nodes[j]).product::<f64>().recip())
            .collect();
        Self { weights: rule.iter().map(|[_, w]| *w).collect(), nodes, barycentric }
    }

    /// Number of points.
    pub fn order(&self) -> usize {
        self.nodes.len()
    }

    /// Values of the Lagrange polynomials at a point of (-1, 1), into `values`.
    pub fn values(&self, at: f64, values: &mut [f64]) {
        for (i, value) in values.iter_mut().enumerate() {
            *value = self.barycentric[i];
            for (j, node) in self.nodes.iter().enumerate() {
                if j != i {
                    *value *= at - node;
                }
            }
        }
    }
}

/// A number rounded up to whole vectors.
pub(crate) fn padded(count: usize) -> usize {
    count.next_multiple_of(crate::numeric::MOST_LANES)
}

/// A boundary mesh: the quarter x >= 0, y >= 0 of a body.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Patches, not connected with each other.
    pub patches: Vec<SurfacePatch>,
    /// Nodes and weights along a side.
    pub basis: ElementBasis,
    /// Points of all nodes, patch by patch, the second coordinate running fastest; `area` includes the weight.
    pub nodes: Vec<SurfacePoint>,
    /// Bounding ball of each patch: middle and radius \[m\].
    pub balls: Vec<(Vector, f64)>,
    /// True if the road's image is part of the problem.
    pub on_road: bool,
}

impl Mesh {
    /// Places `order` x `order` nodes on each patch.
    pub fn new(patches: Vec<SurfacePatch>, order: usize, on_road: bool) -> Self {
        let basis = ElementBasis::new(order);
        let mut nodes = Vec::with_capacity(patches.len() * order * order);
        for patch in &patches {
            for (&u, &weight) in basis.nodes.iter().zip(&basis.weights) {
                for (&v, &other) in basis.nodes.iter().zip(&basis.weights) {
                    let mut point = patch.point([u, v]);
                    point.area *= weight * other;
                    nodes.push(point);
                }
            }
        }
        let balls = patches.iter().map(ball).collect();
        Self { patches, basis, nodes, balls, on_road }
    }

    /// Number of nodes of one patch.
    pub fn nodes_per_patch(&self) -> usize {
        self.basis.order() * self.basis.order()
    }

    /// Number of unknowns of a block: nodes of the quarter.
    pub fn unknowns(&self) -> usize {
        self.nodes.len()
    }
}

/// Points along each side of a patch that its ball is taken around.
const SAMPLES: usize = 5;

fn ball(patch: &SurfacePatch) -> (Vector, f64) {
    let middle = patch.point([0.0, 0.0]).position;
    let mut radius: f64 = 0.0;
    for i in 0..SAMPLES {
        for j in 0..SAMPLES {
            let at = [i, j].map(|index| 2.0 * index as f64 / (SAMPLES - 1) as f64 - 1.0);
            radius = radius.max(distance(patch.point(at).position, middle));
        }
    }
    (middle, radius)
}

pub(crate) fn distance(a: Vector, b: Vector) -> f64 {
    ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}
