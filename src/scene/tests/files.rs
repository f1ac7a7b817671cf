//! Scenes in files: shared tyres, relative paths, and invalid files.

use std::fs;
use std::path::{Path, PathBuf};

use super::super::{DEFAULT, LoadedScene, Road, Scene, SceneError, Sides, Tyre};
use super::{BASE, edited, hash, listed};
use crate::test_models::replaced;

/// The base scene without its tyre, and the tyre as a file.
fn split() -> (String, String) {
    let begin = BASE.find("[tyre]").unwrap();
    let end = BASE.find("[road]").unwrap();
    let tyre = BASE[begin..end].replace("[tyre]\n", "").replace("tyre.layers", "layers");
    let scene = format!("{}tyre = \"tyres/car.toml\"\n{}", &BASE[..begin], &BASE[end..]);
    (scene, tyre)
}

fn folder_with(scene: &str, tyre: Option<&str>) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    fs::write(&path, scene).unwrap();
    fs::create_dir(folder.path().join("tyres")).unwrap();
    if let Some(tyre) = tyre {
        fs::write(folder.path().join("tyres/car.toml"), tyre).unwrap();
    }
    (folder, path)
}

pub(super) fn scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.extension().is_some_and(|ending| ending == "toml")).collect()
}

#[test]
fn every_shipped_scene_loads() {
    let scenes = scenes();
    assert!(scenes.len() >= 2, "{scenes:?}");
    for path in scenes {
        let loaded = Scene::load(&path).unwrap_or_else(|error| panic!("{}", error.render(false)));
        loaded.check_time_domain().unwrap();
    }
}

#[test]
fn the_shared_tyre_is_the_default_scenes() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let default = Scene::from_str(DEFAULT, "default").unwrap();
    assert_eq!(hash(&default), hash(&Scene::load(shipped.join("default.toml")).unwrap()));
    assert_eq!(default.scene.tyre, Scene::load(shipped.join("smooth.toml")).unwrap().scene.tyre);
}

#[test]
fn every_shipped_tyre_loads() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tyres");
    let (scene, _) = split();
    let tyre = |name: &str| {
        let path = folder.join(name);
        let text = replaced(&scene, &[("\"tyres/car.toml\"", &format!("'{}'", path.display()))]);
        let loaded = Scene::from_str(&text, name).unwrap_or_else(|error| panic!("{}", error.render(false)));
        loaded.scene.tyre
    };
    let mut names: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    let by_size = ["175_65r14.toml", "205_55r16.toml", "225_45r17.toml", "srtt_225_60r16.toml"];
    let others = ["car.toml", "isotropic.toml", "plate.toml", "spring_sides.toml", "stiff_tread.toml", "wide.toml"];
    let with_patterns = ["slick.toml", "summer.toml", "winter.toml"];
    let mut expected = [&by_size[..], &others, &with_patterns].concat();
    expected.sort_unstable();
    assert_eq!(names, expected);
    for name in by_size {
        assert!(tyre(name).sidewall.is_some(), "{name}");
    }
    for name in with_patterns {
        assert_eq!(tyre(name), tyre("car.toml"), "{name}");
    }
    let (car, isotropic) = (tyre("car.toml"), tyre("isotropic.toml"));
    assert!(car.sidewall.is_some() && car.layers.iter().any(|layer| layer.tension[0] > 4e4));
    let (springs, wide, plate) = (tyre("spring_sides.toml"), tyre("wide.toml"), tyre("plate.toml"));
    for curved in [&car, &springs, &isotropic, &wide] {
        assert!(curved.curvature && curved.sides == Sides::Guided && curved.cavity.is_some());
        assert!(curved.inflation.as_ref().is_some_and(|inflation| inflation.pressure > 0.0));
    }
    assert!(!plate.curvature && plate.sides == Sides::Supported && plate.inflation.is_none());
    // The pressure that follows a belt's inner face is what its tension bears.
    let tension = |tyre: &Tyre| tyre.layers.iter().map(|layer| layer.tension[0]).sum::<f64>();
    for tyre in [&springs, &isotropic] {
        let hoop = tyre.inflation.as_ref().unwrap().pressure * (tyre.radius() - tyre.thickness());
        assert!((tension(tyre) / hoop - 1.0).abs() < 0.02, "{hoop} N/m");
    }
    assert!(wide.width > car.width && tension(&wide) < tension(&springs));
    assert!(!car.layers[1].cords.is_empty() && isotropic.layers.iter().all(|layer| layer.cords.is_empty()));
}

#[test]
fn a_tyre_in_its_own_file_makes_the_same_scene() {
    let (scene, tyre) = split();
    let (_folder, path) = folder_with(&scene, Some(&tyre));
    let shared = Scene::load(&path).unwrap();
    let whole = Scene::from_str(BASE, "whole").unwrap();
    assert_eq!(shared.scene, whole.scene);
    assert_eq!(hash(&shared), hash(&whole));
    let diagnostic = shared.complain("tyre.layers[1].thickness", "wrong", "right");
    assert!(Path::new(diagnostic.file()).ends_with("tyres/car.toml"));
    assert_eq!(diagnostic.line(), 12);
}

#[test]
fn a_recorded_scene_reads_no_file_that_it_names() {
    let (scene, tyre) = split();
    let (_folder, path) = folder_with(&scene, Some(&format!("a secret\n{tyre}")));
    let file = path.with_file_name("tyres").join("car.toml");
    let named = replaced(&scene, &[("\"tyres/car.toml\"", &format!("'{}'", file.display()))]);
    for error in [
        LoadedScene::recorded(&named, "recorded").unwrap_err(),
        LoadedScene::restored(&named, &named, path.clone(), PathBuf::new()).unwrap_err(),
    ] {
        let text = error.render(false);
        assert!(text.contains("tyre") && text.contains("is not read") && !text.contains("secret"), "{text}");
    }
    let road = "kind = \"profile\"\nfile = \"../road.dat\"";
    let measured = replaced(BASE, &[("kind = \"smooth\"", road)]);
    let loaded = LoadedScene::recorded(&measured, "recorded").unwrap();
    assert_eq!(loaded.scene.road.file(), Some(Path::new("../road.dat")));
}

#[test]
fn mistakes_in_a_tyre_file_point_into_it() {
    let (scene, tyre) = split();
    let tyre = replaced(&tyre, &[("thickness = 0.013", "thickness = -1"), ("width = 0.2\n", "")]);
    let (_folder, path) = folder_with(&replaced(&scene, &[("duration = 1.5", "duration = 0")]), Some(&tyre));
    let error = Scene::load(&path).unwrap_err();
    let found: Vec<_> = error
        .diagnostics()
        .iter()
        .map(|diagnostic| (diagnostic.file().ends_with("car.toml"), diagnostic.line(), diagnostic.key()))
        .collect();
    let expected = [(false, 7, "rolling.duration"), (true, 1, "tyre.width"), (true, 11, "tyre.layers[1].thickness")];
    assert_eq!(found, expected);
}

#[test]
fn syntax_errors_in_a_tyre_file_point_into_it() {
    let (scene, tyre) = split();
    let (_folder, path) = folder_with(&scene, Some(&replaced(&tyre, &[("width = 0.2\n", "width = 0.2 m\n")])));
    let error = Scene::load(&path).unwrap_err();
    assert!(error.diagnostics()[0].file().ends_with("car.toml"));
    assert_eq!(error.diagnostics()[0].line(), 2);
}

#[test]
fn a_missing_tyre_file_is_a_mistake_at_its_path() {
    let (scene, _) = split();
    let (_folder, path) = folder_with(&replaced(&scene, &[("duration = 1.5", "duration = 0")]), None);
    let error = Scene::load(&path).unwrap_err();
    let found = listed(&error);
    assert_eq!((found.len(), found[0].line, found[0].key.as_str()), (2, 2, "tyre"));
    assert!(found[0].wrong.contains("there is no file") && found[0].wrong.contains("car.toml"), "{}", found[0].wrong);
    assert!(found[0].right.contains("relative to the scene"));
    assert_eq!(found[1].key, "rolling.duration");
}

#[test]
fn road_files_are_relative_to_the_scene_whatever_its_place() {
    let scene = edited("kind = \"smooth\"", "kind = \"grid\"\nfile = \"maps/a.npy\"\ndx = 0.01\ndy = 0.01");
    let (first, path) = folder_with(&scene, None);
    let (_second, other) = folder_with(&scene, None);
    let (loaded, elsewhere) = (Scene::load(&path).unwrap(), Scene::load(&other).unwrap());
    let Road::Grid(road) = &loaded.scene.road else { panic!("{:?}", loaded.scene.road) };
    assert!(road.file.is_absolute());
    assert_eq!(road.file, first.path().join("maps/a.npy"));
    assert_eq!(loaded.folder, first.path());
    assert_ne!(loaded.scene, elsewhere.scene);
    assert_eq!(hash(&loaded), hash(&elsewhere));
    assert_eq!(loaded.settings().unwrap()["road"]["file"], "maps/a.npy");
}

#[test]
fn files_that_are_no_scenes() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing.toml");
    let error = Scene::load(&missing).unwrap_err();
    assert!(matches!(&error, SceneError::NotFound { path } if *path == missing));
    assert!(error.to_string().contains("there is no file") && error.to_string().contains("missing.toml"));

    let error = Scene::load(folder.path()).unwrap_err();
    assert!(matches!(error, SceneError::Folder { .. }));
    assert!(error.to_string().contains("is a folder"));

    let binary = folder.path().join("binary.toml");
    fs::write(&binary, b"title = \"a\"\n# \xff\xfe\n").unwrap();
    let error = Scene::load(&binary).unwrap_err();
    assert!(matches!(error, SceneError::NotText { byte: 14, line: 2, .. }), "{error:?}");
    assert!(error.to_string().contains("not UTF-8 text: byte 14, in line 2"));
    assert!(error.diagnostics().is_empty());
}
