//! The Pareto front of accuracy against time as a table, from which `preset` and `accuracy` choose.
//!
//! A stated error is the largest difference of a third octave of the contact force, [`STATED_FROM`] to fmax, from the
//! limit for small time steps, elements and cells, with the axle at the same height, for fmax up to each frequency of
//! `stated_to`. The rows of slices were set from made dense asphalt at 80 km/h up to 1 kHz, and from a chip seal up
//! to 2 kHz, those of cells from nine pairs of road and speed (docs/accuracy.md; an ignored test,
//! tests/suite/presets.rs). Cells have to be finer: a stone of one or two cells is too stiff.
//! `tyrewave study SCENE --check-presets` measures them on any scene.

use crate::scene::{Preset, Road, Scene, TimeRule, Zone};

/// Lowest third octave that a stated error includes \[Hz\].
pub(crate) const STATED_FROM: f64 = 100.0;
/// Cells in the shortest wave that is resolved: on dense asphalt at 30 km/h, levels up to 1 kHz are 5 dB wrong with
/// four.
const CELLS_IN_A_WAVE: f64 = 11.0;

/// Size of the cells of a scene's road for levels up to `highest` \[Hz\], in m: that of the law, or [`Road::cell`],
/// with at least eleven cells in the texture wave that excites that frequency. Over cells the road's shortest waves do
/// not count, as in the runs that set the rows' errors.
pub(crate) fn cell_for(scene: &Scene, highest: f64) -> f64 {
    let of_road = if scene.contact.zone == Zone::Cells { Road::CELL } else { scene.road.cell() };
    let resolved = || of_road.min(scene.rolling.speed() / highest / CELLS_IN_A_WAVE);
    scene.contact.cell_of_law(&scene.road).unwrap_or_else(resolved)
}

/// Settings independent of tyre, speed and frequency, with their stated errors and cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrontRow {
    /// Name of the row.
    pub preset: Preset,
    /// Least number of elements per texture wavelength V/fmax.
    pub per_wavelength: f64,
    /// Longest element \[m\].
    pub longest_element: f64,
    /// Time rule, if none is given.
    pub time_rule: TimeRule,
    /// Least number of time steps in a period of fmax; with another rule as many as give the same error.
    pub steps_per_period: f64,
    /// Tolerance of the poles.
    pub pole_tolerance: f64,
    /// Tolerance of the contact conditions.
    pub contact_tolerance: f64,
    /// Largest cell of a made road of the default's wavelengths, if V/fmax is 22 mm at least \[m\]; over cells their
    /// largest width.
    pub cell: f64,
    /// Tolerance of the slices' curves \[m\].
    pub slice_tolerance: f64,
    /// Largest fmax for which each stated error holds \[Hz\].
    pub stated_to: [f64; 2],
    /// Stated errors \[dB\], one for each of these.
    pub errors: [f64; 2],
    /// Parts of the error up to 1 kHz \[dB\]: by how much the worst third octave, another for each part, changes with
    /// shorter elements, narrower cells, shorter steps. Those of the tolerances are below 0.02 dB.
    pub parts: [f64; 3],
    /// Work relative to the standard preset, on the default scene.
    pub cost: f64,
}

impl FrontRow {
    /// The rows of slices, cheapest first. These poles change levels by 0.002 dB at most (profiles/README.md).
    pub(crate) const OF_SLICES: [Self; 3] = [
        Self {
            preset: Preset::Draft,
            per_wavelength: 2.9,
            longest_element: 8e-3,
            time_rule: TimeRule::Sdirk2,
            steps_per_period: 2.9,
            pole_tolerance: 1e-3,
            contact_tolerance: 1e-6,
            cell: 2.6e-3,
            slice_tolerance: 1e-6,
            stated_to: [1000.0, 2000.0],
            errors: [3.0, 5.0],
            parts: [1.1, 0.8, 1.9],
            cost: 0.5,
        },
        Self {
            preset: Preset::Standard,
            per_wavelength: 5.8,
            longest_element: 4e-3,
            time_rule: TimeRule::Sdirk2,
            steps_per_period: 5.8,
            pole_tolerance: 1e-3,
            contact_tolerance: 1e-6,
            cell: 2e-3,
            slice_tolerance: 3e-7,
            stated_to: [1000.0, 2000.0],
            errors: [1.0, 2.5],
            parts: [0.3, 0.6, 0.5],
            cost: 1.0,
        },
        Self {
            preset: Preset::Reference,
            per_wavelength: 11.6,
            longest_element: 2e-3,
            time_rule: TimeRule::Sdirk2,
            steps_per_period: 11.6,
            pole_tolerance: 1e-3,
            contact_tolerance: 1e-6,
            cell: 1e-3,
            slice_tolerance: 1e-7,
            stated_to: [1000.0, 2000.0],
            errors: [0.3, 0.5],
            parts: [0.2, 0.3, 0.1],
            cost: 2.5,
        },
    ];

    /// The rows of cells, cheapest first. With steps over several elements, cells of 0.95 by 1.9 mm cost as much as
    /// cells of 1.9 by 1.9 mm and have half of their errors; these tolerances change levels by less than 0.01 dB
    /// (profiles/README.md).
    pub(crate) const OF_CELLS: [Self; 3] = [
        Self {
            errors: [3.0, 5.0],
            parts: [1.4, 0.4, 1.4],
            cost: 0.25,
            ..Self::OF_SLICES[0].over_cells([11.6, 2e-3], 2e-3)
        },
        Self {
            errors: [2.0, 3.0],
            parts: [0.2, 0.4, 0.2],
            cost: 1.0,
            ..Self::OF_SLICES[1].over_cells([23.2, 1e-3], 2e-3)
        },
        Self {
            errors: [1.0, 2.0],
            parts: [0.3, 0.3, 0.2],
            cost: 3.4,
            ..Self::OF_SLICES[2].over_cells([23.2, 1e-3], 1e-3)
        },
    ];

    /// The same row over cells: elements in a wave and their largest length \[m\], width of a cell \[m\].
    const fn over_cells(self, elements: [f64; 2], cell: f64) -> Self {
        let [per_wavelength, longest_element] = elements;
        let stated_to = [1250.0, 2000.0];
        Self { per_wavelength, longest_element, cell, contact_tolerance: 1e-3, stated_to, ..self }
    }

    /// Stated error for an fmax \[dB\]; `None` beyond the last of `stated_to`.
    pub(crate) fn error(&self, fmax: f64) -> Option<f64> {
        self.stated_to.iter().position(|&to| fmax <= to).map(|range| self.errors[range])
    }

    /// Stated error for a scene \[dB\]. Also `None` beyond the first of `stated_to` if the cells belong to the law:
    /// elements then get shorter than the cells, and the law has no limit for short cells. `None` with friction, which
    /// chooses another rule and history than the row.
    pub(crate) fn error_for(&self, scene: &Scene, fmax: f64) -> Option<f64> {
        let has_limit = scene.contact.cell_of_law(&scene.road).is_none();
        let error = self.error(fmax).filter(|_| has_limit || fmax <= self.stated_to[0]);
        error.filter(|_| scene.friction.is_none())
    }

    pub(crate) const fn all(zone: Zone) -> &'static [Self; 3] {
        match zone {
            Zone::Slices => &Self::OF_SLICES,
            Zone::Cells => &Self::OF_CELLS,
        }
    }

    pub(crate) const fn of(preset: Preset, zone: Zone) -> &'static Self {
        &Self::all(zone)[preset as usize]
    }

    /// Row that a scene's `preset` or `accuracy` chooses.
    pub(crate) fn asked_for(scene: &Scene) -> Option<&'static Self> {
        let zone = scene.contact.zone;
        let preset = scene.numerics.preset.map(|preset| Self::of(preset, zone));
        preset.or_else(|| Self::within(scene.numerics.accuracy?, scene))
    }

    /// Cheapest row whose stated error for a scene with an fmax does not exceed an accuracy \[dB\]; `None` if no row is
    /// as accurate.
    pub(crate) fn within(accuracy: f64, scene: &Scene) -> Option<&'static Self> {
        let fmax = scene.numerics.fmax?;
        let is_accurate = |row: &&Self| row.error_for(scene, fmax).is_some_and(|error| error <= accuracy);
        Self::all(scene.contact.zone).iter().find(is_accurate)
    }

    /// Smallest stated error for a scene with an fmax \[dB\]; `None` if none is stated.
    pub(crate) fn finest_error(scene: &Scene, fmax: f64) -> Option<f64> {
        Self::all(scene.contact.zone).iter().filter_map(|row| row.error_for(scene, fmax)).reduce(f64::min)
    }

    /// Largest cell of a scene's road for levels up to `highest` \[Hz\], in m; over cells their largest width.
    pub(crate) fn cell_for(&self, scene: &Scene, highest: f64) -> f64 {
        let of_law = scene.contact.cell_of_law(&scene.road);
        of_law.unwrap_or_else(|| self.cell * (cell_for(scene, highest) / Road::CELL))
    }

    /// Number of cells across for levels up to `highest` \[Hz\], at least two.
    pub(crate) fn cells_across(&self, scene: &Scene, highest: f64) -> usize {
        Road::cells(scene.tyre.contact_width, self.cell_for(scene, highest)).max(2)
    }

    /// Relative error of the rule's rate at fmax, phase and damping together, which other rules have to keep.
    pub(crate) fn rule_error(&self) -> f64 {
        let angle = std::f64::consts::TAU / self.steps_per_period;
        (self.time_rule.relative_rate(angle) - 1.0).norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::DEFAULT;
    use crate::test_models::{scene as loaded, scene_text};

    #[test]
    fn the_tables_are_fronts_and_presets_are_their_rows() {
        for zone in [Zone::Slices, Zone::Cells] {
            let all = FrontRow::all(zone);
            for (preset, row) in Preset::ALL.into_iter().zip(all) {
                assert_eq!((FrontRow::of(preset, zone), row.preset), (row, preset));
            }
            let pairs = all.windows(2);
            assert!(pairs.clone().all(|pair| pair[0].cost < pair[1].cost));
            assert!(pairs.clone().all(|pair| (0..2).all(|range| pair[0].errors[range] > pair[1].errors[range])));
            assert!(all.iter().all(|row| row.errors[0] <= row.errors[1]));
            assert!(all.iter().all(|row| row.parts.iter().all(|part| (0.0..=row.errors[0]).contains(part))));
            assert!((FrontRow::of(Preset::Standard, zone).cost - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn an_accuracy_gets_the_cheapest_row_that_keeps_it() {
        let mut scene = Scene::from_str(DEFAULT, "default").unwrap().scene;
        for zone in [Zone::Slices, Zone::Cells] {
            scene.contact.zone = zone;
            let all = FrontRow::all(zone);
            let stated_to = all[0].stated_to;
            for fmax in stated_to {
                scene.numerics.fmax = Some(fmax);
                for row in all {
                    let error = row.error(fmax).unwrap();
                    assert_eq!(FrontRow::within(error, &scene), Some(row));
                    assert_ne!(FrontRow::within(0.99 * error, &scene), Some(row));
                }
                let finest = FrontRow::finest_error(&scene, fmax).unwrap();
                assert_eq!(FrontRow::within(0.99 * finest, &scene), None);
                assert_eq!(FrontRow::within(100.0, &scene), Some(&all[0]));
            }
            let beyond = 1.01 * stated_to[1];
            scene.numerics.fmax = Some(beyond);
            assert_eq!((FrontRow::within(100.0, &scene), FrontRow::finest_error(&scene, beyond)), (None, None));
        }
    }

    #[test]
    fn no_error_is_stated_where_elements_are_shorter_than_cells() {
        let mut scene = Scene::from_str(DEFAULT, "default").unwrap().scene;
        let stated = |scene: &Scene, fmax: f64| FrontRow::finest_error(scene, fmax).map(f64::to_bits);
        let stated_to = FrontRow::OF_SLICES[0].stated_to;
        assert_eq!(stated_to.map(|fmax| stated(&scene, fmax)), [Some(0.3_f64.to_bits()), Some(0.5_f64.to_bits())]);
        let road = "kind = \"profile\"\nfile = \"road.dat\"\nlateral = \"isotropic\"";
        let rolling = "speed_kmh = 80.0\nduration = 1.0\naxle = { load = 3400.0 }";
        scene.road = loaded(&scene_text(64, road, rolling, "", "")).scene.road;
        assert_eq!(stated_to.map(|fmax| stated(&scene, fmax)), [Some(0.3_f64.to_bits()), None]);
        scene.contact.zone = Zone::Cells;
        assert!(stated(&scene, stated_to[1]).is_some());
    }
}
