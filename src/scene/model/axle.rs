//! `rolling.axle`: a load, a load on a mass, or an indentation, told apart by their keys.

use serde::Serialize;

use crate::scene::Problem;
use crate::scene::kind::Bounds;
use crate::scene::table::{Kind, Nested, Table};

/// What holds the axle: a load, a height, or a mass under a load that moves.
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
        /// How far the rigid tyre is pushed into the plane z = 0 \[m\].
        indentation: f64,
        /// Time over which it rises linearly from zero \[s\].
        ramp: f64,
    },
}

impl Axle {
    /// The load \[N\] and the relative tolerance of the mean force, where a load is given.
    pub fn load(&self) -> Option<(f64, f64)> {
        match *self {
            Self::Load { load, tolerance } | Self::Mass { load, tolerance, .. } => Some((load, tolerance)),
            Self::Indentation { .. } => None,
        }
    }

    /// Default relative tolerance of the mean vertical force.
    pub const LOAD_TOLERANCE: f64 = 0.01;
}

const WANTED: &str = "{ load = ... } in N, or { indentation = ..., ramp = ... } in m and s; with a load, mass = ... \
in kg lets the axle move";
/// What only a moving axle has beside its mass.
const OF_A_MASS: [&str; 2] = ["stiffness", "damping"];

pub(in crate::scene) const AXLE: Nested<Axle> = Nested { title: "the axle", wanted: WANTED, read: axle };

fn axle(table: &mut Table<'_>) -> Option<Axle> {
    match (table.has("load"), table.has("indentation")) {
        (true, true) => {
            table.be_lenient();
            table.complain("indentation", Problem::conflict("load"))
        }
        (true, false) => {
            table.refuse(&["ramp"], "a load", "remove it: the load acts from the start; or give an indentation");
            let load = table.required("load", &Bounds::positive("N"));
            let tolerance = table.or("tolerance", &Bounds::inside(0.0, 1.0, ""), Axle::LOAD_TOLERANCE);
            if table.has("mass") {
                let mass = table.required("mass", &Bounds::positive("kg"));
                let stiffness = table.or("stiffness", &Bounds::not_negative("N/m"), 0.0);
                let damping = table.or("damping", &Bounds::not_negative("N s/m"), 0.0);
                let (stiffness, damping) = (stiffness?, damping?);
                return Some(Axle::Mass { load: load?, mass: mass?, stiffness, damping, tolerance: tolerance? });
            }
            table.take("mass");
            table.refuse(&OF_A_MASS, "an axle without a mass", "give its mass, too: mass = ... in kg; or remove it");
            Some(Axle::Load { load: load?, tolerance: tolerance? })
        }
        (false, true) => {
            table.refuse(&["tolerance"], "an indentation", "remove it: a height is held exactly; or give a load");
            let right = "remove it: a height is held whatever the force; or give a load";
            table.refuse(&["mass", "stiffness", "damping"], "an indentation", right);
            let indentation = table.required("indentation", &Bounds::not_negative("m"));
            let ramp = table.or("ramp", &Bounds::not_negative("s"), 0.0);
            Some(Axle::Indentation { indentation: indentation?, ramp: ramp? })
        }
        (false, false) => {
            for key in ["load", "indentation", "tolerance", "ramp", "mass", "stiffness", "damping"] {
                table.take(key);
            }
            if table.has("mass") {
                return table.complain("load", Problem::missing(&Bounds::positive("N").wanted()));
            }
            // A misspelt key explains why neither is there; it is enough to name that.
            if table.has_unknown() { None } else { table.complain_here(Problem::empty(WANTED)) }
        }
    }
}
