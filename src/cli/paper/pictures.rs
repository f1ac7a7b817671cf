//! The paper's figures as pictures.

use crate::report::mobility::{LEVEL, plot};
use crate::report::road::map;
use crate::report::slices;
use crate::response::LevelErrors;
use crate::results::PlotError;
use crate::results::plots::{Axis, ForceMap, LinePlot, Series, ThirdOctavePlot};
use crate::results::spectra::FORCE_LEVEL;

use super::equation_4::Equation4;
use super::patch_force::PatchForces;
use super::recompute::Paper;
use super::search::SearchFigure;
use super::tread_laws::TreadLaws;

/// A picture and its caption.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    /// Its place in the paper, as statements have it.
    pub place: &'static str,
    /// Name of its file.
    pub file: &'static str,
    /// Caption.
    pub caption: String,
    /// Drawing, as SVG.
    pub svg: String,
}

/// All pictures, in the paper's order.
///
/// # Errors
/// [`PlotError`].
pub(super) fn pictures(paper: &Paper) -> Result<Vec<Picture>, PlotError> {
    let picture = |place, file, caption: &str, svg| Picture { place, file, caption: caption.to_owned(), svg };
    let names: Vec<String> = paper.mobility.patches.iter().map(|side| format!("{} mm", 1e3 * side)).collect();
    let mobility = plot(&paper.mobility.mobility, "Driving-point mobility of the tread", &names, LEVEL).to_svg();
    let mut all = vec![picture("figure 2", "mobility.svg", "A square patch in the middle of the tread.", mobility)];
    if !paper.road.description.sample.heights.is_empty() {
        let road = map("A rough road", &paper.road.description)?;
        all.push(picture("figure 3", "road.svg", "A piece of the road, its heights in colours.", road));
    }
    if let Some(view) = &paper.slice.view {
        for (file, svg) in slices::pictures("A slice of the road", view) {
            let caption = match file {
                "slice_profile.svg" => "The slice's highest line of cells, with four indentations.",
                "slice_pressure.svg" => "Pressure under them on an elastic half-space.",
                "slice_displacement.svg" => "Displacement S of the slice as a whole, by both laws.",
                _ => "Its normalised stiffness s, the slope of S, by both laws.",
            };
            all.push(picture("figure 4", file, caption, svg));
        }
    }
    let force = force_map(&paper.patch_forces)?;
    all.push(picture("figure 5", "patch_force.svg", "Forces of the elements while they pass the patch.", force));
    if let Some(laws) = tread_laws(&paper.tread_laws)? {
        let caption = "Contact force by three laws of the tread at the same static contact stiffness.";
        all.push(picture("figure 6", "tread_laws.svg", caption, laws));
    }
    let caption = "How many linear solves it takes to find the points in contact.";
    all.push(picture("contact search", "solves.svg", caption, solves(&paper.search)));
    let caption = "Root mean square of the force's change when a step is halved, relative to the force's variation.";
    all.push(picture("equation 4", "equation_4.svg", caption, equation_4(&paper.equation_4)));
    Ok(all)
}

fn force_map(of: &PatchForces) -> Result<String, PlotError> {
    let map = ForceMap {
        title: "Force over contact and time",
        time: &of.time,
        first_element: &of.first_element,
        force: of.force.view(),
        element_length: of.element,
        speed: of.speed,
        start: of.start,
        shown: 0.0..f64::INFINITY,
    };
    map.to_svg()
}

fn tread_laws(of: &TreadLaws) -> Result<Option<String>, PlotError> {
    if of.laws.iter().all(|law| law.levels.is_empty()) {
        return Ok(None);
    }
    let plot = ThirdOctavePlot {
        title: "Contact force by tread laws",
        quantity: FORCE_LEVEL,
        spectra: of.laws.iter().map(|law| (law.name, law.levels.as_slice())).collect(),
        errors: LevelErrors::default(),
    };
    plot.to_svg().map(Some)
}

/// Draws the shares as steps over the number of solves.
fn solves(of: &SearchFigure) -> String {
    let both = [("local law", &of.local), ("equation 4", &of.equation_4)];
    let series: Vec<Series<'_>> = both
        .iter()
        .map(|(name, solves)| {
            let all: u64 = solves.histogram.values().sum();
            let most = solves.histogram.keys().max().copied().unwrap_or(0);
            let share = |count: u32| {
                let steps = solves.histogram.get(&count).copied().unwrap_or(0);
                100.0 * steps as f64 / all.max(1) as f64
            };
            let points = (0..=most).flat_map(|count| [-0.5, 0.5].map(|side| (f64::from(count) + side, share(count))));
            Series { name, points: points.collect() }
        })
        .collect();
    let points = || series.iter().flat_map(|series| &series.points);
    let last = points().map(|point| point.0).fold(0.5, f64::max);
    let least = points().map(|point| point.1).filter(|share| *share > 0.0).fold(100.0, f64::min);
    let plot = LinePlot {
        title: "Contact search",
        x: Axis::linear("Solves in an instant", -0.5..last),
        y: Axis::logarithmic("Share of instants [%]", 0.5 * least..100.0),
        series,
    };
    plot.to_svg()
}

/// Draws the differences over the coarser of the two steps.
fn equation_4(of: &Equation4) -> String {
    let series: Vec<Series<'_>> = of
        .couplings
        .iter()
        .map(|refined| {
            let points = of.steps.iter().zip(&refined.differences);
            Series { name: refined.name, points: points.map(|(step, found)| (1e3 * step, *found)).collect() }
        })
        .collect();
    let points = || series.iter().flat_map(|series| &series.points);
    let plot = LinePlot {
        title: "Halving the time step",
        x: Axis::logarithmic_around("Time step [ms]", points().map(|point| point.0), [0.9, 1.1]),
        y: Axis::logarithmic_around("Change of the force by halving the step [1]", points().map(|p| p.1), [0.7, 1.4]),
        series,
    };
    plot.to_svg()
}
