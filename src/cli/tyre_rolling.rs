//! Views of the waves and critical speeds of a rotating tyre.

use crate::results::plots::{Axis, LinePlot, Series};
use crate::results::table::{Report, aligned, csv, optional, row};
use crate::study::rolling_waves::{HIGHEST, RollingWave, RollingWaves};
use crate::tyre::critical_speed::TreadWave;
use crate::tyre::slowest_wave::SlowestWave;
use serde_json::{Value, json};

/// Factor from m/s to km/h.
const KMH: f64 = 3.6;

/// Table of the waves \[Hz\], then each critical speed with its meaning.
pub(super) fn report(found: &RollingWaves) -> Report {
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
pub(super) fn to_csv(found: &RollingWaves) -> String {
    let header = ["n", "standing_hz", "forwards_hz", "backwards_hz"];
    let line = |wave: &RollingWave| {
        let RollingWave { n, standing, forwards, backwards } = wave;
        row([n, &optional(*standing), &optional(*forwards), &optional(*backwards)])
    };
    csv(header, found.waves.iter().map(line))
}

/// Everything as JSON, in SI units.
pub(super) fn to_json(found: &RollingWaves) -> Value {
    let RollingWaves { speed, growth, waves, belt, belt_held, tread, limit } = found;
    json!({
        "speed": speed,
        "growth": growth,
        "waves": waves,
        "critical_speeds": { "belt": belt, "belt_not_turning": belt_held, "tread": tread, "stability": limit },
    })
}

/// Frequencies over n with the line n V/L: a wave against the rotation that lies on it stands still beside the axle.
pub(super) fn picture<'a>(found: &RollingWaves, title: &'a str, circumference: f64, highest: f64) -> LinePlot<'a> {
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
