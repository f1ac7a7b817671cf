//! Interface of a standard's microphones to the plan and to the sound of a run.

use std::ops::Range;

use crate::scene::Vehicle;
use crate::sound::frame::Position;

/// Sizes of the tyre beside which microphones stand.
pub(crate) struct Beside<'a> {
    /// Half of its width, shoulders included \[m\].
    pub half_width: f64,
    /// Length of its patch on a smooth road \[m\], computed only where a standard needs it.
    pub patch_length: &'a dyn Fn() -> f64,
}

/// Pairs of microphones that measure intensity.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Probes {
    /// Names of the probes, each with the indices of its two points; the intensity counts from the first to the second.
    pub pairs: Vec<(&'static str, [usize; 2])>,
    /// Distance of the microphones of a pair \[m\].
    pub spacing: f64,
    /// Third octaves of the standard, by their nominal mid-frequencies \[Hz\].
    pub frequencies: Range<f64>,
}

/// Result of a receiver in addition to its spectrum and level.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Finding {
    /// None.
    Level,
    /// Directivity, from points round the tyre.
    Directivity,
    /// Sound power, from points on a hemisphere of a radius \[m\].
    SoundPower(f64),
    /// Level over time as the tyre passes.
    Passage,
    /// Sound intensity, by pairs of microphones.
    Intensity(Probes),
}

pub(crate) trait Standard {
    /// Name of a receiver to which the scene gives none.
    fn name(&self) -> &'static str;

    /// Positions of its microphones.
    fn points(&self, beside: &Beside<'_>) -> Vec<Position>;

    /// Result in addition to its spectrum and level.
    fn finding(&self) -> Finding;

    /// Length of the passage \[m\], if the tyre passes it.
    fn passage(&self) -> Option<f64> {
        None
    }

    /// Vehicle whose four tyres it receives, if more than one.
    fn vehicle(&self) -> Option<Vehicle> {
        None
    }

    /// True if its pressures may be written to sound files: few microphones, which move with the tyre.
    fn is_recorded(&self) -> bool {
        false
    }

    /// True if its pressures are stored over time; `audio` if sound files are asked for.
    fn is_stored(&self, audio: bool) -> bool {
        audio && self.is_recorded()
    }

    /// True if a draft's error is that which is stated for the standards' means; else it depends on the positions.
    fn has_stated_draft(&self) -> bool {
        false
    }
}
