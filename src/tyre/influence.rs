//! Influence functions by wavenumber summation.
//!
//! A contact element, dx long and b wide and loaded uniformly, with its mean displacement observed, has in the
//! wavenumber n
//!
//! ```text
//! H_n(s) = (1/L) sinc^2(kx dx/2) sum_(m odd) (2/B) a_m^2 C_zz(kx_n, ky_m, s),   a_m = mean of sin(ky y) over the strip,
//! Ht_n   = sum_p H_(n + p N):   what a sequence of N elements sees of the wavenumber n.
//! ```
//!
//! Ways to the double sum over p and m, all selectable:
//! - [`Truncation::Tail`]: C_zz is evaluated up to a wavenumber where the tread has become a half-space; above, first
//!   the bands of [`super::half_space_bands`], then, from k_c on, the asymptotic series of
//!   [`super::surface_asymptote`], both with moments that are summed once for all s. Needs a tread without tension.
//! - [`Truncation::Bounded`]: C_zz is evaluated until a bound on the rest, from the half-space's compliance, is below
//!   the tolerance. The reference.
//! - [`Truncation::Fixed`]: a fixed number of m and p, for comparisons.
//!
//! Cost: `Tail` some 30 evaluations of C_zz for each n and s (N = 512), `Bounded` some thousands at a tolerance of
//! 1e-7.

use std::f64::consts::PI;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::compliance::{Stack, StackAt};
use super::half_space_bands::{self, BAND_TERMS};
use super::moments::{Moments, TailClasses};
use super::surface_asymptote::{LARGEST_ARGUMENT, TERMS, series, thickness_limit};
use crate::numeric::Ring;
use crate::scene::{Numerics, Tyre};

/// Which displacement a force on the tread element is related to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Field {
    /// The tread surface.
    Surface,
    /// The innermost face, force on the surface.
    Bottom,
    /// The carcass driven directly under the outermost layer, which rides along as mass: what the springs of a bedding
    /// act on.
    UnderTread,
}

/// How the sums over m and p are ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Truncation {
    /// Explicit terms below a cut-off wavenumber, half-space moments above.
    Tail,
    /// Explicit terms until the rest is bounded by the tolerance.
    Bounded,
    /// `lateral_terms` odd m and |p| <= `aliases`; what is not given is bounded by the tolerance.
    Fixed {
        /// Number of odd m.
        lateral_terms: Option<usize>,
        /// Largest |p|.
        aliases: Option<usize>,
    },
}

/// sin(x)/x.
pub fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

/// Wavenumbers and weights of the sum: geometry only.
#[derive(Clone, Debug, PartialEq)]
pub struct Projection {
    /// Circumference L \[m\].
    pub circumference: f64,
    /// Plate width B \[m\].
    pub width: f64,
    /// Contact width b \[m\].
    pub contact_width: f64,
    /// Length of an element along x \[m\].
    pub element: f64,
    /// Number of elements N.
    pub elements: usize,
}

impl Projection {
    /// The projection of a tyre with N elements.
    pub fn new(tyre: &Tyre, elements: usize) -> Self {
        Self {
            circumference: tyre.circumference,
            width: tyre.width,
            contact_width: tyre.contact_width,
            element: tyre.circumference / elements as f64,
            elements,
        }
    }

    /// kx of the integer wavenumber n \[1/m\].
    pub fn kx(&self, n: i64) -> f64 {
        2.0 * PI * n as f64 / self.circumference
    }

    /// ky of the lateral number m \[1/m\].
    pub fn ky(&self, m: usize) -> f64 {
        PI * m as f64 / self.width
    }

    /// (1/L) sinc^2(kx dx/2) \[1/m\].
    pub fn longitudinal_weight(&self, n: i64) -> f64 {
        let shape = sinc(0.5 * self.kx(n) * self.element);
        shape * shape / self.circumference
    }

    /// (2/B) a_m^2 for odd m and a centred strip \[1/m\]; the sum over all odd m is 1/b.
    pub fn lateral_weight(&self, m: usize) -> f64 {
        let shape = sinc(0.5 * self.ky(m) * self.contact_width);
        2.0 / self.width * shape * shape
    }
}

/// The folded sums Ht_n(s) of one tyre at one resolution.
#[derive(Clone, Debug)]
pub struct InfluenceSum {
    pub(super) stack: Stack,
    pub(super) projection: Projection,
    truncation: Truncation,
    pub(super) tolerance: f64,
    asymptote: Option<Asymptote>,
    /// [ky, lateral weight] of odd m up to the largest cut-off; empty without a tail.
    lateral: Vec<[f64; 2]>,
}

/// The tail's series and moments.
#[derive(Clone, Debug)]
struct Asymptote {
    /// k h from which a layer is a half-space at rest.
    decay: f64,
    coefficients: [f64; TERMS],
    classes: TailClasses,
    moments: Moments,
}

/// The stack at one s, with what the sum needs to know of it.
#[derive(Clone, Debug)]
pub struct SumAt {
    pub(super) stack: StackAt,
    /// Class of the wavenumber below which the layered compliance is evaluated.
    explicit: usize,
    /// Chebyshev coefficients of the half-space in the bands from there to the class of the series.
    bands: Vec<[Complex64; BAND_TERMS]>,
    /// Class above which the series is used.
    class: usize,
    /// phi_j (Q/mu)^j/mu.
    tail: [Complex64; TERMS],
    /// Whether the series converges above the cut-off; where not, the rest is bounded instead.
    converges: bool,
}

/// A value of Ht_n with what it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InfluenceValue {
    /// Ht_n \[m/N\].
    pub value: Complex64,
    /// Evaluations of the compliance.
    pub evaluations: u64,
    /// Bound on what was left out, where it is bounded \[m/N\].
    pub omitted: f64,
}

impl SumAt {
    /// Whether the half-space's series converges above the largest cut-off.
    pub(super) fn converges(&self) -> bool {
        self.converges
    }
}

impl InfluenceSum {
    /// Prepares the sums. `largest_s` is the largest |s| at which they will be wanted (it sets the range of cut-offs).
    pub fn new(tyre: &Tyre, numerics: &Numerics, largest_s: f64) -> Self {
        let truncation = match (numerics.lateral_terms, numerics.wavenumber_aliases) {
            (None, None) => Truncation::Tail,
            (lateral_terms, aliases) => Truncation::Fixed { lateral_terms, aliases },
        };
        let projection = Projection::new(tyre, numerics.elements);
        Self::with(tyre, projection, truncation, numerics.influence_tolerance, largest_s)
    }

    /// Prepares the sums with a given projection and truncation. A tread under tension has no half-space tail: `Tail`
    /// then becomes `Bounded`.
    pub fn with(tyre: &Tyre, projection: Projection, truncation: Truncation, tolerance: f64, largest_s: f64) -> Self {
        let stack = Stack::new(tyre);
        let tread = stack.layers().last().filter(|tread| !tread.is_tense()).cloned();
        let (truncation, asymptote) = match (truncation, tread) {
            (Truncation::Tail, Some(tread)) => {
                let at = stack.at(Complex64::new(largest_s, 0.0));
                let ratio = at.tread().inertia * at.tread().inverse_shear;
                let largest = (ratio.norm() / LARGEST_ARGUMENT).sqrt();
                let smallest = thickness_limit(tread.thickness, tolerance);
                let classes = TailClasses::new(smallest, largest);
                let moments = Moments::new(&projection, &classes);
                let coefficients = series(super::material::modulus_ratio(tread.material.poisson));
                let decay = smallest * tread.thickness;
                (Truncation::Tail, Some(Asymptote { decay, coefficients, classes, moments }))
            }
            (Truncation::Tail, None) => (Truncation::Bounded, None),
            (other, _) => (other, None),
        };
        let highest = asymptote.as_ref().map_or(0.0, |asymptote: &Asymptote| asymptote.classes.highest());
        let lateral = (1..)
            .step_by(2)
            .map(|m| [projection.ky(m), projection.lateral_weight(m)])
            .take_while(|[ky, _]| *ky < highest)
            .collect();
        Self { stack, projection, truncation, tolerance, asymptote, lateral }
    }

    /// [ky, weight] of the odd m below the largest cut-off; empty where the sums have no tail.
    pub(super) fn lateral(&self) -> &[[f64; 2]] {
        &self.lateral
    }

    /// Square of the wavenumber below which the layered compliance is evaluated for the surface \[1/m^2\].
    pub(super) fn cut_off_squared(&self, at: &SumAt) -> f64 {
        self.asymptote.as_ref().map_or(f64::INFINITY, |asymptote| asymptote.classes.cut_off(at.explicit).powi(2))
    }

    /// The surface's share of all wavenumbers above that cut-off.
    pub(super) fn half_space_rest(&self, n: usize, at: &SumAt) -> Complex64 {
        let Some(asymptote) = &self.asymptote else { return Complex64::ZERO };
        if !at.converges {
            return Complex64::ZERO;
        }
        let moments = asymptote.moments.of(n, at.class);
        let mut rest = at.tail.iter().zip(moments).map(|(&c, &moment)| c * moment).sum::<Complex64>();
        for (class, coefficients) in (at.explicit..).zip(&at.bands) {
            let moments = asymptote.moments.band(n, class);
            rest += coefficients.iter().zip(moments).map(|(&c, &moment)| c * moment).sum::<Complex64>();
        }
        rest
    }

    /// The wavenumbers and weights.
    pub fn projection(&self) -> &Projection {
        &self.projection
    }

    /// How the sums are ended.
    pub fn truncation(&self) -> &Truncation {
        &self.truncation
    }

    /// Moduli, cut-off and tail series at s.
    pub fn at(&self, s: Complex64) -> SumAt {
        let stack = self.stack.at(s);
        let (mut class, mut tail, mut converges) = (0, [Complex64::ZERO; TERMS], true);
        let (mut explicit, mut bands) = (0, Vec::new());
        if let Some(asymptote) = &self.asymptote {
            let tread = stack.tread();
            let ratio = tread.inertia * tread.inverse_shear;
            (class, converges) = asymptote.classes.choose((ratio.norm() / LARGEST_ARGUMENT).sqrt());
            let mut power = tread.inverse_shear;
            for (entry, coefficient) in tail.iter_mut().zip(asymptote.coefficients) {
                *entry = power * coefficient;
                power *= ratio;
            }
            let classes = &asymptote.classes;
            let smooth = |class: usize| {
                half_space_bands::is_half_space(tread, classes.cut_off(class), asymptote.decay)
                    && half_space_bands::is_resolved(tread, classes.band(class), self.tolerance)
            };
            explicit = class;
            while explicit > 0 && smooth(explicit - 1) {
                explicit -= 1;
            }
            bands = (explicit..class).map(|class| half_space_bands::coefficients(tread, classes.band(class))).collect();
        }
        SumAt { stack, explicit, bands, class, tail, converges }
    }

    /// Static influence of the element j further on, j = 0..N \[m/N\].
    pub fn static_row(&self, field: Field) -> Vec<f64> {
        let at_rest = self.at(Complex64::ZERO);
        Ring::new(self.projection.elements).elements_of(|n| self.value(n, &at_rest, field).value.re).to_vec()
    }

    /// Ht_n(s) of a field. `n` from 0 to N/2.
    pub fn value(&self, n: usize, at: &SumAt, field: Field) -> InfluenceValue {
        let compliance = |kx: f64, ky: f64| match field {
            Field::Surface => at.stack.normal(kx, ky).surface,
            Field::Bottom => at.stack.normal(kx, ky).bottom,
            Field::UnderTread => at.stack.under_tread(kx, ky),
        };
        match (&self.truncation, &self.asymptote) {
            (Truncation::Tail, Some(asymptote)) => self.with_tail(n, at, asymptote, field, compliance),
            (Truncation::Fixed { lateral_terms, aliases }, _) => {
                self.by_bound(n, at, *lateral_terms, *aliases, compliance)
            }
            _ => self.by_bound(n, at, None, None, compliance),
        }
    }

    fn with_tail(
        &self,
        n: usize,
        at: &SumAt,
        asymptote: &Asymptote,
        field: Field,
        compliance: impl Fn(f64, f64) -> Complex64,
    ) -> InfluenceValue {
        // The faces below do not see the half-space; they keep the larger cut-off.
        let class = if field == Field::Surface { at.explicit } else { at.class };
        let cut_off = asymptote.classes.cut_off(class);
        let (mut value, mut evaluations, mut explicit) = (Complex64::ZERO, 0, 0.0);
        let mut last = Complex64::ZERO;
        for alias in aliases_below(n, &self.projection, cut_off) {
            let kx = self.projection.kx(alias);
            let longitudinal = self.projection.longitudinal_weight(alias);
            let mut row = Complex64::ZERO;
            for m in (1..).step_by(2) {
                let ky = self.projection.ky(m);
                if kx * kx + ky * ky >= cut_off * cut_off {
                    break;
                }
                let weight = self.projection.lateral_weight(m);
                last = compliance(kx, ky);
                row += last * weight;
                explicit += weight * longitudinal;
                evaluations += 1;
            }
            value += row * longitudinal;
        }
        let mut omitted = 0.0;
        match field {
            // Above the cut-off the surface is the half-space's.
            Field::Surface if at.converges => {
                value += self.half_space_rest(n, at);
            }
            // Deeper faces move by exp(-k h) less; and where the series does not converge (|s| far above the sampling
            // frequency) the rest is bounded by the last value times the weight that is left.
            _ => {
                let all = 1.0 / (self.projection.circumference * self.projection.contact_width);
                let rest = last * (0.5 * (all - explicit).max(0.0));
                if field == Field::Surface || field == Field::UnderTread {
                    value += rest;
                }
                omitted = rest.norm();
            }
        }
        InfluenceValue { value, evaluations, omitted }
    }
}

/// Integer wavenumbers n + p N with |kx| below the cut-off, p = 0, 1, -1, 2, ...
pub(super) fn aliases_below(n: usize, projection: &Projection, cut_off: f64) -> impl Iterator<Item = i64> + '_ {
    let largest = (cut_off * projection.circumference / (2.0 * PI)) as i64;
    let elements = projection.elements as i64;
    let n = n as i64;
    let most = (largest + n) / elements + 1;
    (0..=most)
        .flat_map(move |p| if p == 0 { [Some(n), None] } else { [Some(n + p * elements), Some(n - p * elements)] })
        .flatten()
        .filter(move |alias| alias.abs() <= largest)
}
