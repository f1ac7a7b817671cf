//! What a plan knows of a run that will hardly give what it is asked for.

use super::Plan;
use crate::tyre::slowest_wave::{SlowestWave, slowest_wave_below};

impl Plan {
    /// What the user should act on before the run: a speed at which the tyre rolls into its own waves.
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
            "at {} km/h the tyre outruns waves round it, the slowest of which, of {n} periods, has {:.0} km/h: the axle \
             may find no height for its load, and the motion may grow without bound; {right}",
            self.scene.rolling.speed_kmh,
            3.6 * speed
        ))
    }
}
