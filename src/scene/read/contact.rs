//! `[contact]`.

use super::super::kind::{Bounds, Count, Flag, OneOf};
use super::super::table::{Nested, Table};
use super::super::{Contact, Problem, SliceCoupling, Slices, Tread};

pub(super) const CONTACT: Nested<Contact> = Nested { title: "[contact]", wanted: "the table [contact]", read: contact };

fn contact(table: &mut Table<'_>) -> Option<Contact> {
    let tread = table.or("tread", &OneOf::<Tread>::new(), Tread::default());
    let slices = table.or("slices", &OneOf::<Slices>::new(), Slices::default());
    let slice_coupling = table.or("slice_coupling", &OneOf::<SliceCoupling>::new(), SliceCoupling::default());
    let local_compliance = match slice_coupling {
        Some(SliceCoupling::Local) | None => table.optional("local_compliance", &Bounds::positive("m/Pa")),
        Some(SliceCoupling::Explicit | SliceCoupling::Implicit) => {
            let owner = "the paper's slice couplings, whose compliance is G0_ii";
            table.refuse(&["local_compliance"], owner, "remove it, or choose slice_coupling = \"local\"");
            Some(None)
        }
    };
    let cells_across = table.optional("cells_across", &Count(1));
    let cells_along = table.optional("cells_along", &Count(1));
    let slice_tolerance = table.or("slice_tolerance", &Bounds::between(0.0, 1e-3, "m"), Contact::SLICE_TOLERANCE);
    let bedding_stiffness = match tread {
        Some(Tread::Elastic) => refuse_stiffness(table, "tread = \"elastic\""),
        Some(Tread::Uncoupled) => refuse_stiffness(table, "tread = \"uncoupled\""),
        Some(Tread::Bedding) | None => table.optional("bedding_stiffness", &Bounds::positive("N/m^3")),
    };
    let equal_stiffness = match tread {
        Some(Tread::Elastic) => {
            table.refuse(&["equal_stiffness"], "tread = \"elastic\"", "remove it: the others are scaled to this one");
            Some(false)
        }
        Some(Tread::Bedding) => {
            let right = "remove it: the springs have that stiffness unless bedding_stiffness is given";
            table.refuse(&["equal_stiffness"], "tread = \"bedding\"", right);
            Some(false)
        }
        Some(Tread::Uncoupled) | None => table.or("equal_stiffness", &Flag, false),
    };
    let (tread, slice_coupling) = (tread?, slice_coupling?);
    if tread == Tread::Uncoupled && slice_coupling == SliceCoupling::Implicit {
        let right = "remove it: no point feels the others within a step, both couplings are the same";
        return table.complain("slice_coupling", Problem::does_not_belong("tread = \"uncoupled\"", right));
    }
    Some(Contact {
        tread,
        slices: slices?,
        slice_coupling,
        local_compliance: local_compliance?,
        cells_across: cells_across?,
        cells_along: cells_along?,
        slice_tolerance: slice_tolerance?,
        bedding_stiffness: bedding_stiffness?,
        equal_stiffness: equal_stiffness?,
    })
}

fn refuse_stiffness(table: &mut Table<'_>, owner: &str) -> Option<Option<f64>> {
    table.refuse(&["bedding_stiffness"], owner, "remove it, or choose tread = \"bedding\"");
    Some(None)
}
