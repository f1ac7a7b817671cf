//! A curved layer at one wave (n, k_y), reduced to its two faces by the modes between held faces.
//!
//! Rows and columns of a face matrix: V, P, w of the inner face, then of the outer one (see [`super::curved`]).

use std::ops::Range;

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::radial_polynomials::RadialProducts;
use crate::numeric::ComplexField;

/// Entries of the upper triangle of a symmetric 6x6 matrix.
const ENTRIES: usize = 21;
/// Modes whose terms are added together: their coefficients stay in the processor's first cache.
const BLOCK: usize = 8;

/// mu(s) K' + rho s^2 M' + t(s) G' less the modes' terms.
///
/// The prestress counts as stiffness at one modulus mu_0, K = K_elastic + G/mu_0, and t = 1 - mu(s)/mu_0 is what is
/// left of it: modes that the prestress couples are then hardly coupled any more.
#[derive(Clone, Debug)]
pub(super) struct LayerModes {
    /// K', M', G'.
    faces: [[f64; ENTRIES]; 3],
    /// 1/mu_0 under tension.
    reference: Option<f64>,
    blocks: Vec<Block>,
}

/// Some modes.
#[derive(Clone, Debug)]
struct Block {
    /// lambda_j; 1 past the last one.
    stiffness: [f64; BLOCK],
    /// gamma_j.
    prestress: [f64; BLOCK],
    /// m_j m_j^T, m_j g_j^T + g_j m_j^T and g_j g_j^T by entry; the last two only under tension.
    products: Vec<[[f64; BLOCK]; ENTRIES]>,
}

/// Properties of a layer that its waves depend on.
#[derive(Clone, Copy, Debug)]
pub(super) struct LayerWave {
    /// n, k_y \[1/m\].
    pub n: f64,
    pub ky: f64,
    /// lambda/mu.
    pub lame_ratio: f64,
    /// S, S_y \[Pa\].
    pub prestress: [f64; 2],
    /// mu_0 \[Pa\].
    pub shear: f64,
    /// True if s = 0 is all that will be asked for, and mu_0 the modulus there: no mode moves then.
    pub at_rest: bool,
}

impl LayerWave {
    /// K_elastic: the energy over mu as a matrix over V, P, w, each over all polynomials.
    fn stiffness(&self, products: &RadialProducts) -> Mat<f64> {
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

    /// G: the prestress.
    fn prestress(&self, products: &RadialProducts) -> Mat<f64> {
        let Self { n, ky, prestress: [along, across], .. } = *self;
        by_fields(products.values.nrows(), |a, b| {
            let (i, m) = (along * products.values_over_r[(a, b)], across * ky * ky * products.values_r[(a, b)]);
            let both = (n * n + 1.0) * i + m;
            [both, 0.0, 2.0 * n * i, n * n * i + m, 0.0, both]
        })
    }
}

/// A symmetric matrix over three fields of so many polynomials from its entries VV, VP, Vw, PP, Pw, ww. Order: V, P, w
/// of the inner face, of the outer one, then the interior's V, P, w.
fn by_fields(polynomials: usize, entries: impl Fn(usize, usize) -> [f64; 6]) -> Mat<f64> {
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

/// Rows and columns of the upper triangle, row by row.
fn upper_places() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|row| (row..6).map(move |column| (row, column)))
}

fn upper(entry: impl Fn(usize, usize) -> f64) -> [f64; ENTRIES] {
    let mut entries = [0.0; ENTRIES];
    for (value, (row, column)) in entries.iter_mut().zip(upper_places()) {
        *value = entry(row, column);
    }
    entries
}

impl LayerModes {
    /// Reduces a layer at a wave. Where its stiffness cannot be reduced, as for numbers that are not finite, nothing of
    /// it is a number.
    pub fn new(wave: &LayerWave, products: &RadialProducts) -> Self {
        let nothing = [[f64::NAN; ENTRIES]; 3];
        Self::between_held_faces(wave, products).unwrap_or(Self { faces: nothing, reference: None, blocks: Vec::new() })
    }

    fn between_held_faces(wave: &LayerWave, products: &RadialProducts) -> Option<Self> {
        let tense = wave.prestress.iter().any(|stress| stress.abs() > 0.0);
        let prestress = tense.then(|| wave.prestress(products));
        let mut stiffness = wave.stiffness(products);
        if let Some(prestress) = &prestress {
            stiffness += prestress * faer::Scale(wave.shear.recip());
        }
        let modes = stiffness.nrows() - 6;
        if wave.at_rest {
            let coupling = stiffness.submatrix(6, 0, modes, 6);
            let following = stiffness.submatrix(6, 6, modes, modes).llt(Side::Lower).ok()?.solve(coupling);
            let stiff = reduced(&stiffness, &(following.transpose() * coupling * faer::Scale(-0.5)), None);
            let faces = [stiff, [0.0; ENTRIES], [0.0; ENTRIES]];
            return Some(Self { faces, reference: None, blocks: Vec::new() });
        }
        let held = stiffness.submatrix(6, 6, modes, modes).self_adjoint_eigen(Side::Lower).ok()?;
        let (vectors, squares) = (held.U(), held.S().column_vector());
        let coupling = |matrix: &Mat<f64>| vectors.transpose() * matrix.submatrix(6, 0, modes, 6);
        let pulled = coupling(&stiffness);
        // How the interior follows the faces at rest, in modes.
        let following = Mat::from_fn(modes, 6, |j, column| -pulled[(j, column)] / squares[j]);
        let stiff = reduced(&stiffness, &(following.transpose() * &pulled * faer::Scale(0.5)), None);
        // M: the identity in the interior, the products of the polynomials beside it.
        let inertia = by_fields(products.values.nrows(), |a, b| {
            let m = if a < 2 || b < 2 { products.values_r[(a, b)] } else { 0.0 };
            [m, 0.0, 0.0, m, 0.0, m]
        });
        let moved = coupling(&inertia);
        let heavy = reduced(&inertia, &(following.transpose() * &moved), Some(&(following.transpose() * &following)));
        let moving = moved + &following;
        let tight = prestress.map(|matrix| {
            let modal = vectors.transpose() * matrix.submatrix(6, 6, modes, modes) * vectors;
            let (coupled, inner) = (coupling(&matrix), &modal * &following);
            let faces = reduced(&matrix, &(following.transpose() * &coupled), Some(&(following.transpose() * &inner)));
            let own: Vec<f64> = (0..modes).map(|j| modal[(j, j)]).collect();
            (faces, coupled + inner, own)
        });
        let block = |first: usize| {
            let range = first..modes.min(first + BLOCK);
            let mut sets = vec![outer_products(&moving, &moving, range.clone())];
            let (mut lambda, mut gamma) = ([1.0; BLOCK], [0.0; BLOCK]);
            for (lambda, j) in lambda.iter_mut().zip(range.clone()) {
                *lambda = squares[j];
            }
            if let Some((_, pulling, own)) = &tight {
                gamma[..range.len()].copy_from_slice(&own[range.clone()]);
                let twice = outer_products(&moving, pulling, range.clone()).map(|values| values.map(|x| 2.0 * x));
                sets.extend([twice, outer_products(pulling, pulling, range)]);
            }
            Block { stiffness: lambda, prestress: gamma, products: sets }
        };
        Some(Self {
            blocks: (0..modes).step_by(BLOCK).map(block).collect(),
            faces: [stiff, heavy, tight.as_ref().map_or([0.0; ENTRIES], |(faces, ..)| *faces)],
            reference: tense.then(|| wave.shear.recip()),
        })
    }

    /// Tractions on the faces times their radii by displacements, at mu and rho s^2: the blocks within the inner face,
    /// from the outer face to the inner one (rows), and within the outer face.
    #[inline(always)]
    pub fn faces<T: ComplexField>(&self, shear: T, inertia: T) -> [[[T; 3]; 3]; 3] {
        // Loops, not closures over arrays: a call of those would end the lanes' vector instructions.
        let [stiff, heavy, tight] = &self.faces;
        let mut entries = [shear; ENTRIES];
        for k in 0..ENTRIES {
            entries[k] = (shear * stiff[k]).plus_scaled(heavy[k], inertia);
        }
        let squared = inertia * inertia;
        if let Some(reference) = self.reference {
            let left = shear * -reference + 1.0;
            let (mixed, left_squared) = (inertia * left, left * left);
            for k in 0..ENTRIES {
                entries[k] = entries[k].plus_scaled(tight[k], left);
            }
            for block in &self.blocks {
                let mut inverse = [shear; BLOCK];
                for (j, inverse) in inverse.iter_mut().enumerate() {
                    let sum = (shear * block.stiffness[j]).plus_scaled(block.prestress[j], left) + inertia;
                    *inverse = -sum.reciprocal();
                }
                for (products, factor) in block.products.iter().zip([squared, mixed, left_squared]) {
                    add(&mut entries, products, factor, &inverse);
                }
            }
        } else {
            for block in &self.blocks {
                let mut inverse = [shear; BLOCK];
                for (j, inverse) in inverse.iter_mut().enumerate() {
                    *inverse = -(shear * block.stiffness[j] + inertia).reciprocal();
                }
                for products in &block.products {
                    add(&mut entries, products, squared, &inverse);
                }
            }
        }
        let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u] = entries;
        [[[a, b, c], [b, g, h], [c, h, l]], [[d, e, f], [i, j, k], [m, n, o]], [[p, q, r], [q, s, t], [r, t, u]]]
    }
}

/// The faces' own entries of a matrix with what follows them: `cross` and its transpose, and `own`.
fn reduced(matrix: &Mat<f64>, cross: &Mat<f64>, own: Option<&Mat<f64>>) -> [f64; ENTRIES] {
    upper(|row, column| {
        let own = own.map_or(0.0, |own| own[(row, column)]);
        matrix[(row, column)] + cross[(row, column)] + cross[(column, row)] + own
    })
}

/// The symmetric part of f_j g_j^T for some modes j, rows of both.
fn outer_products(f: &Mat<f64>, g: &Mat<f64>, modes: Range<usize>) -> [[f64; BLOCK]; ENTRIES] {
    let mut entries = [[0.0; BLOCK]; ENTRIES];
    for (values, (row, column)) in entries.iter_mut().zip(upper_places()) {
        for (value, j) in values.iter_mut().zip(modes.clone()) {
            *value = 0.5 * (f[(j, row)] * g[(j, column)] + f[(j, column)] * g[(j, row)]);
        }
    }
    entries
}

/// entries += products (factor inverse).
#[inline(always)]
fn add<T: ComplexField>(
    entries: &mut [T; ENTRIES],
    products: &[[f64; BLOCK]; ENTRIES],
    factor: T,
    inverse: &[T; BLOCK],
) {
    let mut coefficients = *inverse;
    for coefficient in &mut coefficients {
        *coefficient = *coefficient * factor;
    }
    for k in 0..ENTRIES {
        let mut sum = entries[k];
        for j in 0..BLOCK {
            sum = sum.plus_scaled(products[k][j], coefficients[j]);
        }
        entries[k] = sum;
    }
}
