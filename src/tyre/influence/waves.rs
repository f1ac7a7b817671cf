//! The tyre's waves: numbers, wavenumbers, and the weights of a centred strip for them across the width. Geometry
//! only.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::numeric::sinc;
use crate::scene::{Sides, Tyre};

/// Dimensions that determine the tyre's waves.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub(crate) struct Waves {
    /// Circumference L \[m\].
    pub circumference: f64,
    /// Width B between the sides \[m\].
    pub width: f64,
    /// Support of the sides.
    pub sides: Sides,
}

impl Waves {
    pub(crate) fn new(tyre: &Tyre) -> Self {
        Self { circumference: tyre.circumference, width: tyre.width, sides: tyre.sides }
    }

    /// kx of the integer wavenumber n \[1/m\].
    pub(crate) fn kx(&self, n: i64) -> f64 {
        2.0 * PI * n as f64 / self.circumference
    }

    /// ky of the lateral number m \[1/m\].
    pub(crate) fn ky(&self, m: usize) -> f64 {
        PI * m as f64 / self.width
    }

    /// Lateral numbers that a centred strip excites, from the lowest on, without end.
    pub(crate) fn lateral_numbers(&self) -> impl Iterator<Item = usize> + Clone + use<> {
        (self.first_lateral_number()..).step_by(2)
    }

    /// Lowest lateral number, which a centred strip excites.
    pub(crate) fn first_lateral_number(&self) -> usize {
        match self.sides {
            Sides::Supported => 1,
            Sides::Guided => 0,
        }
    }

    /// (2/B) a_m^2 of a centred strip b wide, (1/B) a_0^2 \[1/m\]; the sum over all m that it excites is 1/b.
    pub(crate) fn lateral_weight(&self, m: usize, strip: f64) -> f64 {
        let shape = self.lateral_share(m, strip);
        self.lateral_norm(m) * shape * shape
    }

    /// Mean a_m over a centred strip of a wave that is 1 at mid-width.
    pub(crate) fn lateral_share(&self, m: usize, strip: f64) -> f64 {
        sinc(0.5 * self.ky(m) * strip)
    }

    /// 2/B, 1/B for m = 0 \[1/m\]: the reciprocal of the integral over the width of the squared wave.
    pub(crate) fn lateral_norm(&self, m: usize) -> f64 {
        if m == 0 { 1.0 / self.width } else { 2.0 / self.width }
    }

    /// True if a wave is even about mid-width.
    pub(crate) fn is_even(&self, m: usize) -> bool {
        (m - self.first_lateral_number()).is_multiple_of(2)
    }

    /// Value at the side y = B/2, y from mid-width, of cos(ky y) where a wave is even, of sin(ky y) where it is odd; 0
    /// at supported sides.
    pub(crate) fn at_side(&self, m: usize) -> f64 {
        match self.sides {
            Sides::Guided => self.sign_about_middle(m) * if self.is_even(m) { 1.0 } else { -1.0 },
            Sides::Supported => 0.0,
        }
    }

    /// 1 or -1: with y from mid-width, the ratio of the wave that is 1 or slopes upwards at the side y = -B/2 to
    /// cos(ky y) where it is even, to sin(ky y) where it is odd.
    pub(crate) fn sign_about_middle(&self, m: usize) -> f64 {
        let turned = match self.sides {
            // cos(ky y + m pi/2).
            Sides::Guided => m.div_ceil(2),
            // sin(ky y + m pi/2).
            Sides::Supported => m / 2,
        };
        if turned.is_multiple_of(2) { 1.0 } else { -1.0 }
    }
}
