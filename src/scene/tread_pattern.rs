//! Consistency of a tread pattern with its tyre.

use super::problem::{Problem, short};
use super::sizes::{MOST_GROOVES_ACROSS, MOST_OVERLAPS};
use super::table::Table;
use super::{Groove, LateralGroove, Pitches, Scene, Switch, TreadPattern, Tyre};

/// Largest relative difference between the pitches' total length and the circumference.
const OFF: f64 = 0.1;
/// Least thickness of rubber under a groove \[m\].
const UNDER_GROOVE: f64 = 1e-3;
/// Tolerance of comparisons of lengths, for rounding \[m\].
const ROUNDING: f64 = 1e-9;

/// Greatest possible depth of a groove in a tyre's tread \[m\].
pub(crate) fn deepest_groove(tyre: &Tyre) -> f64 {
    let most = tyre.layers.last().map_or(f64::INFINITY, |tread| tread.thickness) - UNDER_GROOVE;
    // Rounded as it is reported in messages.
    (1e6 * most).round() / 1e6 + ROUNDING
}

/// Estimate of the crossings of all edges of grooves across on a `length` \[m\] of `count` pitches, which meets itself
/// at its ends.
fn crossings(laterals: &[LateralGroove], count: usize, length: f64) -> f64 {
    let of_two = |one: &LateralGroove, other: &LateralGroove| {
        let overlap = (one.to.min(other.to) - one.from.max(other.from)).max(0.0);
        let [slope, beside] = [one, other].map(|groove| groove.angle.to_radians().tan());
        (slope - beside).abs() * overlap / length
    };
    let all =
        laterals.iter().enumerate().flat_map(|(n, one)| laterals[..n].iter().map(move |other| of_two(one, other)));
    4.0 * (count as f64).powi(2) * all.sum::<f64>()
}

/// Refuses grooves across that are as wide as a pitch, or too many; `None` after a complaint.
fn across(pattern: &TreadPattern, around: f64, table: &Table<'_>) -> Option<()> {
    let (count, shortest) = match &pattern.pitches {
        None => return Some(()),
        Some(Pitches::Equal(count)) => (*count, around / *count as f64),
        Some(Pitches::Varied(varied)) => {
            let order = varied.in_order();
            (order.len(), order.into_iter().fold(f64::INFINITY, f64::min))
        }
    };
    if count * pattern.laterals.len() > MOST_GROOVES_ACROSS {
        let wrong = format!("{} grooves across in each of {count} pitches", pattern.laterals.len());
        let right = format!("at most {MOST_GROOVES_ACROSS} round the tyre");
        return table.complain("tread_pattern.laterals", Problem::new(wrong, right));
    }
    // Equal pitches are considered as one.
    let (pitches, length) =
        if matches!(pattern.pitches, Some(Pitches::Equal(_))) { (1, shortest) } else { (count, around) };
    let crossings = crossings(&pattern.laterals, pitches, length);
    if crossings * (pitches * pattern.laterals.len()) as f64 > MOST_OVERLAPS {
        let wrong = format!("these grooves across cross each other at {crossings:.1e} places");
        let right = "fewer angles, fewer grooves, or equal pitches";
        return table.complain("tread_pattern.laterals", Problem::new(wrong, right));
    }
    let along = |groove: &LateralGroove| groove.width / groove.angle.to_radians().cos();
    let Some(wide) = pattern.laterals.iter().position(|groove| along(groove) >= shortest) else { return Some(()) };
    let wrong = format!(
        "the groove is {} m long round the tyre, a pitch {}",
        short(along(&pattern.laterals[wide])),
        short((1e4 * shortest).round() / 1e4)
    );
    let key = format!("tread_pattern.laterals[{wide}].width");
    table.complain(&key, Problem::new(wrong, "a groove that leaves some of each pitch solid"))
}

/// Refuses a pattern that does not fit the tyre; `None` after a complaint.
pub(super) fn check(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let complain = |key: &str, wrong: String, right: &str| {
        table.complain::<()>(key, Problem::new(wrong, right));
        false
    };
    let Some(pattern) = &scene.tread_pattern else {
        return match scene.effects.tread_pattern {
            Switch::On => {
                let right = "\"auto\" or \"off\", or a table [tread_pattern] with pitches and grooves";
                let wrong = "there is no [tread_pattern] that says where grooves are";
                table.complain("effects.tread_pattern", Problem::new(wrong, right))
            }
            _ => Some(()),
        };
    };
    let mut fits = true;
    if let Some(Pitches::Varied(varied)) = &pattern.pitches {
        let sum: f64 = varied.in_order().iter().sum();
        let around = scene.tyre.circumference;
        if (sum / around - 1.0).abs() > OFF {
            let wrong = format!("these pitches are {sum:.4} m long, the tyre is {} m round", short(around));
            fits = complain(
                "tread_pattern.pitches",
                wrong,
                "give lengths and a number of pitches that fill the circumference to within 10 %",
            );
        }
    }
    fits &= across(pattern, scene.tyre.circumference, table).is_some();
    let half = 0.5 * scene.tyre.contact_width;
    let thickness = scene.tyre.layers.last().map_or(f64::INFINITY, |tread| tread.thickness);
    let most = deepest_groove(&scene.tyre);
    let strip =
        format!("it lies within the strip that touches the road, which reaches {} m to either side", short(half));
    let depths = pattern.grooves.iter().enumerate().map(|(n, groove)| (format!("grooves[{n}]"), groove.depth));
    let of = |name: &'static str, list: &[LateralGroove]| {
        list.iter().enumerate().map(|(n, of)| (format!("{name}[{n}]"), of.depth)).collect::<Vec<_>>()
    };
    let all = depths.chain(of("laterals", &pattern.laterals)).chain(of("sipes", &pattern.sipes));
    let picture = pattern.depth.map(|depth| (String::new(), depth));
    for (key, depth) in all.chain(picture).filter(|(_, depth)| *depth > most) {
        let dot = if key.is_empty() { "" } else { "." };
        let wrong = format!("{} m is too deep for a tread of {} m", short(depth), short(thickness));
        let right = format!("write at most {} m: 1 mm of the tread stays under it", short((1e6 * most).round() / 1e6));
        fits = complain(&format!("tread_pattern.{key}{dot}depth"), wrong, &right);
    }
    for (n, Groove { position, width, .. }) in pattern.grooves.iter().enumerate() {
        let key = format!("tread_pattern.grooves[{n}]");
        if position.abs() + 0.5 * width > half + ROUNDING {
            let wrong = format!("this groove reaches {} m from the tyre's middle", short(position.abs() + 0.5 * width));
            fits = complain(&format!("{key}.position"), wrong, &strip);
        }
        let meets = |other: &Groove| (other.position - position).abs() < 0.5 * (width + other.width) - ROUNDING;
        if let Some(other) = pattern.grooves[..n].iter().position(meets) {
            let wrong = format!("this groove overlaps with grooves[{other}]");
            fits = complain(&format!("{key}.position"), wrong, "make one groove of both, or move them apart");
        }
    }
    for (name, list) in [("laterals", &pattern.laterals), ("sipes", &pattern.sipes)] {
        for (n, LateralGroove { from, to, .. }) in list.iter().enumerate() {
            for (end, value) in [("from", from), ("to", to)].into_iter().filter(|(_, end)| end.abs() > half + ROUNDING)
            {
                let wrong = format!("{} m is outside of the strip", short(*value));
                fits = complain(&format!("tread_pattern.{name}[{n}].{end}"), wrong, &strip);
            }
        }
    }
    fits.then_some(())
}
