//! Designs of experiments: which combinations of several factors' values are run.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::scene::Setting;
use crate::study::sweep::factor::{Factor, NEEDS_STEPS, Values};

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
