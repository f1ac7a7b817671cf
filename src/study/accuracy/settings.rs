//! What trades accuracy for time in a scene: the settings that a study varies.

use serde::Serialize;

use crate::road::Lattice;
use crate::scene::{History, Road, Scene, SliceCoupling, Slices, TimeRule, Tread};

/// The settings of one run of a study; everything else is the scene's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Elements N round the tyre.
    pub elements: usize,
    /// Time steps per element.
    pub substeps: usize,
    /// Time rule.
    pub time_rule: TimeRule,
    /// How the past is carried along.
    pub history: History,
    /// Length of the force history \[s\], direct only.
    pub memory: f64,
    /// Tolerance of the poles, modal only.
    pub pole_tolerance: f64,
    /// Tolerance of the wavenumber sums.
    pub influence_tolerance: f64,
    /// A fixed number of lateral terms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lateral_terms: Option<usize>,
    /// A fixed largest alias.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavenumber_aliases: Option<usize>,
    /// Cells across the contact width; `None`: the road's own, or level across.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells_across: Option<usize>,
    /// Longest cell along an element \[m\].
    pub cell_length: f64,
    /// Tolerance of the slices' curves \[m\].
    pub slice_tolerance: f64,
    /// Tread law.
    pub tread: Tread,
    /// Slice law.
    pub slices: Slices,
    /// By how much a slice yields more than its element.
    pub slice_coupling: SliceCoupling,
    /// kappa of the local law \[m/Pa\]; `None`: by formula.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub local_compliance: Option<f64>,
}

impl Settings {
    /// Those of a scene.
    pub fn of(scene: &Scene) -> Self {
        let Scene { numerics, contact, .. } = scene;
        let across = Lattice::across(scene.tyre.contact_width, scene.road.cell());
        let made = matches!(scene.road, crate::scene::Road::Made(_) | crate::scene::Road::Profile(_));
        Self {
            elements: numerics.elements,
            substeps: numerics.substeps,
            time_rule: numerics.time_rule,
            history: numerics.history,
            memory: numerics.memory,
            pole_tolerance: numerics.pole_tolerance,
            influence_tolerance: numerics.influence_tolerance,
            lateral_terms: numerics.lateral_terms,
            wavenumber_aliases: numerics.wavenumber_aliases,
            // What a grid that fits keeps is not known here; a texture has no cells of its own.
            cells_across: contact.cells_across.or_else(|| (scene.road.varies_across() && made).then_some(across)),
            cell_length: contact
                .cells_along
                .map_or(scene.road.cell(), |cells| scene.tyre.circumference / (numerics.elements * cells) as f64),
            slice_tolerance: contact.slice_tolerance,
            tread: contact.tread,
            slices: contact.slices,
            slice_coupling: contact.slice_coupling,
            local_compliance: contact.local_compliance,
        }
    }

    /// The scene with these settings.
    pub fn on(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        let Scene { numerics, contact, tyre, .. } = &mut scene;
        (numerics.elements, numerics.substeps, numerics.time_rule) = (self.elements, self.substeps, self.time_rule);
        (numerics.history, numerics.memory) = (self.history, self.memory);
        (numerics.pole_tolerance, numerics.influence_tolerance) = (self.pole_tolerance, self.influence_tolerance);
        (numerics.lateral_terms, numerics.wavenumber_aliases) = (self.lateral_terms, self.wavenumber_aliases);
        (contact.cells_across, contact.slice_tolerance) = (self.cells_across, self.slice_tolerance);
        let element = tyre.circumference / self.elements as f64;
        contact.cells_along = Some(Road::cells(element, self.cell_length));
        (contact.slices, contact.slice_coupling) = (self.slices, self.slice_coupling);
        contact.local_compliance = self.local_compliance.filter(|_| self.slice_coupling == SliceCoupling::Local);
        if contact.tread != self.tread {
            contact.tread = self.tread;
            // Laws are compared at equal static stiffness.
            (contact.bedding_stiffness, contact.equal_stiffness) = (None, self.tread == Tread::Uncoupled);
        }
        if contact.tread == Tread::Uncoupled && contact.slice_coupling == SliceCoupling::Implicit {
            contact.slice_coupling = SliceCoupling::Explicit;
        }
        scene
    }

    /// Time steps in a revolution.
    pub fn steps(&self) -> usize {
        self.elements * self.substeps
    }

    /// Time step of a scene's tyre at its speed \[s\].
    pub fn time_step(&self, scene: &Scene) -> f64 {
        scene.tyre.circumference / (self.steps() as f64 * scene.rolling.speed())
    }

    /// In a line.
    pub fn label(&self, scene: &Scene) -> String {
        let mut parts =
            vec![format!("N = {}", self.elements), format!("q = {}", self.substeps), self.time_rule.name().to_owned()];
        match self.history {
            History::Modal => parts.push(format!("poles {:.0e}", self.pole_tolerance)),
            History::Direct => parts.push(format!("memory {} s", self.memory)),
        }
        if let Some(points) = self.cells_across {
            let across = scene.tyre.contact_width / points as f64;
            parts.push(format!("cells {:.2} by {:.2} mm", 1e3 * self.cell_length, 1e3 * across));
        }
        if self.slice_tolerance > 0.0 {
            parts.push(format!("curves {:.0e} m", self.slice_tolerance));
        }
        parts.join(", ")
    }
}
