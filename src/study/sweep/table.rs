//! The levels of a sweep side by side.

use std::collections::{BTreeMap, BTreeSet};

use crate::response::{BandLevel, SpeedExponent, ThirdOctaveBand};
use crate::results::pass_by::PassBySummary;
use crate::results::plots::{Axis, LinePlot, Series};
use crate::results::summary::RollingResistance;
use crate::results::table::{self, Report, aligned, numbers, optional};
use crate::sound::{Compared, SpeedCoefficient, TotalLevel};
use crate::study::sweep::friction_curves::friction_rows;
use crate::study::sweep::run::Done;
use crate::study::sweep::variants::Label;

/// Reference speed of the levels \[km/h\] (UN R117 for car tyres).
const REFERENCE_SPEED: f64 = 80.0;

/// More spectra in one picture cannot be distinguished.
pub(crate) const MOST_SPECTRA: usize = 12;

/// One line of a block: a band over all speeds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BandLine {
    /// Third octave of the line.
    pub band: ThirdOctaveBand,
    /// Level at each speed \[dB re 1 N\]; `None` where the variant is not done or does not reach the band. Reports put
    /// levels that are not valid in brackets.
    pub levels: Vec<Option<BandLevel>>,
    /// Growth with the speed, from two speeds on.
    pub exponent: Option<SpeedExponent>,
}

impl BandLine {
    /// True if every level behind the growth is valid.
    fn is_valid(&self) -> bool {
        self.levels.iter().flatten().all(|level| level.valid)
    }
}

/// The variants of one road and load.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SweepBlock {
    /// Road and load, as far as they are varied.
    pub group: String,
    /// Speeds \[km/h\], in the order of the sweep.
    pub speeds: Vec<f64>,
    /// Results at each speed; empty where the variant is not done.
    pub found: Vec<Done>,
    /// Bands, rising.
    pub lines: Vec<BandLine>,
}

/// Blocks of a sweep, in the order of its variants.
pub(crate) fn blocks(runs: &[(Label, Option<Done>)]) -> Vec<SweepBlock> {
    // A design may have its speeds in any order; groups keep the order in which they begin.
    let first: BTreeMap<&str, usize> =
        runs.iter().enumerate().rev().map(|(index, (label, _))| (label.group.as_str(), index)).collect();
    let mut runs: Vec<&(Label, Option<Done>)> = runs.iter().collect();
    runs.sort_by_key(|(label, _)| first.get(label.group.as_str()));
    let block = |runs: &[&(Label, Option<Done>)]| {
        let found = runs.iter().map(|(_, done)| done.clone().unwrap_or_default()).collect();
        SweepBlock::new(&runs[0].0.group, runs.iter().map(|(label, _)| label.speed).collect(), found)
    };
    runs.chunk_by(|(one, _), (other, _)| one.group == other.group).map(block).collect()
}

/// Tables of all roads, loads and settings, speeds side by side.
pub(crate) fn side_by_side(blocks: &[SweepBlock]) -> Report {
    let mut report = Report::default();
    for (index, block) in blocks.iter().enumerate() {
        if index > 0 {
            report.text("\n");
        }
        report.append(block.report());
    }
    report
}

impl SweepBlock {
    /// Block of the results at each speed \[km/h\].
    pub(crate) fn new(group: &str, speeds: Vec<f64>, found: Vec<Done>) -> Self {
        let bands: BTreeSet<i32> = found.iter().flat_map(|done| &done.levels).map(|level| level.band.0).collect();
        let line = |band: i32| {
            let at = |done: &Done| done.levels.iter().find(|level| level.band.0 == band).copied();
            let levels: Vec<Option<BandLevel>> = found.iter().map(at).collect();
            let points = speeds.iter().zip(&levels).filter_map(|(&speed, level)| Some((speed, (*level)?.level)));
            BandLine { band: ThirdOctaveBand(band), exponent: SpeedExponent::fit(points), levels }
        };
        let lines = bands.into_iter().map(line).collect();
        Self { group: group.to_owned(), speeds, found, lines }
    }

    /// Receivers with a level at one speed at least.
    fn receivers(&self) -> Vec<String> {
        let mut seen = BTreeSet::new();
        let names = self.found.iter().flat_map(|done| &done.sound).map(|(name, _)| name);
        names.filter(|name| seen.insert(*name)).cloned().collect()
    }

    /// Growth of the level at a receiver with the speed, about 80 km/h, over the bands that are valid in all runs.
    ///
    /// # Errors
    /// Why it is not known; empty where there are too few speeds.
    fn growth_at(&self, receiver: &str) -> Result<(SpeedCoefficient, Compared), String> {
        let pairs = self.speeds.iter().zip(&self.found);
        let (speeds, levels): (Vec<f64>, Vec<&TotalLevel>) =
            pairs.filter_map(|(&speed, done)| Some((speed, done.level_at(receiver)?))).unzip();
        let line =
            |levels: &[f64]| SpeedCoefficient::fit(speeds.iter().copied().zip(levels.iter().copied()), REFERENCE_SPEED);
        let of_all_bands: Vec<f64> = levels.iter().map(|level| level.level).collect();
        line(&of_all_bands).ok_or_else(String::new)?;
        let compared = Compared::for_growth(&levels)?;
        Ok((line(&compared.levels).ok_or_else(String::new)?, compared))
    }

    /// Row with the ranges of bands of the levels at a receiver.
    fn bands_at(&self, receiver: &str) -> Vec<String> {
        let range = |done: &Done| done.level_at(receiver).map_or("-".to_owned(), TotalLevel::range);
        let ranges = self.found.iter().map(range);
        ["  bands".to_owned()].into_iter().chain(ranges).chain([String::new()]).collect()
    }

    /// Note on a growth that is not known, or is not over all bands of the levels.
    fn growth_note(&self, receiver: &str) -> Option<String> {
        match self.growth_at(receiver) {
            Ok((_, compared)) if compared.all => None,
            Ok((_, compared)) => {
                Some(format!("{receiver}: dB/decade over {}, which all speeds have\n", compared.range()))
            }
            Err(why) if why.is_empty() => None,
            Err(why) => Some(format!("{receiver}: no dB/decade: {why}\n")),
        }
    }

    /// Rows of a passage's count and of the standard error of the mean; empty for other receivers.
    fn statistics(&self, receiver: &str) -> Vec<Vec<String>> {
        let row = |title: &str, cell: &dyn Fn(&PassBySummary) -> Option<String>| -> Vec<String> {
            let cells = self.found.iter().map(|done| done.pass_by(receiver).and_then(cell).unwrap_or("-".to_owned()));
            [title.to_owned()].into_iter().chain(cells).chain([String::new()]).collect()
        };
        if self.found.iter().all(|done| done.pass_by(receiver).is_none()) {
            return Vec::new();
        }
        vec![
            row("  passages", &|pass_by| Some(pass_by.passages.to_string())),
            row("  standard error", &|pass_by| Some(format!("{:.1}", pass_by.standard_error?))),
        ]
    }

    /// Note on the run whose number of passages falls farthest short of what the statistical error needs, with its
    /// length.
    fn longest_missing(&self, receiver: &str) -> Option<String> {
        let all =
            self.speeds.iter().zip(&self.found).filter_map(|(speed, done)| Some((speed, done.pass_by(receiver)?)));
        let missing = all.filter_map(|(speed, pass_by)| Some((pass_by.missing_seconds()?, speed, pass_by)));
        let (_, speed, pass_by) = missing.max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(format!("{receiver}, {speed} km/h: {}\n", pass_by.statistics()))
    }

    /// Block for people: a line per band, a column per speed, growth and residual last; below it rolling resistance,
    /// which levels could not be read, and which loads were missed.
    pub(crate) fn report(&self) -> Report {
        let mark = |done: &Done| if done.missed_load().is_some() { " *" } else { "" };
        let columns = || self.speeds.iter().zip(&self.found);
        let titles: Vec<String> = columns().map(|(speed, done)| format!("{speed} km/h{}", mark(done))).collect();
        let header = |first: &str| [first.to_owned()].into_iter().chain(titles.clone());
        let bands = header("Hz").chain(["dB/decade", "residual dB"].map(str::to_owned));
        let row = |line: &BandLine| -> Vec<String> {
            let level = |level: &Option<BandLevel>| match level {
                None => "-".to_owned(),
                Some(BandLevel { level, valid: true, .. }) => format!("{level:.2}"),
                Some(BandLevel { level, .. }) => format!("({level:.2})"),
            };
            let fit = line.exponent.as_ref();
            let number = |number: f64| if line.is_valid() { format!("{number:.2}") } else { format!("({number:.2})") };
            let fit = [fit.map(|fit| fit.decibels_per_decade), fit.and_then(|fit| fit.residual)]
                .map(|value| value.map_or("-".to_owned(), number));
            [line.band.label()].into_iter().chain(line.levels.iter().map(level)).chain(fit).collect()
        };
        let mut report = Report::default();
        if !self.group.is_empty() {
            report.text(format!("{}\n", self.group));
        }
        report.table(numbers(bands, self.lines.iter().map(row)));
        if self.found.iter().any(|done| done.rolling_resistance.is_some()) {
            let row = |name: &str, cell: &dyn Fn(RollingResistance) -> String| -> Vec<String> {
                let cells = self.found.iter().map(|done| done.rolling_resistance.map_or("-".to_owned(), cell));
                [name.to_owned()].into_iter().chain(cells).collect()
            };
            let rows = [
                row("coefficient", &|resistance| format!("{:.5}", resistance.coefficient)),
                row("N", &|resistance| format!("{:.2}", resistance.force)),
                row("W", &|resistance| format!("{:.1}", resistance.power)),
            ];
            report.titled("\n", aligned(header("rolling resistance"), rows));
        }
        if self.found.iter().any(|done| done.friction.is_some()) {
            report.titled("\n", aligned(header("friction"), friction_rows(&self.found)));
        }
        let receivers = self.receivers();
        if !receivers.is_empty() {
            let row = |name: &String| -> Vec<String> {
                let level = |done: &Done| done.level_at(name).map_or("-".to_owned(), TotalLevel::text);
                let growth = self.growth_at(name).map_or("-".to_owned(), |(growth, _)| match growth.slope_interval {
                    Some(interval) => format!("{:.1} +- {interval:.1}", growth.slope.decibels_per_decade),
                    None => format!("{:.1}", growth.slope.decibels_per_decade),
                });
                let label = self.found.iter().map(|done| done.label_of(name)).max().unwrap_or_else(|| name.clone());
                [label].into_iter().chain(self.found.iter().map(level)).chain([growth]).collect()
            };
            let header = header("dB(A) at").chain(["dB/decade".to_owned()]);
            report.text("\n");
            let rows = receivers
                .iter()
                .flat_map(|name| [row(name), self.bands_at(name)].into_iter().chain(self.statistics(name)));
            report.table(aligned(header, rows));
            let longer = receivers.iter().filter_map(|name| self.longest_missing(name));
            longer.for_each(|reported| report.text(reported));
            receivers.iter().filter_map(|name| self.growth_note(name)).for_each(|reported| report.text(reported));
        }
        for (speed, done) in columns() {
            done.unread.iter().for_each(|reported| report.text(format!("{speed} km/h: {reported}\n")));
            if let Some(load) = done.missed_load() {
                report.text(format!("* {speed} km/h: {load}\n"));
            }
        }
        report
    }
}

/// Columns of the error and the bands of a level, and the highest band of the growth.
const BANDS: [&str; 5] = ["level_error_db", "lowest_hz", "highest_hz", "lower_bound", "growth_highest_hz"];

/// Levels at the receivers as CSV: one row per group, receiver and speed, with the regression L = L_ref + b
/// lg(v/v_ref); `None` without receivers.
pub(crate) fn sound_csv(blocks: &[SweepBlock]) -> Option<String> {
    let names = ["group", "receiver", "speed_kmh", "level_db_a", "growth_db_per_decade", "level_at_80_kmh_db_a"];
    let header = names.into_iter().chain(["passages", "standard_error_db"]).chain(BANDS);
    let mut rows: Vec<Vec<String>> = Vec::new();
    for block in blocks {
        for receiver in block.receivers() {
            let growth = block.growth_at(&receiver);
            let common = optional(growth.as_ref().ok().map(|(_, compared)| compared.highest_hz()));
            let growth = growth.map_or_else(
                |_| Default::default(),
                |(growth, _)| {
                    [growth.slope.decibels_per_decade, growth.reference_level].map(|number| number.to_string())
                },
            );
            for (speed, done) in block.speeds.iter().zip(&block.found) {
                let Some(level) = done.level_at(&receiver) else { continue };
                let names = [block.group.clone(), receiver.clone()];
                let numbers = [*speed, level.level].map(|number| number.to_string());
                let covered = level.covered();
                let bands = [
                    optional(level.error),
                    optional(covered.map(|bands| bands.lowest)),
                    optional(covered.map(|bands| bands.highest)),
                    optional(covered.map(|bands| u8::from(bands.lower_bound))),
                    common.clone(),
                ];
                let passed = done.pass_by(&receiver);
                let passages = optional(passed.map(|pass_by| pass_by.passages));
                let error = optional(passed.and_then(|pass_by| pass_by.standard_error));
                let statistics = [passages, error].into_iter().chain(bands);
                rows.push(names.into_iter().chain(numbers).chain(growth.clone()).chain(statistics).collect());
            }
        }
    }
    (!rows.is_empty()).then(|| table::csv(header, rows))
}

/// All blocks as CSV: one row per group, band and speed; the band's growth and the run's other results are repeated.
/// Reading the numbers gives the same bits.
pub(crate) fn csv(blocks: &[SweepBlock]) -> String {
    let band = ["group", "nominal_hz", "mid_frequency_hz", "speed_kmh", "level_db_re_1n"];
    let growth = ["growth_db_per_decade", "residual_db", "speeds"];
    let header = band.into_iter().chain(growth).chain(RollingResistance::COLUMNS).chain(["valid", "load_met"]);
    let mut rows: Vec<Vec<String>> = Vec::new();
    for block in blocks {
        for line in &block.lines {
            let growth = line.exponent.as_ref().map_or_else(Default::default, |fit| {
                [fit.decibels_per_decade.to_string(), optional(fit.residual), fit.speeds.to_string()]
            });
            for ((speed, level), done) in block.speeds.iter().zip(&line.levels).zip(&block.found) {
                let Some(level) = level else { continue };
                let numbers = [line.band.nominal_frequency(), line.band.mid_frequency(), *speed, level.level];
                let flag = |yes: bool| u8::from(yes).to_string();
                let row = [block.group.clone()].into_iter().chain(numbers.map(|number| number.to_string()));
                let row = row.chain(growth.clone()).chain(RollingResistance::cells(done.rolling_resistance));
                let met = done.load.map_or_else(String::new, |load| flag(load.met));
                rows.push(row.chain([flag(level.valid), met]).collect());
            }
        }
    }
    table::csv(header, rows)
}

/// Growth over frequency, a curve per group, grey where a level is not valid; `None` if no band has a growth.
pub(crate) fn growth_plot(blocks: &[SweepBlock], title: &str) -> Option<String> {
    let point = |line: &BandLine| {
        line.exponent.map(|fit| ((line.band.mid_frequency(), fit.decibels_per_decade), line.is_valid()))
    };
    let curve = |block: &SweepBlock| block.lines.iter().filter_map(point).unzip::<_, _, Vec<_>, Vec<_>>();
    let curves = blocks.iter().map(|block| (&block.group, curve(block)));
    let (series, valid): (Vec<Series<'_>>, Vec<Vec<bool>>) = curves
        .filter(|(_, (points, _))| !points.is_empty())
        .map(|(name, (points, valid))| (Series { name, points }, valid))
        .unzip();
    if series.iter().all(|series| series.points.len() < 2) {
        return None;
    }
    let points = || series.iter().flat_map(|series| &series.points);
    let plot = LinePlot {
        title,
        x: Axis::logarithmic_around("Frequency [Hz]", points().map(|point| point.0), [1.0, 1.0]),
        y: Axis::linear_around("Growth of the force level [dB per decade of speed]", points().map(|point| point.1)),
        series: series.clone(),
    };
    Some(plot.to_svg_by_validity(|curve, point| valid[curve][point]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::summary::LoadResult;

    /// Maximum of a passage whose bands are loudest at 800 Hz and valid up to number `valid_to`.
    fn level_valid_to(valid_to: i32, level: f64) -> TotalLevel {
        let band = |n: i32| {
            let level = 60.0 - 4.0 * f64::from((n + 1).abs());
            BandLevel { band: ThirdOctaveBand(n), mean_square: 1.0, level, valid: n <= valid_to }
        };
        TotalLevel::of((-16..=4).map(band).collect()).unwrap().at_most(level)
    }

    #[test]
    fn maxima_of_bands_below_the_loudest_have_no_growth_and_say_so() {
        let SweepBlock { group, speeds, found, .. } = block();
        let with = |levels: [TotalLevel; 3]| {
            let mut found = found.clone();
            for (done, level) in found.iter_mut().zip(levels) {
                done.sound = vec![("beside".to_owned(), level)];
            }
            SweepBlock::new(&group, speeds.clone(), found)
        };
        // At each speed slices are valid for 25 to 80 Hz: 14.8 dB(A) and less, the faster the less.
        let low = with([15.0, 14.8, 11.5].map(|level| level_valid_to(-11, level)));
        let reported = low.report().to_string();
        assert!(reported.contains("at least 14.8") && reported.contains("25 Hz - 80 Hz"), "{reported}");
        assert!(
            reported.contains("no dB/decade: the common bands, 25 Hz - 80 Hz, do not reach the loudest"),
            "{reported}"
        );
        let table = sound_csv(&[low]).unwrap();
        let row: Vec<&str> = table.lines().nth(2).unwrap().rsplit(',').take(5).collect();
        assert_eq!((row, table.contains("80,14.8,,,")), (vec!["", "1", "80", "25", ""], true), "{table}");
        // Maxima of other bands at one speed.
        let apart =
            with([level_valid_to(3, 68.0), level_valid_to(3, 70.0), level_valid_to(-11, 11.5)]).report().to_string();
        assert!(apart.contains("beside: no dB/decade: maxima of different bands"), "{apart}");
    }

    fn block() -> SweepBlock {
        let speeds = vec![50.0, 80.0, 130.0];
        let level =
            |band: i32, level: f64| BandLevel { band: ThirdOctaveBand(band), mean_square: 1.0, level, valid: true };
        let grown = |speed: f64| vec![level(-3, 1.0 + 30.0 * speed.log10()), level(0, 2.0 + 22.25 * speed.log10())];
        let mut found: Vec<Done> =
            speeds.iter().map(|&speed| Done { levels: grown(speed), ..Done::default() }).collect();
        found[2].levels.push(level(3, 3.0));
        found[1].rolling_resistance = Some(RollingResistance { coefficient: 0.0125, force: 37.5, power: 833.0 });
        found[1].unread = vec!["no level at \"cpx\"".to_owned()];
        found[2].load = Some(LoadResult { wanted: 3000.0, relative_error: 0.04, tolerance: 0.01, met: false });
        for (done, speed) in found.iter_mut().zip(&speeds) {
            done.sound = vec![("beside".to_owned(), level_valid_to(3, 70.0 + 35.0 * (speed / 80.0_f64).log10()))];
            done.passed = vec!["beside".to_owned()];
            // A single passage at the lowest speed, two that differ by 2 dB at the others.
            let maxima = if *speed < 60.0 { vec![70.0] } else { vec![69.0, 71.0] };
            done.pass_bys = vec![("beside".to_owned(), PassBySummary::new(String::new(), &maxima, 1, 0.9))];
        }
        SweepBlock::new("stone, 3000 N", speeds, found)
    }

    #[test]
    fn a_made_up_growth_stands_in_table_csv_and_picture() {
        let text = block().report().to_string();
        assert!(text.starts_with("stone, 3000 N\n") && text.contains("130 km/h") && text.contains("22.25"), "{text}");
        let statistics =
            |title: &str| text.lines().find(|line| line.trim_start().starts_with(title)).unwrap().to_owned();
        let cells = |line: String| line.split_whitespace().rev().take(3).map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(cells(statistics("standard error")), ["1.0", "1.0", "-"], "{text}");
        assert!(
            text.contains("beside, 130 km/h: mean of 2 passages, standard error 1.0 dB; for 0.5 dB, some 5.4 s more")
        );
        assert!(text.contains("0.01250") && text.contains("37.50") && text.contains("833.0"), "{text}");
        assert!(text.contains("80 km/h: no level at \"cpx\"\n"), "{text}");
        assert!(text.contains("130 km/h *") && text.contains("* 130 km/h: the mean force is +4.00 % off"), "{text}");
        let bands = text.split("\n\n").next().unwrap();
        let last = bands.lines().last().unwrap();
        assert!(last.trim_start().starts_with("2k") || last.trim_start().starts_with("2000"), "{last}");
        assert_eq!(last.matches(" -").count(), 4, "{last}");
        let csv = csv(&[block()]);
        let mut reader = csv::Reader::from_reader(csv.as_bytes());
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        assert_eq!(rows.len(), 7);
        let growth: f64 = rows[0][5].parse().unwrap();
        assert!((growth - 30.0).abs() < 1e-10 && &rows[0][0] == "stone, 3000 N" && rows[6][5].is_empty());
        assert_eq!((&rows[1][8], &rows[1][9], &rows[1][10], &rows[0][8]), ("0.0125", "37.5", "833", ""));
        assert_eq!((&rows[0][12], &rows[2][12]), ("", "0"));
        let svg = growth_plot(&[block()], "t").unwrap();
        assert!(svg.contains("Growth of the force level") && svg.contains("of speed]"), "{svg}");
        assert_eq!(growth_plot(&[], "t"), None);
        assert!(!svg.contains("#BEBEBE") && !text.contains("(30.00)"));
        assert!(
            text.contains("dB(A) at") && text.contains("beside, L_AFmax") && text.contains("35.0 +- 0.0"),
            "{text}"
        );
        let sound = sound_csv(&[block()]).unwrap();
        assert!(sound.lines().nth(2).unwrap().starts_with("\"stone, 3000 N\",beside,80,70,35"), "{sound}");
        assert_eq!(sound_csv(&[]), None);
    }

    #[test]
    fn a_growth_from_an_invalid_level_is_in_grey_brackets() {
        let SweepBlock { group, speeds, mut found, .. } = block();
        found[1].levels[0].valid = false;
        let block = SweepBlock::new(&group, speeds, found);
        let text = block.report().to_string();
        assert!(text.contains("(30.00)") && text.contains(" 22.25"), "{text}");
        assert!(growth_plot(&[block], "t").unwrap().contains("#BEBEBE"));
    }
}
