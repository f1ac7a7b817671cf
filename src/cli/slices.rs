//! `tyrewave slices`: one slice of a scene's road by both laws, the spread over the road, and with `--calibrate` the
//! local contact law fitted to patches of the road.

use crate::contact::local_compliance::calibrate::ComplianceFit;
use crate::contact::local_compliance::{self, Calibration, CalibrationError};
use crate::counters::{Counter, Stage};
use crate::plan::Plan;
use crate::report::slices::pictures;
use crate::results::table::{Report, aligned, numbers, row};
use crate::road::RoadSurface;
use crate::road::slices::StiffnessCurve;
use crate::run::road::{in_scene, road_limits};
use crate::scene::LoadedScene;
use crate::study::slices::{LAWS, Sample, Spread, spread};
use clap::Args;
use serde_json::json;

use super::context::Context;
use super::error::CliError;
use super::options::finite;
use super::side::Place;

const EXAMPLES: &str = "\
Drawn, as in the paper's figure 4: the profile of the slice's highest line of cells with the indentation levels, the \
pressure at these levels on an elastic half-space, and the displacement S(y) and stiffness s(y) by both laws. Printed: \
the spread of S over the road, and the share of the area in contact; slices.json has these values, too. They depend \
only on the scene's road, contact width and elements.

With --penetrations, slices.json has `slice`: the heights of that slice, and by each law its mean displacement S [m] \
(S = y for a flat slice; below 0 the gap itself) and the pressure on each of its cells, relative to E/(1 - nu^2). \
Springs have the stiffness of the flat slice on the half-space, so that both laws press a flat slice equally hard.

With --calibrate, patches of the road are pressed into a half-space of the tread's modulus, and the only parameter of \
the local contact law is fitted: kappa, the displacement of the tread under the texture per mean pressure. One fit is \
to the approach of road and tread, another to the pressures of elements. The last line is the key for a scene.

Examples:
  tyrewave slices scenes/default.toml
  tyrewave slices scenes/default.toml --at 3.2 --slices 5000
  tyrewave slices scenes/default.toml --at 3.2 --penetrations 0.0005,0.001,0.002
  tyrewave slices scenes/default.toml --calibrate --patches 12";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct SlicesArguments {
    #[command(flatten)]
    place: Place,
    /// Road coordinate of the slice in the pictures, in m.
    #[arg(long, value_name = "X", default_value_t = 0.5, allow_negative_numbers = true)]
    at: f64,
    /// Number of slices in the statistics, beginning with the slice in the pictures.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    slices: u32,
    /// Penetrations past the highest point of the slice in the pictures, in m, separated by commas: slices.json has its
    /// displacement and its pressures there.
    #[arg(long, value_name = "Y1,Y2,...", value_delimiter = ',', allow_hyphen_values = true, value_parser = finite)]
    penetrations: Vec<f64>,
    /// Fit the compliance of the local contact law to patches of the road pressed into a half-space.
    #[arg(long)]
    calibrate: bool,
    /// Largest number of patches that are pressed; a road of finite length may have fewer.
    #[arg(long, value_name = "N", default_value_t = 8, requires = "calibrate", value_parser = patch_count())]
    patches: u32,
}

/// Number of patches, within a range that ends within a reasonable time.
fn patch_count() -> clap::builder::RangedI64ValueParser<u32> {
    clap::value_parser!(u32).range(1..=1000)
}

impl SlicesArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let Self { place, at, slices, penetrations, calibrate, patches } = self;
        let mut side = place.open("slices", context)?;
        let loaded = &side.loaded;
        let sample = side.meter.time(Stage::Road, || Sample::of(loaded, at, slices as usize))?;
        let tolerance = loaded.scene.contact.slice_tolerance;
        let curves = side.meter.time(Stage::Slices, || sample.curves(tolerance))?;
        let largest = |curves: &Vec<StiffnessCurve>| curves.iter().fold(0.0_f64, |error, curve| error.max(curve.error));
        let errors = [largest(&curves[0]), largest(&curves[1])];
        let count = curves[0].len();
        side.meter.count(Counter::Slices, 2 * count as u64);
        let spread = spread(&curves, &sample.depths());
        let mut answer = json!({
            "road_coordinate": sample.first as f64 * sample.lattice.dx,
            "lattice": sample.lattice,
            "slices": count,
            "slice_error": errors,
            "spread": spread,
        });
        if !penetrations.is_empty() {
            answer["slice"] = json!(sample.pressed(&penetrations)?);
        }
        let mut report = spread_report(&spread, count, errors);
        if calibrate {
            let calibration = calibration(loaded, patches as usize)?;
            answer["calibration"] = json!(calibration);
            match &calibration {
                Some(found) => report.append(calibration_report(found)),
                None => report.text("the road has no texture: nothing to calibrate\n"),
            }
        }
        if let Some(view) = sample.view([&curves[0][0], &curves[1][0]])? {
            for (name, picture) in pictures(&side.loaded.title(), &view) {
                side.file(name, picture);
            }
        }
        side.json("slices.json", &answer);
        side.finish(context, &report)
    }
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
    report.text(format!(
        "largest error of a curve because of omitted breakpoints: {winkler:.2} um, {half_space:.2} um\n"
    ));
    report
}

/// Presses at most `most` patches of a scene's road; `None` for a road without texture.
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
    let fitted = |name: &str, fit: &ComplianceFit, difference: &dyn Fn(f64) -> String| {
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
    // The approach is what the law must reproduce in the mean, and patches agree best on it; pressures hardly depend on
    // the compliance.
    report.text(format!("[contact]\nlocal_compliance = {:.3e}\n\n", found.by_approach.compliance));
    report
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use crate::cli::{Command, CommandLine};

    #[test]
    fn penetrations_may_begin_with_a_gap_and_are_finite() {
        let parse = |at: &str| CommandLine::try_parse_from(["tyrewave", "slices", "s.toml", "--penetrations", at]);
        let Command::Slices(found) = parse("-1e-4,2e-4").unwrap().command else { panic!("another command") };
        assert!(
            found
                .penetrations
                .iter()
                .zip([-1e-4, 2e-4])
                .all(|(found, given): (&f64, f64)| found.to_bits() == given.to_bits())
        );
        assert_eq!(found.penetrations.len(), 2);
        assert_eq!(parse("nan").unwrap_err().exit_code(), 2);
    }
}
