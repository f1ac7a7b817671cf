//! What can be wrong inside an OpenCRG file.

use std::path::PathBuf;

/// A fault of an OpenCRG file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CrgError {
    /// A header value is no number.
    #[error("line {line}: {key} = {found:?} is not a number")]
    HeaderNumber {
        /// Line, from 1.
        line: usize,
        /// Key.
        key: String,
        /// Text found.
        found: String,
    },
    /// A header line without an equals sign.
    #[error("line {line}: expected \"key = value\", found {found:?}")]
    HeaderLine {
        /// Line, from 1.
        line: usize,
        /// Text found.
        found: String,
    },
    /// Something that the layout depends on is absent.
    #[error("the header has no {what}")]
    Missing {
        /// What is absent.
        what: &'static str,
    },
    /// An unknown data format.
    #[error(
        "line {line}: unknown data format {found:?}: expected one of LRFI, LDFI, LRBI, LDBI, KRFI, KDFI, KRBI, KDBI"
    )]
    Format {
        /// Line, from 1.
        line: usize,
        /// Text found.
        found: String,
    },
    /// A data channel in a unit that is not the format's.
    #[error("line {line}: channel {channel:?} is in {found:?}, expected {expected:?}")]
    Unit {
        /// Line, from 1.
        line: usize,
        /// Channel name.
        channel: String,
        /// Unit found.
        found: String,
        /// Unit of the format.
        expected: &'static str,
    },
    /// The same channel twice, or a longitudinal section without number or position.
    #[error("line {line}: channel {channel:?} is defined twice or cannot be understood")]
    Channel {
        /// Line, from 1.
        line: usize,
        /// Channel name.
        channel: String,
    },
    /// Longitudinal sections by number in one place and by position in another, or numbers with gaps.
    #[error("the {sections} longitudinal sections must all have positions (at v = X), or be numbered 1 to {sections}")]
    Sections {
        /// Number of sections.
        sections: usize,
    },
    /// Lateral keys that contradict the number of sections.
    #[error(
        "long_section_v_right = {right}, _left = {left}, _increment = {increment} make {expected} longitudinal sections, {found} are defined"
    )]
    SectionCount {
        /// Rightmost v.
        right: f64,
        /// Leftmost v.
        left: f64,
        /// Increment of v.
        increment: f64,
        /// Sections that these make.
        expected: f64,
        /// Sections defined.
        found: usize,
    },
    /// A spacing or range that is not positive, or not finite.
    #[error("{what} = {value} must be positive and finite")]
    NotPositive {
        /// Which quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// Start, end and increment of u that do not make whole rows.
    #[error(
        "reference_line_start_u = {start}, _end_u = {end}, _increment = {increment} do not make a whole number of rows"
    )]
    RowCount {
        /// Start of u.
        start: f64,
        /// End of u.
        end: f64,
        /// Increment of u.
        increment: f64,
    },
    /// Binary data of the wrong length.
    #[error(
        "the header promises {rows} rows of {channels} channels: {expected} bytes of data, {padded} with the padding to whole 80-byte records; {found} are there{hint}"
    )]
    Payload {
        /// Rows promised.
        rows: u64,
        /// Channels.
        channels: usize,
        /// Bytes of the numbers alone.
        expected: u64,
        /// Bytes with padding.
        padded: u64,
        /// Bytes found.
        found: u64,
        /// A likely cause.
        hint: LikelyCause,
    },
    /// Text data with too few or too many rows.
    #[error("the header promises {expected} rows of data, {found} are there")]
    Rows {
        /// Rows promised.
        expected: u64,
        /// Rows found.
        found: u64,
    },
    /// A text record that ends too early.
    #[error("line {line}: {expected} fields of {width} characters expected, the record ends after {found} characters")]
    Record {
        /// Line, from 1.
        line: usize,
        /// Fields expected.
        expected: usize,
        /// Characters per field.
        width: usize,
        /// Characters found.
        found: usize,
    },
    /// A number that no road has: the data are damaged or of another format.
    #[error(
        "row {row}, channel {channel} is {value:e}: no road has this, the data are damaged or not of the stated format{hint}"
    )]
    Absurd {
        /// Row, from 0.
        row: usize,
        /// Channel, from 1.
        channel: usize,
        /// The value.
        value: f64,
        /// A likely cause.
        hint: LikelyCause,
    },
    /// A slope or banking that is not a number.
    #[error("row {row}: the channel {channel:?} has no value")]
    ReferenceLineHole {
        /// Row, from 0.
        row: usize,
        /// Channel name.
        channel: &'static str,
    },
    /// A header without data, and without a reference to another file.
    #[error("the file has no data: no line starting with $$$$ ends its header")]
    NoData,
    /// An included file outside the scene's folder.
    #[error("$ROAD_CRG_FILE names {}, outside the folder {}", path.display(), folder.display())]
    IncludeOutside {
        /// The file named.
        path: PathBuf,
        /// The folder within which files may be included.
        folder: PathBuf,
    },
    /// Files that include each other, or too deep a chain.
    #[error("$ROAD_CRG_FILE names {}, which includes itself or stands at the end of too long a chain", path.display())]
    IncludeCycle {
        /// The file named.
        path: PathBuf,
    },
    /// An included file that cannot be found.
    #[error("$ROAD_CRG_FILE names {}: {source}", path.display())]
    Include {
        /// The file named.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// A guess at what damaged a file; displays as nothing or as the end of a sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LikelyCause {
    /// No guess.
    Unknown,
    /// The data hold no CR LF pair at all although chance would put some there: line ends were converted.
    LineEndsConverted,
    /// The file simply stops.
    Truncated,
}

impl std::fmt::Display for LikelyCause {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(match self {
            Self::Unknown => "",
            Self::LineEndsConverted => {
                ". The binary data contain no CR LF pair: the file was probably transferred as text and every CR LF became LF; transfer it again in binary mode"
            }
            Self::Truncated => ". The file ends too early: it was cut off",
        })
    }
}
