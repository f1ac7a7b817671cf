//! Pressure at a microphone beside the road as a tyre rolls by, from pressures at points that move with the tyre.
//!
//! The points lie on a line parallel to the travel; the microphone takes the place of one after the other, from the
//! front to the rear. With V the speed, c the sound speed, M = V/c, x(t) the microphone's place on the line when it
//! receives the sound of time t, h the line's distance from the tyre's axis of travel, and all of them seen from the
//! origin of the frame:
//!
//! 1. Sound received at t left the origin at the emission time tau. The distance r that it has travelled since and the
//!    Doppler factor follow in closed form:
//!
//!    ```text
//!    R = sqrt(x^2 + (1 - M^2) h^2),  r = (R + M x)/(1 - M^2),  tau = t - r/c,  cos = (x + M r)/r
//!    D = 1/(1 - M cos) = dtau/dt,    r (1 - M cos) = R
//!    ```
//!
//! 2. Each point's pressure p_i(t) loses its delay r_i/c and its decay: q_i(tau) = r_i p_i(tau + r_i/c). The rest
//!    varies slowly from one point to the next.
//! 3. The points about x are cross-faded by Lagrange's cubic through four of them: q(x, tau) = sum_i w_i(x) q_i(tau).
//!    The signals are read between their samples by band-limited interpolation ([`super::resample`]).
//! 4. The microphone receives D q(x, tau)/R: delay and decay restored.
//!
//! Why D/R and why the place at reception: the points' pressures are those of air at rest about a tyre at rest. Air
//! that streams past with V is, to the first power of M, the same problem with the time t - M x/c and the pressure
//! times 1 + M cos (K. Taylor 1978, *A transformation of the acoustic equation with implications for wind-tunnel and
//! low-speed flight tests*, Proc. R. Soc. A 363), read where the microphone is in the moving frame. For a monopole at
//! the origin, D q/R = q/(r (1 - M cos)^2) is the exact far field of a moving monopole (Morse and Ingard, *Theoretical
//! Acoustics*, 11.2); without `amplification` it is q/r, the decay alone. The points' pressures must already contain
//! the transformation's time at the source: motion of the tyre at x_s needs the phase factor exp(i k M x_s). Without it
//! parts of the tyre ahead of and behind each other interfere with a phase that is wrong by k M times their distance:
//! 0.12 rad for 0.1 m at 1 kHz and 80 km/h.
//!
//! Measured at 110 km/h, with four monopoles about the contact patch against the closed form of moving ones: an error
//! of 1.6 % of their sizes at 2.5 kHz, 81 receivers over 20 m or more. Taking the points' places at emission instead is
//! 21 % off, since directions then differ by M. For monopoles at the origin the only difference from the closed form is
//! its near field, V/(omega r).
//!
//! Each point is needed only while the microphone is near it, and the points add up one by one: one point's excerpt is
//! in memory at a time. Cost: 4 x 66 multiplications and additions per sample.

use std::ops::Range;

use thiserror::Error;

use super::frame::Position;
use super::resample::{half_width, weighted};
use crate::numeric::lagrange::uniform_cubic;

/// Number of points that are cross-faded at a time.
pub(crate) const STENCIL: usize = 4;

/// Reason why there is no pass-by.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub(crate) enum PassByError {
    /// Fewer points than are cross-faded at a time.
    #[error("a pass-by needs at least {STENCIL} receivers along its line, not {given}")]
    TooFewReceivers {
        /// Number of points given.
        given: usize,
    },
    /// Points that are not evenly spaced on a line parallel to the travel, front first.
    #[error("receiver {receiver} is not in its place on an evenly spaced line from the front to the rear")]
    NotALine {
        /// Index of the first that is out of place.
        receiver: usize,
    },
    /// An invalid number.
    #[error("{quantity} must be {expected}, not {value}")]
    BadValue {
        /// Name of the quantity.
        quantity: &'static str,
        /// Condition that it must fulfil.
        expected: &'static str,
        /// Value given.
        value: f64,
    },
    /// An excerpt of the wrong length.
    #[error("receiver {receiver} needs {needed} samples of its pressure, {given} are given")]
    ExcerptLength {
        /// Index of the receiver.
        receiver: usize,
        /// Length of [`PassBy::needed`].
        needed: usize,
        /// Number given.
        given: usize,
    },
}

/// Input of a pass-by.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Passage {
    /// Points in the tyre's frame \[m\], as [`super::CoastByLine::positions`] gives them.
    pub receivers: Vec<Position>,
    /// Speed V \[m/s\].
    pub speed: f64,
    /// Sound speed c \[m/s\].
    pub sound_speed: f64,
    /// Sampling rate of the points' pressures \[Hz\].
    pub input_rate: f64,
    /// Sampling rate of the pressure at the microphone \[Hz\].
    pub output_rate: f64,
    /// True if the level is raised ahead of the tyre and lowered behind it as that of a moving source: by 40 lg D, +1.3
    /// and -1.1 dB at +-10 m, 110 km/h.
    pub amplification: bool,
}

/// A pass-by whose points are to be added.
///
/// Time is that of the points' pressures: their sample n is at n/input_rate. The first sample at the microphone left
/// the origin at time 0, and is received at the first point; the last is received at the last point.
#[derive(Clone, Debug)]
pub(crate) struct PassBy {
    passage: Passage,
    spacing: f64,
    /// Distance h of the line from the axis of travel \[m\].
    aside: f64,
    /// Distances r_i of the points from the origin \[m\].
    distances: Vec<f64>,
    samples: usize,
}

/// Values of one sample at the microphone.
struct Instant {
    /// Emission time tau \[s\].
    emission: f64,
    /// D/R, or 1/r without amplification \[1/m\].
    gain: f64,
    /// First point of the stencil, and the weights of its points.
    stencil: (usize, [f64; STENCIL]),
}

impl PassBy {
    /// Checks a passage and computes its geometry.
    ///
    /// # Errors
    /// All of [`PassByError`] but the last.
    pub(crate) fn new(passage: Passage) -> Result<Self, PassByError> {
        let Passage { receivers, speed, sound_speed, input_rate, output_rate, .. } = &passage;
        let given = receivers.len();
        if given < STENCIL {
            return Err(PassByError::TooFewReceivers { given });
        }
        for (quantity, value) in
            [("the sound speed", sound_speed), ("the input's rate", input_rate), ("the output's rate", output_rate)]
        {
            if !(value.is_finite() && *value > 0.0) {
                return Err(PassByError::BadValue { quantity, expected: "positive", value: *value });
            }
        }
        if !(*speed > 0.0 && speed < sound_speed) {
            let expected = "positive and below the speed of sound";
            return Err(PassByError::BadValue { quantity: "the speed", expected, value: *speed });
        }
        let [first, y, z] = receivers[0];
        let length = first - receivers[given - 1][0];
        let spacing = length / (given - 1) as f64;
        let out_of_place = |(index, position): (usize, &Position)| {
            let expected = [first - spacing * index as f64, y, z];
            // NaN is out of place, too.
            !position.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-6 * spacing)
        };
        if let Some(receiver) = receivers.iter().enumerate().position(out_of_place) {
            return Err(PassByError::NotALine { receiver });
        }
        let distances = receivers.iter().map(|[x, y, z]| x.hypot(*y).hypot(*z)).collect();
        // The last sample counts where it falls on the last point up to rounding.
        let samples = (length / speed * output_rate + 1e-9).floor() as usize + 1;
        Ok(Self { spacing, aside: y.hypot(z), distances, samples, passage })
    }

    /// Number of samples at the microphone.
    pub(crate) fn samples(&self) -> usize {
        self.samples
    }

    /// Position x of the microphone in the tyre's frame at a sample \[m\]: that of the tyre behind (x > 0) or past (x <
    /// 0) the microphone.
    pub(crate) fn place(&self, sample: usize) -> f64 {
        self.passage.receivers[0][0] - self.passage.speed * sample as f64 / self.passage.output_rate
    }

    /// Time of a sample at the microphone \[s\].
    pub(crate) fn time(&self, sample: usize) -> f64 {
        self.path(self.place(0)).0 / self.passage.sound_speed + sample as f64 / self.passage.output_rate
    }

    /// Doppler factor D: frequency at the microphone over that of the tyre.
    #[cfg(test)]
    pub(crate) fn doppler_ratio(&self, sample: usize) -> f64 {
        let (distance, shortened) = self.path(self.place(sample));
        distance / shortened
    }

    /// Indices of the samples of a point's pressure that are needed. They may begin a little before 0, where the line
    /// begins close by.
    ///
    /// # Panics
    /// If there is no such receiver.
    pub(crate) fn needed(&self, receiver: usize) -> Range<i64> {
        let reached = self.reached(receiver);
        if reached.is_empty() {
            return 0..0;
        }
        let reach = half_width() * self.ratio() + 1.0;
        let first = self.position(receiver, reached.start) - reach;
        let last = self.position(receiver, reached.end - 1) + reach;
        first.floor() as i64..last.ceil() as i64 + 1
    }

    /// Adds the contribution of one point to `sound`, the pressure at the microphone, of [`Self::samples`] samples.
    /// `excerpt` has the samples [`Self::needed`] of the point's pressure \[Pa\].
    ///
    /// # Errors
    /// [`PassByError::ExcerptLength`].
    ///
    /// # Panics
    /// If there is no such receiver, or `sound` is too short.
    pub(crate) fn add(&self, receiver: usize, excerpt: &[f64], sound: &mut [f64]) -> Result<(), PassByError> {
        let needed = self.needed(receiver);
        let length = (needed.end - needed.start) as usize;
        if excerpt.len() != length {
            return Err(PassByError::ExcerptLength { receiver, needed: length, given: excerpt.len() });
        }
        let mut weights = Vec::new();
        for sample in self.reached(receiver) {
            let instant = self.instant(sample);
            let (first, fades) = instant.stencil;
            let Some(fade) = receiver.checked_sub(first).and_then(|place| fades.get(place)) else {
                continue;
            };
            let position = self.position(receiver, sample);
            let pressure = weighted(excerpt, needed.start, position, self.ratio(), &mut weights);
            sound[sample] += fade * instant.gain * self.distances[receiver] * pressure;
        }
        Ok(())
    }

    /// The whole pass-by \[Pa\]; `pressure` gives the requested samples of a point's pressure.
    ///
    /// # Errors
    /// [`PassByError::ExcerptLength`] if it gives another number of samples.
    pub(crate) fn synthesise(
        &self,
        mut pressure: impl FnMut(usize, Range<i64>) -> Vec<f64>,
    ) -> Result<Vec<f64>, PassByError> {
        let mut sound = vec![0.0; self.samples];
        for receiver in 0..self.distances.len() {
            self.add(receiver, &pressure(receiver, self.needed(receiver)), &mut sound)?;
        }
        Ok(sound)
    }

    /// Highest of the levels at the microphone, and its sample before it, while the tyre is no farther than
    /// `half_length` \[m\] before or past the microphone: the coast-by level of UN R117 with L_AF and 10 m. `None`
    /// without such a sample.
    pub(crate) fn highest(&self, levels: &[f64], half_length: f64) -> Option<(usize, f64)> {
        let within = |sample: &usize| self.place(*sample).abs() <= half_length * (1.0 + 1e-12);
        let within_length = (0..self.samples.min(levels.len())).filter(within).map(|sample| (sample, levels[sample]));
        within_length.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Distance r travelled since the emission, and R, of the sound received at x \[m\].
    fn path(&self, x: f64) -> (f64, f64) {
        let mach = self.passage.speed / self.passage.sound_speed;
        let rest = 1.0 - mach * mach;
        let shortened = (x * x + rest * self.aside * self.aside).sqrt();
        ((shortened + mach * x) / rest, shortened)
    }

    fn instant(&self, sample: usize) -> Instant {
        let x = self.place(sample);
        let (distance, shortened) = self.path(x);
        let gain = if self.passage.amplification { distance / (shortened * shortened) } else { 1.0 / distance };
        let count = self.distances.len();
        let along = (self.passage.receivers[0][0] - x) / self.spacing;
        let first = (along as usize).clamp(1, count - 3) - 1;
        let fades = uniform_cubic(along - first as f64);
        Instant { emission: self.time(sample) - distance / self.passage.sound_speed, gain, stencil: (first, fades) }
    }

    /// Samples to which a point contributes, and one more at either end.
    fn reached(&self, receiver: usize) -> Range<usize> {
        let count = self.distances.len();
        let from = if receiver < STENCIL { 0 } else { receiver - 2 };
        let to = if receiver + STENCIL >= count { count } else { receiver + 2 };
        let sample = |point: usize| point as f64 * self.spacing / self.passage.speed * self.passage.output_rate;
        let first = (sample(from).floor() as usize).saturating_sub(1);
        first..(sample(to).ceil() as usize + 1).min(self.samples)
    }

    /// Position of tau + r_i/c among the samples of a point's pressure.
    fn position(&self, receiver: usize, sample: usize) -> f64 {
        let delay = self.distances[receiver] / self.passage.sound_speed;
        (self.instant(sample).emission + delay) * self.passage.input_rate
    }

    /// Spacing of the coarser samples over that of the input's.
    fn ratio(&self) -> f64 {
        (self.passage.input_rate / self.passage.output_rate).max(1.0)
    }
}

#[cfg(test)]
mod tests;
