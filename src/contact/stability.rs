//! Is the inverse of a discretised tyre stable?
//!
//! Contact prescribes displacements and asks for forces: F(zeta) = u(zeta)/w(zeta) for every wavenumber. A zero of w
//! inside the unit disk is a force that grows by 1/|zeta| a step while no element moves: the contact chatters for ever,
//! however small the step.
//!
//! w is analytic in the disk (the tyre's poles are stable), so the number of zeros inside |zeta| = r is the number of
//! turns of w round zero along that circle (argument principle), for two radii: refused and marginal. The circle is
//! followed in steps that turn w by less than 0.8 rad.
//!
//! w is real at real zeta and conjugate at conjugate zeta, so that half a circle suffices. Of a tyre that turns the
//! waves forwards and backwards are conjugate to each other there: on the lower half the one is what the other is on
//! the upper, both have as many zeros, and these are found from the upper halves of both.
//!
//! An A-stable quadrature of a passive tyre has no such zero: it maps the disk into Re s > 0, where Re(s H) > 0. There
//! delta(zeta) w_n(zeta), with the same delta for all wavenumbers, is positive real, which a compression to the
//! elements of the patch keeps: the patch alone is stable, too. Runge-Kutta rules mix their stages and have this proof
//! for the whole circumference only; the patch rests on the smooth-road tests.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::history::transfer::{Transfer, first_weight};
use crate::numeric::in_parallel;
use crate::time_rule::{Rates, TimeRule};
use crate::tyre::influence::Field;
use crate::tyre::poles::{Direction, RationalModel};

/// A force that grows by more than a tenth a step is refused: |zeta| below 1/1.1.
pub(crate) const UNSTABLE: f64 = 0.909;
/// A force that grows by less than one in a thousand a step is below what the fitted poles can resolve; between the
/// two lies the trapezoidal rule, whose symbol evaluates the model far beyond its band.
pub(crate) const MARGINAL: f64 = 0.999;
/// Largest turn of w between two points of the circle \[rad\].
const TURN: f64 = 0.8;
/// |w(-1)|^(1/stages) relative to the first weight below which a rule rings at half the sampling frequency.
const RINGING: f64 = 1e-2;

/// A zero of the discrete transfer function inside the unit disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnstableZero {
    /// Wavenumber n.
    pub wavenumber: usize,
    /// The zero zeta itself.
    pub zeta: Complex64,
    /// Frequency of the growing force \[Hz\].
    pub frequency: f64,
    /// Wavenumbers that have zeros this deep in the disk: |zeta| < `UNSTABLE` or, for a marginal one, `MARGINAL`.
    pub wavenumbers: usize,
}

/// Stability of a tyre's inverse under a rule at a time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stability {
    /// The zero with the smallest |zeta| < `UNSTABLE`, if there is any.
    pub unstable: Option<UnstableZero>,
    /// The zero with the smallest |zeta| between `UNSTABLE` and `MARGINAL`, if there is none deeper.
    pub marginal: Option<UnstableZero>,
    /// Smallest over the wavenumbers of |w(-1)| relative to the first weight: the response that remains at half the
    /// sampling frequency.
    pub at_half_sampling: f64,
    /// Smallest and largest first weight, times N: the eigenvalues of G0 \[m/N\].
    pub eigenvalues: (f64, f64),
}

impl Stability {
    /// Examines every wavenumber; `spring` \[m/N\] is the compliance in series with each element. `None` if the model
    /// does not hold the field.
    pub fn of(model: &RationalModel, field: Field, rule: TimeRule, time_step: f64, spring: f64) -> Option<Self> {
        let spring = spring / model.elements as f64;
        let circles = [UNSTABLE, MARGINAL].map(|radius| WindingCircle::new(radius, rule));
        let found = in_parallel::made(model.largest_wavenumber() + 1, |n| {
            let mut modes = model.modes(n, field)?;
            modes.constant += spring;
            let first = first_weight(&modes, rule, time_step);
            let w = Transfer::new(modes, Direction::Forwards, rule, time_step);
            // Just inside -1: the trapezoidal symbol is infinite there.
            let end = w.at(Complex64::new(-1.0 + 1e-9, 0.0)).norm().powf(1.0 / rule.stages() as f64);
            let backwards =
                (!modes.odd.is_empty()).then(|| Transfer::new(modes, Direction::Backwards, rule, time_step));
            let zero = |circle| smallest_zero(&w, backwards.as_ref(), circle);
            Some((circles.each_ref().map(zero), end / first, first))
        });
        let found: Vec<_> = found.into_iter().collect::<Option<_>>()?;
        let zero = |which: usize| {
            let zeros = || found.iter().enumerate().filter_map(|(n, entry)| Some((n, entry.0[which]?)));
            let worst = zeros().min_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
            worst.map(|(wavenumber, zeta)| UnstableZero {
                wavenumber,
                zeta,
                frequency: zeta.arg().abs() / (2.0 * PI * time_step),
                wavenumbers: zeros().count(),
            })
        };
        let unstable = zero(0);
        let elements = model.elements as f64;
        Some(Self {
            unstable,
            marginal: if unstable.is_some() { None } else { zero(1) },
            at_half_sampling: found.iter().fold(f64::INFINITY, |a, entry| a.min(entry.1)),
            eigenvalues: found
                .iter()
                .map(|entry| elements * entry.2)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x))),
        })
    }

    /// True if the force rings at half the sampling frequency without decay.
    pub fn rings(&self) -> bool {
        self.at_half_sampling < RINGING || self.marginal.is_some()
    }
}

/// Points from which a circle is followed, the same for every wavenumber.
struct WindingCircle {
    radius: f64,
    /// Angle and the rule's rates there.
    points: Vec<(f64, Option<Rates>)>,
}

impl WindingCircle {
    /// Angles are spaced geometrically towards zeta = 1, where resonances of a fine time step crowd, and evenly
    /// towards -1.
    fn new(radius: f64, rule: TimeRule) -> Self {
        let angles = (0..=320).map(|k| match k {
            0 => 0.0,
            1..=256 => 1e-5 * (0.5 * PI / 1e-5).powf(f64::from(k - 1) / 255.0),
            _ => 0.5 * PI * (1.0 + f64::from(k - 256) / 64.0),
        });
        let points = angles.map(|angle| (angle, rule.rates(Complex64::from_polar(radius, angle)))).collect();
        Self { radius, points }
    }
}

/// Zero of smallest modulus inside a circle, if the winding number says that there is one; of the waves forwards and,
/// if they differ, `backwards`. Where Newton's method finds none, -r stands for it.
fn smallest_zero(w: &Transfer<'_>, backwards: Option<&Transfer<'_>>, circle: &WindingCircle) -> Option<Complex64> {
    // Undecided is no zero: only what is sure is refused.
    if zeros(w, backwards, circle)? == 0 {
        return None;
    }
    let radius = circle.radius;
    let mut best: Option<Complex64> = None;
    for w in std::iter::once(w).chain(backwards) {
        for ring in 1..=6 {
            for step in 0..=6 {
                let start = Complex64::from_polar(radius * f64::from(ring) / 6.5, PI * f64::from(step) / 6.0);
                if let Some(zero) = newton(w, start).filter(|zero| zero.norm() < radius)
                    && best.is_none_or(|best| zero.norm() < best.norm())
                {
                    best = Some(zero);
                }
            }
        }
    }
    // The count is what decides; a zero that Newton's method cannot find is still one.
    best.or(Some(Complex64::new(-radius, 0.0)))
}

/// Number of zeros inside a circle of radius r: half turns of w along its upper half, from the real w(r) to the real
/// w(-r), or of the waves forwards and backwards together by whole turns. `None` where [`upper_half`] has none.
fn zeros(w: &Transfer<'_>, backwards: Option<&Transfer<'_>>, circle: &WindingCircle) -> Option<i64> {
    let turned = upper_half(w, circle)?;
    match backwards {
        None => Some((turned / PI).round() as i64),
        Some(backwards) => Some((0.5 * (turned + upper_half(backwards, circle)?) / PI).round() as i64),
    }
}

/// Angle by which w turns along the upper half of a circle \[rad\].
///
/// `None` where w is not finite or its argument changes on every scale: where w is smaller than its own rounding error,
/// its argument says nothing.
fn upper_half(w: &Transfer<'_>, circle: &WindingCircle) -> Option<f64> {
    let on_circle = |angle: f64| Complex64::from_polar(circle.radius, angle);
    let mut known = circle.points.iter().map(|&(angle, rates)| (angle, w.with_rates(rates, on_circle(angle))));
    let (mut turned, mut last, mut halvings) = (0.0, known.next()?, MOST_HALVINGS);
    for next in known {
        turned += turn(&|angle| w.at(on_circle(angle)), last, next, &mut halvings)?;
        last = next;
    }
    Some(turned)
}

/// Intervals that may be halved on one circle: bounds the work where the argument does not settle.
const MOST_HALVINGS: usize = 4000;

fn turn(
    at: &impl Fn(f64) -> Complex64,
    from: (f64, Complex64),
    to: (f64, Complex64),
    halvings: &mut usize,
) -> Option<f64> {
    let direct = (to.1 / from.1).arg();
    if direct.abs() < TURN {
        return Some(direct);
    }
    if !direct.is_finite() || *halvings == 0 {
        return None;
    }
    *halvings -= 1;
    let middle = 0.5 * (from.0 + to.0);
    let middle = (middle, at(middle));
    Some(turn(at, from, middle, halvings)? + turn(at, middle, to, halvings)?)
}

/// Zero by Newton's method with a central difference for the derivative, moved to the upper half-plane; `None` where
/// it strays or does not converge.
fn newton(w: &Transfer<'_>, start: Complex64) -> Option<Complex64> {
    let mut zeta = start;
    for _ in 0..40 {
        let h = 1e-6;
        let slope = (w.at(zeta + h) - w.at(zeta - h)) / (2.0 * h);
        let change = w.at(zeta) / slope;
        zeta -= change;
        if !zeta.is_finite() || zeta.norm() > 1.5 {
            return None;
        }
        if change.norm() < 1e-10 {
            return Some(if zeta.im < 0.0 { zeta.conj() } else { zeta });
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tyre::poles::turning_ring;

    /// Turns of w round zero along a whole circle, by many points.
    fn whole_turns(w: &Transfer<'_>, radius: f64) -> i64 {
        const POINTS: u32 = 200_000;
        let at = |k: u32| w.at(Complex64::from_polar(radius, 2.0 * PI * f64::from(k) / f64::from(POINTS)));
        let turned: f64 = (0..POINTS).map(|k| (at(k + 1) / at(k)).arg()).sum();
        (turned / (2.0 * PI)).round() as i64
    }

    #[test]
    fn zeros_of_waves_in_either_direction_are_those_of_the_whole_circle() {
        let model = turning_ring::model(16, -220.0);
        let mut found = 0;
        for rule in [TimeRule::FirstOrderHold, TimeRule::Bdf2, TimeRule::Sdirk2] {
            let time_step = 4e-4;
            for n in [0, 1, 2, 5, 8] {
                let modes = model.modes(n, Field::Surface).unwrap();
                let [forwards, backwards] = Direction::BOTH.map(|way| Transfer::new(modes, way, rule, time_step));
                // Of waves that differ, both halves are needed.
                let zeta = Complex64::from_polar(0.7, 1.1);
                assert!(
                    (forwards.at(zeta.conj()) - backwards.at(zeta).conj()).norm() < 1e-12 * forwards.at(zeta).norm()
                );
                for radius in [UNSTABLE, MARGINAL] {
                    let whole = [&forwards, &backwards].map(|w| whole_turns(w, radius));
                    let circle = WindingCircle::new(radius, rule);
                    let counted = zeros(&forwards, Some(&backwards), &circle).unwrap();
                    assert_eq!(whole, [counted; 2], "{rule:?}, n = {n}, {radius}");
                    found += counted;
                }
            }
            let stability = Stability::of(&model, Field::Surface, rule, time_step, 0.0).unwrap();
            assert_eq!(stability.unstable.is_some(), rule == TimeRule::FirstOrderHold, "{rule:?}: {stability:?}");
        }
        assert!(found > 5, "{found}");
    }

    #[test]
    fn a_function_without_a_sure_argument_is_undecided_in_bounded_work() {
        let begin = Complex64::new(1.0, 0.0);
        let of = |at: &dyn Fn(f64) -> Complex64| {
            let (mut halvings, last) = (MOST_HALVINGS, at(1.0));
            (turn(&at, (0.0, begin), (1.0, last), &mut halvings), MOST_HALVINGS - halvings)
        };
        assert_eq!(of(&|_| Complex64::new(f64::NAN, 0.0)).0, None);
        // Rounding noise: another argument at every point, however close.
        let noise = |angle: f64| Complex64::cis((angle * 1e9).sin() * 1e9);
        let (turned, halvings) = of(&noise);
        assert_eq!((turned, halvings), (None, MOST_HALVINGS));
        let (turned, halvings) = of(&|angle: f64| Complex64::cis(40.0 * angle));
        assert!((turned.unwrap_or(f64::NAN) - 40.0).abs() < 1e-9 && halvings < 200, "{turned:?} {halvings}");
    }
}
