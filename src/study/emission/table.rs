//! Emission as CSV, as JSON and for the terminal.

use serde_json::{Value, json};

use super::Emission;
use super::rows::{EmissionModel, EmissionRow};
use crate::results::table::{Report, csv, numbers, optional, row};

/// Columns of `emission.csv`, by which an existing file is recognised.
pub(crate) const EMISSION_HEAD: &str = "group,receiver,model,nominal_hz,reference_kmh,tyres,a_db,b_db_per_decade,\
                                        a_error_db,b_error_db_per_decade,residual_rms_db,runs,lowest_kmh,highest_kmh,\
                                        valid";

/// Columns behind those of [`EMISSION_HEAD`].
const STATISTICS: [&str; 3] = ["passages", "standard_error_db", "level_error_db"];

/// Number of runs that UN R117 asks for on either side of its reference speed.
const R117_RUNS: usize = 4;

impl Emission {
    /// All rows as CSV; reading the numbers gives the same bits. Errors of A and B are half of the 95 % interval by
    /// scatter alone, empty for two runs. The last columns are the fewest passages that a maximum is the mean of, the
    /// largest standard error of such a mean, and the largest error of a level by numerics and slices; the errors are
    /// empty where one is not known.
    pub(crate) fn csv(&self) -> String {
        let rows = self.rows.iter().map(|of| {
            let (model, reference, line) = (of.model.name(), of.model.reference_speed(), &of.line);
            let [band, a_error, b_error] = [of.nominal_hz, line.reference_interval, line.slope_interval].map(optional);
            let [lowest, highest] = &of.speeds;
            let (a, slope, valid) = (&line.reference_level, &line.slope, u8::from(of.valid));
            let (b, rms) = (&slope.decibels_per_decade, optional(slope.residual));
            let passages = optional(of.passages.map(|(fewest, _)| fewest));
            let error = optional(of.passages.and_then(|(_, error)| error));
            row([
                &of.group,
                &of.receiver,
                &model,
                &band,
                &reference,
                &of.tyres,
                a,
                b,
                &a_error,
                &b_error,
                &rms,
                &of.runs[0],
                lowest,
                highest,
                &valid,
                &passages,
                &error,
                &optional(of.error),
            ])
        });
        csv(EMISSION_HEAD.split(',').chain(STATISTICS), rows)
    }

    /// All rows, and the assumptions behind them.
    pub(crate) fn to_json(&self) -> Value {
        let row = |of: &EmissionRow| {
            json!({
                "group": of.group,
                "receiver": of.receiver,
                "model": of.model,
                "nominal_hz": of.nominal_hz,
                "reference_kmh": of.model.reference_speed(),
                "tyres": of.tyres,
                "a_db": of.line.reference_level,
                "b_db_per_decade": of.line.slope.decibels_per_decade,
                "a_error_db": of.line.reference_interval,
                "b_error_db_per_decade": of.line.slope_interval,
                "residual_rms_db": of.line.slope.residual,
                "runs": of.runs[0],
                "lowest_kmh": of.speeds[0],
                "highest_kmh": of.speeds[1],
                "valid": of.valid,
                "passages": of.passages.map(|of| of.0),
                "standard_error_db": of.passages.and_then(|of| of.1),
                "level_error_db": of.error,
            })
        };
        json!({
            "rows": self.rows.iter().map(row).collect::<Vec<_>>(),
            "notes": EmissionModel::ALL.map(EmissionModel::note),
            "missing": self.missing,
        })
    }

    /// Tables by group and receiver, for people.
    pub(crate) fn report(&self) -> Report {
        let mut report = Report::default();
        let apart = |one: &EmissionRow, other: &EmissionRow| {
            (&one.group, &one.receiver, one.model) == (&other.group, &other.receiver, other.model)
        };
        for (index, rows) in self.rows.chunk_by(apart).enumerate() {
            let first = &rows[0];
            if index > 0 {
                report.text("\n");
            }
            let place = [first.group.as_str(), first.receiver.as_str()].map(str::to_owned);
            let place: Vec<String> = place.into_iter().filter(|text| !text.is_empty()).collect();
            report.text(format!("{}: {}\n", place.join(", "), first.model.title()));
            let header = ["Hz", "A dB", "+- scatter", "B dB/decade", "+- scatter", "rms dB", "runs", "km/h"];
            report.table(numbers(header, rows.iter().map(cells)));
            report.text(errors(rows));
            report.text(first.note());
        }
        report.text(
            "\n+- scatter: half of the 95 % interval by the scatter of the runs about the line, without errors of the \
             levels themselves; in brackets: not valid in every run\n",
        );
        self.missing.iter().for_each(|missing| report.text(format!("{missing}\n")));
        EmissionModel::ALL.map(EmissionModel::note).iter().for_each(|note| report.text(format!("{note}\n")));
        report
    }
}

/// Sentence on the errors of the levels behind the rows that are valid.
fn errors(rows: &[EmissionRow]) -> String {
    let valid = || rows.iter().filter(|row| row.valid);
    let unknown = valid().filter(|row| row.error.is_none()).count();
    let largest = match valid().filter_map(|row| row.error).reduce(f64::max) {
        None => "not known".to_owned(),
        Some(error) if unknown == 0 => format!("at most {error:.1} dB"),
        Some(error) => format!("at most {error:.1} dB, not known in {unknown} of the bands"),
    };
    format!("numerical error of the levels, slices included: {largest}\n")
}

/// Cells of a row, in brackets where it is not valid.
fn cells(of: &EmissionRow) -> Vec<String> {
    let line = &of.line;
    let number = |value: Option<f64>| match value {
        None => "-".to_owned(),
        Some(value) if of.valid => format!("{value:.1}"),
        Some(value) => format!("({value:.1})"),
    };
    let values = [
        Some(line.reference_level),
        line.reference_interval,
        Some(line.slope.decibels_per_decade),
        line.slope_interval,
        line.slope.residual,
    ];
    let band = of.nominal_hz.map_or_else(|| "all".to_owned(), |hertz| hertz.to_string());
    let speeds = format!("{} - {}", of.speeds[0], of.speeds[1]);
    [band].into_iter().chain(values.map(number)).chain([of.runs[0].to_string(), speeds]).collect()
}

impl EmissionModel {
    /// Title of the table.
    fn title(self) -> &'static str {
        match self {
            Self::CnossosEu => "CNOSSOS-EU, sound power of four tyres re 1 pW, L_W = A + B lg(v/70 km/h)",
            Self::Nord2000 => "Nord2000, sound power of four tyres re 1 pW, L_W = A + B lg(v/70 km/h)",
            Self::UnR117 => "UN R117, L_AFmax of the coast-by re 20 uPa, A-weighted, L = A + B lg(v/80 km/h)",
        }
    }

    /// Assumptions of the rows.
    fn note(self) -> &'static str {
        match self {
            Self::CnossosEu => {
                "CNOSSOS-EU: rolling noise of category 1 (A_R, B_R), on the scene's road, not on the reference road; \
                 one source at 0.05 m, its power in the half space over the road"
            }
            Self::Nord2000 => {
                "Nord2000: rolling noise of category 1 (a_R, b_R), on the scene's road; 80 % of the power at 0.01 m, \
                 20 % at 0.3 m, in the free field"
            }
            Self::UnR117 => {
                "UN R117: no correction to 20 degrees Celsius, since the tyre of a scene has no temperature; no \
                 deduction of 1 dB(A) and no rounding"
            }
        }
    }
}

impl EmissionRow {
    /// Differences of a row from the regulation that it follows; empty for the models of traffic noise.
    fn note(&self) -> String {
        if self.model != EmissionModel::UnR117 {
            return String::new();
        }
        let [_, slower, faster] = self.runs;
        let mut note = String::new();
        if self.tyres == 1 {
            note.push_str("of one tyre: a vehicle (vehicle = {} of the receiver) has four\n");
        }
        if let Some((passages, error)) = self.passages {
            note.push_str(&match error {
                Some(error) => {
                    format!("means over {passages} or more passages, standard error at most {error:.1} dB\n")
                }
                None => format!(
                    "a run with {passages} passage{} has no known statistical error: a longer rolling.duration gives \
                     one\n",
                    if passages == 1 { "" } else { "s" }
                ),
            });
        }
        if slower.min(faster) < R117_RUNS {
            note.push_str(&format!(
                "runs below and above 80 km/h: {slower} and {faster}; UN R117 asks for {R117_RUNS} each, from 70 to 90 \
                 km/h\n"
            ));
        }
        note
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sound::SpeedCoefficient;

    fn row(model: EmissionModel, nominal_hz: Option<f64>, valid: bool) -> EmissionRow {
        let levels = [(60.0, 69.0), (70.0, 70.0), (90.0, 72.0)];
        EmissionRow {
            group: "rough, stone".to_owned(),
            receiver: "beside".to_owned(),
            model,
            nominal_hz,
            tyres: 4,
            line: SpeedCoefficient::fit(levels, model.reference_speed()).unwrap(),
            runs: [3, 2, 1],
            speeds: [60.0, 90.0],
            valid,
            error: nominal_hz.map(|_| 0.5),
            passages: nominal_hz.is_none().then_some((1, None)),
        }
    }

    #[test]
    fn rows_stand_in_csv_json_and_table_with_brackets_for_doubt() {
        let rows = vec![
            row(EmissionModel::CnossosEu, Some(63.0), true),
            row(EmissionModel::CnossosEu, Some(125.0), false),
            row(EmissionModel::UnR117, None, true),
        ];
        let emission = Emission { rows, missing: Vec::new() };
        let text = emission.csv();
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        assert_eq!(reader.headers().unwrap().len(), 18);
        let read: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        assert_eq!(read.len(), 3);
        let line = emission.rows[0].line;
        assert_eq!((&read[0][0], &read[0][2], &read[0][3], &read[0][14]), ("rough, stone", "cnossos-eu", "63", "1"));
        assert_eq!(read[0][6].parse::<f64>().unwrap().to_bits(), line.reference_level.to_bits());
        assert_eq!(read[0][9].parse::<f64>().unwrap().to_bits(), line.slope_interval.unwrap().to_bits());
        assert_eq!((&read[1][14], &read[2][3], &read[2][4]), ("0", "", "80"));
        let reported = emission.report().to_string();
        assert!(
            reported.contains("rough, stone, beside: CNOSSOS-EU") && reported.contains("lg(v/80 km/h)"),
            "{reported}"
        );
        assert_eq!(reported.matches(" (70.").count(), 1, "{reported}");
        assert!(reported.contains("below and above 80 km/h: 2 and 1;"), "{reported}");
        assert_eq!((&read[2][15], &read[2][16], &read[0][15]), ("1", "", ""));
        assert!(reported.contains("1 passage has no known statistical error"), "{reported}");
        let error = "numerical error of the levels, slices included:";
        assert!(
            reported.contains(&format!("{error} at most 0.5 dB\n"))
                && reported.contains(&format!("{error} not known\n"))
        );
        assert_eq!((&read[0][17], &read[2][17]), ("0.5", ""));
        let json = emission.to_json();
        assert_eq!((&json["rows"][0]["model"], &json["rows"][2]["nominal_hz"]), (&json!("cnossos-eu"), &Value::Null));
        assert_eq!(
            (&json["rows"][0]["level_error_db"], &json["rows"][2]["level_error_db"]),
            (&json!(0.5), &Value::Null)
        );
        assert_eq!(json["rows"][0]["a_db"].as_f64().unwrap().to_bits(), line.reference_level.to_bits());
    }
}
