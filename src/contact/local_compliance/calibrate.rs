//! kappa by pressing patches of the road: the value with which the local law agrees with an elastic half-space.
//!
//! 1. Every patch, periodic, is pressed by rigid contact in three dimensions at a tyre's mean pressures: approach
//!    and pressures.
//! 2. By approach: with S the curve of all cells of the patch, S^-1(kappa p) - kappa p = approach, least squares
//!    over the pressures.
//! 3. By line pressure: the patch is cut into elements of the run's length, the local law is solved on them, and its
//!    pressures are fitted to those of the contact in three dimensions, relative to the mean, least squares over
//!    elements and pressures.
//!
//! Both over all patches together and patch by patch: the spread shows how much of a road one patch is. Everything
//! depends on pressures over E* alone, and c = kappa E* is a length.

use serde::Serialize;

use super::formula::{local_compliance, tread_modulus};
use super::line_law::ElementLine;
use super::patch::{PatchGrid, patches};
use crate::half_space::HalfSpaceError;
use crate::half_space::rough::{HeightMap, IndentationLimits, PeriodicContact};
use crate::numeric::in_parallel;
use crate::road::slices::{SliceBuilder, SliceError, SliceScratch, StiffnessCurve};
use crate::road::{RoadError, RoadSurface};
use crate::scene::{Road, Tyre};

/// Mean pressures \[Pa\]: those of a tyre on the road, edges of the patch included.
pub(crate) const PRESSURES: [f64; 10] = [5e4, 1e5, 1.5e5, 2e5, 2.5e5, 3e5, 3.5e5, 4e5, 4.5e5, 5e5];
/// Tolerance of the contact in three dimensions, relative to the approach: far below any difference of interest.
const TOLERANCE: f64 = 1e-5;
/// Values of c between which the best one is searched for \[m\]: waves of a hundredth of a millimetre to some metres.
const SOUGHT: (f64, f64) = (1e-5, 1.0);
/// Values tried before the search closes in, evenly on the logarithmic scale: about two in an octave.
const TRIED: usize = 33;
/// How far the search closes in, on the natural logarithm.
const CLOSE: f64 = 1e-4;

/// Why patches of a road could not be pressed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CalibrationError {
    /// The road could not be opened or read.
    #[error(transparent)]
    Road(#[from] RoadError),
    /// Its slices could not be made.
    #[error(transparent)]
    Slices(#[from] SliceError),
    /// The contact of a patch with the half-space was not solved.
    #[error(transparent)]
    HalfSpace(#[from] HalfSpaceError),
}

/// Result of a calibration; compliances in m/Pa.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Calibration {
    /// E* of the tread \[Pa\].
    pub effective_modulus: f64,
    /// kappa by formula.
    pub formula: f64,
    /// Patches pressed.
    pub patches: usize,
    /// Length and width of a patch \[m\].
    pub size: [f64; 2],
    /// Length and width of its cells \[m\].
    pub cell: [f64; 2],
    /// Elements that a patch is cut into.
    pub elements: usize,
    /// Fit of the approach; differences in m.
    pub by_approach: ComplianceFit,
    /// Fit of the line pressures; differences relative to the mean pressure.
    pub by_line_pressure: ComplianceFit,
    /// Pressure by pressure.
    pub levels: Vec<PressureLevel>,
}

/// A fitted compliance.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ComplianceFit {
    /// kappa \[m/Pa\], all patches together.
    pub compliance: f64,
    /// kappa of each patch alone \[m/Pa\].
    pub by_patch: Vec<f64>,
    /// Root mean square error of the fit, over patches and pressures.
    pub rms_difference: f64,
    /// Root mean square error with kappa by formula.
    pub rms_difference_of_formula: f64,
}

/// Patches under one mean pressure; means over the patches.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PressureLevel {
    /// Mean pressure \[Pa\].
    pub pressure: f64,
    /// Approach of the contact in three dimensions \[m\].
    pub approach: f64,
    /// Approach of the local law, kappa by approach, and by formula \[m\].
    pub approach_of_law: [f64; 2],
    /// Share of the patch in contact, in three dimensions.
    pub contact_fraction: f64,
    /// Correlation of the line pressures over the elements of all patches, kappa by line pressure, and by formula;
    /// `None` where they do not vary.
    pub correlation: [Option<f64>; 2],
    /// Root mean square of their difference, relative to the mean pressure.
    pub rms_difference: [f64; 2],
}

struct Pressed {
    curve: StiffnessCurve,
    line: ElementLine,
    /// By pressure: approach \[m\], share in contact, pressures/E* by element.
    found: Vec<(f64, f64, Vec<f64>)>,
}

/// Presses at most `most` patches of a road under the tread of a tyre with elements of length `element` \[m\]; `None`
/// for a road without texture.
///
/// # Errors
/// Errors of the road and of the half-space's solver.
pub(crate) fn calibrate(
    tyre: &Tyre,
    road: &Road,
    surface: &RoadSurface,
    limits: crate::road::Limits,
    element: f64,
    most: usize,
) -> Result<Option<Calibration>, CalibrationError> {
    let Some((formula, modulus)) = local_compliance(tyre, surface).zip(tread_modulus(tyre)) else { return Ok(None) };
    let grid = PatchGrid::new(element);
    let maps = patches(road, limits, grid, most)?;
    let pressures = PRESSURES.map(|pressure| pressure / modulus);
    let pressed = in_parallel::map(&maps, |map| press(map, grid, &pressures));
    let pressed = pressed.into_iter().collect::<Result<Vec<_>, CalibrationError>>()?;
    if pressed.is_empty() {
        return Ok(None);
    }
    let c = formula * modulus;
    let by_approach = fit(&pressed, c, modulus, |patch, c| approach_misfit(patch, c, &pressures));
    let by_line = fit(&pressed, c, modulus, |patch, c| line_misfit(patch, c, &pressures));
    let level = |index: usize| level(&pressed, index, pressures[index], modulus, [&by_approach, &by_line], c);
    Ok(Some(Calibration {
        effective_modulus: modulus,
        formula,
        patches: pressed.len(),
        size: [grid.rows() as f64 * grid.dx, grid.columns as f64 * grid.dy],
        cell: [grid.dx, grid.dy],
        elements: grid.elements,
        levels: (0..pressures.len()).map(level).collect(),
        by_approach,
        by_line_pressure: by_line,
    }))
}

fn press(map: &HeightMap, grid: PatchGrid, pressures: &[f64]) -> Result<Pressed, CalibrationError> {
    let area_curve = |heights: &[f64]| -> Result<StiffnessCurve, SliceError> {
        SliceBuilder::winkler(heights.len())?.build(heights, &mut SliceScratch::default())
    };
    let per_element = grid.along * grid.columns;
    let curves = map.heights.chunks_exact(per_element).map(area_curve).collect::<Result<_, _>>()?;
    let limits = IndentationLimits { tolerance: TOLERANCE, ..IndentationLimits::default() };
    let mut contact = PeriodicContact::new(map)?;
    let found = pressures.iter().map(|&pressure| {
        let pressed = contact.press(pressure, limits)?;
        let elements = pressed.pressure.chunks_exact(per_element);
        let means = elements.map(|cells| cells.iter().sum::<f64>() / per_element as f64).collect();
        Ok((pressed.approach, pressed.area_fraction, means))
    });
    let found = found.collect::<Result<_, HalfSpaceError>>()?;
    Ok(Pressed { curve: area_curve(&map.heights)?, line: ElementLine::new(grid, curves), found })
}

/// S^-1(c p) - c p \[m\] at a pressure/E*.
fn approach_by_law(patch: &Pressed, c: f64, pressure: f64) -> f64 {
    patch.curve.penetration_at(c * pressure) - c * pressure
}

/// Mean square error of the law's approach \[m^2\].
fn approach_misfit(patch: &Pressed, c: f64, pressures: &[f64]) -> f64 {
    let differences = pressures.iter().zip(&patch.found).map(|(&p, found)| approach_by_law(patch, c, p) - found.0);
    differences.map(|difference| difference * difference).sum::<f64>() / pressures.len() as f64
}

/// Mean square error of the law's line pressures, relative to the mean pressure; infinite where the law could not be
/// solved.
fn line_misfit(patch: &Pressed, c: f64, pressures: &[f64]) -> f64 {
    let of_level = |(&pressure, found): (&f64, &(f64, f64, Vec<f64>))| {
        patch.line.pressures(c, pressure).map_or(f64::INFINITY, |law| mean_square_difference(&law, &found.2, pressure))
    };
    pressures.iter().zip(&patch.found).map(of_level).sum::<f64>() / pressures.len() as f64
}

/// Mean square of the difference of two lists, in units of `unit`.
fn mean_square_difference(one: &[f64], other: &[f64], unit: f64) -> f64 {
    one.iter().zip(other).map(|(a, b)| ((a - b) / unit).powi(2)).sum::<f64>() / one.len() as f64
}

/// Best c by a misfit, over all patches and for each, as kappa; `formula` is c by formula \[m\].
fn fit(pressed: &[Pressed], formula: f64, modulus: f64, misfit: impl Fn(&Pressed, f64) -> f64 + Sync) -> ComplianceFit {
    let together = |c: f64| {
        let misfits = in_parallel::map(pressed, |patch| misfit(patch, c));
        misfits.iter().sum::<f64>() / misfits.len() as f64
    };
    let (best, least) = least(together);
    let by_patch = in_parallel::map(pressed, |patch| self::least(|c| misfit(patch, c)).0 / modulus);
    ComplianceFit {
        compliance: best / modulus,
        by_patch,
        rms_difference: least.sqrt(),
        rms_difference_of_formula: together(formula).sqrt(),
    }
}

/// Where a function of c is least, and its value there: the best of values tried, then the golden section between its
/// neighbours.
fn least(function: impl Fn(f64) -> f64) -> (f64, f64) {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let spacing = (SOUGHT.1 / SOUGHT.0).ln() / (TRIED - 1) as f64;
    let at = |x: f64| function(x.exp());
    // 1. Values tried, evenly on the logarithmic scale.
    let tried = (0..TRIED).map(|i| SOUGHT.0.ln() + i as f64 * spacing).map(|x| (x, at(x)));
    let (middle, _) = tried.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((SOUGHT.0.ln(), f64::INFINITY));
    // 2. Golden section between the neighbours of the best.
    let (mut low, mut high) = (middle - spacing, middle + spacing);
    let (mut left, mut right) = (high - golden * (high - low), low + golden * (high - low));
    let (mut at_left, mut at_right) = (at(left), at(right));
    while high - low > CLOSE {
        if at_left <= at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - golden * (high - low);
            at_left = at(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + golden * (high - low);
            at_right = at(right);
        }
    }
    if at_left <= at_right { (left.exp(), at_left) } else { (right.exp(), at_right) }
}

fn level(
    pressed: &[Pressed],
    index: usize,
    pressure: f64,
    modulus: f64,
    fits: [&ComplianceFit; 2],
    formula: f64,
) -> PressureLevel {
    let mean = |value: &dyn Fn(&Pressed) -> f64| pressed.iter().map(value).sum::<f64>() / pressed.len() as f64;
    let [approach, line] = fits.map(|fit| fit.compliance * modulus);
    let approach_of_law = [approach, formula].map(|c| mean(&|patch| approach_by_law(patch, c, pressure)));
    let of_lines = [line, formula].map(|c| {
        let pairs: Vec<(f64, f64)> = pressed
            .iter()
            .filter_map(|patch| Some((patch.line.pressures(c, pressure)?, &patch.found[index].2)))
            .flat_map(|(law, found)| law.into_iter().zip(found.iter().copied()))
            .collect();
        let (one, other): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
        (correlation(&one, &other), mean_square_difference(&one, &other, pressure).sqrt())
    });
    PressureLevel {
        pressure: pressure * modulus,
        approach: mean(&|patch| patch.found[index].0),
        approach_of_law,
        contact_fraction: mean(&|patch| patch.found[index].1),
        correlation: of_lines.map(|(correlation, _)| correlation),
        rms_difference: of_lines.map(|(_, difference)| difference),
    }
}

/// Correlation of two lists of equal length; `None` where one does not vary.
fn correlation(one: &[f64], other: &[f64]) -> Option<f64> {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (mean_one, mean_other) = (mean(one), mean(other));
    let sum =
        |of: fn(f64, f64) -> f64| -> f64 { one.iter().zip(other).map(|(a, b)| of(a - mean_one, b - mean_other)).sum() };
    let (squares, others, products) = (sum(|a, _| a * a), sum(|_, b| b * b), sum(|a, b| a * b));
    (squares > 0.0 && others > 0.0).then(|| products / (squares * others).sqrt())
}

#[cfg(test)]
mod tests {
    use super::super::formula::tests::{scene, surface};
    use super::*;

    #[test]
    fn the_least_value_is_found() {
        for place in [1.3e-5_f64, 4e-3, 0.9] {
            let (found, value) = least(|c| 2.0 + (c / place).ln().powi(2));
            assert!((found / place - 1.0).abs() < 2.0 * CLOSE && (value - 2.0).abs() < 1e-7, "{found} for {place}");
        }
        assert_eq!(correlation(&[1.0, 2.0, 3.0], &[5.0, 4.0, 3.0]), Some(-1.0));
        assert_eq!(correlation(&[1.0, 1.0], &[5.0, 4.0]), None);
    }

    #[test]
    fn pressed_dense_asphalt_has_about_the_formulas_compliance() {
        let loaded = scene("kind = \"made\"\nseed = 1");
        let limits = crate::road::Limits::default();
        let (tyre, road) = (&loaded.scene.tyre, &loaded.scene.road);
        let found = calibrate(tyre, road, &surface(&loaded), limits, 1.95 / 256.0, 2).unwrap().unwrap();
        assert_eq!((found.patches, found.elements, found.by_approach.by_patch.len()), (2, 16, 2));
        // Single patches spread by 8 %, and eight of them together are 10 % above the formula.
        let ratio = found.by_approach.compliance / found.formula;
        assert!((0.8..1.4).contains(&ratio), "by approach {ratio} of the formula");
        // The pressures' misfit is flat: 10 % at the formula, 9 % at its least, at 1.5 times the formula.
        let ratio = found.by_line_pressure.compliance / found.formula;
        assert!((0.7..2.5).contains(&ratio), "by line pressure {ratio} of the formula");
        for fit in [&found.by_approach, &found.by_line_pressure] {
            assert!(fit.rms_difference <= fit.rms_difference_of_formula, "{fit:?}");
        }
        for level in &found.levels {
            assert!((level.approach - level.approach_of_law[0]).abs() < 0.05 * level.approach, "{level:?}");
            assert!(level.correlation.iter().all(|correlation| correlation.is_some_and(|c| c > 0.9)), "{level:?}");
        }
        let rising = |of: fn(&PressureLevel) -> f64| found.levels.windows(2).all(|pair| of(&pair[0]) < of(&pair[1]));
        assert!(rising(|level| level.approach) && rising(|level| level.contact_fraction));
    }

    #[test]
    fn a_smooth_road_has_nothing_to_press() {
        let loaded = scene("kind = \"smooth\"");
        let limits = crate::road::Limits::default();
        let none = calibrate(&loaded.scene.tyre, &loaded.scene.road, &surface(&loaded), limits, 0.0076, 2).unwrap();
        assert!(none.is_none());
    }
}
