//! Skewness and kurtosis of a made road: a monotone transformation of Gaussian heights, and its effect on their
//! correlation.
//!
//! The heights are rms g(x), x Gaussian of variance 1 and g(x) = (sinh((asinh x + e)/d) - mean)/deviation (Jones and
//! Pewsey, *Biometrika* 96 (2009) 761-780): e skews, d > 1 shortens the tails, d < 1 lengthens them, and the order of
//! heights stays the same.
//!
//! 1. For a given d the skewness grows with e, and along a line of given skewness the kurtosis falls with d: two nested
//!    bisections find both. Means are sums of the trapezoidal rule, exact to rounding for functions that decay like a
//!    Gaussian.
//! 2. If the Gaussian heights have the correlation r, the transformed ones have the sum of a_k^2 r^k, a_k being the
//!    coefficients of g in normalised Hermite polynomials, the sum of their squares 1.

use crate::road::error::RoadError;

/// Ends of the trapezoidal sums, in standard deviations.
const END: f64 = 9.0;
/// Step of the sums.
const STEP: f64 = 0.05;
/// Ends of the table, in standard deviations of the Gaussian. Heights beyond, one in two million, are those at its
/// ends: no gap of a skewed road is deeper than 8 (skewness -1) to 12 rms heights (-1.85), and the moments stay.
const BOUND: f64 = 5.0;
/// Number of Hermite coefficients; the remainder of their squares is added to the last.
const TERMS: usize = 16;
/// Intervals of the table per standard deviation: linear between, within 1e-5 of the rms height.
const PER_UNIT: f64 = 512.0;
/// Least and greatest d: at the least the kurtosis is above 30, at the greatest the function is all but asinh x.
const TAILS: [f64; 2] = [0.5, 30.0];
/// Greatest |e|: a larger one moves the sinh into its exponential part, where only the scale changes.
const LARGEST_SHIFT: f64 = 20.0;
/// Halvings of an interval.
const HALVINGS: usize = 60;

/// A monotone transformation of standard Gaussian numbers into numbers of mean 0, variance 1 and given skewness and
/// kurtosis.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct HeightShape {
    shift: f64,
    tail: f64,
    mean: f64,
    deviation: f64,
}

impl HeightShape {
    /// The transformation to a skewness and a kurtosis; `None` for 0 and 3, those of a Gaussian.
    ///
    /// # Errors
    /// [`RoadError::Moments`] for an impossible pair, with the range of the kurtosis for this skewness.
    pub(crate) fn new(skewness: f64, kurtosis: f64) -> Result<Option<Self>, RoadError> {
        if skewness.abs() <= 0.0 && (kurtosis - 3.0).abs() <= 0.0 {
            return Ok(None);
        }
        // 1. The range of d in which the skewness is possible, and with it that of the kurtosis.
        let nodes = nodes();
        let at = |tail: f64| skewed(&nodes, skewness, tail).map(|shift| (shift, moments(&nodes, shift, tail)));
        // With shorter tails the skewness may be out of reach: the greatest d found that has it.
        let (mut low, mut high) = (TAILS[0], TAILS[1]);
        let refused = |least: f64, most: f64| Err(RoadError::Moments { skewness, kurtosis, least, most });
        let Some((_, longest)) = at(low) else { return refused(f64::NAN, f64::NAN) };
        for _ in 0..HALVINGS {
            if at(high).is_some() {
                break;
            }
            high = 0.5 * (low + high);
        }
        let least = at(high).map_or(longest.kurtosis, |(_, shortest)| shortest.kurtosis);
        if !(least..=longest.kurtosis).contains(&kurtosis) {
            return refused(least, longest.kurtosis);
        }
        // 2. The kurtosis falls with d: bisection.
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match at(middle) {
                Some((_, found)) if found.kurtosis >= kurtosis => low = middle,
                _ => high = middle,
            }
        }
        let found = at(low).map(|(shift, of)| Self { shift, tail: low, mean: of.mean, deviation: of.deviation });
        found.map_or_else(|| refused(least, longest.kurtosis), |shape| Ok(Some(shape)))
    }

    pub(crate) fn at(&self, x: f64) -> f64 {
        (((x.asinh() + self.shift) / self.tail).sinh() - self.mean) / self.deviation
    }

    /// a_k^2, k = 1, 2, ...: for heights of correlation r that of the transformed ones is the sum of a_k^2 r^k.
    pub(crate) fn powers(&self) -> Vec<f64> {
        let mut sums = [0.0; TERMS];
        for [x, _, weight] in nodes() {
            // Normalised Hermite polynomials: h_k = (x h_(k-1) - sqrt(k - 1) h_(k-2))/sqrt k.
            let (mut before, mut now, value) = (1.0, x, weight * self.at(x));
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum += value * now;
                let k = k as f64 + 1.0;
                (before, now) = (now, (x * now - k.sqrt() * before) / (k + 1.0).sqrt());
            }
        }
        let mut squares: Vec<f64> = sums.iter().map(|a| a * a).collect();
        let rest = 1.0 - squares.iter().sum::<f64>();
        squares[TERMS - 1] += rest.max(0.0);
        squares
    }
}

/// g as a table, for heights in metres.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ShapeTable {
    /// Factor from heights to positions in the table \[1/m\].
    scale: f64,
    values: Vec<f64>,
}

impl ShapeTable {
    /// Table for heights of a given rms \[m\], which they keep.
    pub(super) fn new(shape: &HeightShape, rms: f64) -> Self {
        let count = (2.0 * BOUND * PER_UNIT) as usize;
        let values = (0..=count).map(|place| rms * shape.at(place as f64 / PER_UNIT - BOUND)).collect();
        Self { scale: PER_UNIT / rms, values }
    }

    /// Transforms heights \[m\].
    pub(super) fn apply(&self, heights: &mut [f64]) {
        let last = self.values.len() - 2;
        for height in heights {
            let place = (*height * self.scale + BOUND * PER_UNIT).clamp(0.0, 2.0 * BOUND * PER_UNIT);
            let index = (place as usize).min(last);
            let part = place - index as f64;
            *height = self.values[index] + part * (self.values[index + 1] - self.values[index]);
        }
    }
}

/// Nodes x of the trapezoidal sums, with asinh x and weights.
fn nodes() -> Vec<[f64; 3]> {
    let scale = STEP / (2.0 * std::f64::consts::PI).sqrt();
    let count = (END / STEP).round() as i32;
    (-count..=count).map(|i| f64::from(i) * STEP).map(|x| [x, x.asinh(), scale * (-0.5 * x * x).exp()]).collect()
}

/// Moments of a transformed Gaussian.
#[derive(Clone, Copy, Debug)]
struct Moments {
    mean: f64,
    deviation: f64,
    skewness: f64,
    kurtosis: f64,
}

fn moments(nodes: &[[f64; 3]], shift: f64, tail: f64) -> Moments {
    // Relative to the value at 0, so that a large shift causes no cancellation.
    let middle = (shift / tail).sinh();
    let values = || nodes.iter().map(|[_, asinh, weight]| (((asinh + shift) / tail).sinh() - middle, weight));
    let mean: f64 = values().map(|(value, weight)| weight * value).sum();
    let central = |power: i32| values().map(|(value, weight)| weight * (value - mean).powi(power)).sum::<f64>();
    let variance = central(2);
    Moments {
        mean: middle + mean,
        deviation: variance.sqrt(),
        skewness: central(3) / variance.powf(1.5),
        kurtosis: central(4) / (variance * variance),
    }
}

/// The shift that gives a skewness, if there is one: bisection, as the skewness grows with the shift.
fn skewed(nodes: &[[f64; 3]], skewness: f64, tail: f64) -> Option<f64> {
    let reach = LARGEST_SHIFT.min(300.0 * tail);
    let of = |shift: f64| moments(nodes, shift, tail).skewness;
    let (mut low, mut high) = (-reach, reach);
    if !(of(low)..=of(high)).contains(&skewness) {
        return None;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        *(if of(middle) < skewness { &mut low } else { &mut high }) = middle;
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The moments are recomputed from the function itself on a finer and wider grid.
    #[test]
    fn transformed_numbers_have_the_moments_asked_for() {
        for (skewness, kurtosis) in [(-0.5, 3.0), (-0.13, 2.4), (-0.3, 2.5), (0.4, 3.5), (0.0, 6.0), (-1.0, 5.0)] {
            let shape = HeightShape::new(skewness, kurtosis).unwrap().unwrap();
            let step = 1e-3;
            let mean = |power: i32| {
                let sum = |i: i32| {
                    let x = f64::from(i) * step;
                    (-0.5 * x * x).exp() * shape.at(x).powi(power)
                };
                (-10_000..=10_000).map(sum).sum::<f64>() * step / (2.0 * std::f64::consts::PI).sqrt()
            };
            assert!(mean(1).abs() < 1e-9 && (mean(2) - 1.0).abs() < 1e-9);
            assert!((mean(3) - skewness).abs() < 1e-6 && (mean(4) - kurtosis).abs() < 1e-6, "{} {}", mean(3), mean(4));
            assert!((shape.powers().iter().sum::<f64>() - 1.0).abs() < 1e-9);
            assert!((-800..800).all(|i| shape.at(f64::from(i + 1) * 0.01) > shape.at(f64::from(i) * 0.01)), "monotone");
        }
        assert_eq!(HeightShape::new(0.0, 3.0).unwrap(), None);
    }

    #[test]
    fn pairs_that_no_transformation_has_are_refused_with_the_range() {
        for (skewness, kurtosis) in [(0.0, 1.5), (1.5, 3.0), (-2.0, 4.0)] {
            let Err(RoadError::Moments { least, most, .. }) = HeightShape::new(skewness, kurtosis) else {
                panic!("{skewness}, {kurtosis} should be refused")
            };
            assert!(least > kurtosis && most > least, "{least} to {most}");
            assert!(HeightShape::new(skewness, least + 0.05).is_ok());
        }
    }

    #[test]
    fn the_table_is_the_function() {
        let shape = HeightShape::new(-0.5, 2.9).unwrap().unwrap();
        let table = ShapeTable::new(&shape, 5e-4);
        for i in -3000..3000 {
            let x = f64::from(i) * 2e-3;
            let mut height = [5e-4 * x];
            table.apply(&mut height);
            assert!((height[0] - 5e-4 * shape.at(x.clamp(-BOUND, BOUND))).abs() < 1e-5 * 5e-4, "{x}");
        }
    }
}
