//! Factors of a sweep, each a key of the scene and its values, and designs of experiments, which choose the
//! combinations of several factors' values that are run.

use std::str::FromStr;

use crate::scene::Setting;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Most values of one range: a typing error must not start a million runs.
const MOST_VALUES: usize = 1000;
/// Complaint about a range without steps.
const NEEDS_STEPS: &str = "a grid needs steps, FROM..TO:STEP; --latin-hypercube does without";

/// A key of a scene that is varied.
#[derive(Clone, Debug)]
pub(crate) struct Factor {
    /// The key, such as `road.seed`.
    pub key: String,
    /// Values of the key.
    pub values: Values,
}

#[derive(Clone, Debug)]
pub(crate) enum Values {
    /// A list, in this order.
    Listed(Vec<Setting>),
    /// Any between two ends.
    Between(f64, f64),
}

/// A range from one number to another, as given.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Range {
    /// Equal steps, both ends included; as text, so that whole numbers stay whole.
    Steps(Vec<String>),
    /// Without steps.
    Between(f64, f64),
}

impl Values {
    /// Values of a list, as given.
    ///
    /// # Errors
    /// In words, for a range without steps.
    pub(crate) fn texts(&self) -> Result<Vec<&str>, String> {
        match self {
            Self::Listed(values) => Ok(values.iter().map(Setting::value).collect()),
            Self::Between(..) => Err(NEEDS_STEPS.to_owned()),
        }
    }
}

impl Factor {
    /// Parses a setting whose value is a [`Range`] or a list `A,B,C`; `None` for any other, such as a text in quotes.
    ///
    /// # Errors
    /// In words, for an invalid range and for a value that is given twice.
    pub(crate) fn of(setting: &Setting) -> Result<Option<Self>, String> {
        let key = setting.key();
        let Some(text) = setting.plain_text() else { return Ok(None) };
        let listed = |texts: &mut dyn Iterator<Item = &str>| -> Result<Values, String> {
            let mut seen = Vec::new();
            let one = |text: &str| {
                if seen.iter().any(|earlier| earlier == text) {
                    return Err(format!("--set {key}: {text} is given twice"));
                }
                seen.push(text.to_owned());
                Setting::parse(&format!("{key}={text}"))
            };
            texts.map(one).collect::<Result<_, _>>().map(Values::Listed)
        };
        let values = match Range::parse(text) {
            Some(range) => match range.map_err(|problem| format!("--set {key}: {problem}"))? {
                Range::Steps(texts) => listed(&mut texts.iter().map(String::as_str))?,
                Range::Between(from, to) => Values::Between(from, to),
            },
            None => match parts(text).as_slice() {
                [_] => return Ok(None),
                several => listed(&mut several.iter().copied())?,
            },
        };
        Ok(Some(Self { key: key.to_owned(), values }))
    }

    /// True if its values are draws of the same quantity, over which results are averaged: those of a seed.
    pub(crate) fn repeats(&self) -> bool {
        is_seed(&self.key)
    }

    /// Value at a place in \[0, 1): a list's values have equal shares of it, in their order.
    ///
    /// # Errors
    /// As [`Setting::parse`].
    pub(crate) fn at(&self, place: f64) -> Result<Setting, String> {
        match &self.values {
            Values::Listed(values) => {
                let index = (place * values.len() as f64) as usize;
                Ok(values[index.min(values.len() - 1)].clone())
            }
            Values::Between(from, to) => {
                // Six digits distinguish any two values of a design and can be read.
                let value = shortest(from + place * (to - from), 6);
                Setting::parse(&format!("{}={value:?}", self.key))
            }
        }
    }
}

/// Splits a list at its commas, except for those within quotes and brackets.
fn parts(text: &str) -> Vec<&str> {
    let (mut quote, mut escaped, mut depth) = (None, false, 0_usize);
    let is_comma = |sign: char| {
        let within = quote.is_some() || depth > 0;
        match (quote, sign) {
            (Some('"'), '\\') => {
                escaped = !escaped;
                return false;
            }
            (Some(open), sign) if open == sign && !escaped => quote = None,
            (None, '"' | '\'') => quote = Some(sign),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth = depth.saturating_sub(1),
            _ => {}
        }
        escaped = false;
        sign == ',' && !within
    };
    text.split(is_comma).map(str::trim).collect()
}

pub(crate) fn is_seed(key: &str) -> bool {
    key.rsplit('.').next() == Some("seed")
}

impl Range {
    /// Parses `FROM..TO:STEP`, or `FROM..TO`: of whole numbers in steps of 1, otherwise without steps. `None` for a
    /// text that does not begin with a number and two points; the inner `Err` is the problem in words.
    pub(crate) fn parse(text: &str) -> Option<Result<Self, String>> {
        let (from, rest) = text.split_once("..")?;
        let start = number(from).ok()?;
        Some(Self::from(from.trim(), start, rest))
    }

    fn from(from: &str, start: f64, rest: &str) -> Result<Self, String> {
        let (to, step) = rest.split_once(':').map_or((rest, None), |(to, step)| (to, Some(step)));
        let end = number(to)?;
        let whole = |text: &str| i64::from_str(text.trim()).is_ok();
        if end < start {
            return Err(format!("the range ends at {end}, before it begins at {start}"));
        }
        let width = match step {
            Some(step) => number(step)?,
            None if whole(from) && whole(to) => 1.0,
            None => return Ok(Self::Between(start, end)),
        };
        if width <= 0.0 {
            return Err(format!("the step {width} is not a positive number"));
        }
        // An end that is missed by rounding only is included.
        let steps = ((end - start) / width * (1.0 + 1e-12) + 1e-9).floor();
        if steps >= MOST_VALUES as f64 {
            return Err(format!("{} values are more than {MOST_VALUES}: choose a larger step", steps + 1.0));
        }
        let whole = whole(from) && step.is_none_or(whole);
        let text = |index: u32| {
            let value = shortest(start + f64::from(index) * width, 12);
            if whole { format!("{value}") } else { format!("{value:?}") }
        };
        Ok(Self::Steps((0..=steps as u32).map(text).collect()))
    }
}

/// Parses a finite number.
fn number(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let reported = || format!("\"{text}\" is not a number: a range is FROM..TO:STEP, such as 50..130:10");
    text.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(reported)
}

/// Decimal number of `digits` significant digits nearest to a value.
fn shortest(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

pub(crate) const MOST_POINTS: usize = 100_000;

/// How the factors' values are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Design {
    /// Every value of each with every value of all others, the last factor's innermost.
    #[default]
    Grid,
    /// Latin hypercube: each factor's range is cut into as many equal parts as there are points, and each part is used
    /// once (McKay, Beckman and Conover, Technometrics 21, 1979). Seeds are not drawn, but repeated at every point.
    LatinHypercube {
        /// Number of points, repeated seeds not counted.
        points: usize,
        /// Seed of the random numbers.
        seed: u64,
    },
}

impl Design {
    /// Settings of each point; a single point without settings where there is no factor.
    ///
    /// # Errors
    /// In words, for a factor that is given twice, one without steps on a grid, and too many points.
    pub(crate) fn points(self, factors: &[Factor]) -> Result<Vec<Vec<Setting>>, String> {
        for (index, factor) in factors.iter().enumerate() {
            if factors[..index].iter().any(|earlier| earlier.key == factor.key) {
                return Err(format!("--set {}: given twice", factor.key));
            }
        }
        match self {
            Self::Grid => grid(vec![Vec::new()], factors),
            Self::LatinHypercube { points, seed } => {
                let (repeated, drawn): (Vec<Factor>, Vec<Factor>) = factors.iter().cloned().partition(Factor::repeats);
                if drawn.is_empty() {
                    return Err(
                        "a Latin hypercube needs a factor beside seeds: --set rolling.speed_kmh=50.0..130".into()
                    );
                }
                bounded(points)?;
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                let columns: Vec<Vec<f64>> = drawn.iter().map(|_| column(points, &mut random)).collect();
                let point = |index: usize| {
                    drawn.iter().zip(&columns).map(|(factor, column)| factor.at(column[index])).collect()
                };
                grid((0..points).map(point).collect::<Result<_, _>>()?, &repeated)
            }
        }
    }
}

/// Every one of `points` combined with every combination of the factors.
fn grid(mut points: Vec<Vec<Setting>>, factors: &[Factor]) -> Result<Vec<Vec<Setting>>, String> {
    for factor in factors {
        let Values::Listed(values) = &factor.values else {
            return Err(format!("--set {}: {NEEDS_STEPS}", factor.key));
        };
        bounded(points.len().saturating_mul(values.len()))?;
        let with = |point: &Vec<Setting>| -> Vec<Vec<Setting>> {
            values.iter().map(|value| point.iter().chain([value]).cloned().collect()).collect()
        };
        points = points.iter().flat_map(with).collect();
    }
    Ok(points)
}

fn bounded(points: usize) -> Result<(), String> {
    match points {
        0 => Err("a design of no points".to_owned()),
        1..=MOST_POINTS => Ok(()),
        _ => Err(format!("{points} points are more than {MOST_POINTS}: make several sweeps of them")),
    }
}

/// One place in each of `points` equal parts of \[0, 1), the parts in random order (Fisher and Yates).
fn column(points: usize, random: &mut impl Rng) -> Vec<f64> {
    let mut parts: Vec<usize> = (0..points).collect();
    for last in (1..points).rev() {
        parts.swap(last, random.random_range(0..=last));
    }
    parts.into_iter().map(|part| (part as f64 + random.random::<f64>()) / points as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Option<Vec<String>>, String> {
        let found = Factor::of(&Setting::parse(text)?)?;
        Ok(found.map(|factor| match factor.values {
            Values::Listed(values) => values.iter().map(|value| value.value().to_owned()).collect(),
            Values::Between(from, to) => vec![format!("between {from} and {to}")],
        }))
    }

    #[test]
    fn ranges_and_lists_are_factors_and_all_else_is_a_setting() {
        let listed = |text: &str| of(text).unwrap().unwrap();
        assert_eq!(listed("road.seed=1..3"), ["1", "2", "3"]);
        assert_eq!(listed("rolling.speed_kmh=50..79:10"), ["50", "60", "70"]);
        assert_eq!(listed("x.y=1..1.3:0.1"), ["1.0", "1.1", "1.2", "1.3"], "the end is there in spite of rounding");
        assert_eq!(listed("x.y=-0.2..0:0.1"), ["-0.2", "-0.1", "0.0"]);
        assert_eq!(listed("contact.tread=elastic, bedding"), ["elastic", "bedding"]);
        assert_eq!(listed("x.y=1,2.5"), ["1", "2.5"]);
        assert_eq!(listed("title=\"a,b\",\"c\""), ["a,b", "c"], "a comma in quotes parts nothing");
        assert_eq!(listed("title=\"a\\\",b\", 'c,d'"), ["a\\\",b", "'c,d'"]);
        assert_eq!(listed("x=[1, 2], [3, 4]"), ["[1, 2]", "[3, 4]"]);
        assert_eq!(listed("x.y=1.0..2"), ["between 1 and 2"]);
        for text in ["x.y=80", "title=\"a, b\"", "road.file=../a.dat", "numerics.preset=draft", "x=[1, 2]", "x=a..b"] {
            assert_eq!(of(text), Ok(None), "{text}");
        }
    }

    #[test]
    fn bad_ranges_are_answered() {
        for (text, word) in [
            ("x.y=130..50:10", "before it begins"),
            ("x.y=50..130:0", "not a positive number"),
            ("x.y=50..130:-10", "not a positive number"),
            ("x.y=50..fast:10", "\"fast\""),
            ("x.y=50..130:", "\"\""),
            ("x.y=1..inf:1", "\"inf\""),
            ("x.y=1..100000", "larger step"),
            ("x.y=50,80,50", "given twice"),
        ] {
            let error = of(text).unwrap_err();
            assert!(error.contains(word) && error.contains("--set x.y"), "{text}: {error}");
        }
    }

    fn factors(texts: &[&str]) -> Vec<Factor> {
        texts.iter().map(|text| Factor::of(&Setting::parse(text).unwrap()).unwrap().unwrap()).collect()
    }

    fn values(points: &[Vec<Setting>]) -> Vec<String> {
        points.iter().map(|point| point.iter().map(Setting::value).collect::<Vec<_>>().join(" ")).collect()
    }

    #[test]
    fn a_grid_has_every_combination() {
        let points = Design::Grid.points(&factors(&["a.b=1,2", "road.seed=1..3"])).unwrap();
        assert_eq!(values(&points), ["1 1", "1 2", "1 3", "2 1", "2 2", "2 3"]);
        assert_eq!(Design::Grid.points(&[]).unwrap().len(), 1);
        for (texts, word) in [
            (vec!["a.b=1.0..2"], "needs steps"),
            (vec!["a.b=1,2", "a.b=3,4"], "given twice"),
            (vec!["a.b=1..1000", "a.c=1..1000"], "100000"),
        ] {
            let error = Design::Grid.points(&factors(&texts)).unwrap_err();
            assert!(error.contains(word), "{error}");
        }
    }

    #[test]
    fn a_latin_hypercube_takes_every_part_of_every_factor_once() {
        let factors = factors(&["a.b=10.0..20", "a.c=1..5", "road.seed=1..2"]);
        let design = Design::LatinHypercube { points: 10, seed: 7 };
        let points = design.points(&factors).unwrap();
        assert_eq!(points.len(), 20);
        let column = |index: usize| -> Vec<f64> {
            points.iter().step_by(2).map(|point| point[index].value().parse().unwrap()).collect()
        };
        let mut parts: Vec<i32> = column(0).iter().map(|value| (value - 10.0).floor() as i32).collect();
        parts.sort_unstable();
        assert_eq!(parts, (0..10).collect::<Vec<_>>());
        let mut steps = column(1);
        steps.sort_by(f64::total_cmp);
        assert_eq!(steps, [1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 5.0, 5.0]);
        assert_eq!(values(&points), values(&design.points(&factors).unwrap()), "a seed is a design");
        let other = Design::LatinHypercube { points: 10, seed: 8 };
        assert_ne!(values(&points), values(&other.points(&factors).unwrap()));
        assert!(other.points(&self::factors(&["road.seed=1..2"])).unwrap_err().contains("beside seeds"));
        assert!(Design::LatinHypercube { points: 0, seed: 8 }.points(&factors).unwrap_err().contains("no points"));
    }
}
