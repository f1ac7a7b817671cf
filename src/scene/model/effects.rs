//! What is simulated beside the contact itself, effect by effect.

use serde::{Deserialize, Serialize};

/// Whether an effect is simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Switch {
    /// It is; a scene in which it can make no difference is refused.
    On,
    /// It is not, and costs nothing; a scene that asks for its results is refused.
    Off,
    /// It is where the scene holds what it acts on, or asks for its results.
    #[default]
    Auto,
}

/// Effects, each on, off or `auto`. The laws of tread and slices stand in [`super::Contact`], what holds the axle in
/// [`super::Axle`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Effects {
    /// Texture across the contact width, with the slice law; without it the road is its middle line, level across.
    /// `auto`: off for roads that are level across anyway.
    pub texture: Switch,
    /// Normal vibration of the tread surface, local deformation included. `auto`: where an output asks for it.
    pub tread_vibration: Switch,
    /// Normal vibration of the belt. `auto`: where an output asks for it.
    pub belt_vibration: Switch,
    /// Tangential vibration of the tread surface. `auto`: where an output asks for it.
    pub tangential_motion: Switch,
    /// Belt tension raised by m'' V^2. The tyre then depends on the speed, so this is off unless the scene asks for it.
    /// `auto`: on where it adds more than a tenth to the tension.
    pub centrifugal_tension: Switch,
    /// Sound radiation. `auto`: where there is a receiver.
    pub radiation: Switch,
    /// Tangential friction; not there yet: `on` is refused.
    pub friction: Switch,
}

impl Default for Effects {
    fn default() -> Self {
        Self {
            texture: Switch::Auto,
            tread_vibration: Switch::Auto,
            belt_vibration: Switch::Auto,
            tangential_motion: Switch::Auto,
            centrifugal_tension: Switch::Off,
            radiation: Switch::Auto,
            friction: Switch::Auto,
        }
    }
}
