//! Numbers of contact over cells.

use super::Plan;
use crate::tyre::influence::WaveBand;
use crate::tyre::poles::cells::CellFitOptions;

/// Wavenumbers times the tread's thickness between which waves are handed from the tyre's ring to a shorter one.
const HANDED_OVER: [f64; 2] = [6.0, 12.0];
/// Length of the shorter ring over that of the window, at least.
const RING: usize = 2;

impl Plan {
    /// Height of the tread above its middle, at a distance from there \[m\].
    pub fn crown(&self, from_middle: f64) -> f64 {
        self.scene.tyre.crown_radius.map_or(0.0, |radius| from_middle * from_middle / (2.0 * radius))
    }

    /// The bands of waves that carry the past of cells, seen through a window of so many columns. Finite sums are kept
    /// whole.
    pub fn wave_bands(&self, columns: usize) -> Vec<WaveBand> {
        let numerics = &self.scene.numerics;
        let finite = numerics.lateral_terms.is_some() || numerics.wavenumber_aliases.is_some();
        let fits = |part: &usize| {
            let ring = numerics.elements / part;
            numerics.elements.is_multiple_of(*part) && ring.is_multiple_of(2) && ring >= RING * columns
        };
        let part =
            (1..=numerics.elements).take_while(|part| numerics.elements / part >= RING * columns).filter(fits).max();
        match (part, self.scene.tyre.layers.last()) {
            (Some(part), Some(tread)) if part > 1 && !finite => {
                let border = Some(HANDED_OVER.map(|kh| kh / tread.thickness));
                vec![
                    WaveBand { part: 1, fades_in: None, fades_out: border },
                    WaveBand { part, fades_in: border, fades_out: None },
                ]
            }
            _ => vec![WaveBand::WHOLE],
        }
    }

    /// What the fits of the waves have to be.
    pub fn cell_fit(&self) -> CellFitOptions {
        CellFitOptions { top: self.fit.top, tolerance: self.fit.tolerance, most_poles: self.fit.most_poles }
    }
}
