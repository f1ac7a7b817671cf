//! Boundary elements: time and error of a free sphere with elements of 3 x 3 and of 4 x 4 nodes at several nodes per
//! wavelength, compared with the series for a point source; the rate of the factorisation compared with the machine's
//! peak; a tyre's transfer functions by the full method compared with the draft.
//!
//! `cargo bench --bench radiation`; errors and rates are printed.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may panic, in its helpers, too")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "what was measured is printed")]

use std::f64::consts::{PI, TAU};

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use num_complex::Complex64;
use tyrewave::internals::{
    BodyShape, DraftErrors, Drive, MachinePeak, MeshResolution, ParityBlock, RadiatingBody, RadiationProblem,
    SurfaceTransfer, TransferGrid, TransferProblem, Vector, double, draft_transfers_at,
};

const MEMORY: u64 = 4 << 30;
/// ka of the sphere, away from its interior resonances.
const WAVENUMBER: f64 = 8.0;
const SOURCE: Vector = [0.0, 0.0, 3.0];

/// Total field of a point source at distance r on a rigid sphere of radius 1, theta from the source:
/// -1/(4 pi k) sum (2n + 1) h_n(kr)/h_n'(k) P_n(cos theta), h_n the outgoing functions for exp(+i w t).
fn series(k: f64, r: f64, cosine: f64) -> Complex64 {
    const TERMS: usize = 60;
    // Upward recurrence is stable for functions that grow with n.
    let hankel = |x: f64| {
        let first = Complex64::I * Complex64::from_polar(1.0 / x, -x);
        let mut values = vec![first, first * (Complex64::new(1.0 / x, 0.0) + Complex64::I)];
        for n in 1..TERMS {
            values.push(values[n] * ((2 * n + 1) as f64 / x) - values[n - 1]);
        }
        values
    };
    let (far, near) = (hankel(k * r), hankel(k));
    let (mut before, mut legendre) = (0.0, 1.0);
    let mut sum = Complex64::ZERO;
    for n in 0..TERMS {
        // h_n' = n h_n/x - h_(n+1).
        let slope = near[n] * (n as f64 / k) - near[n + 1];
        sum += far[n] / slope * ((2 * n + 1) as f64 * legendre);
        let next = ((2 * n + 1) as f64 * cosine * legendre - n as f64 * before) / (n + 1) as f64;
        (before, legendre) = (legendre, next);
    }
    sum * (-1.0 / (4.0 * PI * k))
}

/// Largest error at points of the surface, relative to the largest value there; unknowns; flop/s of the factorisation.
fn sphere(order: usize, nodes: f64) -> (f64, usize, f64) {
    let body = RadiatingBody::new(BodyShape::Sphere { radius: 1.0 }, None).unwrap();
    let resolution = MeshResolution { order, ..MeshResolution::of(nodes) };
    // The source is on the axis: the field is even fore and aft and across.
    let problem =
        RadiationProblem::new(&body, WAVENUMBER, WAVENUMBER, &resolution, &ParityBlock::ALL[..1], MEMORY).unwrap();
    let drives = [Drive::Source(SOURCE)];
    let mut solution = problem.solve(&drives).unwrap();
    let angles: Vec<f64> = (0..20).map(|index| PI * (f64::from(index) + 0.5) / 20.0).collect();
    let points: Vec<Vector> = angles.iter().map(|angle| [angle.sin() * 0.8, angle.sin() * 0.6, angle.cos()]).collect();
    let found = &solution.field(&points, true)[0];
    let exact: Vec<Complex64> = angles.iter().map(|angle| series(WAVENUMBER, SOURCE[2], angle.cos())).collect();
    let largest = exact.iter().map(|value| value.norm()).fold(0.0, f64::max);
    let error = found.iter().zip(&exact).map(|(found, exact)| (found - exact).norm() / largest).fold(0.0, f64::max);
    let report = solution.report();
    (error, report.unknowns, report.factor_operations / report.factor_seconds)
}

fn spheres(criterion: &mut Criterion) {
    let peak = MachinePeak::measure().flop_per_second;
    let mut group = criterion.benchmark_group("sphere");
    group.sample_size(10);
    for order in [3, 4] {
        for nodes in [6.0, 9.0, 12.0] {
            let (error, unknowns, rate) = sphere(order, nodes);
            assert!(error < 0.05, "{order} x {order}, {nodes} nodes a wavelength: {error:e}");
            println!(
                "sphere, {order} x {order}, {nodes} nodes a wavelength: error {error:.1e}, {unknowns} unknowns, \
                 LU {:.1} of {:.1} Gflop/s",
                1e-9 * rate,
                1e-9 * peak
            );
            let name = format!("{order} x {order}");
            group.bench_function(BenchmarkId::new(name, nodes), |bench| bench.iter(|| sphere(order, nodes)));
        }
    }
    group.finish();
}

/// Sum of |G|^2 over the tread within 60 mm of the patch, at both ends.
fn strength(transfer: &SurfaceTransfer) -> f64 {
    let value = |across: usize, cell: usize| double(transfer.values[transfer.index(0, across, cell)]);
    let cell = |cell: usize| (0..4).map(|across| value(across, cell).norm_sqr()).sum::<f64>();
    (15..30).map(|index| cell(index) + cell(511 - index)).sum()
}

fn qualities(criterion: &mut Criterion) {
    let body = RadiatingBody::standing_tyre(0.3103, 0.176, 0.02, 0.054).unwrap();
    let receivers: [Vector; 3] = [[8.0, 7.5, 1.2], [0.0, 7.5, 1.2], [0.2, 0.288, 0.1]];
    let problem = TransferProblem {
        body: &body,
        receivers: &receivers,
        grid: TransferGrid { around: 512, across: 4 },
        flank: None,
        resolution: MeshResolution::default(),
        blocks: &ParityBlock::EVEN_ACROSS,
        memory_limit: MEMORY,
    };
    let mut group = criterion.benchmark_group("tyre");
    group.sample_size(10);
    let stated = DraftErrors::of(body.radius(), 0.176).expect("a width that a draft is for").of_standards.band;
    for frequency in [500.0, 1000.0] {
        let wavenumber = TAU * frequency / 343.2;
        let (full, _) = problem.solve(wavenumber).unwrap();
        for (full, draft) in full.iter().zip(draft_transfers_at(&problem, wavenumber)) {
            let error = 10.0 * (strength(&draft) / strength(full)).log10();
            println!("draft, {frequency} Hz, at {:?}: {error:+.1} dB of the full method", full.receiver);
            assert!(error.abs() < stated, "{error}");
        }
        let full = BenchmarkId::new("full", frequency);
        group.bench_function(full, |bench| bench.iter(|| problem.solve(wavenumber).unwrap()));
        let quick = BenchmarkId::new("draft", frequency);
        group.bench_function(quick, |bench| bench.iter(|| draft_transfers_at(&problem, wavenumber)));
    }
    group.finish();
}

criterion_group!(benches, spheres, qualities);
criterion_main!(benches);
