//! `[road]`, one reader per kind.

use serde::Deserialize;

use super::super::kind::{Bounds, Column, Exactly, File, Numbers, OneOf, Whole};
use super::super::problem::short;
use super::super::table::{Nested, Table};
use super::super::{
    AtEnd, GridRoad, Lateral, LengthUnit, MadeRoad, OpenCrgRoad, PowerLawTexture, Problem, ProfileRoad, Road,
};

const LENGTH: Bounds = Bounds::positive("m");
const COORDINATE: Bounds = Bounds::any("m");
/// 120 dB re 1e-6 m are one metre: nothing that a tyre rolls on, and far from overflow.
const LEVEL: Bounds = Bounds::between(-100.0, 120.0, "dB re 1e-6 m");
/// Which pairs a road can have is told when it is opened.
const SKEWNESS: Bounds = Bounds::between(-3.0, 3.0, "");
const KURTOSIS: Bounds = Bounds::between(1.0, 30.0, "");
const EXPONENT: Bounds = Bounds::between(0.0, 10.0, "");
/// Ratio of a third-octave band's mid-wavelength to its lower edge.
const HALF_BAND: f64 = 1.122_018_454_301_963_3;

pub(super) const ROAD: Nested<Road> =
    Nested { title: "the road", wanted: "the table [road] with a kind and its keys", read: road };
const POWER_LAW: Nested<PowerLawTexture> = Nested {
    title: "a power-law texture",
    wanted: "a table, { rms = ..., exponent = ..., longest = ..., shortest = ... }",
    read: power_law,
};

/// The words accepted as `kind`; the tags of [`Road`].
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum RoadKind {
    Smooth,
    Made,
    Profile,
    OpenCrg,
    Grid,
}

fn road(table: &mut Table<'_>) -> Option<Road> {
    let Some(kind) = table.required("kind", &OneOf::<RoadKind>::new()) else {
        table.be_lenient();
        return None;
    };
    match kind {
        RoadKind::Smooth => {
            table.rename("a smooth road");
            Some(Road::Smooth)
        }
        RoadKind::Made => {
            table.rename("a made road");
            made(table).map(Road::Made)
        }
        RoadKind::Profile => {
            table.rename("a profile road");
            profile(table).map(Road::Profile)
        }
        RoadKind::OpenCrg => {
            table.rename("an opencrg road");
            opencrg(table).map(Road::OpenCrg)
        }
        RoadKind::Grid => {
            table.rename("a grid road");
            grid(table).map(Road::Grid)
        }
    }
}

fn made(table: &mut Table<'_>) -> Option<MadeRoad> {
    let seed = table.or("seed", &Whole(0), 0);
    let wavelengths = table.optional("wavelengths", &Numbers(LENGTH));
    let levels = table.optional("levels", &Numbers(LEVEL));
    let power_law = table.optional("power_law", &POWER_LAW);
    let spacing = table.or("spacing", &LENGTH, MadeRoad::SPACING);
    let skewness = table.or("skewness", &SKEWNESS, 0.0);
    let kurtosis = table.or("kurtosis", &KURTOSIS, MadeRoad::GAUSSIAN_KURTOSIS);

    if table.has("power_law") && (table.has("levels") || table.has("wavelengths")) {
        let other = if table.has("levels") { "levels" } else { "wavelengths" };
        return table.complain("power_law", Problem::conflict(other));
    }
    let road = MadeRoad {
        seed: seed?,
        wavelengths: wavelengths?,
        levels: levels?,
        power_law: power_law?,
        spacing: spacing?,
        skewness: skewness?,
        kurtosis: kurtosis?,
    };
    match (&road.wavelengths, &road.levels) {
        (Some(_), None) => {
            return table.complain("levels", Problem::missing("one third-octave level for each of the wavelengths"));
        }
        (None, Some(_)) => {
            let wanted = "the third-octave mid-wavelength of each of the levels";
            return table.complain("wavelengths", Problem::missing(wanted));
        }
        (Some(wavelengths), Some(levels)) if wavelengths.len() != levels.len() => {
            let problem = Problem::length_mismatch(levels.len(), "wavelengths", wavelengths.len());
            return table.complain("levels", problem);
        }
        (Some(wavelengths), Some(_)) => bands(table, wavelengths, road.spacing)?,
        (None, None) => match &road.power_law {
            Some(texture) => resolved(table, "power_law.shortest", texture.shortest, 2.0 * road.spacing, road.spacing)?,
            None => {
                let (shortest, least) = (MadeRoad::DENSE_ASPHALT_SHORTEST, 2.0 * HALF_BAND * road.spacing);
                resolved(table, "spacing", shortest, least, road.spacing)?;
            }
        },
    }
    Some(road)
}

/// Checks that the bands run one way, each once, and that the lattice carries the lower edge of each.
fn bands(table: &Table<'_>, wavelengths: &[f64], spacing: f64) -> Option<()> {
    let falling = wavelengths.first() > wavelengths.last();
    for (number, pair) in wavelengths.windows(2).enumerate() {
        let in_order = if falling { pair[1] < pair[0] } else { pair[1] > pair[0] };
        if !in_order {
            let wrong = format!("{} after {} breaks the order", short(pair[1]), short(pair[0]));
            let right = "list the values from short to long or from long to short, each one once";
            return table.complain(&format!("wavelengths[{}]", number + 1), Problem::new(wrong, right));
        }
    }
    // Every one is checked before the first failure counts.
    let checked: Vec<_> = wavelengths
        .iter()
        .enumerate()
        .map(|(number, &wavelength)| {
            resolved(table, &format!("wavelengths[{number}]"), wavelength, 2.0 * HALF_BAND * spacing, spacing)
        })
        .collect();
    checked.into_iter().collect()
}

/// Checks a wavelength against the shortest one that a lattice carries: two spacings, of its band's lower edge.
fn resolved(table: &Table<'_>, key: &str, wavelength: f64, least: f64, spacing: f64) -> Option<()> {
    // Two spacings exactly are meant to pass, also where 2 x 0.001 is not 0.002 to the last bit.
    if wavelength >= least * (1.0 - 1e-12) {
        return Some(());
    }
    let wrong = format!("a wavelength of {} m needs a finer lattice than {} m", short(wavelength), short(spacing));
    let coarsest = short(spacing * wavelength / least);
    let right = format!("leave shorter wavelengths out, or set road.spacing to at most {coarsest} m");
    table.complain(key, Problem::new(wrong, right))
}

fn power_law(table: &mut Table<'_>) -> Option<PowerLawTexture> {
    let rms = table.required("rms", &LENGTH);
    let exponent = table.required("exponent", &EXPONENT);
    let longest = table.required("longest", &LENGTH);
    let shortest = table.required("shortest", &LENGTH);
    if let (Some(value), Some(limit)) = (shortest, longest)
        && value >= limit
    {
        return table.complain("shortest", Problem::not_below(value, limit, "the longest wavelength"));
    }
    Some(PowerLawTexture { rms: rms?, exponent: exponent?, longest: longest?, shortest: shortest? })
}

fn profile(table: &mut Table<'_>) -> Option<ProfileRoad> {
    let file = table.required("file", &File);
    let distance_unit = table.optional("distance_unit", &OneOf::<LengthUnit>::new());
    let height_unit = table.optional("height_unit", &OneOf::<LengthUnit>::new());
    let distance_column = table.optional("distance_column", &Column);
    let height_column = table.optional("height_column", &Column);
    let range = table.optional("range", &Exactly::<2>(COORDINATE));
    let lateral = table.or("lateral", &OneOf::<Lateral>::new(), Lateral::default());
    let seed = table.or("seed", &Whole(0), 0);
    let at_end = at_end(table);
    if let Some(Some([begin, end])) = range
        && begin >= end
    {
        return table.complain("range", Problem::not_below(begin, end, "the end of the range"));
    }
    Some(ProfileRoad {
        file: file?,
        distance_unit: distance_unit?,
        height_unit: height_unit?,
        distance_column: distance_column?,
        height_column: height_column?,
        range: range?,
        lateral: lateral?,
        seed: seed?,
        at_end: at_end?,
    })
}

fn opencrg(table: &mut Table<'_>) -> Option<OpenCrgRoad> {
    let file = table.required("file", &File);
    let lateral_position = table.optional("lateral_position", &COORDINATE);
    let longest_wavelength = table.optional("longest_wavelength", &LENGTH);
    let at_end = at_end(table);
    Some(OpenCrgRoad {
        file: file?,
        lateral_position: lateral_position?,
        longest_wavelength: longest_wavelength?,
        at_end: at_end?,
    })
}

fn grid(table: &mut Table<'_>) -> Option<GridRoad> {
    let file = table.required("file", &File);
    let dx = table.required("dx", &LENGTH);
    let dy = table.required("dy", &LENGTH);
    let at_end = at_end(table);
    Some(GridRoad { file: file?, dx: dx?, dy: dy?, at_end: at_end? })
}

fn at_end(table: &mut Table<'_>) -> Option<AtEnd> {
    table.or("at_end", &OneOf::<AtEnd>::new(), AtEnd::default())
}
