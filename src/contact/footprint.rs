//! Forces and displacements of a step over the contact window: written by the zone of the contact, read by all others.
//!
//! A step has one instant, or a few where the time rule has stages; its force is their mean sum_i b_i F_i. Points stand
//! column by column along the window, those across within a column; a slice is one point. Where cells have sub-cells,
//! these touch the road, and forces and displacements of cells are those of the tyre's waves.

use std::ops::Range;

use crate::storage::state::{Evolving, StateError, StateStream};

/// Shape of the contact window in a step.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) struct WindowShape {
    /// Elements along the window.
    pub columns: usize,
    /// Points across: cells, or 1 for a slice as a whole.
    pub across: usize,
    /// Instants of a step.
    pub stages: usize,
    /// Sub-cells of a cell along and across; 1 without.
    pub sub_cells: usize,
}

impl WindowShape {
    pub(crate) fn points(&self) -> usize {
        self.columns * self.across
    }

    /// Points that touch the road: those of the tyre's waves, or their sub-cells.
    pub(crate) fn touching_points(&self) -> usize {
        self.points() * self.sub_cells * self.sub_cells
    }
}

/// Tangential part of a footprint, of contact with friction: forces on the tyre and slip of the tread over the road,
/// forward and to the left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TangentialPart {
    /// Forces by point \[N\].
    pub forces: Vec<[f64; 2]>,
    /// Speeds of slip by point \[m/s\]; 0 where a point sticks or carries no force.
    pub slip: Vec<[f64; 2]>,
    /// Sums of the forces \[N\].
    pub total: [f64; 2],
    /// Moment of the forces about the vertical under the axle, to the left above 0 \[N m\].
    pub aligning_moment: f64,
    /// Power that friction dissipates, the sum of mu F_z |v| \[W\].
    pub slip_power: f64,
    /// Power that the forces put into the tyre, what its surface moves apart from rolling times them \[W\].
    pub power: f64,
    /// Torque about the axle, that of a forward force above 0 \[N m\].
    pub torque: f64,
    /// Longitudinal creep.
    pub creep: f64,
    /// Points that stick.
    pub sticking: usize,
    /// Points that slip.
    pub slipping: usize,
    /// Points that adhesion pulls.
    pub bonded: usize,
}

/// Sub-cells, which touch the road where cells have some: row by row of the window.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SubCells {
    /// Forces by stage and sub-cell \[N\].
    pub forces: Vec<f64>,
    /// Displacements by stage and sub-cell \[m\].
    pub displacements: Vec<f64>,
    /// Forces of the step by sub-cell \[N\].
    pub mean: Vec<f64>,
}

/// Numbers of the sub-cells that an instant writes.
pub(crate) struct SubCellsMut<'a> {
    pub force: &'a mut [f64],
    pub displacement: &'a mut [f64],
}

/// Adds `scale` times values of sub-cells, row by row, to those of their cells; there are `sub_cells` along and across
/// in a cell, and `across` cells across.
pub(crate) fn add_to_cells(values: &[f64], [sub_cells, across]: [usize; 2], scale: f64, out: &mut [f64]) {
    let columns = out.chunks_exact_mut(across).zip(values.chunks_exact(sub_cells * sub_cells * across));
    for (cells, rows) in columns {
        for row in rows.chunks_exact(sub_cells * across) {
            let of_cells = cells.iter_mut().zip(row.chunks_exact(sub_cells));
            of_cells.for_each(|(cell, values)| *cell += scale * values.iter().sum::<f64>());
        }
    }
}

/// Footprint of the tyre in a step.
#[derive(Clone, Debug)]
pub struct Footprint {
    shape: WindowShape,
    /// Weights b_i of the instants.
    weights: [f64; 3],
    /// Element number of the first column.
    first_element: i64,
    /// By stage and point \[N\], \[m\].
    force: Vec<f64>,
    displacement: Vec<f64>,
    /// By point, at the last instant \[m\].
    required: Vec<f64>,
    /// By stage and column \[N\]; empty where a column is one point.
    column_force: Vec<f64>,
    /// Forces of the step \[N\] by point, and by column; the latter is empty where a column is one point. Both are
    /// stored, since a sum of means is rounded otherwise than a mean of sums.
    mean: Vec<f64>,
    column_mean: Vec<f64>,
    /// Tangential part at the last instant; `None` without friction.
    tangential: Option<Box<TangentialPart>>,
    /// `None` where cells have no sub-cells.
    sub_cells: Option<Box<SubCells>>,
}

pub(crate) struct StageMut<'a> {
    /// Forces by point \[N\].
    pub force: &'a mut [f64],
    /// Displacements by point, springs included: u = G0 F + u_old \[m\]. Over cells G0 F may be left out a few columns
    /// away from those that touch.
    pub displacement: &'a mut [f64],
    /// Required displacements by point \[m\]; -infinity where there is no road.
    pub required: &'a mut [f64],
    /// Forces by column \[N\]; empty where a column is one point.
    pub column_force: &'a mut [f64],
    /// Tangential part; `None` without friction.
    pub tangential: Option<&'a mut TangentialPart>,
    /// Sub-cells; `None` without.
    pub sub_cells: Option<SubCellsMut<'a>>,
}

/// Copies the reported points of a window; forces on columns outside of them are added to the outermost reported ones,
/// so that none is lost.
fn copy_reported(reported: Range<usize>, of_column: usize, forces: &[f64], out: &mut [f64]) {
    out.copy_from_slice(&forces[reported.clone()]);
    let last = reported.len() - of_column;
    for (end, outside) in [(0, &forces[..reported.start]), (last, &forces[reported.end..])] {
        for column in outside.chunks_exact(of_column) {
            out[end..].iter_mut().zip(column).for_each(|(force, outside)| *force += outside);
        }
    }
}

impl SubCellsMut<'_> {
    /// Writes the reported sub-cells of a window, `of_column` to a column of cells.
    pub(crate) fn write(
        &mut self,
        reported: Range<usize>,
        of_column: usize,
        forces: &[f64],
        displacement: impl Fn(usize) -> f64,
    ) {
        self.displacement.iter_mut().zip(reported.clone()).for_each(|(out, n)| *out = displacement(n));
        copy_reported(reported, of_column, forces, self.force);
    }
}

impl StageMut<'_> {
    /// Writes the `output_cells` of a window, stored column by column; `displacement` gives that of a cell \[m\].
    /// Forces on columns outside `output_cells` are added to its outermost columns, so that none is lost.
    pub(crate) fn write(
        &mut self,
        output_cells: Range<usize>,
        across: usize,
        forces: &[f64],
        required: &[f64],
        displacement: impl Fn(usize) -> f64,
    ) {
        for (out, cell) in self.displacement.iter_mut().zip(output_cells.clone()) {
            *out = displacement(cell);
        }
        self.required.copy_from_slice(&required[output_cells.clone()]);
        copy_reported(output_cells, across, forces, self.force);
        for (sum, cells) in self.column_force.iter_mut().zip(self.force.chunks_exact(across)) {
            *sum = cells.iter().sum();
        }
    }
}

impl Footprint {
    /// Footprint of a tyre at rest in the air; `weights` are the b_i of a step's instants.
    pub(crate) fn new(shape: WindowShape, weights: [f64; 3], has_friction: bool) -> Self {
        let points = shape.points();
        let columns = if shape.across > 1 { shape.columns } else { 0 };
        Self {
            shape,
            weights,
            first_element: 0,
            force: vec![0.0; shape.stages * points],
            displacement: vec![0.0; shape.stages * points],
            required: vec![0.0; points],
            column_force: vec![0.0; shape.stages * columns],
            mean: vec![0.0; points],
            column_mean: vec![0.0; columns],
            tangential: has_friction.then(|| {
                let zeros = || vec![[0.0; 2]; points];
                Box::new(TangentialPart { forces: zeros(), slip: zeros(), ..TangentialPart::default() })
            }),
            sub_cells: (shape.sub_cells > 1).then(|| {
                let zeros = |stages: usize| vec![0.0; stages * shape.touching_points()];
                let (forces, displacements) = (zeros(shape.stages), zeros(shape.stages));
                Box::new(SubCells { forces, displacements, mean: zeros(1) })
            }),
        }
    }

    pub(crate) fn shape(&self) -> WindowShape {
        self.shape
    }

    /// Element number of the window's first column.
    pub fn first_element(&self) -> i64 {
        self.first_element
    }

    /// Number of the first point: points are material like elements, and a window moves on by whole columns of them.
    pub fn first_point(&self) -> i64 {
        self.first_element * self.shape.across as i64
    }

    /// Forces at the step's instants, stage after stage, by point \[N\]. Where cells have sub-cells they are P f, which
    /// may be slightly below 0 at the contact's edge.
    pub fn forces(&self) -> &[f64] {
        &self.force
    }

    /// Displacements at the step's instants, stage after stage, by point \[m\]: u = G0 F + u_old, springs included.
    pub fn displacements(&self) -> &[f64] {
        &self.displacement
    }

    /// Required displacements at the last instant by point \[m\]; -infinity where there is no road.
    pub fn required(&self) -> &[f64] {
        &self.required
    }

    /// Forces of the step by point \[N\]: for a Runge-Kutta rule their mean over the step.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// Forces of the step by column \[N\], averaged likewise.
    pub fn column_mean(&self) -> &[f64] {
        if self.shape.across > 1 { &self.column_mean } else { &self.mean }
    }

    /// Sub-cells; `None` where cells have none.
    pub fn sub_cells(&self) -> Option<&SubCells> {
        self.sub_cells.as_deref()
    }

    /// Points that touch the road, or their sub-cells: number of the first one, forces \[N\] and displacements \[m\]
    /// at the step's instants.
    pub(crate) fn touching(&self) -> (i64, &[f64], &[f64]) {
        match &self.sub_cells {
            Some(of) => {
                let of_column = self.shape.touching_points() / self.shape.columns;
                (self.first_element * of_column as i64, &of.forces, &of.displacements)
            }
            None => (self.first_point(), &self.force, &self.displacement),
        }
    }

    /// Forces of the step on what touches the road \[N\].
    pub fn touching_forces(&self) -> &[f64] {
        self.sub_cells.as_ref().map_or(&self.mean, |sub_cells| &sub_cells.mean)
    }

    /// Tangential part at the last instant; `None` without friction.
    pub fn tangential(&self) -> Option<&TangentialPart> {
        self.tangential.as_deref()
    }

    /// Number of columns that carry force.
    pub fn touching_columns(&self) -> usize {
        self.column_mean().iter().filter(|&&force| force > 0.0).count()
    }

    /// Number of columns from the first to the last one that carries force.
    pub fn extent(&self) -> usize {
        let carries = |&force: &f64| force > 0.0;
        let forces = self.column_mean();
        let ends = forces.iter().position(carries).zip(forces.iter().rposition(carries));
        ends.map_or(0, |(from, to)| to - from + 1)
    }

    /// Sum of the forces at an instant \[N\].
    pub(crate) fn total_at(&self, stage: usize) -> f64 {
        let columns = self.shape.columns;
        let forces = if self.shape.across > 1 { &self.column_force } else { &self.force };
        forces[stage * columns..(stage + 1) * columns].iter().sum()
    }

    /// Numbers that an instant writes, the window's first column being `first_element`.
    pub(crate) fn stage(&mut self, stage: usize, first_element: i64) -> StageMut<'_> {
        let points = self.shape.points();
        let columns = if self.shape.across > 1 { self.shape.columns } else { 0 };
        self.first_element = first_element;
        StageMut {
            force: &mut self.force[stage * points..(stage + 1) * points],
            displacement: &mut self.displacement[stage * points..(stage + 1) * points],
            required: &mut self.required,
            column_force: &mut self.column_force[stage * columns..(stage + 1) * columns],
            tangential: self.tangential.as_deref_mut(),
            sub_cells: self.sub_cells.as_deref_mut().map(|sub_cells| {
                let range = stage * sub_cells.mean.len()..(stage + 1) * sub_cells.mean.len();
                let SubCells { forces, displacements, .. } = sub_cells;
                SubCellsMut { force: &mut forces[range.clone()], displacement: &mut displacements[range] }
            }),
        }
    }

    /// Averages the forces over the instants of a step, once all of them are written; forces of cells are then sums
    /// over their sub-cells.
    pub(crate) fn end_step(&mut self) {
        let Self { shape, weights, force, column_force, mean, column_mean, sub_cells, .. } = self;
        let average = |mean: &mut [f64], forces: &[f64]| {
            mean.fill(0.0);
            for (forces, weight) in forces.chunks_exact(mean.len().max(1)).zip(weights.iter()) {
                mean.iter_mut().zip(forces).for_each(|(mean, force)| *mean += weight * force);
            }
        };
        match sub_cells {
            None => {
                average(mean, force);
                average(column_mean, column_force);
            }
            Some(sub_cells) => {
                average(&mut sub_cells.mean, &sub_cells.forces);
                mean.fill(0.0);
                add_to_cells(&sub_cells.mean, [shape.sub_cells, shape.across], 1.0, mean);
                let columns = column_mean.iter_mut().zip(mean.chunks_exact(shape.across));
                columns.for_each(|(sum, cells)| *sum = cells.iter().sum());
            }
        }
    }
}

/// The column forces of the last step; those by point are found anew in the next step.
impl Evolving for Footprint {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        if self.shape.across > 1 { self.column_mean.state(state) } else { self.mean.state(state) }
    }
}
