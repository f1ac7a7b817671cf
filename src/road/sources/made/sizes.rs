//! Division and size of a synthesis: known from its spectrum and lattice before any array is made.

use super::target::TargetSpectrum;
use crate::counters::Work;
use crate::numeric::{transform_length, transform_multiply_adds};
use crate::road::error::{RoadError, positive};
use crate::road::lattice::Lattice;

/// Largest spacing of the road in parts of the shortest wavelength.
const LARGEST_SHARE: f64 = 0.45;
/// Wanted ratio of the wavelengths of a level: with a larger one the period needed for the longest waves makes the
/// shortest ones expensive, with a smaller one each height is summed from more levels.
const RATIO: f64 = 3.3;
/// Length of a block, in the longest wavelengths of its level.
const BLOCK: f64 = 128.0;
/// One over the part of a block that fades into the next one: eight longest wavelengths.
pub(super) const FADE: usize = 16;
/// Least lateral period in the longest wavelengths of a level, and least excess of it over the strip's width.
const PERIOD: [f64; 2] = [8.0, 4.0];
/// Least number of samples along in the shortest wave, of the shortest level and of the others: with more samples the
/// interpolation kernel is shorter, and samples of long waves cost little.
const SAMPLES: [f64; 2] = [2.8, 5.0];
/// Patches of a level that are stored: rows may lie in two, a third serves a caller that goes back.
pub(super) const MOST_PATCHES: usize = 3;
/// Cost of averaging the two-dimensional density over a cell, and of a pair of random numbers, in multiply-adds.
const COSTS: [f64; 2] = [600.0, 20.0];

/// Waves of some octaves: their lateral period, and the blocks in which they are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LevelSizes {
    /// Lowest wavenumber, cycles per metre.
    pub lower: f64,
    /// Highest wavenumber, cycles per metre.
    pub upper: f64,
    /// Lateral period \[m\].
    pub period: f64,
    /// Length of a block \[m\], including the parts that overlap with its neighbours.
    pub block: f64,
    /// Number of lateral waves that the run resolves, including the constant one.
    pub lines: usize,
    /// Number of samples along in a block.
    pub samples: usize,
}

impl LevelSizes {
    /// Spacing of the samples along \[m\].
    pub(crate) fn spacing(&self) -> f64 {
        self.block / self.samples as f64
    }

    /// Distance of successive blocks \[m\].
    pub(crate) fn pitch(&self) -> f64 {
        self.block * (1.0 - 1.0 / FADE as f64)
    }
}

/// Sizes of a synthesis.
#[derive(Clone, Debug)]
pub(crate) struct Sizes {
    /// The levels that the run's cells resolve, shortest waves first.
    pub levels: Vec<LevelSizes>,
    columns: f64,
}

impl Sizes {
    /// Chooses sizes for a spectrum on a road of `spacing` \[m\]; `limit` bounds the bytes of the working arrays.
    ///
    /// # Errors
    /// A `spacing` too coarse for the spectrum's shortest wavelength; working arrays beyond `limit`.
    pub(crate) fn new(target: &TargetSpectrum, spacing: f64, lattice: Lattice, limit: u64) -> Result<Self, RoadError> {
        positive("road.spacing", spacing)?;
        let (longest, shortest) = (target.longest(), target.shortest());
        let allowed = LARGEST_SHARE * shortest;
        if spacing > allowed * (1.0 + 1e-9) {
            return Err(RoadError::Spacing { spacing, shortest, allowed });
        }
        let count = ((longest / shortest).ln() / RATIO.ln()).round().max(1.0);
        let ratio = (longest / shortest).powf(1.0 / count);
        let [along, across] = resolved(lattice);
        let levels = (0..count as i32).map(|number| {
            let upper = ratio.powi(-number) / shortest;
            let lower = upper / ratio;
            let period = (PERIOD[0] / lower).max(lattice.width() + PERIOD[1] / lower);
            let block = BLOCK / lower;
            let samples = (SAMPLES[usize::from(number > 0)] * upper.min(along) * block / FADE as f64).ceil() as usize;
            let lines = (upper.min(across) * period + 0.5).ceil().max(1.0) as usize;
            LevelSizes { lower, upper, period, block, lines, samples: transform_length(samples.max(4)) * FADE }
        });
        let sizes = Self {
            levels: levels.filter(|level| level.lower < along.hypot(across)).collect(),
            columns: lattice.columns as f64,
        };
        let needed = sizes.bytes();
        if needed.is_nan() || needed > limit as f64 {
            return Err(RoadError::TextureTooLarge { longest, spacing, needed: needed as u64, limit });
        }
        Ok(sizes)
    }

    /// Bytes of the filters, the patches that are stored, and the arrays from which one is made.
    fn bytes(&self) -> f64 {
        let level = |level: &LevelSizes| {
            let samples = level.samples as f64;
            4.0 * samples * (3.0 * level.lines as f64 + (MOST_PATCHES as f64 + 1.0) * self.columns)
        };
        self.levels.iter().map(level).sum()
    }

    /// Work of computing the filters.
    pub(crate) fn opening(&self) -> Work {
        let level = |level: &LevelSizes| level.lines as f64 * level.block * level.upper * COSTS[0];
        let multiply_adds: f64 = self.levels.iter().map(level).sum();
        Work { multiply_adds: multiply_adds as u64, bytes: self.bytes() as u64 }
    }

    /// Multiply-adds for so many metres in so many rows: noise and a transform for each lateral wave, their sum across,
    /// interpolation along.
    pub(crate) fn drawing(&self, metres: f64, rows: f64) -> f64 {
        let level = |level: &LevelSizes| {
            let (samples, lines) = (level.samples as f64, level.lines as f64);
            let patch = lines * (2.0 * level.upper * level.block * COSTS[1] + transform_multiply_adds(level.samples))
                + samples * lines * self.columns;
            ((metres / level.pitch()).ceil() + 1.0) * patch + rows * self.columns * 14.0
        };
        self.levels.iter().map(level).sum()
    }
}

/// Highest wavenumbers that a lattice resolves, along and across, cycles per metre; a single column is a line, which
/// resolves all.
pub(super) fn resolved(lattice: Lattice) -> [f64; 2] {
    [0.5 / lattice.cell(), if lattice.columns > 1 { 0.5 / lattice.dy } else { f64::INFINITY }]
}
