//! One piece of work at a time in the background: on a separate thread, to which it is handed over and back without
//! allocating, or on a thread of the current pool, which allocates a task for each piece.
//!
//! Work that no thread has begun when its result is wanted is done where it is wanted: no thread waits for one that
//! does not get a processor, and without another thread everything is done in place. The result does not depend on
//! where the work was done. A panic of the work goes on where its result is wanted.

use std::any::Any;
use std::mem::replace;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use rayon::Yield;

/// How long a thread polls before it sleeps: to wake it takes some 50 us.
const LOOK_OUT: Duration = Duration::from_micros(300);
/// Time for which a thread of a pool sleeps, when there is no task that it could help with, before it looks again.
const SLEEP: Duration = Duration::from_micros(100);

/// Work to be done in the background.
pub(crate) trait BackgroundTask: Send + 'static {
    /// Does the work; `in_background`: on another thread than the owner's.
    fn carry_out(&mut self, in_background: bool);
}

/// Where the work is.
enum Place<T> {
    /// With its owner.
    Out,
    /// Work that the first free thread begins.
    Waiting(Box<T>),
    /// Under way on another thread.
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

    /// Runs tasks of the pool while the work is under way: it may be waiting for one of them.
    fn help(&self) {
        let mut place = self.lock();
        while matches!(*place, Place::Begun) {
            drop(place);
            let helped = rayon::yield_now() == Some(Yield::Executed);
            place = self.lock();
            if !helped && matches!(*place, Place::Begun) {
                place = self.changed.wait_timeout(place, SLEEP).unwrap_or_else(PoisonError::into_inner).0;
            }
        }
    }
}

impl<T: BackgroundTask> Shared<T> {
    /// Does work that has been begun.
    fn carry_out(&self, mut work: Box<T>) {
        let done = catch_unwind(AssertUnwindSafe(|| {
            work.carry_out(true);
            work
        }));
        self.set(done.map_or_else(Place::Failed, Place::Done));
    }

    /// Does the work that comes until no more will.
    fn serve(&self) {
        self.news.fetch_add(1, Ordering::Release);
        while let Place::Waiting(work) =
            self.wait(|place| matches!(place, Place::Waiting(_) | Place::Over), Place::Begun)
        {
            self.carry_out(work);
        }
    }

    /// Does the work if no thread has begun it yet.
    fn serve_once(&self) {
        let mut place = self.lock();
        if !matches!(*place, Place::Waiting(_)) {
            return;
        }
        let begun = replace(&mut *place, Place::Begun);
        drop(place);
        if let Place::Waiting(work) = begun {
            self.carry_out(work);
        }
    }
}

/// Work and the threads that do it.
pub(crate) struct Background<T: BackgroundTask> {
    shared: Arc<Shared<T>>,
    thread: Option<JoinHandle<()>>,
    in_pool: bool,
}

impl<T: BackgroundTask> Background<T> {
    fn new(work: T, in_pool: bool) -> Self {
        let place = Mutex::new(Place::Done(Box::new(work)));
        let shared = Arc::new(Shared { place, changed: Condvar::new(), news: AtomicU32::new(0) });
        Self { shared, thread: None, in_pool }
    }

    /// Wraps work that is done. It will be done on a separate thread if the current pool has several threads and if
    /// one can be started.
    pub(crate) fn on_a_thread(work: T) -> Self {
        let mut this = Self::new(work, false);
        if rayon::current_num_threads() > 1 {
            let served = Arc::clone(&this.shared);
            this.thread = Builder::new().name("background".to_owned()).spawn(move || served.serve()).ok();
        }
        // Allocations of the thread happen at its start: wait until it has begun.
        while this.thread.is_some() && this.shared.news.load(Ordering::Acquire) == 0 {
            std::thread::yield_now();
        }
        this
    }

    /// Wraps work that is done. It will be done on a thread of the pool that is current when it begins; a thread that
    /// waits for it helps with the tasks of that pool.
    pub(crate) fn in_pool(work: T) -> Self {
        Self::new(work, true)
    }

    /// Takes the work back, done.
    pub(crate) fn take(&self) -> Box<T> {
        match self.wait(Place::Out) {
            Place::Done(work) => work,
            Place::Waiting(mut work) => {
                work.carry_out(false);
                work
            }
            Place::Failed(panic) => resume_unwind(panic),
            Place::Out | Place::Begun | Place::Over => unreachable!("the work is taken once and given back"),
        }
    }

    /// True if [`Self::take`] would not have to wait, nor to do the work.
    pub(crate) fn is_done(&self) -> bool {
        matches!(*self.shared.lock(), Place::Done(_) | Place::Failed(_))
    }

    /// Hands the work over, to be done.
    pub(crate) fn begin(&self, work: Box<T>) {
        self.shared.set(Place::Waiting(work));
        if self.in_pool {
            let served = Arc::clone(&self.shared);
            rayon::spawn(move || served.serve_once());
        }
    }

    /// Looks at the work, done, or changes it.
    pub(crate) fn with<R>(&self, of: impl FnOnce(&mut T) -> R) -> R {
        let mut work = self.take();
        let result = of(&mut work);
        self.shared.set(Place::Done(work));
        result
    }

    /// Takes the work when it is not under way, and leaves `instead`.
    fn wait(&self, instead: Place<T>) -> Place<T> {
        if self.in_pool {
            self.shared.help();
        }
        self.shared.wait(|place| !matches!(place, Place::Begun), instead)
    }
}

impl<T: BackgroundTask> Drop for Background<T> {
    fn drop(&mut self) {
        // Work that has begun is finished first; its panic is handed on with the work, and dropped with it.
        drop(self.wait(Place::Over));
        if let Some(thread) = self.thread.take() {
            self.shared.set(Place::Over);
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Count(u32);

    impl BackgroundTask for Count {
        fn carry_out(&mut self, _: bool) {
            assert!(self.0 < 1000, "a thousand is enough");
            self.0 += 1;
        }
    }

    fn pool(threads: usize) -> rayon::ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }

    #[test]
    fn work_is_done_once_and_its_panic_reaches_its_owner() {
        for (threads, kind) in [1, 2].into_iter().flat_map(|threads| [(threads, false), (threads, true)]) {
            pool(threads).install(|| {
                let background = if kind { Background::in_pool(Count(0)) } else { Background::on_a_thread(Count(0)) };
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
                assert_eq!(background.with(|work| work.0), 1000);
                assert!(background.is_done());
                background.begin(background.take());
                assert!(catch_unwind(AssertUnwindSafe(|| background.take())).is_err());
            });
        }
    }

    #[test]
    fn work_that_nobody_takes_back_keeps_nobody_waiting() {
        for threads in [1, 2] {
            pool(threads).install(|| {
                for background in [Background::in_pool(Count(0)), Background::on_a_thread(Count(0))] {
                    background.begin(background.take());
                }
            });
        }
    }
}
