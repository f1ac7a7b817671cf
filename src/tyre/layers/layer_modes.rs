//! A curved layer at one wave (n, k_y), reduced to its two faces by the modes between held faces.
//!
//! Rows and columns of a face matrix: V, P, w of the inner face, then of the outer one (see [`super::curved`]).

use std::ops::Range;

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use num_complex::Complex64;

use super::coriolis::{CoriolisModes, TurningModes};
use super::elasticity::CordParts;
use super::layer_wave::{LayerWave, by_fields, whole_inertia};
use super::material;
use super::radial_polynomials::RadialProducts;
use super::rotation::Rotation;
use super::triangle::{BLOCK, ENTRIES, upper, upper_places};
use crate::numeric::ComplexField;
use crate::scene::{Layer, MOST_CORD_LOSSES};

/// Pairs of modes of a block.
const PAIRS: usize = BLOCK * (BLOCK - 1) / 2;
/// Most parts in addition to modulus and inertia: prestress and cords.
const MOST_PARTS: usize = 1 + MOST_CORD_LOSSES;

/// mu(s) K' + rho s^2 M' + sum of t_p(s) G_p' less the modes' terms.
///
/// Prestress and cords, the parts G_p, count as stiffness at one s_0: K = K_material + sum G_p f_p(s_0)/mu_0, f = 1
/// for the prestress, and t_p = f_p(s) - f_p(s_0) mu(s)/mu_0 remains of each: modes that they couple are then hardly
/// coupled any more. Cords of all modes of one shape across the layer are nearly diagonal together, whatever t_p.
#[derive(Clone, Debug)]
pub(super) struct LayerModes {
    /// K', M'.
    faces: [[f64; ENTRIES]; 2],
    parts: Vec<Part>,
    blocks: Vec<Block>,
    /// Coupling of the modes of the first block, the lowest ones, by each part, where there are cords: an entry for
    /// each pair. Taken to the first order: c^T (D + E)^-1 c = c^T D^-1 c - c^T D^-1 E D^-1 c.
    coupled: Vec<[f64; PAIRS]>,
    /// Coriolis force, where the tyre turns.
    coriolis: Option<Box<CoriolisModes>>,
    /// Part of the prestress that acts as inertia, where the tyre turns \[Pa/m^2\].
    mean: f64,
}

/// A part of the stiffness that does not follow the modulus.
#[derive(Clone, Debug)]
struct Part {
    /// G_p'.
    faces: [f64; ENTRIES],
    /// f_p(s_0)/mu_0.
    reference: f64,
    /// Index of the cords; `None`: the prestress.
    cords: Option<usize>,
}

#[derive(Clone, Debug)]
struct Block {
    /// lambda_j; 1 past the last one.
    stiffness: [f64; BLOCK],
    /// gamma_pj by part.
    diagonals: Vec<[f64; BLOCK]>,
    terms: Terms,
}

/// Terms c_j c_j^T of modes, c_j = rho s^2 m_j + sum t_p g_pj.
#[derive(Clone, Debug)]
enum Terms {
    /// By entry m_j m_j^T; under tension m_j g_j^T + g_j m_j^T and g_j g_j^T, too.
    Products(Vec<[[f64; BLOCK]; ENTRIES]>),
    /// With cords, whose products would be more numbers than the vectors: m_j, then g_pj, by row.
    Vectors(Vec<[[f64; BLOCK]; 6]>),
}

/// Values of a layer at one s, or at several in lockstep.
#[derive(Clone, Copy, Debug)]
pub(super) struct LayerValues<T> {
    /// mu \[Pa\].
    pub shear: T,
    /// rho s^2 \[Pa/m^2\].
    pub inertia: T,
    /// f of the cords, by loss factor.
    pub fibres: [T; MOST_CORD_LOSSES],
    /// 2 Omega rho s \[Pa/m^2\].
    pub coriolis: T,
}

impl LayerValues<Complex64> {
    /// Values of a layer at s \[1/s\] in steady rotation.
    pub(super) fn new(layer: &Layer, cords: &CordParts, rotation: &Rotation, s: Complex64) -> Self {
        Self {
            shear: material::shear_modulus(&layer.material, s),
            inertia: s * s * layer.material.density,
            fibres: cords.at(s),
            coriolis: rotation.coriolis(layer.material.density, s),
        }
    }
}

/// Blocks of a layer: see [`super::faces`].
pub(super) type Faces<T> = [super::faces::Block<T>; 3];

impl LayerModes {
    /// Reduces a layer at a wave. Where its stiffness cannot be reduced, as for numbers that are not finite, all
    /// values are NaN.
    pub(super) fn new(wave: &LayerWave<'_>, products: &RadialProducts) -> Self {
        Self::between_held_faces(wave, products).unwrap_or(Self::none([[f64::NAN; ENTRIES]; 2]))
    }

    /// The faces alone.
    fn none(faces: [[f64; ENTRIES]; 2]) -> Self {
        Self { faces, parts: Vec::new(), blocks: Vec::new(), coupled: Vec::new(), coriolis: None, mean: 0.0 }
    }

    fn between_held_faces(wave: &LayerWave<'_>, products: &RadialProducts) -> Option<Self> {
        // 1. K: material, prestress and cords at s_0.
        let parts = wave.parts(products);
        let mut stiffness = wave.stiffness(products);
        for (matrix, reference, _) in &parts {
            stiffness += matrix * faer::Scale(*reference);
        }
        let modes = stiffness.nrows() - 6;
        // At s = 0 alone: static condensation, no modes.
        if wave.at_rest {
            let coupling = stiffness.submatrix(6, 0, modes, 6);
            let following = stiffness.submatrix(6, 6, modes, modes).llt(Side::Lower).ok()?.solve(coupling);
            let stiff = reduced(&stiffness, &(following.transpose() * coupling * faer::Scale(-0.5)), None);
            return Some(Self::none([stiff, [0.0; ENTRIES]]));
        }
        // 2. Modes between held faces, K and M on the faces and m_j.
        let held = stiffness.submatrix(6, 6, modes, modes).self_adjoint_eigen(Side::Lower).ok()?;
        let (vectors, squares) = (held.U(), held.S().column_vector());
        let coupling = |matrix: &Mat<f64>| vectors.transpose() * matrix.submatrix(6, 0, modes, 6);
        let pulled = coupling(&stiffness);
        // Motion of the interior that follows the faces at rest, in modes.
        let following = Mat::from_fn(modes, 6, |j, column| -pulled[(j, column)] / squares[j]);
        let stiff = reduced(&stiffness, &(following.transpose() * &pulled * faer::Scale(0.5)), None);
        // M: the identity in the interior; products of the polynomials where a face is involved.
        let inertia = by_fields(products.values.nrows(), |a, b| {
            let m = if a < 2 || b < 2 { products.values_r[(a, b)] } else { 0.0 };
            [m, 0.0, 0.0, m, 0.0, m]
        });
        let moved = coupling(&inertia);
        let heavy = reduced(&inertia, &(following.transpose() * &moved), Some(&(following.transpose() * &following)));
        let moving = moved + &following;
        // 3. Each part: on the faces, g_j and gamma_j.
        let turns = wave.softening > 0.0;
        let has_cords = !wave.cords.is_empty();
        let mut pairs: Vec<[f64; PAIRS]> = Vec::new();
        // Coupling of modes by the prestress, less its mean, to first order.
        let mut tense: Option<Mat<f64>> = None;
        let mut mean = 0.0;
        let parts: Vec<(Part, Mat<f64>, Vec<f64>)> = parts
            .into_iter()
            .map(|(mut matrix, reference, cords)| {
                if turns && cords.is_none() {
                    mean = wave.mean_prestress(products);
                    matrix -= whole_inertia(products) * faer::Scale(mean);
                }
                let modal = vectors.transpose() * matrix.submatrix(6, 6, modes, modes) * vectors;
                let (coupled, inner) = (coupling(&matrix), &modal * &following);
                let condensed = (following.transpose() * &coupled, following.transpose() * &inner);
                let faces = reduced(&matrix, &condensed.0, Some(&condensed.1));
                if has_cords {
                    let entry = |row, column| if column < modes { modal[(row, column)] } else { 0.0 };
                    let all = (0..BLOCK).flat_map(|row| (row + 1..BLOCK).map(move |column| (row, column)));
                    let mut coupled = [0.0; PAIRS];
                    coupled.iter_mut().zip(all).for_each(|(pair, (row, column))| *pair = entry(row, column));
                    pairs.push(coupled);
                }
                let gamma = (0..modes).map(|j| modal[(j, j)]).collect();
                if turns && !has_cords {
                    tense = Some(Mat::from_fn(modes, 6, |j, row| {
                        let apart = |k: &usize| *k != j;
                        let over = |k: usize| modal[(j, k)] / (squares[k] - squares[j]);
                        -(0..modes).filter(apart).map(|k| over(k) * moving[(k, row)]).sum::<f64>()
                    }));
                }
                (Part { faces, reference, cords }, coupled + inner, gamma)
            })
            .collect();
        // 4. Terms of the modes, by blocks.
        let block = |first: usize| {
            let range = first..modes.min(first + BLOCK);
            let padded = |value: &dyn Fn(usize) -> f64, rest: f64| {
                let mut values = [rest; BLOCK];
                values.iter_mut().zip(range.clone()).for_each(|(place, j)| *place = value(j));
                values
            };
            let terms = if has_cords {
                let couplings = parts.iter().map(|(_, pulling, _)| pulling);
                let rows = |matrix: &Mat<f64>| [0, 1, 2, 3, 4, 5].map(|row| padded(&|j| matrix[(j, row)], 0.0));
                Terms::Vectors([&moving].into_iter().chain(couplings).map(rows).collect())
            } else {
                let mut sets = vec![outer_products(&moving, &moving, range.clone())];
                let twice = |f: &Mat<f64>, g: &Mat<f64>| {
                    outer_products(f, g, range.clone()).map(|values| values.map(|x| 2.0 * x))
                };
                for (_, pulling, _) in &parts {
                    sets.extend([twice(&moving, pulling), outer_products(pulling, pulling, range.clone())]);
                }
                sets.extend(tense.iter().map(|tense| twice(&moving, tense)));
                Terms::Products(sets)
            };
            Block {
                stiffness: padded(&|j| squares[j], 1.0),
                diagonals: parts.iter().map(|(.., gamma)| padded(&|j| gamma[j], 0.0)).collect(),
                terms,
            }
        };
        // 5. The Coriolis force.
        let coriolis = turns.then(|| {
            let exchange = by_fields(products.values.nrows(), |a, b| {
                let m = products.values_r[(a, b)];
                [0.0, 0.0, m, 0.0, 0.0, 0.0]
            });
            let modal = vectors.transpose() * exchange.submatrix(6, 6, modes, modes) * vectors;
            let (coupled, inner) = (coupling(&exchange), &modal * &following);
            let condensed = (following.transpose() * &coupled, following.transpose() * &inner);
            let squares: Vec<f64> = squares.iter().copied().collect();
            let couplings = coupled + inner;
            let of = TurningModes {
                squares: &squares,
                moving: &moving,
                couplings: &couplings,
                modal: &modal,
                parts: parts.iter().map(|(_, pulling, _)| pulling).collect(),
                low: squares.iter().filter(|&&square| square < wave.shear_waves).count(),
            };
            Box::new(CoriolisModes::new(reduced(&exchange, &condensed.0, Some(&condensed.1)), &of))
        });
        Some(Self {
            coriolis,
            mean,
            blocks: (0..modes).step_by(BLOCK).map(block).collect(),
            faces: [stiff, heavy],
            coupled: pairs,
            parts: parts.into_iter().map(|(part, ..)| part).collect(),
        })
    }

    /// Tractions on the faces times their radii by displacements: the blocks of [`super::faces`]; of a layer that
    /// turns, without the Coriolis force.
    #[inline(always)]
    pub(super) fn faces<T: ComplexField>(&self, values: &LayerValues<T>) -> Faces<T> {
        values.shear.outlined(
            #[inline(always)]
            || blocks_of(self.entries(values)),
        )
    }

    /// As [`Self::faces`], of the waves n and -n of a tyre that turns, with the Coriolis force.
    #[inline(always)]
    pub(super) fn faces_both_ways<T: ComplexField>(&self, values: &LayerValues<T>) -> [Faces<T>; 2] {
        values.shear.outlined(
            #[inline(always)]
            || {
                let entries = self.entries(values);
                let Some(modes) = &self.coriolis else { return [blocks_of(entries), blocks_of(entries)] };
                let deviation = self.deviation(values);
                let inertia = values.inertia + deviation[0] * self.mean;
                let both = modes.both_ways(entries, [values.coriolis, inertia], values.shear, &deviation);
                let [forwards, backwards] = both;
                [blocks_of(forwards), blocks_of(backwards)]
            },
        )
    }

    /// t_p = f(s) less the fraction of each part that follows the modulus.
    #[inline(always)]
    fn deviation<T: ComplexField>(&self, values: &LayerValues<T>) -> [T; MOST_PARTS] {
        let shear = values.shear;
        let mut deviation = [shear; MOST_PARTS];
        for (deviation, part) in deviation.iter_mut().zip(&self.parts) {
            *deviation = match part.cords {
                None => shear * -part.reference + 1.0,
                Some(index) => shear * -part.reference + values.fibres[index],
            };
        }
        deviation
    }

    /// Tractions of the faces with the modes at rest.
    #[inline(always)]
    fn held<T: ComplexField>(&self, values: &LayerValues<T>, deviation: &[T; MOST_PARTS]) -> [T; ENTRIES] {
        // Loops, not closures over arrays: a call of those would end the lanes' vector code.
        let LayerValues { shear, inertia, .. } = *values;
        let [stiff, heavy] = &self.faces;
        let mut entries = [shear; ENTRIES];
        for k in 0..ENTRIES {
            entries[k] = (shear * stiff[k]).plus_scaled(heavy[k], inertia);
        }
        for (deviation, part) in deviation.iter().zip(&self.parts) {
            for (entry, value) in entries.iter_mut().zip(&part.faces) {
                *entry = entry.plus_scaled(*value, *deviation);
            }
        }
        entries
    }

    /// Entries of the face matrix, without the Coriolis force.
    #[inline(always)]
    fn entries<T: ComplexField>(&self, values: &LayerValues<T>) -> [T; ENTRIES] {
        let deviation = self.deviation(values);
        let mut values = *values;
        let mut coupled = deviation[0];
        if self.coriolis.is_some() {
            values.inertia = values.inertia + deviation[0] * self.mean;
            coupled = values.inertia * values.inertia * deviation[0] * values.shear.reciprocal();
        }
        let (values, inertia) = (&values, values.inertia);
        let mut entries = self.held(values, &deviation);
        let factors = [inertia * inertia, inertia * deviation[0], deviation[0] * deviation[0], coupled];
        for (index, block) in self.blocks.iter().enumerate() {
            let inverse = block.inverse(values, &deviation);
            match &block.terms {
                Terms::Products(products) => {
                    for (products, factor) in products.iter().zip(factors) {
                        add(&mut entries, products, factor, &inverse);
                    }
                }
                Terms::Vectors(vectors) => {
                    let coupled: &[[f64; PAIRS]] = if index == 0 { &self.coupled } else { &[] };
                    add_vectors(&mut entries, vectors, coupled, inertia, &deviation, &inverse);
                }
            }
        }
        entries
    }
}

impl Block {
    /// d_j = mu lambda_j + rho s^2 + sum t_p gamma_pj.
    #[inline(always)]
    fn impedance<T: ComplexField>(&self, values: &LayerValues<T>, deviation: &[T; MOST_PARTS], j: usize) -> T {
        let LayerValues { shear, inertia, .. } = *values;
        let mut sum = shear * self.stiffness[j];
        for (diagonal, deviation) in self.diagonals.iter().zip(deviation) {
            sum = sum.plus_scaled(diagonal[j], *deviation);
        }
        sum + inertia
    }

    /// -1/d_j.
    #[inline(always)]
    fn inverse<T: ComplexField>(&self, values: &LayerValues<T>, deviation: &[T; MOST_PARTS]) -> [T; BLOCK] {
        let mut inverse = [values.shear; BLOCK];
        for (j, inverse) in inverse.iter_mut().enumerate() {
            *inverse = -self.impedance(values, deviation, j).reciprocal();
        }
        inverse
    }
}

/// The blocks of a symmetric 6x6 matrix given by its upper triangle.
#[inline(always)]
fn blocks_of<T>(entries: [T; ENTRIES]) -> Faces<T>
where
    T: Copy,
{
    let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u] = entries;
    [[[a, b, c], [b, g, h], [c, h, l]], [[d, e, f], [i, j, k], [m, n, o]], [[p, q, r], [q, s, t], [r, t, u]]]
}

/// c_j = inertia m_j + sum of t_p g_pj.
#[inline(always)]
fn force_of<T: ComplexField>(
    vectors: &[[[f64; BLOCK]; 6]],
    inertia: T,
    deviation: &[T; MOST_PARTS],
    j: usize,
) -> [T; 6] {
    let mut c = [inertia; 6];
    for row in 0..6 {
        let mut sum = inertia * vectors[0][row][j];
        for (vector, deviation) in vectors[1..].iter().zip(deviation) {
            sum = sum.plus_scaled(vector[row][j], *deviation);
        }
        c[row] = sum;
    }
    c
}

/// Entries of the faces in a matrix, with those of the interior that follows them: `cross` and its transpose, and
/// `square`.
fn reduced(matrix: &Mat<f64>, cross: &Mat<f64>, square: Option<&Mat<f64>>) -> [f64; ENTRIES] {
    upper(|row, column| {
        let square = square.map_or(0.0, |square| square[(row, column)]);
        matrix[(row, column)] + cross[(row, column)] + cross[(column, row)] + square
    })
}

/// Symmetric part of f_j g_j^T for some modes j, rows of both.
fn outer_products(f: &Mat<f64>, g: &Mat<f64>, modes: Range<usize>) -> [[f64; BLOCK]; ENTRIES] {
    let mut entries = [[0.0; BLOCK]; ENTRIES];
    for (values, (row, column)) in entries.iter_mut().zip(upper_places()) {
        for (value, j) in values.iter_mut().zip(modes.clone()) {
            *value = 0.5 * (f[(j, row)] * g[(j, column)] + f[(j, column)] * g[(j, row)]);
        }
    }
    entries
}

/// Adds products (factor inverse) to `entries`.
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

/// Adds c_j c_j^T inverse_j to `entries`, where c_j = inertia m_j + sum of t_p g_pj, and the coupling of the
/// block's modes.
#[inline(always)]
fn add_vectors<T: ComplexField>(
    entries: &mut [T; ENTRIES],
    vectors: &[[[f64; BLOCK]; 6]],
    coupled: &[[f64; PAIRS]],
    inertia: T,
    deviation: &[T; MOST_PARTS],
    inverse: &[T; BLOCK],
) {
    // c_j inverse_j, mode by mode.
    let mut moved = [[inertia; 6]; BLOCK];
    for j in 0..BLOCK {
        let c = force_of(vectors, inertia, deviation, j);
        for row in 0..6 {
            moved[j][row] = c[row] * inverse[j];
        }
        let mut k = 0;
        for (row, moved) in moved[j].into_iter().enumerate() {
            for value in &c[row..] {
                entries[k] = entries[k] + moved * *value;
                k += 1;
            }
        }
    }
    add_coupled(entries, coupled, deviation, &moved);
}

/// Adds the coupling of a block's modes to first order to `entries`, from their motion c_j/d_j.
#[inline(always)]
fn add_coupled<T: ComplexField>(
    entries: &mut [T; ENTRIES],
    coupled: &[[f64; PAIRS]],
    deviation: &[T; MOST_PARTS],
    moved: &[[T; 6]; BLOCK],
) {
    let [first, others @ ..] = coupled else { return };
    let mut pair = 0;
    for i in 0..BLOCK {
        // Row i of E from the diagonal on, times the modes' motion.
        let mut driven = [deviation[0] * 0.0; 6];
        for moved in &moved[i + 1..] {
            let mut e = deviation[0] * first[pair];
            for (other, deviation) in others.iter().zip(&deviation[1..]) {
                e = e.plus_scaled(other[pair], *deviation);
            }
            pair += 1;
            for row in 0..6 {
                driven[row] = driven[row] + e * moved[row];
            }
        }
        let mut k = 0;
        for row in 0..6 {
            for column in row..6 {
                entries[k] = entries[k] + moved[i][row] * driven[column] + moved[i][column] * driven[row];
                k += 1;
            }
        }
    }
}
