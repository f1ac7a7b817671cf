//! Columns of the boundary integral operators: one patch against all targets, by parity.
//!
//! 1. Pairs of a target's mirror (or its image in the road) and the patch that are closer than `FAR` times the patch's
//!    size are near: the near integrals add to all of the patch's columns.
//! 2. Every node of the patch against all targets in vector lanes, near pairs left out ([`super::kernel`]).

use num_complex::Complex64;

use super::body::Vector;
use super::chart::Chart;
use super::elements::{Mesh, SurfacePatch, distance, padded};
use super::kernel::{Coordinates, FarColumn, Layer, arch};
use super::near::NearPatch;
use super::parity::{MIRRORS, ParityBlock, mirrored};

/// Distance to a patch's bounding ball over the ball's radius up to which its integrals are near ones.
pub(crate) const FAR: f64 = 1.2;

/// Place of a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    /// On a patch, at these local coordinates.
    Patch(usize, [f64; 2]),
    /// Elsewhere, on the surface or off it.
    Free,
}

/// Points at which the operators are evaluated, filled up to whole vectors.
#[derive(Clone, Debug, Default)]
pub(crate) struct Targets {
    coordinates: Coordinates,
    places: Vec<Place>,
}

impl Targets {
    /// All nodes of a mesh, then other points.
    pub(crate) fn nodes_and(mesh: &Mesh, others: &[Vector]) -> Self {
        let mut this = Self::default();
        let (nodes, order) = (mesh.nodes_per_patch(), mesh.basis.order());
        for (index, node) in mesh.nodes.iter().enumerate() {
            let local = [(index % nodes) / order, index % order].map(|place| mesh.basis.nodes[place]);
            this.push(node.position, Place::Patch(index / nodes, local));
        }
        for &point in others {
            this.push(point, Place::Free);
        }
        this.fill();
        this
    }

    /// Points that are no nodes.
    pub(crate) fn points(points: &[Vector]) -> Self {
        let mut this = Self::default();
        for &point in points {
            this.push(point, Place::Free);
        }
        this.fill();
        this
    }

    /// Points of a body's surface in the quarter, each a chart and its two parameters; a point that no patch holds is a
    /// free one.
    pub(crate) fn on_surface(mesh: &Mesh, points: &[(Chart, [f64; 2])]) -> Self {
        let mut this = Self::default();
        for &(chart, [meridian, turn]) in points {
            let of_patch = |(index, patch): (usize, &SurfacePatch)| {
                let local = Some(patch).filter(|patch| patch.chart == chart)?.local(meridian, turn)?;
                Some(Place::Patch(index, local))
            };
            let place = mesh.patches.iter().enumerate().find_map(of_patch).unwrap_or(Place::Free);
            this.push(chart.point(meridian, turn).position, place);
        }
        this.fill();
        this
    }

    fn push(&mut self, [x, y, z]: Vector, place: Place) {
        self.coordinates.push(x, y, z);
        self.places.push(place);
    }

    fn fill(&mut self) {
        // Far away: a filling target has no near pairs, and its values are not read.
        while self.coordinates.x.len() < padded(self.places.len()) {
            self.coordinates.push(1e6, 1e6, 1e6);
        }
    }

    /// Number of targets, without those that fill the last vector.
    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }

    pub(crate) fn position(&self, index: usize) -> Vector {
        [self.coordinates.x[index], self.coordinates.y[index], self.coordinates.z[index]]
    }
}

/// Amount of work of an assembly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AssemblyWork {
    /// Kernel evaluations of far pairs.
    pub far_evaluations: u64,
    /// Pairs of a target, a mirror or an image of one, with a patch, integrated as near.
    pub near_pairs: u64,
    /// Kernel evaluations of the near pairs.
    pub near_evaluations: u64,
}

impl AssemblyWork {
    /// Adds the work of another assembly.
    pub fn add(&mut self, other: &Self) {
        self.far_evaluations += other.far_evaluations;
        self.near_pairs += other.near_pairs;
        self.near_evaluations += other.near_evaluations;
    }
}

/// Columns of one patch: for each block `nodes_per_patch` columns of real parts and of imaginary parts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Panel {
    rows: usize,
    blocks: Vec<(ParityBlock, Vec<f64>, Vec<f64>)>,
    far: Vec<f64>,
}

impl Panel {
    pub(crate) fn new(blocks: &[ParityBlock]) -> Self {
        Self { rows: 0, blocks: blocks.iter().map(|&block| (block, Vec::new(), Vec::new())).collect(), far: Vec::new() }
    }

    /// Entry of a block (by its index in the list) for a node of the patch and a target.
    pub(crate) fn at(&self, block: usize, node: usize, target: usize) -> Complex64 {
        let (_, re, im) = &self.blocks[block];
        Complex64::new(re[node * self.rows + target], im[node * self.rows + target])
    }

    /// Integrates a kernel over a patch.
    pub(crate) fn fill(
        &mut self,
        mesh: &Mesh,
        patch: usize,
        targets: &Targets,
        wavenumber: f64,
        layer: Layer,
    ) -> AssemblyWork {
        let arch = arch();
        let (rows, nodes) = (targets.coordinates.x.len(), mesh.nodes_per_patch());
        let images = if mesh.on_road { 2 * MIRRORS } else { MIRRORS };
        self.rows = rows;
        for (_, re, im) in &mut self.blocks {
            re.resize(rows * nodes, 0.0);
            im.resize(rows * nodes, 0.0);
        }
        self.far.clear();
        self.far.resize(2 * MIRRORS * rows, 1.0);
        // 1. Near pairs are excluded from the far columns.
        let (middle, radius) = mesh.balls[patch];
        let mut pairs = Vec::new();
        for target in 0..targets.len() {
            let position = targets.position(target);
            for mirror in 0..images {
                if distance(mirrored(position, mirror), middle) < (1.0 + FAR) * radius {
                    self.far[mirror * rows + target] = 0.0;
                    pairs.push((target, mirror));
                }
            }
        }
        // 2. Far pairs, node by node.
        for node in 0..nodes {
            let point = &mesh.nodes[patch * nodes + node];
            let weight = point.area / (4.0 * std::f64::consts::PI);
            let normal = match layer {
                Layer::Double => point.normal.map(|part| part * weight),
                Layer::Single => [weight, 0.0, 0.0],
            };
            let range = node * rows..(node + 1) * rows;
            let mut columns: Vec<_> = self
                .blocks
                .iter_mut()
                .map(|(block, re, im)| (*block, &mut re[range.clone()], &mut im[range.clone()]))
                .collect();
            arch.dispatch(FarColumn {
                targets: &targets.coordinates,
                far: &self.far,
                source: (point.position, normal),
                wavenumber,
                layer,
                on_road: mesh.on_road,
                columns: &mut columns,
            });
        }
        // 3. Near pairs, for all nodes at once.
        let mut near = NearPatch::new(&mesh.patches[patch], &mesh.basis, layer, wavenumber);
        let mut sums = vec![Complex64::ZERO; nodes];
        for &(target, mirror) in &pairs {
            sums.fill(Complex64::ZERO);
            match targets.places[target] {
                Place::Patch(home, local) if mirror == 0 && home == patch => {
                    near.on_patch(arch, local, &mut sums);
                }
                _ => {
                    let position = mirrored(targets.position(target), mirror);
                    near.near(arch, position, &mut sums);
                }
            }
            for (block, re, im) in &mut self.blocks {
                let sign = block.sign(mirror % MIRRORS);
                for (node, sum) in sums.iter().enumerate() {
                    re[node * rows + target] += sign * sum.re;
                    im[node * rows + target] += sign * sum.im;
                }
            }
        }
        AssemblyWork {
            far_evaluations: (nodes * images * targets.len()) as u64,
            near_pairs: near.work().pairs,
            near_evaluations: near.work().evaluations,
        }
    }
}
