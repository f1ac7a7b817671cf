//! Reasons for values outside their range: physics that the model lacks, and limits of the comparison.
//!
//! A reason is a hypothesis. It is named where it acts on the quantity, in that band and in that direction; an
//! experiment has to confirm it. A value outside its range without any reason indicates a fault.

use serde::Serialize;

use crate::scene::{Scene, Zone};

/// Reason that could explain a value outside its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Missing {
    /// Sidewalls that move against the belt and absorb its waves.
    Sidewalls,
    /// Tread pattern: blocks that strike the road, grooves that resonate.
    TreadPattern,
    /// Air squeezed out of the patch and its voids.
    AirInPatch,
    /// Friction: tread that sticks and slips.
    Friction,
    /// Contact over cells: contact by slices loses force above some 800 Hz.
    Cells,
    /// Other bands are too loud: this one is low beside their sum.
    OtherBands,
    /// Published values are of whole cars, with engines and the ground between.
    WholeCars,
    /// A named road stands in for the published one.
    OtherRoad,
    /// Temperature and losses of rubber at large strains.
    Losses,
}

impl Missing {
    /// Words in the tables.
    pub(crate) const fn title(self) -> &'static str {
        match self {
            Self::Sidewalls => "sidewalls at rest",
            Self::TreadPattern => "no tread pattern",
            Self::AirInPatch => "no air pumped in the patch",
            Self::Friction => "no friction",
            Self::Cells => "slices instead of cells",
            Self::OtherBands => "other bands too loud",
            Self::WholeCars => "published: whole cars",
            Self::OtherRoad => "another road stands in",
            Self::Losses => "losses at small strain",
        }
    }
}

/// Physics that a scene's model lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lacks {
    /// Sidewalls do not move.
    pub sidewalls: bool,
    /// Contact is resolved along the tyre only.
    pub cells: bool,
}

/// Kind of a compared quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compared {
    /// A third octave relative to the sum.
    Shape,
    /// Growth of a third octave, or of all.
    Growth,
    /// Overall level.
    Level,
    /// Difference of receivers.
    Receivers,
    /// Difference of roads.
    Roads,
    /// Rolling resistance.
    Resistance,
    /// Property of the standing tyre.
    Tyre,
}

/// Highest frequency of resonances of a belt between sidewalls at rest \[Hz\].
const BREATHING: f64 = 650.0;
/// Frequency above which tread pattern and air in the patch matter \[Hz\].
const PATTERN: f64 = 700.0;

impl Lacks {
    pub(crate) fn of(scene: &Scene) -> Self {
        Self { sidewalls: scene.tyre.sidewall.is_none(), cells: scene.contact.zone == Zone::Slices }
    }

    /// Reasons for a value outside its range, at a frequency where it has one \[Hz\]; `outside` is negative for a value
    /// below the range.
    pub(super) fn reasons(self, of: Compared, frequency: Option<f64>, outside: f64) -> Vec<Missing> {
        let (low, high) = (outside < 0.0, outside > 0.0);
        let rings = frequency.is_none_or(|frequency| frequency < BREATHING);
        let patterned = frequency.is_none_or(|frequency| frequency > PATTERN);
        use Missing::{AirInPatch, Cells, Friction, Losses, OtherBands, OtherRoad, Sidewalls, TreadPattern, WholeCars};
        let all: &[(bool, Missing)] = match of {
            Compared::Shape => &[
                (high && rings && self.sidewalls, Sidewalls),
                (low && patterned, TreadPattern),
                (low && patterned, AirInPatch),
                (low && patterned, Friction),
                (low && patterned && self.cells, Cells),
                (low, OtherBands),
            ],
            Compared::Growth => &[
                (rings && self.sidewalls, Sidewalls),
                (low && patterned, AirInPatch),
                (low && patterned, TreadPattern),
                (patterned && self.cells, Cells),
                (low, WholeCars),
            ],
            Compared::Level => &[
                (high && self.sidewalls, Sidewalls),
                (low, TreadPattern),
                (low, AirInPatch),
                (low, Friction),
                (low && self.cells, Cells),
            ],
            Compared::Receivers => &[(self.sidewalls, Sidewalls), (low, AirInPatch)],
            Compared::Roads => &[(true, OtherRoad), (high && patterned, AirInPatch), (self.cells, Cells)],
            Compared::Resistance => &[(true, Losses), (self.cells, Cells), (self.sidewalls, Sidewalls)],
            Compared::Tyre => &[],
        };
        if low || high { all.iter().filter(|(acts, _)| *acts).map(|(_, reason)| *reason).collect() } else { Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Lacks = Lacks { sidewalls: true, cells: true };

    #[test]
    fn reasons_act_in_their_bands_and_in_their_direction() {
        let reasons = |frequency, outside| ALL.reasons(Compared::Shape, Some(frequency), outside);
        assert_eq!(reasons(500.0, 8.0), [Missing::Sidewalls]);
        assert_eq!(reasons(315.0, -8.0), [Missing::OtherBands]);
        assert!(reasons(1250.0, -8.0).starts_with(&[Missing::TreadPattern, Missing::AirInPatch]));
        // Nothing that the model lacks makes 1.25 kHz too loud: a fault.
        assert_eq!(reasons(1250.0, 8.0), []);
        assert_eq!(reasons(1250.0, 0.0), []);
    }

    #[test]
    fn what_a_scene_has_is_no_reason() {
        let complete = Lacks { sidewalls: false, cells: false };
        assert_eq!(complete.reasons(Compared::Shape, Some(500.0), 8.0), []);
        assert!(!complete.reasons(Compared::Level, None, -8.0).contains(&Missing::Cells));
    }
}
