//! Views of the results of `tyrewave tyre`: tables, files and pictures of modes, loads and mobility, of a tread's
//! pattern, and of the waves and critical speeds of a rotating tyre.

use std::collections::{BTreeMap, BTreeSet};

use crate::contact::static_contact::StaticContact;
use crate::plan::decisions::cells_across;
use crate::report::tyre::{Quantity, UnderLoad};
use crate::results::plots::{Axis, Colours, HeatMap, LinePlot, PlotError, Series};
use crate::results::table::{Report, aligned, csv, numbers, optional, row};
use crate::scene::Scene;
use crate::study::rolling_waves::{HIGHEST, RollingWave, RollingWaves};
use crate::tyre::critical_speed::TreadWave;
use crate::tyre::influence::mobility::{Mobility, level, phase};
use crate::tyre::modes::{Mode, Modes, Motion};
use crate::tyre::slowest_wave::SlowestWave;
use crate::tyre::tread_pattern::PatternFault;
use crate::tyre::tread_pattern::map::{TreadCells, TreadMap};
use ndarray::Array2;
use num_complex::Complex64;
use serde_json::{Value, json};

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

/// Refinements of the scene's cells that are tried until they resolve the pattern.
const FINER: [usize; 4] = [1, 2, 4, 8];

/// The map of a scene's pattern on its cells, or on the next finer ones that resolve it; `None` without a pattern.
pub(super) fn pattern_map(scene: &Scene) -> Option<Result<TreadMap, PatternFault>> {
    let pattern = scene.pattern()?;
    let across = cells_across(scene);
    let on = |finer: usize| {
        let cells = TreadCells { columns: finer * scene.numerics.elements, across: finer * across };
        TreadMap::new(pattern, scene, cells)
    };
    let coarse = on(1);
    let finer = FINER[1..].iter().find_map(|&finer| on(finer).ok());
    Some(if coarse.is_ok() { coarse } else { finer.map_or(coarse, Ok) })
}

/// Table of pitches and shares of void; `speed` in m/s.
pub(super) fn pattern_report(map: &TreadMap, speed: f64) -> Report {
    let mut report = Report::default();
    report.text(format!("Tread pattern on {} x {} cells\n", map.columns, map.across));
    let percent = |share: f64| format!("{:.2} %", 100.0 * share);
    let mut rows =
        vec![["void".to_owned(), percent(map.exact_void)], ["void on cells".to_owned(), percent(map.void())]];
    if let Some(train) = &map.train {
        let lengths = train.lengths.iter().copied();
        let (least, most) = (lengths.clone().fold(f64::INFINITY, f64::min), lengths.fold(0.0, f64::max));
        let count = train.count() as f64;
        rows.push(["pitches".to_owned(), train.count().to_string()]);
        rows.push(["lengths".to_owned(), format!("{:.1} to {:.1} mm", 1e3 * least, 1e3 * most)]);
        rows.push(["scaled by".to_owned(), format!("{:.4}", train.scale)]);
        let passing = count * speed / train.circumference;
        rows.push([format!("passing at {:.0} km/h", 3.6 * speed), format!("{passing:.0} Hz")]);
        let orders = 1..=2 * train.count();
        let strongest = orders
            .map(|order| (order, train.amplitude(order).norm()))
            .fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best });
        rows.push(["strongest order".to_owned(), format!("{}, {:.3}", strongest.0, strongest.1)]);
    }
    report.table(aligned(["of the tread", "value"], rows));
    report.text("\n");
    report
}

/// The same as JSON, in SI units.
pub(super) fn pattern_json(map: &TreadMap) -> Value {
    json!({
        "void_share": map.exact_void,
        "void_share_on_cells": map.void(),
        "cells": [map.columns, map.across],
        "pitches": map.train.as_ref().map(|train| json!({
            "starts": train.starts,
            "lengths": train.lengths,
            "scale": train.scale,
        })),
    })
}

/// Factor from m/s to km/h.
const KMH: f64 = 3.6;

/// Table of the waves \[Hz\], then each critical speed with its meaning.
pub(super) fn rolling_report(found: &RollingWaves) -> Report {
    let RollingWaves { speed, growth, waves, belt, belt_held, tread, limit } = found;
    let mut report = Report::default();
    report.text(format!(
        "Turning at {:.0} km/h the radius grows by {:.2} mm; lowest radial modes [Hz]\n",
        KMH * speed,
        1e3 * growth
    ));
    let hertz = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.1}"));
    let line = |wave: &RollingWave| {
        let RollingWave { n, standing, forwards, backwards } = *wave;
        [n.to_string(), hertz(standing), hertz(forwards), hertz(backwards)]
    };
    report.table(aligned(["n", "standing", "with the rotation", "against it"], waves.iter().map(line)));
    report.text("\nCritical speeds\n");
    let wave = |wave: &SlowestWave| format!("{:.0} km/h (n = {})", KMH * wave.speed, wave.n);
    let belt = belt.as_ref().map_or_else(
        || format!("none up to {:.0} km/h", KMH * limit.map_or(HIGHEST, |limit| limit.min(HIGHEST))),
        wave,
    );
    let held = belt_held.as_ref().map_or("none".to_owned(), wave);
    let tread = tread.as_ref().map_or("none".to_owned(), |TreadWave { length, speed }| {
        format!("{:.0} km/h ({:.0} mm)", KMH * speed, 1e3 * length)
    });
    let limit = limit.map_or("none".to_owned(), |limit| format!("{:.0} km/h", KMH * limit));
    let rows = [
        ["belt".to_owned(), belt, format!("the tyre rolls into its own wave (not turning: {held})")],
        ["tread".to_owned(), tread, "beyond, contact has no steady state; time stepping still works".to_owned()],
        ["stability".to_owned(), limit, "beyond, a turning tyre on a rigid axle is unstable: refused".to_owned()],
    ];
    report.table(aligned(["of", "speed", "meaning"], rows));
    report.text("\n");
    report
}

/// One row for each n.
pub(super) fn rolling_csv(found: &RollingWaves) -> String {
    let header = ["n", "standing_hz", "forwards_hz", "backwards_hz"];
    let line = |wave: &RollingWave| {
        let RollingWave { n, standing, forwards, backwards } = wave;
        row([n, &optional(*standing), &optional(*forwards), &optional(*backwards)])
    };
    csv(header, found.waves.iter().map(line))
}

/// Everything as JSON, in SI units.
pub(super) fn rolling_json(found: &RollingWaves) -> Value {
    let RollingWaves { speed, growth, waves, belt, belt_held, tread, limit } = found;
    json!({
        "speed": speed,
        "growth": growth,
        "waves": waves,
        "critical_speeds": { "belt": belt, "belt_not_turning": belt_held, "tread": tread, "stability": limit },
    })
}

/// Frequencies over n with the line n V/L: a wave against the rotation that lies on it stands still beside the axle.
pub(super) fn rolling_picture<'a>(
    found: &RollingWaves,
    title: &'a str,
    circumference: f64,
    highest: f64,
) -> LinePlot<'a> {
    let of = |value: fn(&RollingWave) -> Option<f64>| -> Vec<(f64, f64)> {
        found.waves.iter().map(|wave| (wave.n as f64, value(wave).unwrap_or(f64::NAN))).collect()
    };
    let largest = found.waves.len().saturating_sub(1).max(1) as f64;
    let line = vec![(0.0, 0.0), (largest, largest * found.speed / circumference)];
    LinePlot {
        title,
        x: Axis::linear("Waves n round the tyre", 0.0..largest),
        y: Axis::linear("Frequency in the tyre's frame [Hz]", 0.0..highest),
        series: vec![
            Series { name: "with the rotation", points: of(|wave| wave.forwards) },
            Series { name: "against it", points: of(|wave| wave.backwards) },
            Series { name: "standing tyre", points: of(|wave| wave.standing) },
            Series { name: "against it, n V/L", points: line },
        ],
    }
}
