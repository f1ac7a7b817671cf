//! What is in a tyre: inflation, sidewalls and cavity; whether they fit the tyre, and what they give it.

use std::f64::consts::PI;

use super::super::kind::Bounds;
use super::super::problem::short;
use super::super::table::{Nested, Table};
use super::super::{Carried, Cavity, Inflation, Problem, Sides, Sidewalls, Tyre};

const LENGTH: Bounds = Bounds::positive("m");
const ANGLE: Bounds = Bounds::any("rad");

pub(super) const INFLATION: Nested<Inflation> = Nested {
    title: "the inflation",
    wanted: "a table, { pressure = ..., sidewall_radius = ..., sidewall_angle = ... }",
    read: inflation,
};
pub(super) const CAVITY: Nested<Cavity> =
    Nested { title: "the cavity", wanted: "a table, { radius = ..., depth = ..., density = ... }", read: cavity };

/// The arc of a sidewall: all of it or none.
const ARC: [&str; 2] = ["sidewall_radius", "sidewall_angle"];

fn inflation(table: &mut Table<'_>) -> Option<Inflation> {
    let pressure = table.required("pressure", &Bounds::positive("Pa"));
    let sidewall_mass = table.or("sidewall_mass", &Bounds::not_negative("kg/m^2"), 0.0);
    let sidewalls = if ARC.iter().any(|key| table.has(key)) || table.has("sidewall_shear") {
        sidewalls(table).map(Some)
    } else {
        Some(None)
    };
    Some(Inflation { pressure: pressure?, sidewall_mass: sidewall_mass?, sidewalls: sidewalls? })
}

fn sidewalls(table: &mut Table<'_>) -> Option<Sidewalls> {
    let radius = table.required("sidewall_radius", &LENGTH);
    let angle = table.required("sidewall_angle", &ANGLE);
    let shear = table.or("sidewall_shear", &Bounds::not_negative("N/m"), 0.0);
    let angle = angle.filter(|&angle| {
        let is_arc = angle > 0.0 && angle < PI;
        if !is_arc {
            let wrong = format!("{} rad is not half the angle of an arc from rim to belt", short(angle));
            table.complain::<()>("sidewall_angle", Problem::new(wrong, "write a number above 0 and below pi rad"));
        }
        is_arc
    });
    Some(Sidewalls { radius: radius?, angle: angle?, shear: shear? })
}

fn cavity(table: &mut Table<'_>) -> Option<Cavity> {
    let radius = table.required("radius", &LENGTH);
    let depth = table.required("depth", &LENGTH);
    let density = table.required("density", &Bounds::positive("kg/m^3"));
    let sound_speed = table.or("sound_speed", &Bounds::positive("m/s"), Cavity::SOUND_SPEED);
    let relaxation = table.or("relaxation", &Bounds::not_negative("s"), 0.0);
    if let (Some(value), Some(limit)) = (depth, radius)
        && value >= limit
    {
        return table.complain("depth", Problem::not_below(value, limit, "the cavity's mean radius"));
    }
    Some(Cavity {
        radius: radius?,
        depth: depth?,
        density: density?,
        sound_speed: sound_speed?,
        relaxation: relaxation?,
    })
}

/// Checks what is in a tyre against its shape; `None` after complaints.
pub(super) fn check(tyre: &Tyre, table: &Table<'_>) -> Option<()> {
    let mut sound = Some(());
    let mut complain = |key: &str, problem| sound = table.complain(key, problem);
    let flat = || Problem::does_not_belong("a flat tyre", "write curvature = true, or leave this out");
    if !tyre.curvature && tyre.cavity.is_some() {
        complain("cavity", flat());
    }
    if !tyre.curvature && tyre.inflation.as_ref().is_some_and(|inflation| inflation.sidewall_mass > 0.0) {
        complain("inflation.sidewall_mass", flat());
    }
    if tyre.sides == Sides::Supported && tyre.cavity.is_some() {
        let wrong = "sides = \"supported\" has no wave that is constant across the width, which is what the air feels";
        complain("cavity", Problem::new(wrong, "write sides = \"guided\", or leave this out"));
    }
    let (thickness, radius) = (tyre.thickness(), tyre.radius());
    if (tyre.curvature || tyre.carried().is_some()) && thickness >= radius {
        let (thickness, radius) = (short(thickness), short(radius));
        let wrong = format!("the layers are {thickness} m thick together, and the tyre's radius is {radius} m");
        complain("layers", Problem::new(wrong, "make the layers thinner, or the circumference longer"));
    }
    if let Some(cavity) = &tyre.cavity
        && cavity.radius >= radius
    {
        complain("cavity.radius", Problem::not_below(cavity.radius, radius, "the tyre's radius"));
    }
    sound
}

/// What of a tyre the scene left out.
pub(super) struct LeftOut {
    /// The tension of the innermost layer.
    pub(super) tension: bool,
    /// The normal stiffness of the foundation.
    pub(super) normal: bool,
    /// Its tangential stiffness.
    pub(super) tangential: bool,
}

/// A tyre with what was left out taken from its inflation; `None` after complaints.
pub(super) fn inflated(mut tyre: Tyre, left_out: LeftOut, table: &Table<'_>) -> Option<Tyre> {
    let (Some(Carried { tension, normal, tangential }), Some(Inflation { pressure, sidewalls: Some(arc), .. })) =
        (tyre.carried(), &tyre.inflation)
    else {
        return Some(tyre);
    };
    let mut sound = Some(());
    let mut complain = |key, wrong, right| sound = table.complain(key, Problem::new(wrong, right));
    if left_out.tension && !(tension >= 0.0 && tension.is_finite()) {
        let Sidewalls { radius, angle, .. } = *arc;
        let pull = 2.0 * pressure * radius * angle.cos() / tyre.width;
        let wrong = format!(
            "the sidewalls pull the belt inwards by {pull:.3e} Pa, the pressure is {} Pa: a tension of {tension:.3e} \
             N/m would buckle it",
            short(*pressure)
        );
        let right = format!(
            "write a number above {:.4} rad, a sidewall_radius below {:.4} m, or the innermost layer's tension",
            (0.5 * tyre.width / radius).acos(),
            0.5 * tyre.width / angle.cos()
        );
        complain("inflation.sidewall_angle", wrong, right);
    }
    let bears = |stiffness: f64| stiffness > 0.0 && stiffness.is_finite();
    for (key, is_left_out, stiffness) in
        [("foundation.normal", left_out.normal, normal), ("foundation.tangential", left_out.tangential, tangential)]
    {
        if is_left_out && !bears(stiffness) {
            let wrong = format!("sidewalls of this angle give {key} = {stiffness:.3e} N/m^3, which bears nothing");
            complain("inflation.sidewall_angle", wrong, format!("write a number from 0.01 to 2.79 rad, or give {key}"));
        }
    }
    sound?;
    if left_out.tension {
        tyre.layers[0].tension = [tension, 0.0];
    }
    if left_out.normal {
        tyre.foundation.normal = normal;
    }
    if left_out.tangential {
        tyre.foundation.tangential = tangential;
    }
    Some(tyre)
}
