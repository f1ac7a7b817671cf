//! Named textures of made roads: third-octave levels, the mean profile depth that belongs to them, and their origin.
//!
//! Levels of a surface type are published as pictures, hardly ever as numbers. Two of the four roads have measured
//! levels; two are scaled from one of these, and say so ([`NamedTexture::origin`]):
//!
//! 1. A rolled mix with stones r times as large has waves r times as long (r = 8/11 for stones of 8 mm): the level at
//!    a wavelength is that of the dense asphalt at 1/r times the wavelength. Beyond its longest band the level falls by
//!    1 dB a band, as for stones placed independently of each other: the spectral density is constant there.
//! 2. All levels are shifted by the same amount, so that the surface has its mean profile depth (ISO 13473-1).
//!
//! Scaled from the chip seal instead of the dense asphalt (r = 0.48, its peak being at 30 mm instead of 20), the levels
//! of the ISO road would be 3 dB lower from 160 to 50 mm and up to 5 dB higher at 4 mm: a measure of their uncertainty.

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
    /// Surface dressing with coarse chippings.
    #[serde(rename = "chip-seal")]
    ChipSeal,
}

/// Third-octave bands of the named textures: mid-wavelengths 10^(n/10) m, n = -8 (158 mm) down to -24 (4 mm).
const NAMED_TEXTURE_BANDS: std::ops::RangeInclusive<i32> = -24..=-8;

/// Levels of the bands, longest wavelength first \[dB re 1e-6 m\].
type Levels = [f64; 17];

/// The level at 125 mm, the second one, was not measured: it is the mean of its neighbours.
const DENSE_ASPHALT: Levels =
    [40.6, 41.3, 42.0, 40.6, 42.8, 44.2, 44.4, 44.6, 46.0, 46.8, 46.2, 45.6, 43.1, 40.3, 37.9, 35.4, 30.4];
const ISO_10844: Levels =
    [31.8, 32.8, 33.6, 34.3, 33.7, 34.5, 36.2, 36.9, 37.1, 38.0, 39.1, 39.0, 38.4, 36.6, 33.9, 31.4, 28.9];
const STONE_MASTIC_8: Levels =
    [33.4, 34.4, 35.2, 35.9, 35.3, 36.1, 37.8, 38.5, 38.7, 39.6, 40.6, 40.6, 40.0, 38.2, 35.5, 33.0, 30.5];
const CHIP_SEAL: Levels =
    [51.6, 49.9, 50.6, 53.0, 55.9, 54.5, 57.2, 57.7, 56.3, 56.8, 57.0, 56.0, 53.6, 52.5, 51.8, 50.0, 48.0];

impl NamedTexture {
    /// All named textures, from the smoothest to the roughest.
    pub const ALL: [Self; 4] = [Self::Iso10844, Self::StoneMastic8, Self::DenseAsphalt11, Self::ChipSeal];
    /// Texture of a made road that gives neither a name nor a spectrum.
    pub const DEFAULT: Self = Self::DenseAsphalt11;
    /// Shortest mid-wavelength of all of them \[m\].
    pub const SHORTEST: f64 = 0.004;

    /// The value of `road.texture` in a scene.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Iso10844 => "iso-10844",
            Self::DenseAsphalt11 => "dac-11",
            Self::StoneMastic8 => "sma-8",
            Self::ChipSeal => "chip-seal",
        }
    }

    /// Band numbers n (mid-wavelength 10^(n/10) m) and levels of a profile \[dB re 1e-6 m\], longest wavelength first.
    pub fn levels(self) -> impl Iterator<Item = (i32, f64)> {
        let levels = match self {
            Self::Iso10844 => ISO_10844,
            Self::DenseAsphalt11 => DENSE_ASPHALT,
            Self::StoneMastic8 => STONE_MASTIC_8,
            Self::ChipSeal => CHIP_SEAL,
        };
        NAMED_TEXTURE_BANDS.rev().zip(levels)
    }

    /// Mean profile depth of such roads, and by how much a single one may deviate \[m\].
    pub const fn depth(self) -> [f64; 2] {
        match self {
            Self::Iso10844 => [0.5e-3, 0.2e-3],
            Self::DenseAsphalt11 => [1.1e-3, 0.2e-3],
            Self::StoneMastic8 => [0.6e-3, 0.15e-3],
            Self::ChipSeal => [3.3e-3, 0.4e-3],
        }
    }

    /// Skewness and kurtosis of the heights, if they were measured; otherwise heights are Gaussian. The chip seal has
    /// -0.34 and 2.27; 2.4 is the least kurtosis that a made road can have with this skewness.
    pub const fn shape(self) -> Option<[f64; 2]> {
        match self {
            Self::ChipSeal => Some([-0.34, 2.4]),
            Self::Iso10844 | Self::DenseAsphalt11 | Self::StoneMastic8 => None,
        }
    }

    /// Source of depth and levels, in a sentence.
    pub const fn origin(self) -> &'static str {
        match self {
            Self::Iso10844 => {
                "depth: ISO 10844:2014 asks for 0.5 +- 0.2 mm and stones up to 8 mm, for no spectrum; levels: not \
                 measured, those of dac-11 scaled by 8/11 along and to this depth"
            }
            Self::DenseAsphalt11 => {
                "levels: measured on a dense asphalt of this depth; where is not on record, so they are not published \
                 ones; from 160 to 10 mm they lie within 4 dB below and 1 dB above those of chip-seal at the same depth"
            }
            Self::StoneMastic8 => {
                "depth: 0.82 mm measured on SMA 11 (file B6 MP1, 3dT-MM of BASt, in the TextureLab Batch white paper) \
                 times 8/11; levels: not measured, those of dac-11 scaled by 8/11 along and to this depth"
            }
            Self::ChipSeal => {
                "depth, levels, skewness: measured, CAPTIF stations Aylesbury 0, 1 and 10 (captif-nz/captif-slp, MIT): \
                 depths 3.06 to 3.44 mm, energy mean of the levels; 158 mm is longer than a twelfth of the profiles"
            }
        }
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
    fn chip_seal_is_the_stations_mean_and_dense_asphalt_is_near_it() {
        let table = std::fs::read_to_string(reference("roads/captif_aylesbury_levels.csv")).unwrap();
        let rows = table.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect());
        let rows: Vec<Vec<f64>> = rows.collect();
        let dense: Vec<f64> = NamedTexture::DenseAsphalt11.levels().map(|(_, level)| level).collect();
        let to_its_depth = 20.0 * (3.3_f64 / 1.1).log10();
        for (place, (band, level)) in NamedTexture::ChipSeal.levels().enumerate() {
            let row = rows.iter().find(|row| (row[0] - f64::from(band)).abs() < 0.5).unwrap();
            let mean = row[2..].iter().map(|level| 10.0_f64.powf(0.1 * level)).sum::<f64>() / 3.0;
            assert!((10.0 * mean.log10() - level).abs() < 0.051, "band {band}: {level}");
            let below = level - to_its_depth - dense[place];
            assert!(band < -20 || (-1.0..4.0).contains(&below), "band {band}: {below}");
        }
    }

    /// The rule of the module's head, recomputed: levels of the dense asphalt at 11/8 times the wavelength, shifted.
    #[test]
    fn scaled_levels_are_the_dense_asphalts_at_longer_waves() {
        let parent: Vec<f64> = NamedTexture::DenseAsphalt11.levels().map(|(_, level)| level).collect();
        let moved = 10.0 * (11.0_f64 / 8.0).log10();
        let at = |place: f64| {
            let place = place - moved;
            if place < 0.0 {
                return parent[0] + place;
            }
            let first = (place as usize).min(parent.len() - 2);
            parent[first] + (place - first as f64) * (parent[first + 1] - parent[first])
        };
        for texture in [NamedTexture::Iso10844, NamedTexture::StoneMastic8] {
            let shifts: Vec<f64> =
                texture.levels().enumerate().map(|(place, (_, level))| level - at(place as f64)).collect();
            let mean = shifts.iter().sum::<f64>() / shifts.len() as f64;
            // Levels are rounded to 0.1 dB.
            assert!(shifts.iter().all(|shift| (shift - mean).abs() < 0.11), "{}: {shifts:?}", texture.name());
        }
    }

    #[test]
    fn the_default_is_6_to_9_db_above_the_test_track_at_long_waves() {
        let [iso, default] = [NamedTexture::Iso10844, NamedTexture::DEFAULT].map(|of| of.levels().collect::<Vec<_>>());
        let differences = default.iter().zip(&iso).take(4).map(|((_, default), (_, iso))| default - iso);
        for difference in differences {
            assert!((6.0..9.0).contains(&difference), "{difference}");
        }
    }
}
