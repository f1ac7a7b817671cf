//! How the tyre rolls.

use serde::Serialize;

/// How the tyre rolls.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rolling {
    /// Speed \[km/h\].
    pub speed_kmh: f64,
    /// Time simulated after the warm-up \[s\].
    pub duration: f64,
    /// Time simulated before anything counts towards a mean or a spectrum \[s\].
    pub warm_up: f64,
    /// Road coordinate under the axle at t = 0 \[m\]; default: 0 on an endless road, just far enough in on a finite
    /// one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// What holds the axle.
    pub axle: Axle,
}

/// What holds the axle: a load, a height, or a mass under a load that moves.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Axle {
    /// The height is found so that the mean vertical force is this load.
    Load {
        /// Vertical load \[N\].
        load: f64,
        /// Relative tolerance of the mean force.
        tolerance: f64,
    },
    /// A mass under the load, with a spring and a damper: it moves with the contact force, the mean of which is the
    /// load.
    Mass {
        /// Vertical load \[N\].
        load: f64,
        /// Mass that moves with the axle \[kg\].
        mass: f64,
        /// Stiffness of the spring above it \[N/m\].
        stiffness: f64,
        /// Damping of the damper above it \[N s/m\].
        damping: f64,
        /// Relative tolerance of the mean force.
        tolerance: f64,
    },
    /// A fixed height.
    Indentation {
        /// How far the rigid tyre is pushed into the plane z = 0 \[m\].
        indentation: f64,
        /// Time over which it rises linearly from zero \[s\].
        ramp: f64,
    },
}

impl Rolling {
    /// Default warm-up \[s\]: the default tyre's transient after a static start has died out by then.
    pub const WARM_UP: f64 = 0.5;

    /// Speed V \[m/s\].
    pub fn speed(&self) -> f64 {
        self.speed_kmh / 3.6
    }
}

impl Axle {
    /// The load \[N\] and the relative tolerance of the mean force, where a load is given.
    pub fn load(&self) -> Option<(f64, f64)> {
        match *self {
            Self::Load { load, tolerance } | Self::Mass { load, tolerance, .. } => Some((load, tolerance)),
            Self::Indentation { .. } => None,
        }
    }

    /// Default relative tolerance of the mean vertical force.
    pub const LOAD_TOLERANCE: f64 = 0.01;
}
