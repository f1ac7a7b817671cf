//! 3x3 blocks over the faces of layers, and the recursion from the inner face of a stack to its outer one.
//!
//! A layer that is represented by the tractions on its two faces by their displacements has the blocks \[inner,
//! across, outer\] of a symmetric matrix: within the inner face, from the outer face (columns) to the inner one
//! (rows), within the outer face. Rows and columns: V, P, w (see [`super::curved`]). Over an impedance Z the layer has
//!
//! ```text
//! Z' = outer - across^T (Z + inner)^-1 across,   u_inner = -(Z + inner)^-1 across u_outer.
//! ```

use num_complex::Complex64;

use crate::numeric::ComplexField;

/// A block over V, P, w.
pub(super) type Block<T> = [[T; 3]; 3];

/// State of the recursion at a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Climb<T> {
    /// Impedance of the face that is reached.
    pub impedance: Block<T>,
    /// Displacements of the inner face by those of the face reached (`None` without layers).
    pub transfer: Option<Block<T>>,
}

impl<T: ComplexField> Climb<T> {
    #[inline(always)]
    pub(super) fn from(impedance: Block<T>) -> Self {
        Self { impedance, transfer: None }
    }

    /// Goes through a layer, given by its blocks.
    #[inline(always)]
    pub(super) fn through(self, [inner, across, outer]: &[Block<T>; 3]) -> Self {
        // Minus the displacement of the inner face by that of the outer one.
        let minus_transfer = product(&inverse(sum(&self.impedance, inner)), across);
        let impedance = difference(outer, &product(&transposed(across), &minus_transfer));
        let [[p, q, r], [s, t, u], [v, w, x]] = minus_transfer;
        let step = [[-p, -q, -r], [-s, -t, -u], [-v, -w, -x]];
        let transfer = Some(match self.transfer {
            Some(before) => product(&before, &step),
            None => step,
        });
        Self { impedance, transfer }
    }
}

/// Goes through layers from an impedance; `faces` gives a layer's blocks.
#[inline(always)]
pub(super) fn climb<T: ComplexField, L>(
    start: Block<T>,
    layers: &[L],
    mut faces: impl FnMut(usize, &L) -> [Block<T>; 3],
) -> (Block<T>, Option<Block<T>>) {
    let mut climb = Climb::from(start);
    for (index, layer) in layers.iter().enumerate() {
        climb = climb.through(&faces(index, layer));
    }
    (climb.impedance, climb.transfer)
}

/// Impedance of a face under a layer whose outer face is free, given that without the layer.
#[inline(always)]
pub(super) fn carrying<T: ComplexField>(impedance: &Block<T>, [inner, across, outer]: &[Block<T>; 3]) -> Block<T> {
    let following = product(across, &product(&inverse(*outer), &transposed(across)));
    difference(&sum(impedance, inner), &following)
}

#[inline(always)]
pub(super) fn product<T: ComplexField>(a: &Block<T>, b: &Block<T>) -> Block<T> {
    let [x, y, z] = *b;
    let mut result = *a;
    for i in 0..3 {
        for j in 0..3 {
            result[i][j] = a[i][0] * x[j] + a[i][1] * y[j] + a[i][2] * z[j];
        }
    }
    result
}

#[inline(always)]
pub(super) fn transposed<T: ComplexField>([[a, b, c], [d, e, f], [g, h, i]]: &Block<T>) -> Block<T> {
    [[*a, *d, *g], [*b, *e, *h], [*c, *f, *i]]
}

#[inline(always)]
pub(super) fn sum<T: ComplexField>(a: &Block<T>, b: &Block<T>) -> Block<T> {
    let mut result = *a;
    for i in 0..3 {
        for j in 0..3 {
            result[i][j] = a[i][j] + b[i][j];
        }
    }
    result
}

#[inline(always)]
pub(super) fn difference<T: ComplexField>(a: &Block<T>, b: &Block<T>) -> Block<T> {
    let mut result = *a;
    for i in 0..3 {
        for j in 0..3 {
            result[i][j] = a[i][j] - b[i][j];
        }
    }
    result
}

/// a^-1 of a symmetric block by cofactors; a singular one gives entries that are not finite.
#[inline(always)]
pub(super) fn inverse<T: ComplexField>([[a, b, c], [_, d, e], [_, _, f]]: Block<T>) -> Block<T> {
    let (p, q, r) = (d * f - e * e, c * e - b * f, b * e - c * d);
    let scale = (a * p + b * q + c * r).reciprocal();
    let (s, t, u) = ((a * f - c * c) * scale, (b * c - a * e) * scale, (a * d - b * b) * scale);
    let (p, q, r) = (p * scale, q * scale, r * scale);
    [[p, q, r], [q, s, t], [r, t, u]]
}

/// From V, P and tau, upsilon to fields: tangential ones are -i times them.
pub(super) fn to_fields(matrix: Block<Complex64>) -> Block<Complex64> {
    let i = Complex64::i();
    let [[vv, vp, vw], [pv, pp, pw], [wv, wp, ww]] = matrix;
    [[vv, vp, -i * vw], [pv, pp, -i * pw], [i * wv, i * wp, ww]]
}
