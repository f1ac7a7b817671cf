//! From the six states along a sidewall's arc to the impedance at the belt's edge.
//!
//! Fields ~ exp(i n theta + s t); t runs along the arc, u outwards, v = -i V round the tyre. With the steady meridian
//! (R, a, ka, N, see `super::meridian`), f(s) times p, N, G and E, U = t cos a + u sin a, e = (n V + U)/R and forces T
//! per radian
//!
//! ```text
//! t' = -ka u                                   Tt' = R A_t - (ka - p/N) Tn - n G Gam + E e cos a
//! u' = ka t + Tn/(R N)                         Tn' = R A_n + ka Tt - p R e + E e sin a
//! V' = (Tv + G (n t + V cos a))/(R (N + G))    Tv' = R A_v - G Gam cos a + n E e - p (n u + V sin a)
//! Gam = (Tv - N (n t + V cos a))/(R (N + G))
//! A_t = m (s^2 t - Om^2 U cos a + 2 i Om s V cos a)    A_n = m (s^2 u - Om^2 U sin a + 2 i Om s V sin a)
//! A_v = m ((s^2 - Om^2) V + 2 i Om s U)
//! ```
//!
//! Cords along the meridian do not stretch (t' = -ka u), and nothing bends. At the bead t = u = V = 0: the compliance
//! Y = (t, u, V) by (Tt, Tn, Tv) begins with 0 and is handed on, step by step, by exponentials of Magnus' expansion of
//! sixth order (Blanes, Casas, Oteo & Ros 2009, *Phys. Rep.* 470, 151), so that nothing overflows. At the edge
//! t = w cos a_b - q sin a_b, u = w sin a_b + q cos a_b, and K = Q^T Y^-1 Q/R_b per metre of the edge. A belt that is
//! symmetric across moves by q as a whole alone, apart from w and V: K_qq, and K over w and V without q. An edge that
//! is free to move across ([`FreeEdgeImpedance`]) meets all of K. Its only part that is not symmetric, K_wq - K_qw =
//! f p, belongs to the pressure on the belt and is left to it: here both are the mean.
//!
//! Sums of the arc's motion, c . (t, u) over the ends of the steps, go along: Y_k = (E11 Y + E12) M and
//! M = (E21 Y + E22)^-1, the forces there by those of the next end, give the sum by the forces reached,
//! S <- S M + c Y_k (see `super::swept`).
//!
//! Cost: eleven products of 6x6 matrices and one inverse of a 3x3 matrix a step.

use num_complex::Complex64;

use super::arc::Arc;
use super::meridian::{EdgeStatics, MeridianPoint};
use crate::numeric::ComplexField;

/// Impedance of one sidewall at the belt's edge: forces per metre of edge by its motion \[N/m^2\].
///
/// With v = -i V: radial force P = ww w + i wV v, circumferential force q = -i wV w + VV v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeImpedance<T = Complex64> {
    /// ww: radial force by radial motion.
    pub radial: T,
    /// wV: radial force by V, and circumferential force by w.
    pub coupling: T,
    /// VV: circumferential force by V.
    pub circumferential: T,
    /// K_qq: lateral force by lateral motion alone.
    pub lateral: T,
}

/// Impedance of one sidewall at an edge that also moves across, q outwards: forces per metre of edge \[N/m^2\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeEdgeImpedance<T = Complex64> {
    /// Impedance over w and V, and K_qq.
    pub guided: EdgeImpedance<T>,
    /// (K_wq + K_qw)/2.
    pub radial_lateral: T,
    /// qV: lateral force by V, and circumferential force by q.
    pub lateral_circumferential: T,
}

type Matrix<T, const N: usize> = [[T; N]; N];

/// A wave at one s: n, s and f(s).
#[derive(Clone, Copy, Debug)]
pub(super) struct Wave<T> {
    pub(super) n: T,
    pub(super) s: T,
    pub(super) loss: T,
}

/// Largest product of step and wavenumber of production, and of reference values: errors below 2e-6 and 1e-8 of the
/// largest entry of K.
pub(super) const STEP: f64 = 1.0;
pub(super) const FINE_STEP: f64 = 0.2;
/// Fewest steps along an arc. They serve a car's sidewall up to 1.9 kHz: with a fixed number of steps K is smooth in
/// s.
pub(super) const FEWEST_STEPS: usize = 32;

/// Wavenumber along the arc on which the number of steps depends \[1/m\]: inertial, or n round the bead.
pub(super) fn wavenumber(arc: &Arc, n: f64, s: Complex64) -> f64 {
    let along = ((arc.mass * arc.radius / arc.pressure) * s.norm_sqr() + 2.0).sqrt() / arc.radius;
    along.max(n.abs() / arc.bead_radius())
}

/// Units in which the six states are of equal size.
struct Units {
    /// Unit of each state, (t, u, V, Tt, Tn, Tv).
    states: [f64; 6],
    /// Ratios of the unit of the state in the column to that in the row.
    ratios: Matrix<f64, 6>,
}

impl Units {
    fn new(arc: &Arc, wavenumber: f64) -> Self {
        let along = (1.0 / (arc.radius * wavenumber)).min(1.0);
        let force = arc.pressure * arc.radius * arc.edge_radius * wavenumber;
        let states = [along, 1.0, 1.0, force / along, force, force];
        Self { states, ratios: states.map(|row| states.map(|column| column / row)) }
    }
}

/// Coefficients of a wave's equations that do not vary along the arc.
struct Equations<T> {
    n: T,
    /// n f, f.
    lossy_n: T,
    loss: T,
    /// 1/f.
    over_loss: T,
    /// m s^2, 2 i Om m s.
    inertia: T,
    coriolis: T,
    /// m Om^2.
    spin: f64,
    pressure: f64,
    shear: f64,
    hoop: f64,
}

impl<T: ComplexField> Equations<T> {
    #[inline(always)]
    fn new(arc: &Arc, &Wave { n, s, loss }: &Wave<T>) -> Self {
        Self {
            n,
            lossy_n: n * loss,
            loss,
            over_loss: loss.reciprocal(),
            inertia: s * s * arc.mass,
            coriolis: (s * (2.0 * arc.angular_velocity * arc.mass)).times_i(),
            spin: arc.mass * arc.angular_velocity * arc.angular_velocity,
            pressure: arc.pressure,
            shear: arc.shear,
            hoop: arc.hoop,
        }
    }

    /// Matrix of d/dt of (t, u, V, Tt, Tn, Tv) along the arc, in the given units.
    #[inline(always)]
    fn system(&self, point: &MeridianPoint, units: &Units) -> Matrix<T, 6> {
        let Self { n, lossy_n, loss, over_loss, inertia, coriolis, spin, pressure, shear, hoop } = *self;
        let MeridianPoint { radius, sine, cosine, curvature, tension, pressed } = *point;
        let zero = n.like(0.0);
        let over = 1.0 / (radius * (tension + shear));
        // Fractions of shear and tension in the slope of V.
        let (sheared, held) = (shear * over, tension * over);
        let flexible = over_loss * (1.0 / (radius * tension));
        let stretch = hoop / radius;
        let pressed_out = stretch * sine - pressure;
        let turned = coriolis * radius;
        let slow = -spin * radius;
        let bent = loss * (shear * held);
        let mut matrix = [
            [zero, n.like(-curvature), zero, zero, zero, zero],
            [n.like(curvature), zero, zero, zero, flexible, zero],
            [n * sheared, zero, n.like(cosine * sheared), zero, zero, over_loss * over],
            [
                inertia * radius + slow * cosine * cosine + n * n * bent + loss * (stretch * cosine * cosine),
                loss * (stretch * cosine * sine) + slow * cosine * sine,
                turned * cosine + n * bent * cosine + lossy_n * (stretch * cosine),
                zero,
                n.like(pressed - curvature),
                n * -sheared,
            ],
            [
                loss * (pressed_out * cosine) + slow * cosine * sine,
                inertia * radius + slow * sine * sine + loss * (pressed_out * sine),
                turned * sine + lossy_n * pressed_out,
                n.like(curvature),
                zero,
                zero,
            ],
            [
                turned * cosine + n * bent * cosine + lossy_n * (stretch * cosine),
                turned * sine + lossy_n * pressed_out,
                inertia * radius + slow + bent * (cosine * cosine) + n * lossy_n * stretch + loss * (-pressure * sine),
                zero,
                zero,
                n.like(-sheared * cosine),
            ],
        ];
        for (row, ratios) in matrix.iter_mut().zip(&units.ratios) {
            for (entry, ratio) in row.iter_mut().zip(ratios) {
                *entry = *entry * *ratio;
            }
        }
        matrix
    }
}

/// K of a wave; `points`: three of each step, all steps equally long. `widest`: the wave of the largest |n| among
/// those in lockstep, for the exponentials' scale.
#[inline(always)]
pub(super) fn edge_impedance<T: ComplexField>(
    arc: &Arc,
    edge: &EdgeStatics,
    points: &[[MeridianPoint; 3]],
    wave: &Wave<T>,
    widest: &Wave<Complex64>,
) -> EdgeImpedance<T> {
    edge_response::<T, 0>(arc, edge, points, &vec![[]; points.len()], wave, widest).0
}

/// As [`edge_impedance`], and K sums of the arc's motion by w and V of the edge; `sums` has their weights of t and u
/// at the end of each step.
#[inline(always)]
pub(super) fn edge_response<T: ComplexField, const K: usize>(
    arc: &Arc,
    edge: &EdgeStatics,
    points: &[[MeridianPoint; 3]],
    sums: &[[[f64; 2]; K]],
    wave: &Wave<T>,
    widest: &Wave<Complex64>,
) -> (EdgeImpedance<T>, [[T; 2]; K]) {
    let (impedance, by_force, units) = marched(arc, points, sums, wave, widest);
    // At the edge: Y^-1 turns the sums by force into sums by motion.
    let (sine, cosine) = edge.angle.sin_cos();
    let zero = wave.n.like(0.0);
    let mut by_edge = [[zero; 2]; K];
    for (sum, by_force) in by_edge.iter_mut().zip(&by_force) {
        let [t, u, v] = over(by_force, &impedance);
        let [along, out, round] = [cosine / units.states[0], sine / units.states[1], 1.0 / units.states[2]];
        *sum = [t * along + u * out, v * round];
    }
    (at_edge(arc, edge, &impedance, &units), by_edge)
}

/// K of a wave at an edge that also moves across; arguments as of [`edge_impedance`].
pub(super) fn free_edge_impedance(
    arc: &Arc,
    edge: &EdgeStatics,
    points: &[[MeridianPoint; 3]],
    wave: &Wave<Complex64>,
) -> FreeEdgeImpedance {
    let (impedance, [], units) = marched::<Complex64, 0>(arc, points, &vec![[]; points.len()], wave, wave);
    let (sine, cosine) = edge.angle.sin_cos();
    let [[tt, tu, tv], [ut, uu, uv], [vt, vu, _]] = in_units(arc, &impedance, &units);
    FreeEdgeImpedance {
        guided: at_edge(arc, edge, &impedance, &units),
        radial_lateral: (uu - tt) * (sine * cosine) + (tu + ut) * (0.5 * (cosine * cosine - sine * sine)),
        // Equal but for rounding: the mean of both.
        lateral_circumferential: (uv + vu) * (0.5 * cosine) - (tv + vt) * (0.5 * sine),
    }
}

/// Goes along the arc from the bead: (Tt, Tn, Tv) by (t, u, V) at the edge and the sums by force, in the units that
/// are given with them.
#[inline(always)]
fn marched<T: ComplexField, const K: usize>(
    arc: &Arc,
    points: &[[MeridianPoint; 3]],
    sums: &[[[f64; 2]; K]],
    wave: &Wave<T>,
    widest: &Wave<Complex64>,
) -> (Matrix<T, 3>, [[T; 3]; K], Units) {
    let units = Units::new(arc, wavenumber(arc, widest.n.re, widest.s));
    let step = arc.length() / points.len() as f64;
    let squarings = squarings(arc, points, widest, &units, step);
    let equations = Equations::new(arc, wave);
    let zero = wave.n.like(0.0);
    let mut compliance = [[zero; 3]; 3];
    let mut by_force = [[zero; 3]; K];
    // Y and the sums by force, step by step from the bead.
    for ([first, middle, last], weights) in points.iter().zip(sums) {
        let first = equations.system(first, &units);
        let middle = equations.system(middle, &units);
        let last = equations.system(last, &units);
        let moved = exponential(&expansion(&first, &middle, &last, step), squarings);
        let before;
        (compliance, before) = handed_on(&moved, &compliance);
        for (sum, &[along, out]) in by_force.iter_mut().zip(weights) {
            let mut next = over(sum, &before);
            for (j, entry) in next.iter_mut().enumerate() {
                *entry = entry.plus_scaled(along * units.states[0], compliance[0][j]);
                *entry = entry.plus_scaled(out * units.states[1], compliance[1][j]);
            }
            *sum = next;
        }
    }
    (inverse(&compliance), by_force, units)
}

/// Row vector times matrix.
#[inline(always)]
fn over<T: ComplexField>(row: &[T; 3], matrix: &Matrix<T, 3>) -> [T; 3] {
    let mut result = *row;
    for (j, entry) in result.iter_mut().enumerate() {
        *entry = row[0] * matrix[0][j] + row[1] * matrix[1][j] + row[2] * matrix[2][j];
    }
    result
}

/// Squarings after which the exponents of all steps are below 1 in the row-sum norm; taken at both ends of the arc.
fn squarings(arc: &Arc, points: &[[MeridianPoint; 3]], widest: &Wave<Complex64>, units: &Units, step: f64) -> u32 {
    let equations = Equations::new(arc, widest);
    let norm = |point: &MeridianPoint| {
        let rows = equations.system(point, units).map(|row| row.iter().map(|entry| entry.norm()).sum::<f64>());
        rows.into_iter().fold(0.0, f64::max)
    };
    let [first, .., last] = points else { return 0 };
    let largest = step * norm(&first[0]).max(norm(&last[2]));
    // NaN gives none and passes into the result; 60 bounds infinity.
    if largest > 1.0 { largest.log2().ceil().min(60.0) as u32 } else { 0 }
}

// Loops and functions that are inlined by force, no closures: the vector code of the lanes ends at a call.

/// Exponent of a step from its three points: Magnus' expansion of sixth order.
#[inline(always)]
fn expansion<T: ComplexField>(
    first: &Matrix<T, 6>,
    middle: &Matrix<T, 6>,
    last: &Matrix<T, 6>,
    step: f64,
) -> Matrix<T, 6> {
    // In the paper's terms: alpha_1, alpha_2, alpha_3 are mean, slope and bend.
    let slope = 15.0_f64.sqrt() / 3.0 * step;
    let bend = 10.0 / 3.0 * step;
    let mean = scaled(middle, step);
    let slope = plus(&scaled(last, slope), -slope, first);
    let bend = plus(&plus(&scaled(first, bend), -2.0 * bend, middle), bend, last);
    let c1 = commutator(&mean, &slope);
    let c2 = scaled(&commutator(&mean, &plus(&c1, 2.0, &bend)), -1.0 / 60.0);
    let left = plus(&plus(&c1, -20.0, &mean), -1.0, &bend);
    let c3 = commutator(&left, &plus(&slope, 1.0, &c2));
    plus(&plus(&mean, 1.0 / 12.0, &bend), 1.0 / 240.0, &c3)
}

/// exp of a matrix: the series up to the power 12 at 2^-k of it, squared k times.
#[inline(always)]
fn exponential<T: ComplexField>(matrix: &Matrix<T, 6>, squarings: u32) -> Matrix<T, 6> {
    let one = scaled(matrix, 0.5_f64.powi(squarings as i32));
    let two = step_product(&one, &one);
    let three = step_product(&two, &one);
    let four = step_product(&two, &two);
    let inner = plus(&terms(8, &one, &two, &three), inverse_factorial(12), &four);
    let inner = plus(&terms(4, &one, &two, &three), 1.0, &step_product(&four, &inner));
    let mut result = plus(&terms(0, &one, &two, &three), 1.0, &step_product(&four, &inner));
    for _ in 0..squarings {
        result = step_product(&result, &result);
    }
    result
}

/// Terms k, ..., k + 3 of the exponential series, divided by the matrix to the power k.
#[inline(always)]
fn terms<T: ComplexField>(k: u32, one: &Matrix<T, 6>, two: &Matrix<T, 6>, three: &Matrix<T, 6>) -> Matrix<T, 6> {
    let mut sum = scaled(one, inverse_factorial(k + 1));
    sum = plus(&sum, inverse_factorial(k + 2), two);
    sum = plus(&sum, inverse_factorial(k + 3), three);
    for (place, row) in sum.iter_mut().enumerate() {
        row[place] = row[place] + inverse_factorial(k);
    }
    sum
}

fn inverse_factorial(k: u32) -> f64 {
    (1..=k).map(|j| 1.0 / f64::from(j)).product()
}

/// Y after a step E, (E11 Y + E12) M, and M = (E21 Y + E22)^-1.
#[inline(always)]
fn handed_on<T: ComplexField>(moved: &Matrix<T, 6>, compliance: &Matrix<T, 3>) -> (Matrix<T, 3>, Matrix<T, 3>) {
    let before = inverse(&half(moved, 3, compliance));
    (product(&half(moved, 0, compliance), &before), before)
}

/// Three rows of the step, from row `from` on, times (Y, 1).
#[inline(always)]
fn half<T: ComplexField>(moved: &Matrix<T, 6>, from: usize, compliance: &Matrix<T, 3>) -> Matrix<T, 3> {
    let mut sum = *compliance;
    for i in 0..3 {
        for j in 0..3 {
            let mut entry = moved[from + i][3 + j];
            for k in 0..3 {
                entry = entry + moved[from + i][k] * compliance[k][j];
            }
            sum[i][j] = entry;
        }
    }
    sum
}

/// Forces per metre of edge by (t, u, V), from those in units.
#[inline(always)]
fn in_units<T: ComplexField>(arc: &Arc, scaled: &Matrix<T, 3>, units: &Units) -> Matrix<T, 3> {
    let mut entries = *scaled;
    for (row, entries) in entries.iter_mut().enumerate() {
        for (column, entry) in entries.iter_mut().enumerate() {
            *entry = *entry * (units.states[3 + row] / (units.states[column] * arc.edge_radius));
        }
    }
    entries
}

/// K from the impedance in units at the belt's edge.
#[inline(always)]
fn at_edge<T: ComplexField>(arc: &Arc, edge: &EdgeStatics, scaled: &Matrix<T, 3>, units: &Units) -> EdgeImpedance<T> {
    let (sine, cosine) = edge.angle.sin_cos();
    let [[tt, tu, tv], [ut, uu, uv], [vt, vu, circumferential]] = in_units(arc, scaled, units);
    let radial = tt * (cosine * cosine) + uu * (sine * sine) + (tu + ut) * (sine * cosine);
    // Equal but for rounding: the mean of both.
    let coupling = (tv + vt) * (0.5 * cosine) + (uv + vu) * (0.5 * sine);
    let lateral = tt * (sine * sine) + uu * (cosine * cosine) + (tu + ut) * (-sine * cosine);
    EdgeImpedance { radial, coupling, circumferential, lateral }
}

#[inline(always)]
fn product<T: ComplexField, const N: usize>(a: &Matrix<T, N>, b: &Matrix<T, N>) -> Matrix<T, N> {
    let mut result = *a;
    for i in 0..N {
        for j in 0..N {
            let mut sum = a[i][0] * b[0][j];
            for k in 1..N {
                sum = sum + a[i][k] * b[k][j];
            }
            result[i][j] = sum;
        }
    }
    result
}

/// Product of matrices of a step, as a separate function.
#[inline(always)]
fn step_product<T: ComplexField>(a: &Matrix<T, 6>, b: &Matrix<T, 6>) -> Matrix<T, 6> {
    a[0][0].outlined(
        #[inline(always)]
        || product(a, b),
    )
}

#[inline(always)]
fn commutator<T: ComplexField>(a: &Matrix<T, 6>, b: &Matrix<T, 6>) -> Matrix<T, 6> {
    plus(&step_product(a, b), -1.0, &step_product(b, a))
}

/// a + factor b.
#[inline(always)]
fn plus<T: ComplexField>(a: &Matrix<T, 6>, factor: f64, b: &Matrix<T, 6>) -> Matrix<T, 6> {
    let mut sum = *a;
    for i in 0..6 {
        for j in 0..6 {
            sum[i][j] = a[i][j].plus_scaled(factor, b[i][j]);
        }
    }
    sum
}

#[inline(always)]
fn scaled<T: ComplexField>(a: &Matrix<T, 6>, factor: f64) -> Matrix<T, 6> {
    let mut result = *a;
    for i in 0..6 {
        for j in 0..6 {
            result[i][j] = a[i][j] * factor;
        }
    }
    result
}

/// a^-1 by cofactors; a singular matrix gives entries that are not finite.
#[inline(always)]
fn inverse<T: ComplexField>(a: &Matrix<T, 3>) -> Matrix<T, 3> {
    let first = minor(a, 0, 0);
    let scale = (a[0][0] * first + a[0][1] * minor(a, 0, 1) + a[0][2] * minor(a, 0, 2)).reciprocal();
    let mut result = *a;
    for (i, row) in result.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = minor(a, j, i) * scale;
        }
    }
    result
}

#[inline(always)]
fn minor<T: ComplexField>(a: &Matrix<T, 3>, i: usize, j: usize) -> T {
    let [r, s] = [(i + 1) % 3, (i + 2) % 3];
    let [p, q] = [(j + 1) % 3, (j + 2) % 3];
    a[r][p] * a[s][q] - a[r][q] * a[s][p]
}

#[cfg(test)]
#[path = "edge_tests.rs"]
mod tests;
