//! Microphones of the standards, in the frame of one tyre (see [`super`]): one file for each standard. The keys in a
//! scene are those of [`StandardReceiver`]; [`standard`](fn@standard) is the list.
//!
//! ```text
//!            z |                                     coast-by microphone
//!              |                                              o  1.2 m
//!         .----+----.      CPX
//!         |   tyre  |   0.2 m o  0.1 m
//!   ------'----+----'------------------------------------------------- y
//!              0         width/2 + 0.2 m                 7.5 m - offset
//! ```

pub(crate) mod circle;
pub(crate) mod coast_by;
pub(crate) mod cpx;
mod hemisphere;
mod obsi;

mod standard;

use super::frame::Position;
use crate::scene::{ReceiverPlace, StandardReceiver, Vehicle};
pub(crate) use circle::{CIRCLE_POSITIONS, circle};
pub(crate) use coast_by::{COAST_BY_DISTANCE, COAST_BY_HALF_LENGTH, COAST_BY_HEIGHT};
pub(crate) use cpx::close_proximity;
pub(crate) use standard::{Beside, Finding, Probes, Standard};

/// Microphones at a place of the scene.
pub(crate) fn standard(place: &ReceiverPlace) -> Box<dyn Standard> {
    match *place {
        ReceiverPlace::Position { position } => Box::new(Point(position)),
        ReceiverPlace::Standard(standard) => match standard {
            StandardReceiver::CoastBy { distance, height, vehicle, passage } => {
                Box::new(coast_by::CoastBy { distance, height, vehicle, passage })
            }
            StandardReceiver::Cpx => Box::new(cpx::Cpx),
            StandardReceiver::Circle { radius, height } => Box::new(circle::Circle { radius, height }),
            StandardReceiver::Hemisphere { radius } => Box::new(hemisphere::Hemisphere { radius }),
            StandardReceiver::Obsi => Box::new(obsi::Obsi),
        },
    }
}

/// A point that moves with the tyre.
struct Point(Position);

impl Standard for Point {
    fn name(&self) -> &'static str {
        "receiver"
    }

    fn points(&self, _: &Beside<'_>) -> Vec<Position> {
        vec![self.0]
    }

    fn finding(&self) -> Finding {
        Finding::Level
    }

    fn is_recorded(&self) -> bool {
        true
    }
}

impl Vehicle {
    /// A microphone as each tyre sees it, in its own frame \[m\]: front left, front right, rear left, rear right. The
    /// microphone is given in the frame of the vehicle, whose origin is on the road in the middle of the four.
    ///
    /// There is no bodywork, and each tyre is that of the run, not its mirror image.
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
    fn each_tyre_has_the_microphone_at_a_different_place() {
        let vehicle = Vehicle { wheelbase: 2.6, track: 1.5 };
        let seen = vehicle.seen_from_tyres([1.3, 7.5, 1.2]);
        assert_eq!(seen, [[0.0, 6.75, 1.2], [0.0, 8.25, 1.2], [2.6, 6.75, 1.2], [2.6, 8.25, 1.2]]);
    }
}
