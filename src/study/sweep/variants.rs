//! The scenes of a sweep.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;
use toml::{Table, Value};

use crate::plan::Plan;
use crate::scene::{LoadedScene, SceneError, Setting};
use crate::storage::input::{self, SCENE_BYTES};
use crate::study::sweep::factor::is_seed;

/// Key of the speed, over which levels grow.
pub(crate) const SPEED_KEY: &str = "rolling.speed_kmh";
pub(crate) const LOAD_KEY: &str = "rolling.axle.load";
/// Names of factors that are no single key, or have a separate column.
pub(super) const ROAD: &str = "road";
const LOAD: &str = "load N";
pub(super) const SPEED: &str = "speed km/h";
/// Most characters of a value in the name of a folder.
const MOST_LETTERS: usize = 40;

/// Factors of a sweep; an empty list keeps the scene's value.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Axes {
    /// Speeds \[km/h\].
    pub speeds: Vec<f64>,
    /// Loads \[N\].
    pub loads: Vec<f64>,
    /// Files of roads, see [`variants`].
    pub roads: Vec<PathBuf>,
    /// Settings at each point of a design of other factors.
    pub points: Vec<Vec<Setting>>,
}

/// Choice of one variant for one factor.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub(crate) struct Choice {
    /// The key, or `road`, `load N`, `speed km/h`.
    pub factor: String,
    /// The value, as given.
    pub value: String,
    /// True for a seed: results are averaged over it.
    pub repeats: bool,
}

/// Place of a variant in the tables.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct Label {
    /// Name of the variant and of its results folder.
    pub name: String,
    /// Choices shared with the variants at other speeds: road, load and settings, as far as they are varied.
    pub group: String,
    /// Speed \[km/h\].
    pub speed: f64,
    /// Choices for all factors.
    pub choices: Vec<Choice>,
}

/// One scene of a sweep.
#[derive(Clone, Debug)]
pub(crate) struct Variant {
    /// Name, group and choices in the tables.
    pub label: Label,
    /// The scene, open where the sweep's scene is open.
    pub loaded: LoadedScene,
    /// Plan of the scene.
    pub plan: Plan,
}

impl Label {
    /// True if it belongs to a design: more than road, load and speed is varied.
    pub(crate) fn is_of_a_design(&self) -> bool {
        self.choices.iter().any(|choice| ![ROAD, LOAD, SPEED].contains(&choice.factor.as_str()))
    }

    /// Values of the varied factors except seeds, in words.
    pub(crate) fn settings(&self) -> String {
        self.words(|choice| !choice.repeats)
    }

    /// Values of the varied factors except seeds and speed, in words: they name a line over the speed.
    pub(crate) fn settings_beside_speed(&self) -> String {
        self.words(|choice| !choice.repeats && choice.factor != SPEED)
    }

    fn words(&self, counts: impl Fn(&Choice) -> bool) -> String {
        let words = self.choices.iter().filter(|choice| counts(choice));
        words.map(|choice| said(&choice.factor, &choice.value)).collect::<Vec<_>>().join(", ")
    }
}

/// A value of a factor in words.
pub(crate) fn said(factor: &str, value: &str) -> String {
    match factor.rsplit_once(' ') {
        Some((_, unit)) => format!("{value} {unit}"),
        None if factor == ROAD => value.to_owned(),
        None => format!("{}={value}", factor.rsplit('.').next().unwrap_or(factor)),
    }
}

/// Reasons why there is no sweep.
#[derive(Debug, Error)]
pub(crate) enum SweepError {
    /// The scene cannot be split up or put together again.
    #[error("variant {name}: {source}")]
    Scene {
        /// Name of the variant.
        name: String,
        /// Fault of the scene.
        source: SceneError,
    },
    /// A file that is no road.
    #[error("road {}: {message}", path.display())]
    Road {
        /// The file.
        path: PathBuf,
        /// Fault.
        message: String,
    },
}

/// All combinations: roads outermost, then loads, then the points of a design, speeds innermost. A road is a file:
/// - `.toml`: the keys of a scene's `[road]`, paths relative to the file;
/// - `.crg`: OpenCRG; `.npy`: a height map, for a scene whose road is one (its spacings are taken); anything else: a
///   profile (`.dat`, `.csv`). If the scene's road is of the same kind its other keys stay.
///
/// # Errors
/// [`SweepError`] with the first variant that is not a valid scene.
pub(crate) fn variants(base: &LoadedScene, axes: &Axes) -> Result<Vec<Variant>, SweepError> {
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
    let speeds: Vec<Option<f64>> =
        if axes.speeds.is_empty() { vec![None] } else { axes.speeds.iter().copied().map(Some).collect() };
    let points: &[Vec<Setting>] = if axes.points.is_empty() { &[Vec::new()] } else { &axes.points };

    let (mut variants, mut names) = (Vec::new(), BTreeSet::new());
    for road in &roads {
        for load in &loads {
            for point in points {
                for &speed in &speeds {
                    let made = Combination { road: road.as_ref(), load: *load, point, speed };
                    variants.push(made.variant(base, scene.clone(), &mut names)?);
                }
            }
        }
    }
    Ok(variants)
}

struct Combination<'a> {
    road: Option<&'a (String, Table)>,
    load: Option<f64>,
    point: &'a [Setting],
    speed: Option<f64>,
}

impl Combination<'_> {
    /// Choices of all factors, and their texts for names.
    fn choices(&self, speed: f64) -> (Vec<Choice>, Vec<String>) {
        let (mut choices, mut labels) = (Vec::new(), Vec::new());
        let mut add = |factor: &str, value: String, label: String| {
            choices.push(Choice { factor: factor.to_owned(), value, repeats: is_seed(factor) });
            labels.push(label);
        };
        if let Some((name, _)) = self.road {
            add(ROAD, name.clone(), name.clone());
        }
        if let Some(load) = self.load {
            add(LOAD, load.to_string(), format!("{load} N"));
        }
        let varied_speed = |setting: &&Setting| setting.key() != SPEED_KEY;
        for setting in self.point.iter().filter(varied_speed) {
            let (key, value) = (setting.key(), setting.value());
            let short = key.rsplit('.').next().unwrap_or(key);
            let of_same_name = self.point.iter().filter(|other| other.key().rsplit('.').next() == Some(short)).count();
            add(key, value.to_owned(), format!("{}={value}", if of_same_name > 1 { key } else { short }));
        }
        if self.speed.is_some() || self.point.iter().any(|setting| setting.key() == SPEED_KEY) {
            add(SPEED, speed.to_string(), format!("{speed} km/h"));
        }
        (choices, labels)
    }

    /// The variant, made from the keys that the sweep's scene gives.
    fn variant(
        &self,
        base: &LoadedScene,
        mut scene: Table,
        names: &mut BTreeSet<String>,
    ) -> Result<Variant, SweepError> {
        let settled = self.point.iter().find(|setting| setting.key() == SPEED_KEY);
        let settled = settled.and_then(|setting| setting.value().parse().ok());
        let speed = self.speed.or(settled).unwrap_or(base.scene.rolling.speed_kmh);
        let (choices, mut labels) = self.choices(speed);
        let grouped = labels.len() - usize::from(choices.last().is_some_and(|last| last.factor == SPEED));
        let group = labels[..grouped].join(", ");
        if grouped == labels.len() {
            labels.push(format!("{speed} km/h"));
        }
        let name = unique_name(&labels, names);
        if let Some((_, road)) = self.road {
            scene.insert("road".into(), Value::Table(road.clone()));
        }
        set(&mut scene, "rolling", "speed_kmh", Value::Float(speed));
        if let Some(load) = self.load {
            let given = scene.get("rolling").and_then(|rolling| rolling.get("axle")?.as_table());
            // A height is replaced by the load; the other keys of a load stay.
            let mut axle = given.filter(|axle| axle.contains_key("load")).cloned().unwrap_or_default();
            axle.insert("load".to_owned(), Value::Float(load));
            set(&mut scene, "rolling", "axle", Value::Table(axle));
        }
        set(&mut scene, "outputs", "spectra", Value::Boolean(true));
        scene.insert("title".into(), Value::String(format!("{}: {}", base.title(), labels.join(", "))));
        let failed = |source| SweepError::Scene { name: name.clone(), source };
        let loaded = base.varied(scene.to_string(), &name, self.point).map_err(failed)?;
        loaded.check_time_domain().map_err(failed)?;
        let plan = Plan::of(&loaded).map_err(failed)?;
        Ok(Variant { label: Label { name, group, speed, choices }, loaded, plan })
    }
}

/// Unique name of a folder from the labels of what is varied; characters that are unsuitable in file names are
/// replaced.
fn unique_name(labels: &[String], names: &mut BTreeSet<String>) -> String {
    let sign = |sign: char| if sign.is_alphanumeric() || "+-_.=".contains(sign) { sign } else { '_' };
    let part = |label: &String| -> String {
        let label = label.replace(" km/h", "kmh").replace(" N", "N");
        label.chars().map(|letter| if letter == ' ' { letter } else { sign(letter) }).take(MOST_LETTERS).collect()
    };
    let mut name = labels.iter().map(part).collect::<Vec<_>>().join("-");
    while !names.insert(name.clone()) {
        name.push('+');
    }
    name
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
    let of_scene = scene.get("road").and_then(Value::as_table).cloned().unwrap_or_default();
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
        "npy" | "xyz" | "asc" => "grid",
        _ => "profile",
    };
    let same = of_scene.get("kind").and_then(Value::as_str) == Some(kind);
    if ending == "npy" && !same {
        return Err(failed(
            "a height map needs its spacings: name a scene whose [road] has kind = \"grid\", file, dx and dy; for \
             sweep --road, a .toml file with these keys"
                .into(),
        ));
    }
    let mut table = if same { of_scene } else { Table::from_iter([("kind".to_owned(), Value::String(kind.into()))]) };
    table.insert("file".into(), text(&absolute)?);
    Ok((name, table))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::scene::{AtEnd, Axle, PLATE, Road, Scene};
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
        let axes = Axes { speeds: vec![50.0, 62.5], loads: vec![3000.0, 4000.0], roads, ..Axes::default() };
        let made = variants(&base(), &axes).unwrap();
        assert_eq!(made.len(), 12);
        assert_eq!(made[0].label.name, "smooth-3000N-50kmh");
        assert_eq!(made[11].label.name, "stone-4000N-62.5kmh");
        assert_eq!(made[7].label.group, "crossing, 4000 N");
        assert!(matches!(made[2].loaded.scene.rolling.axle, Axle::Load { load, .. } if (load - 4000.0).abs() < 1e-9));
        assert!((made[1].loaded.scene.rolling.speed_kmh - 62.5).abs() < 1e-12);
        let Road::Profile(profile) = &made[4].loaded.scene.road else { panic!("{:?}", made[4].loaded.scene.road) };
        assert_eq!((profile.file.as_path(), profile.at_end), (folder.path().join("a.dat").as_path(), AtEnd::Repeat));
        assert!(matches!(made[8].loaded.scene.road, Road::OpenCrg(_)));
        let same = variants(&base(), &Axes { speeds: vec![80.0, 80.0], ..Axes::default() }).unwrap();
        assert_eq!((same[0].label.name.as_str(), same[1].label.name.as_str()), ("80kmh", "80kmh+"));
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
    fn settings_of_variants_are_named_and_mistakes_reported() {
        let point = |texts: &[&str]| texts.iter().map(|text| Setting::parse(text).unwrap()).collect::<Vec<_>>();
        let axes = Axes {
            speeds: vec![50.0, 80.0],
            points: vec![point(&["road.seed=3", "contact.tread=bedding"])],
            ..Axes::default()
        };
        let made = variants(&base(), &axes).unwrap();
        assert_eq!((made.len(), made[1].label.name.as_str()), (2, "seed=3-tread=bedding-80kmh"));
        assert_eq!(made[1].label.group, "seed=3, tread=bedding");
        let reported: Vec<(&str, &str, bool)> = made[1]
            .label
            .choices
            .iter()
            .map(|choice| (choice.factor.as_str(), choice.value.as_str(), choice.repeats))
            .collect();
        assert_eq!(
            reported,
            [("road.seed", "3", true), ("contact.tread", "bedding", false), ("speed km/h", "80", false)]
        );
        assert!(matches!(&made[1].loaded.scene.road, Road::Made(road) if road.seed == 3));
        // What a task stores is the whole scene.
        let again = made[1].loaded.given().unwrap().to_string();
        assert_eq!(Scene::from_str(&again, "again").unwrap().scene, made[1].loaded.scene);
        let driven = Axes { points: vec![point(&["rolling.speed_kmh=62.5"])], ..Axes::default() };
        let made = variants(&base(), &driven).unwrap();
        assert!(
            (made[0].label.speed - 62.5).abs() < 1e-12
                && made[0].label.name == "62.5kmh"
                && made[0].label.group.is_empty()
        );
        let long = "x".repeat(100);
        let named = Axes { points: vec![point(&[&format!("title=a/{long}")])], ..Axes::default() };
        assert!(variants(&base(), &named).unwrap()[0].label.name.len() < 60);
        for (text, word) in [("rolling.sped_kmh=1", "speed_kmh"), ("road.seed=-1", "--set road.seed")] {
            let wrong = Axes { points: vec![point(&[text])], ..Axes::default() };
            let SweepError::Scene { source, .. } = variants(&base(), &wrong).unwrap_err() else { panic!("{text}") };
            assert!(source.render(false).contains(word), "{text}: {}", source.render(false));
        }
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
