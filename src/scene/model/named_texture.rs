//! Named textures of made roads: third-octave levels, skewness, the mean profile depth that belongs to them, and their
//! origin.
//!
//! No third-octave spectrum of a named surface was to be had as numbers, but for the chip seal's: the levels of
//! `dac-11`, `sma-8`, `sma-11` and `iso-10844` are constructed, and say so ([`NamedTexture::origin`]).
//!
//! 1. `sma-11` is the mean of two spectra: the profile of `rough-asphalt`, its laser's footprint of 2.5 mm removed; and
//!    that of a packing of stones of 2 to 11 mm with flat tops in mortar, of the depth (0.82 mm), rms height (0.66 mm)
//!    and skewness (-1.85) of a scanned SMA 11. They differ by up to 4 dB from 158 to 10 mm.
//! 2. `dac-11` is 3.5 dB below it: depths of 0.50 and 0.81 mm in a library of materials are 4.2 dB apart, the noise of
//!    such roads suggests 1 to 2.5 dB.
//! 3. A mix with stones of 8 instead of 11 mm has waves 8/11 times as long, at 1.4 dB less (`sma-8`) and 5.6 dB less
//!    (`iso-10844`). Beyond the last band levels fall by 1.65 dB a band.
//!
//! The skewness of rolled surfaces, -1, lies between the two that could be read: -1.85 of the SMA 11, +0.1 of
//! `rough-asphalt`. It changes the force by 2 to 3 dB, as much as the uncertainty of the levels.

use serde::{Deserialize, Serialize};

/// Named texture of a made road.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum NamedTexture {
    /// Surface of test tracks to ISO 10844.
    #[serde(rename = "iso-10844")]
    Iso10844,
    /// Dense asphalt concrete, stones up to 11 mm: the default.
    #[serde(rename = "dac-11")]
    DenseAsphalt11,
    /// Stone mastic asphalt, stones up to 8 mm.
    #[serde(rename = "sma-8")]
    StoneMastic8,
    /// Stone mastic asphalt, stones up to 11 mm.
    #[serde(rename = "sma-11")]
    StoneMastic11,
    /// One measured road, rougher than any dense asphalt of which a depth was found: until version 0.3.0 the default.
    #[serde(rename = "rough-asphalt")]
    RoughAsphalt,
    /// Surface dressing with coarse chippings.
    #[serde(rename = "chip-seal")]
    ChipSeal,
}

/// Third-octave bands of the named textures: mid-wavelengths 10^(n/10) m, n = -8 (158 mm) down to -24 (4 mm).
const NAMED_TEXTURE_BANDS: std::ops::RangeInclusive<i32> = -24..=-8;

/// Facts of a texture.
struct Facts {
    name: &'static str,
    /// Levels of the bands, longest wavelength first \[dB re 1e-6 m\].
    levels: [f64; 17],
    /// Uncertainty of the levels as those of such a road \[dB\].
    uncertainty: f64,
    /// Mean profile depth, and by how much a single road may deviate \[m\].
    depth: [f64; 2],
    /// Skewness and kurtosis of the heights.
    moments: [f64; 2],
    origin: &'static str,
}

/// Skewness of rolled surfaces, and the kurtosis of a gamma distribution with it.
const ROLLED: [f64; 2] = [-1.0, 4.5];

const ISO_10844: Facts = Facts {
    name: "iso-10844",
    levels: [32.7, 33.7, 34.1, 34.4, 35.1, 36.1, 37.1, 37.8, 38.4, 38.9, 39.4, 39.8, 39.8, 39.5, 38.6, 37.4, 36.2],
    uncertainty: 3.0,
    depth: [0.5e-3, 0.2e-3],
    moments: ROLLED,
    origin: "constructed, +-3 dB: waves 8/11 times as long as those of sma-11 and 5.6 dB lower; ISO 10844:2014 asks \
             for a depth of 0.5 +- 0.2 mm and stones up to 8 mm, for no spectrum",
};
const DENSE_ASPHALT_11: Facts = Facts {
    name: "dac-11",
    levels: [36.2, 36.2, 36.6, 37.5, 38.6, 39.5, 40.2, 40.7, 41.2, 41.6, 41.9, 41.9, 41.3, 40.3, 39.0, 37.7, 36.3],
    uncertainty: 3.0,
    depth: [0.6e-3, 0.2e-3],
    moments: ROLLED,
    origin: "constructed, +-3 dB: 3.5 dB below sma-11; no published third-octave spectrum of a dense asphalt was to be \
             had",
};
const STONE_MASTIC_8: Facts = Facts {
    name: "sma-8",
    levels: [36.9, 37.9, 38.3, 38.6, 39.3, 40.3, 41.3, 42.0, 42.6, 43.1, 43.6, 43.9, 44.0, 43.6, 42.8, 41.6, 40.3],
    uncertainty: 2.5,
    depth: [0.8e-3, 0.2e-3],
    moments: ROLLED,
    origin: "constructed, +-2.5 dB: waves 8/11 times as long as those of sma-11 and 1.4 dB lower",
};
const STONE_MASTIC_11: Facts = Facts {
    name: "sma-11",
    levels: [39.7, 39.7, 40.1, 41.0, 42.1, 43.0, 43.7, 44.2, 44.7, 45.1, 45.4, 45.4, 44.8, 43.8, 42.5, 41.2, 39.8],
    uncertainty: 3.0,
    depth: [0.9e-3, 0.2e-3],
    moments: ROLLED,
    origin: "constructed, +-3 dB (6 dB in single bands): mean of rough-asphalt and of a packing of stones with the \
             depth, rms height and skewness of one scanned SMA 11",
};
/// The level at 125 mm, the second one, was not measured: it is the mean of its neighbours.
const ROUGH_ASPHALT: Facts = Facts {
    name: "rough-asphalt",
    levels: [40.6, 41.3, 42.0, 40.6, 42.8, 44.2, 44.4, 44.6, 46.0, 46.8, 46.2, 45.6, 43.1, 40.3, 37.9, 35.4, 30.4],
    uncertainty: 0.0,
    depth: [1.1e-3, 0.2e-3],
    moments: [0.0, 3.0],
    origin: "levels: measured, one profile of 20 m of an unnamed road, as rough as a stone mastic asphalt of 11 to \
             16 mm; until version 0.3.0 called dac-11",
};
/// Skewness and kurtosis of the chip seal are -0.34 and 2.27; 2.4 is the least kurtosis that a made road can have with
/// this skewness.
const CHIP_SEAL: Facts = Facts {
    name: "chip-seal",
    levels: [51.6, 49.9, 50.6, 53.0, 55.9, 54.5, 57.2, 57.7, 56.3, 56.8, 57.0, 56.0, 53.6, 52.5, 51.8, 50.0, 48.0],
    uncertainty: 2.0,
    depth: [3.3e-3, 0.4e-3],
    moments: [-0.34, 2.4],
    origin: "depth, levels, skewness: measured, CAPTIF stations Aylesbury 0, 1 and 10 (captif-nz/captif-slp, MIT): \
             depths 3.06 to 3.44 mm, energy mean of the levels, which differ by +-2 dB from station to station; \
             158 mm is longer than a twelfth of the profiles",
};

impl NamedTexture {
    /// All named textures, from the smoothest to the roughest.
    pub const ALL: [Self; 6] = [
        Self::Iso10844,
        Self::DenseAsphalt11,
        Self::StoneMastic8,
        Self::StoneMastic11,
        Self::RoughAsphalt,
        Self::ChipSeal,
    ];
    /// Texture of a made road that gives neither a name nor a spectrum.
    pub const DEFAULT: Self = Self::DenseAsphalt11;
    /// Shortest mid-wavelength of all of them \[m\].
    pub const SHORTEST: f64 = 0.004;

    const fn facts(self) -> &'static Facts {
        match self {
            Self::Iso10844 => &ISO_10844,
            Self::DenseAsphalt11 => &DENSE_ASPHALT_11,
            Self::StoneMastic8 => &STONE_MASTIC_8,
            Self::StoneMastic11 => &STONE_MASTIC_11,
            Self::RoughAsphalt => &ROUGH_ASPHALT,
            Self::ChipSeal => &CHIP_SEAL,
        }
    }

    /// The value of `road.texture` in a scene.
    pub const fn name(self) -> &'static str {
        self.facts().name
    }

    /// Band numbers n (mid-wavelength 10^(n/10) m) and levels of a profile \[dB re 1e-6 m\], longest wavelength first.
    pub fn levels(self) -> impl Iterator<Item = (i32, f64)> {
        NAMED_TEXTURE_BANDS.rev().zip(self.facts().levels)
    }

    /// Uncertainty of the levels as those of such a road \[dB\]; 0 for a single road.
    pub const fn uncertainty(self) -> f64 {
        self.facts().uncertainty
    }

    /// True if the levels follow from a rule instead of a measurement.
    pub const fn is_constructed(self) -> bool {
        !matches!(self, Self::RoughAsphalt | Self::ChipSeal)
    }

    /// Mean profile depth of such roads, and by how much a single one may deviate \[m\].
    pub const fn depth(self) -> [f64; 2] {
        self.facts().depth
    }

    /// Skewness and kurtosis of the heights.
    pub const fn moments(self) -> [f64; 2] {
        self.facts().moments
    }

    /// Source of depth and levels, in a sentence.
    pub const fn origin(self) -> &'static str {
        self.facts().origin
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::reference;

    #[test]
    fn names_are_those_of_scene_files_and_every_band_has_a_level() {
        for texture in NamedTexture::ALL {
            assert_eq!(serde_json::to_value(texture).unwrap(), texture.name());
            let bands: Vec<i32> = texture.levels().map(|(band, _)| band).collect();
            assert_eq!((bands.len(), bands[0], bands[16]), (17, -8, -24));
        }
    }

    #[test]
    fn levels_are_those_of_the_table_of_named_roads() {
        let table = std::fs::read_to_string(reference("roads/named_textures.csv")).unwrap();
        let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let names = rows.next().unwrap();
        let rows: Vec<Vec<f64>> = rows.map(|row| row.iter().map(|cell| cell.parse().unwrap()).collect()).collect();
        for (column, name) in names.iter().enumerate().skip(1) {
            let texture = NamedTexture::ALL.into_iter().find(|texture| texture.name() == *name).unwrap();
            assert_eq!(rows.len(), texture.levels().count());
            for ((band, level), row) in texture.levels().zip(&rows) {
                let wavelength = 1e-3 * row[0];
                assert!((10.0 * wavelength.log10() - f64::from(band)).abs() < 0.01, "{wavelength}");
                assert!((level - row[column]).abs() < 1e-9, "{name}, {wavelength}: {level}");
            }
        }
    }

    #[test]
    fn chip_seal_is_the_stations_mean() {
        let table = std::fs::read_to_string(reference("roads/captif_aylesbury_levels.csv")).unwrap();
        let rows = table.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect());
        let rows: Vec<Vec<f64>> = rows.collect();
        for (band, level) in NamedTexture::ChipSeal.levels() {
            let row = rows.iter().find(|row| (row[0] - f64::from(band)).abs() < 0.5).unwrap();
            let mean = row[2..].iter().map(|level| 10.0_f64.powf(0.1 * level)).sum::<f64>() / 3.0;
            assert!((10.0 * mean.log10() - level).abs() < 0.051, "band {band}: {level}");
        }
    }

    /// The rule of the module's head, recomputed: levels of `sma-11` at 11/8 times the wavelength, shifted.
    #[test]
    fn constructed_levels_are_those_of_the_parent_scaled_and_shifted() {
        let parent: Vec<f64> = NamedTexture::StoneMastic11.levels().map(|(_, level)| level).collect();
        for (texture, stones, shift) in [
            (NamedTexture::DenseAsphalt11, 11.0, -3.5),
            (NamedTexture::StoneMastic8, 8.0, -1.4),
            (NamedTexture::Iso10844, 8.0, -5.6),
        ] {
            let moved = 10.0 * (11.0_f64 / stones).log10();
            for (place, (band, level)) in texture.levels().enumerate() {
                let place = place as f64 - moved;
                // Beyond the longest band the parent is not given here.
                if place < 0.0 {
                    continue;
                }
                let first = (place as usize).min(parent.len() - 2);
                let at = parent[first] + (place - first as f64) * (parent[first + 1] - parent[first]);
                // Levels of both are rounded to 0.1 dB, and the parent's are curved.
                assert!((level - at - shift).abs() < 0.15, "{}, band {band}: {level}", texture.name());
            }
        }
    }
}
