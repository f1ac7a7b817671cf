//! Sound: where it is heard, and how its way there is computed.

use serde::{Deserialize, Serialize};

/// A place, or places, at which the sound pressure is wanted. A scene without any computes none.
///
/// The frame moves with the tyre: its origin is on the road under the axle's centre, x forward, y to the left, z up.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Receiver {
    /// Its name in tables, files and legends; made from the place where it is empty.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Where.
    #[serde(flatten)]
    pub place: ReceiverPlace,
}

/// Where the pressure is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ReceiverPlace {
    /// At one point that moves along with the tyre.
    Position {
        /// Its coordinates \[m\].
        position: [f64; 3],
    },
    /// Where a standard says.
    Standard(StandardReceiver),
}

/// Places that standards or habit give.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "standard", rename_all = "kebab-case")]
pub enum StandardReceiver {
    /// A microphone beside the road that the tyre passes (UN R117, ISO 362).
    CoastBy {
        /// From the tyre's path, to its left \[m\].
        distance: f64,
        /// Above the road \[m\].
        height: f64,
        /// The vehicle whose four tyres are heard; one tyre alone where it is left out. The distance is from the middle
        /// of the vehicle's path then.
        #[serde(skip_serializing_if = "Option::is_none")]
        vehicle: Option<Vehicle>,
    },
    /// Two microphones close to the tyre, moving along (ISO 11819-2).
    Cpx,
    /// A circle round the tyre: its directivity.
    Circle {
        /// Round the vertical through the axle \[m\].
        radius: f64,
        /// Above the road \[m\].
        height: f64,
    },
    /// Positions on a hemisphere over the tyre (ISO 3744): its sound power.
    Hemisphere {
        /// Round the point on the road under the axle \[m\].
        radius: f64,
    },
}

impl StandardReceiver {
    /// Distance of the coast-by microphone from the path \[m\].
    pub const DISTANCE: f64 = 7.5;
    /// Height of the coast-by microphone \[m\].
    pub const HEIGHT: f64 = 1.2;
}

/// Where the four tyres of a vehicle are. They roll alike but know nothing of each other: their mean squares add.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Vehicle {
    /// From the front to the rear axle \[m\].
    pub wheelbase: f64,
    /// From the left to the right tyre of an axle, centre to centre \[m\].
    pub track: f64,
}

impl Vehicle {
    /// Tyres that are heard.
    pub const TYRES: usize = 4;
}

/// Those of a car of the middle class.
impl Default for Vehicle {
    fn default() -> Self {
        Self { wheelbase: 2.7, track: 1.55 }
    }
}

/// How sound gets from the tread to the receivers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Radiation {
    /// Boundary elements, or a draft.
    pub quality: RadiationQuality,
    /// Highest frequency \[Hz\]; above it nothing is radiated.
    pub fmax: f64,
    /// Nodes of the boundary elements a wavelength.
    pub nodes_per_wavelength: f64,
    /// Largest error of the interpolation between the frequencies that are solved for \[dB\].
    #[serde(serialize_with = "super::numerics::decibels")]
    pub frequency_tolerance: f64,
    /// Lateral numbers of the tread's waves that are followed.
    pub lateral_waves: usize,
    /// Radius of the shoulders, outside the tread's width \[m\].
    pub shoulder: f64,
    /// Length of the contact patch that the body of the tyre has; that of the static contact where it is left out
    /// \[m\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub patch_length: Option<f64>,
    /// Height of the slit that a rough road leaves between itself and the patch \[m\]; 0: sealed.
    pub acoustic_gap: f64,
    /// What the air at the tread moves with.
    pub air: AirMotion,
    /// Of the air \[degrees Celsius\].
    pub temperature: f64,
    /// Whether files to listen to are written.
    pub audio: bool,
}

impl Default for Radiation {
    fn default() -> Self {
        Self {
            quality: RadiationQuality::Full,
            fmax: 2500.0,
            nodes_per_wavelength: 9.0,
            frequency_tolerance: 0.2,
            lateral_waves: 8,
            shoulder: 0.02,
            patch_length: None,
            acoustic_gap: 0.0,
            air: AirMotion::Axle,
            temperature: 20.0,
            audio: true,
        }
    }
}

/// How the way from the tread to the receivers is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RadiationQuality {
    /// By boundary elements.
    #[default]
    Full,
    /// By monopoles on the road with a horn's gain fitted to the full method: in a second.
    Draft,
}

/// What the air at the tread moves with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AirMotion {
    /// With the axle: a shape that stands still beside it is silent, however fast the tread runs through it.
    #[default]
    Axle,
    /// With the tread: a measure of the doubt about the layer of air that the tread drags along.
    WithTread,
}
