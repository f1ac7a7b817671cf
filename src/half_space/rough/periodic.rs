//! Frictionless contact of a rigid rough body with an elastic half-space, both periodic along x and y.
//!
//! A pressure wave p_k displaces the surface by u_k = 2 p_k/(E* |k|). The mean mode is left out: a mean pressure
//! displaces a half-space without bound, and how much of it a finite body has is not decided here. So the mean
//! displacement is 0, and the approach is the height of the highest peak over the plane that the undeformed surface
//! reaches: it is 0 for a flat body, and that of the texture alone.
//!
//! The solver is that of `indentation` on one grid, with a given load (module `gradients`); each load starts from
//! the one before.

use super::gradients::{Boundary, Constraint, Solver};
use super::map::{HeightMap, IndentationLimits};
use crate::half_space::HalfSpaceError;

/// A body to be pressed at one load after another; each starts from the pressure of the one before.
pub(crate) struct PeriodicContact<'a> {
    map: &'a HeightMap,
    solver: Solver<'a>,
    /// Pressure/E*.
    pressure: Vec<f64>,
}

/// Solution under one load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pressed<'a> {
    /// Pressure/E*, nx x ny row-major; exactly 0 outside the contact.
    pub pressure: &'a [f64],
    /// Height of the highest peak over the plane that the undeformed surface reaches \[m\].
    pub approach: f64,
    /// Fraction of the cells that carry pressure.
    pub area_fraction: f64,
    /// Iterations done.
    pub iterations: usize,
    /// Largest violation of the contact conditions, relative to the approach.
    pub residual: f64,
}

impl<'a> PeriodicContact<'a> {
    /// `map`: one period, with even numbers of rows and columns.
    ///
    /// # Errors
    /// [`HalfSpaceError::Shape`], [`HalfSpaceError::Odd`], [`HalfSpaceError::NotPositive`] for a cell,
    /// [`HalfSpaceError::Hole`] for a height that is not finite.
    pub(crate) fn new(map: &'a HeightMap) -> Result<Self, HalfSpaceError> {
        map.check(&[])?;
        let extent = map.extent;
        if !extent.nx.is_multiple_of(2) || !extent.ny.is_multiple_of(2) {
            return Err(HalfSpaceError::Odd { rows: extent.nx, columns: extent.ny });
        }
        let solver = Solver::new(extent, map.dx, map.dy, &map.heights, Boundary::Periodic);
        Ok(Self { map, solver, pressure: vec![0.0; extent.cells()] })
    }

    /// Solves for a mean pressure/E*.
    ///
    /// # Errors
    /// [`HalfSpaceError::NotPositive`] for a pressure or tolerance, [`HalfSpaceError::NotConverged`] after too many
    /// iterations.
    pub(crate) fn press(
        &mut self,
        mean_pressure: f64,
        limits: IndentationLimits,
    ) -> Result<Pressed<'_>, HalfSpaceError> {
        self.map.check(&[("tolerance", limits.tolerance), ("mean pressure", mean_pressure)])?;
        let cells = self.map.extent.cells() as f64;
        let progress = self.solver.run(Constraint::Sum(mean_pressure * cells), limits, &mut self.pressure)?;
        let touching = self.pressure.iter().filter(|&&p| p > 0.0).count();
        Ok(Pressed {
            pressure: &self.pressure,
            approach: self.map.peak() - progress.plane,
            area_fraction: touching as f64 / cells,
            iterations: progress.iterations,
            residual: progress.residual,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::half_space::rough::Extent;

    fn wave(cells: usize, amplitude: f64) -> HeightMap {
        let heights =
            (0..cells * 2).map(|place| amplitude * (2.0 * PI * (place / 2) as f64 / cells as f64).cos()).collect();
        HeightMap { heights, extent: Extent { nx: cells, ny: 2 }, dx: 1.0 / cells as f64, dy: 0.1 }
    }

    #[test]
    fn a_wave_pressed_flat_has_the_pressure_of_its_wave() {
        let amplitude = 1e-3;
        let map = wave(32, amplitude);
        let full = PI * amplitude;
        let mut contact = PeriodicContact::new(&map).unwrap();
        let pressed = contact.press(1.3 * full, IndentationLimits::default()).unwrap();
        assert!((pressed.area_fraction - 1.0).abs() < 1e-15);
        assert!((pressed.approach - amplitude).abs() < 1e-7 * amplitude, "{}", pressed.approach);
        for (place, &p) in pressed.pressure.iter().enumerate() {
            let expected = full * (1.3 + (2.0 * PI * (place / 2) as f64 / 32.0).cos());
            assert!((p - expected).abs() < 1e-6 * full, "{p} for {expected}");
        }
    }

    #[test]
    fn a_wave_pressed_in_part_follows_westergaard() {
        // Westergaard 1939: mean p/full = sin^2(psi), psi = pi a/lambda for a contact 2 a wide,
        // p(x) = 2 mean cos(pi x/lambda)/sin^2(psi) sqrt(sin^2(psi) - sin^2(pi x/lambda)).
        let (cells, amplitude) = (480, 1e-3);
        let map = wave(cells, amplitude);
        let full = PI * amplitude;
        let mut contact = PeriodicContact::new(&map).unwrap();
        for psi in [0.3_f64, 0.7, 1.2] {
            let mean = full * psi.sin().powi(2);
            let pressed = contact.press(mean, IndentationLimits::default()).unwrap();
            // The edge lies within a cell on either side.
            assert!((pressed.area_fraction - 2.0 * psi / PI).abs() <= 2.0 / cells as f64, "{}", pressed.area_fraction);
            let highest = 2.0 * mean / psi.sin();
            for (place, &p) in pressed.pressure.iter().enumerate() {
                let sine = (PI * (place / 2) as f64 / cells as f64).sin();
                let cosine = (1.0 - sine * sine).sqrt();
                let root = (psi.sin().powi(2) - sine * sine).max(0.0).sqrt();
                let expected = 2.0 * mean * cosine / psi.sin().powi(2) * root;
                // The pressure falls like a root at the edge: by sqrt(2 cell/a) of its height within one cell.
                let tolerance =
                    highest * if root > 0.2 * psi.sin() { 5e-3 } else { (2.0 / (cells as f64 * psi / PI)).sqrt() };
                assert!((p - expected).abs() < tolerance, "psi {psi}, cell {place}: {p:e} for {expected:e}");
            }
        }
    }

    /// Projected Gauss-Seidel on the dense matrix, with an arbitrary compliance of the mean mode, which only shifts
    /// the plane.
    fn oracle(map: &HeightMap, plane: f64) -> Vec<f64> {
        let Extent { nx, ny } = map.extent;
        let cells = nx * ny;
        let signed = |i: usize, n: usize| if 2 * i > n { i as f64 - n as f64 } else { i as f64 };
        let kernel = |dx: usize, dy: usize| {
            let mut sum = 0.0;
            for i in 0..nx {
                for j in 0..ny {
                    let k = (2.0 * PI * signed(i, nx) / (nx as f64 * map.dx))
                        .hypot(2.0 * PI * signed(j, ny) / (ny as f64 * map.dy));
                    let compliance = if i + j == 0 { 0.3 * nx as f64 * map.dx } else { 2.0 / k };
                    let phase = 2.0 * PI * ((i * dx) as f64 / nx as f64 + (j * dy) as f64 / ny as f64);
                    sum += compliance * phase.cos() / cells as f64;
                }
            }
            sum
        };
        let row: Vec<f64> = (0..cells).map(|place| kernel(place / ny, place % ny)).collect();
        let influence = |a: usize, b: usize| row[(a / ny + nx - b / ny) % nx * ny + (a % ny + ny - b % ny) % ny];
        let mut pressure = vec![0.0_f64; cells];
        for _ in 0..4000 {
            for a in 0..cells {
                let others: f64 = (0..cells).filter(|&b| b != a).map(|b| influence(a, b) * pressure[b]).sum();
                pressure[a] = ((map.heights[a] - plane - others) / influence(0, 0)).max(0.0);
            }
        }
        pressure
    }

    #[test]
    fn agrees_with_gauss_and_seidel_on_rough_patches() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for (plane, dy) in [(-3e-4, 1e-3), (2e-4, 1e-3), (6e-4, 1.7e-3)] {
            let heights: Vec<f64> = (0..64).map(|_| 1e-3 * rng.random::<f64>()).collect();
            let map = HeightMap { heights, extent: Extent { nx: 8, ny: 8 }, dx: 1e-3, dy };
            let expected = oracle(&map, plane);
            let mean = expected.iter().sum::<f64>() / 64.0;
            let mut contact = PeriodicContact::new(&map).unwrap();
            let pressed = contact.press(mean, IndentationLimits::default()).unwrap();
            let highest = expected.iter().copied().fold(0.0, f64::max);
            for (p, e) in pressed.pressure.iter().zip(&expected) {
                assert!((p - e).abs() < 1e-6 * highest, "{p:e} for {e:e}");
            }
            // The mean mode of the oracle lifts its plane by this much.
            let lifted = plane + 0.3 * 8.0 * map.dx * mean;
            let peak = map.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            assert!((pressed.approach - (peak - lifted)).abs() < 1e-8 * peak);
        }
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let odd = HeightMap { heights: vec![0.0; 6], extent: Extent { nx: 3, ny: 2 }, dx: 1.0, dy: 1.0 };
        assert!(matches!(PeriodicContact::new(&odd), Err(HalfSpaceError::Odd { rows: 3, columns: 2 })));
        let map = wave(8, 1e-3);
        let mut contact = PeriodicContact::new(&map).unwrap();
        for pressure in [0.0, -1.0, f64::NAN] {
            assert!(matches!(
                contact.press(pressure, IndentationLimits::default()),
                Err(HalfSpaceError::NotPositive { .. })
            ));
        }
    }
}
