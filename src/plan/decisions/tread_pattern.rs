//! Pattern of the tread, and its blocks.

use super::values::{Decided, DecisionRow, Decisions, given};
use crate::scene::{BlockModel, Scene, Slices, Switch, TreadPattern, Zone};
use crate::tyre::tread_pattern::PatternFault;
use crate::tyre::tread_pattern::blocks::TreadBlocks;
use crate::tyre::tread_pattern::map::{TreadCells, TreadMap};

/// Share of void beyond which a pattern is noted.
const MOST_VOID: f64 = 0.6;

pub(super) const TREAD_PATTERN: DecisionRow = DecisionRow {
    title: "tread pattern",
    short: "pattern",
    decide: pattern,
    switch: Some(|scene, on| {
        scene.effects.tread_pattern = match (on, &scene.tread_pattern) {
            (false, _) => Switch::Off,
            (true, Some(_)) => Switch::Auto,
            // Refused by name: a pattern that the scene does not give cannot be switched on.
            (true, None) => Switch::On,
        };
    }),
    of_cells: true,
};

pub(super) const BLOCKS: DecisionRow = DecisionRow {
    title: "tread blocks",
    short: "blocks",
    decide: blocks,
    switch: Some(|scene, on| {
        let Some(pattern) = &mut scene.tread_pattern else {
            scene.effects.tread_pattern = if on { Switch::On } else { Switch::Off };
            return;
        };
        pattern.blocks = if on { BlockModel::Compliant } else { BlockModel::Continuum };
        if !on {
            pattern.block_compliance = None;
            // Nothing yields that could press air out.
            scene.air_pumping.iter_mut().for_each(|pumping| pumping.squeeze = false);
        }
    }),
    of_cells: true,
};

/// True if the contact law takes depths of the tread into account: over cells, and over slices of springs.
pub(crate) fn takes_depths(scene: &Scene) -> bool {
    scene.contact.zone == Zone::Cells || scene.contact.slices == Slices::Winkler && scene.effects.texture != Switch::Off
}

/// Pattern of the tread, if the contact law takes it into account.
pub(crate) fn taken_pattern(scene: &Scene) -> Option<&TreadPattern> {
    scene.pattern().filter(|_| takes_depths(scene))
}

/// Map of the tread if the contact law takes it into account, or its fault; `None` without such a pattern.
pub(crate) fn tread_map(scene: &Scene, decisions: &Decisions) -> Option<Result<TreadMap, PatternFault>> {
    let pattern = taken_pattern(scene)?;
    let along = if decisions.zone == Zone::Cells { 1 } else { decisions.cells_along.unwrap_or(1) };
    let columns = scene.numerics.elements * along;
    let cells = TreadCells { columns, across: decisions.cells_across.unwrap_or(1) };
    Some(TreadMap::new(pattern, scene, cells))
}

/// Blocks of a map over cells; `None` if no block has a separate compliance.
pub(crate) fn tread_blocks(scene: &Scene, map: &TreadMap) -> Option<TreadBlocks> {
    let pattern = scene.pattern().filter(|_| scene.contact.zone == Zone::Cells)?;
    TreadBlocks::new(map, pattern, scene)
}

fn pattern(scene: &Scene, decisions: &mut Decisions) -> Decided {
    let reason = given(scene.effects.tread_pattern, "tread_pattern");
    if scene.tread_pattern.is_none() {
        return Decided::off(reason.unwrap_or_else(|| "auto: the scene has no [tread_pattern]".to_owned()));
    }
    let Some(map) = tread_map(scene, decisions) else {
        if scene.effects.tread_pattern == Switch::Off {
            return Decided::off(reason.unwrap_or_default());
        }
        let law = "slices take depths by independent springs alone (contact.slices = \"winkler\")";
        decisions.notes.push(format!("the tread's pattern is left out: {law}"));
        return Decided::off(format!("auto: {law}"));
    };
    if let Some(void) = map.as_ref().ok().map(|map| map.exact_void).filter(|void| *void > MOST_VOID) {
        let share = 100.0 * void;
        decisions.notes.push(format!("{share:.0} % of the tread is void: tyres of cars have 20 to 40 %"));
    }
    let form = map.map_or_else(|fault| fault.wrong, |map| form(&map, scene));
    Decided::on(form, reason.unwrap_or_else(|| "the scene has [tread_pattern]".to_owned()))
}

/// A map in words: pitches and their passing frequency, and shares of void.
fn form(map: &TreadMap, scene: &Scene) -> String {
    let pitches = map.train.as_ref().map_or(String::new(), |train| {
        let (count, passing) = (train.count(), scene.rolling.speed() / train.circumference);
        let scaled = (train.scale - 1.0).abs() > 1e-12;
        let scale = if scaled { format!(", lengths times {:.4}", train.scale) } else { String::new() };
        format!("{count} pitches, {:.0} Hz{scale}; ", count as f64 * passing)
    });
    format!("{pitches}{:.1} % void, on cells {:.1} %", 100.0 * map.exact_void, 100.0 * map.void())
}

fn blocks(scene: &Scene, decisions: &mut Decisions) -> Decided {
    let Some(pattern) = taken_pattern(scene) else {
        return Decided::off("there is no tread pattern");
    };
    if scene.contact.zone != Zone::Cells {
        return Decided::off("slices have no blocks");
    }
    if pattern.blocks == BlockModel::Continuum {
        let form = "as stiff as an uncut tread".to_owned();
        return Decided { form, ..Decided::off("tread_pattern.blocks = \"continuum\"") };
    }
    let found = tread_map(scene, decisions).and_then(Result::ok).and_then(|map| tread_blocks(scene, &map));
    let Some(blocks) = found else {
        return Decided::off("no cut is deeper than a third of the tread");
    };
    let yields = || blocks.blocks.iter().map(|block| block.compliance);
    let ends = |best: fn(f64, f64) -> f64, from: f64| yields().fold(from, best);
    let (least, most) = (ends(f64::min, f64::INFINITY), ends(f64::max, 0.0));
    let cells = blocks.smallest().unwrap_or(0);
    let ribs = blocks.blocks.iter().filter(|block| block.parts > 1).count();
    let count = blocks.blocks.len() - ribs;
    let form = format!(
        "{count} blocks and {ribs} ribs yield by {least:.2e} to {most:.2e} m/Pa, pressed by at least {cells} cells each"
    );
    Decided::on(form, if pattern.block_compliance.is_some() { "tread_pattern.block_compliance" } else { "by formula" })
}
