//! Views of the results of `tyrewave tyre`: tables, files and pictures.

use std::collections::{BTreeMap, BTreeSet};

use crate::contact::static_contact::StaticContact;
use crate::report::mobility::Quantity;
use crate::report::tyre::UnderLoad;
use crate::results::plots::{Axis, Colours, HeatMap, LinePlot, PlotError, Series};
use crate::results::table::{Report, aligned, csv, numbers, optional, row};
use crate::tyre::influence::mobility::{Mobility, level, phase};
use crate::tyre::modes::{Mode, Modes, Motion};
use ndarray::Array2;
use num_complex::Complex64;

/// Half the length of a mode's dash, in n.
const DASH: f64 = 0.35;

/// Modes whose peak, relative to the strongest with the same waves and motion, is below this are not in the table: most
/// are those of the sidewalls alone.
const WEAK: f64 = 0.02;

pub(super) const PHASE: Quantity = ("Phase of the driving-point mobility [degrees]", phase);

/// Table with a row for each n, a column for each lateral number and motion that has modes.
pub(super) fn modes_report(modes: &Modes, largest_n: usize) -> Report {
    let kinds: BTreeSet<(usize, Motion)> = modes.confirmed.iter().map(|mode| (mode.m, mode.motion)).collect();
    let header =
        ["n".to_owned()].into_iter().chain(kinds.iter().map(|(m, motion)| format!("m = {m} {}", motion.name())));
    let kind = |mode: &Mode| (mode.n, (mode.m, mode.motion));
    let of_kind = |n, wanted| modes.confirmed.iter().filter(move |mode| kind(mode) == (n, wanted));
    let strongest = |n, wanted| of_kind(n, wanted).map(|mode| mode.peak).fold(0.0_f64, f64::max);
    let is_weak = |mode: &Mode| mode.peak < WEAK * strongest(mode.n, (mode.m, mode.motion));
    let cell = |n: usize, wanted: (usize, Motion)| {
        let shown = of_kind(n, wanted).filter(|mode| !is_weak(mode));
        let texts: Vec<String> =
            shown.map(|mode| format!("{:.1} ({:.1})", mode.frequency(), 100.0 * mode.damping())).collect();
        texts.join(", ")
    };
    let row = |n: usize| [n.to_string()].into_iter().chain(kinds.iter().map(move |&kind| cell(n, kind)));
    let mut report = Report::default();
    report.text("Modes: frequency in Hz (damping in % of the critical one)\n");
    report.table(numbers(header, (0..=largest_n).map(row)));
    let weak = modes.confirmed.iter().filter(|mode| is_weak(mode)).count();
    if weak > 0 {
        let percent = 100.0 * WEAK;
        report.text(format!("{weak} modes below {percent:.0} % of the strongest beside them are only in modes.csv\n"));
    }
    for &(n, m, pole) in &modes.unconfirmed {
        let frequency = pole.im / std::f64::consts::TAU;
        report.text(format!("not confirmed by the compliance itself: n = {n}, m = {m}, near {frequency:.1} Hz\n"));
    }
    report.text("\n");
    report
}

/// Table with a row for each load; `element` is the length of an element \[m\].
pub(super) fn loads_report(loads: &[UnderLoad], element: f64) -> Report {
    let row = |under: &UnderLoad| {
        [
            under.label.clone(),
            format!("{:.2} mm", 1e3 * under.standing.indentation),
            format!("{:.3e}", under.secant_stiffness()),
            format!("{:.3e}", under.standing.stiffness),
            format!("{:.1} mm", 1e3 * under.standing.length),
            under.rolling.map_or("-".to_owned(), |length| format!("{:.1} mm", 1e3 * length)),
        ]
    };
    let header = ["load", "deflection", "stiffness [N/m]", "tangent [N/m]", "patch, standing", "patch, rolling"];
    let mut report = Report::default();
    report.text(format!("On a smooth road; patch in steps of two elements, {:.2} mm\n", 2e3 * element));
    report.table(aligned(header, loads.iter().map(row)));
    report.text("\n");
    report
}

/// Table with a row for each patch.
pub(super) fn mobility_report(mobility: &Mobility, names: &[String]) -> Report {
    let header = ["patch".to_owned()].into_iter().chain(mobility.frequencies.iter().map(|f| format!("{f} Hz")));
    let row = |(column, name): (usize, &String)| {
        let cell = move |row: &Vec<Complex64>| format!("{:.1}, {:.0}°", level(row[column]), phase(row[column]));
        [name.clone()].into_iter().chain(mobility.values.iter().map(cell))
    };
    let mut report = Report::default();
    report.text("Driving-point mobility of square patches: dB re 1 m/(N s), phase\n");
    report.table(aligned(header, names.iter().enumerate().map(row)));
    report
}

pub(super) fn modes_csv(modes: &Modes) -> String {
    let header = ["n", "m", "motion", "frequency_hz", "damping", "circumferential", "lateral", "radial"];
    let line = |mode: &Mode| {
        let [circumferential, lateral, radial] = &mode.shares;
        let (motion, frequency, damping) = (mode.motion.name(), mode.frequency(), mode.damping());
        row([&mode.n, &mode.m, &motion, &frequency, &damping, circumferential, lateral, radial])
    };
    csv(header, modes.confirmed.iter().map(line))
}

pub(super) fn loads_csv(loads: &[UnderLoad]) -> String {
    let header = ["load_n", "deflection_m", "secant_n_per_m", "tangent_n_per_m", "patch_m", "rolling_patch_m"];
    let line = |under: &UnderLoad| {
        let StaticContact { indentation, force, stiffness, length } = under.standing;
        row([&force, &indentation, &under.secant_stiffness(), &stiffness, &length, &optional(under.rolling)])
    };
    csv(header, loads.iter().map(line))
}

/// Lateral numbers that have modes, with their names in the legend.
pub(super) fn lateral_names(modes: &Modes) -> BTreeMap<usize, String> {
    modes.confirmed.iter().map(|mode| (mode.m, format!("m = {}", mode.m))).collect()
}

/// Draws each mode as a dash at its n, one colour for each lateral number.
pub(super) fn dispersion<'a>(
    modes: &Modes,
    names: &'a BTreeMap<usize, String>,
    title: &'a str,
    [largest_n, highest]: [f64; 2],
) -> LinePlot<'a> {
    let dash = |mode: &Mode| {
        let (n, frequency) = (mode.n as f64, mode.frequency());
        [(n - DASH, frequency), (n + DASH, frequency), (n, f64::NAN)]
    };
    let series = names.iter().map(|(&m, name)| Series {
        name,
        points: modes.confirmed.iter().filter(|mode| mode.m == m).flat_map(dash).collect(),
    });
    LinePlot {
        title,
        x: Axis::linear("Waves n round the tyre", -0.5..largest_n + 0.5),
        y: Axis::linear("Frequency of the modes [Hz]", 0.0..highest),
        series: series.collect(),
    }
}

/// Draws |C_zz| of the lowest lateral number over n and frequency; cells with a mode are grey.
pub(super) fn compliance(
    modes: &Modes,
    title: &str,
    highest: f64,
    (m, rows): &(usize, Vec<Vec<f64>>),
) -> Result<String, PlotError> {
    let columns = rows.first().map_or(0, Vec::len);
    let mut values = Array2::from_shape_fn((rows.len(), columns), |(row, n)| 20.0 * rows[row][n].log10());
    for mode in modes.confirmed.iter().filter(|mode| mode.m == *m) {
        let row = (mode.frequency() / highest * rows.len() as f64) as usize;
        if let Some(cell) = values.get_mut((row, mode.n)) {
            *cell = f64::NAN;
        }
    }
    let quantity = format!("|C| radial, m = {m} [dB re 1 m/Pa]; grey: modes");
    let map = HeatMap {
        title,
        x: Axis::linear("Waves n round the tyre", -0.5..columns as f64 - 0.5),
        y: Axis::linear("Frequency [Hz]", 0.0..highest),
        quantity: &quantity,
        values: values.view(),
        colours: Colours::Extent,
        aspect: None,
    };
    map.to_svg()
}

/// Draws the load over deflection of the standing tyre.
pub(super) fn load_deflection<'a>(curve: &[StaticContact], loads: &'a [UnderLoad], title: &'a str) -> LinePlot<'a> {
    let point = |contact: &StaticContact| (1e3 * contact.indentation, contact.force);
    let points: Vec<(f64, f64)> = [(0.0, 0.0)].into_iter().chain(curve.iter().map(point)).collect();
    let deepest = points.last().map_or(1.0, |point| point.0);
    // A load is a line from the axis to the curve and down.
    let series = loads.iter().map(|under| {
        let (x, y) = point(&under.standing);
        Series { name: &under.label, points: vec![(0.0, y), (x, y), (x, 0.0)] }
    });
    let forces = points.iter().map(|point| point.1).collect::<Vec<_>>();
    LinePlot {
        title,
        x: Axis::linear("Deflection [mm]", 0.0..deepest),
        y: Axis::linear("Load, standing on a smooth road [N]", 0.0..forces.last().copied().unwrap_or(1.0)),
        series: [Series { name: "standing", points }].into_iter().chain(series).collect(),
    }
}

/// Draws the length of the patch over the load.
pub(super) fn patch_length<'a>(curve: &[StaticContact], loads: &[UnderLoad], title: &'a str) -> LinePlot<'a> {
    let standing: Vec<(f64, f64)> = curve.iter().map(|contact| (contact.force, 1e3 * contact.length)).collect();
    let mut rolling: Vec<(f64, f64)> =
        loads.iter().filter_map(|under| Some((under.standing.force, 1e3 * under.rolling?))).collect();
    rolling.sort_by(|a, b| a.0.total_cmp(&b.0));
    let ends = |points: &[(f64, f64)], of: fn(&(f64, f64)) -> f64| points.last().map_or(1.0, of);
    let (heaviest, longest) = (ends(&standing, |point| point.0), ends(&standing, |point| point.1));
    let mut series = vec![Series { name: "standing", points: standing }];
    if !rolling.is_empty() {
        series.push(Series { name: "rolling", points: rolling });
    }
    LinePlot {
        title,
        x: Axis::linear("Load [N]", 0.0..heaviest),
        y: Axis::linear("Length of the patch [mm]", 0.0..longest),
        series,
    }
}
