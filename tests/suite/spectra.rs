//! The third-octave bands of `spectra.csv` share the mean square of the written time signal among them.

use num_complex::Complex64;

use tyrewave::internals::{scene_text, transforms};

use crate::common::{Results, run};

/// Rows of spectra.csv: lower edge, upper edge, mean square.
fn bands(results: &Results) -> Vec<[f64; 3]> {
    let mut reader = csv::Reader::from_path(results.path("spectra.csv")).unwrap();
    let column = |name: &str, reader: &mut csv::Reader<std::fs::File>| {
        reader.headers().unwrap().iter().position(|header| header == name).unwrap()
    };
    let columns = ["lower_edge_hz", "upper_edge_hz", "mean_square_n2"].map(|name| column(name, &mut reader));
    let row = |row: csv::StringRecord| columns.map(|column| row[column].parse::<f64>().unwrap());
    reader.records().map(|record| row(record.unwrap())).collect()
}

/// Mean square of a record between two frequencies: one plain transform of the whole record, as it is, without any
/// window.
fn mean_square_between(signal: &[f64], time_step: f64, from: f64, to: f64) -> f64 {
    let count = signal.len();
    let mean = signal.iter().sum::<f64>() / count as f64;
    let mut bins: Vec<Complex64> = signal.iter().map(|&force| Complex64::new(force - mean, 0.0)).collect();
    transforms::forward(count).process(&mut bins);
    let frequency = |k: usize| k.min(count - k) as f64 / (count as f64 * time_step);
    let inside = |k: &usize| (from..to).contains(&frequency(*k));
    (1..count).filter(inside).map(|k| bins[k].norm_sqr()).sum::<f64>() / (count as f64).powi(2)
}

#[test]
fn bands_sum_to_the_mean_square_of_the_written_force() {
    // 2.5 s: the lowest band, 18 Hz, sees 45 periods.
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.3\nduration = 2.5\naxle = { load = 3400.0 }";
    for (road, elements) in [("kind = \"made\"\nseed = 5", 128), ("kind = \"made\"\nseed = 6", 96)] {
        let results = run(&scene_text(elements, road, rolling, "memory = 0.25", ""));
        results.assert_sound(road);
        let (time, force) = (results.array("time.npy"), results.array("total_force.npy"));
        let from = (0.3 / time[1]).round() as usize;
        let time_step = results.report.summary.outcome.time_step;
        let bands = bands(&results);
        assert!(bands.windows(2).all(|pair| pair[0][1].to_bits() == pair[1][0].to_bits()), "bands leave gaps");
        let sum: f64 = bands.iter().map(|band| band[2]).sum();
        let (lowest, highest) = (bands[0][0], bands[bands.len() - 1][1]);
        assert!(lowest < 23.0 && highest > 0.35 / time_step);
        let direct = mean_square_between(&force[from..], time_step, lowest, highest);
        let difference = 10.0 * (sum / direct).log10();
        println!(
            "N = {elements}: {lowest:.1} to {highest:.0} Hz, {:.1} N rms, difference {difference:+.3} dB",
            sum.sqrt()
        );
        assert!(difference.abs() <= 0.1, "{difference} dB");
    }
}
