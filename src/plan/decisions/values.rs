//! Decisions as later stages ask for them: their values, and the rows of the table of effects with words, decision and
//! switch.

use crate::scene::{Axle, Scene, SliceCoupling, Slices, Switch, Tread, Tyre, Zone};
use serde::Serialize;

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
    /// Sub-cells of a cell along and across; 1 without.
    pub sub_cells: usize,
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

impl Decisions {
    /// Heights of the road across the contact width and along an element, if decided.
    pub(crate) fn road_cells(&self) -> [Option<usize>; 2] {
        [self.cells_across, self.cells_along].map(|cells| Some(self.sub_cells * cells?))
    }
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

/// One effect, or one choice of the physics.
pub struct DecisionRow {
    /// Name of the effect, in words.
    pub title: &'static str,
    /// Name of the effect, in a single word.
    pub short: &'static str,
    /// Decides on the effect, and sets what later stages ask for.
    pub decide: fn(&Scene, &mut Decisions) -> Decided,
    /// Switches the effect in a scene; `None` for an effect that cannot be switched.
    pub switch: Option<fn(&mut Scene, bool)>,
    /// True if the effect exists for contact over cells.
    pub of_cells: bool,
}

pub struct Decided {
    /// True if it is simulated.
    pub on: bool,
    /// How it is simulated, in words.
    pub form: String,
    /// Why, in words.
    pub reason: String,
}

impl Decided {
    /// Simulated in some form, for a reason.
    pub(crate) fn on(form: impl Into<String>, reason: impl Into<String>) -> Self {
        Self { on: true, form: form.into(), reason: reason.into() }
    }

    /// Left out, for a reason.
    pub(crate) fn off(reason: impl Into<String>) -> Self {
        Self { on: false, form: String::new(), reason: reason.into() }
    }
}

/// The reason, if the scene sets the switch itself.
pub(crate) fn given(switch: Switch, key: &str) -> Option<String> {
    match switch {
        Switch::On => Some(format!("effects.{key} = \"on\"")),
        Switch::Off => Some(format!("effects.{key} = \"off\"")),
        Switch::Auto => None,
    }
}
