//! The flat tread: the tyre's outermost layer, level, bonded to a rigid base, at rest.
//!
//! Its modulus is that of the local law's formula, E(100 Hz): a road's texture loads and unloads a point within some
//! 10 ms. Its compliance is that of a tyre of this one layer, whose foundation does not give way.

use serde::Serialize;

use crate::contact::local_compliance::formula::tread_modulus;
use crate::road::Lattice;
use crate::scene::{Foundation, Law, Layer, Material, Sides, Tyre};
use crate::tyre::influence::{CellGrid, CellInfluence, CellSums, CellTruncation};

/// Stiffness of the base, in moduli over the tread's thickness.
const RIGID: f64 = 1e9;
/// Free tread on either side of the strip, and behind its end where its ring closes, in thicknesses.
const BESIDE: f64 = 4.0;
/// Distance between cells beyond which they are taken not to influence each other, in thicknesses. With 6 instead, p
/// changes by 2 um rms; with all distances, by 1 um.
const REACH: f64 = 8.0;
/// Relative tolerance of compliances.
const TOLERANCE: f64 = 1e-6;

/// The outermost layer of a tyre, elastic and without tension.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct FlatTread {
    tread: Layer,
    /// E* = E/(1 - nu^2) \[Pa\].
    effective_modulus: f64,
}

impl FlatTread {
    /// Tread of a tyre; `None` for a tyre without layers.
    pub(crate) fn of(tyre: &Tyre) -> Option<Self> {
        let (layer, effective_modulus) = tyre.layers.last().zip(tread_modulus(tyre))?;
        let modulus = effective_modulus * (1.0 - layer.material.poisson * layer.material.poisson);
        let material = Material { law: Law::Elastic, modulus, ..layer.material.clone() };
        let tread = Layer { name: "tread".to_owned(), tension: [0.0; 2], material, ..layer.clone() };
        Some(Self { tread, effective_modulus })
    }

    /// Thickness \[m\].
    pub(crate) fn thickness(&self) -> f64 {
        self.tread.thickness
    }

    /// Compliance of the columns under an element, each by itself: h/(E* dx b) \[m/N\].
    pub(crate) fn spring(&self, lattice: Lattice) -> f64 {
        self.tread.thickness / (self.effective_modulus * lattice.dx * lattice.width())
    }

    /// The tread round a ring, as a tyre of one layer; lengths in m.
    pub(super) fn ring(&self, circumference: f64, width: f64, strip: f64) -> Tyre {
        let Material { modulus, .. } = self.tread.material;
        let stiffness = RIGID * modulus / self.tread.thickness;
        Tyre {
            circumference,
            width,
            contact_width: strip,
            crown_radius: None,
            load_index: None,
            sides: Sides::Guided,
            curvature: false,
            inflation: None,
            cavity: None,
            sidewall: None,
            foundation: Foundation { normal: stiffness, tangential: stiffness, ..Foundation::default() },
            layers: vec![self.tread.clone()],
            angular_velocity: 0.0,
        }
    }

    /// Influence between the cells under `elements` elements of a lattice \[m/N\].
    ///
    /// The tread goes on beside the strip, and along as a ring that is longer than the elements. Of the images in its
    /// sides only the mean of guided and supported ones is taken, which is none; so the influence stays positive
    /// definite.
    pub(crate) fn influence(&self, lattice: Lattice, elements: usize) -> CellInfluence {
        let cell = lattice.cell();
        let beside = BESIDE * self.tread.thickness;
        let rows = elements * lattice.along;
        let round = (rows + (beside / cell).ceil() as usize).next_multiple_of(8);
        let tyre = self.ring(round as f64 * cell, lattice.width() + 2.0 * beside, lattice.width());
        let grid = CellGrid::new(&tyre, round, lattice.columns);
        let truncation = CellTruncation { lateral_terms: None, aliases: None };
        let mut influence = CellSums::new(&tyre, grid, truncation, TOLERANCE, 1.0).cached_instant(0.0, rows);
        influence.hankel.fill(0.0);
        let is_far = |distance: usize, length: f64| distance as f64 * length > REACH * self.tread.thickness;
        for (along, row) in influence.toeplitz.chunks_exact_mut(lattice.columns).enumerate() {
            for (across, value) in row.iter_mut().enumerate() {
                if is_far(along, cell) || is_far(across, lattice.dy) {
                    *value = 0.0;
                }
            }
        }
        influence
    }
}

/// Influence of a force that is spread evenly over an element on the mean displacement of the element j further on
/// \[m/N\], by the influence between the cells under them: as long waves are the same in both, they cancel.
pub fn line_influence(cells: &CellInfluence, lattice: Lattice) -> Vec<f64> {
    let Lattice { along, columns, .. } = lattice;
    let pairs = |distance: usize| if distance == 0 { columns } else { 2 * (columns - distance) };
    let across: Vec<f64> = (0..columns).map(|j| pairs(j) as f64 / (columns * columns) as f64).collect();
    let row_mean = |row: &[f64]| row.iter().zip(&across).map(|(value, share)| value * share).sum::<f64>();
    let rows: Vec<f64> = cells.toeplitz.chunks_exact(columns).map(row_mean).collect();
    let element = |j: usize| {
        let pairs = (0..along).flat_map(|a| (0..along).map(move |b| (j * along + a).abs_diff(b)));
        pairs.map(|distance| rows[distance]).sum::<f64>() / (along * along) as f64
    };
    (0..rows.len() / along).map(element).collect()
}
