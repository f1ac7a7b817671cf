//! Fixed pieces of work, and scenes of the user.
//!
//! Small enough that one takes a few tenths of a second, large enough that every stage has thousands of entries. They
//! are part of the record: a change of one is a change of all its numbers.

use std::fmt;
use std::path::PathBuf;

use crate::counters::catalogue::catalogue;
use crate::scene::{Axle, History, LoadedScene, Outputs, PLATE, Road, Scene, SceneError, Slices, Switch, TimeRule};

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
        /// Dense asphalt heard beside the tyre up to 1 kHz, N = 512.
        Sound => "sound",
        /// Surface compliance of the layered tyre, summed across the width.
        Compliance => "compliance",
        /// Rational models of the influence functions.
        Influence => "influence",
    }
}

/// Work that two programs do in turn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Work {
    /// One of the fixed pieces of work.
    Fixed(Workload),
    /// Scene of a file.
    Scene(PathBuf),
}

impl fmt::Display for Work {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed(workload) => formatter.write_str(workload.name()),
            Self::Scene(path) => write!(formatter, "{}", path.display()),
        }
    }
}

impl Work {
    pub(crate) fn fixed(workloads: &[Workload]) -> Vec<Self> {
        workloads.iter().copied().map(Self::Fixed).collect()
    }
}

/// Reference value of a workload.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Name of the value, with its unit.
    pub what: &'static str,
    /// Reference from a path that shares as little as possible with the workload's.
    pub expected: f64,
    /// Largest relative difference.
    pub tolerance: f64,
}

/// Receiver and radiation, which the plate's scene lacks.
const RECEIVER: &str = "\n[[receiver]]\nstandard = \"cpx\"\n\n[radiation]\nquality = \"draft\"\nfmax = 1000.0\n\
                        audio = false\n";

/// Reference of a varying force.
const fn variation(expected: f64) -> Truth {
    Truth { what: "root mean square of the varying force [N]", expected, tolerance: 1e-5 }
}

impl Workload {
    /// Reference value. Forces of rolling workloads are those of the same scene by direct sums with complete memory (a
    /// test that takes a minute repeats them); the others are checked against reference paths as they run.
    pub const fn truth(self) -> Truth {
        match self {
            Self::Smooth => Truth { what: "mean force [N]", expected: 2767.912323979274, tolerance: 1e-5 },
            Self::Rough => variation(48.92530136118314),
            Self::HighSpeed => variation(465.0516520600554),
            Self::LongRollout => variation(199.02389511046786),
            Self::HalfSpaceSlices => variation(61.05028687115533),
            // By the recursion: the direct sum itself is the reference of the others.
            Self::DirectHistory => variation(169.69001338700753),
            // The errors of its many poles add up.
            Self::Cells => Truth { tolerance: 1e-3, ..variation(74.07911137177945) },
            // From those forces by the same transfer to the microphone.
            Self::Sound => {
                Truth { what: "sound pressure beside the tyre [Pa]", expected: 1.2562395149820886, tolerance: 1e-5 }
            }
            Self::Compliance => {
                Truth { what: "H_n by vectors, off by so much from scalars, plus 1", expected: 1.0, tolerance: 1e-10 }
            }
            Self::Influence => Truth {
                what: "H_n between the fitted points, off by so much of its largest value from sums, plus 1",
                expected: 1.0,
                tolerance: 1e-4,
            },
        }
    }

    /// Scene of a workload that rolls; `None` for the others.
    pub fn scene(self) -> Result<Option<LoadedScene>, SceneError> {
        let text = match self {
            Self::Cells => PLATE.replace("slices = \"winkler\"", "zone = \"cells\""),
            Self::Sound => format!("{PLATE}{RECEIVER}"),
            _ => PLATE.to_owned(),
        };
        let mut loaded = Scene::from_str(&text, self.name())?;
        let scene = &mut loaded.scene;
        scene.title = self.name().to_owned();
        scene.outputs = Outputs { arrays: false, spectra: false, plots: false, ..Outputs::default() };
        // A fixed height: the scene prescribes nothing about the force.
        scene.rolling.axle = Axle::Indentation { indentation: 0.012, ramp: 0.03 };
        let (elements, speed, warm_up, duration) = match self {
            Self::Smooth => (512, 80.0, 0.1, 0.4),
            Self::Rough => (512, 80.0, 0.1, 0.25),
            Self::HighSpeed => (512, 200.0, 0.03, 0.07),
            Self::LongRollout => (96, 80.0, 0.5, 20.0),
            Self::HalfSpaceSlices => (256, 80.0, 0.1, 0.2),
            Self::DirectHistory => (96, 80.0, 0.1, 0.4),
            Self::Cells => (256, 80.0, 0.05, 0.08),
            Self::Sound => (512, 80.0, 0.1, 0.8),
            Self::Compliance | Self::Influence => return Ok(None),
        };
        // A rule that direct sums have, too: they give the reference values.
        (scene.numerics.elements, scene.numerics.time_rule) = (elements, TimeRule::Bdf2);
        scene.rolling.speed_kmh = speed;
        (scene.rolling.warm_up, scene.rolling.duration) = (warm_up, duration);
        match self {
            Self::Smooth => scene.road = Road::Smooth,
            Self::HighSpeed => {
                (scene.numerics.time_rule, scene.numerics.substeps) = (TimeRule::Sdirk2, 2);
                // A road without texture across is generated in no time.
                scene.effects.texture = Switch::Off;
            }
            Self::LongRollout => {
                scene.rolling.axle = Axle::Load { load: 3400.0, tolerance: 0.01 };
                scene.effects.texture = Switch::Off;
            }
            Self::HalfSpaceSlices => scene.contact.slices = Slices::HalfSpace,
            Self::DirectHistory => {
                scene.numerics.history = History::Direct;
                scene.numerics.memory = 0.5;
                scene.effects.texture = Switch::Off;
            }
            Self::Rough | Self::Cells | Self::Sound | Self::Compliance | Self::Influence => {}
        }
        Ok(Some(loaded))
    }
}
