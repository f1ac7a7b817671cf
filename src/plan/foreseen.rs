//! Warnings, from a plan alone, about a run that will hardly give what it is asked for.

use super::Plan;
use crate::scene::{LoadedScene, Rolling, SceneError, short};
use crate::tyre::critical_speed::{TreadWave, limit_below, tread_wave};
use crate::tyre::slowest_wave::{SlowestWave, slowest_wave_below};

impl Plan {
    /// Problems that need the user's attention before the run: a speed at which the tyre rolls into its own waves, a
    /// load beyond the range of its model, a warm-up that takes most of the run, keys that override a preset's.
    pub fn warnings(&self) -> Vec<String> {
        let reported = [self.outrun_waves(), self.load_warning(), self.long_warm_up()].into_iter().flatten();
        reported.chain(self.overridden.iter().cloned()).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DEFAULT, Scene, Setting};

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
}
