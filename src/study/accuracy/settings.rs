//! Settings that a study varies, which trade accuracy for time in a scene.

use serde::Serialize;

use crate::plan::decisions::cells_across;
use crate::road::Lattice;
use crate::scene::{Contact, History, Numerics, Road, Scene, SliceCoupling, Slices, Tread, Zone};

/// The settings of one run of a study; everything else is the scene's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Elements, steps, time rule, history and their tolerances, all explicit.
    #[serde(flatten)]
    pub numerics: Numerics,
    /// Laws and cells; `cells_across` is `None` only for slices of a road that is level across or has a cell size of
    /// its own or of the law. Cells along an element follow from `cell_length`.
    #[serde(flatten)]
    pub contact: Contact,
    /// Longest cell along an element of slices \[m\].
    pub cell_length: f64,
}

impl Settings {
    pub(crate) fn of(scene: &Scene) -> Self {
        let (mut numerics, mut contact) = (scene.numerics.clone(), scene.contact.clone());
        numerics.forget_wishes();
        let across = Lattice::across(scene.tyre.contact_width, scene.road.cell());
        let made = matches!(scene.road, Road::Made(_) | Road::Profile(_));
        // Whether a measured grid keeps its own cells is not known here; a texture has none.
        let of_law = contact.cell_of_law(&scene.road);
        let resolved = made && of_law.is_none();
        contact.cells_across =
            contact.cells_across.or_else(|| (scene.road.varies_across() && resolved).then_some(across));
        if contact.zone == Zone::Cells {
            contact.cell = None;
            contact.cells_across = Some(cells_across(scene));
        }
        let along = |cells: usize| scene.tyre.circumference / (numerics.elements * cells) as f64;
        let cell_length = contact.cells_along.take().map_or(of_law.unwrap_or_else(|| scene.road.cell()), along);
        Self { numerics, contact, cell_length }
    }

    /// A copy changed by `turn`.
    pub(crate) fn with(&self, turn: impl FnOnce(&mut Self)) -> Self {
        let mut settings = self.clone();
        turn(&mut settings);
        settings
    }

    /// The scene with these settings.
    pub(crate) fn on(&self, scene: &Scene) -> Scene {
        let Self { numerics, mut contact, cell_length } = self.clone();
        if contact.zone == Zone::Slices {
            contact.cells_along = Some(Road::cells(scene.tyre.circumference / numerics.elements as f64, cell_length));
        }
        if contact.tread == Tread::Bedding || contact.slice_coupling != SliceCoupling::Local {
            contact.slices = contact.slices.alone();
        }
        let has_one = contact.slice_coupling == SliceCoupling::Local && contact.slices != Slices::Pressed;
        contact.local_compliance = contact.local_compliance.filter(|_| has_one);
        if contact.tread != scene.contact.tread {
            // Laws are compared at equal static stiffness.
            (contact.bedding_stiffness, contact.equal_stiffness) = (None, contact.tread == Tread::Uncoupled);
        }
        Scene { numerics, contact, ..scene.clone() }
    }

    pub(crate) fn steps(&self) -> usize {
        self.numerics.elements * self.numerics.substeps
    }

    /// Time step of a scene's tyre at its speed \[s\].
    pub(crate) fn time_step(&self, scene: &Scene) -> f64 {
        scene.tyre.circumference / (self.steps() as f64 * scene.rolling.speed())
    }

    /// The settings in one line.
    pub(crate) fn label(&self, scene: &Scene) -> String {
        let Self { numerics, contact, cell_length } = self;
        let (elements, substeps, rule) = (numerics.elements, numerics.substeps, numerics.time_rule.name());
        let mut label = format!("N = {elements}, q = {substeps}, {rule}");
        label += &match numerics.history {
            History::Modal => format!(", poles {:.0e}", numerics.pole_tolerance),
            History::Direct => format!(", memory {} s", numerics.memory),
        };
        let across = contact.cells_across.map(|points| 1e3 * scene.tyre.contact_width / points as f64);
        if let (Some(across), Zone::Cells) = (across, contact.zone) {
            label += &format!(", cells {across:.2} mm across");
        } else if let Some(across) = across {
            label += &format!(", cells {:.2} by {across:.2} mm", 1e3 * cell_length);
        }
        if contact.slice_tolerance > 0.0 {
            label += &format!(", curves {:.0e} m", contact.slice_tolerance);
        }
        label
    }
}
