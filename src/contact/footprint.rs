//! Forces and displacements of a step over the contact window: written by the zone of the contact, read by all others.
//!
//! A step has one instant, or a few where the time rule has stages; its force is their mean sum_i b_i F_i. Points stand
//! column by column along the window, those across within a column; a slice is one point.

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
}

impl WindowShape {
    pub(crate) fn points(&self) -> usize {
        self.columns * self.across
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
        self.force.copy_from_slice(&forces[output_cells.clone()]);
        let last = output_cells.len() - across;
        for (end, outside) in [(0, &forces[..output_cells.start]), (last, &forces[output_cells.end..])] {
            for column in outside.chunks_exact(across) {
                for (force, outside) in self.force[end..].iter_mut().zip(column) {
                    *force += outside;
                }
            }
        }
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

    /// Forces at the step's instants, stage after stage, by point \[N\].
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

    /// Tangential part at the last instant; `None` without friction.
    pub fn tangential(&self) -> Option<&TangentialPart> {
        self.tangential.as_deref()
    }

    /// Number of columns that carry force.
    pub fn touching(&self) -> usize {
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
        }
    }

    /// Averages the forces over the instants of a step, once all of them are written.
    pub(crate) fn end_step(&mut self) {
        let Self { weights, force, column_force, mean, column_mean, .. } = self;
        for (means, forces) in [(mean, force), (column_mean, column_force)] {
            means.fill(0.0);
            for (forces, weight) in forces.chunks_exact(means.len().max(1)).zip(weights.iter()) {
                for (mean, force) in means.iter_mut().zip(forces) {
                    *mean += weight * force;
                }
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
