//! Positions on a hemisphere over the tyre, for its sound power (ISO 3744).

use super::standard::{Beside, Finding, Standard};
use crate::sound::frame::Position;
use crate::sound::power::Iso3744;

/// Receivers on a hemisphere; radius \[m\].
pub(super) struct Hemisphere {
    pub(super) radius: f64,
}

impl Standard for Hemisphere {
    fn name(&self) -> &'static str {
        "hemisphere"
    }

    fn points(&self, _: &Beside<'_>) -> Vec<Position> {
        Iso3744::Broadband.positions(self.radius, true)
    }

    fn finding(&self) -> Finding {
        Finding::SoundPower(self.radius)
    }
}
