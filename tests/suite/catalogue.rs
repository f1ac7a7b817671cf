//! Tyres by size among the scenes: each rolls in the default scene, is as large as its name says, and marks published
//! and inferred values.

use std::fs;
use std::path::{Path, PathBuf};

use tyrewave::scene::Scene;

const PAGE: &str = include_str!("../../docs/tyres.md");

/// Nominal size: section width \[m\], height over width, diameter of the rim \[m\].
#[derive(Clone, Copy, Debug)]
struct Size {
    width: f64,
    aspect: f64,
    rim: f64,
}

/// The size at the end of a file's name: `175_65r14` or `srtt_225_60r16`.
fn size(name: &str) -> Option<Size> {
    let mut parts = name.rsplit('_');
    let (aspect, inches) = parts.next()?.split_once('r')?;
    let number = |text: &str| text.parse::<f64>().ok();
    Some(Size { width: 1e-3 * number(parts.next()?)?, aspect: 1e-2 * number(aspect)?, rim: 0.0254 * number(inches)? })
}

/// Files of tyres whose names state a size.
fn catalogue() -> Vec<(String, PathBuf, Size)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tyres");
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut found: Vec<_> = paths
        .filter_map(|path| {
            let name = path.file_stem()?.to_str()?.to_owned();
            size(&name).map(|size| (name, path, size))
        })
        .collect();
    found.sort_by(|a, b| a.0.cmp(&b.0));
    found
}

#[test]
fn tyres_are_as_large_as_their_names_say() {
    let names: Vec<_> = catalogue().into_iter().map(|(name, ..)| name).collect();
    assert_eq!(names, ["175_65r14", "205_55r16", "225_45r17", "srtt_225_60r16"]);
    for (name, path, size) in catalogue() {
        let loaded = Scene::with_tyre(&path, &[]).unwrap_or_else(|error| panic!("{name}: {}", error.render(false)));
        loaded.check_time_domain().unwrap_or_else(|error| panic!("{name}: {}", error.render(false)));
        let tyre = loaded.scene.tyre;
        let within = |what: &str, found: f64, lowest: f64, highest: f64| {
            assert!((lowest..=highest).contains(&found), "{name}, {what}: {found} m, {lowest} to {highest} m");
        };
        // The Tire and Rim Association allows 3 % of the section's height and 4 % of its width (docs/tyres.md).
        let height = tyre.radius() - size.rim / 2.0;
        let nominal = size.aspect * size.width;
        within("height of the section", height, 0.97 * nominal, 1.03 * nominal);
        let sidewall = tyre.sidewall.as_ref().unwrap();
        let section = tyre.width + 2.0 * sidewall.radius * (1.0 - sidewall.angle.cos());
        within("width of the section", section, 0.96 * size.width, 1.04 * size.width);
        // The arcs end on the rim's flange, which is 17 mm high, and the air ends between its well and the belt.
        let bead = tyre.radius() - tyre.thickness() - 2.0 * sidewall.radius * sidewall.angle.sin();
        within("end of the sidewall", bead, size.rim / 2.0, size.rim / 2.0 + 0.017);
        let cavity = tyre.cavity.as_ref().unwrap();
        within("middle of the air", cavity.radius, size.rim / 2.0, tyre.radius() - tyre.thickness());
        assert!(0.5 * tyre.width < tyre.contact_width && tyre.contact_width < tyre.width, "{name}: {tyre:?}");
    }
}

#[test]
fn each_tyre_says_what_is_published_and_what_is_inferred() {
    for (name, path, _) in catalogue() {
        let text = fs::read_to_string(path).unwrap();
        let top = text.split("\ncircumference").next().unwrap();
        for word in ["Published:", "Inferred:", "[1", "docs/tyres.md", "Nothing was fitted to a sound level"] {
            assert!(top.contains(word), "{name}: {word}");
        }
        for key in ["circumference", "width", "contact_width", "inflation", "sidewall", "cavity"] {
            let before = text.split(&format!("\n{key} =")).next().unwrap();
            assert!(before.len() < text.len(), "{name}: {key}");
            let reported = before.lines().rev().take_while(|line| line.starts_with('#'));
            let reported: String = reported.collect::<Vec<_>>().join(" ").to_lowercase();
            assert!(reported.contains("published") || reported.contains("inferred"), "{name}, {key}: {reported}");
        }
        for layer in text.split("[[layers]]").collect::<Vec<_>>().windows(2) {
            let reported = layer[0].lines().rev().take_while(|line| line.starts_with('#'));
            assert!(
                reported.clone().any(|line| line.contains("nferred")),
                "{name}: {:?}",
                reported.collect::<Vec<_>>()
            );
        }
        assert!(PAGE.contains(&format!("`{name}.toml`")), "{name} is not in docs/tyres.md");
        // Sources are numbered, and stand in the page.
        for source in text.split('[').skip(1).filter_map(|rest| rest.split([']', ',']).next()) {
            if source.len() == 1 && source.chars().all(|digit| digit.is_ascii_digit()) {
                assert!(PAGE.contains(&format!("- [{source}] ")), "{name}: source {source}");
            }
        }
    }
}
