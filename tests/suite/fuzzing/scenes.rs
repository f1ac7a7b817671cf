//! Random scenes, made of the keys that a scene may have: each is planned or refused, soon, and none panics.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value as Json;
use toml::{Table, Value};
use tyrewave::Plan;
use tyrewave::internals::{Section, sections};
use tyrewave::scene::{DEFAULT, PLATE, Scene};

use super::corpus;

/// The two numbers behind "from ... to ...", in what a key's title says is plausible.
fn plausible(of: &Json) -> Option<[f64; 2]> {
    let (_, range) = of["title"].as_str()?.rsplit_once("from ")?;
    let (least, rest) = range.split_once(" to ")?;
    Some([least.parse().ok()?, rest.split(' ').next()?.parse().ok()?])
}

/// A value that a schema takes, or nearly.
fn value(of: &Json, random: &mut ChaCha8Rng) -> Option<Value> {
    let limit = |word: &str| of[word].as_f64();
    let kind = of["type"].as_str().or_else(|| of["type"][0].as_str()).unwrap_or_default();
    Some(match kind {
        _ if of["enum"].is_array() => {
            let words = of["enum"].as_array()?;
            words[random.random_range(0..words.len())].as_str()?.into()
        }
        "number" => {
            let low = limit("minimum").or(limit("exclusiveMinimum"));
            let high = limit("maximum").or(limit("exclusiveMaximum"));
            let slightly_outside = random.random_bool(0.05);
            let number = match (plausible(of), low, high) {
                (Some([least, most]), ..) => {
                    let (least, most) = if slightly_outside { (0.5 * least, 2.0 * most) } else { (least, most) };
                    (random.random_range(least.ln()..=most.ln())).exp()
                }
                (None, Some(low), Some(high)) => {
                    random.random_range(low..=high) * if slightly_outside { 1.1 } else { 1.0 }
                }
                (None, Some(low), None) => low + random.random_range(-9.0_f64..9.0).exp(),
                _ => random.random_range(-100.0..100.0),
            };
            number.into()
        }
        "integer" => {
            let least = of["minimum"].as_i64().unwrap_or(0);
            let even = of["multipleOf"].as_i64().unwrap_or(1);
            let number = least + random.random_range(0.0_f64..9.0).exp() as i64;
            (number / even * even).into()
        }
        "boolean" => random.random_bool(0.5).into(),
        "string" if of["pattern"].is_string() => "0.5 dB".into(),
        "string" => "p.csv".into(),
        "array" => {
            let (least, most) = (of["minItems"].as_u64().unwrap_or(1), of["maxItems"].as_u64().unwrap_or(4));
            let count = random.random_range(least..=most.max(least));
            Value::Array((0..count).map(|_| value(&of["items"], random)).collect::<Option<_>>()?)
        }
        "object" => {
            let required = of["required"].as_array()?;
            let mut table = Table::new();
            for (key, inner) in of["properties"].as_object()? {
                let needed = required.iter().any(|name| name == key);
                if let Some(word) = inner["const"].as_str() {
                    table.insert(key.clone(), word.into());
                } else if (needed || random.random_bool(0.3))
                    && let Some(value) = value(inner, random)
                {
                    table.insert(key.clone(), value);
                }
            }
            Value::Table(table)
        }
        _ => {
            let alternatives = of["oneOf"].as_array().or_else(|| of["anyOf"].as_array())?;
            return value(&alternatives[random.random_range(0..alternatives.len())], random);
        }
    })
}

/// The table at a section's path, where the scene has it.
fn at<'a>(scene: &'a mut Table, path: &str, random: &mut ChaCha8Rng) -> Option<&'a mut Table> {
    let mut table = scene;
    for name in path.split('.').filter(|name| !name.is_empty()) {
        table = match table.get_mut(name)? {
            Value::Table(inner) => inner,
            Value::Array(items) => {
                let count = items.len();
                items.get_mut(random.random_range(0..count.max(1)))?.as_table_mut()?
            }
            _ => return None,
        };
    }
    Some(table)
}

/// A shipped scene with one to eight of its keys changed or added.
fn scene(bases: &[Table], all: &[Section<'_>], random: &mut ChaCha8Rng) -> String {
    let mut scene = bases[random.random_range(0..bases.len())].clone();
    for _ in 0..random.random_range(1..=8) {
        let section = &all[random.random_range(0..all.len())];
        let Some(keys) = section.schema["properties"].as_object() else { continue };
        let Some((key, of)) = keys.iter().nth(random.random_range(0..keys.len())) else { continue };
        let whole = of["const"].is_string().then_some(section.schema);
        let Some(new) = value(whole.unwrap_or(of), random) else { continue };
        match (whole, at(&mut scene, &section.path, random)) {
            (Some(_), _) if section.path == "road" => drop(scene.insert("road".to_owned(), new)),
            (None, Some(table)) => drop(table.insert(key.clone(), new)),
            _ => {}
        }
    }
    if random.random_bool(0.1) {
        scene.insert("allow_implausible".to_owned(), true.into());
    }
    scene.to_string()
}

/// Plans a scene and returns the end.
fn planned(text: &str) -> String {
    let outcome = Scene::from_str(text, "random").and_then(|loaded| {
        loaded.check_time_domain()?;
        let plan = Plan::of(&loaded)?;
        plan.check(&loaded)?;
        let amounts = plan.amounts();
        assert!(amounts.memory.iter().all(|(_, bytes)| bytes.is_finite()), "{:?}", amounts.memory);
        Ok(())
    });
    outcome.map_or_else(|error| error.to_string().lines().next().unwrap_or_default().to_owned(), |()| "planned".into())
}

/// So many random scenes, those longer than `reported` printed; the slowest first, with how long each took and
/// what became of it.
fn all_end(count: u64, seed: u64, reported: Duration) -> Vec<(Duration, String, String)> {
    let schema = Scene::json_schema();
    let all = sections(&schema);
    let bases = [DEFAULT, PLATE, corpus::SOUND].map(|text| text.parse::<Table>().unwrap());
    let mut found = Vec::new();
    for number in 0..count {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(number);
        let text = scene(&bases, &all, &mut random);
        let begin = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| planned(&text)));
        let taken = begin.elapsed();
        let outcome = outcome.unwrap_or_else(|_| panic!("scene {number} of seed {seed} panics:\n{text}"));
        if taken > reported {
            println!("{taken:.1?} for scene {number} of seed {seed}: {outcome}\n{text}");
        }
        found.push((taken, outcome, text));
    }
    found.sort_by_key(|(taken, ..)| std::cmp::Reverse(*taken));
    found
}

#[test]
fn random_scenes_are_planned_or_refused() {
    let found = all_end(12, 1, Duration::MAX);
    assert!(found.iter().any(|(_, outcome, _)| outcome != "planned"));
}

#[test]
#[ignore = "10^4 scenes, the ten slowest printed; 10 min"]
fn ten_thousand_random_scenes_are_planned_or_refused_soon() {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse().ok());
    let (reported, longest) = (Duration::from_secs(1), Duration::from_secs(5));
    let count = number("TYREWAVE_FUZZ_SCENES").unwrap_or(10_000);
    let found = all_end(count, number("TYREWAVE_FUZZ_SEED").unwrap_or(2), reported);
    let planned = found.iter().filter(|(_, outcome, _)| outcome == "planned").count();
    println!("{planned} of {count} planned, the others refused; the ten slowest:");
    found.iter().take(10).for_each(|(taken, outcome, _)| println!("{taken:>10.1?}  {outcome}"));
    assert!(planned as u64 * 20 > count, "hardly any scene is planned");
    assert!(found[0].0 <= longest, "a scene takes {:.1?}:\n{}", found[0].0, found[0].2);
}
