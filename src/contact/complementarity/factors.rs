//! A bounded cache of LU factors of the influence matrix of the points in contact.
//!
//! G0 is symmetric and positive definite, so its LU factors need no exchange of rows and are L and D L^T: half of the
//! G0 is symmetric and positive definite, so its LU factors need no exchange of rows and are L and D L^T: half of the
//! work and half of the memory of a general LU. Measured (bench `linear_solvers`) against LU with row exchanges: 1.5
//! to
//!
//! G0 depends on the distance of two elements only, so sets that are shifts of one another share a factor: the key is
//! the pattern of the set counted from its first point. A full cache drops by the clock rule: the next factor, in the
//! order of insertion, that has not been used since the hand last passed.
//!
//! A set that is not found and differs by few points from the one last solved with its own factor is solved by means
//! of that factor (`neighbour_set`).
//!
//! All memory is taken at the start: neither a hit nor a miss allocates. Factors and right-hand sides stand on fixed
//! alignments, so a factor found and the same one made again solve to the same bits; the method that serves a set
//! changes its forces by rounding.

use serde::{Deserialize, Serialize};

use super::ldlt::{Ldlt, Singular, finite};
use super::neighbour_set::{MOST_DIFFERENT, NeighbourSet};
use super::pattern_index::PatternIndex;
use super::tiles::{LINE, packed_length};
use crate::counters::{Meter, Stage, Work};
use crate::numeric::Aligned;
use crate::storage::state::{StateError, StateStream, StateValue, ensure};

/// Largest memory of the factors \[bytes\]: as many as fit are cached, however many were asked for.
const LARGEST_MEMORY: usize = 256 << 20;

/// Exact counts of the events in the cache.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct FactorCounts {
    /// Factorisations.
    pub factorisations: u64,
    /// Factorisations of a band of the matrix in place of the whole.
    pub bands: u64,
    /// Bands whose corrections did not converge fast enough: the whole matrix was factorised, too.
    pub refactorisations: u64,
    /// Sets found.
    pub hits: u64,
    /// Sets not found.
    pub misses: u64,
    /// Sets not found that the factor of a neighbour served: no factorisation.
    pub neighbours: u64,
    /// Factors dropped.
    pub evictions: u64,
}

/// Sizes of a cache.
#[derive(Clone, Copy, Debug)]
struct Sizes {
    /// Points of the largest set.
    points: usize,
    /// Numbers from one column of a factor to the next.
    stride: usize,
    /// Factors.
    slots: usize,
}

impl Sizes {
    fn new(capacity: usize, points: usize) -> Self {
        let points = points.max(1);
        let stride = points.next_multiple_of(LINE);
        let slots = capacity.min(LARGEST_MEMORY / stride.saturating_mul(8 * points)).max(1);
        Self { points, stride, slots }
    }
}

/// Most unknowns of the system of the points by which a set differs from its neighbour, in whole lines.
const SMALL: usize = MOST_DIFFERENT.next_multiple_of(LINE);

/// Largest memory of a cache of `capacity` factors of sets of up to `points` points \[bytes\].
pub(crate) fn largest_memory(capacity: usize, points: usize) -> usize {
    let Sizes { points, stride, slots } = Sizes::new(capacity, points);
    (8 * slots * points).saturating_mul(stride)
}

/// The cache.
pub struct FactorCache {
    sizes: Sizes,
    index: PatternIndex,
    factors: Aligned,
    /// True if a factor was used since the hand passed.
    used: Vec<bool>,
    filled: usize,
    hand: usize,
    pattern: Vec<u64>,
    /// Right-hand sides, one to a stride.
    values: Aligned,
    /// The right side of the system of the points by which a set differs from its neighbour, and its matrix.
    small: Aligned,
    neighbour: NeighbourSet,
    /// The slot that served the last set; true: as that of its neighbour.
    last: (usize, bool),
    solver: Ldlt,
    counts: FactorCounts,
    work: Work,
    /// The part of the work that made factors.
    making: Work,
}

impl FactorCache {
    /// Cache of at most `capacity` factors (at least one; fewer where they would take too much memory) of sets of at
    /// most `points` points.
    pub fn new(capacity: usize, points: usize) -> Self {
        let sizes = Sizes::new(capacity, points);
        let Sizes { points, stride, slots } = sizes;
        let words = points.div_ceil(64);
        Self {
            sizes,
            index: PatternIndex::new(slots, words),
            factors: Aligned::new(slots * stride * points),
            used: vec![false; slots],
            filled: 0,
            hand: 0,
            pattern: vec![0; words],
            values: Aligned::new(stride * (1 + MOST_DIFFERENT)),
            small: Aligned::new(SMALL + packed_length(MOST_DIFFERENT)),
            neighbour: NeighbourSet::new(points),
            last: (0, false),
            solver: Ldlt::new(points.max(MOST_DIFFERENT)),
            counts: FactorCounts::default(),
            work: Work::default(),
            making: Work::default(),
        }
    }

    /// Counts so far.
    pub fn counts(&self) -> FactorCounts {
        self.counts
    }

    /// Solves G f = d on a set of points given by increasing column numbers; `influence[j]` couples columns j apart.
    /// `values` holds d on entry and f on return, in the order of `points`.
    pub fn solve(
        &mut self,
        points: &[usize],
        influence: &[f64],
        values: &mut [f64],
        meter: &mut Meter,
    ) -> Result<(), Singular> {
        let Some(&first) = points.first() else { return Ok(()) };
        self.pattern.fill(0);
        for point in points {
            self.pattern[(point - first) / 64] |= 1 << ((point - first) % 64);
        }
        let slot = match self.index.find(&self.pattern) {
            Some(slot) => {
                self.counts.hits += 1;
                slot
            }
            None => {
                self.counts.misses += 1;
                if let Some(slot) = self.neighbour.serves(points) {
                    self.counts.neighbours += 1;
                    self.last = (slot, true);
                    return self.solve_beside(slot, points, influence, values);
                }
                let slot = self.free_slot();
                self.factorise(slot, points, influence, meter)?;
                self.index.insert(slot, &self.pattern);
                slot
            }
        };
        self.neighbour.keep(slot, points);
        self.last = (slot, false);
        self.solve_one(slot, values)
    }

    /// Solves for another d on the points of the last solution, with the factor that served there.
    pub fn solve_again(&mut self, points: &[usize], influence: &[f64], values: &mut [f64]) -> Result<(), Singular> {
        match self.last {
            (slot, false) => self.solve_one(slot, values),
            (slot, true) => self.solve_beside_again(slot, points, influence, values),
        }
    }

    /// Solves with the factor of the set itself.
    fn solve_one(&mut self, slot: usize, values: &mut [f64]) -> Result<(), Singular> {
        self.values.part(0, values.len()).copy_from_slice(values);
        self.solve_stored(slot, values.len(), 1)?;
        values.copy_from_slice(self.values.part(0, values.len()));
        Ok(())
    }

    /// Solves for the right-hand sides in `self.values`, one to a stride, with a stored factor.
    fn solve_stored(&mut self, slot: usize, rows: usize, columns: usize) -> Result<(), Singular> {
        self.used[slot] = true;
        let entries = (rows * rows * columns) as u64;
        self.work += Work { multiply_adds: entries, bytes: 8 * (rows * rows) as u64 };
        let Sizes { points: most, stride, .. } = self.sizes;
        let factor = self.factors.part(slot * stride * most, packed_length(rows));
        self.solver.solve(factor, self.values.part(0, stride * columns), stride, rows)
    }

    fn solve_beside(
        &mut self,
        slot: usize,
        points: &[usize],
        influence: &[f64],
        values: &mut [f64],
    ) -> Result<(), Singular> {
        let (size, stride) = (self.neighbour.different(), self.sizes.stride);
        let columns = 1 + size;
        self.neighbour.right_sides(points, influence, values, stride, self.values.part(0, stride * columns));
        self.solve_stored(slot, self.neighbour.stored_points(), columns)?;
        let z = (&*self.values.part(0, stride * columns), stride);
        let (right, matrix) = self.small.part(0, SMALL + packed_length(size)).split_at_mut(SMALL);
        self.neighbour.system(points, influence, values, z, matrix, right);
        self.solver.factorise(matrix, size)?;
        self.solver.solve(matrix, right, SMALL, size)?;
        self.neighbour.forces(z, right, values);
        // Right-hand sides, the rows of the system and the forces.
        let sums = (points.len() * (size + size * size + size)) as u64;
        self.work += Work { multiply_adds: sums, bytes: 8 * sums };
        finite(values.iter())
    }

    /// As [`Self::solve_beside`] for another d: all columns but the first, and the factors of their system, are those
    /// of the last solution.
    fn solve_beside_again(
        &mut self,
        slot: usize,
        points: &[usize],
        influence: &[f64],
        values: &mut [f64],
    ) -> Result<(), Singular> {
        let (size, stride) = (self.neighbour.different(), self.sizes.stride);
        self.neighbour.right_side(values, self.values.part(0, stride));
        self.solve_stored(slot, self.neighbour.stored_points(), 1)?;
        let z = (&*self.values.part(0, stride * (1 + size)), stride);
        let (right, matrix) = self.small.part(0, SMALL + packed_length(size)).split_at_mut(SMALL);
        self.neighbour.system_right(points, influence, values, z, right);
        self.solver.solve(matrix, right, SMALL, size)?;
        self.neighbour.forces(z, right, values);
        // The right side of the system and the forces.
        let sums = (2 * points.len() * size) as u64;
        self.work += Work { multiply_adds: sums, bytes: 8 * sums };
        finite(values.iter())
    }

    /// Moves on by `by` elements: column i becomes column i - `by`.
    pub fn advance(&mut self, by: usize) {
        self.neighbour.advance(by);
    }

    /// Work of factorisations and solutions so far.
    pub fn work(&self) -> Work {
        self.work
    }

    /// The part of [`Self::work`] that made factors of sets.
    pub fn making(&self) -> Work {
        self.making
    }

    /// Slot for a new factor; where none is empty, the one that the clock rule drops.
    fn free_slot(&mut self) -> usize {
        if self.filled < self.sizes.slots {
            self.filled += 1;
            return self.filled - 1;
        }
        while std::mem::take(&mut self.used[self.hand]) {
            self.hand = (self.hand + 1) % self.sizes.slots;
        }
        let slot = self.hand;
        self.hand = (self.hand + 1) % self.sizes.slots;
        self.index.remove(slot);
        self.counts.evictions += 1;
        slot
    }

    fn factorise(
        &mut self,
        slot: usize,
        points: &[usize],
        influence: &[f64],
        meter: &mut Meter,
    ) -> Result<(), Singular> {
        let mut laps = meter.laps();
        let rows = points.len();
        let Sizes { points: most, stride, .. } = self.sizes;
        let factor = self.factors.part(slot * stride * most, packed_length(rows));
        self.solver.assemble(points, influence, factor);
        let done = self.solver.factorise(factor, rows);
        self.counts.factorisations += 1;
        let entries = (rows * rows) as u64;
        let work = Work { multiply_adds: entries * rows as u64 / 6, bytes: 8 * entries };
        self.work += work;
        self.making += work;
        meter.lap(&mut laps, Stage::Factorisation);
        done
    }

    /// Saves which sets are held, not their factors, which are made again for the same influence; restores counts, too.
    /// Cost: one factorisation for each set held.
    pub(super) fn state(&mut self, influence: &[f64], state: &mut StateStream<'_>) -> Result<(), StateError> {
        let held = self.filled;
        state.all([&mut self.filled, &mut self.hand, &mut self.neighbour])?;
        let (filled, slots) = (self.filled, self.sizes.slots);
        ensure(filled <= slots && self.hand < slots && self.neighbour.slot.is_none_or(|slot| slot < filled))?;
        ensure(!state.is_restoring() || held == 0)?;
        let mut points = Vec::with_capacity(self.sizes.points);
        // They were counted when they were made first.
        let mut meter = Meter::default();
        for slot in 0..filled {
            if slot < held {
                self.pattern.copy_from_slice(self.index.pattern(slot));
            }
            state.all([&mut self.used[slot], &mut self.pattern])?;
            if slot < held {
                continue;
            }
            points.clear();
            let bits = self.pattern.iter().flat_map(|word| (0..64).map(move |bit| word >> bit & 1 == 1));
            points.extend(bits.enumerate().filter_map(|(point, is_in)| is_in.then_some(point)));
            let fits = points.last().is_some_and(|&last| last < self.sizes.points);
            ensure(fits && self.index.find(&self.pattern).is_none())?;
            ensure(self.neighbour.slot != Some(slot) || self.neighbour.stored_points() == points.len())?;
            self.factorise(slot, &points, influence, &mut meter).map_err(|Singular| StateError::Value)?;
            self.index.insert(slot, &self.pattern);
        }
        state.all([
            &mut StateValue(&mut self.counts),
            &mut StateValue(&mut self.work),
            &mut StateValue(&mut self.making),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::state::{Evolving, SavedState};

    /// A cache with the influence that its factors are made for.
    struct Made<'a>(FactorCache, &'a [f64]);

    impl Evolving for Made<'_> {
        fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
            self.0.state(self.1, state)
        }
    }

    fn influence(distance: usize) -> f64 {
        1.0 / (1.0 + distance as f64).powi(2)
    }

    #[test]
    fn solves_and_reuses_shifted_sets() {
        let row: Vec<f64> = (0..200).map(influence).collect();
        let mut cache = FactorCache::new(4, 100);
        let points = [3_usize, 4, 7, 80, 81];
        let wanted = [1.0, -2.0, 0.5, 3.0, 1.5];
        for shift in [0, 11] {
            let points = points.map(|point| point + shift);
            let mut values: Vec<f64> = points
                .iter()
                .map(|&i| points.iter().zip(&wanted).map(|(&j, f)| influence(i.abs_diff(j)) * f).sum())
                .collect();
            cache.solve(&points, &row, &mut values, &mut Meter::default()).unwrap();
            for (value, exact) in values.iter().zip(&wanted) {
                assert!((value - exact).abs() < 1e-12);
            }
        }
        assert_eq!(cache.counts(), FactorCounts { factorisations: 1, hits: 1, misses: 1, ..FactorCounts::default() });
    }

    #[test]
    fn a_full_cache_drops_what_has_not_been_used_and_stays_right() {
        let row: Vec<f64> = (0..200).map(influence).collect();
        let mut cache = FactorCache::new(3, 8);
        for round in 0..4 {
            for gap in 1..6 {
                let points = [0, gap];
                let mut values = [1.0, 1.0];
                cache.solve(&points, &row, &mut values, &mut Meter::default()).unwrap();
                assert!((values[0] - 1.0 / (1.0 + influence(gap))).abs() < 1e-14, "round {round}");
            }
        }
        assert_eq!(cache.filled, 3);
        assert_eq!(cache.counts().evictions, cache.counts().misses - 3);
    }

    #[test]
    fn a_singular_matrix_is_reported() {
        assert_eq!(
            FactorCache::new(2, 2).solve(&[0, 1], &[1.0, 1.0], &mut [1.0, 2.0], &mut Meter::default()),
            Err(Singular)
        );
    }

    #[test]
    fn a_restored_cache_gives_the_same_bits_and_drops_alike() {
        let row: Vec<f64> = (0..100).map(influence).collect();
        let round = |cache: &mut FactorCache, round: usize| {
            let points: Vec<usize> =
                (0..30 + round % 5).filter(|point| point % 3 > 0 || point % (2 + round % 7) == 0).collect();
            let mut values: Vec<f64> = points.iter().map(|&point| (point as f64).sin()).collect();
            cache.solve(&points, &row, &mut values, &mut Meter::default()).unwrap();
            values.iter().map(|value| value.to_bits()).collect::<Vec<_>>()
        };
        // 23 sets, in an order that meets some again soon and others late.
        let mixed = |number: usize| number.pow(3) % 23;
        let mut whole = FactorCache::new(9, 40);
        (0..57).for_each(|number| drop(round(&mut whole, mixed(number))));
        let mut whole = Made(whole, &row);
        let mut restored = Made(FactorCache::new(9, 40), &row);
        SavedState::of(&mut whole).unwrap().restore(&mut restored).unwrap();
        let [Made(mut whole, _), Made(mut restored, _)] = [whole, restored];
        // Nothing is ever found here.
        let mut forgetful = FactorCache::new(1, 40);
        for number in 57..200 {
            let bits = round(&mut whole, mixed(number));
            assert_eq!(bits, round(&mut restored, mixed(number)));
            forgetful.free_slot();
            assert_eq!(bits, round(&mut forgetful, mixed(number)));
        }
        assert_eq!(whole.counts(), restored.counts());
        assert!(whole.counts().evictions > 10 && whole.counts().hits > 10, "{:?}", whole.counts());
    }

    #[test]
    fn memory_is_bounded_however_many_factors_are_asked_for() {
        assert!(largest_memory(1_000_000, 576) <= LARGEST_MEMORY + (LARGEST_MEMORY >> 6));
        assert!(largest_memory(64, 72) < 64 * 72 * 80 * 8);
    }
}
