//! Is the inverse of a discretised tyre stable?
//!
//! Contact prescribes displacements and asks for forces: F(zeta) = u(zeta)/w(zeta) for every wavenumber. A zero of w
//! inside the unit disk is a force that grows by 1/|zeta| a step while no element moves: the contact chatters for ever,
//! however small the step.
//!
//! w is analytic in the disk (the tyre's poles are stable), so the number of zeros inside |zeta| = r is the number of
//! turns of w round zero along that circle (argument principle). The circle is followed in steps that turn w by less
//! than 0.8 rad.
//!
//! w is real at real zeta and conjugate at conjugate zeta, so that half a circle suffices. Of a tyre that turns the
//! waves forwards and backwards are conjugate to each other there: on the lower half the one is what the other is on
//! the upper, both have as many zeros, and these are found from the upper halves of both.
//!
//! An A-stable rule, as all are, of a passive tyre has no such zero; fitted poles are passive within their tolerance
//! only, which is why it is looked for. The rule maps the disk into Re s > 0, where Re(s H) > 0. There
//! delta(zeta) w_n(zeta), with the same delta for all wavenumbers, is positive real, which a compression to the
//! elements of the patch keeps: the patch alone is stable, too. Runge-Kutta rules mix their stages and have this proof
//! for the whole circumference only; the patch rests on the smooth-road tests.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::ContactError;
use super::history::transfer::Transfer;
use crate::numeric::in_parallel;
use crate::time_rule::{Rates, TimeRule};
use crate::tyre::influence::Field;
use crate::tyre::poles::{Direction, RationalModel};

/// A force that grows by more than a tenth a step is refused: |zeta| below 1/1.1.
pub(crate) const UNSTABLE: f64 = 0.909;
/// A force that grows by less than one in a thousand a step is below what the fitted poles can resolve.
const MARGINAL: f64 = 0.999;
/// Largest turn of w between two points of the circle \[rad\].
const TURN: f64 = 0.8;

/// A zero of the discrete transfer function inside the unit disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnstableZero {
    /// Wavenumber n.
    pub wavenumber: usize,
    /// The zero zeta itself.
    pub zeta: Complex64,
    /// Frequency of the growing force \[Hz\].
    pub frequency: f64,
    /// Wavenumbers that have zeros this deep in the disk: |zeta| < `UNSTABLE` or, for one above that, `MARGINAL`.
    pub wavenumbers: usize,
}

/// The zero of any wavenumber with the smallest |zeta| < `UNSTABLE` or, if there is none, below `MARGINAL`; `spring`
/// \[m/N\] is the compliance in series with each element.
///
/// # Errors
/// [`ContactError::NoSuchField`].
pub fn unstable_zero(
    model: &RationalModel,
    field: Field,
    rule: TimeRule,
    time_step: f64,
    spring: f64,
) -> Result<Option<UnstableZero>, ContactError> {
    for radius in [UNSTABLE, MARGINAL] {
        let circle = WindingCircle::new(radius, rule);
        let found = in_parallel::made(model.largest_wavenumber() + 1, |n| {
            let mut modes = model.modes(n, field)?;
            modes.constant += spring / model.elements as f64;
            let w = Transfer { modes, direction: Direction::Forwards, rule, time_step };
            let backwards = (!modes.odd.is_empty()).then_some(Transfer { direction: Direction::Backwards, ..w });
            Some(smallest_zero(&w, backwards.as_ref(), &circle))
        });
        let found = found.into_iter().collect::<Option<Vec<_>>>().ok_or(ContactError::NoSuchField)?;
        let zeros = || found.iter().enumerate().filter_map(|(n, zero)| Some((n, (*zero)?)));
        let worst = zeros().min_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
        if let Some((wavenumber, zeta)) = worst {
            let frequency = zeta.arg().abs() / (2.0 * PI * time_step);
            return Ok(Some(UnstableZero { wavenumber, zeta, frequency, wavenumbers: zeros().count() }));
        }
    }
    Ok(None)
}

/// Points from which a circle is followed, the same for every wavenumber.
struct WindingCircle {
    radius: f64,
    /// Angle and the rule's rates there.
    points: Vec<(f64, Rates)>,
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
    let mut known = circle.points.iter().map(|(angle, rates)| (*angle, w.with_rates(rates)));
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
    use super::super::history::transfer::first_weight;
    use super::*;
    use crate::tyre::poles::{WaveModes, turning_ring};

    /// Turns of w round zero along a whole circle, by many points.
    fn whole_turns(w: &Transfer<'_>, radius: f64) -> i64 {
        const POINTS: u32 = 200_000;
        let at = |k: u32| w.at(Complex64::from_polar(radius, 2.0 * PI * f64::from(k) / f64::from(POINTS)));
        let turned: f64 = (0..POINTS).map(|k| (at(k + 1) / at(k)).arg()).sum();
        (turned / (2.0 * PI)).round() as i64
    }

    #[test]
    fn zeros_of_waves_both_ways_are_those_of_the_whole_circle() {
        let model = turning_ring::model(16, -220.0);
        let time_step = 4e-4;
        for rule in [TimeRule::Bdf2, TimeRule::Sdirk2] {
            for n in [0, 1, 2, 5, 8] {
                // A spring of negative stiffness makes the ring active: H is as stiff at one s with Re s > 0.
                for (share, expected) in [(0.0, 0), (-0.5, 1)] {
                    let mut modes = model.modes(n, Field::Surface).unwrap();
                    modes.constant = share * first_weight(&modes, rule, time_step);
                    let [forwards, backwards] =
                        Direction::BOTH.map(|direction| Transfer { modes, direction, rule, time_step });
                    // Of waves that differ, both halves are needed.
                    let zeta = Complex64::from_polar(0.7, 1.1);
                    assert!(
                        (forwards.at(zeta.conj()) - backwards.at(zeta).conj()).norm()
                            < 1e-12 * forwards.at(zeta).norm()
                    );
                    let whole = [&forwards, &backwards].map(|w| whole_turns(w, UNSTABLE));
                    let counted = zeros(&forwards, Some(&backwards), &WindingCircle::new(UNSTABLE, rule)).unwrap();
                    assert_eq!((counted, whole), (expected, [expected; 2]), "{rule:?}, n = {n}, {share}");
                }
            }
        }
    }

    #[test]
    fn active_models_are_unstable_with_every_rule_and_passive_never() {
        let (model, time_step) = (turning_ring::model(16, -220.0), 4e-4);
        for rule in TimeRule::ALL {
            let of = |spring: f64| unstable_zero(&model, Field::Surface, rule, time_step, spring).unwrap();
            let weights = (0..=8).map(|n| first_weight(&model.modes(n, Field::Surface).unwrap(), rule, time_step));
            let least = 16.0 * weights.fold(f64::INFINITY, f64::min);
            assert!(least > 0.0 && of(0.0).is_none(), "{rule:?}: {least:e}");
            let zero = of(-0.5 * least).unwrap();
            assert!(zero.zeta.norm() < UNSTABLE && zero.wavenumbers == 9, "{rule:?}: {zero:?}");
        }
    }

    #[test]
    fn a_zero_lies_where_the_rule_puts_that_of_the_model() {
        // 1/(s + 100) - 2/(s + 1000) is zero at s = 800: delta(zeta) = 800 dt.
        let (time_step, rule) = (4e-4, TimeRule::Bdf2);
        let poles = [Complex64::from(-100.0), Complex64::from(-1000.0)];
        let residues = [Complex64::from(1.0), Complex64::from(-2.0)];
        let modes = WaveModes { poles: &poles, residues: &residues, odd: &[], pairs: 0, constant: 0.0 };
        let w = Transfer { modes, direction: Direction::Forwards, rule, time_step };
        let zero = smallest_zero(&w, None, &WindingCircle::new(UNSTABLE, rule)).unwrap();
        let exact = 2.0 - (1.0_f64 + 2.0 * 800.0 * time_step).sqrt();
        assert!((zero - exact).norm() < 1e-8, "{zero}");
    }

    #[test]
    fn a_function_without_a_sure_argument_remains_undecided() {
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
