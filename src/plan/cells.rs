//! Numbers of contact over cells.

use std::f64::consts::{PI, TAU};

use super::Plan;
use super::amounts::{Amounts, Place};
use super::unit::Unit;
use crate::contact::cells::SINGLE;
use crate::contact::cells::past::STEPS;
use crate::contact::friction::wave_group::STEPS as TRACTION_STEPS;
use crate::contact::history::expected_multiply_adds;
use crate::counters::{Counter, Stage};
use crate::numeric::transform_multiply_adds;
use crate::scene::{History, Sides, Tyre};
use crate::tyre::influence::{CellGrid, CellTruncation, WaveBand, wave_bytes};
use crate::tyre::poles::cells::CellFitOptions;
use crate::tyre::poles::expected_fit;

/// Wavenumbers times the tread's thickness between which waves are handed from the tyre's ring to a shorter one.
const HANDED_OVER: [f64; 2] = [3.0, 6.0];
/// Those between which lateral numbers that are the same on cells begin to be taken together.
const FOLDED: [f64; 2] = [6.0, 12.0];
/// Part of the window that a shorter ring has room for contact in, at least, and that a cell is remembered for: the
/// window has room for the chord of a rigid tyre at the deepest position of the axle over the highest stone, and no
/// patch is as long (100 of 150 columns on a chip seal). Where one is, the window is widened.
const PATCH: f64 = 0.68;
/// Blocks that forces are forgotten late.
const LATE: usize = 2;
/// How far the window stays away from what it has left behind on a shorter ring, in the longest waves on it over 2 pi:
/// of that only what creeps back slowly is left.
const CREEPING: f64 = 3.5;
/// How far a side has to be from its image in the strip's edge, in the same measure, to be moved by half a cell.
const FAR_SIDES: f64 = 10.0;

/// Residuals of the search for cells are no smaller than this part of the largest required displacement: its steps are
/// taken in single precision, and each round that brings the exact residual down costs as much as the first.
const LEAST_TOLERANCE: f64 = 3e-10;
/// Forces with friction are no exacter than this part of the largest.
const LEAST_FRICTION_TOLERANCE: f64 = 1e-9;
/// Products of all components, each as nine single ones, that the search with friction takes for an instant, and
/// transforms of its past beside those of normal forces (measured).
const FRICTION_PRODUCTS: f64 = 15.0;
const FRICTION_TRANSFORMS: f64 = 3.0;
/// Parts of the past with friction: pairs of components, of a tyre that turns each twice.
const FRICTION_PARTS: f64 = 9.0;
/// Part of all waves that shorter rings may have of them to be worth the ways between cells and waves (measured: 0.6 at
/// 256 x 16 cells is not, 0.3 at 512 x 16 is).
const FRICTION_RINGS: f64 = 0.5;
/// Channels of the past with friction for a pole of normal forces, multiply-adds of one of them beside one of those,
/// and the time of a wave's fit beside one of normal forces (measured, 256 x 16).
const FRICTION_CHANNELS: f64 = 4.7;
const FRICTION_CHANNEL: f64 = 0.7;
const FRICTION_FIT: f64 = 10.0;
/// Tolerance of fewer poles relative to that of the fit.
const FEWER_POLES: f64 = 1.0;
/// Poles of a wave, conjugates counted, at a tolerance of 1e-5, and how many less for each factor of ten above it
/// (measured, N = 256 to 1024).
const POLES: [f64; 2] = [32.0, 5.0];
/// Bytes of a pole, conjugates counted, and more of them for each stage of a step: its model, coefficients and states,
/// and what making them takes (measured, N = 512 to 2048).
const POLE_BYTES: [f64; 2] = [90.0, 130.0];
/// Bytes of a pole's odd part, conjugates counted: its residue and the ratio of both.
const ODD_POLE_BYTES: f64 = 16.0;
/// Products in single precision that the search for an instant takes, with what goes with them (measured).
const PRODUCTS: f64 = 16.0;

impl Plan {
    /// Returns the height of the tread above its middle, at a distance from there \[m\].
    pub(crate) fn crown(&self, from_middle: f64) -> f64 {
        self.scene.tyre.crown_radius.map_or(0.0, |radius| from_middle * from_middle / (2.0 * radius))
    }

    /// Returns the columns at either end by which the window of cells is longer than what the run tells, which has so
    /// many.
    pub(crate) fn window_margin(&self, columns: usize) -> usize {
        let margin = (0.5 * (self.window - 1.0) * columns as f64).ceil() as usize;
        margin.min((self.scene.numerics.elements - columns) / 2)
    }

    /// Returns the bands of waves that carry the past of cells, seen through a window of so many columns. Finite sums
    /// are kept whole.
    pub(crate) fn wave_bands(&self, columns: usize) -> Vec<WaveBand> {
        let numerics = &self.scene.numerics;
        let finite = numerics.lateral_terms.is_some() || numerics.wavenumber_aliases.is_some();
        let band = |part, fades_in, fades_out| WaveBand { part, fades_in, fades_out, folded: false };
        let borders = self.border(HANDED_OVER).zip(self.border(FOLDED)).filter(|_| !finite);
        let Some((longer, shorter)) = borders else { return vec![WaveBand::WHOLE] };
        let least = (PATCH * columns as f64).ceil() as usize;
        let whole_rings = (1..=numerics.elements).filter(|part| numerics.elements.is_multiple_of(2 * part));
        let has_room = |part: &usize| self.longest_patch(numerics.elements / part, longer[0]) >= least;
        let part = whole_rings.filter(has_room).max().unwrap_or(1);
        let mut bands = vec![WaveBand::WHOLE];
        if part > 1 {
            bands = vec![band(1, None, Some(longer)), band(part, Some(longer), None)];
        }
        let beside = self.scene.tyre.width - self.scene.tyre.contact_width;
        let alone = match self.scene.has_tractions() {
            // Sines of lateral motion have each a mean of its own.
            true => self.decisions.tyre.sides == Sides::Guided,
            // The power of single waves is that of the tyre's own.
            false => self.scene.outputs.vibration.is_some(),
        };
        if shorter[0] * beside > FAR_SIDES && !alone {
            let last = bands.pop().unwrap_or(WaveBand::WHOLE);
            bands.push(WaveBand { fades_out: Some(shorter), ..last });
            bands.push(WaveBand { folded: true, ..band(part, Some(shorter), None) });
        }
        if self.scene.has_tractions() {
            // To see a window from several rings takes as long as many waves of one.
            let waves = |bands: &[WaveBand]| self.expected_waves_of(bands, columns)[0];
            if waves(&bands) > FRICTION_RINGS * waves(&[WaveBand::WHOLE]) {
                return vec![WaveBand::WHOLE];
            }
        }
        bands
    }

    /// Returns the wavenumbers of a border that is told times the tread's thickness; `None` without layers.
    fn border(&self, times_thickness: [f64; 2]) -> Option<[f64; 2]> {
        self.scene.tyre.layers.last().map(|tread| times_thickness.map(|kh| kh / tread.thickness))
    }

    /// Returns the cells that a window stays away from what it has left behind, in waves of this wavenumber and shorter
    /// ones.
    fn creeping(&self, wavenumber: f64) -> usize {
        (CREEPING / wavenumber / self.element).ceil() as usize
    }

    /// Returns the columns of contact that a shorter ring of so many has room for, with waves from a wavenumber on: for
    /// the contact and what it moves on either side, and for as much that is remembered.
    fn longest_patch(&self, ring: usize, wavenumber: f64) -> usize {
        ring.saturating_sub(3 * self.creeping(wavenumber) + self.late_steps()) / 2
    }

    /// Returns the steps that forces are forgotten late, since their poles are gone through block by block.
    fn late_steps(&self) -> usize {
        LATE * if self.scene.has_tractions() { TRACTION_STEPS } else { STEPS }
    }

    /// Returns the columns about the contact in which a band is seen, of a window of so many: short waves are gone
    /// elsewhere.
    pub(crate) fn seen_columns(&self, band: WaveBand, columns: usize) -> usize {
        let Some([longest, _]) = self.border(HANDED_OVER).filter(|_| band.part > 1) else { return columns };
        let patch = self.longest_patch(self.scene.numerics.elements / band.part, longest);
        columns.min(patch + 2 * self.creeping(longest))
    }

    /// Returns the number of steps after which a band forgets forces, seen through a window of so many columns: before
    /// the window comes back to their place on the ring. `None`: there is nothing else on the ring but what is on the
    /// tyre.
    pub(crate) fn forgotten_after(&self, band: WaveBand, columns: usize) -> Option<usize> {
        let [start, _] = band.fades_in.filter(|_| band.part > 1)?;
        let seen = self.seen_columns(band, columns);
        let cells = self.scene.numerics.elements / band.part - seen - self.creeping(start);
        let steps = (cells as f64 * self.element / (self.speed * self.time_step)) as usize;
        Some(steps.saturating_sub(self.late_steps()))
    }

    /// Returns the tyre as a band takes it: for one that is folded its sides are moved by at most half a cell, which
    /// waves as short as that do not feel.
    pub(crate) fn tyre_of(&self, band: WaveBand) -> Tyre {
        let width = if band.folded { self.cell_grid().width_in_cells() } else { self.decisions.tyre.width };
        Tyre { width, ..self.decisions.tyre.clone() }
    }

    /// Returns the cells round the tyre and across its strip.
    pub(crate) fn cell_grid(&self) -> CellGrid {
        let across = self.decisions.cells_across.unwrap_or(1);
        CellGrid::new(&self.decisions.tyre, self.scene.numerics.elements, across)
    }

    /// Tells how far their sums go.
    pub(crate) fn cell_truncation(&self) -> CellTruncation {
        let numerics = &self.scene.numerics;
        CellTruncation { lateral_terms: numerics.lateral_terms, aliases: numerics.wavenumber_aliases }
    }

    /// Tells how far a cell may be from where it is required to be, relative to the largest required displacement.
    pub(crate) fn cell_tolerance(&self) -> f64 {
        self.scene.numerics.contact_tolerance.max(LEAST_TOLERANCE)
    }

    /// Tells how far forces of cells with friction may be off, relative to the largest one.
    pub(crate) fn friction_tolerance(&self) -> f64 {
        self.scene.numerics.contact_tolerance.max(LEAST_FRICTION_TOLERANCE)
    }

    /// Tells whether the tolerance of the contact conditions lets the past of cells be carried in single precision.
    pub(crate) fn is_single(&self) -> bool {
        self.cell_tolerance() >= SINGLE
    }

    /// Returns the tolerance to which fewer poles foretell the past of cells, relative to each wave's influence;
    /// `None`: all do.
    pub(crate) fn fewer_poles(&self) -> Option<f64> {
        self.is_single().then_some(FEWER_POLES * self.fit.tolerance)
    }

    /// Returns the waves that a window of so many columns is expected to need, the multiply-adds of their transforms,
    /// there and back, for an instant, and the forces that are remembered of all waves at one stage of their steps.
    /// They are not listed: there may be more than a machine can hold.
    pub(crate) fn expected_waves(&self, columns: f64) -> [f64; 3] {
        self.expected_waves_of(&self.wave_bands(columns as usize), columns as usize)
    }

    /// Returns the same of some bands.
    fn expected_waves_of(&self, bands: &[WaveBand], columns: usize) -> [f64; 3] {
        let grid = self.cell_grid();
        let waves = grid.waves();
        let mut expected = [0.0; 3];
        for &band in bands {
            let ring = grid.elements() / band.part;
            let around = (ring / 2 + 1) as f64;
            // What a band takes up of the rectangle of all numbers: a quarter of a disc, less the one that fades in.
            let rows = if band.folded { waves.width / grid.pitch() } else { self.last_lateral_number() as f64 };
            let disc =
                |end: f64| 0.25 * PI * rows.min(end / waves.ky(1)) * around.min(end / (band.part as f64 * waves.kx(1)));
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

    /// Returns the largest lateral number of the waves that carry the past.
    pub(crate) fn last_lateral_number(&self) -> usize {
        let grid = self.cell_grid();
        let highest = TAU / grid.length().min(grid.pitch());
        self.cell_truncation().lateral_terms.unwrap_or((highest / grid.waves().ky(1)) as usize)
    }

    /// Returns the poles that one of them is expected to have, conjugates counted.
    pub(crate) fn expected_poles_of_wave(&self) -> f64 {
        POLES[0] - POLES[1] * (self.fit.tolerance / 1e-5).log10()
    }

    /// Returns the requirements of the fits of the waves.
    pub(crate) fn cell_fit(&self) -> CellFitOptions {
        CellFitOptions { top: self.fit.top, tolerance: self.fit.tolerance, most_poles: self.fit.most_poles }
    }
}

impl Amounts {
    /// Adds the past of cells, and the search for those in contact.
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
        let poles = channels * plan.expected_poles_of_wave() * waves;
        let turns = plan.decisions.tyre.turns();
        let (odd_bytes, parts) = if turns { (ODD_POLE_BYTES, 2.0) } else { (0.0, 1.0) };
        self.add(Stage::Axle, Unit::SearchMultiplyAdd, 30.0 * search, Place::Before);
        self.add(Stage::Penetration, Unit::LevelColumn, instants * cells, Place::March);
        self.add(Stage::ActiveSet, Unit::TransformMultiplyAdd, instants * search, Place::March);
        self.add(Stage::History, Unit::TransformMultiplyAdd, instants * transforms, Place::March);
        self.count(Counter::Steps, steps);
        // Forces and displacements of two blocks, the first weights of their instants, and what is not yet forgotten.
        let block = waves * STEPS as f64 * stages * (64.0 + 16.0 * parts * stages) + 8.0 * stages * remembered;
        let of_poles = (POLE_BYTES[0] + odd_bytes + POLE_BYTES[1] * stages) * poles;
        self.hold("poles, states and fields of the cells", of_poles + block + 8.0 * cells * 40.0);
        if scene.numerics.history == History::Direct {
            let pairs = if has_tractions { FRICTION_PARTS } else { 1.0 };
            let sums = pairs * plan.lags as f64 * waves * stages * stages;
            self.add(Stage::Influence, Unit::Evaluation, 2.0 * sums, Place::BeforeOnAll);
            self.add(Stage::History, Unit::DirectMultiplyAdd, 2.0 * parts * steps * sums, Place::MarchOnAll);
            self.hold("weights and forces of the past", (16.0 + 8.0 * parts) * sums);
            return;
        }
        self.poles = poles;
        self.count(Counter::Poles, poles);
        // A fit of 512 elements is one of 257 sums; a single wave takes a quarter of that (measured, flat and at rest;
        // it is taken to grow with the tyre's shape, turning and layers and with the tolerance as sums do).
        let fit = if has_tractions { FRICTION_FIT } else { 1.0 };
        let growth = expected_fit::growth(plan.fit.tolerance, &plan.decisions.tyre);
        self.add(Stage::Fit, Unit::Fit, 0.25 * fit * growth * waves / 257.0, Place::BeforeOnAll);
        self.fit_memory_per_thread = expected_fit::BYTES;
        // Waves of odd and of even number.
        self.fit_memory = 2.0 * wave_bytes(&plan.decisions.tyre, scene.numerics.influence_tolerance);
        let recursion = expected_multiply_adds(rule, STEPS, waves as usize, poles, turns);
        let (recursion, place) =
            if has_tractions { (FRICTION_CHANNEL * recursion, Place::MarchOnAll) } else { (recursion, Place::Behind) };
        self.add(Stage::History, Unit::PoleMultiplyAdd, steps * recursion, place);
    }
}
