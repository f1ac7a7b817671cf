//! What a scene says, as plain data: one type per table of the TOML file.
//!
//! SI units throughout; a key carries its unit in its name only where people think in another one (`speed_kmh`).
//! Values are as the user wrote them or the documented default; [`super::validate`] has checked their ranges.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// A complete scene: what rolls, on what, how fast, and what is wanted from it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Free text, shown in results and plots.
    #[serde(default)]
    pub title: String,
    /// The tyre: given in place or, in the file, by the path of a tyre file.
    pub tyre: Tyre,
    /// The road.
    #[serde(default)]
    pub road: Road,
    /// Speed, duration and axle.
    pub rolling: Rolling,
    /// Contact law of tread and road slices.
    #[serde(default)]
    pub contact: Contact,
    /// Resolution and tolerances.
    #[serde(default)]
    pub numerics: Numerics,
    /// What is written.
    #[serde(default)]
    pub outputs: Outputs,
}

/// The unwrapped tyre: a layered plate, periodic along its circumference, simply supported at both sides.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Tyre {
    /// Circumference L = 2 pi R \[m\].
    pub circumference: f64,
    /// Width B between the simply supported sides \[m\].
    pub width: f64,
    /// Width b of the contact strip, centred \[m\].
    pub contact_width: f64,
    /// The air cushion and carcass under the innermost layer.
    pub foundation: Foundation,
    /// Layers from the rim outwards; the last one is the tread.
    pub layers: Vec<Layer>,
}

/// Elastic foundation under the innermost layer; its loss follows the same power law as the materials.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Foundation {
    /// Normal stiffness per area at the reference frequency \[N/m^3\].
    pub normal: f64,
    /// Tangential stiffness per area at the reference frequency \[N/m^3\].
    pub tangential: f64,
    /// Loss factor eta \[1\].
    #[serde(default)]
    pub loss_factor: f64,
    /// Frequency at which the stiffness is as given \[Hz\].
    #[serde(default = "reference_frequency")]
    pub reference_frequency: f64,
    /// Frequency below which the power law levels off \[Hz\].
    #[serde(default = "corner_frequency")]
    pub corner_frequency: f64,
}

/// One elastic layer.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Layer {
    /// What people call it: belt, tread, ...
    pub name: String,
    /// Thickness h \[m\].
    pub thickness: f64,
    /// Tension per width along x and y \[N/m\]; the prestress is T/h.
    #[serde(default)]
    pub tension: [f64; 2],
    /// What it is made of.
    pub material: Material,
}

/// An isotropic viscoelastic material.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// How the modulus depends on frequency.
    #[serde(default)]
    pub law: Law,
    /// Young's modulus \[Pa\]: at the reference frequency (`power-law`), at rest (`prony`), or at all frequencies.
    pub modulus: f64,
    /// Loss factor eta (`power-law`, `hysteretic`) \[1\].
    #[serde(default)]
    pub loss_factor: f64,
    /// Poisson's ratio, frequency independent, in (-1, 0.5).
    pub poisson: f64,
    /// Density \[kg/m^3\].
    pub density: f64,
    /// Frequency at which the modulus is as given (`power-law`) \[Hz\].
    #[serde(default = "reference_frequency")]
    pub reference_frequency: f64,
    /// Frequency below which the modulus levels off (`power-law`) \[Hz\].
    #[serde(default = "corner_frequency")]
    pub corner_frequency: f64,
    /// Relative strengths g_j (`prony`).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub weights: Vec<f64>,
    /// Relaxation times tau_j (`prony`) \[s\].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub times: Vec<f64>,
}

/// Viscoelastic law; see [`crate::tyre::material`] for the formulas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// E(s) = E.
    Elastic,
    /// E(s) = E ((s + wc)/w0)^(2 atan(eta)/pi): causal and passive.
    #[default]
    PowerLaw,
    /// E(s) = E (1 + sum g_j s tau_j/(1 + s tau_j)): causal and passive.
    Prony,
    /// E (1 + i eta): not causal, for frequency-domain results only.
    Hysteretic,
}

fn reference_frequency() -> f64 {
    1000.0
}

fn corner_frequency() -> f64 {
    1.0
}

/// The road and what happens at its end.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
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

/// A random isotropic Gaussian texture. Give either `wavelengths` with `levels`, or `power_law`; neither: the
/// default dense asphalt.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MadeRoad {
    /// Seed of the random numbers.
    #[serde(default)]
    pub seed: u64,
    /// Third-octave mid-wavelengths \[m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wavelengths: Option<Vec<f64>>,
    /// Third-octave texture levels of a profile, dB re 1e-6 m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub levels: Option<Vec<f64>>,
    /// Power-law spectrum instead of levels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power_law: Option<PowerLawTexture>,
    /// Spacing of the lattice on which the texture is made, independent of the run's elements \[m\].
    #[serde(default = "made_spacing")]
    pub spacing: f64,
}

impl Default for MadeRoad {
    fn default() -> Self {
        Self { seed: 0, wavelengths: None, levels: None, power_law: None, spacing: made_spacing() }
    }
}

fn made_spacing() -> f64 {
    0.001
}

/// Profile spectrum proportional to wavenumber^(-exponent) between two wavelengths.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
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
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ProfileRoad {
    /// CAPTIF `.dat` or CSV; relative to the scene.
    pub file: PathBuf,
    /// Unit of the distance column of a CSV \[m, mm, um\]; CAPTIF files state theirs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance_unit: Option<LengthUnit>,
    /// Unit of the height column of a CSV.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_unit: Option<LengthUnit>,
    /// Name or number (from 1) of the distance column; default: the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance_column: Option<String>,
    /// Name or number (from 1) of the height column; default: the second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_column: Option<String>,
    /// Part of the profile to use \[m\]; default: all of it (CAPTIF: between the reference plates).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// How a line becomes a surface.
    #[serde(default)]
    pub lateral: Lateral,
    /// Seed of the random phases (`lateral = "isotropic"`).
    #[serde(default)]
    pub seed: u64,
    /// What happens past the end.
    #[serde(default)]
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
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct OpenCrgRoad {
    /// The `.crg` file; relative to the scene.
    pub file: PathBuf,
    /// Lateral position v of the tyre's middle \[m\]; default: the middle of the valid columns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lateral_position: Option<f64>,
    /// Whether the slow trend (longer than `longest_wavelength`) is removed, as for texture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longest_wavelength: Option<f64>,
    /// What happens past the end.
    #[serde(default)]
    pub at_end: AtEnd,
}

/// A height map. Rows run along x from road coordinate 0, columns across, centred on the tyre, cell-centred.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GridRoad {
    /// A two-dimensional `.npy` array of heights \[m\]; relative to the scene.
    pub file: PathBuf,
    /// Row spacing \[m\]: row r lies at road coordinate r dx.
    pub dx: f64,
    /// Column spacing \[m\].
    pub dy: f64,
    /// What happens past the end.
    #[serde(default)]
    pub at_end: AtEnd,
}

/// How the tyre rolls.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Rolling {
    /// Speed \[km/h\].
    pub speed_kmh: f64,
    /// Time simulated after the warm-up \[s\].
    pub duration: f64,
    /// Time simulated before anything counts towards a mean or a spectrum \[s\].
    #[serde(default = "warm_up")]
    pub warm_up: f64,
    /// Road coordinate under the axle at t = 0 \[m\]; default: 0 on an endless road, just far enough in on a finite one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// What holds the axle.
    pub axle: Axle,
}

fn warm_up() -> f64 {
    0.5
}

/// What holds the axle: a load or a height.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum Axle {
    /// The height is found so that the mean vertical force is this load.
    Load {
        /// Vertical load \[N\].
        load: f64,
        /// Relative tolerance of the mean force.
        #[serde(default = "load_tolerance")]
        tolerance: f64,
    },
    /// A fixed height.
    Indentation {
        /// How far the rigid tyre is pushed into the plane z = 0 \[m\].
        indentation: f64,
        /// Time over which it rises linearly from zero \[s\].
        #[serde(default)]
        ramp: f64,
    },
}

fn load_tolerance() -> f64 {
    0.01
}

/// Contact laws.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Contact {
    /// How the tread deforms.
    pub tread: Tread,
    /// How a road slice deforms the tread across the width.
    pub slices: Slices,
    /// Cells across the contact width; default: about 2 mm each (a grid that fits exactly keeps its own).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lateral_points: Option<usize>,
    /// Spring stiffness per area of the `bedding` tread \[N/m^3\]; default: the one that gives the smooth static contact the stiffness of the elastic tread.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bedding_stiffness: Option<f64>,
}

/// Tread law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tread {
    /// The elastic layer with coupling between contact points.
    #[default]
    Elastic,
    /// The elastic layer, coupling within one step left out (diagonal of G0).
    Uncoupled,
    /// Independent springs on the belt.
    Bedding,
}

/// Road slice law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Slices {
    /// The slice's highest point counts, flat across.
    None,
    /// Independent springs across the width.
    #[default]
    Winkler,
}

/// Resolution and tolerances.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Numerics {
    /// Elements N round the tyre; even.
    pub elements: usize,
    /// Time steps q per element rolled.
    pub substeps: usize,
    /// Convolution quadrature rule.
    pub time_rule: TimeRule,
    /// Length of the force history that is kept \[s\].
    pub memory: f64,
    /// Relative tolerance of the wavenumber sums, of the influence function's static value.
    pub influence_tolerance: f64,
    /// Tolerance of the contact conditions, relative to the largest required displacement.
    pub contact_tolerance: f64,
    /// A fixed number of odd lateral terms m, instead of the tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lateral_terms: Option<usize>,
    /// A fixed largest alias |p|, instead of the tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavenumber_aliases: Option<usize>,
    /// Largest number of cached factorisations.
    pub cached_factors: usize,
    /// Memory that the run may plan to use \[GB\].
    pub memory_limit: f64,
}

impl Default for Numerics {
    fn default() -> Self {
        Self {
            elements: 512,
            substeps: 1,
            time_rule: TimeRule::Bdf2,
            memory: 0.7,
            influence_tolerance: 1e-7,
            contact_tolerance: 1e-12,
            lateral_terms: None,
            wavenumber_aliases: None,
            cached_factors: 4096,
            memory_limit: 8.0,
        }
    }
}

/// Convolution quadrature rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TimeRule {
    /// First-order backward differences.
    Bdf1,
    /// Second-order backward differences.
    #[default]
    Bdf2,
    /// Trapezoidal rule.
    Trapezoidal,
}

/// What is written to the results folder beside `summary.json`.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Outputs {
    /// `time.npy`, `total_force.npy`, `patch_force.npy`, `patch_element.npy`.
    pub arrays: bool,
    /// `spectra.csv`.
    pub spectra: bool,
    /// SVG plots.
    pub plots: bool,
}

impl Default for Outputs {
    fn default() -> Self {
        Self { arrays: true, spectra: true, plots: true }
    }
}
