//! A circle round the tyre, for its directivity.

use super::standard::{Beside, Finding, Standard};
use crate::sound::frame::Position;

/// Number of positions on a circle for a directivity: every five degrees.
pub(crate) const CIRCLE_POSITIONS: usize = 72;

/// `count` positions on a level circle about the tyre \[m\], from straight ahead (x > 0) by the left.
pub fn circle(radius: f64, height: f64, count: usize) -> Vec<Position> {
    let angle = |index: usize| std::f64::consts::TAU * index as f64 / count as f64;
    (0..count).map(|index| angle(index).sin_cos()).map(|(sin, cos)| [radius * cos, radius * sin, height]).collect()
}

/// Receivers on a circle; radius and height \[m\].
pub(super) struct Circle {
    pub(super) radius: f64,
    pub(super) height: f64,
}

impl Standard for Circle {
    fn name(&self) -> &'static str {
        "circle"
    }

    fn points(&self, _: &Beside<'_>) -> Vec<Position> {
        circle(self.radius, self.height, CIRCLE_POSITIONS)
    }

    fn finding(&self) -> Finding {
        Finding::Directivity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_starts_ahead_and_goes_by_the_left() {
        let around = circle(2.0, 0.3, 4);
        let expected = [[2.0, 0.0, 0.3], [0.0, 2.0, 0.3], [-2.0, 0.0, 0.3], [0.0, -2.0, 0.3]];
        let close = |a: &Position, b: &Position| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(around.iter().zip(&expected).all(|(a, b)| close(a, b)), "{around:?}");
    }
}
