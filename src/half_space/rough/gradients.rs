//! Constrained conjugate gradients for rough contact, preconditioned by the inverse of the influence in wavenumber
//! space.
//!
//! After Polonsky and Keer (Wear 231 (1999) 206-219), with a preconditioner as Zhao, Vollebregt and Oosterlee
//! (Comput. Mech. 55 (2015)) have it, on a free boundary. Pressures are p/E*.
//!
//! 1. Gap g = G p - (z - z_plane); with a given load z_plane is the one of mean gap 0 over the cells with p > 0.
//! 2. Working set A: p > 0 or g < 0. Stop when |g| over p > 0 and -g elsewhere are below tolerance x penetration; then
//!    G p is formed anew and the test repeated, so that the residual holds no accumulated rounding.
//! 3. Residual r = -g on A; preconditioned residual z = (W r) on A, W ~ |k|/2 the inverse of the influence's lattice
//!    spectrum on the *unpadded* periodic grid: its kernel falls like distance^-3, so neither wrap-around nor single
//!    precision harms, and it costs an eighth of a product with G.
//! 4. Direction t = z + beta t on A, beta = max(0, z.(r - r_old)/(z_old.r_old)) (Polak-Ribiere: restarts by itself
//!    when A or the rounding of W changes). With a given load z and t are kept at sum 0 by subtracting a multiple of W
//!    1 on A.
//! 5. p += alpha t, alpha = r.t/(t.G t). Negative pressures are cut to 0 (and the sum restored), G p then formed anew;
//!    otherwise G p += alpha G t.
//!
//! Cost of an iteration: one product with G (two if pressures were cut), one with W, a dozen passes over the grid. Sums
//! are taken row by row and then over the rows in order: the same bits for any number of threads.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::convolution::{Convolution, Extent};
use super::map::IndentationLimits;
use crate::half_space::{HalfSpaceError, love};
use crate::numeric::transform_length;

/// Prescribed quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Constraint {
    /// Sum of p/E* over the cells.
    Sum(f64),
    /// Height of the body that the undeformed surface reaches \[m\].
    Plane(f64),
}

/// How a run ended.
pub(super) struct GradientOutcome {
    pub plane: f64,
    pub iterations: usize,
    pub convolutions: usize,
    pub residual: f64,
}

/// Boundary condition of the half-space outside the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Boundary {
    /// The bare half-space.
    Free,
    /// Periodic continuation of the grid in both directions; the mean pressure causes no displacement. Both numbers of
    /// cells are even, at least 2.
    Periodic,
}

/// Work arrays and operators of one grid.
pub(super) struct Solver<'a> {
    extent: Extent,
    heights: &'a [f64],
    peak: f64,
    influence: Convolution<f64>,
    inverse: Convolution<f32>,
    displacement: Vec<f64>,
    /// Residual on the working set, 0 elsewhere; and the previous one.
    residual: Vec<f64>,
    previous: Vec<f64>,
    preconditioned: Vec<f64>,
    direction: Vec<f64>,
    response: Vec<f64>,
    /// W 1 on the working set.
    unit: Vec<f64>,
    set: Vec<bool>,
    occupied: Vec<bool>,
    convolutions: usize,
}

/// W by its spectrum: 1/sum over the images of 2/|k| sinc sinc, for wavenumbers 2 pi i/mx, 2 pi j/my per cell.
fn inverse_influence(extent: Extent, dx: f64, dy: f64) -> Convolution<f32> {
    /// Images on either side: further ones change W by some percent at the highest wavenumbers only.
    const IMAGES: i32 = 2;
    let padded = Extent { nx: transform_length(extent.nx), ny: transform_length(extent.ny) };
    let (step_x, step_y) = (2.0 * PI / (padded.nx as f64 * dx), 2.0 * PI / (padded.ny as f64 * dy));
    // sin(k d/2) is the same for all images but for its sign.
    let images = |i: usize, step: f64, spacing: f64| -> Vec<(f64, f64)> {
        let sine = (0.5 * i as f64 * step * spacing).sin();
        let image = |m: i32| {
            let k = i as f64 * step + 2.0 * PI * f64::from(m) / spacing;
            let sinc =
                if k.abs() > 0.0 { sine * if m % 2 == 0 { 1.0 } else { -1.0 } / (0.5 * k * spacing) } else { 1.0 };
            (k * k, sinc)
        };
        (-IMAGES..=IMAGES).map(image).collect()
    };
    let along: Vec<_> = (0..=padded.nx / 2).map(|i| images(i, step_x, dx)).collect();
    let across: Vec<_> = (0..=padded.ny / 2).map(|j| images(j, step_y, dy)).collect();
    let mean = 0.25 * step_x.min(step_y);
    Convolution::from_spectrum(extent, padded, |i, j| {
        if i == 0 && j == 0 {
            // Mean mode of a finite patch: as half the lowest wavenumber.
            return mean;
        }
        let sum: f64 =
            along[i].iter().flat_map(|x| across[j].iter().map(move |y| 2.0 * x.1 * y.1 / (x.0 + y.0).sqrt())).sum();
        1.0 / sum
    })
}

/// G of the periodic half-space: 2/|k| for each wave of the grid, 0 for the mean.
fn periodic_influence(extent: Extent, dx: f64, dy: f64) -> Convolution<f64> {
    let (step_x, step_y) = (2.0 * PI / (extent.nx as f64 * dx), 2.0 * PI / (extent.ny as f64 * dy));
    Convolution::from_spectrum(extent, extent, |i, j| {
        if i == 0 && j == 0 { 0.0 } else { 2.0 / (i as f64 * step_x).hypot(j as f64 * step_y) }
    })
}

impl<'a> Solver<'a> {
    pub(super) fn new(extent: Extent, dx: f64, dy: f64, heights: &'a [f64], boundary: Boundary) -> Self {
        let cells = extent.cells();
        let influence = match boundary {
            Boundary::Free => {
                Convolution::from_kernel(extent, |i, j| love::displacement(i as f64 * dx, j as f64 * dy, dx, dy))
            }
            Boundary::Periodic => periodic_influence(extent, dx, dy),
        };
        Self {
            extent,
            heights,
            peak: heights.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            influence,
            inverse: inverse_influence(extent, dx, dy),
            displacement: vec![0.0; cells],
            residual: vec![0.0; cells],
            previous: vec![0.0; cells],
            preconditioned: vec![0.0; cells],
            direction: vec![0.0; cells],
            response: vec![0.0; cells],
            unit: vec![0.0; cells],
            set: vec![false; cells],
            occupied: vec![false; extent.nx],
            convolutions: 0,
        }
    }

    /// Solves from the start value in `pressure` (zeros: a guess is made), which receives the solution.
    pub(super) fn run(
        &mut self,
        constraint: Constraint,
        limits: IndentationLimits,
        pressure: &mut [f64],
    ) -> Result<GradientOutcome, HalfSpaceError> {
        self.start(constraint, pressure);
        let given_load = matches!(constraint, Constraint::Sum(_));
        let (mut fresh, mut old_product) = (true, 0.0);
        let mut worst = f64::INFINITY;
        let mut iterations = 0;
        while iterations <= limits.iterations {
            let plane = match constraint {
                Constraint::Plane(plane) => plane,
                Constraint::Sum(_) => self.mean_plane(pressure),
            };
            let (violation, changed) = self.gaps(pressure, plane);
            worst = violation / (self.peak - plane).abs();
            // Converged: only a displacement that was formed anew counts, see step 2 of the head.
            if worst <= limits.tolerance {
                if fresh {
                    return Ok(GradientOutcome { plane, iterations, convolutions: self.convolutions, residual: worst });
                }
                self.displace(pressure);
                fresh = true;
                continue;
            }
            iterations += 1;
            let product = self.turn(given_load, changed, old_product);
            let cut = self.step(pressure);
            if let Constraint::Sum(sum) = constraint
                && cut
            {
                let total: f64 = row_sums(pressure, self.extent.ny);
                let scale = sum / total;
                pressure.par_iter_mut().for_each(|p| *p *= scale);
            }
            if cut {
                self.displace(pressure);
            }
            fresh = cut;
            old_product = product;
        }
        Err(HalfSpaceError::NotConverged { iterations: limits.iterations, residual: worst })
    }

    /// Makes the start value admissible (guesses one where it is 0) and forms its displacement.
    fn start(&mut self, constraint: Constraint, pressure: &mut [f64]) {
        match constraint {
            Constraint::Plane(plane) => {
                let given = pressure.iter().any(|&p| p > 0.0);
                for (p, &z) in pressure.iter_mut().zip(self.heights) {
                    // Cells below the plane never touch.
                    *p = if z <= plane {
                        0.0
                    } else if given {
                        *p
                    } else {
                        z - plane
                    };
                }
                self.displace(pressure);
                if !given {
                    // A body's shape as pressure, scaled to displace by the overlap on average.
                    let overlap: f64 = pressure.iter().sum();
                    let loaded = pressure.iter().zip(&self.displacement).filter(|(p, _)| **p > 0.0);
                    let scale = overlap / loaded.map(|(_, u)| u).sum::<f64>();
                    pressure.iter_mut().chain(&mut self.displacement).for_each(|value| *value *= scale);
                }
            }
            Constraint::Sum(sum) => {
                let total: f64 = pressure.iter().sum();
                if total > 0.0 {
                    pressure.iter_mut().for_each(|p| *p *= sum / total);
                } else {
                    pressure.fill(sum / pressure.len() as f64);
                }
                self.displace(pressure);
            }
        }
    }

    fn displace(&mut self, pressure: &[f64]) {
        self.influence.apply(pressure, &mut self.displacement, |_| true);
        self.convolutions += 1;
    }

    /// Plane of mean gap 0 over the cells that carry pressure.
    fn mean_plane(&self, pressure: &[f64]) -> f64 {
        let ny = self.extent.ny;
        let rows = pressure.par_chunks(ny).zip(self.displacement.par_chunks(ny)).zip(self.heights.par_chunks(ny));
        let sums: Vec<(f64, f64)> = rows
            .map(|((p, u), z)| {
                let loaded = p.iter().zip(u).zip(z).filter(|((p, _), _)| **p > 0.0);
                loaded.fold((0.0, 0.0), |(sum, count), ((_, u), z)| (sum + z - u, count + 1.0))
            })
            .collect();
        let (sum, count) = sums.iter().fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
        sum / count
    }

    /// Sets residual and working set for the current plane; returns the largest violation \[m\] and whether the set
    /// changed.
    fn gaps(&mut self, pressure: &[f64], plane: f64) -> (f64, bool) {
        let ny = self.extent.ny;
        std::mem::swap(&mut self.residual, &mut self.previous);
        let given = pressure.par_chunks(ny).zip(self.displacement.par_chunks(ny)).zip(self.heights.par_chunks(ny));
        let made = self.residual.par_chunks_mut(ny).zip(self.set.par_chunks_mut(ny)).zip(&mut self.occupied);
        let rows: Vec<(f64, bool)> = given
            .zip(made)
            .map(|(((p, u), z), ((r, set), occupied))| {
                let (mut violation, mut changed) = (0.0f64, false);
                *occupied = false;
                for j in 0..ny {
                    let gap = u[j] - (z[j] - plane);
                    let loaded = p[j] > 0.0;
                    let inside = loaded || gap < 0.0;
                    violation = violation.max(if loaded { gap.abs() } else { -gap });
                    r[j] = if inside { -gap } else { 0.0 };
                    changed |= inside != set[j];
                    set[j] = inside;
                    *occupied |= inside;
                }
                (violation, changed)
            })
            .collect();
        rows.iter().fold((0.0, false), |a, b| (f64::max(a.0, b.0), a.1 | b.1))
    }

    /// Sets the new direction (step 4 of the head); returns z.r.
    fn turn(&mut self, given_load: bool, set_changed: bool, old_product: f64) -> f64 {
        let ny = self.extent.ny;
        let occupied = &self.occupied;
        // 1. W 1 on A, for the sums.
        if given_load && set_changed {
            let ones: Vec<f64> = self.set.iter().map(|&inside| if inside { 1.0 } else { 0.0 }).collect();
            self.inverse.apply(&ones, &mut self.unit, |row| occupied[row]);
            keep_set(&mut self.unit, &self.set, ny);
        }
        // 2. z = W r on A, with a given load at sum 0.
        self.inverse.apply(&self.residual, &mut self.preconditioned, |row| occupied[row]);
        keep_set(&mut self.preconditioned, &self.set, ny);
        let unit_sum = if given_load { row_sums(&self.unit, ny) } else { 0.0 };
        if given_load {
            let excess = row_sums(&self.preconditioned, ny) / unit_sum;
            self.preconditioned.par_iter_mut().zip(&self.unit).for_each(|(z, unit)| *z -= excess * unit);
        }
        let product = dot(&self.preconditioned, &self.residual, ny);
        // 3. t = z + beta t.
        let beta = if old_product > 0.0 {
            ((product - dot(&self.preconditioned, &self.previous, ny)) / old_product).max(0.0)
        } else {
            0.0
        };
        let set = &self.set;
        self.direction.par_iter_mut().zip(&self.preconditioned).zip(set).for_each(|((t, z), &inside)| {
            *t = if inside { z + beta * *t } else { 0.0 };
        });
        if given_load {
            let excess = row_sums(&self.direction, ny) / unit_sum;
            self.direction.par_iter_mut().zip(&self.unit).for_each(|(t, unit)| *t -= excess * unit);
        }
        product
    }

    /// One step along the direction (step 5); true if pressures had to be cut, and the displacement is then out of
    /// date.
    fn step(&mut self, pressure: &mut [f64]) -> bool {
        let ny = self.extent.ny;
        self.influence.apply(&self.direction, &mut self.response, |_| true);
        self.convolutions += 1;
        let alpha = dot(&self.residual, &self.direction, ny) / dot(&self.direction, &self.response, ny);
        let cuts: Vec<bool> = pressure
            .par_chunks_mut(ny)
            .zip(self.direction.par_chunks(ny))
            .map(|(p, t)| {
                let mut cut = false;
                for (p, t) in p.iter_mut().zip(t) {
                    let next = *p + alpha * t;
                    cut |= next < 0.0;
                    *p = next.max(0.0);
                }
                cut
            })
            .collect();
        let cut = cuts.contains(&true);
        if !cut {
            self.displacement.par_iter_mut().zip(&self.response).for_each(|(u, q)| *u += alpha * q);
        }
        cut
    }
}

fn keep_set(values: &mut [f64], set: &[bool], ny: usize) {
    values.par_chunks_mut(ny).zip(set.par_chunks(ny)).for_each(|(values, set)| {
        for (value, &inside) in values.iter_mut().zip(set) {
            *value = if inside { *value } else { 0.0 };
        }
    });
}

/// Sum of all values, row by row: the order does not depend on the number of threads.
fn row_sums(values: &[f64], ny: usize) -> f64 {
    let rows: Vec<f64> = values.par_chunks(ny).map(|row| row.iter().sum()).collect();
    rows.iter().sum()
}

/// Scalar product, row by row as [`row_sums`].
fn dot(a: &[f64], b: &[f64], ny: usize) -> f64 {
    let row = |(a, b): (&[f64], &[f64])| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let rows: Vec<f64> = a.par_chunks(ny).zip(b.par_chunks(ny)).map(row).collect();
    rows.iter().sum()
}
