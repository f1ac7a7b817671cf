//! Pressures of a point that are stored over time: all of the first ones, or only the excerpts that passages need, a
//! few hundredths.

use std::ops::Range;

use crate::storage::state::{Evolving, StateError, StateStream, ensure};

/// Stored samples of a point.
#[derive(Clone, Debug, Default)]
pub(super) struct StoredSignal {
    /// Range of samples of each excerpt.
    wanted: Vec<Range<usize>>,
    /// Number of samples so far.
    pub taken: usize,
    /// Pressures by excerpt, in single precision \[Pa\].
    excerpts: Vec<Vec<f32>>,
}

impl StoredSignal {
    pub(super) fn of(wanted: Vec<Range<usize>>) -> Self {
        let excerpts = vec![Vec::new(); wanted.len()];
        Self { wanted, taken: 0, excerpts }
    }

    /// Takes the next pressures \[Pa\].
    pub(super) fn push(&mut self, pressures: &[f64]) {
        let here = self.taken..self.taken + pressures.len();
        for (wanted, excerpt) in self.wanted.iter().zip(&mut self.excerpts) {
            let (from, to) = (wanted.start.max(here.start), wanted.end.min(here.end));
            if from < to {
                let some = &pressures[from - here.start..to - here.start];
                excerpt.reserve_exact((wanted.len() - excerpt.len()).max(some.len()));
                excerpt.extend(some.iter().map(|&pressure| pressure as f32));
            }
        }
        self.taken = here.end;
    }

    /// An excerpt, as far as it has come \[Pa\].
    pub(super) fn excerpt(&self, index: usize) -> impl Iterator<Item = f64> {
        self.excerpts.get(index).into_iter().flatten().map(|&pressure| f64::from(pressure))
    }

    #[cfg(test)]
    fn count(&self) -> usize {
        self.excerpts.iter().map(Vec::len).sum()
    }
}

impl Evolving for StoredSignal {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.value(&mut self.taken)?;
        state.same(&self.wanted.len())?;
        self.excerpts.iter_mut().try_for_each(|excerpt| state.growing(excerpt))?;
        let due = |wanted: &Range<usize>| wanted.end.min(self.taken).saturating_sub(wanted.start);
        ensure(self.wanted.iter().zip(&self.excerpts).all(|(wanted, excerpt)| excerpt.len() == due(wanted)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::state::SavedState;

    #[test]
    fn excerpts_are_stored_and_nothing_else_whatever_the_blocks() {
        let mut stored = StoredSignal::of(vec![2..5, 4..9, 20..30]);
        for block in [0..3, 3..4, 4..12, 12..25] {
            let pressures: Vec<f64> = block.map(f64::from).collect();
            stored.push(&pressures);
            let mut again = StoredSignal::of(vec![2..5, 4..9, 20..30]);
            SavedState::of(&mut stored).unwrap().restore(&mut again).unwrap();
            stored = again;
        }
        let excerpt = |index| stored.excerpt(index).collect::<Vec<f64>>();
        assert_eq!((excerpt(0), excerpt(1)), (vec![2.0, 3.0, 4.0], vec![4.0, 5.0, 6.0, 7.0, 8.0]));
        assert_eq!((excerpt(2), excerpt(3)), ((20..25).map(f64::from).collect(), Vec::new()));
        assert_eq!((stored.taken, stored.count()), (25, 13));
        assert!(SavedState::of(&mut stored).unwrap().restore(&mut StoredSignal::default()).is_err());
    }
}
