//! The boundary problem at one wavenumber: assembled, factorised and solved block by block.
//!
//! 1. p/2 - K p = f at the nodes of each parity block, f the incident field of a point source at a receiver (whose
//!    solution is the total Green function G_N of body and road) or i w rho S v of a prescribed velocity v.
//! 2. At points inside the body -C p = f without the p/2; together, with multipliers m: \[A C^H; C 0\] \[p; m\] = \[f;
//!    g\], square, factorised by LU with partial pivoting.
//! 3. The field anywhere: p(r) = f(r) + (K p)(r), twice that on the surface itself. On the surface this is better than
//!    interpolation between the nodes by several orders: the integral smooths what interpolation cannot resolve.

use std::time::Instant;

use faer::Mat;
use num_complex::Complex64;

use super::assembly::{AssemblyWork, Panel, Targets};
use super::body::{RadiatingBody, Vector};
use super::chart::Chart;
use super::cost::RadiationCost;
use super::elements::{Mesh, distance};
use super::error::{RadiationError, positive};
use super::factor::Factor;
use super::interior;
use super::kernel::Layer;
use super::mesh::{MeshResolution, mesh};
use super::parity::{MIRRORS, ParityBlock, mirrored};

/// A prescribed velocity: outward normal velocity \[m/s\] at a point of the whole surface, times i w rho
/// \[kg/(m^3 s)\], with the chart that the point lies on.
pub(crate) type Velocity<'a> = dyn Fn(&Chart, Vector) -> Complex64 + Sync + 'a;

/// Source of a field.
pub enum Drive<'a> {
    /// A point source of unit strength (lap G + k^2 G = -delta), its image in the road included.
    Source(Vector),
    /// A prescribed velocity of the surface.
    Velocity(&'a Velocity<'a>),
}

/// Cost and condition of a problem's solution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Unknown pressures of one block.
    pub unknowns: usize,
    /// Interior points of one block.
    pub interior_points: usize,
    /// Reciprocal condition number in the 1-norm of the worst block.
    pub reciprocal_condition: f64,
    /// Work of the assembly, evaluations at other points included.
    pub work: AssemblyWork,
    /// Real operations of the factorisations.
    pub factor_operations: f64,
    /// Duration of the assembly \[s\].
    pub assembly_seconds: f64,
    /// Duration of the factorisations \[s\].
    pub factor_seconds: f64,
}

/// Boundary problem of a body at a wavenumber.
#[derive(Clone, Debug)]
pub struct RadiationProblem {
    body: RadiatingBody,
    mesh: Mesh,
    wavenumber: f64,
    blocks: Vec<ParityBlock>,
    interior: Vec<Vector>,
}

/// Solved surface pressures of all drives.
pub struct Solution<'a> {
    problem: &'a RadiationProblem,
    drives: &'a [Drive<'a>],
    /// By block: rows are unknowns, columns are drives.
    pressures: Vec<Mat<Complex64>>,
    report: SolveReport,
}

impl RadiationProblem {
    /// Makes the mesh for a wavenumber \[rad/m\]; only the given blocks are solved. `mesh_wavenumber` is the one that
    /// the mesh resolves: the wavenumber itself, or that of the prescribed velocity where it is larger.
    ///
    /// # Errors
    /// Refusals of the mesh; more memory than `memory_limit` \[bytes\].
    pub fn new(
        body: &RadiatingBody,
        wavenumber: f64,
        mesh_wavenumber: f64,
        resolution: &MeshResolution,
        blocks: &[ParityBlock],
        memory_limit: u64,
    ) -> Result<Self, RadiationError> {
        positive("the wavenumber", wavenumber)?;
        RadiationCost::expected(body, wavenumber, mesh_wavenumber, resolution, blocks)?.check(memory_limit)?;
        let mesh = mesh(body, mesh_wavenumber, resolution)?;
        let interior = interior::points(body, interior::interior_points(body, wavenumber));
        Ok(Self { body: *body, mesh, wavenumber, blocks: blocks.to_vec(), interior })
    }

    /// The same with another number of interior points, for tests of their effect.
    pub fn with_interior_points(mut self, count: usize) -> Self {
        self.interior = interior::points(&self.body, count);
        self
    }

    /// Mesh of the body's quarter.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Parity blocks that are solved.
    pub fn blocks(&self) -> &[ParityBlock] {
        &self.blocks
    }

    /// Solves for all drives.
    ///
    /// # Errors
    /// Sources that are not in the air; a singular block.
    pub fn solve<'a>(&'a self, drives: &'a [Drive<'a>]) -> Result<Solution<'a>, RadiationError> {
        self.solve_unless(drives, &|| false)
    }

    /// Solves for all drives; asks before each patch and before each block's factorisation whether to stop.
    ///
    /// # Errors
    /// As [`Self::solve`]; [`RadiationError::Interrupted`].
    pub fn solve_unless<'a>(
        &'a self,
        drives: &'a [Drive<'a>],
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Solution<'a>, RadiationError> {
        let check_interrupt = || if interrupted() { Err(RadiationError::Interrupted) } else { Ok(()) };
        for drive in drives {
            if let Drive::Source(point) = drive {
                self.body.check_receiver(*point)?;
            }
        }
        let begin = Instant::now();
        let (unknowns, extra) = (self.mesh.unknowns(), self.interior.len());
        let size = unknowns + extra;
        let targets = Targets::nodes_and(&self.mesh, &self.interior);
        let mut report = SolveReport { unknowns, interior_points: extra, ..SolveReport::default() };
        // 1. The matrices, patch by patch, with the multipliers' columns.
        let mut matrices: Vec<Mat<Complex64>> = self.blocks.iter().map(|_| Mat::zeros(size, size)).collect();
        let nodes = self.mesh.nodes_per_patch();
        // Rows of interior points are scaled to the size of the others.
        let scale = (unknowns as f64).sqrt() * 0.5;
        let mut panel = Panel::new(&self.blocks);
        for patch in 0..self.mesh.patches.len() {
            check_interrupt()?;
            report.work.add(&panel.fill(&self.mesh, patch, &targets, self.wavenumber, Layer::Double));
            for (block, matrix) in matrices.iter_mut().enumerate() {
                for node in 0..nodes {
                    let column = patch * nodes + node;
                    for (row, entry) in matrix.col_mut(column).iter_mut().enumerate() {
                        let value = panel.at(block, node, row);
                        *entry = if row < unknowns { -value } else { -value * scale };
                    }
                    matrix[(column, column)] += 0.5;
                    for row in unknowns..size {
                        matrix[(column, row)] = matrix[(row, column)].conj();
                    }
                }
            }
        }
        // 2. Right sides.
        let mut rights = self.right_sides(drives, &targets, &mut report);
        for right in &mut rights {
            for drive in 0..drives.len() {
                for row in unknowns..size {
                    right[(row, drive)] *= scale;
                }
            }
        }
        report.assembly_seconds = begin.elapsed().as_secs_f64();
        // 3. Factors and solutions, block by block; each matrix is freed before the next.
        report.reciprocal_condition = f64::INFINITY;
        let begin = Instant::now();
        for (matrix, right) in matrices.drain(..).zip(&mut rights) {
            check_interrupt()?;
            let factor = Factor::of(matrix);
            factor.solve(right.as_mut());
            report.factor_operations += 8.0 / 3.0 * (size as f64).powi(3);
            report.reciprocal_condition = report.reciprocal_condition.min(factor.reciprocal_condition());
            let finite = (0..drives.len()).all(|drive| right.col(drive).iter().all(|entry| entry.is_finite()));
            if !finite || report.reciprocal_condition.is_nan() {
                return Err(RadiationError::Singular { wavenumber: self.wavenumber, unknowns });
            }
        }
        report.factor_seconds = begin.elapsed().as_secs_f64();
        Ok(Solution { problem: self, drives, pressures: rights, report })
    }

    /// Right sides f of all drives at the targets, by block.
    fn right_sides(&self, drives: &[Drive<'_>], targets: &Targets, report: &mut SolveReport) -> Vec<Mat<Complex64>> {
        let mut rights: Vec<_> = self.blocks.iter().map(|_| Mat::zeros(targets.len(), drives.len())).collect();
        for (block, right) in self.blocks.iter().zip(&mut rights) {
            for (column, drive) in drives.iter().enumerate() {
                if let Drive::Source(source) = drive {
                    for row in 0..targets.len() {
                        right[(row, column)] = block.part(targets.position(row), |point| self.incident(point, *source));
                    }
                }
            }
        }
        if drives.iter().any(|drive| matches!(drive, Drive::Velocity(_))) {
            let parts = self.velocity_parts(drives);
            self.apply(Layer::Single, targets, &parts, &mut rights, report);
        }
        rights
    }

    /// Prescribed velocities at the nodes, by block, times i w rho.
    fn velocity_parts(&self, drives: &[Drive<'_>]) -> Vec<Mat<Complex64>> {
        let nodes = self.mesh.nodes_per_patch();
        let part = |block: &ParityBlock| {
            Mat::from_fn(self.mesh.unknowns(), drives.len(), |row, column| match &drives[column] {
                Drive::Source(_) => Complex64::ZERO,
                Drive::Velocity(velocity) => {
                    let chart = &self.mesh.patches[row / nodes].chart;
                    block.part(self.mesh.nodes[row].position, |point| velocity(chart, point))
                }
            })
        };
        self.blocks.iter().map(part).collect()
    }

    /// Adds to `sums` the product of a layer operator with the values at the nodes, by block.
    fn apply(
        &self,
        layer: Layer,
        targets: &Targets,
        values: &[Mat<Complex64>],
        sums: &mut [Mat<Complex64>],
        report: &mut SolveReport,
    ) {
        let nodes = self.mesh.nodes_per_patch();
        let mut panel = Panel::new(&self.blocks);
        for patch in 0..self.mesh.patches.len() {
            report.work.add(&panel.fill(&self.mesh, patch, targets, self.wavenumber, layer));
            for (block, (values, sums)) in values.iter().zip(sums.iter_mut()).enumerate() {
                for column in 0..values.ncols() {
                    for node in 0..nodes {
                        let value = values[(patch * nodes + node, column)];
                        for (target, sum) in sums.col_mut(column).iter_mut().enumerate() {
                            *sum += panel.at(block, node, target) * value;
                        }
                    }
                }
            }
        }
    }

    /// Field of a point source and of its image in the road, without the body \[1/m\].
    pub fn incident(&self, point: Vector, source: Vector) -> Complex64 {
        let direct = green(distance(point, source), self.wavenumber);
        if self.body.on_road() { direct + green(distance(point, mirrored(source, 4)), self.wavenumber) } else { direct }
    }
}

/// exp(-ikR)/(4 pi R), the Green function of free space.
fn green(distance: f64, wavenumber: f64) -> Complex64 {
    Complex64::from_polar(1.0 / (4.0 * std::f64::consts::PI * distance), -wavenumber * distance)
}

impl Solution<'_> {
    /// Cost and condition of the solution, fields evaluated so far included.
    pub fn report(&self) -> SolveReport {
        self.report
    }

    /// Field at points, by drive, then point; `on_surface`: all of the points lie on the body, else none.
    pub fn field(&mut self, points: &[Vector], on_surface: bool) -> Vec<Vec<Complex64>> {
        let begin = Instant::now();
        let Self { problem, drives, pressures, report } = self;
        let targets = Targets::points(points);
        let mut sums = problem.right_sides(drives, &targets, report);
        problem.apply(Layer::Double, &targets, pressures, &mut sums, report);
        let factor = if on_surface { 2.0 } else { 1.0 };
        let at = |drive: usize, point: usize| sums.iter().map(|sum| sum[(point, drive)]).sum::<Complex64>() * factor;
        let fields = (0..drives.len()).map(|drive| (0..points.len()).map(|point| at(drive, point)).collect()).collect();
        report.assembly_seconds += begin.elapsed().as_secs_f64();
        fields
    }

    /// Parts of the field by parity at points of the surface in the quarter, each a chart and its two parameters: by
    /// block, rows are points, columns are drives.
    pub fn surface_parts(&mut self, points: &[(Chart, [f64; 2])]) -> Vec<Mat<Complex64>> {
        let begin = Instant::now();
        let Self { problem, drives, pressures, report } = self;
        let targets = Targets::on_surface(&problem.mesh, points);
        let mut sums = problem.right_sides(drives, &targets, report);
        problem.apply(Layer::Double, &targets, pressures, &mut sums, report);
        for sum in &mut sums {
            *sum *= faer::Scale(Complex64::new(2.0, 0.0));
        }
        report.assembly_seconds += begin.elapsed().as_secs_f64();
        sums
    }

    /// Pressure of a drive at a node of the mesh in the quarter, by block.
    pub fn node_pressure(&self, block: usize, node: usize, drive: usize) -> Complex64 {
        self.pressures[block][(node, drive)]
    }

    /// int p conj(u) dS over the whole surface, with u = i w rho v the values of a velocity drive.
    fn product(&self, drive: usize) -> Complex64 {
        let parts = self.problem.velocity_parts(self.drives);
        let unknowns = self.problem.mesh.unknowns();
        let mut sum = Complex64::ZERO;
        for (pressure, velocity) in self.pressures.iter().zip(&parts) {
            for node in 0..unknowns {
                let area = MIRRORS as f64 * self.problem.mesh.nodes[node].area;
                sum += pressure[(node, drive)] * velocity[(node, drive)].conj() * area;
            }
        }
        sum
    }

    /// Radiated power \[W\] of a velocity drive, 1/2 Re int p conj(v) dS; `impedance` is the w rho \[kg/(m^3 s)\] in
    /// the drive's values i w rho v.
    pub fn power(&self, drive: usize, impedance: f64) -> f64 {
        // conj(i w rho v) = -i w rho conj(v).
        0.5 * (self.product(drive) * Complex64::I / impedance).re
    }
}
