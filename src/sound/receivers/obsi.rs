//! On-board sound intensity (AASHTO T 360, SAE J2706): two probes beside the tyre, at the leading and the trailing edge
//! of the contact patch.
//!
//! Each probe is a pair of microphones 16 mm apart on a line across, its middle 102 mm (4 in) from the plane of the
//! sidewall and 76 mm (3 in) over the road. The level is the energetic mean of both, A-weighted, of the third octaves
//! from 400 Hz to 5 kHz. The standard prescribes a certain tyre at 97 km/h (60 mph); here tyre and speed are those of
//! the scene.

use super::standard::{Beside, Finding, Probes, Standard};
use crate::sound::frame::Position;

/// Distance of a probe's middle from the sidewall's plane \[m\].
const DISTANCE: f64 = 0.102;
/// Height over the road \[m\].
const HEIGHT: f64 = 0.076;
/// Distance between the microphones of a probe \[m\].
const SPACING: f64 = 0.016;

pub(super) struct Obsi;

impl Standard for Obsi {
    fn name(&self) -> &'static str {
        "obsi"
    }

    fn points(&self, beside: &Beside<'_>) -> Vec<Position> {
        let edge = 0.5 * (beside.patch_length)();
        let y = beside.half_width + DISTANCE;
        let probe = |x: f64| [[x, y - 0.5 * SPACING, HEIGHT], [x, y + 0.5 * SPACING, HEIGHT]];
        [probe(edge), probe(-edge)].concat()
    }

    fn finding(&self) -> Finding {
        let pairs = vec![("leading", [0, 1]), ("trailing", [2, 3])];
        Finding::Intensity(Probes { pairs, spacing: SPACING, frequencies: 400.0..5000.0 })
    }

    fn is_recorded(&self) -> bool {
        true
    }

    fn is_stored(&self, _: bool) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_probes_point_outwards_at_both_edges_of_the_patch() {
        let points = Obsi.points(&Beside { half_width: 0.1, patch_length: &|| 0.12 });
        assert_eq!((points[0][0], points[3][0]), (0.06, -0.06));
        let Finding::Intensity(Probes { pairs, spacing, .. }) = Obsi.finding() else { panic!("no intensity") };
        for (_, [inner, outer]) in pairs {
            let [inner, outer] = [points[inner], points[outer]];
            assert!(
                (outer[1] - inner[1] - spacing).abs() < 1e-12 && (outer[0] - inner[0]).abs() < 1e-12,
                "{inner:?} {outer:?}"
            );
            assert!((0.5 * (inner[1] + outer[1]) - 0.1 - 0.102).abs() < 1e-12);
        }
    }
}
