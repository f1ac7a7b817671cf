//! Row of the table of effects: its words, its decision, its switch.

use super::values::Decisions;
use crate::scene::{Scene, Switch};

/// One effect, or one choice of the physics.
pub(crate) struct Row {
    /// The effect in words.
    pub title: &'static str,
    /// The effect in a word.
    pub short: &'static str,
    /// Decides on it, and notes what later stages ask for.
    pub decide: fn(&Scene, &mut Decisions) -> Decided,
    /// Switches it in a scene; `None` for what cannot be taken away.
    pub switch: Option<fn(&mut Scene, bool)>,
    /// True if it is looked at where the contact is one of cells.
    pub of_cells: bool,
}

/// Decision on a row.
pub(crate) struct Decided {
    /// True if it is simulated.
    pub on: bool,
    /// Form of the simulation.
    pub form: String,
    /// Reason.
    pub reason: String,
}

/// Gives the reason of a switch that the scene sets.
pub(crate) fn given(switch: Switch, key: &str) -> Option<String> {
    match switch {
        Switch::On => Some(format!("effects.{key} = \"on\"")),
        Switch::Off => Some(format!("effects.{key} = \"off\"")),
        Switch::Auto => None,
    }
}
