//! Shortest warm-up in which an axle finds the height for its load.

use super::Plan;
use crate::contact::axle::LoadControl;
use crate::scene::{LoadedScene, Rolling, SceneError, short};
use crate::tyre::modes::{Motion, modes};

/// Highest frequency up to which the lowest vibration of a tyre is looked for \[Hz\].
const HIGHEST: f64 = 1000.0;
/// Warm-up that is long enough for any tyre \[s\]: no tyre on a rim has a vibration as low as 20 Hz.
const LONG: f64 = 0.1;

impl Plan {
    /// Checks that the warm-up is long enough for the height of a load to be corrected: the mean force in each window
    /// between two corrections has to be that of a height, but within less than half a period of the tyre's slowest
    /// radial vibration the force may lie entirely to one side. Without a warm-up the height is that at rest.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the shortest warm-up.
    pub(crate) fn check_warm_up(&self, loaded: &LoadedScene) -> Result<(), SceneError> {
        let warm_up = self.scene.rolling.warm_up;
        if self.scene.rolling.axle.load().is_none() || self.warm_up_steps == 0 || warm_up >= LONG {
            return Ok(());
        }
        // Of the tyre at rest: when it rotates, its frequencies depend on the frame of reference.
        let Ok(found) = modes(&self.scene.tyre, 1, 1, HIGHEST) else { return Ok(()) };
        let radial = found.confirmed.iter().filter(|mode| mode.motion == Motion::Radial);
        let Some(slowest) = radial.map(|mode| mode.frequency()).reduce(f64::min) else { return Ok(()) };
        let shortest = 0.5 / (slowest * LoadControl::WINDOW);
        if warm_up >= shortest {
            return Ok(());
        }
        let wrong = format!(
            "{} s are too short for an axle to find the height of its load: it is corrected after windows of {:.1} ms, \
             and the tyre's slowest radial vibration, of {slowest:.0} Hz, moves the force for {:.1} ms to one side",
            short(warm_up),
            1e3 * LoadControl::WINDOW * warm_up,
            5e2 / slowest
        );
        let right = format!(
            "at least {} s, the default {} s, or 0: the height at rest on a smooth road",
            short((1e3 * shortest).ceil() / 1e3),
            Rolling::WARM_UP
        );
        Err(loaded.complain("rolling.warm_up", wrong, right).into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DEFAULT, Scene, Setting};

    #[test]
    fn too_short_a_warm_up_is_refused_with_the_shortest_one() {
        let check = |warm_up: f64| {
            let setting = Setting::parse(&format!("rolling.warm_up={warm_up}")).unwrap();
            let loaded = Scene::from_str_with(DEFAULT, "scene", &[setting]).unwrap();
            Plan::of(&loaded).unwrap().check_warm_up(&loaded)
        };
        for short in [0.005, 0.01, 0.02] {
            let error = check(short).unwrap_err().to_string();
            let least: f64 = error.split("at least ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
            println!("{short}: at least {least} s");
            assert!(error.contains("rolling.warm_up") && least > 0.02 && least < LONG, "{error}");
            assert!(check(least).is_ok());
        }
        assert!(check(0.0).is_ok() && check(0.5).is_ok());
    }
}
