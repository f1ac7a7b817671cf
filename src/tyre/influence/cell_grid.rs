//! Cells of the contact strip and what they take of the tyre's waves: geometry only.
//!
//! Cells are dx along by dy = b/M across, i counts along, j across, y_j = B/2 - b/2 + (j + 1/2) dy. A cell is loaded
//! uniformly and its mean displacement observed, so that it takes sinc(kx dx/2) of a wave along and
//!
//! ```text
//! s_m(y_j) = cos(ky y_j) sinc(ky dy/2)      (guided sides; sin where they are supported)
//! ```
//!
//! across.

use super::projection::Projection;
use super::waves::Waves;
use crate::numeric::sinc;
use crate::scene::{Sides, Tyre};

/// Cells of the contact strip.
#[derive(Clone, Debug, PartialEq)]
pub struct CellGrid {
    /// Waves and elements along.
    along: Projection,
    /// Cells M across the strip.
    pub across: usize,
}

impl CellGrid {
    /// N cells round a tyre by M across its contact width.
    pub fn new(tyre: &Tyre, elements: usize, across: usize) -> Self {
        Self { along: Projection::new(tyre, elements), across }
    }

    /// The tyre's waves.
    pub fn waves(&self) -> Waves {
        self.along.waves
    }

    /// Cells N round the tyre.
    pub fn elements(&self) -> usize {
        self.along.elements
    }

    /// Length dx of a cell along \[m\].
    pub fn length(&self) -> f64 {
        self.along.element
    }

    /// Width dy of a cell \[m\].
    pub fn pitch(&self) -> f64 {
        self.along.contact_width / self.across as f64
    }

    /// Distance of a cell's middle from the tyre's, to the left \[m\].
    pub fn from_middle(&self, j: usize) -> f64 {
        (j as f64 + 0.5) * self.pitch() - 0.5 * self.along.contact_width
    }

    /// The width nearest to the tyre's \[m\] at which its sides are whole numbers of cells away from the strip: there,
    /// m and 2 B/dy - m are the same on cells, up to a sign.
    pub fn width_in_cells(&self) -> f64 {
        let strip = self.along.contact_width;
        strip + ((self.waves().width - strip) / self.pitch()).round() * self.pitch()
    }

    /// The lowest lateral number that cells take for m, where sides are whole cells away.
    pub(super) fn same_on_cells(&self, m: usize) -> usize {
        let all = 2 * (self.waves().width / self.pitch()).round() as usize;
        (m % all).min(all - m % all)
    }

    /// Whether any cell feels m; the highest may have its nodes in all of them.
    pub(super) fn is_felt(&self, m: usize) -> bool {
        /// What is left of a node by rounding.
        const ROUNDING: f64 = 1e-9;
        (0..self.across).any(|j| self.wave(m, j).abs() > ROUNDING)
    }

    /// The wave itself at y_j.
    pub fn wave(&self, m: usize, j: usize) -> f64 {
        let waves = self.waves();
        let phase = waves.ky(m) * (0.5 * waves.width + self.from_middle(j));
        match waves.sides {
            Sides::Supported => phase.sin(),
            Sides::Guided => phase.cos(),
        }
    }

    /// s_m(y_j).
    pub fn shape(&self, m: usize, j: usize) -> f64 {
        self.wave(m, j) * sinc(0.5 * self.waves().ky(m) * self.pitch())
    }

    /// sinc^2(ky dy/2), what shapes of two cells have in common, over their mean square.
    pub(super) fn lateral_weight(&self, m: usize) -> f64 {
        let share = sinc(0.5 * self.waves().ky(m) * self.pitch());
        share * share * self.waves().lateral_norm(m)
    }

    /// (1/L) sinc^2(kx dx/2) \[1/m\].
    pub(super) fn longitudinal_weight(&self, n: i64) -> f64 {
        self.along.longitudinal_weight(n)
    }

    /// The lateral numbers that cells can excite, from the lowest on.
    pub fn lateral_numbers(&self) -> impl Iterator<Item = usize> + use<> {
        self.waves().first_lateral_number()..
    }
}
