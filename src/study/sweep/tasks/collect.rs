//! Collection of all tasks' outcomes, and of the missing tasks as a compact list that batch systems read: `3,7-9`.

use std::fmt;
use std::path::PathBuf;

use crate::storage::Unusable;
use crate::study::sweep::run::Done;
use crate::study::sweep::tasks::folder::TaskFolder;
use crate::study::sweep::tasks::outcomes::Outcomes;
use crate::study::sweep::tasks::task::TaskError;
use crate::study::sweep::variants::Label;

/// Outcomes of all tasks.
#[derive(Debug, Default)]
pub(crate) struct Collection {
    /// The tasks, in the order of their numbers, with the results of those that are done.
    pub tasks: Vec<(Label, Option<Done>)>,
    /// Tasks whose last attempt failed: number, name and reason.
    pub failed: Vec<(u64, String, String)>,
    /// Files of outcomes that cannot be used; their tasks are missing.
    pub unusable: Vec<(PathBuf, Unusable)>,
}

impl TaskFolder {
    /// Collects all outcomes and makes one file of each shard that is done; `each` is called after every shard.
    ///
    /// # Errors
    /// [`TaskError`].
    pub(crate) fn collect(&self, mut each: impl FnMut()) -> Result<Collection, TaskError> {
        let mut collection = Collection::default();
        for shard in 0..self.shards() {
            let tasks = self.shard(shard)?;
            let outcomes = Outcomes::of(self, shard, &tasks);
            let found = outcomes.collect()?;
            collection.unusable.extend(found.unusable);
            for (index, (number, done)) in self.numbers(shard).zip(&found.done).enumerate() {
                if let (None, Some(reason)) = (done, outcomes.failure(index)) {
                    collection.failed.push((number, tasks[index].label.name.clone(), reason));
                }
            }
            collection.tasks.extend(tasks.into_iter().map(|task| task.label).zip(found.done));
            each();
        }
        Ok(collection)
    }
}

impl Collection {
    pub(crate) fn missing(&self) -> Numbers {
        let numbers = (0..).zip(&self.tasks).filter(|(_, (_, done))| done.is_none());
        Numbers::new(numbers.map(|(number, _)| number))
    }

    /// Names of the tasks that missed their load.
    pub(crate) fn missed_loads(&self) -> Vec<String> {
        let missed = |done: &Option<Done>| done.as_ref().is_some_and(|done| done.missed_load().is_some());
        self.tasks.iter().filter(|(_, done)| missed(done)).map(|(label, _)| label.name.clone()).collect()
    }
}

/// Distinct numbers, rising.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Numbers(pub Vec<u64>);

impl Numbers {
    /// Collects numbers in any order; duplicates count once.
    pub(crate) fn new(numbers: impl IntoIterator<Item = u64>) -> Self {
        let mut numbers: Vec<u64> = numbers.into_iter().collect();
        numbers.sort_unstable();
        numbers.dedup();
        Self(numbers)
    }
}

impl fmt::Display for Numbers {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, run) in self.0.chunk_by(|one, other| other - one == 1).enumerate() {
            let comma = if index > 0 { "," } else { "" };
            match run {
                [first, .., last] => write!(formatter, "{comma}{first}-{last}")?,
                _ => write!(formatter, "{comma}{}", run[0])?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_said_as_job_arrays_read_them() {
        for (numbers, text) in
            [(&[9, 3, 8, 7, 7][..], "3,7-9"), (&[0], "0"), (&[0, 1], "0-1"), (&[0, 2, 4], "0,2,4"), (&[], "")]
        {
            assert_eq!(Numbers::new(numbers.iter().copied()).to_string(), text);
        }
    }
}
