//! One piece of work at a time on another thread, handed over and back without allocating.
//!
//! Work that no thread has begun when its result is wanted is done where it is wanted: no thread waits for one that
//! does not get a processor, and without another thread everything is done in place. The result does not depend on
//! where the work was done.

use std::any::Any;
use std::mem::replace;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// How long a thread polls before it sleeps: to wake it takes some 50 us.
const LOOK_OUT: Duration = Duration::from_micros(300);

/// Work to be done on another thread.
pub(crate) trait Task: Send + 'static {
    /// Does the work; `in_background`: on the other thread.
    fn carry_out(&mut self, in_background: bool);
}

/// Where the work is.
enum Place<T> {
    /// With its owner.
    Out,
    /// Work that the first free thread begins.
    Waiting(Box<T>),
    /// On the other thread.
    Begun,
    Done(Box<T>),
    /// Panicked.
    Failed(Box<dyn Any + Send>),
    /// No more work will come.
    Over,
}

struct Shared<T> {
    place: Mutex<Place<T>>,
    changed: Condvar,
    /// Counts changes, for threads that poll.
    news: AtomicU32,
}

impl<T> Shared<T> {
    fn lock(&self) -> MutexGuard<'_, Place<T>> {
        self.place.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn set(&self, place: Place<T>) {
        *self.lock() = place;
        self.news.fetch_add(1, Ordering::Release);
        self.changed.notify_one();
    }

    /// Takes the work as soon as `wanted` holds, and leaves `instead`; polls for a while, then sleeps.
    fn wait(&self, wanted: impl Fn(&Place<T>) -> bool, instead: Place<T>) -> Place<T> {
        let begin = Instant::now();
        loop {
            let seen = self.news.load(Ordering::Acquire);
            let mut place = self.lock();
            if begin.elapsed() >= LOOK_OUT {
                while !wanted(&place) {
                    place = self.changed.wait(place).unwrap_or_else(PoisonError::into_inner);
                }
            }
            if wanted(&place) {
                return replace(&mut place, instead);
            }
            drop(place);
            while self.news.load(Ordering::Acquire) == seen && begin.elapsed() < LOOK_OUT {
                // On a busy machine the other thread may need this very processor.
                std::thread::yield_now();
            }
        }
    }
}

/// Work and the thread that does it.
pub(crate) struct BackgroundTask<T: Task> {
    shared: Arc<Shared<T>>,
    thread: Option<JoinHandle<()>>,
}

impl<T: Task> BackgroundTask<T> {
    /// Wraps work that is done; on another thread if `wanted` and if one can be started.
    pub(crate) fn new(work: T, wanted: bool) -> Self {
        let place = Mutex::new(Place::Done(Box::new(work)));
        let shared = Arc::new(Shared { place, changed: Condvar::new(), news: AtomicU32::new(0) });
        let served = Arc::clone(&shared);
        let thread = wanted.then(|| Builder::new().name("history".to_owned()).spawn(move || serve(&served)).ok());
        let thread = thread.flatten();
        // Allocations of the thread happen at its start: wait until it has begun.
        while thread.is_some() && shared.news.load(Ordering::Acquire) == 0 {
            std::thread::yield_now();
        }
        Self { shared, thread }
    }

    /// Takes the work back, done; a panic of the work goes on here.
    pub(crate) fn take(&self) -> Box<T> {
        match self.shared.wait(|place| !matches!(place, Place::Begun), Place::Out) {
            Place::Done(work) => work,
            Place::Waiting(mut work) => {
                work.carry_out(false);
                work
            }
            Place::Failed(panic) => resume_unwind(panic),
            Place::Out | Place::Begun | Place::Over => unreachable!("the work is taken once and given back"),
        }
    }

    /// Hands the work over, to be done.
    pub(crate) fn begin(&self, work: Box<T>) {
        self.shared.set(Place::Waiting(work));
    }

    /// Gives the work back as it was taken.
    pub(crate) fn give_back(&self, work: Box<T>) {
        self.shared.set(Place::Done(work));
    }
}

impl<T: Task> Drop for BackgroundTask<T> {
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            // Work that has begun is finished first.
            self.shared.wait(|place| !matches!(place, Place::Begun), Place::Over);
            self.shared.set(Place::Over);
            // Its panics are handed on with the work.
            let _ = thread.join();
        }
    }
}

/// Does the work that comes until no more will.
fn serve<T: Task>(shared: &Shared<T>) {
    shared.news.fetch_add(1, Ordering::Release);
    while let Place::Waiting(mut work) =
        shared.wait(|place| matches!(place, Place::Waiting(_) | Place::Over), Place::Begun)
    {
        let done = catch_unwind(AssertUnwindSafe(|| {
            work.carry_out(true);
            work
        }));
        shared.set(done.map_or_else(Place::Failed, Place::Done));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Count(u32);

    impl Task for Count {
        fn carry_out(&mut self, _: bool) {
            assert!(self.0 < 1000, "a thousand is enough");
            self.0 += 1;
        }
    }

    #[test]
    fn every_piece_of_work_is_done_once_and_its_panic_reaches_its_owner() {
        for wanted in [false, true] {
            let background = BackgroundTask::new(Count(0), wanted);
            for round in 0..1000 {
                let work = background.take();
                assert_eq!(work.0, round);
                // Now and then the other thread falls asleep, or gets all the time that it needs.
                if round % 100 == 0 {
                    std::thread::sleep(4 * LOOK_OUT);
                }
                background.begin(work);
                if round % 100 == 50 {
                    std::thread::sleep(4 * LOOK_OUT);
                }
            }
            let work = background.take();
            background.give_back(work);
            let work = background.take();
            assert_eq!(work.0, 1000);
            background.begin(work);
            assert!(catch_unwind(AssertUnwindSafe(|| background.take())).is_err());
        }
        // Work that nobody takes back keeps nobody waiting.
        let background = BackgroundTask::new(Count(0), true);
        let work = background.take();
        background.begin(work);
    }
}
