//! The frequencies of a set-up.

use std::time::Instant;

use crate::radiation::{
    Block, Body, FrequencyRange, FrequencyTransfers, Resolution, TransferGrid, TransferProblem, Watch, transfers,
};

#[test]
#[ignore = "exploration"]
fn explore_set_up() {
    let number = |name: &str, default: f64| std::env::var(name).map_or(default, |value| value.parse().unwrap());
    let body = Body::standing_tyre(0.31, 0.24, 0.02, 0.05).unwrap();
    let receivers = [[0.0, 7.5, 1.2], [0.2, 0.32, 0.1], [-0.2, 0.32, 0.1], [10.0, 7.5, 1.2]];
    let problem = TransferProblem {
        body: &body,
        receivers: &receivers,
        grid: TransferGrid { around: 512, across: 4 },
        resolution: Resolution::of(number("NPW", 7.0)),
        blocks: &Block::EVEN_ACROSS,
        memory_limit: 1 << 30,
    };
    let range = FrequencyRange {
        lowest: 25.0,
        highest: number("HIGHEST", 2500.0),
        coarsest: number("COARSEST", 100.0),
        finest: 6.0,
        tolerance: number("TOL", 0.2),
        sound_speed: 343.0,
    };
    let begin = Instant::now();
    let mut frequencies = Vec::new();
    let mut sink = |entry: &FrequencyTransfers| {
        frequencies.push(entry.frequency);
        Ok(())
    };
    let mut watch = Watch { sink: &mut sink, progress: &mut |_| (), interrupted: &|| false };
    let (_, report) = transfers(&problem, &range, Vec::new(), &mut watch).unwrap();
    frequencies.sort_by(f64::total_cmp);
    println!("{frequencies:.1?}");
    println!("{report:#?}");
    println!(
        "wall {:.1} s, LU {:.1} GFlop/s",
        begin.elapsed().as_secs_f64(),
        1e-9 * report.solve.factor_operations / report.solve.factor_seconds
    );
}
