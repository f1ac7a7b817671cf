//! The compliance of a curved tyre: a layered hollow cylinder under tension, by three-dimensional elasticity.
//!
//! 1. start at the inner face with the impedance of sidewalls, inflation and cavity;
//! 2. go outwards in short steps: the state (displacement, traction) of the next face is expm(W) times that of the
//!    last, W by a Magnus expansion of fourth order; only the impedance Z = traction/displacement is handed on, so
//!    nothing overflows;
//! 3. C = Z^-1 on the tread's surface at R = L/2 pi; D = (product of the displacement transfers) C.
//!
//! Fields ~ exp(i(n theta + k_y y) + s t), order circumferential, lateral, radial outward; k = n/r, S = T_theta/h,
//! S_y = T_y/h, Q = rho s^2 + S k^2 + S_y k_y^2; Q_tt, Q_yy, Q_ty, a_t, a_y, C_rr, G_tr, G_yr, G_ty as in
//! `super::elasticity` (isotropic: M' = M - lambda^2/M, l' = lambda - lambda^2/M, lambda/M, M, mu). With the
//! tangential displacements and tractions written as -i times V, P and tau, upsilon all coefficients are real for real
//! s:
//!
//! ```text
//! V' = tau/G_tr + V/r + k w        P' = upsilon/G_yr + k_y w        w' = sigma/C_rr - a_t e - a_y k_y P
//! tau'     = (Q + a) V + (2 k S/r + i c) w + k s_t + k_y s_ty - 2 tau/r
//! upsilon' = Q P + k s_ty + k_y s_y - upsilon/r
//! sigma'   = (Q + a) w + (2 k S/r + i c) V + s_t/r - k tau - k_y upsilon - sigma/r
//! e = k V + w/r,  s_t = Q_tt e + Q_ty k_y P + a_t sigma,  s_y = Q_ty e + Q_yy k_y P + a_y sigma,
//! s_ty = G_ty (k_y V + k P),   a = S/r^2 - rho Omega^2,  c = 2 Omega rho s
//! ```
//!
//! A tyre that turns (Omega, see [`super::rotation`]) keeps all of it symmetric, and C at -n is that of -Omega at n.
//! For 1/r -> 0 this is the flat layer of [`super::layer`]. The expansion is that of Iserles & Norsett (1999), *Phil.
//! Trans. R. Soc. A* 357, 983; impedance instead of transfer matrices as in Rokhlin & Wang (2002), *J. Acoust. Soc.
//! Am.* 112, 822.
//!
//! Sidewalls as arcs ([`crate::sidewall`]), spread evenly across the width B, give the inner face 2/B times the
//! impedance of one of them, between V and w; a belt that moves across as a whole (k_y = 0) meets their lateral one.
//! The pressure on the face is then the full one: the sidewalls' pull turns with the edge, and is in their impedance.
//! A
//! pressure that is uniform over the section drives the edges, too, against the face: the air's term is multiplied by
//! (B_e/B)^2, B_e = B - 2 N_b cos(a_b)/p.
//!
//! Cost: one exponential of a 6x6 matrix and one inverse of a 3x3 matrix per step.

use std::sync::Arc;

use num_complex::Complex64;

use super::compliance::Matrix3;
use super::elasticity::ElasticityAt;
use super::faces::{sum, to_fields};
use super::material;
use super::rotation::{Rotation, hoop_modulus};
use crate::numeric::ComplexField;
use crate::scene::{Cavity, Foundation, Layer, Tyre};
use crate::sidewall::{self, EdgeImpedance, Sidewall, table_bytes};

/// Longest step times (wavenumber + 1/h), a wavenumber multiplied by the ratio of the displacements' rates across and
/// along a layer (see `super::elasticity`): the error is below 2e-5, its median 4e-8. Layers that are not isotropic
/// take twice the steps.
pub const STEP: f64 = 0.6;
/// The same for reference values: the error is below 2e-8.
pub const FINE_STEP: f64 = 0.1;
/// Wavenumber times thickness of the layers from which on waves do not feel the sidewalls under them: these count by
/// exp(-12) of their ratio to the layers, which is a hundredth.
const REACH: f64 = 6.0;
/// Fewest steps in a layer.
const FEWEST_STEPS: usize = 4;
/// Terms of the exponential's series; with a norm of at most 1/2 the first omitted one is below 3e-17.
const TERMS: usize = 14;

type Matrix6 = [[Complex64; 6]; 6];

/// A tyre as a layered hollow cylinder.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvedStack {
    /// Layers from the rim outwards.
    pub layers: Vec<Layer>,
    /// Foundation of the innermost layer.
    pub foundation: Foundation,
    /// Radius of the tread's surface \[m\].
    pub radius: f64,
    /// Width B between the sides \[m\].
    pub width: f64,
    /// One of the two sidewalls, which are equal, as an arc in place of a foundation.
    pub sidewall: Option<Arc<Sidewall>>,
    /// Pressure on the inner face \[Pa\], which follows the face as it turns; less the pull of sidewalls that are not
    /// given as arcs.
    pub pressure: f64,
    /// Mass per area that moves with the inner face, of sidewalls that are a foundation \[kg/m^2\].
    pub sidewall_mass: f64,
    /// Air in the tyre.
    pub cavity: Option<Cavity>,
    /// Rotation, with the growth of the radius.
    pub rotation: Rotation,
}

/// Growth of a tyre's radius by its rotation \[m\]; 0 at rest and of a flat one.
pub fn growth(tyre: &Tyre) -> f64 {
    if tyre.curvature { CurvedStack::new(tyre).rotation.growth } else { 0.0 }
}

/// Number of periods round the tyre from which on waves do not feel what is under layers of a thickness \[m\], whose
/// outer radius is `radius` \[m\].
fn reach(radius: f64, thickness: f64) -> usize {
    (REACH * radius / thickness).ceil() as usize
}

/// Number of waves n >= 0 whose sidewalls are evaluated separately; shorter waves share those of the last.
pub(crate) fn sidewall_waves(tyre: &Tyre) -> usize {
    reach(tyre.radius(), tyre.thickness()) + 1
}

/// Bytes of a tyre's sidewalls for each s; 0 without them.
pub(crate) fn sidewall_bytes(tyre: &Tyre) -> f64 {
    if tyre.sidewall.is_some() { table_bytes(sidewall_waves(tyre)) } else { 0.0 }
}

/// Stiffness per area of the air against a motion of the inner face ~ exp(i n theta) at s \[N/m^3\].
#[inline(always)]
pub fn air_stiffness<T: ComplexField>(cavity: &Cavity, n: i64, s: T) -> T {
    let Cavity { radius, depth, density, sound_speed, relaxation } = *cavity;
    if n == 0 {
        return s.like(density * sound_speed * sound_speed / depth);
    }
    let (squared, wavenumber) = (s * s, n as f64 / radius);
    let waves = squared * sound_speed.powi(-2) + (s * relaxation + 1.0) * (wavenumber * wavenumber);
    squared * (density / depth) * waves.reciprocal()
}

/// The inner face in a wave (n, k_y), and what acts on it.
#[derive(Clone, Copy, Debug)]
pub(in crate::tyre) struct InnerFace {
    n: i64,
    /// k_y \[1/m\].
    pub(super) ky: f64,
    /// Radius of the face \[m\].
    pub(super) radius: f64,
    pressure: f64,
    /// Air in the tyre, where the wave moves it.
    cavity: Option<Cavity>,
    /// m_s Omega^2 \[N/m^3\] and 2 m_s Omega \[N s/m^3\].
    turning: [f64; 2],
    /// Length of the edges of both sidewalls per area of the face \[1/m\].
    edges: f64,
}

impl InnerFace {
    /// Traction per displacement at s of what carries the face: sidewalls and foundation, given as their tangential
    /// and normal stiffness with inertia \[N/m^3\], following pressure, cavity. Order V, P, w.
    #[inline(always)]
    pub(in crate::tyre) fn impedance<T: ComplexField>(&self, s: T, [tangential, normal]: [T; 2]) -> [[T; 3]; 3] {
        let Self { n, ky, radius, pressure, cavity, .. } = *self;
        let hoop = pressure / radius;
        let normal = match &cavity {
            Some(cavity) => normal + air_stiffness(cavity, n, s),
            None => normal,
        };
        let (zero, turned, tilted) = (s.like(0.0), s.like(-(n as f64) * hoop), s.like(-ky * pressure));
        [[tangential + -hoop, zero, turned], [zero, tangential, tilted], [turned, tilted, normal + -hoop]]
    }

    /// |n|, the number of periods round the tyre.
    pub(super) fn periods(&self) -> usize {
        self.n.unsigned_abs() as usize
    }

    /// Adds the impedance of both sidewalls' edges.
    #[inline(always)]
    pub(super) fn hold<T: ComplexField>(&self, impedance: &mut [[T; 3]; 3], edge: &EdgeImpedance<T>) {
        self.hold_scaled(impedance, edge, 1.0);
    }

    /// As [`Self::hold`], times a factor.
    #[inline(always)]
    pub(super) fn hold_scaled<T: ComplexField>(
        &self,
        impedance: &mut [[T; 3]; 3],
        edge: &EdgeImpedance<T>,
        factor: f64,
    ) {
        let EdgeImpedance { radial, coupling, circumferential, lateral } = *edge;
        for (row, column, entry) in [(0, 0, circumferential), (0, 2, coupling), (2, 0, coupling), (2, 2, radial)] {
            impedance[row][column] = impedance[row][column].plus_scaled(factor * self.edges, entry);
        }
        if self.ky <= 0.0 {
            impedance[1][1] = impedance[1][1].plus_scaled(factor * self.edges, lateral);
        }
    }

    /// As [`Self::impedance`] of a tyre that turns: without the Coriolis force of the sidewalls' mass, whose term
    /// between V and w, over i, comes second.
    #[inline(always)]
    pub(super) fn turning_impedance<T: ComplexField>(&self, s: T, foundation: [T; 2]) -> ([[T; 3]; 3], T) {
        let mut impedance = self.impedance(s, foundation);
        let [softening, coriolis] = self.turning;
        impedance[0][0] = impedance[0][0] + -softening;
        impedance[2][2] = impedance[2][2] + -softening;
        (impedance, s * coriolis)
    }
}

struct CurvedLayerAt {
    /// n, k_y \[1/m\].
    n: f64,
    lateral: f64,
    elasticity: ElasticityAt<Complex64>,
    /// rho s^2 + S_y k_y^2 \[Pa/m^2\], S \[Pa\].
    inertia: Complex64,
    tension: f64,
    /// rho Omega^2, i 2 Omega rho s \[Pa/m^2\].
    softening: f64,
    coriolis: Complex64,
    /// Number of steps over that of an isotropic layer.
    fineness: f64,
    /// Traction per displacement that is scaled to 1 \[Pa/m\].
    unit: f64,
}

impl CurvedLayerAt {
    /// Number of steps through a thickness h from the radius r on, none longer than `step` over (wavenumber + 1/h).
    fn steps(&self, r: f64, h: f64, step: f64) -> f64 {
        let q = self.inertia + self.tension * (self.n / r).powi(2);
        let ([along, across], [tr, yr, _]) = (self.elasticity.steepness(), self.elasticity.shear);
        let shear = if yr.norm() < tr.norm() { yr } else { tr };
        let wavenumber = (self.n / r * along).hypot(self.lateral * across) + (q / shear).norm().sqrt();
        ((h * wavenumber + 1.0) * self.fineness / step).ceil().max(FEWEST_STEPS as f64)
    }

    /// Matrix of the derivative of (V, P, w, tau, upsilon, sigma) by r; tractions in units of `unit`.
    fn system(&self, r: f64) -> Matrix6 {
        let Self { elasticity, inertia, tension, softening, coriolis, unit, lateral: ky, .. } = *self;
        let ElasticityAt { plane: [tt, yy, ty], contraction: [at, ay], inverse_radial, shear } = elasticity;
        let [tr, yr, in_plane] = shear;
        let k = self.n / r;
        let zero = Complex64::ZERO;
        let real = |value: f64| Complex64::new(value, 0.0);
        let q = inertia + tension * k * k;
        let hoop = q + (tension / (r * r) - softening);
        let turn = coriolis + 2.0 * k * tension / r;
        let over = 1.0 / r;
        // s_t, s_y and s_ty by V, P, w, sigma.
        let [t_v, t_p, t_w] = [tt * k, ty * ky, tt * over];
        let [y_v, y_p, y_w] = [ty * k, yy * ky, ty * over];
        let [ty_v, ty_p] = [in_plane * ky, in_plane * k];
        let scale = 1.0 / unit;
        let displacement = [
            [real(over), zero, real(k), unit / tr, zero, zero],
            [zero, zero, real(ky), zero, unit / yr, zero],
            [real(-at * k), real(-ay * ky), real(-at * over), zero, zero, inverse_radial * unit],
        ];
        let stiffness = [
            [hoop + t_v * k + ty_v * ky, t_p * k + ty_p * ky, turn + t_w * k],
            [ty_v * k + y_v * ky, q + ty_p * k + y_p * ky, y_w * ky],
            [turn + t_v * over, t_p * over, hoop + t_w * over],
        ]
        .map(|row| row.map(|entry| entry * scale));
        let traction = [
            [real(-2.0 * over), zero, real(k * at)],
            [zero, real(-over), real(ky * ay)],
            [real(-k), real(-ky), real((at - 1.0) * over)],
        ];
        let mut matrix = [[zero; 6]; 6];
        matrix[..3].copy_from_slice(&displacement);
        for (row, (left, right)) in matrix[3..].iter_mut().zip(stiffness.into_iter().zip(traction)) {
            row[..3].copy_from_slice(&left);
            row[3..].copy_from_slice(&right);
        }
        matrix
    }

    /// expm(W) of a step of length d that begins at r: Magnus expansion of fourth order.
    fn step(&self, r: f64, d: f64) -> Matrix6 {
        let offset = 0.5 * d / 3.0_f64.sqrt();
        let (first, second) = (self.system(r + 0.5 * d - offset), self.system(r + 0.5 * d + offset));
        let (one, other) = (product(&second, &first), product(&first, &second));
        let mut exponent = [[Complex64::ZERO; 6]; 6];
        let commutator = 3.0_f64.sqrt() * d * d / 12.0;
        for i in 0..6 {
            for j in 0..6 {
                exponent[i][j] = (first[i][j] + second[i][j]) * (0.5 * d) + (one[i][j] - other[i][j]) * commutator;
            }
        }
        exponential(exponent)
    }
}

impl CurvedStack {
    /// Layers and sidewalls of a tyre, taken as curved, in steady rotation.
    ///
    /// The edges of sidewalls as arcs are at the radius of the inner face: a rigid rotation or translation of the tyre
    /// meets nothing but their stiffness if the tension is that of pressure and pull.
    pub fn new(tyre: &Tyre) -> Self {
        let sidewall = tyre.sidewall_arc(tyre.angular_velocity).map(|arc| Arc::new(Sidewall::new(arc)));
        let share = |wall: &Arc<Sidewall>| wall.effective_width(tyre.width).unwrap_or(f64::NAN) / tyre.width;
        let share = sidewall.as_ref().map(share);
        let cavity = tyre.cavity.map(|cavity| match share {
            Some(share) => Cavity { density: cavity.density * share * share, ..cavity },
            None => cavity,
        });
        let resting = Self {
            layers: tyre.layers.clone(),
            foundation: tyre.foundation.clone(),
            radius: tyre.radius(),
            width: tyre.width,
            sidewall,
            pressure: tyre.inflation.as_ref().map_or(0.0, |inflation| inflation.pressure),
            sidewall_mass: 0.0,
            cavity,
            rotation: Rotation::default(),
        };
        Self { rotation: resting.turning(tyre.angular_velocity), ..resting }
    }

    /// Without sidewalls as arcs: for waves that do not reach the inner face.
    pub(in crate::tyre) fn without_sidewalls(self) -> Self {
        Self { sidewall: None, ..self }
    }

    /// With all of the hoop stress in the layers' tension, so that the stress stays if a layer is cut.
    pub(in crate::tyre) fn resolved(mut self) -> Self {
        let mut from = self.inner_radius();
        for layer in &mut self.layers {
            if self.rotation.turns() {
                layer.tension[0] = self.rotation.prestress(layer, from)[0] * layer.thickness;
            }
            from += layer.thickness;
        }
        self.rotation = Rotation::of_given_tension(self.rotation.angular_velocity);
        self
    }

    /// Rotation at an angular velocity \[rad/s\] with the growth of the stack: see [`super::rotation`].
    pub fn turning(&self, angular_velocity: f64) -> Rotation {
        if angular_velocity.abs() <= 0.0 {
            return Rotation::default();
        }
        // 1. Centrifugal load and hoop stiffness of the layers, and the foundation.
        let inner = self.inner_radius();
        let (mut load, mut stiffness) = (self.sidewall_mass * inner * inner, 0.0);
        for (layer, from) in self.layers_by_radius() {
            let middle = from + 0.5 * layer.thickness;
            load += layer.material.density * layer.thickness * middle * middle;
            stiffness += hoop_modulus(layer) * layer.thickness / middle;
        }
        let [_, normal] = material::foundation_stiffness(&self.foundation, Complex64::ZERO);
        stiffness += normal.re * inner;
        if let Some(sidewall) = &self.sidewall {
            // 2. Sidewalls: their stiffness, and their pull, which falls with the speed.
            let pull = |sidewall: &Sidewall| sidewall.edge().map_or(f64::NAN, |edge| edge.pull());
            let arc = sidewall.arc().clone();
            let resting = Sidewall::new(sidewall::Arc { angular_velocity: 0.0, ..arc.clone() });
            let turning = Sidewall::new(sidewall::Arc { angular_velocity, ..arc });
            let edges = 2.0 / self.width * inner;
            stiffness += edges * turning.impedance(0, Complex64::ZERO).radial.re;
            let fall = edges * (pull(&resting) - pull(&turning));
            return Rotation {
                angular_velocity,
                growth: (angular_velocity * angular_velocity * load + fall) / stiffness,
            };
        }
        Rotation { angular_velocity, growth: angular_velocity * angular_velocity * load / stiffness }
    }

    /// Radius of the inner face \[m\].
    pub fn inner_radius(&self) -> f64 {
        self.radius - self.layers.iter().map(|layer| layer.thickness).sum::<f64>()
    }

    /// Layers, each with the radius of its inner face \[m\].
    pub(in crate::tyre) fn layers_by_radius(&self) -> impl Iterator<Item = (&Layer, f64)> {
        let mut from = self.inner_radius();
        self.layers.iter().map(move |layer| {
            let inner = from;
            from += layer.thickness;
            (layer, inner)
        })
    }

    /// C and D at (n, m, s), k_y = m pi/B: displacement i \[m\] of the outer and of the inner face per unit traction j
    /// \[Pa\] on the outer one; order circumferential, lateral, radial outward. `step`: longest step times
    /// (wavenumber + 1/h).
    pub fn compliance(&self, n: i64, m: usize, s: Complex64, step: f64) -> (Matrix3, Matrix3) {
        // 1. Impedance at the inner face.
        let inner = self.inner_face(n, m);
        let (ky, mut r) = (inner.ky, inner.radius);
        let mut impedance = inner.impedance(s, self.foundation(s));
        if self.rotation.turns() {
            let (turning, coriolis) = inner.turning_impedance(s, self.foundation(s));
            impedance = turning;
            impedance[0][2] += Complex64::i() * coriolis;
            impedance[2][0] += Complex64::i() * coriolis;
        }
        if let Some(sidewall) = &self.sidewall {
            inner.hold(&mut impedance, &sidewall.impedance(n, s));
        }
        // 2. Outwards through the layers; only impedance and transfer of displacement are stored.
        let n = n as f64;
        let mut transfer = identity();
        for layer in &self.layers {
            let h = layer.thickness;
            let at = layer_at(layer, self.rotation, n, ky, s, r);
            let steps = at.steps(r, h, step) as usize;
            let d = h / steps as f64;
            let mut scaled = impedance.map(|row| row.map(|entry| entry / at.unit));
            for index in 0..steps {
                let e = at.step(r + index as f64 * d, d);
                let block = |row: usize, column: usize| -> Matrix3 {
                    std::array::from_fn(|i| std::array::from_fn(|j| e[row + i][column + j]))
                };
                let displacement = sum(&block(0, 0), &product(&block(0, 3), &scaled));
                let traction = sum(&block(3, 0), &product(&block(3, 3), &scaled));
                let inverse = inverse(displacement);
                scaled = product(&traction, &inverse);
                transfer = product(&transfer, &inverse);
            }
            impedance = scaled.map(|row| row.map(|entry| entry * at.unit));
            r += h;
        }
        // 3. The outer face.
        let surface = inverse(impedance);
        let bottom = product(&transfer, &surface);
        (to_fields(surface), to_fields(bottom))
    }

    /// Number of steps through all layers that [`Self::compliance`] takes.
    pub fn steps(&self, n: i64, m: usize, s: Complex64, step: f64) -> f64 {
        let inner = self.inner_face(n, m);
        let mut r = inner.radius;
        let of = |layer: &Layer| {
            let steps = layer_at(layer, self.rotation, n as f64, inner.ky, s, r).steps(r, layer.thickness, step);
            r += layer.thickness;
            steps
        };
        self.layers.iter().map(of).sum()
    }

    /// Number of periods from which on waves do not feel what is under the layers.
    pub(super) fn reach(&self) -> usize {
        reach(self.radius, self.radius - self.inner_radius())
    }

    /// Inner face in a wave; only waves that are uniform across (m = 0) move the air.
    pub(in crate::tyre) fn inner_face(&self, n: i64, m: usize) -> InnerFace {
        let ky = m as f64 * std::f64::consts::PI / self.width;
        InnerFace { cavity: self.cavity.filter(|_| m == 0), ..self.face_of_short_wave(n, ky) }
    }

    /// Inner face in a wave that does not move the air.
    pub(in crate::tyre) fn face_of_short_wave(&self, n: i64, ky: f64) -> InnerFace {
        let Self { pressure, sidewall_mass: mass, rotation: Rotation { angular_velocity: omega, .. }, .. } = *self;
        let turning = [mass * omega * omega, 2.0 * mass * omega];
        InnerFace { n, ky, radius: self.inner_radius(), pressure, cavity: None, turning, edges: 2.0 / self.width }
    }

    /// Tangential and normal stiffness of sidewalls and foundation at s, inertia included \[N/m^3\].
    pub(in crate::tyre) fn foundation(&self, s: Complex64) -> [Complex64; 2] {
        let inertia = s * s * self.sidewall_mass;
        material::foundation_stiffness(&self.foundation, s).map(|stiffness| stiffness + inertia)
    }
}

fn layer_at(layer: &Layer, rotation: Rotation, n: f64, ky: f64, s: Complex64, r: f64) -> CurvedLayerAt {
    let elasticity = ElasticityAt::new(layer, s);
    let [along, across] = rotation.prestress(layer, r);
    let density = layer.material.density;
    let [steep_along, steep_across] = elasticity.steepness();
    CurvedLayerAt {
        n,
        lateral: ky,
        inertia: s * s * density + across * ky * ky,
        tension: along,
        softening: rotation.softening(density),
        coriolis: Complex64::i() * rotation.coriolis(density, s),
        fineness: if layer.is_isotropic() { 1.0 } else { 2.0 },
        unit: elasticity.shear[0].norm() * ((n / r * steep_along).hypot(ky * steep_across) + 1.0 / layer.thickness),
        elasticity,
    }
}

fn identity<const N: usize>() -> [[Complex64; N]; N] {
    std::array::from_fn(|i| std::array::from_fn(|j| Complex64::new(if i == j { 1.0 } else { 0.0 }, 0.0)))
}

fn product<const N: usize>(a: &[[Complex64; N]; N], b: &[[Complex64; N]; N]) -> [[Complex64; N]; N] {
    let mut result = [[Complex64::ZERO; N]; N];
    for (row, left) in result.iter_mut().zip(a) {
        for (factor, right) in left.iter().zip(b) {
            for (entry, value) in row.iter_mut().zip(right) {
                *entry += factor * value;
            }
        }
    }
    result
}

/// a^-1 by cofactors; a singular `a` gives entries that are not finite.
pub(crate) fn inverse(a: Matrix3) -> Matrix3 {
    let minor = |i: usize, j: usize| {
        let [r, s] = [(i + 1) % 3, (i + 2) % 3];
        let [p, q] = [(j + 1) % 3, (j + 2) % 3];
        a[r][p] * a[s][q] - a[r][q] * a[s][p]
    };
    let determinant = a[0][0] * minor(0, 0) + a[0][1] * minor(0, 1) + a[0][2] * minor(0, 2);
    std::array::from_fn(|i| std::array::from_fn(|j| minor(j, i) / determinant))
}

/// Squarings for the largest matrix of finite numbers.
const MOST_SQUARINGS: f64 = 1024.0;

/// exp of a matrix: its series at 2^-k of it, squared k times.
fn exponential(mut matrix: Matrix6) -> Matrix6 {
    let norm = matrix.iter().map(|row| row.iter().map(|entry| entry.norm()).sum::<f64>()).fold(0.0, f64::max);
    // A larger or non-finite matrix has no finite exponential either.
    let squarings = if norm > 0.5 { (2.0 * norm).log2().ceil().min(MOST_SQUARINGS) as i32 } else { 0 };
    let scale = 2.0_f64.powi(-squarings);
    matrix.iter_mut().flatten().for_each(|entry| *entry *= scale);
    let mut result = identity();
    for term in (1..=TERMS).rev() {
        result = product(&matrix, &result);
        result.iter_mut().flatten().for_each(|entry| *entry /= term as f64);
        for (i, row) in result.iter_mut().enumerate() {
            row[i] += 1.0;
        }
    }
    for _ in 0..squarings {
        result = product(&result, &result);
    }
    result
}
