//! Work in the background: displacements by the history at the coming instant, ring by ring.

use super::ring_waves::RingWaves;
use super::short_ring::ShortRing;
use super::wave_transform::WaveNumber;
use crate::counters::{Clock, CpuClock, Meter, Spent, Stage};
use crate::numeric::background::BackgroundTask;
use crate::time_rule::TimeRule;
use crate::time_rule::recursion::{Recursion, WithRecursion};

/// The waves of all rings, and what is to be done for them.
pub(super) struct BackgroundWaves<N: WaveNumber> {
    /// Ring by ring; a short one with its cells.
    pub rings: Vec<(RingWaves<N>, Option<ShortRing<N>>)>,
    rule: TimeRule,
    /// The instant of the block that the march is at.
    instant: usize,
    /// Number of the last instant in its block, if there was one.
    last: Option<usize>,
    /// Clock of processor time in addition to wall time, if there is one, and times of the last part.
    cpu: Option<CpuClock>,
    spent: Spent,
    /// True if the last part ran in the background.
    in_background: bool,
}

impl<N: WaveNumber> BackgroundWaves<N> {
    pub(super) fn new(rings: Vec<(RingWaves<N>, Option<ShortRing<N>>)>, rule: TimeRule) -> Self {
        Self { rings, rule, instant: 0, last: None, cpu: None, spent: Spent::default(), in_background: false }
    }

    /// Sets what is to be done while the march is at an instant of the block; `last` is the previous instant.
    pub(super) fn begin(&mut self, instant: usize, last: Option<usize>, cpu: Option<CpuClock>) {
        (self.instant, self.last, self.cpu) = (instant, last, cpu);
    }

    /// Reports the time of the last part where it ran in the background; within the march it is measured there.
    pub(super) fn report(&self, meter: &mut Meter) {
        if self.in_background {
            meter.add_background(Stage::History, self.spent.wall);
        }
    }
}

impl<N: WaveNumber> BackgroundTask for BackgroundWaves<N> {
    fn carry_out(&mut self, in_background: bool) {
        self.in_background = in_background;
        let mut clock = Clock::start(self.cpu);
        self.rule.with_recursion(Advance(self));
        self.spent = clock.lap();
    }
}

struct Advance<'a, N: WaveNumber>(&'a mut BackgroundWaves<N>);

impl<N: WaveNumber> WithRecursion for Advance<'_, N> {
    type Output = ();

    fn with<R: Recursion>(self, recursion: R) {
        let BackgroundWaves { rings, instant, last, .. } = self.0;
        for (waves, short) in rings {
            if let Some(short) = short {
                if let Some(last) = *last {
                    short.take_forces(last, waves);
                }
                if *instant == 0 {
                    waves.turn();
                }
            }
            waves.advance(*instant, recursion);
            if let Some(short) = short {
                short.find_field(waves);
            }
        }
    }
}
