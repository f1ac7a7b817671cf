//! Driving-point mobility of the default tyre against an independent calculation.

use tyrewave::internals::{driving_point, plate_tyre};

#[test]
fn default_tyre_has_the_mobility_of_the_independent_calculation() {
    let tyre = plate_tyre();
    // An independent calculation, dB re 1 m/(N s); bound 0.5 dB.
    let frequencies = [100.0, 200.0, 315.0, 500.0, 1000.0, 2000.0];
    let table = [
        (0.050, [-45.9, -41.6, -56.2, -49.4, -51.9, -52.2]),
        (0.020, [-45.5, -39.9, -45.1, -43.2, -36.9, -29.3]),
        (0.010, [-43.2, -37.0, -36.5, -34.1, -27.5, -19.6]),
        (0.005, [-37.4, -31.5, -28.9, -25.9, -19.9, -13.2]),
    ];
    let patches: Vec<f64> = table.iter().map(|row| row.0).collect();
    let mobility = driving_point(&tyre, &patches, &frequencies);
    let mut worst = 0.0_f64;
    for (column, (patch, levels)) in table.iter().enumerate() {
        for (row, expected) in levels.iter().enumerate() {
            let value = mobility.values[row][column];
            let level = 20.0 * value.norm().log10();
            worst = worst.max((level - expected).abs());
            assert!(
                (level - expected).abs() < 0.5,
                "{} mm, {} Hz: {level:.2} dB, expected {expected} dB",
                patch * 1e3,
                frequencies[row]
            );
            assert!(value.re > 0.0, "a driving-point mobility takes power");
        }
    }
    println!("largest difference {worst:.2} dB, {} evaluations", mobility.evaluations);
}
