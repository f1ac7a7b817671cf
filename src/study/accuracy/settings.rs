//! Options of a study, and the settings of a scene that it varies, which trade accuracy for time.

use crate::plan::decisions::{cells_across, square_cells};
use crate::plan::front::{FrontRow, cell_for};
use crate::plan::resolution::{Need, Resolution};
use crate::road::Lattice;
use crate::scene::{Contact, History, Numerics, Road, Scene, TimeRule, Zone};
use serde::Serialize;

/// Tolerance of the reference's poles over cells, which are needed for each pair of wavenumbers, and of its contact
/// conditions there, unless the scene's is finer.
const POLES_OF_CELLS: f64 = 1e-5;
const CONTACT_OF_CELLS: f64 = 1e-6;
/// Its cell size, relative to [`cell_for`].
const FINEST_CELL: f64 = 0.5;

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
        let of_law = contact.cell_of_law(&scene.road);
        // Whether a measured grid keeps its own cells is not known here; a texture has none.
        let resolved = matches!(scene.road, Road::Made(_) | Road::Profile(_)) && of_law.is_none();
        let across = || Lattice::across(scene.tyre.contact_width, scene.road.cell());
        contact.cells_across = contact.cells_across.or_else(|| (scene.road.varies_across() && resolved).then(across));
        if contact.zone == Zone::Cells {
            contact.cell = None;
            contact.cells_across = Some(cells_across(scene));
        }
        let along = |cells: usize| scene.tyre.circumference / (numerics.elements * cells) as f64;
        let cell_length = contact.cells_along.take().map_or(of_law.unwrap_or_else(|| scene.road.cell()), along);
        Self { numerics, contact, cell_length }
    }

    /// Settings that a row of the table of presets chooses for a scene up to `highest` \[Hz\].
    pub(crate) fn of_row(scene: &Scene, row: &'static FrontRow, highest: f64) -> Self {
        let mut settings = Self::of(scene);
        let Self { numerics, contact, cell_length } = &mut settings;
        let need = Need { highest, row: Some(row) };
        let (length, speed) = (scene.tyre.circumference, scene.rolling.speed());
        let Resolution { elements, advance } = Resolution::new(need, length, speed, row.time_rule, None, None);
        numerics.take_advance(advance);
        (numerics.elements, numerics.time_rule) = (elements, row.time_rule);
        (numerics.history, numerics.pole_tolerance) = (History::Modal, row.pole_tolerance);
        (numerics.lateral_terms, numerics.wavenumber_aliases) = (None, None);
        numerics.contact_tolerance = row.contact_tolerance;
        let across = row.cells_across(scene, highest);
        if contact.zone == Zone::Cells {
            contact.cells_across = Some(across);
        } else {
            *cell_length = row.cell_for(scene, highest);
            contact.cells_across = contact.cells_across.map(|_| across);
            contact.slice_tolerance = row.slice_tolerance;
        }
        settings
    }

    /// Settings of the reference: twice the scene's elements and as many steps as the highest frequency needs, unless
    /// given.
    pub(crate) fn reference(scene: &Scene, options: &StudyOptions) -> Self {
        let StudyOptions { highest, elements, substeps, sweep, .. } = *options;
        // Steps in a period of the highest frequency, tolerances of poles and sums.
        let (per_period, poles, sums) = if sweep == Sweep::Outline { (24.0, 1e-5, 1e-7) } else { (48.0, 5e-6, 1e-8) };
        let mut settings = Self::of(scene);
        let Self { numerics, contact, cell_length } = &mut settings;
        // A multiple of 16: all parts of it are even.
        let elements = elements.unwrap_or(2 * numerics.elements).div_ceil(16) * 16;
        let substeps = substeps.unwrap_or_else(|| {
            let steps = per_period * highest * scene.tyre.circumference / scene.rolling.speed();
            // An even number: it is halved to see whether it is enough.
            (0.5 * steps / elements as f64).ceil().max(1.0) as usize * 2
        });
        numerics.take_advance(substeps.into());
        numerics.elements = elements;
        if numerics.time_rule.runge_kutta().is_none() {
            numerics.time_rule = TimeRule::Bdf2;
        }
        numerics.history = History::Modal;
        (numerics.lateral_terms, numerics.wavenumber_aliases) = (None, None);
        if contact.zone == Zone::Cells {
            numerics.pole_tolerance = POLES_OF_CELLS;
            numerics.contact_tolerance = numerics.contact_tolerance.min(CONTACT_OF_CELLS);
            let square = square_cells(&scene.tyre, elements);
            contact.cells_across = contact.cells_across.map(|across| square.max(2 * across));
        } else {
            (numerics.pole_tolerance, numerics.influence_tolerance) = (poles, sums);
            numerics.contact_tolerance = Numerics::default().contact_tolerance;
            let of_law = contact.cell_of_law(&scene.road).filter(|_| contact.cells_across.is_none());
            *cell_length = of_law.unwrap_or_else(|| FINEST_CELL * cell_for(scene, highest));
            contact.cells_across =
                contact.cells_across.map(|_| Lattice::across(scene.tyre.contact_width, *cell_length));
            contact.slice_tolerance = 0.0;
        }
        settings
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
        Scene { numerics, contact, ..scene.clone() }
    }

    pub(crate) fn steps(&self) -> usize {
        self.numerics.advance().steps(self.numerics.elements)
    }

    /// Time steps of a scene's tyre at its speed \[Hz\].
    pub(crate) fn rate(&self, scene: &Scene) -> f64 {
        self.steps() as f64 * scene.rolling.speed() / scene.tyre.circumference
    }

    /// The settings in one line.
    pub(crate) fn label(&self) -> String {
        let Self { numerics, contact, .. } = self;
        let (elements, advance, rule) = (numerics.elements, numerics.advance(), numerics.time_rule.name());
        let cells = contact.cells_across.map_or_else(String::new, |cells| format!(", {cells} cells across"));
        let history = match numerics.history {
            History::Modal => format!("poles {:.0e}", numerics.pole_tolerance),
            History::Direct => format!("memory {} s", numerics.memory),
        };
        let has_curves = contact.zone == Zone::Slices && contact.slice_tolerance > 0.0;
        let curves = if has_curves { format!(", curves {:.0e} m", contact.slice_tolerance) } else { String::new() };
        format!("N = {elements}, {advance}, {rule}, {history}{cells}{curves}")
    }
}

/// Extent of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sweep {
    /// The scene's settings, and every other value of the knobs, against a coarser reference: minutes.
    Outline,
    /// The presets, the scene's settings, and every knob.
    Knobs,
    /// The presets alone.
    Presets,
}

/// Extent of a study, and how it compares.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StudyOptions {
    /// Highest frequency compared \[Hz\].
    pub highest: f64,
    /// Time compared \[s\].
    pub duration: f64,
    /// Its extent.
    pub sweep: Sweep,
    /// Elements of the reference; default: twice the scene's, or a quarter more than the finest preset's where the
    /// presets are rolled.
    pub elements: Option<usize>,
    /// Steps per element of the reference; default: 48 steps in a period of `highest`, 24 for an outline.
    pub substeps: Option<usize>,
}

impl StudyOptions {
    /// Up to the scene's fmax, or 1 kHz; over the scene's duration, at most a second.
    pub fn new(scene: &Scene, sweep: Sweep) -> Self {
        let (highest, duration) = (scene.numerics.fmax.unwrap_or(1000.0), scene.rolling.duration.min(1.0));
        Self { highest, duration, sweep, elements: None, substeps: None }
    }
}
