//! The tyre on the road.

use num_complex::Complex64;

use crate::radiation::{Block, Body, Resolution, Transfer, TransferGrid, TransferProblem};

const MEMORY: u64 = 1 << 32;
const RECEIVERS: [[f64; 3]; 4] = [[0.0, 7.5, 1.2], [0.2, 0.32, 0.1], [2.0, 0.0, 0.0], [-3.0, 2.0, 0.5]];

fn difference(a: &Transfer, b: &Transfer) -> (f64, f64) {
    let largest = b.values.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let l2 = |f: &dyn Fn(usize) -> f64| (0..a.values.len()).map(f).sum::<f64>().sqrt();
    let rms = l2(&|i| (a.values[i] - b.values[i]).norm_sqr()) / l2(&|i| b.values[i].norm_sqr());
    let worst = (0..a.values.len()).map(|i| (a.values[i] - b.values[i]).norm()).fold(0.0, f64::max) / largest;
    (rms, worst)
}

#[test]
#[ignore = "exploration"]
fn explore_tyre() {
    let body = Body::standing_tyre(0.31, 0.24, 0.02, 0.05).unwrap();
    let frequencies: Vec<f64> =
        std::env::var("FREQS").unwrap_or("500,1000,2000".into()).split(',').map(|f| f.parse().unwrap()).collect();
    let settings: Vec<(usize, f64, f64)> = std::env::var("SETS")
        .unwrap_or("4:14:0.4,4:9:0.8,4:7:0.8,3:9:0.8,4:9:0.4,4:9:1.5".into())
        .split(',')
        .map(|s| {
            let v: Vec<f64> = s.split(':').map(|x| x.parse().unwrap()).collect();
            (v[0] as usize, v[1], v[2])
        })
        .collect();
    for f in frequencies {
        let k = std::f64::consts::TAU * f / 343.0;
        let mut reference: Option<Vec<Transfer>> = None;
        for &(order, npw, wedge) in &settings {
            let problem = TransferProblem {
                body: &body,
                receivers: &RECEIVERS,
                grid: TransferGrid { around: 512, across: 4 },
                resolution: Resolution { order, nodes_per_wavelength: npw, wedge },
                blocks: &Block::EVEN_ACROSS,
                memory_limit: MEMORY,
            };
            let (transfers, r) = problem.solve(k).unwrap();
            let mut line = format!(
                "f {f} p{order} npw {npw} wedge {wedge} n {} m {} rcond {:.1e} asm {:.2} lu {:.2} near {:.1e}",
                r.unknowns,
                r.interior_points,
                r.reciprocal_condition,
                r.assembly_seconds,
                r.factor_seconds,
                r.work.near_evaluations as f64
            );
            match &reference {
                None => {
                    let t = &transfers[2];
                    let horn: Vec<String> =
                        [14, 20, 30, 50, 80, 128].iter().map(|&c| format!("{:.1}", t.horn(&body, 0, 0, c))).collect();
                    line += &format!(" horn in plane {horn:?}");
                    let t = &transfers[0];
                    let horn: Vec<String> =
                        [14, 20, 30, 50, 80, 128].iter().map(|&c| format!("{:.1}", t.horn(&body, 0, 0, c))).collect();
                    line += &format!(" coast-by {horn:?}");
                    reference = Some(transfers);
                }
                Some(reference) => {
                    for (a, b) in transfers.iter().zip(reference) {
                        let (rms, worst) = difference(a, b);
                        line += &format!(" {rms:.1e}/{worst:.1e}");
                    }
                    // Travelling waves of velocity: orders around, as levels.
                    for order in [2.0, 8.0, 16.0, 40.0] {
                        for t in [0, 1] {
                            let v: Vec<Complex64> = (0..4 * 512)
                                .map(|i| {
                                    let theta = std::f64::consts::TAU * ((i % 512) as f64 + 0.5) / 512.0;
                                    Complex64::from_polar(1.0, order * theta)
                                })
                                .collect();
                            let (a, b) = (transfers[t].sum(&body, &v), reference[t].sum(&body, &v));
                            line += &format!(" n{order}:{:.3}dB", 20.0 * (a.norm() / b.norm()).log10());
                        }
                    }
                }
            }
            println!("{line}");
        }
    }
}
