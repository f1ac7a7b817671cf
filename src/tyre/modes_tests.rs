//! Modes of oscillators with known poles, and of tyres with known ones.

use super::*;
use crate::scene::Law;
use crate::test_models::plate_tyre;
use crate::tyre::poles::turning_ring::Gyroscopic;

fn diagonal(entries: [Complex64; 3]) -> Matrix3 {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { entries[i] } else { Complex64::ZERO }))
}

fn of(compliance: impl Fn(Complex64) -> Matrix3 + Sync) -> Modes {
    modes_of(&[(2, 1)], 500.0, |_, _, s| compliance(s)).unwrap()
}

/// Response of a mass of 1 on a spring and a damper with the pole p.
fn oscillator(pole: Complex64, s: Complex64) -> Complex64 {
    ((s - pole) * (s - pole.conj())).inv()
}

fn pole(frequency: f64, damping: f64) -> Complex64 {
    Complex64::from_polar(1.0, damping.acos()).conj() * -(TAU * frequency / (1.0 - damping * damping).sqrt())
}

#[test]
fn modes_of_oscillators_have_their_frequency_damping_and_motion() {
    // Two radial ones over a delayed background, one round the tyre and one across with the same pole.
    let radial = [pole(90.0, 0.05), pole(230.0, 0.003)];
    let shared = pole(48.0, 0.08);
    let modes = of(|s| {
        let background = (-s * 1e-4).exp() * 1e-7;
        let both = oscillator(radial[0], s) + oscillator(radial[1], s) * 1e-3 + background;
        diagonal([oscillator(shared, s), oscillator(shared, s), both])
    });
    assert_eq!(modes.unconfirmed, []);
    let expected = [
        (shared, 48.0, 0.08, Motion::Circumferential),
        (shared, 48.0, 0.08, Motion::Lateral),
        (radial[0], 90.0, 0.05, Motion::Radial),
        (radial[1], 230.0, 0.003, Motion::Radial),
    ];
    assert_eq!(modes.confirmed.len(), expected.len(), "{:?}", modes.confirmed);
    for (found, (pole, frequency, damping, motion)) in modes.confirmed.iter().zip(expected) {
        // The last step of the secant method is 1e-12, and it converges faster than linearly.
        assert!(same(found.pole, pole, 1e-12), "{found:?}");
        assert!((found.frequency() / frequency - 1.0).abs() < 1e-11, "{found:?}");
        assert!((found.damping() - damping).abs() < 1e-11, "{found:?}");
        assert_eq!(found.motion, motion);
        assert!(found.shares.iter().any(|share| (share - 1.0).abs() < 1e-9), "{found:?}");
    }
}

#[test]
fn rounding_of_the_compliance_makes_no_modes() {
    let (strong, weak) = (pole(90.0, 0.05), pole(140.0, 0.02));
    let strength = 1e-4;
    let modes = modes_of(&[(2, 1)], 200.0, |_, _, s| {
        // Errors of 1e-9 that follow no function of s.
        let digits = (s.im * 1e6).sin() * 1e-9;
        diagonal([(oscillator(strong, s) + oscillator(weak, s) * strength) * (1.0 + digits); 3])
    });
    let modes = modes.unwrap();
    assert_eq!(modes.unconfirmed, []);
    let radial: Vec<&Mode> = modes.confirmed.iter().filter(|mode| mode.motion == Motion::Radial).collect();
    assert_eq!(radial.len(), 2, "{radial:?}");
    for (mode, (pole, strength)) in radial.iter().zip([(strong, 1.0), (weak, strength)]) {
        // A peak is that of the residue 1/(2 Im p).
        let peak = strength / (2.0 * pole.im * pole.re.abs());
        assert!(same(mode.pole, pole, 1e-6) && (mode.peak / peak - 1.0).abs() < 1e-2, "{mode:?} {peak}");
    }
}

#[test]
fn waves_of_a_turning_ring_are_found_with_their_direction() {
    let ring = |n: i64, s: Complex64| {
        let direction = if n < 0 { Direction::Backwards } else { Direction::Forwards };
        Gyroscopic::new(1.0, 150.0, 0.03, 200.0).at(direction, s)
    };
    let wave = |direction| WaveOf { n: 2, direction, m: 1 };
    let waves = Direction::BOTH.map(|direction| wave(Some(direction)));
    let modes =
        found(&waves, &Line::up_to(500.0, MOST_POINTS), |wave, s| diagonal([ring(wave.signed(), s); 3])).unwrap();
    for (direction, signed) in [(Direction::Forwards, 2), (Direction::Backwards, -2)] {
        let of: Vec<_> = modes.confirmed.iter().filter(|mode| mode.direction == Some(direction)).collect();
        let exact = Gyroscopic::new(1.0, 150.0, 0.03, 200.0).pole(direction);
        assert!(of.iter().all(|mode| mode.signed_n() == signed && same(mode.pole, exact, 1e-12)), "{of:?}");
        assert_eq!(of.len(), 3);
    }
}

#[test]
fn a_mode_that_moves_two_ways_is_listed_once_with_its_shares() {
    let bending = pole(120.0, 0.04);
    let (shape, fixed) = ([0.6, 0.0, 0.8], pole(300.0, 0.1));
    let modes = of(|s| {
        let mut compliance = diagonal([oscillator(fixed, s); 3]);
        for (i, row) in compliance.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry += oscillator(bending, s) * (shape[i] * shape[j]);
            }
        }
        compliance
    });
    let below: Vec<_> = modes.confirmed.iter().filter(|mode| mode.frequency() < 200.0).collect();
    assert_eq!((below.len(), below[0].motion), (1, Motion::Radial), "{modes:?}");
    for (share, expected) in below[0].shares.iter().zip([0.36, 0.0, 0.64]) {
        assert!((share - expected).abs() < 1e-6, "{below:?}");
    }
}

#[test]
fn a_pole_of_the_samples_alone_is_reported() {
    let ringing = pole(100.0, 0.05);
    let line = Line::up_to(500.0, MOST_POINTS);
    let cut = |s: Complex64| if s.re < 0.9 * line.shift { Complex64::ONE } else { oscillator(ringing, s) };
    let modes = of(|s| diagonal([Complex64::ONE, Complex64::ONE, cut(s)]));
    assert_eq!((modes.confirmed.len(), modes.unconfirmed.len()), (0, 1), "{modes:?}");
    let (n, m, found) = modes.unconfirmed[0];
    assert!((n, m) == (2, 1) && same(found, ringing, 1e-3), "{modes:?}");
    let waves = [(0, 1), (1, 3), (2, 1)];
    let broken = modes_of(&waves, 500.0, |n, _, s| diagonal([if n > 0 { f64::NAN.into() } else { s.inv() }; 3]));
    let error = broken.unwrap_err();
    assert_eq!((error.n, error.m), (1, 3));
    assert!(matches!(error.source, RationalError::NotFinite { .. }), "{error}");
}

#[test]
fn a_rigid_wave_on_a_power_law_foundation_has_its_closed_form() {
    // A stiff plate so wide that it moves as a mass m'' on k (s/w0)^(2 gamma): s^(2 - 2 gamma) = -k/(m''
    // w0^(2 gamma)). Corrections: k h/E (1e-8) and the corner (1e-9).
    let mut tyre = plate_tyre();
    (tyre.circumference, tyre.width) = (1e6, 1e6);
    (tyre.foundation.loss_factor, tyre.foundation.corner_frequency) = (0.2, 1e-9);
    for layer in &mut tyre.layers {
        layer.tension = [0.0; 2];
        (layer.material.law, layer.material.modulus) = (Law::Elastic, 1e12);
    }
    let mass: f64 = tyre.layers.iter().map(|layer| layer.thickness * layer.material.density).sum();
    let exponent = 2.0 * 0.2_f64.atan() / std::f64::consts::PI;
    let expected = |stiffness: f64| {
        let power = stiffness / mass * (TAU * tyre.foundation.reference_frequency).powf(-exponent);
        let order = 1.0 / (2.0 - exponent);
        Complex64::from_polar(power.powf(order), std::f64::consts::PI * order)
    };
    let found = modes(&tyre, 0, 1, 500.0).unwrap();
    let has = |motion: Motion, pole: Complex64| {
        assert!(
            found.confirmed.iter().any(|mode| mode.motion == motion && same(mode.pole, pole, 1e-6)),
            "{motion:?} {pole}: {found:?}"
        );
    };
    has(Motion::Radial, expected(tyre.foundation.normal));
    has(Motion::Circumferential, expected(tyre.foundation.tangential));
    has(Motion::Lateral, expected(tyre.foundation.tangential));
    assert_eq!((found.confirmed.len(), found.unconfirmed.len()), (3, 0), "{found:?}");
}

#[test]
fn a_tyre_without_loss_has_modes_without_damping() {
    let mut tyre = plate_tyre();
    tyre.foundation.loss_factor = 0.0;
    for layer in &mut tyre.layers {
        layer.material.law = Law::Elastic;
    }
    let found = modes(&tyre, 3, 2, 500.0).unwrap();
    assert!(found.confirmed.len() >= 8 && found.unconfirmed.is_empty(), "{found:?}");
    // A pole on the axis to the rounding of C: 1e-12 of |s|, and what the condition of C adds.
    assert!(found.confirmed.iter().all(|mode| mode.damping().abs() < 1e-9), "{found:?}");
}
