//! Near and self integrals: a patch against a target that is close to it or on it.
//!
//! 1. Near: the patch is halved along its longer side, and each part again, until each part's side is at most the
//!    distance from the target to it (true distance, the mirror bodies' and the road's image targets alike); each part
//!    gets (p + 2)^2 Gauss points, at which the patch's Lagrange polynomials are the interpolation. The parts of a
//!    patch are made once and serve every target.
//! 2. Self: the node cuts its patch into four rectangles; of each a corner of nearly equal sides is split in two
//!    triangles under Duffy's map (M. G. Duffy, SIAM J. Numer. Anal. 19 (1982) 1260-1262), whose Jacobian removes 1/R;
//!    what remains of a long rectangle is doubled outwards in plain Gauss parts.

use std::f64::consts::PI;

use num_complex::Complex64;
use pulp::Arch;

use super::chart::SurfacePoint;
use super::elements::{ElementBasis, SurfacePatch, distance, padded};
use super::kernel::{Coordinates, Layer, NearCell};

/// Largest ratio of a part's side to its distance from the target at which it is no longer halved.
const SIDE_TO_DISTANCE: f64 = 1.0;

/// Parts smaller than this, relative to the patch, are not halved: ends the halving for a target on a patch's edge.
const SMALLEST: f64 = 1e-6;

/// Longest side over the shorter of a rectangle under Duffy's map.
const MOST_SLENDER: f64 = 1.5;

/// Quadrature points in the kernel's form.
#[derive(Clone, Debug, Default)]
struct Points {
    at: Coordinates,
    /// Normals times weight/(4 pi), or for the single layer the weights/(4 pi) in x.
    normals: Coordinates,
}

impl Points {
    fn with_capacity(count: usize) -> Self {
        let list = || Vec::with_capacity(padded(count));
        let coordinates = || Coordinates { x: list(), y: list(), z: list() };
        Self { at: coordinates(), normals: coordinates() }
    }

    fn push(&mut self, layer: Layer, point: &SurfacePoint, weight: f64) {
        let weight = weight * point.area / (4.0 * PI);
        let [x, y, z] = point.position;
        self.at.push(x, y, z);
        match layer {
            Layer::Double => {
                let [x, y, z] = point.normal;
                self.normals.push(x * weight, y * weight, z * weight);
            }
            Layer::Single => self.normals.push(weight, 0.0, 0.0),
        }
    }

    /// Fills the last vector with points of no weight.
    fn fill(&mut self) {
        let (x, y, z) = (self.at.x[0], self.at.y[0], self.at.z[0]);
        while self.at.x.len() < padded(self.at.x.len()) {
            self.at.push(x, y, z);
            self.normals.push(0.0, 0.0, 0.0);
        }
    }

    fn clear(&mut self) {
        for list in [&mut self.at, &mut self.normals] {
            list.x.clear();
            list.y.clear();
            list.z.clear();
        }
    }
}

/// A part of a patch.
#[derive(Clone, Debug)]
struct Cell {
    range: [[f64; 2]; 2],
    points: Points,
    /// Lagrange polynomials at the Gauss points of each side, point by point.
    lagrange: [Vec<f64>; 2],
    /// Positions of corners, middles of sides, middle.
    samples: [[f64; 3]; 9],
    sides: [f64; 2],
    children: Option<[usize; 2]>,
}

/// Amount of work of the near integrals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct NearWork {
    /// Pairs of a target (or its mirror, or its image) and a patch.
    pub pairs: u64,
    /// Kernel evaluations.
    pub evaluations: u64,
}

/// Near and self integrals of one patch, with their buffers.
#[derive(Debug)]
pub(crate) struct NearPatch<'a> {
    patch: &'a SurfacePatch,
    basis: &'a ElementBasis,
    layer: Layer,
    wavenumber: f64,
    rule: ElementBasis,
    cells: Vec<Cell>,
    work: NearWork,
    re: Vec<f64>,
    im: Vec<f64>,
    stack: Vec<usize>,
    single: Points,
    local: Vec<[f64; 2]>,
    values: [Vec<f64>; 2],
}

impl<'a> NearPatch<'a> {
    /// For a patch with its elements' basis and a kernel at a wavenumber \[rad/m\].
    pub(crate) fn new(patch: &'a SurfacePatch, basis: &'a ElementBasis, layer: Layer, wavenumber: f64) -> Self {
        let rule = ElementBasis::new(basis.order() + EXTRA_POINTS);
        let mut this = Self {
            patch,
            basis,
            layer,
            wavenumber,
            rule,
            cells: Vec::new(),
            work: NearWork::default(),
            re: Vec::new(),
            im: Vec::new(),
            stack: Vec::new(),
            single: Points::default(),
            local: Vec::new(),
            values: [vec![0.0; basis.order()], vec![0.0; basis.order()]],
        };
        let root = this.cell([[-1.0, 1.0]; 2]);
        this.cells.push(root);
        this
    }

    pub(crate) fn work(&self) -> NearWork {
        self.work
    }

    fn cell(&self, range: [[f64; 2]; 2]) -> Cell {
        let order = self.basis.order();
        let middle = range.map(|[from, to]| 0.5 * (from + to));
        let half = range.map(|[from, to]| 0.5 * (to - from));
        let mut points = Points::with_capacity(self.rule.order() * self.rule.order());
        for (u, w) in self.rule.nodes.iter().zip(&self.rule.weights) {
            for (v, z) in self.rule.nodes.iter().zip(&self.rule.weights) {
                let at = [middle[0] + half[0] * u, middle[1] + half[1] * v];
                points.push(self.layer, &self.patch.point(at), w * z * half[0] * half[1]);
            }
        }
        points.fill();
        let lagrange = [0, 1].map(|side| {
            let mut values = vec![0.0; self.rule.order() * order];
            for (node, row) in self.rule.nodes.iter().zip(values.chunks_exact_mut(order)) {
                self.basis.values(middle[side] + half[side] * node, row);
            }
            values
        });
        let samples = std::array::from_fn(|index| {
            let steps = [index / 3, index % 3].map(|step| step as f64 - 1.0);
            self.patch.point([middle[0] + half[0] * steps[0], middle[1] + half[1] * steps[1]]).position
        });
        let length = |a: usize, b: usize, c: usize| distance(samples[a], samples[b]) + distance(samples[b], samples[c]);
        let along = f64::max(length(0, 3, 6), f64::max(length(1, 4, 7), length(2, 5, 8)));
        let across = f64::max(length(0, 1, 2), f64::max(length(3, 4, 5), length(6, 7, 8)));
        Cell { range, points, lagrange, samples, sides: [along, across], children: None }
    }

    fn halve(&mut self, index: usize) -> [usize; 2] {
        if let Some(children) = self.cells[index].children {
            return children;
        }
        let Cell { range, sides, .. } = &self.cells[index];
        let side = usize::from(sides[1] > sides[0]);
        let [from, to] = range[side];
        let cut = 0.5 * (from + to);
        let (mut lower, mut upper) = (*range, *range);
        lower[side] = [from, cut];
        upper[side] = [cut, to];
        let parts = [self.cell(lower), self.cell(upper)];
        let children = [self.cells.len(), self.cells.len() + 1];
        self.cells.extend(parts);
        self.cells[index].children = Some(children);
        children
    }

    /// Adds the integrals of the kernel times each of the patch's polynomials to `sums`; the target is not within the
    /// patch (on its edge it may be).
    pub(crate) fn near(&mut self, arch: Arch, target: [f64; 3], sums: &mut [Complex64]) {
        self.work.pairs += 1;
        let smallest = SMALLEST * self.cells[0].sides[0].max(self.cells[0].sides[1]);
        let mut stack = std::mem::take(&mut self.stack);
        stack.push(0);
        while let Some(index) = stack.pop() {
            let cell = &self.cells[index];
            let nearest = cell.samples.iter().map(|&at| distance(at, target)).fold(f64::INFINITY, f64::min);
            let side = cell.sides[0].max(cell.sides[1]);
            if side > SIDE_TO_DISTANCE * nearest && side > smallest {
                stack.extend(self.halve(index));
            } else {
                self.add_cell(arch, index, target, sums);
            }
        }
        self.stack = stack;
    }

    fn add_cell(&mut self, arch: Arch, index: usize, target: [f64; 3], sums: &mut [Complex64]) {
        let Self { cells, re, im, rule, basis, layer, wavenumber, .. } = self;
        let (count, order) = (rule.order(), basis.order());
        let Cell { points, lagrange, .. } = &cells[index];
        self.work.evaluations += (count * count) as u64;
        evaluate(arch, points, target, *wavenumber, *layer, re, im);
        let mut partial = [Complex64::ZERO; MOST_ORDER];
        for i in 0..count {
            partial[..order].fill(Complex64::ZERO);
            for j in 0..count {
                let value = Complex64::new(re[i * count + j], im[i * count + j]);
                for (sum, weight) in partial.iter_mut().zip(&lagrange[1][j * order..(j + 1) * order]) {
                    *sum += value * weight;
                }
            }
            for (row, weight) in sums.chunks_exact_mut(order).zip(&lagrange[0][i * order..(i + 1) * order]) {
                for (sum, part) in row.iter_mut().zip(&partial) {
                    *sum += part * weight;
                }
            }
        }
    }

    /// Adds the same for a target at local coordinates within the patch.
    pub(crate) fn on_patch(&mut self, arch: Arch, [u, v]: [f64; 2], sums: &mut [Complex64]) {
        self.work.pairs += 1;
        let mut points = std::mem::take(&mut self.single);
        points.clear();
        self.local.clear();
        let target = self.patch.point([u, v]).position;
        for far in [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]] {
            self.corner(&mut points, [u, v], far, target);
        }
        points.fill();
        let order = self.basis.order();
        self.work.evaluations += self.local.len() as u64;
        evaluate(arch, &points, target, self.wavenumber, self.layer, &mut self.re, &mut self.im);
        let [first, second] = &mut self.values;
        for ((&[u, v], &re), &im) in self.local.iter().zip(&self.re).zip(&self.im) {
            self.basis.values(u, first);
            self.basis.values(v, second);
            let value = Complex64::new(re, im);
            for (row, weight) in sums.chunks_exact_mut(order).zip(first.iter()) {
                let weighted = value * weight;
                for (sum, other) in row.iter_mut().zip(second.iter()) {
                    *sum += weighted * other;
                }
            }
        }
        self.single = points;
    }

    /// Adds the points of the rectangle between the target at `from` and the patch's corner `to`.
    fn corner(&mut self, points: &mut Points, from: [f64; 2], to: [f64; 2], target: [f64; 3]) {
        let spans = [to[0] - from[0], to[1] - from[1]];
        if spans.iter().any(|span| span.abs() < f64::EPSILON) {
            return;
        }
        let lengths = [
            distance(self.patch.point([to[0], from[1]]).position, target),
            distance(self.patch.point([from[0], to[1]]).position, target),
        ];
        let long = usize::from(lengths[1] > lengths[0]);
        let ratio = lengths[1 - long] / lengths[long] * MOST_SLENDER;
        let mut reach = ratio.min(1.0);
        let mut spans_near = spans;
        spans_near[long] *= reach;
        // 1. The corner with sides in the ratio MOST_SLENDER at most: two triangles under Duffy's map.
        let rule = self.unit_rule();
        for side in 0..2 {
            for &[s, ws] in &rule {
                for &[t, wt] in &rule {
                    let mut at = from;
                    at[side] += spans_near[side] * s;
                    at[1 - side] += spans_near[1 - side] * s * t;
                    let weight = ws * wt * s * (spans_near[0] * spans_near[1]).abs();
                    points.push(self.layer, &self.patch.point(at), weight);
                    self.local.push(at);
                }
            }
        }
        // 2. The rest of a long rectangle, doubling outwards.
        while reach < 1.0 {
            let next = (2.0 * reach).min(1.0);
            for &[s, ws] in &rule {
                for &[t, wt] in &rule {
                    let mut at = from;
                    at[long] += spans[long] * (reach + (next - reach) * s);
                    at[1 - long] += spans[1 - long] * t;
                    let weight = ws * wt * (next - reach) * (spans[0] * spans[1]).abs();
                    points.push(self.layer, &self.patch.point(at), weight);
                    self.local.push(at);
                }
            }
            reach = next;
        }
    }

    /// Nodes and weights of the near rule on (0, 1).
    fn unit_rule(&self) -> Vec<[f64; 2]> {
        self.rule
            .nodes
            .iter()
            .zip(&self.rule.weights)
            .map(|(node, weight)| [0.5 * (node + 1.0), 0.5 * weight])
            .collect()
    }
}

/// Points of a part along a side in addition to the element's order.
const EXTRA_POINTS: usize = 2;

/// Largest order of elements.
const MOST_ORDER: usize = 8;

fn evaluate(
    arch: Arch,
    points: &Points,
    target: [f64; 3],
    wavenumber: f64,
    layer: Layer,
    re: &mut Vec<f64>,
    im: &mut Vec<f64>,
) {
    let count = points.at.x.len();
    re.resize(count, 0.0);
    im.resize(count, 0.0);
    arch.dispatch(NearCell { points: &points.at, normals: &points.normals, target, wavenumber, layer, re, im });
}
