//! What can be wrong with a road.

use std::path::PathBuf;

use super::opencrg::CrgError;

/// A road that cannot be used, and why. Lengths in metres unless the message says otherwise.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RoadError {
    /// A file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file is too large for the memory that the run may use.
    #[error("{} needs {needed} bytes in memory, more than the {limit} that the run may use (numerics.memory_limit)", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// A cell that should hold a number holds something else.
    #[error("{}: line {line}, column {column} ({role}): {found:?} is not a number", path.display())]
    NotANumber {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        /// Column, from 1.
        column: usize,
        /// Which quantity the column holds.
        role: &'static str,
        /// The cell's text.
        found: String,
    },
    /// A line has too few columns.
    #[error("{}: line {line} has {found} columns, column {needed} is needed", path.display())]
    MissingCell {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        /// Column needed, from 1.
        needed: usize,
        /// Columns found.
        found: usize,
    },
    /// The columns file cannot be split into records.
    #[error("{}: {source}", path.display())]
    Columns {
        /// The file.
        path: PathBuf,
        /// What the reader said, with the position.
        source: csv::Error,
    },
    /// The scene names a column that the file does not have.
    #[error("{}: no column {name:?}; the file has: {}", path.display(), available.join(", "))]
    NoSuchColumn {
        /// The file.
        path: PathBuf,
        /// Name or number asked for.
        name: String,
        /// What there is.
        available: Vec<String>,
    },
    /// A CSV without units.
    #[error("{}: the scene must give road.{key} = \"m\", \"mm\" or \"um\": a CSV file does not state its units", path.display())]
    MissingUnit {
        /// The file.
        path: PathBuf,
        /// The key of the scene.
        key: &'static str,
    },
    /// A file of a format with fixed units states another one.
    #[error("{}: line {line}: no unit in {found:?}: expected \"Distance (mm)\" and \"Depth (mm)\" or the like", path.display())]
    UnknownUnit {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        /// The column's title.
        found: String,
    },
    /// Fewer points than a road needs.
    #[error("{}: {found} usable points, at least {needed} are needed", path.display())]
    TooFewPoints {
        /// The file.
        path: PathBuf,
        /// Usable points.
        found: usize,
        /// Points needed.
        needed: usize,
    },
    /// Too large a share of the heights is missing.
    #[error("{}: {missing} of {total} heights are missing, more than the {} % that are filled by interpolation", path.display(), allowed * 100.0)]
    TooManyMissing {
        /// The file.
        path: PathBuf,
        /// Missing heights.
        missing: usize,
        /// All heights.
        total: usize,
        /// Largest share that is filled.
        allowed: f64,
    },
    /// An infinite height or distance.
    #[error("{}: row {row}, column {column} is {value}", path.display())]
    Infinite {
        /// The file.
        path: PathBuf,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// The value.
        value: f64,
    },
    /// Heights that can hardly be metres.
    #[error("{}: the heights span {span:.4} m, more than {allowed} m: are they in another unit (millimetres)?", path.display())]
    ImplausibleHeights {
        /// The file.
        path: PathBuf,
        /// Highest minus lowest.
        span: f64,
        /// Largest span that passes for a texture.
        allowed: f64,
    },
    /// The part of the road asked for is not there.
    #[error("{}: road.range = [{}, {}] m asked for, the file covers {} to {} m", path.display(), asked.0, asked.1, available.0, available.1)]
    Range {
        /// The file.
        path: PathBuf,
        /// From, to.
        asked: (f64, f64),
        /// From, to.
        available: (f64, f64),
    },
    /// A `.npy` file that cannot be decoded.
    #[error("{} is not a complete .npy array: {source}", path.display())]
    Npy {
        /// The file.
        path: PathBuf,
        /// What the reader said.
        source: std::io::Error,
    },
    /// An array that is not two-dimensional.
    #[error("{}: a grid needs a two-dimensional array (rows along x, columns across), this one has the shape {shape:?}", path.display())]
    NpyShape {
        /// The file.
        path: PathBuf,
        /// Its shape.
        shape: Vec<u64>,
    },
    /// An array that does not hold real floating-point numbers.
    #[error("{}: a grid needs float64 or float32 heights, this array holds {found}", path.display())]
    NpyType {
        /// The file.
        path: PathBuf,
        /// Its element type.
        found: String,
    },
    /// A spacing or count that is no positive finite number.
    #[error("{key} = {value} must be positive and finite")]
    NotPositive {
        /// The key of the scene.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// The road is narrower than the contact strip.
    #[error("{}: the road is {available} m wide, the contact strip {needed} m", path.display())]
    Narrow {
        /// The file.
        path: PathBuf,
        /// Contact width.
        needed: f64,
        /// Width available.
        available: f64,
    },
    /// The contact strip leaves the measured columns.
    #[error(
        "{}: a contact strip {width} m wide around lateral_position = {position} m leaves the measured part, v = {} to {} m",
        path.display(),
        available.0,
        available.1
    )]
    LateralPosition {
        /// The file.
        path: PathBuf,
        /// Position asked for.
        position: f64,
        /// Contact width.
        width: f64,
        /// First and last usable v.
        available: (f64, f64),
    },
    /// The run needs more road than there is.
    #[error(
        "the run needs the road from {:.3} to {:.3} m, it is there from {:.3} to {:.3} m: shorten the run, or set road.at_end = \"repeat\" or \"mirror\"",
        needed.0,
        needed.1,
        available.0,
        available.1
    )]
    Short {
        /// From, to.
        needed: (f64, f64),
        /// From, to.
        available: (f64, f64),
    },
    /// `wavelengths` and `levels` of different length, or only one of them.
    #[error(
        "road.wavelengths has {wavelengths} entries and road.levels {levels}: they must be as many, and at least one"
    )]
    LevelCount {
        /// Number of wavelengths.
        wavelengths: usize,
        /// Number of levels.
        levels: usize,
    },
    /// Both kinds of spectrum given.
    #[error("road: give either wavelengths with levels, or power_law, not both")]
    TwoSpectra,
    /// A wavelength that is no third-octave mid-wavelength.
    #[error("road.wavelengths: {wavelength} m is no third-octave mid-wavelength; the nearest is {nearest:.6} m")]
    NotThirdOctave {
        /// As given.
        wavelength: f64,
        /// Nearest exact mid-wavelength.
        nearest: f64,
    },
    /// The same band twice.
    #[error("road.wavelengths: the band at {wavelength:.6} m is given twice")]
    BandTwice {
        /// Exact mid-wavelength.
        wavelength: f64,
    },
    /// A level that is no number or outside anything a road can have.
    #[error("road.levels: {level} dB at {wavelength:.6} m is outside -100 to 120 dB re 1e-6 m")]
    Level {
        /// Mid-wavelength.
        wavelength: f64,
        /// The level.
        level: f64,
    },
    /// The lattice on which the texture is made cannot hold its shortest wavelength.
    #[error("road.spacing = {spacing} m cannot hold wavelengths down to {shortest:.6} m: at most {allowed:.6} m")]
    Spacing {
        /// Spacing of the lattice.
        spacing: f64,
        /// Shortest wavelength of the spectrum.
        shortest: f64,
        /// Largest spacing that holds it.
        allowed: f64,
    },
    /// A power law without room or strength.
    #[error(
        "road.power_law: rms {rms} m, exponent {exponent}, {longest} to {shortest} m: needs rms > 0, a finite exponent and longest >= 1.26 shortest > 0"
    )]
    PowerLaw {
        /// Root-mean-square height.
        rms: f64,
        /// Decay exponent.
        exponent: f64,
        /// Longest wavelength.
        longest: f64,
        /// Shortest wavelength.
        shortest: f64,
    },
    /// Skewness and kurtosis that no monotone transformation of Gaussian heights has.
    #[error(
        "no road is made with a skewness of {skewness} and a kurtosis of {kurtosis}: with this skewness the kurtosis lies from {least:.2} to {most:.2}"
    )]
    Moments {
        /// Skewness asked for.
        skewness: f64,
        /// Kurtosis asked for.
        kurtosis: f64,
        /// Least kurtosis with that skewness.
        least: f64,
        /// Greatest.
        most: f64,
    },
    /// A texture so long-waved against its lattice that its working arrays would not fit in memory.
    #[error(
        "a texture with wavelengths from {longest} m on a lattice of {spacing} m needs {needed} bytes of working memory, more than the {limit} that the run may use"
    )]
    TextureTooLarge {
        /// Longest wavelength.
        longest: f64,
        /// Lattice spacing.
        spacing: f64,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        limit: u64,
    },
    /// An OpenCRG file with a fault.
    #[error("{}: {source}", path.display())]
    Crg {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: CrgError,
    },
    /// The output buffer does not have rows x columns entries.
    #[error("the height buffer has {found} entries, {needed} are needed")]
    BufferSize {
        /// Entries needed.
        needed: usize,
        /// Entries found.
        found: usize,
    },
}
