//! The levels of a sweep side by side.

use std::path::Path;

use crate::response::{BandLevel, SpeedExponent, ThirdOctaveBand};
use crate::results::ResultsError;
use crate::results::plots::{Axis, LinePlot, PlotError, Series};
use crate::results::summary::RollingResistance;
use crate::results::table::{aligned, numbers};
use crate::study::sweep::run::Outcome;
use crate::study::sweep::variants::Variant;

/// One line of a block: a band over all speeds.
#[derive(Clone, Debug, PartialEq)]
pub struct BandLine {
    /// The band.
    pub band: ThirdOctaveBand,
    /// Level at each speed \[dB re 1 N\]; `None` where the variant is not done or does not reach the band.
    pub levels: Vec<Option<f64>>,
    /// Whether the variant vouches for it; text has the others in brackets.
    pub valid: Vec<bool>,
    /// How they grow, from two speeds on.
    pub exponent: Option<SpeedExponent>,
}

/// The variants of one road and load.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepBlock {
    /// Road and load, as far as they are varied.
    pub group: String,
    /// Speeds \[km/h\].
    pub speeds: Vec<f64>,
    /// Bands, rising.
    pub lines: Vec<BandLine>,
    /// Rolling resistance at each speed; `None` where the variant is not done or its tread law has none.
    pub rolling_resistances: Vec<Option<RollingResistance>>,
}

/// The blocks of a sweep, in the order of its variants.
pub fn blocks(variants: &[Variant], outcomes: &[Outcome]) -> Vec<SweepBlock> {
    let pairs: Vec<(&Variant, &Outcome)> = variants.iter().zip(outcomes).collect();
    pairs.chunk_by(|(one, _), (other, _)| one.group == other.group).map(block).collect()
}

fn block(pairs: &[(&Variant, &Outcome)]) -> SweepBlock {
    let levels_of = |outcome: &Outcome| -> Vec<BandLevel> {
        match outcome {
            Outcome::Done { levels, .. } => levels.clone(),
            Outcome::Stopped | Outcome::Failed(_) => Vec::new(),
        }
    };
    let spectra: Vec<(f64, Vec<BandLevel>)> =
        pairs.iter().map(|(variant, outcome)| (variant.speed, levels_of(outcome))).collect();
    let mut bands: Vec<i32> = spectra.iter().flat_map(|(_, levels)| levels).map(|level| level.band.0).collect();
    bands.sort_unstable();
    bands.dedup();
    let lines = bands.into_iter().map(|band| {
        let at = |levels: &[BandLevel]| levels.iter().find(|level| level.band.0 == band).copied();
        let found: Vec<Option<BandLevel>> = spectra.iter().map(|(_, levels)| at(levels)).collect();
        let points =
            spectra.iter().zip(&found).filter_map(|((speed, _), level)| level.map(|level| (*speed, level.level)));
        let exponent = SpeedExponent::fit(points);
        let valid = found.iter().map(|level| level.is_some_and(|level| level.valid)).collect();
        let levels = found.iter().map(|level| level.map(|level| level.level)).collect();
        BandLine { band: ThirdOctaveBand(band), exponent, levels, valid }
    });
    let resistance_of = |outcome: &Outcome| match outcome {
        Outcome::Done { rolling_resistance, .. } => *rolling_resistance,
        Outcome::Stopped | Outcome::Failed(_) => None,
    };
    SweepBlock {
        rolling_resistances: pairs.iter().map(|(_, outcome)| resistance_of(outcome)).collect(),
        group: pairs[0].0.group.clone(),
        lines: lines.collect(),
        speeds: spectra.iter().map(|(speed, _)| *speed).collect(),
    }
}

impl SweepBlock {
    /// The block for people: a line per band, a column per speed, growth and residual last.
    pub fn text(&self) -> String {
        let mut header = vec!["Hz".to_owned()];
        header.extend(self.speeds.iter().map(|speed| format!("{speed} km/h")));
        header.extend(["dB/decade", "residual dB"].map(str::to_owned));
        let row = |line: &BandLine| {
            let mut row = vec![line.band.label()];
            let marked = line.levels.iter().zip(&line.valid).map(|(level, &valid)| match level {
                None => "-".to_owned(),
                Some(level) if valid => format!("{level:.2}"),
                Some(level) => format!("({level:.2})"),
            });
            row.extend(marked);
            let exponent = |of: fn(&SpeedExponent) -> f64| {
                line.exponent.as_ref().map_or("-".to_owned(), |exponent| format!("{:.2}", of(exponent)))
            };
            row.extend([exponent(|fit| fit.decibels_per_decade), exponent(|fit| fit.residual)]);
            row
        };
        let rows: Vec<Vec<String>> = self.lines.iter().map(row).collect();
        let title = if self.group.is_empty() { String::new() } else { format!("{}\n", self.group) };
        format!("{title}{}{}", numbers(&header, &rows), self.resistance_text())
    }

    /// The rolling resistance below: a line per measure, a column per speed; nothing where no variant has any.
    fn resistance_text(&self) -> String {
        if self.rolling_resistances.iter().all(Option::is_none) {
            return String::new();
        }
        let mut header = vec!["rolling resistance".to_owned()];
        header.extend(self.speeds.iter().map(|speed| format!("{speed} km/h")));
        let row = |name: &str, cell: &dyn Fn(&RollingResistance) -> String| {
            let cells = self.rolling_resistances.iter().map(|found| found.as_ref().map_or("-".to_owned(), cell));
            [name.to_owned()].into_iter().chain(cells).collect::<Vec<String>>()
        };
        let rows = [
            row("coefficient", &|resistance| format!("{:.5}", resistance.coefficient)),
            row("N", &|resistance| format!("{:.2}", resistance.force)),
            row("W", &|resistance| format!("{:.1}", resistance.power)),
        ];
        format!("\n{}", aligned(&header, &rows))
    }
}

/// All blocks as CSV: one row per group, band and speed, the band's growth and the speed's rolling resistance repeated.
/// Numbers are written so that reading gives the same bits.
///
/// # Errors
/// [`ResultsError::Write`] naming `path`, where it is going to be.
pub fn csv(blocks: &[SweepBlock], path: &Path) -> Result<String, ResultsError> {
    let failed = |error: csv::Error| ResultsError::writing(path)(error.into());
    let mut writer = csv::Writer::from_writer(Vec::new());
    let header = [
        "group",
        "nominal_hz",
        "mid_frequency_hz",
        "speed_kmh",
        "level_db_re_1n",
        "growth_db_per_decade",
        "residual_db",
        "speeds",
    ];
    let header = header.into_iter().chain(RollingResistance::COLUMNS).chain(["valid"]);
    writer.write_record(header).map_err(failed)?;
    for block in blocks {
        for line in &block.lines {
            let of_line = |of: fn(&SpeedExponent) -> String| line.exponent.as_ref().map_or(String::new(), of);
            let levels = line.levels.iter().zip(&line.valid);
            let columns = block.speeds.iter().zip(levels).zip(&block.rolling_resistances);
            for ((speed, (level, valid)), resistance) in columns {
                let Some(level) = level else { continue };
                let row = [
                    block.group.clone(),
                    line.band.nominal_frequency().to_string(),
                    line.band.mid_frequency().to_string(),
                    speed.to_string(),
                    level.to_string(),
                    of_line(|fit| fit.decibels_per_decade.to_string()),
                    of_line(|fit| fit.residual.to_string()),
                    of_line(|fit| fit.speeds.to_string()),
                ];
                let valid = u8::from(*valid).to_string();
                let row = row.into_iter().chain(RollingResistance::cells(*resistance)).chain([valid]);
                writer.write_record(row).map_err(failed)?;
            }
        }
    }
    let bytes = writer.into_inner().map_err(|error| ResultsError::writing(path)(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Growth over frequency, a curve per group; `None` where no band has one.
///
/// # Errors
/// [`PlotError`].
pub fn growth_plot(blocks: &[SweepBlock], title: &str) -> Result<Option<String>, PlotError> {
    let series: Vec<Series<'_>> = blocks
        .iter()
        .map(|block| Series {
            name: &block.group,
            points: (block.lines.iter())
                .filter_map(|line| line.exponent.map(|fit| (line.band.mid_frequency(), fit.decibels_per_decade)))
                .collect(),
        })
        .filter(|series| !series.points.is_empty())
        .collect();
    let frequencies = || series.iter().flat_map(|series| &series.points).map(|point| point.0);
    let (lowest, highest) = (frequencies().fold(f64::MAX, f64::min), frequencies().fold(0.0, f64::max));
    if lowest >= highest {
        return Ok(None);
    }
    let growths: Vec<f64> = series.iter().flat_map(|series| &series.points).map(|point| point.1).collect();
    let plot = LinePlot {
        title,
        x: Axis::logarithmic("Frequency [Hz]", lowest..highest),
        y: Axis::linear_around("Growth of the force level [dB per decade of speed]", growths),
        series,
    };
    plot.to_svg().map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block() -> SweepBlock {
        let speeds = vec![50.0, 80.0, 130.0];
        let line = |band: i32, offset: f64, slope: f64| {
            let levels: Vec<Option<f64>> =
                speeds.iter().map(|speed: &f64| Some(offset + slope * speed.log10())).collect();
            let exponent = SpeedExponent::fit(speeds.iter().copied().zip(levels.iter().map(|level| level.unwrap())));
            BandLine { band: ThirdOctaveBand(band), valid: vec![true; levels.len()], levels, exponent }
        };
        let mut lines = vec![line(-3, 1.0, 30.0), line(0, 2.0, 22.25)];
        lines.push(BandLine {
            band: ThirdOctaveBand(3),
            levels: vec![None, None, Some(3.0)],
            valid: vec![true; 3],
            exponent: None,
        });
        let rolling_resistances =
            vec![None, Some(RollingResistance { coefficient: 0.0125, force: 37.5, power: 833.0 }), None];
        SweepBlock { group: "stone, 3000 N".into(), speeds, lines, rolling_resistances }
    }

    #[test]
    fn a_made_up_growth_stands_in_table_csv_and_picture() {
        let text = block().text();
        assert!(text.starts_with("stone, 3000 N\n") && text.contains("130 km/h") && text.contains("22.25"), "{text}");
        assert!(text.contains("0.01250") && text.contains("37.50") && text.contains("833.0"), "{text}");
        let bands = text.split("\n\n").next().unwrap();
        let last = bands.lines().last().unwrap();
        assert!(last.trim_start().starts_with("2k") || last.trim_start().starts_with("2000"), "{last}");
        assert_eq!(last.matches(" -").count(), 4, "{last}");
        let csv = csv(&[block()], Path::new("sweep.csv")).unwrap();
        let mut reader = csv::Reader::from_reader(csv.as_bytes());
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 7);
        let growth: f64 = rows[0][5].parse().unwrap();
        assert!((growth - 30.0).abs() < 1e-10 && &rows[0][0] == "stone, 3000 N" && rows[6][5].is_empty());
        assert_eq!((&rows[1][8], &rows[1][9], &rows[1][10], &rows[0][8]), ("0.0125", "37.5", "833", ""));
        let svg = growth_plot(&[block()], "t").unwrap().unwrap();
        assert!(svg.contains("per decade of speed"), "{svg}");
        assert_eq!(growth_plot(&[], "t").unwrap(), None);
    }
}
