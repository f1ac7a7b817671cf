//! Cell after cell: each takes the forces that meet its conditions, those of all others held.
//!
//! Block Gauss-Seidel of nonsmooth contact dynamics (Jean 1999, *Comput. Methods Appl. Mech. Engrg.* 177, 235). For
//! known bounds of friction every step makes a convex function smaller; with bounds that follow F_z there is no proof
//! of convergence for large friction, which is why the number of sweeps is limited.

use super::conditions::{Conditions, onto_disc};
use super::product::Vector;
use crate::tyre::influence::TractionInfluence;

/// Steps of a cell towards its conditions in a sweep.
const CELL_STEPS: usize = 2;

/// Improves the forces by `sweeps` sweeps. `cells` lists the cells that may touch; `displacements` are those of the
/// forces, and remain so on these cells.
pub(super) fn sweep(
    influence: &TractionInfluence,
    conditions: &Conditions<'_>,
    cells: &[usize],
    forces: &mut [Vector],
    displacements: &mut [Vector],
    sweeps: usize,
) {
    let Some(&middle) = cells.first() else { return };
    let middle_block = influence.block(middle, middle);
    let rigidity = 1.0 / middle_block[0][0].max(middle_block[1][1]);
    for sweep in 0..sweeps {
        let mut visit = |cell: usize| {
            let block = influence.block(cell, cell);
            let (begin, mut u) = (forces[cell], displacements[cell]);
            let mut force = begin;
            let d = conditions.required[cell];
            for _ in 0..CELL_STEPS {
                let old = force;
                force[2] = (force[2] - (u[2] - d) / block[2][2]).max(0.0);
                add_block(&block, [0.0, 0.0, force[2] - old[2]], &mut u);
                let slip = conditions.slip(cell, u);
                let trial = [force[0] - rigidity * slip[0], force[1] - rigidity * slip[1]];
                let [x, y] = onto_disc(trial, conditions.friction[cell] * force[2]);
                add_block(&block, [x - force[0], y - force[1], 0.0], &mut u);
                (force[0], force[1]) = (x, y);
            }
            let change = [force[0] - begin[0], force[1] - begin[1], force[2] - begin[2]];
            if change.iter().any(|change| *change != 0.0) {
                forces[cell] = force;
                for &other in cells {
                    add_block(&influence.block(other, cell), change, &mut displacements[other]);
                }
            }
        };
        // Forwards and backwards: neither end is favoured.
        if sweep % 2 == 0 {
            cells.iter().copied().for_each(&mut visit)
        } else {
            cells.iter().rev().copied().for_each(&mut visit)
        }
    }
}

fn add_block(block: &[[f64; 3]; 3], force: Vector, out: &mut Vector) {
    for (out, row) in out.iter_mut().zip(block) {
        *out += row.iter().zip(force).map(|(entry, force)| entry * force).sum::<f64>();
    }
}
