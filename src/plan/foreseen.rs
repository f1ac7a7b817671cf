//! Warnings, from a plan alone, about a run that will hardly give what it is asked for, such as one whose warm-up is
//! too short for the axle to find the height for its load.

use crate::contact::axle::LoadControl;
use crate::scene::{LoadedScene, Rolling, SceneError, short};
use crate::tyre::critical_speed::{TreadWave, limit_below, tread_wave};
use crate::tyre::modes::{Motion, modes};
use crate::tyre::slowest_wave::{SlowestWave, slowest_wave_below};

use super::Plan;

impl Plan {
    /// Problems that need the user's attention before the run: a speed at which the tyre rolls into its own waves, a
    /// load beyond the range of its model, a warm-up that takes most of the run, a standard error that is missed, keys
    /// that override a preset's.
    pub fn warnings(&self) -> Vec<String> {
        let reported = [self.outrun_waves(), self.load_warning(), self.long_warm_up()].into_iter().flatten();
        let Rolling { duration, .. } = self.scene.rolling;
        let missed = self.corrections.iter().filter_map(|corrections| corrections.missed(self.valid_to, duration));
        reported.chain(missed).chain(self.overridden.iter().cloned()).collect()
    }

    /// Warning of a warm-up that is longer than the evaluated time, and than a car's tyre needs.
    fn long_warm_up(&self) -> Option<String> {
        let Rolling { warm_up, duration, .. } = self.scene.rolling;
        (warm_up > duration && warm_up > Rolling::WARM_UP).then(|| {
            format!(
                "rolling.warm_up: {} s are simulated before the {} s that are evaluated; {} s are enough for a car \
                 tyre",
                short(warm_up),
                short(duration),
                Rolling::WARM_UP
            )
        })
    }

    /// Checks that the rotating tyre is stable at the plan's speed; the error names the speed up to which it is.
    pub(crate) fn check_rotation(&self, loaded: &LoadedScene) -> Result<(), SceneError> {
        let rolling = &self.decisions.tyre;
        let Some(limit) = limit_below(rolling, self.speed).filter(|_| rolling.turns()) else { return Ok(()) };
        let [held_by, stiffer] = match rolling.sidewall {
            Some(_) => ["sidewalls", "stiffer sidewalls"],
            None => ["foundation", "a stiffer foundation"],
        };
        let limit = 3.6 * limit;
        let wrong = format!(
            "a tyre that turns this fast has no stiffness left against its {held_by}: it is stable up to {limit:.0} \
             km/h"
        );
        let right = format!("a lower speed, {stiffer}, or effects.rotation = \"off\"");
        Err(loaded.complain("rolling.speed_kmh", wrong, right).into())
    }

    /// Note on waves of the tread's surface that are slower than the tyre rolls.
    pub(crate) fn outrun_tread(&self) -> Option<String> {
        let rolling = &self.decisions.tyre;
        let TreadWave { length, speed } =
            tread_wave(rolling, rolling.turns()).filter(|wave| wave.speed < self.speed)?;
        Some(format!(
            "the tyre rolls faster than waves of its tread, {:.0} mm long, run ({:.0} km/h): the contact has no steady \
             state; time stepping remains well-posed",
            1e3 * length,
            3.6 * speed
        ))
    }

    fn outrun_waves(&self) -> Option<String> {
        let rolling = &self.decisions.tyre;
        let SlowestWave { n, speed } = slowest_wave_below(rolling, self.speed)?;
        let right = if rolling.curvature && !rolling.turns() {
            "effects.rotation = \"auto\" makes waves faster, as in real tyres"
        } else {
            "choose a lower speed"
        };
        Some(format!(
            "at {} km/h the tyre rolls faster than waves round it, the slowest of which, of {n} periods, travels at \
             {:.0} km/h: the axle may find no height for its load, and the motion may grow without bound; {right}",
            self.scene.rolling.speed_kmh,
            3.6 * speed
        ))
    }
}

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
    use crate::scene::{DEFAULT, Scene, Setting};

    use super::*;

    #[test]
    fn a_speed_above_the_belts_waves_is_warned_of() {
        let warnings = |settings: &[&str]| {
            let settings: Vec<Setting> = settings.iter().map(|text| Setting::parse(text).unwrap()).collect();
            Plan::of(&Scene::from_str_with(DEFAULT, "default", &settings).unwrap()).unwrap().warnings()
        };
        let held = |speed| [speed, "effects.rotation=off"];
        assert!(warnings(&[]).is_empty() && warnings(&held("rolling.speed_kmh=190")).is_empty());
        let reported = warnings(&held("rolling.speed_kmh=230"));
        assert!(
            reported.len() == 1 && reported[0].contains("travels at 199 km/h") && reported[0].contains("= \"auto\""),
            "{reported:?}"
        );
        // Tension by its own mass makes every wave of a rotating tyre faster than it rolls.
        for speed in ["rolling.speed_kmh=250", "rolling.speed_kmh=400"] {
            assert!(warnings(&[speed]).is_empty(), "{:?}", warnings(&[speed]));
        }
    }

    #[test]
    fn keys_that_override_a_preset_are_reported_until_unset() {
        let reported = |settings: &[&str]| {
            let settings: Vec<Setting> = settings.iter().map(|text| Setting::parse(text).unwrap()).collect();
            Plan::of(&Scene::from_str_with(DEFAULT, "default", &settings).unwrap()).unwrap().warnings()
        };
        let draft = ["numerics.preset=draft", "numerics.fmax=1000"];
        let overridden = reported(&[&draft[..], &["numerics.elements=600", "numerics.substeps="]].concat());
        let elements =
            overridden.iter().find(|warning| warning.starts_with("numerics.elements = 600 of the scene")).unwrap();
        assert!(
            elements.contains("of preset = \"draft\"") && elements.contains("--set numerics.elements="),
            "{overridden:?}"
        );
        assert!(!overridden.iter().any(|warning| warning.contains("substeps")), "{overridden:?}");
        let unset: Vec<String> =
            overridden.iter().filter_map(|warning| Some(format!("{}=", warning.split_once(" = ")?.0))).collect();
        let settings: Vec<&str> =
            draft.into_iter().chain(["numerics.substeps="]).chain(unset.iter().map(String::as_str)).collect();
        assert!(reported(&settings).is_empty(), "{:?}", reported(&settings));
        assert!(reported(&["numerics.elements=600"]).is_empty(), "no preset, nothing to override");
    }

    #[test]
    fn an_unstable_speed_is_refused_and_a_fast_one_warned_of() {
        let of = |settings: &[&str]| {
            let settings: Vec<Setting> = settings.iter().map(|text| Setting::parse(text).unwrap()).collect();
            Plan::of(&Scene::from_str_with(DEFAULT, "default", &settings).unwrap())
        };
        let error = of(&["rolling.speed_kmh=440"]).unwrap_err().to_string();
        assert!(
            error.contains("its sidewalls: it is stable up to 403 km/h") && error.contains("rolling.speed_kmh"),
            "{error}"
        );
        assert!(of(&["rolling.speed_kmh=440", "effects.rotation=off"]).is_ok());
        let reported = |plan: Plan| plan.decisions.notes.iter().any(|note| note.contains("waves of its tread"));
        // docs/scenes.md states this speed.
        assert!(
            reported(of(&["rolling.speed_kmh=250"]).unwrap()) && !reported(of(&["rolling.speed_kmh=246"]).unwrap())
        );
    }

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
