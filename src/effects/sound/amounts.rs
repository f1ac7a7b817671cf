//! Expected work and memory of the sound.

use super::squeeze::{self, PARTS, found_blocks};
use crate::counters::{Counter, Stage};
use crate::numeric::transform_multiply_adds;
use crate::plan::decisions::taken_pattern;
use crate::plan::sound::SOUND_SEGMENT;
use crate::plan::{Amounts, Expected, Plan, WorkPlace, WorkUnit};
use crate::radiation::{RadiatingBody, SetUpCost};
use crate::response::pressure::open_patch::OpenPatch;
use crate::response::pressure::{PressureStream, PressureTransfers, TransferPath};
use crate::response::vibration::SegmentLayout;
use crate::response::{Orders, SpectrumAccumulator, SqueezedVolumes};
use crate::tyre::influence::{SurfaceWaves, TractionWaves};
use crate::tyre::poles::expected_fit;

/// Memory of the sound's transfers over that of their numbers: the rest is retained by the allocator from the files or
/// equations that they came from (measured).
const TRANSFER_RESERVE: f64 = 1.3;
/// Time of a wave's response to all components of force over that to normal ones.
const TRACTION_WAVE: f64 = 4.0;
/// Memory of the sound's blocks over that of their arrays (measured).
const SOUND_RESERVE: f64 = 1.15;
/// Memory of blocks that wait while a checkpoint is written, over that of the blocks: as state, and as a file.
const IN_CHECKPOINT: f64 = 3.0;

/// Adds boundary elements that are not stored from earlier runs, and the propagation of all forces to all receivers.
pub(super) fn add_amounts(amounts: &mut Amounts, plan: &Plan) {
    let Some(sound) = &plan.sound() else { return };
    let Expected { columns, length, .. } = amounts.expected;
    let path = &sound.path;
    // A body that the run will refuse has no transfers.
    if let Ok(body) = plan.radiating_body(&path.radiation, length) {
        add_set_up(amounts, plan, path, &body);
    }
    let (cells, lateral) = (TransferPath::GRID.around, path.lateral);
    let waves = SurfaceWaves::expected_evaluations(cells / 2, lateral, 0.5 / plan.time_step);
    let evaluation = if plan.decisions.tyre.curvature { expected_fit::CURVED_EVALUATION } else { 1.0 };
    amounts.add(Stage::Radiation, WorkUnit::Evaluation, evaluation * waves, WorkPlace::BeforeOnAll);
    amounts.count(Counter::ComplianceEvaluations, waves);
    let tyre = &plan.decisions.tyre;
    amounts.cache_bytes +=
        SurfaceWaves::stored_bytes(tyre, cells / 2, lateral, 0.5 / plan.time_step, path.bead.is_some());
    if path.bead.is_some() {
        let flows = SurfaceWaves::flank_bytes(&plan.decisions.tyre, cells / 2, lateral, 0.5 / plan.time_step);
        amounts.hold("flow of the sidewalls", flows);
    }
    if plan.scene.has_tractions() {
        let turns = plan.decisions.tyre.turns();
        let tangential = TractionWaves::bytes(cells / 2, lateral, 0.5 / plan.time_step, turns);
        amounts.hold("answers to tangential forces", tangential);
        let ways = if turns { 2.0 } else { 1.0 };
        amounts.add(
            Stage::Radiation,
            WorkUnit::Evaluation,
            ways * TRACTION_WAVE * evaluation * waves,
            WorkPlace::BeforeOnAll,
        );
    }
    let layout = SegmentLayout { columns: columns as usize, ..path.layout };
    let mut streams = vec![PlannedStream::new(path, layout, path.integrals())];
    let found = sound.squeezes.then(|| found_blocks(&plan.scene, &plan.decisions)).flatten();
    if let Some(squeeze) = found {
        let layout = squeeze::layout(&layout, &squeeze, SqueezedVolumes::margin(&squeeze, layout.columns));
        streams.push(PlannedStream::new(path, layout, squeeze.across));
        amounts.hold("spectra of the sound's parts", (PARTS * path.spectra()) as f64 * spectrum_bytes(plan));
    }
    amounts.hold("spectra of the sound", path.spectra() as f64 * spectrum_bytes(plan));
    if plan.scene.outputs.sections.is_some() {
        amounts.hold("sound of a section", path.spectra() as f64 * spectrum_bytes(plan));
    }
    let steps = plan.steps - plan.warm_up_steps;
    if taken_pattern(&plan.scene).is_some() {
        amounts.hold(
            "sound by order",
            sound.receivers.len() as f64 * Orders::bytes(layout.advance.steps(layout.elements)),
        );
    }
    let samples = PressureStream::samples(&layout, steps) as usize;
    let [stored, read] = sound.recorded_samples(samples, plan.speed);
    if plan.kept_transforms.is_some() {
        let bytes = SpectrumAccumulator::bytes_of_transforms(samples);
        amounts.hold("transforms of the sound's spectra", path.spectra() as f64 * bytes);
    }
    amounts.add(Stage::Response, WorkUnit::PassedSample, read, WorkPlace::BeforeOnAll);
    amounts.hold("pressures to listen to", 4.0 * stored);
    add_streams(amounts, plan, &streams);
}

/// Adds the boundary elements of a body that are not stored from earlier runs, and the fields under an open patch.
fn add_set_up(amounts: &mut Amounts, plan: &Plan, path: &TransferPath, body: &RadiatingBody) {
    let (stage, memory_limit) = (Stage::Radiation, plan.scene.numerics.memory_bytes());
    if let Some(SetUpCost { frequencies, cost, bytes_stored }) =
        path.expected(body, memory_limit, &plan.stored_frequencies)
    {
        amounts.add(stage, WorkUnit::RadiationOperation, cost.factor_operations, WorkPlace::BeforeOnAll);
        let kernels = cost.far_evaluations + cost.near_evaluations;
        amounts.add(stage, WorkUnit::RadiationKernel, kernels, WorkPlace::BeforeOnAll);
        amounts.count(Counter::RadiationKernels, kernels);
        amounts.count(Counter::RadiationSolves, frequencies as f64);
        amounts.fit_memory_per_thread = amounts.fit_memory_per_thread.max(cost.bytes as f64);
        amounts.fit_memory_that_stays = bytes_stored as f64;
        // Frequencies that are stored already are only read.
        if frequencies > 0 {
            amounts.cache_bytes += bytes_stored as f64;
        }
        amounts.hold("transfers of the sound", TRANSFER_RESERVE * bytes_stored as f64);
    }
    if let Some(open) = OpenPatch::of(path, body, &[]) {
        let [multiply_adds, bytes] = open.expected(path);
        amounts.add(stage, WorkUnit::RadiationOperation, 8.0 * multiply_adds, WorkPlace::BeforeOnAll);
        amounts.hold("field under the patch", bytes);
    }
}

fn spectrum_bytes(plan: &Plan) -> f64 {
    SpectrumAccumulator::bytes(plan.time_step, SOUND_SEGMENT)
}

/// Propagation of forces or volumes in windows of a layout to all receivers.
struct PlannedStream {
    layout: SegmentLayout,
    bins: usize,
    points: usize,
    /// Cells of G, and its integrals per wavenumber.
    green: [usize; 2],
}

impl PlannedStream {
    fn new(path: &TransferPath, layout: SegmentLayout, integrals: usize) -> Self {
        let bins = (path.radiation.fmax / layout.resolution()).ceil() as usize;
        Self { layout, bins, points: path.streamed(), green: [TransferPath::GRID.around, integrals] }
    }

    /// Memory while `waiting` blocks wait \[bytes\].
    fn bytes(&self, waiting: usize) -> f64 {
        SOUND_RESERVE * PressureStream::bytes(&self.layout, self.bins, waiting, self.points, self.green)
    }

    fn add_work(&self, amounts: &mut Amounts, blocks: u64, passes: u64) {
        let Self { layout, bins, points, green: [cells, integrals] } = self;
        let multiply_adds = |blocks| PressureTransfers::multiply_adds(layout, *bins, blocks, *cells, *integrals);
        let batches = PressureStream::batches(*points).0 as f64;
        // Each pass begins anew what its blocks share.
        let [of_pass, of_blocks] = [multiply_adds(0), multiply_adds(blocks as usize)]
            .map(|[shared, each]| shared * batches + each * *points as f64);
        let products = of_blocks + (passes as f64 - 1.0) * of_pass;
        amounts.add(Stage::Sound, WorkUnit::TransferMultiplyAdd, products, WorkPlace::MarchOnAll);
        let transforms = 0.5 * (layout.places() + points) as f64 * transform_multiply_adds(layout.length());
        amounts.add(Stage::Sound, WorkUnit::SoundMultiplyAdd, blocks as f64 * transforms, WorkPlace::MarchOnAll);
    }
}

/// Adds streams whose blocks wait together, as many as the memory allows that the rest of the run leaves.
fn add_streams(amounts: &mut Amounts, plan: &Plan, streams: &[PlannedStream]) {
    let Some(PlannedStream { layout, .. }) = streams.first() else { return };
    let steps = plan.steps - plan.warm_up_steps;
    let bytes = |waiting: usize| streams.iter().map(|stream| stream.bytes(waiting)).sum::<f64>();
    let free_memory = plan.scene.numerics.memory_bytes() as f64 - amounts.step_memory_on(1) - bytes(0);
    let blocks_in_memory = free_memory / (IN_CHECKPOINT * (bytes(1) - bytes(0)));
    let waiting = PressureStream::most_waiting(layout, steps, blocks_in_memory);
    let blocks = PressureStream::blocks(layout, steps);
    let passes = blocks.div_ceil(waiting as u64);
    streams.iter().for_each(|stream| stream.add_work(amounts, blocks, passes));
    amounts.count(Counter::SoundPasses, passes as f64);
    amounts.hold("blocks of the sound", bytes(waiting));
    if let Some(segments) = plan.segments {
        amounts.memory_per_segment += bytes(segments.steps as usize / layout.hop());
    }
    amounts.waiting_blocks = waiting;
}
