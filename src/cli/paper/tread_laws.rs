//! Figure 6: third octaves of the contact force by the tread laws, at the same static contact stiffness.

use crate::response::BandLevel;
use crate::run::RunError;
use crate::scene::{Scene, Tread};
use crate::study::trial::{Trial, Trials};
use serde::Serialize;

use super::levels::{Change, INSIGNIFICANT, changes, largest, mean};
use super::statement::{Statement, Verdict};

/// Frequency at which the paper finds the largest effect: the contact resonance \[Hz\].
const RESONANCE: f64 = 800.0;
/// The largest change counts as being there within this factor in frequency: two third octaves.
const NEAR: f64 = 1.6;
/// Finest tolerance of the poles of the carcass under a bedding: with 512 elements they reach 1.2e-3.
const BEDDING_POLES: f64 = 2e-3;

/// A tread law compared with the elastic one.
#[derive(Clone, Debug, Serialize)]
pub(super) struct TreadLaw {
    /// Name of the law.
    pub name: &'static str,
    /// Mean force \[N\].
    pub mean_force: f64,
    /// Change of the levels from those of the elastic tread.
    pub changes: Vec<Change>,
    /// Levels of the force.
    #[serde(skip)]
    pub levels: Vec<BandLevel>,
}

/// All three laws.
#[derive(Clone, Debug, Serialize)]
pub(super) struct TreadLaws {
    /// Elastic, bedding, uncoupled.
    pub laws: [TreadLaw; 3],
    /// Mean change by the bedding \[dB\].
    pub mean_of_bedding: f64,
    /// The band in which the bedding exceeds the elastic tread most.
    pub most: Change,
}

impl TreadLaws {
    /// Rolls the other laws beside the elastic tread, whose run is given.
    ///
    /// # Errors
    /// Errors of the runs.
    pub(super) fn of(
        (scene, elastic): (&Scene, &Trial),
        highest: f64,
        trials: &mut Trials<'_>,
    ) -> Result<Self, RunError> {
        let mut bedding = scene.clone();
        bedding.contact.tread = Tread::Bedding;
        bedding.numerics.pole_tolerance = bedding.numerics.pole_tolerance.max(BEDDING_POLES);
        let mut uncoupled = scene.clone();
        (uncoupled.contact.tread, uncoupled.contact.equal_stiffness) = (Tread::Uncoupled, true);
        let law = |name, trial: &Trial| TreadLaw {
            name,
            mean_force: trial.mean_force(),
            changes: changes(&trial.levels, &elastic.levels, highest),
            levels: trial.levels.clone(),
        };
        let laws = [
            law("elastic", elastic),
            law("bedding", &trials.roll(&bedding)?),
            law("uncoupled", &trials.roll(&uncoupled)?),
        ];
        let of_bedding = &laws[1].changes;
        Ok(Self { mean_of_bedding: mean(of_bedding), most: largest(of_bedding, |change| change), laws })
    }

    pub(super) fn statements(&self) -> [Statement; 2] {
        let above = self.laws[1].changes.iter().filter(|change| change.change > 0.0).count();
        let uncoupled = largest(&self.laws[2].changes, f64::abs);
        [
            Statement {
                place: "figure 6",
                subject: "bedding beside the elastic tread, same contact stiffness",
                paper: "the bedding shows higher levels",
                found: format!(
                    "{:+.1} dB in the mean, higher in {above} of {} third octaves; the uncoupled tread within {:.2} \
                     dB",
                    self.mean_of_bedding,
                    self.laws[1].changes.len(),
                    uncoupled.change.abs()
                ),
                verdict: is_higher(self.mean_of_bedding),
                why: format!("in the mean over third octaves {INSIGNIFICANT} dB higher or more"),
            },
            Statement {
                place: "figure 6",
                subject: "where the bedding is highest above the elastic tread",
                paper: "near 800 Hz, the contact resonance",
                found: format!("{:+.1} dB at {} Hz", self.most.change, self.most.frequency),
                verdict: is_near_the_resonance(self.most),
                why: format!("the largest rise within two third octaves of {RESONANCE} Hz"),
            },
        ]
    }
}

fn is_higher(mean: f64) -> Verdict {
    Verdict::of(mean >= INSIGNIFICANT)
}

fn is_near_the_resonance(most: Change) -> Verdict {
    Verdict::of(most.change > 0.0 && (RESONANCE / NEAR..=RESONANCE * NEAR).contains(&most.frequency))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bedding_must_be_higher_and_most_so_at_the_resonance() {
        assert_eq!(
            [2.0, 0.1, -2.0, f64::NAN].map(is_higher).map(|v| v == Verdict::Agrees),
            [true, false, false, false]
        );
        let near = |frequency, change| is_near_the_resonance(Change { frequency, change }) == Verdict::Agrees;
        assert!(near(800.0, 6.0) && near(500.0, 1.0) && near(1250.0, 1.0));
        assert!(!near(400.0, 6.0) && !near(1600.0, 6.0) && !near(800.0, -1.0) && !near(f64::NAN, f64::NAN));
    }
}
