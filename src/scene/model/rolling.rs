//! `[rolling]`: how the tyre rolls. `rolling.axle`: a load, a load on a mass, or an indentation, distinguished by their
//! keys.

use crate::scene::Problem;
use crate::scene::keys::keys;
use crate::scene::kind::{Bounds, Optional};
use crate::scene::table::{Keys, Kind, Nested, Table};
use serde::Serialize;

keys! {
    /// How the tyre rolls.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Rolling {
        /// Speed \[km/h\].
        speed_kmh: f64 => Bounds::positive("km/h").plausible(0.01, 2e3),
        /// Time simulated after the warm-up \[s\].
        duration: f64 => Bounds::positive("s").plausible(1e-4, 1e6),
        /// Time simulated before anything counts towards a mean or a spectrum \[s\].
        warm_up: f64 = Rolling::WARM_UP => Bounds::not_negative("s").plausible(1e-6, 1e6),
        /// Road coordinate under the axle at t = 0 \[m\]; default: 0 on an endless road, just far enough from its
        /// beginning on a finite one.
        start?: f64 => Bounds::any("m").plausible(1e-9, 1e7),
        /// Support of the axle.
        axle: Axle => AXLE,
    }
}

pub(in crate::scene) const ROLLING: Nested<Rolling> =
    Nested::new("[rolling]", "the table [rolling] with speed_kmh, duration and axle");

impl Rolling {
    /// Default warm-up \[s\]: the default tyre's transient after a static start has died out by then.
    pub const WARM_UP: f64 = 0.5;

    /// Speed V in SI units \[m/s\].
    pub fn speed(&self) -> f64 {
        self.speed_kmh / 3.6
    }
}

/// Support of the axle: a load, a height, or a mass under a load that moves.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Axle {
    /// The height is found so that the mean vertical force is this load.
    Load {
        /// Vertical load \[N\].
        load: f64,
        /// Relative tolerance of the mean force.
        tolerance: f64,
    },
    /// A mass under the load, with a spring and a damper: it moves with the contact force, the mean of which is the
    /// load.
    Mass {
        /// Vertical load \[N\].
        load: f64,
        /// Mass that moves with the axle \[kg\].
        mass: f64,
        /// Stiffness of the spring above it \[N/m\].
        stiffness: f64,
        /// Damping of the damper above it \[N s/m\].
        damping: f64,
        /// Relative tolerance of the mean force.
        tolerance: f64,
    },
    /// A fixed height.
    Indentation {
        /// Depth by which the rigid tyre is pushed into the plane z = 0 \[m\].
        indentation: f64,
        /// Time over which it rises linearly from zero \[s\].
        ramp: f64,
    },
}

impl Axle {
    /// Load \[N\] and relative tolerance of the mean force; `None` for an indentation.
    pub fn load(&self) -> Option<(f64, f64)> {
        match *self {
            Self::Load { load, tolerance } | Self::Mass { load, tolerance, .. } => Some((load, tolerance)),
            Self::Indentation { .. } => None,
        }
    }

    /// Default relative tolerance of the mean vertical force.
    pub const LOAD_TOLERANCE: f64 = 0.01;
}

/// Wide bounds: the load is compared with the tyre that bears it when the whole scene is checked.
const LOAD: Bounds = Bounds::positive("N").plausible(1e-3, 1e8);

keys! {
    /// Support of the axle: a load, with or without a mass that moves, or a height.
    #[derive(Debug)]
    AxleKeys {
        /// Vertical load \[N\]: the height is found so that it is the mean force. Or give an `indentation`.
        load: Option<f64> = None => Optional(LOAD),
        /// Depth by which the rigid tyre is pushed into the plane z = 0, and held there \[m\]. Or give a `load`.
        indentation: Option<f64> = None => Optional(Bounds::not_negative("m").plausible(1e-9, 5.0)),
        /// Relative tolerance of the mean force; with a load only.
        tolerance: f64 = Axle::LOAD_TOLERANCE => Bounds::inside(0.0, 1.0, ""),
        /// Time over which an indentation rises linearly from zero \[s\].
        ramp: f64 = 0.0 => Bounds::not_negative("s").plausible(1e-9, 1e6),
        /// Mass under a load that moves with the axle \[kg\]; without it the height stays as it was found.
        mass: Option<f64> = None => Optional(Bounds::positive("kg").plausible(1e-4, 1e7)),
        /// Stiffness of the spring above the mass \[N/m\].
        stiffness: f64 = 0.0 => Bounds::not_negative("N/m").plausible(1e-3, 1e12),
        /// Damping of the damper above the mass \[N s/m\].
        damping: f64 = 0.0 => Bounds::not_negative("N s/m").plausible(1e-3, 1e10),
    }
}

const WANTED: &str = "{ load = ... } in N, or { indentation = ..., ramp = ... } in m and s; with a load, mass = ... \
in kg lets the axle move";

pub(in crate::scene) const AXLE: Nested<Axle> =
    Nested { title: "the axle", wanted: WANTED, schema: AxleKeys::schema, read: axle };

fn axle(table: &mut Table<'_>) -> Option<Axle> {
    match (table.has("load"), table.has("indentation")) {
        (true, false) => {
            table.refuse(&["ramp"], "a load", "remove it: the load acts from the start; or give an indentation");
            if !table.has("mass") {
                let right = "give its mass, too: mass = ... in kg; or remove it";
                table.refuse(&["stiffness", "damping"], "an axle without a mass", right);
            }
        }
        (false, true) => {
            table.refuse(&["tolerance"], "an indentation", "remove it: a height is held exactly; or give a load");
            let right = "remove it: a height is held whatever the force; or give a load";
            table.refuse(&["mass", "stiffness", "damping"], "an indentation", right);
        }
        _ => {}
    }
    let AxleKeys { load, indentation, tolerance, ramp, mass, stiffness, damping } = AxleKeys::read(table)?;
    match (load, indentation, mass) {
        (Some(load), None, None) => Some(Axle::Load { load, tolerance }),
        (Some(load), None, Some(mass)) => Some(Axle::Mass { load, mass, stiffness, damping, tolerance }),
        (None, Some(indentation), _) => Some(Axle::Indentation { indentation, ramp }),
        (Some(_), Some(_), _) => table.complain("indentation", Problem::conflict("load")),
        (None, None, Some(_)) => table.complain("load", Problem::missing(&LOAD.wanted())),
        // A misspelt key, which is reported anyway, explains why neither is there.
        (None, None, None) if table.has_unknown() => None,
        (None, None, None) => table.complain_here(Problem::empty(WANTED)),
    }
}
