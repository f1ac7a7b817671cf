//! `tyrewave radiation` and `tyrewave radiation-cases`: sound radiation of a tyre that stands on a road.

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use crate::counters::Stage;
use crate::plan::{Plan, bytes};
use crate::radiation::cases::{self, RadiationCasesError};
use crate::radiation::{RadiationCost, RadiationError};
use crate::report::radiation::radiation_record;
use crate::response::pressure::PressureShares;
use crate::results::PlotError;
use crate::results::plots::{Axis, LinePlot, PolarPlot, Series, ShareMap};
use crate::results::table::{Report, aligned, csv};
use crate::run::{Progress, RunError};
use crate::storage::input::{self, TABLE_BYTES};
use crate::study::loads::LoadedTyre;
use crate::study::radiation::{
    AHEAD, AtFrequency, CIRCLE, DIRECTIVITY, LOWEST, Radiator, asked_frequencies, named_receivers,
};
use crate::tyre::influence::mobility::frequencies;
use clap::Args;
use serde_json::json;

use super::context::{Context, print};
use super::error::CliError;
use super::options::positive;
use super::side::Place;

const EXAMPLES: &str = "\
The tyre stands on a rigid road, without a gap at the patch. The source is a small piece of the tread 15 mm in front \
of the patch, in the middle of the tyre. Shown are the level of the transfer function from its volume acceleration to \
some receivers, the horn amplification there (relative to the same source and receiver without the tyre, the road's \
reflection included), the directivity on a circle, and the cost of the solution, frequency by frequency.

What radiates is shown for the vibration of the whole rolling tread under a unit force in the middle of the patch. The \
pressure at a receiver is a sum over the waves round the tyre, n periods each, or over the circumference: p = sum p_n. \
The share of a part is Re(p_n conj(p))/|p|^2. Shares add up to one; a part out of phase with the whole has a negative \
share, and others may then exceed one. A part is enough if the cumulative share stays within 10 % of the whole from \
there on.

If the sidewalls radiate ([radiation] sides), the parts are shown, too: tread, shoulders, sides, each with its share \
and its level relative to the whole.

Only the scene's tyre, its load and [radiation] are used. The receivers are always the same: a point in the tyre's \
plane, a cpx microphone, the coast-by microphone beside the tyre.

Results: radiation.json (all numbers, SI units), radiation.csv; horn.svg, transfer.svg, directivity.svg, cost.svg; \
radiating_waves_*.svg and radiating_angles_*.svg, cumulative shares by receiver; radiating_parts_*.svg, levels of \
tread, shoulders and sides; radiation.html, a page of all.

Examples:
  tyrewave radiation scenes/default.toml
  tyrewave radiation scenes/default.toml --highest 4000 --points 12";

const CASES: &str = "\
The file: density, sound_speed, nodes_per_wavelength and cases; each case has name, body ({\"shape\": \"sphere\", \
radius, height} or {\"shape\": \"tyre\", radius, width, shoulder}), plane, wavenumber and either velocity \
(\"uniform\", \"heave\", \"sway\" or {\"circumferential\": m, \"across\": 1}) with receivers, or source with points on \
the surface. Printed: pressure and power, or green, case by case, for 1 m/s.

Examples:
  tyrewave radiation-cases cases.json > computed.json";

/// Number of angles around the tyre up to which shares are shown.
const ANGLES: usize = 72;
/// Number of waves that are drawn, from n = 0 on.
const MOST_WAVES: usize = 129;
/// Names of the receivers in CSV.
const NAMES: [&str; 3] = ["in_plane", "cpx_front", "coast_by"];
/// Names of the pictures, by receiver: shares of waves, of the circumference, levels of parts.
const PICTURES: [[&str; 3]; 3] = [
    ["radiating_waves_in_plane.svg", "radiating_angles_in_plane.svg", "radiating_parts_in_plane.svg"],
    ["radiating_waves_cpx_front.svg", "radiating_angles_cpx_front.svg", "radiating_parts_cpx_front.svg"],
    ["radiating_waves_coast_by.svg", "radiating_angles_coast_by.svg", "radiating_parts_coast_by.svg"],
];
/// Pictures of the sound of a point of the tread, with their captions.
const POINT: [[&str; 2]; 4] = [
    [
        "horn.svg",
        "Amplification in dB by the horn between tyre and road, relative to the same source and receiver without the \
         tyre, the road's reflection included.",
    ],
    ["transfer.svg", "Level of the transfer from the volume acceleration of the point to each receiver, dB re 1/m."],
    ["directivity.svg", "The same on a circle round the axle, over the angle from straight ahead."],
    ["cost.svg", "Unknowns, operations and memory of one frequency, against the frequency in Hz."],
];
/// Captions of the pictures of a receiver.
const SHARES: [&str; 3] = [
    "Cumulative share of the pressure: waves with up to n periods round the tyre; beyond the white line they are \
     shorter than the waves in air.",
    "Cumulative share of the pressure: circumference from the top round the rear.",
    "Level of tread, shoulders and sides relative to the whole, dB.",
];

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct RadiationArguments {
    #[command(flatten)]
    place: Place,
    /// Highest frequency, in Hz.
    #[arg(long, value_name = "HZ", default_value = "2500", value_parser = positive, allow_negative_numbers = true)]
    highest: f64,
    /// Number of frequencies.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(2..=1000))]
    points: u32,
}

impl RadiationArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let Self { place, highest, points } = self;
        let mut side = place.open("radiation", context)?;
        let (scene, title) = (side.loaded.scene.clone(), side.loaded.title());
        let plan = Plan::new(&scene);
        let mut progress = context.progress();
        progress.stage(Stage::Axle);
        let standing = side.meter.time(Stage::Influence, || LoadedTyre::new(&scene));
        let patch = standing.held_by(&scene.rolling.axle).map_err(RunError::from)?.length;
        drop(progress);
        let failed = |error: RadiationError| match error {
            RadiationError::Interrupted => interrupted(),
            error => CliError::Failed(error.to_string()),
        };
        let radiator = Radiator::new(&scene, &plan, patch).map_err(failed)?;
        let asked = asked_frequencies(highest, points);
        let bar = context.bar("boundary elements", asked.len() as u64);
        let open = side.meter.open();
        let found = radiator.at(&asked, context.interrupt.flag(), &|| bar.inc(1)).map_err(failed)?;
        side.meter.close(open, Stage::Radiation);
        bar.finish_and_clear();

        let views = Views { title: &title, found: &found, width: radiator.width() };
        let horn = ("Horn amplification", "Horn amplification [dB]");
        side.file("horn.svg", views.over_frequency(horn, |at, index| at.horn[index]));
        let level = |value: f64| 20.0 * value.log10();
        let transfer = ("Transfer from the tread", "Transfer |G| [dB re 1/m]");
        let transfer = views.over_frequency(transfer, |at, index| level(at.transfers[index]));
        side.file("transfer.svg", transfer);
        side.file("directivity.svg", views.directivity());
        let length = radiator.wavelength(1.0);
        for (receiver, [waves, angles, parts]) in PICTURES.into_iter().enumerate() {
            side.picture(waves, views.waves(receiver, scene.tyre.circumference / length))?;
            side.picture(angles, views.angles(receiver))?;
            if radiator.hears_sides() {
                side.file(parts, views.parts(receiver));
            }
        }
        let costs = costs(&radiator, highest).map_err(failed)?;
        side.file("cost.svg", cost_picture(&costs, &title));
        side.file("radiation.csv", views.csv());
        let answer = radiation_record(&title, &radiator, &found);
        side.json("radiation.json", &answer);
        side.settings = json!({ "scene": side.settings, "highest": highest, "points": points });
        let table = views.table();
        let mut shares = Report::default();
        shares.text(
            "\nPart of the tread that is enough: waves round the tyre, degrees to either side of the contact\n\n",
        );
        shares.append(views.enough());
        if radiator.hears_sides() {
            shares.text("\nRadiating parts: share of the pressure, level relative to the whole\n\n");
            shares.append(views.parts_table());
        }
        let patch = format!("Patch {:.1} mm long", 1e3 * radiator.patch_length());
        let lead = format!("The tyre stands on a rigid road. {patch}.");
        let parts: Vec<[&str; 2]> = PICTURES
            .iter()
            .flat_map(|files| files.iter().zip(SHARES).map(|(&file, caption)| [file, caption]))
            .collect();
        let sections = [("From a point of the tread", &POINT[..], &table), ("Radiating parts", &parts, &shares)];
        side.page("radiation.html", [&title, &lead], &sections);
        let mut report = Report::default();
        report.text(format!("{title}\n{patch}\n\n"));
        sections.into_iter().for_each(|(_, _, of)| report.append(of.clone()));
        report.text("\n");
        side.finish(context, &report)
    }
}

/// Data of all tables and pictures.
struct Views<'a> {
    title: &'a str,
    found: &'a [AtFrequency],
    width: f64,
}

impl Views<'_> {
    fn named(&self) -> [(&'static str, [f64; 3]); 3] {
        named_receivers(self.width)
    }

    fn table(&self) -> Report {
        let header: Vec<String> = ["Hz"]
            .into_iter()
            .map(str::to_owned)
            .chain(self.named().iter().map(|(name, _)| format!("horn, {name}")))
            .chain(["unknowns", "1/condition", "time", "LU Gflop/s"].map(str::to_owned))
            .collect();
        let row = |at: &AtFrequency| -> Vec<String> {
            let [assembly, factor] = at.seconds;
            [format!("{:.0}", at.frequency)]
                .into_iter()
                .chain(at.horn.iter().map(|horn| format!("{horn:+.1} dB")))
                .chain([
                    at.unknowns.to_string(),
                    format!("{:.1e}", at.reciprocal_condition),
                    format!("{:.2} s", assembly + factor),
                    format!("{:.1}", 1e-9 * at.factor_operations / factor),
                ])
                .collect()
        };
        aligned(header, self.found.iter().map(row)).into()
    }

    /// Number of waves and angle of the circumference from which on the share so far stays close to all.
    fn enough(&self) -> Report {
        let header = ["Hz"].into_iter().chain(self.named().map(|(name, _)| name));
        let row = |at: &AtFrequency| -> Vec<String> {
            let one = |shares: &PressureShares| format!("{}, {:.0}", shares.enough_waves(), shares.enough_angle());
            [format!("{:.0}", at.frequency)].into_iter().chain(at.shares.iter().map(one)).collect()
        };
        aligned(header, self.found.iter().map(row)).into()
    }

    /// Share and level of each part, by receiver.
    fn parts_table(&self) -> Report {
        // Without the position, which is in the tables above.
        let column = |name: &str, part: &str| format!("{part}, {}", name.split(',').next().unwrap_or(name));
        let names = self.named().into_iter().flat_map(|(name, _)| PressureShares::PARTS.map(|part| column(name, part)));
        let header: Vec<String> = std::iter::once("Hz".to_owned()).chain(names).collect();
        let row = |at: &AtFrequency| -> Vec<String> {
            let one = |shares: &PressureShares| {
                let pairs = shares.of_parts().into_iter().zip(shares.levels_of_parts());
                pairs.map(|(share, level)| format!("{share:.2}, {level:+.1} dB")).collect::<Vec<_>>()
            };
            [format!("{:.0}", at.frequency)].into_iter().chain(at.shares.iter().flat_map(one)).collect()
        };
        aligned(header, self.found.iter().map(row)).into()
    }

    fn parts(&self, receiver: usize) -> String {
        let level = |at: &AtFrequency, part: usize| at.shares[receiver].levels_of_parts()[part];
        let curve = |part: usize| self.found.iter().map(|at| (at.frequency, level(at, part))).collect();
        let names = PressureShares::PARTS.into_iter().enumerate();
        let series = names.map(|(part, name)| Series { name, points: curve(part) }).collect();
        let title = format!("Radiating parts, {}", self.named()[receiver].0);
        self.line_plot((&title, "Level relative to the whole [dB]"), series)
    }

    /// Map of shares at a receiver, over frequency and `x`.
    fn shares(
        &self,
        receiver: usize,
        x: Axis,
        name: &str,
        so_far: impl Fn(&PressureShares) -> Vec<f64>,
        curves: &[Vec<(f64, f64)>],
    ) -> Result<String, PlotError> {
        let frequencies: Vec<f64> = self.found.iter().map(|at| at.frequency).collect();
        let so_far: Vec<Vec<f64>> = self.found.iter().map(|at| so_far(&at.shares[receiver])).collect();
        let title = format!("{name}, {}: {}", self.named()[receiver].0, self.title);
        let quantity = "Cumulative share of the pressure";
        ShareMap { title: &title, x, quantity, frequencies: &frequencies, so_far: &so_far, curves }.to_svg()
    }

    /// Draws the shares of waves up to |n|, with a line where the waves are as long as those in the air: `in_air` is
    /// the number of these around the tyre per hertz.
    fn waves(&self, receiver: usize, in_air: f64) -> Result<String, PlotError> {
        let title = "Waves round the tyre, up to |n|; white: as long as in the air";
        let x = Axis::linear(title, -0.5..MOST_WAVES as f64 - 0.5);
        let curve = self.found.iter().map(|at| (in_air * at.frequency, at.frequency)).collect();
        let so_far = |shares: &PressureShares| {
            let mut so_far = shares.up_to_wave();
            // A tyre with few elements has fewer.
            so_far.resize(MOST_WAVES, 1.0);
            so_far
        };
        self.shares(receiver, x, "Radiating waves", so_far, &[curve])
    }

    /// Draws the shares of the circumference from the top by the rear up to each angle.
    fn angles(&self, receiver: usize) -> Result<String, PlotError> {
        let title = "From the top round the rear, up to this angle ahead of the contact [degrees]";
        let x = Axis::linear(title, -180.0..180.0);
        let so_far = |shares: &PressureShares| shares.up_to_angle(5 * ANGLES);
        self.shares(receiver, x, "Radiating parts", so_far, &[])
    }

    fn csv(&self) -> String {
        let header = std::iter::once("frequency_hz".to_owned())
            .chain(NAMES.iter().map(|name| format!("transfer_{name}_1_m")))
            .chain(NAMES.iter().map(|name| format!("horn_{name}_db")))
            .chain(NAMES.iter().map(|name| format!("pressure_{name}_pa_n")))
            .chain(NAMES.iter().map(|name| format!("enough_waves_{name}")))
            .chain(NAMES.iter().map(|name| format!("enough_angle_{name}_degrees")))
            .chain(NAMES.iter().flat_map(|name| PressureShares::PARTS.map(|part| format!("share_{part}_{name}"))))
            .chain(
                NAMES.iter().flat_map(|name| PressureShares::PARTS.map(|part| format!("pressure_{part}_{name}_pa_n"))),
            );
        let rows = self.found.iter().map(|at| {
            [at.frequency]
                .into_iter()
                .chain(at.transfers.iter().copied())
                .chain(at.horn.iter().copied())
                .chain(at.shares.iter().map(|shares| shares.pressure.norm()))
                .chain(at.shares.iter().map(|shares| shares.enough_waves() as f64))
                .chain(at.shares.iter().map(PressureShares::enough_angle))
                .chain(at.shares.iter().flat_map(PressureShares::of_parts))
                .chain(at.shares.iter().flat_map(|shares| shares.parts.map(|part| part.norm())))
        });
        csv(header, rows)
    }

    /// Picture of a quantity over frequency, a curve per receiver.
    fn over_frequency(&self, (title, quantity): (&str, &str), value: impl Fn(&AtFrequency, usize) -> f64) -> String {
        let named = self.named();
        let points = |index: usize| self.found.iter().map(|at| (at.frequency, value(at, index))).collect::<Vec<_>>();
        let series = (0..named.len()).map(|index| Series { name: named[index].0, points: points(index) }).collect();
        self.line_plot((title, quantity), series)
    }

    /// Picture of curves over frequency.
    fn line_plot(&self, (title, quantity): (&str, &str), series: Vec<Series<'_>>) -> String {
        let levels = series.iter().flat_map(|series| series.points.iter().map(|point| point.1));
        LinePlot {
            title: &format!("{title}: {}", self.title),
            x: Axis::logarithmic("Frequency [Hz]", LOWEST..self.found.last().map_or(LOWEST, |at| at.frequency)),
            y: Axis::linear_around(quantity, levels),
            series: series.clone(),
        }
        .to_svg()
    }

    fn directivity(&self) -> String {
        let at: Vec<&AtFrequency> = self
            .found
            .iter()
            .filter(|at| DIRECTIVITY.iter().any(|frequency| (frequency - at.frequency).abs() < 1e-9))
            .collect();
        let names: Vec<String> = at.iter().map(|at| format!("{:.0} Hz", at.frequency)).collect();
        let series = at.iter().zip(&names).map(|(at, name)| {
            let count = at.circle.len();
            let point = |index: usize| (360.0 * index as f64 / count as f64, 20.0 * at.circle[index % count].log10());
            Series { name, points: (0..=count).map(point).collect() }
        });
        let [radius, height] = CIRCLE;
        PolarPlot {
            title: &format!("Directivity: {}", self.title),
            source: &format!("Source: a point of the tread {} mm ahead of the patch, mid-tyre", 1e3 * AHEAD),
            quantity: &format!("Transfer |G|, {radius} m from the axle, {height} m high [dB re 1/m]"),
            series: series.collect(),
        }
        .to_svg()
    }
}

/// Expected costs of single frequencies, up to the highest or 4 kHz.
fn costs(radiator: &Radiator, highest: f64) -> Result<Vec<(f64, RadiationCost)>, RadiationError> {
    let frequencies = frequencies(LOWEST, highest.max(4000.0), 30);
    frequencies.into_iter().map(|frequency| Ok((frequency, radiator.cost(frequency)?))).collect()
}

/// Unknowns, operations and memory over frequency.
fn cost_picture(costs: &[(f64, RadiationCost)], title: &str) -> String {
    let points =
        |value: fn(&RadiationCost) -> f64| costs.iter().map(|(frequency, cost)| (*frequency, value(cost))).collect();
    let series: [Series<'_>; 3] = [
        Series { name: "unknowns of a block", points: points(|cost| cost.unknowns as f64) },
        Series { name: "factorisation [Gflop]", points: points(|cost| 1e-9 * cost.factor_operations) },
        Series { name: "memory [MB]", points: points(|cost| 1e-6 * cost.bytes as f64) },
    ];
    let values = series.iter().flat_map(|series| series.points.iter().map(|point| point.1));
    let (highest, most) = costs.last().map_or((LOWEST, 0.0), |(frequency, cost)| (*frequency, cost.bytes as f64));
    LinePlot {
        title: &format!("Cost of a frequency, at most {}: {title}", bytes(most)),
        x: Axis::logarithmic("Frequency [Hz]", LOWEST..highest),
        y: Axis::logarithmic_around("Cost", values.filter(|value| *value > 0.0), [0.9, 1.1]),
        series: series.to_vec(),
    }
    .to_svg()
}

#[derive(Clone, Debug, Args)]
#[command(after_help = CASES)]
pub(crate) struct RadiationCasesArguments {
    /// The cases, a JSON file.
    cases: PathBuf,
}

fn interrupted() -> CliError {
    CliError::Interrupted { partial: None }
}

/// Most memory that a file of cases may take \[bytes\].
const CASES_MEMORY: u64 = 8 << 30;

impl RadiationCasesArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let path = self.cases;
        let text = input::read_text(&path, TABLE_BYTES).map_err(CliError::reading(&path))?;
        let stop = context.interrupt.flag();
        let answer =
            cases::evaluate(&text, CASES_MEMORY, &|| stop.load(Ordering::Relaxed)).map_err(|error| match error {
                RadiationCasesError::Case { source: RadiationError::Interrupted, .. } => interrupted(),
                error => CliError::Usage(format!("{}: {error}", path.display())),
            })?;
        print(&format!("{answer:#}\n"))
    }
}
