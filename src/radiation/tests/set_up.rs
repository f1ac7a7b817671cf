//! The frequencies of a set-up: chosen, stored, the same for any number of threads, stopped and resumed.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use crate::numeric::double;
use crate::radiation::{
    FrequencyRange, FrequencyReport, FrequencyTransfers, FrequencyWatch, MeshResolution, ParityBlock, RadiatingBody,
    RadiationError, TransferGrid, TransferProblem, TransferSet, Vector, transfers,
};

const RECEIVERS: [Vector; 1] = [[0.0, 7.5, 1.2]];

fn tyre() -> RadiatingBody {
    RadiatingBody::standing_tyre(0.31, 0.24, 0.02, 0.05).unwrap()
}

fn problem(body: &RadiatingBody) -> TransferProblem<'_> {
    TransferProblem {
        body,
        receivers: &RECEIVERS,
        grid: TransferGrid { around: 64, across: 2 },
        flank: None,
        resolution: MeshResolution { order: 3, nodes_per_wavelength: 6.0, wedge: 1.5 },
        blocks: &ParityBlock::EVEN_ACROSS,
        memory_limit: 1 << 30,
    }
}

fn range() -> FrequencyRange {
    FrequencyRange { coarsest: 90.0, ..FrequencyRange::up_to(300.0, 0.3, 343.0) }
}

/// A set-up on so many threads that is stopped after some frequencies, and what the sink got.
fn set_up(
    threads: usize,
    known: Vec<FrequencyTransfers>,
    most: usize,
) -> (Result<(TransferSet, FrequencyReport), RadiationError>, Vec<FrequencyTransfers>) {
    let body = tyre();
    let mut stored = Vec::new();
    let finished = AtomicUsize::new(0);
    let mut watch = FrequencyWatch {
        known: &mut |wanted| {
            let of = |entry: &&FrequencyTransfers| wanted.contains(&entry.frequency);
            known.iter().filter(of).cloned().collect()
        },
        sink: &mut |entry| {
            stored.push(entry.clone());
            finished.fetch_add(1, Ordering::Relaxed);
            Ok(())
        },
        progress: &mut |_| (),
        interrupted: &|| finished.load(Ordering::Relaxed) >= most,
    };
    let result = transfers(&problem(&body), &range(), threads, &mut watch);
    (result, stored)
}

#[test]
fn chosen_frequencies_keep_the_tolerance_on_any_threads() {
    let (one, stored) = set_up(1, Vec::new(), usize::MAX);
    let (set, report) = one.unwrap();
    assert_eq!(report.count, stored.len());
    assert_eq!(report.solved, stored.len());
    assert!(report.largest_passed <= 0.3 && report.reciprocal_condition > 1e-6, "{report:?}");
    let (two, _) = set_up(2, Vec::new(), usize::MAX);
    assert_eq!(set.frequencies(), two.unwrap().0.frequencies());
    // Between the frequencies, against a solution there.
    let body = tyre();
    for frequency in [90.0, 171.0, 283.0] {
        let exact = problem(&body).solve(range().wavenumber(frequency)).unwrap().0.remove(0);
        let guess = set.at(&body, 0, frequency).unwrap();
        let norm = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>().sqrt();
        let pairs = || guess.values.iter().zip(&exact.values);
        let difference = norm(&mut pairs().map(|(a, b)| double(a - b).norm_sqr()));
        let size = norm(&mut exact.values.iter().map(|value| double(*value).norm_sqr()));
        assert!(difference < 0.01 * size, "{frequency} Hz: {}", difference / size);
    }
}

#[test]
fn a_stopped_set_up_continues_from_stored_frequencies() {
    let (stopped, stored) = set_up(1, Vec::new(), 3);
    assert_eq!(stopped.err(), Some(RadiationError::Interrupted));
    assert_eq!(stored.len(), 3);
    let (result, rest) = set_up(1, stored, usize::MAX);
    let (set, report) = result.unwrap();
    assert_eq!(report.solved + 3, report.count);
    assert_eq!(rest.len(), report.solved);
    let (whole, _) = set_up(1, Vec::new(), usize::MAX);
    assert_eq!(set.frequencies(), whole.unwrap().0.frequencies());
}

#[test]
#[ignore = "minutes: the default tyre; HIGHEST, TOLERANCE, NODES, THREADS in the environment"]
fn time_of_a_whole_set_up() {
    let number = |name: &str, default: f64| std::env::var(name).map_or(default, |value| value.parse().unwrap());
    let body = tyre();
    let receivers = [[0.0, 7.5, 1.2], [0.2, 0.32, 0.1], [-0.2, 0.32, 0.1], [10.0, 7.5, 1.2]];
    let problem = TransferProblem {
        receivers: &receivers,
        grid: TransferGrid { around: 512, across: 4 },
        resolution: MeshResolution::of(number("NODES", MeshResolution::NODES)),
        ..problem(&body)
    };
    let range = FrequencyRange::up_to(number("HIGHEST", 2500.0), number("TOLERANCE", 0.2), 343.0);
    let begin = Instant::now();
    let mut watch = FrequencyWatch {
        known: &mut |_| Vec::new(),
        sink: &mut |_| Ok(()),
        progress: &mut |_| (),
        interrupted: &|| false,
    };
    let threads = number("THREADS", 2.0) as usize;
    let (set, report) = transfers(&problem, &range, threads, &mut watch).unwrap();
    let frequencies: Vec<f64> = set.frequencies().iter().map(|entry| entry.frequency).collect();
    println!("{frequencies:.1?}\n{report:#?}");
    let rate = 1e-9 * report.solve.factor_operations / report.solve.factor_seconds;
    println!("{threads} threads, {:.1} s, LU {rate:.1} GFlop/s", begin.elapsed().as_secs_f64());
}
