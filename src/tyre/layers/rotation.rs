//! Rotation of a curved tyre: its growth and the hoop stress of its layers, steady in the frame of the tyre.
//!
//! Layers that turn with Omega are held together by one growth w_0 that they share: each bears the centrifugal load in
//! proportion to its hoop stiffness, and the foundation the rest:
//!
//! ```text
//! w_0 = Omega^2 (sum rho_j h_j r_j^2 + m_s R_i^2)/(sum Q_tt,j(0) h_j/r_j + k_n(0) R_i),
//! S_j = T_theta,j/h_j + Q_tt,j(0) w_0/r_j,
//! ```
//!
//! r_j mid radii, Q_tt(0) the hoop modulus at s = 0 of strains held across, m_s the mass of the sidewalls per area of
//! the inner face, R_i its radius. Within 1.3 % of the statics of the layers in full. Small motion about this state has
//! the accelerations (circumferential, lateral, outward)
//!
//! ```text
//! (s^2 - Omega^2) v + 2 Omega s w,   s^2 q,   (s^2 - Omega^2) w - 2 Omega s v,
//! ```
//!
//! of the sidewalls' mass, too. Left out: the radial prestress of the layers that hang on the belt, at most 1.1 % of C
//! at 110 km/h and 5.8 % at 250 km/h.

use num_complex::Complex64;

use super::elasticity::ElasticityAt;
use crate::scene::Layer;

/// Steady rotation of a curved stack; at rest by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rotation {
    /// Angular velocity Omega \[rad/s\]; positive where the tyre moves with growing theta, the direction of the waves
    /// exp(i n theta).
    pub angular_velocity: f64,
    /// Growth w_0 of the radius \[m\].
    pub growth: f64,
}

impl Rotation {
    /// A rotation whose tension is already in the layers' tension: no growth adds to it.
    pub fn of_given_tension(angular_velocity: f64) -> Self {
        Self { angular_velocity, growth: 0.0 }
    }

    /// True unless the angular velocity is 0.
    pub fn turns(&self) -> bool {
        self.angular_velocity != 0.0
    }

    /// Prestress S, S_y \[Pa\] of a layer whose inner face has the radius `from` \[m\].
    pub fn prestress(&self, layer: &Layer, from: f64) -> [f64; 2] {
        let [hoop, across] = layer.tension.map(|tension| tension / layer.thickness);
        if !self.turns() {
            return [hoop, across];
        }
        [hoop + hoop_modulus(layer) * self.growth / (from + 0.5 * layer.thickness), across]
    }

    /// rho Omega^2: reduction by rotation of the stiffness against circumferential and outward motion \[Pa/m^2\].
    pub(super) fn softening(&self, density: f64) -> f64 {
        density * self.angular_velocity * self.angular_velocity
    }

    /// 2 Omega rho s, of the Coriolis force \[Pa/m^2\]; of a mass per area \[N/m^3\].
    pub(super) fn coriolis(&self, density: f64, s: Complex64) -> Complex64 {
        s * (2.0 * self.angular_velocity * density)
    }
}

/// Q_tt at s = 0 \[Pa\].
pub(super) fn hoop_modulus(layer: &Layer) -> f64 {
    ElasticityAt::new(layer, Complex64::ZERO).plane[0].re
}
