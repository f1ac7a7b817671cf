//! The sums: a contact element, dx long and b wide and loaded uniformly, with its mean displacement observed, has for
//! the wavenumber n
//!
//! ```text
//! H_n(s) = (1/L) sinc^2(kx dx/2) sum_(m odd) (2/B) a_m^2 C_zz(kx_n, ky_m, s),
//! a_m    = mean of sin(ky y) over the strip,
//! Ht_n   = sum_p H_(n + p N):   the wavenumber n as a sequence of N elements samples it.
//! ```
//!
//! The double sum over p and m can be ended in three ways:
//! - [`Truncation::Tail`]: C_zz is evaluated up to a wavenumber where the tread has become a half-space; what is above
//!   takes no evaluation (`super::half_space_tail`). Needs a tread without tension.
//! - [`Truncation::Bounded`]: C_zz is evaluated until a bound on the remainder, from the half-space's compliance, is
//!   below the tolerance. The reference.
//! - [`Truncation::Fixed`]: a fixed number of m and p, for comparisons.
//!
//! With rotation, H_n and H_-n differ: H_n = E_n + i O_n, E_n = (H_n + H_-n)/2 and O_n = (H_n - H_-n)/2i. Both are
//! real functions of s, real at real s and conjugate at conjugate s. O is 0 at rest, of n = 0 and of n = N/2, which
//! stands for both of its signs.
//!
//! Waves of a curved tyre below the tread's thickness count as flat in all of them; the effect of curvature on those is
//! added to the first two (`super::short_waves`).
//!
//! Cost: `Tail` some 30 evaluations of C_zz for each n and s (N = 512), `Bounded` some thousands at a tolerance of
//! 1e-7.

use std::f64::consts::PI;
use std::sync::Arc;

use num_complex::Complex64;

use super::half_space_tail::{HalfSpaceTail, HalfSpaceTailAt, series_limit};
use super::kernel::{Field, Kernel, KernelAt};
use super::moments::{self, EXPLICIT_ALIASES};
use super::projection::Projection;
use super::short_waves::{self, ShortWaves, SumChange};
use crate::numeric::{Ring, in_parallel};
use crate::scene::{Numerics, Tyre};
use crate::tyre::layers::curved::sidewall_bytes;

/// How the sums over m and p are ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Truncation {
    /// Explicit terms below a cut-off wavenumber, half-space moments above.
    Tail,
    /// Explicit terms until the remainder is bounded by the tolerance.
    Bounded,
    /// `lateral_terms` odd m and |p| <= `aliases`; one that is `None` is bounded by the tolerance.
    Fixed {
        /// Number of odd m; `None`: until the bound.
        lateral_terms: Option<usize>,
        /// Largest |p|; `None`: until the bound.
        aliases: Option<usize>,
    },
}

/// The folded sums Ht_n(s) of one tyre at one resolution.
#[derive(Clone, Debug)]
pub struct InfluenceSum {
    pub(super) kernel: Kernel,
    pub(super) projection: Projection,
    pub(super) tolerance: f64,
    turns: bool,
    /// Half-space tail; `None`: the sums are ended by a bound, or by the numbers below.
    pub(super) tail: Option<HalfSpaceTail>,
    /// Effect of curvature on waves that are evaluated as flat.
    curvature: Option<Arc<Curvature>>,
    /// Number of odd m, if fixed.
    pub(super) lateral_terms: Option<usize>,
    /// Largest |p|, if fixed.
    pub(super) aliases: Option<usize>,
}

/// Kernel, tail and effect of curvature at one s.
#[derive(Clone, Debug)]
pub struct SumAt {
    pub(super) kernel: KernelAt,
    pub(super) tail: Option<HalfSpaceTailAt>,
    curvature: Option<SumChange<Complex64>>,
}

/// Most bytes of a [`SumAt`]: of a flat tyre, of a curved one, and of one that turns. A test counts them for the
/// default tyres up to the time steps of 2048 elements.
const POINT_BYTES: [f64; 3] = [6e3, 2e4, 3e4];

/// Short waves of a curved tyre, and moments of the sum's weights for n = 0..=N/2.
#[derive(Debug)]
struct Curvature {
    waves: ShortWaves,
    moments: Vec<SumChange<f64>>,
}

/// A value of Ht_n and its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InfluenceValue {
    /// Ht_n \[m/N\]; of a tyre that turns its even part E_n.
    pub value: Complex64,
    /// Odd part O_n \[m/N\].
    pub odd: Complex64,
    /// Evaluations of the compliance used.
    pub evaluations: u64,
}

impl InfluenceSum {
    /// Truncation and tolerance as `numerics` has them. `largest_s`: largest |s| of use \[1/s\], which sets the range
    /// of cut-offs.
    pub fn new(tyre: &Tyre, numerics: &Numerics, largest_s: f64) -> Self {
        let truncation = match (numerics.lateral_terms, numerics.wavenumber_aliases) {
            (None, None) => Truncation::Tail,
            (lateral_terms, aliases) => Truncation::Fixed { lateral_terms, aliases },
        };
        let projection = Projection::new(tyre, numerics.elements);
        Self::with(tyre, projection, truncation, numerics.influence_tolerance, largest_s)
    }

    /// With a given projection and truncation. A tread under tension has no half-space tail: `Tail` then becomes
    /// `Bounded`.
    pub fn with(tyre: &Tyre, projection: Projection, truncation: Truncation, tolerance: f64, largest_s: f64) -> Self {
        Self::prepared(tyre, projection, truncation, tolerance, largest_s, true)
    }

    /// For a coarse [`Self::static_row`] alone: the effect of curvature on the short waves, 6e-5 of them at rest and
    /// half of the work, is left out.
    pub fn coarse_at_rest(tyre: &Tyre, projection: Projection, tolerance: f64) -> Self {
        Self::prepared(tyre, projection, Truncation::Tail, tolerance, 1.0, false)
    }

    fn prepared(
        tyre: &Tyre,
        projection: Projection,
        truncation: Truncation,
        tolerance: f64,
        largest_s: f64,
        short_waves: bool,
    ) -> Self {
        let kernel = Kernel::new(tyre, largest_s, tolerance);
        let tread = kernel.tread().filter(|_| truncation == Truncation::Tail);
        let tail = tread.map(|tread| {
            let at_largest = kernel.at(Complex64::new(largest_s, 0.0));
            HalfSpaceTail::new(tread, at_largest.tread(), &projection, tolerance)
        });
        let (lateral_terms, aliases) = match truncation {
            Truncation::Fixed { lateral_terms, aliases } => (lateral_terms, aliases),
            Truncation::Tail | Truncation::Bounded => (None, None),
        };
        let fixed = matches!(truncation, Truncation::Fixed { .. });
        let curvature = kernel.flat_from().filter(|_| short_waves && !fixed && kernel.tread().is_some()).map(|from| {
            let at_largest = kernel.at(Complex64::new(largest_s, 0.0));
            let limit = series_limit(at_largest.tread());
            Arc::new(Curvature::new(ShortWaves::new(tyre, from, limit, largest_s, tolerance), &projection))
        });
        let turns = tyre.curvature && tyre.turns();
        Self { kernel, projection, tolerance, turns, tail, curvature, lateral_terms, aliases }
    }

    /// True if H_n and H_-n differ: odd parts are then not zero.
    pub fn turns(&self) -> bool {
        self.turns
    }

    /// Most bytes of [`Self::at_all`] at so many s.
    pub fn expected_bytes(tyre: &Tyre, points: usize) -> f64 {
        let point_bytes = POINT_BYTES[usize::from(tyre.curvature) + usize::from(tyre.curvature && tyre.turns())];
        points as f64 * (point_bytes + sidewall_bytes(tyre))
    }

    /// Wavenumbers and weights of the contact elements.
    pub fn projection(&self) -> &Projection {
        &self.projection
    }

    /// Moduli, cut-off and tail series at s \[1/s\].
    pub fn at(&self, s: Complex64) -> SumAt {
        self.with_kernel(self.kernel.at(s), self.curvature.as_ref().map(|curvature| curvature.waves.at(s)))
    }

    /// [`Self::at`] for each s of a list, on all threads: of a curved tyre several s in lockstep.
    pub fn at_all(&self, points: &[Complex64]) -> Vec<SumAt> {
        let Some(curvature) = &self.curvature else {
            return in_parallel::map(points, |&s| self.at(s));
        };
        let changes = curvature.waves.at_all(points);
        let kernels = in_parallel::map(points, |&s| self.kernel.at(s));
        let both = kernels.into_iter().zip(changes);
        both.map(|(kernel, change)| self.with_kernel(kernel, Some(change))).collect()
    }

    fn with_kernel(&self, kernel: KernelAt, curvature: Option<SumChange<Complex64>>) -> SumAt {
        SumAt { tail: self.tail.as_ref().map(|tail| tail.at(kernel.tread())), kernel, curvature }
    }

    /// Addition to Ht_n of the surface by the curvature of waves that are evaluated as flat \[m/N\].
    pub(super) fn by_curvature(&self, n: usize, at: &SumAt) -> Complex64 {
        match (&self.curvature, &at.curvature) {
            (Some(curvature), Some(change)) => short_waves::sum(&change.even, &curvature.moments[n].even),
            _ => Complex64::ZERO,
        }
    }

    /// As [`Self::by_curvature`], of the odd part.
    pub(super) fn odd_by_curvature(&self, n: usize, at: &SumAt) -> Complex64 {
        match (&self.curvature, &at.curvature) {
            // The odd parts of n = 0 and N/2, which stand for both signs, are 0.
            (Some(curvature), Some(change)) if n > 0 && 2 * n < self.projection.elements => {
                short_waves::sum(&change.odd, &curvature.moments[n].odd)
            }
            _ => Complex64::ZERO,
        }
    }

    /// Sign of an alias' odd part in that of Ht_n; 0 for n = 0 and N/2, which stand for both signs.
    pub(super) fn sign_of_odd(&self, n: usize, alias: i64) -> f64 {
        if n == 0 || 2 * n == self.projection.elements { 0.0 } else { alias.signum() as f64 }
    }

    /// Static influence of an element on that j elements further on, j = 0..N \[m/N\].
    pub fn static_row(&self, field: Field) -> Vec<f64> {
        let change = self.curvature.as_ref().filter(|_| field == Field::Surface);
        let at_rest = self.with_kernel(self.kernel.at_rest(), change.map(|curvature| curvature.waves.resting()));
        self.row(&at_rest, field)
    }

    /// As [`Self::static_row`] at a real s \[1/s\]: at delta(0)/dt it is the influence within a step; of a tyre that
    /// turns its even part.
    pub fn row_at(&self, s: f64, field: Field) -> Vec<f64> {
        self.row(&self.at(Complex64::from(s)), field)
    }

    fn row(&self, at: &SumAt, field: Field) -> Vec<f64> {
        let of = |n| self.value(n, at, field).value.re;
        let values = in_parallel::made(self.projection.elements / 2 + 1, of);
        Ring::new(self.projection.elements).elements_of(|n| values[n]).to_vec()
    }

    /// Ht_n(s) of a field, for n from 0 to N/2.
    pub fn value(&self, n: usize, at: &SumAt, field: Field) -> InfluenceValue {
        match (&self.tail, &at.tail) {
            (Some(tail), Some(tail_at)) => self.with_tail(n, at, (tail, tail_at), field),
            _ => self.by_bound(n, at, field),
        }
    }

    fn with_tail(
        &self,
        n: usize,
        at: &SumAt,
        (tail, tail_at): (&HalfSpaceTail, &HalfSpaceTailAt),
        field: Field,
    ) -> InfluenceValue {
        let cut_off = tail.cut_off(tail_at, field == Field::Surface);
        let (mut value, mut evaluations, mut explicit) = (Complex64::ZERO, 0, 0.0);
        let (mut last, mut odd) = (Complex64::ZERO, Complex64::ZERO);
        // 1. Explicit terms below the cut-off.
        for alias in self.projection.aliases_below(n, cut_off) {
            let kx = self.projection.waves.kx(alias);
            let longitudinal = self.projection.longitudinal_weight(alias);
            let (mut row, mut odd_row) = (Complex64::ZERO, Complex64::ZERO);
            for lateral in &tail.lateral {
                if kx * kx + lateral.ky * lateral.ky >= cut_off * cut_off {
                    break;
                }
                if self.turns {
                    let parts = at.kernel.normal_parts(alias.abs(), lateral.m, field);
                    last = parts.even;
                    odd_row += parts.odd * lateral.weight;
                } else {
                    last = at.kernel.normal(alias, lateral.m, field);
                }
                row += last * lateral.weight;
                explicit += lateral.weight * longitudinal;
                evaluations += 1;
            }
            value += row * longitudinal;
            odd += odd_row * (longitudinal * self.sign_of_odd(n, alias));
        }
        // 2. Above the cut-off the surface is the half-space's.
        if field == Field::Surface && tail_at.converges {
            let value = value + tail.rest(n, tail_at) + self.by_curvature(n, at);
            return InfluenceValue { value, odd: odd + self.odd_by_curvature(n, at), evaluations };
        }
        // 3. Where the series does not converge, half of the bound. Deeper faces move by exp(-k h) less.
        if field != Field::Bottom {
            value += bounded_rest(last, &self.projection, explicit);
        }
        InfluenceValue { value, odd, evaluations }
    }
}

/// Remainder of a sum whose series does not converge (|s| far above the sampling frequency), from the last value and
/// the `weight` summed so far: half of its bound.
pub(super) fn bounded_rest(last: Complex64, projection: &Projection, weight: f64) -> Complex64 {
    last * (0.5 * (projection.total_weight() - weight).max(0.0))
}

impl Curvature {
    fn new(waves: ShortWaves, projection: &Projection) -> Self {
        let lateral = moments::lateral(projection, waves.highest());
        let lobes = (waves.highest() * projection.element / (2.0 * PI)) as i64 + EXPLICIT_ALIASES;
        let of = |n| waves.moments(&moments::signed_longitudinal(projection, n, lobes).concat(), &lateral);
        let moments = in_parallel::made(projection.elements / 2 + 1, of);
        Self { waves, moments }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DEFAULT, PLATE, Scene, TimeRule};
    use crate::tyre::influence::convolution_quadrature::Contour;

    #[test]
    fn the_kernel_on_a_contour_holds_no_more_than_is_expected() {
        let mut misses = Vec::new();
        for (text, angular_velocity) in [(PLATE, 0.0), (DEFAULT, 0.0), (DEFAULT, -70.0)] {
            for (elements, tolerance) in [(256, 1e-4), (512, 1e-7), (2048, 1e-5)] {
                let tyre = Scene::from_str(text, "default").unwrap().scene.tyre;
                let tyre = Tyre { angular_velocity, ..tyre };
                // Bands of waves belong to s, moments to elements: few of these make it quick.
                let projection = Projection::new(&tyre, 32);
                let time_step = tyre.circumference / (elements as f64 * 22.2);
                let contour = Contour::new(TimeRule::Bdf2, time_step, 40).points;
                let largest = contour.iter().map(|s| s.norm()).fold(0.0, f64::max);
                let sum = InfluenceSum::with(&tyre, projection, Truncation::Tail, tolerance, largest);
                let bytes: usize = sum.at_all(&contour).iter().map(bytes).sum();
                let expected = InfluenceSum::expected_bytes(&tyre, contour.len());
                let each = bytes / contour.len();
                println!("N = {elements}, {tolerance:e}, curved: {}: {each} bytes each", tyre.curvature);
                if bytes as f64 > expected {
                    misses.push(format!("N = {elements}, {tolerance:e}: {bytes} bytes held, {expected} expected"));
                }
            }
        }
        assert!(misses.is_empty(), "{misses:#?}");
    }

    fn turning() -> Tyre {
        let tyre = Scene::from_str(DEFAULT, "default").unwrap().scene.tyre;
        Tyre { angular_velocity: -69.4 / tyre.radius(), ..tyre }
    }

    #[test]
    fn sums_of_a_tyre_that_turns_are_those_over_signed_aliases() {
        let tyre = turning();
        let fixed = Truncation::Fixed { lateral_terms: Some(3), aliases: Some(2) };
        let sum = InfluenceSum::with(&tyre, Projection::new(&tyre, 48), fixed, 1e-6, 5e4);
        assert!(sum.turns());
        for s in [Complex64::new(0.0, 600.0), Complex64::new(0.0, -600.0), Complex64::new(2e4, 0.0)] {
            let at = sum.at(s);
            for n in [0, 1, 5, 23, 24] {
                let signed = |n: i64| {
                    let mut total = Complex64::ZERO;
                    for alias in (-2..=2).map(|p| n + 48 * p) {
                        let longitudinal = sum.projection.longitudinal_weight(alias);
                        for m in sum.projection.waves.lateral_numbers().take(3) {
                            let weight = longitudinal * sum.projection.lateral_weight(m);
                            total += at.kernel.normal(alias, m, Field::Surface) * weight;
                        }
                    }
                    total
                };
                let found = sum.value(n, &at, Field::Surface);
                let (forwards, backwards) = (signed(n as i64), signed(-(n as i64)));
                let size = forwards.norm();
                let even = (forwards + backwards) * 0.5;
                assert!((found.value - even).norm() < 1e-11 * size, "n {n}, s {s}");
                let odd = if n == 24 { Complex64::ZERO } else { (forwards - backwards) / Complex64::new(0.0, 2.0) };
                assert!((found.odd - odd).norm() < 1e-11 * size, "n {n}, s {s}: {} {odd}", found.odd);
                if s.im == 0.0 {
                    assert!(found.value.im.abs() < 1e-12 * size && found.odd.im.abs() < 1e-12 * size);
                }
            }
        }
    }

    #[test]
    fn turning_lanes_and_bounded_sums_are_the_scalar_sums() {
        let tyre = turning();
        let points = [0.0, 60.0, 600.0, 6e3, 2e4].map(|w| Complex64::new(0.0, w));
        let points: Vec<_> = points.into_iter().chain([Complex64::new(1e4, 0.0), Complex64::new(3e3, -4e3)]).collect();
        let of =
            |(truncation, tolerance)| InfluenceSum::with(&tyre, Projection::new(&tyre, 48), truncation, tolerance, 3e4);
        let (tail, bounded) = (of((Truncation::Tail, 1e-5)), of((Truncation::Bounded, 3e-6)));
        let (at, at_bounded) = (tail.at_all(&points), bounded.at_all(&points));
        for (n, driven) in [(0, Field::Surface), (3, Field::Surface), (17, Field::UnderTread), (24, Field::Surface)] {
            let mut faces = Vec::new();
            tail.faces(n, &at, driven, &mut faces);
            let at_rest = tail.value(n, &at[0], driven).value.norm();
            for (((faces, at), at_bounded), s) in faces.iter().zip(&at).zip(&at_bounded).zip(&points) {
                let (scalar, bottom) = (tail.value(n, at, driven), tail.value(n, at, Field::Bottom));
                let size = scalar.value.norm();
                for (found, wanted) in [(faces.driven, scalar.value), (faces.odd[0], scalar.odd)] {
                    assert!((found - wanted).norm() < 1e-10 * size, "{driven:?}, n {n}, s {s}: {found} {wanted}");
                }
                for (found, wanted) in [(faces.bottom, bottom.value), (faces.odd[1], bottom.odd)] {
                    assert!((found - wanted).norm() < 1e-5 * size, "belt, n {n}, s {s}: {found} {wanted}");
                }
                let exact = bounded.value(n, at_bounded, driven);
                // The bound's tolerance is of the static value; at 3 kHz that is thousands of times the value. The
                // tail's remainder under the tread is half of its bound, and relative to the static value, too.
                let allowed = match driven {
                    Field::Surface => 3e-6 * at_rest + 1e-5 * size,
                    _ => 1e-4 * at_rest,
                };
                let off = [(scalar.value - exact.value).norm(), (scalar.odd - exact.odd).norm()];
                println!(
                    "{driven:?}, n {n}, s {s}: odd {:.1e}, tail {:?}",
                    exact.odd.norm() / size,
                    off.map(|o| o / size)
                );
                assert!(off[0] < allowed, "{driven:?}, n {n}, s {s}: {off:?}");
                assert!(off[1] < 1e-5 * size, "{driven:?}, n {n}, s {s}: {off:?}");
                assert!((n % 24 > 0) == (exact.odd.norm() > 0.0 && s.norm() > 0.0) || s.norm() == 0.0);
            }
        }
    }

    /// Bytes of its series; those of the layers are few.
    fn bytes(at: &SumAt) -> usize {
        let curvature = at
            .curvature
            .as_ref()
            .map_or(0, |change| (change.even.capacity() + change.odd.capacity()) * size_of_val(&change.even[0]));
        let tail = at.tail.as_ref().map_or(0, HalfSpaceTailAt::heap_bytes);
        size_of_val(at) + curvature + tail
    }
}
