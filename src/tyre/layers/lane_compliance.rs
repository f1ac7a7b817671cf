//! Compliance for normal traction at several values of s in lockstep.
//!
//! Same formulas as [`super::compliance`] over [`Lanes`]: one wavenumber, several s. Where lanes need different
//! methods for a layer both are evaluated and the results blended; lanes that need slices (grazing waves, rare) are
//! redone one by one.

use num_complex::Complex64;
use pulp::Simd;

use super::anisotropic::FlatLayers;
use super::compliance::{NormalCompliance, StackAt};
use super::layer::{Exponents, FaceState, LayerAt, LayerMethod, LayerResult, choose_method};
use super::matrix2::Matrix2;
use crate::numeric::lanes::{load, store};
use crate::numeric::{ComplexField, Lanes, MOST_LANES};

/// A stack at several values of s.
#[derive(Clone, Debug)]
pub(crate) struct LaneStack<'a, S: Simd> {
    lanes: StackAt<Lanes<S>>,
    single: [&'a StackAt; MOST_LANES],
}

impl<'a, S: Simd> LaneStack<'a, S> {
    /// `single`: stacks of the same tyre, one per lane.
    pub(crate) fn new(simd: S, single: [&'a StackAt; MOST_LANES]) -> Self {
        let layer = |(index, layer): (usize, &LayerAt<Complex64>)| LayerAt {
            thickness: layer.thickness,
            shear: Lanes::from_fn(simd, |lane| single[lane].layers[index].shear),
            inverse_shear: Lanes::from_fn(simd, |lane| single[lane].layers[index].inverse_shear),
            modulus_ratio: layer.modulus_ratio,
            inertia: Lanes::from_fn(simd, |lane| single[lane].layers[index].inertia),
            prestress: layer.prestress,
        };
        let layers = single[0].layers.iter().enumerate().map(layer).collect();
        let foundation = [0, 1].map(|axis| Lanes::from_fn(simd, |lane| single[lane].foundation[axis]));
        let all: Vec<_> = single[..S::F64_LANES].iter().filter_map(|at| at.anisotropic.as_ref()).collect();
        let anisotropic = (!all.is_empty()).then(|| {
            let entry = |of: &dyn Fn(&FlatLayers<Complex64>) -> Complex64| Lanes::from_fn(simd, |lane| of(all[lane]));
            FlatLayers::in_lanes(&all, entry)
        });
        Self { lanes: StackAt { layers, foundation, anisotropic }, single }
    }

    /// Compliances at a wavenumber \[1/m\]. To be called within a `pulp` dispatch.
    #[inline(always)]
    pub(crate) fn normal(&self, kx: f64, ky: f64) -> NormalCompliance<Lanes<S>> {
        self.driven(kx, ky, true)
    }

    /// As [`Self::normal`], of the surface or, driven there, of the face under the tread: see
    /// [`StackAt::under_tread`].
    #[inline(always)]
    pub(crate) fn driven(&self, kx: f64, ky: f64, on_surface: bool) -> NormalCompliance<Lanes<S>> {
        if let Some(layers) = &self.lanes.anisotropic {
            if !layers.is_even(kx, ky) {
                let unknown = Lanes::zero(self.lanes.foundation[0].simd());
                let [surface, bottom] =
                    self.redo([true; MOST_LANES], [unknown; 2], |single| driven(single, kx, ky, on_surface));
                return NormalCompliance { surface, bottom };
            }
            let (surface, bottom) = layers.surface(self.lanes.foundation, kx, ky);
            let face = if on_surface { surface[2][2] } else { layers.under_tread(self.lanes.foundation, kx, ky) };
            return NormalCompliance { surface: face, bottom: bottom[2][2] };
        }
        let (both, under_tread, sliced) = self.p_sv(kx, ky, !on_surface);
        let NormalCompliance { surface, bottom } = both.normal();
        let face = if on_surface { surface } else { under_tread };
        let [surface, bottom] = self.redone(sliced, [face, bottom], |single| driven(single, kx, ky, on_surface));
        NormalCompliance { surface, bottom }
    }

    /// C_xz/i at a wavenumber \[1/m\]: see [`StackAt::tangential`]. To be called within a `pulp` dispatch.
    #[inline(always)]
    pub(crate) fn tangential_over_i(&self, kx: f64, ky: f64) -> Lanes<S> {
        if let Some(layers) = &self.lanes.anisotropic {
            if !layers.is_even(kx, ky) {
                let unknown = Lanes::zero(self.lanes.foundation[0].simd());
                let one = |single: &StackAt| [single.tangential(kx, ky) * -Complex64::i()];
                return self.redo([true; MOST_LANES], [unknown], one)[0];
            }
            return -layers.surface(self.lanes.foundation, kx, ky).0[0][2];
        }
        let (both, _, sliced) = self.p_sv(kx, ky, false);
        let k = kx.hypot(ky);
        let value = both.surface.0[0][1] * if k > 0.0 { -kx / k } else { 0.0 };
        let [value] = self.redone(sliced, [value], |single| [single.tangential(kx, ky) * -Complex64::i()]);
        value
    }

    /// [`StackAt::p_sv`], and which lanes need slices.
    #[inline(always)]
    fn p_sv(
        &self,
        kx: f64,
        ky: f64,
        under_tread: bool,
    ) -> (NormalCompliance<Matrix2<Lanes<S>>>, Lanes<S>, [bool; MOST_LANES]) {
        self.lanes.foundation[0].outlined(
            #[inline(always)]
            || {
                let mut sliced = [false; MOST_LANES];
                let (both, driven) = self.lanes.p_sv(
                    kx,
                    ky,
                    under_tread,
                    #[inline(always)]
                    |layer, exponents, under| pass(layer, exponents, under, &mut sliced),
                );
                (both, driven, sliced)
            },
        )
    }

    /// The values, those of some lanes evaluated one by one.
    #[inline(always)]
    fn redone<const VALUES: usize>(
        &self,
        lanes: [bool; MOST_LANES],
        values: [Lanes<S>; VALUES],
        single: impl Fn(&StackAt) -> [Complex64; VALUES],
    ) -> [Lanes<S>; VALUES] {
        if lanes == [false; MOST_LANES] { values } else { self.redo(lanes, values, single) }
    }

    #[inline(never)]
    fn redo<const VALUES: usize>(
        &self,
        lanes: [bool; MOST_LANES],
        values: [Lanes<S>; VALUES],
        single: impl Fn(&StackAt) -> [Complex64; VALUES],
    ) -> [Lanes<S>; VALUES] {
        let known = values.map(Lanes::to_array);
        let anew: [_; MOST_LANES] = std::array::from_fn(|lane| lanes[lane].then(|| single(self.single[lane])));
        std::array::from_fn(|value| {
            let simd = values[value].simd();
            Lanes::from_fn(simd, |lane| anew[lane].map_or(known[value][lane], |anew| anew[value]))
        })
    }
}

/// Compliances of one s: of the surface, or of the face under the tread that is driven in its place, and of the
/// bottom.
fn driven(single: &StackAt, kx: f64, ky: f64, on_surface: bool) -> [Complex64; 2] {
    let NormalCompliance { surface, bottom } = single.normal(kx, ky);
    [if on_surface { surface } else { single.under_tread(kx, ky) }, bottom]
}

/// One layer, each lane by the method that suits it; marks the lanes that need slices.
#[inline(always)]
fn pass<S: Simd>(
    layer: &LayerAt<Lanes<S>>,
    exponents: &Exponents<Lanes<S>>,
    under: Matrix2<Lanes<S>>,
    sliced: &mut [bool; MOST_LANES],
) -> LayerResult<Lanes<S>> {
    let simd = exponents.alpha_squared.simd();
    let scale = simd.splat_f64s(layer.thickness * layer.thickness);
    let alpha = simd.mul_f64s(simd.sqrt_f64s(exponents.alpha_squared.norm_squared()), scale);
    let beta = simd.mul_f64s(simd.sqrt_f64s(exponents.beta_squared.norm_squared()), scale);
    let (smaller, larger) = (simd.min_f64s(alpha, beta), simd.max_f64s(alpha, beta));
    // If the extreme lanes agree on a method, it suits all.
    let least = choose_method(simd.reduce_min_f64s(smaller), simd.reduce_min_f64s(larger));
    let most = choose_method(simd.reduce_min_f64s(smaller), simd.reduce_max_f64s(larger));
    if least == most && least == LayerMethod::Thin {
        return layer.p_sv_thin(exponents, layer.thickness, under);
    }
    let thick = layer.p_sv_thick(exponents, under);
    if least == most && least == LayerMethod::Thick {
        return thick;
    }
    let (alpha, beta) = (store(simd, alpha), store(simd, beta));
    let mut thin = [0.0; MOST_LANES];
    for lane in 0..S::F64_LANES {
        match choose_method(alpha[lane], beta[lane]) {
            LayerMethod::Thin => thin[lane] = 1.0,
            LayerMethod::Thick => {}
            LayerMethod::Sliced(_) => sliced[lane] = true,
        }
    }
    let mask = simd.greater_than_f64s(load(simd, &thin), simd.splat_f64s(0.5));
    let series = layer.p_sv_thin(exponents, layer.thickness, under);
    LayerResult {
        top: FaceState {
            displacement: blend::<S>(mask, series.top.displacement, thick.top.displacement),
            traction: blend::<S>(mask, series.top.traction, thick.top.traction),
        },
        bottom_displacement: blend::<S>(mask, series.bottom_displacement, thick.bottom_displacement),
    }
}

#[inline(always)]
fn blend<S: Simd>(mask: S::m64s, yes: Matrix2<Lanes<S>>, no: Matrix2<Lanes<S>>) -> Matrix2<Lanes<S>> {
    let ([[a, b], [c, d]], [[e, f], [g, h]]) = (yes.0, no.0);
    Matrix2([
        [Lanes::blend(mask, a, e), Lanes::blend(mask, b, f)],
        [Lanes::blend(mask, c, g), Lanes::blend(mask, d, h)],
    ])
}
