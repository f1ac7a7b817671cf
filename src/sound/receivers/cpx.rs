//! Two microphones close to the tyre that move with it (ISO 11819-2).

use super::standard::{Beside, Finding, Standard};
use crate::sound::frame::{Position, Side};

/// Distance of the close-proximity microphones from the plane of the undeformed sidewall \[m\].
pub(crate) const CPX_DISTANCE: f64 = 0.2;
/// Height of the close-proximity microphones over the road \[m\].
pub(crate) const CPX_HEIGHT: f64 = 0.1;
/// Distance of the microphones ahead of and behind the axle's plane \[m\].
pub(crate) const CPX_ADVANCE: f64 = 0.2;

/// The two mandatory microphones of the close-proximity method, front and rear, beside a tyre of a width \[m\]: 0.2 m
/// from the undeformed sidewall, 0.1 m high, 0.2 m ahead of and behind the axle's plane, hence at 45 and 135 degrees to
/// the direction of travel (ISO 11819-2:2017). The CPX level of a run is the [energetic mean] of both.
///
/// [energetic mean]: crate::sound::levels::energetic_mean
pub fn close_proximity(width: f64, side: Side) -> [Position; 2] {
    let y = side.sign() * (0.5 * width + CPX_DISTANCE);
    [[CPX_ADVANCE, y, CPX_HEIGHT], [-CPX_ADVANCE, y, CPX_HEIGHT]]
}

pub(super) struct Cpx;

impl Standard for Cpx {
    fn name(&self) -> &'static str {
        "cpx"
    }

    fn points(&self, beside: &Beside<'_>) -> Vec<Position> {
        close_proximity(2.0 * beside.half_width, Side::Left).to_vec()
    }

    fn finding(&self) -> Finding {
        Finding::Level
    }

    fn is_recorded(&self) -> bool {
        true
    }

    fn has_stated_draft(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn close_proximity_microphones_are_at_45_degrees() {
        let [front, rear] = close_proximity(0.2, Side::Left);
        assert_eq!((front, rear), ([0.2, 0.1 + 0.2, 0.1], [-0.2, 0.1 + 0.2, 0.1]));
        assert!((front[0].atan2(front[1] - 0.1).to_degrees() - 45.0).abs() < 1e-9);
        assert!(close_proximity(0.2, Side::Right)[0][1] < 0.0);
    }
}
