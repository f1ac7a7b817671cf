//! Row of the table of effects: its words, its decision, its switch.

use super::values::Decisions;
use crate::scene::{Scene, Switch};

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

/// The reason, if the scene sets the switch itself.
pub(crate) fn given(switch: Switch, key: &str) -> Option<String> {
    match switch {
        Switch::On => Some(format!("effects.{key} = \"on\"")),
        Switch::Off => Some(format!("effects.{key} = \"off\"")),
        Switch::Auto => None,
    }
}
