//! Consistency of a tread's pattern with its tyre.

use super::problem::{Problem, short};
use super::table::Table;
use super::{Groove, LateralGroove, Pitches, Scene, Switch};

/// Part by which the pitches' lengths may miss the circumference.
const OFF: f64 = 0.1;
/// Rubber under a groove, at least \[m\].
const UNDER_GROOVE: f64 = 1e-3;
/// Rounding of lengths \[m\].
const ROUNDING: f64 = 1e-9;

/// Complains about a pattern that does not fit the tyre; `None` then.
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
    let half = 0.5 * scene.tyre.contact_width;
    let thickness = scene.tyre.layers.last().map_or(f64::INFINITY, |tread| tread.thickness);
    let most = thickness - UNDER_GROOVE;
    let strip =
        format!("it lies within the strip that touches the road, which reaches {} m to either side", short(half));
    let depths = pattern.grooves.iter().enumerate().map(|(n, groove)| (format!("grooves[{n}]"), groove.depth));
    let of = |name: &'static str, list: &[LateralGroove]| {
        list.iter().enumerate().map(|(n, of)| (format!("{name}[{n}]"), of.depth)).collect::<Vec<_>>()
    };
    let all = depths.chain(of("laterals", &pattern.laterals)).chain(of("sipes", &pattern.sipes));
    let picture = pattern.depth.map(|depth| (String::new(), depth));
    for (key, depth) in all.chain(picture).filter(|(_, depth)| *depth > most + ROUNDING) {
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
