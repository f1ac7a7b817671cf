//! `tyrewave fit-tyre`: a tyre identified from measured driving-point mobilities.

use std::path::PathBuf;

use crate::counters::Stage;
use crate::results::plots::{Axis, ComparisonPanel, ComparisonPlot};
use crate::results::table::{Report, aligned, csv, row};
use crate::scene::{LoadedScene, SceneError, Tyre};
use crate::storage::input::{self, TABLE_BYTES};
use crate::study::fit_tyre::measured::{MeasuredPoint, SMALLEST_PATCH, read, sides};
use crate::study::fit_tyre::universal_file::{self, UniversalFile};
use crate::study::fit_tyre::{BOUND, Estimate, FitTyreError, PIECES, Parameter, TyreFit, Uncertainty, fit};
use crate::tyre::influence::mobility::{level, phase};
use clap::Args;
use num_complex::Complex64;
use serde_json::json;

use super::context::Context;
use super::error::CliError;
use super::options::{by_name, positive};
use super::side::Place;

const EXAMPLES: &str = "\
A CSV file has a header and one line for each measured value, several patches in one file; columns in any order:
  frequency_hz  frequency
  patch_m       side of the square patch that is driven and whose mean velocity is observed
  re, im        mobility in m/(N s), time factor exp(+i w t); or
  level_db      its level, dB re 1 m/(N s), and
  phase_deg     its phase
Or, without patch_m, the columns re_20mm and im_20mm for a patch of 20 mm, and so on, as `tyrewave mobility` and \
`tyrewave tyre` write them. Other columns and lines that begin with # are ignored.

A universal file (UFF, UNV) is read, too: the frequency responses at driving points of its datasets 58, text or \
binary, with the units of dataset 164 or of the axes' labels; accelerance, receptance and their inverses are converted \
to mobilities, and everything else in the file is skipped and counted. The file does not state the side of the patch: \
give it with --patch.

Data that cannot be a driving-point mobility are refused, with the likely reason: a phase beyond +-90 degrees by more \
than three times --phase-error, or a level that no fit from this tyre could reach.

The fit starts from the scene's tyre, and takes from it all parameters that are not fitted. Parameters: tread-modulus, \
tread-loss, tread-thickness, tread-density, belt-modulus, belt-loss, cord-stiffness, cord-angle, tension-along, \
tension-across, foundation-normal, foundation-tangential, foundation-loss, sidewall-radius, sidewall-angle, \
sidewall-mass, sidewall-shear, sidewall-loss. Some parameters are fitted only if --free names them: thickness and \
density of the tread (better weighed and measured), the angle of the belt's cords, the mass of the sidewalls, and the \
loss factors of foundation and sidewalls. If the scene's tension follows from inflation and sidewalls, it changes with \
the fitted sidewalls. Every parameter stays within a factor 4 of the start.

Results: tyre.toml, to be named in a scene as tyre = \"tyre.toml\"; fit.txt, fit.json; mobility.csv, measured and \
fitted; mobility.svg and residuals.svg. Intervals are 95 % confidence intervals, if the uncertainties and the model \
are right; they are wider by sqrt(chi^2/N) if this is above 1.

Examples:
  tyrewave fit-tyre mobility.csv scenes/default.toml
  tyrewave fit-tyre mobility.csv scenes/default.toml --free foundation-loss --fix tension-across --out fitted
  tyrewave fit-tyre mobility.csv scenes/default.toml --level-error 1 --phase-error 5 --json
  tyrewave fit-tyre tread.unv scenes/default.toml --patch 0.02 --lowest 40 --highest 2000";

/// A larger chi^2/N is not explained by chance.
const LARGE: f64 = 2.0;
/// Residuals are drawn up to this.
const WORST: f64 = 10.0;

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct FitTyreArguments {
    /// File of measured mobilities, CSV or universal (dataset 58), see below.
    #[arg(value_name = "MOBILITY")]
    mobility: PathBuf,
    #[command(flatten)]
    place: Place,
    /// Parameters that are not fitted.
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = by_name(Parameter::ALL, Parameter::name))]
    fix: Vec<Parameter>,
    /// Parameters that are fitted in addition to the usual ones.
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = by_name(Parameter::ALL, Parameter::name))]
    free: Vec<Parameter>,
    /// Standard deviation of the measured levels, in dB.
    #[arg(long, value_name = "DB", default_value = "0.5", value_parser = positive, allow_negative_numbers = true)]
    level_error: f64,
    /// Standard deviation of the measured phases, in degrees.
    #[arg(long, value_name = "DEGREES", default_value = "3", value_parser = positive, allow_negative_numbers = true)]
    phase_error: f64,
    /// Side of the square patch of a universal file, in m; or one for each of its driving points, in the file's order.
    #[arg(long, value_name = "METRES", value_delimiter = ',', value_parser = positive, allow_negative_numbers = true)]
    patch: Vec<f64>,
    /// Lowest frequency that is fitted, in Hz; below it a shaker or a hammer excites too little.
    #[arg(long, value_name = "HZ", value_parser = positive, allow_negative_numbers = true)]
    lowest: Option<f64>,
    /// Highest frequency that is fitted, in Hz.
    #[arg(long, value_name = "HZ", value_parser = positive, allow_negative_numbers = true)]
    highest: Option<f64>,
}

impl FitTyreArguments {
    /// Fits, writes the tyre with the quality of the fit, and prints tables or JSON.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let Self { mobility: path, place, fix, free, level_error, phase_error, patch, lowest, highest } = self;
        let mut side = place.open_tyre("fit-tyre", context)?;
        let free = free_parameters(&side.loaded, &fix, &free)?;
        let start = &side.loaded.scene.tyre;
        let bytes = input::read(&path, TABLE_BYTES).map_err(CliError::reading(&path))?;
        let in_file = |error: &dyn std::fmt::Display| CliError::Usage(format!("{}: {error}", path.display()));
        let range = [lowest.unwrap_or(0.0), highest.unwrap_or(f64::INFINITY)];
        let UniversalFile { points, notes } =
            measured(&bytes, start.width, &patch, range).map_err(|reported| in_file(&reported))?;
        let uncertainty = Uncertainty { level: level_error, phase: phase_error };
        let bar = context.bar("fitting the tyre", PIECES);
        let mut watch = |done: u64, text: &str| {
            bar.set_position(done);
            bar.set_message(text.to_owned());
        };
        let work = || fit(start, &free, &points, uncertainty, context.interrupt.flag(), &mut watch);
        let fitted = side.meter.time(Stage::Influence, work).map_err(|error| match error {
            FitTyreError::Interrupted => CliError::Interrupted { partial: None },
            other => in_file(&other),
        })?;
        bar.finish_and_clear();

        let title = side.loaded.title();
        let mut tables = tables(&fitted, &points);
        notes.iter().for_each(|note| tables.text(format!("note: {note}\n")));
        let heading = format!(
            "# Fitted by `tyrewave fit-tyre` to {} mobilities, from the tyre of: {}\n",
            points.len(),
            title.replace(char::is_control, " ")
        );
        side.file("tyre.toml", heading + &written(&fitted.tyre)?);
        side.file("fit.txt", tables.to_string());
        side.json("fit.json", &record(&fitted, &points));
        side.file("mobility.csv", to_csv(&fitted, &points));
        let names: Vec<String> =
            patches(&points).iter().map(|side| format!("{} mm", (side * 1e6).round() / 1e3)).collect();
        let titles = ["measured (marks) and fitted (lines)", "fitted minus measured"];
        let titles = titles.map(|what| format!("{title}: {what}"));
        let [overlay, residuals] = pictures(&fitted, &points, &titles, &names);
        side.file("mobility.svg", overlay.to_svg());
        side.file("residuals.svg", residuals.to_svg());
        side.settings = json!({
            "scene": side.settings,
            "mobility": path.display().to_string(),
            "free": free.iter().map(|parameter| parameter.name()).collect::<Vec<_>>(),
            "level_error_db": level_error,
            "phase_error_deg": phase_error,
            "patch": patch,
            "lowest": lowest,
            "highest": highest,
        });
        side.finish(context, &tables)
    }
}

/// Reads measured values between two frequencies \[Hz\], with notes about the file.
fn measured(bytes: &[u8], width: f64, patches: &[f64], range: [f64; 2]) -> Result<UniversalFile, String> {
    if universal_file::is_universal(bytes) {
        let is_side = |side: &f64| (SMALLEST_PATCH..=width).contains(side);
        return match patches.iter().find(|side| !is_side(side)) {
            Some(side) => Err(format!("--patch {side} is not {}", sides(width))),
            None if patches.is_empty() => {
                Err("a universal file does not state the side of the patch: give --patch, in m".to_owned())
            }
            None => universal_file::read(bytes, patches, range).map_err(|error| error.to_string()),
        };
    }
    if !patches.is_empty() {
        return Err("--patch is for universal files: here the column patch_m has the side".to_owned());
    }
    let mut points = read(bytes, width).map_err(|error| error.to_string())?;
    let [lowest, highest] = range;
    points.retain(|point| (lowest..=highest).contains(&point.frequency));
    if points.is_empty() {
        Err(format!("no values from {lowest} to {highest} Hz"))
    } else {
        Ok(UniversalFile { points, notes: Vec::new() })
    }
}

/// The usual parameters and those asked for, as far as the tyre has them.
fn free_parameters(loaded: &LoadedScene, fix: &[Parameter], free: &[Parameter]) -> Result<Vec<Parameter>, CliError> {
    if let Some(both) = free.iter().find(|parameter| fix.contains(parameter)) {
        return Err(CliError::Usage(format!("{} cannot be both free and fixed", both.name())));
    }
    let tyre = &loaded.scene.tyre;
    let missing = free.iter().filter(|parameter| parameter.value(tyre).is_none());
    let mut diagnostics = missing.map(|parameter| {
        let wrong = format!("{} cannot be fitted from 0, or without a starting value", parameter.name());
        loaded.complain(&parameter.key(tyre), wrong, "start from a positive value, or leave it out of --free")
    });
    if let Some(first) = diagnostics.next() {
        return Err(SceneError::from(first).into());
    }
    let wanted = |parameter: &Parameter| {
        let asked = free.contains(parameter) || (parameter.is_free_from(tyre) && !fix.contains(parameter));
        asked && parameter.value(tyre).is_some()
    };
    let chosen: Vec<Parameter> = Parameter::ALL.into_iter().filter(wanted).collect();
    if chosen.is_empty() { Err(CliError::Usage("every parameter is fixed".to_owned())) } else { Ok(chosen) }
}

/// The tyre as TOML.
fn written(tyre: &Tyre) -> Result<String, CliError> {
    Ok(toml::to_string(tyre).map_err(|source| SceneError::NotToml { source })?)
}

/// Distinct sides of patches \[m\], the largest first.
fn patches(points: &[MeasuredPoint]) -> Vec<f64> {
    let mut sides: Vec<f64> = points.iter().map(|point| point.patch).collect();
    sides.sort_by(|a, b| b.total_cmp(a));
    sides.dedup_by(|a, b| a.total_cmp(b).is_eq());
    sides
}

/// Everything as JSON, for programs; an infinite number is null.
fn record(fit: &TyreFit, points: &[MeasuredPoint]) -> serde_json::Value {
    let estimate = |estimate: &Estimate| {
        let Estimate { parameter, start, value, deviation, interval, at_bound } = estimate;
        json!({
            "name": parameter.name(),
            "unit": parameter.unit(),
            "start": start,
            "value": value,
            "interval_95": interval,
            "relative_deviation": deviation,
            "at_bound": at_bound,
        })
    };
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "measured_values": points.len(),
        "chi_squared_per_n": { "start": fit.chi_squared[0], "fitted": fit.chi_squared[1] },
        "converged": fit.converged,
        "condition": fit.condition,
        "parameters": fit.estimates.iter().map(estimate).collect::<Vec<_>>(),
        "correlations": fit.correlations,
        "tyre": fit.tyre,
    })
}

/// True if the measurement determines a parameter: the interval, given by its upper end, is narrower than the bounds.
fn is_determined(value: f64, upper: f64) -> bool {
    upper / value < BOUND
}

/// Tables and text for people.
fn tables(fit: &TyreFit, points: &[MeasuredPoint]) -> Report {
    let mut report = Report::default();
    let [before, after] = fit.chi_squared;
    report.text(format!(
        "{} measured values of {} patches: chi^2/N {after:.2} ({before:.1} at the start), condition {:.0}\n\n",
        points.len(),
        patches(points).len(),
        fit.condition
    ));
    let number = |value: f64| if (1e-2..1e4).contains(&value) { format!("{value:.4}") } else { format!("{value:.3e}") };
    let named = |parameter: Parameter| match parameter.unit() {
        "" => parameter.name().to_owned(),
        unit => format!("{} [{unit}]", parameter.name()),
    };
    let reported = |parameter: Parameter| match fit.estimates.iter().find(|estimate| estimate.parameter == parameter) {
        Some(Estimate { start, value, interval: [from, to], at_bound, .. }) => {
            let note = if *at_bound { "at its bound" } else { "" };
            let (start, fitted) = (number(*start), number(*value));
            if !is_determined(*value, *to) {
                return row([&named(parameter), &start, &fitted, &"-", &"-", &"not determined", &note]);
            }
            let width = format!("{:.1}", 100.0 * (to / value - 1.0));
            row([&named(parameter), &start, &fitted, &number(*from), &number(*to), &width, &note])
        }
        None => {
            let value = parameter.value(&fit.tyre).map_or("none".to_owned(), number);
            row([&named(parameter), &value, &value, &"", &"", &"", &"fixed"])
        }
    };
    report.table(aligned(["", "start", "fitted", "95 % from", "to", "+- %", ""], Parameter::ALL.map(reported)));
    report.text("\nCorrelations:\n");
    let header = [String::new()].into_iter().chain((1..=fit.estimates.len()).map(|number| number.to_string()));
    let rows = fit.estimates.iter().zip(&fit.correlations).zip(1..).map(|((estimate, row), number)| {
        let name = format!("{number} {}", estimate.parameter.name());
        [name].into_iter().chain(row.iter().map(|value| format!("{value:.2}")))
    });
    report.table(aligned(header, rows));
    report.text("\n");
    let lost = |estimate: &&Estimate| estimate.at_bound || !is_determined(estimate.value, estimate.interval[1]);
    let lost: Vec<&str> = fit.estimates.iter().filter(lost).map(|estimate| estimate.parameter.name()).collect();
    if !lost.is_empty() {
        let lost = lost.join(",");
        report.text(format!(
            "note: not determined, because the measurement hardly depends on it or the start is a factor {BOUND} away: \
             {lost}; fix it (--fix {lost}), or start nearer\n"
        ));
    }
    if after > LARGE {
        report.text(format!(
            "note: the residuals are {:.1} times as large as the uncertainties explain: residuals.svg shows whether a \
             patch's side, the model or the uncertainties are wrong\n",
            after.sqrt()
        ));
    }
    if !fit.converged {
        report
            .text("note: the minimum was not reached within the largest number of steps: start again from tyre.toml\n");
    }
    report
}

/// CSV with one line for each measured value, in the file's order; it can be fitted again.
fn to_csv(fit: &TyreFit, points: &[MeasuredPoint]) -> String {
    let header =
        "frequency_hz,patch_m,level_db,phase_deg,fitted_level_db,fitted_phase_deg,level_residual,phase_residual";
    let mobilities = points.iter().zip(&fit.mobilities);
    let rows = mobilities.zip(fit.residuals.chunks_exact(2)).map(|((point, &fitted), residual)| {
        let [measured, fitted] = [point.mobility, fitted].map(|mobility| [level(mobility), phase(mobility)]);
        [&[point.frequency, point.patch], &measured[..], &fitted, residual].concat()
    });
    csv(header.split(','), rows)
}

/// Measured and fitted levels and phases; residuals in uncertainties.
fn pictures<'a>(
    fit: &TyreFit,
    points: &[MeasuredPoint],
    titles: &'a [String; 2],
    names: &'a [String],
) -> [ComparisonPlot<'a>; 2] {
    let sides = patches(points);
    // One list per patch, by rising frequency.
    let by_patch = |value: &dyn Fn(usize) -> f64| -> Vec<Vec<(f64, f64)>> {
        let of = |side: &f64| {
            let of_patch = points.iter().enumerate().filter(|(_, point)| point.patch.total_cmp(side).is_eq());
            let mut list: Vec<(f64, f64)> = of_patch.map(|(index, point)| (point.frequency, value(index))).collect();
            list.sort_by(|a, b| a.0.total_cmp(&b.0));
            list
        };
        sides.iter().map(of).collect()
    };
    let panel = |title: &str, least: &[f64], points: Vec<Vec<(f64, f64)>>, curves: Vec<Vec<(f64, f64)>>| {
        let values = points.iter().chain(&curves).flatten().map(|point| point.1).chain(least.iter().copied());
        ComparisonPanel { y: Axis::linear_around(title, values), points, curves }
    };
    let compared = |title: &str, of: fn(Complex64) -> f64| {
        panel(title, &[], by_patch(&|index| of(points[index].mobility)), by_patch(&|index| of(fit.mobilities[index])))
    };
    // The axis shows at least one uncertainty to either side: smaller residuals need no attention.
    let residuals = |title: &str, part: usize| {
        let residuals = by_patch(&|index| fit.residuals[2 * index + part].clamp(-WORST, WORST));
        panel(title, &[-1.0, 1.0], residuals, Vec::new())
    };
    let frequencies = points.iter().map(|point| point.frequency);
    let x = Axis::logarithmic_around("Frequency [Hz]", frequencies, [0.97, 1.03]);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let plot = |title: &'a str, panels: [ComparisonPanel; 2]| ComparisonPlot {
        title,
        x: x.clone(),
        names: names.clone(),
        panels: panels.into(),
    };
    [
        plot(&titles[0], [compared("Mobility [dB re 1 m/(N s)]", level), compared("Phase [degrees]", phase)]),
        plot(&titles[1], [residuals("Level residual / uncertainty", 0), residuals("Phase residual / uncertainty", 1)]),
    ]
}
