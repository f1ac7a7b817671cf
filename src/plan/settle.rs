//! Decides settings that a scene leaves open: elements, steps, rule, history, tolerances and cells from `fmax`,
//! `preset` and `accuracy`. What the scene gives stays.

use serde::Serialize;

use super::front::FrontRow;
use super::resolution::{Need, Resolution};
use super::stated::Unstated;
use crate::scene::{
    Axle, Diagnostic, History, LoadedScene, Numerics, OF_SLICES, Road, Scene, SceneError, Switch, Tyre, Zone, short,
};
use crate::time_rule::Advance;

/// A setting that the scene left open or that has another source than the scene, and its reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PlannedSetting {
    /// Key in the scene.
    pub key: &'static str,
    /// Chosen value, as text.
    pub value: String,
    /// Why it was chosen.
    pub reason: String,
}

/// Keys that choose a row of the table.
const WISHES: [&str; 2] = ["numerics.preset", "numerics.accuracy"];

/// Decides every setting of a scene; returns the scene and the choices.
///
/// # Errors
/// [`SceneError::Invalid`] where wishes contradict each other, or given numbers cannot reach them.
pub(crate) fn decide(loaded: &LoadedScene) -> Result<(Scene, Vec<PlannedSetting>), SceneError> {
    settle(Settling { loaded, scene: loaded.scene.clone(), choices: Vec::new(), row_alone: false })
}

/// Tension of the layers along the belt, with that from inflation and the sidewalls' arcs; empty for a tyre without
/// these.
pub(crate) fn tension(tyre: &Tyre) -> Vec<PlannedSetting> {
    let Some(carried) = tyre.carried_tension() else { return Vec::new() };
    let used = tyre.tension_along();
    let reason = if tyre.tension_is_carried() {
        format!("pressure and sidewalls give {carried:.3e} N/m along")
    } else {
        format!("given; pressure and sidewalls would give {carried:.3e} N/m along")
    };
    vec![PlannedSetting { key: "tyre.layers.tension", value: format!("{used:.3e} N/m along all layers"), reason }]
}

/// Keys to which a scene gives other values than its preset or accuracy would, in words.
pub(crate) fn overridden(loaded: &LoadedScene, scene: &Scene) -> Vec<String> {
    let Numerics { preset, accuracy, .. } = loaded.scene.numerics;
    let wish = match (preset, accuracy) {
        (Some(preset), _) => format!("preset = \"{}\"", preset.name()),
        (None, Some(accuracy)) => format!("accuracy = \"{} dB\"", short(accuracy)),
        (None, None) => return Vec::new(),
    };
    let mut alone = loaded.scene.clone();
    (alone.contact.cells_across, alone.contact.cells_along) = (None, None);
    let alone = settle(Settling { loaded, scene: alone, choices: Vec::new(), row_alone: true });
    let Ok((alone, choices)) = alone else { return Vec::new() };
    let (Ok(taken), Ok(used)) = (alone.to_json(), scene.to_json()) else { return Vec::new() };
    let reported = |choice: &PlannedSetting| {
        let (table, key) = choice.key.split_once('.')?;
        let [given, taken] = [&used, &taken].map(|scene| &scene[table][key]);
        let is_overridden = loaded.gives(choice.key) && given != taken && !taken.is_null();
        is_overridden.then(|| {
            let key = choice.key;
            format!(
                "{key} = {given} of the scene replaces {taken} of {wish}, whose stated accuracy holds for its own \
                 values only; --set {key}= removes the key"
            )
        })
    };
    choices.iter().filter_map(reported).collect()
}

fn settle(mut settling: Settling<'_>) -> Result<(Scene, Vec<PlannedSetting>), SceneError> {
    let loaded = settling.loaded;
    let Numerics { fmax, preset, accuracy, .. } = loaded.scene.numerics;
    if preset.is_some() || accuracy.is_some() {
        settling.take_zone();
    }
    let zone = settling.scene.contact.zone;
    let row = match (preset, accuracy) {
        (Some(preset), _) => Some(FrontRow::of(preset, zone)),
        (None, Some(accuracy)) => {
            let scene = &settling.scene;
            Some(FrontRow::within(accuracy, scene).ok_or_else(|| not_stated(loaded, scene, accuracy))?)
        }
        (None, None) => None,
    };
    // The scene's reader requires fmax beside a preset and an accuracy.
    if let Some(highest) = fmax {
        if let Some(row) = row {
            settling.take_row(row, highest);
        }
        settling.take_resolution(Need { highest, row })?;
        if let Some(row) = row {
            settling.take_cells_along(row, highest);
            // Settings that the scene gives itself may invalidate the row's error.
            if let Err(why @ (Unstated::Coarser(_) | Unstated::OfAnotherKind(_))) =
                FrontRow::stated_error(&settling.scene)
            {
                let wish = settling.choices.iter_mut().find(|choice| WISHES.contains(&choice.key));
                wish.into_iter().for_each(|wish| wish.reason = why.to_string());
            }
            // A preset beside keys that are all given has chosen nothing.
            if settling.choices.len() == 1 {
                settling.choices.clear();
            }
        }
    }
    Ok((settling.scene, settling.choices))
}

/// Complaint about an accuracy \[dB\] that no row of the table states.
fn not_stated(loaded: &LoadedScene, scene: &Scene, accuracy: f64) -> Diagnostic {
    let (zone, fmax) = (scene.contact.zone, scene.numerics.fmax.unwrap_or_default());
    if scene.friction.is_some() {
        let right = "a preset, or settings of your own";
        return loaded.complain("numerics.accuracy", "no error is stated with friction", right);
    }
    let Some(finest) = FrontRow::finest_error(scene, fmax) else {
        let [row, ..] = FrontRow::all(zone);
        let stated = row.stated_to.into_iter().rfind(|&to| FrontRow::finest_error(scene, to).is_some());
        let wrong = format!("no error is stated for fmax = {} Hz on this road", short(fmax));
        let right = format!("fmax up to {} Hz, a preset, or settings of your own", short(stated.unwrap_or_default()));
        return loaded.complain("numerics.accuracy", wrong, right);
    };
    let wrong = format!("{} dB is finer than any row of the table states", short(accuracy));
    let slices = if zone == Zone::Cells { ", contact.zone = \"slices\"" } else { "" };
    let right = format!("at least {} dB{slices}, or settings of your own", short(finest));
    loaded.complain("numerics.accuracy", wrong, right)
}

/// A scene whose open settings are being decided.
struct Settling<'a> {
    loaded: &'a LoadedScene,
    scene: Scene,
    choices: Vec<PlannedSetting>,
    /// True if the row of the table overrides settings that the scene gives.
    row_alone: bool,
}

impl Settling<'_> {
    fn choose(&mut self, key: &'static str, value: String, reason: String) {
        self.choices.push(PlannedSetting { key, value, reason });
    }

    /// Chooses cells for a scene with receivers, if it gives no key of the contact that cells do not have.
    fn take_zone(&mut self) {
        let Scene { receivers, effects, road, rolling, numerics, .. } = &self.scene;
        let has_texture = road.varies_across() && effects.texture != Switch::Off;
        let of_slices = matches!(rolling.axle, Axle::Mass { .. })
            || numerics.lateral_terms.is_some()
            || ["zone", "tread"].iter().chain(&OF_SLICES).any(|key| self.loaded.gives(&format!("contact.{key}")));
        if !receivers.is_empty() && has_texture && !of_slices {
            self.scene.contact.zone = Zone::Cells;
        }
    }

    /// Takes the settings of a row of the table, except elements and steps.
    fn take_row(&mut self, row: &FrontRow, highest: f64) {
        let name = row.preset.name();
        let why = format!("preset \"{name}\"");
        let error = row.error_for(&self.scene, highest).map_or_else(
            || "no error is stated for such a scene,".to_owned(),
            |error| {
                let [elements, cells, steps] = row.parts;
                let parts = format!("elements {elements:.1}, cells {cells:.1}, steps {steps:.1} dB up to 1 kHz");
                format!("third octaves within {} dB up to fmax ({parts})", short(error))
            },
        );
        let error_and_work = format!("{error} at {} times the work of \"standard\"", short(row.cost));
        if self.scene.numerics.preset.is_some() {
            self.choose("numerics.preset", name.to_owned(), format!("given: {error_and_work}"));
        } else {
            self.choose("numerics.accuracy", why.clone(), format!("the cheapest that keeps it: {error_and_work}"));
        }
        if self.scene.contact.zone != self.loaded.scene.contact.zone {
            let reason = format!("{why} of a sound: slices drive no waves that are odd across, and end below fmax");
            self.choose("contact.zone", "cells".to_owned(), reason);
        }
        let (loaded, row_alone) = (self.loaded, self.row_alone);
        let open = |key: &str| row_alone || !loaded.gives(key);
        let (rule, history, poles) =
            (open("numerics.time_rule"), open("numerics.history"), open("numerics.pole_tolerance"));
        // A row whose value is the default chooses nothing.
        let slices = open("contact.slice_tolerance")
            && self.scene.contact.zone == Zone::Slices
            && self.scene.contact.slice_tolerance.to_bits() != row.slice_tolerance.to_bits();
        if rule && self.scene.friction.is_some() {
            // Friction has chosen it already.
            let name = self.scene.numerics.time_rule.name().to_owned();
            self.choose("numerics.time_rule", name, "[friction]: the rule dissipates in every step".to_owned());
        } else if rule {
            self.scene.numerics.time_rule = row.time_rule;
            self.choose("numerics.time_rule", row.time_rule.name().to_owned(), why.clone());
        }
        if history {
            self.scene.numerics.history = History::Modal;
            self.choose("numerics.history", "modal".to_owned(), format!("{why}: the whole history, at the least work"));
        }
        if poles && self.scene.numerics.history == History::Modal {
            self.scene.numerics.pole_tolerance = row.pole_tolerance;
            self.choose("numerics.pole_tolerance", format!("{:.0e}", row.pole_tolerance), why.clone());
        }
        if open("numerics.contact_tolerance") {
            self.scene.numerics.contact_tolerance = row.contact_tolerance;
            self.choose("numerics.contact_tolerance", format!("{:.0e}", row.contact_tolerance), why.clone());
        }
        let has_texture = self.scene.effects.texture != Switch::Off;
        if slices && has_texture {
            self.scene.contact.slice_tolerance = row.slice_tolerance;
            self.choose("contact.slice_tolerance", format!("{:.0e}", row.slice_tolerance), why.clone());
        }
        let Scene { contact, road, .. } = &self.scene;
        let has_cells = contact.zone == Zone::Cells || has_texture && road.varies_across();
        if contact.cells_across.is_none() && contact.cell.is_none() && has_cells {
            let cells = row.cells_across(&self.scene, highest);
            let reason =
                format!("{why}: cells of at most {} mm across", millimetres(row.cell_for(&self.scene, highest)));
            self.scene.contact.cells_across = Some(cells);
            self.choose("contact.cells_across", cells.to_string(), reason);
        }
    }

    /// Chooses elements, and substeps or elements per step, for a need; refuses given ones that do not reach it.
    fn take_resolution(&mut self, need: Need) -> Result<(), SceneError> {
        let is_given = |key: &str| !self.row_alone && self.loaded.gives(key);
        let elements = is_given("numerics.elements").then_some(self.scene.numerics.elements);
        let advance = (is_given("numerics.substeps") || is_given("numerics.elements_per_step"))
            .then(|| self.scene.numerics.advance());
        let Scene { tyre, rolling, numerics, .. } = &mut self.scene;
        let (length, speed, rule) = (tyre.circumference, rolling.speed(), numerics.time_rule);
        let found = Resolution::new(need, length, speed, rule, elements, advance);
        numerics.elements = found.elements;
        numerics.take_advance(found.advance);
        let (texture, highest) = (found.texture_limit(length, speed), need.highest);
        let speed_kmh = rolling.speed_kmh;
        if elements.is_some() && texture < highest {
            let wrong = format!(
                "{} elements hold no texture above {texture:.0} Hz at {speed_kmh} km/h, and numerics.fmax = {} Hz is \
                 wanted",
                found.elements,
                short(highest)
            );
            let wanted = Resolution::new(need, length, speed, rule, None, None).elements;
            return Err(self.loaded.complain("numerics.elements", wrong, format!("{wanted}, or leave it out")).into());
        }
        let limit = found.rule_limit(need, length, speed, rule);
        let percent = (100.0 * need.rule_error()).round();
        if advance.is_some() && limit < (1.0 - 1e-9) * highest {
            let wrong = format!(
                "{} keep phase and damping of {} within {percent} % up to {limit:.0} Hz, and numerics.fmax = {} Hz is \
                 wanted",
                match found.advance {
                    Advance { substeps, elements_per_step: 1 } => format!("{substeps} steps per element"),
                    Advance { elements_per_step, .. } => format!("steps of {elements_per_step} elements"),
                },
                rule.name(),
                short(highest)
            );
            let enough = Resolution::new(need, length, speed, rule, Some(found.elements), None);
            let Advance { substeps, elements_per_step } = enough.advance;
            let key = found.key_of_advance();
            let number = if key == "numerics.substeps" { substeps } else { elements_per_step };
            return Err(self.loaded.complain(key, wrong, format!("{number}, or leave it out")).into());
        }
        if elements.is_none() {
            let reason = format!(
                "fmax = {highest} Hz: {:.1} per texture wavelength at {speed_kmh} km/h, none longer than {} mm",
                2.0 * texture / highest,
                short(1e3 * need.longest_element())
            );
            self.choose("numerics.elements", found.elements.to_string(), reason);
        }
        if advance.is_none() {
            let reason = format!(
                "{:.1} steps in a period of fmax; {} stays within {percent} % in phase and damping up to {limit:.0} Hz",
                found.steps_per_second(length, speed) / highest,
                rule.name()
            );
            let Advance { substeps, elements_per_step } = found.advance;
            self.choose(found.key_of_advance(), substeps.max(elements_per_step).to_string(), reason);
        }
        Ok(())
    }

    fn take_cells_along(&mut self, row: &FrontRow, highest: f64) {
        let Scene { tyre, road, contact, numerics, .. } = &self.scene;
        if contact.cells_along.is_some() || contact.zone == Zone::Cells || matches!(road, Road::Smooth) {
            return;
        }
        let cell = row.cell_for(&self.scene, highest);
        let cells = Road::cells(tyre.circumference / numerics.elements as f64, cell);
        self.scene.contact.cells_along = Some(cells);
        let reason = format!("preset \"{}\": cells of at most {} mm along", row.preset.name(), millimetres(cell));
        self.choose("contact.cells_along", cells.to_string(), reason);
    }
}

/// A length in mm, to a hundredth.
fn millimetres(length: f64) -> String {
    short((1e5 * length).round() / 100.0)
}
