//! Spheres, free and on the road: closed-form values, irregular frequencies, convergence, reciprocity, cut spheres.

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::radiation::chart::Chart;
use crate::radiation::{BodyShape, Drive, MeshResolution, ParityBlock, RadiatingBody, RadiationProblem, Vector};

const MEMORY: u64 = 1 << 30;

fn sphere(height: Option<f64>) -> RadiatingBody {
    RadiatingBody::new(BodyShape::Sphere { radius: 1.0 }, height).unwrap()
}

/// Pressure of the pulsating sphere, a = rho = c = 1, v = 1, at r.
fn pulsating(k: f64, r: f64) -> Complex64 {
    Complex64::new(0.0, k) / Complex64::new(1.0, k) / r * Complex64::from_polar(1.0, -k * (r - 1.0))
}

/// Relative errors on the surface (between nodes), far away, and of the power; and the reciprocal condition.
fn pulsating_errors(k: f64, resolution: &MeshResolution, interior: Option<usize>) -> [f64; 4] {
    let body = sphere(None);
    let mut problem = RadiationProblem::new(&body, k, k, resolution, &ParityBlock::ALL[..1], MEMORY).unwrap();
    if let Some(count) = interior {
        problem = problem.with_interior_points(count);
    }
    let velocity = |_: &Chart, _: Vector| Complex64::new(0.0, k);
    let drives = [Drive::Velocity(&velocity)];
    let mut solution = problem.solve(&drives).unwrap();
    let worst = |found: &[Complex64], exact: Complex64| {
        found.iter().map(|value| (value - exact).norm() / exact.norm()).fold(0.0, f64::max)
    };
    let surface = solution.field(&[[0.6, 0.0, 0.8], [0.36, 0.48, -0.8], [0.0, 0.0, 1.0]], true);
    let far = solution.field(&[[3.0, 0.0, 0.0], [-1.8, 2.4, 0.0]], false);
    let power = 2.0 * PI * k * k / (1.0 + k * k);
    [
        worst(&surface[0], pulsating(k, 1.0)),
        worst(&far[0], pulsating(k, 3.0)),
        (solution.power(0, k) / power - 1.0).abs(),
        solution.report().reciprocal_condition,
    ]
}

#[test]
fn free_sphere_to_1e_minus_4_at_ten_nodes_per_wavelength() {
    for k in [1.0, PI, 4.493_409_457_909_064, 5.0] {
        let [surface, far, power, condition] = pulsating_errors(k, &MeshResolution::of(10.0), None);
        assert!(surface < 1e-4 && far < 1e-4 && power < 1e-4, "k = {k}: {surface} {far} {power}");
        assert!(condition > 1e-6, "k = {k}: reciprocal condition {condition}");
    }
}

#[test]
fn without_interior_points_the_inside_resonates() {
    let resolution = MeshResolution::of(10.0);
    let [.., with] = pulsating_errors(PI, &resolution, None);
    let [.., without] = pulsating_errors(PI, &resolution, Some(0));
    assert!(without < 0.02 * with, "reciprocal condition {without} without, {with} with interior points");
}

#[test]
fn error_falls_with_the_order_of_the_elements() {
    // Between 3 x 3 elements of a side h and of h/2 at one wavenumber: the error of the field far away falls at least
    // as h^4.
    let at = |nodes_per_wavelength| {
        let resolution = MeshResolution { order: 3, nodes_per_wavelength, wedge: MeshResolution::WEDGE };
        pulsating_errors(5.0, &resolution, None)[1]
    };
    let (coarse, fine) = (at(6.0), at(12.0));
    assert!(fine < coarse / 16.0, "{coarse} to {fine}");
}

#[test]
fn waves_of_a_source_and_of_a_velocity_are_reciprocal() {
    // p at r of the velocity against i w rho int G_N v dS on a sphere over the road; the mesh is fine enough for the
    // quadrature over the elements' nodes.
    let (k, body, receiver) = (3.0, sphere(Some(1.3)), [2.5, 1.0, 0.7]);
    let problem = RadiationProblem::new(&body, k, k, &MeshResolution::of(8.0), &ParityBlock::ALL, MEMORY).unwrap();
    let shape = |[x, y, z]: Vector| 1.0 + x + 0.5 * y * z;
    let velocity = |_: &Chart, point: Vector| Complex64::new(0.0, k * shape(point));
    let drives = [Drive::Velocity(&velocity), Drive::Source(receiver)];
    let mut solution = problem.solve(&drives).unwrap();
    let direct = solution.field(&[receiver], false)[0][0];
    let mesh = problem.mesh();
    let mut sum = Complex64::ZERO;
    for (node, point) in mesh.nodes.iter().enumerate() {
        for (block, parity) in ParityBlock::ALL.iter().enumerate() {
            let part = parity.part(point.position, shape);
            sum += solution.node_pressure(block, node, 1) * (4.0 * point.area * part);
        }
    }
    let reciprocal = sum * Complex64::new(0.0, k);
    assert!((direct - reciprocal).norm() < 3e-4 * direct.norm(), "{direct} against {reciprocal}");
}

/// Pressure over the whole surface, the wedge at the road included, of a heaving and pulsating sphere.
fn surface(height: f64, k: f64, resolution: &MeshResolution, points: &[Vector]) -> Vec<Complex64> {
    let body = sphere(Some(height));
    let problem = RadiationProblem::new(&body, k, k, resolution, &ParityBlock::ALL[..2], MEMORY).unwrap();
    let velocity = |_: &Chart, [x, _, z]: Vector| Complex64::new(0.0, k * (1.0 + z - height + 0.7 * x));
    let drives = [Drive::Velocity(&velocity)];
    problem.solve(&drives).unwrap().field(points, true).remove(0)
}

/// Largest difference between two meshes over the surface's largest pressure.
fn self_convergence(height: f64, k: f64, coarse: &MeshResolution, fine: &MeshResolution) -> f64 {
    let start = if height < 1.0 { height.acos() } else { 0.0 };
    let points: Vec<Vector> = [0.01, 0.03, 0.1, 0.2, 0.4, 0.8, 1.5, 2.5]
        .iter()
        .flat_map(|from_cut| {
            let alpha: f64 = start + from_cut;
            [0.3_f64, 2.5].map(|phi| [alpha.sin() * phi.cos(), alpha.sin() * phi.sin(), height - alpha.cos()])
        })
        .collect();
    let (coarse, fine) = (surface(height, k, coarse, &points), surface(height, k, fine, &points));
    let largest = fine.iter().map(|value| value.norm()).fold(0.0, f64::max);
    coarse.iter().zip(&fine).map(|(a, b)| (a - b).norm() / largest).fold(0.0, f64::max)
}

#[test]
fn nearly_touching_and_cut_spheres_to_1_percent() {
    for height in [1.01, 0.95] {
        let fine = MeshResolution { order: 4, nodes_per_wavelength: 14.0, wedge: 0.4 };
        let error = self_convergence(height, 3.0, &MeshResolution::of(8.0), &fine);
        assert!(error < 0.01, "height {height}: {error}");
    }
}

#[test]
#[ignore = "minutes: many meshes"]
fn touching_and_cut_spheres_keep_1_percent_up_to_k_10() {
    for height in [1.1, 1.01, 1.0, 0.99, 0.95, 0.8, 0.5] {
        for k in [1.0, PI, 10.0] {
            let fine = MeshResolution { order: 4, nodes_per_wavelength: 13.0, wedge: 0.4 };
            let error = self_convergence(height, k, &MeshResolution::of(8.0), &fine);
            println!("height {height}, k {k:.3}: {error:.1e}");
            assert!(error < 0.01, "height {height}, k {k}: {error}");
        }
    }
}
