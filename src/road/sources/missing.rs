//! Values that mark missing heights.
//!
//! 1. Cells that are empty, NaN, or a word that instruments and programs write for nothing; and what the scene names.
//! 2. Where the scene names nothing: a number that recurs exactly is none where it lies farther from all others than
//!    these from each other, and either steeply beside them or as far as no road has it ([`outlying`]). One that lies
//!    among them, but every time far from its neighbours ([`isolated`]), or less far outside them ([`bound`]), is
//!    refused: only the user knows. All are reported by name where the scene names other numbers.

use std::collections::{BTreeMap, BTreeSet};

use super::conditioning::STEEPEST;
use crate::road::file_fault::FileFault;
use crate::road::report::RoadNote;
use crate::road::texture::rms;
use crate::scene::MissingHeight;

/// Words for a missing value, in lower case.
const WORDS: [&str; 31] = [
    "",
    "nan",
    "-nan",
    "+nan",
    "nan(ind)",
    "-nan(ind)",
    "-nan(snan)",
    "1.#qnan",
    "-1.#qnan",
    "1.#ind",
    "-1.#ind",
    "na",
    "n/a",
    "#n/a",
    "n.a.",
    "null",
    "(null)",
    "nil",
    "none",
    "bad",
    "invalid",
    "missing",
    "nodata",
    "no data",
    "no_data",
    "dropout",
    "-",
    "--",
    "---",
    "*",
    "#value!",
];
/// Relative difference within which numbers in the scene and in the file are equal: that of single precision.
const EQUAL: f64 = 1e-6;
/// Least number of occurrences of a number outside all others, and of one among them.
const FEWEST: [usize; 2] = [3, 10];
/// Most distinct numbers beside steep steps that are considered; more of them are not dropouts, the road is steep
/// everywhere.
const MOST_NUMBERS: usize = 1_000_000;
/// Fewest heights that differ, of a texture: plates, edges and coarse steps have fewer.
const FEWEST_LEVELS: usize = 30;
/// Distance from all others at which no road has heights that recur exactly \[m\].
const FARTHEST: f64 = 0.02;
/// Least step of heights beside a number for none \[m\]: heights of few digits, finely sampled, step as steeply.
const LEAST_RISE: f64 = 2e-3;
/// Rows beside each other are so many mean steps apart at most.
const WIDEST_STEP: f64 = 2.0;

/// True if a cell marks a missing height: a usual word for it, or one that the scene names. Any other word is most
/// likely a damaged number.
pub(super) fn is_word_for_none(cell: &str, named: Option<&[MissingHeight]>) -> bool {
    let cell = cell.trim();
    let names = |missing: &MissingHeight| matches!(missing, MissingHeight::Word(word) if word == cell);
    WORDS.contains(&cell.to_lowercase().as_str()) || named.unwrap_or_default().iter().any(names)
}

/// Notes the words that marked missing heights, if any did.
pub(super) fn note_words(words: BTreeMap<String, usize>, notes: &mut Vec<RoadNote>) {
    if !words.is_empty() {
        notes.push(RoadNote::WordsForMissing { words });
    }
}

/// Sets missing heights to NaN. `heights` are row-major \[m\], `place` is the position of a row \[m\], `unit` the
/// file's unit \[m\], `named` what the scene names.
///
/// # Errors
/// [`FileFault::StandsForNone`] where only the user can decide.
pub(super) fn mark(
    heights: &mut [f64],
    columns: usize,
    place: impl Fn(usize) -> f64,
    unit: f64,
    named: Option<&[MissingHeight]>,
    notes: &mut Vec<RoadNote>,
) -> Result<(), FileFault> {
    let is = |value: f64| move |height: f64| is_named(height, value);
    for missing in named.unwrap_or_default() {
        if let MissingHeight::Number(value) = *missing {
            notes.push(RoadNote::NamedMissing { value, count: clear(heights, is(value * unit)) });
        }
    }
    // An empty array: every number is a height.
    if named.is_some_and(<[MissingHeight]>::is_empty) {
        return Ok(());
    }
    let in_file = |value: f64| significant(value / unit);
    if named.is_some() {
        if let Some((value, count)) = outlying(heights, columns, &place).or_else(|| doubtful(heights, columns, &place))
        {
            notes.push(RoadNote::NotNamedMissing { value: in_file(value), count });
        }
        return Ok(());
    }
    while let Some((value, _)) = outlying(heights, columns, &place) {
        let count = clear(heights, is(value));
        notes.push(RoadNote::TakenForMissing { value: in_file(value), count });
    }
    match doubtful(heights, columns, &place) {
        Some((value, count)) => Err(FileFault::StandsForNone { value: in_file(value), count }),
        None => Ok(()),
    }
}

/// How often each number that a scene names stands among heights \[m\].
pub(super) fn named_counts(heights: &[f64], unit: f64, named: Option<&[MissingHeight]>) -> Vec<(f64, usize)> {
    let count = |value: f64| heights.iter().filter(|height| is_named(**height, value * unit)).count();
    let numbers = named.unwrap_or_default().iter().filter_map(|missing| match missing {
        MissingHeight::Number(value) => Some(*value),
        MissingHeight::Word(_) => None,
    });
    numbers.map(|value| (value, count(value))).collect()
}

/// True if a height is a number, up to its rounding.
fn is_named(height: f64, value: f64) -> bool {
    (height - value).abs() <= EQUAL * value.abs()
}

/// Sets heights to NaN; returns their number.
fn clear(heights: &mut [f64], is_missing: impl Fn(f64) -> bool) -> usize {
    let mut count = 0;
    for height in heights.iter_mut().filter(|height| is_missing(**height)) {
        *height = f64::NAN;
        count += 1;
    }
    count
}

/// Rounds a number to the digits of single precision, which removes the rounding of the unit's factor.
fn significant(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// The lowest of some numbers, how often it occurs, and the next one.
struct Lowest {
    value: f64,
    count: usize,
    next: f64,
}

impl Lowest {
    fn of(numbers: impl Iterator<Item = f64>) -> Self {
        let none = Self { value: f64::INFINITY, count: 0, next: f64::INFINITY };
        numbers.filter(|number| !number.is_nan()).fold(none, |lowest, number| {
            if number < lowest.value {
                Self { value: number, count: 1, next: lowest.value }
            } else if number > lowest.value {
                Self { next: lowest.next.min(number), ..lowest }
            } else {
                Self { count: lowest.count + 1, ..lowest }
            }
        })
    }
}

/// Returns the same bits for equal heights: zero has one sign.
fn bits(height: f64) -> u64 {
    (height + 0.0).to_bits()
}

/// Calls with each two measured heights of a column in rows beside each other, as bits, and whether a road is less
/// steep than between them. Rows at the same place, and on either side of a gap, are none.
fn each_pair(heights: &[f64], columns: usize, place: &impl Fn(usize) -> f64, mut call: impl FnMut([u64; 2], bool)) {
    let Some(last) = (heights.len() / columns).checked_sub(1) else { return };
    let widest = WIDEST_STEP * (place(last) - place(0)) / last as f64;
    for row in 1..=last {
        let distance = place(row) - place(row - 1);
        if distance <= 0.0 || distance > widest {
            continue;
        }
        let rows = heights[(row - 1) * columns..(row + 1) * columns].split_at(columns);
        for (before, after) in rows.0.iter().zip(rows.1).filter(|(before, after)| !(*before - *after).is_nan()) {
            let rise = (after - before).abs();
            call([bits(*before), bits(*after)], rise >= LEAST_RISE && rise >= STEEPEST * distance);
        }
    }
}

/// Returns the lowest or highest height and how often it occurs, where it recurs, is farther from all others than these
/// are from each other, and either farther than on any road or steeper than a road on every side.
fn outlying(heights: &[f64], columns: usize, place: &impl Fn(usize) -> f64) -> Option<(f64, usize)> {
    let lowest = Lowest::of(heights.iter().copied());
    let highest = Lowest::of(heights.iter().map(|height| -height));
    let found = |this: &Lowest, other: &Lowest, sign: f64| {
        let (apart, others) = (this.next - this.value, -other.value - this.next);
        let is_far = others > 0.0 && others.is_finite() && apart > others;
        (this.count >= FEWEST[0] && is_far).then_some((sign * this.value + 0.0, apart, this.count))
    };
    let (value, apart, count) = found(&lowest, &highest, 1.0).or_else(|| found(&highest, &lowest, -1.0))?;
    let (mut sides, mut steep) = (0_usize, 0_usize);
    each_pair(heights, columns, place, |[before, after], is_steep| {
        if (before == bits(value)) != (after == bits(value)) {
            sides += 1;
            steep += usize::from(is_steep);
        }
    });
    (apart > FARTHEST || (sides > 0 && steep == sides)).then_some((value, count))
}

fn doubtful(heights: &[f64], columns: usize, place: &impl Fn(usize) -> f64) -> Option<(f64, usize)> {
    bound(heights).or_else(|| isolated(heights, columns, place))
}

/// Returns the lowest or highest height and how often it occurs, where it recurs in less than half of the heights, and
/// the others are those of a texture, farther away than their root mean square.
fn bound(heights: &[f64]) -> Option<(f64, usize)> {
    [1.0, -1.0].into_iter().find_map(|sign| {
        let lowest = Lowest::of(heights.iter().map(|height| sign * height));
        let value = sign * lowest.value + 0.0;
        if lowest.count < FEWEST[1] || lowest.next.is_infinite() {
            return None;
        }
        let is_other = |height: &f64| !height.is_nan() && bits(*height) != bits(value);
        let others: Vec<f64> = heights.iter().copied().filter(is_other).collect();
        let mut levels = BTreeSet::new();
        let is_texture = others.iter().any(|height| levels.insert(bits(*height)) && levels.len() == FEWEST_LEVELS);
        let is_far = lowest.next - lowest.value > rms(&others);
        (is_texture && is_far && lowest.count < others.len()).then_some((value, lowest.count))
    })
}

/// A number and its number of occurrences, if it recurs and every one of its runs along the road is steeper than a road
/// on either side.
fn isolated(heights: &[f64], columns: usize, place: &impl Fn(usize) -> f64) -> Option<(f64, usize)> {
    let mut sides = BTreeMap::new();
    let (mut steep, mut all) = (0, 0);
    each_pair(heights, columns, place, |pair, is_steep| {
        all += 1;
        steep += usize::from(is_steep);
        if sides.len() < MOST_NUMBERS && is_steep {
            pair.into_iter().for_each(|number| *sides.entry(number).or_insert(0_usize) += 1);
        }
    });
    sides.retain(|_, sides| *sides >= FEWEST[1]);
    // Steep everywhere: another unit, not missing heights.
    if sides.is_empty() || sides.len() >= MOST_NUMBERS || 2 * steep > all {
        return None;
    }
    each_pair(heights, columns, place, |[before, after], is_steep| {
        // A side that is not steep: the number is a height.
        if before != after && !is_steep {
            sides.remove(&before);
            sides.remove(&after);
        }
    });
    let mut counts: BTreeMap<u64, usize> = sides.into_keys().map(|number| (number, 0)).collect();
    for height in heights {
        if let Some(count) = counts.get_mut(&bits(*height)) {
            *count += 1;
        }
    }
    let recurring = counts.into_iter().filter(|(_, count)| *count >= FEWEST[1]);
    recurring.min_by_key(|(_, count)| *count).map(|(number, count)| (f64::from_bits(number), count))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A texture in millimetres, 0.5 mm apart, with a number in every `every`th place.
    fn with(value: f64, every: usize) -> Vec<f64> {
        let texture = |i: usize| 0.8e-3 * (0.3 * i as f64).sin() + 0.5e-3 * (0.11 * i as f64).cos();
        (0..1000).map(|i| if i % every == 7 { 1e-3 * value } else { texture(i) }).collect()
    }

    fn marked(heights: &mut [f64], named: Option<&[MissingHeight]>) -> Result<Vec<RoadNote>, FileFault> {
        let mut notes = Vec::new();
        mark(heights, 1, |row| 0.5e-3 * row as f64, 1e-3, named, &mut notes).map(|()| notes)
    }

    fn marked_at(spacing: f64, heights: &mut [f64]) -> Result<Vec<RoadNote>, FileFault> {
        let mut notes = Vec::new();
        mark(heights, 1, |row| spacing * row as f64, 1e-3, None, &mut notes).map(|()| notes)
    }

    fn missing(heights: &[f64]) -> usize {
        heights.iter().filter(|height| height.is_nan()).count()
    }

    #[test]
    fn a_number_far_outside_all_others_is_reported_as_missing() {
        for value in [-99.99, -9999.0, 999.0, 30.0] {
            let mut heights = with(value, 50);
            assert_eq!(marked(&mut heights, None).unwrap(), [RoadNote::TakenForMissing { value, count: 20 }]);
            assert_eq!(missing(&heights), 20);
        }
        // Two such numbers, one of them 0 within a texture that is offset by 30 mm.
        let mut heights = with(-9999.0, 50);
        heights.iter_mut().for_each(|height| *height += if *height > -1.0 { 0.03 } else { 0.0 });
        heights.iter_mut().skip(3).step_by(100).for_each(|height| *height = 0.0);
        let notes = marked(&mut heights, None).unwrap();
        let taken = |value, count| RoadNote::TakenForMissing { value, count };
        assert_eq!(notes, [taken(-9999.0, 20), taken(0.0, 10)]);
    }

    #[test]
    fn a_number_far_outside_is_found_at_any_spacing_and_beside_gaps() {
        for spacing in [0.5e-3, 0.05] {
            let mut heights = with(-99.99, 50);
            heights[58..90].fill(f64::NAN);
            let taken = RoadNote::TakenForMissing { value: -99.99, count: 20 };
            assert_eq!(marked_at(spacing, &mut heights).unwrap(), [taken], "{spacing}");
        }
        // Zeros of both signs, and a step across a gap between the rows.
        let mut heights = with(0.0, 50);
        heights.iter_mut().for_each(|height| *height += if height.abs() > 0.0 { 0.01 } else { 0.0 });
        heights.iter_mut().skip(7).step_by(100).for_each(|height| *height = -0.0);
        let mut notes = Vec::new();
        let place = |row: usize| 0.5e-3 * (row + if row > 57 { 100 } else { 0 }) as f64;
        mark(&mut heights, 1, place, 1e-3, None, &mut notes).unwrap();
        assert_eq!(notes, [RoadNote::TakenForMissing { value: 0.0, count: 20 }]);
    }

    #[test]
    fn a_number_that_is_always_alone_is_refused_until_named() {
        // A hill of 200 mm: no number lies outside it.
        let hill = |heights: &mut [f64], value: f64| {
            let missing = 1e-3 * value;
            heights.iter_mut().enumerate().filter(|(_, height)| height.to_bits() != missing.to_bits()).for_each(
                |(i, height)| {
                    *height += 2e-4 * i as f64 - 0.1;
                },
            );
        };
        let mut heights = with(-99.99, 50);
        hill(&mut heights, -99.99);
        let refused = marked(&mut heights, None).unwrap_err();
        assert!(
            matches!(refused, FileFault::StandsForNone { value, count: 20 } if (value + 99.99).abs() < 1e-9),
            "{refused}"
        );
        assert!(refused.to_string().contains("road.missing = -99.99"), "{refused}");
        let named = [MissingHeight::Number(-99.99)];
        assert_eq!(
            marked(&mut heights.clone(), Some(&named)).unwrap(),
            [RoadNote::NamedMissing { value: -99.99, count: 20 }]
        );
        assert_eq!(marked(&mut heights.clone(), Some(&[])).unwrap(), []);
        assert_eq!(missing(&heights), 0);
        let other = [MissingHeight::Number(-9999.0)];
        assert_eq!(
            marked(&mut heights, Some(&other)).unwrap(),
            [
                RoadNote::NamedMissing { value: -9999.0, count: 0 },
                RoadNote::NotNamedMissing { value: -99.99, count: 20 }
            ]
        );
    }

    #[test]
    fn a_number_outside_the_others_is_refused_in_runs_and_on_coarse_lattices() {
        for (value, spacing, run) in [(-3.5, 0.5e-3, 40), (-3.5, 0.5e-3, 10), (4.0, 2e-3, 1), (-10.0, 5e-3, 5)] {
            let mut heights = with(0.0, usize::MAX);
            heights.iter_mut().enumerate().filter(|(i, _)| i / run % 20 == 3).for_each(|(_, height)| {
                *height = 1e-3 * value;
            });
            let refused = marked_at(spacing, &mut heights.clone()).unwrap_err();
            let is_value = |found: f64| (found - value).abs() < 1e-9;
            assert!(matches!(refused, FileFault::StandsForNone { value, .. } if is_value(value)), "{refused}");
            heights.iter_mut().for_each(|height| *height = 1e-3 * (1e3 * *height - value).round());
            assert_eq!(marked_at(5e-3, &mut heights).unwrap(), [], "in coarse steps");
        }
        // Plates: with a cleat, with a trapezoid, and half of it rough.
        let trapezoid = |i: usize| 5e-4 * (i as f64 - 300.0).min(420.0 - i as f64).clamp(0.0, 40.0);
        let rough = |i: usize| if i < 501 { -5e-3 } else { 1e-3 * (0.7 * i as f64).sin() };
        let cleat = |i: usize| if i / 50 == 3 { 0.01 } else { 0.0 };
        let plates: [&dyn Fn(usize) -> f64; 3] = [&cleat, &trapezoid, &rough];
        for height in plates {
            let mut plate: Vec<f64> = (0..1000).map(height).collect();
            assert_eq!(marked_at(5e-3, &mut plate).unwrap(), []);
        }
    }

    #[test]
    fn texture_of_few_digits_has_no_number_for_none() {
        let mut heights: Vec<f64> = with(0.0, usize::MAX).iter().map(|height| (height * 1e4).round() / 1e4).collect();
        assert_eq!(marked(&mut heights, None).unwrap(), []);
        assert_eq!(missing(&heights), 0);
        // Slots of one depth in a plane, as wide as they are far from steep.
        for (spacing, depth) in [(0.5e-3, -0.5e-3), (0.02, -2e-3)] {
            let slot = |row: usize| if row % 6 < 3 { 1e-16 * (row % 3) as f64 } else { depth };
            let mut slots: Vec<f64> = (0..200).map(slot).collect();
            assert_eq!(marked_at(spacing, &mut slots).unwrap(), []);
        }
        // Tenths of millimetres every 0.02 mm: each step is steeper than 3 : 1.
        let fine = |i: usize| (0.012 * i as f64).sin() + 0.4 * (0.0046 * i as f64).sin();
        let mut heights: Vec<f64> = (0..10_000).map(|i| 1e-4 * (10.0 * fine(i)).round()).collect();
        assert_eq!(marked_at(0.02e-3, &mut heights).unwrap(), []);
        let mut plane = vec![0.0; 100];
        assert_eq!(marked(&mut plane, None).unwrap(), []);
    }

    #[test]
    fn words_for_none_are_known_and_damaged_numbers_are_not() {
        for word in ["", " ", "NaN", "-nan(ind)", "N/A", "Bad", "NULL", "NoData", "---", "-"] {
            assert!(is_word_for_none(word, None), "{word}");
        }
        for word in ["0.3x", "1,5", "wet", "O.3", "inf"] {
            assert!(!is_word_for_none(word, None), "{word}");
        }
        assert!(is_word_for_none("wet", Some(&[MissingHeight::Word("wet".into())])));
    }
}
