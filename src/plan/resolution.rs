//! Elements, time step and tolerances from the highest frequency and the accuracy wanted, and the
//! requirements of the model that is fitted to a scene's tyre.

use std::f64::consts::PI;

use crate::numeric::transform_length;
use crate::scene::{Numerics, Scene, TimeRule, Zone};
use crate::time_rule::Advance;
use crate::tyre::influence::Field;
use crate::tyre::poles::FitOptions;

use super::front::FrontRow;

/// Requirements of a scene on its resolution.
///
/// Without a row of the table: four elements per texture wavelength V/fmax, whose averaging lowers the texture at fmax
/// by 0.9 dB, none longer than 5 mm, and 5 % in phase and damping of the time rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Need {
    /// Highest frequency \[Hz\].
    pub highest: f64,
    /// Row of the table that a preset or an accuracy has chosen.
    pub row: Option<&'static FrontRow>,
}

impl Need {
    /// Largest relative error of the rule's rate, phase and damping together, at which a frequency still counts as
    /// resolved.
    pub(crate) const RULE_ERROR: f64 = 0.05;

    /// Elements per texture wavelength V/fmax.
    pub(crate) fn per_wavelength(&self) -> f64 {
        self.row.map_or(4.0, |row| row.per_wavelength)
    }

    /// Longest element \[m\]; 5 mm are 20 elements in a patch of 100 mm.
    pub(crate) fn longest_element(&self) -> f64 {
        self.row.map_or(5e-3, |row| row.longest_element)
    }

    /// Longest way that the tyre rolls in a step of several elements \[m\]: an element of the row's slices, since the
    /// patch has to be resolved in time, too.
    fn longest_step(&self) -> f64 {
        self.row.map_or(self.longest_element(), |row| FrontRow::of(row.preset, Zone::Slices).longest_element)
    }

    /// Largest relative error of the rule's rate at fmax, phase and damping together.
    pub(crate) fn rule_error(&self) -> f64 {
        self.row.map_or(Self::RULE_ERROR, FrontRow::rule_error)
    }

    /// Largest w dt of a rule at fmax.
    pub(crate) fn largest_angle(&self, rule: TimeRule) -> f64 {
        match self.row {
            Some(row) if row.time_rule == rule => 2.0 * PI / row.steps_per_period,
            _ => rule.largest_angle(self.rule_error()),
        }
    }
}

/// Elements around the tyre, and how far it rolls in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Resolution {
    /// Number N of elements.
    pub elements: usize,
    /// Steps per element, or elements per step.
    pub advance: Advance,
}

impl Resolution {
    /// Most elements that are proposed: far more than any plan accepts.
    const MOST: f64 = (1_u64 << 30) as f64;

    /// Chooses N, and q or s, for a need, circumference \[m\], speed \[m/s\] and rule; given values stay. N is the
    /// next even number without prime factors above 5, s the largest power of two for which N is a multiple of 2 s.
    pub(crate) fn new(
        need: Need,
        circumference: f64,
        speed: f64,
        rule: TimeRule,
        elements: Option<usize>,
        advance: Option<Advance>,
    ) -> Self {
        let elements = elements.unwrap_or_else(|| {
            let longest = need.longest_element().min(speed / (need.highest * need.per_wavelength()));
            let least = (circumference / longest).min(Self::MOST).ceil() as usize;
            let unit = advance.map_or(1, |advance| match advance.elements_per_step {
                1 => 1,
                elements_per_step => 2 * elements_per_step,
            });
            unit * transform_length(least.max(Numerics::FEWEST_ELEMENTS).div_ceil(unit))
        });
        let advance = advance.unwrap_or_else(|| {
            let time_step = need.largest_angle(rule) / (2.0 * PI * need.highest);
            let element = circumference / elements as f64;
            let substeps = (element / (speed * time_step) - 1e-9).ceil().clamp(1.0, Self::MOST) as usize;
            let longest = (speed * time_step).min(need.longest_step()) * (1.0 + 1e-9);
            let fits = |&s: &usize| s as f64 * element <= longest && elements.is_multiple_of(2 * s);
            let elements_per_step = (1..8).map(|doublings| 1 << doublings).take_while(fits).last().unwrap_or(1);
            Advance { substeps, elements_per_step }
        });
        Self { elements, advance }
    }

    /// Highest frequency of texture that the elements can represent: two per wavelength \[Hz\].
    pub(crate) fn texture_limit(&self, circumference: f64, speed: f64) -> f64 {
        0.5 * speed * self.elements as f64 / circumference
    }

    /// Highest frequency at which the rule keeps the need's [`Need::rule_error`] \[Hz\].
    pub(crate) fn rule_limit(&self, need: Need, circumference: f64, speed: f64, rule: TimeRule) -> f64 {
        need.largest_angle(rule) * self.steps_per_second(circumference, speed) / (2.0 * PI)
    }

    pub(crate) fn steps_per_second(&self, circumference: f64, speed: f64) -> f64 {
        speed * self.advance.steps(self.elements) as f64 / circumference
    }

    /// Key of the scene that says how far the tyre rolls in a step.
    pub(crate) const fn key_of_advance(&self) -> &'static str {
        if self.advance.elements_per_step > 1 { "numerics.elements_per_step" } else { "numerics.substeps" }
    }
}

/// Options of the model of a scene's tyre under forces on a field.
pub fn fit_options(scene: &Scene, field: Field) -> FitOptions {
    let Numerics { elements, substeps, elements_per_step, pole_tolerance, influence_tolerance, .. } = scene.numerics;
    let highest_speed = scene.rolling.speed() * substeps as f64 / elements_per_step as f64;
    FitOptions {
        driven: field,
        tolerance: pole_tolerance,
        // The sums must be more accurate than the fit to them.
        influence_tolerance: influence_tolerance.min(0.01 * pole_tolerance),
        ..FitOptions::new(&scene.tyre, elements, highest_speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_and_steps_follow_frequency_unless_given() {
        let need = |highest| Need { highest, row: None };
        let of = |highest, rule, elements, substeps: Option<usize>| {
            Resolution::new(need(highest), 1.95, 80.0 / 3.6, rule, elements, substeps.map(Advance::from))
        };
        let found = of(2000.0, TimeRule::Bdf2, None, None);
        assert_eq!(found, Resolution { elements: 720, advance: 4.into() });
        assert!(found.rule_limit(need(2000.0), 1.95, 80.0 / 3.6, TimeRule::Bdf2) >= 2000.0);
        assert!(found.texture_limit(1.95, 80.0 / 3.6) >= 2.0 * 2000.0);
        assert_eq!(of(2000.0, TimeRule::Bdf2, Some(512), Some(3)), Resolution { elements: 512, advance: 3.into() });
        assert!(of(2000.0, TimeRule::Sdirk3, None, None).advance.substeps < found.advance.substeps);
        // Small elements take the steps that the frequency needs, none longer than 5 mm.
        let step_of = |highest, elements| of(highest, TimeRule::Sdirk3, Some(elements), None).advance;
        assert_eq!(step_of(1000.0, 512), Advance::within(1));
        assert_eq!(step_of(1000.0, 2048), Advance::over(4));
        assert_eq!(step_of(50.0, 2048), Advance::over(4));
        assert_eq!(step_of(50.0, 4100), Advance::over(2));
        // Low frequencies still need the patch resolved.
        assert_eq!(of(50.0, TimeRule::Bdf2, None, None).elements, 400);
    }

    #[test]
    fn a_row_is_kept_at_every_speed_and_by_every_rule() {
        for row in FrontRow::OF_SLICES.iter().chain(&FrontRow::OF_CELLS) {
            let need = Need { highest: 1000.0, row: Some(row) };
            for speed in [10.0, 22.0, 40.0] {
                let found = Resolution::new(need, 1.95, speed, row.time_rule, None, None);
                let element = 1.95 / found.elements as f64;
                assert!(element <= row.longest_element && speed / 1000.0 / element >= row.per_wavelength, "{row:?}");
                assert!(found.steps_per_second(1.95, speed) >= (1.0 - 1e-6) * 1000.0 * row.steps_per_period, "{row:?}");
                let other = Resolution::new(need, 1.95, speed, TimeRule::Sdirk3, None, None);
                let angle = 2.0 * PI * 1000.0 / other.steps_per_second(1.95, speed);
                let error = (TimeRule::Sdirk3.relative_rate(angle) - 1.0).norm();
                assert!(other.elements == found.elements && error <= row.rule_error(), "{row:?}: {error}");
            }
        }
    }
}
