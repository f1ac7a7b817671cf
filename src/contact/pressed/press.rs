//! A block of road pressed by the flat tread, deeper and deeper: forces and yielding of its slices.
//!
//! At each approach F >= 0, G F >= d over all cells, d = depth + z - crown, depth counted from where the highest cell
//! touches: the search for cells in contact. With F_i the sum over a slice, and its highest point z_i less the crown,
//!
//! ```text
//! p_i = depth + z_i - (G_line F)_i,
//! ```
//!
//! G_line the influence of lines ([`line_influence`]) by the same G.
//!
//! 1. The depth at which the mean pressure is [`TOP_PRESSURE`] within [`NEAR`], by a power of the depth through the
//!    last two loads, with searches of a low tolerance.
//! 2. [`APPROACHES`] depths up to there, closer at first, each search from the forces of the one before.
//! 3. The points of each slice as a concave curve ([`Yielding`]).

use std::ops::Range;

use super::flat_tread::{FlatTread, line_influence};
use super::yielding::Yielding;
use crate::contact::cells::{CellSearch, InstantCells};
use crate::road::Lattice;

/// Approaches at which a block is pressed. Twice as many change third octaves of the force on a chip seal by up to 0.3
/// dB, that of 25 mm by 0.7 dB, and their error relative to cells by 0.01 dB on average.
pub(crate) const APPROACHES: usize = 20;
/// Mean pressure at the last of them \[Pa\]: some three times a tyre's, since single slices carry more than the mean.
pub(crate) const TOP_PRESSURE: f64 = 1e6;
/// Power of the depths' spacing.
const CLOSER: f64 = 1.3;
/// How far cells may be from where they are required to be, relative to the depth; a thirtieth of it changes no third
/// octave by 0.1 dB.
const TOLERANCE: f64 = 3e-4;
/// The same while the last depth is searched for, and how near to its load it is found.
const ROUGHLY: f64 = 1e-2;
const NEAR: f64 = 0.05;
/// First depth that is tried, in thicknesses of the tread, and the most depths.
const FIRST_DEPTH: f64 = 0.15;
const DEPTHS: usize = 20;

/// A press for blocks of one size.
pub(crate) struct Press {
    search: CellSearch,
    lattice: Lattice,
    /// Height of the tread above its middle by cell across \[m\].
    crown: Vec<f64>,
    line: Vec<f64>,
    first_depth: f64,
    spring: f64,
    /// z - crown less the highest of them \[m\]; -infinity without road.
    relief: Vec<f64>,
    required: Vec<f64>,
    forces: Vec<f64>,
    /// By slice.
    sums: Vec<f64>,
}

impl Press {
    /// Press for blocks of `elements` elements. `crown`: height of the tread above its middle by cell across \[m\].
    pub(crate) fn new(tread: &FlatTread, lattice: Lattice, crown: Vec<f64>, elements: usize) -> Self {
        let influence = tread.influence(lattice, elements);
        let zeros = vec![0.0; elements * lattice.cells()];
        Self {
            line: line_influence(&influence, lattice),
            search: CellSearch::new(InstantCells::new(influence), TOLERANCE),
            lattice,
            crown,
            first_depth: FIRST_DEPTH * tread.thickness(),
            spring: tread.spring(lattice),
            relief: zeros.clone(),
            required: zeros.clone(),
            forces: zeros,
            sums: vec![0.0; elements],
        }
    }

    /// Presses a block whose cells have these heights \[m\], element by element, -infinity where there is no road;
    /// returns how its `slices` yield. No result depends on what was pressed before.
    pub(crate) fn press(&mut self, heights: &[f64], slices: Range<usize>) -> Vec<Yielding> {
        let cells = self.lattice.cells();
        for (relief, row) in self.relief.chunks_mut(self.lattice.columns).zip(heights.chunks(self.lattice.columns)) {
            relief.iter_mut().zip(row).zip(&self.crown).for_each(|((relief, z), crown)| *relief = z - crown);
        }
        let highest_of = |cells: &[f64]| cells.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let peaks: Vec<f64> = self.relief.chunks(cells).map(highest_of).collect();
        let highest = highest_of(&peaks);
        if !highest.is_finite() {
            return Vec::new();
        }
        self.relief.iter_mut().for_each(|relief| *relief -= highest);
        let top = self.top_depth();
        let mut points: Vec<Vec<[f64; 2]>> = vec![Vec::with_capacity(APPROACHES); slices.len()];
        let mut held = vec![0.0; slices.len()];
        self.forces.fill(0.0);
        for approach in 1..=APPROACHES {
            let depth = top * (approach as f64 / APPROACHES as f64).powf(CLOSER);
            self.at(depth);
            for (sum, forces) in self.sums.iter_mut().zip(self.forces.chunks(cells)) {
                *sum = forces.iter().sum();
            }
            for ((place, points), held) in slices.clone().zip(&mut points).zip(&mut held) {
                *held = depth - highest + peaks[place] - self.line_displacement(place);
                if self.sums[place] > 0.0 {
                    points.push([self.sums[place], *held]);
                }
            }
        }
        let curve = |((place, points), held): ((usize, Vec<[f64; 2]>), f64)| {
            if points.is_empty() {
                Yielding::held_off(peaks[place], held, self.spring)
            } else {
                Yielding::above(peaks[place], &points, self.spring)
            }
        };
        slices.zip(points).zip(held).map(curve).collect()
    }

    /// Presses to a depth \[m\], starting from the present forces; returns their sum \[N\].
    fn at(&mut self, depth: f64) -> f64 {
        self.required.iter_mut().zip(&self.relief).for_each(|(required, relief)| *required = depth + relief);
        self.search.solve(&self.required, &mut self.forces);
        self.forces.iter().sum()
    }

    /// Forces \[N\] on the cells of the last block, at a depth \[m\], and their sum.
    #[cfg(test)]
    pub(super) fn at_depth(&mut self, depth: f64) -> (&[f64], f64) {
        let load = self.at(depth);
        (&self.forces, load)
    }

    /// Depth \[m\] at which the mean pressure over the cells that have road is [`TOP_PRESSURE`].
    fn top_depth(&mut self) -> f64 {
        let there = self.relief.iter().filter(|relief| relief.is_finite()).count();
        let wanted = TOP_PRESSURE * there as f64 * self.lattice.cell() * self.lattice.dy;
        self.search.set_tolerance(ROUGHLY);
        self.forces.fill(0.0);
        let (mut depth, mut last) = (self.first_depth, None::<[f64; 2]>);
        for _ in 0..DEPTHS {
            let load = self.at(depth);
            let share = wanted / load;
            if (share - 1.0).abs() < NEAR {
                break;
            }
            // Load grows with depth, by a power of about 2.
            let power = last.map_or(2.0, |[d, l]| (load / l).ln() / (depth / d).ln());
            last = Some([depth, load]);
            depth *= share.powf(power.clamp(1.0, 4.0).recip()).clamp(0.2, 5.0);
        }
        self.search.set_tolerance(TOLERANCE);
        depth
    }

    /// (G_line F) of a slice \[m\].
    fn line_displacement(&self, place: usize) -> f64 {
        self.sums.iter().enumerate().map(|(other, force)| self.line[other.abs_diff(place)] * force).sum()
    }
}
