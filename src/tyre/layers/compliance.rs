//! The stack of layers: surface compliance C and transfers D in wavenumber space.
//!
//! 1. start with the impedance of the foundation, diag(k_t, k_n);
//! 2. go through the layers upwards (see [`super::layer`]): impedance on each interface, displacement transfer to the
//!    one below;
//! 3. C = displacement/traction on the last face; D = (product of the transfers) C;
//! 4. turn from the direction of k to x and y.
//!
//! Cost: one P-SV pass of 2x2 matrices a layer (see [`operations`]), and one SH pass where the full matrix is wanted.

use num_complex::Complex64;

use super::layer::{Exponents, FaceState, LayerAt, LayerResult, Way, choose_way};
use super::material;
use super::matrix2::Matrix2;
use crate::numeric::ComplexField;
use crate::scene::{Foundation, Layer, Tyre};

/// A 3x3 matrix over x, y, z: displacement i \[m\] per unit traction j \[Pa\].
pub type Matrix3 = [[Complex64; 3]; 3];

/// The layers and the foundation of a tyre, ready to be evaluated at any s.
#[derive(Clone, Debug, PartialEq)]
pub struct Stack {
    layers: Vec<Layer>,
    foundation: Foundation,
}

/// A stack at one value of s, or at several in lockstep.
#[derive(Clone, Debug)]
pub struct StackAt<T = Complex64> {
    /// The layers, from the rim outwards.
    pub(super) layers: Vec<LayerAt<T>>,
    /// Tangential and normal foundation stiffness per area \[N/m^3\].
    pub(super) foundation: [T; 2],
}

/// Compliances of the surface and of the bottom face for normal traction, at one (kx, ky) and as many s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalCompliance<T = Complex64> {
    /// C_zz \[m/Pa\].
    pub surface: T,
    /// D_zz to the bottom face \[m/Pa\].
    pub bottom: T,
}

/// Real additions, multiplications, divisions and square roots of one evaluation for normal traction, both faces, of a
/// stack of so many layers, where k h is so large that the layers' waves are taken ([`thick`](Way::Thick)); exp as 34,
/// sin and cos together as 40, a complex square root as 8. A test counts them.
pub const fn operations(layers: u64) -> u64 {
    1260 + layers.saturating_sub(1) * 1160
}

impl Stack {
    /// The stack of a tyre.
    pub fn new(tyre: &Tyre) -> Self {
        Self::of(tyre.layers.clone(), tyre.foundation.clone())
    }

    /// A stack of given layers, from the rim outwards, on a foundation.
    pub fn of(layers: Vec<Layer>, foundation: Foundation) -> Self {
        Self { layers, foundation }
    }

    /// Its layers and foundation.
    pub(super) fn into_parts(self) -> (Vec<Layer>, Foundation) {
        (self.layers, self.foundation)
    }

    /// The layers, from the rim outwards.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Moduli and inertia at s \[1/s\].
    pub fn at(&self, s: Complex64) -> StackAt {
        let layers = self
            .layers
            .iter()
            .map(|layer| {
                let shear = material::shear_modulus(&layer.material, s);
                LayerAt {
                    thickness: layer.thickness,
                    shear,
                    inverse_shear: shear.inv(),
                    modulus_ratio: material::modulus_ratio(layer.material.poisson),
                    inertia: s * s * layer.material.density,
                    prestress: layer.tension.map(|tension| tension / layer.thickness),
                }
            })
            .collect();
        StackAt { layers, foundation: material::foundation_stiffness(&self.foundation, s) }
    }
}

impl<T: ComplexField> StackAt<T> {
    /// P-SV matrices of the surface and of the transfer to the bottom face: displacement (w, u_z) for unit traction
    /// (tau, sigma), each layer by `pass`.
    #[inline(always)]
    pub(super) fn p_sv(
        &self,
        kx: f64,
        ky: f64,
        mut pass: impl FnMut(&LayerAt<T>, &Exponents<T>, Matrix2<T>) -> LayerResult<T>,
    ) -> NormalCompliance<Matrix2<T>> {
        let [tangential, normal] = self.foundation;
        let Some((top, transfer)) = climb(&self.layers, Matrix2::diagonal(tangential, normal), kx, ky, &mut pass)
        else {
            let compliance = Matrix2::diagonal(tangential.reciprocal(), normal.reciprocal());
            return NormalCompliance { surface: compliance, bottom: compliance };
        };
        let surface = top.displacement.over(top.traction);
        NormalCompliance { surface, bottom: transfer * surface }
    }

    /// [`StackAt::under_tread`], each layer by `pass`.
    #[inline(always)]
    pub(super) fn under(
        &self,
        kx: f64,
        ky: f64,
        mut pass: impl FnMut(&LayerAt<T>, &Exponents<T>, Matrix2<T>) -> LayerResult<T>,
    ) -> T {
        let [tangential, normal] = self.foundation;
        let (tread, carcass) = (self.tread(), &self.layers[..self.layers.len() - 1]);
        let foundation = Matrix2::diagonal(tangential, normal);
        let below = match climb(carcass, foundation, kx, ky, &mut pass) {
            Some((top, _)) => top.traction.over(top.displacement),
            None => foundation,
        };
        // The tread seen from below: its mirror image over a free face; mirroring changes the sign of the off-diagonal
        // terms.
        let [zero, one] = [0.0, 1.0].map(|value| normal.like(value));
        let above = pass(tread, &tread.exponents(kx, ky), Matrix2::diagonal(zero, zero)).top;
        let [[a, b], [c, d]] = above.traction.over(above.displacement).0;
        let total = below + Matrix2([[a, -b], [-c, d]]);
        Matrix2::diagonal(one, one).over(total).0[1][1]
    }

    /// The outermost layer.
    pub fn tread(&self) -> &LayerAt<T> {
        // A checked scene has at least one layer.
        &self.layers[self.layers.len() - 1]
    }
}

impl<T: Copy> NormalCompliance<Matrix2<T>> {
    /// The zz entries.
    #[inline(always)]
    pub(super) fn normal(self) -> NormalCompliance<T> {
        NormalCompliance { surface: self.surface.0[1][1], bottom: self.bottom.0[1][1] }
    }
}

/// A layer by the way that suits it.
fn pass(
    layer: &LayerAt<Complex64>,
    exponents: &Exponents<Complex64>,
    under: Matrix2<Complex64>,
) -> LayerResult<Complex64> {
    layer.p_sv(exponents, way(layer, exponents), under)
}

fn way(layer: &LayerAt<Complex64>, exponents: &Exponents<Complex64>) -> Way {
    let h_squared = layer.thickness * layer.thickness;
    choose_way(exponents.alpha_squared.norm() * h_squared, exponents.beta_squared.norm() * h_squared)
}

impl StackAt {
    /// Surface and bottom compliance for normal traction.
    pub fn normal(&self, kx: f64, ky: f64) -> NormalCompliance {
        self.p_sv(kx, ky, pass).normal()
    }

    /// C_xz: displacement of the surface along x for normal traction \[m/Pa\]. It needs no SH pass, whose waves have no
    /// normal motion.
    pub fn tangential(&self, kx: f64, ky: f64) -> Complex64 {
        let k = kx.hypot(ky);
        if k > 0.0 { -Complex64::i() * self.p_sv(kx, ky, pass).surface.0[0][1] * (kx / k) } else { Complex64::ZERO }
    }

    /// Driving-point compliance \[m/Pa\] for normal traction applied under the outermost layer, which rides along: what
    /// independent springs in place of the tread's elasticity act on.
    pub fn under_tread(&self, kx: f64, ky: f64) -> Complex64 {
        self.under(kx, ky, pass)
    }

    /// The full matrices: C on the surface and D to the bottom face, \[m/Pa\].
    pub fn full(&self, kx: f64, ky: f64) -> (Matrix3, Matrix3) {
        let p_sv = self.p_sv(kx, ky, pass);
        let mut under = self.foundation[0];
        let (mut transfer, mut surface) = (Complex64::ONE, under.inv());
        for layer in &self.layers {
            let exponents = layer.exponents(kx, ky);
            let thin = way(layer, &exponents) == Way::Thin;
            let [displacement, traction, bottom] = layer.sh(&exponents, thin, under);
            under = traction / displacement;
            surface = displacement / traction;
            transfer *= bottom / displacement;
        }
        let k = kx.hypot(ky);
        let direction = if k > 0.0 { [kx / k, ky / k] } else { [1.0, 0.0] };
        (turn(p_sv.surface, surface, direction), turn(p_sv.bottom, transfer * surface, direction))
    }
}

/// P-SV pass upwards through layers, each by `pass`: displacement and traction on the last top face for two states, and
/// the product of the displacement transfers from there to the bottom (`None` without layers).
#[inline(always)]
fn climb<T: ComplexField>(
    layers: &[LayerAt<T>],
    foundation: Matrix2<T>,
    kx: f64,
    ky: f64,
    pass: &mut impl FnMut(&LayerAt<T>, &Exponents<T>, Matrix2<T>) -> LayerResult<T>,
) -> Option<(FaceState<T>, Matrix2<T>)> {
    let mut under = foundation;
    let mut last: Option<(FaceState<T>, Matrix2<T>)> = None;
    for layer in layers {
        let exponents = layer.exponents(kx, ky);
        let result = pass(layer, &exponents, under);
        let step = result.bottom_displacement.over(result.top.displacement);
        let transfer = match last {
            Some((_, below)) => below * step,
            None => step,
        };
        under = result.top.traction.over(result.top.displacement);
        last = Some((result.top, transfer));
    }
    last
}

/// From (w, u_z; tau, sigma) and SH in the direction of k to x, y, z. With u_r = -i w and tau = i sigma_rz.
fn turn(p_sv: Matrix2<Complex64>, sh: Complex64, [cos, sin]: [f64; 2]) -> Matrix3 {
    let i = Complex64::i();
    let [[rr, r_sigma], [z_tau, zz]] = p_sv.0;
    let (rz, zr) = (-i * r_sigma, i * z_tau);
    let cross = (rr - sh) * (cos * sin);
    [
        [rr * (cos * cos) + sh * (sin * sin), cross, rz * cos],
        [cross, rr * (sin * sin) + sh * (cos * cos), rz * sin],
        [zr * cos, zr * sin, zz],
    ]
}

#[cfg(test)]
#[path = "operations_tests.rs"]
mod tests;
