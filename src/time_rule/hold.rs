//! The first-order hold: exact modes under a force that is linear between the steps. Its inverse is unstable for a
//! tyre, and every run refuses it: it shows what a rule that is exact for the modes would give.

use num_complex::Complex64;

/// Exact step of a' = lambda a + F for F linear between the steps, in units of dt, z = lambda dt:
/// a_l = exp(z) a_(l-1) + dt (yesterday F_(l-1) + today F_l).
#[derive(Clone, Copy, Debug)]
pub(crate) struct FirstOrderHold {
    /// exp(z); not below exp(-300), which is as good as zero and still has a reciprocal.
    pub decay: Complex64,
    /// (exp z - 1 - z)/z^2.
    pub today: Complex64,
    /// (exp z - 1)/z less that.
    pub yesterday: Complex64,
}

impl FirstOrderHold {
    /// Step for z = lambda dt, Re z < 0.
    pub(crate) fn new(z: Complex64) -> Self {
        let decay = Complex64::new(z.re.max(-300.0), z.im).exp();
        let (first, second) = if z.norm() < 0.5 {
            // Taylor: sum z^k/(k+1)!, sum z^k/(k+2)!; 0.5^16/18! is far below rounding.
            let (mut first, mut second, mut term) = (Complex64::ZERO, Complex64::ZERO, Complex64::ONE);
            for k in 0..16 {
                let order = f64::from(k);
                first += term / (order + 1.0);
                second += term / ((order + 1.0) * (order + 2.0));
                term *= z / (order + 1.0);
            }
            (first, second)
        } else {
            ((decay - 1.0) / z, (decay - 1.0 - z) / (z * z))
        };
        Self { decay, today: second, yesterday: first - second }
    }
}
