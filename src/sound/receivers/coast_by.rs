//! A microphone beside the road that the tyre passes (UN R117, ISO 362).

use super::standard::{Beside, Finding, Standard};
use crate::scene::{StandardReceiver, Vehicle};
use crate::sound::frame::{Position, Side};

/// Road before a passage in which the detector settles \[m\]: 0.27 s at 80 km/h. The same at all speeds, so that they
/// share the transfers.
const LEAD: f64 = 6.0;
/// Distance between the points of a passage \[m\], in proportion larger for a microphone farther away than the
/// standard's.
const SPACING: f64 = 0.25;
/// Distances of a microphone beside the road, and its greatest height, for which a draft's error over the whole line is
/// that of the standard's \[m\].
const DRAFT_PASSED: std::ops::RangeInclusive<f64> = 5.0..=10.0;
const DRAFT_HEIGHT: f64 = 2.0;

/// Distance of the coast-by microphone from the centre of the track \[m\]; UN R117 allows +-0.05.
pub(crate) const COAST_BY_DISTANCE: f64 = StandardReceiver::DISTANCE;
/// Height of the coast-by microphone over the road \[m\]; UN R117 allows +-0.02.
pub(crate) const COAST_BY_HEIGHT: f64 = StandardReceiver::HEIGHT;
/// Half the length of track over which the maximum is read \[m\].
pub(crate) const COAST_BY_HALF_LENGTH: f64 = 10.0;

/// Positions of the microphone beside the road as seen from the tyre that passes it.
///
/// UN R117 annex 3 (1.1.3 and figure 1; the same geometry as ISO 362-1 and, for tyres, ISO 13325): microphone 7.5 m
/// +-0.05 m from the centre line CC' of the track and 1.2 m +-0.02 m above it; the highest level L_AF is read while the
/// vehicle is between the lines AA' and BB', 10 m before and behind the microphone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoastByLine {
    /// Number of positions, at least 2. A pass-by cross-faded between 81 of them over 20 m, the default, has an error
    /// of 0.3 % at 4 kHz for a source as large as the tyre; between 41 it is 0.5 % at 2.5 kHz and 4 % at 4 kHz.
    pub receivers: usize,
    /// Largest x, and the negative of the smallest \[m\]. More than 10 m lets the detector settle before the first
    /// reading.
    pub half_length: f64,
    /// Distance of the microphone from the centre of the track \[m\].
    pub distance: f64,
    /// Height of the microphone over the road \[m\].
    pub height: f64,
    /// Distance of the tyre's path from the centre of the track towards the microphone \[m\], negative on the far side.
    /// 0, the default: one tyre represents the vehicle. Tyres at +-0.75 m have, at equal power, a mean of their mean
    /// squares 0.12 dB above that.
    pub offset: f64,
    /// Side of the tyre on which the microphone is.
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
    /// Positions in the order in which the microphone takes them: from the front to the rear.
    pub fn positions(&self) -> Vec<Position> {
        let spacing = 2.0 * self.half_length / (self.receivers.max(2) - 1) as f64;
        let y = self.side.sign() * (self.distance - self.offset);
        let x = |index: usize| self.half_length - spacing * index as f64;
        (0..self.receivers.max(2)).map(|index| [x(index), y, self.height]).collect()
    }
}

/// Receiver of a coast-by; distance, height and length of the passage in metres.
pub(super) struct CoastBy {
    pub(super) distance: f64,
    pub(super) height: f64,
    pub(super) vehicle: Option<Vehicle>,
    pub(super) passage: Option<f64>,
}

impl CoastBy {
    fn length(&self) -> f64 {
        self.passage.unwrap_or_else(|| StandardReceiver::passage(self.distance, self.height))
    }

    /// Points of a passage along which the tyre is followed for `followed` metres to either side, its path `offset`
    /// nearer to the microphone.
    fn line(&self, followed: f64, offset: f64) -> Vec<Position> {
        let Self { distance, height, .. } = *self;
        let near = COAST_BY_DISTANCE.hypot(COAST_BY_HEIGHT);
        let spacing = SPACING * (distance.hypot(height) / near).max(1.0);
        // As many points as reach that far; the lead is needed before the passage alone.
        let steps = ((followed + LEAD) / spacing - 1e-9).ceil();
        let half_length = steps * spacing;
        let receivers = 2 * steps as usize + 1;
        let line = CoastByLine { half_length, receivers, distance, height, offset, ..Default::default() };
        let mut positions = line.positions();
        positions.truncate(receivers - (LEAD / spacing) as usize);
        positions
    }
}

impl Standard for CoastBy {
    fn name(&self) -> &'static str {
        "coast-by"
    }

    fn points(&self, _: &Beside<'_>) -> Vec<Position> {
        match self.vehicle {
            None => self.line(0.5 * self.length(), 0.0),
            // Tyres of one side see the microphone on the same line, the front ones later by the wheelbase.
            Some(Vehicle { wheelbase, track }) => {
                let sides = [0.5 * track, -0.5 * track];
                sides.into_iter().flat_map(|offset| self.line(0.5 * (self.length() + wheelbase), offset)).collect()
            }
        }
    }

    fn finding(&self) -> Finding {
        Finding::Passage
    }

    fn passage(&self) -> Option<f64> {
        Some(self.length())
    }

    fn vehicle(&self) -> Option<Vehicle> {
        self.vehicle
    }

    fn has_stated_draft(&self) -> bool {
        DRAFT_PASSED.contains(&self.distance) && self.height <= DRAFT_HEIGHT
    }
}

#[cfg(test)]
mod tests {
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
}
