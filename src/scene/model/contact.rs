//! Contact laws of tread and road slices.

use serde::{Deserialize, Serialize};

/// Contact laws.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Contact {
    /// How the tread deforms.
    pub tread: Tread,
    /// How a road slice deforms the tread across the width.
    pub slices: Slices,
    /// Which penetration a slice's stiffness curve is read at.
    pub slice_coupling: SliceCoupling,
    /// Cells across the contact width; default: about 2 mm each (a grid that fits exactly keeps its own).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lateral_points: Option<usize>,
    /// Largest error of a slice's displacement curve that dropping breakpoints may make \[m\]; 0 keeps it exact.
    pub slice_tolerance: f64,
    /// Spring stiffness per area of the `bedding` tread \[N/m^3\]; default: influence functions and springs
    /// that give one element alone and the smooth static contact the stiffness of the elastic tread.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bedding_stiffness: Option<f64>,
    /// `uncoupled` only: whether G0_ii is scaled so that the smooth static contact has the stiffness of the elastic tread.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub equal_stiffness: bool,
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
    /// An elastic half-space across the width.
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
