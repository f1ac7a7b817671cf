//! The sums without the half-space's tail: explicit terms until the remainder is bounded. The reference for the tail
//! of [`super::folded_sum`], and the method where there is none.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::folded_sum::{InfluenceSum, InfluenceValue, SumAt};
use super::kernel::Field;
use super::projection::Projection;
use super::waves::Waves;

impl InfluenceSum {
    /// Explicit terms; whichever of the two counts is not given ends when the remainder is below the tolerance times
    /// the static value.
    ///
    /// Bound: for k h >= 3 and |Q/mu| <= 0.4 k^2, |C_zz| <= 2 (1 - nu)/(|mu| k). Then the remainder of the sum over m,
    /// with a_m^2 <= (2 B/(pi b m))^2, is below c (2/B) (2 B/(pi b))^2 min(1/(2 m k), 1/(4 m ky)) and the remainder
    /// over p, with sinc^2 <= (dx kx/2)^-2, below (c/(L b)) 2 sum (dx kx_p/2)^-2/kx_p.
    pub(super) fn by_bound(&self, n: usize, at: &SumAt, field: Field) -> InfluenceValue {
        let Projection { waves, contact_width, element, elements } = self.projection;
        let Waves { circumference, width, .. } = waves;
        let tread = at.kernel.tread();
        let ratio = tread.inertia_over_shear().norm();
        // (1 - nu) = 1/(2 (1 - kappa)).
        let bound = (1.0 / (1.0 - tread.modulus_ratio)) * tread.inverse_shear.norm();
        let prestress = tread.prestress[0].max(tread.prestress[1]) * tread.inverse_shear.norm();
        let decided = |k: f64| k * tread.thickness >= 3.0 && ratio + prestress * k * k <= 0.4 * k * k;
        // The static value by its first three lateral numbers.
        let at_rest = self.kernel.at(Complex64::ZERO);
        let floor = self.projection.longitudinal_weight(n as i64)
            * waves
                .lateral_numbers()
                .take(3)
                .map(|m| at_rest.normal(n as i64, m, Field::Surface).norm() * self.projection.lateral_weight(m))
                .sum::<f64>();
        let target = self.tolerance * floor;
        let slope = (2.0 / width) * (2.0 * width / (PI * contact_width)).powi(2);

        let (mut value, mut odd, mut evaluations) = (Complex64::ZERO, Complex64::ZERO, 0);
        for p in 0.. {
            let pair = [n as i64 + p * elements as i64, n as i64 - p * elements as i64];
            for &alias in if p == 0 { &pair[..1] } else { &pair[..] } {
                let kx = waves.kx(alias);
                let longitudinal = self.projection.longitudinal_weight(alias);
                let (mut row, mut odd_row) = (Complex64::ZERO, Complex64::ZERO);
                for (before, m) in waves.lateral_numbers().enumerate() {
                    let ky = waves.ky(m);
                    let weight = self.projection.lateral_weight(m);
                    if self.turns() {
                        let parts = at.kernel.normal_parts(alias.abs(), m, field);
                        row += parts.even * weight;
                        odd_row += parts.odd * weight;
                    } else {
                        row += at.kernel.normal(alias, m, field) * weight;
                    }
                    evaluations += 1;
                    let k = kx.hypot(ky);
                    match self.lateral_terms {
                        Some(terms) if before + 1 >= terms => break,
                        Some(_) => {}
                        None if decided(k) => {
                            let rest = bound * slope / (m as f64 * (2.0 * k).max(4.0 * ky)) * longitudinal;
                            // Tolerances of the aliases add up: sum 1/(1 + p^2) < 2.1.
                            if rest < 0.2 * target / (1.0 + (p * p) as f64) {
                                break;
                            }
                        }
                        None => {}
                    }
                }
                value += row * longitudinal;
                odd += odd_row * (longitudinal * self.sign_of_odd(n, alias));
            }
            match self.aliases {
                Some(most) if p as usize >= most => break,
                Some(_) => {}
                None => {
                    let kx = waves.kx(((p + 1) as usize * elements - n) as i64);
                    if decided(kx) {
                        let step = 2.0 * PI / element;
                        // sum over |p'| > p of kx^-3, as an integral from the middle between two aliases.
                        let sum = 2.0 / (2.0 * step * (kx - 0.5 * step).max(0.25 * step).powi(2));
                        let rest = bound / (circumference * contact_width) * (2.0 / element).powi(2) * sum;
                        if rest < 0.5 * target {
                            break;
                        }
                    }
                }
            }
        }
        if field == Field::Surface {
            value += self.by_curvature(n, at);
            odd += self.odd_by_curvature(n, at);
        }
        InfluenceValue { value, odd, evaluations }
    }
}
