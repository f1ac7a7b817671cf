//! Figure 4: a slice of the road and its stiffness function by both laws, and what the law is worth in the force.

use serde::Serialize;

use super::levels::{Change, changes, largest};
use super::statement::{Statement, Verdict};
use crate::run::error::RunError;
use crate::scene::{LoadedScene, Scene};
use crate::study::slices::{LAWS, Sample, SliceView, Spread, spread};
use crate::study::trial::{Trial, Trials};

/// Road coordinate of the slice \[m\].
const PLACE: f64 = 0.5;
/// A level that changes by less is the same \[dB\]: what the accuracy `standard` states, and about what is heard.
const INSIGNIFICANT: f64 = 1.0;

/// The slice, the spread over the road, and levels of the force by both laws.
#[derive(Clone, Debug, Serialize)]
pub struct SliceFigure {
    /// The slice; none of a flat road.
    #[serde(skip)]
    pub view: Option<SliceView>,
    /// Slices of the spread.
    pub slices: usize,
    /// Spread of S over the road by both laws.
    pub spread: Vec<Spread>,
    /// Mean force by both laws, the half-space law second \[N\].
    pub mean_force: [f64; 2],
    /// Change of the force's third octaves from the springs to the half-space.
    pub changes: Vec<Change>,
    /// The largest of them.
    pub largest: Change,
}

impl SliceFigure {
    /// Of so many slices of the scene's road, and of the force with the law that `springs` were not rolled with.
    ///
    /// # Errors
    /// Of the road and of the run.
    pub fn of(
        loaded: &LoadedScene,
        slices: usize,
        (scene, springs): (&Scene, &Trial),
        highest: f64,
        trials: &mut Trials<'_>,
    ) -> Result<Self, RunError> {
        let sample = Sample::of(loaded, PLACE, slices)?;
        let curves = sample.curves(loaded.scene.contact.slice_tolerance)?;
        let mut other = scene.clone();
        other.contact.slices = LAWS[1].0;
        let half_space = trials.roll(&other)?;
        let changes = changes(&half_space.levels, &springs.levels, highest);
        Ok(Self {
            view: sample.view([&curves[0][0], &curves[1][0]])?,
            slices: curves[0].len(),
            spread: spread(&curves, &sample.depths()),
            mean_force: [springs.mean_force(), half_space.mean_force()],
            largest: largest(&changes, f64::abs),
            changes,
        })
    }

    /// What the paper says of it.
    pub fn statement(&self) -> Statement {
        let differences: Vec<String> = self
            .spread
            .iter()
            .map(|row| format!("{:.0} % at {:.1} mm", 100.0 * row.difference, 1e3 * row.penetration))
            .collect();
        Statement {
            place: "figure 4",
            subject: "springs or half-space under a slice",
            paper: "no significant difference between the two",
            found: format!(
                "force levels differ by {:+.1} dB at most, at {} Hz; displacements S of {} slices by {} (rms)",
                self.largest.change,
                self.largest.frequency,
                self.slices,
                differences.join(", ")
            ),
            verdict: judge(self.largest.change),
            why: format!("judged by third octaves of the force: {INSIGNIFICANT} dB or less is not significant"),
        }
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
