//! Contact laws of tread and road slices.

use serde::{Deserialize, Serialize};

/// Contact laws.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contact {
    /// How the tread deforms.
    pub tread: Tread,
    /// How the road under an element deforms the tread.
    pub slices: Slices,
    /// By how much a slice yields more than the element as a whole.
    pub slice_coupling: SliceCoupling,
    /// kappa \[m/Pa\] of `slice_coupling = "local"`: a slice under the line force f yields like a spring of compliance
    /// kappa/(dx b). Default: from the tread's modulus and the road's texture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub local_compliance: Option<f64>,
    /// Cells across the contact width; default: about [`Road::cell`](super::Road::cell) each (a grid that fits exactly
    /// keeps its own).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells_across: Option<usize>,
    /// Cells along an element; default: at most [`Road::cell`](super::Road::cell) each (a grid that fits exactly keeps
    /// its own).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells_along: Option<usize>,
    /// Largest error of a slice's displacement curve that leaving breakpoints out may make \[m\]; 0 keeps it exact.
    pub slice_tolerance: f64,
    /// Spring stiffness per area of the `bedding` tread \[N/m^3\]; default: influence functions and springs
    /// that give one element alone and the smooth static contact the stiffness of the elastic tread.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bedding_stiffness: Option<f64>,
    /// `uncoupled` only: whether G0_ii is scaled so that the smooth static contact has the stiffness of the elastic
    /// tread.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub equal_stiffness: bool,
}

impl Contact {
    /// That of the standard preset. Thinned curves err to the same side in every slice: 1e-6 m changes levels by 0.1
    /// dB, 1e-5 m by 6 dB (measured at N = 512).
    pub const SLICE_TOLERANCE: f64 = 3e-7;
}

impl Default for Contact {
    fn default() -> Self {
        Self {
            tread: Tread::default(),
            slices: Slices::default(),
            slice_coupling: SliceCoupling::default(),
            local_compliance: None,
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
    /// The elastic layer, coupling within one step left out (diagonal of G0). What is left out falls with the time
    /// step: the limit is the elastic layer.
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

/// By how much a slice yields more than the element as a whole.
///
/// `explicit` and `implicit` are the paper's equation 4 and take the element's own influence of one time step for the
/// slice's spring; that falls with the time step and takes the texture's yielding with it, so neither has a limit for
/// small time steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SliceCoupling {
    /// By a compliance that belongs to the tread under the stones, whatever the time step.
    #[default]
    Local,
    /// By G0_ii, the curve read at the penetration that the forces of the step leave out.
    Explicit,
    /// By G0_ii, the curve read at what is left of the penetration after what the neighbours do in the same step.
    Implicit,
}
