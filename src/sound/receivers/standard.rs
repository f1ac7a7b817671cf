//! A standard as the plan and the sound of a run ask for it.

use std::ops::Range;

use crate::scene::Vehicle;
use crate::sound::frame::Position;

/// Tyre that microphones stand beside.
pub(crate) struct Beside<'a> {
    /// Half of its width, shoulders included \[m\].
    pub half_width: f64,
    /// Length of its patch on a smooth road \[m\], worked out where a standard asks for it.
    pub patch_length: &'a dyn Fn() -> f64,
}

/// Pairs of microphones that measure intensity.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Probes {
    /// Names of the probes, each with the numbers of its two points, from the one towards the other.
    pub pairs: Vec<(&'static str, [usize; 2])>,
    /// Distance of the microphones of a pair \[m\].
    pub spacing: f64,
    /// Third octaves of the standard, by their nominal mid-frequencies \[Hz\].
    pub frequencies: Range<f64>,
}

/// Finding of a receiver beside its spectrum and level.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Finding {
    /// None.
    Level,
    /// Directivity, from points round the tyre.
    Directivity,
    /// Sound power, from points on a hemisphere of a radius \[m\].
    SoundPower(f64),
    /// Passage.
    Passage,
    /// Sound intensity, by pairs of microphones.
    Intensity(Probes),
}

/// Microphones of a standard.
pub(crate) trait Standard {
    /// Returns the name of a receiver that the scene gives none.
    fn name(&self) -> &'static str;

    /// Returns the places of its microphones.
    fn points(&self, beside: &Beside<'_>) -> Vec<Position>;

    /// Returns the finding beside its spectrum and level.
    fn finding(&self) -> Finding;

    /// Returns the length of the passage \[m\], if the tyre passes it.
    fn passage(&self) -> Option<f64> {
        None
    }

    /// Returns the vehicle whose four tyres it hears, if it hears more than one.
    fn vehicle(&self) -> Option<Vehicle> {
        None
    }

    /// Tells whether all of its pressures are kept to be listened to: it moves along, as a few microphones.
    fn is_recorded(&self) -> bool {
        false
    }

    /// Tells whether its pressures are kept over time, where files to listen to are wanted or not.
    fn is_kept(&self, audio: bool) -> bool {
        audio && self.is_recorded()
    }

    /// Tells whether a draft's error is that which is stated for the standards' means; else it goes with the places.
    fn has_stated_draft(&self) -> bool {
        false
    }
}
