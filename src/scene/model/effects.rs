//! `[effects]`: what is simulated besides the contact itself, effect by effect.

use serde::{Deserialize, Serialize};

use crate::scene::Problem;
use crate::scene::keys::keys;
use crate::scene::kind::OneOf;
use crate::scene::table::{Keys, Nested, Table};

/// Choice for an effect: simulated, not simulated, or depending on the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Switch {
    /// Simulated; a scene in which it can make no difference is refused.
    On,
    /// Not simulated, at no cost; a scene that asks for its results is refused.
    Off,
    /// Simulated if the scene has what it acts on, or asks for its results.
    #[default]
    Auto,
}

keys! {
    /// Effects, each on, off or `auto`. The laws of tread and slices stand in [`super::Contact`], what holds the axle
    /// in [`super::Axle`].
    #[derive(Clone, Debug, PartialEq, Eq, Serialize)]
    pub Effects {
        /// Texture across the contact width, with the slice law; without it the road is its middle line, level across.
        /// `auto`: off for roads that are level across anyway.
        texture: Switch = Switch::Auto => OneOf::new(),
        /// Normal vibration of the tread surface, local deformation included. `auto`: where an output asks for it.
        tread_vibration: Switch = Switch::Auto => OneOf::new(),
        /// Normal vibration of the belt. `auto`: where an output asks for it.
        belt_vibration: Switch = Switch::Auto => OneOf::new(),
        /// Tangential vibration of the tread surface. `auto`: where an output asks for it.
        tangential_motion: Switch = Switch::Auto => OneOf::new(),
        /// Rotation of the tyre: centrifugal growth and tension, Coriolis forces; waves that run forwards then differ
        /// from those that run backwards. `auto`: on for curved tyres; a flat plate does not turn.
        rotation: Switch = Switch::Auto => OneOf::new(),
        /// Sound radiation. `auto`: where there is a receiver.
        radiation: Switch = Switch::Auto => OneOf::new(),
        /// Friction. `auto`: where the scene has a table `[friction]`.
        friction: Switch = Switch::Auto => OneOf::new(),
        /// Pattern of the tread. `auto`: where the scene or its tyre's file has a table `[tread_pattern]`, over cells
        /// and over slices of springs.
        tread_pattern: Switch = Switch::Auto => OneOf::new(),
        /// Air under the contact patch. `auto`: where the scene has a table `[air_pumping]` that opens the patch.
        air_pumping: Switch = Switch::Auto => OneOf::new(),
    }
}

pub(in crate::scene) const EFFECTS: Nested<Effects> = Nested::new("[effects]", "the table [effects]").read_by(effects);

fn effects(table: &mut Table<'_>) -> Option<Effects> {
    if table.has("centrifugal_tension") {
        let wrong = "this key has been removed: a tyre that turns has more than tension";
        let right =
            "leave it out: effects.rotation = \"auto\" takes tension, growth and Coriolis forces in; \"off\" none";
        table.complain::<()>("centrifugal_tension", Problem::new(wrong, right));
        table.pass(&["centrifugal_tension"]);
    }
    Effects::read(table)
}
