//! Decisions on the physics that a run simulates and on its effects, with their reasons.
//!
//! Every later stage asks a [`Decisions`] value what to do; the rows of [`Decisions::rows`] say the same in words.
//! [`PHYSICS`] lists the choices of the physics, a file a matter; each effect states its own rows.

mod axle;
mod contact;
mod row;
mod tension;
mod values;

use crate::scene::{History, Road, Scene, Zone};
pub use axle::TYPICAL_AXLE;
pub use contact::cells_across;
pub use row::{Decided, Row, given};
pub use values::{Decision, Decisions};

/// Choices of the physics, in the order of the data's way.
pub static PHYSICS: [Row; 7] = [
    tension::TENSION,
    contact::ZONE,
    contact::TEXTURE,
    contact::SLICE_COUPLING,
    contact::TREAD_COUPLING,
    axle::AXLE,
    Row { title: "memory of the tyre", short: "memory", decide: history, switch: None, of_cells: false },
];

/// Physics that is not there yet.
pub static MISSING: [Row; 1] =
    [Row { title: "friction", short: "friction", decide: later, switch: None, of_cells: false }];

impl Decisions {
    /// Decides on a scene by rows, one after the other; `takes_models`: an effect takes the models of the tyre.
    pub fn by<'a>(rows: impl Iterator<Item = &'a Row>, scene: &Scene, takes_models: bool) -> Self {
        let single = matches!(scene.road, Road::Smooth) || scene.contact.zone == Zone::Cells;
        let mut decisions = Self {
            zone: scene.contact.zone,
            slices: scene.contact.slices,
            cells_across: scene.contact.cells_across,
            cells_along: if single { Some(1) } else { scene.contact.cells_along },
            tread: scene.contact.tread,
            slice_coupling: scene.contact.slice_coupling,
            takes_models,
            tyre: scene.tyre.clone(),
            rows: Vec::new(),
            notes: Vec::new(),
        };
        for row in rows {
            let Decided { on, form, reason } = (row.decide)(scene, &mut decisions);
            decisions.rows.push(Decision { effect: row.title, on, form, reason });
        }
        decisions
    }
}

fn history(scene: &Scene, _: &mut Decisions) -> Decided {
    let (form, reason) = match scene.numerics.history {
        History::Direct => (format!("sum over {} s", scene.numerics.memory), "numerics.history = \"direct\""),
        History::Modal => ("recursion by poles".to_owned(), "numerics.history = \"modal\""),
    };
    Decided { on: true, form, reason: reason.to_owned() }
}

fn later(_: &Scene, _: &mut Decisions) -> Decided {
    Decided { on: false, form: String::new(), reason: "not there yet".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{PLATE, Slices, Switch};

    fn of(edit: impl FnOnce(&mut Scene)) -> Decisions {
        let mut scene = Scene::from_str(PLATE, "default").unwrap().scene;
        edit(&mut scene);
        Decisions::new(&scene)
    }

    #[test]
    fn centrifugal_tension_follows_the_speed_and_is_off_unless_asked_for() {
        let base = of(|_| ());
        assert!(!base.rows[0].on && base.rows[0].reason.contains("18.7 %"), "{}", base.rows[0].reason);
        assert_eq!(base.tyre, Scene::from_str(PLATE, "default").unwrap().scene.tyre);
        let at = |speed: f64| {
            of(|scene| {
                scene.effects.centrifugal_tension = Switch::Auto;
                scene.rolling.speed_kmh = speed;
            })
        };
        assert!(at(80.0).rows[0].on && !at(50.0).rows[0].on);
        // m'' = 6 mm x 1300 + 13 mm x 1150 kg/m^3, raised on the belt alone: the tread carries none.
        let (fast, speed) = (at(200.0), 200.0_f64 / 3.6);
        assert!((fast.tyre.layers[0].tension[0] - (6e4 + (7.8 + 14.95) * speed * speed)).abs() < 1e-6);
        assert!(fast.tyre.layers[1].tension[0].abs() < 1e-12 && (fast.tyre.layers[0].tension[1] - 2e4).abs() < 1e-9);
        let told = of(|scene| scene.rolling.speed_kmh = 200.0);
        assert!(told.notes.len() == 1 && told.notes[0].contains("117."), "{:?}", told.notes);
    }

    #[test]
    fn texture_follows_the_road() {
        assert_eq!(of(|_| ()).slices, Slices::Winkler);
        let smooth = of(|scene| scene.road = Road::Smooth);
        assert_eq!((smooth.slices, smooth.cells_across), (Slices::None, Some(1)));
        let off = of(|scene| scene.effects.texture = Switch::Off);
        assert_eq!((off.slices, off.cells_across), (Slices::Winkler, Some(1)));
        let line = of(|scene| (scene.effects.texture, scene.contact.cells_along) = (Switch::Off, Some(1)));
        assert_eq!((line.slices, line.cells_across, line.cells_along), (Slices::None, Some(1), Some(1)));
    }
}
