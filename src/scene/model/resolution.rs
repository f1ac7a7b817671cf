//! Elements and time step from the highest frequency wanted.

use std::f64::consts::PI;

use super::TimeRule;
use crate::numeric::transform_length;

/// Elements round the tyre and steps per element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution {
    /// N.
    pub elements: usize,
    /// q.
    pub substeps: usize,
}

impl Resolution {
    /// Elements per texture wavelength V/fmax: averaging over an element takes sinc(pi/4) = 0.9 off it, 0.9 dB.
    pub const PER_WAVELENGTH: f64 = 4.0;
    /// Longest element \[m\]: 20 of them in a patch of 100 mm.
    pub const LONGEST_ELEMENT: f64 = 5e-3;
    /// Largest relative error of the rule's rate at fmax, phase and damping together.
    pub const RULE_ERROR: f64 = 0.05;
    /// Fewest elements that are proposed.
    const FEWEST_ELEMENTS: usize = 16;
    /// Most elements that are proposed: far more than any plan accepts.
    const MOST: f64 = (1_u64 << 30) as f64;

    /// For the frequency `highest` \[Hz\], circumference \[m\], speed \[m/s\] and rule; what is given stays. N is the next even number without prime factors above 5.
    pub fn new(
        highest: f64,
        circumference: f64,
        speed: f64,
        rule: TimeRule,
        elements: Option<usize>,
        substeps: Option<usize>,
    ) -> Self {
        let elements = elements.unwrap_or_else(|| {
            let longest = Self::LONGEST_ELEMENT.min(speed / (highest * Self::PER_WAVELENGTH));
            transform_length(((circumference / longest).min(Self::MOST).ceil() as usize).max(Self::FEWEST_ELEMENTS))
        });
        let substeps = substeps.unwrap_or_else(|| {
            let time_step = rule.largest_angle(Self::RULE_ERROR) / (2.0 * PI * highest);
            (circumference / elements as f64 / (speed * time_step) - 1e-9).ceil().clamp(1.0, Self::MOST) as usize
        });
        Self { elements, substeps }
    }

    /// Highest frequency of the texture that the elements can hold at all: two per wavelength \[Hz\].
    pub fn texture_limit(&self, circumference: f64, speed: f64) -> f64 {
        0.5 * speed * self.elements as f64 / circumference
    }

    /// Highest frequency at which the rule keeps [`Self::RULE_ERROR`] \[Hz\].
    pub fn rule_limit(&self, circumference: f64, speed: f64, rule: TimeRule) -> f64 {
        let steps_per_second = speed * (self.elements * self.substeps) as f64 / circumference;
        rule.largest_angle(Self::RULE_ERROR) * steps_per_second / (2.0 * PI)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_and_steps_follow_the_frequency_and_what_is_given_stays() {
        let of =
            |highest, rule, elements, substeps| Resolution::new(highest, 1.95, 80.0 / 3.6, rule, elements, substeps);
        let found = of(2000.0, TimeRule::Bdf2, None, None);
        assert_eq!(found, Resolution { elements: 720, substeps: 4 });
        assert!(found.rule_limit(1.95, 80.0 / 3.6, TimeRule::Bdf2) >= 2000.0);
        assert!(found.texture_limit(1.95, 80.0 / 3.6) >= 2.0 * 2000.0);
        assert_eq!(of(2000.0, TimeRule::Bdf2, Some(512), Some(3)), Resolution { elements: 512, substeps: 3 });
        assert!(of(2000.0, TimeRule::Sdirk3, None, None).substeps < found.substeps);
        // Low frequencies still resolve the patch.
        assert_eq!(of(50.0, TimeRule::Bdf2, None, None).elements, 400);
    }
}
