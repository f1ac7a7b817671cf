//! Error that a scene's preset states, if the scene keeps the preset's settings.

use super::decisions::cells_across;
use super::front::{FrontRow, STATED_FROM};
use super::resolution::{Need, Resolution};
use crate::scene::{History, MeshLevels, Numerics, Scene, Switch, Zone};
use thiserror::Error;

/// Reasons why the numerical error of a scene's levels is not known.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum Unstated {
    /// Neither `preset` nor `accuracy` is given.
    #[error("numerical error not known: take a preset, or `tyrewave study`")]
    NoPreset,
    /// A key given by the scene is coarser than that of its preset.
    #[error("numerical error not known: {0} is coarser than that of the preset; `tyrewave study`")]
    Coarser(&'static str),
    /// A key given by the scene makes sums of another kind than those of its preset, finer or coarser: nothing was
    /// measured with it.
    #[error("numerical error not known: no preset was measured with {0}; `tyrewave study`")]
    OfAnotherKind(&'static str),
    /// No error is stated for such a scene: because of its fmax, its road, or friction.
    #[error("numerical error not known: no preset states one for such a scene; `tyrewave study`")]
    OfNoRow,
}

impl FrontRow {
    /// Error of force levels that a scene's `preset` or `accuracy` states: the lowest frequency at which it holds
    /// \[Hz\], and the error \[dB\].
    ///
    /// # Errors
    /// Why none is stated.
    pub(crate) fn stated_error(scene: &Scene) -> Result<(f64, f64), Unstated> {
        if let Some(levels) = &scene.outputs.levels {
            return Self::stated_error_of_finer_mesh(scene, levels);
        }
        let (row, fmax) = Self::asked_for(scene).zip(scene.numerics.fmax).ok_or(Unstated::NoPreset)?;
        let error = row.error_for(scene, fmax).ok_or(Unstated::OfNoRow)?;
        row.departure(scene, fmax).map_or(Ok((STATED_FROM, error)), Err)
    }

    /// As [`Self::stated_error`], for levels of a finer mesh: those of the most accurate row whose settings it keeps.
    fn stated_error_of_finer_mesh(scene: &Scene, levels: &MeshLevels) -> Result<(f64, f64), Unstated> {
        let mut finer = scene.clone();
        finer.numerics.elements = levels.fine_elements(scene.numerics.elements);
        finer.outputs.levels = None;
        let of = |row: &Self| {
            let numerics = Numerics { preset: Some(row.preset), accuracy: None, ..finer.numerics.clone() };
            Self::stated_error(&Scene { numerics, ..finer.clone() })
        };
        let stated = Self::all(scene.contact.zone).iter().rev().find_map(|row| of(row).ok());
        stated.map_or_else(|| Self::stated_error(&finer), Ok)
    }

    /// A key of a scene by which the row's error does not hold; `None` if there is none.
    fn departure(&'static self, scene: &Scene, fmax: f64) -> Option<Unstated> {
        let Scene { tyre, contact, numerics, rolling, road, effects, .. } = scene;
        let (length, speed, rule) = (tyre.circumference, rolling.speed(), numerics.time_rule);
        let given = Resolution { elements: numerics.elements, advance: numerics.advance() };
        let element = length / numerics.elements as f64;
        let longest = self.longest_element.min(speed / (fmax * self.per_wavelength));
        let over_cells = contact.zone == Zone::Cells;
        let over_slices = !over_cells && effects.texture != Switch::Off && road.varies_across();
        let widest = self.cell_for(scene, fmax) * (1.0 + 1e-9);
        let is_wide = |length: f64, cells: usize| length / cells as f64 > widest;
        let across = if over_cells { Some(cells_across(scene)) } else { contact.cells_across.filter(|_| over_slices) };
        let along = contact.cells_along.filter(|_| over_slices);
        let rule_limit = given.rule_limit(Need { highest: fmax, row: Some(self) }, length, speed, rule);
        let is_coarser = [
            ("numerics.elements", element > longest * (1.0 + 1e-9)),
            (given.key_of_advance(), rule_limit < (1.0 - 1e-9) * fmax),
            ("contact.cells_across", across.is_some_and(|cells| is_wide(tyre.contact_width, cells))),
            ("contact.cells_along", along.is_some_and(|cells| is_wide(element, cells))),
            ("contact.slice_tolerance", over_slices && contact.slice_tolerance > self.slice_tolerance),
            ("numerics.pole_tolerance", numerics.pole_tolerance > self.pole_tolerance),
            ("numerics.contact_tolerance", numerics.contact_tolerance > self.contact_tolerance),
            ("numerics.influence_tolerance", numerics.influence_tolerance > Numerics::default().influence_tolerance),
        ];
        let is_of_another_kind = [
            ("numerics.history", numerics.history != History::Modal),
            ("numerics.lateral_terms", numerics.lateral_terms.is_some()),
            ("numerics.wavenumber_aliases", numerics.wavenumber_aliases.is_some()),
        ];
        let first = |keys: &[(&'static str, bool)]| keys.iter().find(|(_, departs)| *departs).map(|(key, _)| *key);
        let coarser = first(&is_coarser).map(Unstated::Coarser);
        coarser.or_else(|| first(&is_of_another_kind).map(Unstated::OfAnotherKind))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::settle::decide;
    use crate::scene::{DEFAULT, Preset, Setting};
    use crate::test_models::{scene_text, with_all_terms};

    fn error_of_cells(preset: Preset) -> Result<u64, Unstated> {
        Ok(FrontRow::of(preset, Zone::Cells).errors[0].to_bits())
    }

    #[test]
    fn no_error_is_stated_for_elements_longer_than_the_rows() {
        let mut scene = Scene::from_str(DEFAULT, "default").unwrap().scene;
        assert_eq!(FrontRow::stated_error(&scene), Err(Unstated::NoPreset));
        (scene.numerics.preset, scene.numerics.fmax) = (Some(Preset::Standard), Some(1000.0));
        let stated = |scene: &Scene| FrontRow::stated_error(scene).map(|(_, error)| error.to_bits());
        assert_eq!(stated(&scene), Ok(1.0_f64.to_bits()));
        scene.contact.zone = Zone::Cells;
        assert_eq!(stated(&scene), Err(Unstated::Coarser("numerics.elements")));
        scene.numerics.elements *= 4;
        assert_eq!(stated(&scene), error_of_cells(Preset::Standard));
        scene.numerics.fmax = Some(2500.0);
        assert_eq!(stated(&scene), Err(Unstated::OfNoRow));
    }

    #[test]
    fn levels_of_a_finer_mesh_have_the_error_of_its_row() {
        let mut scene = Scene::from_str(DEFAULT, "default").unwrap().scene;
        scene.contact.zone = Zone::Cells;
        (scene.numerics.preset, scene.numerics.fmax) = (Some(Preset::Draft), Some(1000.0));
        scene.contact.cells_across = Some(56);
        let stated = |scene: &Scene| FrontRow::stated_error(scene).map(|(_, error)| error.to_bits());
        assert_eq!(stated(&scene), Err(Unstated::Coarser("numerics.elements")));
        scene.numerics.elements *= 2;
        assert_eq!(stated(&scene), error_of_cells(Preset::Draft));
        scene.outputs.levels = Some(MeshLevels { standard_error: 0.5, elements: None, segments: 1 });
        assert_eq!(stated(&scene), error_of_cells(Preset::Standard));
        scene.numerics.elements /= 2;
        assert_eq!(stated(&scene), error_of_cells(Preset::Draft));
        scene.numerics.elements /= 2;
        assert_eq!(stated(&scene), Err(Unstated::Coarser("numerics.elements")));
    }

    #[test]
    fn no_error_is_stated_for_settings_coarser_than_the_preset() {
        let preset = |zone: &str, keys: &str| {
            let texture = "kind = \"made\"\nseed = 1\ntexture = \"sma-8\"";
            let rolling = "speed_kmh = 80.0\nduration = 1.0\naxle = { load = 3400.0 }";
            let numerics = "preset = \"standard\"\nfmax = 1000.0";
            let text = with_all_terms(&scene_text(2048, texture, rolling, numerics, ""));
            let wishes = [format!("contact.zone=\"{zone}\""), keys.to_owned()].join("\n");
            let settings: Vec<Setting> =
                wishes.lines().filter(|line| !line.is_empty()).flat_map(Setting::parse).collect();
            let loaded = Scene::from_str_with(&text, "scene", &settings).unwrap();
            let (scene, choices) = decide(&loaded).unwrap();
            let reported = choices.into_iter().find(|choice| choice.key == "numerics.preset").unwrap().reason;
            (FrontRow::stated_error(&scene).map(|(_, error)| error.to_bits()), reported)
        };
        assert_eq!(preset("slices", "").0, Ok(1.0_f64.to_bits()));
        assert_eq!(preset("cells", "").0, error_of_cells(Preset::Standard));
        assert_eq!(preset("cells", "numerics.elements_per_step=4").0, error_of_cells(Preset::Standard));
        for (zone, key, value) in [
            ("slices", "contact.cells_across", "20"),
            ("slices", "contact.slice_tolerance", "1e-6"),
            ("slices", "numerics.pole_tolerance", "2e-3"),
            ("slices", "numerics.contact_tolerance", "1e-5"),
            ("slices", "numerics.influence_tolerance", "1e-6"),
            ("cells", "contact.cells_across", "20"),
            ("cells", "numerics.pole_tolerance", "2e-3"),
        ] {
            let (found, reported) = preset(zone, &format!("{key}={value}"));
            assert_eq!(found, Err(Unstated::Coarser(key)), "{key} = {value}");
            assert!(reported.contains("not known") && reported.contains(key), "{reported}");
        }
        for (key, value) in [("numerics.lateral_terms", "400"), ("numerics.wavenumber_aliases", "20")] {
            let (found, reported) = preset("slices", &format!("{key}={value}"));
            assert_eq!(found, Err(Unstated::OfAnotherKind(key)), "{key} = {value}");
            assert!(
                reported.contains("not known") && reported.contains(key) && !reported.contains("coarser"),
                "{reported}"
            );
        }
    }
}
