//! `tyrewave slices`: one slice of a scene's road by both laws, the spread over the road, and with `--calibrate` what
//! pressing patches of the road says about the local contact law.

use clap::Args;
use serde::Serialize;
use serde_json::json;
use tyrewave::contact::local_compliance::calibrate::Fit;
use tyrewave::contact::local_compliance::{self, Calibration, CalibrationError};
use tyrewave::counters::{Counter, Stage};
use tyrewave::plan::Plan;
use tyrewave::results::plots::{Axis, LinePlot, Series};
use tyrewave::results::table::{Report, aligned, numbers, row};
use tyrewave::road::slices::statistics::{LevelStatistics, statistics};
use tyrewave::road::slices::{CELL_LENGTH, SliceScratch, StiffnessCurve};
use tyrewave::road::{Lattice, RoadSurface};
use tyrewave::run::prepare::{in_scene, road_limits, slice_builder};
use tyrewave::scene::{LoadedScene, Slices};

use super::context::Context;
use super::error::CliError;
use super::side::{Place, Side};

const EXAMPLES: &str = "\
Drawn, as in the paper's figure 4: the profile of the slice's highest line of cells with the indentation levels, the \
pressure under them on an elastic half-space, and the displacement S(y) and stiffness s(y) by both laws. Printed: the \
spread of S over the road, and the share of the area in contact; also in slices.json. Of the scene its road, contact \
width and elements count.

With --calibrate, patches of the road are pressed into a half-space of the tread's modulus, and the local contact \
law's one parameter, the tread's yielding to the texture under a mean pressure, is fitted: by the approach of road and \
tread, and by the pressures of elements. The line to put into a scene is printed last.

Examples:
  tyrewave slices scenes/default.toml
  tyrewave slices scenes/default.toml --at 3.2 --slices 5000
  tyrewave slices scenes/default.toml --calibrate --patches 12";

/// Indentation levels that are drawn, as shares of the slice's depth.
const LEVELS: [f64; 4] = [0.25, 0.5, 1.0, 1.5];
/// Points of a drawn curve.
const POINTS: usize = 200;
/// The laws side by side.
const LAWS: [(Slices, &str); 2] = [(Slices::Winkler, "winkler"), (Slices::HalfSpace, "half-space")];

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct SlicesArguments {
    #[command(flatten)]
    place: Place,
    /// Road coordinate of the slice that is drawn, in m.
    #[arg(long, value_name = "X", default_value_t = 0.5, allow_negative_numbers = true)]
    at: f64,
    /// Number of slices that the statistics cover, from the drawn one on.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    slices: u32,
    /// Fit the compliance of the local contact law to patches of the road pressed into a half-space.
    #[arg(long)]
    calibrate: bool,
    /// Most patches that are pressed; a road that ends may hold fewer.
    #[arg(long, value_name = "N", default_value_t = 8, requires = "calibrate", value_parser = patch_count())]
    patches: u32,
}

/// As many patches as anybody wants to wait for.
fn patch_count() -> clap::builder::RangedI64ValueParser<u32> {
    clap::value_parser!(u32).range(1..=1000)
}

/// The spread of S over the road at one penetration, by both laws.
#[derive(Clone, Debug, Serialize)]
struct Spread {
    /// Penetration past each slice's highest point \[m\].
    penetration: f64,
    /// Mean of S/y by the winkler and by the half-space law.
    mean: [f64; 2],
    /// Standard deviation of S/y by both.
    deviation: [f64; 2],
    /// Root mean square of the difference of S between both, over the mean S.
    difference: f64,
    /// Mean share of the area in contact, winkler.
    contact_fraction: f64,
    /// Mean, median and the middle 90 % of S and of s, by both.
    quantiles: [Option<LevelStatistics>; 2],
}

/// The heights asked for and where they are.
struct Sample {
    lattice: Lattice,
    first: i64,
    heights: Vec<f64>,
}

impl SlicesArguments {
    /// Computes, draws and tabulates.
    pub fn execute(self, context: &Context) -> Result<(), CliError> {
        let Self { place, at, slices, calibrate, patches } = self;
        let mut side = place.open("slices", context)?;
        let loaded = &side.loaded;
        let sample = side.meter.time(Stage::Road, || sample(loaded, at, slices))?;
        let tolerance = loaded.scene.contact.slice_tolerance;
        let build = |law| -> Result<Vec<StiffnessCurve>, CliError> {
            let builder = slice_builder(law, sample.lattice)?.with_tolerance(tolerance)?;
            Ok(builder.build_rows(&sample.heights)?)
        };
        let build = || Ok::<_, CliError>([build(LAWS[0].0)?, build(LAWS[1].0)?]);
        let curves = side.meter.time(Stage::Slices, build)?;
        let largest = |curves: &Vec<StiffnessCurve>| curves.iter().fold(0.0_f64, |error, curve| error.max(curve.error));
        let errors = [largest(&curves[0]), largest(&curves[1])];
        let count = curves[0].len();
        side.meter.count(Counter::Slices, 2 * count as u64);
        let spread = spread(&curves, &depths(&sample));
        let mut answer = json!({
            "road_coordinate": sample.first as f64 * sample.lattice.dx,
            "lattice": sample.lattice,
            "slices": count,
            "slice_error": errors,
            "spread": spread,
        });
        let mut report = spread_report(&spread, count, errors);
        if calibrate {
            let calibration = calibration(loaded, patches as usize)?;
            answer["calibration"] = json!(calibration);
            match &calibration {
                Some(found) => report.append(calibration_report(found)),
                None => report.text("the road has no texture: nothing to calibrate\n"),
            }
        }
        draw(&mut side, &sample, [&curves[0][0], &curves[1][0]])?;
        side.json("slices.json", &answer);
        side.finish(context, &report)
    }
}

fn sample(loaded: &LoadedScene, at: f64, slices: u32) -> Result<Sample, CliError> {
    let scene = &loaded.scene;
    let read = || {
        let lattice = Plan::new(scene).lattice()?;
        let dx = lattice.dx;
        let mut surface = RoadSurface::open(&scene.road, lattice, road_limits(scene))?;
        let first = (at / dx).round() as i64;
        let there = surface.extent().map_or(i64::MAX, |(_, end)| (end / dx + 1e-6).floor() as i64 - first + 1);
        let rows = i64::from(slices).min(there.max(1)) as usize;
        let mut heights = vec![0.0; rows * lattice.cells()];
        surface.heights(first, rows, &mut heights)?;
        Ok(Sample { lattice, first, heights })
    };
    read().map_err(|error| in_scene(loaded, error).into())
}

/// Depth of every point under its slice's highest one \[m\], slice by slice.
fn depths(sample: &Sample) -> Vec<f64> {
    sample
        .heights
        .chunks(sample.lattice.cells())
        .flat_map(|row| {
            let peak = row.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            row.iter().map(move |height| peak - height)
        })
        .collect()
}

fn spread(curves: &[Vec<StiffnessCurve>; 2], depths: &[f64]) -> Vec<Spread> {
    // Penetrations at fractions of the road's mean depth: where the laws can differ.
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

fn spread_report(spread: &[Spread], slices: usize, errors: [f64; 2]) -> Report {
    let mut report = Report::default();
    if spread.is_empty() {
        report.text("the road is flat under every element: S(y) = y by every law\n");
        return report;
    }
    report.text(format!("S(y)/y over {slices} slices, mean and standard deviation\n"));
    let row = |row: &Spread| {
        let law = |law: usize| format!("{:.3} +- {:.3}", row.mean[law], row.deviation[law]);
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let y = format!("{:.3}", 1e3 * row.penetration);
        [y, law(0), law(1), percent(row.difference), percent(row.contact_fraction)]
    };
    let header = ["y [mm]", LAWS[0].1, LAWS[1].1, "rms difference", "area in contact"];
    report.table(numbers(header, spread.iter().map(row)));
    let [winkler, half_space] = errors.map(|error| 1e6 * error);
    report.text(format!("largest error of a curve by leaving breakpoints out: {winkler:.2} um, {half_space:.2} um\n"));
    report
}

fn draw(side: &mut Side, sample: &Sample, curves: [&StiffnessCurve; 2]) -> Result<(), CliError> {
    let title = &side.loaded.title();
    let lattice = sample.lattice;
    let slice = &sample.heights[..lattice.cells()];
    let peak = curves[0].peak;
    // The line that touches first: the levels count from its own peak, too.
    let highest = slice.iter().position(|&height| height >= peak).unwrap_or(0) / lattice.columns;
    let row = &slice[highest * lattice.columns..][..lattice.columns];
    let depth = row.iter().map(|height| peak - height).fold(0.0, f64::max);
    if depth <= 0.0 {
        return Ok(());
    }
    let across: Vec<f64> = (0..lattice.columns).map(|column| 1e3 * lattice.y(column)).collect();
    let x = || Axis::linear("Across the tyre [mm]", across[0]..across[across.len() - 1]);
    let levels = LEVELS.map(|share| share * depth);
    let named = levels.map(|level| format!("y = {:.2} mm", 1e3 * level));

    let profile = across.iter().zip(row).map(|(&y, &height)| (y, 1e3 * height)).collect();
    let mut series = vec![Series { name: "road", points: profile }];
    series.extend(levels.iter().zip(&named).map(|(level, name)| {
        let height = 1e3 * (peak - level);
        Series { name, points: vec![(across[0], height), (across[across.len() - 1], height)] }
    }));
    let heights = series.iter().flat_map(|series| series.points.iter().map(|point| point.1)).collect::<Vec<_>>();
    let heading = format!("Road across the tyre: {title}");
    let plot = LinePlot { title: &heading, x: x(), y: Axis::linear_around("Height [mm]", heights), series };
    side.picture("slice_profile.svg", plot.to_svg())?;

    let builder = slice_builder(Slices::HalfSpace, lattice)?;
    let (_, pressures) =
        builder.build_with_pressures(slice, CELL_LENGTH, lattice.dy, &levels, &mut SliceScratch::default())?;
    let pressures: Vec<&[f64]> =
        pressures.iter().map(|pressure| &pressure[highest * lattice.columns..][..lattice.columns]).collect();
    // The road has the first colour in the picture before; a penetration keeps its own.
    let mut series = vec![Series { name: "", points: Vec::new() }];
    let of_levels = pressures.iter().zip(&named).map(|(pressure, name)| Series {
        name,
        points: across.iter().copied().zip(pressure.iter().copied()).collect(),
    });
    series.extend(of_levels);
    let highest = pressures.iter().copied().flatten().fold(0.0_f64, |highest, pressure| highest.max(*pressure));
    let y = Axis::linear("Pressure / E* on a half-space [1]", 0.0..1.05 * highest);
    let heading = format!("Pressure across the tyre: {title}");
    let plot = LinePlot { title: &heading, x: x(), y, series };
    side.picture("slice_pressure.svg", plot.to_svg())?;

    let deepest = 1.25 * levels[levels.len() - 1];
    let curve = |value: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        (0..=POINTS).map(|i| deepest * i as f64 / POINTS as f64).map(|y| (1e3 * y, value(y))).collect()
    };
    for (file, quantity, values) in [
        ("slice_displacement.svg", "S(y) [mm]", curves.map(|c| curve(&|y| 1e3 * c.displacement_at(y)))),
        ("slice_stiffness.svg", "Normalised stiffness s(y) [1]", curves.map(|c| curve(&|y| c.stiffness_at(y)))),
    ] {
        let highest = values.iter().flatten().fold(0.0_f64, |top, point| top.max(point.1));
        let series = LAWS.iter().zip(values).map(|(&(_, name), points)| Series { name, points }).collect();
        let x = Axis::linear("Penetration y past the highest point [mm]", 0.0..1e3 * deepest);
        let heading = format!("A slice by both laws: {title}");
        let plot = LinePlot { title: &heading, x, y: Axis::linear(quantity, 0.0..1.05 * highest), series };
        side.picture(file, plot.to_svg())?;
    }
    Ok(())
}

/// Presses at most `most` patches of a scene's road; `None` for one without texture.
fn calibration(loaded: &LoadedScene, most: usize) -> Result<Option<Calibration>, CliError> {
    let scene = &loaded.scene;
    let (plan, limits) = (Plan::new(scene), road_limits(scene));
    let lattice = plan.lattice().map_err(|error| in_scene(loaded, error))?;
    let surface = RoadSurface::open(&scene.road, lattice, limits).map_err(|error| in_scene(loaded, error))?;
    let tyre = &plan.decisions.tyre;
    let found = local_compliance::calibrate(tyre, &scene.road, &surface, limits, plan.element, most);
    found.map_err(|error| match error {
        CalibrationError::Road(error) => in_scene(loaded, error).into(),
        CalibrationError::Slices(error) => error.into(),
        CalibrationError::HalfSpace(error) => error.into(),
    })
}

fn calibration_report(found: &Calibration) -> Report {
    let millimetres = |compliance: f64| format!("{:.2} mm", 1e3 * compliance * found.effective_modulus);
    let [length, width] = found.size.map(|size| 1e3 * size);
    let mut report = Report::default();
    report.text(format!(
        "\nCompliance of the local contact law: {} patches of {length:.0} by {width:.0} mm, E* = {:.2} MPa, \
         {} elements each\n",
        found.patches,
        1e-6 * found.effective_modulus,
        found.elements
    ));
    let header = ["", "kappa [m/Pa]", "kappa E*", "patch by patch", "rms difference", "of the formula"];
    let fitted = |name: &str, fit: &Fit, difference: &dyn Fn(f64) -> String| {
        let (low, high) =
            fit.by_patch.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &kappa| (low.min(kappa), high.max(kappa)));
        row([
            &name,
            &format!("{:.3e}", fit.compliance),
            &millimetres(fit.compliance),
            &format!("{} to {}", millimetres(low), millimetres(high)),
            &difference(fit.rms_difference),
            &difference(fit.rms_difference_of_formula),
        ])
    };
    let rows = [
        row([&"by formula", &format!("{:.3e}", found.formula), &millimetres(found.formula), &"", &"", &""]),
        fitted("by approach", &found.by_approach, &|difference| format!("{:.3} mm", 1e3 * difference)),
        fitted("by line pressure", &found.by_line_pressure, &|difference| format!("{:.1} %", 100.0 * difference)),
    ];
    report.table(aligned(header, rows));
    report.text("\n");
    let header = ["pressure", "contact", "approach", "of the law", "by formula", "line pressures", "by formula"];
    let rows = found.levels.iter().map(|level| {
        let length = |value: f64| format!("{:.3} mm", 1e3 * value);
        let pair = |which: usize| {
            let correlation = level.correlation[which].map_or("-".to_owned(), |value| format!("{value:.3}"));
            format!("{correlation}, {:.0} %", 100.0 * level.rms_difference[which])
        };
        [
            format!("{:.2} MPa", 1e-6 * level.pressure),
            format!("{:.0} %", 100.0 * level.contact_fraction),
            length(level.approach),
            length(level.approach_of_law[0]),
            length(level.approach_of_law[1]),
            pair(0),
            pair(1),
        ]
    });
    report.table(aligned(header, rows));
    report.text("line pressures: correlation and rms difference, local law against three dimensions\n\n");
    // The approach is what the law must give in the mean, and patches agree best on it; the pressures hardly tell
    // compliances apart.
    report.text(format!("[contact]\nlocal_compliance = {:.3e}\n\n", found.by_approach.compliance));
    report
}
