//! `[friction]` and `[adhesion]`: tangential forces and attraction on contact cells.

use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Value as Json, json};

use crate::scene::Problem;
use crate::scene::keys::{is_default, keys};
use crate::scene::kind::{Bounds, OneOf};
use crate::scene::table::{Keys, Kind, Nested, Table, Value};

/// Law of the coefficient of friction, where it is not constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FrictionLaw {
    /// Falls from `mu_slow` to `mu_fast` with increasing slip speed, delayed by a memory length.
    Falling,
}

/// Coefficient of friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coefficient {
    /// The same at all speeds.
    Constant(f64),
    /// Falling with the speed of slip.
    Falling(FallingFriction),
}

/// Coefficient of friction that follows the slip speed: with v its magnitude and D the memory length,
///
/// mu_ss(v) = mu_fast + (mu_slow - mu_fast) exp(-v/v_s),   dmu/dt = (mu_ss - mu) (v + v_0)/D.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FallingFriction {
    /// Coefficient of slow slip.
    pub slow: f64,
    /// Coefficient of fast slip.
    pub fast: f64,
    /// Speed scale v_s \[m/s\].
    pub speed_scale: f64,
    /// Memory length D \[m\].
    pub memory_length: f64,
    /// Speed floor v_0 \[m/s\].
    pub speed_floor: f64,
}

impl FallingFriction {
    /// Coefficient in steady slip at a speed \[m/s\].
    pub fn steady(&self, speed: f64) -> f64 {
        self.fast + (self.slow - self.fast) * (-speed / self.speed_scale).exp()
    }

    /// Coefficient after a step of `time_step` \[s\] with slip at `speed` \[m/s\], from the one before: exact for
    /// constant speed.
    pub fn after(&self, before: f64, speed: f64, time_step: f64) -> f64 {
        let steady = self.steady(speed);
        steady + (before - steady) * (-time_step * (speed + self.speed_floor) / self.memory_length).exp()
    }
}

/// Largest coefficient of friction. The search for the forces is known to terminate up to 4; beyond, a failure is
/// reported as such.
const MOST_FRICTION: f64 = 8.0;
const COEFFICIENT: Bounds = Bounds::between(0.0, MOST_FRICTION, "");
/// Largest spin \[1/m\]: a wheel that turns on the spot about a point of its patch, 0.1 m from its middle.
const MOST_SPIN: f64 = 10.0;
/// Largest pull \[Pa\], that of the stickiest rubber: probes come off soft tapes at 1e6 Pa.
const MOST_PULL: f64 = 1e6;
const SPEED: Bounds = Bounds::positive("m/s").plausible(1e-6, 1e3);
const RATIO: Bounds = Bounds::any("").plausible(1e-9, 10.0);

keys! {
    /// Friction between tread and road, over cells.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Friction {
        /// Coefficient of friction; 0 leaves contact without friction. Or give a `law`.
        mu?: f64 => COEFFICIENT,
        /// Law of a coefficient that is not constant, in place of `mu`.
        law?: FrictionLaw => OneOf::new(),
        /// Coefficient of slow slip, `law = "falling"`.
        mu_slow?: f64 => COEFFICIENT,
        /// Coefficient of fast slip, `law = "falling"`.
        mu_fast?: f64 => COEFFICIENT,
        /// Speed of slip over which the coefficient falls by a factor e \[m/s\], `law = "falling"`.
        speed_scale?: f64 => SPEED,
        /// Length of slip over which the coefficient follows \[m\], `law = "falling"`.
        memory_length?: f64 => Bounds::positive("m").plausible(1e-9, 1.0),
        /// Speed that replaces the slip speed at rest \[m/s\], `law = "falling"`: the friction of a cell at rest
        /// recovers with it.
        speed_floor?: f64 => SPEED,
        /// Creep of the wheel against free rolling of a rigid one.
        #[serde(skip_serializing_if = "is_default")]
        creep: Creep = Creep::default() => CREEP,
    }
}

/// Longitudinal creep, prescribed or that of free rolling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LongitudinalCreep {
    /// Constant in time.
    Given(f64),
    /// Creep of a wheel without a torque about its axle.
    Free,
}

impl LongitudinalCreep {
    /// The word for free rolling.
    const FREE: &str = "free";
}

impl Serialize for LongitudinalCreep {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Given(creep) => creep.serialize(serializer),
            Self::Free => Self::FREE.serialize(serializer),
        }
    }
}

/// Kind of a [`LongitudinalCreep`]: a number, or the word for free rolling.
struct LongitudinalKind;

impl Kind for LongitudinalKind {
    type Output = LongitudinalCreep;

    fn wanted(&self) -> String {
        format!("{}, or \"{}\"", RATIO.wanted(), LongitudinalCreep::FREE)
    }

    fn read(&self, value: &Value<'_>) -> Option<LongitudinalCreep> {
        match value.value.as_str() {
            Some(LongitudinalCreep::FREE) => Some(LongitudinalCreep::Free),
            Some(_) => value.wrong_type(self),
            None => RATIO.read(value).map(LongitudinalCreep::Given),
        }
    }

    fn schema(&self) -> Json {
        json!({ "anyOf": [RATIO.schema(), { "type": "string", "enum": [LongitudinalCreep::FREE] }] })
    }
}

keys! {
    /// Creep: speed of the tread against the road, as parts of the rolling speed.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Creep {
        /// Longitudinal creep; above 0 brakes, 1 is a locked wheel. `"free"`: the wheel rolls freely, its creep follows
        /// the torque about the axle.
        longitudinal: LongitudinalCreep = LongitudinalCreep::Given(0.0) => LongitudinalKind,
        /// Lateral creep, the tangent of the slip angle; above 0 to the left.
        lateral: f64 = 0.0 => RATIO,
        /// Spin \[1/m\]: turning about the vertical over the rolling speed.
        spin: f64 = 0.0 => Bounds::any("1/m").plausible(1e-9, MOST_SPIN),
        /// Time from the run's start over which creep rises linearly from zero \[s\].
        ramp: f64 = Creep::RAMP => Bounds::not_negative("s").plausible(1e-9, 1e6),
    }
}

const CREEP: Nested<Creep> = Nested::new("the creep", "{ longitudinal = ..., lateral = ..., spin = ..., ramp = ... }");

impl Creep {
    /// Default time over which creep rises \[s\].
    pub const RAMP: f64 = 0.02;
}

pub(in crate::scene) const FRICTION: Nested<Friction> =
    Nested::new("[friction]", "the table [friction] with mu").read_by(friction);

/// Keys of the falling law.
const OF_FALLING: [&str; 5] = ["mu_slow", "mu_fast", "speed_scale", "memory_length", "speed_floor"];

fn friction(table: &mut Table<'_>) -> Option<Friction> {
    if table.has("law") {
        let right = "remove it: mu_slow and mu_fast say how large friction is";
        table.refuse(&["mu"], "a law", right);
    } else {
        table.refuse(&OF_FALLING, "a constant coefficient", "remove it, or choose law = \"falling\"");
    }
    let read = Friction::read(table)?;
    let missing = |key: &&&str| !table.has(key);
    match (read.law, read.mu) {
        (None, None) if table.has_unknown() => None,
        (None, None) => table.complain("mu", Problem::missing("the coefficient of friction, such as 0.9, or a law")),
        (None, Some(_)) => Some(read),
        (Some(FrictionLaw::Falling), _) => {
            let absent: Vec<_> = OF_FALLING.iter().filter(missing).collect();
            for key in &absent {
                table.complain::<()>(key, Problem::missing("its value: law = \"falling\" has no default for it"));
            }
            absent.is_empty().then_some(read)
        }
    }
}

impl Friction {
    /// The coefficient as a constant, or as the falling law.
    pub fn coefficient(&self) -> Coefficient {
        let falling = || {
            Some(FallingFriction {
                slow: self.mu_slow?,
                fast: self.mu_fast?,
                speed_scale: self.speed_scale?,
                memory_length: self.memory_length?,
                speed_floor: self.speed_floor?,
            })
        };
        match self.law.and_then(|_| falling()) {
            Some(falling) => Coefficient::Falling(falling),
            None => Coefficient::Constant(self.mu.unwrap_or(0.0)),
        }
    }

    /// True if tangential forces are impossible: the contact is then that without friction.
    pub fn is_frictionless(&self) -> bool {
        match self.coefficient() {
            Coefficient::Constant(mu) => mu <= 0.0,
            Coefficient::Falling(FallingFriction { slow, fast, .. }) => slow.max(fast) <= 0.0,
        }
    }
}

keys! {
    /// Adhesion between tread and road, over cells: a constant pull within a range (Dugdale).
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Adhesion {
        /// Pull per area of a bonded cell \[Pa\].
        stress: f64 => Bounds::positive("Pa").plausible(1.0, MOST_PULL),
        /// Gap up to which a cell is bonded \[m\].
        range: f64 => Bounds::positive("m").plausible(1e-10, 1e-2),
    }
}

pub(in crate::scene) const ADHESION: Nested<Adhesion> =
    Nested::new("[adhesion]", "the table [adhesion] with stress and range");
