//! `[tread_pattern]`: grooves, sipes and pitches of the tread, or a raster of its depths.

use std::path::PathBuf;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};
use serde_json::{Value as Json, json};
use toml::de::DeValue;

use crate::scene::Problem;
use crate::scene::keys::{is_default, keys};
use crate::scene::kind::{Bounds, File, NumberList, OneOf, Text, Whole};
use crate::scene::sizes::MOST_PITCHES;
use crate::scene::table::{Each, Keys, Kind, Nested, Table, Value};

/// Greatest depth of a void in the tread \[m\].
pub const DEEPEST_VOID: f64 = 0.02;
const LENGTH: Bounds = Bounds::positive("m").plausible(1e-4, 1.0);
const DEPTH: Bounds = Bounds::between(0.0, DEEPEST_VOID, "m").plausible(1e-5, 1.0);
const ACROSS: Bounds = Bounds::any("m").plausible(1e-6, 2.0);

/// Part of the tyre that a raster shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RasterPeriod {
    /// One pitch, which each pitch of the train stretches to its length.
    Pitch,
    /// The whole circumference.
    #[default]
    Circumference,
}

/// Model of the blocks between grooves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum BlockModel {
    /// The mean pressure of each block compresses it by an additional compliance.
    #[default]
    Compliant,
    /// Blocks are as stiff as the tread without cuts.
    Continuum,
}

/// Pitches round the tyre.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Pitches {
    /// Equal pitches, so many round the tyre.
    Equal(usize),
    /// Pitches of several lengths in a given or random order.
    Varied(PitchSequence),
}

keys! {
    /// Pitches of several lengths, one after the other round the tyre.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub PitchSequence {
        /// Lengths of the pitches A, B, C ... \[m\]; all are scaled by one factor to fill the circumference.
        lengths: Vec<f64> => NumberList(LENGTH),
        /// Order of the pitches by their letters, such as "ABCB", or "random".
        sequence: String => Text,
        /// Number of pitches in a random order; each length comes as often as any other, or once more.
        count?: usize => Whole::between(1, MOST_PITCHES),
        /// Seed of a random order.
        seed?: u64 => Whole::least(0),
    }
}

impl PitchSequence {
    /// The word for a random order.
    pub const RANDOM: &'static str = "random";
    /// Default seed of a random order.
    pub const SEED: u64 = 1;

    /// True if the order is random.
    pub fn is_random(&self) -> bool {
        self.sequence == Self::RANDOM
    }

    /// Lengths in their order round the tyre, not yet scaled \[m\]. A random order is a shuffle of lengths that occur
    /// equally often, or nearly so.
    pub fn in_order(&self) -> Vec<f64> {
        let count = self.lengths.len();
        if !self.is_random() {
            return self
                .sequence
                .chars()
                .filter_map(|letter| self.lengths.get(Self::number(letter)?).copied())
                .collect();
        }
        let mut order: Vec<f64> = (0..self.count.unwrap_or(0)).map(|place| self.lengths[place % count]).collect();
        let mut random = ChaCha8Rng::seed_from_u64(self.seed.unwrap_or(Self::SEED));
        for last in (1..order.len()).rev() {
            // The modulo bias is below 1e-17 for some hundred places.
            order.swap(last, (random.next_u64() % (last as u64 + 1)) as usize);
        }
        order
    }

    /// Index in `lengths` of a letter of the sequence, A being 0; `None` for other characters.
    pub fn number(letter: char) -> Option<usize> {
        letter.is_ascii_uppercase().then(|| letter as usize - 'A' as usize)
    }
}

const VARIED: Nested<PitchSequence> =
    Nested::new("the pitches", "the number of equal pitches, or { lengths = [...], sequence = \"ABC...\" }")
        .read_by(sequence);

fn sequence(table: &mut Table<'_>) -> Option<PitchSequence> {
    let given = table.peek("sequence", &Text).flatten();
    if given.as_deref() != Some(PitchSequence::RANDOM) {
        table.refuse(&["count", "seed"], "a sequence of letters", "remove it, or sequence = \"random\"");
    }
    let read = PitchSequence::read(table)?;
    if read.is_random() {
        return match read.count {
            Some(_) => Some(read),
            None => table.complain("count", Problem::missing("the number of pitches round the tyre, such as 65")),
        };
    }
    if read.sequence.is_empty() {
        return table.complain("sequence", Problem::empty("letters, such as \"ABCB\", or \"random\""));
    }
    let has_length = |letter: &char| PitchSequence::number(*letter).is_some_and(|number| number < read.lengths.len());
    if let Some(letter) = read.sequence.chars().find(|letter| !has_length(letter)) {
        let last = char::from(b'A' + (read.lengths.len().min(26) - 1) as u8);
        let wrong = format!("the pitch {letter} has no length: `lengths` has {}", read.lengths.len());
        return table.complain("sequence", Problem::new(wrong, format!("letters from A to {last}, or more lengths")));
    }
    Some(read)
}

/// Kind of the key `pitches`: a number of equal ones, or a table.
#[derive(Clone, Copy, Debug)]
struct PitchesKind;

impl Kind for PitchesKind {
    type Output = Pitches;

    fn wanted(&self) -> String {
        VARIED.wanted()
    }

    fn read(&self, value: &Value<'_>) -> Option<Pitches> {
        match value.value {
            DeValue::Integer(_) => Whole::between(1, MOST_PITCHES).read(value).map(Pitches::Equal),
            DeValue::Table(_) => VARIED.read(value).map(Pitches::Varied),
            _ => value.wrong_type(self),
        }
    }

    fn schema(&self) -> Json {
        json!({ "anyOf": [Whole::<usize>::between(1, MOST_PITCHES).schema(), VARIED.schema()] })
    }
}

keys! {
    /// A groove round the tyre.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Groove {
        /// Distance of its middle from the tyre's, to the left \[m\].
        position: f64 => ACROSS,
        /// Width \[m\].
        width: f64 => LENGTH,
        /// Depth \[m\].
        depth: f64 => DEPTH,
    }
}

keys! {
    /// A groove or a sipe across, once in each pitch.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub LateralGroove {
        /// Distance of its right end from the tyre's middle, to the left \[m\].
        from: f64 => ACROSS,
        /// Distance of its left end from the tyre's middle, to the left \[m\].
        to: f64 => ACROSS,
        /// Width, square to the groove \[m\].
        width: f64 => LENGTH,
        /// Depth \[m\].
        depth: f64 => DEPTH,
        /// Angle to the direction across; above 0 the left end is further forward \[degrees\].
        angle: f64 = 0.0 => Bounds::inside(-85.0, 85.0, "degrees").no_radians(85.0),
        /// Place in the pitch at which its line crosses the tyre's middle, in parts of the pitch.
        offset: f64 = 0.0 => Bounds::any("").plausible(1e-6, 100.0),
    }
}

const GROOVES: Each<Groove> =
    Each(Nested::new("a groove", "an array of tables, [{ position = ..., width = ..., depth = ... }]"));

const LATERALS: Each<LateralGroove> = Each(
    Nested::new("a groove across", "an array of tables, [{ from = ..., to = ..., width = ..., depth = ... }]")
        .read_by(lateral),
);

fn lateral(table: &mut Table<'_>) -> Option<LateralGroove> {
    let read = LateralGroove::read(table)?;
    table.below("from", "to", &ACROSS, "`to`")?;
    Some(read)
}

keys! {
    /// Pattern of the tread. Its depths turn with the tyre, over cells and over slices of springs.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub TreadPattern {
        /// Raster of depths in place of grooves: a two-dimensional `.npy` array \[m\], along and across, or a `.png`
        /// whose black is `depth` deep.
        file?: PathBuf => File,
        /// Depth of a picture's black \[m\].
        depth?: f64 => DEPTH,
        /// Part of the tyre that the raster shows.
        #[serde(skip_serializing_if = "is_default")]
        period: RasterPeriod = RasterPeriod::Circumference => OneOf::new(),
        /// Number of equal pitches round the tyre, or their lengths and their order.
        pitches?: Pitches => PitchesKind,
        /// Grooves round the tyre.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        grooves: Vec<Groove> = Vec::new() => GROOVES,
        /// Grooves across, in each pitch.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        laterals: Vec<LateralGroove> = Vec::new() => LATERALS,
        /// Sipes across, in each pitch: cuts that are narrower than a cell. They divide blocks and are no void.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        sipes: Vec<LateralGroove> = Vec::new() => LATERALS,
        /// Model of the blocks between grooves.
        #[serde(skip_serializing_if = "is_default")]
        blocks: BlockModel = BlockModel::Compliant => OneOf::new(),
        /// Compliance of every block's mean pressure, in place of the formula \[m/Pa\].
        block_compliance?: f64 => Bounds::not_negative("m/Pa").plausible(1e-13, 1e-6),
    }
}

pub(in crate::scene) const TREAD_PATTERN: Nested<TreadPattern> =
    Nested::new("[tread_pattern]", "the table [tread_pattern] with pitches and grooves, or with a file")
        .read_by(pattern);

fn pattern(table: &mut Table<'_>) -> Option<TreadPattern> {
    if table.has("file") {
        table.refuse(&["grooves", "laterals", "sipes"], "a raster", "remove it: the raster has all depths");
    } else {
        let right = "remove it, or name a file with the depths";
        table.refuse(&["depth", "period"], "grooves that are given one by one", right);
    }
    let read = TreadPattern::read(table)?;
    if read.blocks == BlockModel::Continuum && read.block_compliance.is_some() {
        let problem = Problem::does_not_belong("blocks = \"continuum\"", "remove it, or blocks = \"compliant\"");
        return table.complain("block_compliance", problem);
    }
    let by_pitch = read.period == RasterPeriod::Pitch && read.file.is_some();
    if (by_pitch || !read.laterals.is_empty() || !read.sipes.is_empty()) && read.pitches.is_none() {
        return table.complain("pitches", Problem::missing("their number, such as 65, or their lengths and sequence"));
    }
    let Some(file) = &read.file else { return Some(read) };
    match file.extension().and_then(|ending| ending.to_str()) {
        Some("png") if read.depth.is_none() => {
            table.complain("depth", Problem::missing("the depth of the picture's black, such as 0.008"))
        }
        Some("npy") if read.depth.is_some() => {
            let right = "remove it, or name a .png";
            table.complain("depth", Problem::does_not_belong("an array, which is in metres", right))
        }
        Some("png" | "npy") => Some(read),
        _ => {
            let wrong = format!("\"{}\" is neither .npy nor .png", file.display());
            table.complain("file", Problem::new(wrong, "name a two-dimensional .npy array or a .png"))
        }
    }
}
