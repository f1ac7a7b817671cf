//! Waves around a rotating tyre, beside those of the standing one, and its critical speeds.
//!
//! Rotation splits the two waves of n periods: the one against the rotation is the faster. A force that stands below
//! the axle runs around the tyre against its rotation with the speed V, at n V/L for n periods: where this line meets a
//! wave against the rotation, the tyre rolls into its own wave.

use serde::Serialize;

use crate::plan::Decisions;
use crate::scene::{Scene, Switch};
use crate::tyre::critical_speed::{TreadWave, limit, tread_wave};
use crate::tyre::modes::{Modes, ModesError, Motion, modes};
use crate::tyre::poles::Direction;
use crate::tyre::slowest_wave::{SlowestWave, slowest_wave_below};

/// Highest speed up to which the belt's waves are looked for \[m/s\].
pub(crate) const HIGHEST: f64 = 200.0;

/// Lowest radial modes of n periods and of the lowest lateral number \[Hz\], where they exist.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct RollingWave {
    /// Number of periods around the circumference.
    pub n: usize,
    /// Frequency on the tyre that does not rotate \[Hz\].
    pub standing: Option<f64>,
    /// Frequency of the wave that runs with the rotation \[Hz\].
    pub forwards: Option<f64>,
    /// Frequency of the wave that runs against the rotation \[Hz\].
    pub backwards: Option<f64>,
}

/// Waves and critical speeds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RollingWaves {
    /// Rolling speed \[m/s\].
    pub speed: f64,
    /// Growth of the radius by rotation \[m\].
    pub growth: f64,
    /// Waves by n, from 0 on.
    pub waves: Vec<RollingWave>,
    /// Slowest wave of the belt on the rotating tyre; `None` if no wave is slower than [`HIGHEST`] and the limit.
    pub belt: Option<SlowestWave>,
    /// Slowest wave of the belt on the tyre that does not rotate; `None` if none is slower than [`HIGHEST`].
    pub belt_held: Option<SlowestWave>,
    /// Wave of the tread's surface, if it has one.
    pub tread: Option<TreadWave>,
    /// Speed up to which the rotating tyre is stable \[m/s\].
    pub limit: Option<f64>,
}

/// Finds the waves n = 0..=`largest_n` up to a frequency \[Hz\], and the critical speeds of a scene's tyre, which
/// rotates unless it is flat.
///
/// # Errors
/// As [`modes`].
pub(crate) fn rolling_waves(scene: &Scene, largest_n: usize, highest: f64) -> Result<RollingWaves, ModesError> {
    let mut turning = scene.clone();
    turning.effects.rotation = Switch::Auto;
    let Decisions { tyre, growth, .. } = Decisions::new(&turning);
    let standing = modes(&scene.tyre, largest_n, 1, highest)?;
    let rolling = if tyre.turns() { modes(&tyre, largest_n, 1, highest)? } else { standing.clone() };
    let waves = (0..=largest_n).map(|n| RollingWave {
        n,
        standing: lowest(&standing, n, None),
        forwards: lowest(&rolling, n, Some(Direction::Forwards)),
        backwards: lowest(&rolling, n, Some(Direction::Backwards)),
    });
    let limit = limit(&tyre);
    Ok(RollingWaves {
        speed: scene.rolling.speed(),
        growth,
        waves: waves.collect(),
        belt: slowest_wave_below(&tyre, limit.map_or(HIGHEST, |limit| limit.min(HIGHEST))),
        belt_held: slowest_wave_below(&scene.tyre, HIGHEST),
        tread: tread_wave(&tyre, tyre.turns()),
        limit,
    })
}

/// Frequency of the lowest radial mode of n periods \[Hz\], of the given direction where modes have one.
fn lowest(modes: &Modes, n: usize, direction: Option<Direction>) -> Option<f64> {
    let mut of_wave = modes.confirmed.iter().filter(|mode| mode.n == n && mode.motion == Motion::Radial);
    of_wave.find(|mode| mode.direction.is_none() || mode.direction == direction).map(|mode| mode.frequency())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::DEFAULT;
    use crate::test_models::on_springs;

    #[test]
    fn rotation_splits_waves_about_as_in_an_inextensional_ring() {
        let springs = on_springs(DEFAULT);
        for (text, speed, slowest) in [(&*springs, 110.0, 59.0), (&springs, 250.0, 59.0), (DEFAULT, 110.0, 55.2)] {
            let mut scene = Scene::from_str(text, "scene").unwrap().scene;
            scene.rolling.speed_kmh = speed;
            let found = rolling_waves(&scene, 6, 400.0).unwrap();
            // Revolutions per second.
            let turns = found.speed / scene.tyre.circumference;
            for wave in &found.waves[1..] {
                let RollingWave { n, standing, forwards, backwards } = *wave;
                let (n, standing) = (n as f64, standing.unwrap());
                let shift = 2.0 * n * turns / (n * n + 1.0);
                let middle = standing.hypot(turns * n * (n * n - 1.0) / (n * n + 1.0));
                for (found, ring) in [(backwards.unwrap(), middle + shift), (forwards.unwrap(), middle - shift)] {
                    assert!((found / ring - 1.0).abs() < 0.03, "{speed} km/h, n = {n}: {found} Hz, ring {ring} Hz");
                }
            }
            // No wave of the rotating belt is slower than its stability limit.
            assert_eq!(found.belt, None, "{found:?}");
            assert!(found.belt_held.is_some_and(|wave| (wave.speed - slowest).abs() < 1.0), "{found:?}");
        }
    }
}
