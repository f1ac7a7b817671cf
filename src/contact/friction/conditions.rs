//! Contact and friction law of a cell.
//!
//! With F the force on the tyre, F_z and u_z into it, g = u_t + shift the slip of the step (its speed times
//! dt/delta(0)):
//!
//! ```text
//! F_z >= 0,  u_z >= d,  F_z (u_z - d) = 0;       |F_t| <= mu F_z,  F_t.g = -mu F_z |g|
//! ```
//!
//! For any lengths of force per displacement r that is
//!
//! ```text
//! F_z = max(0, F_z - r (u_z - d)),    F_t = P(F_t - r g),    P onto the disc |F_t| <= mu F_z
//! ```
//!
//! and the difference of both sides is the error. Near a guess a slipping cell has e = z/|z|, z = F_t - r g,
//! and, with t across e and beta = mu F_z/|z| <= 1, the equations of a Newton step for the new forces:
//!
//! ```text
//! F_t = mu F_z e + tau t,     beta r g.t + (1 - beta) tau = 0
//! ```

use super::product::Vector;

/// Conditions of an instant on all cells of a window.
#[derive(Clone, Copy)]
pub(crate) struct Conditions<'a> {
    /// Required displacements d \[m\]; -infinity where a cell cannot touch.
    pub required: &'a [f64],
    /// Slip of the step without the displacements by its forces \[m\].
    pub shift: &'a [[f64; 2]],
    /// Coefficient of friction mu.
    pub friction: &'a [f64],
}

/// State of a cell near a guess.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CellState {
    /// No force.
    Open,
    /// Pressed, no slip.
    Sticking,
    /// Pressed and slipping, the force along this direction; beta r is the last number, 1 - beta the one before.
    Slipping([f64; 2], f64, f64),
}

pub(crate) fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

/// Projects a tangential force onto the disc of forces no larger than `bound`.
pub(crate) fn onto_disc(force: [f64; 2], bound: f64) -> [f64; 2] {
    let size = length(force);
    if size <= bound { force } else { force.map(|component| component * (bound / size)) }
}

impl Conditions<'_> {
    /// Feasible forces nearest to those of a cell.
    pub(crate) fn feasible(&self, cell: usize, [x, y, z]: Vector) -> Vector {
        let z = if z > 0.0 && self.required[cell] > f64::NEG_INFINITY { z } else { 0.0 };
        let [x, y] = onto_disc([x, y], self.friction[cell] * z);
        [x, y, z]
    }

    /// Trial forces of a cell, F - r (u - d) and F - r g, r by component \[N/m\].
    fn trial(&self, cell: usize, [fx, fy, fz]: Vector, [ux, uy, uz]: Vector, [rx, ry, rz]: Vector) -> Vector {
        let [sx, sy] = self.shift[cell];
        [fx - rx * (ux + sx), fy - ry * (uy + sy), fz - rz * (uz - self.required[cell])]
    }

    /// Differences between the forces of a cell and the projection of its trial forces \[N\]: normal, tangential.
    pub(crate) fn missed(&self, cell: usize, force: Vector, displacement: Vector, rigidity: Vector) -> [f64; 2] {
        let [x, y, z] = self.trial(cell, force, displacement, rigidity);
        let normal = (force[2] - z.max(0.0)).abs();
        let [px, py] = onto_disc([x, y], self.friction[cell] * force[2]);
        [normal, length([force[0] - px, force[1] - py])]
    }

    /// State of a cell near a guess. Rigidities along x and y have to be the same for the projection to be one onto a
    /// disc.
    pub(crate) fn state(&self, cell: usize, force: Vector, displacement: Vector, rigidity: Vector) -> CellState {
        let [x, y, z] = self.trial(cell, force, displacement, rigidity);
        if z.is_nan() || z <= 0.0 {
            return CellState::Open;
        }
        let (bound, size) = (self.friction[cell] * force[2].max(0.0), length([x, y]));
        if size > bound || self.friction[cell] <= 0.0 {
            let beta = if size > 0.0 { bound / size } else { 0.0 };
            let direction = if size > 0.0 { [x / size, y / size] } else { [1.0, 0.0] };
            CellState::Slipping(direction, 1.0 - beta, beta * rigidity[0])
        } else {
            CellState::Sticking
        }
    }

    /// Slip of a cell in the step \[m\].
    pub(crate) fn slip(&self, cell: usize, [x, y, _]: Vector) -> [f64; 2] {
        let [sx, sy] = self.shift[cell];
        [x + sx, y + sy]
    }
}
