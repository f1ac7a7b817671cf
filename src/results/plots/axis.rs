//! Axes: range, scale, ticks and their labels.

use std::ops::Range;

/// One axis of a picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Axis {
    /// Title of the axis, unit included.
    pub title: String,
    scale: Scale,
    pub range: Range<f64>,
    /// Values, and labels of those that have one.
    ticks: Vec<(f64, Option<String>)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scale {
    Linear,
    Logarithmic,
    /// Words at 0, 1, 2, ...
    Words,
}

/// Approximate number of labelled ticks.
const TICKS: f64 = 8.0;
/// Labels with more decimals, or of larger values, are written with a power of ten.
const MOST_DECIMALS: usize = 3;
const LARGEST_PLAIN: f64 = 1e6;

impl Axis {
    /// Linear axis over exactly `range`, in the unit that `title` names. An empty or non-finite range becomes 0 to 1.
    pub(crate) fn linear(title: impl Into<String>, range: Range<f64>) -> Self {
        let range = sound(range, 0.0..1.0);
        let step = round_step((range.end - range.start) / TICKS);
        let largest = range.start.abs().max(range.end.abs());
        let label = |value: f64| Some(with_minus(multiple(value + 0.0, step, largest)));
        let ticks = multiples(&range, step).map(|value| (value, label(value))).collect();
        Self { title: title.into(), scale: Scale::Linear, range, ticks }
    }

    /// Linear axis that holds all of `values` with a margin, ends on round numbers and does not magnify the rounding of
    /// a constant.
    pub(crate) fn linear_around(title: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        let Range { start: low, end: high } = extent(values);
        let margin = 0.05 * (high - low).max(1e-6 * high.abs().max(low.abs())).max(f64::MIN_POSITIVE);
        let step = round_step((high - low + 2.0 * margin) / TICKS);
        let range = ((low - margin) / step).floor() * step..((high + margin) / step).ceil() * step;
        Self::linear(title, range)
    }

    /// Logarithmic axis over exactly `range`; 1 to 10 unless both ends are positive.
    pub(crate) fn logarithmic(title: impl Into<String>, range: Range<f64>) -> Self {
        let range = sound(range, 1.0..10.0);
        let range = if range.start > 0.0 { range } else { 1.0..10.0 };
        let [first, last] = [range.start, range.end].map(|end| end.log10().floor() as i32);
        let labelled: &[i32] = match last - first {
            ..=1 => &[1, 2, 3, 5],
            2..=3 => &[1, 2, 5],
            _ => &[1],
        };
        let inside = range.start * (1.0 - 1e-12)..=range.end * (1.0 + 1e-12);
        let tick = |exponent: i32, digit: i32| {
            let value = f64::from(digit) * 10.0_f64.powi(exponent);
            (value, labelled.contains(&digit).then(|| power_label(value)))
        };
        let ticks = (first..=last).flat_map(|exponent| (1..10).map(move |digit| tick(exponent, digit)));
        let ticks = ticks.filter(|(value, _)| inside.contains(value)).collect();
        Self { title: title.into(), scale: Scale::Logarithmic, range, ticks }
    }

    /// Logarithmic axis from `below` times the smallest to `above` times the largest of `values`.
    pub(crate) fn logarithmic_around(
        title: impl Into<String>,
        values: impl IntoIterator<Item = f64>,
        [below, above]: [f64; 2],
    ) -> Self {
        let Range { start: low, end: high } = extent(values);
        Self::logarithmic(title, below * low..above * high)
    }

    /// Linear axis with given ticks: values, and labels of those that have one.
    pub(super) fn with_ticks(
        title: impl Into<String>,
        range: Range<f64>,
        ticks: impl IntoIterator<Item = (f64, Option<String>)>,
    ) -> Self {
        Self { title: title.into(), scale: Scale::Linear, range, ticks: ticks.into_iter().collect() }
    }

    /// Axis of words, at 0, 1, 2, ...
    pub(crate) fn of_words(title: impl Into<String>, words: &[&str]) -> Self {
        let ticks = words.iter().enumerate().map(|(place, word)| (place as f64, Some((*word).to_owned())));
        Self { scale: Scale::Words, ..Self::with_ticks(title, -0.5..words.len() as f64 - 0.5, ticks) }
    }

    pub(super) fn is_of_words(&self) -> bool {
        self.scale == Scale::Words
    }

    /// Label of a value: that of its tick, else the number.
    pub(super) fn label(&self, value: f64) -> String {
        let tick = self.ticks.iter().find(|(tick, _)| tick.total_cmp(&value).is_eq());
        tick.and_then(|(_, label)| label.clone()).unwrap_or_else(|| four_digits(value))
    }

    /// Position of a value as a part of the axis' length; outside \[0, 1\] for values beyond its ends. NaN where a
    /// logarithm has no value.
    pub(super) fn place(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear | Scale::Words => (value - self.range.start) / (self.range.end - self.range.start),
            Scale::Logarithmic if value > 0.0 => {
                (value / self.range.start).ln() / (self.range.end / self.range.start).ln()
            }
            Scale::Logarithmic => f64::NAN,
        }
    }

    /// Value at a part of the axis' length, the inverse of [`Self::place`].
    pub(super) fn value(&self, place: f64) -> f64 {
        let Range { start, end } = self.range;
        match self.scale {
            Scale::Linear | Scale::Words => start + place * (end - start),
            Scale::Logarithmic => start * (end / start).powf(place),
        }
    }

    /// Positions and labels of the labelled ticks.
    pub(super) fn ticks(&self) -> impl Iterator<Item = (f64, &str)> {
        self.ticks.iter().filter_map(|(value, label)| Some((self.place(*value), label.as_deref()?)))
    }

    /// Positions of ticks without a label.
    pub(super) fn minor_ticks(&self) -> impl Iterator<Item = f64> + '_ {
        self.ticks.iter().filter(|(_, label)| label.is_none()).map(|(value, _)| self.place(*value))
    }
}

/// A value with four digits.
pub fn four_digits(value: f64) -> String {
    let size = value.abs();
    if (1e-3..1e6).contains(&size) {
        let decimals = (3 - size.log10().floor() as i32).max(0) as usize;
        with_minus(format!("{value:.decimals$}"))
    } else if size > 0.0 {
        with_minus(format!("{value:.3e}"))
    } else {
        "0".to_owned()
    }
}

/// Smallest and largest finite value; 0 and 1 if there is none.
pub(super) fn extent(values: impl IntoIterator<Item = f64>) -> Range<f64> {
    let (low, high) = values
        .into_iter()
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low <= high { low..high } else { 0.0..1.0 }
}

fn sound(range: Range<f64>, otherwise: Range<f64>) -> Range<f64> {
    let usable = range.start.is_finite() && range.end.is_finite() && range.start < range.end;
    if usable { range } else { otherwise }
}

/// Smallest of 1, 2, 2.5, 5 times a power of ten that is not below `step`.
fn round_step(step: f64) -> f64 {
    let power = 10.0_f64.powf(step.log10().floor());
    [1.0, 2.0, 2.5, 5.0, 10.0]
        .into_iter()
        .map(|digit| digit * power)
        .find(|&round| round >= step * (1.0 - 1e-9))
        .unwrap_or(step)
}

/// A multiple of a step, with the digits that all multiples up to a largest one have; with a power of ten where it
/// would be too long for the room beside an axis.
fn multiple(value: f64, step: f64, largest: f64) -> String {
    let power = |of: f64| (of * (1.0 + 1e-9)).log10().floor() as i32;
    // 2.5 times a power of ten has a digit more than the others.
    let mantissa = step * 10.0_f64.powi(-power(step));
    let more = i32::from((mantissa - mantissa.round()).abs() > 0.01);
    let decimals = (more - power(step)).max(0) as usize;
    if decimals <= MOST_DECIMALS && largest < LARGEST_PLAIN {
        format!("{value:.decimals$}")
    } else if value.abs() < 0.5 * step {
        "0".to_owned()
    } else {
        let digits = (power(value.abs().max(step)) - power(step) + more).max(0) as usize;
        format!("{value:.digits$e}")
    }
}

fn multiples(range: &Range<f64>, step: f64) -> impl Iterator<Item = f64> + use<> {
    let first = (range.start / step - 1e-6).ceil() as i64;
    let last = (range.end / step + 1e-6).floor() as i64;
    (first..=last).map(move |count| count as f64 * step)
}

fn power_label(value: f64) -> String {
    if (0.009..20_000.0).contains(&value) {
        // Enough digits for 0.01, none for integers.
        let text = format!("{value:.2}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        with_minus(format!("{value:.0e}"))
    }
}

/// Replaces hyphens by minus signs.
fn with_minus(text: String) -> String {
    text.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.ticks().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(labels(&Axis::linear("", 0.0..3.0)), ["0.0", "0.5", "1.0", "1.5", "2.0", "2.5", "3.0"]);
        assert_eq!(labels(&Axis::linear("", -60.0..-10.0)), ["−60", "−50", "−40", "−30", "−20", "−10"]);
        assert_eq!(
            labels(&Axis::linear("", -0.2..0.2)),
            ["−0.20", "−0.15", "−0.10", "−0.05", "0.00", "0.05", "0.10", "0.15", "0.20"]
        );
        assert_eq!(
            labels(&Axis::linear("", 0.0..0.17)),
            ["0.000", "0.025", "0.050", "0.075", "0.100", "0.125", "0.150"]
        );
        assert_eq!(
            labels(&Axis::logarithmic("", 20.0..5000.0)),
            ["20", "50", "100", "200", "500", "1000", "2000", "5000"]
        );
        assert_eq!(labels(&Axis::logarithmic("", 1e-9..1e-2)).first(), Some(&"1e−9"));
    }

    #[test]
    fn labels_of_extreme_values_fit_beside_the_axis() {
        let small = ["−4e−10", "−3e−10", "−2e−10", "−1e−10", "0"];
        assert_eq!(labels(&Axis::linear("", -4e-10..3e-10))[..5], small);
        assert_eq!(labels(&Axis::linear("", 0.0..1.7e7))[..3], ["0", "2.5e6", "5.0e6"]);
        for exponent in -40..40 {
            for range in [0.0..1.0, -0.4..0.9, 3.3..4.0, 0.0..0.17] {
                let scale = 10.0_f64.powi(exponent);
                let axis = Axis::linear("", scale * range.start..scale * range.end);
                let shown = labels(&axis);
                assert!(shown.iter().all(|label| label.chars().count() <= 8), "{shown:?}");
                assert!(shown.windows(2).all(|pair| pair[0] != pair[1]), "{shown:?}");
            }
        }
    }

    #[test]
    fn values_have_four_digits() {
        let shown = [0.0, 12.345_67, -0.012_345, 123_456.7, 1.5e-7, 2.0e9].map(four_digits);
        assert_eq!(shown, ["0", "12.35", "−0.01235", "123457", "1.500e−7", "2.000e9"]);
    }

    #[test]
    fn nonsense_ranges_become_some_axis() {
        for range in [0.0..0.0, 1.0..0.0, f64::NAN..1.0, 0.0..f64::INFINITY] {
            assert_eq!(Axis::linear("", range.clone()).range, 0.0..1.0);
            assert_eq!(Axis::logarithmic("", range).range, 1.0..10.0);
        }
        assert_eq!(Axis::logarithmic("", -1.0..1.0).range, 1.0..10.0);
        assert_eq!(extent([f64::NAN]), 0.0..1.0);
        assert_eq!(extent([f64::NAN, 3.0, f64::NEG_INFINITY]), 3.0..3.0);
    }

    #[test]
    fn places_and_values_are_each_others_inverse() {
        for axis in [Axis::linear("", -2.0..6.0), Axis::logarithmic("", 0.5..50.0)] {
            for place in [0.0, 0.1, 0.5, 0.73, 1.0] {
                assert!((axis.place(axis.value(place)) - place).abs() < 1e-12, "{axis:?} {place}");
            }
        }
    }

    proptest! {
        #[test]
        fn an_axis_around_values_has_a_sensible_number_of_ticks(a in -1e9f64..1e9, b in -1e9f64..1e9) {
            let axis = Axis::linear_around("", [a, b]);
            for value in [a, b] {
                prop_assert!((0.0..=1.0).contains(&axis.place(value)));
            }
            let ticks = axis.ticks().count();
            prop_assert!((3..=12).contains(&ticks), "{} ticks over {:?}", ticks, axis.range);
        }
    }
}
