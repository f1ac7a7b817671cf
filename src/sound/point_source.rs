//! Equivalent point source of a tyre on a hard road: the sound power that models of traffic noise assign to it.
//!
//! A source of the power W at the height h has the distance r_1 from a receiver, and its image in the road r_2. Models
//! differ in how they count the road:
//!
//! ```text
//! CNOSSOS-EU   p^2/(rho c W) = 1/(2 pi r_1^2)
//! Nord2000     p^2/(rho c W) = (1/r_1^2 + 1/r_2^2 + 2 C/(r_1 r_2))/(4 pi)
//! ```
//!
//! CNOSSOS-EU (Directive (EU) 2015/996, 2.2.1) has a source at 0.05 m that radiates evenly into the half space above
//! the road, the first reflection included in its power. Nord2000 (Jonasson, SP Report 2006:12, as Harmonoise) has 80 %
//! of the rolling noise of a car at 0.01 m and 20 % at 0.3 m; its power is that of the free field, and the reflection
//! is a part of the propagation. C is the mean of cos(2 pi f (r_2 - r_1)/c) over a band of equal power per hertz. Close
//! to the road r_1 = r_2 and C = 1: a level in Nord2000 is 10 lg 2 = 3.0 dB below that in CNOSSOS-EU, for the same
//! pressure.
//!
//! For a pressure that is a mean over positions k, with p_0 = 20 uPa and W_0 = 1 pW,
//!
//! ```text
//! L_W = L_p - 10 lg(rho c W_0/p_0^2 mean_k p_k^2/(rho c W))
//! ```

use std::f64::consts::{PI, TAU};

use super::frame::Position;
use super::levels::level;
use super::power::REFERENCE_POWER;
use crate::numeric::sinc;
use crate::radiation::Air;
use crate::response::ThirdOctaveBand;

/// Treatment of the reflection by the road in a model of traffic noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RoadReflection {
    /// Included in the power, which radiates evenly into the half space.
    InPower,
    /// Image of the source, which interferes with it.
    Image,
}

/// Point sources of a model of traffic noise, for rolling noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PointSources {
    /// Heights \[m\], each with its share of the power.
    sources: &'static [(f64, f64)],
    road: RoadReflection,
}

impl PointSources {
    /// Source of CNOSSOS-EU, vehicles of category 1.
    pub(crate) const CNOSSOS_EU: Self = Self { sources: &[(0.05, 1.0)], road: RoadReflection::InPower };
    /// Sources of Nord2000, vehicles of category 1.
    pub(crate) const NORD2000: Self = Self { sources: &[(0.01, 0.8), (0.3, 0.2)], road: RoadReflection::Image };

    /// Level of the sound power \[dB re 1 pW\] that causes a level of the mean square over some positions \[dB re 20
    /// uPa\] in a band. The source is on the road at the frame's origin. NaN without a position.
    pub(crate) fn power_level(
        &self,
        level_there: f64,
        band: ThirdOctaveBand,
        positions: &[Position],
        air: &Air,
    ) -> f64 {
        let sum: f64 = positions.iter().map(|position| self.spread(band, *position, air)).sum();
        let mean = sum / positions.len() as f64;
        level_there - level(REFERENCE_POWER * air.impedance() * mean)
    }

    /// p^2/(rho c W) at a position \[1/m^2\], its mean over a band.
    fn spread(&self, band: ThirdOctaveBand, [x, y, z]: Position, air: &Air) -> f64 {
        let one = |&(height, share): &(f64, f64)| {
            let distance = |height: f64| x.hypot(y).hypot(z - height);
            let [direct, reflected] = [distance(height), distance(-height)];
            share
                * match self.road {
                    RoadReflection::InPower => (TAU * direct * direct).recip(),
                    RoadReflection::Image => {
                        // The mean of the cosine over a band is that at its middle, times sinc of half its width.
                        let delay = TAU * (reflected - direct) / air.sound_speed;
                        let middle = 0.5 * (band.lower_edge() + band.upper_edge());
                        let coherence = (delay * middle).cos() * sinc(0.5 * delay * band.width());
                        let both = 2.0 * coherence / (direct * reflected);
                        (direct.powi(-2) + reflected.powi(-2) + both) / (4.0 * PI)
                    }
                }
        };
        self.sources.iter().map(one).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiation::draft::monopole;

    fn air() -> Air {
        Air::at(20.0).unwrap()
    }

    #[test]
    fn monopoles_over_the_road_have_the_power_that_they_were_given() {
        // The program's monopole over a rigid road: power W in the free field, p^2 = 4 pi rho c W |G|^2.
        let positions = [[0.0, 7.5, 1.2], [4.0, 7.5, 1.2], [-9.0, 7.5, 1.2], [0.0, 1.0, 3.0]];
        let power = 2.5e-3;
        for band in (-16..=10).map(ThirdOctaveBand) {
            let mean_square = |position: Position, height: f64| {
                let steps = 4000;
                let square = |step: i32| {
                    let frequency = band.lower_edge() + band.width() * (f64::from(step) + 0.5) / f64::from(steps);
                    monopole([0.0, 0.0, height], position, TAU * frequency / air().sound_speed).norm_sqr()
                };
                let mean = (0..steps).map(square).sum::<f64>() / f64::from(steps);
                4.0 * PI * air().impedance() * power * mean
            };
            let received = |position: &Position| 0.8 * mean_square(*position, 0.01) + 0.2 * mean_square(*position, 0.3);
            let mean = positions.iter().map(received).sum::<f64>() / positions.len() as f64;
            let found = PointSources::NORD2000.power_level(level(mean), band, &positions, &air());
            let exact = 10.0 * (power / 1e-12).log10();
            assert!((found - exact).abs() < 1e-4, "{}: {found} dB, given {exact} dB", band.label());
        }
    }

    #[test]
    fn a_half_space_is_3_db_above_the_free_field() {
        // A pressure of 1 Pa at r: W = 2 pi r^2 p^2/(rho c).
        let position = [3.0, 4.0, 0.05];
        let band = ThirdOctaveBand(-10);
        let found = PointSources::CNOSSOS_EU.power_level(level(1.0), band, &[position], &air());
        let exact = 10.0 * (TAU * 25.0 / air().impedance() / 1e-12).log10();
        assert!((found - exact).abs() < 1e-10, "{found} for {exact}");
        // At a low frequency, and low over the road, source and image are in phase.
        let far = [0.0, 300.0, 1.0];
        let [half, free] = [PointSources::CNOSSOS_EU, PointSources::NORD2000]
            .map(|sources| sources.power_level(60.0, band, &[far], &air()));
        assert!((half - free - 10.0 * 2.0_f64.log10()).abs() < 1e-3, "{half} and {free}");
        assert!(PointSources::NORD2000.power_level(60.0, band, &[], &air()).is_nan());
    }

    #[test]
    fn a_detour_of_half_a_wave_cancels_the_source() {
        let high = PointSources { sources: &[(0.3, 1.0)], road: RoadReflection::Image };
        let position = [0.0, 7.5, 1.2];
        let detour = 7.5_f64.hypot(1.5) - 7.5_f64.hypot(0.9);
        let band = ThirdOctaveBand::containing(0.5 * air().sound_speed / detour).unwrap();
        let [low, cancelled] = [ThirdOctaveBand(-10), band].map(|band| high.spread(band, position, &air()));
        // In the band the phase differs from pi by 0.73 at most: 1 - cos is 0.25 there, and 2 where both are in phase.
        assert!(low / cancelled > 7.0, "{low} and {cancelled}");
    }
}
