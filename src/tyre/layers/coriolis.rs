//! The Coriolis force in a curved layer that is reduced to its two faces.
//!
//! The cross mass Gam of V and w adds i g Gam to the layer's matrix, g = 2 Omega rho s. Reduced like a part of the
//! stiffness (see [`super::layer_modes`]) it is Gam' on the faces, pulls h_j of the modes and a matrix Gam_jk between
//! them. With the modes' forces c_j and impedances d_j without rotation
//!
//! ```text
//! Z = Z_0 + i g Gam' - (c + i g h)^T (D + i g Gam)^-1 (c + i g h) + c^T D^-1 c = Z_0 + A + i B,
//! f = h - Gam D^-1 c,
//! A = g^2 f^T D^-1 f + ...,   B = g (Gam' - h^T D^-1 c - (D^-1 c)^T f) - g^3 (D^-1 f)^T Gam D^-1 f + ...
//! ```
//!
//! A, even in Omega, and B, odd in it, give both signs of Omega: what is a wave's at n and at -n.

use faer::Mat;

use super::layer_modes::{ENTRIES, upper_places};
use crate::numeric::ComplexField;

/// Gam', h_j and Gam_jk of a layer.
#[derive(Clone, Debug)]
pub(super) struct CoriolisModes {
    /// Gam'.
    pub faces: [f64; ENTRIES],
    /// h_j, rows j.
    pub pulls: Mat<f64>,
    /// Gam_jk.
    pub modal: Mat<f64>,
}

impl CoriolisModes {
    /// A and B from g, c_j/d_j and 1/d_j.
    pub fn parts<T: ComplexField>(&self, g: T, moved: &[[T; 6]], inverse: &[T]) -> [[T; ENTRIES]; 2] {
        let modes = self.modal.nrows();
        let zero = g.like(0.0);
        let follow = |vectors: &[[T; 6]]| -> Vec<[T; 6]> {
            let row = |j: usize| {
                let mut sum = [zero; 6];
                for (k, vector) in vectors.iter().enumerate().take(modes) {
                    for row in 0..6 {
                        sum[row] = sum[row].plus_scaled(self.modal[(j, k)], vector[row]);
                    }
                }
                sum
            };
            (0..modes).map(row).collect()
        };
        let f: Vec<[T; 6]> = follow(moved)
            .into_iter()
            .enumerate()
            .map(|(j, sum)| std::array::from_fn(|row| -sum[row] + self.pulls[(j, row)]))
            .collect();
        let f_moved: Vec<[T; 6]> = f.iter().zip(inverse).map(|(f, inverse)| f.map(|f| f * *inverse)).collect();
        let (mut even, mut odd, mut third) = ([zero; ENTRIES], [zero; ENTRIES], [zero; ENTRIES]);
        for ((j, f), again) in f.iter().enumerate().zip(follow(&f_moved)) {
            for (k, (row, column)) in upper_places().enumerate() {
                even[k] = even[k] + f[row] * f_moved[j][column];
                odd[k] = odd[k].plus_scaled(-self.pulls[(j, row)], moved[j][column]) - moved[j][row] * f[column];
                third[k] = third[k] + f_moved[j][row] * again[column];
            }
        }
        let squared = g * g;
        for k in 0..ENTRIES {
            even[k] = even[k] * squared;
            odd[k] = (odd[k] + self.faces[k] - third[k] * squared) * g;
        }
        [even, odd]
    }
}
