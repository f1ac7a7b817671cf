//! Ratios of interleaved times of two programs, with their confidence.
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
pub(super) const CUT: f64 = 1.3;

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
    /// Ratio of times \[s\], one of each program per pair; `doubt` is the probability that the interval misses the
    /// median.
    pub(crate) fn new(first: &[f64], second: &[f64], doubt: f64) -> Self {
        Self::pooled(&[(first, second)], doubt)
    }

    /// Ratio of several workloads' times \[s\]: geometric mean of their ratios, pair by pair. A change common to all of
    /// them stands out from their independent noise.
    pub(crate) fn pooled(workloads: &[(&[f64], &[f64])], doubt: f64) -> Self {
        let pairs = workloads.iter().map(|(first, _)| first.len()).min().unwrap_or(0);
        let mean = |pair: usize| {
            let sum: f64 = workloads.iter().map(|(first, second)| (second[pair] / first[pair]).ln()).sum();
            (sum / workloads.len() as f64).exp()
        };
        let mut ratios: Vec<f64> = (0..pairs).map(mean).filter(|ratio| ratio.is_finite()).collect();
        ratios.sort_by(f64::total_cmp);
        let seconds = workloads.iter().map(|(first, _)| median(&mut first.to_vec())).sum();
        let (low, high) = match rank(ratios.len(), doubt) {
            Some(k) => (ratios[k - 1], ratios[ratios.len() - k]),
            None => (0.0, f64::INFINITY),
        };
        Self { median: median(&mut ratios), low, high, pairs: ratios.len(), seconds }
    }

    /// Smallest change that these pairs could have distinguished from none: from the median to the farther end of the
    /// interval.
    pub(crate) fn resolution(&self) -> f64 {
        (self.high - self.median).max(self.median - self.low)
    }
}

/// True if this number of pairs has an interval.
pub(super) fn are_enough(pairs: usize, doubt: f64) -> bool {
    rank(pairs, doubt).is_some()
}

/// Largest k for which x_(k) ... x_(n+1-k) misses the median with a probability of at most `doubt`.
fn rank(pairs: usize, doubt: f64) -> Option<usize> {
    // P(B(n, 1/2) < k), summed from below.
    let mut term = 0.5_f64.powi(i32::try_from(pairs).ok()?);
    let mut below = 0.0;
    let mut found = None;
    for k in 1..=pairs / 2 {
        below += term;
        if 2.0 * below > doubt {
            break;
        }
        found = Some(k);
        term *= (pairs - k + 1) as f64 / k as f64;
    }
    found
}

/// Median of the values, which are sorted by this; NaN for none.
pub(super) fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => f64::NAN,
        length if length % 2 == 1 => values[middle],
        _ => 0.5 * (values[middle - 1] + values[middle]),
    }
}

/// Times of a stage \[s\], one for each run of the first and of the second program, from the times of its blocks \[ns\]
/// (runs x blocks; `None`: disturbed).
pub(super) fn stage_times(first: &[&[Option<u64>]], second: &[&[Option<u64>]]) -> (Vec<f64>, Vec<f64>) {
    let all = || first.iter().chain(second);
    let blocks = all().map(|run| run.len()).max().unwrap_or(0);
    let of = |run: &&[Option<u64>], block: usize| run.get(block).copied().flatten().map(|time| time as f64);
    // 1. Usual time of each block: the median over all runs.
    let usual: Vec<f64> = (0..blocks)
        .map(|block| {
            let mut times: Vec<f64> = all().filter_map(|run| of(run, block)).collect();
            if times.is_empty() { 0.0 } else { median(&mut times) }
        })
        .collect();
    let whole: f64 = usual.iter().sum();
    // 2. Sum of the blocks that count, each cut, scaled to all blocks.
    let seconds = |run: &&[Option<u64>]| {
        let (mut found, mut stands_for) = (0.0, 0.0);
        for (block, usual) in usual.iter().enumerate() {
            if let Some(time) = of(run, block) {
                found += time.min(CUT * usual);
                stands_for += usual;
            }
        }
        1e-9 * found * whole / stands_for
    };
    (first.iter().map(seconds).collect(), second.iter().map(seconds).collect())
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn ranks_are_those_of_the_binomial_distribution() {
        // Table A3 of the book: n = 20, P(B <= 5) = 0.0207, so that x_(6) ... x_(15) has 95.86 %.
        assert_eq!(rank(20, 0.05), Some(6));
        assert_eq!(rank(20, 0.0413), Some(5));
        assert_eq!(rank(5, 0.05), None);
        assert_eq!(rank(6, 0.05), Some(1));
        assert_eq!(rank(0, 0.05), None);
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

    fn times(rng: &mut ChaCha8Rng, factor: f64) -> (Vec<f64>, Vec<f64>) {
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for _ in 0..30 {
            let drift = 1.0 + 0.3 * rng.random::<f64>();
            let mut of = |factor: f64| {
                let own = drift * (1.0 + 0.02 * rng.random::<f64>());
                run(rng, factor, own)
            };
            first.push(of(1.0));
            second.push(of(factor));
        }
        let first: Vec<&[Option<u64>]> = first.iter().map(Vec::as_slice).collect();
        let second: Vec<&[Option<u64>]> = second.iter().map(Vec::as_slice).collect();
        stage_times(&first, &second)
    }

    fn compared(rng: &mut ChaCha8Rng, factor: f64) -> Ratio {
        let (a, b) = times(rng, factor);
        Ratio::new(&a, &b, 1e-3)
    }

    #[test]
    fn workloads_together_show_what_none_of_them_does() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for _ in 0..3 {
            let of = |factor: f64, rng: &mut ChaCha8Rng| -> Vec<_> { (0..6).map(|_| times(rng, factor)).collect() };
            let pooled = |runs: &[(Vec<f64>, Vec<f64>)]| {
                Ratio::pooled(&runs.iter().map(|(a, b)| (&a[..], &b[..])).collect::<Vec<_>>(), 1e-3)
            };
            let (slower, same) = (of(1.02, &mut rng), of(1.0, &mut rng));
            let alone: f64 = slower.iter().map(|(a, b)| Ratio::new(a, b, 1e-3).resolution()).sum();
            let (slower, same) = (pooled(&slower), pooled(&same));
            assert!(slower.resolution() < 0.7 * alone / 6.0, "{slower:?}, alone {}", alone / 6.0);
            assert!(slower.low > 1.004 && (slower.median - 1.02).abs() < 0.01, "{slower:?}");
            assert!(same.low < 1.0 && same.high > 1.0, "{same:?}");
        }
    }

    #[test]
    fn a_change_of_five_percent_is_seen_through_interruptions_and_no_change_is_none() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..5 {
            let slower = compared(&mut rng, 1.05);
            assert!(slower.low > 1.01 && (slower.median - 1.05).abs() < 0.015, "{slower:?}");
            let same = compared(&mut rng, 1.0);
            assert!(same.low < 1.0 && same.high > 1.0 && same.resolution() < 0.04, "{same:?}");
        }
    }

    #[test]
    fn few_pairs_say_nothing() {
        let ratio = Ratio::new(&[1.0; 4], &[2.0; 4], 1e-3);
        assert!(ratio.low <= 0.0 && ratio.high.is_infinite() && ratio.resolution().is_infinite());
        assert!(median(&mut []).is_nan());
    }
}
