//! Transfer from a tyre to receivers: the total Green function G_N on a regular grid of its tread, and of its flank
//! where that moves, too.
//!
//! p(r) = i w rho int G_N(y; r) v_n(y) dS over the tread; G_N is smooth along the tread, v_n is not, and much of the
//! sum cancels. So G_N is not interpolated between the elements' nodes, where it would jump from element to element:
//!
//! 1. On panels around the tread, finer towards the patch as the elements are, G_N is evaluated at p + 2 Gauss points
//!    by the boundary integral itself, which is smooth across elements.
//! 2. Each cell's mean is that of the panels' polynomials over the cell; the part of a cell within the patch counts as
//!    0: there the tread is at rest against the road, and no air moves.
//!
//! Grid: theta from the bottom (the contact's centre), increasing towards +x, cell c from 2 pi c/n to 2 pi (c + 1)/n.
//! Across the tread Gauss points of (0, w), w half the straight tread's width, weights summing to w: one side where
//! only blocks even across are solved, whose values then hold for both sides; else that of y > 0, then that of y < 0.
//! Behind the points of the tread come the rings of the flank, cut by the road where the tyre is.

use num_complex::{Complex32, Complex64};

use super::body::{BodyShape, RadiatingBody, Vector};
use super::chart::Chart;
use super::elements::{ElementBasis, Mesh, distance};
use super::error::{RadiationError, positive};
use super::flank::Flank;
use super::mesh::MeshResolution;
use super::parity::ParityBlock;
use super::solve::{Drive, RadiationProblem, SolveReport};
use crate::numeric::{SplitRule, double, single};

/// Grid of a transfer on the tread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TransferGrid {
    /// Cells around the tread, an even number.
    pub around: usize,
    /// Gauss points from the tread's middle to its edge.
    pub across: usize,
}

/// G_N of one receiver at one frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceTransfer {
    /// Position of the receiver \[m\].
    pub receiver: Vector,
    /// Wavenumber \[rad/m\].
    pub wavenumber: f64,
    /// Grid of the values.
    pub grid: TransferGrid,
    /// 1: even part, for both sides; 2: y > 0, then y < 0.
    pub sides: usize,
    /// Means of G_N over the cells \[1/m\], `[side][row][around]`, rows the points across the tread, then the rings of
    /// a flank; in single precision, in which they are stored.
    pub values: Vec<Complex32>,
}

/// Gauss points of (0, w), and weights that sum to w, for half a tread of width w \[m\].
pub(crate) fn across_points(half_width: f64, count: usize) -> Vec<[f64; 2]> {
    let basis = ElementBasis::new(count);
    let scaled = |(node, weight): (&f64, &f64)| [0.5 * half_width * (1.0 + node), 0.5 * half_width * weight];
    basis.nodes.iter().zip(&basis.weights).map(scaled).collect()
}

/// Half the width of a tyre's straight tread \[m\]; 0 for other bodies.
pub(crate) fn half_tread(body: &RadiatingBody) -> f64 {
    match body.shape() {
        BodyShape::Tyre { width, shoulder, .. } => 0.5 * width - shoulder,
        BodyShape::Sphere { .. } => 0.0,
    }
}

/// r0 \[m\]: from a receiver to the contact's centre, or to the road below the body, or to its middle without a road.
pub(crate) fn contact_distance(body: &RadiatingBody, receiver: Vector) -> f64 {
    distance(receiver, [0.0; 3]).max(if body.on_road() { 0.0 } else { body.radius() })
}

impl SurfaceTransfer {
    /// Number of rows of a side: points across the tread, and rings of a flank.
    pub fn rows(&self) -> usize {
        self.values.len() / (self.sides * self.grid.around)
    }

    /// Index of a value.
    pub fn index(&self, side: usize, row: usize, around: usize) -> usize {
        (side * self.rows() + row) * self.grid.around + around
    }

    /// Horn amplification at a cell \[dB\]: |G_N| over that of direct sound and road's reflection without the tyre, at
    /// the cell's middle; minus infinity within the patch.
    pub fn horn(&self, body: &RadiatingBody, side: usize, across: usize, around: usize) -> f64 {
        let theta = std::f64::consts::TAU * (around as f64 + 0.5) / self.grid.around as f64;
        let y = across_points(half_tread(body), self.grid.across)[across][0];
        let y = if side == 0 { y } else { -y };
        let radius = body.radius();
        let free = |y: f64| {
            let point = [radius * theta.sin(), y, body.middle() - radius * theta.cos()];
            let [x, across, z] = self.receiver;
            let one = |z: f64| {
                let r = distance(point, [x, across, z]);
                Complex64::from_polar(1.0 / (4.0 * std::f64::consts::PI * r), -self.wavenumber * r)
            };
            if body.on_road() { one(z) + one(-z) } else { one(z) }
        };
        let free = if self.sides == 1 { (free(y) + free(-y)) * 0.5 } else { free(y) };
        20.0 * (double(self.values[self.index(side, across, around)]).norm() / free.norm()).log10()
    }

    /// p(r)/(i w rho) of a velocity of the tread given by its cell means, in the order of the values: the sum over the
    /// grid.
    pub fn sum(&self, body: &RadiatingBody, velocity: &[Complex64]) -> Complex64 {
        let cell = std::f64::consts::TAU / self.grid.around as f64 * body.radius();
        let both = if self.sides == 1 { 2.0 } else { 1.0 };
        let points = across_points(half_tread(body), self.grid.across);
        let rows = self.values.chunks_exact(self.grid.around).zip(velocity.chunks_exact(self.grid.around));
        let row = |(row, (values, velocity)): (usize, (&[Complex32], &[Complex64]))| {
            let sum: Complex64 = values.iter().zip(velocity).map(|(value, velocity)| double(*value) * velocity).sum();
            sum * (points[row % self.rows()][1] * cell * both)
        };
        rows.enumerate().filter(|(row, _)| row % self.rows() < self.grid.across).map(row).sum()
    }
}

/// Transfers of a tyre at one wavenumber.
#[derive(Clone, Debug)]
pub struct TransferProblem<'a> {
    /// Body; must be a tyre.
    pub body: &'a RadiatingBody,
    /// Positions of the receivers \[m\].
    pub receivers: &'a [Vector],
    /// Grid of the transfers.
    pub grid: TransferGrid,
    /// Flank, where it moves, too.
    pub flank: Option<Flank>,
    /// Fineness of the mesh.
    pub resolution: MeshResolution,
    /// Parity blocks: [`ParityBlock::EVEN_ACROSS`] or [`ParityBlock::ALL`].
    pub blocks: &'a [ParityBlock],
    /// Largest memory \[bytes\].
    pub memory_limit: u64,
}

impl TransferProblem<'_> {
    /// Checks the problem without solving it.
    ///
    /// # Errors
    /// A body that is no tyre or has no straight tread, an empty grid, receivers that are not in the air, blocks other
    /// than the two lists.
    pub fn check(&self) -> Result<(), RadiationError> {
        positive("the straight tread's half width", half_tread(self.body))?;
        if self.grid.around == 0 || !self.grid.around.is_multiple_of(2) {
            return Err(RadiationError::Cells { around: self.grid.around });
        }
        positive("the number of points across", self.grid.across as f64)?;
        self.resolution.check()?;
        if self.blocks != ParityBlock::ALL && self.blocks != ParityBlock::EVEN_ACROSS {
            return Err(RadiationError::Blocks);
        }
        self.receivers.iter().try_for_each(|&receiver| self.body.check_receiver(receiver))
    }

    /// 1 where only blocks even across are solved, else 2.
    pub fn sides(&self) -> usize {
        if self.blocks.len() == ParityBlock::ALL.len() { 2 } else { 1 }
    }

    /// Number of values of a transfer.
    pub fn values(&self) -> usize {
        let rows = self.grid.across + if self.flank.is_some() { SplitRule::POINTS } else { 0 };
        self.sides() * rows * self.grid.around
    }

    /// Solves for the transfers to all receivers at a wavenumber \[rad/m\].
    ///
    /// # Errors
    /// As [`Self::check`], [`RadiationProblem::new`] and [`RadiationProblem::solve`].
    pub fn solve(&self, wavenumber: f64) -> Result<(Vec<SurfaceTransfer>, SolveReport), RadiationError> {
        self.solve_unless(wavenumber, &|| false)
    }

    /// The same; asks whether to stop, as [`RadiationProblem::solve_unless`].
    ///
    /// # Errors
    /// As [`Self::solve`]; [`RadiationError::Interrupted`].
    pub fn solve_unless(
        &self,
        wavenumber: f64,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<(Vec<SurfaceTransfer>, SolveReport), RadiationError> {
        self.check()?;
        let (body, grid) = (self.body, self.grid);
        let problem =
            RadiationProblem::new(body, wavenumber, wavenumber, &self.resolution, self.blocks, self.memory_limit)?;
        let drives: Vec<Drive<'_>> = self.receivers.iter().map(|&receiver| Drive::Source(receiver)).collect();
        let mut solution = problem.solve_unless(&drives, interrupted)?;
        // 1. Points on the panels of each row: points across the tread, rings of the flank.
        let panels = Panels::of(problem.mesh());
        let tread = Chart::of_tyre(body).into_iter().flat_map(|[tread, ..]| {
            across_points(half_tread(body), grid.across).into_iter().map(move |[y, _]| (tread, y))
        });
        let tread = tread.map(|(chart, y)| (chart, y, panels.clone()));
        let cut = |chart: &Chart, meridian: f64| if body.half_patch() > 0.0 { chart.cut_turn(meridian) } else { 0.0 };
        let rings = self.flank.iter().flat_map(|flank| flank.rings());
        let rings = rings.map(|ring| (ring.chart, ring.meridian, panels.begun_at(cut(&ring.chart, ring.meridian))));
        let rows: Vec<(Chart, f64, Panels)> = tread.chain(rings).collect();
        let points: Vec<(Chart, [f64; 2])> = rows
            .iter()
            .flat_map(|(chart, meridian, panels)| panels.turns().into_iter().map(|theta| (*chart, [*meridian, theta])))
            .collect();
        // 2. G_N at the points, by parity.
        let parts = solution.surface_parts(&points);
        // 3. Means over cells, both sides from the parities.
        let means: Vec<_> = rows.iter().map(|(_, _, panels)| panels.means(grid.around)).collect();
        let (sides, turns) = (self.sides(), points.len() / rows.len());
        let transfers = self.receivers.iter().enumerate().map(|(drive, &receiver)| {
            let mut values = Vec::with_capacity(self.values());
            for side in 0..sides {
                for (row, means) in means.iter().enumerate() {
                    for (from, mirror) in (0..grid.around).map(|cell| Panels::source(cell, grid.around)) {
                        // The mirror of the cell: bit 0 fore-aft, bit 1 across.
                        let mirror = usize::from(mirror) + 2 * side;
                        let value = means[from].iter().map(|&(point, weight)| {
                            let place = row * turns + point;
                            let sum: Complex64 = (self.blocks.iter().zip(&parts))
                                .map(|(block, part)| part[(place, drive)] * block.sign(mirror))
                                .sum();
                            sum * weight
                        });
                        values.push(single(value.sum()));
                    }
                }
            }
            SurfaceTransfer { receiver, wavenumber, grid, sides, values }
        });
        Ok((transfers.collect(), solution.report()))
    }
}

/// Panels around the tread.
#[derive(Clone)]
struct Panels {
    breaks: Vec<f64>,
    basis: ElementBasis,
}

/// Points at which a panel's polynomial is averaged over its share of a cell.
const MEAN_POINTS: usize = 3;

impl Panels {
    /// Panels of the elements in the tread's first ring.
    fn of(mesh: &Mesh) -> Self {
        let mut breaks = Vec::new();
        for patch in &mesh.patches {
            if matches!(patch.chart, Chart::Tread { .. }) && patch.meridian[0] <= 0.0 {
                if breaks.is_empty() {
                    breaks.push(patch.turn[0]);
                }
                breaks.push(patch.turn[1]);
            }
        }
        Self { breaks, basis: ElementBasis::new(mesh.basis.order() + 2) }
    }

    /// The same in proportion, from another angle to the top.
    fn begun_at(&self, start: f64) -> Self {
        let ends = [self.breaks.first(), self.breaks.last()].map(|end| end.copied().unwrap_or(0.0));
        let moved = |at: &f64| start + (at - ends[0]) * (ends[1] - start) / (ends[1] - ends[0]);
        Self { breaks: self.breaks.iter().map(moved).collect(), basis: self.basis.clone() }
    }

    /// Angles of all points.
    fn turns(&self) -> Vec<f64> {
        let panel = |ends: &[f64]| {
            let (from, to) = (ends[0], ends[1]);
            self.basis.nodes.iter().map(move |node| 0.5 * ((from + to) + (to - from) * node)).collect::<Vec<_>>()
        };
        self.breaks.windows(2).flat_map(panel).collect()
    }

    /// Cell of the first half whose mean a cell has, and whether mirrored: cell c mirrors cell n - 1 - c.
    fn source(cell: usize, around: usize) -> (usize, bool) {
        if 2 * cell < around { (cell, false) } else { (around - 1 - cell, true) }
    }

    /// For each cell of the first half, the points and weights of the mean over it.
    fn means(&self, around: usize) -> Vec<Vec<(usize, f64)>> {
        let width = std::f64::consts::TAU / around as f64;
        let rule = ElementBasis::new(MEAN_POINTS);
        let order = self.basis.order();
        let mut values = vec![0.0; order];
        let cells = around / 2;
        let mut means = Vec::with_capacity(cells);
        for cell in 0..cells {
            let (from, to) = (cell as f64 * width, (cell + 1) as f64 * width);
            let mut weights: Vec<(usize, f64)> = Vec::new();
            for (panel, ends) in self.breaks.windows(2).enumerate() {
                let (low, high) = (from.max(ends[0]), to.min(ends[1]));
                if low >= high {
                    continue;
                }
                let first = weights.len();
                weights.extend((0..order).map(|node| (panel * order + node, 0.0)));
                for (node, weight) in rule.nodes.iter().zip(&rule.weights) {
                    let at = 0.5 * ((low + high) + (high - low) * node);
                    let local = (2.0 * at - ends[0] - ends[1]) / (ends[1] - ends[0]);
                    self.basis.values(local, &mut values);
                    for ((_, sum), value) in weights[first..].iter_mut().zip(&values) {
                        *sum += value * 0.5 * weight * (high - low) / width;
                    }
                }
            }
            means.push(weights);
        }
        means
    }
}
