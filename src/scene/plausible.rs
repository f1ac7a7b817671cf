//! Numbers of a scene that may be each by itself, and are hardly meant together.

use super::problem::{Problem, short};
use super::table::Table;
use super::{Axle, Cavity, Inflation, Scene, Tyre};

/// Largest section height of a tyre, from rim to tread, over its radius.
const SECTION: f64 = 0.3;
/// Forces on a strip as wide as the tread's and as long as the tyre's radius, from the lightest toy to a wheel of steel
/// \[N/m^2\].
const LOADED: [f64; 2] = [300.0, 1e8];
/// Part of the circumference on which the inflation pressure over the contact strip would bear the load: from a car's
/// tyre that bears a tenth of its load index, to what presses the belt onto the rim.
const BORNE_ON: [f64; 2] = [0.0125, 0.3];
/// Weight of a kilogram \[N\].
const GRAVITY: f64 = 9.81;
/// Factor by which a gas in a tyre may be heavier or lighter than air: others than air have other heat capacities, and
/// temperatures differ.
const GAS: f64 = 1.5;
/// Pressure of the atmosphere \[Pa\].
const ATMOSPHERE: f64 = 1.013e5;
/// Ratio of the heat capacities of air.
const HEAT_CAPACITIES: f64 = 1.4;

/// Complains about numbers that are hardly meant; `None` then.
pub(super) fn check(scene: &Scene, table: &Table<'_>) -> Option<()> {
    [load(scene, table), indentation(scene, table), air(&scene.tyre, table)].into_iter().collect()
}

/// Complains about a load that no tyre of this size and pressure has; `None` then.
fn load(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let Some((load, _)) = scene.rolling.axle.load() else { return Some(()) };
    let Tyre { contact_width, circumference, .. } = scene.tyre;
    let [least, most] = match &scene.tyre.inflation {
        Some(Inflation { pressure }) => {
            BORNE_ON.map(|share| two_digits(share * pressure * contact_width * circumference))
        }
        // In whole decades: the numbers are no exacter.
        None => {
            let [least, most] = LOADED.map(|load| (load * contact_width * scene.tyre.radius()).log10());
            [10_f64.powf(least.floor()), 10_f64.powf(most.ceil())]
        }
    };
    let fits = |load: f64| (least / table.slack()..=most * table.slack()).contains(&load);
    if fits(load) {
        return Some(());
    }
    let problem = Problem::implausible(load, [least, most], "N");
    let weight = GRAVITY * load;
    let problem = if load < least && fits(weight) {
        problem.with_hint(&format!("{} kg weigh {weight:.0} N", short(load)))
    } else {
        problem
    };
    table.complain("rolling.axle.load", problem)
}

/// Complains about an indentation that is deeper than the tyre is high above its rim; `None` then.
fn indentation(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let Axle::Indentation { indentation, .. } = scene.rolling.axle else { return Some(()) };
    let (key, radius) = ("rolling.axle.indentation", scene.tyre.radius());
    // Pushed in by more than its radius the rigid circle has no outline left to speak of.
    if indentation > radius {
        return table.complain(key, Problem::exceeds(indentation, radius, "the tyre's radius"));
    }
    let most = scene.tyre.height_over_rim().unwrap_or(SECTION * radius);
    if indentation <= most * table.slack() {
        return Some(());
    }
    // To a millimetre: the number is no exacter.
    table.complain(key, Problem::implausible(indentation, [0.0, (1e3 * most).round() / 1e3], "m"))
}

/// Complains about air in a tyre that is not of its pressure; `None` then.
fn air(tyre: &Tyre, table: &Table<'_>) -> Option<()> {
    let (Some(Inflation { pressure }), Some(Cavity { density, sound_speed, .. })) = (&tyre.inflation, tyre.cavity)
    else {
        return Some(());
    };
    let of_air = HEAT_CAPACITIES * (pressure + ATMOSPHERE) / (sound_speed * sound_speed);
    let range = [of_air / GAS, of_air * GAS].map(two_digits);
    if (range[0] / table.slack()..=range[1] * table.slack()).contains(&density) {
        return Some(());
    }
    let problem = Problem::implausible(density, range, "kg/m^3");
    let hint = format!("air at {} Pa over the atmosphere has {of_air:.2} kg/m^3", short(*pressure));
    table.complain("tyre.cavity.density", problem.with_hint(&hint))
}

/// Returns a positive number to two digits.
fn two_digits(number: f64) -> f64 {
    let unit = 10_f64.powf(number.log10().floor() - 1.0);
    // No more digits than two, whatever the unit's rounding.
    format!("{:.1e}", (number / unit).round() * unit).parse().unwrap_or(number)
}
