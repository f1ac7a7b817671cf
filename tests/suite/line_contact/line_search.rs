//! Contact of a row of cells at one penetration by a general active-set search: the reference of the curve follower.
//!
//! Find p >= 0 with u = G p >= r, p . (u - r) = 0, r_i = y - d_i required. Nothing is assumed about how the set changes
//! with y.
//!
//! 1. Guess the set (given, or every cell with r > 0), solve G_AA p = r_A.
//! 2. Exchange every cell that violates its condition (p < 0 in the set, u < r outside): block principal pivoting.
//! 3. If the number of violations has not fallen for ten exchanges, exchange only the violating cell of highest index
//!    until it falls: Murty's rule, finite for positive definite G (Judice and Pires, Comput. Oper. Res. 21 (1994)
//!    587-596).
//!
//! Cost: m^3/6 multiply-adds per solve of m cells.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use tyrewave::internals::LineInfluence;

/// Exchanges of whole blocks without progress before Murty's rule takes over.
const PATIENCE: usize = 10;

/// Contact at one penetration.
pub(super) struct LineContact {
    /// Pressure/E* of every cell.
    pub pressure: Vec<f64>,
    /// True if each cell is in contact.
    pub touching: Vec<bool>,
    /// Multiply-adds of the factorisations.
    pub multiply_adds: u64,
}

/// Solves the contact of a profile at one penetration.
///
/// `depths`: depth of each cell below the highest \[m\]; `penetration` \[m\] of the highest; `guess`: cells expected in
/// contact, e.g. those of a neighbouring level.
pub(super) fn solve(line: &LineInfluence, depths: &[f64], penetration: f64, guess: Option<&[bool]>) -> LineContact {
    let n = depths.len();
    let row = line.row();
    let required: Vec<f64> = depths.iter().map(|depth| penetration - depth).collect();
    let scale = required.iter().copied().fold(0.0, f64::max);
    let tolerance = 1e-13 * scale;
    let mut touching = guess.map_or_else(|| required.iter().map(|&r| r > 0.0).collect(), <[bool]>::to_vec);
    let mut contact = LineContact { pressure: vec![0.0; n], touching: Vec::new(), multiply_adds: 0 };
    let (mut fewest, mut patience) = (usize::MAX, PATIENCE);
    loop {
        let set: Vec<usize> = (0..n).filter(|&i| touching[i]).collect();
        let matrix = Mat::from_fn(set.len(), set.len(), |i, j| row[set[i].abs_diff(set[j])]);
        let right = Mat::from_fn(set.len(), 1, |i, _| required[set[i]]);
        let solution = matrix.llt(Side::Lower).expect("a positive definite influence").solve(&right);
        contact.multiply_adds += (set.len() as u64).pow(3) / 6;
        contact.pressure.fill(0.0);
        for (k, &i) in set.iter().enumerate() {
            contact.pressure[i] = solution[(k, 0)];
        }
        let violating: Vec<usize> = (0..n)
            .filter(|&i| {
                if touching[i] {
                    contact.pressure[i] * row[0] < -tolerance
                } else {
                    let u: f64 = set.iter().map(|&j| row[i.abs_diff(j)] * contact.pressure[j]).sum();
                    u < required[i] - tolerance
                }
            })
            .collect();
        let Some(&last) = violating.last() else { break };
        if violating.len() < fewest {
            (fewest, patience) = (violating.len(), PATIENCE);
        } else {
            patience = patience.saturating_sub(1);
        }
        if patience > 0 {
            violating.iter().for_each(|&i| touching[i] = !touching[i]);
        } else {
            touching[last] = !touching[last];
        }
    }
    contact.touching = touching;
    contact
}
