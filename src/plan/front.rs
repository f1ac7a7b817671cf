//! The joint front of accuracy against time as a table: what `preset` and `accuracy` choose from.
//!
//! A stated error is the largest difference of a third octave of the contact force, [`STATED_FROM`] to fmax, from the
//! limit for small time steps, elements and cells, with the axle at the same height. The rows were set from made dense
//! asphalt at 80 km/h and hold on other roads at other speeds (docs/accuracy.md; an ignored test,
//! tests/suite/presets.rs).
//! `tyrewave study SCENE --check-presets` measures them on any scene.

use crate::scene::{Numerics, Preset, Road, Scene, TimeRule};

/// Lowest third octave that a stated error is about \[Hz\].
pub(crate) const STATED_FROM: f64 = 100.0;
/// Cells in the shortest wave that is asked for: dense asphalt at 30 km/h, up to 1 kHz, is 5 dB wrong with four.
const CELLS_IN_A_WAVE: f64 = 11.0;

/// Size of cells of a scene's road for levels up to `highest` \[Hz\], in m: that of the law, or [`Road::cell`] and
/// eleven of them at least in the texture wave that excites it.
pub(crate) fn cell_for(scene: &Scene, highest: f64) -> f64 {
    let resolved = || scene.road.cell().min(scene.rolling.speed() / highest / CELLS_IN_A_WAVE);
    scene.contact.cell_of_law(&scene.road).unwrap_or_else(resolved)
}

/// Settings in terms that do not depend on tyre, speed and frequency, with what they are worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrontRow {
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
    /// Tolerance of the contact conditions over cells.
    pub cell_tolerance: f64,
    /// Widest and longest cell of a made road of the default's wavelengths, where V/fmax is 22 mm at least \[m\].
    pub cell: f64,
    /// Tolerance of the slices' curves \[m\].
    pub slice_tolerance: f64,
    /// Stated error \[dB\].
    pub error: f64,
    /// Work relative to the standard preset, on the default scene.
    pub cost: f64,
}

impl FrontRow {
    /// The table, cheapest first.
    pub(crate) const ALL: [Self; 3] = [
        Self {
            preset: Preset::Draft,
            per_wavelength: 2.9,
            longest_element: 8e-3,
            time_rule: TimeRule::Sdirk2,
            steps_per_period: 2.9,
            pole_tolerance: 1e-3,
            cell_tolerance: 1e-4,
            cell: 2.6e-3,
            slice_tolerance: 1e-6,
            error: 3.0,
            cost: 0.5,
        },
        Self {
            preset: Preset::Standard,
            per_wavelength: 5.8,
            longest_element: 4e-3,
            time_rule: TimeRule::Sdirk2,
            steps_per_period: 5.8,
            pole_tolerance: 1e-4,
            cell_tolerance: 1e-5,
            cell: 2e-3,
            slice_tolerance: 3e-7,
            error: 1.0,
            cost: 1.0,
        },
        Self {
            preset: Preset::Reference,
            per_wavelength: 11.6,
            longest_element: 2e-3,
            time_rule: TimeRule::Sdirk2,
            steps_per_period: 11.6,
            pole_tolerance: 1e-5,
            cell_tolerance: 1e-6,
            cell: 1e-3,
            slice_tolerance: 1e-7,
            error: 0.3,
            cost: 2.5,
        },
    ];

    /// Returns the row of a preset.
    pub(crate) const fn of(preset: Preset) -> &'static Self {
        &Self::ALL[preset as usize]
    }

    /// The row that a scene's `preset` or `accuracy` chooses.
    pub(crate) fn asked_for(numerics: &Numerics) -> Option<&'static Self> {
        numerics.preset.map(Self::of).or_else(|| numerics.accuracy.and_then(Self::within))
    }

    /// From which frequency on \[Hz\] a scene's `preset` or `accuracy` states an error of its force levels, and which
    /// \[dB\].
    pub(crate) fn stated_error(numerics: &Numerics) -> Option<(f64, f64)> {
        Self::asked_for(numerics).map(|row| (STATED_FROM, row.error))
    }

    /// The cheapest row whose stated error is not above an accuracy \[dB\]; `None` where no row is as accurate.
    pub(crate) fn within(accuracy: f64) -> Option<&'static Self> {
        Self::ALL.iter().find(|row| row.error <= accuracy)
    }

    /// The smallest stated error \[dB\].
    pub(crate) fn finest_error() -> f64 {
        Self::ALL.iter().map(|row| row.error).fold(f64::INFINITY, f64::min)
    }

    /// Widest and longest cell of a scene's road for levels up to `highest` \[Hz\], in m.
    pub(crate) fn cell_for(&self, scene: &Scene, highest: f64) -> f64 {
        let of_law = scene.contact.cell_of_law(&scene.road);
        of_law.unwrap_or_else(|| self.cell * (cell_for(scene, highest) / Road::CELL))
    }

    /// Relative error of the rule's rate at fmax, phase and damping together: what another rule has to keep.
    pub(crate) fn rule_error(&self) -> f64 {
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
            assert_eq!((FrontRow::of(preset), row.preset), (row, preset));
        }
        let pairs = FrontRow::ALL.windows(2);
        assert!(pairs.clone().all(|pair| pair[0].cost < pair[1].cost && pair[0].error > pair[1].error));
        assert!((FrontRow::of(Preset::Standard).cost - 1.0).abs() < 1e-12);
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
