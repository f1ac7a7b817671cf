//! Flank of a tyre that moves: tread and rings against the boundary problem with their velocity, and rings against
//! others.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::numeric::{SplitRule, double};
use crate::radiation::chart::Chart;
use crate::radiation::solve::Velocity;
use crate::radiation::transfer::{across_points, half_tread};
use crate::radiation::{
    Drive, Flank, MeshResolution, ParityBlock, RadiatingBody, RadiationProblem, SurfaceTransfer, TransferGrid,
    TransferProblem, Vector,
};

const MEMORY: u64 = 1 << 31;
const BEAD: f64 = 0.19;
const GRID: TransferGrid = TransferGrid { around: 512, across: 4 };

/// At 7.5 m, near the side, ahead.
const RECEIVERS: [Vector; 3] = [[0.0, 7.5, 1.2], [0.2, 0.32, 0.1], [2.0, 0.4, 0.2]];

/// R = 0.31 m, straight tread 0.136 m, shoulders of 20 mm, a patch of 0.108 m.
fn tyre() -> RadiatingBody {
    RadiatingBody::standing_tyre(0.31, 0.176, 0.02, 0.054).unwrap()
}

/// Worst relative error over some receivers of sums of G over tread and flank with a normal velocity by chart and
/// position, against the boundary problem with that velocity.
fn against_velocity(body: &RadiatingBody, velocity: &Velocity<'_>, blocks: &[ParityBlock]) -> f64 {
    // Down to the axle: the whole side.
    let flank = Flank::new(body, 1e-3).unwrap();
    let wavenumber = TAU * 400.0 / 343.0;
    let problem = TransferProblem {
        body,
        receivers: &RECEIVERS,
        grid: GRID,
        flank: Some(flank.clone()),
        resolution: MeshResolution::of(7.0),
        blocks,
        memory_limit: MEMORY,
    };
    let (transfers, _) = problem.solve(wavenumber).unwrap();
    let direct = RadiationProblem::new(body, wavenumber, wavenumber, &problem.resolution, blocks, MEMORY).unwrap();
    let [tread, ..] = Chart::of_tyre(body).unwrap();
    let drives = [Drive::Velocity(velocity)];
    let fields = direct.solve(&drives).unwrap().field(&RECEIVERS, false).remove(0);
    let rings = flank.rings().map(|ring| (ring.chart, ring.meridian, ring.area));
    let across = across_points(half_tread(body), 4).into_iter().map(|[y, weight]| (tread, y, weight * body.radius()));
    let rows: Vec<(Chart, f64, f64)> = across.chain(rings).collect();
    let mut worst: f64 = 0.0;
    for (transfer, field) in transfers.iter().zip(fields) {
        let mut sum = Complex64::ZERO;
        for side in 0..2 {
            for (row, (chart, meridian, area)) in rows.iter().enumerate() {
                for cell in 0..512 {
                    let theta = TAU * (cell as f64 + 0.5) / 512.0;
                    let [x, y, z] = chart.point(*meridian, theta).position;
                    let at = [x, if side == 0 { y } else { -y }, z];
                    let index = transfer.index(if transfer.sides == 2 { side } else { 0 }, row, cell);
                    sum += double(transfer.values[index]) * velocity(chart, at) * (area * TAU / 512.0);
                }
            }
        }
        worst = worst.max((sum - field).norm() / field.norm());
    }
    worst
}

#[test]
fn tread_and_flank_together_radiate_as_the_whole_body() {
    let body = tyre();
    let middle = body.middle();
    // Breathing, and the whole body up.
    let breathing = |_: &Chart, _: Vector| Complex64::ONE;
    let up = |chart: &Chart, [x, y, z]: Vector| {
        let normal = match *chart {
            Chart::Shoulder { shoulder, edge, .. } => 1.0 - ((y.abs() - edge) / shoulder).powi(2),
            Chart::Sidewall { .. } => 0.0,
            _ => 1.0,
        };
        Complex64::from((z - middle) / x.hypot(z - middle) * normal.max(0.0).sqrt())
    };
    for (name, error, allowed) in [
        ("breathing", against_velocity(&body, &breathing, &ParityBlock::EVEN_ACROSS), 0.01),
        // The road cuts the shoulders between their two rings.
        ("up", against_velocity(&body, &up, &ParityBlock::EVEN_ACROSS), 0.03),
    ] {
        println!("{name}: {error:.1e}");
        assert!(error < allowed, "{name}: {error:.1e}");
    }
}

#[test]
#[ignore = "a minute: what of the error is the tread's, and sides against each other"]
fn error_of_other_motions() {
    let body = tyre();
    let tread = |chart: &Chart, [x, _, z]: Vector| match chart {
        Chart::Tread { .. } => Complex64::from((z - body.middle()) / x.hypot(z - body.middle())),
        _ => Complex64::ZERO,
    };
    let against = |chart: &Chart, [_, y, _]: Vector| match chart {
        Chart::Shoulder { .. } | Chart::Sidewall { .. } => Complex64::from(y.signum()),
        _ => Complex64::ZERO,
    };
    println!("tread alone up: {:.1e}", against_velocity(&body, &tread, &ParityBlock::EVEN_ACROSS));
    println!("sides against each other: {:.1e}", against_velocity(&body, &against, &ParityBlock::ALL));
}

/// Errors of G of some waves at places between the rings, by the polynomials through these, relative to its largest at
/// the rings: by receiver and order the worst.
fn errors(frequency: f64, orders: &[usize]) -> Vec<f64> {
    let body = tyre();
    let flank = Flank::new(&body, BEAD).unwrap();
    // Rings elsewhere: two on the shoulder, three on the side again.
    let mut others = flank.clone();
    others.rule = SplitRule::new(0.75 * flank.rule.split);
    let solved = |flank: &Flank| {
        let problem = TransferProblem {
            body: &body,
            receivers: &RECEIVERS,
            grid: GRID,
            flank: Some(flank.clone()),
            resolution: MeshResolution::of(7.0),
            blocks: &ParityBlock::EVEN_ACROSS,
            memory_limit: MEMORY,
        };
        problem.solve(TAU * frequency / 343.0).unwrap().0
    };
    let (known, between) = (solved(&flank), solved(&others));
    let mut found = Vec::new();
    for (known, between) in known.iter().zip(&between) {
        for &order in orders {
            let wave = |transfer: &SurfaceTransfer, ring: usize| -> Complex64 {
                let cell = |cell: usize| {
                    let turn = TAU * order as f64 * (cell as f64 + 0.5) / GRID.around as f64;
                    double(transfer.values[transfer.index(0, GRID.across + ring, cell)])
                        * Complex64::from_polar(1.0, turn)
                };
                (0..GRID.around).map(cell).sum()
            };
            let at_rings = [0, 1, 2, 3, 4].map(|ring| wave(known, ring));
            let largest = at_rings.iter().fold(0.0_f64, |largest, value| largest.max(value.norm()));
            let error = |ring: usize| {
                let polynomials = flank.rule.polynomials(others.rule.points[ring]);
                let guess: Complex64 = polynomials.iter().zip(at_rings).map(|(weight, value)| value * weight).sum();
                (guess - wave(between, ring)).norm() / largest
            };
            found.push((0..SplitRule::POINTS).map(error).fold(0.0, f64::max));
        }
    }
    found
}

#[test]
#[ignore = "a minute: the error of the rings over frequency"]
fn error_of_the_rings_over_frequency() {
    for frequency in [125.0, 250.0, 500.0, 1000.0, 2000.0] {
        println!("{frequency} Hz, n = 0, 4, 12 by receiver: {:.4?}", errors(frequency, &[0, 4, 12]));
    }
}
