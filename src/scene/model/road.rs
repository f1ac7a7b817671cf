//! `[road]`: the kinds of roads, and their continuation beyond the measured part.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

use super::conditioning::{Levelling, MissingHeight, MissingHeights};
use super::made_road::{MadeRoad, made};
use super::named_texture::NamedTexture;
use crate::scene::keys::{is_default, keys};
use crate::scene::kind::{Bounds, Columns, Exactly, File, OneOf, Whole};
use crate::scene::table::{Keys, Nested, Table};
use crate::scene::{Problem, schema};

const LENGTH: Bounds = Bounds::positive("m").plausible(1e-6, 1e4);
const COORDINATE: Bounds = Bounds::any("m").plausible(1e-9, 1e7);

/// The road and its continuation past its end.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Road {
    /// The plane z = 0.
    #[default]
    Smooth,
    /// Isotropic random texture of a given spectrum, endless.
    Made(MadeRoad),
    /// A measured longitudinal profile.
    Profile(ProfileRoad),
    /// An OpenCRG file.
    #[serde(rename = "opencrg")]
    OpenCrg(OpenCrgRoad),
    /// A height map in a two-dimensional `.npy` array.
    Grid(GridRoad),
}

impl Road {
    /// Largest size of a cell chosen for a road \[m\].
    pub const CELL: f64 = 0.002;

    /// True if the height of the road may vary across the width.
    pub fn varies_across(&self) -> bool {
        !matches!(self, Self::Smooth | Self::Profile(ProfileRoad { lateral: Lateral::Extruded, .. }))
    }

    /// Cell size for levels within about a decibel \[m\]: half the shortest wave of a made road, the spacing of a
    /// height map; at most [`Self::CELL`]. The shortest waves of other files are not known before they are read: a
    /// quarter of [`Self::CELL`], which a coarse chip seal needs (profiles/README.md).
    pub fn cell(&self) -> f64 {
        let shortest = match self {
            Self::Smooth => return Self::CELL,
            Self::Made(MadeRoad { power_law: Some(law), .. }) => law.shortest,
            Self::Made(MadeRoad { wavelengths: Some(given), .. }) => {
                given.iter().copied().fold(f64::INFINITY, f64::min)
            }
            Self::Made(_) => NamedTexture::SHORTEST,
            // The spacings of a text file are not known before it is read.
            Self::Grid(grid) => 2.0 * grid.dx.unwrap_or(0.0).min(grid.dy.unwrap_or(0.0)),
            Self::Profile(_) | Self::OpenCrg(_) => 0.0,
        };
        (0.5 * shortest).clamp(0.25 * Self::CELL, Self::CELL)
    }

    /// Number of cells of at most the size `cell` on a length \[m\], at least 1.
    pub fn cells(length: f64, cell: f64) -> usize {
        // A whole number up to rounding in a scene file counts as whole.
        (length / cell - 1e-9).ceil().max(1.0) as usize
    }
}

/// Unit of a length in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum LengthUnit {
    /// Metre.
    #[serde(rename = "m")]
    Metre,
    /// Millimetre.
    #[serde(rename = "mm")]
    Millimetre,
    /// Micrometre.
    #[serde(rename = "um")]
    Micrometre,
    /// Centimetre.
    #[serde(rename = "cm")]
    Centimetre,
    /// Inch, 25.4 mm.
    #[serde(rename = "in")]
    Inch,
    /// Foot, 12 inches.
    #[serde(rename = "ft")]
    Foot,
    /// Thousandth of an inch.
    #[serde(rename = "mil")]
    Mil,
}

impl LengthUnit {
    /// All units, one of each in metres, and their words in column titles, in lower case; the first word is that in a
    /// scene.
    const ALL: [(Self, f64, &[&str]); 7] = [
        (Self::Metre, 1.0, &["m", "metre", "metres", "meter", "meters"]),
        (Self::Millimetre, 1e-3, &["mm", "millimetre", "millimetres", "millimeter", "millimeters"]),
        (
            Self::Micrometre,
            1e-6,
            &[
                "um",
                "\u{b5}m",
                "\u{3bc}m",
                "micrometre",
                "micrometres",
                "micrometer",
                "micrometers",
                "micron",
                "microns",
            ],
        ),
        (Self::Centimetre, 1e-2, &["cm", "centimetre", "centimetres", "centimeter", "centimeters"]),
        (Self::Inch, 0.0254, &["in", "inch", "inches"]),
        (Self::Foot, 0.3048, &["ft", "foot", "feet"]),
        (Self::Mil, 25.4e-6, &["mil", "mils", "thou"]),
    ];

    /// The unit named by a word, in any case.
    pub(crate) fn of_word(word: &str) -> Option<Self> {
        let word = word.trim().to_lowercase();
        Self::ALL.into_iter().find(|(.., words)| words.contains(&word.as_str())).map(|(unit, ..)| unit)
    }

    /// The unit's word in a scene.
    pub(crate) fn word(self) -> &'static str {
        Self::ALL.iter().find(|(unit, ..)| *unit == self).map_or("m", |(.., words)| words[0])
    }

    /// One unit in metres.
    pub(crate) fn metres(self) -> f64 {
        Self::ALL.iter().find(|(unit, ..)| *unit == self).map_or(1.0, |(_, metres, _)| *metres)
    }
}

/// How a profile is continued across the width.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Lateral {
    /// The same height across.
    #[default]
    Extruded,
    /// An endless isotropic surface with the same profile spectrum and random phases.
    Isotropic,
}

/// Continuation of a measured road that is narrower than the contact strip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Widen {
    /// Undefined: a run that needs a wider road is refused.
    #[default]
    Refuse,
    /// The road's mirror images at its edges.
    Mirror,
}

/// Continuation past the end of a measured road.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AtEnd {
    /// Undefined: a run that needs more road than there is is refused.
    #[default]
    Refuse,
    /// The road starts again.
    Repeat,
    /// The road is traversed back and forth.
    Mirror,
}

keys! {
    /// A measured longitudinal profile from a file of columns.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub ProfileRoad {
        /// A table of text, CAPTIF `.dat`, or ERD; relative to the scene.
        file: PathBuf => File,
        /// Unit of the distances, where the file does not state it.
        distance_unit?: LengthUnit => OneOf::new(),
        /// Unit of the heights, where the file does not state it.
        height_unit?: LengthUnit => OneOf::new(),
        /// Columns of distance and height, by their titles or numbers from 1; default: by titles, or the only two. Of
        /// an ERD file the channel of the heights alone.
        columns?: Vec<String> => Columns,
        /// Part of the profile to use \[m\]; default: all of it (CAPTIF: between the reference plates).
        range?: [f64; 2] => RANGE,
        /// Values that mark missing heights, besides empty cells and NaN: numbers in the file's unit, words; [] if
        /// there are none. Default: values that recur exactly and lie far from all others are recognised.
        missing?: Vec<MissingHeight> => MissingHeights,
        /// Level that is subtracted from the heights: mean and slope along and across, the mean alone, or nothing.
        #[serde(skip_serializing_if = "is_default")]
        level: Levelling = Levelling::default() => OneOf::new(),
        /// Waves longer than this are removed \[m\]; default: none.
        longest_wavelength?: f64 => LENGTH,
        /// How a line becomes a surface.
        lateral: Lateral = Lateral::default() => OneOf::new(),
        /// Seed of the random phases (`lateral = "isotropic"`).
        seed: u64 = 0 => Whole::least(0),
        /// Continuation past the end.
        at_end: AtEnd = AtEnd::default() => OneOf::new(),
    }
}

const RANGE: Exactly<2> = Exactly(COORDINATE);

keys! {
    /// An OpenCRG road.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub OpenCrgRoad {
        /// The `.crg` file; relative to the scene.
        file: PathBuf => File,
        /// Lateral position v of the tyre's middle \[m\]; default: the middle of the valid columns.
        lateral_position?: f64 => COORDINATE,
        /// Continuation of a road that is narrower than the contact strip.
        #[serde(skip_serializing_if = "is_default")]
        widen: Widen = Widen::default() => OneOf::new(),
        /// Values that mark missing heights, besides empty cells and NaN: numbers in the file's unit, words; [] if
        /// there are none. Default: values that recur exactly and lie far from all others are recognised.
        missing?: Vec<MissingHeight> => MissingHeights,
        /// Level that is subtracted from the heights: mean and slope along and across, the mean alone, or nothing.
        #[serde(skip_serializing_if = "is_default")]
        level: Levelling = Levelling::default() => OneOf::new(),
        /// Waves longer than this are removed \[m\]; default: none.
        longest_wavelength?: f64 => LENGTH,
        /// Continuation past the end.
        at_end: AtEnd = AtEnd::default() => OneOf::new(),
    }
}

keys! {
    /// A height map. Rows run along x from road coordinate 0, columns across, centred on the tyre, cell-centred.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub GridRoad {
        /// A two-dimensional `.npy` array of heights, or text: points x, y, z on a grid, or an ESRI grid (`.asc`);
        /// relative to the scene.
        file: PathBuf => File,
        /// Row spacing of an array \[m\]: row r lies at road coordinate r dx. Text states its spacings.
        dx?: f64 => LENGTH,
        /// Column spacing of an array \[m\].
        dy?: f64 => LENGTH,
        /// Unit of x and y of text, where it does not state it.
        distance_unit?: LengthUnit => OneOf::new(),
        /// Unit of the heights; of an array metres by default.
        height_unit?: LengthUnit => OneOf::new(),
        /// Columns of x (along the road), y and height, by their titles or numbers from 1.
        columns?: Vec<String> => Columns,
        /// Continuation of a road that is narrower than the contact strip.
        #[serde(skip_serializing_if = "is_default")]
        widen: Widen = Widen::default() => OneOf::new(),
        /// Values that mark missing heights, besides empty cells and NaN: numbers in the file's unit, words; [] if
        /// there are none. Default: values that recur exactly and lie far from all others are recognised.
        missing?: Vec<MissingHeight> => MissingHeights,
        /// Level that is subtracted from the heights: mean and slope along and across, the mean alone, or nothing.
        #[serde(skip_serializing_if = "is_default")]
        level: Levelling = Levelling::default() => OneOf::new(),
        /// Waves longer than this are removed \[m\]; default: none.
        longest_wavelength?: f64 => LENGTH,
        /// Continuation past the end.
        at_end: AtEnd = AtEnd::default() => OneOf::new(),
    }
}

impl GridRoad {
    /// True if the file is an `.npy` array, by its ending, not text.
    pub(crate) fn is_array(&self) -> bool {
        is_array(&self.file)
    }
}

fn is_array(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npy"))
}

impl Road {
    /// File that the road is read from; `None` for a smooth or a made road.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::Smooth | Self::Made(_) => None,
            Self::Profile(road) => Some(&road.file),
            Self::OpenCrg(road) => Some(&road.file),
            Self::Grid(road) => Some(&road.file),
        }
    }

    /// As [`Self::file`], to be changed.
    pub(crate) fn file_mut(&mut self) -> Option<&mut PathBuf> {
        match self {
            Self::Smooth | Self::Made(_) => None,
            Self::Profile(road) => Some(&mut road.file),
            Self::OpenCrg(road) => Some(&mut road.file),
            Self::Grid(road) => Some(&mut road.file),
        }
    }
}

pub(in crate::scene) const ROAD: Nested<Road> = Nested {
    title: "the road",
    wanted: "the table [road] with a kind and its keys",
    schema: || OneOf::<RoadKind>::tables("kind", "What kind of road it is.", |kind| kind.table().1()),
    read: road,
};

/// The words accepted as `kind`; the tags of [`Road`].
#[derive(Clone, Copy, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
enum RoadKind {
    Smooth,
    Made,
    Profile,
    OpenCrg,
    Grid,
}

impl RoadKind {
    /// The kind in words, the schema of its keys, and their reader.
    #[expect(clippy::type_complexity, reason = "three parts of one statement")]
    fn table(self) -> (&'static str, fn() -> Json, fn(&mut Table<'_>) -> Option<Road>) {
        match self {
            Self::Smooth => ("a smooth road", || schema::table("The plane z = 0.", []), |_| Some(Road::Smooth)),
            Self::Made => ("a made road", MadeRoad::schema, |table| made(table).map(Road::Made)),
            Self::Profile => ("a profile road", ProfileRoad::schema, |table| profile(table).map(Road::Profile)),
            Self::OpenCrg => {
                ("an opencrg road", OpenCrgRoad::schema, |table| OpenCrgRoad::read(table).map(Road::OpenCrg))
            }
            Self::Grid => ("a grid road", GridRoad::schema, |table| grid(table).map(Road::Grid)),
        }
    }
}

fn road(table: &mut Table<'_>) -> Option<Road> {
    let Some(kind) = table.required("kind", &OneOf::<RoadKind>::new()) else {
        table.be_lenient();
        return None;
    };
    let (title, _, read) = kind.table();
    table.rename(title);
    read(table)
}

/// Former keys, each for one column, now in `columns`.
const OLD_COLUMNS: [&str; 2] = ["distance_column", "height_column"];

fn grid(table: &mut Table<'_>) -> Option<GridRoad> {
    let mut sound = Some(());
    match table.peek("file", &File) {
        Some(Some(file)) if is_array(&file) => {
            for key in ["dx", "dy"].into_iter().filter(|key| !table.has(key)) {
                sound = table.complain_of_missing(key, &LENGTH);
            }
            table.refuse(&["columns", "distance_unit"], "an array", "leave this out");
        }
        Some(Some(_)) => table.refuse(&["dx", "dy"], "a grid of text, which states its spacings", "leave this out"),
        _ => {}
    }
    let read = GridRoad::read(table);
    sound.and(read)
}

fn profile(table: &mut Table<'_>) -> Option<ProfileRoad> {
    let mut sound = Some(());
    for key in OLD_COLUMNS {
        if table.has(key) {
            sound = table
                .complain(key, Problem::moved("road.columns", "a table with columns = [\"distance\", \"height\"]"));
            table.pass(&[key]);
        }
    }
    let read = sound.and(ProfileRoad::read(table));
    match table.peek("range", &RANGE) {
        Some(Some([begin, end])) if begin >= end => {
            table.complain("range", Problem::not_below(begin, end, "the end of the range"))
        }
        _ => read,
    }
}
