//! What influence functions take of the time: summed without shortcuts, as the paper does, and by poles.
//!
//! The sums Ht_n(s) for n = 0..=N/2 at all points of the contour of a memory as long as the scene's are far too many to
//! wait for: a sample of them is summed and timed, evenly spread over both, and stands for all.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use num_complex::Complex64;
use rayon::prelude::*;
use serde::Serialize;

use super::statement::{Statement, Verdict};
use crate::plan::Plan;
use crate::run::error::RunError;
use crate::run::past::refused;
use crate::scene::{LoadedScene, Scene, TimeRule};
use crate::tyre::influence::convolution_quadrature::Contour;
use crate::tyre::influence::{Field, InfluenceSum, Projection, SumAt, Truncation};
use crate::tyre::poles::scaling::{FitCost, cost};

/// The golden ratio's part beyond 1: its multiples are spread evenly over 0 to 1.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// What influence functions take, beside a run.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct InfluenceShare {
    /// Values Ht_n(s) that there are.
    pub values: f64,
    /// Those of them that were summed.
    pub sampled: usize,
    /// Evaluations of the compliance for all of them, extrapolated.
    pub evaluations: f64,
    /// Time for all of them on all threads \[s\], extrapolated.
    pub sums: f64,
    /// The fit of poles that takes their place.
    pub fit: FitCost,
    /// Time of rolling the scene from its start to its end \[s\], extrapolated.
    pub march: f64,
    /// Time that is rolled then \[s\].
    pub rolled: f64,
}

impl InfluenceShare {
    /// For a scene that is rolled for so long \[s\], each second of it taking so much time \[s\]; so many of the sums
    /// are timed.
    ///
    /// # Errors
    /// A fit that was refused, or stopped by `stop`.
    pub fn of(scene: &Scene, (rolled, march): (f64, f64), samples: usize, stop: &AtomicBool) -> Result<Self, RunError> {
        let loaded = LoadedScene::from_scene(scene, "paper")?;
        let plan = Plan::new(scene);
        let tyre = &plan.decisions.tyre;
        let fit = cost(tyre, &plan.fit, stop).map_err(|error| refused(&loaded, error, "another tolerance"))?;
        // As exact as the poles, and no better; as the paper's, the weights are of a multistep rule.
        let contour = Contour::new(TimeRule::Bdf2, plan.time_step, (scene.numerics.memory / plan.time_step) as usize);
        let projection = Projection::new(tyre, scene.numerics.elements);
        let largest = contour.points.iter().fold(0.0_f64, |largest, s| largest.max(s.norm()));
        let tolerance = scene.numerics.pole_tolerance;
        let sum = InfluenceSum::with(tyre, projection, Truncation::Bounded, tolerance, largest);
        let rows = scene.numerics.elements / 2 + 1;
        let chosen: Vec<(usize, Complex64)> = (0..samples)
            .map(|sample| {
                let part = (sample as f64 + 0.5) / samples as f64;
                let row = (GOLDEN * sample as f64).fract() * rows as f64;
                (row as usize, contour.points[(part * contour.points.len() as f64) as usize])
            })
            .collect();
        // Moduli at an s serve all n: they are not what is timed.
        let at: Vec<SumAt> = sum.at_all(&chosen.iter().map(|(_, s)| *s).collect::<Vec<_>>());
        let begin = Instant::now();
        let evaluations: u64 =
            chosen.par_iter().zip(&at).map(|((n, _), at)| sum.value(*n, at, Field::Surface).evaluations).sum();
        let seconds = begin.elapsed().as_secs_f64();
        let values = rows as f64 * contour.points.len() as f64;
        let all = values / samples as f64;
        Ok(Self {
            values,
            sampled: samples,
            evaluations: all * evaluations as f64,
            sums: all * seconds,
            fit,
            march: march * rolled,
            rolled,
        })
    }

    /// Shares of the time by sums and by poles.
    pub fn shares(&self) -> [f64; 2] {
        [self.sums, self.fit.seconds].map(|influence| influence / (influence + self.march))
    }

    /// What the paper says of it.
    pub fn statements(&self) -> [Statement; 2] {
        let [sums, poles] = self.shares();
        let paper = "they are the most time-consuming step";
        let why = format!("most of the time is more than half of it; {:.1} s rolled beside it", self.rolled);
        [
            Statement {
                place: "performance",
                subject: "influence functions by sums without shortcuts",
                paper,
                found: format!(
                    "{:.1} % of the time: {:.3e} evaluations, {:.0} s beside {:.1} s of rolling; extrapolated from {} \
                     of {:.3e} sums",
                    100.0 * sums,
                    self.evaluations,
                    self.sums,
                    self.march,
                    self.sampled,
                    self.values
                ),
                verdict: takes_most(sums),
                why: why.clone(),
            },
            Statement {
                place: "performance",
                subject: "influence functions by poles",
                paper,
                found: format!(
                    "{:.1} % of the time: {:.3e} evaluations, {} poles, {:.1} s beside {:.1} s of rolling; {:.0} \
                     times as fast as the sums",
                    100.0 * poles,
                    self.fit.evaluations as f64,
                    self.fit.order,
                    self.fit.seconds,
                    self.march,
                    self.sums / self.fit.seconds
                ),
                verdict: takes_most(poles),
                why,
            },
        ]
    }
}

fn takes_most(share: f64) -> Verdict {
    Verdict::of(share > 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_of_the_whole_time() {
        let fit = FitCost { elements: 512, layers: 2, evaluations: 1000, order: 100, seconds: 1.0 };
        let share =
            InfluenceShare { values: 1e6, sampled: 10, evaluations: 1e8, sums: 27.0, fit, march: 3.0, rolled: 18.5 };
        assert!((share.shares()[0] - 0.9).abs() < 1e-12 && (share.shares()[1] - 0.25).abs() < 1e-12);
        let [sums, poles] = share.statements();
        assert_eq!([sums.verdict, poles.verdict], [Verdict::Agrees, Verdict::Disagrees]);
        assert!(sums.found.starts_with("90.0 %") && poles.found.contains("27 times"), "{} {}", sums.found, poles.found);
    }
}
