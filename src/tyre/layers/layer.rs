//! The elastic field in one layer: from the impedance under it to the impedance on it.
//!
//! In the direction of the wavenumber k = sqrt(kx^2 + ky^2) the field splits into a P-SV part (u_r, u_z) and an SH
//! part. With u_r = -i w and sigma_rz = -i tau (fields ~ exp(i k r + s t)) the P-SV equations become
//!
//! ```text
//! w'     = k u_z + tau/mu                u_z'   = -nu' k w + sigma/M
//! sigma' = Q u_z - k tau                 tau'   = (E' k^2 + Q) w + nu' k sigma
//! ```
//!
//! with M = lambda + 2 mu, kappa = mu/M, nu' = 1 - 2 kappa, E' = 4 mu (1 - kappa), Q = rho s^2 + Sx kx^2 + Sy ky^2:
//! coefficients that stay bounded for nu -> 1/2, and real for real s. The characteristic exponents are +-alpha, +-beta,
//! alpha^2 = k^2 + Q/M, beta^2 = k^2 + Q/mu.
//!
//! Three methods for a layer, chosen by |alpha h| and |beta h|:
//! 1. *thin* (both <= 2): the transfer matrix exp(A h) with (w, sigma)' = P (u_z, tau), (u_z, tau)' = R (w, sigma), so
//!    that exp(A h) consists of c(PR h^2), s(PR h^2) P h, R s(PR h^2) h and c(RP h^2); c, s by power series, the
//!    two-point Newton form f(PR) = f(alpha^2) I + f\[alpha^2, beta^2\] (PR - alpha^2 I) with exact divided
//!    differences;
//! 2. *thick*: growing and decaying waves, each scaled to 1 at the face where it is largest, so nothing overflows. The
//!    second wave is the divided difference (P + SV) mu/Q of the two, which stays independent of P when Q/(mu k^2) ->
//!    0;
//! 3. *thick with a slow wave* (one exponent large, the other nearly zero: grazing incidence): the layer is cut into
//!    thin ones.
//!
//! Derivation from the field equations; the impedance recursion is the Riccati form of Rokhlin & Wang (2002),
//! *J. Acoust. Soc. Am.* 112, 822.

use super::matrix2::Matrix2;
use super::scaled_series::{SERIES_LIMIT, exponential_quotient, hyperbolic_pair};
use crate::numeric::ComplexField;

#[derive(Clone, Copy, Debug)]
pub(crate) struct LayerAt<T> {
    /// Thickness h \[m\].
    pub thickness: f64,
    /// Shear modulus mu(s) \[Pa\].
    pub shear: T,
    /// 1/mu(s) \[1/Pa\].
    pub inverse_shear: T,
    /// mu/(lambda + 2 mu).
    pub modulus_ratio: f64,
    /// rho s^2 \[Pa/m^2\].
    pub inertia: T,
    /// Prestress \[Sx, Sy\] \[Pa\].
    pub prestress: [f64; 2],
}

/// Displacements (w, u_z) and tractions (tau, sigma) on a face, as columns for two independent states.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceState<T> {
    /// Rows w, u_z.
    pub displacement: Matrix2<T>,
    /// Rows tau, sigma.
    pub traction: Matrix2<T>,
}

/// Result of a layer over an impedance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LayerResult<T> {
    /// Two independent states on the top face.
    pub top: FaceState<T>,
    /// Displacement of the bottom face in the same two states.
    pub bottom_displacement: Matrix2<T>,
}

/// Method for a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LayerMethod {
    /// Transfer matrix by series.
    Thin,
    /// Scaled waves.
    Thick,
    /// Cut into this many thin layers.
    Sliced(usize),
}

/// |exponent h| below which a wave in a thick layer counts as slow.
const SLOW: f64 = 0.05;
/// Most slices of a thick layer with a slow wave; beyond, the waves are used all the same.
const MOST_SLICES: f64 = 512.0;

/// Method by |alpha h|^2 and |beta h|^2.
pub(crate) fn choose_method(alpha_h_squared: f64, beta_h_squared: f64) -> LayerMethod {
    let largest = alpha_h_squared.max(beta_h_squared);
    if largest <= SERIES_LIMIT {
        return LayerMethod::Thin;
    }
    if alpha_h_squared.min(beta_h_squared) < SLOW * SLOW {
        let slices = (largest / SERIES_LIMIT).sqrt().ceil();
        if slices <= MOST_SLICES {
            return LayerMethod::Sliced(slices as usize);
        }
    }
    LayerMethod::Thick
}

/// Squared exponents and other values that depend on the wavenumber.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exponents<T> {
    /// k \[1/m\].
    pub k: f64,
    /// Q \[Pa/m^2\].
    pub q: T,
    /// Q/mu \[1/m^2\].
    pub q_over_shear: T,
    /// alpha^2 \[1/m^2\].
    pub alpha_squared: T,
    /// beta^2 \[1/m^2\].
    pub beta_squared: T,
}

impl<T: ComplexField> LayerAt<T> {
    /// rho s^2/mu \[1/m^2\]: the square of s over the speed of shear waves.
    pub(crate) fn inertia_over_shear(&self) -> T {
        self.inertia * self.inverse_shear
    }

    /// At a wavenumber (kx, ky) \[1/m\].
    #[inline(always)]
    pub(crate) fn exponents(&self, kx: f64, ky: f64) -> Exponents<T> {
        let k_squared = kx * kx + ky * ky;
        let q = self.inertia + (self.prestress[0] * kx * kx + self.prestress[1] * ky * ky);
        let q_over_shear = q * self.inverse_shear;
        Exponents {
            k: k_squared.sqrt(),
            q,
            q_over_shear,
            alpha_squared: q_over_shear * self.modulus_ratio + k_squared,
            beta_squared: q_over_shear + k_squared,
        }
    }

    /// P-SV states on top of the layer over an impedance (tau, sigma) = `under` (w, u_z), by a given method.
    #[inline(always)]
    pub(crate) fn p_sv(&self, exponents: &Exponents<T>, method: LayerMethod, under: Matrix2<T>) -> LayerResult<T> {
        match method {
            LayerMethod::Thin => self.p_sv_thin(exponents, self.thickness, under),
            LayerMethod::Thick => self.p_sv_thick(exponents, under),
            LayerMethod::Sliced(slices) => {
                let thickness = self.thickness / slices as f64;
                let mut result = self.p_sv_thin(exponents, thickness, under);
                for _ in 1..slices {
                    let below = result.top.traction.over(result.top.displacement);
                    let to_bottom = result.bottom_displacement.over(result.top.displacement);
                    result = self.p_sv_thin(exponents, thickness, below);
                    result.bottom_displacement = to_bottom * result.bottom_displacement;
                }
                result
            }
        }
    }

    /// Method 1 of the module, for a thickness `h`.
    #[inline(always)]
    pub(super) fn p_sv_thin(&self, exponents: &Exponents<T>, h: f64, under: Matrix2<T>) -> LayerResult<T> {
        // 1. c and s of alpha^2 h^2, and their divided differences.
        let Exponents { k, q, q_over_shear, alpha_squared, beta_squared } = *exponents;
        let (kappa, mu) = (self.modulus_ratio, self.shear);
        let h_squared = h * h;
        let pair = hyperbolic_pair(alpha_squared * h_squared, beta_squared * h_squared);
        // PR - alpha^2 I and RP - alpha^2 I have rank one and the common factor 1 - kappa.
        let scale = (1.0 - kappa) * h_squared;
        let (cosh_difference, sinhc_difference) = (pair.cosh_difference * scale, pair.sinhc_difference * scale);
        let v = q_over_shear + 2.0 * k * k;
        let two_k_squared = q.like(-2.0 * k * k);
        let k_over_mu = self.inverse_shear * k;
        let two_mu_k_v = mu * v * (2.0 * k);
        let pr = Matrix2([[v, k_over_mu], [-two_mu_k_v, two_k_squared]]);
        let rp = Matrix2([[two_k_squared, -k_over_mu], [two_mu_k_v, v]]);
        let p = Matrix2([[q.like(k), self.inverse_shear], [q, q.like(-k)]]);
        let nu = 1.0 - 2.0 * kappa;
        let r = Matrix2([
            [q.like(-nu * k), self.inverse_shear * kappa],
            [mu * (4.0 * (1.0 - kappa) * k * k) + q, q.like(nu * k)],
        ]);
        let cosh = Matrix2::diagonal(pair.cosh, pair.cosh);
        let sinhc = Matrix2::diagonal(pair.sinhc, pair.sinhc);
        // 2. The blocks of exp(A h).
        let xx = (cosh + pr.scaled(cosh_difference)).0;
        let yy = (cosh + rp.scaled(cosh_difference)).0;
        let s_pr = (sinhc + pr.scaled(sinhc_difference)).scaled(q.like(h));
        let xy = (s_pr * p).0;
        let yx = (r * s_pr).0;
        // 3. From (w, sigma | u_z, tau) to (w, u_z | tau, sigma).
        let t11 = Matrix2([[xx[0][0], xy[0][0]], [yx[0][0], yy[0][0]]]);
        let t12 = Matrix2([[xy[0][1], xx[0][1]], [yy[0][1], yx[0][1]]]);
        let t21 = Matrix2([[yx[1][0], yy[1][0]], [xx[1][0], xy[1][0]]]);
        let t22 = Matrix2([[yy[1][1], yx[1][1]], [xy[1][1], xx[1][1]]]);
        LayerResult {
            top: FaceState { displacement: t11 + t12 * under, traction: t21 + t22 * under },
            bottom_displacement: Matrix2::diagonal(q.like(1.0), q.like(1.0)),
        }
    }

    /// Method 2 of the module.
    #[inline(always)]
    pub(super) fn p_sv_thick(&self, exponents: &Exponents<T>, under: Matrix2<T>) -> LayerResult<T> {
        let Exponents { k, q, q_over_shear, alpha_squared, beta_squared } = *exponents;
        let (kappa, mu, h) = (self.modulus_ratio, self.shear, self.thickness);
        let (alpha, beta) = (alpha_squared.square_root(), beta_squared.square_root());
        let (decay_p, decay_s) = ((alpha * -h).exponential(), (beta * -h).exponential());
        // 1. (exp(-beta h) - exp(-alpha h)) mu/Q; beta - alpha = (1 - kappa) (Q/mu)/(alpha + beta).
        let split = (alpha + beta).reciprocal() * (1.0 - kappa);
        let argument = q_over_shear * split * -h;
        let near = decay_p * split * exponential_quotient(argument) * -h;
        let far = (decay_s - decay_p) * q_over_shear.reciprocal();
        let delta = argument.select_below(0.25, near, far);

        let shear_traction = mu * (2.0 * k * k) + q;
        let two_mu_k = mu * (2.0 * k);
        // 2. Wave P: displacement (-k, alpha), traction (-2 mu k alpha, 2 mu k^2 + Q).
        let p_displacement = [q.like(-k), alpha];
        let p_traction = [-(two_mu_k * alpha), shear_traction];
        // Wave SV: displacement (beta, -k), traction (2 mu k^2 + Q, -2 mu k beta); enters through (P + SV) mu/Q only.
        let over_beta = (beta + k).reciprocal();
        let over_alpha = (alpha + k).reciprocal();
        let d_displacement = [over_beta, over_alpha * kappa];
        let d_traction = [mu * (over_alpha * (-2.0 * kappa * k) + 1.0), q * over_beta * over_beta];
        let sv_displacement = [beta, q.like(-k)];
        let sv_traction = [shear_traction, -(two_mu_k * beta)];

        // 3. Waves that decay downwards from the top face: on the top face, and on the bottom face.
        let down = FaceState {
            displacement: columns(p_displacement, d_displacement),
            traction: columns(p_traction, d_traction),
        };
        let down_far = FaceState {
            displacement: away(p_displacement, d_displacement, sv_displacement, decay_p, delta),
            traction: away(p_traction, d_traction, sv_traction, decay_p, delta),
        };
        // 4. Waves that decay upwards are their mirror images; the impedance below determines how much of them is
        // reflected.
        let (up, up_far) = (mirror(down), mirror(down_far));
        let reflected =
            (under * up.displacement - up.traction).solve(down_far.traction - under * down_far.displacement);
        LayerResult {
            top: FaceState {
                displacement: down.displacement + up_far.displacement * reflected,
                traction: down.traction + up_far.traction * reflected,
            },
            bottom_displacement: down_far.displacement + up.displacement * reflected,
        }
    }

    /// SH: (u, t) on top and u at the bottom over an impedance t = `under` u, in one state.
    pub(crate) fn sh(&self, exponents: &Exponents<T>, thin: bool, under: T) -> [T; 3] {
        let h = self.thickness;
        if thin {
            let argument = exponents.beta_squared * (h * h);
            let pair = hyperbolic_pair(argument, argument);
            let s = pair.sinhc * h;
            let displacement = pair.cosh + s * self.inverse_shear * under;
            let traction = self.shear * exponents.beta_squared * s + pair.cosh * under;
            [displacement, traction, under.like(1.0)]
        } else {
            let beta = exponents.beta_squared.square_root();
            let decay = (beta * -h).exponential();
            let impedance = self.shear * beta;
            let echo = decay * decay;
            let (sum, difference) = (echo + 1.0, -echo + 1.0);
            [
                impedance * sum + under * difference,
                impedance * (impedance * difference + under * sum),
                impedance * decay * 2.0,
            ]
        }
    }
}

// Functions, not closures: they are inlined by force, since the vector code of the lanes ends at a call.

#[inline(always)]
fn columns<T: ComplexField>(p: [T; 2], d: [T; 2]) -> Matrix2<T> {
    Matrix2([[p[0], d[0]], [p[1], d[1]]])
}

/// Both waves on the far face.
#[inline(always)]
fn away<T: ComplexField>(p: [T; 2], d: [T; 2], sv: [T; 2], decay_p: T, delta: T) -> Matrix2<T> {
    columns([p[0] * decay_p, p[1] * decay_p], [d[0] * decay_p + sv[0] * delta, d[1] * decay_p + sv[1] * delta])
}

/// Mirror image in the middle plane: u_z and tau change sign.
#[inline(always)]
fn mirror<T: ComplexField>(face: FaceState<T>) -> FaceState<T> {
    let [above, [a, b]] = face.displacement.0;
    let [[c, d], below] = face.traction.0;
    FaceState { displacement: Matrix2([above, [-a, -b]]), traction: Matrix2([[-c, -d], below]) }
}
