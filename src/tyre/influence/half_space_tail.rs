//! Contribution to the surface of all waves above a cut-off wavenumber, where the tread has become a half-space.
//!
//! From a first cut-off on, the bands of [`super::half_space_bands`], then, from k_c on, the asymptotic series of
//! [`surface_asymptote`](crate::tyre::layers::surface_asymptote), both with moments that are summed once for all s.

use num_complex::Complex64;

use super::half_space_bands::{self, BAND_TERMS};
use super::moments::{Moments, TailClasses};
use super::projection::{Lateral, Projection};
use crate::scene::Layer;
use crate::tyre::layers::layer::LayerAt;
use crate::tyre::layers::material::modulus_ratio;
use crate::tyre::layers::surface_asymptote::{LARGEST_ARGUMENT, TERMS, series, thickness_limit};

/// Series and moments of the tail.
#[derive(Clone, Debug)]
pub(super) struct HalfSpaceTail {
    tolerance: f64,
    /// k h from which on a layer is a half-space at rest.
    decay: f64,
    coefficients: [f64; TERMS],
    classes: TailClasses,
    moments: Moments,
    /// Lateral numbers up to the largest cut-off.
    pub(super) lateral: Vec<Lateral>,
}

/// The tail at one s.
#[derive(Clone, Debug)]
pub(super) struct HalfSpaceTailAt {
    /// Class of the wavenumber below which the layered compliance is evaluated.
    explicit: usize,
    /// Chebyshev coefficients of the half-space in the bands from there to the class of the series.
    bands: Vec<[Complex64; BAND_TERMS]>,
    /// Class above which the series is used.
    class: usize,
    /// phi_j (Q/mu)^j/mu.
    series: [Complex64; TERMS],
    /// True if the series converges above the largest cut-off; if not, the remainder is bounded instead.
    pub(super) converges: bool,
}

/// Wavenumber above which the series converges \[1/m\].
pub(super) fn series_limit(tread: &LayerAt<Complex64>) -> f64 {
    (tread.inertia_over_shear().norm() / LARGEST_ARGUMENT).sqrt()
}

#[cfg(test)]
impl HalfSpaceTailAt {
    pub(super) fn heap_bytes(&self) -> usize {
        self.bands.capacity() * size_of::<[Complex64; BAND_TERMS]>()
    }
}

impl HalfSpaceTail {
    /// Tail of a tread, given also at the largest s of use.
    pub(super) fn new(tread: &Layer, at_largest: &LayerAt<Complex64>, projection: &Projection, tolerance: f64) -> Self {
        let smallest = thickness_limit(tread.thickness, tolerance);
        let classes = TailClasses::new(smallest, series_limit(at_largest));
        Self {
            tolerance,
            decay: smallest * tread.thickness,
            coefficients: series(modulus_ratio(tread.material.poisson)),
            lateral: projection.lateral_below(classes.highest()),
            moments: Moments::new(projection, &classes),
            classes,
        }
    }

    /// `tread`: at the s wanted.
    pub(super) fn at(&self, tread: &LayerAt<Complex64>) -> HalfSpaceTailAt {
        let (classes, ratio) = (&self.classes, tread.inertia_over_shear());
        let (class, converges) = classes.choose(series_limit(tread));
        let mut power = tread.inverse_shear;
        let series = self.coefficients.map(|coefficient| {
            let term = power * coefficient;
            power *= ratio;
            term
        });
        // The explicit terms end as low as bands of the half-space are valid and resolved.
        let smooth = |class: usize| {
            half_space_bands::is_half_space(tread, classes.cut_off(class), self.decay)
                && half_space_bands::is_resolved(tread, classes.band(class), self.tolerance)
        };
        let mut explicit = class;
        while explicit > 0 && smooth(explicit - 1) {
            explicit -= 1;
        }
        let bands = (explicit..class).map(|class| half_space_bands::coefficients(tread, classes.band(class))).collect();
        HalfSpaceTailAt { explicit, bands, class, series, converges }
    }

    /// Wavenumber below which the layered compliance is evaluated \[1/m\]. The faces below the surface have no
    /// half-space limit; they keep the larger cut-off of the series.
    pub(super) fn cut_off(&self, at: &HalfSpaceTailAt, surface: bool) -> f64 {
        self.classes.cut_off(if surface { at.explicit } else { at.class })
    }

    /// Contribution to the surface of all waves of n above its cut-off \[m/N\], where the series converges.
    pub(super) fn rest(&self, n: usize, at: &HalfSpaceTailAt) -> Complex64 {
        let moments = self.moments.of(n, at.class);
        let mut rest = at.series.iter().zip(moments).map(|(&c, &moment)| c * moment).sum::<Complex64>();
        for (class, coefficients) in (at.explicit..).zip(&at.bands) {
            let moments = self.moments.band(n, class);
            rest += coefficients.iter().zip(moments).map(|(&c, &moment)| c * moment).sum::<Complex64>();
        }
        rest
    }
}
