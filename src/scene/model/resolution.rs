//! Elements, time step and tolerances from the highest frequency and the accuracy wanted.

use std::f64::consts::PI;

use serde::Serialize;

use super::TimeRule;
use crate::numeric::transform_length;

/// What a scene wants of its resolution.
///
/// Without an accuracy: four elements per texture wavelength V/fmax, whose averaging takes 0.9 dB off the texture at fmax, and 5 % in phase and damping of the time rule. With
/// an accuracy of a dB, one half of it is left to each of the two: averaging over an element takes 20 lg(1/sinc(pi/p)) ~ 8.7 (pi/p)^2/6 dB off at p elements per wavelength; an
/// error e of the rule's rate moves the level of a mass or a bed of springs by up to 2 x 8.7 e dB. Rules of thumb for what can be foreseen: what roughness in the contact adds is not in them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Need {
    /// Highest frequency \[Hz\].
    pub highest: f64,
    /// Accuracy of levels \[dB\].
    pub accuracy: Option<f64>,
}

/// 20 lg e: decibels of a relative change of amplitude.
const DECIBELS_PER_NEPER: f64 = 20.0 * std::f64::consts::LOG10_E;

impl Need {
    /// Elements per texture wavelength V/fmax.
    pub fn per_wavelength(&self) -> f64 {
        self.accuracy.map_or(4.0, |accuracy| PI / (6.0 * 0.5 * accuracy / DECIBELS_PER_NEPER).sqrt()).max(2.0)
    }

    /// Largest relative error of the rule's rate at fmax, phase and damping together.
    pub fn rule_error(&self) -> f64 {
        self.accuracy.map_or(0.05, |accuracy| 0.5 * accuracy / (2.0 * DECIBELS_PER_NEPER))
    }

    /// Tolerance of the poles: the standard 1e-5 leaves 1e-6 of the force's peak (measured), far below any level; it is worth relaxing only where decibels do not matter.
    pub fn pole_tolerance(&self) -> f64 {
        self.accuracy.map_or(1e-5, |accuracy| (1e-5 * accuracy).clamp(1e-6, 1e-4))
    }

    /// Width of a road cell across \[m\]. Measured on dense asphalt, by springs: a slice pressed in by 1 mm is 36, 9 and 2 % stiffer with cells of 4, 2 and 1 mm than with 0.5 mm.
    pub fn cell(&self) -> f64 {
        self.accuracy.map_or(2e-3, |accuracy| (2e-3 * accuracy).clamp(0.5e-3, 4e-3))
    }
}

/// A setting that the scene left open, and why it is what it is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Choice {
    /// The key in the scene.
    pub key: &'static str,
    /// Its value.
    pub value: String,
    /// Why.
    pub reason: String,
}

/// Elements round the tyre and steps per element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution {
    /// N.
    pub elements: usize,
    /// q.
    pub substeps: usize,
}

impl Resolution {
    /// Longest element \[m\]: 20 of them in a patch of 100 mm.
    pub const LONGEST_ELEMENT: f64 = 5e-3;
    /// Fewest elements that are proposed.
    const FEWEST_ELEMENTS: usize = 16;
    /// Most elements that are proposed: far more than any plan accepts.
    const MOST: f64 = (1_u64 << 30) as f64;

    /// For a need, circumference \[m\], speed \[m/s\] and rule; what is given stays. N is the next even number without prime factors above 5.
    pub fn new(
        need: Need,
        circumference: f64,
        speed: f64,
        rule: TimeRule,
        elements: Option<usize>,
        substeps: Option<usize>,
    ) -> Self {
        let elements = elements.unwrap_or_else(|| {
            let longest = Self::LONGEST_ELEMENT.min(speed / (need.highest * need.per_wavelength()));
            transform_length(((circumference / longest).min(Self::MOST).ceil() as usize).max(Self::FEWEST_ELEMENTS))
        });
        let substeps = substeps.unwrap_or_else(|| {
            let time_step = rule.largest_angle(need.rule_error()) / (2.0 * PI * need.highest);
            (circumference / elements as f64 / (speed * time_step) - 1e-9).ceil().clamp(1.0, Self::MOST) as usize
        });
        Self { elements, substeps }
    }

    /// Highest frequency of the texture that the elements can hold at all: two per wavelength \[Hz\].
    pub fn texture_limit(&self, circumference: f64, speed: f64) -> f64 {
        0.5 * speed * self.elements as f64 / circumference
    }

    /// Highest frequency at which the rule keeps the need's [`Need::rule_error`] \[Hz\].
    pub fn rule_limit(&self, need: Need, circumference: f64, speed: f64, rule: TimeRule) -> f64 {
        let steps_per_second = speed * (self.elements * self.substeps) as f64 / circumference;
        rule.largest_angle(need.rule_error()) * steps_per_second / (2.0 * PI)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_and_steps_follow_the_frequency_and_what_is_given_stays() {
        let need = |highest| Need { highest, accuracy: None };
        let of = |highest, rule, elements, substeps| {
            Resolution::new(need(highest), 1.95, 80.0 / 3.6, rule, elements, substeps)
        };
        let found = of(2000.0, TimeRule::Bdf2, None, None);
        assert_eq!(found, Resolution { elements: 720, substeps: 4 });
        assert!(found.rule_limit(need(2000.0), 1.95, 80.0 / 3.6, TimeRule::Bdf2) >= 2000.0);
        assert!(found.texture_limit(1.95, 80.0 / 3.6) >= 2.0 * 2000.0);
        assert_eq!(of(2000.0, TimeRule::Bdf2, Some(512), Some(3)), Resolution { elements: 512, substeps: 3 });
        assert!(of(2000.0, TimeRule::Sdirk3, None, None).substeps < found.substeps);
        // Low frequencies still resolve the patch.
        assert_eq!(of(50.0, TimeRule::Bdf2, None, None).elements, 400);
    }

    #[test]
    fn an_accuracy_is_kept_by_averaging_and_by_the_rule() {
        for accuracy in [0.1, 0.5, 1.0, 2.0] {
            let need = Need { highest: 1000.0, accuracy: Some(accuracy) };
            let x = PI / need.per_wavelength();
            let averaging = -20.0 * (x.sin() / x).log10();
            assert!(averaging < 0.53 * accuracy && averaging > 0.47 * accuracy, "{accuracy}: {averaging}");
            assert!(20.0 * (1.0 + need.rule_error()).powi(2).log10() <= 0.5 * accuracy);
        }
        let of = |accuracy| Resolution::new(Need { highest: 1000.0, accuracy }, 1.95, 22.0, TimeRule::Bdf2, None, None);
        assert!(of(Some(0.5)).elements > of(None).elements && of(Some(0.1)).elements > of(Some(0.5)).elements);
    }
}
