//! Stated errors of contact over slices: differences of third octaves from contact over cells of 1 mm.
//!
//! Measured with the default tyre at 3400 N, with 1024 elements of 1.9 mm, on made roads of two classes, two roads and
//! two seeds each: against cells as long as the elements, and these against cells of half the size on one seed of each
//! road. docs/contact.md has the errors on roads and seeds that were not used to set the table.

use super::Plan;
use crate::response::{SliceErrors, ThirdOctaveBand};
use crate::road::RoadSurface;
use crate::scene::{RadiationQuality, Scene, SliceCoupling, Slices, Switch, Tread, Zone};

/// Third octave of 100 Hz, the lowest of the table.
const FIRST: ThirdOctaveBand = ThirdOctaveBand(-10);
/// Number of bands of the table, up to 2.5 kHz.
const BANDS: usize = 15;
/// Speeds of the table \[km/h\].
const SPEEDS: [f64; 3] = [50.0, 80.0, 110.0];
/// Root-mean-square height of the macrotexture up to which a road is in the fine class \[m\]: dense asphalt.
const FINE: f64 = 6e-4;
/// Shortest cell of a measured road for which the errors of springs are known \[m\]: springs have no limit as cells get
/// smaller.
const SHORTEST_CELL: f64 = 1.5e-3;

/// Errors at [`SPEEDS`] by band \[dB\]: the root mean square over seeds and three neighbouring bands, on the road of
/// the class where it is largest. Those of force and of drafts do not fall with frequency: each is at least that of the
/// bands below.
struct Errors {
    /// Errors of force and vibration.
    force: [[f64; BANDS]; 3],
    /// Errors of sound by [`RadiationQuality::Full`], close to the tyre or beside the road, whichever is larger.
    full: [[f64; BANDS]; 3],
    /// Errors of sound by [`RadiationQuality::Draft`], close to the tyre.
    draft: [[f64; BANDS]; 3],
}

/// Errors of springs on asphalts with stones of 11 and of 8 mm.
const SPRINGS_ON_ASPHALT: Errors = Errors {
    force: [
        [0.6, 0.7, 1.3, 1.5, 1.9, 2.0, 2.0, 2.0, 2.0, 2.0, 2.5, 2.6, 2.9, 3.6, 5.3],
        [0.8, 0.8, 0.8, 0.8, 1.4, 1.4, 1.4, 1.4, 1.5, 2.1, 2.6, 2.6, 2.9, 2.9, 2.9],
        [1.3, 1.3, 1.3, 1.3, 1.3, 1.3, 1.4, 1.9, 2.3, 2.4, 2.7, 2.7, 2.8, 2.8, 2.9],
    ],
    full: [
        [1.3, 1.1, 1.7, 1.6, 4.7, 4.7, 4.6, 2.3, 3.6, 4.0, 4.3, 5.2, 7.4, 11.3, 13.6],
        [7.2, 6.0, 3.6, 1.5, 3.0, 3.0, 3.0, 3.2, 3.7, 3.4, 3.8, 4.6, 7.2, 10.4, 12.5],
        [8.6, 7.7, 4.7, 3.7, 3.7, 3.6, 3.6, 1.8, 2.3, 2.3, 2.4, 3.6, 7.2, 11.8, 14.1],
    ],
    draft: [
        [0.5, 0.5, 1.1, 1.6, 1.6, 1.7, 1.7, 1.7, 1.7, 1.7, 1.9, 2.6, 3.1, 4.4, 5.8],
        [0.6, 0.6, 0.6, 0.6, 0.6, 1.0, 1.0, 1.2, 1.2, 1.2, 2.0, 2.6, 3.8, 5.6, 7.8],
        [0.8, 0.8, 0.8, 0.8, 0.8, 1.5, 1.7, 1.9, 1.9, 1.9, 1.9, 2.7, 3.9, 5.6, 7.6],
    ],
};

const SPRINGS_ON_CHIP_SEAL: Errors = Errors {
    force: [
        [2.7, 2.9, 2.9, 2.9, 2.9, 2.9, 2.9, 2.9, 2.9, 2.9, 2.9, 2.9, 2.9, 3.9, 5.2],
        [2.2, 2.2, 2.5, 3.1, 3.3, 3.3, 3.3, 3.3, 3.3, 3.5, 3.5, 3.5, 3.5, 3.5, 5.1],
        [2.6, 2.6, 2.6, 2.6, 2.7, 2.8, 2.8, 2.8, 3.3, 3.8, 3.8, 3.8, 3.8, 3.8, 3.9],
    ],
    full: [
        [2.7, 3.1, 3.4, 2.6, 2.5, 3.0, 2.8, 2.4, 3.4, 3.9, 4.6, 6.4, 8.6, 12.1, 13.8],
        [4.4, 3.7, 1.7, 2.0, 1.9, 2.1, 2.0, 2.6, 2.7, 2.7, 3.2, 5.3, 8.2, 11.6, 12.9],
        [3.2, 2.9, 2.1, 1.9, 1.4, 1.5, 1.6, 1.8, 2.8, 3.0, 2.9, 3.9, 6.9, 12.2, 14.6],
    ],
    draft: [
        [2.4, 2.6, 2.8, 2.8, 2.8, 2.8, 2.8, 2.8, 2.8, 2.8, 2.8, 3.6, 4.7, 7.0, 9.4],
        [2.0, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 4.3, 7.1, 9.9],
        [1.7, 1.8, 1.9, 1.9, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 3.7, 5.9, 8.1],
    ],
};

const PRESSED_ON_ASPHALT: Errors = Errors {
    force: [
        [0.9, 0.9, 0.9, 1.0, 1.1, 1.1, 1.1, 1.1, 1.7, 2.0, 2.8, 3.6, 3.6, 4.7, 6.6],
        [1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.6, 1.6, 2.1, 2.3, 2.7, 2.7, 2.7],
        [2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4, 2.4],
    ],
    full: [
        [2.3, 2.0, 2.6, 2.5, 4.1, 4.2, 4.0, 2.5, 3.6, 3.7, 2.8, 3.2, 6.4, 9.9, 11.9],
        [6.5, 5.3, 2.5, 0.9, 4.1, 4.1, 4.1, 4.0, 4.7, 3.9, 4.4, 4.8, 7.0, 10.4, 12.3],
        [6.9, 6.2, 3.5, 2.8, 3.8, 3.8, 3.7, 3.1, 3.7, 3.6, 2.7, 3.9, 7.2, 12.0, 14.1],
    ],
    draft: [
        [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.1, 1.3, 1.6, 3.2, 4.9],
        [1.3, 1.3, 1.3, 1.3, 1.3, 1.4, 1.9, 1.9, 1.9, 1.9, 2.3, 2.6, 3.2, 4.3, 6.0],
        [2.1, 2.1, 2.1, 2.1, 2.1, 2.4, 2.7, 2.7, 2.7, 2.7, 2.7, 3.2, 4.2, 5.6, 7.4],
    ],
};

const PRESSED_ON_CHIP_SEAL: Errors = Errors {
    force: [
        [1.7, 1.7, 1.7, 1.7, 1.7, 1.8, 1.8, 2.4, 2.4, 2.5, 2.5, 2.5, 2.5, 2.5, 2.5],
        [1.2, 1.7, 1.9, 1.9, 1.9, 1.9, 1.9, 2.2, 2.5, 2.6, 2.6, 2.6, 2.6, 2.6, 2.6],
        [1.4, 1.4, 1.7, 2.0, 2.0, 2.0, 2.0, 2.2, 2.7, 3.0, 3.0, 3.0, 3.0, 3.0, 3.6],
    ],
    full: [
        [2.5, 2.3, 1.6, 1.9, 2.6, 3.1, 2.6, 2.3, 3.5, 3.9, 3.9, 4.0, 5.9, 9.6, 11.3],
        [4.2, 3.6, 2.4, 1.7, 2.9, 2.5, 2.9, 2.0, 3.0, 3.0, 3.4, 4.7, 6.8, 9.6, 10.7],
        [4.0, 3.6, 2.8, 2.5, 2.8, 2.9, 2.4, 2.0, 3.2, 3.6, 3.2, 4.2, 7.3, 11.8, 14.0],
    ],
    draft: [
        [2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 2.1, 4.2, 6.7],
        [1.6, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 3.4, 5.6, 7.8],
        [1.1, 1.1, 1.4, 1.6, 1.6, 1.6, 1.6, 1.6, 1.6, 1.7, 1.9, 2.4, 3.8, 5.6, 7.5],
    ],
};

impl Plan {
    /// True if levels have an error by slices: with contact over slices on a road with texture across.
    pub(crate) fn by_slices(&self) -> bool {
        let Self { decisions, scene, .. } = self;
        let has_texture = scene.effects.texture != Switch::Off && scene.road.varies_across();
        decisions.zone == Zone::Slices && has_texture
    }

    /// Errors of levels from contact over slices on a road; `None` over cells, without texture, and for laws that were
    /// not measured.
    pub(crate) fn slice_errors_on(&self, surface: &RoadSurface) -> Option<SliceErrors> {
        let Self { decisions, scene, speed, .. } = self;
        let lattice = surface.lattice();
        let springs_have_a_limit = surface.is_made() || lattice.cell().min(lattice.dy) >= SHORTEST_CELL;
        let by_class = match decisions.slices {
            Some(Slices::Winkler) if springs_have_a_limit => [&SPRINGS_ON_ASPHALT, &SPRINGS_ON_CHIP_SEAL],
            Some(Slices::Pressed) => [&PRESSED_ON_ASPHALT, &PRESSED_ON_CHIP_SEAL],
            Some(Slices::Winkler | Slices::HalfSpace) | None => return None,
        };
        let measured = decisions.zone == Zone::Slices
            && lattice.columns > 1
            && decisions.slice_coupling == SliceCoupling::Local
            && scene.contact.tread == Tread::Elastic
            && scene.contact.local_compliance.is_none();
        if !measured {
            return None;
        }
        let macrotexture = surface.macrotexture()?;
        let Errors { force, full, draft } = by_class[usize::from(macrotexture > FINE)];
        let sound = if scene.radiation.quality == RadiationQuality::Full { full } else { draft };
        let [force, sound] = [force, sound].map(|errors| at_speed(errors, 3.6 * speed));
        Some(SliceErrors::new(macrotexture, scene.contact.largest_slice_error, FIRST, &force, &sound))
    }

    /// Frequency up to which slices are valid, in words, and whether that is below the scene's `fmax`.
    pub(crate) fn end_of_slices(&self, errors: &SliceErrors) -> (String, bool) {
        let Scene { numerics, receivers, rolling, .. } = &self.scene;
        let SliceErrors { force_valid_to, sound_valid_to, largest, .. } = *errors;
        let nominal = |end: f64| ThirdOctaveBand::containing(end).map_or(end, ThirdOctaveBand::nominal_frequency);
        let [force, sound] = [force_valid_to, sound_valid_to].map(nominal);
        let up_to = |end: f64| {
            let first = FIRST.nominal_frequency();
            if end < first {
                format!("in no third octave from {first} Hz on (those below have no known error by slices)")
            } else {
                format!("up to {end} Hz")
            }
        };
        let (of_sound, end) = if receivers.is_empty() {
            (String::new(), force)
        } else {
            (format!(", of sound {}", up_to(sound)), force.min(sound))
        };
        let missed = numerics.missed(end);
        let wanted = missed.as_deref().unwrap_or_default();
        let reported = format!(
            "on this road at {:.0} km/h, levels of force and vibration by slices are within {largest} dB of those by \
             cells {}{of_sound}{wanted}; contact.zone = \"cells\" has no such limit, contact.largest_slice_error \
             admits more",
            rolling.speed_kmh,
            up_to(force)
        );
        (reported, missed.is_some())
    }
}

/// Errors at a speed \[km/h\]: between two speeds of the table the larger, above all of them those at the highest.
/// Below all of them those at the lowest, in the bands with the same texture wavelengths: the error grows as these get
/// shorter.
fn at_speed(errors: &[[f64; BANDS]; 3], speed: f64) -> [f64; BANDS] {
    let above = SPEEDS.iter().position(|measured| speed <= *measured).unwrap_or(SPEEDS.len() - 1);
    let at_or_below = if speed >= SPEEDS[above] { above } else { above.saturating_sub(1) };
    let shift = (10.0 * (SPEEDS[0] / speed).log10()).ceil().max(0.0) as usize;
    std::array::from_fn(|band| {
        let band = (band + shift).min(BANDS - 1);
        errors[above][band].max(errors[at_or_below][band])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::road::Limits;
    use crate::scene::Road;
    use crate::test_models::{scene, scene_text};

    const TABLES: [&Errors; 4] =
        [&SPRINGS_ON_ASPHALT, &SPRINGS_ON_CHIP_SEAL, &PRESSED_ON_ASPHALT, &PRESSED_ON_CHIP_SEAL];

    const ROLLING: &str = "speed_kmh = 80.0\nwarm_up = 0.1\nduration = 0.1\naxle = { load = 3000.0 }";

    #[test]
    fn errors_never_fall_with_the_frequency() {
        let rows = TABLES.iter().flat_map(|errors| errors.force.iter().chain(&errors.draft));
        for row in rows {
            assert!(row.windows(2).all(|pair| pair[0] <= pair[1]) && row[0] > 0.0 && row[14] < 15.0, "{row:?}");
        }
        // Waves that are odd across are missing beside the road at 100 Hz, and even more at 2 kHz.
        let full = TABLES.iter().flat_map(|errors| &errors.full).flatten();
        assert!(full.clone().count() == 180 && full.clone().all(|error| (0.1..20.0).contains(error)));
    }

    #[test]
    fn errors_between_speeds_are_the_larger_of_both() {
        let errors = &SPRINGS_ON_ASPHALT.force;
        let bits = |row: [f64; BANDS]| row.map(f64::to_bits);
        for (speed, row) in SPEEDS.iter().zip(errors) {
            assert_eq!(bits(at_speed(errors, *speed)), bits(*row));
        }
        let between = std::array::from_fn(|band| errors[0][band].max(errors[1][band]));
        assert_eq!(bits(at_speed(errors, 60.0)), bits(between));
        assert_eq!(bits(at_speed(errors, 150.0)), bits(errors[2]));
        // At half the speed a band has the error of the band of twice its frequency, three or four further on.
        let slow = at_speed(errors, 25.0);
        assert_eq!([slow[0], slow[14]].map(f64::to_bits), [errors[0][4], errors[0][14]].map(f64::to_bits));
    }

    #[test]
    fn named_asphalts_are_fine_and_chip_seals_coarse() {
        for (texture, fine) in [("iso-10844", true), ("sma-8", true), ("dac-11", true), ("chip-seal", false)] {
            let road = format!("kind = \"made\"\nseed = 1\ntexture = \"{texture}\"");
            let loaded = scene(&scene_text(256, &road, ROLLING, "", ""));
            let plan = Plan::of(&loaded).unwrap();
            let surface = RoadSurface::open(&plan.scene.road, plan.lattice().unwrap(), Limits::default()).unwrap();
            let errors = plan.slice_errors_on(&surface).unwrap();
            assert_eq!(errors.macrotexture <= FINE, fine, "{texture}: {} m", errors.macrotexture);
            assert!(surface.is_made() && errors.bands.len() == BANDS);
            let reported = plan.end_of_slices(&errors).0;
            let end = if errors.force_valid_to < 90.0 {
                "cells in no third octave from 100 Hz on (those below have"
            } else {
                "cells up to "
            };
            assert!(reported.contains(end), "{reported}");
        }
        let smooth = RoadSurface::open(
            &Road::Smooth,
            crate::road::Lattice { dx: 0.01, along: 1, dy: 0.1, columns: 1 },
            Limits::default(),
        )
        .unwrap();
        assert_eq!(smooth.macrotexture(), None);
    }
}
