//! Decisions on the physics that a run simulates and on its effects, with their reasons.
//!
//! Every later stage asks a [`Decisions`] value what to do; the rows of [`Decisions::rows`] say the same in words.
//! [`PHYSICS`] lists the choices of the physics, with a file for each subject; each effect states its rows itself.

mod axle;
mod contact;
mod tread_pattern;
mod values;

use crate::scene::{History, Road, Scene, Zone};
pub(crate) use contact::{cells_across, square_cells};
pub(crate) use tread_pattern::{taken_pattern, takes_depths, tread_blocks, tread_map};
pub use values::Decisions;
pub(crate) use values::{Decided, Decision, DecisionRow, given};

/// Choices of the physics, in the order of the computation.
pub(crate) static PHYSICS: [DecisionRow; 7] = [
    axle::ROTATION,
    contact::ZONE,
    contact::TEXTURE,
    contact::SLICE_COUPLING,
    contact::TREAD_COUPLING,
    axle::AXLE,
    DecisionRow { title: "memory of the tyre", short: "memory", decide: history, switch: None, of_cells: false },
];

/// Choices of the physics that are listed after the effects.
pub(crate) static LATE: [DecisionRow; 3] = [contact::FRICTION, tread_pattern::TREAD_PATTERN, tread_pattern::BLOCKS];

impl Decisions {
    /// Decides on a scene row by row; `takes_models`: an effect uses the models of the tyre.
    pub(crate) fn by<'a>(rows: impl Iterator<Item = &'a DecisionRow>, scene: &Scene, takes_models: bool) -> Self {
        let single = matches!(scene.road, Road::Smooth) || scene.contact.zone == Zone::Cells;
        let mut decisions = Self {
            zone: scene.contact.zone,
            slices: Some(scene.contact.slices),
            cells_across: scene.contact.cells_across,
            cells_along: if single { Some(1) } else { scene.contact.cells_along },
            sub_cells: scene.contact.sub_cells.filter(|_| scene.contact.zone == Zone::Cells).unwrap_or(1),
            tread: scene.contact.tread,
            slice_coupling: scene.contact.slice_coupling,
            takes_models,
            tyre: scene.tyre.clone(),
            growth: 0.0,
            axle: scene.rolling.axle.clone(),
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
    Decided::on(form, reason)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DEFAULT, PLATE, Slices, Switch};
    use crate::test_models::on_springs;

    fn of(edit: impl FnOnce(&mut Scene)) -> Decisions {
        let mut scene = Scene::from_str(PLATE, "default").unwrap().scene;
        edit(&mut scene);
        Decisions::new(&scene)
    }

    #[test]
    fn a_curved_tyre_turns_against_its_elements_unless_held() {
        let flat = of(|_| ());
        assert!(!flat.rows[0].on && flat.rows[0].reason.contains("flat plate"), "{}", flat.rows[0].reason);
        let text = on_springs(DEFAULT);
        let curved = |speed: f64, switch: Switch| {
            let mut scene = Scene::from_str(&text, "springs").unwrap().scene;
            (scene.rolling.speed_kmh, scene.effects.rotation) = (speed, switch);
            Decisions::new(&scene)
        };
        let fast = curved(250.0, Switch::Auto);
        // V/R, and the growth of the belt of cords.
        assert!((fast.tyre.angular_velocity + 223.76).abs() < 0.01 && fast.rows[0].on, "{:?}", fast.rows[0]);
        assert!((fast.growth - 1.6e-3).abs() < 5e-6, "{}", fast.growth);
        let held = curved(250.0, Switch::Off);
        assert_eq!((held.tyre, held.growth.to_bits()), (Scene::from_str(&text, "springs").unwrap().scene.tyre, 0));
    }

    #[test]
    fn texture_follows_the_road() {
        assert_eq!(of(|_| ()).slices, Some(Slices::Winkler));
        let smooth = of(|scene| scene.road = Road::Smooth);
        assert_eq!((smooth.slices, smooth.cells_across), (None, Some(1)));
        let off = of(|scene| scene.effects.texture = Switch::Off);
        assert_eq!((off.slices, off.cells_across), (Some(Slices::Winkler), Some(1)));
        let line = of(|scene| (scene.effects.texture, scene.contact.cells_along) = (Switch::Off, Some(1)));
        assert_eq!((line.slices, line.cells_across, line.cells_along), (None, Some(1), Some(1)));
    }
}
