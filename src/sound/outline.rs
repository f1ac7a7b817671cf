//! What is in the way of a microphone: the tyre and the road.

use super::receivers::Position;

/// What a position is inside of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// The tyre, its wheel included: the body is closed at the sidewalls.
    Tyre,
    /// The road, or on it: a rigid road's surface belongs to the air, what is below does not.
    Road,
}

/// The undeformed tyre: a cylinder about the axle with rounded shoulders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TyreOutline {
    /// Outer radius \[m\].
    pub radius: f64,
    /// Width from sidewall to sidewall \[m\].
    pub width: f64,
    /// Radius of the rounding between tread and sidewall \[m\]; at most half of the width.
    pub shoulder: f64,
    /// Height of the axle's centre over the road \[m\]; less than the radius where the tyre is flattened.
    pub axle_height: f64,
}

impl TyreOutline {
    /// Distance from the tyre's surface \[m\], negative inside. The flattening at the road is left out: near it the
    /// distance is too small, never too large.
    pub fn distance(&self, position: Position) -> f64 {
        let [x, y, z] = position;
        // In the half plane of radius and |y| the outline is a rectangle with a rounded corner.
        let beyond = [
            x.hypot(z - self.axle_height) - (self.radius - self.shoulder),
            y.abs() - (0.5 * self.width - self.shoulder),
        ];
        let outside = beyond.map(|part| part.max(0.0));
        outside[0].hypot(outside[1]) + beyond[0].max(beyond[1]).min(0.0) - self.shoulder
    }

    /// What a position \[m\] is inside of; `None` in the air. The road comes first where both are.
    pub fn obstacle(&self, position: Position) -> Option<Obstacle> {
        if position[2] < 0.0 {
            Some(Obstacle::Road)
        } else if self.distance(position) < 0.0 {
            Some(Obstacle::Tyre)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::receivers::{CoastByLine, Side, close_proximity};
    use super::*;

    const TYRE: TyreOutline = TyreOutline { radius: 0.32, width: 0.2, shoulder: 0.03, axle_height: 0.305 };

    #[test]
    fn distances_are_those_of_tread_sidewall_and_shoulder() {
        for (position, distance) in [
            ([0.0, 0.0, 0.305], -0.1),
            ([0.0, 0.0, 0.305 + 0.4], 0.08),
            ([0.4, 0.05, 0.305], 0.08),
            ([0.1, 0.3, 0.305], 0.2),
            ([0.1, -0.3, 0.305], 0.2),
            ([0.29 + 0.03, 0.07 + 0.04, 0.305], 0.02),
            ([0.31, 0.0, 0.305], -0.01),
        ] {
            assert!((TYRE.distance(position) - distance).abs() < 1e-12, "{position:?}: {}", TYRE.distance(position));
        }
    }

    #[test]
    fn the_rounding_is_air_where_a_sharp_corner_would_be_tyre() {
        let corner = [0.315, 0.095, 0.305];
        assert_eq!(TYRE.obstacle(corner), None);
        assert_eq!(TyreOutline { shoulder: 0.0, ..TYRE }.obstacle(corner), Some(Obstacle::Tyre));
    }

    #[test]
    fn microphones_of_the_standards_are_in_the_air_and_others_are_not() {
        let [front, rear] = close_proximity(TYRE.width, Side::Right);
        for position in CoastByLine::default().positions().into_iter().chain([front, rear]) {
            assert_eq!(TYRE.obstacle(position), None, "{position:?}");
        }
        assert!((TYRE.distance(front) - 0.2).abs() < 1e-12);
        assert_eq!(TYRE.obstacle([5.0, 0.0, 0.0]), None);
        assert_eq!(TYRE.obstacle([5.0, 0.0, -1e-6]), Some(Obstacle::Road));
        assert_eq!(TYRE.obstacle([0.0, 0.0, 0.001]), Some(Obstacle::Tyre));
        assert_eq!(TYRE.obstacle([0.0, 0.0, -0.001]), Some(Obstacle::Road));
    }
}
