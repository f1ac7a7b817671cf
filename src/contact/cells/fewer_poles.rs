//! Fewer poles for the part of the history that the pass predicts.
//!
//! The pass over the poles hands on the displacements by forces later than a block; the earlier ones are summed with
//! the exact first weights. Most of a wave's poles are there for its highest frequencies, which have decayed by then.
//! So, for a fixed time step and for each wave:
//! 1. the displacements by every pole after the block, by instant of the force and of the displacement, are sampled on
//!    the unit circle relative to max(|H|, 0.003 max |H|), the measure of the fit;
//! 2. poles are taken one by one (orthogonal matching pursuit: Pati, Rezaiifar & Krishnaprasad 1993, Proc. 27th
//!    Asilomar Conf., 40), each time the one that explains most of the remainder, pairs as a whole;
//! 3. once the remainder is small, residues of those taken are fitted, and they are enough if the largest error is
//!    within the tolerance at every sample.
//!
//! Poles stay where they are: stable ones stay stable.

use std::f64::consts::PI;

use num_complex::Complex64;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::storage::{CacheKind, Cached, Format};
use crate::time_rule::TimeRule;
use crate::tyre::poles::WaveModes;
use crate::tyre::poles::pole_model::PoleModel;

/// Samples between the lowest frequency and the highest, in addition to those at the poles' frequencies.
const SAMPLES: usize = 16;
/// Lowest frequency in parts of the highest.
const LOWEST: f64 = 1e-4;
/// Part of |H|'s maximum below which an error is not relative to |H|.
const FLOOR: f64 = 3e-3;
/// Part of the tolerance that the root mean square of the errors has to be below before the largest is examined.
const ROOT_MEAN_SQUARE: f64 = 0.5;
/// Part of a column's square below which its remainder is rounding.
const DEPENDENT: f64 = 1e-12;

/// Poles that predict the waves of a ring, which all of its poles do to within a tolerance.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct FewerPoles {
    /// `None` for a two-step rule.
    pub(super) model: Option<PoleModel>,
    pub(super) tolerance: f64,
}

impl FewerPoles {
    /// Poles of a model's waves for displacements by forces of more than `passed` steps ago; of a wave that can do
    /// without none, all.
    pub(super) fn of(model: &PoleModel, rule: TimeRule, time_step: f64, passed: usize, tolerance: f64) -> Self {
        let waves = 0..if rule.looks_back() { 0 } else { model.len() };
        let reduced = |wave: usize| fewer_poles(&model.wave(wave), rule, time_step, passed, tolerance);
        let reduced: Vec<Option<FewerModes>> = waves.into_par_iter().map(reduced).collect();
        let mut all = PoleModel::new(1);
        for (wave, reduced) in reduced.iter().enumerate() {
            let WaveModes { poles, residues, odd, .. } = reduced.as_ref().map_or(model.wave(wave), FewerModes::modes);
            all.push(poles, [&[residues.to_vec()], &[odd.to_vec()]], 0);
        }
        Self { model: (!reduced.is_empty()).then(|| all.complete()), tolerance }
    }
}

impl Cached for FewerPoles {
    const KIND: CacheKind = CacheKind {
        extension: "fewer",
        format: Format { magic: b"TWAVEFEW", version: 1, name: "poles of contact cells for a time step" },
    };

    fn is_valid(&self) -> bool {
        self.model.as_ref().is_none_or(PoleModel::is_valid)
    }
}

/// Poles and residues of a wave.
#[derive(Clone, Debug)]
struct FewerModes {
    poles: Vec<Complex64>,
    residues: Vec<Complex64>,
    odd: Vec<Complex64>,
    pairs: usize,
}

impl FewerModes {
    fn modes(&self) -> WaveModes<'_> {
        let Self { poles, residues, odd, pairs } = self;
        WaveModes { poles, residues, odd, pairs: *pairs, constant: 0.0 }
    }
}

/// Displacements of poles at samples: real unknowns, of a pair two.
struct Columns {
    /// Unknowns of each pole.
    places: Vec<Vec<usize>>,
    /// Sample by sample: value of each unknown.
    values: Vec<Vec<Complex64>>,
}

impl Columns {
    /// Displacements by forces of more than `passed` steps ago, relative to |H|; `None` for a rule whose steps are no
    /// maps of one state.
    fn new(modes: &WaveModes<'_>, rule: TimeRule, time_step: f64, passed: usize) -> Option<Self> {
        let maps: Option<Vec<_>> = modes.poles.iter().map(|&pole| rule.step_map(pole, time_step)).collect();
        let maps = maps?;
        let even = (0..SAMPLES).map(|n| PI * LOWEST.powf(n as f64 / (SAMPLES - 1) as f64));
        let angles: Vec<f64> = even.chain(maps.iter().map(|map| map.whole.arg().abs())).collect();
        let sizes: Vec<f64> =
            angles.iter().map(|angle| modes.evaluate(Complex64::new(0.0, angle / time_step)).norm()).collect();
        let floor = FLOOR * sizes.iter().fold(0.0, |largest: f64, size| largest.max(*size));
        let mut unknowns = 0;
        let places = (0..maps.len()).map(|index| {
            let first = unknowns;
            unknowns += if index < modes.pairs { 2 } else { 1 };
            (first..unknowns).collect()
        });
        let places: Vec<Vec<usize>> = places.collect();
        let stages = rule.stages();
        let mut values = Vec::with_capacity(angles.len() * stages * stages);
        for (angle, size) in angles.iter().zip(&sizes) {
            let zeta = Complex64::cis(-angle);
            for (input, output) in (0..stages).flat_map(|input| (0..stages).map(move |output| (input, output))) {
                let mut row = Vec::with_capacity(unknowns);
                for (index, map) in maps.iter().enumerate() {
                    let scale = modes.multiplicity(index) / size.max(floor);
                    let response = scale * map.outputs[output] * map.inputs[input] * map.whole.powu(passed as u32);
                    let [upper, lower] =
                        [response / (1.0 - map.whole * zeta), response.conj() / (1.0 - map.whole.conj() * zeta)];
                    if index < modes.pairs {
                        row.push(0.5 * (upper + lower));
                        row.push(Complex64::new(0.0, 0.5) * (upper - lower));
                    } else {
                        row.push(upper);
                    }
                }
                values.push(row);
            }
        }
        Some(Self { places, values })
    }

    /// Scalar products of all columns: real numbers in rows of the unknowns.
    fn products(&self, unknowns: usize) -> Vec<Vec<f64>> {
        let mut products = vec![vec![0.0; unknowns]; unknowns];
        for row in &self.values {
            for (a, products) in row.iter().zip(&mut products) {
                for (b, product) in row.iter().zip(products) {
                    *product += a.re * b.re + a.im * b.im;
                }
            }
        }
        products
    }

    /// Largest error at a sample for a difference of the unknowns' values.
    fn largest(&self, difference: &[f64]) -> f64 {
        let error = |row: &Vec<Complex64>| {
            row.iter().zip(difference).fold(Complex64::ZERO, |sum, (value, part)| sum + part * value).norm()
        };
        self.values.iter().map(error).fold(0.0, f64::max)
    }
}

/// Poles that predict a wave's displacements by forces of more than `passed` steps ago to within `tolerance`; `None`
/// where none can be left out, or for a two-step rule.
fn fewer_poles(
    modes: &WaveModes<'_>,
    rule: TimeRule,
    time_step: f64,
    passed: usize,
    tolerance: f64,
) -> Option<FewerModes> {
    let columns = Columns::new(modes, rule, time_step, passed)?;
    let flat = |residues: &[Complex64]| -> Vec<f64> {
        let parts = residues.iter().zip(&columns.places);
        parts.flat_map(|(residue, places)| [residue.re, residue.im].into_iter().take(places.len())).collect()
    };
    let targets: Vec<Vec<f64>> =
        [modes.residues, modes.odd].into_iter().filter(|residues| !residues.is_empty()).map(flat).collect();
    let products = columns.products(targets.first()?.len());
    let mut residual = Residual::new(&products, &targets);
    let mut taken: Vec<usize> = Vec::new();
    let enough = (ROOT_MEAN_SQUARE * tolerance).powi(2) * columns.values.len() as f64;
    while taken.len() + 1 < modes.poles.len() {
        let pole = residual.best(&columns.places, &taken)?;
        columns.places[pole].iter().for_each(|&place| residual.take(place));
        taken.push(pole);
        if residual.square > enough {
            continue;
        }
        let places: Vec<usize> = taken.iter().flat_map(|&pole| columns.places[pole].iter().copied()).collect();
        let fitted: Vec<Vec<f64>> = targets.iter().map(|target| fit(&products, &places, target)).collect();
        let error = |(target, fitted): (&Vec<f64>, &Vec<f64>)| {
            columns.largest(&target.iter().zip(fitted).map(|(a, b)| a - b).collect::<Vec<_>>())
        };
        if targets.iter().zip(&fitted).map(error).fold(0.0, f64::max) > tolerance {
            continue;
        }
        taken.sort_unstable();
        let number = |fitted: &Vec<f64>, pole: usize| match columns.places[pole][..] {
            [re, im] => Complex64::new(fitted[re], fitted[im]),
            _ => fitted[columns.places[pole][0]].into(),
        };
        let residues = |fitted: &Vec<f64>| taken.iter().map(|&pole| number(fitted, pole)).collect();
        return Some(FewerModes {
            poles: taken.iter().map(|&pole| modes.poles[pole]).collect(),
            residues: residues(&fitted[0]),
            odd: fitted.get(1).map(residues).unwrap_or_default(),
            pairs: taken.iter().filter(|&&pole| pole < modes.pairs).count(),
        });
    }
    None
}

/// Remainder that the unknowns taken so far do not explain: Schur complements.
struct Residual {
    products: Vec<Vec<f64>>,
    /// Squares of the columns at the beginning.
    squares: Vec<f64>,
    /// Scalar products of columns and targets.
    targets: Vec<Vec<f64>>,
    /// Square of the remainder of the targets.
    square: f64,
}

impl Residual {
    fn new(products: &[Vec<f64>], targets: &[Vec<f64>]) -> Self {
        let times = |target: &Vec<f64>| products.iter().map(|row| dot(row, target)).collect::<Vec<f64>>();
        let right: Vec<Vec<f64>> = targets.iter().map(times).collect();
        let square = targets.iter().zip(&right).map(|(target, right)| dot(target, right)).sum();
        let squares = products.iter().enumerate().map(|(place, row)| row[place]).collect();
        Self { products: products.to_vec(), squares, targets: right, square }
    }

    /// Pole that explains most of the remainder; `None` where none explains any.
    fn best(&self, places: &[Vec<usize>], taken: &[usize]) -> Option<usize> {
        let gain = |places: &[usize]| -> f64 {
            let explained = |target: &Vec<f64>| match *places {
                [a, b] => {
                    let (aa, ab, bb) = (self.products[a][a], self.products[a][b], self.products[b][b]);
                    let determinant = aa * bb - ab * ab;
                    let (ta, tb) = (target[a], target[b]);
                    if determinant > DEPENDENT * self.squares[a] * self.squares[b] {
                        (bb * ta * ta - 2.0 * ab * ta * tb + aa * tb * tb) / determinant
                    } else {
                        0.0
                    }
                }
                [a] if self.products[a][a] > DEPENDENT * self.squares[a] => target[a] * target[a] / self.products[a][a],
                _ => 0.0,
            };
            self.targets.iter().map(explained).sum()
        };
        let gains = places.iter().enumerate().filter(|(pole, _)| !taken.contains(pole));
        let best = gains.map(|(pole, places)| (pole, gain(places))).max_by(|a, b| a.1.total_cmp(&b.1));
        best.filter(|(_, gain)| *gain > 0.0).map(|(pole, _)| pole)
    }

    /// Takes an unknown: its contribution is removed from the others and the targets.
    fn take(&mut self, place: usize) {
        let row = self.products[place].clone();
        let pivot = row[place];
        for target in &mut self.targets {
            let part = target[place] / pivot;
            self.square -= part * target[place];
            target.iter_mut().zip(&row).for_each(|(target, product)| *target -= part * product);
        }
        for products in &mut self.products {
            let part = products[place] / pivot;
            products.iter_mut().zip(&row).for_each(|(product, entry)| *product -= part * entry);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Values of the unknowns at `places` that come closest to a target, zero elsewhere: Cholesky's factorisation.
fn fit(products: &[Vec<f64>], places: &[usize], target: &[f64]) -> Vec<f64> {
    let size = places.len();
    let mut factor = vec![vec![0.0; size]; size];
    let mut right: Vec<f64> = places.iter().map(|&place| dot(&products[place], target)).collect();
    for i in 0..size {
        for j in 0..=i {
            let rest = products[places[i]][places[j]] - dot(&factor[i][..j], &factor[j][..j]);
            factor[i][j] = if i == j { rest.sqrt() } else { rest / factor[j][j] };
        }
        right[i] = (right[i] - dot(&factor[i][..i], &right[..i])) / factor[i][i];
    }
    for i in (0..size).rev() {
        right[i] /= factor[i][i];
        for j in 0..i {
            right[j] -= factor[i][j] * right[i];
        }
    }
    let mut values = vec![0.0; target.len()];
    places.iter().zip(right).for_each(|(&place, value)| values[place] = value);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::Cache;

    const TIME_STEP: f64 = 1e-4;
    const PASSED: usize = 4;

    /// Displacements at the instants up to the fifth step after a force at a stage, and from there on.
    fn late(modes: &WaveModes<'_>, residues: &[Complex64], rule: TimeRule, stage: usize) -> [Vec<f64>; 2] {
        let mut response = vec![0.0; 400 * rule.stages()];
        for (index, (&pole, &residue)) in modes.poles.iter().zip(residues).enumerate() {
            let weights = rule.coefficients(pole, modes.multiplicity(index) * residue, TIME_STEP);
            rule.impulse_response(weights.into(), stage, &mut response);
        }
        // The first is one instant after the force.
        let late = response.split_off((PASSED + 1) * rule.stages() - stage - 1);
        [response, late]
    }

    #[test]
    fn fewer_poles_foretell_the_same_after_a_block() {
        let number = Complex64::new;
        let poles = [number(-4e3, 9e3), number(-3e4, 6e4), number(-9e4, 2e5)]
            .into_iter()
            .chain([-8.0, -120.0, -900.0, -5e3, -2.2e4, -2.3e4, -9e4, -4e5].map(Complex64::from));
        let poles: Vec<Complex64> = poles.collect();
        let residue = |pole: &Complex64| -0.05 * pole * if pole.im > 0.0 { number(1.0, 0.4) } else { 1.0.into() };
        let residues: Vec<Complex64> = poles.iter().map(residue).collect();
        let odd: Vec<Complex64> = residues.iter().enumerate().map(|(n, r)| 0.1 * (n as f64).sin() * r).collect();
        for (rule, tolerance) in
            [(TimeRule::Sdirk2, 1e-3), (TimeRule::Sdirk2, 1e-5), (TimeRule::Sdirk3, 1e-4), (TimeRule::Bdf1, 1e-4)]
        {
            let modes = WaveModes { poles: &poles, residues: &residues, odd: &odd, pairs: 3, constant: 0.0 };
            let fewer = fewer_poles(&modes, rule, TIME_STEP, PASSED, tolerance).unwrap();
            let found = fewer.modes();
            let order = |modes: &WaveModes<'_>| modes.poles.len() + modes.pairs;
            println!("{rule:?}, {tolerance:e}: {} of {} poles", order(&found), order(&modes));
            assert!(order(&found) < order(&modes) && found.odd.len() == found.poles.len());
            for stage in 0..rule.stages() {
                for (exact_residues, other) in [(modes.residues, found.residues), (modes.odd, found.odd)] {
                    let [early, exact] = late(&modes, exact_residues, rule, stage);
                    let [_, late] = late(&found, other, rule, stage);
                    let scale: f64 = early.iter().chain(&exact).map(|u| u.abs()).sum();
                    let missed: f64 = exact.iter().zip(&late).map(|(a, b)| (a - b).abs()).sum();
                    // Even and odd parts are compared with the even one; a sum of errors is more than any wave of
                    // them.
                    assert!(missed < 40.0 * tolerance * scale, "{rule:?}, {tolerance:e}: {:e}", missed / scale);
                }
            }
        }
        // The waves of a model, one that can do without some poles and one that cannot, from the cache on disk too.
        let mut model = PoleModel::new(1);
        for last in [poles.len(), 1] {
            model.push(&poles[..last], [&[residues[..last].to_vec()], &[odd[..last].to_vec()]], 7);
        }
        let (model, folder) = (model.complete(), tempfile::tempdir().unwrap());
        let of = |rule: TimeRule| FewerPoles::of(&model, rule, TIME_STEP, PASSED, 1e-4);
        let found = of(TimeRule::Sdirk2);
        let fewer = fewer_poles(&model.wave(0), TimeRule::Sdirk2, TIME_STEP, PASSED, 1e-4).unwrap();
        let of_waves = [0, 1].map(|wave| found.model.as_ref().unwrap().wave(wave));
        assert_eq!(of_waves, [fewer.modes(), model.wave(1)]);
        let cache = Cache::at(folder.path().to_owned(), u64::MAX);
        cache.store(&[1; 32], &found).unwrap();
        assert_eq!(cache.load(&[1; 32]).unwrap(), Some(Ok(found)));
        assert!(of(TimeRule::Bdf2).model.is_none());
        let modes = WaveModes { poles: &poles[..1], residues: &residues[..1], odd: &[], pairs: 1, constant: 0.0 };
        assert!(fewer_poles(&modes, TimeRule::Sdirk2, TIME_STEP, PASSED, 1e-4).is_none());
        assert!(fewer_poles(&modes, TimeRule::Bdf2, TIME_STEP, PASSED, 1e-4).is_none());
    }
}
