//! Share of the influence functions in the computing time: by sums, and by poles.
//!
//! Sums of two kinds: as in the paper, without aliases and with lateral waves as short as the shortest around the tyre;
//! and to the accuracy of the poles. H_n(s) for n = 0..=N/2 at all points of the contour of a memory as long as the
//! scene's are far too many: a sample of them, evenly spread over both, is summed and timed, and extrapolated.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use crate::numeric::in_parallel;
use crate::plan::Plan;
use crate::plan::models::{fetch, refused};
use crate::run::RunError;
use crate::scene::{LoadedScene, Scene, TimeRule};
use crate::tyre::influence::convolution_quadrature::Contour;
use crate::tyre::influence::{Field, InfluenceSum, Projection, SumAt, Truncation};
use crate::tyre::poles::scaling::{FitCost, cost};
use num_complex::Complex64;
use serde::Serialize;

use super::statement::{Statement, Verdict};

/// Shares in this range are too close to a half for one measurement of the time.
const ABOUT_HALF: [f64; 2] = [0.4, 0.6];
/// Fractional part of the golden ratio: its multiples modulo 1 are spread evenly.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Time of the influence functions, beside that of a run.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct InfluenceShare {
    /// Number of values H_n(s) in all.
    pub values: f64,
    /// Number of values that were summed.
    pub sampled: usize,
    /// Summed as the paper does.
    pub plain: Sums,
    /// Summed to the accuracy of the poles.
    pub exact: Sums,
    /// The fit of poles that replaces the sums.
    pub fit: FitCost,
    /// Time of reading the poles from the user's cache, as every later run does \[s\].
    pub kept: f64,
    /// Wall time of rolling the scene from start to end \[s\], extrapolated.
    pub march: f64,
    /// Simulated time of that \[s\].
    pub rolled: f64,
}

/// Cost of all sums of a kind, extrapolated from a sample.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Sums {
    /// Evaluations of the compliance.
    pub evaluations: f64,
    /// Time on all threads \[s\].
    pub seconds: f64,
}

impl Sums {
    /// Sums a sample of (n, s); all values are `times` as many.
    fn of(sum: &InfluenceSum, sample: &[(usize, Complex64)], times: f64) -> Self {
        // The moduli at an s serve all n: their time is not measured.
        let at: Vec<SumAt> = sum.at_all(&sample.iter().map(|(_, s)| *s).collect::<Vec<_>>());
        let begin = Instant::now();
        let of = |index: usize| sum.value(sample[index].0, &at[index], Field::Surface).evaluations;
        let evaluations: u64 = in_parallel::made(sample.len(), of).iter().sum();
        Self { evaluations: times * evaluations as f64, seconds: times * begin.elapsed().as_secs_f64() }
    }
}

impl InfluenceShare {
    /// Measures the shares of a scene that is rolled for `rolled` \[s\], each second of it taking `march` \[s\];
    /// `samples` of the sums are timed.
    ///
    /// # Errors
    /// A fit that was refused, or stopped by `stop`.
    pub(super) fn of(
        scene: &Scene,
        (rolled, march): (f64, f64),
        samples: usize,
        stop: &AtomicBool,
    ) -> Result<Self, RunError> {
        let loaded = LoadedScene::from_scene(scene, "paper")?;
        let plan = Plan::new(scene);
        let tyre = &plan.decisions.tyre;
        let fit = cost(tyre, &plan.fit, stop).map_err(|error| refused(&loaded, error, "another tolerance"))?;
        let begin = Instant::now();
        fetch(tyre, &plan.fit, stop).map_err(|error| refused(&loaded, error, "another tolerance"))?;
        let kept = begin.elapsed().as_secs_f64();
        // As in the paper, the weights are those of a multistep rule.
        let contour = Contour::new(TimeRule::Bdf2, plan.time_step, (scene.numerics.memory / plan.time_step) as usize);
        let projection = Projection::new(tyre, scene.numerics.elements);
        let largest = contour.points.iter().fold(0.0_f64, |largest, s| largest.max(s.norm()));
        let sum = |truncation| {
            InfluenceSum::with(tyre, projection.clone(), truncation, scene.numerics.pole_tolerance, largest)
        };
        let shortest = projection.waves.kx((scene.numerics.elements / 2) as i64);
        let lateral = projection.waves.lateral_numbers().take_while(|&m| projection.waves.ky(m) <= shortest).count();
        let plain = Truncation::Fixed { lateral_terms: Some(lateral.max(1)), aliases: Some(0) };
        let rows = scene.numerics.elements / 2 + 1;
        let chosen: Vec<(usize, Complex64)> = (0..samples)
            .map(|sample| {
                let part = (sample as f64 + 0.5) / samples as f64;
                let row = (GOLDEN * sample as f64).fract() * rows as f64;
                (row as usize, contour.points[(part * contour.points.len() as f64) as usize])
            })
            .collect();
        let values = rows as f64 * contour.points.len() as f64;
        let all = values / samples as f64;
        Ok(Self {
            values,
            sampled: samples,
            plain: Sums::of(&sum(plain), &chosen, all),
            exact: Sums::of(&sum(Truncation::Bounded), &chosen, all),
            kept,
            fit,
            march: march * rolled,
            rolled,
        })
    }

    /// Shares of the influence functions in the total time: by plain sums, and by poles that have to be fitted.
    pub(super) fn shares(&self) -> [f64; 2] {
        [self.plain.seconds, self.fit.seconds].map(|influence| influence / (influence + self.march))
    }

    pub(super) fn statements(&self) -> [Statement; 2] {
        let [sums, poles] = self.shares();
        let paper = "they are the most time-consuming step";
        let [low, high] = ABOUT_HALF.map(|share| 100.0 * share);
        [
            Statement {
                place: "performance",
                subject: "influence functions by sums",
                paper,
                found: format!(
                    "{:.0} % of the time: {:.1e} evaluations, {:.0} s beside {:.1} s of rolling, extrapolated; to the \
                     accuracy of the poles {:.1e}, {:.0} s",
                    100.0 * sums,
                    self.plain.evaluations,
                    self.plain.seconds,
                    self.march,
                    self.exact.evaluations,
                    self.exact.seconds
                ),
                verdict: takes_most(sums),
                why: format!(
                    "more than {high:.0} % of the time; {:.1} s rolled; {} of {:.1e} sums timed",
                    self.rolled, self.sampled, self.values
                ),
            },
            Statement {
                place: "performance",
                subject: "influence functions by poles",
                paper,
                found: format!(
                    "{:.0} % of the first run's time: {:.1e} evaluations, {:.1} s; {:.1} % of later ones', {:.0} ms",
                    100.0 * poles,
                    self.fit.evaluations as f64,
                    self.fit.seconds,
                    100.0 * self.kept / (self.kept + self.march),
                    1e3 * self.kept
                ),
                verdict: takes_most(poles),
                why: format!(
                    "more than {high:.0} % of the first run's time; {low:.0} to {high:.0} % cannot be told from half"
                ),
            },
        ]
    }
}

fn takes_most(share: f64) -> Verdict {
    if (ABOUT_HALF[0]..=ABOUT_HALF[1]).contains(&share) { Verdict::NotComparable } else { Verdict::of(share > 0.5) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_of_the_whole_time() {
        let fit = FitCost { elements: 512, layers: 2, evaluations: 1000, order: 100, seconds: 1.0 };
        let sums = |seconds| Sums { evaluations: 1e8, seconds };
        let (plain, exact) = (sums(27.0), sums(1000.0));
        let share =
            InfluenceShare { values: 1e6, sampled: 10, plain, exact, fit, kept: 0.03, march: 3.0, rolled: 18.5 };
        assert!((share.shares()[0] - 0.9).abs() < 1e-12 && (share.shares()[1] - 0.25).abs() < 1e-12);
        let [sums, poles] = share.statements();
        assert_eq!([sums.verdict, poles.verdict], [Verdict::Agrees, Verdict::Disagrees]);
        assert!(sums.found.starts_with("90 %") && poles.found.contains("1.0 % of later"), "{sums:?} {poles:?}");
        assert_eq!(takes_most(0.5), Verdict::NotComparable);
    }
}
