//! Tables, and reports of text and tables: for files at their full width, for a terminal within its width. Tables of a
//! results folder are read column by column.

use std::fmt;
use std::ops::Range;

use comfy_table::{Cell, CellAlignment, ColumnConstraint, ContentArrangement, LineStyle, TableStyle, Width};
use serde_json::{Value, json};

/// Spaces beside a cell's content, and between two columns.
const PADDING: usize = 2;
const GAP: usize = 1;

/// Cells of a row, from the left, of any displayable type.
pub(crate) trait Cells {
    /// Their texts. Numbers are written so that reading gives the same bits; where there is none (the level of silence,
    /// the mean of nothing) the cell is empty.
    fn texts(self) -> Vec<String>;
}

impl<R: IntoIterator<Item: ToString>> Cells for R {
    fn texts(self) -> Vec<String> {
        let text = |cell: R::Item| Some(cell.to_string()).filter(|text| !NO_NUMBERS.contains(&text.trim()));
        self.into_iter().map(|cell| text(cell).unwrap_or_default()).collect()
    }
}

/// Texts of values that are not finite.
const NO_NUMBERS: [&str; 3] = ["-inf", "inf", "NaN"];

/// A row of cells of several types.
pub(crate) fn row<const COUNT: usize>(cells: [&dyn fmt::Display; COUNT]) -> Vec<String> {
    cells.texts()
}

/// Text of a cell, empty for `None`.
pub(crate) fn optional(cell: Option<impl ToString>) -> String {
    cell.map_or_else(String::new, |cell| cell.to_string())
}

/// A table with a line under its header.
#[derive(Clone, Debug)]
pub struct TextTable {
    /// Names of the columns; empty without a header.
    pub header: Vec<String>,
    /// Rows, each with a cell for every column.
    pub rows: Vec<Vec<String>>,
    alignment: fn(usize) -> CellAlignment,
}

/// Table with words in the first column to the left, numbers in the others to the right.
pub(crate) fn aligned(header: impl Cells, rows: impl IntoIterator<Item: Cells>) -> TextTable {
    TextTable::new(header, rows, |column| if column == 0 { CellAlignment::Left } else { CellAlignment::Right })
}

/// Table as [`aligned`], all columns being numbers.
pub(crate) fn numbers(header: impl Cells, rows: impl IntoIterator<Item: Cells>) -> TextTable {
    TextTable::new(header, rows, |_| CellAlignment::Right)
}

/// Table as [`aligned`], all columns being words.
pub(crate) fn words(header: impl Cells, rows: impl IntoIterator<Item: Cells>) -> TextTable {
    TextTable::new(header, rows, |_| CellAlignment::Left)
}

impl TextTable {
    /// Header and rows must have the same number of columns; an empty header means rows alone.
    fn new(header: impl Cells, rows: impl IntoIterator<Item: Cells>, alignment: fn(usize) -> CellAlignment) -> Self {
        Self { header: header.texts(), rows: rows.into_iter().map(Cells::texts).collect(), alignment }
    }

    /// True for a column of numbers, which are aligned to the right.
    pub fn is_number(&self, column: usize) -> bool {
        (self.alignment)(column) == CellAlignment::Right
    }

    /// The table for a terminal of `width` columns: long cells are wrapped between words, and within words longer than
    /// half of it; columns that do not fit follow in further tables below, each with the first column again.
    pub fn within(&self, width: usize) -> String {
        let cells = |column: usize| {
            self.header.iter().skip(column).take(1).chain(self.rows.iter().map(move |row| &row[column]))
        };
        let widest = |column: usize| {
            let words = cells(column).flat_map(|cell| cell.split_whitespace());
            // A word of more than half the width, such as a hash, is broken where there is no room for it.
            words.map(|word| word.chars().count()).max().unwrap_or(0).min(width / 2) + PADDING
        };
        let count = self.rows.first().map_or(self.header.len(), Vec::len);
        let (mut parts, mut used) = (vec![vec![]], 0);
        for column in 0..count {
            if used + widest(column) > width && parts[parts.len() - 1].len() > 1 {
                parts.push(vec![0]);
                used = widest(0) + GAP;
            }
            used += widest(column) + GAP;
            let last = parts.len() - 1;
            parts[last].push(column);
        }
        let text = |columns: &Vec<usize>| {
            let mut table = self.drawn(columns);
            table.set_content_arrangement(ContentArrangement::Dynamic).set_width(width as u16);
            let least =
                columns.iter().map(|&column| ColumnConstraint::LowerBoundary(Width::Fixed(widest(column) as u16)));
            table.set_constraints(least);
            trimmed(&table)
        };
        parts.iter().map(text).collect::<Vec<_>>().join("\n")
    }

    fn drawn(&self, columns: &[usize]) -> comfy_table::Table {
        let row = |cells: &Vec<String>| -> Vec<Cell> {
            columns.iter().map(|&column| Cell::new(&cells[column]).set_alignment((self.alignment)(column))).collect()
        };
        let mut table = comfy_table::Table::new();
        table.load_style(TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─')));
        if !self.header.is_empty() {
            table.set_header(row(&self.header));
        }
        table.add_rows(self.rows.iter().map(row));
        table
    }
}

/// A line wrapped to a width; a longer word has a separate line.
fn wrapped(line: &str, width: usize) -> String {
    if line.trim_end().chars().count() <= width {
        return line.to_owned();
    }
    let (mut text, mut used) = (String::new(), 0);
    for word in line.split_inclusive(' ') {
        let length = word.trim_end().chars().count();
        if used > 0 && used + length > width {
            text.truncate(text.trim_end_matches(' ').len());
            text.push('\n');
            used = 0;
        }
        text.push_str(word);
        used += word.chars().count();
    }
    text
}

/// Lines without trailing spaces, a newline last.
fn trimmed(table: &comfy_table::Table) -> String {
    table.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

/// At full width.
impl fmt::Display for TextTable {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.rows.first().map_or(self.header.len(), Vec::len);
        formatter.write_str(&trimmed(&self.drawn(&(0..count).collect::<Vec<_>>())))
    }
}

/// Text and tables in their order; displayed at full width.
#[derive(Clone, Debug, Default)]
pub struct Report(Vec<ReportPart>);

/// Part of a report.
#[derive(Clone, Debug)]
pub enum ReportPart {
    /// Lines of text.
    Text(String),
    /// A table of any width.
    Table(TextTable),
}

impl From<TextTable> for Report {
    fn from(table: TextTable) -> Self {
        Self(vec![ReportPart::Table(table)])
    }
}

impl Report {
    /// Adds lines as they are.
    pub fn text(&mut self, text: impl Into<String>) {
        self.0.push(ReportPart::Text(text.into()));
    }

    /// Adds a table after the parts so far.
    pub fn table(&mut self, table: TextTable) {
        self.0.push(ReportPart::Table(table));
    }

    /// Adds lines, and a table under them.
    pub fn titled(&mut self, text: impl Into<String>, table: TextTable) {
        self.text(text);
        self.table(table);
    }

    /// Adds all parts of another report.
    pub fn append(&mut self, other: Self) {
        self.0.extend(other.0);
    }

    /// Parts in their order.
    pub fn parts(&self) -> &[ReportPart] {
        &self.0
    }

    /// The report as JSON: texts, and tables as columns and rows; cells that are numbers become numbers.
    pub fn to_json(&self) -> Value {
        let cell = |cell: &String| match serde_json::from_str(cell) {
            Ok(number @ Value::Number(_)) => number,
            _ => Value::from(cell.trim()),
        };
        let part = |part: &ReportPart| match part {
            ReportPart::Text(text) => json!({ "text": text.trim() }),
            ReportPart::Table(table) => {
                let rows: Vec<Vec<Value>> = table.rows.iter().map(|row| row.iter().map(cell).collect()).collect();
                json!({ "columns": table.header, "rows": rows })
            }
        };
        let empty = |part: &&ReportPart| matches!(part, ReportPart::Text(text) if text.trim().is_empty());
        self.0.iter().filter(|part| !empty(part)).map(part).collect()
    }

    /// The report for a terminal of `width` columns: lines are wrapped between words, for tables see
    /// [`TextTable::within`].
    pub fn within(&self, width: usize) -> String {
        let part = |part: &ReportPart| match part {
            ReportPart::Text(text) => text.split_inclusive('\n').map(|line| wrapped(line, width)).collect(),
            ReportPart::Table(table) => table.within(width),
        };
        self.0.iter().map(part).collect()
    }
}

impl fmt::Display for Report {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|part| match part {
            ReportPart::Text(text) => formatter.write_str(text),
            ReportPart::Table(table) => table.fmt(formatter),
        })
    }
}

/// Header and rows as CSV; cells are quoted where they need it, and a space is put before words that spreadsheets would
/// take for a formula.
pub(crate) fn csv(header: impl Cells, rows: impl IntoIterator<Item: Cells>) -> String {
    csv_rows(std::iter::once(header.texts()).chain(rows.into_iter().map(Cells::texts)))
}

/// Rows as CSV, as [`csv`] writes them, without a header.
pub(crate) fn csv_rows(rows: impl IntoIterator<Item: Cells>) -> String {
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
    let harmless = |cell: String| {
        let formula = cell.starts_with(['=', '+', '-', '@']) && cell.len() > 1 && cell.parse::<f64>().is_err();
        if formula { format!(" {cell}") } else { cell }
    };
    let mut lines = rows.into_iter().map(|line| line.texts().into_iter().map(harmless).collect::<Vec<_>>());
    // Writing to memory does not fail, and text is UTF-8.
    let written = lines.try_for_each(|line| writer.write_record(line));
    written.ok().and_then(|()| String::from_utf8(writer.into_inner().ok()?).ok()).unwrap_or_default()
}

/// A number with groups of three digits: 21 233 664.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> = (0..digits.len())
        .filter(|position| *position == 0 || (digits.len() - position).is_multiple_of(3))
        .map(|position| {
            let end = position + if position == 0 { (digits.len() - 1) % 3 + 1 } else { 3 };
            &digits[position..end]
        })
        .collect();
    groups.join(" ")
}

/// Columns of names that the user has given: read as words even where they look like numbers.
const NAMES: [&str; 3] = ["receiver", "field", "frame"];

/// Cells of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum StoredColumn {
    /// Numbers; an empty cell is NaN.
    Numbers(Vec<f64>),
    /// Words.
    Words(Vec<String>),
}

/// Columns of a CSV file, by name.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredTable {
    /// Names and cells of the columns, from the left.
    pub columns: Vec<(String, StoredColumn)>,
}

impl StoredTable {
    /// Reads the text of a file of comma-separated values.
    ///
    /// # Errors
    /// Rows of different lengths.
    pub fn parse(text: &str) -> Result<Self, csv::Error> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let names: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
        let mut cells = vec![Vec::new(); names.len()];
        for record in reader.records() {
            for (cells, cell) in cells.iter_mut().zip(&record?) {
                cells.push(cell.to_owned());
            }
        }
        let columns = names.into_iter().zip(cells).map(|(name, cells)| {
            let number = |cell: &String| if cell.is_empty() { Some(f64::NAN) } else { cell.parse().ok() };
            let numbers: Option<Vec<f64>> = cells.iter().map(number).collect();
            let column = match numbers.filter(|_| !NAMES.contains(&name.as_str())) {
                Some(numbers) => StoredColumn::Numbers(numbers),
                None => StoredColumn::Words(cells),
            };
            (name, column)
        });
        Ok(Self { columns: columns.collect() })
    }

    /// A column of numbers; `None` if there is none of that name.
    pub fn numbers(&self, wanted: &str) -> Option<&[f64]> {
        self.columns.iter().find_map(|(name, column)| match column {
            StoredColumn::Numbers(numbers) if name == wanted => Some(&numbers[..]),
            _ => None,
        })
    }

    /// Name and rows of each signal, whose rows follow each other; the name consists of the cells before the first
    /// column of frequencies.
    pub(crate) fn signals(&self) -> Vec<(String, Range<usize>)> {
        let before = self.columns.iter().take_while(|(name, _)| !name.ends_with("_hz"));
        let before: Vec<&StoredColumn> = before.map(|(_, column)| column).collect();
        let rows = self.columns.first().map_or(0, |(_, column)| match column {
            StoredColumn::Numbers(numbers) => numbers.len(),
            StoredColumn::Words(words) => words.len(),
        });
        let mut signals: Vec<(String, Range<usize>)> = Vec::new();
        for row in 0..rows {
            let cells = before.iter().filter_map(|column| match column {
                StoredColumn::Numbers(numbers) => {
                    Some(numbers[row]).filter(|number| !number.is_nan()).map(|n| n.to_string())
                }
                StoredColumn::Words(words) => Some(words[row].clone()).filter(|word| !word.is_empty()),
            });
            let name = cells.collect::<Vec<_>>().join(", ");
            match signals.last_mut() {
                Some((last, rows)) if *last == name => rows.end = row + 1,
                _ => signals.push((name, row..row + 1)),
            }
        }
        signals
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_an_empty_cell() {
        let levels = [[1.5, f64::NEG_INFINITY, f64::NAN], [f64::INFINITY, -0.0, 2.0]];
        assert_eq!(csv(["a", "b", "c"], levels), "a,b,c\n1.5,,\n,-0,2\n");
        let shown = numbers(["level"], [[format!("{:8.1}", f64::NEG_INFINITY)]]);
        assert!(!shown.within(80).contains("inf"), "{}", shown.within(80));
    }

    #[test]
    fn thousands_are_grouped() {
        let cases = [
            (0, "0"),
            (12, "12"),
            (999, "999"),
            (1000, "1 000"),
            (21_233_664, "21 233 664"),
            (u64::MAX, "18 446 744 073 709 551 615"),
        ];
        for (number, text) in cases {
            assert_eq!(grouped(number), text);
        }
    }

    #[test]
    fn columns_line_up() {
        let table = aligned(["stage", "calls"], [["road", "7"], ["history", "1 000"]]);
        let text = table.to_string();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 4, "{text}");
        assert!(lines[2].ends_with('7') && lines[3].ends_with("1 000"), "{text}");
        assert_eq!(lines[2].chars().count(), lines[3].chars().count(), "{text}");
    }
    #[test]
    fn tables_fit_a_terminal_and_lose_nothing() {
        let header: Vec<String> =
            ["what", "why"].into_iter().map(str::to_owned).chain((0..30).map(|n| format!("{n} km/h"))).collect();
        let row = |name: &str| -> Vec<String> {
            let reason = "a long reason for it, in many words that wrap".to_owned();
            [name.to_owned(), reason].into_iter().chain((0..30).map(|n| format!("{n}.25"))).collect()
        };
        let table = aligned(&header, &[row("one thing"), row("another")]);
        for width in [40, 80, 120] {
            let text = table.within(width);
            assert!(text.lines().all(|line| line.chars().count() <= width), "{text}");
            let words: Vec<&str> = text.split_whitespace().collect();
            assert!((0..30).all(|n| words.iter().filter(|word| **word == format!("{n}.25")).count() == 2), "{text}");
        }
        assert_eq!(table.within(1000), table.to_string());
        let hash = "4223876399".repeat(6);
        let cache = aligned(["entry", "kB"], [[format!("{hash}.waves"), "2566.0".to_owned()]]);
        for width in [40, 60] {
            let text = cache.within(width);
            assert!(text.lines().all(|line| line.chars().count() <= width) && text.contains("2566.0"), "{text}");
        }
        assert!(cache.within(80).contains(&hash), "whole where there is room");
        let mut report = Report::default();
        report.text("title\n");
        report.table(table.clone());
        assert_eq!(report.to_string(), format!("title\n{table}"));
        let mut report = Report::default();
        report.text("  some words in a row\n\nand awordthatislong there");
        assert_eq!(report.within(10), "  some\nwords in a\nrow\n\nand\nawordthatislong\nthere");
    }

    #[test]
    fn reports_are_json_with_numbers_as_numbers() {
        let mut report = Report::default();
        report.text("title\n\n");
        report.text("\n");
        report.table(aligned(["what", "so much"], [["a", "1.50"], ["b", "-"]]));
        let expected = json!([
            { "text": "title" },
            { "columns": ["what", "so much"], "rows": [["a", 1.5], ["b", "-"]] },
        ]);
        assert_eq!(report.to_json(), expected);
    }

    #[test]
    fn cells_of_csv_are_no_formulas() {
        let rows = [["=1+1", "@sum(a1)"], ["-1.5", "-2*3"], ["+1", "-"]];
        assert_eq!(csv(["=a", "b"], rows), " =a,b\n =1+1, @sum(a1)\n-1.5, -2*3\n+1,-\n");
    }

    #[test]
    fn cells_of_csv_are_quoted_where_they_need_it() {
        assert_eq!(csv(["a", "b"], [["1,5", "say \"x\""]]), "a,b\n\"1,5\",\"say \"\"x\"\"\"\n");
    }

    #[test]
    fn columns_have_kinds_and_signals_their_rows() {
        let text = "receiver,position_m,nominal_hz,level\n7,0.5,100,50\n7,0.5,125,\n8,,100,-1e3\n";
        let table = StoredTable::parse(text).unwrap();
        assert_eq!(table.columns[0].1, StoredColumn::Words(["7", "7", "8"].map(str::to_owned).to_vec()));
        assert_eq!(table.numbers("nominal_hz").unwrap(), [100.0, 125.0, 100.0]);
        let level = table.numbers("level").unwrap();
        assert!(level[1].is_nan() && level[2].to_bits() == (-1e3_f64).to_bits());
        assert_eq!(table.signals(), [("7, 0.5".to_owned(), 0..2), ("8".to_owned(), 2..3)]);
        assert!(table.numbers("receiver").is_none() && StoredTable::parse("a,b\n1\n").is_err());
    }
}
