//! The tables of a scene: which keys each one has, what may stand at them, and which of them fit together.
//!
//! Every reader reads all of its keys before it gives up, so that independent mistakes are reported together.

mod axle;
mod contact;
mod effects;
mod inflation;
mod numerics;
mod road;
mod rolling;
mod sound;
mod tyre;
mod vibration;

use super::kind::Text;
use super::table::Table;
use super::{Axle, Contact, Effects, Numerics, Outputs, Problem, Radiation, Road, Scene};

/// Reads a whole scene; `None` after a complaint.
pub(super) fn scene(table: &mut Table<'_>) -> Option<Scene> {
    let title = table.or("title", &Text, String::new());
    let tyre = table.required("tyre", &tyre::TyreKind);
    let road = table.or("road", &road::ROAD, Road::default());
    let rolling = table.required("rolling", &rolling::ROLLING);
    let contact = table.or("contact", &contact::CONTACT, Contact::default());
    let effects = table.or("effects", &effects::EFFECTS, Effects::default());
    let numerics = table.or("numerics", &numerics::NUMERICS, Numerics::default());
    let outputs = table.or("outputs", &numerics::OUTPUTS, Outputs::default());
    let receivers = table.or("receiver", &sound::RECEIVERS, Vec::new());
    let radiation = table.or("radiation", &sound::RADIATION, Radiation::default());

    let scene = Scene {
        title: title?,
        tyre: tyre?,
        road: road?,
        rolling: rolling?,
        contact: contact?,
        effects: effects?,
        numerics: numerics?,
        outputs: outputs?,
        receivers: receivers?,
        radiation: radiation?,
    };
    effects::check(&scene, table)?;
    vibration::check(&scene, table)?;
    sound::check(&scene, table)?;
    // Pushed in by more than its radius the rigid circle has no outline left to speak of.
    let radius = scene.tyre.radius();
    match scene.rolling.axle {
        Axle::Indentation { indentation, .. } if indentation > radius => {
            table.complain("rolling.axle.indentation", Problem::exceeds(indentation, radius, "the tyre's radius"))
        }
        _ => Some(scene),
    }
}
