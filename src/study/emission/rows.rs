//! Regressions of the emission over the logarithm of the speed.

use std::collections::BTreeSet;

use super::run_levels::{RunLevels, octaves};
use crate::counters::catalogue::catalogue;
use crate::response::{BandLevel, ThirdOctaveBand};
use crate::scene::Vehicle;
use crate::sound::{Compared, SpeedCoefficient, TotalLevel};
use crate::study::sweep::repeated::largest;

/// Speeds that UN R117 permits for car tyres \[km/h\].
const R117_SPEEDS: std::ops::RangeInclusive<f64> = 70.0..=90.0;
/// Third octaves of Nord2000, 25 Hz to 10 kHz.
const NORD2000_BANDS: std::ops::RangeInclusive<i32> = -16..=10;

catalogue! {
    /// Models of traffic noise, and the regulation of tyres, that rows are made for.
    pub(crate) enum EmissionModel as "kebab-case",
    /// Name in tables for scripts.
    name {
        /// Octaves of the sound power by CNOSSOS-EU: A_R and B_R.
        CnossosEu => "cnossos-eu",
        /// Third octaves of the sound power by Nord2000: a_R and b_R.
        Nord2000 => "nord2000",
        /// Maximum of the coast-by, by UN R117 for tyres of classes C1 and C2.
        UnR117 => "un-r117",
    }
}

impl EmissionModel {
    /// Reference speed v_ref \[km/h\].
    pub(crate) fn reference_speed(self) -> f64 {
        match self {
            Self::CnossosEu | Self::Nord2000 => 70.0,
            Self::UnR117 => 80.0,
        }
    }
}

/// Line L = A + B lg(v/v_ref) through the levels of a band.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct EmissionRow {
    /// Road, load and settings, as far as they are varied.
    pub group: String,
    /// Name of the receiver.
    pub receiver: String,
    /// Model that the row is for.
    pub model: EmissionModel,
    /// Nominal mid-frequency of the band \[Hz\]; `None` of an overall level.
    pub nominal_hz: Option<f64>,
    /// Number of tyres whose level it is.
    pub tyres: usize,
    /// The fit: level A at v_ref, slope B.
    pub line: SpeedCoefficient,
    /// Number of runs of the fit, and how many of them are slower and faster than v_ref.
    pub runs: [usize; 3],
    /// Lowest and highest speed \[km/h\].
    pub speeds: [f64; 2],
    /// True if the band is valid in every run.
    pub valid: bool,
    /// Largest error of a level by numerics and slices \[dB\], if that of every level is known.
    pub error: Option<f64>,
    /// Passages of a maximum, of the run with the fewest, and the largest standard error of a level \[dB\] if that of
    /// every level is known.
    pub passages: Option<(usize, Option<f64>)>,
}

#[derive(Clone, Copy, Debug)]
struct Point {
    /// Speed \[km/h\].
    speed: f64,
    level: f64,
    valid: bool,
    error: Option<f64>,
}

/// Rows of one group at one receiver, from its runs.
pub(super) fn rows(runs: &[&RunLevels]) -> Vec<EmissionRow> {
    let row = |model: EmissionModel, nominal_hz, tyres, points: Vec<Point>| {
        let points: Vec<Point> = points.into_iter().filter(|point| point.level.is_finite()).collect();
        let reference = model.reference_speed();
        let line = SpeedCoefficient::fit(points.iter().map(|point| (point.speed, point.level)), reference)?;
        let speeds = || points.iter().map(|point| point.speed);
        Some(EmissionRow {
            group: runs[0].group.clone(),
            receiver: runs[0].receiver.clone(),
            model,
            nominal_hz,
            tyres,
            line,
            runs: [
                points.len(),
                speeds().filter(|v| *v < reference).count(),
                speeds().filter(|v| *v > reference).count(),
            ],
            speeds: [speeds().fold(f64::INFINITY, f64::min), speeds().fold(0.0, f64::max)],
            valid: points.iter().all(|point| point.valid),
            error: largest(points.iter().map(|point| point.error)),
            passages: None,
        })
    };
    // Points of each band from all runs, bands rising; a band reaches over so many third octaves on either side.
    let banded = |model: EmissionModel, reach: i32, bands: &dyn Fn(&RunLevels) -> Vec<BandLevel>| -> Vec<EmissionRow> {
        let spectra: Vec<(&RunLevels, Vec<BandLevel>)> = runs.iter().map(|of| (*of, bands(of))).collect();
        let numbers: BTreeSet<_> = spectra.iter().flat_map(|(_, bands)| bands).map(|of| of.band).collect();
        let points = |band: ThirdOctaveBand| -> Vec<Point> {
            let of_run = |(run, bands): &(&RunLevels, Vec<BandLevel>)| {
                let of = bands.iter().find(|of| of.band == band)?;
                let thirds = (band.0 - reach..=band.0 + reach).map(ThirdOctaveBand);
                let error = largest(thirds.map(|third| run.errors.total(third)));
                Some(Point { speed: run.speed, level: of.level, valid: of.valid, error })
            };
            spectra.iter().filter_map(of_run).collect()
        };
        let one = |band: ThirdOctaveBand| row(model, Some(band.nominal_frequency()), Vehicle::TYRES, points(band));
        numbers.into_iter().filter_map(one).collect()
    };
    let mut all = banded(EmissionModel::CnossosEu, 1, &|of| octaves(&of.power[0]));
    let in_nord2000 = |of: &BandLevel| NORD2000_BANDS.contains(&of.band.0);
    all.extend(banded(EmissionModel::Nord2000, 0, &|of| of.power[1].iter().copied().filter(in_nord2000).collect()));
    let maximum = row(EmissionModel::UnR117, None, runs[0].tyres, maxima(runs).unwrap_or_default());
    let passed = || runs.iter().filter(|of| R117_SPEEDS.contains(&of.speed)).filter_map(|of| of.passages);
    let fewest = passed().map(|(count, _)| count).min();
    let passages = fewest.map(|fewest| (fewest, largest(passed().map(|(_, error)| error))));
    all.extend(maximum.map(|row| EmissionRow { passages, ..row }));
    all
}

/// Maxima of the runs at the speeds of UN R117.
///
/// # Errors
/// Why these are not of one kind: maxima of different bands, or of bands that do not reach the loudest.
fn maxima(runs: &[&RunLevels]) -> Result<Vec<Point>, String> {
    let passed = runs.iter().filter(|of| R117_SPEEDS.contains(&of.speed));
    let (speeds, levels): (Vec<f64>, Vec<&TotalLevel>) =
        passed.filter_map(|of| Some((of.speed, of.maximum.as_ref()?))).unzip();
    if levels.is_empty() {
        return Ok(Vec::new());
    }
    let compared = Compared::for_growth(&levels)?;
    let points = speeds.into_iter().zip(compared.levels).zip(&levels);
    let point = |((speed, level), of): ((f64, f64), &&TotalLevel)| Point {
        speed,
        level,
        valid: !of.is_lower_bound(),
        error: of.error,
    };
    Ok(points.map(point).collect())
}

/// Why a receiver has no row of UN R117 if its maxima cannot be compared.
pub(super) fn no_maxima(runs: &[&RunLevels]) -> Option<String> {
    let why = maxima(runs).err()?;
    let place = [runs[0].group.as_str(), runs[0].receiver.as_str()];
    let place: Vec<&str> = place.into_iter().filter(|text| !text.is_empty()).collect();
    Some(format!("{}: no line of UN R117: {why}", place.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::super::run_levels::tests::bands;
    use super::*;
    use crate::response::LevelErrors;

    /// A maximum whose bands are loudest at 800 Hz and end with band `last`.
    fn maximum(last: i32, level: f64) -> TotalLevel {
        let band = |n: i32| {
            let level = 60.0 - 2.0 * f64::from((n + 1).abs());
            BandLevel { band: ThirdOctaveBand(n), mean_square: 1.0, level, valid: true }
        };
        TotalLevel::of((-16..=last).map(band).collect()).unwrap().at_most(level)
    }

    #[test]
    fn maxima_of_different_or_few_bands_make_no_line() {
        let with = |lasts: [i32; 3]| {
            let mut runs = runs(&[70.0, 80.0, 90.0], &[0.0; 3]);
            for (of, last) in runs.iter_mut().zip(lasts) {
                of.maximum = Some(maximum(last, 14.8));
            }
            let rows = of(&runs).into_iter().filter(|row| row.model == EmissionModel::UnR117).count();
            (rows, no_maxima(&runs.iter().collect::<Vec<_>>()).unwrap_or_default())
        };
        assert_eq!(with([3, 3, 3]), (1, String::new()));
        let (rows, why) = with([3, 3, -11]);
        assert!(rows == 0 && why == "rough, coast-by: no line of UN R117: maxima of different bands", "{why}");
        let (rows, why) = with([-11; 3]);
        assert!(rows == 0 && why.contains("25 Hz - 80 Hz, do not reach the loudest"), "{why}");
    }

    /// Runs whose power levels lie on lines of A and B about 70 km/h, by band, offset as given \[dB\].
    fn runs(speeds: &[f64], off: &[f64]) -> Vec<RunLevels> {
        let run = |(&speed, off): (&f64, &f64)| {
            let x = (speed / 70.0).log10();
            let level = |band: i32| 90.0 + f64::from(band) + (30.0 + f64::from(band)) * x + off;
            let power = bands(&(-16..=4).map(|band| (band, level(band))).collect::<Vec<_>>());
            RunLevels {
                group: "rough".to_owned(),
                receiver: "coast-by".to_owned(),
                tyres: 1,
                speed,
                power: [power.clone(), power],
                errors: LevelErrors { numerical: Some((90.0, 0.5)), ..LevelErrors::default() },
                maximum: Some(maximum(0, 70.5 + 31.0 * (speed / 80.0).log10() + off)),
                passages: Some((4, Some(0.01 * speed))),
            }
        };
        speeds.iter().zip(off).map(run).collect()
    }

    fn of(runs: &[RunLevels]) -> Vec<EmissionRow> {
        rows(&runs.iter().collect::<Vec<_>>())
    }

    #[test]
    fn exact_lines_are_found_with_their_speeds() {
        let found = of(&runs(&[50.0, 70.0, 80.0, 90.0, 110.0], &[0.0; 5]));
        let model = |model| found.iter().filter(move |row| row.model == model).collect::<Vec<_>>();
        let nord = model(EmissionModel::Nord2000);
        assert_eq!(nord.len(), 21);
        for (row, band) in nord.iter().zip(-16..) {
            let band = f64::from(band);
            let off = [row.line.reference_level - 90.0 - band, row.line.slope.decibels_per_decade - 30.0 - band];
            assert!(off.iter().all(|off| off.abs() < 1e-9), "{row:?}");
            assert!(row.line.slope.residual.unwrap() < 1e-9 && row.valid == (band < 3.0) && row.tyres == 4);
            assert_eq!((row.runs, row.speeds), ([5, 1, 3], [50.0, 110.0]));
            assert_eq!(row.error, (band > -10.5).then_some(0.5), "{row:?}");
        }
        // Octaves end where a third octave is missing: the run goes up to 2.5 kHz.
        let cnossos = model(EmissionModel::CnossosEu);
        assert_eq!(
            cnossos.iter().filter_map(|row| row.nominal_hz).collect::<Vec<_>>(),
            [63.0, 125.0, 250.0, 500.0, 1000.0, 2000.0]
        );
        assert_eq!(cnossos.iter().map(|row| row.valid).collect::<Vec<_>>(), [true, true, true, true, true, false]);
        assert_eq!(cnossos.iter().map(|row| row.error).take(2).collect::<Vec<_>>(), [None, Some(0.5)]);
        // At v_ref an octave is the sum of its three lines.
        let exact = 10.0 * [89.0, 90.0, 91.0].map(|level: f64| 10.0_f64.powf(0.1 * level)).iter().sum::<f64>().log10();
        assert!((cnossos[4].line.reference_level - exact).abs() < 0.02, "{:?}", cnossos[4]);
        // UN R117 has runs at 70 to 90 km/h alone; the one at 90 km/h is not valid.
        let [r117] = model(EmissionModel::UnR117)[..] else { panic!("one row") };
        assert!((r117.line.reference_level - 70.5).abs() < 1e-9);
        assert!((r117.line.slope.decibels_per_decade - 31.0).abs() < 1e-8);
        assert_eq!((r117.runs, r117.speeds, r117.tyres, r117.valid), ([3, 1, 1], [70.0, 90.0], 1, false));
        assert_eq!((r117.passages, r117.error), (Some((4, Some(0.9))), None));
        let mut single = runs(&[70.0, 80.0, 90.0], &[0.0; 3]);
        single[0].passages = Some((1, None));
        assert_eq!(of(&single).last().unwrap().passages, Some((1, None)), "an error that is not known is none of 0");
    }

    #[test]
    fn scatter_gives_the_intervals_of_the_closed_form() {
        // Off the line by +e at the middle and by -e/2 at the ends, which are as far from it in the logarithm: slope
        // and sum of these are 0, s = e sqrt(3/2), S = 2 d^2, t = 12.706.
        let (e, d) = (0.4, 0.1);
        let speeds = [-d, 0.0, d].map(|x| 70.0 * 10.0_f64.powf(x));
        let found = of(&runs(&speeds, &[-0.5 * e, e, -0.5 * e]));
        let row = found.iter().find(|row| row.nominal_hz == Some(1000.0) && row.model == EmissionModel::Nord2000);
        let line = row.unwrap().line;
        assert!((line.slope.decibels_per_decade - 30.0).abs() < 1e-9 && (line.reference_level - 90.0).abs() < 1e-9);
        let s = e * 1.5_f64.sqrt();
        assert!((line.slope_interval.unwrap() - 12.7062 * s / (2.0_f64.sqrt() * d)).abs() < 1e-3, "{line:?}");
        assert!((line.reference_interval.unwrap() - 12.7062 * s / 3.0_f64.sqrt()).abs() < 1e-3, "{line:?}");
        assert!((line.slope.residual.unwrap() - e * 0.5_f64.sqrt()).abs() < 1e-9, "{line:?}");
    }

    #[test]
    fn a_band_of_one_speed_and_silence_have_no_row() {
        let mut runs = runs(&[50.0, 60.0], &[0.0; 2]);
        runs[0].power[1].retain(|of| of.band.0 != -16);
        runs[1].power[1][1].level = f64::NEG_INFINITY;
        let found = of(&runs);
        let nord: Vec<f64> =
            found.iter().filter(|row| row.model == EmissionModel::Nord2000).filter_map(|row| row.nominal_hz).collect();
        assert_eq!(nord[0].to_bits(), 40.0_f64.to_bits(), "{nord:?}");
        assert!(found.iter().all(|row| row.line.slope_interval.is_none() && row.model != EmissionModel::UnR117));
    }
}
