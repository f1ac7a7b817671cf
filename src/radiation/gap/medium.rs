//! Air between two walls: the boundary layers of viscosity and of heat.
//!
//! Between rigid walls of constant temperature at a distance h, at an angular frequency w (exp(+i w t)), the mean flow
//! and the mean compression are those of air without losses with
//!
//! ```text
//! F = 1 - tanh(q)/q,   q = (1 + i) h/(2 delta),   delta_v = sqrt(2 nu/w),   delta_t = delta_v/sqrt(Pr)
//! ```
//!
//! -dp/dx F_v = i w rho v and (gamma - (gamma - 1) F_t) p/(rho c^2) = compression. Wide gaps have F = 1; narrow ones
//! flow by Poiseuille's law, F_v = i w h^2/(12 nu), and compress isothermally, F_t = 0.

use num_complex::Complex64;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GapAir {
    /// Speed of sound \[m/s\].
    pub sound_speed: f64,
    /// Kinematic viscosity nu \[m^2/s\].
    pub viscosity: f64,
    /// Prandtl number.
    pub prandtl: f64,
    /// Ratio gamma of the heat capacities.
    pub heat_ratio: f64,
}

impl GapAir {
    /// F_v in a gap of a height \[m\] at an angular frequency \[rad/s\].
    pub(crate) fn flow(&self, height: f64, angular: f64) -> Complex64 {
        share(height * (angular / self.viscosity).sqrt())
    }

    /// gamma - (gamma - 1) F_t in a gap of a height \[m\] at an angular frequency \[rad/s\].
    pub(crate) fn compression(&self, height: f64, angular: f64) -> Complex64 {
        let share = share(height * (angular * self.prandtl / self.viscosity).sqrt());
        self.heat_ratio - (self.heat_ratio - 1.0) * share
    }
}

/// 1 - tanh(q)/q for q = (1 + i) s/sqrt(8), s the height over sqrt(nu/w).
fn share(s: f64) -> Complex64 {
    let q = Complex64::new(1.0, 1.0) * (s / 8.0_f64.sqrt());
    if s < SMALL {
        // q^2/3 - 2 q^4/15 + 17 q^6/315 - ...
        let square = q * q;
        return square * (1.0 / 3.0 - square * (2.0 / 15.0 - square * (17.0 / 315.0 - square * (62.0 / 2835.0))));
    }
    let fallen = (-2.0 * q).exp();
    1.0 - (1.0 - fallen) / ((1.0 + fallen) * q)
}

/// Height over sqrt(nu/w) below which 1 - tanh(q)/q loses more digits to cancellation than the truncated series.
const SMALL: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiation::gap::tests::AIR;

    #[test]
    fn narrow_gaps_are_viscous_and_isothermal_wide_ones_lossless() {
        let angular = std::f64::consts::TAU * 1000.0;
        for height in [1e-7, 1e-6, 5e-6] {
            let poiseuille = Complex64::I * angular * height * height / (12.0 * AIR.viscosity);
            let off = (AIR.flow(height, angular) / poiseuille - 1.0).norm();
            // The next term of the series is 2 q^2/5, |q|^2 = w h^2/(4 nu).
            let next = 0.1 * angular * height * height / AIR.viscosity;
            assert!(off < 1.05 * next + 1e-12 && off > 0.9 * next - 1e-12, "{height}: {off:e}, {next:e}");
            let isothermal = (AIR.compression(height, angular) - AIR.heat_ratio).norm();
            assert!(isothermal < 0.04 * next.max(1e-12) / 0.1, "{height}: {isothermal:e}");
        }
        // Relative reduction by the layers in a wide gap: delta (1 - i)/h.
        let layer = (2.0 * AIR.viscosity / angular).sqrt();
        for height in [0.01, 0.1] {
            let thin = Complex64::new(1.0, -1.0) * (layer / height);
            assert!((AIR.flow(height, angular) - (1.0 - thin)).norm() < 1e-12, "{height}");
            let heat = (AIR.heat_ratio - 1.0) * thin / AIR.prandtl.sqrt();
            assert!((AIR.compression(height, angular) - (1.0 + heat)).norm() < 1e-12, "{height}");
        }
        // Series and formula meet.
        let [below, above] = [SMALL * (1.0 - 1e-12), SMALL].map(share);
        assert!((below / above - 1.0).norm() < 1e-10, "{below} {above}");
    }
}
