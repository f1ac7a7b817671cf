//! Where the standards put their microphones, in the frame of one tyre (see [`super`]).
//!
//! ```text
//!            z |                                     coast-by microphone
//!              |                                              o  1.2 m
//!         .----+----.      CPX
//!         |   tyre  |   0.2 m o  0.1 m
//!   ------'----+----'------------------------------------------------- y
//!              0         width/2 + 0.2 m                 7.5 m - offset
//! ```

use crate::scene::{StandardReceiver, Vehicle};

/// Where a microphone is \[m\]: x forward, y to the left, z up from the road below the axle's centre.
pub type Position = [f64; 3];

/// A side of the tyre.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Side {
    /// y > 0.
    #[default]
    Left,
    /// y < 0.
    Right,
}

impl Side {
    /// Returns the sign of y: +1 to the left, -1 to the right.
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

/// Distance of the coast-by microphone from the centre of the track \[m\]; UN R117 allows +-0.05.
pub const COAST_BY_DISTANCE: f64 = StandardReceiver::DISTANCE;
/// Height of the coast-by microphone over the road \[m\]; UN R117 allows +-0.02.
pub const COAST_BY_HEIGHT: f64 = StandardReceiver::HEIGHT;
/// Half the length of track over which the maximum is read \[m\].
pub const COAST_BY_HALF_LENGTH: f64 = 10.0;

/// The positions that the microphone beside the road takes as seen from the tyre that passes it.
///
/// UN R117 annex 3 (1.1.3 and figure 1; the same geometry as ISO 362-1 and, for tyres, ISO 13325): microphone 7.5 m
/// +-0.05 m from the centre line CC' of the track and 1.2 m +-0.02 m above it; the highest level L_AF is read while the
/// vehicle is between the lines AA' and BB', 10 m before and behind the microphone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoastByLine {
    /// Number of positions, at least 2. A pass-by cross-faded between 81 of them over 20 m, the default, is 0.3 % wrong
    /// at 4 kHz for a source as large as the tyre, between 41 it is 0.5 % at 2.5 kHz and 4 % at 4 kHz.
    pub receivers: usize,
    /// Largest x, and less the smallest \[m\]. Longer than 10 m gives the detector time before the first reading.
    pub half_length: f64,
    /// From the centre of the track to the microphone \[m\].
    pub distance: f64,
    /// Height of the microphone over the road \[m\].
    pub height: f64,
    /// How far the tyre runs from the centre of the track towards the microphone \[m\], less than 0 for one on the far
    /// side. 0, the default: one tyre stands for the vehicle. Tyres at +-0.75 m have, at equal power, a mean of their
    /// mean squares 0.12 dB above that.
    pub offset: f64,
    /// On which side of the tyre the microphone is.
    pub side: Side,
}

impl Default for CoastByLine {
    fn default() -> Self {
        Self {
            receivers: 81,
            half_length: COAST_BY_HALF_LENGTH,
            distance: COAST_BY_DISTANCE,
            height: COAST_BY_HEIGHT,
            offset: 0.0,
            side: Side::Left,
        }
    }
}

impl CoastByLine {
    /// The positions, in the order in which the microphone takes them: from the front to the rear.
    pub fn positions(&self) -> Vec<Position> {
        let spacing = 2.0 * self.half_length / (self.receivers.max(2) - 1) as f64;
        let y = self.side.sign() * (self.distance - self.offset);
        let x = |index: usize| self.half_length - spacing * index as f64;
        (0..self.receivers.max(2)).map(|index| [x(index), y, self.height]).collect()
    }
}

/// Distance of the close-proximity microphones from the plane of the undeformed sidewall \[m\].
pub const CPX_DISTANCE: f64 = 0.2;
/// Height of the close-proximity microphones over the road \[m\].
pub const CPX_HEIGHT: f64 = 0.1;
/// How far they are ahead of and behind the axle's plane \[m\].
pub const CPX_ADVANCE: f64 = 0.2;

/// The two mandatory microphones of the close-proximity method, front and rear, beside a tyre of a width \[m\]: 0.2 m
/// from the undeformed sidewall, 0.1 m high, 0.2 m ahead of and behind the axle's plane, hence at 45 and 135 degrees to
/// the direction of travel (ISO 11819-2:2017). The CPX level of a run is the [energetic mean] of both.
///
/// [energetic mean]: super::levels::energetic_mean
pub fn close_proximity(width: f64, side: Side) -> [Position; 2] {
    let y = side.sign() * (0.5 * width + CPX_DISTANCE);
    [[CPX_ADVANCE, y, CPX_HEIGHT], [-CPX_ADVANCE, y, CPX_HEIGHT]]
}

/// Positions of a circle that show a directivity: every five degrees.
pub const CIRCLE_POSITIONS: usize = 72;

/// Positions on a level circle about the tyre \[m\], for its directivity: from straight ahead (x > 0) by the left.
pub fn circle(radius: f64, height: f64, count: usize) -> Vec<Position> {
    let angle = |index: usize| std::f64::consts::TAU * index as f64 / count as f64;
    (0..count).map(|index| angle(index).sin_cos()).map(|(sin, cos)| [radius * cos, radius * sin, height]).collect()
}

impl Vehicle {
    /// A microphone as each tyre sees it, in its own frame: front left, front right, rear left, rear right. The
    /// microphone is given in the frame of the vehicle, whose origin is on the road in the middle of the four.
    ///
    /// Bodywork is not there, and each tyre is that of the run, not its mirror image.
    pub fn seen_from_tyres(&self, microphone: Position) -> [Position; Self::TYRES] {
        [(0.5, 0.5), (0.5, -0.5), (-0.5, 0.5), (-0.5, -0.5)].map(|(axle, side)| {
            let [x, y, z] = microphone;
            [x - axle * self.wheelbase, y - side * self.track, z]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::levels::{energetic_mean, energetic_sum};
    use super::*;

    #[test]
    fn the_coast_by_microphone_glides_from_the_front_to_the_rear() {
        let line = CoastByLine::default().positions();
        assert_eq!((line.len(), line[0], line[80]), (81, [10.0, 7.5, 1.2], [-10.0, 7.5, 1.2]));
        assert!((line[40][0]).abs() < 1e-12 && (line[0][0] - line[1][0] - 0.25).abs() < 1e-12);
        let near = CoastByLine {
            offset: 0.75,
            side: Side::Right,
            receivers: 161,
            half_length: 15.0,
            ..CoastByLine::default()
        }
        .positions();
        assert_eq!((near[0], near[160]), ([15.0, -6.75, 1.2], [-15.0, -6.75, 1.2]));
    }

    #[test]
    fn one_tyre_in_the_middle_stands_for_the_four_of_a_vehicle() {
        // A point source's level falls with the distance squared.
        let level = |[x, y, z]: Position| -10.0 * (x * x + y * y + z * z).log10();
        let vehicle = Vehicle { wheelbase: 0.0, track: 1.5 };
        let four = vehicle.seen_from_tyres([0.0, 7.5, 1.2]).map(level);
        let off = energetic_mean(four) - level([0.0, 7.5, 1.2]);
        assert!((off - 0.123).abs() < 0.001, "{off}");
        assert!((energetic_sum(four) - energetic_mean(four) - 6.0206).abs() < 1e-4);
    }

    #[test]
    fn each_tyre_sees_the_microphone_from_its_own_place() {
        let vehicle = Vehicle { wheelbase: 2.6, track: 1.5 };
        let seen = vehicle.seen_from_tyres([1.3, 7.5, 1.2]);
        assert_eq!(seen, [[0.0, 6.75, 1.2], [0.0, 8.25, 1.2], [2.6, 6.75, 1.2], [2.6, 8.25, 1.2]]);
    }

    #[test]
    fn close_proximity_microphones_are_at_45_degrees_from_where_the_sidewall_leaves_the_axle_plane() {
        let [front, rear] = close_proximity(0.2, Side::Left);
        assert_eq!((front, rear), ([0.2, 0.1 + 0.2, 0.1], [-0.2, 0.1 + 0.2, 0.1]));
        assert!((front[0].atan2(front[1] - 0.1).to_degrees() - 45.0).abs() < 1e-9);
        assert!(close_proximity(0.2, Side::Right)[0][1] < 0.0);
    }

    #[test]
    fn a_circle_starts_ahead_and_goes_by_the_left() {
        let around = circle(2.0, 0.3, 4);
        let expected = [[2.0, 0.0, 0.3], [0.0, 2.0, 0.3], [-2.0, 0.0, 0.3], [0.0, -2.0, 0.3]];
        let close = |a: &Position, b: &Position| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(around.iter().zip(&expected).all(|(a, b)| close(a, b)), "{around:?}");
    }
}
