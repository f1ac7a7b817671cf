//! `rolling.axle`: a load or an indentation, told apart by their keys.

use super::super::kind::Bounds;
use super::super::table::{Nested, Table};
use super::super::{Axle, Problem};

const WANTED: &str = "{ load = ... } in N, or { indentation = ..., ramp = ... } in m and s";

pub(super) const AXLE: Nested<Axle> = Nested { title: "the axle", wanted: WANTED, read: axle };

fn axle(table: &mut Table<'_>) -> Option<Axle> {
    match (table.has("load"), table.has("indentation")) {
        (true, true) => {
            table.be_lenient();
            table.complain("indentation", Problem::Conflict { other: "load" })
        }
        (true, false) => {
            table.refuse(&["ramp"], "a load", "remove it: the load acts from the start; or give an indentation");
            let load = table.required("load", &Bounds::positive("N"));
            let tolerance = table.or("tolerance", &Bounds::inside(0.0, 1.0, ""), Axle::LOAD_TOLERANCE);
            Some(Axle::Load { load: load?, tolerance: tolerance? })
        }
        (false, true) => {
            table.refuse(&["tolerance"], "an indentation", "remove it: a height is held exactly; or give a load");
            let indentation = table.required("indentation", &Bounds::not_negative("m"));
            let ramp = table.or("ramp", &Bounds::not_negative("s"), 0.0);
            Some(Axle::Indentation { indentation: indentation?, ramp: ramp? })
        }
        (false, false) => {
            for key in ["load", "indentation", "tolerance", "ramp"] {
                table.take(key);
            }
            // A misspelt key explains why neither is there; it is enough to name that.
            if table.has_unknown() { None } else { table.complain_here(Problem::Empty { wanted: WANTED.to_owned() }) }
        }
    }
}
