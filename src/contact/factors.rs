//! A bounded cache of LU factors of the influence matrix of the points in contact.
//!
//! G0 depends on the distance of two elements only, so sets that are shifts of one another share a factor: the key is the pattern of the set
//! counted from its first point. A full cache drops by the clock rule: the next factor, in the order of insertion, that has not been used since the hand last
//! passed. Key hashing is seeded with constants: runs repeat exactly.

use std::collections::HashMap;
use std::collections::hash_map::DefaultHasher;
use std::hash::BuildHasherDefault;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::{factor, solve};
use faer::perm::Perm;
use faer::{Mat, MatMut, Par};

/// Exact counts of what the cache did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FactorCounts {
    /// Factorisations.
    pub factorisations: u64,
    /// Sets found.
    pub hits: u64,
    /// Sets not found.
    pub misses: u64,
    /// Factors dropped.
    pub evictions: u64,
}

/// One LU factorisation.
#[derive(Debug)]
struct Factor {
    key: Box<[u64]>,
    lu: Mat<f64>,
    permutation: Perm<usize>,
    used: bool,
}

/// The cache.
pub struct FactorCache {
    index: HashMap<Box<[u64]>, usize, BuildHasherDefault<DefaultHasher>>,
    factors: Vec<Factor>,
    capacity: usize,
    hand: usize,
    key: Vec<u64>,
    scratch: MemBuffer,
    scratch_points: usize,
    counts: FactorCounts,
}

/// A matrix turned out singular.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Singular;

impl FactorCache {
    /// A cache of at most `capacity` factors (at least one).
    pub fn new(capacity: usize) -> Self {
        Self {
            index: HashMap::default(),
            factors: Vec::new(),
            capacity: capacity.max(1),
            hand: 0,
            key: Vec::new(),
            scratch: MemBuffer::new(solve::solve_in_place_scratch::<usize, f64>(0, 1, Par::Seq)),
            scratch_points: 0,
            counts: FactorCounts::default(),
        }
    }

    /// What was done so far.
    pub fn counts(&self) -> FactorCounts {
        self.counts
    }

    /// Solves G f = d on a set of points given by increasing column numbers; `influence[j]` couples columns j apart. `values` holds d on
    /// entry and f on return, in the order of `points`.
    pub fn solve(&mut self, points: &[usize], influence: &[f64], values: &mut [f64]) -> Result<(), Singular> {
        let Some(&first) = points.first() else { return Ok(()) };
        self.key.clear();
        self.key.resize((points[points.len() - 1] - first) / 64 + 1, 0);
        for point in points {
            self.key[(point - first) / 64] |= 1 << ((point - first) % 64);
        }
        let slot = match self.index.get(self.key.as_slice()) {
            Some(&slot) => {
                self.counts.hits += 1;
                slot
            }
            None => {
                self.counts.misses += 1;
                self.factorise(points, influence)?
            }
        };
        if self.scratch_points < points.len() {
            self.scratch = MemBuffer::new(solve::solve_in_place_scratch::<usize, f64>(points.len(), 1, Par::Seq));
            self.scratch_points = points.len();
        }
        let factor = &mut self.factors[slot];
        factor.used = true;
        let rows = points.len();
        solve::solve_in_place(
            factor.lu.as_ref(),
            factor.lu.as_ref(),
            factor.permutation.as_ref(),
            MatMut::from_column_major_slice_mut(values, rows, 1),
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
        if values.iter().all(|value| value.is_finite()) { Ok(()) } else { Err(Singular) }
    }

    fn factorise(&mut self, points: &[usize], influence: &[f64]) -> Result<usize, Singular> {
        let rows = points.len();
        let mut lu = Mat::from_fn(rows, rows, |i, j| influence[points[i].abs_diff(points[j])]);
        let (mut forward, mut backward) = (vec![0_usize; rows], vec![0_usize; rows]);
        let request = factor::lu_in_place_scratch::<usize, f64>(rows, rows, Par::Seq, Default::default());
        let mut memory = MemBuffer::new(request);
        factor::lu_in_place(
            lu.as_mut(),
            &mut forward,
            &mut backward,
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        self.counts.factorisations += 1;
        // LU itself never fails: a zero pivot shows here.
        if !(0..rows).all(|i| lu[(i, i)].is_finite() && lu[(i, i)] != 0.0) {
            return Err(Singular);
        }
        let permutation = Perm::new_checked(forward.into_boxed_slice(), backward.into_boxed_slice(), rows);
        let entry = Factor { key: self.key.as_slice().into(), lu, permutation, used: true };
        let slot = if self.factors.len() < self.capacity {
            self.factors.push(entry);
            self.factors.len() - 1
        } else {
            while std::mem::take(&mut self.factors[self.hand].used) {
                self.hand = (self.hand + 1) % self.capacity;
            }
            let slot = self.hand;
            self.hand = (self.hand + 1) % self.capacity;
            self.index.remove(&self.factors[slot].key);
            self.factors[slot] = entry;
            self.counts.evictions += 1;
            slot
        };
        self.index.insert(self.key.as_slice().into(), slot);
        Ok(slot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn influence(distance: usize) -> f64 {
        1.0 / (1.0 + distance as f64).powi(2)
    }

    #[test]
    fn solves_and_reuses_shifted_sets() {
        let row: Vec<f64> = (0..200).map(influence).collect();
        let mut cache = FactorCache::new(4);
        let points = [3_usize, 4, 7, 80, 81];
        let wanted = [1.0, -2.0, 0.5, 3.0, 1.5];
        for shift in [0, 11] {
            let points = points.map(|point| point + shift);
            let mut values: Vec<f64> = points
                .iter()
                .map(|&i| points.iter().zip(&wanted).map(|(&j, f)| influence(i.abs_diff(j)) * f).sum())
                .collect();
            cache.solve(&points, &row, &mut values).unwrap();
            for (value, exact) in values.iter().zip(&wanted) {
                assert!((value - exact).abs() < 1e-12);
            }
        }
        assert_eq!(cache.counts(), FactorCounts { factorisations: 1, hits: 1, misses: 1, evictions: 0 });
    }

    #[test]
    fn a_full_cache_drops_what_has_not_been_used_and_stays_right() {
        let row: Vec<f64> = (0..200).map(influence).collect();
        let mut cache = FactorCache::new(3);
        for round in 0..4 {
            for gap in 1..6 {
                let points = [0, gap];
                let mut values = [1.0, 1.0];
                cache.solve(&points, &row, &mut values).unwrap();
                assert!((values[0] - 1.0 / (1.0 + influence(gap))).abs() < 1e-14, "round {round}");
            }
        }
        assert!(cache.factors.len() == 3 && cache.index.len() == 3);
        assert_eq!(cache.counts().evictions, cache.counts().misses - 3);
    }

    #[test]
    fn a_singular_matrix_is_reported() {
        assert_eq!(FactorCache::new(2).solve(&[0, 1], &[1.0, 1.0], &mut [1.0, 2.0]), Err(Singular));
    }
}
