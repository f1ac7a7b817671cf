//! A validation as a table, as JSON, as a page and as a section of a Markdown file.

use maud::html;
use serde_json::{Value, json};

use super::html::{article, document, figure, table};
use crate::response::ThirdOctaveBand;
use crate::results::plots::{Axis, LinePlot, Series, four_digits};
use crate::results::table::{Report, TextTable, aligned, words};
use crate::scene::NamedTexture;
use crate::sound::TotalLevel;
use crate::study::validation::{
    FLEET_ROADS, Group, GroupSummary, Measured, Missing, PUBLISHED_SPEEDS, TyreLevels, ValidationRow, ValidationRun,
    Verdict, bands as published_bands, summaries,
};

/// Lines of a Markdown file between which the section is placed.
pub const MARKERS: [&str; 2] = ["<!-- tyrewave validate --markdown -->", "<!-- end of tyrewave validate -->"];

/// Explanation of the columns.
const LEGEND: &str = "numerical: bound of the error that is stated for elements, steps and slices, not part of the \
verdict. road: how far below and above the value may lie, since levels and skewness of constructed roads are \
uncertain. outside: distance from the published range; 0 where the whole spread of the road is inside; cannot be told \
where only a part of it is. could explain: physics that the model lacks, or limits of the comparison, that act on this \
quantity in this direction; nothing there points to a fault. \
Third octaves: A-weighted, along the coast-by line, relative to the energy sum of 200 to 2000 Hz; published ones are \
of roads of both kinds, dac-11 and sma-8.";

/// A value with one decimal, or none from 1000 on.
fn value(value: f64) -> String {
    if value.abs() >= 1000.0 { format!("{value:.0}") } else { format!("{value:.1}") }
}

fn range(row: &ValidationRow) -> String {
    format!("{} to {}", value(row.range[0]), value(row.range[1]))
}

fn computed(row: &ValidationRow) -> String {
    let least = if row.is_lower_bound { "at least " } else { "" };
    row.computed.map_or_else(|| "not computed".to_owned(), |computed| format!("{least}{}", value(computed)))
}

fn outside(row: &ValidationRow) -> String {
    match row.verdict() {
        Verdict::Inside => "0".to_owned(),
        Verdict::Below(by) => format!("-{}", value(by)),
        Verdict::Above(by) => format!("+{}", value(by)),
        Verdict::CannotBeTold => "cannot be told".to_owned(),
        Verdict::Unknown if row.is_bound() => "a bound".to_owned(),
        Verdict::Unknown => String::new(),
    }
}

fn reasons(row: &ValidationRow) -> String {
    row.could_explain.iter().map(|reason| Missing::title(*reason)).collect::<Vec<_>>().join(", ")
}

/// Table of all rows.
fn whole(rows: &[ValidationRow]) -> TextTable {
    let header =
        ["", "quantity", "unit", "computed", "numerical", "road", "published", "sets", "outside", "could explain"];
    let mut last = None;
    let cells = rows.iter().map(|row| {
        let group = if last == Some(row.group) { "" } else { row.group.title() };
        last = Some(row.group);
        [
            group.to_owned(),
            row.name(),
            row.unit.clone(),
            computed(row),
            row.numerical_error.map_or_else(String::new, |error| format!("+-{}", value(error))),
            row.road_spread.map_or_else(String::new, |[below, above]| format!("{below:+.1} {above:+.1}")),
            range(row),
            row.sets.to_string(),
            outside(row),
            reasons(row),
        ]
    });
    words(header, cells.collect::<Vec<_>>())
}

/// Counts of a group, for a cell.
fn inside(summary: &GroupSummary) -> String {
    let GroupSummary { rows, known, cannot_be_told, bounds, inside, .. } = *summary;
    if known + cannot_be_told + bounds == 0 {
        return "not computed".to_owned();
    }
    let not_computed = rows - known - cannot_be_told - bounds;
    let met = if summary.group == Group::Targets { " met" } else { "" };
    let counts = [
        (known, format!("{inside} of {known}{met}")),
        (cannot_be_told, format!("{cannot_be_told} cannot be told")),
        (bounds, format!("{bounds} only a bound")),
        (not_computed, format!("{not_computed} not computed")),
    ];
    counts.into_iter().filter(|(count, _)| *count > 0).map(|(_, words)| words).collect::<Vec<_>>().join(", ")
}

fn worst(summary: &GroupSummary, rows: &[ValidationRow]) -> String {
    let worst = summary.worst.map(|place| &rows[place]);
    worst.map_or_else(|| "-".to_owned(), |row| format!("{}: {} {}", row.name(), outside(row), row.unit))
}

fn groups(rows: &[ValidationRow]) -> TextTable {
    let cells = summaries(rows)
        .into_iter()
        .map(|summary| [summary.group.title().to_owned(), inside(&summary), worst(&summary, rows)]);
    words(["", "inside the published range", "farthest outside"], cells.collect::<Vec<_>>())
}

/// A validation for a terminal: all rows, then the groups.
pub(crate) fn report(title: &str, rows: &[ValidationRow]) -> Report {
    let mut report = Report::default();
    report.titled(format!("{title}\n\n"), whole(rows));
    report.titled("\n", groups(rows));
    report.text(format!("\n{LEGEND}\n\n"));
    report
}

/// A run as JSON, with bands, bound and error of its levels, and the passages of the maximum.
fn run(run: &ValidationRun) -> Value {
    let mut record = json!(run);
    for (name, level) in [("coast_by", &run.coast_by), ("cpx", &run.cpx)] {
        let bands = level.as_ref().and_then(TotalLevel::covered);
        record[format!("{name}_range_hz")] = json!(bands.map(|bands| [bands.lowest, bands.highest]));
        record[format!("{name}_lower_bound")] = json!(bands.map(|bands| bands.lower_bound));
        record[format!("{name}_error")] = json!(level.as_ref().and_then(|level| level.error));
    }
    record["coast_by_passages"] = json!(run.pass_by.as_ref().map(|pass_by| pass_by.passages));
    record["coast_by_standard_error"] = json!(run.pass_by.as_ref().and_then(|pass_by| pass_by.standard_error));
    record
}

/// A validation as JSON: rows, groups, tyre, runs.
pub(crate) fn record(title: &str, rows: &[ValidationRow], measured: &Measured) -> Value {
    let row = |row: &ValidationRow| {
        let mut record = json!(row);
        record["outside"] = json!(row.outside());
        record["verdict"] = json!(row.verdict());
        record
    };
    json!({
        "title": title,
        "rows": rows.iter().map(row).collect::<Vec<_>>(),
        "groups": summaries(rows),
        "tyre": measured.tyre,
        "runs": measured.runs.iter().map(run).collect::<Vec<_>>(),
        "load": measured.load,
    })
}

/// Section of a Markdown file, between its markers: the groups, and the third octaves at 80 km/h, with a question mark
/// for those that cannot be told.
pub fn markdown(rows: &[ValidationRow]) -> String {
    let mut lines = vec![MARKERS[0].to_owned()];
    lines.push("| | inside the published range | farthest outside |".to_owned());
    lines.push("|---|---|---|".to_owned());
    for summary in summaries(rows) {
        lines.push(format!("| {} | {} | {} |", summary.group.title(), inside(&summary), worst(&summary, rows)));
    }
    let on = |road: NamedTexture| {
        rows.iter().filter(move |row| row.group == Group::Shape80 && row.road == Some(road)).collect::<Vec<_>>()
    };
    let line = |name: &str, road: NamedTexture, cell: &dyn Fn(&ValidationRow) -> String| {
        let cells: Vec<String> = on(road).iter().map(|row| cell(row)).collect();
        format!("| {name} | {} |", cells.join(" | "))
    };
    let first = FLEET_ROADS[0];
    lines.push(String::new());
    lines.push(line("80 km/h, Hz", first, &|row| row.title.trim_end_matches(" Hz").to_owned()));
    lines.push(format!("|---{}|", "|---".repeat(on(first).len())));
    lines.push(line("published, at least, dB", first, &|row| value(row.range[0])));
    lines.push(line("at most, dB", first, &|row| value(row.range[1])));
    for road in FLEET_ROADS {
        lines.push(line(&format!("{}, dB", road.name()), road, &computed));
        lines.push(line("outside, dB", road, &|row| outside(row).replace("cannot be told", "?")));
    }
    lines.push(MARKERS[1].to_owned());
    lines.join("\n") + "\n"
}

/// Pictures of a validation: name of the file, SVG, caption.
pub(crate) fn pictures(
    rows: &[ValidationRow],
    measured: &Measured,
    levels: &[TyreLevels],
) -> Vec<(&'static str, String, String)> {
    let shapes =
        [(Group::Shape50, "shape_50.svg"), (Group::Shape80, "shape_80.svg"), (Group::Shape110, "shape_110.svg")];
    let mut pictures = Vec::new();
    for (group, file) in shapes {
        let title = format!("{}, A-weighted, less the sum of 200 to 2000 Hz", sentence(group.title()));
        if let Some(svg) = bands(rows, group, &title, "Relative level [dB]") {
            pictures.push((file, svg, format!("{title}: the published range, and what was computed on two roads.")));
        }
    }
    let title = sentence(Group::Growth.title());
    if let Some(svg) = bands(rows, Group::Growth, &title, "Growth [dB a decade]") {
        let caption = format!("{title}: the published range, and what was computed on two roads.");
        pictures.push(("growth.svg", svg, caption));
    }
    if let Some(svg) = levels_picture(levels) {
        let caption = "One tyre at the coast-by microphone, 80 km/h: each published set, and what was computed.";
        pictures.push(("levels_80.svg", svg, caption.to_owned()));
    }
    if let Some(svg) = roads(measured) {
        pictures.push(("roads.svg", svg, "Coast-by on the named roads at 80 km/h, A-weighted third octaves.".into()));
    }
    pictures.push(("textures.svg", textures(), "Third-octave texture levels of the named roads.".into()));
    pictures
}

fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Picture of the range and values of a group of bands; `None` if none was computed.
fn bands(rows: &[ValidationRow], group: Group, title: &str, quantity: &str) -> Option<String> {
    // The bands of a road follow each other from 200 Hz on.
    let on = |road: NamedTexture| {
        let rows = rows.iter().filter(move |row| row.group == group && row.road == Some(road));
        rows.enumerate().map(|(place, row)| (ThirdOctaveBand(place as i32 - 7).mid_frequency(), row))
    };
    let computed = |road| on(road).filter_map(|(frequency, row)| Some((frequency, row.computed?))).collect();
    let series = FLEET_ROADS.map(|road| Series { name: road.name(), points: computed(road) });
    let series: Vec<Series<'_>> = series.into_iter().filter(|series| !series.points.is_empty()).collect();
    if series.is_empty() {
        return None;
    }
    let range: Vec<(f64, [f64; 2])> = on(FLEET_ROADS[0]).map(|(frequency, row)| (frequency, row.range)).collect();
    let found = series.iter().flat_map(|series| series.points.iter().map(|point| point.1));
    let levels = found.chain(range.iter().flat_map(|point| point.1)).collect::<Vec<_>>();
    let y = Axis::linear_around(quantity, levels);
    let x = Axis::logarithmic_around("Frequency [Hz]", range.iter().map(|point| point.0), [0.9, 1.1]);
    Some(LinePlot { title, x, y, series }.to_svg_over("published range", &range))
}

/// Picture of the levels of one tyre; `None` if none was computed.
fn levels_picture(levels: &[TyreLevels]) -> Option<String> {
    let frequencies = || published_bands().map(ThirdOctaveBand::mid_frequency);
    let series = |of: &TyreLevels| {
        let points = frequencies().zip(&of.levels).filter_map(|(frequency, level)| Some((frequency, (*level)?)));
        (of.is_computed, of.name.clone(), points.collect::<Vec<_>>())
    };
    let drawn = levels.iter().map(series).filter(|(_, _, points)| !points.is_empty()).collect::<Vec<_>>();
    let was_computed = drawn.iter().any(|(is_computed, ..)| *is_computed);
    let series = drawn.iter().map(|(_, name, points)| Series { name, points: points.clone() }).collect();
    was_computed.then(|| plot("One tyre at 7.5 m, 80 km/h", "Level [dB(A)]", "Frequency [Hz]", series))
}

/// Picture of the coast-by levels on all roads at 80 km/h; `None` without such a run.
fn roads(measured: &Measured) -> Option<String> {
    let of_speed = measured.runs.iter().filter(|run| (run.speed_kmh - PUBLISHED_SPEEDS[1]).abs() < 1e-9);
    let series: Vec<Series<'_>> = of_speed
        .map(|run| {
            let bands = run.coast_by_bands.iter().filter(|(band, _)| **band >= -10);
            let points = bands.map(|(band, level)| (ThirdOctaveBand(*band).mid_frequency(), *level)).collect();
            Series { name: run.texture.name(), points }
        })
        .collect();
    if series.iter().all(|series| series.points.is_empty()) {
        return None;
    }
    Some(plot("Coast-by on the named roads, 80 km/h", "Level [dB(A)]", "Frequency [Hz]", series))
}

fn textures() -> String {
    let series = NamedTexture::ALL.map(|texture| {
        let points = texture.levels().map(|(band, level)| (1e3 * 10.0_f64.powf(0.1 * f64::from(band)), level));
        Series { name: texture.name(), points: points.collect() }
    });
    plot("Textures by name", "Texture level [dB re 1e-6 m]", "Texture wavelength [mm]", series.into())
}

fn plot(title: &str, quantity: &str, across: &str, series: Vec<Series<'_>>) -> String {
    let points = || series.iter().flat_map(|series| &series.points);
    let (x, y) = (points().map(|point| point.0).collect::<Vec<_>>(), points().map(|point| point.1).collect::<Vec<_>>());
    let x = Axis::logarithmic_around(across, x, [0.9, 1.1]);
    LinePlot { title, x, y: Axis::linear_around(quantity, y), series }.to_svg()
}

/// Self-contained HTML page of a validation.
pub(crate) fn page(
    title: &str,
    rows: &[ValidationRow],
    levels: &[TyreLevels],
    pictures: &[(&'static str, String, String)],
) -> String {
    let mut sources: Vec<(&str, &str, &str)> = Vec::new();
    for row in rows {
        let source = (row.source.as_str(), row.spread.as_str(), row.group.title());
        if !sources.iter().any(|(known, spread, _)| (*known, *spread) == (source.0, source.1)) {
            sources.push(source);
        }
    }
    let sources = words(["of", "source", "spread"], sources.iter().map(|(source, spread, of)| [*of, *source, *spread]));
    let roads = words(
        ["road", "mean profile depth [mm]", "origin"],
        NamedTexture::ALL.map(|texture| {
            let [depth, within] = texture.depth();
            let depth = format!("{} +- {}", four_digits(1e3 * depth), four_digits(1e3 * within));
            [texture.name().to_owned(), depth, texture.origin().to_owned()]
        }),
    );
    let frequencies = published_bands().map(|band| format!("{} Hz", band.nominal_frequency()));
    let cell = |level: Option<f64>| level.map_or_else(|| "-".to_owned(), value);
    let line = |of: &TyreLevels| std::iter::once(of.name.clone()).chain(of.levels.iter().copied().map(cell)).collect();
    let levels = aligned(
        std::iter::once("dB(A) at the coast-by microphone".to_owned()).chain(frequencies),
        levels.iter().map(line).collect::<Vec<Vec<String>>>(),
    );
    let lead = html! { p { "Compared with published values. " (LEGEND) } };
    let sections = [
        ("Groups", table(&groups(rows))),
        ("Pictures", html! { @for (_, svg, caption) in pictures { (figure(svg, caption)) } }),
        ("All rows", table(&whole(rows))),
        ("Levels of one tyre at 80 km/h", table(&levels)),
        ("Sources", table(&sources)),
        ("Roads", table(&roads)),
    ];
    let content = article(0, title, &lead, sections.map(|(heading, content)| (heading.to_owned(), content)));
    document(title, &content)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::response::BandLevel;
    use crate::results::pass_by::PassBySummary;
    use crate::study::validation::{Lacks, Published, StandingTyre, levels_of_one_tyre, rows};

    fn nothing() -> Measured {
        let lacks = Lacks { sidewalls: true, cells: true };
        Measured { tyre: StandingTyre::default(), runs: Vec::new(), cases: Vec::new(), load: 3400.0, lacks }
    }

    #[test]
    fn tables_and_page_show_unknown_values_and_every_source() {
        let measured = nothing();
        let rows = rows(&measured, &Published::embedded());
        let report = report("A tyre", &rows).to_string();
        assert!(report.contains("not computed") && report.contains("stiffness at 350 kg"), "{report}");
        let record = record("A tyre", &rows, &measured);
        assert_eq!(record["rows"].as_array().unwrap().len(), rows.len());
        assert!(record["rows"][0]["computed"].is_null() && record["rows"][0]["outside"].is_null());
        let levels = levels_of_one_tyre(&measured, &Published::embedded());
        let pictures = pictures(&rows, &measured, &levels);
        // Without runs only the textures have a picture.
        assert_eq!(pictures.iter().map(|picture| picture.0).collect::<Vec<_>>(), ["textures.svg"]);
        let page = page("A tyre", &rows, &levels, &pictures);
        // Every published set stands in the page, of one tyre: Harmonoise and Nord2000 at 500 Hz.
        assert!(page.contains(">48.4<") && page.contains(">53.7<"));
        for source in ["NCHRP 630", "Nord2000", "748A", "captif", "10844"] {
            assert!(page.contains(source), "{source}");
        }
    }

    #[test]
    fn a_level_of_few_bands_is_a_bound_in_every_count() {
        let band = |n: i32| BandLevel { band: ThirdOctaveBand(n), mean_square: 1.0, level: 50.0, valid: true };
        let level = |error| Some(TotalLevel { error, ..TotalLevel::of((-16..=-11).map(band).collect()).unwrap() });
        let mut measured = nothing();
        measured.runs.push(ValidationRun {
            texture: NamedTexture::DenseAsphalt11,
            speed_kmh: 80.0,
            coast_by: level(Some(0.4)),
            band_errors: Default::default(),
            pass_by: Some(PassBySummary::new(String::new(), &[50.0], 1, 0.9)),
            cpx: level(None),
            coast_by_bands: BTreeMap::new(),
            cpx_bands: BTreeMap::new(),
            rolling_resistance: None,
        });
        let rows = rows(&measured, &Published::embedded());
        let reported = report("A tyre", &rows).to_string();
        assert!(reported.contains("at least 57.8") && reported.contains("1 only a bound, "), "{reported}");
        assert!(markdown(&rows).contains("1 only a bound, "));
        let run = &record("A tyre", &rows, &measured)["runs"][0];
        assert_eq!((&run["coast_by_range_hz"], &run["coast_by_lower_bound"]), (&json!([25.0, 80.0]), &json!(true)));
        assert_eq!((&run["coast_by_error"], &run["cpx_error"]), (&json!(0.4), &Value::Null));
        assert_eq!((&run["coast_by_passages"], &run["coast_by_standard_error"]), (&json!(1), &Value::Null));
        assert!(run["coast_by"].is_number() && run["cpx_range_hz"].is_array());
    }

    #[test]
    fn the_section_has_a_column_for_every_band() {
        let mut rows = rows(&nothing(), &Published::embedded());
        for row in rows.iter_mut().filter(|row| row.group == Group::Shape80) {
            row.computed = Some(row.range[1] + 2.0);
            row.road_spread = Some([-3.0, 1.0]);
        }
        let uncertain = markdown(&rows);
        assert!(uncertain.contains("| third octaves, 80 km/h | 22 cannot be told | - |"), "{uncertain}");
        assert!(uncertain.contains("| outside, dB | ? |") && uncertain.lines().all(|line| line.chars().count() <= 120));
        rows.iter_mut().for_each(|row| row.road_spread = None);
        let text = markdown(&rows);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!([lines[0], lines[lines.len() - 1]], MARKERS);
        assert!(text.contains("| third octaves, 80 km/h | 0 of 22 |") && text.contains("+2.0 dB |"), "{text}");
        let of_bands = lines.iter().filter(|line| line.matches('|').count() == 13).count();
        assert_eq!(of_bands, 8, "{text}");
        assert!(lines.iter().all(|line| line.chars().count() <= 120), "{text}");
    }
}
