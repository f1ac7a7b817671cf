//! Drawing a random surface piece by piece.
//!
//! 1. The spectrum is divided into [levels](super::levels) of some octaves each. The correlation of short waves extends
//!    over a few millimetres: they are drawn with a short lateral period, long ones on a coarse lattice.
//! 2. Each level is drawn patch by patch, its position and its random numbers fixed on the road.
//! 3. A row of the run's cells is interpolated along in the patches of all levels, by a windowed sinc, all columns at
//!    once.
//! 4. For a road that is not Gaussian, each height is transformed separately.
//!
//! The spectrum is scene data and the random numbers belong to the waves of a patch, so the road is the same at any
//! number of elements and cells, up to the resolution of the cells. Results depend neither on the order of access nor
//! on the number of threads.

use std::collections::VecDeque;

use pulp::Arch;
use rayon::prelude::*;

use super::levels::{Patch, WaveLevel};
use super::rings::RingSpectrum;
use super::rows::{Interpolation, LANES};
use super::shape::{HeightShape, ShapeTable};
use super::sizes::{MOST_PATCHES, Sizes};
use super::target::TargetSpectrum;
use super::translation::corrected;
use crate::road::error::RoadError;
use crate::road::lattice::Lattice;

/// Rows that one thread interpolates at a time.
const BLOCK: usize = 32;

/// A texture to be drawn.
#[derive(Clone)]
pub(crate) struct RoadDesign {
    /// Levels of its profiles.
    pub target: TargetSpectrum,
    /// Transformation of the heights, unless they are Gaussian.
    pub shape: Option<HeightShape>,
    /// Spacing of the road's lattice \[m\], which bounds its shortest wavelength.
    pub spacing: f64,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// A random isotropic surface on a run's lattice.
pub(crate) struct Texture {
    spectrum: RingSpectrum,
    lattice: Lattice,
    levels: Vec<WaveLevel>,
    /// Transformation to heights other than Gaussian.
    shape: Option<ShapeTable>,
    /// Number of rows within half a block of the shortest waves: so few do not need more patches than are stored.
    piece: usize,
}

impl Texture {
    /// Prepares a texture: `limit` bounds the bytes of its working arrays.
    ///
    /// # Errors
    /// A spacing too coarse for the spectrum's shortest wavelength; working arrays beyond `limit`.
    pub(crate) fn new(design: &RoadDesign, lattice: Lattice, limit: u64) -> Result<Self, RoadError> {
        let RoadDesign { target, shape, spacing, seed } = design;
        let sizes = Sizes::new(target, *spacing, lattice, limit)?;
        let spectrum = shape.as_ref().map_or_else(|| RingSpectrum::fit(target), |shape| corrected(target, shape));
        let rms = spectrum.variance().sqrt();
        let shape = shape.as_ref().map(|shape| ShapeTable::new(shape, rms));
        let shortest = sizes.levels.iter().map(|level| level.block).fold(f64::INFINITY, f64::min);
        // Numbered from the longest waves: they stay the same whichever of the shorter ones a run resolves.
        let all = sizes.levels.len() as u64;
        let levels = sizes
            .levels
            .into_iter()
            .enumerate()
            .map(|(place, sizes)| WaveLevel::new(&spectrum, sizes, all - 1 - place as u64, *seed, lattice));
        let levels = levels.collect();
        Ok(Self {
            levels,
            shape,
            spectrum,
            lattice,
            piece: ((0.5 * shortest / lattice.cell()) as usize).clamp(1, 1 << 20),
        })
    }

    /// The two-dimensional spectrum, with its deviation from the target.
    pub(crate) fn spectrum(&self) -> &RingSpectrum {
        &self.spectrum
    }

    /// Computes the heights \[m\] of the rows from `first` on that fill `heights`.
    pub(crate) fn rows(&self, first: i64, patches: &mut Patches, heights: &mut [f64]) {
        let columns = self.lattice.columns;
        patches.levels.resize_with(self.levels.len(), VecDeque::new);
        // 1. The patches under a piece of rows are drawn, if they are not stored.
        for (piece, heights) in heights.chunks_mut(self.piece * columns).enumerate() {
            let first = first + (piece * self.piece) as i64;
            let last = first + (heights.len() / columns) as i64 - 1;
            for (level, stored) in self.levels.iter().zip(&mut patches.levels) {
                let (from, to) = (level.place(&self.lattice, first), level.place(&self.lattice, last));
                let from = from.block - i64::from(from.weights[1] > 0.0);
                for block in from..=to.block {
                    draw(level, block, stored, &mut patches.amplitudes);
                }
            }
            // 2. The rows are interpolated in them.
            let stored = &patches.levels;
            heights.par_chunks_mut(BLOCK * columns).enumerate().for_each_init(
                Default::default,
                |space, (number, heights)| {
                    self.interpolate(first + (number * BLOCK) as i64, stored, space, heights);
                },
            );
        }
    }

    fn interpolate(&self, first: i64, stored: &[VecDeque<(i64, Patch)>], space: &mut Rows, heights: &mut [f64]) {
        let columns = self.lattice.columns;
        let Rows { sums, weights } = space;
        sums.resize(columns.div_ceil(LANES), [0.0; LANES]);
        let arch = Arch::new();
        for (row, heights) in (first..).zip(heights.chunks_exact_mut(columns)) {
            sums.fill([0.0; LANES]);
            for (level, stored) in self.levels.iter().zip(stored) {
                let place = level.place(&self.lattice, row);
                for (before, &factor) in place.weights.iter().enumerate() {
                    let block = place.block - before as i64;
                    if factor > 0.0
                        && let Some((_, patch)) = stored.iter().find(|(held, _)| *held == block)
                    {
                        let sample = place.sample + before as f64 * level.pitch();
                        let samples = level.samples(patch, sample, factor, weights);
                        arch.dispatch(Interpolation { sums, weights, samples });
                    }
                }
            }
            heights.iter_mut().zip(sums.as_flattened()).for_each(|(height, &sum)| *height = f64::from(sum));
            if let Some(shape) = &self.shape {
                shape.apply(heights);
            }
        }
    }
}

/// Draws a patch unless it is stored; the oldest one of more than [`MOST_PATCHES`] is dropped.
fn draw(level: &WaveLevel, block: i64, stored: &mut VecDeque<(i64, Patch)>, amplitudes: &mut Vec<f32>) {
    if stored.iter().any(|(held, _)| *held == block) {
        return;
    }
    let oldest = if stored.len() == MOST_PATCHES { stored.pop_front() } else { None };
    let (_, mut heights) = oldest.unwrap_or_default();
    level.patch(block, amplitudes, &mut heights);
    stored.push_back((block, heights));
}

/// Patches drawn before, the last few of each level, and scratch to draw the next.
#[derive(Default)]
pub(crate) struct Patches {
    levels: Vec<VecDeque<(i64, Patch)>>,
    amplitudes: Vec<f32>,
}

/// Work arrays for a row.
#[derive(Default)]
struct Rows {
    sums: Vec<[f32; LANES]>,
    weights: Vec<f32>,
}
