//! Zone of the contact, texture, and coupling of points in contact. Friction: whether tangential forces act, and by
//! which law.

use crate::road::Lattice;
use crate::scene::{
    Coefficient, FallingFriction, LongitudinalCreep, PatchAir, Road, Scene, SliceCoupling, Slices, Switch, Tread, Tyre,
    Zone,
};
use crate::tyre::tread_pattern::map::{TreadCells, TreadMap};

use super::tread_pattern::taken_pattern;
use super::values::{Decided, DecisionRow, Decisions, given};

pub(super) const ZONE: DecisionRow = DecisionRow {
    title: "contact in three dimensions",
    short: "cells",
    decide: zone,
    switch: Some(|scene, on| {
        scene.contact.zone = if on { Zone::Cells } else { Zone::Slices };
        if !on {
            // The cell size of contact over cells is not a resolution of the texture in slices.
            (scene.contact.cell, scene.contact.cells_across, scene.contact.sub_cells) = (None, None, None);
            scene.outputs.cells_every = None;
            // Slices have no blocks that press air out, and no voids of the road.
            let grooves = scene.tread_pattern.iter().flat_map(|pattern| &pattern.grooves);
            let has_grooves = grooves.into_iter().any(|groove| groove.depth > 0.0);
            if let Some(pumping) = &mut scene.air_pumping {
                pumping.squeeze = false;
                if pumping.patch == PatchAir::Voids {
                    pumping.patch = if has_grooves { PatchAir::Grooves } else { PatchAir::Sealed };
                }
            }
            if let Some(vibration) = &mut scene.outputs.vibration {
                vibration.lateral_tolerance = None;
            }
        }
    }),
    of_cells: true,
};

pub(super) const TEXTURE: DecisionRow = DecisionRow {
    title: "texture across the width",
    short: "texture",
    decide: texture,
    switch: Some(|scene, on| {
        scene.effects.texture = if on { Switch::On } else { Switch::Off };
        if !on {
            scene.contact.cells_across = None;
        }
    }),
    of_cells: false,
};

pub(super) const SLICE_COUPLING: DecisionRow = DecisionRow {
    title: "slice coupling",
    short: "slices",
    decide: slice_coupling,
    switch: Some(|scene, on| {
        scene.contact.slice_coupling = if on { SliceCoupling::Local } else { SliceCoupling::Explicit };
        if !on {
            scene.contact.local_compliance = None;
            scene.contact.slices = scene.contact.slices.alone();
        }
    }),
    of_cells: false,
};

pub(super) const TREAD_COUPLING: DecisionRow = DecisionRow {
    title: "tread coupling",
    short: "tread",
    decide: tread_coupling,
    switch: Some(|scene, on| {
        let without = if scene.contact.tread == Tread::Bedding { Tread::Bedding } else { Tread::Uncoupled };
        scene.contact.tread = if on { Tread::Elastic } else { without };
        if on {
            (scene.contact.bedding_stiffness, scene.contact.equal_stiffness) = (None, false);
            return;
        }
        // Independent springs do not conserve volume: the air under them has no paths.
        scene.air_pumping = None;
    }),
    of_cells: false,
};

fn zone(scene: &Scene, _: &mut Decisions) -> Decided {
    let Scene { contact, tyre, .. } = scene;
    let (on, form) = match contact.zone {
        Zone::Slices => (false, "slices, one for each element".to_owned()),
        Zone::Cells => {
            let crown = tyre.crown_radius.map_or("a level tread".to_owned(), |radius| format!("a crown of {radius} m"));
            let cells = cells_across(scene);
            let sub_cells = match contact.sub_cells.unwrap_or(1) {
                1 => String::new(),
                number => format!(" with {number} x {number} sub-cells each"),
            };
            (true, format!("{cells} cells across {:.0} mm{sub_cells}, {crown}", 1e3 * tyre.contact_width))
        }
    };
    let name = if on { "cells" } else { "slices" };
    Decided { on, form, reason: format!("contact.zone = \"{name}\"") }
}

/// Number of cells across the strip: as given, or so that cells are about square.
pub(crate) fn cells_across(scene: &Scene) -> usize {
    let Scene { contact, tyre, numerics, .. } = scene;
    let given = contact.cell.map(|size| Lattice::across(tyre.contact_width, size));
    contact.cells_across.or(given).unwrap_or_else(|| square_cells(tyre, numerics.elements))
}

/// Number of cells across the strip for which cells are about as wide as elements are long.
pub(crate) fn square_cells(tyre: &Tyre, elements: usize) -> usize {
    Lattice::across(tyre.contact_width, tyre.circumference / elements as f64)
}

fn texture(scene: &Scene, decisions: &mut Decisions) -> Decided {
    let switch = scene.effects.texture;
    if scene.contact.zone == Zone::Cells {
        (decisions.slices, decisions.cells_across) = (None, Some(cells_across(scene)));
        return Decided::on("heights of cells", "contact.zone = \"cells\"");
    }
    if let Some(pattern) = taken_pattern(scene) {
        let (elements, along) =
            (scene.numerics.elements, decisions.cells_along.or(scene.contact.cells_along).unwrap_or(1));
        let across = scene.contact.cells_across.unwrap_or_else(|| {
            let square = TreadCells { columns: elements * along, across: square_cells(&scene.tyre, elements) };
            TreadMap::fewest_across(pattern, scene, square)
        });
        (decisions.slices, decisions.cells_across) = (Some(Slices::Winkler), Some(across));
        decisions.cells_along = Some(along);
        return Decided::on("springs all over each slice", "the tread has a pattern");
    }
    let varies = scene.road.varies_across();
    // A road that is level across is not flat along an element, unless that is one cell.
    let flat = matches!(scene.road, Road::Smooth) || scene.contact.cells_along == Some(1);
    let law = (!flat).then_some(scene.contact.slices);
    let mut level = |form: &str, reason: String| {
        (decisions.slices, decisions.cells_across) = (law, Some(1));
        Decided { on: false, form: form.to_owned(), reason }
    };
    if switch == Switch::Off {
        let form = if varies { "middle line of the road, level across" } else { "" };
        return level(form, "effects.texture = \"off\"".to_owned());
    }
    if !varies {
        let road =
            if matches!(scene.road, Road::Smooth) { "the road is smooth" } else { "the road is the same all across" };
        return level("", format!("auto: {road}"));
    }
    if scene.contact.cells_across == Some(1) {
        return level("", "contact.cells_across = 1".to_owned());
    }
    let law = match scene.contact.slices {
        Slices::Winkler => "springs all over each slice",
        Slices::HalfSpace => "each line across on an elastic half-space",
        Slices::Pressed => "the road pressed in three dimensions by the flat tread",
    };
    let reason =
        given(switch, "texture").unwrap_or_else(|| "auto: the road varies across the contact width".to_owned());
    (decisions.slices, decisions.cells_across) = (Some(scene.contact.slices), scene.contact.cells_across);
    if scene.contact.slices == Slices::Pressed {
        let note =
            "the road is pressed as the tyre comes near, half a second for each metre on a slow core, and kept on disk";
        decisions.notes.push(note.to_owned());
    }
    let pressed = (scene.contact.slices == Slices::Pressed).then_some(Road::CELL);
    if let Some(size) = scene.contact.cell_of_law(&scene.road).or(pressed) {
        let element = scene.tyre.circumference / scene.numerics.elements as f64;
        decisions.cells_across.get_or_insert_with(|| Lattice::across(scene.tyre.contact_width, size));
        decisions.cells_along.get_or_insert_with(|| Road::cells(element, size));
    }
    Decided::on(law, reason)
}

fn slice_coupling(scene: &Scene, decisions: &mut Decisions) -> Decided {
    decisions.slice_coupling = SliceCoupling::Explicit;
    if scene.contact.zone == Zone::Cells {
        return Decided::off("cells have no law of their own");
    }
    // The explicit form can keep its factors.
    if decisions.slices.is_none() {
        return Decided::off("slices that are level are the same by every form");
    }
    match scene.contact.slice_coupling {
        SliceCoupling::Local => {
            let reason = match scene.contact.local_compliance {
                _ if decisions.slices == Some(Slices::Pressed) => "from the pressed road".to_owned(),
                Some(kappa) => format!("contact.local_compliance = {kappa:e} m/Pa"),
                None => "its compliance from the tread's modulus and the road's texture".to_owned(),
            };
            decisions.slice_coupling = SliceCoupling::Local;
            Decided::on("each slice yields by a compliance of its own", reason)
        }
        SliceCoupling::Explicit => {
            decisions.notes.push(
                "the paper's slice coupling takes the element's influence of one time step for the slice's spring: \
                 levels have no limit as the time step falls; \
                 contact.slice_coupling = \"local\" has one"
                    .to_owned(),
            );
            let form = "curves read without the neighbours' forces of the step".to_owned();
            Decided { form, ..Decided::off("contact.slice_coupling = \"explicit\"") }
        }
    }
}

fn tread_coupling(scene: &Scene, _: &mut Decisions) -> Decided {
    let tread = scene.contact.tread;
    let (on, form) = match tread {
        Tread::Elastic => (true, "elastic layer"),
        Tread::Uncoupled => (false, "points in contact are coupled from the next step on; elastic in the limit"),
        Tread::Bedding => (false, "independent springs on the carcass"),
    };
    let name = match tread {
        Tread::Elastic => "elastic",
        Tread::Uncoupled => "uncoupled",
        Tread::Bedding => "bedding",
    };
    Decided { on, form: form.to_owned(), reason: format!("contact.tread = \"{name}\"") }
}

pub(super) const FRICTION: DecisionRow = DecisionRow {
    title: "friction",
    short: "friction",
    decide: friction,
    // A scene without [friction] refuses to have it switched on.
    switch: Some(|scene, on| {
        scene.effects.friction = if on { Switch::On } else { Switch::Auto };
        if !on {
            (scene.friction, scene.adhesion) = (None, None);
        }
    }),
    of_cells: true,
};

fn friction(scene: &Scene, _: &mut Decisions) -> Decided {
    let reason = given(scene.effects.friction, "friction");
    let Some(friction) = &scene.friction else {
        return Decided::off(reason.unwrap_or_else(|| "auto: the scene has no [friction]".to_owned()));
    };
    let law = match friction.coefficient() {
        Coefficient::Constant(mu) => format!("mu = {mu}"),
        Coefficient::Falling(FallingFriction { slow, fast, .. }) => format!("mu from {slow} down to {fast}"),
    };
    let rolling = match friction.creep.longitudinal {
        LongitudinalCreep::Given(_) => "",
        LongitudinalCreep::Free => ", rolls freely",
    };
    let law = format!("{law}{rolling}");
    let form = scene.adhesion.as_ref().map_or(law.clone(), |pull| format!("{law}, a pull of {} Pa", pull.stress));
    let reason = reason.unwrap_or_else(|| "the scene has [friction]".to_owned());
    Decided { on: scene.has_tractions(), form, reason }
}
