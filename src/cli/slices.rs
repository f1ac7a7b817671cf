//! `tyrewave slices`: one slice of a scene's road by both laws, and the spread over the road.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use serde_json::json;
use tyrewave::counters::{Counter, Meter, Stage};
use tyrewave::plan::{Plan, settled};
use tyrewave::results::plots::{Axis, LinePlot, Series};
use tyrewave::results::summary::Cost;
use tyrewave::results::{ResultsFolder, Summary};
use tyrewave::road::slices::statistics::{LevelStatistics, statistics};
use tyrewave::road::slices::{CELL_LENGTH, SliceScratch, StiffnessCurve};
use tyrewave::road::{Lattice, RoadSurface};
use tyrewave::run::prepare::{in_scene, road_limits, slice_builder};
use tyrewave::scene::{LoadedScene, Scene, Slices};

use super::{CliError, Context, calibrate, side_folder};

const EXAMPLES: &str = "\
Drawn, as in the paper's figure 4: the profile of the slice's highest line of cells with the indentation levels, the pressure under them on an elastic half-space, and the \
displacement S(y) and stiffness s(y) by both laws. Printed: the spread of S over the road, and the share of the area in contact.

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

/// Arguments of `tyrewave slices`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct SlicesArguments {
    /// The scene; its road, contact width and elements count.
    pub scene: PathBuf,
    /// Road coordinate of the slice that is drawn, in m.
    #[arg(long, value_name = "X", default_value_t = 0.5, allow_negative_numbers = true)]
    pub at: f64,
    /// Number of slices that the statistics cover, from the drawn one on.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub slices: u32,
    /// Fit the compliance of the local contact law to patches of the road pressed into a half-space.
    #[arg(long)]
    pub calibrate: bool,
    /// Most patches that are pressed; a road that ends may hold fewer.
    #[arg(long, value_name = "N", default_value_t = 8, requires = "calibrate", value_parser = patch_count())]
    pub patches: u32,
    /// Folder for the pictures and slices.json; default: results/NAME-slices, NAME being the scene's.
    #[arg(long, short, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
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
    ///
    /// # Errors
    /// [`CliError`].
    pub fn execute(self, context: &Context) -> Result<(), CliError> {
        let loaded = settled(Scene::load(&self.scene)?)?;
        let begin = std::time::Instant::now();
        let mut meter = Meter::default();
        let sample = meter.time(Stage::Road, || self.sample(&loaded))?;
        let laws = [Slices::Winkler, Slices::HalfSpace];
        let curves = meter.time(Stage::Slices, || -> Result<_, CliError> {
            let tolerance = loaded.scene.contact.slice_tolerance;
            let build = |law| {
                let builder = slice_builder(law, sample.lattice)?.with_tolerance(tolerance)?;
                Ok::<_, CliError>(builder.build_rows(&sample.heights)?)
            };
            Ok([build(laws[0])?, build(laws[1])?])
        })?;
        let errors =
            [0, 1].map(|law: usize| curves[law].iter().fold(0.0_f64, |largest, curve| largest.max(curve.error)));
        meter.count(Counter::Slices, 2 * curves[0].len() as u64);
        let depths = depths(&sample);
        let spread = spread(&curves, &depths);
        let calibration = if self.calibrate { calibrate::calibration(&loaded, self.patches as usize)? } else { None };
        let target = self.out.clone().unwrap_or_else(|| side_folder(&self.scene, "slices"));
        let folder = ResultsFolder::create(&target)?;
        let title = loaded.title();
        draw(&folder, &title, &sample, [&curves[0][0], &curves[1][0]])?;
        let mut answer = json!({
            "road_coordinate": sample.first as f64 * sample.lattice.dx,
            "lattice": sample.lattice,
            "slices": curves[0].len(),
            "slice_error": errors,
            "spread": spread,
        });
        if self.calibrate {
            answer["calibration"] = json!(calibration);
        }
        folder.write_text("slices.json", &format!("{answer:#}\n"))?;
        let cost = Cost::new(&meter, begin.elapsed().as_secs_f64(), context.threads);
        let place = folder.finish(Summary::begun(&title, loaded.settings()?, cost))?;
        let calibrated = if self.calibrate { calibrate::text(calibration.as_ref()) } else { String::new() };
        let spread = table(&spread, curves[0].len(), errors);
        context.answer(&format!("{spread}{calibrated}"), &place)
    }

    fn sample(&self, loaded: &LoadedScene) -> Result<Sample, CliError> {
        let scene = &loaded.scene;
        let read = || {
            let lattice = Plan::new(scene).lattice()?;
            let dx = lattice.dx;
            let mut surface = RoadSurface::open(&scene.road, lattice, road_limits(scene))?;
            let first = (self.at / dx).round() as i64;
            let there = surface.extent().map_or(i64::MAX, |(_, end)| (end / dx + 1e-6).floor() as i64 - first + 1);
            let rows = i64::from(self.slices).min(there.max(1)) as usize;
            let mut heights = vec![0.0; rows * lattice.cells()];
            surface.heights(first, rows, &mut heights)?;
            Ok(Sample { lattice, first, heights })
        };
        read().map_err(|error| in_scene(loaded, error).into())
    }
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

fn table(spread: &[Spread], slices: usize, errors: [f64; 2]) -> String {
    if spread.is_empty() {
        return "the road is flat under every element: S(y) = y by every law\n".into();
    }
    let mut text = format!("S(y)/y over {slices} slices, mean and standard deviation\n");
    text.push_str("     y [mm]   winkler           half-space        rms difference   area in contact\n");
    for row in spread {
        text.push_str(&format!(
            "   {:8.3}   {:.3} +- {:.3}    {:.3} +- {:.3}    {:8.1} %       {:8.1} %\n",
            1e3 * row.penetration,
            row.mean[0],
            row.deviation[0],
            row.mean[1],
            row.deviation[1],
            100.0 * row.difference,
            100.0 * row.contact_fraction
        ));
    }
    text.push_str(&format!(
        "largest error of a curve by leaving breakpoints out: {:.2} um, {:.2} um\n",
        1e6 * errors[0],
        1e6 * errors[1]
    ));
    text
}

fn draw(folder: &ResultsFolder, title: &str, sample: &Sample, curves: [&StiffnessCurve; 2]) -> Result<(), CliError> {
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
    let plot = LinePlot { title, x: x(), y: Axis::linear_around("Height [mm]", heights), series };
    folder.write_text("slice_profile.svg", &plot.to_svg()?)?;

    let builder = slice_builder(Slices::HalfSpace, lattice)?;
    let (_, pressures) =
        builder.build_with_pressures(slice, CELL_LENGTH, lattice.dy, &levels, &mut SliceScratch::default())?;
    let pressures: Vec<&[f64]> =
        pressures.iter().map(|pressure| &pressure[highest * lattice.columns..][..lattice.columns]).collect();
    let series: Vec<Series<'_>> = pressures
        .iter()
        .zip(&named)
        .map(|(pressure, name)| Series { name, points: across.iter().copied().zip(pressure.iter().copied()).collect() })
        .collect();
    let highest = pressures.iter().copied().flatten().fold(0.0_f64, |highest, pressure| highest.max(*pressure));
    let y = Axis::linear("Pressure / E* on a half-space [1]", 0.0..1.05 * highest);
    let plot = LinePlot { title, x: x(), y, series };
    folder.write_text("slice_pressure.svg", &plot.to_svg()?)?;

    let deepest = 1.25 * levels[levels.len() - 1];
    let curve = |value: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        (0..=POINTS).map(|i| deepest * i as f64 / POINTS as f64).map(|y| (1e3 * y, value(y))).collect()
    };
    let names = ["winkler", "half-space"];
    for (file, quantity, values) in [
        ("slice_displacement.svg", "S(y) [mm]", curves.map(|c| curve(&|y| 1e3 * c.displacement_at(y)))),
        ("slice_stiffness.svg", "Normalised stiffness s(y) [1]", curves.map(|c| curve(&|y| c.stiffness_at(y)))),
    ] {
        let highest = values.iter().flatten().fold(0.0_f64, |top, point| top.max(point.1));
        let series = names.iter().zip(values).map(|(&name, points)| Series { name, points }).collect();
        let x = Axis::linear("Penetration y past the highest point [mm]", 0.0..1e3 * deepest);
        let plot = LinePlot { title, x, y: Axis::linear(quantity, 0.0..1.05 * highest), series };
        folder.write_text(file, &plot.to_svg()?)?;
    }
    Ok(())
}
