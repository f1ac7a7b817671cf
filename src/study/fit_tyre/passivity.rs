//! Checks that measured values are a driving-point mobility at all, or finds what else they are.
//!
//! The power that a force puts into a passive body is Re(Y) F^2/2: Re(Y) >= 0, a phase within +-90 degrees, beyond it
//! by its uncertainty at most. Accelerance i w Y has Im >= 0, receptance Y/(i w) Im <= 0. Where the phase leaves
//! several answers, or none, the starting tyre's mobilities decide: a fit moves levels by less than a factor ten.

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;
use thiserror::Error;

use super::measured::MeasuredPoint;
use super::misfit::{DECIBELS, Uncertainty};
use crate::scene::short;

/// A phase this many standard deviations beyond +-90 degrees is outside.
const BEYOND: f64 = 3.0;
/// One value in so many may lie outside: of normally distributed errors one in 740 does.
const ONE_IN: usize = 200;
/// Median difference of levels from the starting tyre's that no fit removes \[dB\].
const FAR: f64 = 20.0;
/// The same of phases, in degrees.
const TURNED: f64 = 45.0;

/// Quantity that the values are instead of a mobility.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum Instead {
    #[error(
        "Its values are those of an accelerance (imaginary part 0 or more): divide by i w, w = 2 pi f, or give the \
         universal file (dataset 58), which says what it holds"
    )]
    Accelerance,
    #[error(
        "Its values are those of a receptance (imaginary part 0 or less): multiply by i w, w = 2 pi f, or give the \
         universal file (dataset 58), which says what it holds"
    )]
    Receptance,
    #[error(
        "With the opposite sign it would be one: force and velocity were counted in opposite directions; turn the \
         sign, or the phase by 180 degrees"
    )]
    OppositeSign,
    #[error(
        "With the opposite sign of the phase it would be one: it has the time factor exp(-i w t); turn the sign of \
         the imaginary part, or of the phase"
    )]
    OtherTimeFactor,
    #[error("Its phases are in radians, and phase_deg is in degrees: multiply by 180/pi")]
    Radians,
    #[error("Its unit is another one, such as mm/(N s), or m/(kN s)")]
    OtherUnits,
    #[error(
        "Neither as an accelerance nor as a receptance nor with the opposite sign is it one: the phase is wrong (a \
         delay, a filter in one channel), or force and velocity are at two points; leave frequencies out at which \
         nothing was measured (--lowest, --highest), or state the phases' uncertainty (--phase-error)"
    )]
    WrongPhase,
}

/// Values that are no driving-point mobility.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("this is not a driving-point mobility in m/(N s): {evidence}. {instead}")]
pub struct NoMobility {
    /// Fault found, in words.
    pub evidence: String,
    /// Quantity that the values are instead, as far as the data show.
    pub instead: Instead,
}

impl Instead {
    /// The mobility that a value would be, if it were this quantity.
    fn mobility(self, point: &MeasuredPoint) -> Complex64 {
        let (value, i_omega) = (point.mobility, Complex64::new(0.0, TAU * point.frequency));
        match self {
            Self::Accelerance => value / i_omega,
            Self::Receptance => value * i_omega,
            Self::OppositeSign => -value,
            Self::OtherTimeFactor => value.conj(),
            Self::Radians => Complex64::from_polar(value.norm(), value.arg().to_degrees()),
            Self::OtherUnits | Self::WrongPhase => value,
        }
    }
}

/// Refuses values that are no driving-point mobility; `computed` are the starting tyre's mobilities at the same points.
///
/// # Errors
/// [`NoMobility`].
pub(super) fn judge(
    points: &[MeasuredPoint],
    uncertainty: Uncertainty,
    computed: &[Complex64],
) -> Result<(), NoMobility> {
    let limit = 90.0 + BEYOND * uncertainty.phase;
    let is_outside = |value: Complex64| value.arg().to_degrees().abs() > limit;
    let outside: Vec<&MeasuredPoint> = points.iter().filter(|point| is_outside(point.mobility)).collect();
    let is_passive = |instead: Instead| {
        ONE_IN * points.iter().filter(|point| is_outside(instead.mobility(point))).count() <= points.len()
    };
    let distances = |instead: Instead| {
        let ratios = || points.iter().zip(computed).map(|(point, computed)| instead.mobility(point) / computed);
        [
            median(ratios().map(|ratio| DECIBELS * ratio.norm().ln())),
            median(ratios().map(|ratio| ratio.arg().to_degrees().abs())),
        ]
    };
    let level = |instead: Instead| distances(instead)[0].abs();
    // 1. Phases outside +-90 degrees: another quantity or sign.
    let [given_level, given_phase] = distances(Instead::OtherUnits);
    if ONE_IN * outside.len() > points.len() {
        let by_level = |a: &Instead, b: &Instead| level(*a).total_cmp(&level(*b));
        let candidates = [Instead::Accelerance, Instead::Receptance, Instead::OppositeSign];
        let nearest = candidates.into_iter().filter(|&instead| is_passive(instead)).min_by(by_level);
        // A phase of +-90 degrees alone looks like an accelerance or a receptance, at the level of a mobility.
        let instead = nearest.filter(|&instead| level(instead) <= FAR || given_level.abs() > FAR);
        let first = outside
            .iter()
            .min_by(|a, b| a.frequency.total_cmp(&b.frequency))
            .map_or((0.0, 0.0), |point| (point.frequency, point.mobility.arg().to_degrees()));
        let evidence = format!(
            "its real part is below 0 by more than its uncertainty at {} of {} values, first at {} Hz (phase {:.0} \
             degrees, uncertain by {} degrees), so that the tyre would give off power",
            outside.len(),
            points.len(),
            short((100.0 * first.0).round() / 100.0),
            first.1,
            uncertainty.phase
        );
        return Err(NoMobility { evidence, instead: instead.unwrap_or(Instead::WrongPhase) });
    }
    // 2. Phases are possible, levels are not: another quantity with such phases, or another unit.
    if given_level.abs() > FAR {
        let fits = |instead: &Instead| is_passive(*instead) && level(*instead) <= FAR;
        let instead = [Instead::Accelerance, Instead::Receptance].into_iter().find(fits);
        let evidence = format!(
            "its levels are {:.0} dB {} those of the starting tyre (median), which no fit can reach",
            given_level.abs(),
            if given_level > 0.0 { "above" } else { "below" }
        );
        return Err(NoMobility { evidence, instead: instead.unwrap_or(Instead::OtherUnits) });
    }
    // 3. Levels agree, phases do not: another time factor, or radians.
    let is_small = |point: &MeasuredPoint| point.mobility.arg().to_degrees().abs() <= PI;
    let turned = match distances(Instead::OtherTimeFactor)[1] {
        conjugate if given_phase > TURNED && conjugate < 0.5 * given_phase => Some(Instead::OtherTimeFactor),
        _ if points.iter().all(is_small) && distances(Instead::Radians)[1] < 0.5 * given_phase => {
            Some(Instead::Radians)
        }
        _ => None,
    };
    match turned {
        Some(instead) => {
            let evidence = format!("its phases are {given_phase:.0} degrees from those of the starting tyre (median)");
            Err(NoMobility { evidence, instead })
        }
        None => Ok(()),
    }
}

/// Upper median; 0 for no values.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

#[cfg(test)]
mod tests {
    use super::super::measured::read;
    use super::*;

    /// Points of a damped oscillator: phases from 14 over 40 to -40 degrees.
    fn tyre() -> Vec<MeasuredPoint> {
        let mobility = |frequency: f64| {
            let i_omega = Complex64::new(0.0, TAU * frequency);
            (i_omega * 2e-6 + 0.002) / (1.0 + 2e-4 * i_omega + 1e-8 * i_omega * i_omega)
        };
        let at = |frequency| MeasuredPoint { frequency, patch: 0.02, mobility: mobility(frequency) };
        (0..40).map(|step| at(50.0 * 1.11_f64.powi(step))).collect()
    }

    /// Verdict on changed values, for a starting tyre whose mobility is 1.5 times the measured one.
    fn reported(points: &[MeasuredPoint], change: impl Fn(Complex64, f64) -> Complex64) -> Option<Instead> {
        let computed: Vec<Complex64> = points.iter().map(|point| 1.5 * point.mobility).collect();
        reported_of(points, &computed, change)
    }

    fn reported_of(
        points: &[MeasuredPoint],
        computed: &[Complex64],
        change: impl Fn(Complex64, f64) -> Complex64,
    ) -> Option<Instead> {
        let changed: Vec<MeasuredPoint> = points
            .iter()
            .map(|point| MeasuredPoint { mobility: change(point.mobility, point.frequency), ..*point })
            .collect();
        judge(&changed, Uncertainty { level: 0.5, phase: 3.0 }, computed).err().map(|refused| refused.instead)
    }

    #[test]
    fn what_is_no_driving_point_mobility_is_named() {
        let points = tyre();
        let i_omega = |frequency: f64| Complex64::new(0.0, TAU * frequency);
        let turn = |degrees: f64| Complex64::from_polar(1.0, degrees.to_radians());
        assert_eq!(reported(&points, |value, _| value), None);
        assert_eq!(reported(&points, |value, frequency| value * i_omega(frequency)), Some(Instead::Accelerance));
        assert_eq!(reported(&points, |value, frequency| value / i_omega(frequency)), Some(Instead::Receptance));
        assert_eq!(reported(&points, |value, frequency| value * i_omega(frequency) / 9.81), Some(Instead::Accelerance));
        assert_eq!(reported(&points, |value, _| -value), Some(Instead::OppositeSign));
        assert_eq!(reported(&points, |value, _| value * 1e3), Some(Instead::OtherUnits));
        assert_eq!(reported(&points, |value, _| value * turn(90.0)), Some(Instead::WrongPhase));
        assert_eq!(reported(&points, |value, _| value * turn(-90.0)), Some(Instead::WrongPhase));
        // A delay of a millisecond between the channels.
        assert_eq!(reported(&points, |value, frequency| value * turn(-0.36 * frequency)), Some(Instead::WrongPhase));
        // As much as the uncertainty allows.
        let edge =
            |value: Complex64, _| Complex64::from_polar(value.norm(), value.arg().signum() * 98.0_f64.to_radians());
        assert_eq!(reported(&points, edge), None);
    }

    #[test]
    fn an_accelerance_under_the_titles_of_a_mobility_is_no_mobility() {
        let [mobility, accelerance] = [
            include_str!("../../../tests/reference/fit_tyre/mobility.csv"),
            include_str!("../../../tests/reference/fit_tyre/accelerance_as_mobility.csv"),
        ]
        .map(|text| read(text.as_bytes(), 0.136).unwrap());
        let computed: Vec<Complex64> = mobility.iter().map(|point| point.mobility).collect();
        let uncertainty = Uncertainty { level: 0.5, phase: 3.0 };
        assert_eq!(judge(&mobility, uncertainty, &computed), Ok(()));
        let refused = judge(&accelerance, uncertainty, &computed).unwrap_err();
        assert_eq!(refused.instead, Instead::Accelerance);
        let reported = refused.to_string();
        assert!(
            reported.contains("below 0 by more than its uncertainty at 25 of 30 values, first at 50 Hz"),
            "{reported}"
        );
        for (change, instead) in [
            ((|value, i_omega| value / i_omega) as fn(Complex64, Complex64) -> Complex64, Instead::Receptance),
            (|value, _| -value, Instead::OppositeSign),
            (|value, _| value.conj(), Instead::OtherTimeFactor),
            (|value, _| value * Complex64::i(), Instead::WrongPhase),
        ] {
            assert_eq!(
                reported_of(&mobility, &computed, |value, f| change(value, Complex64::new(0.0, TAU * f))),
                Some(instead)
            );
        }
    }

    #[test]
    fn a_receptance_below_resonance_is_known_by_its_level() {
        let low: Vec<MeasuredPoint> = tyre().into_iter().filter(|point| point.frequency < 1000.0).collect();
        let receptance = |value: Complex64, frequency: f64| value / Complex64::new(0.0, TAU * frequency);
        assert!(low.iter().all(|point| receptance(point.mobility, point.frequency).re > 0.0));
        assert_eq!(reported(&low, receptance), Some(Instead::Receptance));
    }

    #[test]
    fn time_factor_and_radians_are_recognised_by_phases() {
        let stiff: Vec<MeasuredPoint> = tyre()
            .into_iter()
            .map(|point| MeasuredPoint { mobility: Complex64::from_polar(0.01, 1.0), ..point })
            .collect();
        assert_eq!(reported(&stiff, |value, _| value.conj()), Some(Instead::OtherTimeFactor));
        let radians = |value: Complex64, _| Complex64::from_polar(value.norm(), value.arg().to_radians());
        assert_eq!(reported(&stiff, radians), Some(Instead::Radians));
    }
}
