//! Uncertainty of a named road as factors of a sweep, and the spread of results that it causes.
//!
//! The corner cases are the levels, as they are stated and off by their uncertainty, with each skewness that was read
//! of rolled surfaces. A spread is that of the means over seeds; seeds and all other factors are those of the sweep.

use std::collections::BTreeMap;

use super::factor::Factor;
use super::repeated::RepeatedTable;
use crate::results::table::{Report, aligned, csv, optional};
use crate::scene::{NamedTexture, Road, Scene, Setting};

/// Keys of the two factors.
pub(crate) const ROAD_KEYS: [&str; 2] = ["road.offset", "road.skewness"];
/// Skewness of Gaussian heights, and of a scanned stone mastic asphalt: constructed roads lie between them.
const SKEWNESS: [f64; 2] = [0.0, -1.85];

/// Offsets \[dB\] and skewness of the corner cases of a named road about those that are stated, which come first;
/// `None` for a road that was measured.
pub(crate) fn corner_values(texture: NamedTexture, [offset, skewness]: [f64; 2]) -> Option<[Vec<f64>; 2]> {
    let off = texture.is_constructed().then_some(texture.uncertainty())?;
    let others = SKEWNESS.into_iter().filter(|other| (other - skewness).abs() > 1e-9);
    Some([vec![offset, offset - off, offset + off], std::iter::once(skewness).chain(others).collect()])
}

/// The factors of a scene's road, and the values that it states.
#[derive(Clone, Debug)]
pub(crate) struct RoadUncertainty {
    /// Levels and skewness.
    pub factors: Vec<Factor>,
    stated: [String; 2],
}

impl RoadUncertainty {
    /// The corner cases of a scene's road.
    ///
    /// # Errors
    /// In words, for a road that is none of the constructed ones.
    pub(crate) fn of(scene: &Scene) -> Result<Self, String> {
        let constructed = || {
            let Road::Made(made) = &scene.road else { return None };
            let stated = [made.offset, made.moments()[0]];
            Some((stated, corner_values(made.named()?, stated)?))
        };
        let needed = "--road-uncertainty needs a constructed road.texture: dac-11, sma-8, sma-11 or iso-10844";
        let (stated, values) = constructed().ok_or(needed)?;
        let factor = |(key, values): (&str, Vec<f64>)| {
            let listed = values.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
            Setting::parse(&format!("{key}={listed}")).and_then(|setting| Factor::of(&setting))
        };
        let factors = ROAD_KEYS.into_iter().zip(values).map(factor);
        let factors = factors.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        Ok(Self { factors, stated: stated.map(|value| value.to_string()) })
    }

    /// Spread of every quantity of a sweep's table.
    pub(crate) fn spread(&self, table: &RepeatedTable) -> Spread {
        let place = |key: &&str| table.factors.iter().position(|factor| factor == key);
        let places: Vec<usize> = ROAD_KEYS.iter().filter_map(place).collect();
        let others = |values: &[String]| -> Vec<String> {
            let kept = values.iter().enumerate().filter(|(place, _)| !places.contains(place));
            kept.map(|(_, value)| value.clone()).collect()
        };
        let (mut rows, mut known) = (Vec::new(), BTreeMap::new());
        for (values, quantity, unit, mean) in table.values() {
            let is_stated = places.iter().zip(&self.stated).all(|(place, stated)| &values[*place] == stated);
            let others = others(values);
            let place = *known.entry((others.clone(), quantity)).or_insert_with(|| {
                let range = [f64::INFINITY, f64::NEG_INFINITY];
                rows.push(SpreadRow { others, quantity: quantity.to_owned(), unit, stated: None, range });
                rows.len() - 1
            });
            let row: &mut SpreadRow = &mut rows[place];
            row.range = [row.range[0].min(mean), row.range[1].max(mean)];
            if is_stated {
                row.stated = Some(mean);
            }
        }
        Spread { factors: others(&table.factors), rows }
    }
}

/// Lowest and highest mean of a quantity over the corner cases.
#[derive(Clone, Debug, PartialEq)]
struct SpreadRow {
    /// Values of the other factors.
    others: Vec<String>,
    quantity: String,
    unit: &'static str,
    /// Mean on the road as it is stated.
    stated: Option<f64>,
    range: [f64; 2],
}

/// Spreads of all quantities.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Spread {
    factors: Vec<String>,
    rows: Vec<SpreadRow>,
}

impl Spread {
    /// A line for each quantity: value on the road as stated, and how far the corner cases lie below and above.
    pub(crate) fn report(&self) -> Report {
        let columns = ["quantity", "unit", "road as stated", "below", "above"].map(str::to_owned);
        let line = |row: &SpreadRow| {
            let decimals = if row.unit.starts_with("dB") { 1 } else { 5 };
            let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:+.decimals$}"));
            let stated = row.stated.map_or("-".to_owned(), |value| format!("{value:.decimals$}"));
            let [below, above] = row.range.map(|end| number(row.stated.map(|stated| end - stated)));
            let cells = [row.quantity.clone(), row.unit.to_owned(), stated, below, above];
            row.others.iter().cloned().chain(cells).collect::<Vec<_>>()
        };
        let mut report = Report::from(aligned(self.factors.iter().cloned().chain(columns), self.rows.iter().map(line)));
        report.text("below, above: means over seeds with levels and skewness of the road as they may be\n");
        report
    }

    /// Columns: the other factors, quantity, unit, mean on the road as stated, lowest and highest mean.
    pub(crate) fn csv(&self) -> String {
        let columns = ["quantity", "unit", "stated", "lowest", "highest"].map(str::to_owned);
        let line = |row: &SpreadRow| {
            let [lowest, highest] = row.range.map(|end| end.to_string());
            let cells = [row.quantity.clone(), row.unit.to_owned(), optional(row.stated), lowest, highest];
            row.others.iter().cloned().chain(cells).collect::<Vec<_>>()
        };
        csv(self.factors.iter().cloned().chain(columns), self.rows.iter().map(line))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::response::{BandLevel, ThirdOctaveBand};
    use crate::scene::DEFAULT;
    use crate::study::sweep::run::Done;
    use crate::study::sweep::variants::{Choice, Label};

    fn scene(texture: &str) -> Scene {
        let settings: Vec<Setting> =
            [format!("road.texture={texture}")].iter().flat_map(|text| Setting::parse(text)).collect();
        Scene::from_str_with(DEFAULT, "default", &settings).unwrap().scene
    }

    #[test]
    fn spreads_are_those_of_means_over_seeds() {
        let uncertainty = RoadUncertainty::of(&scene("sma-8")).unwrap();
        let values: Vec<Vec<&str>> = uncertainty.factors.iter().map(|factor| factor.values.texts().unwrap()).collect();
        assert_eq!(values, [["0", "-2.5", "2.5"], ["-1", "0", "-1.85"]]);
        let mut runs = Vec::new();
        for (offset, skewness) in values[0].iter().flat_map(|offset| values[1].iter().map(move |s| (*offset, *s))) {
            for seed in ["1", "2"] {
                let choice = |factor: &str, value: &str, repeats| Choice {
                    factor: factor.to_owned(),
                    value: value.to_owned(),
                    repeats,
                };
                let choices = vec![
                    choice(ROAD_KEYS[0], offset, false),
                    choice(ROAD_KEYS[1], skewness, false),
                    choice("road.seed", seed, true),
                ];
                let number = |text: &str| text.parse::<f64>().unwrap();
                let level = 40.0 + number(offset) + number(skewness) + 0.2 * number(seed);
                let band = BandLevel { band: ThirdOctaveBand(-3), mean_square: 1.0, level, valid: true };
                let label = Label { name: String::new(), group: String::new(), speed: 80.0, choices };
                runs.push((label, Some(Done { levels: vec![band], ..Done::default() })));
            }
        }
        let spread = uncertainty.spread(&RepeatedTable::of(&runs));
        let row = spread.rows.iter().find(|row| row.quantity == "force, 500 Hz").unwrap();
        // Seeds add 0.3 dB; stated: a skewness of -1.
        assert!((row.stated.unwrap() - 39.3).abs() < 1e-9, "{row:?}");
        assert!((row.range[0] - 35.95).abs() < 1e-9 && (row.range[1] - 42.8).abs() < 1e-9, "{row:?}");
        assert!(spread.report().to_string().contains("+3.5") && spread.csv().contains("force, 500 Hz"));
    }

    #[test]
    fn corner_cases_lie_about_the_road_of_the_scene() {
        let mut scene = scene("dac-11");
        let Road::Made(made) = &mut scene.road else { panic!("a made road") };
        (made.offset, made.skewness) = (2.0, Some(0.0));
        let uncertainty = RoadUncertainty::of(&scene).unwrap();
        let values: Vec<Vec<&str>> = uncertainty.factors.iter().map(|factor| factor.values.texts().unwrap()).collect();
        assert_eq!(values, [vec!["2", "-1", "5"], vec!["0", "-1.85"]]);
    }

    #[test]
    fn roads_that_were_measured_have_no_corner_cases() {
        for texture in ["rough-asphalt", "chip-seal"] {
            assert!(RoadUncertainty::of(&scene(texture)).unwrap_err().contains("sma-11"));
        }
    }
}
