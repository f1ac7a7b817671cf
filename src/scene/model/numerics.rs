//! `[numerics]` and `[outputs]`: resolution, tolerances, and what is written.

use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Value as Json, json};

use super::vibration::{VIBRATION, Vibration};
use crate::counters::catalogue::catalogue;
use crate::scene::Problem;
use crate::scene::keys::keys;
use crate::scene::kind::{Bounds, Decibels, Flag, OneOf, Optional, Whole};
use crate::scene::sizes::MOST;
use crate::scene::table::{Keys, Kind, Nested, Table, Value};
use crate::time_rule::{Advance, TimeRule};

const FORMER_RULES: [[&str; 2]; 2] = [
    ["trapezoidal", "write \"sdirk2\", of the same order, whose force does not ring at half the sampling frequency"],
    ["first-order-hold", "write \"sdirk2\", of the same order, with which no force grows while nothing moves"],
];

keys! {
    /// Resolution and tolerances.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Numerics {
        /// Highest frequency wanted \[Hz\]: the plan chooses elements and substeps by it where they are not given.
        fmax?: f64 => FMAX,
        /// Row of the plan's table of accuracy against time, from which all settings are taken that are not given.
        preset?: Preset => OneOf::new(),
        /// Largest numerical error of third-octave levels up to `fmax` \[dB\]: the cheapest row of the plan's table
        /// that keeps it is taken.
        #[serde(skip_serializing_if = "Option::is_none", serialize_with = "optional_decibels")]
        accuracy: Option<f64> = None => Optional(Decibels(Bounds::between(0.05, 12.0, "dB"))),
        /// Elements N round the tyre; even.
        elements: usize = 512 => Elements,
        /// Time steps q per element rolled.
        substeps: usize = 1 => Whole::between(1, MOST),
        /// Elements s rolled in a time step, beside `substeps = 1`; N is a multiple of 2 s.
        elements_per_step: usize = 1 => Whole::between(1, MOST),
        /// Time rule; by default `sdirk2`, with a direct history `bdf2`.
        time_rule: TimeRule = TimeRule::Sdirk2 => OneOf::instead_of(&FORMER_RULES),
        /// Treatment of the force history; by default by poles, or as a sum if a `memory` is given.
        history: History = History::Modal => OneOf::new(),
        /// Length of the force history that is kept, `direct` only \[s\].
        memory: f64 = 0.7 => Bounds::positive("s").plausible(1e-6, 1e5),
        /// Tolerance of the rational models of the influence functions, `modal` only; relative to each one's value, or
        /// to 0.003 of its largest where that is more. The bounds: what a fit in double precision can reach, and what
        /// can still be called a fit.
        pole_tolerance: f64 = 1e-5 => Bounds::between(1e-10, 1e-2, ""),
        /// Relative tolerance of the wavenumber sums, of the influence function's static value. Below a few units of
        /// rounding no sum of thousands of terms converges.
        influence_tolerance: f64 = 1e-7 => Bounds::between(1e-14, 0.1, ""),
        /// Tolerance of the contact conditions, relative to the largest required displacement. A linear solve cannot
        /// leave less than rounding; with a larger tolerance a contact condition would say nothing.
        contact_tolerance: f64 = 1e-12 => Bounds::between(1e-15, 1e-3, ""),
        /// A fixed number of odd lateral terms m, instead of the tolerance.
        lateral_terms?: usize => Whole::between(1, MOST),
        /// A fixed largest alias |p|, instead of the tolerance.
        wavenumber_aliases?: usize => Whole::between(0, MOST),
        /// Largest number of cached factorisations; fewer where they would take more than 256 MB.
        cached_factors: usize = 32 => Whole::between(1, MOST),
        /// Memory that the run may plan to use \[GB\].
        memory_limit: f64 = 8.0 => Bounds::positive("GB").plausible(1e-6, 1e6),
        /// Computing time on one core that the run may plan to use \[h\].
        time_limit: f64 = 24.0 => Bounds::positive("h").plausible(1e-6, 1e6),
    }
}

/// From the lowest third octave that is written: a value in kHz lies below.
const FMAX: Bounds = Bounds::positive("Hz").plausible(25.0, 1e5);

pub(in crate::scene) const NUMERICS: Nested<Numerics> =
    Nested::new("[numerics]", "the table [numerics]").read_by(numerics);

impl Numerics {
    /// Least number of elements: fewer put less than two into the patch of a car tyre.
    pub const FEWEST_ELEMENTS: usize = 16;

    /// Forgets the wishes by which other settings were chosen; those keep their values.
    pub fn forget_wishes(&mut self) {
        (self.fmax, self.preset, self.accuracy) = (None, None, None);
    }

    /// Words for a message where the wanted `fmax` exceeds `highest` \[Hz\]; `None` if it does not, or none is wanted.
    pub fn missed(&self, highest: f64) -> Option<String> {
        let fmax = self.fmax.filter(|fmax| highest < *fmax)?;
        Some(format!(": numerics.fmax = {fmax} Hz is not reached"))
    }

    /// How far the tyre rolls in a step.
    pub const fn advance(&self) -> Advance {
        Advance { substeps: self.substeps, elements_per_step: self.elements_per_step }
    }

    /// Sets how far the tyre rolls in a step.
    pub const fn take_advance(&mut self, advance: Advance) {
        Advance { substeps: self.substeps, elements_per_step: self.elements_per_step } = advance;
    }

    /// `memory_limit` in bytes.
    pub fn memory_bytes(&self) -> u64 {
        (self.memory_limit * 1e9) as u64
    }
}

fn numerics(table: &mut Table<'_>) -> Option<Numerics> {
    let read = Numerics::read(table);
    if table.has("preset") && table.has("accuracy") {
        let wrong = "this and `preset` both choose a row of the same table";
        return table.complain("accuracy", Problem::new(wrong, "either this or `preset`"));
    }
    if let Some(key) = ["preset", "accuracy"].into_iter().find(|key| table.has(key))
        && !table.has("fmax")
    {
        let wanted = format!("{FMAX}, the highest frequency that numerics.{key} is meant for");
        return table.complain("fmax", Problem::missing(&wanted));
    }
    let mut read = read?;
    let Numerics { elements, substeps, elements_per_step, .. } = read;
    if elements_per_step > 1 && substeps > 1 {
        let wrong = format!("a step cannot roll {elements_per_step} elements and a part of one, substeps = {substeps}");
        return table.complain("elements_per_step", Problem::new(wrong, "either this or `substeps`"));
    }
    let is_left_open = table.has("fmax") && !table.has("elements");
    if elements_per_step > 1 && !is_left_open && !elements.is_multiple_of(2 * elements_per_step) {
        let wrong = format!("{elements} elements are no multiple of twice {elements_per_step}");
        let right = format!("1, or elements = {}", elements.next_multiple_of(2 * elements_per_step));
        return table.complain("elements_per_step", Problem::new(wrong, right));
    }
    // A given memory implies the sum; its convolution weights exist for multistep rules only.
    if table.has("memory") && !table.has("history") {
        read.history = History::Direct;
    }
    if read.history == History::Direct && !table.has("time_rule") {
        read.time_rule = TimeRule::Bdf2;
    }
    Some(read)
}

/// An even number of elements within bounds.
struct Elements;

impl Kind for Elements {
    type Output = usize;

    fn wanted(&self) -> String {
        format!("an even whole number of at least {} and at most {MOST}", Numerics::FEWEST_ELEMENTS)
    }

    fn read(&self, value: &Value<'_>) -> Option<usize> {
        if value.value.as_integer().is_none() {
            return value.wrong_type(self);
        }
        let elements: usize = Whole::between(Numerics::FEWEST_ELEMENTS as u64, MOST).read(value)?;
        // Wavenumbers run from -N/2 to N/2 - 1.
        if elements.is_multiple_of(2) {
            Some(elements)
        } else {
            let right = format!("write an even number, such as {}", elements - 1);
            value.complain(Problem::new(format!("{elements} is odd"), right))
        }
    }

    fn schema(&self) -> Json {
        json!({ "type": "integer", "minimum": Numerics::FEWEST_ELEMENTS, "maximum": MOST, "multipleOf": 2 })
    }
}

fn optional_decibels<S: Serializer>(accuracy: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    accuracy.map(Decibels::text).serialize(serializer)
}

/// Writes a level difference as it is read, in quotes.
pub(super) fn decibels<S: Serializer>(difference: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    Decibels::text(*difference).serialize(serializer)
}

catalogue! {
    /// A named row of the table of accuracy against time.
    pub enum Preset as "kebab-case",
    /// The value of `numerics.preset` in a scene.
    name {
        /// For trying out: fast, levels within a few decibels.
        Draft => "draft",
        /// For final results.
        Standard => "standard",
        /// For comparison with other results: the most accurate.
        Reference => "reference",
    }
}

/// How the displacement due to past forces is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum History {
    /// The convolution sum over `memory` seconds: the reference.
    Direct,
    /// A recursion per pole of the rational model: the whole past, much faster.
    #[default]
    Modal,
}

keys! {
    /// Files in the results folder beside `summary.json`.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Outputs {
        /// `time.npy`, `total_force.npy`, `patch_force.npy`, `patch_element.npy`.
        arrays: bool = true => Flag,
        /// `spectra.csv`.
        spectra: bool = true => Flag,
        /// SVG plots.
        plots: bool = true => Flag,
        /// How much of the run after the warm-up `patch_force.svg` shows \[s\]; default: the time in which six lengths
        /// of the patch are rolled.
        patch_span?: f64 => Bounds::positive("s"),
        /// Wall time between two checkpoints of an unfinished run \[s\]; 0: only when it is interrupted.
        checkpoint_interval: f64 = 60.0 => Bounds::not_negative("s").plausible(1e-6, 1e9),
        /// Time between two instants at which all cells are written to `cells.npy` \[s\], with
        /// `contact.zone = "cells"` only; none without it.
        cells_every?: f64 => Bounds::positive("s").plausible(1e-9, 1e6),
        /// Length of the sections of the road rolled after the warm-up, each of which has levels of its own in
        /// `sections.csv` \[m\]; none without it.
        sections?: f64 => Bounds::between(0.5, 1e4, "m"),
        /// Vibration of the tyre; none is computed without it.
        vibration?: Vibration => VIBRATION,
        /// Levels of a finer mesh with a standard error; without it levels are those of the run's mesh.
        levels?: MeshLevels => MESH_LEVELS,
    }
}

keys! {
    /// Levels of a finer mesh: the run, over the scene's elements, is corrected by short runs over these and over more
    /// elements, on the first piece of its road. Over `contact.zone = "cells"` only.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub MeshLevels {
        /// Standard error wanted of every third octave from 100 Hz to the highest valid one \[dB\]: the short runs last
        /// as long as that takes, and the run no longer, but to `rolling.duration` at most.
        standard_error: f64 => Bounds::between(0.05, 6.0, "dB"),
        /// Elements of the finer mesh, a multiple of `numerics.elements`; twice as many by default.
        elements?: usize => Elements,
        /// Segments of the road that are rolled side by side on as many threads, each after a warm-up of its own; 1 for
        /// a run in one piece.
        segments: usize = 1 => Whole::between(1, MOST_SEGMENTS),
    }
}

/// Most segments of a run.
const MOST_SEGMENTS: u64 = 1000;

const MESH_LEVELS: Nested<MeshLevels> = Nested::new("[outputs.levels]", "the table [outputs.levels]");

impl MeshLevels {
    /// Elements of the finer mesh beside a run over so many.
    pub(crate) fn fine_elements(&self, elements: usize) -> usize {
        self.elements.unwrap_or(2 * elements)
    }
}

pub(in crate::scene) const OUTPUTS: Nested<Outputs> = Nested::new("[outputs]", "the table [outputs]");
