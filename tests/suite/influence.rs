//! Rational models of the influence functions: against brute force, on hard tyres, and through the cache.

use std::f64::consts::PI;
use std::fs;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use num_complex::Complex64;
use tyrewave::internals::{
    Cache, Cached, FitError, FitOptions, RationalModel, Unusable, Weights, fetch_from as fetch, fit,
    fit_unless_stopped, pole_key as key, wide_tyre,
};
use tyrewave::scene::{Law, Layer, Material, TimeRule, Tyre};
use tyrewave::tyre::{Field, InfluenceSum, Projection, Truncation};

/// Flag that never stops a test.
static NEVER: AtomicBool = AtomicBool::new(false);

fn options(tyre: &Tyre, elements: usize, tolerance: f64, top_frequency: f64) -> FitOptions {
    FitOptions { top: 2.0 * PI * top_frequency, ..FitOptions::new(tyre, elements, 0.0).with_tolerance(tolerance) }
}

fn exact(tyre: &Tyre, options: &FitOptions) -> InfluenceSum {
    let projection = Projection::new(tyre, options.elements);
    InfluenceSum::with(tyre, projection, Truncation::Tail, options.influence_tolerance, options.top)
}

/// Largest error on points that no fit has seen, relative to |H_n(s)| or to `floor` times the largest over the band,
/// over all n.
fn fresh_error(model: &RationalModel, sum: &InfluenceSum, points: &[Complex64], floor: f64) -> f64 {
    let at: Vec<_> = points.iter().map(|&s| sum.at(s)).collect();
    let mut worst = 0.0_f64;
    for n in 0..=model.largest_wavenumber() {
        let mut faces = Vec::new();
        sum.faces(n, &at, Field::Surface, &mut faces);
        // The largest |H_n| sits on a resonance that the points may straddle; the model finds it cheaply.
        let scan = (0..4000).map(|k| Complex64::new(0.0, model.top * 1e-4f64.powf(f64::from(k) / 3999.0)));
        let scale = scan
            .filter_map(|s| model.evaluate(n, s, Field::Surface))
            .map(|value| value.norm())
            .chain(faces.iter().map(|face| face.driven.norm()))
            .fold(0.0, f64::max);
        for (&s, face) in points.iter().zip(&faces) {
            let local = face.driven.norm().max(floor * scale);
            let error = model.evaluate(n, s, Field::Surface).map(|value| (value - face.driven).norm() / local);
            worst = worst.max(error.unwrap_or(f64::INFINITY));
        }
    }
    worst
}

fn all_poles_are_stable(model: &RationalModel) -> bool {
    (0..=model.largest_wavenumber())
        .filter_map(|n| model.modes(n, Field::Surface))
        .all(|modes| modes.poles.iter().all(|pole| pole.re < 0.0 && pole.im >= 0.0))
}

#[test]
fn error_on_fresh_points_is_within_the_tolerance() {
    let tyre = wide_tyre();
    let options = options(&tyre, 64, 1e-6, 20e3);
    let model = fit(&tyre, &options).unwrap();
    let sum = exact(&tyre, &options);
    let mut points: Vec<_> =
        (0..150).map(|k| Complex64::new(0.0, options.top * 1e-4f64.powf(k as f64 / 149.3))).collect();
    points.extend((1..20).map(|k| Complex64::new(options.top * 0.6f64.powi(k), 0.0)));
    // Between fresh rungs the error may be a little larger than on them.
    let error = fresh_error(&model, &sum, &points, 3e-3);
    assert!(error < 2e-6, "{error:.1e}");
    // The contour of a second-order rule whose |s| reaches the top: there the maximum principle bounds the error by the
    // largest |H_n| alone.
    let contour: Vec<_> = (0..60)
        .map(|k| TimeRule::Bdf2.symbol(Complex64::from_polar(0.999, -PI * k as f64 / 59.0)) * (options.top / 4.0))
        .collect();
    let error = fresh_error(&model, &sum, &contour, 1.0);
    assert!(error < 1e-6, "{error:.1e}");
    assert!(all_poles_are_stable(&model));
    assert!(model.statistics().iter().all(|entry| entry.passivity >= -1e-6 && entry.error <= 1e-6));
}

#[test]
fn convolution_weights_of_the_model_equal_the_brute_force_ones() {
    let tyre = wide_tyre();
    let (elements, speed, lags) = (64, 80.0 / 3.6, 256);
    let time_step = tyre.circumference / elements as f64 / speed;
    let options = options(&tyre, elements, 1e-6, 20e3);
    let model = fit(&tyre, &options).unwrap();
    let weights = Weights::new(&exact(&tyre, &options), Field::Surface, TimeRule::Bdf2, time_step, lags);
    for n in [0, 1, 7, 20, 32] {
        // The rule stepped for every pole: (3/2 a_l - 2 a_(l-1) + a_(l-2)/2)/dt = lambda a_l + F_l.
        let modes = model.modes(n, Field::Surface).unwrap();
        let mut response = vec![modes.constant; 1];
        response.resize(lags, 0.0);
        for (index, (&pole, &residue)) in modes.poles.iter().zip(modes.residues).enumerate() {
            let (mut last, mut before) = (Complex64::ZERO, Complex64::ZERO);
            for (lag, value) in response.iter_mut().enumerate() {
                let force = if lag == 0 { time_step } else { 0.0 };
                let state = (last * 2.0 - before * 0.5 + force) / (1.5 - pole * time_step);
                *value += (residue * state).re * modes.multiplicity(index);
                (before, last) = (last, state);
            }
        }
        let peak = weights.of(n).iter().fold(0.0_f64, |a, &b| a.max(b.abs()));
        let sum: f64 = weights.of(n).iter().map(|w| w.abs()).sum();
        for (lag, (&exact, &ours)) in weights.of(n).iter().zip(&response).enumerate() {
            // A weight is a mean of H over the contour: its error is at most the largest of H.
            assert!((exact - ours).abs() < 2e-6 * sum.max(peak), "n {n}, lag {lag}: {exact:e} {ours:e}");
        }
    }
}

#[test]
fn a_tighter_tolerance_takes_more_poles_and_reaches_it() {
    let tyre = wide_tyre();
    let mut last = 0;
    for tolerance in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        let options = options(&tyre, 16, tolerance, 8e3);
        let model = fit(&tyre, &options).unwrap();
        assert!(model.order() > last, "{tolerance}: {} after {last}", model.order());
        last = model.order();
        assert!(model.statistics().iter().all(|entry| entry.error.max(entry.real_axis_error) <= tolerance));
        // Work is part of the contract: a change that needs twice the poles fails here.
        let most = if tolerance < 1e-5 { 9 * 70 } else { 9 * 55 };
        assert!(last < most, "{last} poles for {tolerance}");
    }
}

#[test]
fn a_tight_tolerance_is_reached_over_the_whole_band() {
    // Every sixteenth wavenumber of 1024 elements round the default tyre. Poles beyond the band are what a tight fit
    // hangs on: the top of the real axis is fitted, not only checked.
    let tyre = Tyre { circumference: 1.95 / 16.0, ..wide_tyre() };
    let options = options(&tyre, 64, 1e-7, 20e3);
    let model = fit(&tyre, &options).unwrap();
    let sum = exact(&tyre, &FitOptions { influence_tolerance: 1e-12, ..options });
    let mut points: Vec<_> =
        (0..150).map(|k| Complex64::new(0.0, options.top * 1e-4f64.powf(k as f64 / 149.3))).collect();
    points.extend((0..20).map(|k| Complex64::new(options.top * 0.6f64.powi(k), 0.0)));
    let error = fresh_error(&model, &sum, &points, 3e-3);
    println!("error {error:.1e}, {} poles", model.order());
    assert!(error < 2e-7, "{error:.1e}");
    assert!(all_poles_are_stable(&model));
    assert!(model.statistics().iter().all(|entry| entry.passivity >= -1e-7));
}

#[test]
fn hard_tyres_reach_the_tolerance_or_are_refused() {
    let base = wide_tyre();
    let changed = |change: &dyn Fn(&mut Tyre)| {
        let mut tyre = base.clone();
        change(&mut tyre);
        tyre
    };
    let four = |tyre: &mut Tyre| {
        let (belt, tread) = (tyre.layers[0].clone(), tyre.layers[1].clone());
        let middle = |thickness, modulus| Layer {
            tension: [0.0; 2],
            thickness,
            material: Material { modulus, ..tread.material.clone() },
            ..tread.clone()
        };
        tyre.layers = vec![belt, middle(6e-3, 5e7), middle(4e-3, 2e7), tread.clone()];
    };
    let cases: Vec<(&str, Tyre)> = vec![
        ("nearly incompressible", changed(&|tyre| tyre.layers[1].material.poisson = 0.4999)),
        ("thin tread", changed(&|tyre| tyre.layers[1].thickness = 3e-3)),
        ("thick tread", changed(&|tyre| tyre.layers[1].thickness = 30e-3)),
        ("stiff belt", changed(&|tyre| tyre.layers[0].material.modulus *= 100.0)),
        ("no tension", changed(&|tyre| tyre.layers[0].tension = [0.0; 2])),
        ("much loss", changed(&|tyre| tyre.layers.iter_mut().for_each(|layer| layer.material.loss_factor = 0.5))),
        ("one layer", changed(&|tyre| drop(tyre.layers.remove(0)))),
        ("four layers", changed(&four)),
    ];
    for (name, tyre) in cases {
        let options = options(&tyre, 16, 1e-5, 6e3);
        let model = fit(&tyre, &options).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(all_poles_are_stable(&model), "{name}");
        let points: Vec<_> =
            (0..77).map(|k| Complex64::new(0.0, options.top * 1e-4f64.powf(k as f64 / 76.3))).collect();
        let error = fresh_error(&model, &exact(&tyre, &options), &points, 3e-3);
        assert!(error < 2e-5, "{name}: {error:.1e}");
        assert!(model.statistics().iter().all(|entry| entry.passivity >= -1e-5), "{name}");
    }
    // Hardly any loss: reached or refused, never shipped worse than asked for.
    let little = changed(&|tyre| tyre.layers.iter_mut().for_each(|layer| layer.material.loss_factor = 0.01));
    match fit(&little, &options(&little, 8, 1e-3, 2e3)) {
        Ok(model) => assert!(all_poles_are_stable(&model)),
        Err(error) => assert!(matches!(error, FitError::Refused { error, .. } if error > 1e-3), "{error}"),
    }
}

#[test]
fn a_law_that_is_not_causal_is_refused_by_the_name_of_its_layer() {
    let mut tyre = wide_tyre();
    tyre.layers[1].material.law = Law::Hysteretic;
    let refused = fit(&tyre, &options(&tyre, 8, 1e-6, 4e3));
    assert_eq!(refused, Err(FitError::NotCausal { layer: "tread".into() }));
}

#[test]
fn options_out_of_range_are_named() {
    let tyre = wide_tyre();
    for (options, name) in [
        (FitOptions { elements: 7, ..options(&tyre, 8, 1e-3, 1e3) }, "elements"),
        (FitOptions { top: f64::NAN, ..options(&tyre, 8, 1e-3, 1e3) }, "top"),
        (FitOptions { tolerance: 0.0, ..options(&tyre, 8, 1e-3, 1e3) }, "tolerance"),
    ] {
        assert!(matches!(fit(&tyre, &options), Err(FitError::Options { what, .. }) if what == name));
    }
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let tyre = wide_tyre();
    let options = options(&tyre, 32, 1e-4, 6e3);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fit(&tyre, &options).unwrap())
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn a_fit_stops_before_it_begins_and_on_its_way() {
    let tyre = wide_tyre();
    let stop = AtomicBool::new(true);
    assert_eq!(fit_unless_stopped(&tyre, &options(&tyre, 8, 1e-3, 2e3), &stop), Err(FitError::Stopped));
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::at(folder.path().to_path_buf(), u64::MAX);
    let long = options(&tyre, 2048, 1e-7, 20e3);
    stop.store(false, Ordering::Relaxed);
    let fetched = std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(Duration::from_millis(30));
            stop.store(true, Ordering::Relaxed);
        });
        fetch(&cache, &tyre, &long, &stop)
    });
    assert!(matches!(fetched, Err(FitError::Stopped)));
    assert!(cache.list(&[RationalModel::KIND]).unwrap().is_empty(), "half a model is none");
}

#[test]
fn elements_of_half_a_millimetre_take_few_near_poles() {
    // The wavenumbers of 4096 elements round the default tyre, 16 of them: at the highest ones the tread is a
    // half-space at rest, and poles to spare used to run away beyond the band until they overflowed, or until 150 of
    // them were in use.
    let tyre = Tyre { circumference: 1.95 / 256.0, ..wide_tyre() };
    let options = options(&tyre, 16, 1e-5, 20e3);
    let model = fit(&tyre, &options).unwrap();
    for n in 2..=8 {
        assert!(model.statistics()[n].order <= 40, "n = {n}: {} poles", model.statistics()[n].order);
        let modes = model.modes(n, Field::Surface).unwrap();
        assert!(modes.poles.iter().all(|pole| pole.norm() < 31.0 * options.top), "n = {n}");
    }
}

#[test]
fn a_bad_cache_entry_is_rebuilt_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::at(folder.path().join("models"), u64::MAX);
    let tyre = wide_tyre();
    let options = options(&tyre, 8, 1e-3, 2e3);
    let cold = fetch(&cache, &tyre, &options, &NEVER).unwrap();
    assert!(!cold.warm && cold.warnings.is_empty());
    let warm = fetch(&cache, &tyre, &options, &NEVER).unwrap();
    assert!(warm.warm && warm.warnings.is_empty());
    assert_eq!(cold.model, warm.model);

    let path = cache.path::<RationalModel>(&key(&tyre, &options).unwrap());
    let sound = fs::read(&path).unwrap();
    let mut cases: Vec<(Vec<u8>, Option<Unusable>)> = vec![
        (sound[..sound.len() / 2].to_vec(), Some(Unusable::Truncated)),
        (Vec::new(), Some(Unusable::Truncated)),
        (b"a letter home".to_vec(), Some(Unusable::Foreign { wanted: "an influence model" })),
        ([&sound[..], b"more"].concat(), Some(Unusable::Damaged)),
    ];
    for position in [20, 60, sound.len() / 2, sound.len() - 1] {
        let mut damaged = sound.clone();
        damaged[position] ^= 0x40;
        cases.push((damaged, None));
    }
    let mut older = sound.clone();
    older[8] = 0;
    cases.push((older, Some(Unusable::Version { found: 0, wanted: RationalModel::KIND.format.version })));
    for (bytes, reason) in cases {
        fs::write(&path, &bytes).unwrap();
        let found = cache.load::<RationalModel>(&key(&tyre, &options).unwrap()).unwrap().unwrap().unwrap_err();
        assert!(reason.is_none_or(|reason| reason == found), "{found:?} for {reason:?}");
        let again = fetch(&cache, &tyre, &options, &NEVER).unwrap();
        assert!(!again.warm && again.warnings.len() == 1, "{:?}", again.warnings);
        assert_eq!(again.model, cold.model);
        assert_eq!(fs::read(&path).unwrap(), sound, "rebuilt to the same bytes");
    }

    // A sound entry under another model's name.
    let other = FitOptions { tolerance: 2e-3, ..options };
    fs::copy(&path, cache.path::<RationalModel>(&key(&tyre, &other).unwrap())).unwrap();
    let load = cache.load::<RationalModel>(&key(&tyre, &other).unwrap()).unwrap().unwrap();
    assert_eq!(load.unwrap_err(), Unusable::Key);
    assert_eq!(cache.list(&[RationalModel::KIND]).unwrap().len(), 2);
    assert_eq!(cache.clear().unwrap().0, 2);
    assert!(cache.list(&[RationalModel::KIND]).unwrap().is_empty());
}

#[test]
fn everything_that_a_model_depends_on_changes_its_key() {
    let base = wide_tyre();
    let usual = options(&base, 8, 1e-3, 2e3);
    let mut keys = vec![key(&base, &usual).unwrap()];
    for change in [
        |tyre: &mut Tyre| tyre.width = 0.21,
        |tyre: &mut Tyre| tyre.layers[0].tension[1] = 2.000_000_000_000_1e4,
        |tyre: &mut Tyre| tyre.layers[1].material.corner_frequency = 1.5,
        |tyre: &mut Tyre| tyre.foundation.loss_factor = 0.11,
        |tyre: &mut Tyre| tyre.layers.truncate(1),
    ] {
        let mut tyre = base.clone();
        change(&mut tyre);
        keys.push(key(&tyre, &usual).unwrap());
    }
    for options in [
        FitOptions { elements: 10, ..usual },
        FitOptions { driven: Field::UnderTread, ..usual },
        FitOptions { top: 1.1 * usual.top, ..usual },
        FitOptions { tolerance: 1.1e-3, ..usual },
        FitOptions { influence_tolerance: 1e-9, ..usual },
    ] {
        keys.push(key(&base, &options).unwrap());
    }
    let count = keys.len();
    keys.sort_unstable();
    keys.dedup();
    assert_eq!(keys.len(), count);
}

#[test]
fn concurrent_writers_and_readers_see_whole_entries() {
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::at(folder.path().to_path_buf(), u64::MAX);
    let tyre = wide_tyre();
    let usual = options(&tyre, 8, 1e-2, 1e3);
    let model = fit(&tyre, &usual).unwrap();
    let name = key(&tyre, &usual).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for _ in 0..25 {
                    cache.store(&name, &model).unwrap();
                    assert_eq!(cache.load::<RationalModel>(&name).unwrap().unwrap().unwrap(), model);
                }
            });
        }
    });
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");

    let size = cache.list(&[RationalModel::KIND]).unwrap()[0].bytes;
    let bounded = Cache::at(folder.path().to_path_buf(), 3 * size);
    for index in 0..6_u8 {
        bounded.store(&[index; 32], &model).unwrap();
    }
    let total: u64 = bounded.list(&[RationalModel::KIND]).unwrap().iter().map(|entry| entry.bytes).sum();
    assert!(total <= 3 * size);
    assert!(bounded.load::<RationalModel>(&[5; 32]).unwrap().unwrap().is_ok(), "the newest stays");
}

#[test]
fn a_folder_that_cannot_be_used_costs_a_warning_only() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "in the way").unwrap();
    let tyre = wide_tyre();
    let fetched = fetch(&Cache::at(file, u64::MAX), &tyre, &options(&tyre, 8, 1e-2, 1e3), &NEVER).unwrap();
    assert!(!fetched.warm && !fetched.warnings.is_empty());
}
