//! `[rolling]`: how the tyre rolls.

use serde::Serialize;

use super::axle::{AXLE, Axle};
use crate::scene::keys::keys;
use crate::scene::kind::Bounds;
use crate::scene::table::Nested;

keys! {
    /// How the tyre rolls.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Rolling {
        /// Speed \[km/h\].
        speed_kmh: f64 => Bounds::positive("km/h").plausible(0.01, 2e3),
        /// Time simulated after the warm-up \[s\].
        duration: f64 => Bounds::positive("s").plausible(1e-4, 1e6),
        /// Time simulated before anything counts towards a mean or a spectrum \[s\].
        warm_up: f64 = Rolling::WARM_UP => Bounds::not_negative("s").plausible(1e-6, 1e6),
        /// Road coordinate under the axle at t = 0 \[m\]; default: 0 on an endless road, just far enough from its
        /// beginning on a finite one.
        start?: f64 => Bounds::any("m").plausible(1e-9, 1e7),
        /// Support of the axle.
        axle: Axle => AXLE,
    }
}

pub(in crate::scene) const ROLLING: Nested<Rolling> =
    Nested::new("[rolling]", "the table [rolling] with speed_kmh, duration and axle");

impl Rolling {
    /// Default warm-up \[s\]: the default tyre's transient after a static start has died out by then.
    pub const WARM_UP: f64 = 0.5;

    /// Speed V in SI units \[m/s\].
    pub fn speed(&self) -> f64 {
        self.speed_kmh / 3.6
    }
}
