//! Views of a tread's pattern.

use serde_json::{Value, json};

use crate::plan::decisions::cells_across;
use crate::results::table::{Report, aligned};
use crate::scene::Scene;
use crate::tyre::tread_pattern::PatternFault;
use crate::tyre::tread_pattern::map::{TreadCells, TreadMap};

/// Refinements of the scene's cells that are tried until they resolve the pattern.
const FINER: [usize; 4] = [1, 2, 4, 8];

/// The map of a scene's pattern on its cells, or on the next finer ones that resolve it; `None` without a pattern.
pub(super) fn map(scene: &Scene) -> Option<Result<TreadMap, PatternFault>> {
    let pattern = scene.pattern()?;
    let across = cells_across(scene);
    let on = |finer: usize| {
        let cells = TreadCells { columns: finer * scene.numerics.elements, across: finer * across };
        TreadMap::new(pattern, scene, cells)
    };
    let coarse = on(1);
    let finer = FINER[1..].iter().find_map(|&finer| on(finer).ok());
    Some(if coarse.is_ok() { coarse } else { finer.map_or(coarse, Ok) })
}

/// Table of pitches and shares of void; `speed` in m/s.
pub(super) fn report(map: &TreadMap, speed: f64) -> Report {
    let mut report = Report::default();
    report.text(format!("Tread pattern on {} x {} cells\n", map.columns, map.across));
    let percent = |share: f64| format!("{:.2} %", 100.0 * share);
    let mut rows =
        vec![["void".to_owned(), percent(map.exact_void)], ["void on cells".to_owned(), percent(map.void())]];
    if let Some(train) = &map.train {
        let lengths = train.lengths.iter().copied();
        let (least, most) = (lengths.clone().fold(f64::INFINITY, f64::min), lengths.fold(0.0, f64::max));
        let count = train.count() as f64;
        rows.push(["pitches".to_owned(), train.count().to_string()]);
        rows.push(["lengths".to_owned(), format!("{:.1} to {:.1} mm", 1e3 * least, 1e3 * most)]);
        rows.push(["scaled by".to_owned(), format!("{:.4}", train.scale)]);
        let passing = count * speed / train.circumference;
        rows.push([format!("passing at {:.0} km/h", 3.6 * speed), format!("{passing:.0} Hz")]);
        let orders = 1..=2 * train.count();
        let strongest = orders
            .map(|order| (order, train.amplitude(order).norm()))
            .fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best });
        rows.push(["strongest order".to_owned(), format!("{}, {:.3}", strongest.0, strongest.1)]);
    }
    report.table(aligned(["of the tread", "value"], rows));
    report.text("\n");
    report
}

/// The same as JSON, in SI units.
pub(super) fn to_json(map: &TreadMap) -> Value {
    json!({
        "void_share": map.exact_void,
        "void_share_on_cells": map.void(),
        "cells": [map.columns, map.across],
        "pitches": map.train.as_ref().map(|train| json!({
            "starts": train.starts,
            "lengths": train.lengths,
            "scale": train.scale,
        })),
    })
}
