//! Tyres, roads and scenes of unit tests, integration tests and benchmarks.
//!
//! A test's scene is the shipped one of the flat tyre, or a scene of that tyre given as text, with some keys changed. A
//! change that finds nothing to change panics: otherwise a test would lose its subject unnoticed when the shipped scene
//! changes.

pub(crate) mod cells;
pub mod transforms;

use std::path::{Path, PathBuf};

use toml::{Table, Value};

use crate::scene::{LoadedScene, PLATE, Scene, Tyre};

/// The flat tyre's circumference \[m\].
pub const CIRCUMFERENCE: f64 = 1.95;
/// The flat tyre's contact width \[m\].
pub const CONTACT_WIDTH: f64 = 0.12;

/// A measured road of chip seal, a CAPTIF profile, among the [`reference`] files.
pub const CHIP_SEAL: &str = "roads/captif_aylesbury_station_10.dat";
/// A measured strip of cobbles, OpenCRG, among the [`reference`] files.
pub const COBBLES: &str = "roads/belgian_block.crg";

/// Path of a file of `tests/reference`: published values and measured roads.
pub fn reference(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(name)
}

/// Scene read from TOML text.
///
/// # Panics
///
/// If the text is not a valid scene.
pub fn scene(text: &str) -> LoadedScene {
    Scene::from_str(text, "scene.toml").unwrap_or_else(|error| panic!("{}\n{text}", error.render(false)))
}

/// The shipped scene of the flat tyre.
pub fn plate_scene() -> Scene {
    scene(PLATE).scene
}

/// The flat tyre, of [`CIRCUMFERENCE`] and 0.12 m contact width.
pub fn plate_tyre() -> Tyre {
    plate_scene().tyre
}

/// The flat tyre with a strip 0.15 m wide.
pub fn wide_tyre() -> Tyre {
    Tyre { contact_width: 0.15, ..plate_tyre() }
}

/// [`wide_tyre`] with layers of one density and a tread of the given loss factor.
#[cfg(test)]
pub(crate) fn tyre(loss_factor: f64) -> Tyre {
    let mut tyre = wide_tyre();
    tyre.layers.iter_mut().for_each(|layer| layer.material.density = 1200.0);
    tyre.layers[1].material.loss_factor = loss_factor;
    tyre
}

/// Text of a scene of the flat tyre: the keys of the tables of road and rolling, further keys of the numerics, and
/// further tables. The sums are short for speed: 4 lateral terms, 2 aliases.
pub fn scene_text(elements: usize, road: &str, rolling: &str, numerics: &str, more: &str) -> String {
    format!(
        "{}\n[road]\n{road}\n[rolling]\n{rolling}\n[numerics]\nelements = {elements}\nlateral_terms = 4\n\
         wavenumber_aliases = 2\n{numerics}\n{more}\n",
        tyre_tables()
    )
}

/// Allows implausible numbers in a scene's text.
pub fn implausible(text: &str) -> String {
    format!("allow_implausible = true\n{text}")
}

/// Restores the default number of terms of the sums in a text of [`scene_text`].
pub fn with_all_terms(text: &str) -> String {
    without(text, &["numerics.lateral_terms", "numerics.wavenumber_aliases"])
}

/// The tables `[tyre]` and `[[tyre.layers]]` of the shipped scene, as TOML.
fn tyre_tables() -> String {
    let mut tables = table(PLATE);
    tables.retain(|name, _| name == "tyre");
    tables.to_string()
}

/// Keys of a road from a grid whose lattice is that of the run, so that it is used without resampling.
pub fn grid_road(path: &Path, elements: usize, columns: usize) -> String {
    format!(
        "kind = \"grid\"\nfile = '{}'\ndx = {:?}\ndy = {:?}\nlevel = \"off\"",
        path.display(),
        CIRCUMFERENCE / elements as f64,
        CONTACT_WIDTH / columns as f64
    )
}

/// Replaces the values of keys in a scene's text, as `("rolling.speed_kmh", "110.0")`; a layer goes by its number, as
/// in `"tyre.layers.1.material.modulus"`.
///
/// # Panics
///
/// If a key is not there.
pub fn edit(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (path, value)| {
        changed(&text, path, |inside, key| {
            let there = inside.contains_key(key);
            inside.extend(table(&format!("{key} = {value}")));
            there
        })
    })
}

/// Removes keys or tables from a scene's text.
///
/// # Panics
///
/// If a key or table is not there.
pub fn without(text: &str, paths: &[&str]) -> String {
    paths.iter().fold(text.to_owned(), |text, path| changed(&text, path, |inside, key| inside.remove(key).is_some()))
}

/// Adds keys to a table of a scene's text.
///
/// # Panics
///
/// If the table is not there, or one of the keys is.
pub fn add(text: &str, name: &str, keys: &str) -> String {
    changed(text, name, |inside, name| {
        let Some(Value::Table(inside)) = inside.get_mut(name) else { return false };
        table(keys).into_iter().all(|(key, value)| inside.insert(key, value).is_none())
    })
}

/// Replaces the road of a scene's text; `keys` are those of the table `[road]`.
///
/// # Panics
///
/// If the text has no road.
pub fn with_road(text: &str, keys: &str) -> String {
    changed(text, "road", |inside, road| inside.insert(road.to_owned(), table(keys).into()).is_some())
}

/// Replaces the tyre of a scene's text by the car tyre with springs instead of sidewalls, the default of earlier
/// versions.
///
/// # Panics
///
/// If the text has no tyre.
pub fn on_springs(text: &str) -> String {
    let springs = table(include_str!("../../scenes/tyres/spring_sides.toml"));
    changed(text, "tyre", |inside, tyre| inside.insert(tyre.to_owned(), springs.into()).is_some())
}

/// Replaces passages in any text; the result need not be a scene.
///
/// # Panics
///
/// If a passage is not there.
pub fn replaced(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "no {from:?} in\n{text}");
        text.replace(from, to)
    })
}

/// Text after a change of the table that holds the last key of a path; `change` returns false if it found nothing to
/// change.
fn changed(text: &str, path: &str, change: impl FnOnce(&mut Table, &str) -> bool) -> String {
    let mut scene = Value::Table(table(text));
    let (way, key) = path.rsplit_once('.').unwrap_or(("", path));
    let inside = way.split_terminator('.').try_fold(&mut scene, |value, key| match key.parse::<usize>() {
        Ok(number) => value.get_mut(number),
        Err(_) => value.get_mut(key),
    });
    let done = inside.and_then(Value::as_table_mut).is_some_and(|inside| change(inside, key));
    assert!(done, "{path} cannot be changed in\n{text}");
    scene.as_table().map(Table::to_string).unwrap_or_default()
}

fn table(text: &str) -> Table {
    text.parse().unwrap_or_else(|error| panic!("{error}\n{text}"))
}

#[cfg(test)]
mod tests {
    use std::panic::catch_unwind;

    use super::*;
    use crate::scene::Axle;

    #[test]
    fn a_text_written_again_is_the_same_scene() {
        let text = with_road(PLATE, "kind = \"made\"\ntexture = \"dac-11\"\nseed = 1");
        assert_eq!(scene(&text).scene, plate_scene());
        let rolling = "speed_kmh = 80\nduration = 1\naxle = { load = 1000 }";
        let tyre = scene(&scene_text(64, "kind = \"smooth\"", rolling, "", "")).scene.tyre;
        assert_eq!(tyre, plate_tyre());
        assert!((tyre.circumference - CIRCUMFERENCE).abs().max((tyre.contact_width - CONTACT_WIDTH).abs()) < 1e-15);
    }

    #[test]
    fn keys_are_exchanged_left_out_and_added() {
        let text =
            edit(PLATE, &[("tyre.layers.1.material.modulus", "2e6"), ("rolling.axle", "{ indentation = 0.01 }")]);
        let changed = scene(&add(&without(&text, &["rolling.warm_up"]), "numerics", "pole_tolerance = 3e-4")).scene;
        assert!((changed.tyre.layers[1].material.modulus - 2e6).abs() < 1e-9);
        assert!((changed.numerics.pole_tolerance - 3e-4).abs() < 1e-18);
        assert!(matches!(changed.rolling.axle, Axle::Indentation { .. }), "{:?}", changed.rolling.axle);
        assert!(!text.contains("3400"));
    }

    #[test]
    fn a_change_of_what_is_not_there_fails() {
        for change in [
            || edit(PLATE, &[("rolling.speed", "1.0")]),
            || edit(PLATE, &[("tyre.layers.2.thickness", "1.0")]),
            || without(PLATE, &["outputs"]),
            || add(PLATE, "rolling", "duration = 1.0"),
            || add(PLATE, "effects", "texture = \"off\""),
            || replaced(PLATE, &[("speed = 80", "speed = 90")]),
        ] {
            assert!(catch_unwind(change).is_err());
        }
    }
}
