//! Moments of the sums' weights above a cut-off wavenumber.
//!
//! M_j(n, k_c) = sum over p and odd m with k > k_c of (1/L) sinc^2(kx dx/2) (2/B) a_m^2 k^-(2j+1): geometry only, summed once. Explicit to some
//! sixteen lobes of the element and several hundred m; beyond, each sum is an integral over a smooth function:
//! sinc^2(kx dx/2) = sin^2(pi n/N)/(pi (n/N + p))^2 varies with p only as a power, and a_m^2 is replaced by its mean 2/(b ky)^2 (the oscillation
//! about it sums to order m^-3). Both substitute x = X/t and use Gauss-Legendre nodes on 0 < t < 1.
//!
//! Between two neighbouring cut-offs lies a band with its own Chebyshev moments (see [`super::half_space_bands`]).

use std::f64::consts::PI;

use rayon::prelude::*;

use super::half_space_bands::{self, BAND_TERMS};
use super::influence::Projection;
use super::surface_asymptote::TERMS;

/// Cut-off wavenumbers in steps of 2^(1/4).
#[derive(Clone, Debug, PartialEq)]
pub struct TailClasses {
    cut_offs: Vec<f64>,
}

/// Number of classes at most: a cut-off of 2^12 times the smallest.
const MOST_CLASSES: usize = 48;

impl TailClasses {
    /// Classes from `smallest` until `largest` is reached \[1/m\].
    pub fn new(smallest: f64, largest: f64) -> Self {
        let mut cut_offs = vec![smallest];
        let mut next = smallest;
        while next < largest && cut_offs.len() < MOST_CLASSES {
            next *= std::f64::consts::SQRT_2.sqrt();
            cut_offs.push(next);
        }
        Self { cut_offs }
    }

    /// The cut-off of a class \[1/m\].
    pub fn cut_off(&self, class: usize) -> f64 {
        self.cut_offs[class]
    }

    /// The largest cut-off \[1/m\].
    pub fn highest(&self) -> f64 {
        self.cut_offs[self.cut_offs.len() - 1]
    }

    /// The band of k^2 between the cut-offs of a class and the next \[1/m^2\].
    pub fn band(&self, class: usize) -> [f64; 2] {
        [self.cut_offs[class].powi(2), self.cut_offs[class + 1].powi(2)]
    }

    /// The smallest class at or above a wavenumber, and whether there is one.
    pub fn choose(&self, wavenumber: f64) -> (usize, bool) {
        let class = self.cut_offs.partition_point(|&cut_off| cut_off < wavenumber);
        if class < self.cut_offs.len() { (class, true) } else { (self.cut_offs.len() - 1, false) }
    }
}

/// M_j for n = 0..=N/2 and every class.
#[derive(Clone, Debug)]
pub struct Moments {
    classes: usize,
    values: Vec<[f64; TERMS]>,
    bands: Vec<[f64; BAND_TERMS]>,
}

/// Lobes of sinc^2 that are summed one by one, counted from the cut-off.
const EXPLICIT_ALIASES: i64 = 12;
/// Odd m summed one by one past the cut-off.
const EXPLICIT_LATERAL: usize = 240;

/// Eight-point Gauss-Legendre nodes and weights on 0..1.
const NODES: [(f64, f64); 8] = [
    (0.019_855_071_751_231_856, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_64, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_63),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_63),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];

impl Moments {
    /// Sums the moments for n = 0..=N/2.
    pub fn new(projection: &Projection, classes: &TailClasses) -> Self {
        let count = classes.cut_offs.len();
        let rows: Vec<_> =
            (0..=projection.elements / 2).into_par_iter().map(|n| for_wavenumber(projection, classes, n)).collect();
        let (mut values, mut bands) = (Vec::with_capacity(rows.len() * count), Vec::with_capacity(rows.len() * count));
        for (row_values, row_bands) in rows {
            values.extend(row_values);
            bands.extend(row_bands);
        }
        Self { classes: count, values, bands }
    }

    /// Chebyshev moments nu_j(n) of the band between a class and the next.
    pub fn band(&self, n: usize, class: usize) -> &[f64; BAND_TERMS] {
        &self.bands[n * self.classes + class]
    }

    /// M_j(n) of a class.
    pub fn of(&self, n: usize, class: usize) -> &[f64; TERMS] {
        &self.values[n * self.classes + class]
    }
}

/// Adds weight k^-(2j+1).
pub(super) fn add(moments: &mut [f64; TERMS], weight: f64, k_squared: f64) {
    let inverse = 1.0 / k_squared;
    let mut term = weight * inverse.sqrt();
    for moment in moments {
        *moment += term;
        term *= inverse;
    }
}

/// Power moments above every cut-off, and Chebyshev moments between neighbouring ones (the last entry stays empty).
fn for_wavenumber(
    projection: &Projection,
    classes: &TailClasses,
    n: usize,
) -> (Vec<[f64; TERMS]>, Vec<[f64; BAND_TERMS]>) {
    let count = classes.cut_offs.len();
    let mut bands = vec![[0.0; BAND_TERMS]; count];
    // Shell c holds what lies between cut-off c and c + 1; the last one everything above.
    let mut shells = vec![[0.0; TERMS]; count];
    let highest = classes.cut_offs[count - 1];
    let last_m = 2 * (highest * projection.width / (2.0 * PI)) as usize + 2 * EXPLICIT_LATERAL + 1;
    let lobes = (highest * projection.element / (2.0 * PI)) as i64 + EXPLICIT_ALIASES;
    let elements = projection.elements as i64;
    let aliases: Vec<(f64, f64)> = (-lobes..=lobes)
        .map(|p| n as i64 + p * elements)
        .map(|alias| (projection.kx(alias).powi(2), projection.longitudinal_weight(alias)))
        .collect();
    // What is left of the sum over p past the last lobe on either side; smooth in p, so that a midpoint integral does.
    let far_aliases: Vec<(f64, f64)> = {
        let fraction = n as f64 / projection.elements as f64;
        let sine = (PI * fraction).sin();
        [1.0, -1.0]
            .into_iter()
            .flat_map(|side| {
                let edge = lobes as f64 + 0.5 + side * fraction;
                NODES.iter().map(move |&(t, weight)| {
                    let x = edge / t;
                    (x, weight * edge / (t * t))
                })
            })
            .map(|(x, weight)| {
                let kx = 2.0 * PI * x / projection.element;
                (kx * kx, weight * (sine / (PI * x)).powi(2) / projection.circumference)
            })
            .collect()
    };
    let mut row = |ky: f64, lateral: f64| {
        let ky_squared = ky * ky;
        for &(kx_squared, longitudinal) in &aliases {
            let k_squared = kx_squared + ky_squared;
            if k_squared < classes.cut_offs[0] * classes.cut_offs[0] {
                continue;
            }
            let shell = classes.cut_offs.partition_point(|&cut_off| cut_off * cut_off <= k_squared) - 1;
            add(&mut shells[shell], lateral * longitudinal, k_squared);
            if shell + 1 < count {
                half_space_bands::add(&mut bands[shell], lateral * longitudinal, k_squared, classes.band(shell));
            }
        }
        for &(kx_squared, longitudinal) in &far_aliases {
            add(&mut shells[count - 1], lateral * longitudinal, kx_squared + ky_squared);
        }
    };
    for m in (1..=last_m).step_by(2) {
        row(projection.ky(m), projection.lateral_weight(m));
    }
    // Odd m past the last one: half of the integral over m, from the middle between two of them.
    let edge = last_m as f64 + 1.0;
    for (t, weight) in NODES {
        let m = edge / t;
        let ky = PI * m / projection.width;
        let mean = 2.0 / projection.width * 2.0 / (ky * projection.contact_width).powi(2);
        row(ky, 0.5 * weight * edge / (t * t) * mean);
    }
    for class in (0..count.saturating_sub(1)).rev() {
        let beyond = shells[class + 1];
        for (moment, more) in shells[class].iter_mut().zip(beyond) {
            *moment += more;
        }
    }
    (shells, bands)
}
