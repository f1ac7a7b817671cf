use super::*;
use crate::numeric::legendre::gauss;

const WIDTH: f64 = 0.14;
const ZONE: f64 = 0.015;
/// Waves m <= MOST.
const MOST: usize = 16;

/// Integral over y from a half-width to another, by panels that grow finer towards both edges.
fn integral(from: f64, to: f64, value: impl Fn(f64) -> f64) -> f64 {
    let rule = gauss(24);
    let panels = 400;
    let place = |panel: usize| 0.5 * (from + to) - 0.5 * (to - from) * (PI * panel as f64 / panels as f64).cos();
    let panel = |index: usize| {
        let (a, b) = (place(index), place(index + 1));
        let sum: f64 = rule.iter().map(|[x, weight]| weight * value(0.5 * (a + b + (b - a) * x))).sum();
        0.5 * (b - a) * sum
    };
    (0..panels).map(panel).sum()
}

type Shapes = [Box<dyn Fn(f64) -> f64>; 3];

/// psi, psi' and chi of a family on the whole width, as written in the module's head.
fn shapes(parity: Parity, rate: f64) -> Shapes {
    let half = 0.5 * WIDTH;
    match (parity, rate > 0.0) {
        (Parity::Even, false) => {
            [Box::new(|y| 2.0 * y / WIDTH), Box::new(|_| 2.0 / WIDTH), Box::new(|y| y * y / WIDTH)]
        }
        (Parity::Odd, false) => [Box::new(|_| 1.0), Box::new(|_| 0.0), Box::new(|y| y)],
        (Parity::Even, true) => {
            let scale = (rate * half).sinh();
            [
                Box::new(move |y| (rate * y).sinh() / scale),
                Box::new(move |y| rate * (rate * y).cosh() / scale),
                Box::new(move |y| (rate * y).cosh() / (rate * scale)),
            ]
        }
        (Parity::Odd, true) => {
            let scale = (rate * half).cosh();
            [
                Box::new(move |y| (rate * y).cosh() / scale),
                Box::new(move |y| rate * (rate * y).sinh() / scale),
                Box::new(move |y| (rate * y).sinh() / (rate * scale)),
            ]
        }
    }
}

/// The same, less their projections on the waves; those of q past the first family less the first.
struct Projected {
    shapes: Vec<Shapes>,
    /// c_m and d_m by family, by quadrature.
    coefficients: Vec<Vec<[f64; 2]>>,
    waves: Vec<(f64, f64)>,
}

impl Projected {
    fn new(parity: Parity, rates: &[f64]) -> Self {
        let first = usize::from(parity == Parity::Odd);
        let waves: Vec<(f64, f64)> = (first..=MOST)
            .step_by(2)
            .map(|m| (PI * m as f64 / WIDTH, if m == 0 { WIDTH } else { 0.5 * WIDTH }))
            .collect();
        let shapes: Vec<_> = rates.iter().map(|&rate| shapes(parity, rate)).collect();
        let half = 0.5 * WIDTH;
        let coefficients = shapes
            .iter()
            .map(|[psi, _, chi]| {
                let of = |&(k, norm): &(f64, f64)| {
                    let sine = integral(-half, half, |y| psi(y) * (k * (y + half)).sin()) / norm;
                    let cosine = integral(-half, half, |y| chi(y) * (k * (y + half)).cos()) / norm;
                    [sine, cosine]
                };
                waves.iter().map(of).collect()
            })
            .collect();
        Self { shapes, coefficients, waves }
    }

    fn sum(&self, family: usize, y: f64, term: impl Fn(f64, [f64; 2], f64) -> f64) -> f64 {
        let terms = self.waves.iter().zip(&self.coefficients[family]);
        terms.map(|(&(k, _), &coefficients)| term(k, coefficients, k * (y + 0.5 * WIDTH))).sum()
    }

    fn psi(&self, family: usize, y: f64) -> f64 {
        self.shapes[family][0](y) - self.sum(family, y, |_, [sine, _], at| sine * at.sin())
    }

    fn slope(&self, family: usize, y: f64) -> f64 {
        self.shapes[family][1](y) - self.sum(family, y, |k, [sine, _], at| k * sine * at.cos())
    }

    fn chi(&self, family: usize, y: f64) -> f64 {
        self.shapes[family][2](y) - self.sum(family, y, |_, [_, cosine], at| cosine * at.cos())
    }

    fn q(&self, family: usize, of: impl Fn(usize) -> f64) -> f64 {
        if family == 0 { of(0) } else { of(family) - of(0) }
    }
}

const RATES: [f64; 3] = [0.0, 350.0, 2100.0];

#[test]
fn full_width_is_twice_half_width_in_all_products_of_lifts() {
    for parity in [Parity::Even, Parity::Odd] {
        let found = LateralShapes::new(parity, [WIDTH, ZONE], MOST, &RATES);
        let exact = Projected::new(parity, &RATES);
        let half = 0.5 * WIDTH;
        // Twice half of the width is the full width: products of one parity are even.
        let whole = |value: &dyn Fn(f64) -> f64| {
            let (full, half) = (integral(-half, half, value), integral(0.0, half, value));
            let size = integral(0.0, 0.5 * WIDTH, |y| value(y).abs());
            assert!((full - 2.0 * half).abs() <= 1e-10 * size, "{full} {half}");
            full
        };
        for a in 0..RATES.len() {
            for b in 0..RATES.len() {
                let q = |family: usize, y: f64| exact.q(family, |family| exact.psi(family, y));
                let q_slope = |family: usize, y: f64| exact.q(family, |family| exact.slope(family, y));
                let [q_q, slope_slope] = &found.lateral;
                let [chi_chi, psi_psi] = &found.radial;
                let [chi_slope, psi_q] = &found.mixed;
                let pairs = [
                    (q_q, whole(&|y| q(a, y) * q(b, y)), [q_q, q_q]),
                    (slope_slope, whole(&|y| q_slope(a, y) * q_slope(b, y)), [slope_slope, slope_slope]),
                    (chi_chi, whole(&|y| exact.chi(a, y) * exact.chi(b, y)), [chi_chi, chi_chi]),
                    (psi_psi, whole(&|y| exact.psi(a, y) * exact.psi(b, y)), [psi_psi, psi_psi]),
                    (chi_slope, whole(&|y| exact.chi(a, y) * q_slope(b, y)), [chi_chi, slope_slope]),
                    (psi_q, whole(&|y| exact.psi(a, y) * q(b, y)), [psi_psi, q_q]),
                ];
                for (index, (found, wanted, [one, other])) in pairs.into_iter().enumerate() {
                    let found = found[(a, b)];
                    let error = (found - wanted).abs() / (one[(a, a)] * other[(b, b)]).sqrt();
                    assert!(error < 1e-7, "{parity:?}, product {index} of {a}, {b}: {found} {wanted}, {error:.1e}");
                }
            }
        }
    }
}

#[test]
fn waves_meet_only_the_slope_that_the_edges_demand() {
    for parity in [Parity::Even, Parity::Odd] {
        let found = LateralShapes::new(parity, [WIDTH, ZONE], MOST, &RATES);
        let exact = Projected::new(parity, &RATES);
        let half = 0.5 * WIDTH;
        for wave in &found.waves {
            let cosine = |y: f64| (wave.wavenumber * (y + half)).cos();
            for family in 0..RATES.len() {
                let slope = integral(-half, half, |y| exact.slope(family, y) * cosine(y)) / wave.norm;
                assert!((slope - wave.boundary).abs() < 1e-9 * wave.boundary.abs(), "m = {}: {slope}", wave.number);
                let chi = integral(-half, half, |y| exact.chi(family, y) * cosine(y)) / wave.norm;
                assert!(chi.abs() < 1e-12 * WIDTH, "m = {}: {chi:e}", wave.number);
            }
        }
    }
}

#[test]
fn values_over_the_zone_are_means_and_the_end_of_a_fitted_line() {
    let half = 0.5 * WIDTH;
    let middle = half - 0.5 * ZONE;
    let mean = |shape: &dyn Fn(f64) -> f64| integral(half - ZONE, half, shape) / ZONE;
    let at_edge = |shape: &dyn Fn(f64) -> f64| mean(&|y| (1.0 + 6.0 * (y - middle) / ZONE) * shape(y));
    // A straight line is its own fit.
    assert!((at_edge(&|y| 3.0 * y - 1.0) - (3.0 * half - 1.0)).abs() < 1e-12);
    for parity in [Parity::Even, Parity::Odd] {
        let found = LateralShapes::new(parity, [WIDTH, ZONE], MOST, &RATES);
        let exact = Projected::new(parity, &RATES);
        for wave in &found.waves {
            let at = |y: f64| wave.wavenumber * (y + half);
            let wanted = [mean(&|y| at(y).sin()), mean(&|y| at(y).cos()), at_edge(&|y| at(y).cos())];
            let zone = [wave.zone.lateral, wave.zone.mean, wave.zone.at_edge];
            for (found, wanted) in zone.into_iter().zip(wanted) {
                assert!((found - wanted).abs() < 1e-10, "m = {}: {found} {wanted}", wave.number);
            }
        }
        for (family, zone) in found.lifts.iter().enumerate() {
            let q = mean(&|y| exact.q(family, |family| exact.psi(family, y)));
            assert!((zone.lateral - q).abs() < 1e-9, "{family}: {} {q}", zone.lateral);
            for (found, wanted) in
                [(zone.mean, mean(&|y| exact.chi(family, y))), (zone.at_edge, at_edge(&|y| exact.chi(family, y)))]
            {
                assert!((found - wanted).abs() < 1e-9 * WIDTH, "{family}: {found} {wanted}");
            }
        }
    }
}
