//! Pictures of a sweep of settings: levels against what is varied.

use std::collections::BTreeSet;

use super::{FORCE, MeanBands, Quantity, RepeatedRow, RepeatedTable, SOUND};
use crate::results::plots::{Axis, PointPlot, PointSeries};
use crate::results::spectra::FORCE_LEVEL;
use crate::study::sweep::variants::{SPEED, said};

/// More lines in one picture cannot be distinguished.
const MOST_LINES: usize = 7;

/// Kinds that are drawn, with name and axis title.
const DRAWN: [(u8, &str, &str); 2] = [(FORCE, "Force", FORCE_LEVEL), (SOUND, "Sound", "Level [dB(A)]")];

/// A series of a picture: its name, the quantity and the combinations.
type Drawn<'a> = (String, &'a Quantity, Vec<&'a RepeatedRow>);

/// Name of the receiver; empty for the force, of which there is one.
fn of_sound(quantity: &Quantity) -> String {
    if quantity.rank.0 == SOUND { quantity.name.clone() } else { String::new() }
}

impl RepeatedTable {
    /// Levels against each factor with more than one value, as name of a file and picture: a point with its interval
    /// for every combination, and a line through the means where values occur more than once.
    pub(crate) fn plots(&self, title: &str) -> Vec<(String, String)> {
        let mut plots = Vec::new();
        for (column, factor) in self.factors.iter().enumerate() {
            if self.labels(column).len() < 2 {
                continue;
            }
            for (rank, name, _) in DRAWN {
                let of = |quantity| (of_sound(quantity), quantity, self.rows.iter().collect());
                let series: Vec<Drawn<'_>> = self.quantities_of(rank).map(of).collect();
                if series.is_empty() {
                    continue;
                }
                let file: String = factor.chars().map(|sign| if sign.is_alphanumeric() { sign } else { '_' }).collect();
                let file = format!("{}_by_{file}.svg", name.to_lowercase());
                plots.push((file, self.against(column, title, &series, false)));
            }
        }
        plots
    }

    /// Levels against the speed or, if that is not varied, against the key with the most values, numbers before words:
    /// a line for each receiver and each combination of the rest, in one picture or in one for each receiver. Empty if
    /// there are too many lines even so.
    pub(crate) fn curves(&self, title: &str) -> Vec<String> {
        let mut varied: Vec<usize> = (0..self.factors.len()).filter(|&column| self.labels(column).len() > 1).collect();
        varied.sort_by_key(|&column| {
            let labels = self.labels(column);
            (self.factors[column] == SPEED, labels.iter().all(|label| label.parse::<f64>().is_ok()), labels.len())
        });
        let Some(column) = varied.pop() else { return Vec::new() };
        varied.sort_unstable();
        let mut combinations: Vec<(String, Vec<&RepeatedRow>)> = Vec::new();
        for row in &self.rows {
            let rest = varied.iter().map(|&other| said(&self.factors[other], &row.values[other]));
            let rest = rest.collect::<Vec<_>>().join(", ");
            match combinations.iter_mut().find(|(other, _)| *other == rest) {
                Some((_, rows)) => rows.push(row),
                None => combinations.push((rest, vec![row])),
            }
        }
        if combinations.len() > MOST_LINES {
            return Vec::new();
        }
        let mut pictures = Vec::new();
        for (rank, ..) in DRAWN.into_iter().rev() {
            let drawn: Vec<&Quantity> = self.quantities_of(rank).collect();
            let together = if drawn.len() * combinations.len() > MOST_LINES { 1 } else { drawn.len().max(1) };
            for drawn in drawn.chunks(together) {
                let line = |quantity, (rest, rows): &(String, Vec<_>)| {
                    let names = [rest.clone(), of_sound(quantity)].into_iter().filter(|name| !name.is_empty());
                    (names.collect::<Vec<_>>().join(", "), quantity, rows.clone())
                };
                let lines = drawn.iter().flat_map(|quantity| combinations.iter().map(|rest| line(*quantity, rest)));
                pictures.push(self.against(column, title, &lines.collect::<Vec<_>>(), true));
            }
        }
        pictures
    }

    /// Draws named quantities of some combinations against the factor `column`.
    fn against(&self, column: usize, title: &str, all: &[Drawn<'_>], joined: bool) -> String {
        let (factor, labels) = (&self.factors[column], self.labels(column));
        let (x, places) = axis_of(factor, &labels);
        let point = |quantity: &Quantity, row: &RepeatedRow| {
            let (mean, _) = row.drawn.get(quantity)?;
            let place = labels.iter().position(|label| *label == row.values[column])?;
            // An interval that is not known, as that of a single run, has no bar: a width of 0 draws none.
            Some((places[place], mean.mean, mean.interval.unwrap_or(0.0)))
        };
        let series = all.iter().map(|(name, quantity, rows)| PointSeries {
            name,
            points: rows.iter().filter_map(|row| point(quantity, row)).collect(),
            joined,
        });
        let series: Vec<PointSeries<'_>> = series.collect();
        let ends = series.iter().flat_map(|series| &series.points);
        let ends = ends.flat_map(|&(_, level, half)| [level - half, level + half]);
        let drawn = DRAWN.into_iter().find(|(rank, ..)| all.iter().any(|(_, quantity, _)| quantity.rank.0 == *rank));
        let (_, short, axis) = drawn.unwrap_or(DRAWN[0]);
        // Where bands are missing the axis names those that are present, and says where they may matter.
        let bands =
            all.iter().flat_map(|(_, quantity, rows)| rows.iter().filter_map(move |row| row.drawn.get(*quantity)));
        let range = |bands: &MeanBands| {
            let bound = if bands.lower_bound { ", at least" } else { "" };
            Some(format!("{}{bound}", bands.range.as_ref()?))
        };
        let ranges: BTreeSet<String> = bands.filter_map(|(_, bands)| range(bands.as_ref()?)).collect();
        let axis = [axis.to_owned()].into_iter().chain(ranges).collect::<Vec<_>>().join(", ");
        let y = Axis::linear_around(axis, ends);
        PointPlot { title: &format!("{short} against {factor}: {title}"), x, y, series }.to_svg()
    }

    /// Quantities of a rank that can be drawn: levels that cannot be compared cannot.
    fn quantities_of(&self, rank: u8) -> impl Iterator<Item = &Quantity> {
        let is_drawn = move |quantity: &&Quantity| self.rows.iter().any(|row| row.drawn.contains_key(*quantity));
        self.quantities.iter().filter(move |quantity| quantity.rank.0 == rank).filter(is_drawn)
    }

    /// Distinct values of a factor, in the order of the rows.
    fn labels(&self, column: usize) -> Vec<&str> {
        let mut seen = BTreeSet::new();
        self.rows.iter().map(|row| row.values[column].as_str()).filter(|label| seen.insert(*label)).collect()
    }
}

/// Axis for a factor, and the positions of its values: numbers at their value, words side by side.
fn axis_of(factor: &str, labels: &[&str]) -> (Axis, Vec<f64>) {
    let numbers: Option<Vec<f64>> = labels.iter().map(|label| label.parse().ok()).collect();
    match numbers {
        Some(places) => (Axis::linear_around(factor, places.iter().copied()), places),
        None => (Axis::of_words(factor, labels), (0..labels.len()).map(|index| index as f64).collect()),
    }
}
