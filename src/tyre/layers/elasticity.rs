//! Elastic constants of a layer: isotropic rubber, rubber with cords, or an orthotropic material.
//!
//! A layer's stiffness is a sum of positive parts, each with a separate factor of s, so that it is passive:
//!
//! ```text
//! C(s) = mu(s) C_0 + sum_k f_k(s) K_k (tt c^4, yy s^4, ty c^2 s^2, G_ty c^2 s^2, nothing else).
//! ```
//!
//! C_0, in units of the shear modulus mu, is the material's: isotropic, or orthotropic with mu = G_theta_r. The others
//! are cords at +-angle, c and s its cosine and sine. They bear nothing outwards, so that of the constants
//!
//! ```text
//! s_t = Q_tt e_t + Q_ty e_y + a_t sigma,   s_y = Q_ty e_t + Q_yy e_y + a_y sigma,
//! e_r = sigma/C_rr - a_t e_t - a_y e_y
//! ```
//!
//! they change Q and G_ty alone: no 3x3 matrix is inverted.

use num_complex::Complex64;

use super::material;
use crate::numeric::ComplexField;
use crate::scene::{Layer, MOST_CORD_LOSSES, PlaneConstants};

/// Constants of a layer at one s, or at several in lockstep.
#[derive(Clone, Copy, Debug)]
pub(super) struct ElasticityAt<T> {
    /// Q_tt, Q_yy, Q_ty \[Pa\].
    pub plane: [T; 3],
    /// a_t, a_y (no unit).
    pub contraction: [f64; 2],
    /// 1/C_rr \[1/Pa\].
    pub inverse_radial: T,
    /// G_tr, G_yr, G_ty \[Pa\].
    pub shear: [T; 3],
}

/// Constants of a material in units of its shear modulus mu.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MaterialRatios {
    /// Q_tt, Q_yy, Q_ty.
    pub plane: [f64; 3],
    /// a_t, a_y.
    pub contraction: [f64; 2],
    /// mu/C_rr.
    pub inverse_radial: f64,
    /// G_tr, G_yr, G_ty.
    pub shear: [f64; 3],
}

/// Cords of one loss factor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Fibres {
    loss_factor: f64,
    /// Stiffness along, across, and both between them and in shear, at the reference frequency \[Pa\].
    pub shares: [f64; 3],
}

/// All cords of a layer, those of equal loss factor together.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct CordParts {
    /// Reference and corner frequency \[Hz\].
    frequencies: [f64; 2],
    /// By loss factor.
    pub parts: Vec<Fibres>,
}

impl MaterialRatios {
    pub(super) fn new(layer: &Layer) -> Self {
        match &layer.orthotropic {
            None => {
                let kappa = material::modulus_ratio(layer.material.poisson);
                let (plate, cross) = (4.0 * (1.0 - kappa), 2.0 * (1.0 - 2.0 * kappa));
                Self {
                    plane: [plate, plate, cross],
                    contraction: [1.0 - 2.0 * kappa; 2],
                    inverse_radial: kappa,
                    shear: [1.0; 3],
                }
            }
            Some(moduli) => {
                let PlaneConstants { plane, contraction, radial } = moduli.constants();
                let measure = moduli.g_theta_r;
                Self {
                    plane: plane.map(|modulus| modulus / measure),
                    contraction,
                    inverse_radial: measure / radial,
                    shear: [1.0, moduli.g_y_r / measure, moduli.g_theta_y / measure],
                }
            }
        }
    }
}

impl CordParts {
    pub(super) fn new(layer: &Layer) -> Self {
        let mut parts: Vec<Fibres> = Vec::new();
        for cords in &layer.cords {
            let shares = cords.shares_in(layer.thickness);
            match parts.iter_mut().find(|part| part.loss_factor.total_cmp(&cords.loss_factor).is_eq()) {
                Some(part) => part.shares.iter_mut().zip(shares).for_each(|(sum, share)| *sum += share),
                None => parts.push(Fibres { loss_factor: cords.loss_factor, shares }),
            }
        }
        let material = &layer.material;
        Self { frequencies: [material.reference_frequency, material.corner_frequency], parts }
    }

    /// Factors f_k at s; zero past the parts.
    pub(super) fn at(&self, s: Complex64) -> [Complex64; MOST_CORD_LOSSES] {
        let [reference, corner] = self.frequencies;
        let mut factors = [Complex64::ZERO; MOST_CORD_LOSSES];
        for (factor, part) in factors.iter_mut().zip(&self.parts) {
            *factor = material::power_law(s, part.loss_factor, reference, corner);
        }
        factors
    }
}

impl ElasticityAt<Complex64> {
    /// Constants of a layer at s \[1/s\].
    pub(super) fn new(layer: &Layer, s: Complex64) -> Self {
        let shear = material::shear_modulus(&layer.material, s);
        let ratios = MaterialRatios::new(layer);
        let mut found = Self {
            plane: ratios.plane.map(|ratio| shear * ratio),
            contraction: ratios.contraction,
            inverse_radial: ratios.inverse_radial / shear,
            shear: ratios.shear.map(|ratio| shear * ratio),
        };
        let cords = CordParts::new(layer);
        for (part, factor) in cords.parts.iter().zip(cords.at(s)) {
            let [along, across, between] = part.shares.map(|share| factor * share);
            let [tt, yy, ty] = &mut found.plane;
            (*tt, *yy, *ty) = (*tt + along, *yy + across, *ty + between);
            found.shear[2] += between;
        }
        found
    }

    /// Ratio to an isotropic layer of the rate at which displacements change across the thickness, for waves along and
    /// across: half the root of Q over the shear modulus outwards, at least 1.
    pub(super) fn steepness(&self) -> [f64; 2] {
        [0, 1].map(|axis| (0.5 * (self.plane[axis] / self.shear[axis]).norm().sqrt()).max(1.0))
    }
}

impl<T: ComplexField> ElasticityAt<T> {
    /// Constants of several s side by side: `value` gives the lanes of an entry.
    #[inline(always)]
    pub(super) fn in_lanes(
        single: &ElasticityAt<Complex64>,
        mut value: impl FnMut(&dyn Fn(&ElasticityAt<Complex64>) -> Complex64) -> T,
    ) -> Self {
        Self {
            plane: [value(&|at| at.plane[0]), value(&|at| at.plane[1]), value(&|at| at.plane[2])],
            contraction: single.contraction,
            inverse_radial: value(&|at| at.inverse_radial),
            shear: [value(&|at| at.shear[0]), value(&|at| at.shear[1]), value(&|at| at.shear[2])],
        }
    }
}
