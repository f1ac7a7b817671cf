//! Energy of a curved layer at one wave (n, k_y), as matrices over the polynomials of its fields.

use faer::Mat;

use super::elasticity::{Fibres, MaterialRatios};
use super::radial_polynomials::RadialProducts;
use crate::scene::MOST_CORD_LOSSES;

/// Properties of a layer on which its waves depend.
#[derive(Clone, Debug)]
pub(super) struct LayerWave<'a> {
    /// n, k_y \[1/m\].
    pub n: f64,
    pub ky: f64,
    /// lambda/mu.
    pub lame_ratio: f64,
    /// Constants over mu, where the material is not isotropic.
    pub orthotropic: Option<MaterialRatios>,
    /// S, S_y \[Pa\].
    pub prestress: [f64; 2],
    /// rho Omega^2 of a tyre that turns \[Pa/m^2\]; 0 at rest.
    pub softening: f64,
    /// Cords, and their f at s_0.
    pub cords: &'a [Fibres],
    pub fibres: [f64; MOST_CORD_LOSSES],
    /// mu_0 \[Pa\].
    pub shear: f64,
    /// Square of the largest wavenumber of shear waves \[1/m^2\].
    pub shear_waves: f64,
    /// True if s = 0 is the only s, and mu_0 the modulus there: no mode moves then.
    pub at_rest: bool,
}

impl LayerWave<'_> {
    /// K_material: the energy over mu as a matrix over V, P, w, each over all polynomials.
    pub(super) fn stiffness(&self, products: &RadialProducts) -> Mat<f64> {
        if let Some(ratios) = &self.orthotropic {
            return self.orthotropic(ratios, products);
        }
        let Self { n, ky, lame_ratio: lame, .. } = *self;
        let (n_squared, ky_squared) = (n * n, ky * ky);
        by_fields(products.values.nrows(), |a, b| {
            let (d, h, h_t) = (products.slopes[(a, b)], products.slope_value[(a, b)], products.value_slope[(a, b)]);
            let (i, f, m) = (products.values_over_r[(a, b)], products.values[(a, b)], products.values_r[(a, b)]);
            let (hr, hr_t) = (products.slope_value_r[(a, b)], products.value_slope_r[(a, b)]);
            [
                (lame + 2.0) * n_squared * i + d - h - h_t + i + ky_squared * m,
                (lame + 1.0) * n * ky * f,
                n * (lame * (h_t + i) + 3.0 * i - h),
                (lame + 2.0) * ky_squared * m + d + n_squared * i,
                ky * (lame * (hr_t + f) - hr),
                lame * (d + h + h_t + i) + 2.0 * (d + i) + n_squared * i + ky_squared * m,
            ]
        })
    }

    /// K_material of an orthotropic material: int [Q_tt e_t^2 + Q_yy e_y^2 + 2 Q_ty e_t e_y + C_rr
    /// (e_r + a_t e_t + a_y e_y)^2 + G_tr g_rt^2 + G_yr g_ry^2 + G_ty g_ty^2] r dr.
    pub(super) fn orthotropic(&self, ratios: &MaterialRatios, products: &RadialProducts) -> Mat<f64> {
        let Self { n, ky, .. } = *self;
        let MaterialRatios { plane: [tt, yy, ty], contraction: [at, ay], inverse_radial, shear } = *ratios;
        let [tr, yr, in_plane] = shear;
        let rr = inverse_radial.recip();
        let (c_tr, c_yr) = (rr * at, rr * ay);
        let mut matrix = self.membrane([tt + c_tr * at, yy + c_yr * ay, ty + c_tr * ay], in_plane, products);
        matrix += by_fields(products.values.nrows(), |a, b| {
            let (d, h, h_t) = (products.slopes[(a, b)], products.slope_value[(a, b)], products.value_slope[(a, b)]);
            let (i, m) = (products.values_over_r[(a, b)], products.values_r[(a, b)]);
            let (hr, hr_t) = (products.slope_value_r[(a, b)], products.value_slope_r[(a, b)]);
            [
                tr * (d - h - h_t + i),
                0.0,
                n * (c_tr * h_t + tr * (i - h)),
                yr * d,
                ky * (c_yr * hr_t - yr * hr),
                c_tr * (h + h_t) + rr * d + tr * n * n * i + yr * ky * ky * m,
            ]
        });
        matrix
    }

    /// Energy of strains in the layer's surface: int [tt e_t^2 + yy e_y^2 + 2 ty e_t e_y + G g_ty^2] r dr.
    pub(super) fn membrane(&self, [tt, yy, ty]: [f64; 3], in_plane: f64, products: &RadialProducts) -> Mat<f64> {
        let Self { n, ky, .. } = *self;
        by_fields(products.values.nrows(), |a, b| {
            let (i, f, m) = (products.values_over_r[(a, b)], products.values[(a, b)], products.values_r[(a, b)]);
            [
                tt * n * n * i + in_plane * ky * ky * m,
                (ty + in_plane) * n * ky * f,
                tt * n * i,
                yy * ky * ky * m + in_plane * n * n * i,
                ty * ky * f,
                tt * i,
            ]
        })
    }

    /// Parts of the stiffness that do not follow the modulus, each with f(s_0)/mu_0 and the index of its cords
    /// (`None`: prestress).
    pub(super) fn parts(&self, products: &RadialProducts) -> Vec<(Mat<f64>, f64, Option<usize>)> {
        let tense = self.softening > 0.0 || self.prestress.iter().any(|stress| stress.abs() > 0.0);
        let inverse = self.shear.recip();
        let tension = tense.then(|| (self.prestress(products), inverse, None));
        let cords = self.cords.iter().zip(self.fibres).enumerate().map(|(index, (cords, fibres))| {
            let [along, across, between] = cords.shares;
            (self.membrane([along, across, between], between, products), fibres * inverse, Some(index))
        });
        tension.into_iter().chain(cords).collect()
    }

    /// Mean of the prestress over the layer, as an inertia of V and w \[Pa/m^2\].
    pub(super) fn mean_prestress(&self, products: &RadialProducts) -> f64 {
        let Self { n, ky, prestress: [along, across], softening, .. } = *self;
        // Of a displacement that is constant across the layer.
        let sum = |matrix: &Mat<f64>| -> f64 { (0..2).map(|a| (0..2).map(|b| matrix[(a, b)]).sum::<f64>()).sum() };
        along * n * n * sum(&products.values_over_r) / sum(&products.values_r) + across * ky * ky - softening
    }

    /// G: the prestress, less rho Omega^2 of rotation.
    pub(super) fn prestress(&self, products: &RadialProducts) -> Mat<f64> {
        let Self { n, ky, prestress: [along, across], softening, .. } = *self;
        by_fields(products.values.nrows(), |a, b| {
            let (i, m) = (along * products.values_over_r[(a, b)], across * ky * ky * products.values_r[(a, b)]);
            let both = (n * n + 1.0) * i + m - softening * products.values_r[(a, b)];
            [both, 0.0, 2.0 * n * i, n * n * i + m, 0.0, both]
        })
    }
}

/// Symmetric matrix over three fields of so many polynomials from its entries VV, VP, Vw, PP, Pw, ww. Order: V, P, w
/// of the inner face, of the outer one, then the interior's V, P, w.
pub(super) fn by_fields(polynomials: usize, entries: impl Fn(usize, usize) -> [f64; 6]) -> Mat<f64> {
    let place = |field: usize, a: usize| if a < 2 { 3 * a + field } else { 4 + field * (polynomials - 2) + a };
    let mut matrix = Mat::zeros(3 * polynomials, 3 * polynomials);
    for b in 0..polynomials {
        for a in 0..polynomials {
            let [vv, vp, vw, pp, pw, ww] = entries(a, b);
            for (field, value) in [vv, pp, ww].into_iter().enumerate() {
                matrix[(place(field, a), place(field, b))] = value;
            }
            for (row, column, value) in [(0, 1, vp), (0, 2, vw), (1, 2, pw)] {
                matrix[(place(row, a), place(column, b))] = value;
                matrix[(place(column, b), place(row, a))] = value;
            }
        }
    }
    matrix
}

/// M of all polynomials.
pub(super) fn whole_inertia(products: &RadialProducts) -> Mat<f64> {
    by_fields(products.values.nrows(), |a, b| {
        let m = products.values_r[(a, b)];
        [m, 0.0, 0.0, m, 0.0, m]
    })
}
