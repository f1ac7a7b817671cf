//! Pattern of a tread as a table and as pictures.

use ndarray::ArrayView2;

use super::plots::{Axis, Colours, HeatMap, LinePlot, PlotError, Series};
use super::table::{csv, row};
use crate::tyre::tread_pattern::map::TreadMap;
use crate::tyre::tread_pattern::pitches::PitchTrain;

/// Largest order of the pitches' spectrum, in multiples of the number of pitches.
const ORDERS: usize = 4;

/// Table of a pattern on a tyre at a speed \[m/s\]: starts and lengths of pitches, void shares of the whole tread and
/// of each row of cells, and the amplitudes of one unit pulse for each pitch.
pub(crate) fn pattern_csv(map: &TreadMap, speed: f64) -> String {
    let header = ["quantity", "number", "place_m", "frequency_hz", "value", "imaginary"];
    let none = f64::NAN;
    let line = |quantity: &str, number: usize, [place, frequency, value, imaginary]: [f64; 4]| {
        row([&quantity, &number, &place, &frequency, &value, &imaginary])
    };
    let mut rows = vec![
        line("void_share", 0, [none, none, map.exact_void, none]),
        line("void_share_on_cells", 0, [none, none, map.void(), none]),
    ];
    let of_rows = map.void_of_rows().into_iter().enumerate();
    rows.extend(of_rows.map(|(j, share)| line("void_share_of_row", j, [map.y(j), none, share, none])));
    if let Some(train) = &map.train {
        let pitches = train.starts.iter().zip(&train.lengths).enumerate();
        rows.extend(pitches.map(|(j, (start, length))| line("pitch", j, [*start, none, *length, none])));
        rows.extend((0..=ORDERS * train.count()).map(|order| {
            let amplitude = train.amplitude(order);
            let frequency = order as f64 * speed / train.circumference;
            line("pitch_amplitude", order, [none, frequency, amplitude.re, amplitude.im])
        }));
    }
    csv(header, rows)
}

/// Draws the depths of the tread, unrolled, with its sipes as lines.
///
/// # Errors
/// Errors of the picture.
pub fn tread_picture(map: &TreadMap, title: &str) -> Result<String, PlotError> {
    let [dx, dy] = map.size;
    let (length, half) = (dx * map.columns as f64, 0.5 * dy * map.across as f64);
    let mm: Vec<f64> = map.depths.iter().map(|depth| 1e3 * depth).collect();
    let values = ArrayView2::from_shape((map.columns, map.across), &mm).map_err(|_| PlotError {
        picture: "the tread",
        quantity: "depths",
        expected: map.columns,
        got: 0,
    })?;
    // The part that a picture can show cell by cell.
    let shown = (map.columns).min((4.0 * 2.0 * half / dx) as usize).max(1);
    let (part, _) = values.split_at(ndarray::Axis(0), shown);
    let (shown, aspect) = (dx * shown as f64, 2.0 * half / (dx * shown as f64));
    let line = |ends: &[[f64; 2]; 2]| ends.map(|[x, y]| (x, 1e3 * y)).to_vec();
    let sipes: Vec<Vec<(f64, f64)>> = map.sipe_lines.iter().map(line).collect();
    HeatMap {
        title,
        x: Axis::linear(format!("Along, of {length:.3} m [m]"), 0.0..shown),
        y: Axis::linear("Across, to the left [mm]", -1e3 * half..1e3 * half),
        quantity: "Depth [mm]",
        values: part.t(),
        colours: Colours::Extent,
        aspect: Some(aspect),
    }
    .to_svg_under(&sipes)
}

/// Draws the spectrum of one unit pulse for each pitch, at a speed \[m/s\].
pub fn pitch_spectrum(train: &PitchTrain, speed: f64, title: &str) -> String {
    let rate = speed / train.circumference;
    let last = ORDERS * train.count();
    // Each order is a separate vertical line.
    let line = |order: usize| {
        let (frequency, amplitude) = (order as f64 * rate, train.amplitude(order).norm());
        [(frequency, 0.0), (frequency, amplitude), (frequency, f64::NAN)]
    };
    let name = format!("{} pitches", train.count());
    LinePlot {
        title,
        x: Axis::linear("Frequency k V/L [Hz]", 0.0..last as f64 * rate),
        y: Axis::linear("Amplitude |A_k| of the pitches", 0.0..1.0),
        series: vec![Series { name: &name, points: (1..=last).flat_map(line).collect() }],
    }
    .to_svg()
}
