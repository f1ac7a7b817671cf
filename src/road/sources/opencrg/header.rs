//! The text header of an OpenCRG file.
//!
//! 1. Lines are ISO 8859-1, ended by LF or CR LF. A `*` in the first column marks a comment line, `!` starts a comment.
//! 2. `$NAME` opens a section, a line of `$`, `$$` or `$!...` closes it; `$$$$` (or `$$` outside any section) ends the
//!    header: data start at the byte after its LF.
//! 3. `key = value` in the sections of parameters; `#:FORMAT` and `D:name,unit` in `$KD_DEFINITION`.

use std::collections::BTreeMap;

use crate::road::file_fault::FileFault;
use crate::storage::input::excerpt;

/// Storage format of the numbers behind the header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CrgFormat {
    /// Rows start at record boundaries (`L`); otherwise they follow each other without a gap (`K`).
    pub aligned: bool,
    /// 64-bit numbers (`D`); otherwise 32-bit (`R`).
    pub double: bool,
    /// Text (`F`); otherwise big-endian IEEE 754 (`B`).
    pub text: bool,
}

impl CrgFormat {
    fn parse(text: &str) -> Option<Self> {
        let letters: Vec<char> = text.trim().to_ascii_uppercase().chars().collect();
        let choose = |letter: char, yes: char, no: char| (letter == yes || letter == no).then_some(letter == yes);
        match letters[..] {
            [order, size, kind, 'I'] => Some(Self {
                aligned: choose(order, 'L', 'K')?,
                double: choose(size, 'D', 'R')?,
                text: choose(kind, 'F', 'B')?,
            }),
            _ => None,
        }
    }
}

/// Meaning of a column of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CrgChannel {
    /// Heading of the reference line \[rad\].
    Heading,
    /// x or y of the reference line \[m\].
    Plane,
    /// Cross slope \[1\].
    Banking,
    /// Longitudinal slope \[1\].
    Slope,
    /// Elevations of longitudinal section number N (from 1).
    Numbered(usize),
    /// Elevations of the longitudinal section at v \[m\].
    At(f64),
    /// Something else.
    Unknown,
}

/// Content of a header.
#[derive(Clone, Debug, Default)]
pub(super) struct Header {
    /// `$ROAD_CRG`: lower-case key and value.
    pub road: BTreeMap<String, f64>,
    /// `$ROAD_CRG_MODS`, if the section is there.
    pub modifiers: Option<BTreeMap<String, f64>>,
    /// `$ROAD_CRG_FILE`: name of the included file.
    pub include: Option<String>,
    /// Data format.
    pub format: Option<CrgFormat>,
    /// Channels in column order, with their names.
    pub channels: Vec<(CrgChannel, String)>,
    /// Where data start: byte offset and line number (from 1).
    pub data: Option<(usize, usize)>,
}

#[derive(Clone, Copy, PartialEq)]
enum Section {
    None,
    Text,
    Road,
    Modifiers,
    File,
    Definition,
}

impl Header {
    /// Parses the header at the start of a file.
    ///
    /// # Errors
    /// Lines that cannot be understood, with their number.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, FileFault> {
        let mut header = Self::default();
        let mut section = Section::None;
        let mut offset = 0;
        let mut number = 0;
        while offset < bytes.len() {
            let end =
                bytes[offset..].iter().position(|&byte| byte == b'\n').map_or(bytes.len(), |length| offset + length);
            // ISO 8859-1: every byte is the code point of the same number.
            let line: String = bytes[offset..end].iter().map(|&byte| char::from(byte)).collect();
            offset = end + 1;
            number += 1;
            let line = line.trim_end();
            if line.starts_with("$$$$") || (line.starts_with("$$") && section == Section::None) {
                header.data = Some((offset.min(bytes.len()), number + 1));
                break;
            }
            if line.starts_with('$') {
                section = header.open_section(line);
            } else if !line.starts_with('*') {
                let line = line.split('!').next().unwrap_or_default().trim();
                if !line.is_empty() {
                    header.line(section, line, number)?;
                }
            }
        }
        Ok(header)
    }

    fn open_section(&mut self, line: &str) -> Section {
        let token = line.split_whitespace().next().unwrap_or_default().to_ascii_uppercase();
        match token.split('!').next().unwrap_or_default() {
            "$CT" => Section::Text,
            "$ROAD_CRG" => Section::Road,
            "$ROAD_CRG_MODS" => {
                self.modifiers.get_or_insert_default();
                Section::Modifiers
            }
            "$ROAD_CRG_FILE" => Section::File,
            "$KD_DEFINITION" => Section::Definition,
            "$" | "$$" | "$$$" => Section::None,
            // $ROAD_CRG_OPTS (of evaluation programs), $ROAD_CRG_MPRO (map projection) and sections of other programs
            // hold nothing about elevations; in free text a word with a dollar sign is text.
            _ => Section::Text,
        }
    }

    fn line(&mut self, section: Section, line: &str, number: usize) -> Result<(), FileFault> {
        match section {
            Section::None | Section::Text => {}
            Section::Road => insert(&mut self.road, line, number)?,
            Section::Modifiers => insert(self.modifiers.get_or_insert_default(), line, number)?,
            Section::File => self.include.get_or_insert_default().push_str(line),
            Section::Definition => self.definition(line, number)?,
        }
        Ok(())
    }

    fn definition(&mut self, line: &str, number: usize) -> Result<(), FileFault> {
        if let Some(format) = line.strip_prefix("#:") {
            let fault = || FileFault::Format { line: number, found: excerpt(format.trim()) };
            self.format = Some(CrgFormat::parse(format).ok_or_else(fault)?);
        } else if let Some(channel) = line.strip_prefix("D:").or_else(|| line.strip_prefix("d:")) {
            self.channels.push(parse_channel(channel, number)?);
        }
        Ok(())
    }
}

fn insert(values: &mut BTreeMap<String, f64>, line: &str, number: usize) -> Result<(), FileFault> {
    let (key, text) =
        line.split_once('=').ok_or_else(|| FileFault::HeaderLine { line: number, found: excerpt(line) })?;
    let key = key.trim().to_ascii_lowercase();
    match leading_number(text.trim()) {
        Some(value) => {
            values.insert(key, value);
            Ok(())
        }
        None => Err(FileFault::HeaderNumber { line: number, key: excerpt(&key), found: excerpt(text.trim()) }),
    }
}

/// Most characters of a number: doubles are written with 25.
const LONGEST_NUMBER: usize = 64;

/// The number at the start of a text, as C's `strtod` reads it: files in circulation have `2.000000000+e00`.
fn leading_number(text: &str) -> Option<f64> {
    let text = text.split_whitespace().next().filter(|text| text.len() <= LONGEST_NUMBER)?.replace(['d', 'D'], "e");
    (1..=text.len())
        .rev()
        .filter(|&end| text.is_char_boundary(end))
        .find_map(|end| text[..end].parse::<f64>().ok())
        .filter(|value| value.is_finite())
}

fn parse_channel(text: &str, line: usize) -> Result<(CrgChannel, String), FileFault> {
    let (name, unit) = text.split_once(',').unwrap_or((text, ""));
    let name = name.split_whitespace().collect::<Vec<_>>().join(" ");
    let lower = name.to_ascii_lowercase();
    let fault = || FileFault::Channel { line, channel: excerpt(&name) };
    let (channel, expected) = if let Some(rest) = lower.strip_prefix("long section") {
        let rest = rest.trim();
        let channel = match rest.strip_prefix("at v") {
            Some(position) => {
                let value = position.trim().strip_prefix('=').ok_or_else(fault)?;
                CrgChannel::At(leading_number(value.trim()).ok_or_else(fault)?)
            }
            None => CrgChannel::Numbered(rest.parse().map_err(|_| fault())?),
        };
        (channel, "m")
    } else {
        match lower.strip_prefix("reference line").map(str::trim) {
            Some("phi") => (CrgChannel::Heading, "rad"),
            Some("x" | "y") => (CrgChannel::Plane, "m"),
            Some("banking") => (CrgChannel::Banking, "m/m"),
            Some("slope") => (CrgChannel::Slope, "m/m"),
            _ => return Ok((CrgChannel::Unknown, name)),
        }
    };
    let unit = unit.split(',').next().unwrap_or_default().trim();
    if !unit.is_empty() && !unit.eq_ignore_ascii_case(expected) {
        return Err(FileFault::Unit { line, channel: excerpt(&name), found: excerpt(unit), expected });
    }
    Ok((channel, name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_end_as_real_files_end_them() {
        let text = b"$CT\nfree text with $CT inside\n$$\n$ROAD_CRG ! comment\nReference_Line_Increment=0.5!c\n$!****\n\
            * c\n$KD_Definition\r\n#:LRFI\r\nU:reference line u,m,0,1\r\nD:long section at v = -1.5,m ! x\r\n\
            D:reference line  phi,rad\r\n$\r\n* text\n$$$$$$$0\n1\n";
        let header = Header::parse(text).unwrap();
        assert_eq!(header.road["reference_line_increment"].to_bits(), 0.5_f64.to_bits());
        assert_eq!(header.format, Some(CrgFormat { aligned: true, double: false, text: true }));
        assert_eq!(header.channels[0].0, CrgChannel::At(-1.5));
        assert_eq!(header.channels[1].0, CrgChannel::Heading);
        let (offset, line) = header.data.unwrap();
        assert_eq!((&text[offset..], line), (&b"1\n"[..], 16));
    }

    #[test]
    fn faults_are_located() {
        let fault = |text: &str| Header::parse(text.as_bytes()).unwrap_err().to_string();
        assert!(fault("$ROAD_CRG\nreference_line_increment = ten\n").contains("line 2"));
        assert!(fault("$ROAD_CRG\nnonsense\n").contains("key = value"));
        assert!(fault("$KD_DEFINITION\n#:KRBX\n").contains("KRBX"));
        assert!(fault("$KD_DEFINITION\nD:long section 1,mm\n").contains("mm"));
        assert!(fault("$KD_DEFINITION\nD:long section at v 3,m\n").contains("line 2"));
    }

    #[test]
    fn numbers_are_read_like_strtod() {
        for (text, value) in [("2.000000000+e00", 2.0_f64), ("1.5D+01", 15.0), ("-3 rest", -3.0), ("1e", 1.0)] {
            assert_eq!(leading_number(text).map(f64::to_bits), Some(value.to_bits()), "{text}");
        }
        assert!(leading_number("ten").is_none() && leading_number("").is_none() && leading_number("inf").is_none());
    }
}
