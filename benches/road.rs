//! Cost of roads: drawing made texture, and resampling a measured profile, per metre.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use tyrewave::road::height_map::HeightMap;
use tyrewave::road::resample::Resampled;
use tyrewave::road::{Lattice, Limits, RoadSurface};
use tyrewave::scene::{AtEnd, MadeRoad, Road};

const METRES: usize = 20;

fn roads(criterion: &mut Criterion) {
    let lattice = Lattice { dx: 1.95 / 512.0, dy: 0.002, columns: 70 };
    let rows = (METRES as f64 / lattice.dx) as usize;
    let mut heights = vec![0.0; rows * lattice.columns];
    let mut group = criterion.benchmark_group("road");
    group.sample_size(10).throughput(Throughput::Elements(METRES as u64));
    let spec = Road::Made(MadeRoad::default());
    group.bench_function("open made road", |bench| {
        bench.iter(|| RoadSurface::open(&spec, lattice, Limits::default()).is_ok())
    });
    if let Ok(mut road) = RoadSurface::open(&spec, lattice, Limits::default()) {
        let mut first = 0;
        group.bench_function("draw made road", |bench| {
            bench.iter(|| {
                first += rows as i64;
                assert!(road.heights(first, rows, &mut heights).is_ok());
                // The road must be rough: a draw that got fast by giving nothing fails.
                let square = heights.iter().map(|z| z * z).sum::<f64>() / heights.len() as f64;
                assert!((0.4e-3..0.9e-3).contains(&square.sqrt()));
                black_box(square)
            });
        });
    }
    let spacing = 3.75e-5;
    let profile: Vec<f64> = (0..48_000).map(|i| 1e-3 * (f64::from(i) * spacing * 300.0).sin()).collect();
    let map = HeightMap { path: "bench".into(), dx: spacing, dy: 0.0, first_y: 0.0, columns: 1, heights: profile };
    let road = Resampled::new(map, lattice, AtEnd::Repeat);
    group.bench_function("resample repeated profile", |bench| bench.iter(|| road.heights(0, black_box(&mut heights))));
    group.finish();
}

criterion_group!(benches, roads);
criterion_main!(benches);
