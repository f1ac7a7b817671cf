//! Ratios of paired times of two programs, with their confidence.
//!
//! 1. A stage's time in a run is the sum over its blocks, each cut at [`CUT`] times its usual time, the median of the
//!    same block over all runs of both programs. Blocks that other processes disturbed are left out and represented by
//!    the others: the sum is scaled by the usual times of all blocks over those of the blocks that count.
//! 2. Consecutive runs of both programs are a pair; slower drifts cancel in their ratio.
//! 3. The median of the ratios has an interval of order statistics: x_(k) ... x_(n+1-k) holds it with probability 1 - 2
//!    P(B(n, 1/2) < k), whatever the distribution (W. J. Conover, *Practical Nonparametric Statistics*, section 3.2).
//!    The only assumption is that pairs are independent.

use serde::Serialize;

/// Blocks longer than this many medians count as disturbed.
const CUT: f64 = 1.3;
/// Probability that an interval misses its median.
const MISS_PROBABILITY: f64 = 1e-3;

/// A ratio of times with its confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Ratio {
    /// Median of the pairs' ratios, second program over first.
    pub median: f64,
    /// Lower end of the interval; 0 for too few pairs.
    pub low: f64,
    /// Upper end of the interval; infinite for too few pairs.
    pub high: f64,
    /// Number of pairs.
    pub pairs: usize,
    /// Median time of the first program \[s\].
    pub seconds: f64,
}

impl Ratio {
    /// Ratio of times \[s\], one of each program per pair.
    pub(super) fn new([first, second]: &[Vec<f64>; 2]) -> Self {
        let mut ratios: Vec<f64> = first.iter().zip(second).map(|(a, b)| b / a).filter(|x| x.is_finite()).collect();
        ratios.sort_by(f64::total_cmp);
        let pairs = ratios.len();
        let (low, high) = match rank(pairs) {
            0 => (0.0, f64::INFINITY),
            k => (ratios[k - 1], ratios[pairs - k]),
        };
        Self { median: median(ratios), low, high, pairs, seconds: median(first.clone()) }
    }
}

/// Largest k for which x_(k) ... x_(n+1-k) misses the median of n pairs with a probability of at most
/// [`MISS_PROBABILITY`]; 0 if none does.
fn rank(pairs: usize) -> usize {
    // P(B(n, 1/2) < k), summed from below.
    let (mut term, mut below, mut k) = (0.5_f64.powf(pairs as f64), 0.0, 0);
    loop {
        below += term;
        if 2.0 * below > MISS_PROBABILITY {
            return k;
        }
        term *= (pairs - k) as f64 / (k + 1) as f64;
        k += 1;
    }
}

/// Median; NaN for no values.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        length => 0.5 * (values[(length - 1) / 2] + values[length / 2]),
    }
}

/// Times of a stage \[s\], one for each run of the first and of the second program, from the times of its blocks \[ns\]
/// (runs x blocks; `None`: disturbed).
pub(super) fn stage_times(runs: [Vec<&[Option<u64>]>; 2]) -> [Vec<f64>; 2] {
    let blocks = runs.iter().flatten().map(|run| run.len()).min().unwrap_or(0);
    // 1. Usual time of each block: the median over all runs.
    let times = |block: usize| runs.iter().flatten().filter_map(move |run| run[block]).map(|time| time as f64);
    let usual: Vec<f64> = (0..blocks).map(|block| median(times(block).collect()).max(0.0)).collect();
    // 2. Sum of the blocks that count, each cut, scaled to all blocks.
    let seconds = |run: &&[Option<u64>]| {
        let known = || run.iter().zip(&usual).filter_map(|(time, usual)| Some(((*time)? as f64, usual)));
        let found: f64 = known().map(|(time, usual)| time.min(CUT * usual)).sum();
        1e-9 * found * usual.iter().sum::<f64>() / known().map(|(_, usual)| usual).sum::<f64>()
    };
    runs.each_ref().map(|runs| runs.iter().map(seconds).collect())
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn ranks_are_those_of_the_binomial_distribution() {
        // 2^-9 for n = 10, 2^-10 for n = 11; 2 (1 + 20 + 190)/2^20 = 4.0e-4 for n = 20 and k = 3, 2.6e-3 for k = 4.
        assert_eq!([0, 10, 11, 20].map(rank), [0, 0, 1, 3]);
        // The normal distribution's n/2 - 3.29 sqrt(n)/2 for many.
        assert!(rank(1000).abs_diff(448) <= 1, "{}", rank(1000));
    }

    /// A run of 100 blocks that takes about `factor`, drifts as a whole, and is interrupted now and then for much
    /// longer than a block.
    fn run(rng: &mut ChaCha8Rng, factor: f64, drift: f64) -> Vec<Option<u64>> {
        (0..100)
            .map(|block| {
                let usual = 1e6 * (1.0 + f64::from(block % 7)) * factor * drift;
                let interrupted = if rng.random::<f64>() < 0.1 { 4e6 } else { 0.0 };
                let known = rng.random::<f64>() < 0.2;
                (!known).then_some((usual * (1.0 + 0.05 * rng.random::<f64>()) + interrupted) as u64)
            })
            .collect()
    }

    fn compared(rng: &mut ChaCha8Rng, factor: f64) -> Ratio {
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for _ in 0..30 {
            let drift = 1.0 + 0.3 * rng.random::<f64>();
            let mut of = |factor: f64| {
                let pace = drift * (1.0 + 0.02 * rng.random::<f64>());
                run(rng, factor, pace)
            };
            first.push(of(1.0));
            second.push(of(factor));
        }
        Ratio::new(&stage_times([&first, &second].map(|runs| runs.iter().map(Vec::as_slice).collect())))
    }

    #[test]
    fn five_percent_are_seen_through_interruptions() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..5 {
            let slower = compared(&mut rng, 1.05);
            assert!(slower.low > 1.01 && (slower.median - 1.05).abs() < 0.015, "{slower:?}");
            let same = compared(&mut rng, 1.0);
            assert!(same.low < 1.0 && same.high > 1.0 && same.high - same.low < 0.08, "{same:?}");
        }
    }

    #[test]
    fn few_pairs_say_nothing() {
        let ratio = Ratio::new(&[vec![1.0; 4], vec![2.0; 4]]);
        assert!(ratio.low <= 0.0 && ratio.high.is_infinite() && (ratio.median - 2.0).abs() < 1e-15);
        assert!(Ratio::new(&[vec![], vec![]]).median.is_nan());
    }
}
