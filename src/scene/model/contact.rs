//! `[contact]`: contact laws of tread and road slices.

use serde::{Deserialize, Serialize, Serializer};

use super::numerics::decibels;
use super::road::Road;
use crate::scene::Problem;
use crate::scene::keys::{is_default, keys};
use crate::scene::kind::{Bounds, Decibels, Flag, OneOf, Whole};
use crate::scene::sizes::MOST_CELLS;
use crate::scene::table::{Keys, Nested, Table};

/// Most sub-cells of a cell along and across: they are 1 mm long where cells are 8 mm, about as long as cells can be.
const MOST_SUB_CELLS: u64 = 8;

/// Default bound of the error of levels computed by slices \[dB\].
const LARGEST_SLICE_ERROR: f64 = 2.0;

fn is_usual(error: &f64) -> bool {
    error.to_bits() == LARGEST_SLICE_ERROR.to_bits()
}

const FORMER_SLICES: [[&str; 2]; 1] =
    [["none", "write \"winkler\"; cells_across = 1 and cells_along = 1 make slices flat, on the road's middle line"]];
const FORMER_COUPLINGS: [[&str; 2]; 1] = [[
    "implicit",
    "write \"local\", or \"explicit\", the paper's equation 4: this one had no limit for short time steps either",
]];

keys! {
    /// Contact laws.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Contact {
        /// Zone of the contact: slices or cells.
        #[serde(skip_serializing_if = "is_default")]
        zone: Zone = Zone::default() => OneOf::new(),
        /// How the tread deforms.
        tread: Tread = Tread::default() => OneOf::new(),
        /// How the road under an element deforms the tread.
        slices: Slices = Slices::default() => OneOf::instead_of(&FORMER_SLICES),
        /// Compliance of a slice in addition to that of the element as a whole.
        slice_coupling: SliceCoupling = SliceCoupling::default() => OneOf::instead_of(&FORMER_COUPLINGS),
        /// kappa \[m/Pa\] of `slice_coupling = "local"`: a slice under the line force f yields like a spring of
        /// compliance kappa/(dx b). Default: from the tread's modulus and the road's texture.
        local_compliance?: f64 => Bounds::positive("m/Pa").plausible(1e-18, 1e-4),
        /// Size of a cell across \[m\], `zone = "cells"` only; instead of `cells_across`. Default: that of the
        /// preset, without one a cell's length.
        cell?: f64 => Bounds::positive("m").plausible(1e-5, 1.0),
        /// Cells across the contact width; default: as many as the road's texture asks for, each about 2 mm at most (a
        /// grid that fits exactly keeps its columns).
        cells_across?: usize => Whole::between(1, MOST_CELLS),
        /// Sub-cells of a cell along and across, `zone = "cells"` only: they touch the road, the cells carry the tyre's
        /// waves and their history. 1: the cells themselves touch. Default: that of the preset, without one 1.
        sub_cells?: usize => Whole::between(1, MOST_SUB_CELLS),
        /// Cells along an element; default: as many as the road's texture asks for, each 2 mm at most (a grid that fits
        /// exactly keeps its rows).
        cells_along?: usize => Whole::between(1, MOST_CELLS),
        /// Largest error of a slice's displacement curve that leaving breakpoints out may make \[m\]; 0 keeps it
        /// exact. The default is that of the standard preset: thinned curves err to the same side in every slice,
        /// 1e-6 m changes levels by 0.1 dB, 1e-5 m by 6 dB (measured at N = 512).
        slice_tolerance: f64 = 3e-7 => Bounds::between(0.0, 1e-3, "m"),
        /// Largest error of a third octave by slices, compared with cells, of valid levels and audio files: from the
        /// first band with a larger one on, bands are not valid. The error itself is in the tables of levels.
        #[serde(skip_serializing_if = "is_usual", serialize_with = "decibels")]
        largest_slice_error: f64 = LARGEST_SLICE_ERROR => Decibels(Bounds::between(0.1, 60.0, "dB")),
        /// Spring stiffness per area of the `bedding` tread \[N/m^3\]; default: influence functions and springs
        /// that give one element alone and the smooth static contact the stiffness of the elastic tread.
        bedding_stiffness?: f64 => Bounds::positive("N/m^3").plausible(1e3, 1e16),
        /// `uncoupled` only: whether G0_ii is scaled so that the smooth static contact has the stiffness of the elastic
        /// tread.
        #[serde(skip_serializing_if = "std::ops::Not::not")]
        equal_stiffness: bool = false => Flag,
    }
}

pub(in crate::scene) const CONTACT: Nested<Contact> = Nested::new("[contact]", "the table [contact]").read_by(contact);

/// Writes the keys of the zone alone: a scene of cells with the keys of slices would be refused when it is read back.
pub(super) fn of_zone<S: Serializer>(contact: &Contact, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct OfCells {
        zone: Zone,
        #[serde(skip_serializing_if = "Option::is_none")]
        cell: Option<f64>,
        #[serde(skip_serializing_if = "Option::is_none")]
        cells_across: Option<usize>,
        #[serde(skip_serializing_if = "Option::is_none")]
        sub_cells: Option<usize>,
    }
    match *contact {
        Contact { zone: Zone::Slices, .. } => contact.serialize(serializer),
        Contact { zone, cell, cells_across, sub_cells, .. } => {
            OfCells { zone, cell, cells_across, sub_cells }.serialize(serializer)
        }
    }
}

/// Keys that have no meaning for cells.
pub(crate) const OF_SLICES: [&str; 8] = [
    "slices",
    "slice_coupling",
    "local_compliance",
    "cells_along",
    "slice_tolerance",
    "largest_slice_error",
    "bedding_stiffness",
    "equal_stiffness",
];

fn contact(table: &mut Table<'_>) -> Option<Contact> {
    match table.peek("zone", &OneOf::<Zone>::new()).map(Option::unwrap_or_default) {
        Some(Zone::Cells) => {
            let owner = "zone = \"cells\", where each cell has a force of its own";
            table.refuse(&OF_SLICES, owner, "remove it, or choose zone = \"slices\"");
            let tread = table.peek("tread", &OneOf::<Tread>::new()).flatten();
            if tread.is_some_and(|tread| tread != Tread::Elastic) {
                let problem = Problem::new("cells are coupled through the tread", "remove it: cells are elastic");
                table.complain::<()>("tread", problem);
            }
            if table.has("cell") && table.has("cells_across") {
                let wrong = "this and `cells_across` both say how many cells there are across";
                return table.complain("cell", Problem::new(wrong, "either this or `cells_across`"));
            }
        }
        Some(Zone::Slices) => {
            table.refuse(&["cell", "sub_cells"], "zone = \"cells\"", "remove it, or choose zone = \"cells\"");
        }
        None => {}
    }
    let tread = table.peek("tread", &OneOf::<Tread>::new()).map(Option::unwrap_or_default);
    let coupling = table.peek("slice_coupling", &OneOf::<SliceCoupling>::new()).map(Option::unwrap_or_default);
    if coupling == Some(SliceCoupling::Explicit) {
        let owner = "the paper's slice coupling, whose compliance is G0_ii";
        table.refuse(&["local_compliance"], owner, "remove it, or choose slice_coupling = \"local\"");
    }
    let slices = table.peek("slices", &OneOf::<Slices>::new()).flatten();
    if slices == Some(Slices::Pressed) {
        let owner = "slices = \"pressed\", whose curves contain the whole compliance of a slice";
        let right = "remove it, or choose slices = \"winkler\"";
        table.refuse(&["local_compliance"], owner, right);
        if coupling == Some(SliceCoupling::Explicit) {
            return table.complain("slice_coupling", Problem::does_not_belong(owner, right));
        }
        if tread == Some(Tread::Bedding) {
            let wrong = "springs on the carcass are independent, and a road is pressed by a coupled tread";
            return table.complain("tread", Problem::new(wrong, "an elastic tread, or slices = \"winkler\""));
        }
    }
    let (elastic, bedding) = ("tread = \"elastic\"", "remove it, or choose tread = \"bedding\"");
    match tread {
        Some(Tread::Elastic) => {
            table.refuse(&["bedding_stiffness"], elastic, bedding);
            table.refuse(&["equal_stiffness"], elastic, "remove it: the others are scaled to this one");
        }
        Some(Tread::Uncoupled) => table.refuse(&["bedding_stiffness"], "tread = \"uncoupled\"", bedding),
        Some(Tread::Bedding) => {
            let right = "remove it: the springs have that stiffness unless bedding_stiffness is given";
            table.refuse(&["equal_stiffness"], "tread = \"bedding\"", right);
        }
        None => {}
    }
    Contact::read(table)
}

/// Zone of the contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Zone {
    /// Slices, one for each element of the tyre, the road's texture in how they yield.
    #[default]
    Slices,
    /// Cells along and across, the texture in their heights: contact in three dimensions.
    Cells,
}

/// Tread law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tread {
    /// The elastic layer with coupling between contact points.
    #[default]
    Elastic,
    /// The elastic layer without coupling within one time step (diagonal of G0). The neglected part decreases with the
    /// time step: the limit is the elastic layer.
    Uncoupled,
    /// Independent springs on the belt.
    Bedding,
}

/// Road slice law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Slices {
    /// Independent springs all over the slice.
    #[default]
    Winkler,
    /// Each line of cells across is a rough profile on an elastic half-space.
    HalfSpace,
    /// The road pressed in three dimensions by the flat tread.
    Pressed,
}

impl Contact {
    /// Cell size of the local law on a road whose spectrum has no shortest wave \[m\]: [`Road::CELL`]. The law
    /// considers no shorter waves: springs have no limit as cells get smaller, and pressing takes far longer. `None`
    /// where cells resolve a road, the finer the better.
    pub fn cell_of_law(&self, road: &Road) -> Option<f64> {
        let endless = matches!(road, Road::Profile(_) | Road::OpenCrg(_)) && road.varies_across();
        (endless && self.is_local()).then_some(Road::CELL)
    }

    /// True if slices yield by the local law, as springs or as pressed.
    pub fn is_local(&self) -> bool {
        self.zone == Zone::Slices
            && self.slice_coupling == SliceCoupling::Local
            && matches!(self.slices, Slices::Winkler | Slices::Pressed)
    }
}

impl Slices {
    /// This law, or springs in place of a pressed slice, for the slice coupling and tread law that do not support it.
    #[must_use]
    pub fn alone(self) -> Self {
        if self == Self::Pressed { Self::Winkler } else { self }
    }
}

/// Compliance of a slice in addition to that of the element as a whole.
///
/// `explicit` is the paper's equation 4 and takes the influence of the element on itself within one time step for the
/// slice's spring; that decreases with the time step, and with it the compliance of the texture, so that it has no
/// limit for small time steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SliceCoupling {
    /// By a local compliance of the tread under the asperities, independent of the time step.
    #[default]
    Local,
    /// By G0_ii, the curve evaluated at the penetration without the forces of the step.
    Explicit,
}
