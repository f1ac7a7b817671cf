//! Pressures of a flank that moves: sums of its waves, and its contribution beside the tread's.

use std::f64::consts::TAU;
use std::sync::Arc;

use num_complex::{Complex32, Complex64};

use super::model::PressureModel;
use super::shares::PressureShares;
use super::surface::SurfaceGreen;
use crate::numeric::{SplitRule, legendre};
use crate::response::vibration::{Across, SegmentLayout};
use crate::scene::{AirMotion, Scene, TimeRule, Tyre};
use crate::tyre::influence::{SurfaceWaves, Waves};
use crate::tyre::layers::curved::{CurvedStack, FINE_STEP};

const AROUND: usize = 64;
const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/tyres/car.toml");

fn tyre() -> Tyre {
    Scene::with_tyre(PATH, &[]).unwrap().scene.tyre
}

fn model(tyre: &Tyre, lateral: Vec<usize>, across: Across, air: AirMotion) -> PressureModel {
    let layout = SegmentLayout {
        elements: AROUND,
        advance: 1.into(),
        revolutions: 4,
        columns: 8,
        across,
        phase: 0,
        first_position: 0.0,
        circumference: tyre.circumference,
        time_step: 0.09 / AROUND as f64,
        rule: TimeRule::Sdirk2,
    };
    let waves = SurfaceWaves::with_flank(tyre, AROUND / 2, lateral, [1200.0, 1e-6], Some(&SplitRule::new(0.26)));
    PressureModel {
        layout,
        waves: Arc::new(waves),
        scale: 1.0,
        tangential: None,
        contact_width: tyre.contact_width,
        density: 1.2,
        air,
        highest: f64::INFINITY,
        delays: Vec::new(),
        strips: None,
    }
}

/// G that is 1 on the tread, and on each ring another function of the place round the tyre.
fn green(tyre: &Tyre, frequency: f64, ring: impl Fn(usize, usize) -> f32) -> SurfaceGreen {
    let mut across: Vec<f64> = legendre::gauss(3).iter().map(|[x, _]| 0.25 * tyre.width * (1.0 + x)).collect();
    across.reverse();
    let tread = vec![Complex32::ONE; 3 * AROUND];
    let rings = (0..SplitRule::POINTS * AROUND).map(|place| Complex32::from(ring(place / AROUND, place % AROUND)));
    SurfaceGreen {
        frequencies: vec![frequency],
        around: AROUND,
        across,
        half_width: 0.5 * tyre.width,
        rings: SplitRule::POINTS,
        values: vec![tread.into_iter().chain(rings).collect()],
        under_patch: None,
    }
}

#[test]
fn a_uniform_field_hears_the_volume_tread_and_sidewalls_sweep() {
    let tyre = tyre();
    let model = model(&tyre, vec![0], Across::Even, AirMotion::Axle);
    for frequency in [40.0, 180.0] {
        let shares = PressureShares::at(&model, &green(&tyre, frequency, |_, _| 1.0), 0);
        // Of n = 0 alone: the belt's edge under the tread, and the volume that any motion of the edge sweeps.
        let s = Complex64::new(0.0, TAU * frequency);
        let (surface, bottom) = CurvedStack::new(&tyre).compliance(0, 0, s, FINE_STEP);
        let edge = crate::sidewall::Sidewall::new(tyre.sidewall_arc(0.0).unwrap()).edge().unwrap();
        let inner = tyre.radius() - tyre.thickness();
        let swept = -2.0 * edge.pull() / tyre.inflation.as_ref().unwrap().pressure * inner / tyre.radius();
        let expected = swept / tyre.width * bottom[2][2] / surface[2][2];
        let [tread, shoulders, sides] = shares.parts;
        let found = (shoulders + sides) / tread;
        println!("{frequency} Hz: flank over tread {found:.4}, shoulders {:.4}", shoulders / tread);
        assert!((found - expected).norm() < 5e-3 * expected.norm(), "{frequency} Hz: {found} {expected}");
        assert!((shares.of_parts().iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn parts_waves_and_cells_of_a_flank_sum_to_one_pressure() {
    let tyre = Tyre { angular_velocity: -71.6, ..tyre() };
    let field = |ring: usize, cell: usize| 1.0 + ((ring + 1) * cell % 7) as f32;
    for air in [AirMotion::Axle, AirMotion::WithTread, AirMotion::Road] {
        let together = model(&tyre, vec![0, 2], Across::Even, air);
        let shares = PressureShares::at(&together, &green(&tyre, 150.0, field), 0);
        let whole = shares.pressure;
        for sum in [shares.parts.iter().sum::<Complex64>(), shares.cells.iter().sum(), shares.waves.iter().sum()] {
            assert!((sum - whole).norm() < 1e-5 * whole.norm(), "{air:?}: {sum} {whole}");
        }
        // Forces that are resolved across, with the shares of a strip, give the same sound.
        let apart = model(&tyre, vec![0, 2], Across::Resolved { components: 2, values: 0 }, air);
        let waves = Waves::new(&tyre);
        let (strip, shapes) = (apart.strip(), apart.shapes());
        assert_eq!((strip.len(), shapes.len()), (2, 2 * (1 + SplitRule::POINTS)));
        let (mut flows, mut out) = (apart.flow_buffer(), vec![Complex64::ZERO; apart.integrals_of_wave()]);
        let (mut flows_of_strip, mut sums) =
            (together.flow_buffer(), vec![Complex64::ZERO; together.integrals_of_wave()]);
        let weights = out.len() / shapes.len();
        for n in [-5, 0, 3] {
            apart.factors_at([150.0, 120.0], n, 1.0, &strip, &mut flows, &mut out);
            together.factors_at([150.0, 120.0], n, 1.0, &together.strip(), &mut flows_of_strip, &mut sums);
            let share = |m: usize| waves.lateral_share(2 * m, tyre.contact_width) * waves.sign_about_middle(2 * m);
            for place in 0..SplitRule::POINTS * weights {
                let of = |m: usize| out[m * (1 + SplitRule::POINTS) * weights + weights + place] * share(m);
                let (found, wanted) = (of(0) + of(1), sums[2 * weights + place]);
                assert!((found - wanted).norm() <= 1e-12 * wanted.norm(), "{air:?}, n = {n}: {found} {wanted}");
            }
        }
    }
}
