//! The flat stack with layers that are not isotropic: no direction of the wavenumber splits its field.
//!
//! With (V, P, sigma) = x and (tau, upsilon, w) = y (see [`super::curved`], 1/r -> 0) the equations of a layer couple x
//! to y alone,
//!
//! ```text
//! x' = A1 y,  A1 = [1/G_tr  0  kx]      y' = A2 x,  A2 = [Q + kx^2 Q_tt + ky^2 G_ty   kx ky (Q_ty + G_ty)   kx a_t]
//!                  [0  1/G_yr  ky]                       [kx ky (Q_ty + G_ty)   Q + kx^2 G_ty + ky^2 Q_yy   ky a_y]
//!                  [-kx  -ky   Q ]                       [-kx a_t                -ky a_y                    1/C_rr]
//! ```
//!
//! so that its transfer matrix consists of c(M), s(M) and products, M = A1 A2 h^2, c and s the entire functions of
//! [`super::scaled_series`]. Their series in M need M^2 alone: by the theorem of Cayley and Hamilton the coefficients
//! of higher powers follow from the invariants of M, and no eigenvectors are needed, which coincide where P and S do.
//! A1 S and A2 S, S = diag(1, 1, -1), are symmetric: A2 A1 = S M^T S/h^2.
//!
//! A layer in which a wave grows by more than [`THIN`] is halved until it does not, represented by its tractions on
//! the faces, and doubled as often: two equal layers meet in the middle, where a mirror makes a sum of two blocks
//! diagonal. Nothing overflows.
//!
//! Cost: some 700 complex multiplications for each layer and 80 for each doubling.

use num_complex::Complex64;

use super::elasticity::ElasticityAt;
use super::faces::{Block, carrying, climb, difference, inverse, product, transposed};
use crate::numeric::ComplexField;
use crate::scene::Layer;

/// Growth of waves times thickness up to which a layer is not halved.
const THIN: f64 = 1.5;
/// Terms of the series: the first omitted one is 1.5^32/32! = 2e-30.
const TERMS: usize = 15;
/// Halvings by which lanes may differ.
const UNEVEN: i32 = 3;
/// Most halvings of a layer.
const MOST_HALVINGS: f64 = 40.0;

/// A layer at one s, or at several in lockstep.
#[derive(Clone, Debug)]
pub(super) struct FlatLayer<T> {
    thickness: f64,
    elasticity: ElasticityAt<T>,
    /// rho s^2 \[Pa/m^2\].
    inertia: T,
    prestress: [f64; 2],
    /// Bounds of the squared growth of waves: coefficients of kx^2 and of ky^2, and inertia \[1, 1, 1/m^2\]; the least
    /// of all lanes, and the largest.
    growth: [[f64; 3]; 2],
}

#[derive(Clone, Debug)]
pub(super) struct FlatLayers<T>(Vec<FlatLayer<T>>);

impl FlatLayers<Complex64> {
    /// `None` where all layers are isotropic; s in 1/s.
    pub(super) fn new(layers: &[Layer], s: Complex64) -> Option<Self> {
        let at = |layer: &Layer| {
            let elasticity = ElasticityAt::new(layer, s);
            let [tr, yr, ty] = elasticity.shear.map(Complex64::norm);
            let least = tr.min(yr);
            let inertia = s * s * layer.material.density;
            let prestress = layer.tension.map(|tension| tension / layer.thickness);
            let by = |axis: usize| (elasticity.plane[axis].norm() + ty + prestress[axis].abs()) / least + 1.0;
            FlatLayer {
                thickness: layer.thickness,
                growth: [[by(0), by(1), inertia.norm() / least]; 2],
                elasticity,
                inertia,
                prestress,
            }
        };
        (!layers.iter().all(Layer::is_isotropic)).then(|| Self(layers.iter().map(at).collect()))
    }
}

impl<T: ComplexField> FlatLayers<T> {
    /// Layers of several s side by side: `value` gives the lanes of an entry.
    #[inline(always)]
    pub(super) fn in_lanes(
        single: &[&FlatLayers<Complex64>],
        mut value: impl FnMut(&dyn Fn(&FlatLayers<Complex64>) -> Complex64) -> T,
    ) -> Self {
        let layers = (0..single[0].0.len()).map(|index| {
            let first = &single[0].0[index];
            let lanes = |term: usize| single.iter().map(move |at| at.0[index].growth[1][term]);
            let bounds = |bound: fn(f64, f64) -> f64| [0, 1, 2].map(|term| lanes(term).reduce(bound).unwrap_or(0.0));
            FlatLayer {
                thickness: first.thickness,
                elasticity: ElasticityAt::in_lanes(&first.elasticity, |entry| {
                    value(&|at: &FlatLayers<Complex64>| entry(&at.0[index].elasticity))
                }),
                inertia: value(&|at| at.0[index].inertia),
                prestress: first.prestress,
                growth: [bounds(f64::min), bounds(f64::max)],
            }
        });
        Self(layers.collect())
    }

    /// True if all lanes need about as many halvings: a layer cut much thinner than it needs loses digits.
    #[inline(always)]
    pub(super) fn is_even(&self, kx: f64, ky: f64) -> bool {
        self.0.iter().all(|layer| {
            let [least, most] = layer.growth.map(|growth| layer.halvings(growth, kx, ky));
            most - least <= UNEVEN
        })
    }

    /// C of the surface, and displacements of the bottom face for tractions on the surface, over a tangential and
    /// normal foundation stiffness \[N/m^3\]. Rows and columns V, P, w.
    #[inline(always)]
    pub(super) fn surface(&self, foundation: [T; 2], kx: f64, ky: f64) -> (Block<T>, Block<T>) {
        let (impedance, transfer) = self.climb(foundation, kx, ky, self.0.len());
        let surface = inverse(impedance);
        let bottom = match transfer {
            Some(transfer) => product(&transfer, &surface),
            None => surface,
        };
        (surface, bottom)
    }

    /// Driving-point compliance \[m/Pa\] for normal traction under the outermost layer, whose mass and stiffness act
    /// there.
    #[inline(always)]
    pub(super) fn under_tread(&self, foundation: [T; 2], kx: f64, ky: f64) -> T {
        let carcass = self.0.len().saturating_sub(1);
        let (mut impedance, _) = self.climb(foundation, kx, ky, carcass);
        for layer in &self.0[carcass..] {
            impedance = carrying(&impedance, &layer.faces(kx, ky));
        }
        inverse(impedance)[2][2]
    }

    #[inline(always)]
    fn climb(&self, [tangential, normal]: [T; 2], kx: f64, ky: f64, layers: usize) -> (Block<T>, Option<Block<T>>) {
        climb(
            diagonal(tangential, tangential, normal),
            &self.0[..layers],
            #[inline(always)]
            |_, layer| layer.faces(kx, ky),
        )
    }
}

impl<T: ComplexField> FlatLayer<T> {
    /// Tractions on the faces by their displacements: see [`super::faces`].
    #[inline(always)]
    fn faces(&self, kx: f64, ky: f64) -> [Block<T>; 3] {
        self.inertia.outlined(
            #[inline(always)]
            || {
                let halvings = self.halvings(self.growth[1], kx, ky);
                let [mut outer, mut down] = self.thin(kx, ky, self.thickness * 0.5_f64.powi(halvings));
                for _ in 0..halvings {
                    // The middle face, where outer + S outer S is a block in the plane and one outwards.
                    let middle = self.halved_inverse(&outer);
                    let through = product(&middle, &down);
                    let twice = product(&down, &through);
                    outer = difference(&outer, &product(&mirrored(&down), &through));
                    down = negated(&twice);
                }
                [mirrored(&outer), down, outer]
            },
        )
    }

    /// Halvings after which waves grow by no more than [`THIN`].
    #[inline(always)]
    fn halvings(&self, [along, across, inertia]: [f64; 3], kx: f64, ky: f64) -> i32 {
        let growth = self.thickness * (along * kx * kx + across * ky * ky + inertia).sqrt();
        if growth > THIN { (growth / THIN).log2().ceil().min(MOST_HALVINGS) as i32 } else { 0 }
    }

    /// (outer + S outer S)^-1, a block in the plane and an entry outwards.
    #[inline(always)]
    fn halved_inverse(&self, [[a, b, _], [_, d, _], [_, _, f]]: &Block<T>) -> Block<T> {
        let scale = (*a * *d - *b * *b).reciprocal() * 0.5;
        let zero = a.like(0.0);
        [[*d * scale, -(*b * scale), zero], [-(*b * scale), *a * scale, zero], [zero, zero, f.reciprocal() * 0.5]]
    }

    /// Thin part: tractions of the outer face by its displacements, and of the inner one by those of the outer.
    #[inline(always)]
    fn thin(&self, kx: f64, ky: f64, h: f64) -> [Block<T>; 2] {
        let Self { elasticity, inertia, prestress: [sx, sy], .. } = self;
        let ElasticityAt { plane: [tt, yy, ty], contraction: [along, across], inverse_radial, shear } = *elasticity;
        let [tr, yr, in_plane] = shear;
        // 1. A1 and A2, M = A1 A2 h^2, and c(M), s(M).
        let zero = inertia.like(0.0);
        let (x, y) = (inertia.like(kx), inertia.like(ky));
        let q = *inertia + (sx * kx * kx + sy * ky * ky);
        let a1 = [[tr.reciprocal(), zero, x], [zero, yr.reciprocal(), y], [-x, -y, q]];
        let mixed = (ty + in_plane) * (kx * ky);
        let (xr, yr) = (inertia.like(kx * along), inertia.like(ky * across));
        let a2 = [
            [q + tt * (kx * kx) + in_plane * (ky * ky), mixed, xr],
            [mixed, q + in_plane * (kx * kx) + yy * (ky * ky), yr],
            [-xr, -yr, inverse_radial],
        ];
        let mut m = product(&a1, &a2);
        for entry in m.as_flattened_mut() {
            *entry = *entry * (h * h);
        }
        let [cosh, sinhc] = functions(&m);
        // 2. The transfer matrix: h s(M) A1 and h A2 s(M).
        let (mut xy, mut yx) = (product(&sinhc, &a1), product(&a2, &sinhc));
        for entry in xy.as_flattened_mut().iter_mut().chain(yx.as_flattened_mut()) {
            *entry = *entry * h;
        }
        // c(A2 A1) = S c(M)^T S.
        let yy = mirrored(&transposed(&cosh));
        // 3. From transfer to tractions on the faces.
        // Displacements V, P, w and tractions tau, upsilon, sigma above by tractions below.
        let by_traction =
            [[xy[0][0], xy[0][1], cosh[0][2]], [xy[1][0], xy[1][1], cosh[1][2]], [yy[2][0], yy[2][1], yx[2][2]]];
        let traction =
            [[yy[0][0], yy[0][1], yx[0][2]], [yy[1][0], yy[1][1], yx[1][2]], [xy[2][0], xy[2][1], cosh[2][2]]];
        // t_above = traction t_below + ..., t_below = by_traction^-1 (u_above - by_displacement u_below).
        let inverse = general_inverse(&by_traction);
        [product(&traction, &inverse), negated(&inverse)]
    }
}

/// c(M) and s(M) by their series, to the power `TERMS` of M.
#[inline(always)]
fn functions<T: ComplexField>(m: &Block<T>) -> [Block<T>; 2] {
    let square = product(m, m);
    let [[a, b, c], [d, e, f], [g, h, i]] = *m;
    let one = a.like(1.0);
    // Invariants: M^3 = first M^2 - second M + third.
    let first = a + e + i;
    let second = a * e - b * d + a * i - c * g + e * i - f * h;
    let third = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g);
    let zero = a.like(0.0);
    // M^j = p M^2 + q M + r.
    let (mut p, mut q, mut r) = (zero, zero, one);
    let mut even = [zero, zero, one];
    let mut odd = [zero, zero, one];
    let (mut even_factor, mut odd_factor) = (1.0, 1.0);
    for j in 1..=TERMS {
        let next = first * p + q;
        q = r - second * p;
        r = third * p;
        p = next;
        even_factor /= (2 * j * (2 * j - 1)) as f64;
        odd_factor /= (2 * j * (2 * j + 1)) as f64;
        even = [
            even[0].plus_scaled(even_factor, p),
            even[1].plus_scaled(even_factor, q),
            even[2].plus_scaled(even_factor, r),
        ];
        odd = [odd[0].plus_scaled(odd_factor, p), odd[1].plus_scaled(odd_factor, q), odd[2].plus_scaled(odd_factor, r)];
    }
    [combined(&square, m, even), combined(&square, m, odd)]
}

#[inline(always)]
fn combined<T: ComplexField>(square: &Block<T>, m: &Block<T>, [p, q, r]: [T; 3]) -> Block<T> {
    let mut result = *m;
    for i in 0..3 {
        for j in 0..3 {
            result[i][j] = square[i][j] * p + m[i][j] * q;
        }
        result[i][i] = result[i][i] + r;
    }
    result
}

/// S block S: entries that couple outwards with in-plane change their sign.
#[inline(always)]
fn mirrored<T: ComplexField>([[a, b, c], [d, e, f], [g, h, i]]: &Block<T>) -> Block<T> {
    [[*a, *b, -*c], [*d, *e, -*f], [-*g, -*h, *i]]
}

#[inline(always)]
fn negated<T: ComplexField>([[a, b, c], [d, e, f], [g, h, i]]: &Block<T>) -> Block<T> {
    [[-*a, -*b, -*c], [-*d, -*e, -*f], [-*g, -*h, -*i]]
}

#[inline(always)]
fn diagonal<T: ComplexField>(a: T, b: T, c: T) -> Block<T> {
    let zero = a.like(0.0);
    [[a, zero, zero], [zero, b, zero], [zero, zero, c]]
}

/// a^-1 of any block by cofactors; a singular one gives entries that are not finite.
#[inline(always)]
fn general_inverse<T: ComplexField>([[a, b, c], [d, e, f], [g, h, i]]: &Block<T>) -> Block<T> {
    let (a, b, c, d, e, f, g, h, i) = (*a, *b, *c, *d, *e, *f, *g, *h, *i);
    let (p, q, r) = (e * i - f * h, f * g - d * i, d * h - e * g);
    let scale = (a * p + b * q + c * r).reciprocal();
    [
        [p * scale, (c * h - b * i) * scale, (b * f - c * e) * scale],
        [q * scale, (a * i - c * g) * scale, (c * d - a * f) * scale],
        [r * scale, (b * g - a * h) * scale, (a * e - b * d) * scale],
    ]
}
