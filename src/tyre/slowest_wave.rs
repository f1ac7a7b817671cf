//! Speed of the slowest wave round a tyre, up to which a tyre can roll steadily.
//!
//! A force that stands still beside the axle of a tyre that rolls at V is to the tread a wave of n periods at the
//! frequency n V/R. The tread moves with the force as long as Re C_zz(n, m, i n V/R) > 0, and against it from the
//! wave's resonance on, where V is the speed of the free wave. Above the slowest one, waves stand behind the patch,
//! the mean force need not grow with the indentation any more, and the motion may grow without bound.
//!
//! A tyre that turns does so at the speed V that is tested, and a pattern that stands beside the axle has s = i n Om:
//! of its two waves of n periods the one that runs against the rotation, with elements counted against it.
//!
//! Waves shorter than 2 pi times the layers' thickness are left out: those are of the tread alone, whose shear waves
//! are as slow, but die out within a wavelength. (Default tyre at 250 km/h with the tension that its rolling adds: Re
//! C_zz < 0 from n = 57 on, and a run that is steady.)
//!
//! Cost: one evaluation of C_zz for each n, and ten times as many where a wave is slower than V.

use num_complex::Complex64;
use serde::Serialize;

use super::influence::Waves;
use super::influence::kernel::Kernel;
use crate::numeric::in_parallel;
use crate::scene::Tyre;

/// 2 pi times the layers' thickness over the wavelength, up to which waves are those of the belt.
const HIGHEST: f64 = 1.0;
/// Relative tolerance of the compliances.
const TOLERANCE: f64 = 1e-3;
/// Bisections of the interval of speeds.
const HALVINGS: usize = 10;

/// A free wave round the tyre.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SlowestWave {
    /// Periods round the tyre.
    pub n: usize,
    /// Phase speed \[m/s\].
    pub speed: f64,
}

/// The slowest wave of a tyre as it rolls, where it is slower than `speed` \[m/s\]; its speed is bisected to 1e-3 of
/// that.
pub fn slowest_wave_below(tyre: &Tyre, speed: f64) -> Option<SlowestWave> {
    let highest = (HIGHEST * tyre.radius() / tyre.thickness()).clamp(1.0, 1000.0) as usize;
    let waves: Vec<usize> = (1..=highest).collect();
    let m = Waves::new(tyre).first_lateral_number();
    let kernel = |tyre: &Tyre| Kernel::new(tyre, highest as f64 * speed / tyre.radius(), TOLERANCE);
    let still = (!tyre.turns()).then(|| kernel(tyre));
    // The longest wave that is slower than a speed.
    let outrun = |speed: f64| {
        let rate = speed / tyre.radius();
        let direction = if tyre.angular_velocity < 0.0 { -1 } else { 1 };
        let turning = || kernel(&Tyre { angular_velocity: rate.copysign(tyre.angular_velocity), ..tyre.clone() });
        let kernel = still.clone().unwrap_or_else(turning);
        let compliance = |&n: &usize| {
            let s = Complex64::new(0.0, n as f64 * rate);
            kernel.at(s).full(direction * n as i64, m)[2][2].re
        };
        in_parallel::map(&waves, compliance).iter().position(|&compliance| compliance < 0.0).map(|index| waves[index])
    };
    let mut found = SlowestWave { n: outrun(speed)?, speed };
    let mut slower = 0.0;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (slower + found.speed);
        match outrun(middle) {
            Some(n) => found = SlowestWave { n, speed: middle },
            None => slower = middle,
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DEFAULT, Scene};
    use crate::tyre::modes::{Motion, modes};

    #[test]
    fn the_slowest_wave_is_the_free_one_of_the_least_phase_velocity() {
        let tyre = Scene::from_str(DEFAULT, "default").unwrap().scene.tyre;
        let found = slowest_wave_below(&tyre, 400.0 / 3.6).unwrap();
        let free = modes(&tyre, 10, 1, 400.0).unwrap().confirmed;
        let radial = free.iter().filter(|mode| mode.n > 0 && mode.motion == Motion::Radial);
        let speeds = radial.map(|mode| (mode.frequency() * tyre.circumference / mode.n as f64, mode.n));
        let speeds: Vec<(f64, usize)> = speeds.collect();
        let least = speeds.iter().map(|(speed, _)| *speed).fold(f64::INFINITY, f64::min);
        assert!((found.speed / least - 1.0).abs() < 0.03, "{found:?} {least} m/s");
        // Waves of neighbouring n are nearly as slow.
        let same_wave = speeds.iter().filter(|(_, n)| *n == found.n);
        assert!(same_wave.map(|(speed, _)| speed).any(|speed| speed / least < 1.03), "{found:?} {speeds:?}");
        assert_eq!(slowest_wave_below(&tyre, 0.95 * least), None);
    }
}
