//! Values that later stages ask for, and their rows in words.

use serde::Serialize;

use crate::scene::{Axle, SliceCoupling, Slices, Tread, Tyre, Zone};

/// Decisions on everything that a run simulates.
#[derive(Clone, Debug, PartialEq)]
pub struct Decisions {
    /// Zone of the contact: slices or cells.
    pub zone: Zone,
    /// Slice law; `None` if slices are flat.
    pub slices: Option<Slices>,
    /// Cells across the contact width, if decided; 1: the road's middle line, level across.
    pub cells_across: Option<usize>,
    /// Cells along an element, if decided.
    pub cells_along: Option<usize>,
    /// Law of the tread.
    pub tread: Tread,
    /// Coupling of a slice's additional compliance to its element.
    pub slice_coupling: SliceCoupling,
    /// True if an effect uses the models of the tyre that the contact needs.
    pub takes_models: bool,
    /// The tyre as it rolls: with its angular velocity, if rotation is simulated.
    pub tyre: Tyre,
    /// Growth of the radius by rotation \[m\].
    pub growth: f64,
    /// The axle; an indentation is counted from the tyre at rest, plus the growth.
    pub axle: Axle,
    /// All effects in words, in the order of the computation.
    pub rows: Vec<Decision>,
    /// Notes for the user before the run.
    pub notes: Vec<String>,
}

/// Decision on one effect, in words.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Decision {
    /// Name of the effect.
    pub effect: &'static str,
    /// True if it is simulated.
    pub on: bool,
    /// How it is simulated.
    pub form: String,
    /// Why it was decided so.
    pub reason: String,
}
