//! Decisions of a plan, and its refusals.

use super::*;
use crate::counters::Stage;
use crate::plan::front::FrontRow;
use crate::scene::tests::{BASE, edited, listed};
use crate::scene::{PLATE, Preset, Road, SceneError, TimeRule};
use crate::test_models::{replaced, with_road};

fn planned(text: &str) -> Result<Plan, SceneError> {
    Plan::of(&Scene::from_str(text, "test.toml")?)
}

/// Asserts that the plan of the base scene with `from` replaced by `to` is refused with exactly one complaint.
#[track_caller]
fn refused(from: &str, to: &str, line: usize, key: &str, wrong: &str, right: &str) {
    let loaded = Scene::from_str(&edited(from, to), "test.toml").unwrap();
    let found = listed(&Plan::of(&loaded).unwrap_err());
    let [complaint] = found.as_slice() else { panic!("expected one complaint, got {found:#?}") };
    assert_eq!((complaint.line, complaint.key.as_str()), (line, key), "{complaint:?}");
    assert!(complaint.wrong.contains(wrong) && complaint.right.contains(right), "{complaint:?}");
}

#[test]
fn what_cannot_reach_the_highest_frequency_is_refused() {
    let from = "elements = 512";
    refused(from, "fmax = 9e3\nelements = 512", 26, "numerics.elements", "no texture above", "leave it out");
    refused(from, "fmax = 2e3\nsubsteps = 1", 26, "numerics.substeps", "up to", "leave it out");
    for keys in ["fmax = 2e3", "fmax = 2e3\nelements = 512"] {
        assert!(planned(&edited(from, keys)).is_ok(), "{keys}");
    }
    let finest = "at least 0.3 dB";
    let keys = "fmax = 1000\naccuracy = \"0.06 dB\"";
    refused(from, keys, 26, "numerics.accuracy", "finer than any row", finest);
    let keys = "fmax = 2500\naccuracy = \"3 dB\"";
    refused(from, keys, 26, "numerics.accuracy", "no error is stated for fmax = 2500 Hz", "fmax up to 2000 Hz");
}

#[test]
fn elements_that_the_tyre_does_not_have_are_refused() {
    let with = |elements: &str| format!("plots = true\n[outputs.vibration]\nelements = {elements}");
    let key = "outputs.vibration.elements[1]";
    refused("plots = true", &with("[511, 512]"), 29, key, "no element 512", "from 0 to 511");
    assert!(planned(&edited("plots = true", &with("[511, 0]"))).is_ok());
}

/// The base scene on a made road with keys under `[numerics]`, without the settings that a row of the table chooses.
fn open(keys: &str) -> String {
    let chosen = ["elements", "substeps", "time_rule", "history"];
    let others = BASE.lines().filter(|line| !chosen.iter().any(|key| line.starts_with(key)));
    let text = others.collect::<Vec<_>>().join("\n").replace("kind = \"smooth\"", "kind = \"made\"");
    text.replace("[numerics]", &format!("[numerics]\nfmax = 1000\n{keys}"))
}

#[test]
fn missing_settings_follow_from_preset_and_accuracy() {
    for row in FrontRow::all(Zone::Slices) {
        let (name, error) = (row.preset.name(), row.error(1000.0).unwrap());
        let load = |wish: &str| planned(&open(wish)).unwrap_or_else(|error| panic!("{}", error.render(false)));
        let (preset, accuracy) = (load(&format!("preset = \"{name}\"")), load(&format!("accuracy = \"{error} dB\"")));
        let mut same = accuracy.scene.clone();
        (same.numerics.preset, same.numerics.accuracy) = (Some(row.preset), None);
        assert_eq!(same, preset.scene);
        for (plan, wish) in [(&preset, "preset"), (&accuracy, "accuracy")] {
            let keys: Vec<&str> = plan.choices.iter().map(|choice| choice.key).collect();
            let first = format!("numerics.{wish}");
            let mut expected = vec![
                first.as_str(),
                "numerics.time_rule",
                "numerics.history",
                "numerics.pole_tolerance",
                "numerics.contact_tolerance",
                "contact.slice_tolerance",
                "contact.cells_across",
                "numerics.elements",
                "numerics.substeps",
                "contact.cells_along",
            ];
            // The standard row's value is the default.
            expected.retain(|key| *key != "contact.slice_tolerance" || row.preset != Preset::Standard);
            assert_eq!(keys, expected);
            assert!(plan.choices[0].reason.contains(&format!("within {error} dB")));
            assert!(plan.choices.iter().all(|choice| !choice.reason.is_empty()));
            let found = &plan.scene;
            assert_eq!(
                found.contact.cells_across,
                Some(Road::cells(found.tyre.contact_width, row.cell_for(found, found.numerics.fmax.unwrap())))
            );
            assert!((found.numerics.pole_tolerance / row.pole_tolerance - 1.0).abs() < 1e-12);
            // The effective settings are read back unchanged; all of them are given then.
            let again = planned(&found.to_toml().unwrap()).unwrap();
            assert_eq!(again.scene, *found);
            assert!(again.choices.is_empty(), "{:?}", again.choices);
        }
    }
}

#[test]
fn keys_that_are_given_stay_beside_a_preset() {
    let keys =
        "preset = \"draft\"\nelements = 1000\ntime_rule = \"sdirk2\"\nhistory = \"direct\"\npole_tolerance = 1e-8";
    let plan = planned(&open(keys)).unwrap();
    let numerics = &plan.scene.numerics;
    assert_eq!((numerics.elements, numerics.time_rule, numerics.history), (1000, TimeRule::Sdirk2, History::Direct));
    assert!((numerics.pole_tolerance - 1e-8).abs() < 1e-20);
    let chosen: Vec<&str> = plan.choices.iter().map(|choice| choice.key).collect();
    let expected = [
        "numerics.preset",
        "numerics.contact_tolerance",
        "contact.slice_tolerance",
        "contact.cells_across",
        "numerics.elements_per_step",
        "contact.cells_along",
    ];
    assert_eq!(chosen, expected);
}

#[test]
fn a_preset_over_cells_asks_for_no_more_than_it_needs() {
    for row in FrontRow::all(Zone::Cells) {
        let cells = |keys: &str| {
            let text = open(&format!("preset = \"{}\"\n{keys}", row.preset.name()));
            planned(&replaced(&text, &[("tread = \"elastic\"", "zone = \"cells\"")])).unwrap()
        };
        let plan = cells("");
        assert!((plan.cell_tolerance() / row.contact_tolerance - 1.0).abs() < 1e-12);
        assert!(plan.is_single() && plan.fewer_poles().is_some());
        assert!(plan.choices.iter().any(|choice| choice.key == "numerics.contact_tolerance"));
        let exact = cells("contact_tolerance = 1e-12");
        assert!(!exact.is_single() && exact.fewer_poles().is_none());
    }
    let slices = |keys: &str| planned(&open(keys)).unwrap().is_single();
    assert!(slices("preset = \"draft\"") && !slices("preset = \"draft\"\ncontact_tolerance = 1e-12"));
}

#[test]
fn short_rings_have_room_for_the_contact_and_with_vibration_only_waves_of_the_tyre() {
    let mut scene = Scene::from_str(crate::scene::DEFAULT, "default").unwrap().scene;
    scene.contact.zone = Zone::Cells;
    let mut plan = Plan::new(&scene);
    for (columns, wanted) in [(30, [64, 64]), (60, [108, 128]), (75, [128, 128]), (90, [144, 256])] {
        for (takes_models, wanted) in [false, true].into_iter().zip(wanted) {
            plan.decisions.takes_models = takes_models;
            let bands = plan.wave_bands(columns);
            for band in &bands[1..] {
                assert_eq!(band.ring, Some(wanted), "{columns} columns");
                let patch = plan.seen_columns(*band, columns);
                assert!(patch as f64 >= 0.68 * columns as f64 && patch < wanted, "{patch} of {columns}");
                assert!(
                    plan.forgotten_after(*band, columns).unwrap() as f64 > 0.68 * columns as f64 - 1.0,
                    "{columns}"
                );
            }
        }
    }
}

#[test]
fn a_preset_takes_cells_for_sound_unless_slices_are_given() {
    let receiver = "\n[[receiver]]\nstandard = \"cpx\"\n";
    let zone = |preset: &str, law: &str, receiver: &str| {
        let text = replaced(&open(preset), &[("tread = \"elastic\"", law)]);
        let plan = planned(&(text + receiver)).unwrap_or_else(|error| panic!("{}", error.render(false)));
        let chosen = plan.choices.iter().any(|choice| choice.key == "contact.zone");
        (plan.decisions.zone == Zone::Cells, chosen)
    };
    let preset = "preset = \"draft\"";
    assert_eq!(zone(preset, "", receiver), (true, true));
    assert_eq!(zone("accuracy = \"3 dB\"", "", receiver), (true, true));
    for law in ["slices = \"winkler\"", "tread = \"elastic\"", "zone = \"slices\""] {
        assert_eq!(zone(preset, law, receiver), (false, false), "{law}");
    }
    assert_eq!(zone(preset, "", ""), (false, false));
    assert_eq!(zone("", "", receiver), (false, false));
}

#[test]
fn what_sidewalls_give_is_shown_beside_what_is_used() {
    let foundation = "foundation = { normal = 1.8e6, tangential = 1e6, loss_factor = 0.1 }";
    let sidewall = "curvature = true\ninflation = { pressure = 2.2e5 }\n\
                    sidewall = { radius = 0.05, angle = 1.1, mass = 7.0, shear = 8e3 }";
    let text = edited(foundation, sidewall);
    let given = planned(&text).unwrap();
    let formula = format!("{:.3e} N/m along", given.scene.tyre.carried_tension().unwrap());
    let [choice] = given.choices.as_slice() else { panic!("{:?}", given.choices) };
    assert_eq!((choice.key, choice.value.as_str()), ("tyre.layers.tension", "6.000e4 N/m along all layers"));
    assert!(choice.reason.contains("given; ") && choice.reason.contains(&formula), "{}", choice.reason);
    let open = planned(&replaced(&text, &[("tension = [6e4, 2e4]\n", "")])).unwrap();
    let [choice] = open.choices.as_slice() else { panic!("{:?}", open.choices) };
    assert!(choice.value.contains(&formula) && choice.reason.contains("sidewalls give"), "{choice:?}");
    assert_eq!(planned(&open.scene.to_toml().unwrap()).unwrap().choices, open.choices);
    assert!(planned(BASE).unwrap().choices.is_empty());
}

#[test]
fn the_estimate_knows_how_the_history_is_carried() {
    let text = PLATE.replace("elements = 512", "elements = 4096").replace("speed_kmh = 80.0", "speed_kmh = 250.0");
    let mut loaded = Scene::from_str(&text, "estimate").unwrap();
    loaded.scene.rolling.duration = 1.0;
    let core_seconds = |plan: &Plan| plan.forecast(&UnitCosts::default(), 1, 0.0).core_seconds();
    let modal = Plan::new(&loaded.scene);
    assert!(modal.check(&loaded).is_ok(), "{} core seconds", core_seconds(&modal));
    loaded.scene.numerics.memory *= 2.0;
    let longer = Plan::new(&loaded.scene);
    assert_eq!(core_seconds(&longer).to_bits(), core_seconds(&modal).to_bits(), "poles have no memory");
    loaded.scene.numerics.history = History::Direct;
    let direct = Plan::new(&loaded.scene);
    assert!(core_seconds(&direct) > 100.0 * core_seconds(&modal));
    assert!(direct.amounts().memory_on(1) > modal.amounts().memory_on(1));
    assert!(direct.check(&loaded).is_err());
}

#[test]
fn threads_share_the_work_and_a_smooth_road_has_hardly_any() {
    let rough = Plan::new(&Scene::from_str(PLATE, "default").unwrap().scene);
    let of = |plan: &Plan, threads| plan.forecast(&UnitCosts::default(), threads, 1e7);
    let background = |plan: &Plan, of_road: bool| -> f64 {
        let stages = of(plan, 2).stages;
        let road = |stage: Stage| matches!(stage, Stage::Road | Stage::Slices);
        stages.iter().filter(|it| it.background && road(it.stage) == of_road).map(|it| it.seconds).sum()
    };
    // Work in the background delays nobody.
    assert!(background(&rough, true) > 0.0 && background(&rough, false) > 0.0);
    assert!(of(&rough, 2).wall_seconds < 0.8 * of(&rough, 1).wall_seconds);
    assert!((of(&rough, 2).core_seconds() - of(&rough, 1).core_seconds()).abs() < 1e-9);
    let text = with_road(PLATE, "kind = \"smooth\"");
    let smooth = Plan::new(&Scene::from_str(&text, "smooth").unwrap().scene);
    let road = background(&smooth, true);
    assert!(road < 0.01 * of(&smooth, 2).wall_seconds, "{road}");
    let held = |plan: &Plan| plan.amounts().memory.iter().map(|(_, bytes)| bytes).sum::<f64>();
    assert!(held(&smooth) < held(&rough));
}

#[test]
fn curvature_of_short_waves_does_not_move_expected_contact() {
    use crate::contact::static_contact::StaticTyre;
    use crate::tyre::influence::{Field, InfluenceSum, Projection, Truncation};
    let scene = crate::scene::Scene::from_str(crate::scene::DEFAULT, "default").unwrap().scene;
    let (tyre, tolerance) = (&scene.tyre, super::feasible::COARSE_TOLERANCE);
    let projection = || Projection::new(tyre, 256);
    let whole = InfluenceSum::with(tyre, projection(), Truncation::Tail, tolerance, 1.0);
    let [coarse, whole] = [InfluenceSum::coarse_at_rest(tyre, projection(), tolerance), whole].map(|sum| {
        let row = sum.static_row(Field::Surface);
        StaticTyre { influence: &row, circumference: tyre.circumference }.under(&scene.rolling.axle).unwrap()
    });
    assert!((coarse.indentation / whole.indentation - 1.0).abs() < 1e-3, "{coarse:?} {whole:?}");
    assert!((coarse.length - whole.length).abs() < 1e-12, "{coarse:?} {whole:?}");
    assert!(coarse.indentation.to_bits() != whole.indentation.to_bits(), "nothing was left out");
}

#[test]
fn a_plan_presses_its_tyre_once() {
    let loaded = crate::scene::Scene::from_str(crate::scene::PLATE, "plate").unwrap();
    let plan = Plan::of(&loaded).unwrap();
    assert!(plan.standing.get().is_none(), "a plan alone sums nothing");
    plan.check(&loaded).unwrap();
    let found = plan.standing.get().unwrap().clone();
    assert!(found.is_ok() && plan.clone().with_cached_model().standing.get() == Some(&found));
    // Plans that differ only in settings it does not depend on share it, those with another tyre or axle do not.
    let of = |change: &dyn Fn(&mut Scene)| {
        let mut scene = plan.scene.clone();
        change(&mut scene);
        Plan::new(&scene)
    };
    let finer = of(&|scene| scene.numerics.elements *= 2);
    let expected = finer.amounts().expected;
    let finer = of(&|scene| scene.numerics.elements *= 2).standing_as(&plan);
    assert!(finer.standing.get() == Some(&found) && finer.amounts().expected == expected);
    let wider = of(&|scene| scene.tyre.width *= 1.1).standing_as(&plan);
    let heavier = of(&|scene| scene.rolling.axle = Axle::Load { load: 4000.0, tolerance: 0.01 }).standing_as(&plan);
    assert!(wider.standing.get().is_none() && heavier.standing.get().is_none());
}

#[test]
fn results_over_cells_have_rows_across() {
    let text = edited("tread = \"elastic\"", "zone = \"cells\"\ncells_across = 4");
    let plan = planned(&text).unwrap();
    let amounts = plan.amounts();
    // Time, total force, first element, length, area, peak pressure; forces of columns and of rows.
    let of_step = 8.0 * (6.0 + amounts.expected.columns + 4.0);
    assert_eq!(amounts.result_bytes as u64, (plan.steps as f64 * of_step) as u64);
    let without = planned(&text.replace("plots = true", "plots = true\narrays = false")).unwrap();
    assert_eq!(without.amounts().result_bytes as u64, 0);
}
