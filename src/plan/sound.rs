//! Sound of a plan: receivers, body, length of the blocks of forces, highest frequency.

use std::ops::Range;

use super::Plan;
use super::decisions::taken_pattern;
use super::front::FrontRow;
use super::receivers::{PlannedReceiver, planned_receivers};
use super::settle::Choice;
use super::stated::Unstated;
use crate::contact::cells::gaps::PLACES;
use crate::radiation::draft::DraftErrors;
use crate::radiation::gap::patch::Channel;
use crate::radiation::stored::StoredTransfers;
use crate::radiation::{Air, Body, RadiationError};
use crate::response::ThirdOctaveBand;
use crate::response::pressure::{PressureModel, PressureStream, TransferPath};
use crate::response::vibration::{Across, SegmentLayout};
use crate::results::pass_by::LISTENED;
use crate::scene::{Groove, Numerics, Radiation, RadiationQuality, Scene, Tyre, Zone};
use crate::sound::pass_by::STENCIL;
use crate::sound::receivers::Beside;
use crate::sound::resample::FILE_RATE;

/// Least length of the blocks in which forces are transformed \[s\]: the tyre's lowest modes ring out within it.
const BLOCK: f64 = 0.5;
/// Length of the segments for averaged spectra of sound \[s\]: a resolution of 1 Hz in the lowest bands, which are 5 Hz
/// wide, and rise by 10 dB from one to the next.
pub(crate) const SOUND_SEGMENT: f64 = 1.0;
/// Time over which a record fades in and out before its spectrum is taken \[s\].
pub(crate) const SOUND_FADE: f64 = 0.25;
/// Highest frequency of the radiation, as a part of the Nyquist frequency.
const BELOW_NYQUIST: f64 = 0.9;

/// Samples of a point that a passage needs in addition to those while the microphone is near it: the reach of
/// resampling.
const EXCERPT_ENDS: f64 = 70.0;
/// Step to which patch lengths are rounded, as a part of the tyre's radius.
const PATCH_STEP: f64 = 0.01;
/// Largest relative error of the expected patch length before the static contact is solved.
const PATCH_ERROR: f64 = 0.2;

/// Sound of a run, as planned.
#[derive(Clone, Debug, PartialEq)]
pub struct Sound {
    /// Transfer path to the points of all receivers.
    pub path: TransferPath,
    /// Receivers.
    pub receivers: Vec<PlannedReceiver>,
    /// Frequency from which on the error of the forces' third octaves holds that `preset` or `accuracy` states \[Hz\],
    /// and that error \[dB\], or the reason why none is stated.
    pub stated: Result<(f64, f64), Unstated>,
    /// Errors of a draft round this tyre, where they are stated.
    pub draft: Option<DraftErrors>,
    /// True if blocks squeeze volume into the voids beside them.
    pub squeezes: bool,
}

impl Sound {
    /// Mid-frequency of the highest third octave that is radiated as a whole \[Hz\]; 0 where there is none.
    pub(crate) fn complete_to(&self) -> f64 {
        let whole = ThirdOctaveBand::within(1.0..PressureModel::flat_to(self.path.radiation.fmax));
        whole.last().map_or(0.0, |band| band.mid_frequency())
    }

    /// Largest number of samples of a point's pressure that are stored.
    pub(crate) fn stored_samples(&self) -> usize {
        (LISTENED / self.path.layout.time_step) as usize
    }

    /// Points of a receiver over which its spectrum is averaged: all but those in which the detector settles before a
    /// passage.
    pub(crate) fn counted(&self, receiver: &PlannedReceiver) -> impl Iterator<Item = usize> {
        let rear = self.path.positions[receiver.points.clone()].last().map_or(0.0, |last| last[0]);
        let counts = move |point: &usize| !receiver.is_passed() || self.path.positions[*point][0] <= 1e-9 - rear;
        receiver.points.clone().filter(counts)
    }

    /// Length of a line of points that is passed \[m\].
    fn line_length(&self, receiver: &PlannedReceiver) -> f64 {
        let line = receiver.lines().first().cloned().and_then(|line| self.path.positions.get(line));
        line.and_then(|line| Some(line.first()?[0] - line.last()?[0])).unwrap_or(0.0)
    }

    /// Shortest `rolling.duration` that gives so many samples of pressure, rounded up to the next hundredth \[s\]:
    /// pressures come in blocks.
    pub(crate) fn duration_for(&self, samples: u64) -> f64 {
        let (length, hop) = (self.path.layout.length() as u64, self.path.layout.hop() as u64);
        let steps = length + samples.saturating_sub(1) / hop * hop;
        debug_assert!(PressureStream::samples(&self.path.layout, steps) >= samples);
        (100.0 * steps as f64 * self.path.layout.time_step + 1e-6).ceil() / 100.0
    }

    /// Shortest `rolling.duration` at a speed \[m/s\] that gives sound, a passage at every receiver that is passed
    /// included \[s\]; the propagation from the ends of a line counts as the whole line at 343 m/s.
    pub(crate) fn least_duration(&self, speed: f64) -> f64 {
        let lines =
            self.receivers.iter().filter(|receiver| receiver.is_passed()).map(|receiver| self.line_length(receiver));
        let longest = lines.fold(0.0, f64::max);
        let seconds = longest / speed + longest / 343.0;
        let ends = if longest > 0.0 { 2.0 * EXCERPT_ENDS } else { 0.0 };
        self.duration_for((seconds / self.path.layout.time_step + ends) as u64 + 1)
    }

    /// For so many samples of all points at a speed \[m/s\]: the number of samples that are stored, and the number of
    /// samples of passages that are computed.
    pub(crate) fn recorded_samples(&self, samples: usize, speed: f64) -> [f64; 2] {
        let stored = self.stored_samples().min(samples) as f64;
        let one = |receiver: &PlannedReceiver| {
            if !receiver.is_passed() {
                let recorded = receiver.standard().is_kept(self.path.radiation.audio);
                return [if recorded { stored * receiver.points.len() as f64 } else { 0.0 }, 0.0];
            }
            let lines = receiver.lines();
            let points = lines.first().map_or(0, ExactSizeIterator::len) as f64;
            let length = self.line_length(receiver);
            let seconds = length / speed;
            let passages = (stored * self.path.layout.time_step / seconds).floor();
            let spacing = length / (points - 1.0);
            let excerpt = STENCIL as f64 * spacing / speed / self.path.layout.time_step + EXCERPT_ENDS;
            [points * excerpt, seconds * FILE_RATE].map(|samples| lines.len() as f64 * passages * samples)
        };
        self.receivers.iter().map(one).fold([0.0; 2], |[stored, read], [s, r]| [stored + s, read + r])
    }
}

impl Plan {
    /// Body that radiates. Its patch is as long as the scene says, or as that of the static contact \[m\] in steps of a
    /// hundredth of the radius, so that runs of one tyre share its transfers.
    ///
    /// # Errors
    /// Sizes that do not fit each other.
    pub(crate) fn radiating_body(&self, radiation: &Radiation, at_rest: f64) -> Result<Body, RadiationError> {
        let patch = self.patch_length(radiation, at_rest);
        let width = self.scene.tyre.width + 2.0 * radiation.shoulder;
        Body::standing_tyre(self.radius, width, radiation.shoulder, 0.5 * patch)?.with_gap(radiation.acoustic_gap)
    }

    /// Length of the patch of the body that radiates, given that of the static contact \[m\].
    fn patch_length(&self, radiation: &Radiation, at_rest: f64) -> f64 {
        let step = self.patch_step();
        radiation.patch_length.unwrap_or_else(|| (at_rest / step).round().max(1.0) * step)
    }

    /// Blocks of the forces; columns, phase and first position are set by the run.
    pub(crate) fn sound_layout(&self) -> SegmentLayout {
        let Numerics { elements, substeps, .. } = self.scene.numerics;
        let revolution = (elements * substeps) as f64 * self.time_step;
        self.segment_layout((BLOCK / revolution).ceil().clamp(1.0, 1e6) as usize)
    }

    /// The same, and the number of lateral waves if a strip excites `lateral_waves` of them; for forces on cells all
    /// that are no higher.
    fn followed(&self, lateral_waves: usize) -> (SegmentLayout, usize) {
        let layout = self.sound_layout();
        match self.decisions.zone {
            Zone::Slices => (layout, lateral_waves),
            Zone::Cells => {
                let lateral = lateral_waves.saturating_mul(2) - 1;
                let forces = if self.scene.has_tractions() { 3 } else { 1 };
                let components = lateral.saturating_mul(forces);
                (SegmentLayout { across: Across::Resolved { components, kept: 0 }, ..layout }, lateral)
            }
        }
    }

    /// Step to which the length of a body's patch is rounded \[m\].
    pub(crate) fn patch_step(&self) -> f64 {
        PATCH_STEP * self.radius
    }

    /// Number of lateral waves that radiate for forces on cells, as a choice.
    pub(crate) fn radiating_waves(&self) -> Option<Choice> {
        let sound = self.sound().filter(|_| self.decisions.zone == Zone::Cells)?;
        Some(Choice {
            key: "radiation.lateral_waves",
            value: sound.path.radiation.lateral_waves.to_string(),
            reason: format!("even waves across; with the odd ones between them {} radiate", sound.path.lateral),
        })
    }

    /// Transfer path of a tyre to the points of some receivers, for forces as a layout and a number of lateral waves
    /// have them.
    ///
    /// # Errors
    /// Air that cannot be.
    pub(crate) fn transfer_path(
        &self,
        tyre: &Tyre,
        radiation: Radiation,
        (positions, receivers): (Vec<[f64; 3]>, Vec<Range<usize>>),
        (layout, lateral): (SegmentLayout, usize),
    ) -> Result<TransferPath, RadiationError> {
        let arc = tyre.sidewall_arc(0.0).filter(|_| radiation.hears_sides(tyre));
        Ok(TransferPath {
            air: Air::checked(radiation.temperature)?,
            radiation,
            positions,
            receivers,
            layout,
            lateral,
            has_tractions: self.scene.has_tractions(),
            bead: arc.map(|arc| arc.bead_radius()),
            channels: channels(&self.scene),
            places: if self.scene.opens_voids() { PLACES } else { 1 },
        })
    }

    /// Sound of the run; `None` without receivers, or in air that cannot be, which scenes refuse.
    #[doc(hidden)]
    pub fn sound(&self) -> Option<Sound> {
        let Scene { tyre, receivers, radiation, .. } = &self.scene;
        if receivers.is_empty() {
            return None;
        }
        let fmax = radiation.fmax.min(BELOW_NYQUIST * 0.5 / self.time_step);
        let radiation = Radiation { fmax, ..radiation.clone() };
        let followed = self.followed(radiation.lateral_waves);
        let patch_length = || self.patch_length(&radiation, self.expected().length);
        let half_width = 0.5 * tyre.width + radiation.shoulder;
        let (planned, positions) = planned_receivers(receivers, &Beside { half_width, patch_length: &patch_length });
        let points = planned.iter().map(|receiver| receiver.points.clone()).collect();
        let path = self.transfer_path(tyre, radiation, (positions, points), followed).ok()?;
        Some(Sound {
            path,
            receivers: planned,
            stated: FrontRow::stated_error(&self.scene),
            draft: DraftErrors::of(self.radius, 2.0 * half_width),
            squeezes: self.scene.squeezes_blocks(),
        })
    }

    /// Frequencies that are stored for the sound of the run \[Hz\]; none without receivers, or where no equations are
    /// solved. The static contact is not solved yet: entries of a patch about as long as expected are taken for the
    /// run's.
    pub(crate) fn frequencies_on_disk(&self) -> Vec<f64> {
        let solved = |sound: &Sound| sound.path.radiation.quality == RadiationQuality::Full;
        let Some(Sound { path, .. }) = self.sound().filter(solved) else { return Vec::new() };
        let (range, at_rest, step) = (path.range(), self.expected().length, self.patch_step());
        let reach = (PATCH_ERROR * at_rest / step) as i64;
        // The nearest first; a patch length that the scene gives is the same for all of them.
        let mut tried: Vec<i64> = (-reach..=reach).collect();
        tried.sort_by_key(|steps| steps.abs());
        let mut found = tried.into_iter().filter_map(|steps| {
            let body = self.radiating_body(&path.radiation, at_rest + steps as f64 * step).ok()?;
            let problem = path.problem(&body, self.scene.numerics.memory_bytes());
            StoredTransfers::open(&problem, &range, &path.receivers, &mut Vec::new()).frequencies()
        });
        found.next().unwrap_or_default()
    }
}

/// Grooves of a scene with air through the patch.
pub(crate) fn channels(scene: &Scene) -> Vec<Channel> {
    if taken_pattern(scene).is_none() {
        return Vec::new();
    }
    let channel = |groove: &Groove| Channel { position: groove.position, width: groove.width, depth: groove.depth };
    scene.open_grooves().iter().filter(|groove| groove.depth > 0.0).map(channel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counters::Counter;
    use crate::scene::{DEFAULT, Receiver, ReceiverPlace, StandardReceiver, Switch, Vehicle};
    use crate::test_models::on_springs;

    fn coast_by(vehicle: Option<Vehicle>) -> StandardReceiver {
        let (distance, height) = (StandardReceiver::DISTANCE, StandardReceiver::HEIGHT);
        StandardReceiver::CoastBy { distance, height, vehicle, passage: None }
    }

    #[test]
    fn a_vehicle_is_heard_for_half_a_minute_within_1_1_gigabytes_and_a_point_more_takes_some_1_7_megabytes() {
        // On springs the tread alone radiates. The sides of a tyre on arcs add five rings to four points across it.
        let tyres = [(on_springs(DEFAULT), 1.1e9, 1.8e6), (DEFAULT.to_owned(), 1.8e9, 9.0 / 4.0 * 1.8e6)];
        for (text, most, steepest) in tyres {
            let mut scene = Scene::from_str(&text, "scene").unwrap().scene;
            scene.numerics.elements = 1024;
            scene.rolling.duration = 40.0;
            // A fit of the turning tyre takes more memory than its sound.
            scene.effects.rotation = Switch::Off;
            let receiver = |standard| Receiver { name: String::new(), place: ReceiverPlace::Standard(standard) };
            let vehicle = Vehicle { wheelbase: 2.7, track: 1.55 };
            let mut memory = |vehicles: usize| {
                scene.receivers = vec![receiver(StandardReceiver::Cpx)];
                scene.receivers.extend((0..vehicles).map(|_| receiver(coast_by(Some(vehicle)))));
                let plan = Plan::new(&scene);
                (plan.sound().unwrap().path.points(), plan.amounts().memory_on(2))
            };
            let [(few, least), (some, one), (many, four)] = [0, 1, 4].map(&mut memory);
            assert_eq!([few, some, many], [2, 440, 1754]);
            assert!(one < most, "{one:.2e} bytes of {some} points, {least:.2e} of {few}");
            let slope = (four - one) / (many - some) as f64;
            assert!(slope < steepest, "{slope:.2e} bytes a point");
        }
    }

    #[test]
    fn as_many_blocks_wait_as_the_memory_allows_that_the_rest_of_the_run_leaves() {
        let mut scene = Scene::from_str(DEFAULT, "default").unwrap().scene;
        let place = ReceiverPlace::Standard(StandardReceiver::Cpx);
        scene.receivers = vec![Receiver { name: String::new(), place }];
        scene.rolling.duration = 40.0;
        let mut within = |limit: f64| {
            scene.numerics.memory_limit = limit;
            let plan = Plan::new(&scene);
            let blocks = PressureStream::blocks(&plan.sound().unwrap().path.layout, plan.steps - plan.warm_up_steps);
            let amounts = plan.amounts();
            let passes = amounts.counters.iter().find(|(counter, _)| *counter == Counter::SoundPasses).unwrap().1;
            assert_eq!(passes as u64, blocks.div_ceil(amounts.waiting_blocks as u64), "{limit} GB");
            (amounts.waiting_blocks, amounts.step_memory_on(1))
        };
        let (most, all) = within(8.0);
        // A checkpoint holds the blocks twice more.
        let (few, some) = within(1e-9 * all);
        assert!(most > 20 && few > 4 && few <= most / 3, "{few} of {most}");
        assert!(some < all && within(1e-3).0 == 1);
    }

    #[test]
    fn places_of_the_standards_are_in_the_air_and_a_scene_without_any_has_no_sound() {
        let mut scene = Scene::from_str(DEFAULT, "default").unwrap().scene;
        assert_eq!(Plan::new(&scene).sound(), None);
        let standards = [
            coast_by(None),
            StandardReceiver::Cpx,
            StandardReceiver::Circle { radius: 2.0, height: 0.3 },
            StandardReceiver::Hemisphere { radius: 3.0 },
        ];
        let place = |standard| Receiver { name: String::new(), place: ReceiverPlace::Standard(standard) };
        scene.receivers = standards.map(place).to_vec();
        let plan = Plan::new(&scene);
        let sound = plan.sound().unwrap();
        let body = plan.radiating_body(&sound.path.radiation, 0.11).unwrap();
        for &position in &sound.path.positions {
            assert_eq!(body.check_receiver(position), Ok(()), "{position:?}");
        }
        let front = sound.path.positions[sound.receivers[1].points.start];
        assert!((body.depth(front) + 0.2).abs() < 1e-12, "0.2 m from the sidewall: {}", body.depth(front));
        assert_eq!(sound.receivers.last().map(|receiver| receiver.points.end), Some(sound.path.points()));
    }
}
