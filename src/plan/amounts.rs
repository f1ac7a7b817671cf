//! Work of each stage of a run, and the memory that it holds: formulas in the sizes of the scene, before any of it is
//! done.
//!
//! Solvers state their work for given sizes (`expected` beside their code); here are the sizes. Quantities that only
//! the run determines are estimated: the length of the patch from a static solution with a few hundred elements, the
//! poles of a fit that is not in the cache from those of the default tyre.

use serde::Serialize;

use crate::contact::complementarity::{ActiveSet, LocalSet, largest_memory};
use crate::contact::history::ModalHistory;
use crate::contact::pressed::strip::block_elements;
use crate::counters::{Counter, Stage};
use crate::numeric::transform_multiply_adds;
use crate::plan::Plan;
use crate::plan::decisions::Decisions;
use crate::plan::smooth_contact::Expected;
use crate::plan::unit::WorkUnit;
use crate::road::Lattice;
use crate::road::ahead::CHUNK_ROWS;
use crate::road::sources::grid_stream::LONG_GRID;
use crate::road::sources::made::{Sizes, TargetSpectrum};
use crate::scene::{History, Road, Scene, SliceCoupling, Slices, Tread, Zone};
use crate::tyre::influence::convolution_quadrature::ContourCircle;
use crate::tyre::influence::{InfluenceSum, steep_bytes, wave_bytes, wave_count};
use crate::tyre::layers::surface_asymptote::{LARGEST_ARGUMENT, thickness_limit};
use crate::tyre::poles::expected_fit;
use crate::tyre::poles::pole_model::PoleModel;

/// Most bytes of freed pages that the allocator keeps: up to 3e6 more were seen beside other programs (measured).
const ALLOCATOR_BYTES: f64 = 4e6;
/// Bytes that the allocator keeps for each thread that generates texture (measured).
const THREAD_BYTES: f64 = 8e6;
/// Memory of a texture over that of its arrays: the allocator keeps smaller arrays freed before (measured).
const TEXTURE_RESERVE: f64 = 1.6;
/// Bytes in memory for a byte of a measured road's file while it is read whole (measured: grids of single precision
/// 5.9, profiles of 16 bytes a line 3.9).
const READING: f64 = 6.5;
/// Memory of a grid that is read in pieces (measured: 118 MB).
const PIECES_BYTES: f64 = 1.3e8;
/// Arrays of the streamed spectrum, in lengths of a segment.
const SPECTRUM_ARRAYS: f64 = 8.0;
/// Products with the influence between the cells of a block of pressed road for all of its approaches, with the work
/// around them: an estimate from the products of some blocks.
const PRESSED_PRODUCTS: f64 = 300.0;
/// Bytes of a block of pressed road per cell: tables of products of many lengths, forces, displacements: an estimate
/// from the memory of runs with N = 256 to 1024.
const PRESSED_CELL_BYTES: f64 = 1200.0;

/// Place of work in the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WorkPlace {
    /// On one thread, before the steps.
    Before,
    /// On all threads, before the steps.
    BeforeOnAll,
    /// In the steps, on the marching thread.
    March,
    /// In the steps, on all threads.
    MarchOnAll,
    /// Beside the steps, on the threads that they leave free.
    #[serde(rename = "behind")]
    Background,
}

/// Work of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Amount {
    /// The stage that does it.
    pub stage: Stage,
    /// Unit of the amount.
    pub unit: WorkUnit,
    /// Number of units.
    pub amount: f64,
    /// On which threads, and when.
    pub place: WorkPlace,
}

/// Work and memory of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Amounts {
    /// Contact on a smooth road.
    pub expected: Expected,
    /// Number of poles of the model, counting conjugates; 0 without one.
    pub poles: f64,
    /// Work by stage, in the order of the computation.
    pub work: Vec<Amount>,
    /// Expected values of the exact counters.
    pub counters: Vec<(Counter, f64)>,
    /// Memory by its holder \[bytes\].
    pub memory: Vec<(&'static str, f64)>,
    /// Additional memory for each thread in the steps \[bytes\].
    pub memory_per_thread: f64,
    /// Additional memory for each thread in the fit, which ends before the steps \[bytes\].
    pub fit_memory_per_thread: f64,
    /// Memory of the kernel at the points of the fit, or of the contour of a direct history with its weights, and of
    /// the waves of a curved tyre \[bytes\].
    pub fit_memory: f64,
    /// Memory that is allocated during the fit and held in the steps, included in [`Self::memory`] \[bytes\].
    pub fit_memory_that_stays: f64,
    /// Memory of each segment of the run while it is rolled \[bytes\], and how many are rolled at once.
    #[serde(skip)]
    pub(crate) memory_per_segment: f64,
    #[serde(skip)]
    pub(crate) segments_at_once: usize,
    /// Runs that are over before this one begins.
    #[serde(skip)]
    pub(crate) before: Vec<Self>,
    /// Result arrays \[bytes\].
    pub result_bytes: f64,
    /// Models, waves and transfers that the run leaves in the cache \[bytes\].
    pub cache_bytes: f64,
    /// Most blocks of the sound's forces that wait in memory; 0 without sound.
    pub(crate) waiting_blocks: usize,
}

impl Amounts {
    /// Work and memory of the physics.
    pub(crate) fn of_physics(plan: &Plan) -> Self {
        let scene = &plan.scene;
        let mut amounts = Self { expected: plan.expected(), ..Self::default() };
        amounts.hold("freed pages that the allocator keeps", ALLOCATOR_BYTES);
        if plan.needs_model() {
            amounts.model(plan);
        }
        match (plan.decisions.zone, scene.numerics.history) {
            (Zone::Slices, History::Direct) => amounts.direct(scene, plan),
            (Zone::Slices, History::Modal) => amounts.modal(scene, plan),
            (Zone::Cells, _) => amounts.cells(plan),
        }
        amounts.road(scene, plan);
        if plan.decisions.zone == Zone::Slices {
            amounts.contact(scene, plan);
        }
        amounts
    }

    /// Largest memory of a run on `threads` threads \[bytes\], without the process itself: that of the steps, or of the
    /// fit before them.
    pub fn memory_on(&self, threads: usize) -> f64 {
        let fit = self.set_up_memory_on(threads);
        let before = self.before.iter().map(|other| other.memory_on(threads));
        before.fold((fit + self.fit_memory_that_stays).max(self.step_memory_on(threads)), f64::max)
    }

    /// Turns the work and the memory of the contact into those of segments on so many threads. The run holds one more
    /// contact, that it has been prepared with.
    pub(crate) fn add_segments(&mut self, plan: &Plan, threads: usize) {
        let Some(segments) = plan.segments else { return };
        let times = segments.rolled(plan.warm_up_steps) as f64 / plan.steps as f64;
        for amount in &mut self.work {
            if matches!(amount.place, WorkPlace::March | WorkPlace::MarchOnAll | WorkPlace::Background) {
                amount.place = WorkPlace::MarchOnAll;
                amount.amount *= times;
            }
        }
        for (counter, amount) in &mut self.counters {
            if matches!(counter, Counter::Steps | Counter::Slices) {
                *amount *= times;
            }
        }
        self.memory_per_segment = self.memory.iter().map(|(_, bytes)| bytes).sum();
        self.segments_at_once = segments.count.min(threads);
    }

    /// Memory of the steps on `threads` threads \[bytes\].
    pub(crate) fn step_memory_on(&self, threads: usize) -> f64 {
        let steps = self.memory.iter().map(|(_, bytes)| bytes).sum::<f64>() + self.memory_per_thread * threads as f64;
        steps
            + self.memory_per_segment * self.segments_at_once as f64
            + expected_fit::RETAINED * self.set_up_memory_on(threads)
    }

    /// Memory of the influence functions on `threads` threads before the steps \[bytes\].
    pub(crate) fn set_up_memory_on(&self, threads: usize) -> f64 {
        self.fit_memory_per_thread * threads as f64 + self.fit_memory
    }

    pub(crate) fn add(&mut self, stage: Stage, unit: WorkUnit, amount: f64, place: WorkPlace) {
        self.work.push(Amount { stage, unit, amount, place });
    }

    /// Adds to the expected value of a counter.
    pub(crate) fn count(&mut self, counter: Counter, amount: f64) {
        match self.counters.iter_mut().find(|known| known.0 == counter) {
            Some(known) => known.1 += amount,
            None => self.counters.push((counter, amount)),
        }
    }

    pub(crate) fn hold(&mut self, what: &'static str, bytes: f64) {
        self.memory.push((what, bytes));
    }

    /// Adds the work of another run, which is done before this one; its memory is free again by then.
    pub(crate) fn add_before(&mut self, other: Self) {
        self.work.extend(other.work.iter().map(|&amount| {
            let place = match amount.place {
                WorkPlace::Before | WorkPlace::March => WorkPlace::Before,
                WorkPlace::BeforeOnAll | WorkPlace::MarchOnAll | WorkPlace::Background => WorkPlace::BeforeOnAll,
            };
            Amount { place, ..amount }
        }));
        self.cache_bytes += other.cache_bytes;
        self.before.push(other);
    }

    fn direct(&mut self, scene: &Scene, plan: &Plan) {
        let (wavenumbers, lags, steps) = (wavenumbers(scene), plan.lags as f64, plan.steps as f64);
        let Expected { points, columns, .. } = self.expected;
        let evaluations = wavenumbers * lags * terms(scene, plan);
        let cost = if scene.tyre.curvature { expected_fit::CURVED_EVALUATION } else { 1.0 };
        self.add(Stage::Influence, WorkUnit::Evaluation, cost * evaluations, WorkPlace::BeforeOnAll);
        self.count(Counter::ComplianceEvaluations, evaluations);
        // The first steps have a shorter history.
        let used = if steps > lags { lags * (1.0 - 0.5 * lags / steps) } else { 0.5 * steps };
        self.add(Stage::History, WorkUnit::DirectMultiplyAdd, steps * used * points * columns, WorkPlace::MarchOnAll);
        let forces = 8.0 * lags * (3.0 * columns + 9.0);
        self.hold("weights and forces of the history", forces);
        // The kernel at all points of the contour, the weights from its transform, and those by element.
        let waves = wave_bytes(&plan.decisions.tyre, scene.numerics.influence_tolerance);
        let kernel = InfluenceSum::expected_bytes(&plan.decisions.tyre, ContourCircle::new(plan.lags).points().count());
        self.fit_memory = self.fit_memory.max(waves + kernel + 8.0 * lags * wavenumbers);
        self.fit_memory_that_stays = forces;
    }

    /// Adds the fitted model that the recursion and the vibration need.
    fn model(&mut self, plan: &Plan) {
        let (scene, cached) = (&plan.scene, plan.cached_poles);
        let numerics = &scene.numerics;
        let (elements, tolerance) = (numerics.elements as f64, numerics.pole_tolerance);
        self.poles = cached.map_or_else(|| expected_fit::poles(elements, tolerance), |cached| cached as f64);
        if cached.is_none() {
            let share = expected_fit::share(elements, tolerance, &plan.decisions.tyre);
            let sums = expected_fit::SUMS;
            self.add(Stage::Influence, WorkUnit::Fit, sums * share, WorkPlace::BeforeOnAll);
            self.add(Stage::Fit, WorkUnit::Fit, (1.0 - sums) * share, WorkPlace::BeforeOnAll);
            self.cache_bytes += self.poles * PoleModel::bytes_of_pole(2, plan.decisions.tyre.turns());
            self.fit_memory_per_thread = expected_fit::BYTES;
            let waves = wave_bytes(&plan.decisions.tyre, 0.01 * tolerance);
            self.fit_memory = waves + InfluenceSum::expected_bytes(&plan.decisions.tyre, expected_fit::POINTS);
        }
        self.count(Counter::ComplianceEvaluations, if cached.is_none() { expected_fit::EVALUATIONS } else { 0.0 });
    }

    fn modal(&mut self, scene: &Scene, plan: &Plan) {
        let numerics = &scene.numerics;
        self.count(Counter::Poles, self.poles);
        let Expected { columns, .. } = self.expected;
        let (rule, steps) = (numerics.time_rule, plan.steps as f64);
        let turns = plan.decisions.tyre.turns();
        let work = ModalHistory::expected(
            rule,
            numerics.elements,
            self.poles,
            [columns as usize, numerics.elements_per_step],
            turns,
        );
        let stages = rule.nodes().len() as f64;
        self.add(Stage::Influence, WorkUnit::Pole, self.poles * stages, WorkPlace::Before);
        self.add(Stage::History, WorkUnit::PoleMultiplyAdd, steps * work.poles, WorkPlace::Background);
        self.add(Stage::History, WorkUnit::SearchMultiplyAdd, steps * work.near, WorkPlace::March);
        self.add(Stage::Transforms, WorkUnit::TransformMultiplyAdd, steps * work.transforms, WorkPlace::Background);
        self.hold("poles and their states", work.pole_bytes);
        self.hold("forces, displacements and influences of blocks", work.block_bytes);
    }

    fn road(&mut self, scene: &Scene, plan: &Plan) {
        let lattice = lattice(scene, plan);
        let across = lattice.columns as f64;
        // From the window of the first step to that of the last.
        let passed = scene.numerics.advance().elements(plan.steps.saturating_sub(1) as i64);
        let rows = passed as f64 + self.expected.columns;
        match &scene.road {
            Road::Smooth => self.add(Stage::Road, WorkUnit::ResampledHeight, rows, WorkPlace::Background),
            Road::Made(made) => {
                let limit = scene.numerics.memory_bytes();
                let sizes =
                    TargetSpectrum::of(made).and_then(|target| Sizes::new(&target, made.spacing, lattice, limit));
                // A road that cannot be generated is refused when it is opened.
                if let Ok(sizes) = sizes {
                    let opening = sizes.opening();
                    let drawing = sizes.drawing(rows * plan.element, rows * lattice.along as f64);
                    let unit = WorkUnit::TextureMultiplyAdd;
                    self.add(Stage::Road, unit, opening.multiply_adds as f64, WorkPlace::BeforeOnAll);
                    self.add(Stage::Road, unit, drawing, WorkPlace::Background);
                    self.hold("texture of the road", TEXTURE_RESERVE * opening.bytes as f64);
                    self.memory_per_thread += THREAD_BYTES;
                }
            }
            Road::Profile(_) | Road::OpenCrg(_) | Road::Grid(_) => {
                self.add(Stage::Road, WorkUnit::ResampledHeight, rows * lattice.cells() as f64, WorkPlace::Background);
                let file = scene.road.file().and_then(|file| std::fs::metadata(file).ok());
                let file = file.map_or(0.0, |file| file.len() as f64);
                let is_array = matches!(&scene.road, Road::Grid(grid) if grid.is_array());
                let in_pieces = is_array && file > LONG_GRID[0] as f64;
                self.hold("file of the road as it is read", if in_pieces { PIECES_BYTES } else { READING * file });
            }
        }
        let piece = rows.min(CHUNK_ROWS as f64);
        self.hold("cells of a piece of road", 8.0 * piece * lattice.along as f64 * across);
        let cells = rows * lattice.cells() as f64;
        match plan.decisions.slices {
            Some(Slices::Pressed) if lattice.cells() > 1 => self.pressed(plan, lattice, rows),
            Some(Slices::HalfSpace) => {
                self.add(Stage::Slices, WorkUnit::HalfSpacePair, cells * across, WorkPlace::Background)
            }
            Some(Slices::Winkler | Slices::Pressed) | None => {
                self.add(Stage::Slices, WorkUnit::SpringCell, cells, WorkPlace::Background);
            }
        }
        self.count(Counter::Slices, rows);
    }

    /// Adds the curves of `elements` elements of a road that is pressed in three dimensions.
    fn pressed(&mut self, plan: &Plan, lattice: Lattice, elements: f64) {
        let tyre = &plan.decisions.tyre;
        let thickness = tyre.layers.last().map_or(0.0, |tread| tread.thickness);
        // Elements whose curves a block gives, and those that it presses beyond them at either end.
        let [inner, beyond] = block_elements(tyre.circumference, thickness, plan.element);
        let cells = (inner + 2 * beyond) as f64 * lattice.cells() as f64;
        let product = transform_multiply_adds(4 * cells as usize);
        let blocks = (elements / inner as f64).ceil() + 1.0;
        let products = blocks * PRESSED_PRODUCTS * product;
        self.add(Stage::Slices, WorkUnit::TransformMultiplyAdd, products, WorkPlace::Background);
        self.hold("a block of road that is pressed", PRESSED_CELL_BYTES * cells);
    }

    fn contact(&mut self, scene: &Scene, plan: &Plan) {
        let Expected { points, columns, .. } = self.expected;
        let smooth = matches!(scene.road, Road::Smooth);
        let solutions = plan.steps as f64 * scene.numerics.time_rule.stages() as f64;
        self.add(Stage::Axle, WorkUnit::StaticPair, columns * columns, WorkPlace::Before);
        let waves = wave_count(&scene.tyre, scene.numerics.influence_tolerance);
        if waves > 0.0 {
            self.add(Stage::Axle, WorkUnit::Evaluation, waves * expected_fit::WAVE_AT_REST, WorkPlace::BeforeOnAll);
        }
        let steep = steep_bytes(&scene.tyre);
        if steep > 0.0 {
            self.hold("polynomials of layers with cords", steep);
        }
        let column = if smooth { WorkUnit::LevelColumn } else { WorkUnit::RoughColumn };
        self.add(Stage::Penetration, column, solutions * columns, WorkPlace::March);
        self.count(Counter::Steps, plan.steps as f64);
        if plan.decisions.tread == Tread::Uncoupled {
            // Each point separately: as simple as pressing it into a level slice.
            self.add(Stage::ActiveSet, WorkUnit::LevelColumn, solutions * columns, WorkPlace::March);
            return;
        }
        let point = if smooth { WorkUnit::SmoothPoint } else { WorkUnit::RoughPoint };
        let turns = plan.decisions.tyre.turns();
        let search = match plan.decisions.slice_coupling {
            SliceCoupling::Explicit => ActiveSet::expected(points, columns, smooth, turns),
            _ => LocalSet::expected(points, columns, smooth, turns),
        };
        self.add(Stage::ActiveSet, point, solutions * search.points, WorkPlace::March);
        self.add(Stage::ActiveSet, WorkUnit::SearchMultiplyAdd, solutions * search.multiply_adds, WorkPlace::March);
        self.count(Counter::Solves, solutions * search.solves);
        self.count(Counter::Factorisations, solutions * search.factorisations);
        self.count(Counter::Bands, solutions * search.bands);
        self.hold("factors", largest_memory(scene.numerics.cached_factors, columns as usize) as f64);
    }

    /// Adds the spectra and pictures that every run writes, and arrays of so many bytes.
    pub(crate) fn add_results(&mut self, plan: &Plan, array_bytes: f64) {
        let (steps, outputs) = (plan.steps as f64, &plan.scene.outputs);
        if array_bytes > 0.0 {
            self.result_bytes = array_bytes;
            self.add(Stage::Output, WorkUnit::OutputByte, self.result_bytes, WorkPlace::March);
            self.count(Counter::BytesWritten, self.result_bytes);
        }
        if outputs.plots {
            self.add(Stage::Response, WorkUnit::Plot, 2.0, WorkPlace::Before);
            let drawn = plan.steps_drawn(self.expected.length).min(steps);
            self.hold("steps that are drawn", 8.0 * drawn * (self.expected.columns + 2.0));
        }
        if outputs.plots || outputs.spectra {
            let segment = (crate::plan::SEGMENT / plan.time_step).min(2.0 * steps);
            self.hold("spectrum", 8.0 * SPECTRUM_ARRAYS * segment);
        }
    }
}

/// Number of wavenumbers around the tyre, 0 to N/2.
pub(crate) fn wavenumbers(scene: &Scene) -> f64 {
    (scene.numerics.elements / 2 + 1) as f64
}

/// Lattice of the road, without reading its file.
fn lattice(scene: &Scene, plan: &Plan) -> Lattice {
    let width = scene.tyre.contact_width;
    let Decisions { cells_across, cells_along, .. } = plan.decisions;
    let columns = cells_across.unwrap_or_else(|| Lattice::across(width, scene.road.cell()));
    let along = cells_along.unwrap_or_else(|| Road::cells(plan.element, scene.road.cell()));
    Lattice { dx: plan.element, along, dy: width / columns as f64, columns }
}

/// Terms of the sums over m and aliases for one wavenumber and frequency.
fn terms(scene: &Scene, plan: &Plan) -> f64 {
    let (tyre, numerics) = (&scene.tyre, &scene.numerics);
    let tread = &tyre.layers[tyre.layers.len() - 1];
    let shear_speed = (tread.material.modulus / (2.0 * (1.0 + tread.material.poisson) * tread.material.density)).sqrt();
    let cut_off = thickness_limit(tread.thickness, numerics.influence_tolerance)
        .max(2.0 / (plan.time_step * shear_speed * LARGEST_ARGUMENT.sqrt()));
    let lateral = numerics.lateral_terms.map_or(cut_off * tyre.width / std::f64::consts::TAU, |terms| terms as f64);
    let aliases = match (numerics.lateral_terms, numerics.wavenumber_aliases) {
        (_, Some(aliases)) => 2.0 * aliases as f64 + 1.0,
        (Some(_), None) => 100.0,
        (None, None) => (2.0 * cut_off * plan.element / std::f64::consts::TAU).max(1.0),
    };
    lateral.max(1.0) * aliases
}
