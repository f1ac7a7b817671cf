//! What trades accuracy for time in a scene: the settings that a study varies.

use serde::Serialize;

use crate::road::Lattice;
use crate::scene::{History, Scene, SliceCoupling, Slices, TimeRule, Tread};

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
    /// Tolerance of the slices' curves \[m\].
    pub slice_tolerance: f64,
    /// Tread law.
    pub tread: Tread,
    /// Slice law.
    pub slices: Slices,
    /// Which penetration the slices' curves are read at.
    pub slice_coupling: SliceCoupling,
}

impl Settings {
    /// Those of a scene.
    pub fn of(scene: &Scene) -> Self {
        let Scene { numerics, contact, .. } = scene;
        let across = Lattice::usual_across(scene.tyre.contact_width);
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
            slice_tolerance: contact.slice_tolerance,
            tread: contact.tread,
            slices: contact.slices,
            slice_coupling: contact.slice_coupling,
        }
    }

    /// The scene with these settings.
    pub fn on(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        let Scene { numerics, contact, .. } = &mut scene;
        (numerics.elements, numerics.substeps, numerics.time_rule) = (self.elements, self.substeps, self.time_rule);
        (numerics.history, numerics.memory) = (self.history, self.memory);
        (numerics.pole_tolerance, numerics.influence_tolerance) = (self.pole_tolerance, self.influence_tolerance);
        (numerics.lateral_terms, numerics.wavenumber_aliases) = (self.lateral_terms, self.wavenumber_aliases);
        (contact.cells_across, contact.slice_tolerance) = (self.cells_across, self.slice_tolerance);
        (contact.slices, contact.slice_coupling) = (self.slices, self.slice_coupling);
        if contact.tread != self.tread {
            contact.tread = self.tread;
            // Laws are compared at equal static stiffness.
            (contact.bedding_stiffness, contact.equal_stiffness) = (None, self.tread == Tread::Uncoupled);
        }
        if contact.tread == Tread::Uncoupled {
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
            parts.push(format!("cells {:.2} mm", 1e3 * scene.tyre.contact_width / points as f64));
        }
        if self.slice_tolerance > 0.0 {
            parts.push(format!("curves {:.0e} m", self.slice_tolerance));
        }
        parts.join(", ")
    }
}
