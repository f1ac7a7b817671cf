//! `rolling.axle`: a load, a load on a mass, or an indentation, told apart by their keys.

use super::super::kind::Bounds;
use super::super::table::Kind;
use super::super::table::{Nested, Table};
use super::super::{Axle, Problem};

const WANTED: &str = "{ load = ... } in N, or { indentation = ..., ramp = ... } in m and s; with a load, mass = ... \
in kg lets the axle move";
/// What only a moving axle has beside its mass.
const OF_A_MASS: [&str; 2] = ["stiffness", "damping"];

pub(super) const AXLE: Nested<Axle> = Nested { title: "the axle", wanted: WANTED, read: axle };

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
