//! The joint front of accuracy against time as a table: what `preset` and `accuracy` choose from.
//!
//! Derived with `tyrewave study` on made dense asphalt, checked on other roads and speeds (tests/presets.rs); `tyrewave study SCENE --check-presets` checks them on any scene. A stated error is
//! the largest difference of a third octave of the contact force, 100 Hz to fmax, from a finer run of the same model (1024 elements or more, at least 48 steps in a period of fmax, cells of 1 mm) with the
//! axle at the same height: 1.2 times the worst seen in the derivation. That run is itself not converged in the time step: on a rough road the contact is of first order in it at best.

use serde::{Deserialize, Serialize};

use super::TimeRule;

/// A named row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// For trying out: fast, levels within a few decibels.
    Draft,
    /// For results.
    Standard,
    /// To compare others with.
    Reference,
}

/// Settings in terms that do not depend on tyre, speed and frequency, with what they are worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrontRow {
    /// Its preset.
    pub preset: Preset,
    /// Elements per texture wavelength V/fmax, at least.
    pub per_wavelength: f64,
    /// Longest element \[m\].
    pub longest_element: f64,
    /// Time rule where none is given.
    pub time_rule: TimeRule,
    /// Time steps in a period of fmax, at least; with another rule so many that its error is the same.
    pub steps_per_period: f64,
    /// Tolerance of the poles.
    pub pole_tolerance: f64,
    /// Widest cell across \[m\].
    pub cell: f64,
    /// Stated error \[dB\].
    pub error: f64,
    /// Work relative to the standard preset, on the default scene.
    pub cost: f64,
}

impl Preset {
    /// All presets, cheapest first.
    pub const ALL: [Self; 3] = [Self::Draft, Self::Standard, Self::Reference];

    /// The preset's name in a scene.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Standard => "standard",
            Self::Reference => "reference",
        }
    }

    /// Its row.
    pub const fn row(self) -> &'static FrontRow {
        &FrontRow::ALL[self as usize]
    }
}

impl FrontRow {
    /// The table, cheapest first.
    pub const ALL: [Self; 3] = [
        Self {
            preset: Preset::Draft,
            per_wavelength: 4.0,
            longest_element: 5e-3,
            time_rule: TimeRule::Bdf2,
            steps_per_period: 12.0,
            pole_tolerance: 1e-3,
            cell: 4e-3,
            error: 6.5,
            cost: 0.5,
        },
        Self {
            preset: Preset::Standard,
            per_wavelength: 5.5,
            longest_element: 4e-3,
            time_rule: TimeRule::Bdf2,
            steps_per_period: 20.0,
            pole_tolerance: 1e-4,
            cell: 3e-3,
            error: 5.0,
            cost: 1.0,
        },
        Self {
            preset: Preset::Reference,
            per_wavelength: 9.0,
            longest_element: 2.5e-3,
            time_rule: TimeRule::Bdf2,
            steps_per_period: 32.0,
            pole_tolerance: 1e-5,
            cell: 2e-3,
            error: 3.5,
            cost: 2.5,
        },
    ];

    /// The cheapest row whose stated error is not above an accuracy \[dB\]; `None` where no row is as accurate.
    pub fn within(accuracy: f64) -> Option<&'static Self> {
        Self::ALL.iter().find(|row| row.error <= accuracy)
    }

    /// The smallest stated error \[dB\].
    pub fn finest_error() -> f64 {
        Self::ALL.iter().map(|row| row.error).fold(f64::INFINITY, f64::min)
    }

    /// Cells across a contact width \[m\].
    pub fn cells(&self, contact_width: f64) -> usize {
        (contact_width / self.cell - 1e-9).ceil().max(2.0) as usize
    }

    /// Relative error of the rule's rate at fmax, phase and damping together: what another rule has to keep.
    pub fn rule_error(&self) -> f64 {
        let angle = std::f64::consts::TAU / self.steps_per_period;
        (self.time_rule.relative_rate(angle) - 1.0).norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_a_front_and_presets_are_its_rows() {
        for (preset, row) in Preset::ALL.into_iter().zip(&FrontRow::ALL) {
            assert_eq!((preset.row(), row.preset), (row, preset));
        }
        let pairs = FrontRow::ALL.windows(2);
        assert!(pairs.clone().all(|pair| pair[0].cost < pair[1].cost && pair[0].error > pair[1].error));
        assert!((Preset::Standard.row().cost - 1.0).abs() < 1e-12);
    }

    #[test]
    fn an_accuracy_gets_the_cheapest_row_that_keeps_it() {
        for row in &FrontRow::ALL {
            assert_eq!(FrontRow::within(row.error), Some(row));
            assert_ne!(FrontRow::within(0.99 * row.error), Some(row));
        }
        assert_eq!(FrontRow::within(0.99 * FrontRow::finest_error()), None);
        assert_eq!(FrontRow::within(100.0), Some(&FrontRow::ALL[0]));
    }
}
