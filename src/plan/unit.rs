//! What work is counted in, and what a unit of it costs on one core.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::scene::TimeRule;

/// A unit of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// A fit of the influence functions, in fits of 512 elements to 1e-5.
    Fit,
    /// A pole read, checked, and made ready.
    Pole,
    /// An evaluation of the layered compliance.
    Evaluation,
    /// A pair of elements in the static solution.
    StaticPair,
    /// A multiply-add of drawing a random texture.
    TextureMultiplyAdd,
    /// A height resampled from a measured road.
    ResampledHeight,
    /// A slice's cell under springs.
    SpringCell,
    /// A pair of a slice's cells on a half-space.
    HalfSpacePair,
    /// A multiply-add of the direct history.
    DirectMultiplyAdd,
    /// A multiply-add of the recursion by poles, `bdf1`.
    Bdf1MultiplyAdd,
    /// The same, `bdf2`.
    Bdf2MultiplyAdd,
    /// The same, `trapezoidal`.
    TrapezoidalMultiplyAdd,
    /// The same, `sdirk2`.
    Sdirk2MultiplyAdd,
    /// The same, `sdirk3`.
    Sdirk3MultiplyAdd,
    /// The same, `first-order-hold`.
    HoldMultiplyAdd,
    /// A multiply-add of the transforms between elements and wavenumbers.
    TransformMultiplyAdd,
    /// A column of the window over a level slice.
    LevelColumn,
    /// A column of the window over a rough slice.
    RoughColumn,
    /// A point in contact on a smooth road, in a step.
    SmoothPoint,
    /// A point in contact on a rough road, in a step.
    RoughPoint,
    /// A multiply-add of the search.
    SearchMultiplyAdd,
    /// A multiply-add of the transforms of forces to wavenumbers and frequencies.
    VibrationMultiplyAdd,
    /// A pole at a frequency, for velocities.
    VibrationPole,
    /// A residue of the tangential displacement fitted.
    TangentialPole,
    /// A byte of a result array.
    OutputByte,
    /// A step: what belongs to no stage.
    Step,
    /// A plot.
    Plot,
}

impl Unit {
    /// The unit of the recursion by poles under a rule.
    pub const fn of_poles(rule: TimeRule) -> Self {
        match rule {
            TimeRule::Bdf1 => Self::Bdf1MultiplyAdd,
            TimeRule::Bdf2 => Self::Bdf2MultiplyAdd,
            TimeRule::Trapezoidal => Self::TrapezoidalMultiplyAdd,
            TimeRule::Sdirk2 => Self::Sdirk2MultiplyAdd,
            TimeRule::Sdirk3 => Self::Sdirk3MultiplyAdd,
            TimeRule::FirstOrderHold => Self::HoldMultiplyAdd,
        }
    }
}

/// Seconds of one core for each unit.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct UnitCosts {
    seconds: BTreeMap<Unit, f64>,
    /// Whether they were measured on this machine.
    pub measured: bool,
}

/// Measured on one core of an AMD EPYC with AVX-512, release build: what plans are checked with where nothing was
/// measured.
const TYPICAL: [(Unit, f64); 27] = [
    (Unit::Fit, 0.49),
    (Unit::Pole, 5e-6),
    (Unit::Evaluation, 7e-8),
    (Unit::StaticPair, 8e-7),
    (Unit::TextureMultiplyAdd, 7e-11),
    (Unit::ResampledHeight, 1e-8),
    (Unit::SpringCell, 2.7e-8),
    (Unit::HalfSpacePair, 3.2e-9),
    (Unit::DirectMultiplyAdd, 1e-10),
    (Unit::Bdf1MultiplyAdd, 5e-11),
    (Unit::Bdf2MultiplyAdd, 6e-11),
    (Unit::TrapezoidalMultiplyAdd, 6e-11),
    (Unit::Sdirk2MultiplyAdd, 7.5e-11),
    (Unit::Sdirk3MultiplyAdd, 8.5e-11),
    (Unit::HoldMultiplyAdd, 8e-11),
    (Unit::TransformMultiplyAdd, 1.2e-10),
    (Unit::LevelColumn, 8e-9),
    (Unit::RoughColumn, 2e-8),
    (Unit::SmoothPoint, 5e-8),
    (Unit::RoughPoint, 1.25e-7),
    (Unit::SearchMultiplyAdd, 1e-10),
    (Unit::VibrationMultiplyAdd, 4e-10),
    (Unit::VibrationPole, 1.6e-9),
    (Unit::TangentialPole, 8e-5),
    (Unit::OutputByte, 1.2e-9),
    (Unit::Step, 9e-7),
    (Unit::Plot, 2e-3),
];

impl Default for UnitCosts {
    fn default() -> Self {
        Self { seconds: BTreeMap::from(TYPICAL), measured: false }
    }
}

impl UnitCosts {
    /// Seconds of a unit.
    pub fn of(&self, unit: Unit) -> f64 {
        self.seconds.get(&unit).copied().unwrap_or_default()
    }

    /// Takes a measured value; one that is no positive number is left as it was.
    pub fn set(&mut self, unit: Unit, seconds: f64) {
        if seconds > 0.0 && seconds.is_finite() {
            self.seconds.insert(unit, seconds);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_has_a_typical_cost_and_what_is_no_cost_is_not_taken() {
        let mut costs = UnitCosts::default();
        assert!(TYPICAL.iter().all(|&(unit, seconds)| seconds > 0.0 && costs.of(unit) > 0.0));
        for rule in TimeRule::ALL {
            assert!(costs.of(Unit::of_poles(rule)) > 0.0);
        }
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            costs.set(Unit::Step, bad);
        }
        assert_eq!(costs, UnitCosts::default());
        let text = serde_json::to_string(&costs).unwrap();
        assert_eq!(serde_json::from_str::<UnitCosts>(&text).unwrap(), costs);
    }
}
