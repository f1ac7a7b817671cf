//! The scenes of a sweep.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use thiserror::Error;
use toml::{Table, Value};

use crate::plan::Plan;
use crate::scene::{LoadedScene, Scene, SceneError};
use crate::storage::input::{self, SCENE_BYTES};

/// What is varied; an empty list leaves the scene's own value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axes {
    /// Speeds \[km/h\].
    pub speeds: Vec<f64>,
    /// Loads \[N\].
    pub loads: Vec<f64>,
    /// Roads: files as in [`variants`].
    pub roads: Vec<PathBuf>,
}

/// One scene of a sweep.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Name of its results folder.
    pub name: String,
    /// The scene, open where the scene of the sweep is open.
    pub loaded: LoadedScene,
    /// Its plan.
    pub plan: Plan,
    /// Speed \[km/h\].
    pub speed: f64,
    /// What it has in common with the variants at other speeds: road and load, as far as they are varied.
    pub group: String,
}

/// Why there is no sweep.
#[derive(Debug, Error)]
pub enum SweepError {
    /// The scene cannot be taken apart or put together again.
    #[error("variant {name}: {source}")]
    Scene {
        /// The variant.
        name: String,
        /// What is wrong with it.
        source: SceneError,
    },
    /// A file that does not make a road.
    #[error("road {}: {message}", path.display())]
    Road {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
}

/// All combinations, speeds innermost. A road is a file:
/// - `.toml`: the keys of a scene's `[road]`, paths relative to the file;
/// - `.crg`: OpenCRG; `.npy`: a height map, for a scene whose road is one (its spacings are taken); anything else: a
///   profile (`.dat`, `.csv`). If the scene's own road is of the same kind its other keys stay.
///
/// # Errors
/// [`SweepError`] with the first variant that is no scene.
pub fn variants(base: &LoadedScene, axes: &Axes) -> Result<Vec<Variant>, SweepError> {
    let failed = |name: &str| {
        let name = name.to_owned();
        move |source| SweepError::Scene { name, source }
    };
    let scene = base.given().map_err(failed("as given"))?;
    let roads: Vec<Option<(String, Table)>> = if axes.roads.is_empty() {
        vec![None]
    } else {
        axes.roads.iter().map(|path| road(&scene, path).map(Some)).collect::<Result<_, _>>()?
    };
    let loads: Vec<Option<f64>> =
        if axes.loads.is_empty() { vec![None] } else { axes.loads.iter().copied().map(Some).collect() };
    let speeds = if axes.speeds.is_empty() { vec![base.scene.rolling.speed_kmh] } else { axes.speeds.clone() };

    let (mut variants, mut names) = (Vec::new(), BTreeSet::new());
    for road in &roads {
        for load in &loads {
            for &speed in &speeds {
                let mut parts: Vec<String> = road.iter().map(|(name, _)| name.clone()).collect();
                parts.extend(load.map(|load| format!("{load} N")));
                let group = parts.join(", ");
                parts.push(format!("{speed} km/h"));
                let label = parts.join(", ");
                let mut name = label.replace(" km/h", "kmh").replace(" N", "N").replace(", ", "-");
                while !names.insert(name.clone()) {
                    name.push('+');
                }
                let mut scene = scene.clone();
                if let Some((_, road)) = road {
                    scene.insert("road".into(), Value::Table(road.clone()));
                }
                set(&mut scene, "rolling", "speed_kmh", Value::Float(speed));
                if let Some(load) = load {
                    let given = scene.get("rolling").and_then(|rolling| rolling.get("axle")?.as_table());
                    // A height gives way to the load; what goes with a load stays.
                    let mut axle = given.filter(|axle| axle.contains_key("load")).cloned().unwrap_or_default();
                    axle.insert("load".to_owned(), Value::Float(*load));
                    set(&mut scene, "rolling", "axle", Value::Table(axle));
                }
                set(&mut scene, "outputs", "spectra", Value::Boolean(true));
                scene.insert("title".into(), Value::String(format!("{}: {label}", base.title())));
                let loaded = Scene::from_str(&scene.to_string(), &name).map_err(failed(&name))?;
                loaded.check_time_domain().map_err(failed(&name))?;
                let plan = Plan::of(&loaded).map_err(failed(&name))?;
                variants.push(Variant { name, loaded, plan, speed, group });
            }
        }
    }
    Ok(variants)
}

fn set(scene: &mut Table, table: &str, key: &str, value: Value) {
    let entry = scene.entry(table).or_insert_with(|| Value::Table(Table::new()));
    if let Value::Table(table) = entry {
        table.insert(key.to_owned(), value);
    }
}

/// A road's name and its table.
fn road(scene: &Table, path: &Path) -> Result<(String, Table), SweepError> {
    let failed = |message: String| SweepError::Road { path: path.to_owned(), message };
    let absolute = std::path::absolute(path).map_err(|error| failed(error.to_string()))?;
    if !absolute.is_file() {
        return Err(failed("there is no such file".into()));
    }
    let name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let own = scene.get("road").and_then(Value::as_table).cloned().unwrap_or_default();
    let text = |path: &Path| match path.to_str() {
        Some(text) => Ok(Value::String(text.to_owned())),
        None => Err(failed("its name is not UTF-8".into())),
    };
    if ending == "toml" {
        let content = input::read_text(&absolute, SCENE_BYTES).map_err(|error| failed(error.to_string()))?;
        let mut table: Table = content.parse().map_err(|error: toml::de::Error| failed(error.to_string()))?;
        if let Some(file) = table.get("file").and_then(Value::as_str) {
            let file = absolute.parent().unwrap_or(Path::new("")).join(file);
            table.insert("file".into(), text(&file)?);
        }
        return Ok((name, table));
    }
    let kind = match ending.as_str() {
        "crg" => "opencrg",
        "npy" => "grid",
        _ => "profile",
    };
    let same = own.get("kind").and_then(Value::as_str) == Some(kind);
    if kind == "grid" && !same {
        return Err(failed(
            "a height map needs its spacings: name a .toml file with kind = \"grid\", file, dx and dy".into(),
        ));
    }
    let mut table = if same { own } else { Table::from_iter([("kind".to_owned(), Value::String(kind.into()))]) };
    table.insert("file".into(), text(&absolute)?);
    Ok((name, table))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::scene::{AtEnd, Axle, PLATE, Road};
    use crate::test_models::edit;

    fn base() -> LoadedScene {
        Scene::from_str(PLATE, "default.toml").unwrap()
    }

    #[test]
    fn all_combinations_are_made_and_named_after_what_is_varied() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            fs::write(folder.path().join(name), text).unwrap();
            folder.path().join(name)
        };
        let roads = vec![
            file("smooth.toml", "kind = \"smooth\""),
            file("crossing.toml", "kind = \"profile\"\nfile = \"a.dat\"\nat_end = \"repeat\""),
            file("stone.crg", ""),
        ];
        let axes = Axes { speeds: vec![50.0, 62.5], loads: vec![3000.0, 4000.0], roads };
        let made = variants(&base(), &axes).unwrap();
        assert_eq!(made.len(), 12);
        assert_eq!(made[0].name, "smooth-3000N-50kmh");
        assert_eq!(made[11].name, "stone-4000N-62.5kmh");
        assert_eq!(made[7].group, "crossing, 4000 N");
        assert!(matches!(made[2].loaded.scene.rolling.axle, Axle::Load { load, .. } if (load - 4000.0).abs() < 1e-9));
        assert!((made[1].loaded.scene.rolling.speed_kmh - 62.5).abs() < 1e-12);
        let Road::Profile(profile) = &made[4].loaded.scene.road else { panic!("{:?}", made[4].loaded.scene.road) };
        assert_eq!((profile.file.as_path(), profile.at_end), (folder.path().join("a.dat").as_path(), AtEnd::Repeat));
        assert!(matches!(made[8].loaded.scene.road, Road::OpenCrg(_)));
        let same = variants(&base(), &Axes { speeds: vec![80.0, 80.0], ..Axes::default() }).unwrap();
        assert_eq!((same[0].name.as_str(), same[1].name.as_str()), ("80kmh", "80kmh+"));
        assert_eq!(same[0].loaded.scene.tyre, base().scene.tyre);
    }

    #[test]
    fn a_preset_chooses_anew_at_every_speed() {
        let draft = ("numerics", "{ preset = \"draft\", fmax = 1000.0 }");
        let at = |speed: &str| Scene::from_str(&edit(PLATE, &[draft, ("rolling.speed_kmh", speed)]), "draft").unwrap();
        let made = variants(&at("80.0"), &Axes { speeds: vec![50.0, 80.0, 110.0], ..Axes::default() }).unwrap();
        for (variant, speed) in made.iter().zip(["50.0", "80.0", "110.0"]) {
            let (found, alone) = (&variant.plan, Plan::of(&at(speed)).unwrap());
            assert_eq!(found.scene.numerics, alone.scene.numerics, "{speed}");
            assert_eq!(found.scene.contact, alone.scene.contact, "{speed}");
            assert_eq!(found.choices, alone.choices, "{speed}");
        }
        assert_ne!(made[0].plan.scene.numerics.elements, made[2].plan.scene.numerics.elements);
    }

    #[test]
    fn a_scene_may_leave_the_road_out() {
        let (head, rest) = PLATE.split_once("[road]").unwrap();
        let (_, tail) = rest.split_once("[rolling]").unwrap();
        let smooth = Scene::from_str(&format!("{head}[rolling]{tail}"), "smooth").unwrap();
        let made = variants(&smooth, &Axes { speeds: vec![50.0], ..Axes::default() }).unwrap();
        assert_eq!(made[0].loaded.scene.road, Road::Smooth);
    }

    #[test]
    fn what_makes_no_scene_is_named() {
        let with = |road: &Path| {
            let axes = Axes { roads: vec![road.to_owned()], ..Axes::default() };
            variants(&base(), &axes).unwrap_err().to_string()
        };
        assert!(with(Path::new("nowhere.dat")).contains("no such file"));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        fs::write(&path, "kind = \"cobbles\"").unwrap();
        assert!(with(&path).contains("cobbles"), "{}", with(&path));
        fs::write(&path, "kind = ").unwrap();
        assert!(with(&path).contains("a.toml"), "{}", with(&path));
        let grid = folder.path().join("a.npy");
        fs::write(&grid, "").unwrap();
        assert!(with(&grid).contains("dx and dy"));
        let fast = variants(&base(), &Axes { speeds: vec![-3.0], ..Axes::default() }).unwrap_err();
        assert!(fast.to_string().contains("speed_kmh"), "{fast}");
    }
}
