//! Tables that people wrote or a program exported: one record a line, cells separated by commas, semicolons, tabs or
//! blanks, in UTF-8, UTF-16 or Latin-1, with decimal points or commas.

use std::borrow::Cow;

/// The delimiter is found from so many lines.
const SAMPLE: usize = 1000;

/// Marks that begin a comment line.
const COMMENTS: [&str; 3] = ["#", "%", "//"];

/// Text of a table, with its delimiter and decimal sign.
#[derive(Debug)]
pub(crate) struct SeparatedTable<'a> {
    text: Cow<'a, str>,
    style: Style,
}

/// A delimiter, `None` for any run of blanks, and whether decimals follow a comma.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Style {
    delimiter: Option<char>,
    decimal_comma: bool,
}

/// A line of a table, counted from 1, and its cells, trimmed and without their quotes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Record<'a> {
    pub(crate) line: u64,
    pub(crate) cells: Vec<&'a str>,
}

impl Record<'_> {
    /// Returns the number of cells up to the last that is not empty.
    pub(crate) fn filled(&self) -> usize {
        self.cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1)
    }
}

/// Returns the text of a file: UTF-16 with or without a byte order mark, UTF-8, else Latin-1. The mark that DOS puts at
/// the end is none of it.
pub(crate) fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.as_chunks::<2>().0.iter().map(|&pair| unit(pair)).collect();
        Cow::Owned(String::from_utf16_lossy(&units))
    };
    let text = match bytes {
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        // In UTF-16, letters of Latin-1 have one byte that is zero.
        [1..=255, 0, 1..=255, 0, ..] => wide(bytes, u16::from_le_bytes),
        [0, 1..=255, 0, 1..=255, ..] => wide(bytes, u16::from_be_bytes),
        _ => {
            let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            match std::str::from_utf8(bytes) {
                Ok(text) => Cow::Borrowed(text),
                Err(_) => Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()),
            }
        }
    };
    let length = text.trim_end_matches('\u{1a}').len();
    let text = match text {
        Cow::Borrowed(text) => Cow::Borrowed(&text[..length]),
        Cow::Owned(mut text) => {
            text.truncate(length);
            Cow::Owned(text)
        }
    };
    // Lines that end with CR alone.
    if text.contains('\r') && !text.contains('\n') { Cow::Owned(text.replace('\r', "\n")) } else { text }
}

impl<'a> SeparatedTable<'a> {
    /// Reads a file's bytes as a table. A first line `sep=;` states the delimiter; otherwise delimiter and decimal sign
    /// are those by which most lines consist of numbers.
    pub(crate) fn of(bytes: &'a [u8]) -> Self {
        let text = decoded(bytes);
        let style = style_of(&text);
        Self { text, style }
    }

    /// All records, including titles and lines before them; blank lines and comments are left out.
    pub(crate) fn records(&self) -> impl Iterator<Item = Record<'_>> {
        let record = |(line, text)| Record { line, cells: self.style.cells(text) };
        lines(&self.text).map(record).filter(|record| record.cells.iter().any(|cell| !cell.is_empty()))
    }

    /// A line, counted from 1, as it stands in the file; empty if there is none.
    pub(crate) fn line(&self, line: u64) -> &str {
        self.text.lines().nth(line.saturating_sub(1) as usize).unwrap_or_default()
    }

    /// Comment lines before a line, with their numbers and without their marks, the nearest first.
    pub(crate) fn comments_before(&self, line: u64) -> impl Iterator<Item = (u64, &str)> {
        let before: Vec<(u64, &str)> = (1..line).zip(self.text.lines()).collect();
        before.into_iter().rev().filter_map(|(line, text)| {
            let mark = COMMENTS.iter().find(|&&mark| text.trim_start().starts_with(mark))?;
            Some((line, text.trim_start().trim_start_matches(mark).trim()))
        })
    }

    /// The finite number in a cell; a Fortran exponent (1.0D-3) and a typographic minus are understood.
    pub(crate) fn number(&self, cell: &str) -> Option<f64> {
        number(cell, self.style.decimal_comma)
    }

    pub(crate) fn is_parted_by_commas(&self) -> bool {
        self.style.delimiter == Some(',')
    }

    /// True if blanks part the cells: one that is missing leaves no trace.
    pub(crate) fn is_parted_by_blanks(&self) -> bool {
        self.style.delimiter.is_none()
    }

    /// Returns the first number whose comma may part thousands as well as decimals, and its line, where all numbers
    /// with a comma are of this kind.
    pub(crate) fn ambiguous_comma(&self) -> Option<(u64, &str)> {
        if !self.style.decimal_comma {
            return None;
        }
        let cells = self.records().flat_map(|record| {
            let line = record.line;
            record.cells.into_iter().map(move |cell| (line, cell))
        });
        let mut numbers = cells.filter(|(_, cell)| cell.contains(',') && self.number(cell).is_some());
        let first = numbers.next().filter(|(_, cell)| may_part_thousands(cell))?;
        numbers.all(|(_, cell)| may_part_thousands(cell)).then_some(first)
    }

    /// True if the text holds signs that no table has: it is something else.
    pub(crate) fn is_binary(&self) -> bool {
        let odd = |sign: char| sign.is_control() && !sign.is_whitespace() && sign != '\u{1a}';
        self.text.chars().take(4096).any(odd)
    }
}

/// Cells of a line by each delimiter that could separate its words: titles may be separated otherwise than numbers.
pub(crate) fn words(line: &str) -> impl Iterator<Item = Vec<&str>> {
    [Some(';'), Some('\t'), Some(','), None]
        .map(|delimiter| Style { delimiter, decimal_comma: false }.cells(line))
        .into_iter()
}

/// The number in a word, with a decimal point or comma.
pub(crate) fn any_number(word: &str) -> Option<f64> {
    number(word, false).or_else(|| number(word, true))
}

fn number(cell: &str, decimal_comma: bool) -> Option<f64> {
    // Words that Rust parses as numbers, such as "inf" and "nan", are not numbers here.
    let begins = cell.starts_with(|sign: char| sign.is_ascii_digit() || "+-.,\u{2212}".contains(sign));
    if !begins || cell.contains(if decimal_comma { '.' } else { ',' }) || cell.ends_with(',') {
        return None;
    }
    let parsed = if cell.contains([',', '\u{2212}', 'd', 'D']) {
        cell.replace(',', ".").replace('\u{2212}', "-").replace(['d', 'D'], "e").parse()
    } else {
        cell.parse::<f64>()
    };
    parsed.ok().filter(|number| number.is_finite())
}

/// True if the comma of a number may part thousands: three digits follow it, and no zero begins.
fn may_part_thousands(number: &str) -> bool {
    let digits = number.trim_start_matches(['+', '-', '\u{2212}']);
    digits.split_once(',').is_some_and(|(before, after)| {
        (1..=3).contains(&before.len())
            && !before.starts_with('0')
            && after.len() == 3
            && after.bytes().all(|sign| sign.is_ascii_digit())
    })
}

/// Returns the lines that are neither blank nor comments, with their numbers.
fn lines(text: &str) -> impl Iterator<Item = (u64, &str)> {
    let is_left_out = |line: &str| {
        let line = line.trim();
        line.is_empty() || COMMENTS.iter().any(|mark| line.starts_with(mark)) || separator(line).is_some()
    };
    (1..).zip(text.lines()).filter(move |(_, line)| !is_left_out(line))
}

/// The delimiter stated by a line `sep=;`.
fn separator(line: &str) -> Option<char> {
    let line = line.trim_matches('"');
    let stated = line.get(..4).filter(|begin| begin.eq_ignore_ascii_case("sep=")).map(|_| &line[4..])?;
    let mut signs = stated.chars();
    signs.next().filter(|sign| !sign.is_alphanumeric() && signs.next().is_none())
}

/// Delimiter and decimal sign by which most of the first lines consist of numbers; ties go to the earlier candidate.
fn style_of(text: &str) -> Style {
    let stated = text.lines().find(|line| !line.trim().is_empty()).and_then(separator);
    let delimiters = match stated {
        Some(sign) => vec![Some(sign).filter(|sign| *sign != ' ')],
        None => vec![Some(';'), Some('\t'), Some(','), None],
    };
    let styles =
        delimiters.iter().flat_map(|&delimiter| [false, true].map(|decimal_comma| Style { delimiter, decimal_comma }));
    let sample: Vec<&str> = lines(text).map(|(_, line)| line).take(SAMPLE).collect();
    // Compared in this order: lines of two or more numbers only; lines with two or more numbers; cells of the first
    // line.
    let score = |style: &Style| {
        let (mut pure, mut mixed) = (0, 0);
        for line in &sample {
            let cells = style.cells(line);
            let full = cells.iter().filter(|cell| !cell.is_empty()).count();
            let numbers = cells.iter().filter(|cell| number(cell, style.decimal_comma).is_some()).count();
            mixed += usize::from(numbers >= 2);
            pure += usize::from(numbers >= 2 && numbers == full);
        }
        let first = sample.first().filter(|_| style.delimiter.is_some()).map_or(0, |line| style.cells(line).len());
        (pure, mixed, first)
    };
    let mut best = Style { delimiter: delimiters[0], decimal_comma: false };
    let mut highest = score(&best);
    for style in styles.skip(1) {
        let reached = score(&style);
        if reached > highest {
            (best, highest) = (style, reached);
        }
    }
    best
}

impl Style {
    fn cells(self, line: &str) -> Vec<&str> {
        let mut quoted = false;
        let parts = |sign: char| {
            quoted ^= sign == '"';
            !quoted && self.delimiter.map_or(sign.is_whitespace(), |delimiter| sign == delimiter)
        };
        let cells = line.split(parts).map(|cell| cell.trim().trim_matches('"').trim());
        if self.delimiter.is_some() { cells.collect() } else { cells.filter(|cell| !cell.is_empty()).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> Vec<Vec<f64>> {
        let table = SeparatedTable::of(bytes);
        table.records().map(|record| record.cells.iter().filter_map(|cell| table.number(cell)).collect()).collect()
    }

    #[test]
    fn delimiters_and_decimals_are_found_from_the_numbers() {
        for text in [
            "0.5,-1.25\n1,2\n",
            "0.5;-1.25\n1;2\n",
            "0,5;-1,25\n1;2\n",
            "0,5\t-1,25\n1\t2\n",
            "  0.5   -1.25\n 1 2\n",
            "0,5 -1,25\n1,0 2\n",
            "\"0,5\",\"-1,25\"\n1,2\n",
            "sep=;\n0,5;-1,25\n1;2\n",
            "# made by a program, x; y\n0.5, -1.25\n// next\n1, 2\n% end\n",
            "5.0D-1 -1.25d0\r\n1.E0 2.\r\n",
            "0.5,\u{2212}1.25\r1,2\r",
            "0.5,-1.25\n1,2\n\u{1a}",
        ] {
            let wide: Vec<u16> = format!("\u{feff}{text}").encode_utf16().collect();
            let little: Vec<u8> = wide.iter().flat_map(|unit| unit.to_le_bytes()).collect();
            let big: Vec<u8> = wide.iter().flat_map(|unit| unit.to_be_bytes()).collect();
            for bytes in [text.as_bytes(), &little, &big, &little[2..], &big[2..]] {
                assert_eq!(read(bytes), [vec![0.5, -1.25], vec![1.0, 2.0]], "{text:?}");
            }
        }
        assert_eq!(SeparatedTable::of(b"H\xf6he (\xb5m);x\n").records().next().unwrap().cells, ["Höhe (µm)", "x"]);
    }

    #[test]
    fn commas_between_thousands_are_distinguished_from_decimals() {
        for (text, ambiguous) in [
            ("0;4,123\n1;-6,001\n", Some((1, "4,123"))),
            ("x;z\n\"1\";\"800\"\n\"2\";\"1,024\"\n", Some((3, "1,024"))),
            ("0;4,123\n1;0,001\n", None),
            ("0,5;4,123\n1,0;6,001\n", None),
            ("0;1234,123\n1;6,001\n", None),
            ("0;4.123\n1;6.001\n", None),
        ] {
            assert_eq!(SeparatedTable::of(text.as_bytes()).ambiguous_comma(), ambiguous, "{text}");
        }
    }

    #[test]
    fn words_and_numbers_of_another_style_are_no_numbers() {
        for word in ["", "nan", "inf", "infinity", "1.234,5", "0.5.1", "1,", "Bad", "-", "1d", "12:00"] {
            assert!(number(word, true).is_none() && number(word, false).is_none(), "{word}");
        }
        assert!(number("1,5", false).is_none() && number("1.5", true).is_none() && number("1e999", false).is_none());
    }
}
