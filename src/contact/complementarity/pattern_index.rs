//! Finds the slot of a pattern of points: open addressing with linear probing, all memory taken at the start.

/// Slots by their patterns.
#[derive(Clone, Debug)]
pub(super) struct PatternIndex {
    /// Slot + 1 by hashed place, 0 where there is none; at most half full.
    places: Vec<u32>,
    /// Patterns by slot.
    patterns: Vec<u64>,
    /// Words of a pattern.
    words: usize,
}

impl PatternIndex {
    /// Index for `slots` slots with patterns of `words` words.
    pub(super) fn new(slots: usize, words: usize) -> Self {
        Self { places: vec![0; (2 * slots).next_power_of_two()], patterns: vec![0; slots * words], words }
    }

    pub(super) fn pattern(&self, slot: usize) -> &[u64] {
        &self.patterns[slot * self.words..(slot + 1) * self.words]
    }

    /// Slot that has a pattern.
    pub(super) fn find(&self, pattern: &[u64]) -> Option<usize> {
        let place = self.place(pattern);
        self.places[place].checked_sub(1).map(|slot| slot as usize)
    }

    /// Gives a pattern that no slot has to a slot that has none.
    pub(super) fn insert(&mut self, slot: usize, pattern: &[u64]) {
        let place = self.place(pattern);
        self.patterns[slot * self.words..(slot + 1) * self.words].copy_from_slice(pattern);
        self.places[place] = slot as u32 + 1;
    }

    /// Takes a slot's pattern away from it.
    pub(super) fn remove(&mut self, slot: usize) {
        let mask = self.places.len() - 1;
        let mut gap = self.place(self.pattern(slot));
        self.places[gap] = 0;
        // Entries that a collision pushed past the gap move back, so that a search may stop at the first empty place.
        let mut next = (gap + 1) & mask;
        while let Some(other) = self.places[next].checked_sub(1) {
            let home = hash(self.pattern(other as usize)) & mask;
            if (next.wrapping_sub(home) & mask) >= (next.wrapping_sub(gap) & mask) {
                self.places[gap] = other + 1;
                self.places[next] = 0;
                gap = next;
            }
            next = (next + 1) & mask;
        }
    }

    /// Place that holds a pattern, or the empty one where it would go.
    fn place(&self, pattern: &[u64]) -> usize {
        let mask = self.places.len() - 1;
        let mut place = hash(pattern) & mask;
        while let Some(slot) = self.places[place].checked_sub(1) {
            if self.pattern(slot as usize) == pattern {
                break;
            }
            place = (place + 1) & mask;
        }
        place
    }
}

/// Hashes a pattern: multiplies and folds, word by word, without a seed, so that runs repeat exactly.
fn hash(pattern: &[u64]) -> usize {
    let mut hash = 0_u64;
    for word in pattern {
        let wide = u128::from(hash ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15_f39c_c060_5ced_c835);
        hash = (wide as u64) ^ ((wide >> 64) as u64);
    }
    hash as usize
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn agrees_with_a_hash_map_over_many_changes() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let (slots, mut index, mut map) = (16, PatternIndex::new(16, 2), HashMap::new());
        for _ in 0..20_000 {
            let pattern = [random.random_range(0..24_u64) << random.random_range(0..3_u32), 1];
            assert_eq!(index.find(&pattern), map.get(&pattern).copied());
            if map.contains_key(&pattern) {
                continue;
            }
            let slot = random.random_range(0..slots);
            if let Some((&old, _)) = map.iter().find(|(_, held)| **held == slot) {
                index.remove(slot);
                map.remove(&old);
            }
            index.insert(slot, &pattern);
            map.insert(pattern, slot);
        }
        for (pattern, slot) in map {
            assert_eq!((index.find(&pattern), index.pattern(slot)), (Some(slot), pattern.as_slice()));
        }
    }
}
