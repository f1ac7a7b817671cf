//! Energy of a curved layer by the lateral derivatives in it, for motion of any shape across the tyre.
//!
//! A wave of [`super::layer_wave`] has w, V ~ cos(k_y y) and P ~ sin(k_y y). For other shapes the energy over the
//! section, per radian and with k = n/r, S, S_y, Q as in [`super::curved`], is
//!
//! ```text
//! int [u^T U u + 2 P_y S_c^T c + S_p P_y^2 - 2 P T_c^T c_y + c_y^T T_cc c_y] dy,   c = (V, w),  u = (V, P, w),
//! ```
//!
//! with U = `uniform`, free of derivatives, S = `strained`, the terms of e_y = P_y, and T = `tilted`, those of V_y and
//! w_y in g_ty = k P - V_y and g_ry = P' + w_y. A wave has U + k_y (S + T) between c and P and U + k_y^2 (S + T)
//! elsewhere. All three are the energy of `super::layer_wave` with k_y = 0 or 1 and some constants set to 0.

use faer::Mat;
use num_complex::Complex64;

use super::elasticity::{CordParts, Fibres, MaterialRatios};
use super::layer_modes::LayerValues;
use super::layer_wave::{LayerWave, by_fields, whole_inertia};
use super::radial_polynomials::RadialProducts;
use super::rotation::Rotation;
use crate::numeric::{ComplexSymmetricMatrix, SymmetricMatrix};
use crate::scene::Layer;

/// Displacement component of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::tyre) enum Component {
    /// V: circumferential motion is -i V.
    Circumferential,
    /// P, lateral.
    Lateral,
    /// w, outward.
    Radial,
}

/// Factor of a part of the energy at s.
#[derive(Clone, Copy, Debug)]
enum Factor {
    Shear,
    Cords(usize),
    Constant,
    Inertia,
    Coriolis,
}

/// Energy of a layer for waves of n periods, as matrices over polynomials across its thickness.
#[derive(Clone, Debug)]
pub(in crate::tyre) struct LateralSplit {
    layer: Layer,
    cords: CordParts,
    rotation: Rotation,
    polynomials: usize,
    uniform: Vec<(Factor, SymmetricMatrix)>,
    strained: Vec<(Factor, SymmetricMatrix)>,
    tilted: Vec<(Factor, SymmetricMatrix)>,
}

/// U, S and T at one s; rows and columns as [`LateralSplit::place`].
#[derive(Clone, Debug)]
pub(in crate::tyre) struct LateralSplitAt {
    pub(in crate::tyre) uniform: ComplexSymmetricMatrix,
    pub(in crate::tyre) strained: ComplexSymmetricMatrix,
    pub(in crate::tyre) tilted: ComplexSymmetricMatrix,
}

/// Polynomials of a degree across a layer, for all n.
#[derive(Clone, Debug)]
pub(in crate::tyre) struct LayerPolynomials {
    products: RadialProducts,
    from: f64,
}

impl LayerPolynomials {
    /// For a layer whose inner face has the radius `from` \[m\]; a degree of at least 2.
    pub(in crate::tyre) fn new(layer: &Layer, from: f64, degree: usize) -> Self {
        Self { products: RadialProducts::new(from, layer.thickness, degree), from }
    }

    /// Number of polynomials.
    pub(in crate::tyre) fn count(&self) -> usize {
        self.products.values.nrows()
    }
}

impl LateralSplit {
    pub(in crate::tyre) fn new(layer: &Layer, polynomials: &LayerPolynomials, rotation: &Rotation, n: f64) -> Self {
        let LayerPolynomials { products, from } = polynomials;
        let cords = CordParts::new(layer);
        let ratios = MaterialRatios::new(layer);
        let [along, across] = rotation.prestress(layer, *from);
        let wave = |ky: f64, prestress: [f64; 2], softening: f64| LayerWave {
            n,
            ky,
            lame_ratio: 0.0,
            orthotropic: None,
            prestress,
            softening,
            cords: &[],
            fibres: Default::default(),
            shear: 1.0,
            shear_waves: 0.0,
            at_rest: false,
        };
        let [tr, yr, ty] = ratios.shear;
        let fibres = |wave: &LayerWave<'_>, shares: &dyn Fn(&Fibres) -> ([f64; 3], f64)| {
            let matrix = |(index, part): (usize, &Fibres)| {
                let (plane, in_plane) = shares(part);
                (Factor::Cords(index), wave.membrane(plane, in_plane, products))
            };
            cords.parts.iter().enumerate().map(matrix).collect::<Vec<_>>()
        };
        // 1. No derivatives: k_y = 0.
        let softening = rotation.softening(layer.material.density);
        let still = wave(0.0, [along, 0.0], softening);
        let exchange = by_fields(products.values.nrows(), |a, b| [0.0, 0.0, products.values_r[(a, b)], 0.0, 0.0, 0.0]);
        let mut uniform = vec![
            (Factor::Shear, still.orthotropic(&ratios, products)),
            (Factor::Constant, still.prestress(products)),
            (Factor::Inertia, whole_inertia(products)),
            (Factor::Coriolis, exchange),
        ];
        uniform.extend(fibres(&still, &|part| (part.shares, part.shares[2])));
        if !rotation.turns() {
            uniform.retain(|(factor, _)| !matches!(factor, Factor::Coriolis));
        }
        // 2. Strain across alone: k_y = 1 and no shear in g_ry and g_ty.
        let one = wave(1.0, [0.0, across], 0.0);
        let stretched = MaterialRatios { shear: [tr, 0.0, 0.0], ..ratios };
        let mut strained =
            vec![(Factor::Shear, one.orthotropic(&stretched, products)), (Factor::Constant, one.prestress(products))];
        strained.extend(fibres(&one, &|part| (part.shares, 0.0)));
        // 3. Slopes of V and w across alone: k_y = 1 and nothing but that shear.
        let sheared = MaterialRatios {
            plane: [0.0; 3],
            contraction: [0.0; 2],
            inverse_radial: f64::INFINITY,
            shear: [0.0, yr, ty],
        };
        let mut tilted =
            vec![(Factor::Shear, one.orthotropic(&sheared, products)), (Factor::Constant, one.prestress(products))];
        tilted.extend(fibres(&one, &|part| ([0.0; 3], part.shares[2])));
        let polynomials = polynomials.count();
        let packed = |parts: Vec<(Factor, Mat<f64>)>, holds: fn(usize) -> bool| {
            let pack = |matrix: &Mat<f64>| {
                SymmetricMatrix::from_fn(matrix.nrows(), |row, column| {
                    let lateral = [row, column].map(|place| usize::from(is_lateral(polynomials, place)));
                    if holds(lateral[0] + lateral[1]) { matrix[(row, column)] } else { 0.0 }
                })
            };
            parts.iter().map(|(factor, matrix)| (*factor, pack(matrix))).collect()
        };
        Self {
            // By the number of lateral components of an entry.
            uniform: packed(uniform, |_| true),
            strained: packed(strained, |lateral| lateral > 0),
            tilted: packed(tilted, |lateral| lateral < 2),
            layer: layer.clone(),
            rotation: *rotation,
            cords,
            polynomials,
        }
    }

    /// Row of a component's polynomial: 0 that of the inner face, 1 that of the outer one, then interior ones.
    pub(in crate::tyre) fn place(&self, component: Component, polynomial: usize) -> usize {
        let component = component as usize;
        if polynomial < 2 { 3 * polynomial + component } else { 4 + component * (self.polynomials - 2) + polynomial }
    }

    /// Number of polynomials of a component.
    pub(in crate::tyre) fn polynomials(&self) -> usize {
        self.polynomials
    }

    pub(in crate::tyre) fn at(&self, s: Complex64) -> LateralSplitAt {
        let values = LayerValues::new(&self.layer, &self.cords, &self.rotation, s);
        let sum = |parts: &[(Factor, SymmetricMatrix)]| {
            let mut sum = ComplexSymmetricMatrix::zeros(3 * self.polynomials);
            for (factor, matrix) in parts {
                let factor = match *factor {
                    Factor::Shear => values.shear,
                    Factor::Cords(index) => values.fibres[index],
                    Factor::Constant => Complex64::ONE,
                    Factor::Inertia => values.inertia,
                    Factor::Coriolis => Complex64::i() * values.coriolis,
                };
                sum.add_scaled(factor, matrix);
            }
            sum
        };
        LateralSplitAt { uniform: sum(&self.uniform), strained: sum(&self.strained), tilted: sum(&self.tilted) }
    }
}

/// True for a row of the lateral component.
fn is_lateral(polynomials: usize, place: usize) -> bool {
    if place < 6 { place % 3 == 1 } else { (place - 6) / (polynomials - 2) == 1 }
}
