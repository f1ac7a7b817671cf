//! The growing factor's curve of a row of cells against one general search per level.

mod line_search;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tyrewave::internals::{GrowingContact, LineInfluence};

/// Random depths of a rough profile: half of them white, half of them correlated; some with ties.
fn profile(rng: &mut ChaCha8Rng, cells: usize, case: usize) -> Vec<f64> {
    let mut z = 0.0;
    let heights: Vec<f64> = (0..cells)
        .map(|_| {
            let random = rng.random::<f64>() - 0.5;
            z = if case.is_multiple_of(2) { 2e-3 * random } else { z + 3e-4 * random };
            if case.is_multiple_of(5) { (z * 1e4).round() * 1e-4 } else { z }
        })
        .collect();
    let peak = heights.iter().copied().fold(f64::MIN, f64::max);
    heights.iter().map(|z| peak - z).collect()
}

#[test]
fn agrees_with_the_general_search_at_a_hundred_levels() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut growing = GrowingContact::default();
    let mut worst = 0.0f64;
    for case in 0..200 {
        let cells = 2 + case / 5;
        let line = LineInfluence::love(cells, 10f64.powf(rng.random_range(-4.0..-2.0)), 2e-3);
        let depths = profile(&mut rng, cells, case);
        growing.follow(&line, &depths);
        let deepest = growing.events().last().unwrap().0;
        let mut pressure = vec![0.0; cells];
        for _ in 0..100 {
            let y = deepest * 1.1 * rng.random::<f64>();
            let reference = line_search::solve(&line, &depths, y, None);
            let expected: f64 = reference.pressure.iter().sum();
            let force: f64 = growing.events().iter().map(|&(touch, w)| w * (y - touch).max(0.0)).sum();
            growing.pressure_at(y, &mut pressure);
            let summed: f64 = pressure.iter().sum();
            let scale = y * line.flat_stiffness();
            worst = worst.max((force - expected).abs() / scale).max((summed - expected).abs() / scale);
            for (p, expected) in pressure.iter().zip(&reference.pressure) {
                worst = worst.max((p - expected).abs() / scale);
            }
        }
    }
    // Rounding times the condition number (some hundreds).
    assert!(worst < 1e-12, "largest difference {worst:.1e}");
}

#[test]
fn a_curve_costs_one_factorisation() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let cells = 80;
    let line = LineInfluence::love(cells, 4e-3, 2e-3);
    let (mut followed, mut searched) = (0, 0);
    for case in 0..20 {
        let depths = profile(&mut rng, cells, case);
        let mut growing = GrowingContact::default();
        growing.follow(&line, &depths);
        followed += growing.multiply_adds();
        let deepest = growing.events()[cells - 1].0;
        let mut guess: Option<Vec<bool>> = None;
        for level in 1..=64 {
            let y = deepest * f64::from(level) / 64.0;
            let contact = line_search::solve(&line, &depths, y, guess.as_deref());
            searched += contact.multiply_adds;
            guess = Some(contact.touching);
        }
    }
    assert!(followed <= 20 * (cells as u64).pow(3) / 6, "{followed}");
    let ratio = searched as f64 / followed as f64;
    println!("multiply-adds, search at 64 levels over one curve: {ratio:.1}");
    assert!(ratio >= 20.0, "{ratio}");
}
