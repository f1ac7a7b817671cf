//! Displacements by forces, and sweeps of projected Gauss-Seidel over the points: what every search for the forces
//! begins with.

use pulp::{Arch, Simd, WithSimd};

use super::windows::{add_row, add_windows};

/// G0 by distance, from 1 - columns to columns - 1, from `influence` by distance from 0.
pub fn mirrored(influence: &[f64], columns: usize) -> Vec<f64> {
    influence[1..columns].iter().rev().chain(&influence[..columns]).copied().collect()
}

/// u = G0 F, the forces given as (point, force); `row` as from [`mirrored`].
pub fn displace(arch: Arch, displacement: &mut [f64], row: &[f64], forces: impl Iterator<Item = (usize, f64)> + Clone) {
    let last = displacement.len() - 1;
    displacement.fill(0.0);
    add_windows(arch, displacement, row, forces.map(|(point, force)| (last - point, force)));
}

/// Values of columns after the window has moved on by a number of elements: what was column i is column i - `by`.
pub fn move_on<T: Copy + Default>(values: &mut [T], by: usize) {
    let columns = values.len();
    let by = by.min(columns);
    values.copy_within(by.., 0);
    values[columns - by..].fill(T::default());
}

/// The law of a point by itself.
pub trait OwnForce {
    /// Its force while all others stay as they are, from its force so far and u = G0 F there.
    fn force(&mut self, column: usize, force: f64, displacement: f64) -> f64;
}

/// Sweeps of projected Gauss-Seidel.
pub struct Sweeps<'a, L> {
    /// How many.
    pub sweeps: usize,
    /// The points' law.
    pub law: L,
    /// Forces by column.
    pub estimate: &'a mut [f64],
    /// G0 times the estimate, kept so.
    pub displacement: &'a mut [f64],
    /// As from [`mirrored`].
    pub row: &'a [f64],
}

impl<L: OwnForce> WithSimd for Sweeps<'_, L> {
    /// Forces changed.
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> usize {
        let Self { sweeps, mut law, estimate, displacement, row } = self;
        let mut changes = 0;
        for _ in 0..sweeps {
            for (column, estimate) in estimate.iter_mut().enumerate() {
                let force = law.force(column, *estimate, displacement[column]);
                let change = force - *estimate;
                *estimate = force;
                if change != 0.0 {
                    changes += 1;
                    add_row(simd, displacement, &row[displacement.len() - 1 - column..], change);
                }
            }
        }
        changes
    }
}
