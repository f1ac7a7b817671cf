//! Inner loops: the free-space Green function and its normal derivative, in vector lanes.
//!
//! G = exp(-ikR)/(4 pi R), time factor exp(+i w t). dG/dn' = (1 + ikR) exp(-ikR) (x - y).n'/(4 pi R^3) for the target x
//! and the source y with its normal n'. Some 30 vector operations a pair, most of them the sine and cosine.

use pulp::{Arch, Simd, WithSimd};

use super::parity::{MIRRORS, ParityBlock};
use crate::numeric::lanes::cos_sin;

/// Kernel of a layer operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Layer {
    /// G.
    Single,
    /// dG/dn' at the source.
    Double,
}

/// Coordinates of points, a multiple of the lanes long.
#[derive(Clone, Debug, Default)]
pub(crate) struct Coordinates {
    /// Fore and aft \[m\].
    pub x: Vec<f64>,
    /// Across \[m\].
    pub y: Vec<f64>,
    /// Height \[m\].
    pub z: Vec<f64>,
}

impl Coordinates {
    pub(crate) fn push(&mut self, x: f64, y: f64, z: f64) {
        self.x.push(x);
        self.y.push(y);
        self.z.push(z);
    }
}

/// A source: position, then normal times weight/(4 pi), or (weight/(4 pi), 0, 0) for the single layer.
pub(crate) type Source = ([f64; 3], [f64; 3]);

/// Real and imaginary part of the kernel at a distance vector, without the factor 1/(4 pi).
#[inline(always)]
fn value<S: Simd, const DOUBLE: bool>(
    simd: S,
    [x, y, z]: [S::f64s; 3],
    [nx, ny, nz]: [S::f64s; 3],
    wavenumber: S::f64s,
) -> (S::f64s, S::f64s) {
    let square = simd.mul_add_e_f64s(x, x, simd.mul_add_e_f64s(y, y, simd.mul_f64s(z, z)));
    let distance = simd.sqrt_f64s(square);
    let inverse = simd.div_f64s(simd.splat_f64s(1.0), distance);
    let phase = simd.mul_f64s(wavenumber, distance);
    let (cos, sin) = cos_sin(simd, phase);
    if DOUBLE {
        let along = simd.mul_add_e_f64s(x, nx, simd.mul_add_e_f64s(y, ny, simd.mul_f64s(z, nz)));
        let factor = simd.mul_f64s(along, simd.mul_f64s(inverse, simd.mul_f64s(inverse, inverse)));
        let re = simd.mul_add_e_f64s(phase, sin, cos);
        let im = simd.sub_f64s(simd.mul_f64s(phase, cos), sin);
        (simd.mul_f64s(factor, re), simd.mul_f64s(factor, im))
    } else {
        let factor = simd.mul_f64s(nx, inverse);
        (simd.mul_f64s(factor, cos), simd.neg_f64s(simd.mul_f64s(factor, sin)))
    }
}

/// One column of the far field: a source against all targets and their mirrors, added by parity.
pub(crate) struct FarColumn<'a> {
    /// Targets, whole vectors.
    pub targets: &'a Coordinates,
    /// 1 where a mirror's pair is far, 0 where it is integrated as near: mirror by mirror, as long as the targets.
    pub far: &'a [f64],
    /// Source with its normal and weight.
    pub source: Source,
    /// Wavenumber \[rad/m\].
    pub wavenumber: f64,
    /// Kernel.
    pub layer: Layer,
    /// True if the road's image is added.
    pub on_road: bool,
    /// Blocks, each with its column's real and imaginary parts.
    pub columns: &'a mut [(ParityBlock, &'a mut [f64], &'a mut [f64])],
}

impl FarColumn<'_> {
    #[inline(always)]
    fn run<S: Simd, const DOUBLE: bool>(self, simd: S) {
        let Self { targets, far, source: (position, normal), wavenumber, on_road, columns, .. } = self;
        let (xs, _) = S::as_simd_f64s(&targets.x);
        let (ys, _) = S::as_simd_f64s(&targets.y);
        let (zs, _) = S::as_simd_f64s(&targets.z);
        let (far, _) = S::as_simd_f64s(far);
        let position = position.map(|number| simd.splat_f64s(number));
        let normal = normal.map(|number| simd.splat_f64s(number));
        let wavenumber = simd.splat_f64s(wavenumber);
        let zero = simd.splat_f64s(0.0);
        let stride = xs.len();
        for chunk in 0..stride {
            let mut sums = [(zero, zero); MIRRORS];
            for (mirror, sum) in sums.iter_mut().enumerate() {
                let x = if mirror & 1 == 0 { xs[chunk] } else { simd.neg_f64s(xs[chunk]) };
                let y = if mirror & 2 == 0 { ys[chunk] } else { simd.neg_f64s(ys[chunk]) };
                let (x, y) = (simd.sub_f64s(x, position[0]), simd.sub_f64s(y, position[1]));
                let z = simd.sub_f64s(zs[chunk], position[2]);
                let (re, im) = value::<S, DOUBLE>(simd, [x, y, z], normal, wavenumber);
                let weight = far[mirror * stride + chunk];
                *sum = (select(simd, weight, re), select(simd, weight, im));
                if on_road {
                    let z = simd.sub_f64s(simd.neg_f64s(zs[chunk]), position[2]);
                    let (re, im) = value::<S, DOUBLE>(simd, [x, y, z], normal, wavenumber);
                    let weight = far[(MIRRORS + mirror) * stride + chunk];
                    sum.0 = simd.add_f64s(sum.0, select(simd, weight, re));
                    sum.1 = simd.add_f64s(sum.1, select(simd, weight, im));
                }
            }
            let [a, b, c, d] = sums;
            for (block, re, im) in columns.iter_mut() {
                let odd = [block.fore_aft_odd, block.across_odd];
                let add = |odd: bool, p, q| if odd { simd.sub_f64s(p, q) } else { simd.add_f64s(p, q) };
                let real = add(odd[1], add(odd[0], a.0, b.0), add(odd[0], c.0, d.0));
                let imaginary = add(odd[1], add(odd[0], a.1, b.1), add(odd[0], c.1, d.1));
                let (re, _) = S::as_mut_simd_f64s(re);
                let (im, _) = S::as_mut_simd_f64s(im);
                re[chunk] = real;
                im[chunk] = imaginary;
            }
        }
    }
}

/// The value where the weight is not 0, else 0: also where the value is NaN, at the source itself.
#[inline(always)]
fn select<S: Simd>(simd: S, weight: S::f64s, value: S::f64s) -> S::f64s {
    let zero = simd.splat_f64s(0.0);
    simd.select_f64s(simd.greater_than_f64s(weight, zero), value, zero)
}

impl WithSimd for FarColumn<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self.layer {
            Layer::Single => self.run::<S, false>(simd),
            Layer::Double => self.run::<S, true>(simd),
        }
    }
}

/// The kernel at one target from a cell's quadrature points.
pub(crate) struct NearCell<'a> {
    /// Quadrature points, whole vectors.
    pub points: &'a Coordinates,
    /// Their normals times weight/(4 pi), or the weights/(4 pi) in x.
    pub normals: &'a Coordinates,
    /// Target \[m\].
    pub target: [f64; 3],
    /// Wavenumber \[rad/m\].
    pub wavenumber: f64,
    /// Kernel.
    pub layer: Layer,
    /// Real parts by point.
    pub re: &'a mut [f64],
    /// Imaginary parts by point.
    pub im: &'a mut [f64],
}

impl NearCell<'_> {
    #[inline(always)]
    fn run<S: Simd, const DOUBLE: bool>(self, simd: S) {
        let (xs, _) = S::as_simd_f64s(&self.points.x);
        let (ys, _) = S::as_simd_f64s(&self.points.y);
        let (zs, _) = S::as_simd_f64s(&self.points.z);
        let (nxs, _) = S::as_simd_f64s(&self.normals.x);
        let (nys, _) = S::as_simd_f64s(&self.normals.y);
        let (nzs, _) = S::as_simd_f64s(&self.normals.z);
        let (re, _) = S::as_mut_simd_f64s(self.re);
        let (im, _) = S::as_mut_simd_f64s(self.im);
        let target = self.target.map(|number| simd.splat_f64s(number));
        let wavenumber = simd.splat_f64s(self.wavenumber);
        for chunk in 0..xs.len() {
            let away = [
                simd.sub_f64s(target[0], xs[chunk]),
                simd.sub_f64s(target[1], ys[chunk]),
                simd.sub_f64s(target[2], zs[chunk]),
            ];
            let normal = [nxs[chunk], nys[chunk], nzs[chunk]];
            (re[chunk], im[chunk]) = value::<S, DOUBLE>(simd, away, normal, wavenumber);
        }
    }
}

impl WithSimd for NearCell<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self.layer {
            Layer::Single => self.run::<S, false>(simd),
            Layer::Double => self.run::<S, true>(simd),
        }
    }
}

/// The processor's widest vectors.
pub(crate) fn arch() -> Arch {
    Arch::new()
}
