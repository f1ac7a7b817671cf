//! Heights that stand for none.
//!
//! 1. Cells that are empty, NaN, or a word that instruments and programs write for nothing; and what the scene names.
//! 2. Where the scene names nothing: a number that recurs exactly is none where it lies so far outside all others as
//!    these reach, and steeply beside them ([`outlying`]). One that lies among them, but every time far from its neighbours ([`isolated`]), is
//!    refused: only the user knows. Both are told by name where the scene names other numbers.

use std::collections::BTreeMap;

use super::conditioning::STEEPEST;
use crate::road::file_fault::FileFault;
use crate::road::report::RoadNote;
use crate::scene::MissingHeight;

/// Words for no value, lower case.
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
/// Numbers in the scene and in the file are equal within this, that of single precision.
const EQUAL: f64 = 1e-6;
/// Fewest occurrences of a number outside all others, and of one among them.
const FEWEST: [usize; 2] = [3, 10];
/// Distinct numbers beside steep steps that are looked at; more of them are no dropouts, but steep everywhere.
const MOST_NUMBERS: usize = 1_000_000;

/// Tells whether a cell stands for no height: a usual word for it, or one that the scene names. Any other word is most
/// likely a damaged number.
pub(super) fn is_word_for_none(cell: &str, named: Option<&[MissingHeight]>) -> bool {
    let cell = cell.trim();
    let names = |missing: &MissingHeight| matches!(missing, MissingHeight::Word(word) if word == cell);
    WORDS.contains(&cell.to_lowercase().as_str()) || named.unwrap_or_default().iter().any(names)
}

/// Tells which words stood for missing heights, if any did.
pub(super) fn tell_words(words: BTreeMap<String, usize>, notes: &mut Vec<RoadNote>) {
    if !words.is_empty() {
        notes.push(RoadNote::WordsForMissing { words });
    }
}

/// Sets heights that stand for none to NaN. `heights` are row-major \[m\], `place` is where a row lies \[m\], `unit`
/// what one of the file's unit is \[m\], `named` what the scene names.
///
/// # Errors
/// [`FileFault::StandsForNone`], where only the user can know.
pub(super) fn mark(
    heights: &mut [f64],
    columns: usize,
    place: impl Fn(usize) -> f64,
    unit: f64,
    named: Option<&[MissingHeight]>,
    notes: &mut Vec<RoadNote>,
) -> Result<(), FileFault> {
    let is = |value: f64| move |height: f64| (height - value).abs() <= EQUAL * value.abs();
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
        if let Some((value, count)) = outlying(heights, columns, &place).or_else(|| isolated(heights, columns, &place))
        {
            notes.push(RoadNote::NotNamedMissing { value: in_file(value), count });
        }
        return Ok(());
    }
    while let Some((value, _)) = outlying(heights, columns, &place) {
        let count = clear(heights, is(value));
        notes.push(RoadNote::TakenForMissing { value: in_file(value), count });
    }
    match isolated(heights, columns, &place) {
        Some((value, count)) => Err(FileFault::StandsForNone { value: in_file(value), count }),
        None => Ok(()),
    }
}

/// Sets heights to NaN; returns how many.
fn clear(heights: &mut [f64], is_missing: impl Fn(f64) -> bool) -> usize {
    let mut count = 0;
    for height in heights.iter_mut().filter(|height| is_missing(**height)) {
        *height = f64::NAN;
        count += 1;
    }
    count
}

/// Returns a number to the digits that single precision has: a unit's factor leaves no others behind.
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

/// A measured height and its row.
type Height = (usize, f64);

/// Calls with each two measured heights that follow each other in a column.
fn each_pair(heights: &[f64], columns: usize, mut call: impl FnMut(Height, Height)) {
    for column in 0..columns {
        let rows = heights.iter().skip(column).step_by(columns).copied().enumerate();
        let mut last: Option<Height> = None;
        for height in rows.filter(|(_, height)| !height.is_nan()) {
            if let Some(last) = last {
                call(last, height);
            }
            last = Some(height);
        }
    }
}

/// Tells whether two heights are steeper than a road.
fn is_steep(place: &impl Fn(usize) -> f64, (a, low): Height, (b, high): Height) -> bool {
    let distance = place(b) - place(a);
    distance > 0.0 && (high - low).abs() >= STEEPEST * distance
}

/// Returns the lowest or highest height and how often it occurs, where it recurs, is farther from all others than these
/// are from each other, and every one of its runs along the road is steeper than a road on either side.
fn outlying(heights: &[f64], columns: usize, place: &impl Fn(usize) -> f64) -> Option<(f64, usize)> {
    let lowest = Lowest::of(heights.iter().copied());
    let highest = Lowest::of(heights.iter().map(|height| -height));
    let found = |this: &Lowest, other: &Lowest| {
        let others = -other.value - this.next;
        let is_far = others > 0.0 && others.is_finite() && this.next - this.value > others;
        (this.count >= FEWEST[0] && is_far).then_some(this.count)
    };
    let low = found(&lowest, &highest).map(|count| (lowest.value, count));
    let (value, count) = low.or_else(|| found(&highest, &lowest).map(|count| (-highest.value, count)))?;
    let mut is_apart = true;
    each_pair(heights, columns, |before, after| {
        let is_side = (before.1.to_bits() == value.to_bits()) != (after.1.to_bits() == value.to_bits());
        is_apart &= !is_side || is_steep(place, before, after);
    });
    is_apart.then_some((value, count))
}

/// Returns a number and how often it occurs, where it recurs and every one of its runs along the road is steeper than a
/// road on either side.
fn isolated(heights: &[f64], columns: usize, place: &impl Fn(usize) -> f64) -> Option<(f64, usize)> {
    let mut occurrences = BTreeMap::new();
    let (mut steep, mut all) = (0, 0);
    each_pair(heights, columns, |before, after| {
        let is_steep = is_steep(place, before, after);
        all += 1;
        steep += usize::from(is_steep);
        if occurrences.len() < MOST_NUMBERS && is_steep {
            *occurrences.entry(before.1.to_bits()).or_insert(0_usize) += 1;
            *occurrences.entry(after.1.to_bits()).or_insert(0) += 1;
        }
    });
    occurrences.retain(|_, sides| *sides >= FEWEST[1]);
    // Steep everywhere: another unit, not missing heights.
    if occurrences.is_empty() || occurrences.len() >= MOST_NUMBERS || 2 * steep > all {
        return None;
    }
    each_pair(heights, columns, |before, after| {
        // A side that is not steep: the number is a height.
        if before.1.to_bits() != after.1.to_bits() && !is_steep(place, before, after) {
            occurrences.remove(&before.1.to_bits());
            occurrences.remove(&after.1.to_bits());
        }
    });
    let counted = occurrences.into_keys().map(|bits| {
        let count = heights.iter().filter(|height| height.to_bits() == bits).count();
        (f64::from_bits(bits), count)
    });
    counted.filter(|(_, count)| *count >= FEWEST[1]).min_by_key(|(_, count)| *count)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a texture in millimetres, 0.5 mm apart, with a number in every `every`th place.
    fn with(value: f64, every: usize) -> Vec<f64> {
        let texture = |i: usize| 0.8e-3 * (0.3 * i as f64).sin() + 0.5e-3 * (0.11 * i as f64).cos();
        (0..1000).map(|i| if i % every == 7 { 1e-3 * value } else { texture(i) }).collect()
    }

    fn marked(heights: &mut [f64], named: Option<&[MissingHeight]>) -> Result<Vec<RoadNote>, FileFault> {
        let mut notes = Vec::new();
        mark(heights, 1, |row| 0.5e-3 * row as f64, 1e-3, named, &mut notes).map(|()| notes)
    }

    fn missing(heights: &[f64]) -> usize {
        heights.iter().filter(|height| height.is_nan()).count()
    }

    #[test]
    fn a_number_far_outside_all_others_is_taken_for_missing_and_told() {
        for value in [-99.99, -9999.0, 999.0, 30.0] {
            let mut heights = with(value, 50);
            assert_eq!(marked(&mut heights, None).unwrap(), [RoadNote::TakenForMissing { value, count: 20 }]);
            assert_eq!(missing(&heights), 20);
        }
        // Two of them, and a stand-off.
        let mut heights = with(-9999.0, 50);
        heights.iter_mut().for_each(|height| *height += if *height > -1.0 { 0.03 } else { 0.0 });
        heights.iter_mut().skip(3).step_by(100).for_each(|height| *height = 0.0);
        let notes = marked(&mut heights, None).unwrap();
        let taken = |value, count| RoadNote::TakenForMissing { value, count };
        assert_eq!(notes, [taken(-9999.0, 20), taken(0.0, 10)]);
    }

    #[test]
    fn a_number_among_the_others_that_is_always_alone_is_refused_until_it_is_named() {
        // A hill of 200 mm: nothing lies outside it.
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
    fn texture_of_few_digits_has_no_number_for_none() {
        let mut heights: Vec<f64> = with(0.0, usize::MAX).iter().map(|height| (height * 1e4).round() / 1e4).collect();
        assert_eq!(marked(&mut heights, None).unwrap(), []);
        assert_eq!(missing(&heights), 0);
        // Slots of one depth in a plane, as wide as they are far from steep.
        let slot = |row: usize| if row % 6 < 3 { 1e-16 * (row % 3) as f64 } else { -0.5e-3 };
        let mut slots: Vec<f64> = (0..200).map(slot).collect();
        assert_eq!(marked(&mut slots, None).unwrap(), []);
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
