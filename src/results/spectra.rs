//! `spectra.csv`: third-octave levels, one row per band.

use serde::Deserialize;

use super::table::csv;
use crate::response::{BandLevel, LevelErrors, ThirdOctaveBand};

pub(crate) const SPECTRA_FILE: &str = "spectra.csv";
/// Column of what a finer mesh adds to levels \[dB\], where they are corrected to one.
pub(crate) const CORRECTION: &str = "correction_db";

/// Quantity of its levels.
pub(crate) const FORCE_LEVEL: &str = "Contact force level [dB re 1 N]";

/// Lowest band \[Hz\]: below, a run of seconds has too few periods.
pub(crate) const LOWEST_FREQUENCY: f64 = 20.0;

/// Text of the file. Columns: nominal frequency, exact mid-frequency and edges \[Hz\], mean square \[N^2\], level \[dB
/// re 1 N\], 1 for valid levels and 0 for others, the numerical error of valid levels, the error by slices and the
/// standard error of the level \[dB\]; of levels corrected to a finer mesh also what that has added \[dB\]. Numbers are
/// written so that reading gives the same bits; where there is none (the level of silence, an error that is not known)
/// the cell is empty.
pub(crate) fn force_levels_csv(
    levels: &[BandLevel],
    errors: &LevelErrors,
    standard_error: impl Fn(ThirdOctaveBand) -> Option<f64>,
    correction: impl Fn(ThirdOctaveBand) -> Option<f64>,
) -> String {
    let is_corrected = levels.iter().any(|level| correction(level.band).is_some());
    let header = "nominal_hz,mid_frequency_hz,lower_edge_hz,upper_edge_hz,mean_square_n2,level_db_re_1n,valid,error_db,\
                  slice_error_db,standard_error_db";
    let rows = levels.iter().map(|&BandLevel { band, mean_square, level, valid: is_valid }| {
        let valid = f64::from(u8::from(is_valid));
        let edges = [band.lower_edge(), band.upper_edge()];
        let known = [errors.numerical(band).filter(|_| is_valid), errors.by_slices(band), standard_error(band)];
        let [numerical, slices, scatter] = known.map(|error| error.unwrap_or(f64::NAN));
        let middle = band.mid_frequency();
        let added = is_corrected.then(|| correction(band).unwrap_or(f64::NAN));
        [band.nominal_frequency(), middle, edges[0], edges[1], mean_square, level, valid, numerical, slices, scatter]
            .into_iter()
            .chain(added)
    });
    csv(header.split(',').chain([CORRECTION].into_iter().filter(|_| is_corrected)), rows)
}

/// Levels in such a text, with the same bits; `None` if it is another text.
pub fn read_force_levels(text: &str) -> Option<Vec<BandLevel>> {
    #[derive(Deserialize)]
    struct Line {
        mid_frequency_hz: f64,
        mean_square_n2: f64,
        level_db_re_1n: Option<f64>,
        valid: f64,
    }
    let level = |line: Result<Line, csv::Error>| {
        let Line { mid_frequency_hz, mean_square_n2: mean_square, level_db_re_1n: level, valid } = line.ok()?;
        let band = ThirdOctaveBand::containing(mid_frequency_hz)?;
        let level = level.unwrap_or(f64::NEG_INFINITY);
        Some(BandLevel { band, mean_square, level, valid: valid > 0.0 })
    };
    csv::Reader::from_reader(text.as_bytes()).into_deserialize().map(level).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::response::level_errors::BySlices;

    #[test]
    fn numbers_come_back_bit_by_bit() {
        let level = |n: i32, mean_square: f64| BandLevel {
            band: ThirdOctaveBand(n),
            mean_square,
            level: 10.0 * mean_square.log10(),
            valid: n < -14,
        };
        let levels = [level(-15, 1.0 / 3.0), level(-14, 0.0), level(-13, 1e-200)];
        let slices = BySlices::Known(vec![(ThirdOctaveBand(-14), 2.0)]);
        let errors = LevelErrors { numerical: Some((0.0, 1.0 / 3.0)), slices };
        let text = force_levels_csv(&levels, &errors, |band| (band.0 == -13).then_some(0.7), |_| None);
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let rows: Vec<Vec<f64>> = reader
            .records()
            .map(|row| row.unwrap().iter().map(|field| field.parse().unwrap_or(f64::NEG_INFINITY)).collect())
            .collect();
        assert_eq!(rows.len(), 3);
        for (row, level) in rows.iter().zip(&levels) {
            let slices = if level.band.0 == -14 { 2.0 } else { f64::NEG_INFINITY };
            let expected = [
                level.band.nominal_frequency(),
                level.band.mid_frequency(),
                level.band.lower_edge(),
                level.band.upper_edge(),
                level.mean_square,
                level.level,
                f64::from(u8::from(level.valid)),
                if level.valid { 1.0 / 3.0 } else { f64::NEG_INFINITY },
                slices,
                if level.band.0 == -13 { 0.7 } else { f64::NEG_INFINITY },
            ];
            assert_eq!(row.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), expected.map(f64::to_bits));
        }
        assert_eq!(read_force_levels(&text).unwrap(), levels);
        assert_eq!(read_force_levels("a,b\n1,2\n"), None);
        assert!(text.starts_with("nominal_hz,") && text.contains("\n31.5,") && text.contains(",0,,0,,2,\n"), "{text}");
    }
}
