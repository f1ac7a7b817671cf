//! Numbers of contact over cells.

use std::f64::consts::{PI, TAU};

use super::Plan;
use super::amounts::{Amounts, Place};
use super::unit::Unit;
use crate::contact::cells::past::STEPS;
use crate::contact::history::expected_multiply_adds;
use crate::counters::{Counter, Stage};
use crate::numeric::transform_multiply_adds;
use crate::scene::History;
use crate::tyre::influence::{CellGrid, CellTruncation, WAVE_BYTES, WaveBand, wave_count};
use crate::tyre::poles::cells::CellFitOptions;
use crate::tyre::poles::expected_fit;

/// Wavenumbers times the tread's thickness between which waves are handed from the tyre's ring to a shorter one.
const HANDED_OVER: [f64; 2] = [6.0, 12.0];
/// How far the shorter ring reaches beyond the window, at least, in the longest waves on it over 2 pi: what has gone
/// round it has decayed by then.
const DECAYED: f64 = 40.0;

/// Residuals of the search for cells are no smaller than this part of the largest required displacement: its steps are
/// taken in single precision, and each round that brings the exact residual down costs as much as the first.
const LEAST_TOLERANCE: f64 = 3e-10;
/// Poles of a wave, conjugates counted, at a tolerance of 1e-5, and how many less for each factor of ten above it
/// (measured, N = 256 to 1024).
const POLES: [f64; 2] = [32.0, 5.0];
/// Bytes of a pole, conjugates counted: its model, its coefficients and its states.
const POLE_BYTES: f64 = 90.0;
/// Products in single precision that the search for an instant takes, with what goes with them (measured).
const PRODUCTS: f64 = 16.0;

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
        let Some(tread) = self.scene.tyre.layers.last().filter(|_| !finite) else { return vec![WaveBand::WHOLE] };
        let border = HANDED_OVER.map(|kh| kh / tread.thickness);
        let least = columns + (DECAYED / border[0] / self.element).ceil() as usize;
        let whole_rings = (1..=numerics.elements / least).filter(|part| numerics.elements.is_multiple_of(2 * part));
        match whole_rings.max() {
            Some(part) if part > 1 => vec![
                WaveBand { part: 1, fades_in: None, fades_out: Some(border) },
                WaveBand { part, fades_in: Some(border), fades_out: None },
            ],
            _ => vec![WaveBand::WHOLE],
        }
    }

    /// The cells round the tyre and across its strip.
    pub fn cell_grid(&self) -> CellGrid {
        let across = self.decisions.cells_across.unwrap_or(1);
        CellGrid::new(&self.decisions.tyre, self.scene.numerics.elements, across)
    }

    /// How far their sums go.
    pub fn cell_truncation(&self) -> CellTruncation {
        let numerics = &self.scene.numerics;
        CellTruncation { lateral_terms: numerics.lateral_terms, aliases: numerics.wavenumber_aliases }
    }

    /// How far a cell may be from where it is required to be, relative to the largest required displacement.
    pub fn cell_tolerance(&self) -> f64 {
        self.scene.numerics.contact_tolerance.max(LEAST_TOLERANCE)
    }

    /// Waves that a window of so many columns is expected to need, and the multiply-adds of their transforms, there and
    /// back, for an instant. They are not listed: there may be more than a machine can hold.
    pub(super) fn expected_waves(&self, columns: f64) -> [f64; 2] {
        let grid = self.cell_grid();
        let (waves, cells) = (grid.waves(), columns * grid.across as f64);
        let mut expected = [0.0; 2];
        for band in self.wave_bands(columns as usize) {
            let ring = grid.elements() / band.part;
            let around = (ring / 2 + 1) as f64;
            let (rows, count) = match (band.fades_out, self.last_lateral_number() as f64) {
                // A quarter of a disc.
                (Some([_, end]), _) => {
                    let rows = end / waves.ky(1);
                    (rows, 0.25 * PI * rows * around.min(end / waves.kx(1)))
                }
                (None, last) => (last, last * around),
            };
            expected[0] += count;
            // A transform along for each lateral number, a product across by halves.
            expected[1] += rows * (transform_multiply_adds(ring) + cells);
        }
        expected
    }

    /// The largest lateral number of the waves that carry the past.
    pub(super) fn last_lateral_number(&self) -> usize {
        let grid = self.cell_grid();
        let highest = TAU / grid.length().min(grid.pitch());
        self.cell_truncation().lateral_terms.unwrap_or((highest / grid.waves().ky(1)) as usize)
    }

    /// Poles that one of them is expected to have, conjugates counted.
    pub(super) fn expected_poles_of_wave(&self) -> f64 {
        POLES[0] - POLES[1] * (self.fit.tolerance / 1e-5).log10()
    }

    /// What the fits of the waves have to be.
    pub fn cell_fit(&self) -> CellFitOptions {
        CellFitOptions { top: self.fit.top, tolerance: self.fit.tolerance, most_poles: self.fit.most_poles }
    }
}

impl Amounts {
    /// The past of cells, and the search for those in contact.
    pub(super) fn cells(&mut self, plan: &Plan) {
        let Plan { scene, .. } = plan;
        let (rule, steps) = (scene.numerics.time_rule, plan.steps as f64);
        let stages = rule.stages() as f64;
        let instants = steps * stages;
        let [waves, transforms] = plan.expected_waves(self.expected.columns);
        let cells = self.expected.columns * plan.cell_grid().across as f64;
        let search = PRODUCTS * transform_multiply_adds(4 * cells as usize);
        let poles = plan.expected_poles_of_wave() * waves;
        self.add(Stage::Axle, Unit::SearchMultiplyAdd, 30.0 * search, Place::Before);
        self.add(Stage::Penetration, Unit::LevelColumn, instants * cells, Place::March);
        self.add(Stage::ActiveSet, Unit::TransformMultiplyAdd, instants * search, Place::March);
        self.add(Stage::History, Unit::TransformMultiplyAdd, instants * transforms, Place::MarchOnAll);
        self.count(Counter::Steps, steps);
        // Forces and displacements of a block, and the first weights of its instants.
        let block = waves * STEPS as f64 * stages * (32.0 + 8.0 * stages);
        self.hold("poles, states and fields of the cells", POLE_BYTES * poles + block + 8.0 * cells * 40.0);
        if scene.numerics.history == History::Direct {
            let sums = plan.lags as f64 * waves * stages * stages;
            self.add(Stage::Influence, Unit::Evaluation, 2.0 * sums, Place::BeforeOnAll);
            self.add(Stage::History, Unit::DirectMultiplyAdd, 2.0 * steps * sums, Place::MarchOnAll);
            self.hold("weights and forces of the past", 24.0 * sums);
            return;
        }
        self.poles = poles;
        self.count(Counter::Poles, poles);
        // A fit of 512 elements is one of 257 sums; a single wave takes a quarter of that (measured).
        self.add(Stage::Fit, Unit::Fit, 0.25 * waves / 257.0, Place::BeforeOnAll);
        self.fit_memory_per_thread = expected_fit::BYTES;
        // Waves of odd and of even number.
        self.fit_memory = 2.0 * WAVE_BYTES * wave_count(&scene.tyre, scene.numerics.influence_tolerance);
        let recursion = expected_multiply_adds(rule, STEPS, waves as usize, poles);
        self.add(Stage::History, Unit::PoleMultiplyAdd, steps * recursion, Place::MarchOnAll);
    }
}
