//! Figure 4: a slice of the road and its stiffness function by both laws, and the effect of the law on the force.

use crate::run::RunError;
use crate::scene::{LoadedScene, Scene, SliceCoupling};
use crate::study::slices::{LAWS, Sample, SliceView, Spread, spread};
use crate::study::trial::{Trial, Trials};
use serde::Serialize;

use super::levels::{Change, INSIGNIFICANT, changes, largest};
use super::statement::{Statement, Verdict};

/// Road coordinate of the slice \[m\].
const PLACE: f64 = 0.5;
/// The slice, the spread over the road, and the change of the force between the laws.
#[derive(Clone, Debug, Serialize)]
pub(super) struct SliceFigure {
    /// View of the slice; `None` for a flat road.
    #[serde(skip)]
    pub view: Option<SliceView>,
    /// Number of slices of the spread.
    pub slices: usize,
    /// Spread of S over the road by both laws.
    pub spread: Vec<Spread>,
    /// Change from springs to a half-space under the slices, with the scene's local law.
    pub local: Changed,
    /// The same with the paper's equation 4.
    pub equation_4: Changed,
}

/// Change of the force by a half-space under the slices instead of springs.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Changed {
    /// Mean force with springs, and with the half-space \[N\].
    pub mean_force: [f64; 2],
    /// Changes of the force's third octaves.
    pub changes: Vec<Change>,
    /// The largest of them.
    pub largest: Change,
}

impl Changed {
    fn of((scene, springs): (&Scene, &Trial), highest: f64, trials: &mut Trials<'_>) -> Result<Self, RunError> {
        let mut other = scene.clone();
        other.contact.slices = LAWS[1].0;
        let half_space = trials.roll(&other)?;
        let changes = changes(&half_space.levels, &springs.levels, highest);
        let mean_force = [springs.mean_force(), half_space.mean_force()];
        Ok(Self { mean_force, largest: largest(&changes, f64::abs), changes })
    }

    fn words(&self) -> String {
        format!("{:+.1} dB at {} Hz", self.largest.change, self.largest.frequency)
    }
}

impl SliceFigure {
    /// Compares `slices` slices of a scene's road, and its force; `springs` is the run of the scene.
    ///
    /// # Errors
    /// Errors of the road and of the runs.
    pub(super) fn of(
        loaded: &LoadedScene,
        slices: usize,
        springs: &Trial,
        highest: f64,
        trials: &mut Trials<'_>,
    ) -> Result<Self, RunError> {
        let sample = Sample::of(loaded, PLACE, slices)?;
        let curves = sample.curves(loaded.scene.contact.slice_tolerance)?;
        let local = Changed::of((&loaded.scene, springs), highest, trials)?;
        let mut paper = loaded.scene.clone();
        paper.contact.slice_coupling = SliceCoupling::Explicit;
        let springs = trials.roll(&paper)?;
        let equation_4 = Changed::of((&paper, &springs), highest, trials)?;
        Ok(Self {
            view: sample.view([&curves[0][0], &curves[1][0]])?,
            slices: curves[0].len(),
            spread: spread(&curves, &sample.depths()),
            local,
            equation_4,
        })
    }

    pub(super) fn statement(&self) -> Statement {
        Statement {
            place: "figure 4",
            subject: "springs or half-space under a slice",
            paper: "no significant difference between the two",
            found: format!(
                "force: {} by equation 4, {} by the local law; S: {}",
                self.equation_4.words(),
                self.local.words(),
                self.ends().map_or(String::new(), |[light, deep]| format!(
                    "{:.0} % at {:.1} mm, {:.0} % at {:.1} mm",
                    100.0 * light.difference,
                    1e3 * light.penetration,
                    100.0 * deep.difference,
                    1e3 * deep.penetration
                ))
            ),
            verdict: judge(self.equation_4.largest.change),
            why: format!("third octaves of the force by equation 4 within {INSIGNIFICANT} dB"),
        }
    }

    /// Smallest and largest penetration of the spread.
    fn ends(&self) -> Option<[&Spread; 2]> {
        Some([self.spread.first()?, self.spread.last()?])
    }
}

fn judge(largest: f64) -> Verdict {
    Verdict::of(largest.abs() <= INSIGNIFICANT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_that_changes_by_more_than_a_decibel_is_significant() {
        let found = [0.2, -0.9, 1.5, -3.0, f64::NAN].map(|largest| judge(largest) == Verdict::Agrees);
        assert_eq!(found, [true, true, false, false, false]);
    }
}
