//! A clock, and the time that it has measured.

use std::time::{Duration, Instant};

use super::amounts::amounts;

amounts! {
    /// Time of a piece of work.
    pub struct Spent {
        /// Wall time.
        pub wall: Duration,
        /// Wall time of the part over which processor time was measured.
        pub watched: Duration,
        /// Processor time over the watched part.
        pub cpu: Duration,
    }
}

impl Spent {
    /// Time of a whole of which this part was timed: `factor` times the wall time (never less than this), with
    /// processor time at the rate of the watched part.
    pub fn extrapolated(self, factor: f64) -> Self {
        let wall = if factor > 1.0 { self.wall.mul_f64(factor) } else { self.wall };
        if self.watched.is_zero() {
            return Self { wall, ..Self::default() };
        }
        let cpu = self.cpu.mul_f64(wall.as_secs_f64() / self.watched.as_secs_f64());
        Self { wall, watched: wall, cpu }
    }

    /// Processor time over all of it \[s\], extrapolated at the rate of the watched part; `None` where none was
    /// watched.
    pub fn cpu_seconds(self) -> Option<f64> {
        let watched = self.watched.as_secs_f64();
        (watched > 0.0).then(|| self.cpu.as_secs_f64() * self.wall.as_secs_f64() / watched)
    }

    /// A fraction, 0 to 1, of all its times.
    pub fn share(self, share: f64) -> Self {
        Self { wall: self.wall.mul_f64(share), watched: self.watched.mul_f64(share), cpu: self.cpu.mul_f64(share) }
    }
}

/// Reads processor time so far: of the calling thread or of all, see [`super::process`].
pub(crate) type CpuClock = fn() -> Option<Duration>;

/// A clock that goes from one piece of work to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    /// When the current lap began.
    pub began: Instant,
    cpu: Option<(CpuClock, Duration)>,
}

impl Clock {
    /// `cpu` reads processor time beside wall time.
    pub(crate) fn start(cpu: Option<CpuClock>) -> Self {
        let cpu = cpu.and_then(|clock| Some((clock, clock()?)));
        // Last, so that the system call is no part of the first lap's wall time.
        Self { began: Instant::now(), cpu }
    }

    /// Time since the last lap ended, or the first began.
    pub(crate) fn lap(&mut self) -> Spent {
        let last = self.began;
        let Some((clock, before)) = &mut self.cpu else {
            self.began = Instant::now();
            return Spent { wall: self.began - last, ..Spent::default() };
        };
        let now = clock().unwrap_or(*before);
        let cpu = now.saturating_sub(*before);
        *before = now;
        // The processor was busy in the call, too: both times hold it.
        self.began = Instant::now();
        let wall = self.began - last;
        Spent { wall, watched: wall, cpu }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counters::process::thread_cpu_time;

    fn busy(time: Duration) {
        let begin = Instant::now();
        while begin.elapsed() < time {
            std::hint::black_box(begin);
        }
    }

    #[test]
    fn laps_follow_each_other() {
        let begin = Instant::now();
        let mut laps = Clock::start(None);
        busy(Duration::from_millis(2));
        let one = laps.lap();
        busy(Duration::from_millis(1));
        let other = laps.lap();
        assert!(one.wall >= Duration::from_millis(2) && other.wall >= Duration::from_millis(1));
        assert!(one.wall + other.wall <= begin.elapsed());
        assert_eq!((one.watched, one.cpu), (Duration::ZERO, Duration::ZERO));
    }

    #[test]
    fn processor_time_comes_with_the_wall_time_it_belongs_to() {
        let mut laps = Clock::start(Some(thread_cpu_time));
        busy(Duration::from_millis(20));
        let spent = laps.lap();
        assert_eq!(spent.watched == spent.wall, thread_cpu_time().is_some());
        assert_eq!(spent.cpu > Duration::ZERO, thread_cpu_time().is_some());
    }

    #[test]
    fn a_part_stands_for_the_whole() {
        let [ten, two, three] = [10, 2, 3].map(Duration::from_millis);
        let spent = Spent { wall: ten, watched: two, cpu: three };
        let whole = spent.extrapolated(4.0);
        assert_eq!((whole.wall, whole.watched, whole.cpu), (4 * ten, 4 * ten, 20 * three));
        assert_eq!(spent.extrapolated(1.0).wall, ten);
        let unwatched = Spent { wall: ten, ..Spent::default() };
        assert_eq!(unwatched.extrapolated(2.0), Spent { wall: 2 * ten, ..Spent::default() });
    }
}
