//! Contact with the half-space against closed forms: sphere, circular punch, strip punch, sinusoid to full contact.

use std::f64::consts::PI;

use tyrewave::half_space::{
    Extent, HalfSpaceError, HeightMap, Indentation, IndentationControl, IndentationLimits, indent,
};
use tyrewave::internals::{Convolution, GrowingContact, LineInfluence, love_displacement};

/// A square map of n x n cells over `side`, from the height at (x, y) relative to its middle.
fn map(n: usize, side: f64, height: impl Fn(f64, f64) -> f64) -> HeightMap {
    let dx = side / n as f64;
    let at = |i: usize| (i as f64 - 0.5 * (n as f64 - 1.0)) * dx;
    let heights = (0..n * n).map(|place| height(at(place / n), at(place % n))).collect();
    HeightMap { heights, extent: Extent { nx: n, ny: n }, dx, dy: dx }
}

fn solve(map: &HeightMap, control: IndentationControl) -> Indentation {
    indent(map, 1e7, control, IndentationLimits::default()).unwrap()
}

fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect()
}

/// Johnson, Contact Mechanics (1985), eqs 4.22-4.24: F = 4/3 E* sqrt(R) delta^(3/2), p0 = 2 E* sqrt(delta/R)/pi.
#[test]
fn a_sphere_converges_to_hertz() {
    let (radius, penetration) = (0.3, 1e-3f64);
    let contact_radius = (radius * penetration).sqrt();
    let load = 4.0 / 3.0 * 1e7 * radius.sqrt() * penetration.powf(1.5);
    let peak = 2.0 * 1e7 * (penetration / radius).sqrt() / PI;
    let (mut by_penetration, mut by_load, mut pressures) = (Vec::new(), Vec::new(), Vec::new());
    for n in [17usize, 33, 65, 129, 257] {
        let sphere = map(n, 3.0 * contact_radius, |x, y| -(x * x + y * y) / (2.0 * radius));
        let pushed = solve(&sphere, IndentationControl::Penetration(penetration));
        by_penetration.push((pushed.load / load - 1.0).abs());
        let loaded = solve(&sphere, IndentationControl::Load(load));
        by_load.push((loaded.penetration / penetration - 1.0).abs());
        let dx = sphere.dx;
        let at = |i: usize| (i as f64 - 0.5 * (n as f64 - 1.0)) * dx;
        let difference: f64 = (0..n * n)
            .map(|place| {
                let r = at(place / n).hypot(at(place % n)) / contact_radius;
                (loaded.pressure[place] - peak * (1.0 - r * r).max(0.0).sqrt()).abs() * dx * dx
            })
            .sum();
        pressures.push(difference / load);
    }
    println!("load error {by_penetration:?}\npenetration error {by_load:?}\npressure error {pressures:?}");
    println!("orders {:?} {:?} {:?}", orders(&by_penetration), orders(&by_load), orders(&pressures));
    assert!(by_penetration[4] < 2e-4 && by_load[4] < 1e-4 && pressures[4] < 2e-3);
    // The edge of contact is resolved to a cell: order 1 to 2 depending on how it falls on the grid, on average well
    // above 1.
    for errors in [&by_penetration, &by_load, &pressures] {
        assert!((errors[0] / errors[4]).log2() / 4.0 > 1.2, "{:?}", orders(errors));
    }
}

/// A flat circular punch, F = 2 E* a delta (Johnson 1985, eq. 3.36): the pressure is singular at the edge, so order 1.
#[test]
fn a_circular_punch_converges_to_the_closed_form() {
    let (radius, penetration) = (0.01, 1e-4);
    let errors: Vec<f64> = [32usize, 64, 128, 256]
        .iter()
        .map(|&n| {
            let punch = map(n, 2.2 * radius, |x, y| if x.hypot(y) <= radius { 0.0 } else { -1.0 });
            let contact = solve(&punch, IndentationControl::Penetration(penetration));
            // All of the face touches: area within the staircase.
            assert!((contact.area_fraction * 2.2 * 2.2 / PI - 1.0).abs() < 0.05);
            (contact.load / (2.0 * 1e7 * radius * penetration) - 1.0).abs()
        })
        .collect();
    println!("{errors:?} orders {:?}", orders(&errors));
    assert!(errors[3] < 5e-3, "{errors:?}");
    assert!((errors[0] / errors[3]).log2() / 3.0 > 0.7, "{errors:?}");
}

/// A flat strip much longer than wide: p(y) = P/(pi sqrt(a^2 - y^2)) (Johnson 1985, eq. 2.64).
#[test]
fn a_strip_punch_has_the_closed_forms_pressure() {
    let half_width = 1e-3;
    let errors: Vec<f64> = [50usize, 100, 200, 400]
        .iter()
        .map(|&cells| {
            let pitch = 2.0 * half_width / cells as f64;
            let line = LineInfluence::love(cells, 1e4 * half_width, pitch);
            let mut contact = GrowingContact::default();
            contact.follow(&line, &vec![0.0; cells]);
            let mut pressure = vec![0.0; cells];
            contact.pressure_at(1e-5, &mut pressure);
            let load: f64 = pressure.iter().map(|p| p * pitch).sum();
            // Over the middle half: the edge cells hold an integrable singularity.
            (cells / 4..3 * cells / 4)
                .map(|i| {
                    let y = (i as f64 + 0.5) * pitch - half_width;
                    (pressure[i] / (load / (PI * (half_width * half_width - y * y).sqrt())) - 1.0).abs()
                })
                .fold(0.0, f64::max)
        })
        .collect();
    println!("{errors:?} orders {:?}", orders(&errors));
    assert!(errors[3] < 2e-3 && (errors[0] / errors[3]).log2() / 3.0 > 0.9, "{errors:?}");
}

/// Westergaard (J. Appl. Mech. 6 (1939) 49-53; Johnson 1985, section 13.2): a wavy surface of amplitude D and
/// wavelength l under the mean pressure m touches over the width 2a of each wave, m = M sin^2(pi a/l), M = pi E* D/l,
/// and fully from m = M on. His surface is endless. Here 31 waves on a strip: under the middle one the mean pressure
/// varies by some 1/31^2 only, so that its mean pressure and width must satisfy his formula, up to full contact.
#[test]
fn the_middle_of_many_waves_follows_westergaard_to_full_contact() {
    let (waves, per_wave) = (31usize, 48usize);
    let (amplitude, wavelength) = (1e-4, 0.01);
    let cells = waves * per_wave;
    let pitch = wavelength / per_wave as f64;
    let line = LineInfluence::love(cells, 1e3 * wavelength * waves as f64, pitch);
    // Crests in the middle of each wave's cells.
    let depths: Vec<f64> = (0..cells)
        .map(|i| {
            let phase = 2.0 * PI * ((i % per_wave) as f64 + 0.5) / per_wave as f64;
            amplitude * (1.0 + phase.cos())
        })
        .collect();
    let least = depths.iter().copied().fold(f64::MAX, f64::min);
    let depths: Vec<f64> = depths.iter().map(|depth| depth - least).collect();
    let mut contact = GrowingContact::default();
    contact.follow(&line, &depths);
    let full = contact.events()[cells - 1].0;
    let middle = waves / 2 * per_wave..(waves / 2 + 1) * per_wave;
    let full_pressure = PI * amplitude / wavelength;
    let mut pressure = vec![0.0; cells];
    let mut widths = Vec::new();
    for level in 1..=60 {
        contact.pressure_at(full * f64::from(level) / 50.0, &mut pressure);
        let wave = &pressure[middle.clone()];
        let mean = wave.iter().sum::<f64>() / per_wave as f64 / full_pressure;
        let width = wave.iter().filter(|&&p| p > 0.0).count() as f64 / per_wave as f64;
        let expected = if mean < 1.0 { mean.sqrt().asin() * 2.0 / PI } else { 1.0 };
        widths.push(width);
        // Contact is resolved to a cell on either side.
        assert!(
            (width - expected).abs() <= 2.5 / per_wave as f64,
            "mean {mean}: width {width}, Westergaard {expected}"
        );
        if mean > 1.02 {
            // Full contact: p = m + M cos.
            for (i, p) in wave.iter().enumerate() {
                let phase = 2.0 * PI * (i as f64 + 0.5) / per_wave as f64;
                let exact = mean - phase.cos();
                assert!((p / full_pressure - exact).abs() < 0.02, "cell {i}: {} {exact}", p / full_pressure);
            }
        }
    }
    assert!(widths[0] < 0.5 && widths[59] >= 1.0, "{widths:?}");
}

/// p >= 0, g >= 0, p g = 0 from the pressure alone, on a surface with ties, a spike and flat parts.
#[test]
fn the_contact_conditions_hold_on_awkward_surfaces() {
    let surfaces: [(&str, HeightMap); 5] = [
        ("flat", map(40, 0.1, |_, _| 1e-3)),
        ("spike", map(101, 0.1, |x, y| if x.hypot(y) < 1e-4 { 2e-3 } else { 0.0 })),
        ("terraces", map(96, 0.1, |x, y| ((x * 60.0).sin() * (y * 80.0).cos() * 4.0).round() * 2e-4)),
        ("two points", HeightMap { heights: vec![0.0, 1e-4], extent: Extent { nx: 1, ny: 2 }, dx: 1e-3, dy: 1e-3 }),
        (
            "long cells",
            HeightMap { dx: 1e-2, ..map(64, 0.064, |x, y| (x * 200.0).sin() * 1e-3 + (y * 731.0).sin() * 1e-4) },
        ),
    ];
    for (name, surface) in surfaces {
        let Extent { nx, ny } = surface.extent;
        for control in [IndentationControl::Penetration(1.3e-3), IndentationControl::Load(20.0)] {
            let contact = solve(&surface, control);
            let kernel = |i: usize, j: usize| {
                love_displacement(i as f64 * surface.dx, j as f64 * surface.dy, surface.dx, surface.dy) / 1e7
            };
            let mut displacement = vec![0.0; nx * ny];
            Convolution::<f64>::from_kernel(surface.extent, kernel)
                .apply(&contact.pressure, &mut displacement, |_| true);
            let plane = surface.heights.iter().copied().fold(f64::MIN, f64::max) - contact.penetration;
            for (place, p) in contact.pressure.iter().enumerate() {
                let gap = (displacement[place] - (surface.heights[place] - plane)) / contact.penetration;
                let holds = *p >= 0.0 && gap > -1.1e-8 && (*p <= 0.0 || gap < 1.1e-8);
                assert!(holds, "{name}, {control:?}: gap {gap:e} at pressure {p}");
            }
            println!("{name} {control:?}: {} iterations", contact.iterations);
        }
    }
}

#[test]
fn impossible_problems_are_refused_by_name() {
    let mut surface = map(8, 0.1, |x, _| x);
    let refused =
        |surface: &HeightMap, control| indent(surface, 1e7, control, IndentationLimits::default()).unwrap_err();
    for control in
        [IndentationControl::Load(0.0), IndentationControl::Load(f64::NAN), IndentationControl::Penetration(-1e-3)]
    {
        assert!(matches!(refused(&surface, control), HalfSpaceError::NotPositive { .. }));
    }
    surface.heights[19] = f64::NAN;
    assert!(matches!(refused(&surface, IndentationControl::Load(1.0)), HalfSpaceError::Hole { row: 2, column: 3, .. }));
    surface.heights.pop();
    assert!(matches!(refused(&surface, IndentationControl::Load(1.0)), HalfSpaceError::Shape { found: 63, .. }));
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let surface = map(120, 0.1, |x, y| (x * 300.0).sin() * (y * 230.0).cos() * 5e-4 - (x * x + y * y) * 0.3);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve(&surface, IndentationControl::Load(30.0)))
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
}
