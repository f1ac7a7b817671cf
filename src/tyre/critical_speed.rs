//! Critical speeds of a tyre other than that of its slowest wave ([`super::slowest_wave`]).
//!
//! **Limit of stability.** In the frame of the tyre, rotation takes Om^2 M from the stiffness of its motion along the
//! circumference and outwards, and gives tension. The remainder, the amended stiffness, must be positive definite: the
//! tyre is then passive, since Coriolis forces do no work. Waves of two and more periods gain by rotation; of one
//! period, a rigid motion of the belt against its foundation, the stiffness falls by m'' Om^2. Past the speed at which
//! it vanishes the damping, which turns with the tyre, feeds the motion on a rigid axle. Searched for at s = 0, where
//! rubber has relaxed: C(n, m, 0), the inverse of that stiffness, is positive definite below the limit and not beyond.
//!
//! **Waves of the tread.** A pattern of n periods that stands still beside the axle is a motion of the tread at s = i
//! n Om. Waves about as short as the tread is thick are those of its surface (Rayleigh waves). Above their speed Re
//! C_zz(n, m, i n Om) < 0: contact has no steady form that depends on the road under it alone. Time steps stay
//! well-posed.
//!
//! Cost: some ten compliances for each speed tried, once per halving.

use num_complex::Complex64;
use serde::Serialize;

use super::influence::Waves;
use super::layers::compliance::{Matrix3, Stack};
use super::layers::curved::{CurvedStack, STEP};
use crate::scene::Tyre;

/// Most periods round the tyre that are tested.
const WAVES: i64 = 6;
/// Number of lateral numbers that are tested.
const LATERAL: usize = 2;
/// 2 pi times the tread's thickness over the length of its surface wave.
const TREAD_WAVE: f64 = 5.0;
/// Bisections of the interval of speeds.
const HALVINGS: usize = 20;
/// Highest speed that is tested \[m/s\].
const HIGHEST: f64 = 1000.0;

/// Highest speed of stable rolling \[m/s\] if it lies below `speed` \[m/s\], to 1e-6 of that; `None` if not, and for a
/// flat tyre.
pub(crate) fn limit_below(tyre: &Tyre, speed: f64) -> Option<f64> {
    if !tyre.curvature || is_stable(tyre, speed) {
        return None;
    }
    let (mut stable, mut unstable) = (0.0, speed);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (stable + unstable);
        if is_stable(tyre, middle) {
            stable = middle;
        } else {
            unstable = middle;
        }
    }
    Some(stable)
}

/// Highest speed of stable rolling \[m/s\], if it is below 1000 m/s.
pub fn limit(tyre: &Tyre) -> Option<f64> {
    limit_below(tyre, HIGHEST)
}

/// Surface wave of the tread that stands still under the axle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct TreadWave {
    /// Wavelength \[m\].
    pub length: f64,
    /// Speed of the tyre \[m/s\] from which the wave stands still under the axle.
    pub speed: f64,
}

/// Surface wave of some 1.3 tread thicknesses (16 mm), of a tyre that turns as it rolls (`turns`) or does not; `None`
/// if it is faster than 1000 m/s.
pub(crate) fn tread_wave(tyre: &Tyre, turns: bool) -> Option<TreadWave> {
    let thickness = tyre.layers.last()?.thickness;
    let n = (TREAD_WAVE * tyre.radius() / thickness).round().max(1.0);
    let follows = |speed: f64| steady_compliance(tyre, n as i64, speed, turns) > 0.0;
    // The speed is bracketed by doubling, then bisected.
    let (mut slower, mut faster) = (0.0, 1.0);
    while follows(faster) {
        (slower, faster) = (faster, 2.0 * faster);
        if faster > HIGHEST {
            return None;
        }
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (slower + faster);
        if follows(middle) {
            slower = middle;
        } else {
            faster = middle;
        }
    }
    Some(TreadWave { length: tyre.circumference / n, speed: slower })
}

/// Re C_zz(n, m, i n Om) of a pattern that stands still beside the axle \[m/Pa\], m the lowest lateral number.
fn steady_compliance(tyre: &Tyre, n: i64, speed: f64, turns: bool) -> f64 {
    let (angular_velocity, waves) = (speed / tyre.radius(), Waves::new(tyre));
    let (m, s) = (waves.first_lateral_number(), Complex64::new(0.0, n as f64 * angular_velocity));
    if !tyre.curvature {
        return Stack::new(tyre).at(s).normal(waves.kx(n), waves.ky(m)).surface.re;
    }
    let turning = if turns { angular_velocity } else { 0.0 };
    CurvedStack::new(&Tyre { angular_velocity: turning, ..tyre.clone() }).compliance(n, m, s, STEP).0[2][2].re
}

/// True if the amended stiffness is positive definite at a speed \[m/s\].
fn is_stable(tyre: &Tyre, speed: f64) -> bool {
    let stack = CurvedStack::new(&Tyre { angular_velocity: speed / tyre.radius(), ..tyre.clone() });
    let mut lateral = Waves::new(tyre).lateral_numbers().take(LATERAL);
    lateral.all(|m| (1..=WAVES).all(|n| is_positive(&stack.compliance(n, m, Complex64::ZERO, STEP).0)))
}

/// True if a Hermitian matrix is positive definite, by its leading minors.
fn is_positive([[a, b, c], [_, d, e], [.., f]]: &Matrix3) -> bool {
    let (a, d, f) = (a.re, d.re, f.re);
    let plane = a * d - b.norm_sqr();
    let whole = f * plane + 2.0 * (b * e * c.conj()).re - a * e.norm_sqr() - d * c.norm_sqr();
    a > 0.0 && plane > 0.0 && whole > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DEFAULT, PLATE, Scene};
    use crate::test_models::on_springs;

    #[test]
    fn the_limit_is_where_the_belt_on_its_foundation_is_not_stiff() {
        let tyre = |text: &str| Scene::from_str(text, "default").unwrap().scene.tyre;
        let springs = on_springs(DEFAULT);
        for (text, expected) in [(&*springs, 119.8), (DEFAULT, 111.9)] {
            let found = limit(&tyre(text)).unwrap();
            assert!((found - expected).abs() < 0.5, "{found} m/s");
            assert!(limit_below(&tyre(text), 0.99 * found).is_none());
            assert!(limit_below(&tyre(text), 1.01 * found).is_some_and(|speed| (speed / found - 1.0).abs() < 1e-5));
        }
        assert_eq!(limit(&tyre(PLATE)), None);
    }

    #[test]
    fn waves_of_the_tread_hardly_feel_that_the_tyre_turns() {
        let tyre = Scene::from_str(&on_springs(DEFAULT), "springs").unwrap().scene.tyre;
        let [held, turning] = [false, true].map(|turns| tread_wave(&tyre, turns).unwrap());
        assert!((held.length - 0.0163).abs() < 1e-4 && (held.speed - 53.0).abs() < 1.0, "{held:?}");
        assert!((turning.speed / held.speed - 1.0).abs() < 0.03, "{held:?} {turning:?}");
    }

    #[test]
    fn minors_distinguish_positive_matrices() {
        let matrix = |least: f64| {
            // Eigenvalues 1, 2 and `least` under a unitary turn.
            let (c, s, i) = (0.6_f64, 0.8_f64, Complex64::i());
            let u = [
                [c.into(), s.into(), Complex64::ZERO],
                [-i * s, i * c, Complex64::ZERO],
                [Complex64::ZERO, Complex64::ZERO, Complex64::ONE],
            ];
            let values = [1.0, least, 2.0];
            let entry = |r: usize, k: usize| (0..3).map(|j| u[r][j] * values[j] * u[k][j].conj()).sum();
            std::array::from_fn(|r| std::array::from_fn(|k| entry(r, k)))
        };
        assert!(is_positive(&matrix(0.1)) && !is_positive(&matrix(-0.1)));
    }
}
