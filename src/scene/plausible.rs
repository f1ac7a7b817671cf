//! Checks of numbers that are possible each by itself but implausible together.

use super::problem::{Problem, short};
use super::table::Table;
use super::{Axle, Cavity, Inflation, Scene, Tyre};

/// Largest plausible section height of a tyre, from rim to tread, over its radius.
const SECTION: f64 = 0.3;
/// Plausible range of the load over contact width times radius \[N/m^2\], from the lightest toy to a wheel of steel.
const LOADED: [f64; 2] = [300.0, 1e8];
/// Plausible range of the part of the circumference on which the inflation pressure over the contact width bears the
/// load: from a car tyre at a tenth of its load capacity to one whose belt is pressed onto the rim.
const BORNE_ON: [f64; 2] = [0.0125, 0.3];
/// Least such part on a truck, whose empty axles are lighter still: there a load in kilograms is borne on less.
const BORNE_BY_TRUCK_ON: f64 = 0.005;
/// Load from which a tyre may be a truck's \[N\]: a car's is no such number of kilograms.
const LOAD_OF_TRUCK: f64 = 1000.0;
/// Least length over width of the patch: round and narrow tyres of two-wheelers have few loads below that.
const SHORT_PATCH: f64 = 0.25;
/// Pressure that a tyre without air makes up for by its structure, in that it still bears loads \[Pa\].
const STRUCTURE: f64 = 1e5;
/// Gravitational acceleration \[m/s^2\].
pub(crate) const GRAVITY: f64 = 9.81;
/// Factor by which a gas in a tyre may be denser or less dense than air: other gases have other heat capacities, and
/// temperatures differ.
const GAS: f64 = 1.5;
/// Atmospheric pressure \[Pa\].
const ATMOSPHERE: f64 = 1.013e5;
/// Ratio of the heat capacities of air.
const HEAT_CAPACITIES: f64 = 1.4;

/// Refuses implausible combinations; `None` after a complaint.
pub(super) fn check(scene: &Scene, table: &Table<'_>) -> Option<()> {
    [load(scene, table), indentation(scene, table), air(&scene.tyre, table)].into_iter().collect()
}

/// Refuses a load that no tyre of this size and pressure bears; `None` after a complaint.
fn load(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let Some((load, _)) = scene.rolling.axle.load() else { return Some(()) };
    let Tyre { contact_width, circumference, .. } = scene.tyre;
    let [least, most] = match &scene.tyre.inflation {
        Some(Inflation { pressure }) => {
            let on_width = pressure * contact_width;
            let of_truck = LOAD_OF_TRUCK.max(BORNE_BY_TRUCK_ON * on_width * circumference);
            let of_narrow = SHORT_PATCH * on_width * contact_width;
            let least = (BORNE_ON[0] * on_width * circumference).min(of_truck).min(of_narrow);
            [least, BORNE_ON[1] * pressure.max(STRUCTURE) * contact_width * circumference].map(two_digits)
        }
        // In whole decades: the bounds are no more exact.
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

/// Refuses an indentation deeper than the tyre's height above its rim; `None` after a complaint.
fn indentation(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let Axle::Indentation { indentation, .. } = scene.rolling.axle else { return Some(()) };
    let (key, radius) = ("rolling.axle.indentation", scene.tyre.radius());
    // Pushed in by more than its radius the rigid circle leaves no meaningful outline.
    if indentation > radius {
        return table.complain(key, Problem::exceeds(indentation, radius, "the tyre's radius"));
    }
    let most = scene.tyre.height_over_rim().unwrap_or(SECTION * radius);
    if indentation <= most * table.slack() {
        return Some(());
    }
    // To a millimetre: the bound is no more exact.
    table.complain(key, Problem::implausible(indentation, [0.0, (1e3 * most).round() / 1e3], "m"))
}

/// Refuses a cavity whose density does not match the inflation pressure; `None` after a complaint.
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

/// Rounds a positive number to two digits.
fn two_digits(number: f64) -> f64 {
    let unit = 10_f64.powf(number.log10().floor() - 1.0);
    // Formatted again: the rounding of `unit` may leave more digits.
    format!("{:.1e}", (number / unit).round() * unit).parse().unwrap_or(number)
}
