//! Values that later stages ask for, and their rows in words.

use serde::Serialize;

use crate::scene::{Axle, SliceCoupling, Slices, Tread, Tyre, Zone};

/// Decisions on everything that a run simulates.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Decisions {
    /// Zone of the contact: slices or cells.
    pub zone: Zone,
    /// The slice law in use; [`Slices::None`] where a slice holds no texture.
    pub slices: Slices,
    /// Cells across the contact width, where that is decided; 1: the road's middle line, level across.
    pub cells_across: Option<usize>,
    /// Cells along an element, where that is decided.
    pub cells_along: Option<usize>,
    /// The tread law.
    pub tread: Tread,
    /// By how much a slice yields more than its element.
    pub slice_coupling: SliceCoupling,
    /// True if an effect takes the models of the tyre that the contact makes.
    pub takes_models: bool,
    /// The tyre as it rolls: turning, where rotation is taken in.
    pub tyre: Tyre,
    /// Growth of its radius by rotation \[m\].
    pub growth: f64,
    /// The axle that holds it: an indentation, which counts from the tyre at rest, and the growth.
    pub axle: Axle,
    /// All effects in words, in the order of the data's way.
    pub rows: Vec<Decision>,
    /// Notes for the user before the run.
    pub notes: Vec<String>,
}

/// One effect as it was decided on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Decision {
    /// The effect.
    pub effect: &'static str,
    /// True if it is simulated.
    pub on: bool,
    /// How.
    pub form: String,
    /// Why.
    pub reason: String,
}
