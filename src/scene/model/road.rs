//! The road: its kinds and what happens at its end.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// The road and what happens at its end.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Road {
    /// The plane z = 0.
    #[default]
    Smooth,
    /// Isotropic random texture of a given spectrum, endless.
    Made(MadeRoad),
    /// A measured longitudinal profile.
    Profile(ProfileRoad),
    /// An OpenCRG file.
    #[serde(rename = "opencrg")]
    OpenCrg(OpenCrgRoad),
    /// A height map in a two-dimensional `.npy` array.
    Grid(GridRoad),
}

impl Road {
    /// Largest size of a cell chosen for a road \[m\].
    pub const CELL: f64 = 0.002;

    /// Whether a section across may be other than level.
    pub fn varies_across(&self) -> bool {
        !matches!(self, Self::Smooth | Self::Profile(ProfileRoad { lateral: Lateral::Extruded, .. }))
    }

    /// Size of cells for levels within a decibel or so \[m\]: half the shortest wave of a made road, the spacing of a
    /// height map; [`Self::CELL`] at most. What waves other files hold nobody knows before they are read: a quarter of
    /// that at least, which a coarse chip seal wants (profiles/README.md).
    pub fn cell(&self) -> f64 {
        let shortest = match self {
            Self::Smooth => return Self::CELL,
            Self::Made(MadeRoad { power_law: Some(law), .. }) => law.shortest,
            Self::Made(MadeRoad { wavelengths: Some(given), .. }) => {
                given.iter().copied().fold(f64::INFINITY, f64::min)
            }
            Self::Made(_) => MadeRoad::DENSE_ASPHALT_SHORTEST,
            Self::Grid(grid) => 2.0 * grid.dx.min(grid.dy),
            Self::Profile(_) | Self::OpenCrg(_) => 0.0,
        };
        (0.5 * shortest).clamp(0.25 * Self::CELL, Self::CELL)
    }

    /// Cells of at most a size on a length \[m\].
    pub fn cells(length: f64, cell: f64) -> usize {
        // What fits up to rounding in a scene file fits.
        (length / cell - 1e-9).ceil().max(1.0) as usize
    }
}

/// A random isotropic texture. Give either `wavelengths` with `levels`, or `power_law`; neither: the
/// default dense asphalt.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MadeRoad {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Third-octave mid-wavelengths \[m\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavelengths: Option<Vec<f64>>,
    /// Third-octave texture levels of a profile, dB re 1e-6 m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub levels: Option<Vec<f64>>,
    /// Power-law spectrum instead of levels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power_law: Option<PowerLawTexture>,
    /// Spacing of the lattice on which the texture is made, independent of the run's elements \[m\].
    pub spacing: f64,
    /// Skewness of the heights: 0 for Gaussian ones, negative where stones have flat tops between deep gaps.
    pub skewness: f64,
    /// Kurtosis of the heights: 3 for Gaussian ones.
    pub kurtosis: f64,
}

impl MadeRoad {
    /// Kurtosis of Gaussian heights.
    pub const GAUSSIAN_KURTOSIS: f64 = 3.0;

    /// Default lattice spacing \[m\]: a quarter of the shortest wavelength of the default dense asphalt, 4 mm.
    pub const SPACING: f64 = 0.001;
    /// Shortest third-octave mid-wavelength of the default dense asphalt \[m\].
    pub const DENSE_ASPHALT_SHORTEST: f64 = 0.004;
}

impl Default for MadeRoad {
    fn default() -> Self {
        Self {
            seed: 0,
            wavelengths: None,
            levels: None,
            power_law: None,
            spacing: Self::SPACING,
            skewness: 0.0,
            kurtosis: Self::GAUSSIAN_KURTOSIS,
        }
    }
}

/// Profile spectrum proportional to wavenumber^(-exponent) between two wavelengths.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PowerLawTexture {
    /// Root-mean-square height \[m\].
    pub rms: f64,
    /// Decay exponent of the one-sided profile spectrum.
    pub exponent: f64,
    /// Longest wavelength \[m\].
    pub longest: f64,
    /// Shortest wavelength \[m\].
    pub shortest: f64,
}

/// A measured longitudinal profile from a file of columns.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProfileRoad {
    /// CAPTIF `.dat` or CSV; relative to the scene.
    pub file: PathBuf,
    /// Unit of the distance column of a CSV \[m, mm, um\]; CAPTIF files state theirs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_unit: Option<LengthUnit>,
    /// Unit of the height column of a CSV.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_unit: Option<LengthUnit>,
    /// Name or number (from 1) of the distance column; default: the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_column: Option<String>,
    /// Name or number (from 1) of the height column; default: the second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_column: Option<String>,
    /// Part of the profile to use \[m\]; default: all of it (CAPTIF: between the reference plates).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// How a line becomes a surface.
    pub lateral: Lateral,
    /// Seed of the random phases (`lateral = "isotropic"`).
    pub seed: u64,
    /// What happens past the end.
    pub at_end: AtEnd,
}

/// Unit of a length in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum LengthUnit {
    /// Metre.
    #[serde(rename = "m")]
    Metre,
    /// Millimetre.
    #[serde(rename = "mm")]
    Millimetre,
    /// Micrometre.
    #[serde(rename = "um")]
    Micrometre,
}

/// How a profile is continued across the width.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Lateral {
    /// The same height across.
    #[default]
    Extruded,
    /// An endless isotropic surface with the same profile spectrum and random phases.
    Isotropic,
}

/// What happens past the end of a measured road.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AtEnd {
    /// A run that needs more road than there is is refused.
    #[default]
    Refuse,
    /// The road starts again.
    Repeat,
    /// The road is run back and forth.
    Mirror,
}

/// An OpenCRG road.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OpenCrgRoad {
    /// The `.crg` file; relative to the scene.
    pub file: PathBuf,
    /// Lateral position v of the tyre's middle \[m\]; default: the middle of the valid columns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lateral_position: Option<f64>,
    /// Whether the slow trend (longer than `longest_wavelength`) is removed, as for texture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub longest_wavelength: Option<f64>,
    /// What happens past the end.
    pub at_end: AtEnd,
}

/// A height map. Rows run along x from road coordinate 0, columns across, centred on the tyre, cell-centred.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GridRoad {
    /// A two-dimensional `.npy` array of heights \[m\]; relative to the scene.
    pub file: PathBuf,
    /// Row spacing \[m\]: row r lies at road coordinate r dx.
    pub dx: f64,
    /// Column spacing \[m\].
    pub dy: f64,
    /// What happens past the end.
    pub at_end: AtEnd,
}

impl Road {
    /// The file that the road is read from; `None` for a road that is made.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::Smooth | Self::Made(_) => None,
            Self::Profile(road) => Some(&road.file),
            Self::OpenCrg(road) => Some(&road.file),
            Self::Grid(road) => Some(&road.file),
        }
    }

    /// As [`Self::file`], to be changed.
    pub(crate) fn file_mut(&mut self) -> Option<&mut PathBuf> {
        match self {
            Self::Smooth | Self::Made(_) => None,
            Self::Profile(road) => Some(&mut road.file),
            Self::OpenCrg(road) => Some(&mut road.file),
            Self::Grid(road) => Some(&mut road.file),
        }
    }
}
