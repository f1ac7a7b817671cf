//! The stack of layers: surface compliance C and transfers D in wavenumber space.
//!
//! 1. start with the impedance of the foundation, diag(k_t, k_n);
//! 2. go through the layers upwards (see [`super::layer`]): impedance on each interface, displacement transfer to the
//!    one below;
//! 3. C = displacement/traction on the last face; D = (product of the transfers) C;
//! 4. turn from the direction of k to x and y.
//!
//! Where not all layers are isotropic, the stack is that of `super::anisotropic`, without that split.
//!
//! Cost: one P-SV pass of 2x2 matrices per layer (see [`operations`]), and one SH pass where the full matrix is
//! wanted.

use num_complex::Complex64;

use super::anisotropic::FlatLayers;
use super::faces::to_fields;
use super::layer::{Exponents, FaceState, LayerAt, LayerMethod, LayerResult, choose_method};
use super::material;
use super::matrix2::Matrix2;
use crate::numeric::ComplexField;
use crate::scene::{Foundation, Layer, Tyre};

/// A 3x3 matrix over x, y, z: displacement i \[m\] per unit traction j \[Pa\].
pub type Matrix3 = [[Complex64; 3]; 3];

/// Layers and foundation of a flat tyre, for any s.
#[derive(Clone, Debug, PartialEq)]
pub struct Stack {
    pub(super) layers: Vec<Layer>,
    pub(super) foundation: Foundation,
}

/// A stack at one value of s, or at several in lockstep.
#[derive(Clone, Debug)]
pub struct StackAt<T = Complex64> {
    /// Layers from the rim outwards.
    pub(super) layers: Vec<LayerAt<T>>,
    /// Tangential and normal foundation stiffness per area \[N/m^3\].
    pub(super) foundation: [T; 2],
    /// Where not all layers are isotropic, the same layers; they are then evaluated in place of `layers`.
    pub(super) anisotropic: Option<FlatLayers<T>>,
}

/// Compliances of the surface and of the bottom face for normal traction on the surface, at one (kx, ky).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalCompliance<T = Complex64> {
    /// Outward displacement of the surface, C_zz \[m/Pa\].
    pub surface: T,
    /// Outward displacement of the bottom face, D_zz \[m/Pa\].
    pub bottom: T,
}

/// Real additions, multiplications, divisions and square roots of one evaluation for normal traction, both faces, of a
/// stack of so many layers, where k h is so large that the layers' waves are taken (`thick`); exp as 34, sin and cos
/// together as 40, a complex square root as 8. A test counts them.
pub const fn operations(layers: u64) -> u64 {
    1260 + layers.saturating_sub(1) * 1160
}

impl Stack {
    /// Layers and foundation of a tyre, its curvature disregarded.
    pub fn new(tyre: &Tyre) -> Self {
        Self::of(tyre.layers.clone(), tyre.foundation.clone())
    }

    /// `layers`: from the rim outwards.
    pub fn of(layers: Vec<Layer>, foundation: Foundation) -> Self {
        Self { layers, foundation }
    }

    /// Layers from the rim outwards.
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
        StackAt {
            layers,
            foundation: material::foundation_stiffness(&self.foundation, s),
            anisotropic: FlatLayers::new(&self.layers, s),
        }
    }
}

impl<T: ComplexField> StackAt<T> {
    /// P-SV matrices of the surface and of the transfer to the bottom face, displacement (w, u_z) for unit traction
    /// (tau, sigma), each layer by `pass`; and, if `under_tread`, the driving-point compliance under the tread.
    // One loop with a single call of `pass`: it is inlined there, and long.
    #[inline(always)]
    pub(super) fn p_sv(
        &self,
        kx: f64,
        ky: f64,
        under_tread: bool,
        mut pass: impl FnMut(&LayerAt<T>, &Exponents<T>, Matrix2<T>) -> LayerResult<T>,
    ) -> (NormalCompliance<Matrix2<T>>, T) {
        let ([tangential, normal], count) = (self.foundation, self.layers.len());
        let [zero, one] = [0.0, 1.0].map(|value| normal.like(value));
        let foundation = Matrix2::diagonal(tangential, normal);
        // Impedance under the next layer and under the last one; state and transfer of the layers so far.
        let (mut under, mut under_last) = (foundation, foundation);
        let mut last: Option<(FaceState<T>, Matrix2<T>)> = None;
        let mut driven = zero;
        for index in 0..count + usize::from(under_tread && count > 0) {
            // The tread once more at the end, on a free face.
            let again = index == count;
            let layer = &self.layers[index - usize::from(again)];
            let below = if again { Matrix2::diagonal(zero, zero) } else { under };
            let LayerResult { top, bottom_displacement } = pass(layer, &layer.exponents(kx, ky), below);
            let impedance = top.traction.over(top.displacement);
            if again {
                // As seen from below: its mirror image; mirroring changes the sign of the off-diagonal terms.
                let [[a, b], [c, d]] = impedance.0;
                let total = under_last + Matrix2([[a, -b], [-c, d]]);
                driven = Matrix2::diagonal(one, one).over(total).0[1][1];
                break;
            }
            let step = bottom_displacement.over(top.displacement);
            let transfer = match last {
                Some((_, before)) => before * step,
                None => step,
            };
            last = Some((top, transfer));
            (under_last, under) = (under, impedance);
        }
        let matrices = match last {
            Some((top, transfer)) => {
                let surface = top.displacement.over(top.traction);
                NormalCompliance { surface, bottom: transfer * surface }
            }
            None => {
                let compliance = Matrix2::diagonal(tangential.reciprocal(), normal.reciprocal());
                NormalCompliance { surface: compliance, bottom: compliance }
            }
        };
        (matrices, driven)
    }
}

impl<T: Copy> NormalCompliance<Matrix2<T>> {
    /// zz entries.
    #[inline(always)]
    pub(super) fn normal(self) -> NormalCompliance<T> {
        NormalCompliance { surface: self.surface.0[1][1], bottom: self.bottom.0[1][1] }
    }
}

/// P-SV pass of a layer, by series or by waves as its exponents suit.
fn pass(
    layer: &LayerAt<Complex64>,
    exponents: &Exponents<Complex64>,
    under: Matrix2<Complex64>,
) -> LayerResult<Complex64> {
    layer.p_sv(exponents, method(layer, exponents), under)
}

fn method(layer: &LayerAt<Complex64>, exponents: &Exponents<Complex64>) -> LayerMethod {
    let h_squared = layer.thickness * layer.thickness;
    choose_method(exponents.alpha_squared.norm() * h_squared, exponents.beta_squared.norm() * h_squared)
}

impl StackAt {
    /// Outermost layer.
    pub(crate) fn tread(&self) -> &LayerAt<Complex64> {
        // A checked scene has at least one layer.
        &self.layers[self.layers.len() - 1]
    }

    /// Surface and bottom compliance for normal traction; kx and ky in 1/m.
    pub fn normal(&self, kx: f64, ky: f64) -> NormalCompliance {
        if let Some(layers) = &self.anisotropic {
            let (surface, bottom) = layers.surface(self.foundation, kx, ky);
            return NormalCompliance { surface: surface[2][2], bottom: bottom[2][2] };
        }
        self.p_sv(kx, ky, false, pass).0.normal()
    }

    /// C_xz: displacement of the surface along x for normal traction \[m/Pa\]; kx and ky in 1/m. It needs no SH pass,
    /// whose waves have no normal motion.
    pub fn tangential(&self, kx: f64, ky: f64) -> Complex64 {
        if let Some(layers) = &self.anisotropic {
            return -Complex64::i() * layers.surface(self.foundation, kx, ky).0[0][2];
        }
        let k = kx.hypot(ky);
        if k > 0.0 {
            -Complex64::i() * self.p_sv(kx, ky, false, pass).0.surface.0[0][1] * (kx / k)
        } else {
            Complex64::ZERO
        }
    }

    /// Driving-point compliance \[m/Pa\] for normal traction applied under the outermost layer, which moves as a free
    /// layer with it: what independent springs in place of the tread's elasticity act on.
    pub fn under_tread(&self, kx: f64, ky: f64) -> Complex64 {
        if let Some(layers) = &self.anisotropic {
            return layers.under_tread(self.foundation, kx, ky);
        }
        self.p_sv(kx, ky, true, pass).1
    }

    /// Full matrices: C on the surface and D to the bottom face \[m/Pa\]; kx and ky in 1/m.
    pub fn full(&self, kx: f64, ky: f64) -> (Matrix3, Matrix3) {
        if let Some(layers) = &self.anisotropic {
            let (surface, bottom) = layers.surface(self.foundation, kx, ky);
            return (to_fields(surface), to_fields(bottom));
        }
        let (p_sv, _) = self.p_sv(kx, ky, false, pass);
        let mut under = self.foundation[0];
        let (mut transfer, mut surface) = (Complex64::ONE, under.inv());
        for layer in &self.layers {
            let exponents = layer.exponents(kx, ky);
            let thin = method(layer, &exponents) == LayerMethod::Thin;
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

/// From (w, u_z; tau, sigma) and SH along k to x, y, z. Here u_r = -i w and tau = i sigma_rz.
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
