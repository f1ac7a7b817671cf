//! A standard as the plan and the sound of a run ask for it.

use crate::scene::Vehicle;
use crate::sound::frame::Position;

/// Tyre that microphones stand beside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beside {
    /// Half of its width, shoulders included \[m\].
    pub half_width: f64,
}

/// Finding of a receiver beside its spectrum and level.
#[derive(Clone, Debug, PartialEq)]
pub enum Finding {
    /// None.
    Level,
    /// Directivity, from points round the tyre.
    Directivity,
    /// Sound power, from points on a hemisphere of a radius \[m\].
    SoundPower(f64),
    /// Passage.
    Passage,
}

/// Microphones of a standard.
pub trait Standard {
    /// Name of a receiver that the scene gives none.
    fn name(&self) -> &'static str;

    /// Places of its microphones.
    fn points(&self, beside: &Beside) -> Vec<Position>;

    /// Finding beside its spectrum and level.
    fn finding(&self) -> Finding;

    /// Length of the passage \[m\], if the tyre passes it.
    fn passage(&self) -> Option<f64> {
        None
    }

    /// The vehicle whose four tyres it hears, if it hears more than one.
    fn vehicle(&self) -> Option<Vehicle> {
        None
    }

    /// Tells whether all of its pressures are kept to be listened to: it moves along, as a few microphones.
    fn is_recorded(&self) -> bool {
        false
    }

    /// Tells whether a draft's error is that which is stated for the standards' means; else it goes with the places.
    fn has_stated_draft(&self) -> bool {
        false
    }
}
