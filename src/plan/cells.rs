//! Sizes and tolerances of contact over cells.

use std::f64::consts::{PI, TAU};

use super::Plan;
use super::amounts::{Amounts, WorkPlace};
use super::unit::WorkUnit;
use crate::contact::cells::SINGLE;
use crate::contact::cells::history::STEPS;
use crate::contact::friction::wave_group::STEPS as TRACTION_STEPS;
use crate::contact::history::expected_multiply_adds;
use crate::counters::{Counter, Stage};
use crate::numeric::{transform_length, transform_multiply_adds};
use crate::scene::{History, Sides, Tyre};
use crate::tyre::influence::{CellGrid, CellTruncation, WaveBand, wave_bytes};
use crate::tyre::poles::cells::CellFitOptions;
use crate::tyre::poles::expected_fit;
use crate::tyre::poles::pole_model::PoleModel;
use crate::tyre::poles::traction_model::TractionModel;

/// Wavenumber times thickness of the tread: in this range waves cross-fade from the tyre's ring to a shorter one.
const HANDED_OVER: [f64; 2] = [3.0, 6.0];
/// The range in which waves cross-fade to those whose lateral numbers, equal on cells, are summed together.
const FOLDED: [f64; 2] = [6.0, 12.0];
/// Least part of the window that a shorter ring has room for as contact, and for which a cell is remembered: the window
/// has room for the chord of a rigid tyre at the deepest position of the axle over the highest stone, and no patch is
/// as long (100 of 150 columns on a chip seal). Where one is, the window is widened.
const PATCH: f64 = 0.68;
/// Delay of the forgetting of forces, in blocks.
const LATE: usize = 2;
/// Distance of the window from forces behind it on a shorter ring, in units of the longest wave there over 2 pi: beyond
/// it only slowly creeping remainders are left.
const CREEPING: f64 = 3.5;
/// Least distance of a side from its image in the strip's edge, in the same unit, for it to be moved by half a cell.
const FAR_SIDES: f64 = 10.0;

/// Smallest residual of the search for cells, relative to the largest required displacement: its steps are in single
/// precision, and each round that lowers the exact residual costs as much as the first.
const LEAST_TOLERANCE: f64 = 3e-10;
/// Smallest error of forces with friction, relative to the largest.
const LEAST_FRICTION_TOLERANCE: f64 = 1e-9;
/// Products of all components, each as nine single ones, in the search with friction for an instant, and transforms of
/// its history relative to those of normal forces (measured).
const FRICTION_PRODUCTS: f64 = 15.0;
const FRICTION_TRANSFORMS: f64 = 3.0;
/// Parts of the history with friction: pairs of components; twice as many if the tyre rotates.
const FRICTION_PARTS: f64 = 9.0;
/// Largest share of all waves for which shorter rings are faster with friction, the transforms between cells and waves
/// included (measured: 0.6 at 256 x 16 cells is too much, 0.3 at 512 x 16 is not).
const FRICTION_RINGS: f64 = 0.5;
/// Channels of the history with friction for a pole of normal forces, multiply-adds of one of them relative to those,
/// and time of a wave's fit relative to one of normal forces (measured, 256 x 16).
const FRICTION_CHANNELS: f64 = 4.7;
const FRICTION_CHANNEL: f64 = 0.7;
const FRICTION_FIT: f64 = 10.0;
/// Tolerance of the reduced set of poles relative to that of the fit.
const FEWER_POLES: f64 = 1.0;
/// Bytes on disk of that set relative to those of the fit (measured).
const FEWER_BYTES: f64 = 0.5;
/// Poles of a wave, counting conjugates, at a tolerance of 1e-5, and the decrease for each factor of ten above it
/// (measured, N = 256 to 1024).
const POLES: [f64; 2] = [32.0, 5.0];
/// Bytes of a pole, counting conjugates, and more for each stage of a step: its model, coefficients and states, and
/// temporaries (measured, N = 512 to 2048).
const POLE_BYTES: [f64; 2] = [90.0, 130.0];
/// Bytes of a pole's odd part, counting conjugates: its residue and the ratio of both.
const ODD_POLE_BYTES: f64 = 16.0;
/// Products in single precision in the search for an instant, with the work around them (measured).
const PRODUCTS: f64 = 16.0;

impl Plan {
    /// Height of the tread's surface above its middle, at a distance from there \[m\].
    #[doc(hidden)]
    pub fn crown(&self, from_middle: f64) -> f64 {
        self.scene.tyre.crown_radius.map_or(0.0, |radius| from_middle * from_middle / (2.0 * radius))
    }

    /// Columns that the window of cells has beyond each end of the reported one of `columns` columns.
    pub(crate) fn window_margin(&self, columns: usize) -> usize {
        let margin = (0.5 * (self.window - 1.0) * columns as f64).ceil() as usize;
        margin.min((self.scene.numerics.elements - columns) / 2)
    }

    /// Bands of waves that carry the history of cells, seen through a window of `columns` columns. Truncated sums are
    /// not split into bands.
    pub(crate) fn wave_bands(&self, columns: usize) -> Vec<WaveBand> {
        let numerics = &self.scene.numerics;
        let finite = numerics.lateral_terms.is_some() || numerics.wavenumber_aliases.is_some();
        let band = |ring, fades_in, fades_out| WaveBand { ring, fades_in, fades_out, folded: false };
        let borders = self.border(HANDED_OVER).zip(self.border(FOLDED)).filter(|_| !finite);
        let Some((longer, shorter)) = borders else { return vec![WaveBand::WHOLE] };
        let least = 2 * (PATCH * columns as f64).ceil() as usize + self.beside_patch(longer[0]);
        // Power is found for each of the tyre's own waves, which only a ring of a whole part of its elements has.
        let has_own = |ring: &usize| !self.decisions.takes_models || numerics.elements.is_multiple_of(*ring);
        let ring = (least..numerics.elements).find(|ring| transform_length(*ring) == *ring && has_own(ring));
        let mut bands = vec![WaveBand::WHOLE];
        if ring.is_some() {
            bands = vec![band(None, None, Some(longer)), band(ring, Some(longer), None)];
        }
        let beside = self.scene.tyre.width - self.scene.tyre.contact_width;
        let alone = match self.scene.has_tractions() {
            // Each sine of lateral motion has a separate mean.
            true => self.decisions.tyre.sides == Sides::Guided,
            // The power of single waves has to be that of the tyre itself.
            false => self.scene.outputs.vibration.is_some(),
        };
        if shorter[0] * beside > FAR_SIDES && !alone {
            let last = bands.pop().unwrap_or(WaveBand::WHOLE);
            bands.push(WaveBand { fades_out: Some(shorter), ..last });
            bands.push(WaveBand { folded: true, ..band(ring, Some(shorter), None) });
        }
        if self.scene.has_tractions() {
            // A window on several rings costs as much as many waves of one.
            let waves = |bands: &[WaveBand]| self.expected_waves_of(bands, columns)[0];
            if waves(&bands) > FRICTION_RINGS * waves(&[WaveBand::WHOLE]) {
                return vec![WaveBand::WHOLE];
            }
        }
        bands
    }

    /// Wavenumbers \[1/m\] of a border given in units of the tread's thickness; `None` without layers.
    fn border(&self, times_thickness: [f64; 2]) -> Option<[f64; 2]> {
        self.scene.tyre.layers.last().map(|tread| times_thickness.map(|kh| kh / tread.thickness))
    }

    /// Cells between the window and forces behind it, for waves of this wavenumber \[1/m\] and shorter ones.
    fn creeping(&self, wavenumber: f64) -> usize {
        (CREEPING / wavenumber / self.element).ceil() as usize
    }

    /// Cells of a shorter ring, for waves from a wavenumber on, beside the contact and as much that is remembered: the
    /// contact's surroundings on either side among them.
    fn beside_patch(&self, wavenumber: f64) -> usize {
        3 * self.creeping(wavenumber) + self.late_steps() * self.scene.numerics.elements_per_step
    }

    /// Delay of the forgetting of forces in steps, since the recursion advances its poles block by block.
    fn late_steps(&self) -> usize {
        LATE * if self.scene.has_tractions() { TRACTION_STEPS } else { STEPS }
    }

    /// Columns around the contact in which a band is evaluated, for a window of `columns` columns: short waves have
    /// decayed elsewhere.
    pub(crate) fn seen_columns(&self, band: WaveBand, columns: usize) -> usize {
        let Some((ring, [longest, _])) = band.ring.zip(self.border(HANDED_OVER)) else { return columns };
        columns.min(ring.saturating_sub(self.beside_patch(longest)) / 2 + 2 * self.creeping(longest))
    }

    /// Number of steps after which a band forgets forces, seen through a window of `columns` columns: before the window
    /// returns to their place on the ring. `None` for a ring as long as the tyre.
    pub(crate) fn forgotten_after(&self, band: WaveBand, columns: usize) -> Option<usize> {
        let (ring, [start, _]) = band.ring.zip(band.fades_in)?;
        let cells = ring - self.seen_columns(band, columns) - self.creeping(start);
        let steps = (cells as f64 * self.element / (self.speed * self.time_step)) as usize;
        Some(steps.saturating_sub(self.late_steps()))
    }

    /// The tyre as a band sees it: for a folded band its sides are moved by at most half a cell, which such short waves
    /// do not notice.
    pub(crate) fn tyre_of(&self, band: WaveBand) -> Tyre {
        let width = if band.folded { self.cell_grid().width_in_cells() } else { self.decisions.tyre.width };
        Tyre { width, ..self.decisions.tyre.clone() }
    }

    /// Cells around a band's ring and across the strip.
    pub(crate) fn grid_of(&self, band: WaveBand) -> CellGrid {
        CellGrid::new(&self.tyre_of(band), self.scene.numerics.elements, self.cell_grid().across).on_ring(band.ring)
    }

    /// Cells around the tyre and across its strip.
    pub(crate) fn cell_grid(&self) -> CellGrid {
        let across = self.decisions.cells_across.unwrap_or(1);
        CellGrid::new(&self.decisions.tyre, self.scene.numerics.elements, across)
    }

    pub(crate) fn cell_truncation(&self) -> CellTruncation {
        let numerics = &self.scene.numerics;
        CellTruncation { lateral_terms: numerics.lateral_terms, aliases: numerics.wavenumber_aliases }
    }

    /// Tolerance of a cell's displacement, relative to the largest required displacement.
    pub(crate) fn cell_tolerance(&self) -> f64 {
        self.scene.numerics.contact_tolerance.max(LEAST_TOLERANCE)
    }

    /// Tolerance of the forces of cells with friction, relative to the largest one.
    pub(crate) fn friction_tolerance(&self) -> f64 {
        self.scene.numerics.contact_tolerance.max(LEAST_FRICTION_TOLERANCE)
    }

    /// True if the tolerance of the contact conditions permits single precision for the history by poles.
    pub(crate) fn is_single(&self) -> bool {
        self.cell_tolerance() >= SINGLE
    }

    /// Tolerance of the reduced set of poles that predicts the history of cells, relative to each wave's influence;
    /// `None` if all poles do.
    pub(crate) fn fewer_poles(&self) -> Option<f64> {
        self.is_single().then_some(FEWER_POLES * self.fit.tolerance)
    }

    /// Expected values for a window of `columns` columns: number of waves, multiply-adds of their transforms there and
    /// back for an instant, and number of remembered forces of all waves at one stage of their steps. The waves are not
    /// listed: they might not fit into memory.
    pub(crate) fn expected_waves(&self, columns: f64) -> [f64; 3] {
        self.expected_waves_of(&self.wave_bands(columns as usize), columns as usize)
    }

    /// The same for some bands.
    fn expected_waves_of(&self, bands: &[WaveBand], columns: usize) -> [f64; 3] {
        let mut expected = [0.0; 3];
        for &band in bands {
            let grid = self.grid_of(band);
            let (ring, waves) = (grid.elements(), grid.waves());
            let around = (ring / 2 + 1) as f64;
            // Share of the rectangle of all wavenumbers: a quarter of a disc, less the one of the band before.
            let rows = if band.folded { waves.width / grid.pitch() } else { self.last_lateral_number() as f64 };
            let disc = |end: f64| 0.25 * PI * rows.min(end / waves.ky(1)) * around.min(end / waves.kx(1));
            let inner = band.fades_in.map_or(0.0, |[start, _]| disc(start));
            let rows = band.fades_out.map_or(rows, |[_, end]| rows.min(end / waves.ky(1)));
            let count = band.fades_out.map_or(rows * around, |[_, end]| disc(end)) - inner;
            expected[0] += count;
            // A transform along for each lateral number, a product across by halves.
            let seen = self.seen_columns(band, columns) * grid.across;
            expected[1] += rows * (transform_multiply_adds(ring) + seen as f64);
            expected[2] += count * self.forgotten_after(band, columns).unwrap_or(0) as f64;
        }
        expected
    }

    /// Largest lateral number of the waves that carry the history.
    pub(crate) fn last_lateral_number(&self) -> usize {
        let grid = self.cell_grid();
        let highest = TAU / grid.length().min(grid.pitch());
        self.cell_truncation().lateral_terms.unwrap_or((highest / grid.waves().ky(1)) as usize)
    }

    /// Expected number of poles of a wave, counting conjugates.
    pub(crate) fn expected_poles_of_wave(&self) -> f64 {
        POLES[0] - POLES[1] * (self.fit.tolerance / 1e-5).log10()
    }

    /// Requirements of the fits of the waves.
    pub(crate) fn cell_fit(&self) -> CellFitOptions {
        CellFitOptions { top: self.fit.top, tolerance: self.fit.tolerance, most_poles: self.fit.most_poles }
    }
}

impl Amounts {
    /// Adds the history of cells, and the search for those in contact.
    pub(super) fn cells(&mut self, plan: &Plan) {
        let Plan { scene, .. } = plan;
        let (rule, steps) = (scene.numerics.time_rule, plan.steps as f64);
        let stages = rule.stages() as f64;
        let instants = steps * stages;
        let [waves, transforms, remembered] = plan.expected_waves(self.expected.columns);
        let cells = self.expected.columns * plan.cell_grid().across as f64;
        let has_tractions = scene.has_tractions();
        let products = if has_tractions { FRICTION_TRANSFORMS * FRICTION_PRODUCTS } else { PRODUCTS };
        let search = products * transform_multiply_adds(4 * cells as usize);
        let transforms = if has_tractions { FRICTION_TRANSFORMS * transforms } else { transforms };
        let channels = if has_tractions { FRICTION_CHANNELS } else { 1.0 };
        let cached = plan.cached_cell_poles;
        let poles = cached.map_or_else(|| channels * plan.expected_poles_of_wave() * waves, |cached| cached as f64);
        let turns = plan.decisions.tyre.turns();
        let (odd_bytes, parts) = if turns { (ODD_POLE_BYTES, 2.0) } else { (0.0, 1.0) };
        self.add(Stage::Axle, WorkUnit::SearchMultiplyAdd, 30.0 * search, WorkPlace::Before);
        self.add(Stage::Penetration, WorkUnit::LevelColumn, instants * cells, WorkPlace::March);
        self.add(Stage::ActiveSet, WorkUnit::TransformMultiplyAdd, instants * search, WorkPlace::March);
        self.add(Stage::History, WorkUnit::TransformMultiplyAdd, instants * transforms, WorkPlace::March);
        self.count(Counter::Steps, steps);
        // Forces and displacements of two blocks, the first weights of their instants, and forces that are not
        // forgotten yet.
        let block = waves * STEPS as f64 * stages * (64.0 + 16.0 * parts * stages) + 8.0 * stages * remembered;
        let of_poles = (POLE_BYTES[0] + odd_bytes + POLE_BYTES[1] * stages) * poles;
        self.hold("poles, states and fields of the cells", of_poles + block + 8.0 * cells * 40.0);
        if scene.numerics.history == History::Direct {
            let pairs = if has_tractions { FRICTION_PARTS } else { 1.0 };
            let sums = pairs * plan.lags as f64 * waves * stages * stages;
            self.add(Stage::Influence, WorkUnit::Evaluation, 2.0 * sums, WorkPlace::BeforeOnAll);
            self.add(Stage::History, WorkUnit::DirectMultiplyAdd, 2.0 * parts * steps * sums, WorkPlace::MarchOnAll);
            self.hold("weights and forces of the history", (16.0 + 8.0 * parts) * sums);
            return;
        }
        self.poles = poles;
        self.count(Counter::Poles, poles);
        if cached.is_none() {
            // A fit of 512 elements is one of 257 sums; a single wave takes a quarter of that (measured, flat and at
            // rest; it is taken to grow with the tyre's shape, turning and layers and with the tolerance as sums do).
            let fit = if has_tractions { FRICTION_FIT } else { 1.0 };
            let growth = expected_fit::growth(plan.fit.tolerance, &plan.decisions.tyre);
            self.add(Stage::Fit, WorkUnit::Fit, 0.25 * fit * growth * waves / 257.0, WorkPlace::BeforeOnAll);
            self.fit_memory_per_thread = expected_fit::BYTES;
            let of_pole =
                if has_tractions { TractionModel::BYTES_OF_CHANNEL } else { PoleModel::bytes_of_pole(1, turns) };
            let fewer = if has_tractions || plan.fewer_poles().is_none() { 0.0 } else { FEWER_BYTES };
            self.cache_bytes += (1.0 + fewer) * poles * of_pole;
        }
        // Waves of odd and of even number.
        self.fit_memory = 2.0 * wave_bytes(&plan.decisions.tyre, scene.numerics.influence_tolerance);
        let recursion = expected_multiply_adds(rule, STEPS, waves as usize, poles, turns);
        let (recursion, place) = if has_tractions {
            (FRICTION_CHANNEL * recursion, WorkPlace::MarchOnAll)
        } else {
            (recursion, WorkPlace::Background)
        };
        self.add(Stage::History, WorkUnit::PoleMultiplyAdd, steps * recursion, place);
    }
}
