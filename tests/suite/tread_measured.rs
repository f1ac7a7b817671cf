//! Measurements of treads with patterns: what they cost, and what they sound like.

use std::path::{Path, PathBuf};
use std::time::Instant;

use tyrewave::Plan;
use tyrewave::counters::Counter;
use tyrewave::internals::{decisions, march};
use tyrewave::run::Simulation;
use tyrewave::scene::{LoadedScene, Scene};

/// A tyre of the examples in cells, with other tables after.
fn over_cells(name: &str, road: &str, seconds: f64, more: &str) -> LoadedScene {
    let tyre = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tyres").join(format!("{name}.toml"));
    let text = format!(
        "tyre = '{}'\n[road]\n{road}\n[rolling]\nspeed_kmh = 80.0\nwarm_up = 0.1\nduration = {seconds:?}\n\
         axle = {{ load = 3400.0, tolerance = 0.1 }}\n[contact]\nzone = \"cells\"\ncells_across = 30\n[numerics]\n\
         elements = 512\npole_tolerance = 1e-4\ncontact_tolerance = 1e-5\n{more}",
        tyre.display()
    );
    Scene::from_str(&text, name).unwrap_or_else(|error| panic!("{}", error.render(false)))
}

#[test]
#[ignore = "a minute or two"]
fn a_pattern_costs_at_most_a_third_more_than_a_slick() {
    let cost = |name: &str, more: &str| {
        let loaded = over_cells(name, "kind = \"made\"\nseed = 1", 0.15, more);
        let plan = Plan::of(&loaded).unwrap();
        let mut run = Simulation::begin(&loaded, &plan, &Default::default()).unwrap();
        let (begin, mut steps) = (Instant::now(), 0);
        while run.step().unwrap().is_some() {
            steps += 1;
        }
        let time = begin.elapsed().as_secs_f64() / f64::from(steps);
        let counts = march(&run).search_counts();
        let [solves, search] = [counts.solves, counts.work.multiply_adds].map(|count| count as f64 / f64::from(steps));
        let history = run.finish().meter.counted(Counter::HistoryMultiplyAdds) as f64 / f64::from(steps);
        println!(
            "{name} {more:?}: {:.0} us a step, {solves:.2} iterations, multiply-adds of the past {history:.2e}, of the \
             search {search:.2e}, {} proofs",
            1e6 * time,
            counts.fallbacks
        );
        [history + search, search, time]
    };
    let slick = cost("slick", "");
    let mut most_expensive: f64 = 0.0;
    for (name, more) in [("summer", ""), ("winter", ""), ("winter", "[effects]\ntread_pattern = \"off\"")] {
        let of_pattern = cost(name, more);
        let [all, search, time] = [0, 1, 2].map(|of| of_pattern[of] / slick[of]);
        most_expensive = most_expensive.max(all);
        println!("    {all:.2} of the slick's step, {search:.2} of its search, {time:.2} of its time");
    }
    assert!(most_expensive < 1.3, "{most_expensive}");
}

#[test]
#[ignore = "writes pictures and spectra"]
fn pictures_of_patterns() {
    let folder = PathBuf::from(std::env::var_os("TYREWAVE_PICTURES").unwrap_or_else(|| "patterns".into()));
    std::fs::create_dir_all(&folder).unwrap();
    for name in ["summer", "winter"] {
        let loaded = over_cells(name, "kind = \"smooth\"", 0.1, "");
        let plan = Plan::of(&loaded).unwrap();
        for row in &decisions(&plan).rows {
            println!("{name}: {} {} {} ({})", row.effect, row.on, row.form, row.reason);
        }
        let map = plan.tread_map().unwrap();
        let save = |file: &str, svg: String| std::fs::write(folder.join(format!("{name}_{file}.svg")), svg).unwrap();
        save("tread", tyrewave::internals::tread_picture(&map, name).unwrap());
        let train = map.train.as_ref().unwrap();
        save("pitches", tyrewave::internals::pitch_spectrum(train, plan.speed, name));
    }
}

#[test]
#[ignore = "minutes"]
fn spectra_of_equal_sequenced_and_random_pitches() {
    let lateral =
        "laterals = [{ from = -0.0545, to = 0.0, width = 0.00385, depth = 0.007, angle = 0.0, offset = 0.5625 }]";
    let lengths = "lengths = [0.02625, 0.030, 0.03375]";
    let orders = [
        ("equal", "pitches = 64".to_owned()),
        ("sequenced", format!("pitches = {{ {lengths}, sequence = \"{}\" }}", "AABBCCBB".repeat(8))),
        ("random", format!("pitches = {{ {lengths}, sequence = \"random\", count = 65, seed = 1 }}")),
    ];
    for (name, pitches) in orders {
        let more = format!("[tread_pattern]\n{pitches}\n{lateral}");
        let loaded = over_cells("slick", "kind = \"smooth\"", 0.72, &more);
        let plan = Plan::of(&loaded).unwrap_or_else(|error| panic!("{}", error.render(false)));
        let mut run = Simulation::begin(&loaded, &plan, &Default::default()).unwrap();
        let mut forces = Vec::new();
        while let Some(step) = run.step().unwrap() {
            forces.push(step.total_force);
        }
        let steps = 512 * plan.scene.numerics.substeps;
        let mut last: Vec<rustfft::num_complex::Complex64> =
            forces[forces.len() - steps..].iter().map(|force| (*force).into()).collect();
        rustfft::FftPlanner::new().plan_fft_forward(steps).process(&mut last);
        let level = |order: usize| 20.0 * (last[order].norm() / steps as f64).log10();
        let mut all: Vec<(usize, f64)> = (1..steps / 2).map(|order| (order, level(order))).collect();
        let near: f64 = (40..90).map(|order| 10.0_f64.powf(0.1 * level(order))).sum();
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        let reported: Vec<String> = all.iter().take(8).map(|(order, level)| format!("{order}: {level:.1}")).collect();
        println!("{name}: {} dB re 1 N; orders 40 to 89 {:.1} dB", reported.join(", "), 10.0 * near.log10());
        if let Some(train) = plan.tread_map().and_then(|map| map.train) {
            let pulses: Vec<String> = all
                .iter()
                .take(8)
                .map(|(order, _)| format!("{order}: {:.3}", train.amplitude(*order).norm()))
                .collect();
            println!("    A_k {}", pulses.join(", "));
        }
    }
}
