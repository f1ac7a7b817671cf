//! Compliance of single waves of a tyre, curved or flat.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::kernel::Kernel;
use crate::numeric::in_parallel;
use crate::scene::Tyre;
use crate::tyre::layers::compliance::Matrix3;

/// Relative accuracy of a curved tyre's waves.
const TOLERANCE: f64 = 1e-8;

/// C \[m/Pa\] of the waves of `around` periods round the tyre and of a lateral number, at frequencies \[Hz\] that are
/// not negative: displacement i of the tread's surface for unit traction j; order circumferential, lateral, outward.
/// Wave by wave, within each wave frequency by frequency.
pub fn wave_compliance(tyre: &Tyre, around: &[u32], lateral: usize, frequencies: &[f64]) -> Vec<Matrix3> {
    let highest = frequencies.iter().fold(0.0_f64, |a, &b| a.max(b));
    let kernel = Kernel::new(tyre, TAU * highest, TOLERANCE);
    let at = in_parallel::map(frequencies, |&frequency| kernel.at(Complex64::new(0.0, TAU * frequency)));
    let wave = |&n: &u32| at.iter().map(|at| at.full(i64::from(n), lateral)).collect::<Vec<_>>();
    in_parallel::map(around, wave).concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DEFAULT, PLATE, Scene};
    use crate::tyre::layers::compliance::Stack;

    #[test]
    fn flat_tyres_are_their_layers_and_curved_ones_at_short_waves() {
        let norm = |matrix: &Matrix3| matrix.iter().flatten().map(|value| value.norm()).fold(0.0, f64::max);
        for (scene, around, allowed) in [(PLATE, 7, 1e-14), (DEFAULT, 300, 3e-2)] {
            let tyre = Scene::from_str(scene, "scene").unwrap().scene.tyre;
            let found = wave_compliance(&tyre, &[1, around], 1, &[0.0, 700.0]);
            assert_eq!(found.len(), 4);
            let s = Complex64::new(0.0, TAU * 700.0);
            let waves = super::super::Waves::new(&tyre);
            let flat = Stack::new(&tyre).at(s).full(waves.kx(around.into()), waves.ky(1)).0;
            let zz = (found[3][2][2] - flat[2][2]).norm();
            assert!(zz <= allowed * norm(&flat), "{scene:.40}: {zz:e} of {:e}", norm(&flat));
        }
    }
}
