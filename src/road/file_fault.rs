//! Faults inside a road's file. Rows and channels of arrays count from 0, lines and columns of text from 1.

use std::path::PathBuf;

use crate::storage::InputError;
use crate::storage::array::ArrayError;

/// A fault of a file. Its messages are shown after the file's name; lengths in metres unless they say otherwise.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FileFault {
    #[error("it cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// Sizes in bytes.
    #[error("it needs {needed} bytes in memory, more than the {limit} that the run may use (numerics.memory_limit)")]
    TooLarge { needed: u64, limit: u64 },

    /// The file's kind in words, and the kind of road that reads it, as a scene names it.
    #[error("it is {found}: a road of kind = \"{kind}\"")]
    OtherKind { found: &'static str, kind: &'static str },

    // Profiles and grids.
    #[error("line {line}, column {column} ({role}): {found:?} is not a number")]
    NotANumber { line: u64, column: usize, role: &'static str, found: String },
    #[error("line {line} has {found} columns, column {needed} is needed")]
    MissingCell { line: u64, needed: usize, found: usize },
    /// A line of numbers whose cells are not those of the table.
    #[error(
        "line {line} has {found} numbers or words, the table {usual}: nothing says which is which; correct the line, \
         put # before a line that is not a point, or export the table with ; or tabs between all its columns"
    )]
    Ragged { line: u64, found: usize, usual: usize },
    /// A first line of spacing and number of the points, in the file's words.
    #[error(
        "line {line}: {found:?} is out of the order of the points and seems to state their number: put # before it, or \
         take it out"
    )]
    PointCount { line: u64, found: String },
    #[error(
        "line {line}: {found:?}: every number with a comma has three digits behind it, which may be decimals or \
         thousands: export it with decimal points, and with nothing between thousands"
    )]
    AmbiguousComma { line: u64, found: String },
    #[error("no column {name:?}; the file has: {available}")]
    NoSuchColumn { name: String, available: String },
    /// Not a table of numbers, and nothing else that is read.
    #[error("it is not a format that roads are read from. {READ}")]
    NotRead,
    #[error("it is {found}, which is not read. {READ}")]
    Unreadable { found: &'static str },
    #[error("line {line}: one column of numbers; a road needs the distance of each height, too")]
    OneColumn { line: u64 },
    /// Cells whose decimals cannot be distinguished from cells.
    #[error(
        "line {line}: {found:?} has {cells} cells separated by commas and no decimal point: if its decimals have \
         commas, too, export it with ; or tabs between its columns, or with decimal points; if they are whole numbers, \
         choose the columns: road.columns = [1, 2]"
    )]
    DecimalCommas { line: u64, found: String, cells: usize },
    /// Columns that nothing identifies, or several that titles identify alike.
    #[error(
        "{cells} columns, and no titles that say which are {roles}: {found:?}; choose {} of them by title or number: \
         road.columns = [{}] (tyrewave road FILE --columns {}){}",
        likely.len(),
        listed(likely, ", "), listed(likely, ","),
        if (*cells, likely.len()) == (3, 2) { "; points x, y, z are a road of kind = \"grid\"" } else { "" }
    )]
    WhichColumns { cells: usize, roles: String, likely: Vec<usize>, found: String },
    #[error("road.columns names {found} columns, {needed} are needed: {roles}")]
    ColumnCount { found: usize, needed: usize, roles: String },
    #[error(
        "column {column} {title:?}, taken for the {role}, merely counts (0, 1, 2, 3): choose the columns by title or \
         number: road.columns = [\"distance\", \"height\"] or [1, 2] (tyrewave road FILE --columns 1,2)"
    )]
    Counter { column: usize, title: String, role: &'static str },
    #[error(
        "line {line}: the title {title:?} says {file}, the scene says road.{key} = \"{scene}\": take the key out of \
         the scene, or correct the title"
    )]
    UnitContradiction { line: u64, title: String, file: &'static str, key: &'static str, scene: &'static str },
    #[error(
        "line {line}: {found:?}, the unit of the column {title:?}, is not a unit of length that is read (m, mm, um, \
         cm, in, ft, mil): convert the column and its unit; a text in brackets must be a unit"
    )]
    UnknownUnit { line: u64, title: String, found: String },
    #[error("line {line}: the title {title:?} says {first}, the row of units below it {second}: correct one of them")]
    UnitRow { line: u64, title: String, first: &'static str, second: &'static str },
    /// A title by which a column may count downwards, and the columns (from 1) that choose it as it is.
    #[error(
        "column {column} {title:?} may count downwards, and heights count upwards: if it does, turn the signs of its \
         values and call it height; if it does not, choose it: road.columns = [{}] (tyrewave road FILE --columns {})",
        listed(columns, ", "),
        listed(columns, ",")
    )]
    Downwards { column: usize, title: String, columns: Vec<usize> },
    /// Lines of more than one way over the road.
    #[error(
        "line {line}: the distance starts again: {count} passes in one file, and a road is one of them; write each \
         into a file of its own (points x, y, z are a road of kind = \"grid\")"
    )]
    Passes { count: usize, line: u64 },
    /// A step from one distance to the next \[m\] that is more than half of the profile.
    #[error(
        "line {line}: the distance jumps from {from} to {to} m: there are several passes in one file, or a distance is \
         wrong"
    )]
    Jump { line: u64, from: f64, to: f64 },
    /// Points at the distance of another one.
    #[error(
        "{count} of {total} points lie at the distance of another one, at another height: there are several passes in \
         one file, or distances of too few digits; write each pass into a file of its own (points x, y, z are a road \
         of kind = \"grid\")"
    )]
    Coinciding { count: usize, total: usize },
    #[error(
        "line {line}: {found:?} is not the second line of an ERD file: expected channels, samples, records, bytes, \
         form, step"
    )]
    ErdHeader { line: u64, found: String },
    #[error("it is an ERD file with binary data (form {form}): export it as text (form 5)")]
    ErdBinary { form: i64 },
    /// Root-mean-square height \[m\].
    #[error(
        "it is flat: its heights vary by {:.2e} um (rms) only, and no road is so smooth: is their unit right (that of \
         OpenCRG is metres, that of other files road.height_unit), and is it their column (of a table, road.columns)?",
        1e6 * rms
    )]
    TooFlat { rms: f64 },
    #[error("{found} usable points, at least {needed} are needed")]
    TooFewPoints { found: usize, needed: usize },
    /// Points too far apart \[m\] for a third octave of texture up to the wavelength `longest` \[m\].
    #[error(
        "its points are {spacing:.3} m apart, too far for any texture up to a wavelength of {longest} m: is the unit \
         of its distances right?"
    )]
    TooCoarse { spacing: f64, longest: f64 },
    /// More than the share `allowed` of the heights is missing.
    #[error(
        "{missing} of {total} heights are missing, more than the {} % that are filled by interpolation",
        allowed * 100.0
    )]
    TooManyMissing { missing: usize, total: usize, allowed: f64 },
    /// A height, in the file's unit, that most likely marks missing ones.
    #[error(
        "the height {value} recurs exactly {count} times, far from its neighbours or from all others: if it stands for \
         a height that was not measured, write road.missing = {value} (--set road.missing={value}); if it was \
         measured, road.missing = []"
    )]
    StandsForNone { value: f64, count: usize },
    /// Heights that differ from their neighbours by at least three times the distance.
    #[error(
        "{spikes} of {total} heights are spikes, steeper than 3 : 1 (ISO 13473-1), more than the {} % that are \
         interpolated: are the units of heights and distances right?", allowed * 100.0
    )]
    TooManySpikes { spikes: usize, total: usize, allowed: f64 },
    #[error("it is flat: it has no texture to make a surface like it")]
    Flat,
    #[error("row {row}, column {column} is {value}")]
    Infinite { row: usize, column: usize, value: f64 },
    /// Heights that can hardly be metres.
    #[error(
        "the heights span {span:.4} m, more than {allowed} m: are they in another unit (millimetres)? Hills are \
         removed with road.longest_wavelength"
    )]
    ImplausibleHeights { span: f64, allowed: f64 },
    /// Points so near each other, or so far apart, that they can hardly be measured.
    #[error(
        "its points are {spacing:e} m apart, and no road is measured so: from {least:e} to {most} m is plausible; is \
         the unit of its distances right, or a scale?"
    )]
    ImplausibleSpacing { spacing: f64, least: f64, most: f64 },
    #[error(transparent)]
    Npy(ArrayError),
    #[error("a grid needs a two-dimensional array (rows along x, columns across), this one has the shape {shape:?}")]
    NpyShape { shape: Vec<u64> },
    #[error(
        "a grid needs float64 or float32 heights in metres, this array holds {found}: convert it, as \
         heights.astype(\"float64\") does in numpy"
    )]
    NpyType { found: String },

    /// A point of a cloud, and the length \[m\] at which it lies.
    #[error(
        "line {line}: the {name} {at} m is not on a grid of {step} m: only points on a grid are read; bring a \
         scattered cloud to a grid first"
    )]
    OffGrid { line: u64, name: &'static str, at: f64, step: f64 },
    /// Most places of the points' grid would be empty.
    #[error(
        "its {points} points lie on no grid: one with their usual steps has {places} places; bring a scattered cloud \
         to a grid first"
    )]
    Scattered { points: usize, places: f64 },
    #[error("lines {other} and {line} are points at the same place: more than one pass, or rounded coordinates?")]
    SamePlace { line: u64, other: u64 },
    #[error("all points have the same {name}: they form a profile, not a grid")]
    OneLine { name: &'static str },
    #[error("an array does not state its spacings: the scene must give road.dx and road.dy")]
    NoSpacing,

    // OpenCRG: its header.
    #[error("line {line}: {key} = {found:?} is not a number")]
    HeaderNumber { line: usize, key: String, found: String },
    #[error("line {line}: expected \"key = value\", found {found:?}")]
    HeaderLine { line: usize, found: String },
    #[error("the header has no {what}")]
    Missing { what: &'static str },
    #[error(
        "line {line}: unknown data format {found:?}: expected one of LRFI, LDFI, LRBI, LDBI, KRFI, KDFI, KRBI, KDBI"
    )]
    Format { line: usize, found: String },
    #[error("line {line}: channel {channel:?} is in {found:?}, expected {expected:?}")]
    Unit { line: usize, channel: String, found: String, expected: &'static str },
    #[error("line {line}: channel {channel:?} is defined twice or cannot be understood")]
    Channel { line: usize, channel: String },
    /// Some sections by number and some by position, or numbers with gaps.
    #[error("the {sections} longitudinal sections must all have positions (at v = X), or be numbered 1 to {sections}")]
    Sections { sections: usize },
    #[error(
        "long_section_v_right = {right}, _left = {left}, _increment = {increment} make {expected} longitudinal \
         sections, {found} are defined"
    )]
    SectionCount { right: f64, left: f64, increment: f64, expected: f64, found: usize },
    #[error("{what} = {value} must be positive and finite")]
    NotPositive { what: &'static str, value: f64 },
    #[error(
        "reference_line_start_u = {start}, _end_u = {end}, _increment = {increment} do not make a whole number of rows"
    )]
    RowCount { start: f64, end: f64, increment: f64 },
    #[error("the file has no data: no line starting with $$$$ ends its header")]
    NoData,

    // OpenCRG: its data.
    /// Binary data of the wrong length, in bytes; `padded` is the length with padding to whole records.
    #[error(
        "the header promises {rows} rows of {channels} channels: {expected} bytes of data, {padded} with the padding \
         to whole 80-byte records; {found} are there{hint}"
    )]
    Payload { rows: u64, channels: usize, expected: u64, padded: u64, found: u64, hint: LikelyCause },
    #[error("the header promises {expected} rows of data, {found} are there")]
    Rows { expected: u64, found: u64 },
    /// A text record that ends too early: fields expected, characters per field, characters found.
    #[error("line {line}: {expected} fields of {width} characters expected, the record ends after {found} characters")]
    Record { line: usize, expected: usize, width: usize, found: usize },
    /// Damaged data, or data of another format; the channel counts from 1.
    #[error(
        "row {row}, channel {channel} is {value:e}: no road has this, the data are damaged or not of the stated \
         format{hint}"
    )]
    Absurd { row: usize, channel: usize, value: f64, hint: LikelyCause },
    #[error("row {row}: the channel {channel:?} has no value")]
    ReferenceLineHole { row: usize, channel: &'static str },

    // OpenCRG: files that include others.
    #[error("$ROAD_CRG_FILE names {}, outside the folder {}", path.display(), folder.display())]
    IncludeOutside { path: PathBuf, folder: PathBuf },
    #[error(
        "$ROAD_CRG_FILE names {}, which includes itself or is at the end of too long a chain", path.display()
    )]
    IncludeCycle { path: PathBuf },
    #[error("$ROAD_CRG_FILE names {}: {source}", path.display())]
    Include { path: PathBuf, source: std::io::Error },
}

/// The file formats that a road is read from, for messages.
const READ: &str = "Read are, as kind = \"profile\", tables of text (columns separated by commas, semicolons, tabs or \
                    blanks; UTF-8, UTF-16 or Latin-1), CAPTIF .dat and ERD as text; as \"opencrg\" .crg; as \"grid\" \
                    .npy, XYZ and ESRI grids (.asc) as text. Topographies of other instruments (SUR, X3P, ...) are \
                    read through the Python package: tyrewave.Road.from_topography";

/// Returns numbers of columns with a text between them.
fn listed(columns: &[usize], between: &str) -> String {
    columns.iter().map(usize::to_string).collect::<Vec<_>>().join(between)
}

/// Likely cause of a file's damage; displays as nothing or as the end of a sentence.
#[derive(Clone, Copy, Debug, thiserror::Error, PartialEq, Eq)]
pub(crate) enum LikelyCause {
    /// No guess.
    #[error("")]
    Unknown,
    /// The data contain no CR LF pair at all although chance would produce some: line ends were converted.
    #[error(
        ". The binary data contain no CR LF pair: the file was probably transferred as text and every CR LF became \
         LF; transfer it again in binary mode"
    )]
    LineEndsConverted,
    /// The file ends too early.
    #[error(". The file ends too early: it was cut off")]
    Truncated,
}

impl From<InputError> for FileFault {
    fn from(error: InputError) -> Self {
        match error {
            InputError::Io(source) => Self::Io(source),
            InputError::TooLarge { found, limit } => Self::TooLarge { needed: found, limit },
        }
    }
}

impl From<ArrayError> for FileFault {
    fn from(error: ArrayError) -> Self {
        match error {
            ArrayError::Io(source) => Self::Io(source),
            ArrayError::Type { found } => Self::NpyType { found },
            other @ ArrayError::Damaged(_) => Self::Npy(other),
        }
    }
}
