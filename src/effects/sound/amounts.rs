//! Expected work and memory of the sound.

use super::open_patch::OpenAmounts;
use super::planned::{SOUND_SEGMENT, Sound};
use super::squeeze::{self, PARTS, found_blocks};
use crate::counters::{Counter, Stage};
use crate::numeric::transform_multiply_adds;
use crate::plan::decisions::taken_pattern;
use crate::plan::{Amounts, Expected, Place, Plan, Unit};

use crate::radiation::SetUpCost;
use crate::response::pressure::{PressureStream, PressureTransfers};
use crate::response::vibration::SegmentLayout;
use crate::response::{Orders, SpectrumAccumulator, SqueezedVolumes};
use crate::tyre::influence::{SurfaceWaves, TractionWaves};
use crate::tyre::poles::expected_fit;

/// Memory of the sound's transfers over that of their numbers: the rest is kept by the allocator from the files or
/// equations that they came from (measured).
const TRANSFER_RESERVE: f64 = 1.3;
/// Time of a wave's response to all components of force over that to normal ones.
const TRACTION_WAVE: f64 = 4.0;
/// Memory of the sound's blocks over that of their arrays (measured).
const SOUND_RESERVE: f64 = 1.15;

/// Adds boundary elements that are not stored from earlier runs, and the propagation of all forces to all receivers.
pub(super) fn add_amounts(amounts: &mut Amounts, plan: &Plan) {
    let Some(sound) = &plan.sound() else { return };
    let Expected { columns, length, .. } = amounts.expected;
    if let Some(SetUpCost { frequencies, cost, bytes_kept }) = sound.expected(plan, length) {
        let stage = Stage::Radiation;
        amounts.add(stage, Unit::RadiationOperation, cost.factor_operations, Place::BeforeOnAll);
        let kernels = cost.far_evaluations + cost.near_evaluations;
        amounts.add(stage, Unit::RadiationKernel, kernels, Place::BeforeOnAll);
        amounts.count(Counter::RadiationKernels, kernels);
        amounts.count(Counter::RadiationSolves, frequencies as f64);
        amounts.fit_memory_per_thread = amounts.fit_memory_per_thread.max(cost.bytes as f64);
        amounts.fit_memory_that_stays = bytes_kept as f64;
        // Frequencies that are stored already are only read.
        if frequencies > 0 {
            amounts.cache_bytes += bytes_kept as f64;
        }
        amounts.hold("transfers of the sound", TRANSFER_RESERVE * bytes_kept as f64);
    }
    if let Some(OpenAmounts { multiply_adds, bytes }) = OpenAmounts::of(plan, sound, length) {
        amounts.add(Stage::Radiation, Unit::RadiationOperation, 8.0 * multiply_adds, Place::BeforeOnAll);
        amounts.hold("field under the patch", bytes);
    }
    let (cells, lateral) = (Sound::GRID.around, sound.lateral);
    let waves = SurfaceWaves::expected_evaluations(cells / 2, lateral, 0.5 / plan.time_step);
    let evaluation = if plan.decisions.tyre.curvature { expected_fit::CURVED_EVALUATION } else { 1.0 };
    amounts.add(Stage::Radiation, Unit::Evaluation, evaluation * waves, Place::BeforeOnAll);
    amounts.count(Counter::ComplianceEvaluations, waves);
    if sound.bead.is_some() {
        let flows = SurfaceWaves::flank_bytes(&plan.decisions.tyre, cells / 2, lateral, 0.5 / plan.time_step);
        amounts.hold("flow of the sidewalls", flows);
    }
    if plan.scene.has_tractions() {
        let turns = plan.decisions.tyre.turns();
        let tangential = TractionWaves::bytes(cells / 2, lateral, 0.5 / plan.time_step, turns);
        amounts.hold("answers to tangential forces", tangential);
        let ways = if turns { 2.0 } else { 1.0 };
        amounts.add(Stage::Radiation, Unit::Evaluation, ways * TRACTION_WAVE * evaluation * waves, Place::BeforeOnAll);
    }
    let layout = SegmentLayout { columns: columns as usize, ..sound.layout };
    add_stream(amounts, plan, sound, &layout, sound.integrals());
    let found = sound.squeezes.then(|| found_blocks(&plan.scene, &plan.decisions)).flatten();
    if let Some(squeeze) = found {
        let layout = squeeze::layout(&layout, &squeeze, SqueezedVolumes::margin(&squeeze, layout.columns));
        add_stream(amounts, plan, sound, &layout, squeeze.across);
        amounts.hold("spectra of the sound's parts", (PARTS * sound.spectra()) as f64 * spectrum_bytes(plan));
    }
    amounts.hold("spectra of the sound", sound.spectra() as f64 * spectrum_bytes(plan));
    let steps = plan.steps - plan.warm_up_steps;
    if taken_pattern(&plan.scene).is_some() {
        amounts.hold("sound by order", sound.receivers.len() as f64 * Orders::bytes(layout.elements * layout.substeps));
    }
    let samples = PressureStream::samples(&layout, steps) as usize;
    let [kept, read] = sound.recorded_samples(samples, plan.speed);
    amounts.add(Stage::Response, Unit::PassedSample, read, Place::BeforeOnAll);
    amounts.hold("pressures to listen to", 4.0 * kept);
}

fn spectrum_bytes(plan: &Plan) -> f64 {
    SpectrumAccumulator::bytes(plan.time_step, SOUND_SEGMENT)
}

/// Adds the propagation of forces or volumes in windows of a layout to all receivers, with so many integrals per
/// wavenumber.
fn add_stream(amounts: &mut Amounts, plan: &Plan, sound: &Sound, layout: &SegmentLayout, integrals: usize) {
    let (cells, points) = (Sound::GRID.around, sound.streamed());
    let bins = (sound.radiation.fmax / layout.resolution()).ceil() as usize;
    let steps = plan.steps - plan.warm_up_steps;
    let blocks = PressureStream::blocks(layout, steps);
    let together = PressureStream::together(layout, bins, steps);
    let passes = blocks.div_ceil(together.max(1) as u64);
    let [shared, each] = PressureTransfers::multiply_adds(layout, bins, together, cells, integrals);
    let products = shared * PressureStream::batches(points).0 as f64 + each * points as f64;
    amounts.add(Stage::Sound, Unit::TransferMultiplyAdd, passes as f64 * products, Place::MarchOnAll);
    let transforms = 0.5 * (layout.places() + points) as f64 * transform_multiply_adds(layout.length());
    amounts.add(Stage::Sound, Unit::SoundMultiplyAdd, blocks as f64 * transforms, Place::MarchOnAll);
    let blocks = PressureStream::bytes(layout, bins, steps, points, [cells, integrals]);
    amounts.hold("blocks of the sound", SOUND_RESERVE * blocks);
}
