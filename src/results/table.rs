//! Tables as text: aligned for the terminal, comma-separated for files.

use std::path::Path;

use comfy_table::{Cell, CellAlignment, LineStyle, Table, TableStyle};

use super::error::ResultsError;

/// A table with a line under its header, words in the first column to the left, numbers in the others to the right; a
/// newline last.
pub fn aligned<R: AsRef<[String]>>(header: &[impl AsRef<str>], rows: &[R]) -> String {
    table(header, rows, |column| if column == 0 { CellAlignment::Left } else { CellAlignment::Right })
}

/// As [`aligned`], all columns being numbers.
pub fn numbers<R: AsRef<[String]>>(header: &[impl AsRef<str>], rows: &[R]) -> String {
    table(header, rows, |_| CellAlignment::Right)
}

/// As [`aligned`], all columns being words.
pub fn words<R: AsRef<[String]>>(header: &[impl AsRef<str>], rows: &[R]) -> String {
    table(header, rows, |_| CellAlignment::Left)
}

/// Columns of the same number in header and rows; without a header only rows.
fn table<R: AsRef<[String]>>(
    header: &[impl AsRef<str>],
    rows: &[R],
    alignment: impl Fn(usize) -> CellAlignment,
) -> String {
    let cell = |(column, text): (usize, &str)| Cell::new(text).set_alignment(alignment(column));
    let mut table = Table::new();
    table.load_style(TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─')));
    if !header.is_empty() {
        table.set_header(header.iter().map(AsRef::as_ref).enumerate().map(cell));
    }
    for row in rows {
        table.add_row(row.as_ref().iter().map(String::as_str).enumerate().map(cell).collect::<Vec<_>>());
    }
    table.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

/// Comma-separated values with a header. Numbers written by `to_string` come back with the same bits.
///
/// # Errors
/// [`ResultsError::Write`] naming `path`, where it is going to be.
pub fn comma_separated<R: IntoIterator<Item = String>>(
    header: &[&str],
    rows: impl IntoIterator<Item = R>,
    path: &Path,
) -> Result<String, ResultsError> {
    let failed = |error: csv::Error| ResultsError::writing(path)(error.into());
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header).map_err(failed)?;
    for row in rows {
        writer.write_record(row).map_err(failed)?;
    }
    let bytes = writer.into_inner().map_err(|error| ResultsError::writing(path)(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// A number with thin groups of three: 21 233 664.
pub fn grouped(number: u64) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

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
        let text = aligned(&["stage", "calls"], &[["road".into(), "7".into()], ["history".into(), "1 000".into()]]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 4, "{text}");
        assert!(lines[2].ends_with('7') && lines[3].ends_with("1 000"), "{text}");
        assert_eq!(lines[2].chars().count(), lines[3].chars().count(), "{text}");
    }
}
