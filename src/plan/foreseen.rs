//! Knowledge of a plan about a run that will hardly give what it is asked for.

use super::Plan;
use crate::tyre::slowest_wave::{SlowestWave, slowest_wave_below};

impl Plan {
    /// Lists what the user should act on before the run: a speed at which the tyre rolls into its own waves.
    pub fn warnings(&self) -> Vec<String> {
        self.outrun_waves().into_iter().collect()
    }

    fn outrun_waves(&self) -> Option<String> {
        let rolling = &self.decisions.tyre;
        let SlowestWave { n, speed } = slowest_wave_below(rolling, self.speed)?;
        let right = if *rolling == self.scene.tyre {
            "effects.centrifugal_tension = \"auto\" makes waves faster, as tyres have it"
        } else {
            "choose a lower speed"
        };
        Some(format!(
            "at {} km/h the tyre outruns waves round it, the slowest of which, of {n} periods, has {:.0} km/h: the \
             axle may find no height for its load, and the motion may grow without bound; {right}",
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
    fn a_speed_above_that_of_the_belts_waves_is_told_unless_they_are_made_faster() {
        let warnings = |settings: &[&str]| {
            let settings: Vec<Setting> = settings.iter().map(|text| Setting::parse(text).unwrap()).collect();
            Plan::of(&Scene::from_str_with(DEFAULT, "default", &settings).unwrap()).unwrap().warnings()
        };
        assert!(warnings(&[]).is_empty() && warnings(&["rolling.speed_kmh=200"]).is_empty());
        let told = warnings(&["rolling.speed_kmh=230"]);
        assert!(told.len() == 1 && told[0].contains("has 212 km/h") && told[0].contains("= \"auto\""), "{told:?}");
        // Tension by the tyre's own weight makes every wave faster than it rolls.
        let auto = |speed| [speed, "effects.centrifugal_tension=auto"];
        for speed in ["rolling.speed_kmh=250", "rolling.speed_kmh=400"] {
            assert!(warnings(&auto(speed)).is_empty(), "{:?}", warnings(&auto(speed)));
        }
    }
}
