//! Cells of the contact strip and their shapes in the tyre's waves: geometry only.
//!
//! Cells are dx along by dy = b/M across, i counts along, j across, y_j = B/2 - b/2 + (j + 1/2) dy. A cell is loaded
//! uniformly and its mean displacement observed: along, that weights a wave by sinc(kx dx/2), and across by
//!
//! ```text
//! s_m(y_j) = cos(ky y_j) sinc(ky dy/2)      (guided sides; sin where they are supported)
//! ```

use std::f64::consts::PI;

use super::projection::Projection;
use super::waves::Waves;
use crate::numeric::sinc;
use crate::scene::{Sides, Tyre};

/// Cells of the contact strip.
#[derive(Clone, Debug, PartialEq)]
pub struct CellGrid {
    /// Waves and elements along.
    along: Projection,
    /// Cells M across the strip.
    pub across: usize,
    /// True if cells carry long waves alone: see [`Self::of_long_waves`].
    fades: bool,
}

/// Phases over a cell, in half turns, between which waves fade out on cells of long waves.
const FADES: [f64; 2] = [0.6, 0.95];

/// Part of a wave that cells of long waves carry, by its phase over a cell along or across.
pub(crate) fn carried(phase: f64) -> f64 {
    let [start, end] = FADES.map(|half_turns| half_turns * PI);
    (0.5 * PI * ((phase.abs() - start) / (end - start)).clamp(0.0, 1.0)).cos().powi(2)
}

impl CellGrid {
    /// N = `elements` cells round the tyre by M = `across` over its contact width.
    pub fn new(tyre: &Tyre, elements: usize, across: usize) -> Self {
        Self { along: Projection::new(tyre, elements), across, fades: false }
    }

    /// The same cells, carrying no waves that are shorter than about two of them. What remains has no inverse.
    #[must_use]
    pub(crate) fn of_long_waves(self) -> Self {
        Self { fades: true, ..self }
    }

    /// True if short waves fade out.
    pub(super) fn fades(&self) -> bool {
        self.fades
    }

    /// Part of the wave of these numbers that cells carry.
    pub(super) fn carried(&self, n: i64, m: usize) -> f64 {
        let waves = self.waves();
        if self.fades { carried(waves.kx(n) * self.length()) * carried(waves.ky(m) * self.pitch()) } else { 1.0 }
    }

    pub(crate) fn waves(&self) -> Waves {
        self.along.waves
    }

    /// The same cells on a ring of so many, if given, instead of round the tyre: its waves are then those of the ring.
    pub fn on_ring(mut self, ring: Option<usize>) -> Self {
        if let Some(cells) = ring {
            self.along.waves.circumference = cells as f64 * self.along.element;
            self.along.elements = cells;
        }
        self
    }

    /// Cells N round the tyre, or the ring.
    pub fn elements(&self) -> usize {
        self.along.elements
    }

    /// Length dx of a cell along \[m\].
    pub fn length(&self) -> f64 {
        self.along.element
    }

    /// Width dy of a cell \[m\].
    pub fn pitch(&self) -> f64 {
        self.along.contact_width / self.across as f64
    }

    /// Position of a cell's middle, from the tyre's middle to the left \[m\].
    pub fn from_middle(&self, j: usize) -> f64 {
        (j as f64 + 0.5) * self.pitch() - 0.5 * self.along.contact_width
    }

    /// Width nearest to the tyre's \[m\] at which the sides are whole numbers of cells away from the strip: there, m
    /// and 2 B/dy - m are the same on cells, up to a sign.
    pub fn width_in_cells(&self) -> f64 {
        let strip = self.along.contact_width;
        strip + ((self.waves().width - strip) / self.pitch()).round() * self.pitch()
    }

    /// Lateral numbers 2 B/dy after which waves are the same on cells, up to a sign, where sides are whole cells away.
    pub(super) fn lateral_period(&self) -> usize {
        2 * (self.waves().width / self.pitch()).round() as usize
    }

    /// Lowest lateral number whose wave is the same as that of m on cells, where sides are whole cells away.
    pub(super) fn same_on_cells(&self, m: usize) -> usize {
        let all = self.lateral_period();
        (m % all).min(all - m % all)
    }

    /// True if any cell lies off the nodes of m; the highest m may have a node in the middle of every cell.
    pub(super) fn is_felt(&self, m: usize) -> bool {
        /// Largest value at a node by rounding.
        const ROUNDING: f64 = 1e-9;
        (0..self.across).any(|j| self.wave(m, j).abs() > ROUNDING)
    }

    /// Lateral wave at y_j, without the mean over the cell: cos or sin of ky y_j.
    pub fn wave(&self, m: usize, j: usize) -> f64 {
        let waves = self.waves();
        let phase = waves.ky(m) * (0.5 * waves.width + self.from_middle(j));
        match waves.sides {
            Sides::Supported => phase.sin(),
            Sides::Guided => phase.cos(),
        }
    }

    /// s_m(y_j), the mean of the wave over a cell.
    pub fn shape(&self, m: usize, j: usize) -> f64 {
        self.wave(m, j) * sinc(0.5 * self.waves().ky(m) * self.pitch())
    }

    /// a_m = (1/M) sum_j s_m(y_j), the mean over the strip: zero for waves that are odd about mid-width.
    pub fn mean_shape(&self, m: usize) -> f64 {
        let waves = self.waves();
        let even = if waves.is_even(m) { waves.sign_about_middle(m) } else { 0.0 };
        even * waves.lateral_share(m, self.along.contact_width)
    }

    /// Lateral numbers, up to `last`, that make up the mean over the strip: of forces that are uncorrelated from cell
    /// to cell, and waves so short along that all m answer alike, no more than the fraction `tolerance` of the mean
    /// square is left out. Of longer waves it is less.
    pub fn numbers_in_mean(&self, tolerance: f64, last: usize) -> Vec<usize> {
        let waves = self.waves();
        // The sum over all numbers is 1/b.
        let mut rest = 1.0;
        let numbers = waves.lateral_numbers().take_while(|&m| {
            let wanted = m <= last && rest > tolerance;
            rest -= waves.lateral_weight(m, self.along.contact_width) * self.along.contact_width;
            wanted
        });
        numbers.collect()
    }

    /// sinc^2(ky dy/2) times the norm of the lateral wave, 2/B (1/B for m = 0) \[1/m\]: the factor that all pairs of
    /// cells share.
    pub(super) fn lateral_weight(&self, m: usize) -> f64 {
        let share = sinc(0.5 * self.waves().ky(m) * self.pitch());
        share * share * self.waves().lateral_norm(m)
    }

    /// (1/L) sinc^2(kx dx/2) \[1/m\].
    pub(super) fn longitudinal_weight(&self, n: i64) -> f64 {
        self.along.longitudinal_weight(n)
    }

    /// Lateral numbers that cells can excite, from the lowest on, without end.
    pub fn lateral_numbers(&self) -> impl Iterator<Item = usize> + use<> {
        self.waves().first_lateral_number()..
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DEFAULT, PLATE, Scene};

    #[test]
    fn means_over_the_strip_are_those_of_its_cells() {
        for scene in [PLATE, DEFAULT] {
            let tyre = Scene::from_str(scene, "scene").unwrap().scene.tyre;
            for across in [1, 4, 7] {
                let grid = CellGrid::new(&tyre, 64, across);
                for m in grid.lateral_numbers().take(20) {
                    let mean = (0..across).map(|j| grid.shape(m, j)).sum::<f64>() / across as f64;
                    assert!((mean - grid.mean_shape(m)).abs() < 1e-14, "m = {m}, {across}: {mean}");
                }
            }
            let grid = CellGrid::new(&tyre, 64, 4);
            let numbers = |tolerance| grid.numbers_in_mean(tolerance, 1000).len();
            println!("{:?}", [0.1, 0.05, 0.02, 0.01].map(numbers));
            let numbers = grid.numbers_in_mean(0.02, 1000);
            let width = tyre.contact_width;
            let remainder = |count: usize| {
                1.0 - numbers[..count].iter().map(|&m| grid.waves().lateral_weight(m, width) * width).sum::<f64>()
            };
            assert!(remainder(numbers.len()) <= 0.02 && remainder(numbers.len() - 1) > 0.02, "{numbers:?}");
            assert!(numbers.iter().all(|&m| grid.waves().is_even(m)));
            assert!(grid.numbers_in_mean(0.0, 7).iter().all(|&m| m <= 7));
        }
    }
}
