//! Sound of a run with receivers: transfers before the first step, pressures during the run, levels and sound files at
//! its end.
//!
//! Without a receiver there is no observer, no body, no table.

mod amounts;
mod decision;
mod groove_fields;
mod page;
mod passing;
mod pictures;
mod results;
mod sections;
mod squeeze;
mod stored_signal;
mod summed;
mod valid_levels;

use std::any::Any;
use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::effect::{Effect, RunStart};
use super::error::RunError;
use super::observer::{EffectObserver, End, Found, Observer, ReceiverOrders, Step};
use super::section::{Figure, LevelTable, PageSection, ReportError};
use super::sections::cut::SectionCut;
use super::stored::Stored;
use crate::counters::{Counter, Job, Meter, Stage, Work};
use crate::plan::decisions::{DecisionRow, taken_pattern};
use crate::plan::receivers::PlannedReceiver;
use crate::plan::sound::{SOUND_FADE, SOUND_SEGMENT, Sound};
use crate::plan::{Amounts, Decisions, MeshCorrections, Plan, PlannedSetting};
use crate::radiation::RadiationError;
use crate::response::pressure::open_patch::{GrooveFields, waves_for};
use crate::response::pressure::set_up::{FoundTransfers, SetUp};
use crate::response::pressure::{BlockPressures, PressureStream};
use crate::response::vibration::SegmentLayout;
use crate::response::{LateralForces, LevelErrors, Orders, SliceErrors, SpectrumAccumulator, SpectrumError};
use crate::results::files::ResultFiles;
use crate::results::sound::{
    BodySummary, RatedLevel, ReceiverSpectrum, SOUND_COLUMN, SOUND_FILE, SOUND_LEVEL, SoundError,
};
use crate::scene::{LoadedScene, Scene, SceneError, Zone};
use crate::storage::state::{StateError, StateStream, ensure};
use groove_fields::{MiddlePressure, expected_resonances, pitch_frequency};
use passing::Passing;
use sections::SoundSections;
use squeeze::{PARTS, SqueezeStream, found_blocks};
use stored_signal::StoredSignal;
use summed::Summed;

pub(crate) struct SoundEffect;

impl Effect for SoundEffect {
    fn name(&self) -> &'static str {
        "sound"
    }

    fn rows(&self) -> &'static [DecisionRow] {
        &decision::ROWS
    }

    fn check(&self, loaded: &LoadedScene, scene: &Scene) -> Result<(), SceneError> {
        if scene.squeezes_blocks() && found_blocks(scene, &Decisions::new(scene)).is_none() {
            let wrong = "no cut is deeper than a third of the tread: it has no compliant blocks".to_owned();
            return Err(loaded.complain("air_pumping.squeeze", wrong, "deeper grooves, or leave this out").into());
        }
        Ok(())
    }

    fn choice(&self, plan: &Plan) -> Option<PlannedSetting> {
        let path = plan.sound().filter(|_| plan.decisions.zone == Zone::Cells)?.path;
        let reason = format!("even waves across; with the odd ones between them {} radiate", path.lateral);
        Some(PlannedSetting { key: "radiation.lateral_waves", value: path.radiation.lateral_waves.to_string(), reason })
    }

    fn notes(&self, plan: &Plan) -> Vec<String> {
        let passages = |sound| notes_of_passages(plan, &sound, Passing::few);
        expected_resonances(plan).into_iter().chain(plan.sound().into_iter().flat_map(passages)).collect()
    }

    fn look_up(&self, plan: &mut Plan) {
        plan.stored_frequencies = plan.frequencies_on_disk();
    }

    fn add_amounts(&self, plan: &Plan, amounts: &mut Amounts) {
        amounts::add_amounts(amounts, plan);
    }

    fn missing(&self, plan: &Plan) -> Vec<String> {
        missing_sounds(plan)
    }

    fn levels(&self) -> &'static [LevelTable] {
        &[LevelTable {
            file: SOUND_FILE,
            quantity: SOUND_LEVEL,
            column: SOUND_COLUMN,
            errors: |stored| {
                let numerical = stored.summary.sound.as_ref().and_then(|sound| sound.error.of_bands());
                let (by_slices, slices) = (stored.plan.by_slices(), stored.summary.contact.slices.as_ref());
                LevelErrors::new(numerical, by_slices, slices, SliceErrors::sound)
            },
        }]
    }

    fn figures(&self, stored: &Stored) -> Vec<Figure> {
        page::figures(stored)
    }

    fn sections(&self, stored: &Stored, all: &[Stored]) -> Result<Vec<PageSection>, ReportError> {
        Ok(vec![PageSection { heading: "Sound", blocks: page::blocks(stored, all)? }])
    }

    fn begin(&self, begin: &mut RunStart<'_>, job: &mut Job<'_>) -> Result<Option<Box<dyn EffectObserver>>, RunError> {
        Ok(SoundObserver::begin(begin, job)?.map(|observer| Box::new(observer) as Box<dyn EffectObserver>))
    }
}

/// Observer of the patch's forces, from which the pressures at the receivers are computed.
pub(crate) struct SoundObserver {
    sound: Sound,
    /// By point, the whole time steps of its delay, by which its pressures are early.
    delays: Vec<u64>,
    /// Summary of the body and its solution.
    body: BodySummary,
    /// Fields in the grooves, where air passes through the patch.
    grooves: Option<GrooveFields>,
    stream: PressureStream,
    /// Volumes that blocks squeeze into voids, where their sound is computed.
    squeeze: Option<Box<SqueezeStream>>,
    /// Lateral waves of forces on cells; `None` for slices.
    lateral: Option<LateralForces>,
    /// By place and point.
    spectra: Vec<SpectrumAccumulator>,
    /// By point, pressures over time as far as they are stored.
    signals: Vec<StoredSignal>,
    /// By open groove, pressures in its middle.
    middle_pressures: Vec<MiddlePressure>,
    /// By receiver, pressures at its first point by order of the revolution; empty without a tread pattern.
    orders: Vec<Orders>,
    /// Levels by section of the road, where these are asked for.
    sections: Option<Box<SoundSections>>,
    valid_to: f64,
    /// True if contact is over slices, whose levels have a further error.
    by_slices: bool,
    /// Errors of contact over slices, where they are known.
    slice_errors: Option<SliceErrors>,
    /// Corrections of the levels to a finer mesh.
    corrections: Option<Arc<MeshCorrections>>,
    /// Rolling speed \[m/s\].
    speed: f64,
}

/// Sound of a run that keeps its results in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct SoundResults {
    /// Spectra by receiver.
    pub receivers: Vec<ReceiverSpectrum>,
    /// A-weighted levels by receiver.
    pub rated: Vec<RatedLevel>,
    /// Body that radiates.
    pub(crate) body: BodySummary,
    /// Errors of the levels.
    pub error: SoundError,
    /// Errors of third octaves by receiver.
    pub(crate) level_errors: Vec<LevelErrors>,
}

/// Warning for a run without a single complete block of forces, at a speed \[m/s\].
fn too_short(sound: &Sound, speed: f64) -> String {
    let seconds = sound.least_duration(speed);
    format!("the run is too short for sound: it takes a rolling.duration of {seconds:.2} s")
}

/// Band of the radiation, from which the samples of a passage are planned \[Hz\].
fn radiated(sound: &Sound) -> Range<f64> {
    0.0..sound.path.radiation.fmax
}

/// Messages on sounds for which a run of a plan is too short, known before it.
fn missing_sounds(plan: &Plan) -> Vec<String> {
    let Some(sound) = plan.sound() else { return Vec::new() };
    let samples = PressureStream::samples(&sound.path.layout, plan.steps - plan.warm_up_steps);
    if samples == 0 {
        return vec![too_short(&sound, plan.speed)];
    }
    notes_of_passages(plan, &sound, |passing, stored| passing.missing(&sound, stored))
}

/// Messages on the receivers that are passed, from their passing and the number of stored samples, before a run.
fn notes_of_passages(plan: &Plan, sound: &Sound, note: impl Fn(&Passing, usize) -> Option<String>) -> Vec<String> {
    // The run will refuse a body that cannot be.
    let Ok(body) = plan.radiating_body(&sound.path.radiation, plan.expected().length) else { return Vec::new() };
    let (delays, _) = sound.path.delays(&body);
    let samples = PressureStream::samples(&sound.path.layout, plan.steps - plan.warm_up_steps);
    let stored = sound.stored_samples().min(samples as usize);
    let reported = |receiver: &PlannedReceiver| {
        let passing = Passing::of(sound, &delays, receiver, plan.speed, &radiated(sound))?;
        Some(format!("{}: {}", receiver.name, note(&passing, stored)?))
    };
    sound.receivers.iter().filter(|receiver| receiver.is_passed()).filter_map(reported).collect()
}

/// Complaint about a body that cannot be.
fn impossible_body(loaded: &LoadedScene, error: &RadiationError) -> SceneError {
    let key = match error {
        RadiationError::Gap { .. } => "radiation.acoustic_gap",
        RadiationError::Shoulder { .. } => "radiation.shoulder",
        _ => "radiation.patch_length",
    };
    loaded.complain(key, error.to_string(), "another one").into()
}

/// Adds both parts of a receiver's pressures to their spectra, where there is squeeze.
fn take_parts(
    receiver: usize,
    parts: Option<&mut [SpectrumAccumulator; PARTS]>,
    pressures: &BlockPressures<'_>,
    squeezed: Option<&BlockPressures<'_>>,
) {
    let (Some([vibration, squeeze]), Some(squeezed)) = (parts, squeezed) else { return };
    pressures.of(receiver, |block| block.iter().for_each(|&pressure| vibration.push(pressure)));
    squeezed.of(receiver, |block| block.iter().for_each(|&pressure| squeeze.push(pressure)));
}

impl SoundObserver {
    /// Begins the observer of a run; `None` without receivers, or, with a warning, if the run is too short.
    ///
    /// # Errors
    /// An impossible body or receiver, a plan that needs too much memory: complaints about the scene;
    /// [`RunError::Interrupted`].
    pub(crate) fn begin(begin: &RunStart<'_>, job: &mut Job<'_>) -> Result<Option<Self>, RunError> {
        let RunStart { loaded, plan, contact, amounts, .. } = *begin;
        let Some(sound) = plan.sound() else { return Ok(None) };
        let geometry = &contact.geometry;
        let layout = SegmentLayout {
            columns: geometry.columns,
            phase: geometry.substep(plan.warm_up_steps),
            first_position: geometry.first_position(),
            ..sound.path.layout
        };
        let samples = PressureStream::samples(&layout, plan.steps - plan.warm_up_steps);
        if samples == 0 {
            job.warnings.push(too_short(&sound, plan.speed));
            return Ok(None);
        }
        // 1. Transfers and fields in the grooves.
        let (path, tyre, gaps) = (&sound.path, &plan.decisions.tyre, &contact.gaps);
        let body = plan.radiating_body(&path.radiation, contact.at_rest.length);
        let body = body.map_err(|error| impossible_body(loaded, &error))?;
        let (delays, _) = path.delays(&body);
        let set_up = SetUp { loaded, path, body: &body, tyre, gaps };
        let FoundTransfers { transfers, report, grooves } = set_up.find(layout, contact.scale, job)?;
        if let Some(grooves) = &grooves {
            let across = contact.gaps.first().map(|gap| gap.across);
            let needed = waves_for(&path.channels, tyre.contact_width, across);
            if path.radiation.lateral_waves < needed {
                let taken = path.radiation.lateral_waves;
                job.warnings.push(format!(
                    "the field under the patch has steps from void to rib that take radiation.lateral_waves = \
                     {needed}; {taken} are followed"
                ));
            }
            job.warnings.extend(pitch_frequency(plan).iter().flat_map(|&passing| grooves.near(passing)));
        }
        // 2. Signals that are stored over time.
        let stored = sound.stored_samples().min(samples as usize);
        let speed = plan.speed;
        let mut signals = vec![StoredSignal::default(); path.points()];
        for receiver in &sound.receivers {
            if receiver.is_passed() {
                // The samples are the same whatever band is recorded.
                let passing = Passing::of(&sound, &delays, receiver, speed, &radiated(&sound));
                let missing = passing.as_ref().and_then(|passing| passing.missing(&sound, stored));
                job.warnings.extend(missing.map(|why| format!("{}: {why}", receiver.name)));
                passing.iter().for_each(|passing| passing.request(stored, &mut signals));
            } else if receiver.standard().is_stored(path.radiation.audio) {
                signals[receiver.points.clone()].fill(StoredSignal::of(std::iter::once(0..stored).collect()));
            }
        }
        // 3. Spectra, orders and lateral forces.
        let spectra = (0..path.spectra())
            .map(|_| {
                let spectrum = SpectrumAccumulator::faded(samples as usize, plan.time_step, SOUND_SEGMENT, SOUND_FADE)?;
                Ok(spectrum.keeping(plan.kept_transforms))
            })
            .collect::<Result<_, SpectrumError>>()?;
        let steps = plan.steps_per_revolution();
        let receivers = if taken_pattern(&plan.scene).is_some() { sound.receivers.len() } else { 0 };
        let over_cells = plan.decisions.zone == Zone::Cells;
        let lateral = over_cells.then(|| {
            let (grid, numbers) = (plan.cell_grid(), path.lateral_numbers(tyre));
            LateralForces::new(&grid, numbers).with_tangential(&grid, plan.scene.has_tractions())
        });
        let most_waiting = amounts(plan).waiting_blocks;
        let squeeze = SqueezeStream::new(plan, &sound, geometry, &transfers, samples as usize, most_waiting)?;
        let valid_to = contact.sound_valid_to().min(sound.complete_to());
        let sections = SectionCut::of(plan, geometry.start);
        let sections =
            sections.and_then(|cut| SoundSections::new(cut, &sound, PressureStream::first_step(&layout), valid_to));
        Ok(Some(Self {
            body: BodySummary::of(path.radiation.quality, &body, &path.air, &report),
            delays,
            grooves,
            squeeze: squeeze.map(Box::new),
            lateral,
            stream: PressureStream::new(transfers, plan.steps - plan.warm_up_steps, most_waiting),
            spectra,
            signals,
            orders: vec![Orders::new(steps); receivers],
            middle_pressures: vec![MiddlePressure::default(); path.channels.len()],
            speed,
            sections: sections.map(Box::new),
            valid_to,
            by_slices: plan.by_slices(),
            slice_errors: contact.slice_errors.clone(),
            corrections: plan.corrections.clone(),
            sound,
        }))
    }

    /// Takes the forces of a step after the warm-up \[N\], stage by stage, point by point, as
    /// [`Footprint::forces`](crate::contact::footprint::Footprint::forces) has them, and the tangential ones.
    pub(crate) fn take(&mut self, forces: &[f64], tangential: Option<&[[f64; 2]]>, meter: &mut Meter) {
        let completes = self.stream.completes_next();
        let columns = self.stream.columns();
        let work = || {
            if let Some(squeeze) = &mut self.squeeze {
                squeeze.push(forces);
            }
            match &mut self.lateral {
                None => self.stream.push(forces),
                Some(lateral) => self.stream.push(lateral.of_all(forces, tangential, columns)),
            }
        };
        // A block's end is long and rare: it is timed by itself, and does not represent other steps.
        if completes {
            meter.time(Stage::Sound, work);
            self.complete_block(meter);
        } else {
            meter.time_in_step(Stage::Sound, work);
        }
    }

    /// Computes the pressures of the blocks that wait, if they are due, after a further block.
    fn complete_block(&mut self, meter: &mut Meter) {
        let streams = || std::iter::once(&self.stream).chain(self.squeeze.iter().map(|squeeze| &squeeze.stream));
        meter.count(Counter::SoundTransforms, streams().map(PressureStream::transforms).sum());
        if streams().any(PressureStream::is_due) {
            let multiply_adds = streams().map(PressureStream::multiply_adds).sum();
            meter.time(Stage::Sound, || self.receive());
            meter.count(Counter::SoundPasses, 1);
            meter.add_work(Stage::Sound, Work { multiply_adds, bytes: 0 });
        }
    }

    /// Computes the pressures of the blocks that wait, and adds them to spectra, orders and stored signals.
    fn receive(&mut self) {
        let Self { sound, stream, signals, spectra, squeeze, orders, middle_pressures, sections, .. } = self;
        let (other, parts) = match squeeze.as_deref_mut() {
            None => (None, &mut [][..]),
            Some(SqueezeStream { stream, parts, .. }) => (Some(stream), &mut parts[..]),
        };
        stream.receive(other, |streamed, pressures, squeezed| {
            let summed = Summed { pressures, squeezed };
            let [start, end] = [streamed.start, streamed.end].map(|point| point.min(sound.path.points()));
            for point in end..streamed.end {
                let of = point - streamed.start;
                let Some(place) = sound.path.spectrum_of(point) else {
                    summed.of(of, |sum| middle_pressures[point - sound.path.points()].take(sum));
                    continue;
                };
                summed.of(of, |sum| sum.iter().for_each(|&pressure| spectra[place].push(pressure)));
                take_parts(of, parts.get_mut(place), pressures, squeezed);
            }
            let points = start..end;
            for (receiver, orders) in sound.receivers.iter().zip(orders.iter_mut()) {
                if points.contains(&receiver.points.start) {
                    let first = receiver.points.start - points.start;
                    summed.of(first, |sum| sum.iter().for_each(|&pressure| orders.push(pressure)));
                }
            }
            let each = signals[points.clone()].par_iter_mut().zip(&mut spectra[points.clone()]).enumerate();
            each.for_each(|(point, (signal, spectrum))| {
                summed.of(point, |sum| {
                    sum.iter().for_each(|&pressure| spectrum.push(pressure));
                    signal.push(sum);
                });
            });
            if squeezed.is_some() {
                let each = parts[points].par_iter_mut().enumerate();
                each.for_each(|(point, parts)| take_parts(point, Some(parts), pressures, squeezed));
            }
            if let Some(sections) = sections {
                sections.take(streamed.start, streamed.end, &summed);
            }
        });
        if let Some(sections) = sections {
            sections.complete();
        }
    }

    /// Spectra and levels of the sound so far.
    ///
    /// # Errors
    /// Too few samples for a spectrum.
    pub(crate) fn results(&self) -> Result<SoundResults, RunError> {
        let receivers = self.receiver_spectra(&self.point_spectra()?)?;
        let rated = self.rated(&receivers);
        let level_errors = receivers.iter().map(|of| self.level_errors(of.error.of_bands())).collect();
        Ok(SoundResults { receivers, rated, body: self.body.clone(), error: self.sound.error(), level_errors })
    }
}

impl Observer for SoundObserver {
    fn observe(&mut self, step: &Step<'_>, meter: &mut Meter) -> Result<(), RunError> {
        if step.counts {
            let tangential = step.footprint.tangential().map(|part| part.forces.as_slice());
            self.take(step.footprint.forces(), tangential, meter);
        }
        Ok(())
    }
}

impl EffectObserver for SoundObserver {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.stream, &mut self.squeeze, &mut self.spectra])?;
        ensure(self.squeeze.iter().all(|squeeze| squeeze.stream.is_level_with(&self.stream)))?;
        state.all([&mut self.signals, &mut self.orders, &mut self.middle_pressures, &mut self.sections])
    }

    fn section_rows(&mut self) -> Option<&mut VecDeque<String>> {
        self.sections.as_mut().map(|sections| &mut sections.rows)
    }

    fn of_segment(&self, from: u64) -> Option<Box<dyn EffectObserver>> {
        Some(Box::new(Self {
            sound: self.sound.clone(),
            delays: Vec::new(),
            body: self.body.clone(),
            grooves: None,
            stream: self.stream.of_segment(),
            squeeze: self.squeeze.as_ref().map(|squeeze| Box::new(squeeze.of_segment(from))),
            lateral: self.lateral.clone(),
            spectra: Vec::new(),
            signals: Vec::new(),
            middle_pressures: Vec::new(),
            orders: Vec::new(),
            sections: None,
            slice_errors: None,
            corrections: None,
            ..*self
        }))
    }

    fn join(&mut self, segment: Box<dyn EffectObserver>, meter: &mut Meter) {
        let Ok(segment) = (segment as Box<dyn Any>).downcast::<Self>() else { return };
        let Self { stream, squeeze, .. } = *segment;
        let mut squeezed = squeeze.map(|squeeze| squeeze.stream.into_blocks()).into_iter().flatten();
        for block in stream.into_blocks() {
            self.stream.append(block);
            if let Some((own, block)) = self.squeeze.as_deref_mut().zip(squeezed.next()) {
                own.stream.append(block);
            }
            self.complete_block(meter);
        }
    }

    fn remaining_blocks(&self, within: u64) -> (u64, Option<Stage>) {
        let (remaining, is_near) = self.stream.remaining_blocks(within as usize);
        (remaining, is_near.then_some(Stage::Sound))
    }

    fn report(&self, end: &End<'_>, found: &mut Found) {
        let rate = self.speed / end.plan.scene.tyre.circumference;
        let one = |(receiver, orders): (&PlannedReceiver, &Orders)| {
            let pressures = orders.found(rate)?.into_iter().map(|order| order.all).collect();
            Some(ReceiverOrders { receiver: receiver.file.clone(), pressures })
        };
        found.pressures_by_order = self.sound.receivers.iter().zip(&self.orders).filter_map(one).collect();
    }

    fn write(&self, end: &End<'_>, files: &dyn ResultFiles, found: &mut Found, _: &mut Meter) -> Result<(), RunError> {
        found.sound = Some(self.write_all(end.loaded, files)?);
        found
            .warnings
            .extend(self.middle_pressures.iter().enumerate().filter_map(|(groove, middle)| middle.warning(groove)));
        Ok(())
    }
}
