//! One interface for both slice laws: heights in, stiffness curves out.
//!
//! Plan: [`SliceBuilder`] has what depends on the grid only. Prepare: [`SliceScratch`], one per thread. Run:
//! [`SliceBuilder::build`] for one slice, [`SliceBuilder::build_rows`] for a chunk of road. A long road is made in
//! chunks ahead of the tyre, so its length costs no memory.

use rayon::prelude::*;

use super::reduce::reduce;
use super::{SliceError, StiffnessCurve, half_space, winkler};
use crate::half_space::{GrowingContact, LineInfluence};

/// How a slice deforms the tread.
#[derive(Clone, Debug)]
enum Law {
    /// Highest point only, flat.
    Flat,
    /// Independent springs.
    Winkler,
    /// Elastic half-space.
    HalfSpace(LineInfluence),
}

/// Least number of slices that a thread takes at a time: scratch is made for each such portion.
const LEAST_SLICES: usize = 16;

/// Makes the stiffness curves of slices of one grid by one law.
#[derive(Clone, Debug)]
pub struct SliceBuilder {
    law: Law,
    columns: usize,
    lines: usize,
    tolerance: f64,
}

/// Work arrays of one thread; sized on first use, then reused without allocation.
#[derive(Clone, Debug, Default)]
pub struct SliceScratch {
    depths: Vec<f64>,
    contact: GrowingContact,
    events: Vec<(f64, f64)>,
    winkler: winkler::Scratch,
}

impl SliceBuilder {
    /// Builder for slices whose highest point alone makes contact, as a flat slice: S(y) = y.
    ///
    /// # Errors
    /// [`SliceError::Empty`] for no columns.
    pub fn flat(columns: usize) -> Result<Self, SliceError> {
        Self::new(Law::Flat, columns)
    }

    /// Builder for independent springs over `columns` cells of equal width.
    ///
    /// # Errors
    /// [`SliceError::Empty`] for no columns.
    pub fn winkler(columns: usize) -> Result<Self, SliceError> {
        Self::new(Law::Winkler, columns)
    }

    /// Builder for an elastic half-space pressed on cells of `length` along the road by `pitch` across it \[m\].
    ///
    /// # Errors
    /// [`SliceError::Empty`] for no columns, [`SliceError::Length`] for a cell without size, [`SliceError::MayShrink`]
    /// if the grid is so extreme that rounding hides that the contact area only grows.
    pub fn half_space(columns: usize, length: f64, pitch: f64) -> Result<Self, SliceError> {
        for (what, value) in [("the length of a slice's cells", length), ("the width of a slice's cells", pitch)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(SliceError::Length { what, value });
            }
        }
        if columns == 0 {
            return Err(SliceError::Empty);
        }
        let line = LineInfluence::love(columns, length, pitch);
        if !line.only_grows() {
            return Err(SliceError::MayShrink { columns, length, pitch });
        }
        Self::new(Law::HalfSpace(line), columns)
    }

    fn new(law: Law, columns: usize) -> Result<Self, SliceError> {
        if columns == 0 {
            return Err(SliceError::Empty);
        }
        Ok(Self { law, columns, lines: 1, tolerance: 0.0 })
    }

    /// The same builder for slices of `lines` lines of cells along the element; by default there is one.
    ///
    /// # Errors
    /// [`SliceError::Empty`] for none.
    pub fn with_lines(mut self, lines: usize) -> Result<Self, SliceError> {
        if lines == 0 {
            return Err(SliceError::Empty);
        }
        self.lines = lines;
        Ok(self)
    }

    /// Drops breakpoints as long as every S(y) stays within `tolerance` \[m\]; 0, the default, keeps the curve exact.
    ///
    /// # Errors
    /// [`SliceError::Length`] unless the tolerance is finite and not negative.
    pub fn with_tolerance(mut self, tolerance: f64) -> Result<Self, SliceError> {
        if !(tolerance >= 0.0 && tolerance.is_finite()) {
            return Err(SliceError::Length { what: "the tolerance of the slices' curves", value: tolerance });
        }
        self.tolerance = tolerance;
        Ok(self)
    }

    /// Number of cells of one slice.
    pub fn cells(&self) -> usize {
        self.lines * self.columns
    }

    /// Curve of one slice.
    ///
    /// `heights`: one height \[m\] per cell, line by line.
    ///
    /// # Errors
    /// [`SliceError::Cells`] for another number of heights, [`SliceError::Hole`] (slice 0) for a height that is not
    /// finite.
    pub fn build(&self, heights: &[f64], scratch: &mut SliceScratch) -> Result<StiffnessCurve, SliceError> {
        if heights.len() != self.cells() {
            return Err(SliceError::Cells { cells: self.cells(), found: heights.len() });
        }
        SliceError::refuse_holes(heights, self.cells())?;
        Ok(self.curve(heights, scratch))
    }

    /// Curve of as many finite heights as there are cells.
    fn curve(&self, heights: &[f64], scratch: &mut SliceScratch) -> StiffnessCurve {
        match &self.law {
            Law::Flat => StiffnessCurve::flat(heights.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
            Law::Winkler => winkler::curve(heights, self.tolerance, &mut scratch.winkler),
            Law::HalfSpace(line) => {
                let SliceScratch { depths, contact, events, .. } = scratch;
                reduce(half_space::curve(line, heights, self.columns, depths, contact, events), self.tolerance)
            }
        }
    }

    /// Curve of one slice, and the pressure/E* \[1\] of every cell at each of the penetrations `at` \[m\] past the
    /// highest point (0 at or above it).
    ///
    /// On the half-space the pressures are those solved for on the builder's cells. The independent springs of
    /// [`Self::winkler`] and the rigid lines of [`Self::flat`] have no stiffness themselves: they get that of the flat
    /// line on cells of `length` by `pitch` \[m\].
    ///
    /// # Errors
    /// As [`Self::build`].
    pub fn build_with_pressures(
        &self,
        heights: &[f64],
        length: f64,
        pitch: f64,
        at: &[f64],
        scratch: &mut SliceScratch,
    ) -> Result<(StiffnessCurve, Vec<Vec<f64>>), SliceError> {
        let curve = self.build(heights, scratch)?;
        let peak = curve.peak;
        let spring = match &self.law {
            Law::HalfSpace(_) => 0.0,
            Law::Flat | Law::Winkler => {
                LineInfluence::love(self.columns, length, pitch).flat_stiffness() / self.columns as f64
            }
        };
        let mut pressures = vec![vec![0.0; self.cells()]; at.len()];
        for (number, line_heights) in heights.chunks_exact(self.columns).enumerate() {
            let later = match &self.law {
                Law::HalfSpace(line) => {
                    half_space::follow(line, line_heights, peak, &mut scratch.depths, &mut scratch.contact)
                }
                Law::Flat | Law::Winkler => 0.0,
            };
            for (&y, pressure) in at.iter().zip(&mut pressures) {
                let pressure = &mut pressure[number * self.columns..][..self.columns];
                match self.law {
                    Law::HalfSpace(_) if y > later => scratch.contact.pressure_at(y - later, pressure),
                    Law::HalfSpace(_) => {}
                    Law::Flat => pressure.fill(spring * y.max(0.0)),
                    Law::Winkler => {
                        for (p, height) in pressure.iter_mut().zip(line_heights) {
                            *p = spring * (y - (peak - height)).max(0.0);
                        }
                    }
                }
            }
        }
        Ok((curve, pressures))
    }

    /// Curves of many slices, in parallel on the current rayon pool; the same bits for any number of threads.
    ///
    /// `heights`: slice by slice, line by line \[m\].
    ///
    /// # Errors
    /// [`SliceError::Cells`] if the heights do not fill whole slices; [`SliceError::Hole`] for the first height that
    /// is not finite.
    pub fn build_rows(&self, heights: &[f64]) -> Result<Vec<StiffnessCurve>, SliceError> {
        let cells = self.cells();
        if !heights.len().is_multiple_of(cells) {
            return Err(SliceError::Cells { cells, found: heights.len() });
        }
        // Checked beforehand, so that the first hole is reported whichever thread meets one first.
        SliceError::refuse_holes(heights, cells)?;
        let slices = heights.par_chunks_exact(cells).with_min_len(LEAST_SLICES);
        Ok(slices.map_init(SliceScratch::default, |scratch, slice| self.curve(slice, scratch)).collect())
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn random_heights(count: usize) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        (0..count).map(|_| 4e-3 * rng.random::<f64>()).collect()
    }

    #[test]
    fn the_number_of_threads_changes_no_bit() {
        let heights = random_heights(1000 * 40);
        let builder = SliceBuilder::winkler(40).unwrap().with_tolerance(1e-6).unwrap();
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| builder.build_rows(&heights).unwrap())
        };
        let one = on(1);
        assert_eq!(one, on(2));
        assert_eq!(one, on(5));
    }

    #[test]
    fn a_hole_is_refused_with_its_place() {
        let mut heights = random_heights(30);
        heights[17] = f64::NAN;
        let error = SliceBuilder::winkler(10).unwrap().build_rows(&heights).unwrap_err();
        assert!(matches!(error, SliceError::Hole { slice: 1, cell: 7, .. }), "{error}");
        assert!(SliceBuilder::winkler(7).unwrap().build_rows(&heights).is_err());
        assert_eq!(SliceBuilder::winkler(0).unwrap_err(), SliceError::Empty);
    }

    #[test]
    fn the_flat_law_keeps_the_peak_only() {
        let curves = SliceBuilder::flat(3).unwrap().build_rows(&[0.0, 2.0, 1.0, -1.0, -3.0, -2.0]).unwrap();
        assert_eq!(curves, vec![StiffnessCurve::flat(2.0), StiffnessCurve::flat(-1.0)]);
    }
}
