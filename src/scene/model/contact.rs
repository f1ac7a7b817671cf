//! Contact laws of tread and road slices.

use serde::{Deserialize, Serialize};

/// Contact laws.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contact {
    /// How the tread deforms.
    pub tread: Tread,
    /// How the road under an element deforms the tread.
    pub slices: Slices,
    /// Which penetration a slice's stiffness curve is read at.
    pub slice_coupling: SliceCoupling,
    /// Cells across the contact width; default: about 2 mm each (a grid that fits exactly keeps its own).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells_across: Option<usize>,
    /// Cells along an element; default: at most 2 mm each (a grid that fits exactly keeps its own).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells_along: Option<usize>,
    /// Largest error of a slice's displacement curve that leaving breakpoints out may make \[m\]; 0 keeps it exact.
    pub slice_tolerance: f64,
    /// Spring stiffness per area of the `bedding` tread \[N/m^3\]; default: influence functions and springs
    /// that give one element alone and the smooth static contact the stiffness of the elastic tread.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bedding_stiffness: Option<f64>,
    /// `uncoupled` only: whether G0_ii is scaled so that the smooth static contact has the stiffness of the elastic tread.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub equal_stiffness: bool,
}

impl Contact {
    /// A micrometre of road changes no third-octave level of the force by more than 0.05 dB (measured), and leaves a tenth of the breakpoints.
    pub const SLICE_TOLERANCE: f64 = 1e-6;
}

impl Default for Contact {
    fn default() -> Self {
        Self {
            tread: Tread::default(),
            slices: Slices::default(),
            slice_coupling: SliceCoupling::default(),
            cells_across: None,
            cells_along: None,
            slice_tolerance: Self::SLICE_TOLERANCE,
            bedding_stiffness: None,
            equal_stiffness: false,
        }
    }
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
    /// The slice's highest point counts, flat.
    None,
    /// Independent springs all over the slice.
    #[default]
    Winkler,
    /// Each line of cells across on an elastic half-space.
    HalfSpace,
}

/// Which penetration a slice's stiffness curve is read at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SliceCoupling {
    /// The one that the forces of the step leave out: the paper's equation 4.
    #[default]
    Explicit,
    /// The one that is left after what the neighbours do in the same step: each slice's spring in series with the coupled tread.
    Implicit,
}
