//! Errors of a road.

use std::path::{Path, PathBuf};

use super::file_fault::FileFault;

/// Fault inside a road's file; its message says where.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct RoadFileFault(pub(crate) FileFault);

/// A road that cannot be used, and why. Lengths in metres unless the message says otherwise.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RoadError {
    /// A file that cannot be read, is damaged, or contains no usable road.
    #[error("{}: {fault}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The fault, with its place in the file.
        fault: RoadFileFault,
    },
    /// A table whose titles have no units, while the scene gives none either.
    #[error(
        "{}: the scene must give road.{key} = \"m\", \"mm\", \"um\", \"cm\", \"in\", \"ft\" or \"mil\": the file does \
         not state this unit, as a title \"Height (mm)\" would", path.display()
    )]
    MissingUnit {
        /// The file.
        path: PathBuf,
        /// The key of the scene that must give the unit.
        key: &'static str,
    },
    /// The file does not cover the part of the road asked for.
    #[error(
        "{}: road.range = [{}, {}] m asked for, the file covers {} to {} m",
        path.display(), asked.0, asked.1, available.0, available.1
    )]
    Range {
        /// The file.
        path: PathBuf,
        /// Begin and end of the range asked for.
        asked: (f64, f64),
        /// Begin and end of the profile.
        available: (f64, f64),
    },
    /// A spacing or count that is not a positive finite number.
    #[error("{key} = {value} must be positive and finite")]
    NotPositive {
        /// The key of the scene.
        key: &'static str,
        /// Its value.
        value: f64,
    },
    /// The road is narrower than the contact strip.
    #[error(
        "{}: the road is {available} m wide, the contact strip {needed} m: road.widen = \"mirror\" continues it across \
         by its mirror images, as if the road beside were like it; or take a contact strip of at most {available} m",
        path.display()
    )]
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
        "{}: a contact strip {width} m wide around lateral_position = {position} m leaves the measured \
         part, v = {} to {} m",
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
        /// First and last usable lateral position v.
        available: (f64, f64),
    },
    /// The run needs more road than there is.
    #[error(
        "the run needs the road from {:.3} to {:.3} m, it is there from {:.3} to {:.3} m: shorten \
         the run, or set road.at_end = \"repeat\" or \"mirror\"",
        needed.0,
        needed.1,
        available.0,
        available.1
    )]
    Short {
        /// Begin and end of the part needed.
        needed: (f64, f64),
        /// Begin and end of the road.
        available: (f64, f64),
    },
    /// `wavelengths` and `levels` of different length, or only one of them given.
    #[error(
        "road.wavelengths has {wavelengths} entries and road.levels {levels}: they must be as many, and at least one"
    )]
    LevelCount {
        /// Number of wavelengths.
        wavelengths: usize,
        /// Number of levels.
        levels: usize,
    },
    /// More than one kind of spectrum is given.
    #[error("road: give either a texture, or wavelengths with levels, or power_law, only one of them")]
    TwoSpectra,
    /// A wavelength that is not a third-octave mid-wavelength.
    #[error("road.wavelengths: {wavelength} m is not a third-octave mid-wavelength; the nearest is {nearest:.6} m")]
    NotThirdOctave {
        /// The wavelength as given.
        wavelength: f64,
        /// Nearest exact mid-wavelength.
        nearest: f64,
    },
    /// The same band is given twice.
    #[error("road.wavelengths: the band at {wavelength:.6} m is given twice")]
    BandTwice {
        /// Exact mid-wavelength.
        wavelength: f64,
    },
    /// A level that is not a number or that no road can have.
    #[error("road.levels: {level} dB at {wavelength:.6} m is outside -100 to 120 dB re 1e-6 m")]
    Level {
        /// Mid-wavelength.
        wavelength: f64,
        /// The level, dB re 1e-6 m.
        level: f64,
    },
    /// The lattice on which the texture is made cannot resolve its shortest wavelength.
    #[error("road.spacing = {spacing} m cannot hold wavelengths down to {shortest:.6} m: at most {allowed:.6} m")]
    Spacing {
        /// Spacing of the lattice.
        spacing: f64,
        /// Shortest wavelength of the spectrum.
        shortest: f64,
        /// Largest spacing that resolves it.
        allowed: f64,
    },
    /// A power law without a range of wavelengths or without energy.
    #[error(
        "road.power_law: rms {rms} m, exponent {exponent}, {longest} to {shortest} m: needs rms > 0, a \
         finite exponent and longest >= 1.26 shortest > 0"
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
        "no road is made with a skewness of {skewness} and a kurtosis of {kurtosis}: with this \
         skewness the kurtosis lies from {least:.2} to {most:.2}"
    )]
    Moments {
        /// Skewness asked for.
        skewness: f64,
        /// Kurtosis asked for.
        kurtosis: f64,
        /// Least kurtosis with that skewness.
        least: f64,
        /// Greatest kurtosis with that skewness.
        most: f64,
    },
    /// A texture of such long waves relative to its lattice that its working arrays would not fit in memory.
    #[error(
        "a texture with wavelengths from {longest} m on a lattice of {spacing} m needs {needed} bytes of \
         working memory, more than the {limit} that the run may use"
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
    /// A trend wavelength that is too long for the road, or for its spacing.
    #[error(
        "{}: road.longest_wavelength = {longest} m is too long for a road of {length} m, known every {spacing} m: \
         leave it out, or remove shorter waves, too",
        path.display()
    )]
    Trend {
        /// The file.
        path: PathBuf,
        /// Longest wavelength asked for.
        longest: f64,
        /// Length of the road.
        length: f64,
        /// Spacing of its rows.
        spacing: f64,
    },
    /// More heights than fit in memory.
    #[error(
        "the road's heights need {needed} bytes, more than the {limit} that the run may use (numerics.memory_limit): \
         a coarser spacing, or fewer and larger cells"
    )]
    TooManyHeights {
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        limit: u64,
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

impl RoadError {
    /// True if the file is plainly one for another kind of road.
    pub fn is_of_another_kind(&self) -> bool {
        matches!(self, Self::File { fault: RoadFileFault(FileFault::OtherKind { .. }), .. })
    }

    /// Error of a fault of the file at `path`.
    pub(crate) fn file(path: &Path, fault: impl Into<FileFault>) -> Self {
        Self::File { path: path.to_owned(), fault: RoadFileFault(fault.into()) }
    }
}

/// Refuses a quantity that is not positive and finite; `key` is its name in the scene.
pub(super) fn positive(key: &'static str, value: f64) -> Result<(), RoadError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(RoadError::NotPositive { key, value }) }
}
