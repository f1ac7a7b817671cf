//! Fixed pieces of work, and scenes of the user.
//!
//! Small enough that one takes a few tenths of a second, large enough that every stage has thousands of entries. They
//! are part of the record: a change of one is a change of all its numbers.

use serde::{Deserialize, Serialize};

use crate::counters::catalogue::catalogue;
use crate::scene::{
    Axle, History, LoadedScene, NamedTexture, Outputs, PLATE, Road, Scene, SceneError, Slices, Switch, TimeRule,
};

catalogue! {
    /// A fixed piece of work.
    pub enum Workload,
    /// Name on the command line and in records.
    name {
        /// A smooth road at 80 km/h, N = 512.
        Smooth => "smooth",
        /// Dense asphalt at 80 km/h, N = 512.
        Rough => "rough",
        /// The profile of dense asphalt at 200 km/h, N = 512, two steps per element by a rule of two stages.
        HighSpeed => "high_speed",
        /// Many steps of a coarse tyre on the profile of dense asphalt, the load followed.
        LongRollout => "long_rollout",
        /// Dense asphalt with slices on the elastic half-space.
        HalfSpaceSlices => "half_space_slices",
        /// Convolution of the remembered forces, N = 96.
        DirectHistory => "direct_history",
        /// Dense asphalt on cells, N = 256.
        Cells => "cells",
        /// Dense asphalt, received beside the tyre up to 1 kHz, N = 512.
        Sound => "sound",
        /// Rational models of the influence functions.
        Influence => "influence",
    }
}

/// Work that two programs do in turn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SharedWork {
    /// Name of a fixed piece of work, or path of a scene.
    pub name: String,
    /// True for a scene.
    pub is_scene: bool,
}

/// A physical value and its reference.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct MeasuredValue {
    /// Name of the value, with its unit.
    pub what: String,
    /// Computed value.
    pub value: f64,
    /// Reference from a path that shares as little as possible with the workload's.
    pub expected: f64,
    /// Largest relative difference from the reference.
    pub tolerance: f64,
}

impl MeasuredValue {
    /// Complaint about a wrong value; `None` for a right one.
    pub fn complaint(&self) -> Option<String> {
        let Self { what, value, expected, tolerance } = self;
        let is_right = (value - expected).abs() <= tolerance * expected.abs();
        (!is_right).then(|| format!("wrong result: {what} is {value}, not {expected} within {tolerance:e}"))
    }
}

/// Receiver and radiation, which the plate's scene lacks.
const RECEIVER: &str = "\n[[receiver]]\nstandard = \"cpx\"\n\n[radiation]\nquality = \"draft\"\nfmax = 1000.0\n\
                        audio = false\n";

/// Value of a fit.
const OF_FIT: &str = "H_n between the fitted points, off by so much of its largest value from sums, plus 1";

impl Workload {
    /// Reference value, nothing computed yet. Forces of rolling workloads are those of the same scene by direct sums
    /// with complete memory (a test that takes a minute repeats them); the influence functions are checked
    /// against sums as they are fitted.
    pub fn truth(self) -> MeasuredValue {
        let variation = "root mean square of the varying force [N]";
        let (what, expected, tolerance) = match self {
            Self::Smooth => ("mean force [N]", 2767.912323979274, 1e-5),
            Self::Rough => (variation, 48.92530136118314, 1e-5),
            Self::HighSpeed => (variation, 465.0516520600554, 1e-5),
            Self::LongRollout => (variation, 199.02389511046786, 1e-5),
            Self::HalfSpaceSlices => (variation, 61.05028687115533, 1e-5),
            // By the recursion: the direct sum itself is the reference of the others.
            Self::DirectHistory => (variation, 169.69001338700753, 1e-5),
            // The errors of its many poles add up.
            Self::Cells => (variation, 74.07911137177945, 1e-3),
            // From those forces by the same transfer to the microphone.
            Self::Sound => ("sound pressure beside the tyre [Pa]", 1.2562395149820886, 1e-5),
            Self::Influence => (OF_FIT, 1.0, 1e-4),
        };
        MeasuredValue { what: what.to_owned(), value: f64::NAN, expected, tolerance }
    }

    /// Scene of a workload that rolls; `None` for the others.
    ///
    /// # Errors
    /// A scene that is refused.
    pub fn scene(self) -> Result<Option<LoadedScene>, SceneError> {
        let (elements, speed, warm_up, duration) = match self {
            Self::Smooth => (512, 80.0, 0.1, 0.4),
            Self::Rough => (512, 80.0, 0.1, 0.25),
            Self::HighSpeed => (512, 200.0, 0.03, 0.07),
            Self::LongRollout => (96, 80.0, 0.5, 20.0),
            Self::HalfSpaceSlices => (256, 80.0, 0.1, 0.2),
            Self::DirectHistory => (96, 80.0, 0.1, 0.4),
            Self::Cells => (256, 80.0, 0.05, 0.08),
            Self::Sound => (512, 80.0, 0.1, 0.8),
            Self::Influence => return Ok(None),
        };
        let text = match self {
            Self::Cells => PLATE.replace("slices = \"winkler\"", "zone = \"cells\""),
            Self::Sound => format!("{PLATE}{RECEIVER}"),
            _ => PLATE.to_owned(),
        };
        let mut loaded = Scene::from_str(&text, self.name())?;
        let scene = &mut loaded.scene;
        scene.outputs = Outputs { arrays: false, spectra: false, plots: false, ..Outputs::default() };
        // A rule that direct sums have, too: they give the reference values.
        (scene.numerics.elements, scene.numerics.time_rule) = (elements, TimeRule::Bdf2);
        let rolling = &mut scene.rolling;
        (rolling.speed_kmh, rolling.warm_up, rolling.duration) = (speed, warm_up, duration);
        // A fixed height: the scene prescribes nothing about the force.
        rolling.axle = Axle::Indentation { indentation: 0.012, ramp: 0.03 };
        if let Road::Made(road) = &mut scene.road {
            // Records are of this road.
            road.texture = Some(NamedTexture::RoughAsphalt);
        }
        match self {
            Self::Smooth => scene.road = Road::Smooth,
            Self::HighSpeed => (scene.numerics.time_rule, scene.numerics.substeps) = (TimeRule::Sdirk2, 2),
            Self::LongRollout => scene.rolling.axle = Axle::Load { load: 3400.0, tolerance: 0.01 },
            Self::HalfSpaceSlices => scene.contact.slices = Slices::HalfSpace,
            Self::DirectHistory => (scene.numerics.history, scene.numerics.memory) = (History::Direct, 0.5),
            Self::Rough | Self::Cells | Self::Sound | Self::Influence => {}
        }
        if matches!(self, Self::HighSpeed | Self::LongRollout | Self::DirectHistory) {
            // A road without texture across is generated in no time.
            scene.effects.texture = Switch::Off;
        }
        Ok(Some(loaded))
    }
}
