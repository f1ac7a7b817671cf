//! Shapes of motion across a belt with free edges: waves, lifts and their products.
//!
//! Waves of one parity, y' = y + B/2, k_m = m pi/B: cos(k_m y') for w and v, sin(k_m y') for q. Lifts: psi for q and
//! chi for w and v, chi' = psi and psi(B/2) = 1, one family without and others with a rate kappa \[1/m\], at which the
//! motion of an edge layer decays:
//!
//! ```text
//! even:  psi = 2 y/B or sinh(kappa y)/sinh(kappa B/2),   chi = y^2/B or psi'/kappa^2,
//! odd:   psi = 1 or cosh(kappa y)/cosh(kappa B/2),       chi = y or psi'/kappa^2.
//! ```
//!
//! With t = psi'(B/2) and psi'' = kappa^2 psi all integrals over the width are closed:
//!
//! ```text
//! int psi_a psi_b = 2 (t_a - t_b)/(a^2 - b^2),     int psi_a' psi_b' = 2 t_b - b^2 int psi_a psi_b,
//! int chi_a psi_b' = 2 chi_a(B/2) - int psi_a psi_b,    int chi_a chi_b = int chi_a psi_b'/b^2.
//! ```
//!
//! Lifts are taken less their projections on the waves m <= M, so that w and v lifts are orthogonal in energy to these
//! waves. Sine coefficients c_m of psi and cosine coefficients d_m of chi are
//!
//! ```text
//! c_m = -beta_m k_m/(kappa^2 + k_m^2),   d_m = -c_m/k_m,   beta_m = 4/B (even; 2/B at m = 0), -4/B (odd).
//! ```
//!
//! The cosine coefficient of psi' less k_m c_m is beta_m in every family: a wave meets only the slope of q that the
//! edges' motion demands. Families of q past the first are taken less the first: they leave the edges at rest, and are
//! orthogonal to all these waves, too.

use std::f64::consts::PI;

use faer::Mat;
use serde::Deserialize;

/// Symmetry about mid-width of w and v; q has the other one.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Parity {
    /// w(-y) = w(y): motion that a centred strip excites.
    Even,
    /// w(-y) = -w(y).
    Odd,
}

/// A wave across the tyre.
#[derive(Clone, Copy, Debug)]
pub(super) struct LateralWave {
    /// m.
    pub number: usize,
    /// k_m \[1/m\].
    pub wavenumber: f64,
    /// int cos^2(k_m y') dy: B/2, or B for m = 0 \[m\].
    pub norm: f64,
    /// beta_m \[1/m\].
    pub boundary: f64,
    pub zone: ZoneValues,
}

/// Values of a shape over the zone of an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct ZoneValues {
    /// Mean of a shape of q.
    pub lateral: f64,
    /// Mean of a shape of w and v.
    pub mean: f64,
    /// Value at the edge of the straight line fitted to a shape of w.
    pub at_edge: f64,
}

/// Waves m <= M and lifts of one parity.
#[derive(Clone, Debug)]
pub(super) struct LateralShapes {
    pub waves: Vec<LateralWave>,
    /// Zone values of each family of lifts.
    pub lifts: Vec<ZoneValues>,
    /// int psi_a psi_b and int psi_a' psi_b' between families of q.
    pub lateral: [Mat<f64>; 2],
    /// int chi_a chi_b and int psi_a psi_b between families of w and v.
    pub radial: [Mat<f64>; 2],
    /// int chi_a psi_b' and int psi_a psi_b, a a family of w and v, b one of q.
    pub mixed: [Mat<f64>; 2],
}

/// A family of lifts before its projection.
#[derive(Clone, Copy, Debug)]
struct Family {
    parity: Parity,
    rate: f64,
    width: f64,
}

/// First and second integral of a shape at a place.
type Integrals = [f64; 2];

impl Family {
    /// True for the family without a rate.
    fn is_polynomial(&self) -> bool {
        self.rate <= 0.0
    }

    /// psi(y), y in 0..=B/2 \[m\].
    fn psi(&self, y: f64) -> f64 {
        let Self { parity, width, .. } = *self;
        if self.is_polynomial() {
            return match parity {
                Parity::Even => 2.0 * y / width,
                Parity::Odd => 1.0,
            };
        }
        self.exponentials(y, parity)
    }

    /// chi(y) \[m\].
    fn chi(&self, y: f64) -> f64 {
        let Self { parity, rate, width } = *self;
        if self.is_polynomial() {
            return match parity {
                Parity::Even => y * y / width,
                Parity::Odd => y,
            };
        }
        let other = match parity {
            Parity::Even => Parity::Odd,
            Parity::Odd => Parity::Even,
        };
        self.exponentials(y, other) / rate
    }

    /// sinh(kappa y) for even parity or cosh(kappa y), over the value of psi's numerator at B/2; without overflow.
    fn exponentials(&self, y: f64, parity: Parity) -> f64 {
        let Self { rate, width, .. } = *self;
        let sign = |parity: Parity| if parity == Parity::Even { -1.0 } else { 1.0 };
        let rising = (rate * (y - 0.5 * width)).exp();
        let falling = (-rate * (y + 0.5 * width)).exp();
        (rising + sign(parity) * falling) / (1.0 + sign(self.parity) * (-rate * width).exp())
    }

    /// First and second integral of chi, from any common place on.
    fn integrals_of_chi(&self, y: f64) -> Integrals {
        let over = self.rate.powi(2).recip();
        match (self.is_polynomial(), self.parity) {
            (true, Parity::Even) => [y.powi(3) / (3.0 * self.width), y.powi(4) / (12.0 * self.width)],
            (true, Parity::Odd) => [0.5 * y * y, y.powi(3) / 6.0],
            (false, _) => [self.psi(y) * over, self.chi(y) * over],
        }
    }

    /// t = psi'(B/2) \[1/m\].
    fn slope(&self) -> f64 {
        match (self.is_polynomial(), self.parity) {
            (true, Parity::Even) => 2.0 / self.width,
            (true, Parity::Odd) => 0.0,
            (false, _) => self.rate.powi(2) * self.chi(0.5 * self.width),
        }
    }

    /// int psi_a psi_b \[m\].
    fn psi_psi(&self, other: &Self) -> f64 {
        let Self { parity, rate, width } = *self;
        if rate.to_bits() != other.rate.to_bits() {
            return 2.0 * (self.slope() - other.slope()) / (rate * rate - other.rate * other.rate);
        }
        let half = 0.5 * rate * width;
        match (self.is_polynomial(), parity) {
            (true, Parity::Even) => width / 3.0,
            (true, Parity::Odd) => width,
            (false, Parity::Even) => (half.tanh().recip() - half / half.sinh().powi(2)) / rate,
            (false, Parity::Odd) => (half.tanh() + half / half.cosh().powi(2)) / rate,
        }
    }

    /// int psi_a' psi_b' \[1/m\].
    fn slope_slope(&self, other: &Self) -> f64 {
        2.0 * other.slope() - other.rate * other.rate * self.psi_psi(other)
    }

    /// int chi_a psi_b' \[m\].
    fn chi_slope(&self, other: &Self) -> f64 {
        2.0 * self.chi(0.5 * self.width) - self.psi_psi(other)
    }

    /// int chi_a chi_b \[m^3\].
    fn chi_chi(&self, other: &Self) -> f64 {
        match (self.is_polynomial(), other.is_polynomial(), self.parity) {
            (_, false, _) => self.chi_slope(other) / (other.rate * other.rate),
            (false, true, _) => other.chi_chi(self),
            (true, true, Parity::Even) => self.width.powi(3) / 80.0,
            (true, true, Parity::Odd) => self.width.powi(3) / 12.0,
        }
    }

    /// c_m, d_m and the cosine coefficient of psi'.
    fn coefficients(&self, wave: &LateralWave) -> [f64; 3] {
        let Self { rate, width, .. } = *self;
        let LateralWave { number, wavenumber, boundary, .. } = *wave;
        if number == 0 {
            // Mean of chi, and of psi'.
            let [integral, _] = self.integrals_of_chi(0.5 * width);
            let [from, _] = self.integrals_of_chi(0.0);
            return [0.0, 2.0 * (integral - from) / width, boundary];
        }
        let sine = -boundary * wavenumber / (rate * rate + wavenumber * wavenumber);
        [sine, -sine / wavenumber, boundary + wavenumber * sine]
    }

    /// Values over the zone from `from` to the edge \[m\].
    fn zone(&self, from: f64) -> ZoneValues {
        let to = 0.5 * self.width;
        let [mean, at_edge] = zone_of_slope([from, to], |y| self.integrals_of_chi(y));
        ZoneValues { lateral: (self.chi(to) - self.chi(from)) / (to - from), mean, at_edge }
    }
}

/// Mean over a zone, and value at its end of the straight line fitted there, from the integrals of a shape: the mean
/// of (1 + 6 (y - y_mid)/b) times the shape.
fn zone_of_slope([from, to]: [f64; 2], integrals: impl Fn(f64) -> Integrals) -> [f64; 2] {
    let length = to - from;
    let ([first, second], [first_end, second_end]) = (integrals(from), integrals(to));
    let mean = (first_end - first) / length;
    let moment = 0.5 * length * (first_end + first) - (second_end - second);
    [mean, mean + 6.0 * moment / (length * length)]
}

impl LateralShapes {
    /// Waves up to m = `most` and one family of lifts for each rate \[1/m\], the first of them 0, of a belt of a width
    /// and with zones of a length at its edges \[m\].
    pub(super) fn new(parity: Parity, [width, zone]: [f64; 2], most: usize, rates: &[f64]) -> Self {
        // 1. Waves.
        let first = usize::from(parity == Parity::Odd);
        let wave = |number: usize| {
            let wavenumber = PI * number as f64 / width;
            let (norm, boundary) = match (number, parity) {
                (0, _) => (width, 2.0 / width),
                (_, Parity::Even) => (0.5 * width, 4.0 / width),
                (_, Parity::Odd) => (0.5 * width, -4.0 / width),
            };
            let range = [width - zone, width];
            let [mean, at_edge] = zone_of_slope(range, |y| {
                let (sine, cosine) = (wavenumber * y).sin_cos();
                if number == 0 { [y, 0.5 * y * y] } else { [sine / wavenumber, -cosine / wavenumber.powi(2)] }
            });
            let cosine = |y: f64| (wavenumber * y).cos();
            let lateral = if number == 0 { 0.0 } else { (cosine(range[0]) - cosine(range[1])) / (wavenumber * zone) };
            LateralWave { number, wavenumber, norm, boundary, zone: ZoneValues { lateral, mean, at_edge } }
        };
        let waves: Vec<LateralWave> = (first..=most).step_by(2).map(wave).collect();
        // 2. Families less their projections.
        let families: Vec<Family> = rates.iter().map(|&rate| Family { parity, rate, width }).collect();
        let coefficients: Vec<Vec<[f64; 3]>> =
            families.iter().map(|family| waves.iter().map(|wave| family.coefficients(wave)).collect()).collect();
        let count = families.len();
        let projected = |whole: fn(&Family, &Family) -> f64, row: usize, column: usize| {
            Mat::from_fn(count, count, |a, b| {
                let taken = waves.iter().zip(&coefficients[a]).zip(&coefficients[b]);
                let taken = taken.map(|((wave, one), other)| wave.norm * one[row] * other[column]);
                whole(&families[a], &families[b]) - taken.sum::<f64>()
            })
        };
        let psi_psi = projected(Family::psi_psi, 0, 0);
        let boundary: f64 = waves.iter().map(|wave| wave.norm * wave.boundary * wave.boundary).sum();
        let slope_slope = projected(Family::slope_slope, 2, 2) + Mat::from_fn(count, count, |_, _| boundary);
        let zones = families.iter().zip(&coefficients).map(|(family, coefficients)| {
            let mut zone = family.zone(0.5 * width - zone);
            for (wave, [sine, cosine, _]) in waves.iter().zip(coefficients) {
                zone.lateral -= sine * wave.zone.lateral;
                zone.mean -= cosine * wave.zone.mean;
                zone.at_edge -= cosine * wave.zone.at_edge;
            }
            zone
        });
        let mut lifts: Vec<ZoneValues> = zones.collect();
        // 3. Families of q past the first, less the first.
        let one = lifts[0].lateral;
        lifts.iter_mut().skip(1).for_each(|zone| zone.lateral -= one);
        let apart =
            Mat::from_fn(count, count, |a, b| f64::from(u8::from(a == b)) - f64::from(u8::from(a > 0 && b == 0)));
        let chi_slope = projected(Family::chi_slope, 1, 2);
        let chi_chi = projected(Family::chi_chi, 1, 1);
        Self {
            lateral: [&apart * &psi_psi * apart.transpose(), &apart * slope_slope * apart.transpose()],
            mixed: [chi_slope * apart.transpose(), &psi_psi * apart.transpose()],
            radial: [chi_chi, psi_psi],
            waves,
            lifts,
        }
    }
}

#[cfg(test)]
#[path = "lateral_shapes_tests.rs"]
mod tests;
