//! Tangential forces of a sweep: their table, and curves over the creep that is varied.

use crate::results::plots::{Axis, LinePlot, Series};
use crate::results::summary::FrictionSummary;
use crate::results::table::csv;
use crate::study::sweep::run::Done;
use crate::study::sweep::variants::Label;

/// Prefix of the keys of creep, over which forces are drawn.
const CREEP: &str = "friction.creep.";

/// A quantity of friction: its name, its column, its value.
type Figure = (&'static str, &'static str, fn(&FrictionSummary) -> f64);

/// Quantities of friction that sweeps list.
const FIGURES: [Figure; 8] = [
    ("longitudinal force, N", "longitudinal_force_n", |of| of.mean_longitudinal_force),
    ("lateral force, N", "lateral_force_n", |of| of.mean_lateral_force),
    ("aligning moment, N m", "aligning_moment_n_m", |of| of.mean_aligning_moment),
    ("torque, N m", "torque_n_m", |of| of.mean_torque),
    ("slip power, W", "slip_power_w", |of| of.mean_slip_power),
    ("share that slips", "slipping_share", |of| of.slipping_share),
    ("resistance by slip", "slip_resistance", |of| of.slip_resistance),
    ("creep", "longitudinal_creep", |of| of.mean_creep),
];

/// Rows of the table for people, one for each quantity.
pub(super) fn friction_rows(found: &[Done]) -> impl Iterator<Item = Vec<String>> + '_ {
    FIGURES.into_iter().map(move |(name, _, value)| {
        let cell = |done: &Done| done.friction.as_ref().map_or("-".to_owned(), |of| format!("{:.4}", value(of)));
        [name.to_owned()].into_iter().chain(found.iter().map(cell)).collect()
    })
}

/// Tangential forces as CSV, one row per variant; `None` without friction.
pub(crate) fn friction_csv(runs: &[(Label, Option<Done>)]) -> Option<String> {
    let header = ["variant", "group", "speed_kmh"].into_iter().chain(FIGURES.map(|(_, column, _)| column));
    let row = |(label, done): &(Label, Option<Done>)| {
        let friction = done.as_ref()?.friction.as_ref()?;
        let numbers = FIGURES.map(|(.., value)| value(friction).to_string());
        let names = [label.name.clone(), label.group.clone(), label.speed.to_string()];
        Some(names.into_iter().chain(numbers).collect::<Vec<_>>())
    };
    let rows: Vec<Vec<String>> = runs.iter().filter_map(row).collect();
    (!rows.is_empty()).then(|| csv(header, rows))
}

/// Forces over the creep, one curve for each force and combination of the other settings; `None` if no creep is varied.
pub(crate) fn friction_plot(runs: &[(Label, Option<Done>)], title: &str) -> Option<String> {
    let of_creep = |label: &Label| label.choices.iter().position(|choice| choice.factor.starts_with(CREEP));
    let mut curves: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    let mut key = String::new();
    for (label, done) in runs {
        let Some((place, friction)) = of_creep(label).zip(done.as_ref().and_then(|done| done.friction)) else {
            continue;
        };
        // Free rolling is drawn at the creep that the run has found.
        let choice = &label.choices[place];
        let creep = choice.value.parse().unwrap_or(friction.mean_creep);
        key.clone_from(&choice.factor);
        let others = label.choices.iter().enumerate().filter(|(index, choice)| *index != place && !choice.repeats);
        let others: String = others.map(|(_, choice)| format!(", {} {}", choice.factor, choice.value)).collect();
        for (name, force) in
            [("longitudinal", friction.mean_longitudinal_force), ("lateral", friction.mean_lateral_force)]
        {
            let name = format!("{name}{others}");
            match curves.iter_mut().find(|(known, _)| *known == name) {
                Some((_, points)) => points.push((creep, force)),
                None => curves.push((name, vec![(creep, force)])),
            }
        }
    }
    curves.iter_mut().for_each(|(_, points)| points.sort_by(|a, b| a.0.total_cmp(&b.0)));
    if curves.iter().all(|(_, points)| points.len() < 2) {
        return None;
    }
    let points = || curves.iter().flat_map(|(_, points)| points);
    let plot = LinePlot {
        title,
        x: Axis::linear_around(&key, points().map(|point| point.0)),
        y: Axis::linear_around("Force on the tyre [N]", points().map(|point| point.1)),
        series: curves.iter().map(|(name, points)| Series { name, points: points.clone() }).collect(),
    };
    Some(plot.to_svg())
}
