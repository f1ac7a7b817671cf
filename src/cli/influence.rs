//! `tyrewave influence`: the influence functions of a scene's tyre, fitted and checked.

use std::f64::consts::PI;
use std::time::Instant;

use crate::counters::{Counter, Stage};
use crate::plan::models::{fetch, refused};
use crate::plan::{Decisions, fit_options};
use crate::results::PlotError;
use crate::results::plots::{Axis, Colours, ComparisonPanel, ComparisonPlot, HeatMap, LinePlot, Series};
use crate::results::table::{Report, Table, aligned};
use crate::run::Progress;
use crate::run::RunError;
use crate::scene::{Law, TimeRule, Tyre};
use crate::tyre::influence::{Field, InfluenceSum, Projection, Truncation};
use crate::tyre::poles::{Direction, RationalModel};
use crate::tyre::views::{Causality, causality, element_mobility, impulse_responses, magnitudes, static_ratios};
use clap::Args;
use ndarray::Array2;
use num_complex::Complex64;
use serde_json::{Value, json};

use super::context::Context;
use super::error::CliError;
use super::influence_cost::CostReport;
use super::side::Place;

const EXAMPLES: &str = "\
Drawn: |H_n| over wavenumber and frequency with the fitted poles, the influence over distance and time, the static \
influence beside the half-space's, and an element's mobility from the fit beside the sums. Printed, and in \
influence.json: poles, samples and errors; causality of the tyre's own laws and of the hysteretic one. Of the scene \
its tyre, elements, speed and tolerances count. A tyre that turns answers differently on either side of the force, and \
its map has waves against the rotation left of 0.

Examples:
  tyrewave influence scenes/default.toml
  tyrewave influence scenes/default.toml --out influence
  tyrewave influence scenes/default.toml --cost";

/// Number of frequencies of the map and of the mobility.
const FREQUENCIES: usize = 240;
/// Lowest and highest frequency drawn \[Hz\].
const BAND: (f64, f64) = (30.0, 10e3);
/// Number of times of the response, and their spacing \[s\].
const TIMES: (usize, f64) = (240, 5e-5);
/// Lags on either side of t = 0 by which causality is judged.
const LAGS: usize = 512;
/// Wavenumbers whose causality is reported.
const CHECKED: [usize; 4] = [0, 5, 20, 100];

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct InfluenceArguments {
    #[command(flatten)]
    place: Place,
    /// Fit anew with 512 to 8192 elements, with 2 to 9 layers, and on one thread beside all of them, and report what
    /// each takes (minutes; on an idle machine).
    #[arg(long)]
    cost: bool,
}

/// Data of all pictures and checks.
struct View<'a> {
    title: &'a str,
    /// As it rolls: with its rotation, if it turns.
    tyre: &'a Tyre,
    model: &'a RationalModel,
    sum: InfluenceSum,
}

impl InfluenceArguments {
    /// Fits (or takes from the cache), checks, draws.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let mut side = self.place.open("influence", context)?;
        let loaded = side.loaded.clone();
        let (title, scene, stop) = (loaded.title(), &loaded.scene, context.interrupt.flag());
        let mut progress = context.progress();
        progress.stage(Stage::Influence);
        let options = fit_options(scene, Field::Surface);
        let tyre = Decisions::new(scene).tyre;
        let begin = Instant::now();
        let fetched = side
            .meter
            .time(Stage::Influence, || fetch(&tyre, &options, stop))
            .map_err(|error| RunError::from(refused(&loaded, error, "another tolerance")))?;
        let fit_seconds = begin.elapsed().as_secs_f64();
        for warning in &fetched.warnings {
            progress.warning(warning);
        }
        let model = &fetched.model;
        side.meter.count(Counter::ComplianceEvaluations, if fetched.warm { 0 } else { model.evaluations() });
        side.meter.count(Counter::Poles, model.order() as u64);
        let sum = exact(&tyre, scene.numerics.elements, options.influence_tolerance, options.top);
        let view = View { title: &title, sum, tyre: &tyre, model };
        side.picture("influence_map.svg", view.map())?;
        side.picture("influence_time.svg", view.over_time())?;
        side.file("influence_static.svg", view.at_rest());
        side.file("influence_mobility.svg", view.mobility());
        let (checks, statistics) = (view.checks(), model.statistics());
        let worst = |value: &dyn Fn(usize) -> f64| (0..statistics.len()).map(value).fold(0.0, f64::max);
        let mut report = Report::default();
        report.text(format!(
            "{} poles for {} wavenumbers, {} in {fit_seconds:.2} s, {} compliance evaluations\n\
             largest error on fresh points: axis {:.1e}, real axis {:.1e}, belt {:.1e} (tolerance {:.1e})\n",
            model.order(),
            statistics.len(),
            if fetched.warm { "from the cache" } else { "fitted" },
            model.evaluations(),
            worst(&|n| statistics[n].error),
            worst(&|n| statistics[n].real_axis_error),
            worst(&|n| statistics[n].bottom_error),
            model.tolerance,
        ));
        report.table(causality_table(&checks));
        let mut answer = json!({
            "causality": checks,
            "cost": null,
            "order": model.order(),
            "wavenumbers": statistics,
        });
        if self.cost {
            let mut tick = || progress.stage(Stage::Influence);
            let costs = CostReport::new(&tyre, &options, stop, &mut tick)
                .map_err(|error| RunError::from(refused(&loaded, error, "another tolerance")))?;
            side.file("influence_cost.svg", costs.plot(&title));
            answer["cost"] = costs.to_json();
            report.text("\n");
            report.append(costs.report());
        }
        side.json("influence.json", &answer);
        drop(progress);
        side.finish(context, &report)
    }
}

/// The sums without a fit, up to |s| = `top` \[rad/s\].
fn exact(tyre: &Tyre, elements: usize, tolerance: f64, top: f64) -> InfluenceSum {
    InfluenceSum::with(tyre, Projection::new(tyre, elements), Truncation::Tail, tolerance, top)
}

fn frequencies() -> Vec<f64> {
    let ratio: f64 = BAND.1 / BAND.0;
    (0..FREQUENCIES).map(|k| BAND.0 * ratio.powf((k as f64 + 0.5) / FREQUENCIES as f64)).collect()
}

fn decibel(value: f64) -> f64 {
    20.0 * value.log10()
}

impl View<'_> {
    fn elements(&self) -> usize {
        self.model.elements
    }

    /// Picture of |H_n| \[dB\]; cells with a lightly damped pole have no value and are grey.
    fn map(&self) -> Result<String, PlotError> {
        let frequencies = frequencies();
        let half = self.elements() / 2;
        let magnitudes = |direction| {
            let wavenumbers: Vec<usize> = (0..=half).collect();
            magnitudes(self.model, Field::Surface, direction, &wavenumbers, &frequencies).unwrap_or_default()
        };
        let forwards = magnitudes(Direction::Forwards);
        // Waves against the rotation go left of 0, if they differ.
        let left = if self.model.turns() { half } else { 0 };
        let backwards = if left > 0 { magnitudes(Direction::Backwards) } else { Vec::new() };
        let of_column = |column: usize| match column.checked_sub(left) {
            Some(n) => (Direction::Forwards, n),
            None => (Direction::Backwards, left - column),
        };
        let value = |(row, column): (usize, usize)| match of_column(column) {
            (Direction::Forwards, n) => decibel(forwards[n][row]),
            (Direction::Backwards, n) => decibel(backwards[n][row]),
        };
        let columns = left + half + 1;
        let mut values = Array2::from_shape_fn((FREQUENCIES, columns), value);
        for column in 0..columns {
            let (direction, n) = of_column(column);
            let Some(modes) = self.model.modes(n, Field::Surface) else { continue };
            let rings = |&index: &usize| {
                let pole = modes.poles[index];
                -pole.re < 0.3 * pole.norm() && modes.belongs_to(direction, index)
            };
            for pole in (0..modes.pairs).filter(rings).map(|index| modes.poles[index]) {
                let place = (pole.im / (2.0 * PI) / BAND.0).ln() / (BAND.1 / BAND.0).ln() * FREQUENCIES as f64;
                if (0.0..FREQUENCIES as f64).contains(&place) {
                    values[(place as usize, column)] = f64::NAN;
                }
            }
        }
        let label = if left > 0 {
            "Wavenumber n (waves round the tyre, positive: with the rotation)"
        } else {
            "Wavenumber n (waves round the tyre)"
        };
        let map = HeatMap {
            title: &format!("Influence by wavenumber: {}", self.title),
            x: Axis::linear(label, -0.5 - left as f64..half as f64 + 0.5),
            y: Axis::logarithmic("Frequency [Hz]", BAND.0..BAND.1),
            quantity: "|H_n| [dB re 1 m/N]; grey: fitted poles",
            values: values.view(),
            colours: Colours::Extent,
            aspect: None,
        };
        map.to_svg()
    }

    fn over_time(&self) -> Result<String, PlotError> {
        let times: Vec<f64> = (0..TIMES.0).map(|k| (k as f64 + 0.5) * TIMES.1).collect();
        let half = self.elements() / 4;
        let response =
            |distances: &[usize]| impulse_responses(self.model, Field::Surface, distances, &times).unwrap_or_default();
        let right = response(&(0..=half).collect::<Vec<_>>());
        // Symmetric if the tyre does not turn: the same to the left.
        let left = self.model.turns().then(|| {
            response(&(0..=half).map(|distance| (self.elements() - distance) % self.elements()).collect::<Vec<_>>())
        });
        let value = |(row, column): (usize, usize)| {
            let rows = left.as_ref().filter(|_| column < half).unwrap_or(&right);
            1e3 * rows[column.abs_diff(half)][row]
        };
        let values = Array2::from_shape_fn((TIMES.0, 2 * half + 1), value);
        let dx = self.tyre.circumference / self.elements() as f64;
        let map = HeatMap {
            title: &format!("Influence over distance and time: {}", self.title),
            x: Axis::linear("Distance from the force [m]", -(half as f64 + 0.5) * dx..(half as f64 + 0.5) * dx),
            y: Axis::linear("Time [ms]", 0.0..1e3 * TIMES.0 as f64 * TIMES.1),
            quantity: "Influence function g [mm/(N s)]",
            values: values.view(),
            colours: Colours::Extent,
            aspect: None,
        };
        map.to_svg()
    }

    /// Picture of the static influence over distance relative to that at distance 0, beside the elastic half-space's
    /// (Love).
    fn at_rest(&self) -> String {
        let tyre = self.tyre;
        let dx = tyre.circumference / self.elements() as f64;
        let reach = (0.1 / dx) as usize + 1;
        let ratios = static_ratios(self.model, Field::Surface, [dx, tyre.contact_width], reach).unwrap_or_default();
        let distance = |j: usize| 1e3 * dx * j as f64;
        let plot = LinePlot {
            title: &format!("Influence at rest: {}", self.title),
            x: Axis::linear("Distance [mm]", 0.0..1e3 * dx * reach as f64),
            y: Axis::linear("Static influence, relative to the element's own [1]", 0.0..1.0),
            series: vec![
                Series { name: "tyre", points: ratios.iter().map(|r| (distance(r.distance), r.tyre)).collect() },
                Series {
                    name: "half-space",
                    points: ratios.iter().map(|r| (distance(r.distance), r.half_space)).collect(),
                },
            ],
        };
        plot.to_svg()
    }

    fn mobility(&self) -> String {
        let frequencies = frequencies();
        let curve = |value: &(dyn Fn(Complex64) -> Complex64 + Sync)| -> Vec<(f64, f64)> {
            frequencies.iter().map(|&f| (f, decibel(value(Complex64::new(0.0, 2.0 * PI * f)).norm()))).collect()
        };
        let elements = self.elements();
        let fitted = curve(&|s| {
            element_mobility(elements, s, |n| self.model.evaluate(n, s, Field::Surface).unwrap_or_default())
        });
        let summed = curve(&|s| {
            let at = self.sum.at(s);
            element_mobility(elements, s, |n| self.sum.value(n, &at, Field::Surface).value)
        });
        // The two curves coincide in a picture: their difference is drawn below.
        let differences: Vec<(f64, f64)> =
            fitted.iter().zip(&summed).map(|(fit, sum)| (fit.0, fit.1 - sum.1)).collect();
        let panel = |quantity: &str, points: Vec<(f64, f64)>| ComparisonPanel {
            y: Axis::linear_around(quantity, points.iter().map(|point| point.1)),
            points: vec![Vec::new()],
            curves: vec![points],
        };
        let plot = ComparisonPlot {
            title: &format!("Mobility of an element by fitted poles: {}", self.title),
            x: Axis::logarithmic("Frequency [Hz]", BAND.0..BAND.1),
            names: vec!["fit"],
            panels: vec![panel("Mobility [dB re 1 m/(N s)]", fitted), panel("Fit less sums [dB]", differences)],
        };
        plot.to_svg()
    }

    /// Causality by wavenumber, of the tyre's laws and of the hysteretic one in their place.
    fn checks(&self) -> Value {
        let mut hysteretic = self.tyre.clone();
        for layer in &mut hysteretic.layers {
            layer.material.law = Law::Hysteretic;
        }
        let time_step = 0.5 / BAND.1;
        let top = 4.0 / time_step;
        let of = |tyre: &Tyre| -> Causality {
            let sum = exact(tyre, self.elements(), 1e-11, top);
            causality(&sum, TimeRule::Bdf2, time_step, LAGS)
        };
        let (own, other) = (of(self.tyre), of(&hysteretic));
        let at = |n: usize| json!({ "n": n, "own": own.kramers_kronig[n], "hysteretic": other.kramers_kronig[n] });
        let residuals: Vec<Value> = CHECKED.into_iter().filter(|&n| n <= self.elements() / 2).map(at).collect();
        json!({
            "kramers_kronig": residuals,
            "precursor": { "own": own.precursor, "hysteretic": other.precursor },
            "energy_before": { "own": own.energy_before, "hysteretic": other.energy_before },
        })
    }
}

fn causality_table(checks: &Value) -> Table {
    let row = |title: String, row: &Value| {
        let number = |law: &str| format!("{:.1e}", row[law].as_f64().unwrap_or(f64::NAN));
        [title, number("own"), number("hysteretic")]
    };
    let mut rows = vec![
        row("largest answer before t = 0 over all".to_owned(), &checks["precursor"]),
        row("share of energy before t = 0".to_owned(), &checks["energy_before"]),
    ];
    let residuals = checks["kramers_kronig"].as_array().into_iter().flatten();
    rows.extend(residuals.map(|found| row(format!("Kramers-Kronig residual, n = {}", found["n"]), found)));
    aligned(["causality", "own laws", "hysteretic"], rows)
}
