//! Slices of a scene's road by both laws: one to look at, and the spread over the road (Larsson's figure 4).

use serde::Serialize;

use crate::plan::Plan;
use crate::road::slices::statistics::{LevelStatistics, statistics};
use crate::road::slices::{CELL_LENGTH, SliceError, SliceScratch, StiffnessCurve};
use crate::road::{Lattice, RoadSurface};
use crate::run::RunError;
use crate::run::road::{in_scene, road_limits};
use crate::run::slices::slice_builder;
use crate::scene::{LoadedScene, Slices};

/// Indentations considered, relative to the slice's depth.
const LEVELS: [f64; 4] = [0.25, 0.5, 1.0, 1.5];
/// The compared laws, with their names.
pub(crate) const LAWS: [(Slices, &str); 2] = [(Slices::Winkler, "winkler"), (Slices::HalfSpace, "half-space")];

/// The spread of S over the road at one penetration, by both laws.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Spread {
    /// Penetration past each slice's highest point \[m\].
    pub penetration: f64,
    /// Mean of S/y by the winkler and by the half-space law.
    pub mean: [f64; 2],
    /// Standard deviation of S/y by both.
    pub deviation: [f64; 2],
    /// Root mean square of the difference of S between both, over the mean S.
    pub difference: f64,
    /// Mean share of the area in contact, winkler.
    pub contact_fraction: f64,
    /// Mean, median and the middle 90 % of S and of s, by both.
    pub quantiles: [Option<LevelStatistics>; 2],
}

/// One slice pressed to given penetrations.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PressedSlice {
    /// Heights of its cells \[m\], lines along the road after each other.
    pub heights: Vec<f64>,
    /// Penetrations past the highest point \[m\].
    pub penetration: Vec<f64>,
    pub laws: [PressedByLaw; 2],
}

#[derive(Clone, Debug, Serialize)]
pub(crate) struct PressedByLaw {
    pub law: &'static str,
    /// S \[m\] at each penetration.
    pub displacement: Vec<f64>,
    /// Pressure on each cell over E/(1 - nu^2), penetration by penetration.
    pub pressure: Vec<Vec<f64>>,
}

/// Heights of consecutive slices of a road.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    /// Elements and their cells.
    pub lattice: Lattice,
    /// Number of the first element.
    pub first: i64,
    /// Heights \[m\], slice by slice.
    pub heights: Vec<f64>,
}

/// The first slice of a sample, along its highest line of cells.
#[derive(Clone, Debug)]
pub(crate) struct SliceView {
    /// Positions across the tyre \[m\].
    pub across: Vec<f64>,
    /// Heights at these positions \[m\].
    pub heights: Vec<f64>,
    /// Highest point of the slice \[m\].
    pub peak: f64,
    /// Indentations past the highest point that are considered \[m\].
    pub levels: [f64; 4],
    /// Pressures at each indentation on an elastic half-space, over its modulus E*.
    pub pressures: Vec<Vec<f64>>,
    /// Stiffness curves by both laws.
    pub curves: [StiffnessCurve; 2],
}

impl Sample {
    /// Reads `slices` slices from the road coordinate `at` \[m\] on; fewer where the road ends.
    ///
    /// # Errors
    /// Errors of the road.
    pub(crate) fn of(loaded: &LoadedScene, at: f64, slices: usize) -> Result<Self, RunError> {
        let scene = &loaded.scene;
        let read = || {
            let lattice = Plan::new(scene).lattice()?;
            let dx = lattice.dx;
            let mut surface = RoadSurface::open(&scene.road, lattice, road_limits(scene))?;
            let first = (at / dx).round() as i64;
            let there = surface.extent().map_or(i64::MAX, |(_, end)| (end / dx + 1e-6).floor() as i64 - first + 1);
            let rows = (slices as i64).min(there.max(1)) as usize;
            let mut heights = vec![0.0; rows * lattice.cells()];
            surface.heights(first, rows, &mut heights)?;
            Ok(Self { lattice, first, heights })
        };
        read().map_err(|error| in_scene(loaded, error))
    }

    /// Curves of all slices by both laws, to a tolerance \[m\].
    ///
    /// # Errors
    /// [`SliceError`].
    pub(crate) fn curves(&self, tolerance: f64) -> Result<[Vec<StiffnessCurve>; 2], SliceError> {
        let build = |law| slice_builder(Some(law), self.lattice)?.with_tolerance(tolerance)?.build_rows(&self.heights);
        Ok([build(LAWS[0].0)?, build(LAWS[1].0)?])
    }

    /// Depth of every point below its slice's highest one \[m\], slice by slice.
    pub(crate) fn depths(&self) -> Vec<f64> {
        self.heights
            .chunks(self.lattice.cells())
            .flat_map(|row| {
                let peak = row.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                row.iter().map(move |height| peak - height)
            })
            .collect()
    }

    /// The first slice pressed by both laws at penetrations past its highest point \[m\].
    ///
    /// # Errors
    /// [`SliceError`].
    pub(crate) fn pressed(&self, penetrations: &[f64]) -> Result<PressedSlice, SliceError> {
        let lattice = self.lattice;
        let heights = &self.heights[..lattice.cells()];
        let by_law = |(law, name): (Slices, &'static str)| -> Result<PressedByLaw, SliceError> {
            let mut scratch = SliceScratch::default();
            let builder = slice_builder(Some(law), lattice)?;
            let (curve, pressure) =
                builder.build_with_pressures(heights, CELL_LENGTH, lattice.dy, penetrations, &mut scratch)?;
            let displacement = penetrations.iter().map(|&y| curve.displacement_at(y)).collect();
            Ok(PressedByLaw { law: name, displacement, pressure })
        };
        Ok(PressedSlice {
            heights: heights.to_vec(),
            penetration: penetrations.to_vec(),
            laws: [by_law(LAWS[0])?, by_law(LAWS[1])?],
        })
    }

    /// View of the first slice, given its curves; `None` if it is flat across.
    ///
    /// # Errors
    /// [`SliceError`].
    pub(crate) fn view(&self, curves: [&StiffnessCurve; 2]) -> Result<Option<SliceView>, SliceError> {
        let lattice = self.lattice;
        let slice = &self.heights[..lattice.cells()];
        let peak = curves[0].peak;
        // The line that touches first: the levels count from its peak.
        let highest = slice.iter().position(|&height| height >= peak).unwrap_or(0) / lattice.columns;
        let line = |values: &[f64]| values[highest * lattice.columns..][..lattice.columns].to_vec();
        let heights = line(slice);
        let depth = heights.iter().map(|height| peak - height).fold(0.0, f64::max);
        if depth <= 0.0 {
            return Ok(None);
        }
        let levels = LEVELS.map(|share| share * depth);
        let builder = slice_builder(Some(Slices::HalfSpace), lattice)?;
        let (_, pressures) =
            builder.build_with_pressures(slice, CELL_LENGTH, lattice.dy, &levels, &mut SliceScratch::default())?;
        Ok(Some(SliceView {
            across: (0..lattice.columns).map(|column| lattice.y(column)).collect(),
            heights,
            peak,
            levels,
            pressures: pressures.iter().map(|pressure| line(pressure)).collect(),
            curves: curves.map(Clone::clone),
        }))
    }
}

/// Spread over some slices, from their curves by both laws and their depths \[m\]; empty for flat ones.
pub(crate) fn spread(curves: &[Vec<StiffnessCurve>; 2], depths: &[f64]) -> Vec<Spread> {
    // Penetrations at multiples of the road's mean depth: there the laws can differ.
    let typical = 2.0 * depths.iter().sum::<f64>() / depths.len() as f64;
    if typical <= 0.0 {
        return Vec::new();
    }
    let count = curves[0].len() as f64;
    let at = |share: f64| {
        let y = share * typical;
        let values = [0, 1].map(|law: usize| curves[law].iter().map(move |curve| curve.displacement_at(y) / y));
        let mean = values.clone().map(|values| values.sum::<f64>() / count);
        let deviation = [0, 1].map(|law: usize| {
            (values[law].clone().map(|value| (value - mean[law]).powi(2)).sum::<f64>() / count).sqrt()
        });
        let [winkler, half_space] = values;
        let difference = (winkler.zip(half_space).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / count).sqrt();
        // Independent springs: the normalised stiffness is the share of the area in contact.
        let quantiles =
            [0, 1].map(|law: usize| statistics(&curves[law], &[y]).and_then(|levels| levels.first().copied()));
        let contact = quantiles[0].map_or(0.0, |level| level.stiffness.mean);
        Spread {
            penetration: y,
            mean,
            deviation,
            difference: difference / (0.5 * (mean[0] + mean[1])),
            contact_fraction: contact,
            quantiles,
        }
    };
    [0.25, 0.5, 1.0, 2.0].map(at).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::{scene, scene_text};

    #[test]
    fn pressures_by_both_laws_add_up_to_their_displacements() {
        let rolling = "speed_kmh = 80.0\nwarm_up = 0.05\nduration = 0.1\naxle = { indentation = 0.01 }";
        let cells = "[contact]\ncells_across = 12\ncells_along = 2";
        let loaded = scene(&scene_text(64, "kind = \"made\"", rolling, "", cells));
        let sample = Sample::of(&loaded, 0.5, 1).unwrap();
        let flat = Sample { heights: vec![0.0; sample.lattice.cells()], ..sample.clone() };
        let stiffness: f64 = flat.pressed(&[1.0]).unwrap().laws[1].pressure[0].iter().sum();
        for found in sample.pressed(&[-1e-3, 0.0, 2e-4, 1e-3, 5e-3]).unwrap().laws {
            assert!((found.displacement[0] + 1e-3).abs() < 1e-18, "a gap stays a gap");
            for (pressure, displacement) in found.pressure.iter().zip(&found.displacement).skip(1) {
                let force: f64 = pressure.iter().sum();
                assert!((force / stiffness - displacement).abs() < 1e-15, "{}: {displacement}", found.law);
            }
        }
    }
}
