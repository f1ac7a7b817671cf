//! Collection of all tasks' outcomes, and of the missing tasks.

use std::path::PathBuf;

use crate::storage::Unusable;
use crate::study::sweep::run::Done;
use crate::study::sweep::tasks::error::TaskError;
use crate::study::sweep::tasks::folder::TaskFolder;
use crate::study::sweep::tasks::numbers::Numbers;
use crate::study::sweep::tasks::outcomes::Outcomes;
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
