//! Projection of the tyre's waves on a contact element: wavenumbers and weights, geometry only.

use std::f64::consts::PI;

use super::waves::Waves;
use crate::numeric::sinc;
use crate::scene::Tyre;

/// Lateral number m with ky \[1/m\] and its weight \[1/m\].
#[derive(Clone, Copy, Debug)]
pub(in crate::tyre) struct Lateral {
    pub(in crate::tyre) m: usize,
    pub(in crate::tyre) ky: f64,
    pub(in crate::tyre) weight: f64,
}

/// Wavenumbers and weights of the sums for contact elements.
#[derive(Clone, Debug, PartialEq)]
pub struct Projection {
    /// Waves of the tyre.
    pub(crate) waves: Waves,
    /// Contact width b \[m\].
    pub contact_width: f64,
    /// Length of an element along x \[m\].
    pub element: f64,
    /// Number N of elements round the tyre.
    pub elements: usize,
}

impl Projection {
    /// N = `elements` round the tyre, as wide as its contact.
    pub fn new(tyre: &Tyre, elements: usize) -> Self {
        Self {
            waves: Waves::new(tyre),
            contact_width: tyre.contact_width,
            element: tyre.circumference / elements as f64,
            elements,
        }
    }

    /// (1/L) sinc^2(kx dx/2) \[1/m\].
    pub fn longitudinal_weight(&self, n: i64) -> f64 {
        let shape = sinc(0.5 * self.waves.kx(n) * self.element);
        shape * shape / self.waves.circumference
    }

    /// Weight of a lateral wave in the mean over the contact strip \[1/m\], (2/B) a_m^2.
    pub fn lateral_weight(&self, m: usize) -> f64 {
        self.waves.lateral_weight(m, self.contact_width)
    }

    pub(super) fn first_lateral(&self, count: usize) -> Vec<Lateral> {
        self.all_lateral().take(count).collect()
    }

    /// Lateral numbers of a centred strip with ky below the cut-off \[1/m\], from the lowest on.
    pub(in crate::tyre) fn lateral_below(&self, cut_off: f64) -> Vec<Lateral> {
        self.all_lateral().take_while(|lateral| lateral.ky < cut_off).collect()
    }

    fn all_lateral(&self) -> impl Iterator<Item = Lateral> {
        self.waves.lateral_numbers().map(|m| Lateral { m, ky: self.waves.ky(m), weight: self.lateral_weight(m) })
    }

    /// Sum of all weights, 1/(L b) \[1/m^2\].
    pub fn total_weight(&self) -> f64 {
        1.0 / (self.waves.circumference * self.contact_width)
    }

    /// Wavenumbers n + p N, p = 0, 1, -1, 2, ...
    pub fn aliases(&self, n: usize) -> impl Iterator<Item = i64> + use<> {
        let (n, elements) = (n as i64, self.elements as i64);
        std::iter::once(n).chain((1..).flat_map(move |p| [n + p * elements, n - p * elements]))
    }

    /// As [`Self::aliases`], those with |kx| up to the cut-off \[1/m\].
    pub fn aliases_below(&self, n: usize, cut_off: f64) -> impl Iterator<Item = i64> + use<> {
        let largest = (cut_off * self.waves.circumference / (2.0 * PI)) as i64;
        let elements = self.elements as i64;
        let n = n as i64;
        let most = (largest + n) / elements + 1;
        self.aliases(n as usize).take(2 * most as usize + 1).filter(move |alias| alias.abs() <= largest)
    }
}
