//! The Coriolis force in a curved layer that is reduced to its two faces.
//!
//! The cross mass Gam of V and w adds i g Gam to the layer's matrix, g = 2 Omega rho s. Reduced like a part of the
//! stiffness (see [`super::layer_modes`]) it is Gam' on the faces, pulls h_j of the modes and Gam_jk between them. To
//! the second order in g, with x = (rho s^2 + ...)/mu and y_j = lambda_j/(lambda_j + x),
//!
//! ```text
//! Z = Z_0 + i g A(x) + (g^2/mu) B(x),
//! A = Gam' - sum_j (1 - y_j)(h_j m_j^T + m_j h_j^T) + sum_jk Gam_jk (1 - y_j)(1 - y_k) m_j m_k^T,
//! B = sum_j f_j f_j^T/(lambda_j + x),   f_j = h_j - sum_k Gam_jk (1 - y_k) m_k:
//! ```
//!
//! what is odd in Omega and what is even, for the waves n and -n at once. Both are rational functions of x with real
//! coefficients and poles at -lambda_j, so that no product over pairs of modes remains:
//!
//! ```text
//! A = A_0 + sum_j (A_j1 y_j + A_j2 y_j^2),   B = sum_j (B_j1 y_j + B_j2 y_j^2 + B_j3 y_j^3).
//! ```
//!
//! Parts of the stiffness that do not follow the modulus pull modes by t g_j as well: - i g sum_j (t/mu lambda_j) (h_j
//! g_j^T + g_j h_j^T).
//!
//! High modes are quasi-static: y as a function of 1/lambda is a parabola through its values at three Lambda_p, which
//! stand for all of them.
//!
//! Error: at most 7e-6 of C up to 6 kHz and 5e-5 up to 10 kHz at 250 km/h (default tyres).

use faer::Mat;

use super::triangle::{BLOCK, ENTRIES, upper};
use crate::numeric::ComplexField;

/// Number of Lambda_p that stand for the high modes.
const POLES: usize = 3;
/// Most blocks of poles.
const MOST_BLOCKS: usize = 4;
/// Sets of coefficients: of y and y^2 in A, of y, y^2 and y^3 in B.
const SETS: usize = 5;
/// Least relative distance of two lambda_j: closer ones are moved apart, so that residues are finite.
const APART: f64 = 1e-5;

type Entries = [f64; ENTRIES];
type Vector = [f64; 6];

/// Coriolis force of a layer, between its faces.
#[derive(Clone, Debug)]
pub(super) struct CoriolisModes {
    /// A_0.
    constant: Entries,
    /// Minus sum_j (h_j g_j^T + g_j h_j^T)/lambda_j, by part.
    parts: Vec<Entries>,
    blocks: Vec<PoleBlock>,
}

/// [`BLOCK`] poles and their coefficients; unused poles have coefficients of 0.
#[derive(Clone, Debug)]
struct PoleBlock {
    /// lambda_j; the last block ends with Lambda_p.
    squares: [f64; BLOCK],
    /// By set, entry and pole.
    sets: [[[f64; BLOCK]; ENTRIES]; SETS],
}

/// Properties of the modes of a layer that turns.
pub(super) struct TurningModes<'a> {
    /// lambda_j, rising.
    pub squares: &'a [f64],
    /// m_j and h_j, in rows.
    pub moving: &'a Mat<f64>,
    pub couplings: &'a Mat<f64>,
    /// Gam_jk.
    pub modal: &'a Mat<f64>,
    /// g_j of each part of the stiffness, in rows.
    pub parts: Vec<&'a Mat<f64>>,
    /// Number of modes with which waves of the largest s resonate.
    pub low: usize,
}

struct Pole {
    square: f64,
    sets: [Entries; SETS],
}

impl CoriolisModes {
    /// `faces`: Gam'.
    pub(super) fn new(faces: Entries, modes: &TurningModes<'_>) -> Self {
        let TurningModes { squares, moving, couplings, modal, ref parts, low } = *modes;
        let count = squares.len();
        // 1. Distinct lambda_j.
        let mut apart = squares.to_vec();
        for j in 1..count {
            apart[j] = apart[j].max(apart[j - 1] * (1.0 + APART));
        }
        // 2. The pole of each mode.
        let row = |matrix: &Mat<f64>, j: usize| -> Vector { std::array::from_fn(|row| matrix[(j, row)]) };
        let (m, h): (Vec<Vector>, Vec<Vector>) = (0..count).map(|j| (row(moving, j), row(couplings, j))).unzip();
        let rows = (0..count).map(|j| modal.col_as_slice(j)).collect();
        let residues = Residues { squares: &apart, m: &m, h: &h, modal, rows };
        let mut constant = faces;
        let mut found: Vec<Pole> = (0..count).map(|a| residues.pole(a, &mut constant)).collect();
        // 3. As many poles as fill blocks; the high modes begin where the gap is widest.
        let most = (low + POLES).div_ceil(BLOCK).clamp(1, MOST_BLOCKS) * BLOCK - POLES;
        if count > most {
            let gap = |&j: &usize| apart[j] / apart[j - 1];
            let first = (most - POLES..=most).max_by(|a, b| gap(a).total_cmp(&gap(b))).unwrap_or(most);
            let high = found.split_off(first);
            found.extend(together(&high));
        }
        // 4. Poles by blocks, coefficients side by side.
        let blocks = found.chunks(BLOCK).map(|poles| {
            let mut block = PoleBlock { squares: [1.0; BLOCK], sets: [[[0.0; BLOCK]; ENTRIES]; SETS] };
            for (place, pole) in poles.iter().enumerate() {
                block.squares[place] = pole.square;
                for (set, pole_set) in block.sets.iter_mut().zip(&pole.sets) {
                    set.iter_mut().zip(pole_set).for_each(|(entry, value)| entry[place] = *value);
                }
            }
            block
        });
        let part = |pulling: &&Mat<f64>| {
            upper(|one, other| {
                let term = |j: usize| h[j][one] * pulling[(j, other)] + pulling[(j, one)] * h[j][other];
                -(0..count).map(|j| term(j) / squares[j]).sum::<f64>()
            })
        };
        Self { constant, parts: parts.iter().map(part).collect(), blocks: blocks.collect() }
    }

    /// Entries of both waves, n and -n, from those without the Coriolis force; g and mu x \[Pa/m^2\], mu, and t by
    /// part.
    #[inline(always)]
    pub(super) fn both_ways<T: ComplexField>(
        &self,
        entries: [T; ENTRIES],
        [g, inertia]: [T; 2],
        shear: T,
        deviation: &[T],
    ) -> [[T; ENTRIES]; 2] {
        let over = shear.reciprocal();
        let x = inertia * over;
        let zero = g * 0.0;
        let (mut odd, mut even) = ([zero; ENTRIES], [zero; ENTRIES]);
        for (entry, constant) in odd.iter_mut().zip(&self.constant) {
            *entry = zero + *constant;
        }
        for (part, deviation) in self.parts.iter().zip(deviation) {
            let share = *deviation * over;
            for k in 0..ENTRIES {
                odd[k] = odd[k].plus_scaled(part[k], share);
            }
        }
        // y, y^2, y^3 of a block of poles, then their sums for each entry.
        for block in &self.blocks {
            let (mut y, mut squared, mut cubed) = ([zero; BLOCK], [zero; BLOCK], [zero; BLOCK]);
            for j in 0..BLOCK {
                y[j] = (x + block.squares[j]).reciprocal() * block.squares[j];
                squared[j] = y[j] * y[j];
                cubed[j] = squared[j] * y[j];
            }
            let [first, second, even_first, even_second, even_third] = &block.sets;
            for k in 0..ENTRIES {
                let (mut a, mut b) = (odd[k], even[k]);
                for j in 0..BLOCK {
                    a = a.plus_scaled(first[k][j], y[j]).plus_scaled(second[k][j], squared[j]);
                    b = b.plus_scaled(even_first[k][j], y[j]).plus_scaled(even_second[k][j], squared[j]);
                    b = b.plus_scaled(even_third[k][j], cubed[j]);
                }
                (odd[k], even[k]) = (a, b);
            }
        }
        let (force, squared) = (g.times_i(), g * g * over);
        let mut both = [entries, entries];
        for k in 0..ENTRIES {
            let (even, odd) = (entries[k] + even[k] * squared, odd[k] * force);
            both[0][k] = even + odd;
            both[1][k] = even - odd;
        }
        both
    }
}

/// Vectors and couplings of modes, for the residues of A and B.
struct Residues<'a> {
    squares: &'a [f64],
    m: &'a [Vector],
    h: &'a [Vector],
    modal: &'a Mat<f64>,
    /// Rows of `modal`, which is symmetric.
    rows: Vec<&'a [f64]>,
}

impl Residues<'_> {
    /// Pole of the mode a; adds to A_0 what does not depend on x.
    fn pole(&self, a: usize, constant: &mut Entries) -> Pole {
        let Self { squares, m, h, modal, ref rows } = *self;
        let (count, square) = (squares.len(), squares[a]);
        // 1. Of A: - (1 - y) U + (1 - y)^2 W.
        let mut u = h[a];
        for k in (0..count).filter(|&k| k != a) {
            add(&mut u, modal[(a, k)] * square / (squares[k] - square), &m[k]);
        }
        let u = twice_symmetric(&u, &m[a]);
        let w = scaled(&twice_symmetric(&m[a], &m[a]), 0.5 * modal[(a, a)]);
        for k in 0..ENTRIES {
            constant[k] += w[k] - u[k];
        }
        // 2. Of B, by powers of 1/(lambda_a + x): F_j = singular_j/(lambda_a + x) + rest_j + slope_j (lambda_a + x) and
        // so on, with singular_j = lambda_a Gam_ja m_a and rest_j = h_j + sum_k Gam_jk weight_k m_k. The other modes
        // divide by lambda_j - lambda_a; their contributions are summed before they are multiplied.
        let weight = |k: usize| if k == a { -1.0 } else { square / (squares[k] - square) };
        let (mut rest, mut slope) = (h[a], [0.0; 6]);
        let (mut others, mut coupled, mut sum, mut sum_of_squares) = ([0.0; 6], vec![0.0; count], 0.0, 0.0);
        for k in 0..count {
            let coupling = modal[(a, k)];
            add(&mut rest, coupling * weight(k), &m[k]);
            if k == a {
                continue;
            }
            let over = (squares[k] - square).recip();
            add(&mut slope, -coupling * squares[k] * over * over, &m[k]);
            let share = coupling * over;
            add(&mut others, share, &h[k]);
            coupled.iter_mut().zip(rows[k]).for_each(|(sum, coupling)| *sum += share * coupling);
            sum += share * coupling;
            sum_of_squares += share * share;
        }
        for (k, coupled) in coupled.into_iter().enumerate() {
            add(&mut others, coupled * weight(k), &m[k]);
        }
        let singular = m[a].map(|m| m * square * modal[(a, a)]);
        let moved = scaled(&twice_symmetric(&m[a], &m[a]), 0.5 * square * square);
        let (whole, bend) = (twice_symmetric(&rest, &rest), twice_symmetric(&singular, &slope));
        let (pulled, cross) = (twice_symmetric(&m[a], &others), twice_symmetric(&singular, &rest));
        let mut powers = [[0.0; ENTRIES]; 3];
        for k in 0..ENTRIES {
            powers[0][k] = 0.5 * whole[k] + bend[k] + square * pulled[k] - sum_of_squares * moved[k];
            powers[1][k] = cross[k] + sum * moved[k];
        }
        powers[2] = scaled(&twice_symmetric(&singular, &singular), 0.5);
        let [first, second, third] = powers;
        // 3. By powers of y = lambda_a/(lambda_a + x).
        let over = square.recip();
        let mut linear = u;
        linear.iter_mut().zip(&w).for_each(|(entry, w)| *entry -= 2.0 * w);
        let sets = [linear, w, scaled(&first, over), scaled(&second, over * over), scaled(&third, over.powi(3))];
        Pole { square, sets }
    }
}

/// Few simple poles in place of high ones: y(t) = 1/(1 + x t), t = 1/lambda, through its values at three t_p; y^2 = (t
/// y)' and y^3 = (t^2 y)''/2.
fn together(high: &[Pole]) -> [Pole; POLES] {
    let [least, largest] = [high[0].square, high[high.len() - 1].square];
    let places = [least, least.powf(0.6) * largest.powf(0.4), largest].map(f64::recip);
    std::array::from_fn(|p| {
        let [one, other] = [(p + 1) % POLES, (p + 2) % POLES].map(|q| places[q]);
        let scale = ((places[p] - one) * (places[p] - other)).recip();
        let [constant, linear, bend] = [scale * one * other, -scale * (one + other), scale];
        let mut sets = [[0.0; ENTRIES]; SETS];
        for Pole { square, sets: replaced } in high {
            let t = square.recip();
            let powers = [
                constant + t * (linear + t * bend),
                constant + t * (2.0 * linear + t * 3.0 * bend),
                constant + t * (3.0 * linear + t * 6.0 * bend),
            ];
            for k in 0..ENTRIES {
                sets[0][k] += powers[0] * replaced[0][k] + powers[1] * replaced[1][k];
                sets[2][k] += powers[0] * replaced[2][k] + powers[1] * replaced[3][k] + powers[2] * replaced[4][k];
            }
        }
        Pole { square: places[p].recip(), sets }
    })
}

fn add(sum: &mut Vector, factor: f64, vector: &Vector) {
    sum.iter_mut().zip(vector).for_each(|(sum, value)| *sum += factor * value);
}

fn scaled(entries: &Entries, factor: f64) -> Entries {
    entries.map(|entry| entry * factor)
}

/// f g^T + g f^T.
fn twice_symmetric(f: &Vector, g: &Vector) -> Entries {
    upper(|row, column| f[row] * g[column] + g[row] * f[column])
}
