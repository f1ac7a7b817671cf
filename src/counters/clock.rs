//! Clocks that may be off, and what they have measured.

use std::ops::{AddAssign, SubAssign};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::process::thread_cpu_time;

/// Which clocks are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clocks {
    /// Wall time.
    pub wall: bool,
    /// Processor time of the calling thread, beside wall time: over microseconds that of others is not known, see
    /// [`super::process::cpu_time`].
    pub cpu: bool,
}

impl Clocks {
    /// None.
    pub const OFF: Self = Self { wall: false, cpu: false };
}

/// Time of a piece of work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Spent {
    /// Wall time.
    pub wall: Duration,
    /// Wall time of the part over which processor time was measured.
    pub watched: Duration,
    /// Processor time over that part.
    pub cpu: Duration,
}

impl AddAssign for Spent {
    fn add_assign(&mut self, other: Self) {
        self.wall += other.wall;
        self.watched += other.watched;
        self.cpu += other.cpu;
    }
}

impl SubAssign for Spent {
    /// Takes off a part of the whole; nothing goes below zero, whatever the clocks say.
    fn sub_assign(&mut self, part: Self) {
        self.wall = self.wall.saturating_sub(part.wall);
        self.watched = self.watched.saturating_sub(part.watched);
        self.cpu = self.cpu.saturating_sub(part.cpu);
    }
}

impl Spent {
    /// The whole of which a part was timed, `factor` times as long, with the processor time that it had at the rate of
    /// the watched part.
    pub fn extrapolated(self, factor: f64) -> Self {
        let wall = if factor > 1.0 { self.wall.mul_f64(factor) } else { self.wall };
        if self.watched.is_zero() {
            return Self { wall, ..Self::default() };
        }
        let cpu = self.cpu.mul_f64(wall.as_secs_f64() / self.watched.as_secs_f64());
        Self { wall, watched: wall, cpu }
    }

    /// Processor time over all of it \[s\], at the rate of the part over which it was measured; `None` where it was
    /// not.
    pub fn cpu_seconds(self) -> Option<f64> {
        let watched = self.watched.as_secs_f64();
        (watched > 0.0).then(|| self.cpu.as_secs_f64() * self.wall.as_secs_f64() / watched)
    }

    /// A share of it.
    pub fn share(self, share: f64) -> Self {
        Self { wall: self.wall.mul_f64(share), watched: self.watched.mul_f64(share), cpu: self.cpu.mul_f64(share) }
    }
}

/// Clocks that go from one piece of work to the next.
#[derive(Clone, Copy, Debug)]
pub struct Laps {
    wall: Option<Instant>,
    cpu: Option<Duration>,
}

impl Laps {
    /// Starts the clocks that are to be read.
    pub fn begin(clocks: Clocks) -> Self {
        let cpu = if clocks.cpu { thread_cpu_time() } else { None };
        // Last, so that the system call is no part of the first lap's wall time.
        Self { wall: clocks.wall.then(Instant::now), cpu }
    }

    /// What was spent since the last lap ended, or the first began; nothing where the clocks are off.
    pub fn lap(&mut self) -> Spent {
        let Some(last) = self.wall else { return Spent::default() };
        let now = Instant::now();
        let wall = now - last;
        self.wall = Some(now);
        let Some(before) = self.cpu else { return Spent { wall, ..Spent::default() } };
        let cpu = thread_cpu_time();
        self.cpu = cpu;
        let next = Instant::now();
        self.wall = Some(next);
        // The processor was busy in the call, too: both times hold it.
        Spent { wall, watched: next - last, cpu: cpu.unwrap_or(before).saturating_sub(before) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn busy(time: Duration) {
        let begin = Instant::now();
        while begin.elapsed() < time {
            std::hint::black_box(begin);
        }
    }

    #[test]
    fn clocks_that_are_off_measure_nothing_and_laps_follow_each_other() {
        let mut off = Laps::begin(Clocks::OFF);
        assert_eq!(off.lap(), Spent::default());
        let begin = Instant::now();
        let mut laps = Laps::begin(Clocks { wall: true, cpu: false });
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
        let mut laps = Laps::begin(Clocks { wall: true, cpu: true });
        busy(Duration::from_millis(20));
        let spent = laps.lap();
        assert!(spent.watched >= spent.wall);
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
