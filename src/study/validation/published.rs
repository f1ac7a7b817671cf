//! Published values: third octaves of cars, and single quantities, read from the files in `data`.
//!
//! A set of third octaves gives A-weighted levels at 50, 80 and 110 km/h. From it come
//!
//! ```text
//! relative level of a band = L_A(band) - 10 lg sum over 200 ... 2000 Hz of 10^(L_A/10),
//! growth of a band = (L_A at 110 km/h - L_A at 50 km/h)/lg(110/50).
//! ```
//!
//! Levels of one tyre at the coast-by microphone, r = 7.6 m from the source, are those of a car less 6 dB: the power
//! spreads over the half sphere 2 pi r^2, levels at 15 m fall with 20 lg r.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::response::ThirdOctaveBand;
use crate::scene::NamedTexture;

/// Speeds of the published third octaves \[km/h\].
pub(crate) const PUBLISHED_SPEEDS: [f64; 3] = [50.0, 80.0, 110.0];
/// Names of the columns of a speed.
const SPEED_NAMES: [&str; 3] = ["50", "80", "110"];
/// Bands whose energies are summed, lowest and highest: 200 Hz to 2 kHz.
pub(super) const BANDS: std::ops::RangeInclusive<i32> = -7..=3;

/// Roads for the comparison with fleets of cars, of which published third octaves do not tell one from the other.
pub(crate) const FLEET_ROADS: [NamedTexture; 2] = [NamedTexture::DenseAsphalt11, NamedTexture::StoneMastic8];
/// Roads of a validation, from the smoothest to the roughest.
pub(crate) const ROADS: [NamedTexture; 5] =
    [NamedTexture::Iso10844, FLEET_ROADS[0], FLEET_ROADS[1], NamedTexture::StoneMastic11, NamedTexture::ChipSeal];

/// Distance of the coast-by microphone from the source on the road \[m\]: 7.5 m aside, 1.2 m above.
const DISTANCE: f64 = 7.595;
/// The same of the published levels of automobiles \[m\]: 15 m aside, 1.5 m above.
const AUTOMOBILES_AT: f64 = 15.07;
/// Tyres of a car, each with a quarter of its power.
const TYRES: f64 = 4.0;

const CARS: &str = include_str!("data/car_rolling_noise_third_octaves.csv");
const AUTOMOBILES: &str = include_str!("data/fhwa_tnm_autos_third_octaves.csv");
const QUANTITIES: &str = include_str!("data/quantities.json");

/// True if a row needs a road at a speed \[km/h\]: roads other than those of the fleets are compared at 80 km/h alone.
pub(super) fn is_compared(texture: NamedTexture, speed: f64) -> bool {
    FLEET_ROADS.contains(&texture) || (speed - PUBLISHED_SPEEDS[1]).abs() < 1e-9
}

/// Origin of a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RangeOrigin {
    /// From measurements.
    Measured,
    /// Target of a fit: shows whether the tyre still is what it was fitted to.
    Target,
}

/// Published range of a quantity.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub(crate) struct Quantity {
    /// Name of the quantity.
    pub title: String,
    /// Unit of the range.
    pub unit: String,
    /// Lowest value.
    pub lowest: f64,
    /// Highest value.
    pub highest: f64,
    /// Number of sets.
    pub sets: usize,
    /// Measured, or a target of a fit.
    pub kind: RangeOrigin,
    /// Spread in words.
    pub spread: String,
    /// Source.
    pub source: String,
}

/// Widening of ranges of third octaves.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub(super) struct Widening {
    pub unit: String,
    pub spread: f64,
    pub reason: String,
}

#[derive(Deserialize)]
struct Bands {
    shape: Widening,
    growth: Widening,
    sources: BTreeMap<String, String>,
}

#[derive(Deserialize)]
struct File {
    bands: Bands,
    quantities: BTreeMap<String, Quantity>,
}

/// Third octaves of one source.
#[derive(Clone, Debug, PartialEq)]
pub struct PublishedSet {
    /// Name of the source.
    pub source: String,
    /// Levels of the bands from 200 Hz to 2 kHz at each of the published speeds, of one tyre at the coast-by microphone
    /// \[dB(A)\].
    levels: [BTreeMap<i32, f64>; 3],
}

impl PublishedSet {
    /// Level of a band of one tyre at the coast-by microphone \[dB(A)\]; `speed` is an index of [`PUBLISHED_SPEEDS`].
    pub(crate) fn level(&self, speed: usize, band: ThirdOctaveBand) -> Option<f64> {
        self.levels.get(speed)?.get(&band.0).copied()
    }

    /// Level of a band relative to the energy sum of all bands \[dB\]; `speed` is an index of [`PUBLISHED_SPEEDS`].
    pub(crate) fn relative(&self, speed: usize, band: ThirdOctaveBand) -> Option<f64> {
        let levels = self.levels.get(speed)?;
        Some(levels.get(&band.0)? - energy_sum(levels.values().copied()))
    }

    /// Growth of a band from the lowest to the highest speed \[dB per decade\].
    pub(crate) fn growth(&self, band: ThirdOctaveBand) -> Option<f64> {
        let [lowest, _, highest] = &self.levels;
        Some((highest.get(&band.0)? - lowest.get(&band.0)?) / decades())
    }
}

/// Decades of speed between the lowest and the highest published one.
pub(super) fn decades() -> f64 {
    (PUBLISHED_SPEEDS[2] / PUBLISHED_SPEEDS[0]).log10()
}

pub(super) fn energy_sum(levels: impl IntoIterator<Item = f64>) -> f64 {
    crate::sound::levels::energetic_sum(levels)
}

/// Bands of the comparison, lowest first.
pub(crate) fn bands() -> impl Iterator<Item = ThirdOctaveBand> {
    BANDS.map(ThirdOctaveBand)
}

/// All published values.
#[derive(Clone, Debug)]
pub struct Published {
    /// Sets of third octaves.
    pub sets: Vec<PublishedSet>,
    pub(super) shape: Widening,
    pub(super) growth: Widening,
    quantities: BTreeMap<String, Quantity>,
}

impl Published {
    /// Reads the embedded files.
    ///
    /// # Panics
    /// If an embedded file is damaged: a test reads them.
    #[expect(clippy::expect_used, reason = "the files are part of the program, and a test reads them")]
    pub fn embedded() -> Self {
        let File { bands, quantities } = serde_json::from_str(QUANTITIES).expect("quantities.json is valid");
        let Bands { shape, growth, sources } = bands;
        let cars = |speed| format!("A_weighted_band_minus_overall_{speed}kmh_dB");
        let power = |speed| format!("LW_{speed}kmh_dB");
        let mut sets = Vec::new();
        for (name, source) in sources {
            let of_cars = levels(CARS, "set", &name, cars).zip(levels(CARS, "set", &name, power));
            let levels = of_cars
                .map(|(shape, power)| shifted(absolute(shape, &power), -10.0 * (TAU * DISTANCE.powi(2)).log10()))
                .or_else(|| {
                    let at_15_m = levels(AUTOMOBILES, "pavement", &name, |speed| format!("LA_15m_{speed}kmh"))?;
                    Some(shifted(at_15_m, 20.0 * (AUTOMOBILES_AT / DISTANCE).log10()))
                })
                .map(|of_car| shifted(of_car, -10.0 * TYRES.log10()))
                .expect("each named set has its bands");
            sets.push(PublishedSet { source, levels });
        }
        Self { sets, shape, growth, quantities }
    }

    pub(crate) fn quantity(&self, name: &str) -> Option<&Quantity> {
        self.quantities.get(name)
    }

    /// Names and ranges of all single quantities.
    #[cfg(test)]
    pub(crate) fn quantities(&self) -> impl Iterator<Item = (&str, &Quantity)> {
        self.quantities.iter().map(|(name, quantity)| (name.as_str(), quantity))
    }

    /// Range of a band relative to the sum \[dB\]; `speed` is an index of [`PUBLISHED_SPEEDS`].
    pub(crate) fn shape_range(&self, speed: usize, band: ThirdOctaveBand) -> [f64; 2] {
        widened(self.sets.iter().filter_map(|set| set.relative(speed, band)), self.shape.spread)
    }

    /// Range of a band's growth \[dB per decade\].
    pub(crate) fn growth_range(&self, band: ThirdOctaveBand) -> [f64; 2] {
        widened(self.sets.iter().filter_map(|set| set.growth(band)), self.growth.spread)
    }
}

fn widened(values: impl Iterator<Item = f64>, by: f64) -> [f64; 2] {
    let [lowest, highest] =
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    [lowest - by, highest + by]
}

fn shifted(mut levels: [BTreeMap<i32, f64>; 3], by: f64) -> [BTreeMap<i32, f64>; 3] {
    levels.iter_mut().flat_map(BTreeMap::values_mut).for_each(|level| *level += by);
    levels
}

/// Levels at all speeds with a common reference: each A-weighted shape, shifted so that 1 kHz, where the A-weighting is
/// 0 dB, has the level of its power.
fn absolute(shape: [BTreeMap<i32, f64>; 3], power: &[BTreeMap<i32, f64>; 3]) -> [BTreeMap<i32, f64>; 3] {
    let mut shifted = shape;
    for (shape, power) in shifted.iter_mut().zip(power) {
        let shift = power.get(&0).zip(shape.get(&0)).map_or(f64::NAN, |(power, shape)| power - shape);
        shape.values_mut().for_each(|level| *level += shift);
    }
    shifted
}

/// Levels of the bands at the three speeds, from the columns named after the speed, for the rows of a set; `None` for a
/// set that is missing or incomplete.
fn levels(
    table: &str,
    key: &str,
    set: &str,
    column: impl Fn(&'static str) -> String,
) -> Option<[BTreeMap<i32, f64>; 3]> {
    let mut lines = table.lines();
    let header: Vec<&str> = lines.next()?.split(',').collect();
    let place = |name: &str| header.iter().position(|cell| *cell == name);
    let (key, frequency) = (place(key)?, place("band_Hz")?);
    let mut found = [BTreeMap::new(), BTreeMap::new(), BTreeMap::new()];
    for cells in lines.map(|line| line.split(',').collect::<Vec<_>>()) {
        let band = ThirdOctaveBand::containing(cells.get(frequency)?.parse().ok()?)?;
        if cells.get(key) != Some(&set) || !BANDS.contains(&band.0) {
            continue;
        }
        for (found, speed) in found.iter_mut().zip(SPEED_NAMES) {
            found.insert(band.0, cells.get(place(&column(speed))?)?.parse().ok()?);
        }
    }
    found.iter().all(|levels| levels.len() == BANDS.count()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::reference;

    #[test]
    fn levels_of_one_tyre_differ_by_ten_decibels_at_500_hz() {
        let at = |set: &PublishedSet| set.level(1, ThirdOctaveBand(-3)).unwrap();
        let mut found: Vec<f64> = Published::embedded().sets.iter().map(at).collect();
        found.sort_by(f64::total_cmp);
        // By hand: a power of 83.1 dB, less 3.2 dB by the A-weighting, 25.6 by the distance, 6 for one tyre of four.
        for (found, expected) in found.iter().zip([48.3, 53.7, 54.7, 58.5, 59.0]) {
            assert!((found - expected).abs() < 0.1, "{found}");
        }
    }

    #[test]
    fn all_sets_have_all_bands_at_all_speeds() {
        let published = Published::embedded();
        assert_eq!(published.sets.len(), 5);
        for set in &published.sets {
            for speed in 0..3 {
                let shape: Vec<f64> = bands().map(|band| set.relative(speed, band).unwrap()).collect();
                assert_eq!(shape.len(), 11);
                assert!(energy_sum(shape).abs() < 1e-9, "{}: relative levels add up to 0 dB", set.source);
            }
        }
    }

    /// Checked by hand: Nord2000's slopes are the law's coefficients, 25.9 at 500 Hz; the model's table has TNM's.
    #[test]
    fn growth_is_that_of_the_laws() {
        let published = Published::embedded();
        let growth = |source: &str, band| {
            let set = published.sets.iter().find(|set| set.source.contains(source)).unwrap();
            set.growth(ThirdOctaveBand(band)).unwrap()
        };
        // Levels are rounded to 0.1 dB, over a third of a decade.
        assert!((growth("Denmark", -3) - 25.9).abs() < 0.6 && (growth("Denmark", 1) - 41.4).abs() < 0.6);
        assert!((growth("Harmonoise", 0) - 29.1).abs() < 0.6);
        assert!((growth("dense graded", 0) - 43.5).abs() < 0.6);
        let [lowest, highest] = published.growth_range(ThirdOctaveBand(-3));
        assert!((lowest - (21.5 - 3.0)).abs() < 0.6 && (highest - (37.6 + 3.0)).abs() < 0.6, "{lowest} {highest}");
    }

    #[test]
    fn a_range_holds_every_set_and_is_wider_by_the_stated_spread() {
        let published = Published::embedded();
        for (speed, band) in (0..3).flat_map(|speed| bands().map(move |band| (speed, band))) {
            let [lowest, highest] = published.shape_range(speed, band);
            let values: Vec<f64> = published.sets.iter().map(|set| set.relative(speed, band).unwrap()).collect();
            let least = values.iter().copied().fold(f64::INFINITY, f64::min);
            let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            assert!((least - lowest - 2.4).abs() < 1e-9 && (highest - most - 2.4).abs() < 1e-9);
        }
    }

    #[test]
    fn single_quantities_are_those_of_their_sources() {
        let published = Published::embedded();
        for (name, quantity) in published.quantities() {
            assert!(quantity.lowest < quantity.highest && quantity.sets > 0, "{name}");
            assert!(quantity.source.len() > 10 && !quantity.spread.is_empty(), "{name}");
        }
        let middle = |name: &str| {
            let quantity = published.quantity(name).unwrap();
            0.5 * (quantity.lowest + quantity.highest)
        };
        let text = std::fs::read_to_string(reference("levels/levels.json")).unwrap();
        let levels: serde_json::Value = serde_json::from_str(&text).unwrap();
        let iso = &levels["iso_11819_1_1997"];
        let car = iso["annex_D_L_veh_cars_80kmh_dBA"]["average"].as_f64().unwrap();
        let slope = iso["annex_E_cars"]["slope_dB_per_decade"].as_f64().unwrap();
        for (name, speed) in [("level_50", 50.0_f64), ("level_80", 80.0), ("level_110", 110.0)] {
            let one_tyre = car - 6.0 + slope * (speed / 80.0).log10();
            assert!((middle(name) - one_tyre).abs() < 0.1, "{name}: {one_tyre}");
        }
        let below = &levels["cpx_minus_passby_7.5m_dB"];
        let cpx: Vec<f64> =
            below["CPX"].as_array().unwrap().iter().map(|value| value.as_f64().unwrap() + 6.0).collect();
        let spread = 2.0 * 1.8;
        let quantity = published.quantity("cpx_less_coast_by").unwrap();
        assert!(cpx.iter().all(|value| (quantity.lowest..quantity.highest).contains(value)));
        assert!(quantity.highest - quantity.lowest < 2.0 * spread + 1.0);

        let octaves = std::fs::read_to_string(reference("levels/cpx_octaves_tii_2022.csv")).unwrap();
        let surface = |name: &str| -> Vec<f64> {
            let line = octaves.lines().find(|line| line.starts_with(&format!("{name},"))).unwrap();
            line.split(',').skip(1).take(5).map(|cell| cell.parse().unwrap()).collect()
        };
        for ((name, hra), sma) in
            ["hra_250", "hra_500", "hra_1000", "hra_2000", "hra_4000"].iter().zip(surface("HRA")).zip(surface("SMA 10"))
        {
            assert!((middle(name) - (hra - sma)).abs() < 0.01, "{name}: {hra} less {sma}");
        }
    }
}
