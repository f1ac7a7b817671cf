//! `[[receiver]]` and `[radiation]`: where sound is received, and how its transfer paths are computed. `[air_pumping]`:
//! the air under the contact patch.

use std::path::PathBuf;

use crate::scene::Problem;
use crate::scene::keys::{is_default, keys};
use crate::scene::kind::{Bounds, Decibels, Exactly, File, Flag, Name, OneOf, Optional, Whole};
use crate::scene::table::{Each, Keys, Kind, Nested, Table, Value};
use serde::{Deserialize, Serialize};
use serde_json::{Value as Json, json};

use super::effects::Switch;
use super::numerics::decibels;
use super::tyre::{Sides, Tyre};

/// A place, or places, at which the sound pressure is wanted. A scene without any computes none.
///
/// The frame moves with the tyre: its origin is on the road under the axle's centre, x forward, y to the left, z up.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Receiver {
    /// Name in tables, files and legends; made from the place if it is empty.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Where it is.
    #[serde(flatten)]
    pub place: ReceiverPlace,
}

/// Place, or set of places, of a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ReceiverPlace {
    /// At one point that moves along with the tyre.
    Position {
        /// Coordinates x, y, z \[m\].
        position: [f64; 3],
    },
    /// Where a standard puts its microphones.
    Standard(StandardReceiver),
}

impl ReceiverPlace {
    /// Key to complain about, and the place \[m\] at which a draft's error is judged; `None` if that error is known for
    /// the standard itself.
    pub(crate) fn judged_by(&self) -> Option<(&'static str, [f64; 3])> {
        Some(match *self {
            Self::Position { position } => ("position", position),
            // Half of its positions are above the tyre.
            Self::Standard(StandardReceiver::Hemisphere { radius }) => ("standard", [0.0, 0.0, radius]),
            Self::Standard(StandardReceiver::Circle { radius, height }) => ("height", [radius, 0.0, height]),
            Self::Standard(StandardReceiver::CoastBy { distance, height, vehicle, .. }) => {
                let nearest = distance - vehicle.map_or(0.0, |vehicle| 0.5 * vehicle.track);
                ("standard", [0.0, nearest, height])
            }
            Self::Standard(StandardReceiver::Cpx) => return None,
            // In the near field of both edges of the patch.
            Self::Standard(StandardReceiver::Obsi) => ("standard", [0.1, 0.2, 0.1]),
        })
    }
}

/// Places given by standards or by common practice.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "standard", rename_all = "kebab-case")]
pub enum StandardReceiver {
    /// A microphone beside the road that the tyre passes (UN R117, ISO 362).
    CoastBy {
        /// Distance from the tyre's path, to its left \[m\].
        distance: f64,
        /// Height above the road \[m\].
        height: f64,
        /// The vehicle whose four tyres contribute; without it, one tyre alone. With it the distance is from the middle
        /// of the vehicle's path.
        #[serde(skip_serializing_if = "Option::is_none")]
        vehicle: Option<Vehicle>,
        /// Length of road over which the passage is followed, half of it before the microphone \[m\]; by default as
        /// long as the level needs to rise and to fall by 10 dB.
        #[serde(skip_serializing_if = "Option::is_none")]
        passage: Option<f64>,
    },
    /// Two microphones close to the tyre, moving along (ISO 11819-2).
    Cpx,
    /// A circle round the tyre: directivity.
    Circle {
        /// Radius round the vertical axis through the axle \[m\].
        radius: f64,
        /// Height above the road \[m\].
        height: f64,
    },
    /// Positions on a hemisphere over the tyre (ISO 3744): sound power.
    Hemisphere {
        /// Radius round the point on the road under the axle \[m\].
        radius: f64,
    },
    /// Two sound intensity probes at the edges of the patch, moving along (AASHTO T 360, SAE J2706).
    Obsi,
}

impl StandardReceiver {
    /// Distance of the coast-by microphone from the path \[m\].
    pub const DISTANCE: f64 = 7.5;
    /// Height of the coast-by microphone \[m\].
    pub const HEIGHT: f64 = 1.2;
    /// Default length of the passage by a microphone at a distance and height \[m\]: the level of a point source, which
    /// falls with the distance squared, rises and falls by 10 dB over +-3 times its least distance; no less than the
    /// length on which standards read the maximum.
    pub fn passage(distance: f64, height: f64) -> f64 {
        (6.0 * distance.hypot(height)).max(READ)
    }
}

/// Length of road on which standards read the maximum \[m\].
const READ: f64 = 20.0;
/// Bounds of the length of a passage.
const PASSAGE: Bounds = Bounds::between(READ, 1e3, "m");

/// Bounds from axle to axle, for anything that rolls.
const WHEELBASE: Bounds = Bounds::between(0.0, 20.0, "m");
const TRACK: Bounds = Bounds::inside(0.0, 5.0, "m");

keys! {
    /// Where the four tyres of a vehicle are, by default those of a middle-class car. They roll alike but are taken as
    /// uncorrelated: their mean squares add.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize)]
    pub Vehicle {
        /// From the front to the rear axle \[m\].
        wheelbase: f64 = 2.7 => WHEELBASE,
        /// From the left to the right tyre of an axle, centre to centre \[m\].
        track: f64 = 1.55 => TRACK,
    }
}

impl Vehicle {
    /// Number of tyres that contribute.
    pub const TYRES: usize = 4;
}

keys! {
    /// How sound gets from the tread to the receivers.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Radiation {
        /// Boundary elements, or a draft.
        quality: RadiationQuality = RadiationQuality::Full => OneOf::new(),
        /// Highest frequency \[Hz\]; above it nothing is radiated.
        fmax: f64 = 2500.0 => Bounds::between(50.0, 2e4, "Hz"),
        /// Nodes of the boundary elements a wavelength.
        nodes_per_wavelength: f64 = 9.0 => Bounds::between(3.0, 40.0, ""),
        /// Largest error of the interpolation between the frequencies that are solved for \[dB\].
        #[serde(serialize_with = "decibels")]
        frequency_tolerance: f64 = 0.2 => Decibels(Bounds::between(1e-3, 6.0, "dB")),
        /// Number of the tread's even waves across that radiate; with contact over cells, whose forces are not even
        /// across, the odd ones between them, too.
        lateral_waves: usize = 6 => Whole::between(1, 1000),
        /// Radius of the shoulders, outside the tread's width \[m\].
        shoulder: f64 = 0.02 => Bounds::inside(0.0, 1.0, "m").plausible(1e-3, 1.0),
        /// Length of the contact patch that the body of the tyre has; that of the static contact where it is left out
        /// \[m\].
        patch_length?: f64 => LENGTH,
        /// Height of the slit between a rough road and the patch \[m\]; 0: sealed.
        acoustic_gap: f64 = 0.0 => Bounds::between(0.0, 0.05, "m"),
        /// Motion of the air at the tread: at rest over the road, at rest beside the axle, or round with the tread.
        air: AirMotion = AirMotion::Road => OneOf::new(),
        /// Sound of the sidewalls and shoulders, which move with `[tyre.sidewall]`: on, off, or `auto`, which is on for
        /// boundary elements; a draft has that of the tread alone.
        sides: Switch = Switch::Auto => OneOf::new(),
        /// Air temperature \[degrees Celsius\].
        temperature: f64 = 20.0 => Bounds::between(-50.0, 60.0, "degrees Celsius"),
        /// True if audio files are written.
        audio: bool = true => Flag,
        /// Pressure that is full scale, 1, in audio files \[Pa\]; default: for all files of a run, a sweep or a report
        /// the same, large enough for the loudest.
        full_scale?: f64 => Bounds::inside(0.0, 1e5, "Pa"),
    }
}

impl Radiation {
    /// True if the sidewalls of a tyre contribute to the sound: wanted, possible, and not a draft.
    pub fn hears_sides(&self, tyre: &Tyre) -> bool {
        self.sides != Switch::Off && self.quality == RadiationQuality::Full && Self::sides_move(tyre)
    }

    /// True if the sidewalls of a tyre move with the edges of its belt, and thus can radiate.
    pub fn sides_move(tyre: &Tyre) -> bool {
        tyre.sidewall.is_some() && tyre.sides == Sides::Guided
    }
}

/// How the transfer paths from tread to receivers are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RadiationQuality {
    /// By boundary elements.
    #[default]
    Full,
    /// By monopoles on the road with a horn gain fitted to the full method: takes a second.
    Draft,
}

/// Motion of the air at the tread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AirMotion {
    /// At rest over the road: the texture impressed on the tread stands still in it where tyre and road touch.
    #[default]
    Road,
    /// Moving with the axle: a shape that stands still beside it radiates no sound, however fast the tread runs through
    /// it. For estimates of the uncertainty: it is true a quarter of the way round from the contact.
    Axle,
    /// Moving with the tread: for estimates of the uncertainty due to the layer of air that the tread drags along.
    WithTread,
}

pub(in crate::scene) const RECEIVERS: Each<Receiver> = Each(Nested {
    title: "[[receiver]]",
    wanted: "tables [[receiver]], one for each place",
    schema: ReceiverKeys::schema,
    read: receiver,
});
pub(in crate::scene) const RADIATION: Nested<Radiation> = Nested::new("[radiation]", "the table [radiation]");
const VEHICLE: Nested<Vehicle> = Nested::new("the vehicle", "a table, { wheelbase = 2.7, track = 1.55 }");

const LENGTH: Bounds = Bounds::inside(0.0, 1e4, "m");

/// Plausible distances of a microphone: standard ones are from 0.1 m above the road to 25 m beside a railway; the 0.2 m
/// of CPX and the 7.5 m of coast-by, written in millimetres, are out of range.
const FROM_TYRE: Bounds = LENGTH.plausible(1e-3, FARTHEST);
const SHIFT: Bounds = Bounds::between(-1e4, 1e4, "m");
const ANGLE: Bounds = Bounds::between(-360.0, 360.0, "degrees");
const COORDINATE: Bounds = Bounds::between(-1e4, 1e4, "m").plausible(1e-9, FARTHEST);
const FARTHEST: f64 = 100.0;

/// The values of `standard`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Standard {
    CoastBy,
    Cpx,
    Circle,
    Hemisphere,
    Obsi,
}

keys! {
    /// A place, or places, at which the sound pressure is wanted: a `position`, those of a `file`, or what a `standard`
    /// says.
    #[derive(Debug)]
    ReceiverKeys {
        /// Name in tables, files and legends; made from the place where it is left out.
        name: String = String::new() => Name,
        /// A point that moves along with the tyre, from the road under the axle's centre x forward, y to the left, z up
        /// \[m\].
        position: Option<[f64; 3]> = None => Optional(Exactly(COORDINATE)),
        /// File of microphones that move along, each a separate receiver: a table with the line `name,x,y,z` and a
        /// row for each, in metres as `position`, or XML of programs for microphone arrays; relative to the scene, and
        /// in its table beside `offset` and `rotation_deg` alone.
        file: Option<PathBuf> = None => Optional(File),
        /// Shift of the microphones of a `file`, after they are turned \[m\].
        offset: [f64; 3] = [0.0; 3] => Exactly(SHIFT),
        /// Angles by which the microphones of a `file` are turned about the origin of the file, counter-clockwise about
        /// x, then y, then z, the axes of the scene; one number is about z, the vertical \[degrees\].
        rotation_deg: [f64; 3] = [0.0; 3] => Rotation,
        /// Places beside the passing tyre (UN R117, ISO 362), close to it (ISO 11819-2), round it for its directivity
        /// or its sound power (ISO 3744), or at the edges of its patch for the intensity (AASHTO T 360).
        standard: Option<Standard> = None => Optional(OneOf::new()),
        /// Distance for `coast-by`: from the tyre's path, or the middle of the vehicle's, to its left \[m\].
        distance: f64 = StandardReceiver::DISTANCE => FROM_TYRE,
        /// Above the road \[m\]: of `circle`, and of `coast-by`, there by default as in UN R117.
        height: Option<f64> = None => Optional(FROM_TYRE),
        /// Radius for `circle`, round the vertical through the axle, or for `hemisphere`, round the point under it
        /// \[m\].
        radius: Option<f64> = None => Optional(FROM_TYRE),
        /// Vehicle for `coast-by`, whose four tyres contribute; one tyre alone where it is left out.
        vehicle: Option<Vehicle> = None => Optional(VEHICLE),
        /// Passage for `coast-by`: length of road over which the tyre is followed, half of it before the microphone;
        /// default: long enough for the level to rise and fall by 10 dB \[m\].
        passage: Option<f64> = None => Optional(PASSAGE),
    }
}

/// Shift \[m\] and angles \[degrees\] in a table that names a file of microphones.
pub(in crate::scene) fn array_placement(table: &mut Table<'_>) -> Option<[[f64; 3]; 2]> {
    let ReceiverKeys { offset, rotation_deg, .. } = ReceiverKeys::read(table)?;
    Some([offset, rotation_deg])
}

/// Angles about the three axes in degrees, or one, about the vertical.
struct Rotation;

impl Kind for Rotation {
    type Output = [f64; 3];

    fn wanted(&self) -> String {
        format!("{}, about the vertical, or three of them, [x, y, z], about x, y and z", ANGLE.wanted())
    }

    fn read(&self, value: &Value<'_>) -> Option<[f64; 3]> {
        match value.items() {
            Some(_) => Exactly(ANGLE).read(value),
            None => ANGLE.read(value).map(|angle| [0.0, 0.0, angle]),
        }
    }

    fn schema(&self) -> Json {
        json!({ "anyOf": [ANGLE.schema(), Exactly::<3>(ANGLE).schema()] })
    }
}

fn receiver(table: &mut Table<'_>) -> Option<Receiver> {
    let standard = table.peek("standard", &OneOf::<Standard>::new());
    let (owner, others): (_, &[_]) = match standard {
        _ if table.has("position") => ("position", &["distance", "height", "radius", "vehicle", "passage"]),
        Some(Some(Standard::CoastBy)) => ("standard = \"coast-by\"", &["radius"]),
        Some(Some(Standard::Cpx)) => ("standard = \"cpx\"", &["distance", "height", "radius", "vehicle", "passage"]),
        Some(Some(Standard::Obsi)) => ("standard = \"obsi\"", &["distance", "height", "radius", "vehicle", "passage"]),
        Some(Some(Standard::Circle)) => ("standard = \"circle\"", &["distance", "vehicle", "passage"]),
        Some(Some(Standard::Hemisphere)) => {
            ("standard = \"hemisphere\"", &["distance", "height", "vehicle", "passage"])
        }
        _ => ("", &[]),
    };
    table.refuse(others, owner, "leave this out");
    if !table.has("file") {
        table.refuse(&["offset", "rotation_deg"], owner, "leave this out");
    }
    let ReceiverKeys { name, position, file, standard, distance, height, radius, vehicle, passage, .. } =
        ReceiverKeys::read(table)?;
    if file.is_some() {
        // In every other scene the file's rows have replaced the table by now.
        let right = "give each position, as a run writes it";
        return table.complain("file", Problem::new("a recorded scene names a file, which is not read", right));
    }
    let required = |key, length: Option<f64>| match length {
        None => table.complain(key, Problem::missing(&FROM_TYRE.wanted())),
        given => given,
    };
    let place = match (position, standard) {
        (Some(position), None) => ReceiverPlace::Position { position },
        (Some(_), Some(_)) => {
            return table.complain("standard", Problem::new("`position` is given, too", "one of the two"));
        }
        // A misspelt key is reported anyway, with the name that was probably meant.
        (None, None) if table.has_unknown() => return None,
        (None, None) => {
            let right = "position = [x, y, z] in metres, a file, or standard = \"coast-by\", \"cpx\", \"circle\", \
                         \"hemisphere\" or \"obsi\"";
            return table.complain_here(Problem::new("it does not say where the receiver is", right));
        }
        (None, Some(standard)) => ReceiverPlace::Standard(match standard {
            Standard::CoastBy => {
                let height = height.unwrap_or(StandardReceiver::HEIGHT);
                StandardReceiver::CoastBy { distance, height, vehicle, passage }
            }
            Standard::Cpx => StandardReceiver::Cpx,
            Standard::Obsi => StandardReceiver::Obsi,
            Standard::Circle => {
                let (radius, height) = (required("radius", radius), required("height", height));
                StandardReceiver::Circle { radius: radius?, height: height? }
            }
            Standard::Hemisphere => StandardReceiver::Hemisphere { radius: required("radius", radius)? },
        }),
    };
    Some(Receiver { name, place })
}

/// Paths of the air under the patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PatchAir {
    /// None: the patch is sealed all over.
    #[default]
    Sealed,
    /// The grooves that run round the tyre; the ribs between them are sealed.
    Grooves,
    /// All voids between tread and road, those of grooves and of the road's texture, as they stand at some places.
    Voids,
}

keys! {
    /// Air under the contact patch.
    #[derive(Clone, Debug, PartialEq, Eq, Serialize)]
    pub AirPumping {
        /// Paths of the air under the patch: none, the grooves of `[tread_pattern]` that run round the tyre, or all
        /// voids between tread and road.
        patch: PatchAir = PatchAir::Sealed => OneOf::new(),
        /// True if compliant blocks of `[tread_pattern]` press air into the voids beside them, as much as the volume of
        /// their compression.
        #[serde(skip_serializing_if = "is_default")]
        squeeze: bool = false => Flag,
    }
}

pub(in crate::scene) const AIR_PUMPING: Nested<AirPumping> =
    Nested::new("[air_pumping]", "the table [air_pumping] with patch = \"sealed\", \"grooves\" or \"voids\"");
