//! Road of a planned run: opened, checked for its length, its errors located in the scene.

use crate::effects::RunError;
use crate::plan::Plan;
use crate::road::{Limits, RoadDescription, RoadError, RoadSurface, describe};
use crate::scene::{LoadedScene, Scene, SceneError};

/// Opens the road of a planned run, and checks that it reaches `chord` \[m\] beyond the axle's path; also returns the
/// road coordinate at which the axle starts \[m\].
///
/// # Errors
/// [`RunError`] with the key that is to blame.
pub(crate) fn open_road(loaded: &LoadedScene, plan: &Plan, chord: f64) -> Result<(RoadSurface, f64), RunError> {
    let scene = &plan.scene;
    let open = || -> Result<_, RoadError> {
        let surface = RoadSurface::open(&scene.road, plan.lattice()?, road_limits(scene))?;
        let start = match (scene.rolling.start, surface.extent()) {
            (Some(start), _) => start,
            (None, None) => 0.0,
            (None, Some((from, _))) => from + (chord / plan.element).ceil() * plan.element,
        };
        let travel = plan.speed * plan.time_step * plan.steps as f64;
        surface.check_covers(start - chord, start + travel + chord)?;
        Ok((surface, start))
    };
    open().map_err(|error| in_scene(loaded, error))
}

/// Describes the road of a plan.
///
/// # Errors
/// Those of the road, see [`in_scene`].
pub(crate) fn described(plan: &Plan) -> Result<RoadDescription, RoadError> {
    let scene = &plan.scene;
    describe(&scene.road, plan.lattice()?, scene.rolling.speed(), road_limits(scene))
}

/// Memory limit for opening a scene's road.
pub(crate) fn road_limits(scene: &Scene) -> Limits {
    Limits { bytes: scene.numerics.memory_bytes() }
}

/// Error of a road, located in the scene at the key that it is about.
pub(crate) fn in_scene(loaded: &LoadedScene, error: RoadError) -> RunError {
    let (key, right) = match &error {
        error if error.is_of_another_kind() => {
            ("road.kind", "the kind that the file is of, with its keys; or another file")
        }
        RoadError::Short { .. } => ("rolling.duration", "a road that is long enough, a shorter run, or another at_end"),
        RoadError::NotPositive { key, .. } => (*key, "a positive number"),
        RoadError::Range { .. } => ("road.range", "a part of what the file covers"),
        RoadError::LateralPosition { .. } => ("road.lateral_position", "a strip inside the measured columns"),
        RoadError::NotThirdOctave { .. } | RoadError::BandTwice { .. } | RoadError::LevelCount { .. } => {
            ("road.wavelengths", "each third-octave mid-wavelength once, with its level")
        }
        RoadError::Level { .. } => ("road.levels", "a level in dB re 1e-6 m"),
        RoadError::Spacing { .. } | RoadError::TextureTooLarge { .. } => {
            ("road.spacing", "a spacing that suits the wavelengths")
        }
        RoadError::Trend { .. } => ("road.longest_wavelength", "a shorter wavelength, or none"),
        RoadError::TooManyHeights { .. } => ("road", "a coarser spacing, fewer cells, or a larger memory_limit"),
        RoadError::Moments { .. } => ("road.kurtosis", "a kurtosis in that range, or less skewness"),
        RoadError::PowerLaw { .. } | RoadError::TwoSpectra => ("road.power_law", "one valid spectrum"),
        RoadError::MissingUnit { key, .. } => (*key, "\"m\", \"mm\" or \"um\""),
        RoadError::Narrow { .. } => ("road.file", "a road at least as wide as tyre.contact_width"),
        _ => ("road.file", "a complete file of the kind that road.kind names"),
    };
    let key = if key.contains('.') { key.to_owned() } else { format!("road.{key}") };
    SceneError::from(loaded.complain(&key, error.to_string(), right)).into()
}
