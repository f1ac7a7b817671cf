//! Moments of the sums' weights above a cut-off wavenumber.
//!
//! M_j(n, k_c) = sum over p and m with k > k_c of (1/L) sinc^2(kx dx/2) (2/B) a_m^2 k^-(2j+1): geometry only,
//! summed once. Explicit to a few lobes of the element and some dozen m past the highest cut-off. Beyond, sinc^2(kx
//! dx/2) = sin^2(pi n/N)/(pi (n/N + p))^2 varies with p only as a power, and a_m^2 = 2 (1 - cos(ky b))/(ky b)^2 with m
//! as a power and an oscillation: all three are tails of [`tail_sum`].
//!
//! Between two neighbouring cut-offs lies a band with separate Chebyshev moments (see [`super::half_space_bands`]).

use std::f64::consts::PI;

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::half_space_bands::{self, BAND_TERMS};
use super::projection::Projection;
use super::tail_sum;
use crate::numeric::lanes::{dispatch, load};
use crate::numeric::{MOST_LANES, in_parallel};
use crate::tyre::layers::surface_asymptote::TERMS;

/// Cut-off wavenumbers in steps of 2^(1/4), lowest first; a class is an index of them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TailClasses {
    cut_offs: Vec<f64>,
}

/// Most classes: a cut-off of 2^12 times the smallest.
const MOST_CLASSES: usize = 48;

impl TailClasses {
    /// From `smallest` until `largest` is reached \[1/m\], or the most classes.
    pub(super) fn new(smallest: f64, largest: f64) -> Self {
        let mut cut_offs = vec![smallest];
        let mut next = smallest;
        while next < largest && cut_offs.len() < MOST_CLASSES {
            next *= std::f64::consts::SQRT_2.sqrt();
            cut_offs.push(next);
        }
        Self { cut_offs }
    }

    /// Cut-off of a class \[1/m\].
    pub(super) fn cut_off(&self, class: usize) -> f64 {
        self.cut_offs[class]
    }

    /// Largest cut-off \[1/m\].
    pub(super) fn highest(&self) -> f64 {
        self.cut_offs[self.last()]
    }

    pub(super) fn last(&self) -> usize {
        self.cut_offs.len() - 1
    }

    /// Band of k^2 between the cut-offs of a class and the next \[1/m^2\].
    pub(super) fn band(&self, class: usize) -> [f64; 2] {
        [self.cut_offs[class].powi(2), self.cut_offs[class + 1].powi(2)]
    }

    /// The lowest class whose cut-off is at or above a wavenumber \[1/m\], and true; the last class and false if there
    /// is none.
    pub(super) fn choose(&self, wavenumber: f64) -> (usize, bool) {
        let class = self.cut_offs.partition_point(|&cut_off| cut_off < wavenumber);
        if class < self.cut_offs.len() { (class, true) } else { (self.cut_offs.len() - 1, false) }
    }
}

/// M_j, and the Chebyshev moments of the bands, for n = 0..=N/2 and every class.
#[derive(Clone, Debug)]
pub(super) struct Moments {
    classes: usize,
    values: Vec<[f64; TERMS]>,
    bands: Vec<[f64; BAND_TERMS]>,
}

/// Lobes of sinc^2 past the highest cut-off that are summed term by term.
pub(super) const EXPLICIT_ALIASES: i64 = 20;
/// Least number of odd m past the highest cut-off that are summed term by term.
const EXPLICIT_LATERAL: usize = 30;
/// Most of them: for a strip of nearly the whole width, whose a_m^2 beat slowly.
const MOST_LATERAL: usize = 2000;

impl Moments {
    /// Sums the moments for n = 0..=N/2.
    pub(super) fn new(projection: &Projection, classes: &TailClasses) -> Self {
        let count = classes.cut_offs.len();
        let lateral = lateral(projection, classes.highest());
        let powers: Vec<_> = (0..count - 1).map(|class| powers_of(classes.band(class))).collect();
        let of = |n| for_wavenumber(projection, classes, &powers, &lateral, n);
        let rows = in_parallel::made(projection.elements / 2 + 1, of);
        let (mut values, mut bands) = (Vec::with_capacity(rows.len() * count), Vec::with_capacity(rows.len() * count));
        for (row_values, row_bands) in rows {
            values.extend(row_values);
            bands.extend(row_bands);
        }
        Self { classes: count, values, bands }
    }

    /// Chebyshev moments nu_j(n) of the band between a class and the next.
    pub(super) fn band(&self, n: usize, class: usize) -> &[f64; BAND_TERMS] {
        &self.bands[n * self.classes + class]
    }

    /// M_j(n) above the cut-off of a class.
    pub(super) fn of(&self, n: usize, class: usize) -> &[f64; TERMS] {
        &self.values[n * self.classes + class]
    }
}

/// Adds weight k^-(2j+1) to the moments, in every lane.
#[inline(always)]
pub(super) fn add<S: Simd>(simd: S, moments: &mut [S::f64s; TERMS], weight: S::f64s, k_squared: S::f64s) {
    let inverse = simd.div_f64s(simd.splat_f64s(1.0), k_squared);
    let mut term = simd.mul_f64s(weight, simd.sqrt_f64s(inverse));
    for moment in moments {
        *moment = simd.add_f64s(*moment, term);
        term = simd.mul_f64s(term, inverse);
    }
}

/// Row j: Chebyshev coefficients of k^-(2j+1) in a band, which turn its Chebyshev moments into power moments.
type PowersOfBand = [[f64; BAND_TERMS]; TERMS];

fn powers_of(band: [f64; 2]) -> PowersOfBand {
    std::array::from_fn(|j| half_space_bands::chebyshev(band, |k_squared| k_squared.powf(-0.5 - j as f64)))
}

/// A value of ky^2 or kx^2 and its weight.
pub(super) type Weighted = (f64, f64);

/// kx^2 and longitudinal weights of all aliases of n: those up to `lobes`, then terms that stand for all others.
pub(super) fn longitudinal(projection: &Projection, n: usize, lobes: i64) -> [Vec<Weighted>; 2] {
    let mut aliases = signed_longitudinal(projection, n, lobes);
    aliases.iter_mut().flatten().for_each(|(kx, _)| *kx *= *kx);
    aliases
}

/// As [`longitudinal`], by kx with its sign.
pub(super) fn signed_longitudinal(projection: &Projection, n: usize, lobes: i64) -> [Vec<(f64, f64)>; 2] {
    let elements = projection.elements as i64;
    let explicit = (-lobes..=lobes)
        .map(|p| n as i64 + p * elements)
        .map(|alias| (projection.waves.kx(alias), projection.longitudinal_weight(alias)))
        .collect();
    let fraction = n as f64 / projection.elements as f64;
    let sine = (PI * fraction).sin();
    let far = [1.0, -1.0]
        .into_iter()
        .flat_map(|side| tail_sum::plain(lobes as f64 + 0.5 + side * fraction).map(move |term| (side, term)))
        .map(|(side, (x, weight))| {
            let kx = 2.0 * PI * x / projection.element;
            (side * kx, weight * (sine / (PI * x)).powi(2) / projection.waves.circumference)
        })
        .collect();
    [explicit, far]
}

/// ky^2 and lateral weights of the m that a strip excites: those summed term by term, then terms that stand for all
/// others.
pub(super) fn lateral(projection: &Projection, highest: f64) -> Vec<Weighted> {
    // 1. How far terms go: a_m^2 oscillates like cos(m angle).
    let angle = PI * projection.contact_width / projection.waves.width;
    let beat = angle.sin().abs();
    let beyond = ((PARTS_PER_BEAT / beat) as usize).clamp(EXPLICIT_LATERAL, MOST_LATERAL);
    let first = projection.waves.first_lateral_number();
    let last = 2 * ((highest * projection.waves.width / (2.0 * PI)) as usize + beyond) + first;
    // 2. Explicit terms.
    let mean = |m: f64| {
        let ky = PI * m / projection.waves.width;
        (ky * ky, 4.0 / projection.waves.width / (ky * projection.contact_width).powi(2))
    };
    let mut rows: Vec<Weighted> =
        (first..=last).step_by(2).map(|m| (projection.waves.ky(m).powi(2), projection.lateral_weight(m))).collect();
    // 3. The mean of the others. A beat too slow for summation by parts is taken as constant: angle is close to pi, so
    // that the cosine is -1 for odd m and 1 for even ones.
    let is_constant = PARTS_PER_BEAT / beat > MOST_LATERAL as f64;
    let standing = match (is_constant, first) {
        (true, 1) => 2.0,
        (true, _) => 0.0,
        (false, _) => 1.0,
    };
    rows.extend(tail_sum::plain(0.5 * (last + 1) as f64).map(|(x, weight)| {
        let (ky_squared, mean) = mean(2.0 * x);
        (ky_squared, weight * mean * standing)
    }));
    // 4. Their oscillation, by parts.
    if !is_constant {
        let weights = tail_sum::oscillating(-Complex64::cis((last + 2) as f64 * angle), 2.0 * angle);
        rows.extend((last + 2..).step_by(2).zip(weights).map(|(m, weight)| {
            let (ky_squared, mean) = mean(m as f64);
            (ky_squared, weight * mean)
        }));
    }
    rows
}

/// Odd m past the cut-off after which a beat of 1 is summed by parts to rounding.
const PARTS_PER_BEAT: f64 = 25.0;

/// Power moments above every cut-off, and Chebyshev moments between neighbouring ones (the last entry stays empty),
/// for the wavenumber n.
fn for_wavenumber(
    projection: &Projection,
    classes: &TailClasses,
    powers: &[PowersOfBand],
    lateral: &[Weighted],
    n: usize,
) -> (Vec<[f64; TERMS]>, Vec<[f64; BAND_TERMS]>) {
    let count = classes.cut_offs.len();
    let squares: Vec<f64> = classes.cut_offs.iter().map(|cut_off| cut_off * cut_off).collect();
    let lobes = (classes.highest() * projection.element / (2.0 * PI)) as i64 + EXPLICIT_ALIASES;
    let [aliases, far_aliases] = longitudinal(projection, n, lobes);
    let mut bands = vec![[0.0; BAND_TERMS]; count];
    let above = dispatch(Sums { squares: &squares, lateral, aliases: [&aliases, &far_aliases], bands: &mut bands });
    // The power moments of a band are its Chebyshev moments times coefficients: from the highest cut-off down.
    let mut values = vec![above; count];
    for class in (0..count - 1).rev() {
        values[class] = values[class + 1];
        for (moment, coefficients) in values[class].iter_mut().zip(&powers[class]) {
            *moment += coefficients.iter().zip(&bands[class]).map(|(c, moment)| c * moment).sum::<f64>();
        }
    }
    (values, bands)
}

/// Sums over m and aliases, terms of the same shell side by side: power moments above the highest cut-off, and
/// Chebyshev moments of the bands.
struct Sums<'a> {
    /// Cut-offs, squared.
    squares: &'a [f64],
    lateral: &'a [Weighted],
    /// Explicit aliases, then those beyond every cut-off.
    aliases: [&'a [Weighted]; 2],
    bands: &'a mut [[f64; BAND_TERMS]],
}

/// Terms of one shell (between two cut-offs) that wait until they fill a vector.
#[derive(Clone, Copy)]
struct Waiting {
    weights: [f64; MOST_LANES],
    k_squared: [f64; MOST_LANES],
    count: usize,
}

impl WithSimd for Sums<'_> {
    type Output = [f64; TERMS];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; TERMS] {
        let Self { squares, lateral, aliases: [explicit, far], bands } = self;
        let count = squares.len();
        let nothing = Waiting { weights: [0.0; MOST_LANES], k_squared: [squares[0]; MOST_LANES], count: 0 };
        let mut waiting = vec![nothing; count + 1];
        let zero = simd.splat_f64s(0.0);
        let mut sums = ShellSums { simd, squares, bands: vec![[zero; BAND_TERMS]; count], above: [zero; TERMS] };
        for &(ky_squared, lateral) in lateral {
            // Number of cut-offs at or below k; that of the next alias is the same or a neighbour.
            let mut shell = 0;
            for &(kx_squared, longitudinal) in explicit {
                let k_squared = kx_squared + ky_squared;
                while shell < count && squares[shell] <= k_squared {
                    shell += 1;
                }
                while shell > 0 && squares[shell - 1] > k_squared {
                    shell -= 1;
                }
                if shell > 0 {
                    sums.push(&mut waiting[shell], shell, lateral * longitudinal, k_squared);
                }
            }
            for &(kx_squared, longitudinal) in far {
                sums.push(&mut waiting[count], count, lateral * longitudinal, kx_squared + ky_squared);
            }
        }
        for (shell, waiting) in waiting.iter_mut().enumerate().skip(1) {
            waiting.weights[waiting.count..].fill(0.0);
            sums.add(waiting, shell);
        }
        for (band, sums) in bands.iter_mut().zip(&sums.bands) {
            *band = sums.map(|sum| simd.reduce_sum_f64s(sum));
        }
        sums.above.map(|sum| simd.reduce_sum_f64s(sum))
    }
}

/// Sums of [`Sums`], lane by lane.
struct ShellSums<'a, S: Simd> {
    simd: S,
    squares: &'a [f64],
    bands: Vec<[S::f64s; BAND_TERMS]>,
    above: [S::f64s; TERMS],
}

impl<S: Simd> ShellSums<'_, S> {
    #[inline(always)]
    fn push(&mut self, waiting: &mut Waiting, shell: usize, weight: f64, k_squared: f64) {
        waiting.weights[waiting.count] = weight;
        waiting.k_squared[waiting.count] = k_squared;
        waiting.count += 1;
        if waiting.count == S::F64_LANES {
            self.add(waiting, shell);
            waiting.count = 0;
        }
    }

    #[inline(always)]
    fn add(&mut self, waiting: &Waiting, shell: usize) {
        let (weight, k_squared) = (load(self.simd, &waiting.weights), load(self.simd, &waiting.k_squared));
        if shell == self.squares.len() {
            add(self.simd, &mut self.above, weight, k_squared);
        } else {
            let band = [self.squares[shell - 1], self.squares[shell]];
            half_space_bands::add(self.simd, &mut self.bands[shell - 1], weight, k_squared, band);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::waves::Waves;
    use super::*;
    use crate::scene::Sides;

    /// A strip of a fraction of the width, 64 elements round.
    fn projection(share: f64, sides: Sides) -> Projection {
        Projection {
            waves: Waves { circumference: 1.95, width: 0.2, sides },
            contact_width: 0.2 * share,
            element: 1.95 / 64.0,
            elements: 64,
        }
    }

    fn shares() -> impl Iterator<Item = (f64, Sides)> {
        [Sides::Supported, Sides::Guided]
            .into_iter()
            .flat_map(|sides| [0.35, 0.6, 0.75, 0.98, 1.0].map(|share| (share, sides)))
    }

    /// M_0 above everything explicit, against sums term by term to m and p so far out that halving estimates the
    /// remainder to 1e-9.
    #[test]
    fn moments_equal_sums_that_go_much_further() {
        for (share, sides) in shares() {
            let projection = projection(share, sides);
            let classes = TailClasses::new(700.0, 900.0);
            let moments = Moments::new(&projection, &classes);
            for n in [1, 13, 32] {
                let straight = |most_m: usize, most_p: i64| -> f64 {
                    let aliases: Vec<_> = (-most_p..=most_p).map(|p| n as i64 + p * 64).collect();
                    let shape: Vec<_> = aliases
                        .iter()
                        .map(|&a| (projection.waves.kx(a).powi(2), projection.longitudinal_weight(a)))
                        .collect();
                    let mut sum = 0.0;
                    for m in (projection.waves.first_lateral_number()..most_m).step_by(2) {
                        let (ky, weight) = (projection.waves.ky(m), projection.lateral_weight(m));
                        for &(kx_squared, longitudinal) in &shape {
                            let k_squared = kx_squared + ky * ky;
                            if k_squared >= 700.0 * 700.0 {
                                sum += weight * longitudinal / k_squared.sqrt();
                            }
                        }
                    }
                    sum
                };
                // Both remainders fall like the square of the number of terms: extrapolated.
                let (near, far) = (straight(2001, 100), straight(4001, 200));
                let exact = far + (far - near) / 3.0;
                let error = (moments.of(n, 0)[0] - exact).abs() / exact;
                assert!(
                    error < 3e-6 && (moments.of(n, 0)[0] - far).abs() < 1e-3 * far,
                    "b/B {share}, {sides:?}, n {n}: {error:.1e}"
                );
            }
        }
    }

    #[test]
    fn moments_do_not_depend_on_where_explicit_terms_end() {
        for (share, sides) in shares() {
            let projection = projection(share, sides);
            let of = |largest: f64| Moments::new(&projection, &TailClasses::new(700.0, largest));
            let (near, far) = (of(900.0), of(12_000.0));
            for n in [0, 1, 13, 32] {
                for (j, (a, b)) in near.of(n, 0).iter().zip(far.of(n, 0)).enumerate() {
                    // A guided strip of the whole width is excited by no m but 0.
                    let error = (a - b).abs() / b.max(1e-9 * far.of(1, 0)[j]);
                    // Far lobes, whose k hardly changes with m, have the largest error of the integral over m.
                    assert!(error < 5e-10, "b/B {share}, {sides:?}, n {n}, moment {j}: {error:.1e}");
                }
            }
        }
    }
}
