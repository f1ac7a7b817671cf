//! Sound of a plan: receivers, body, length of the blocks of forces, highest frequency, errors.

use std::ops::Range;

use super::Plan;
use super::decisions::taken_pattern;
use super::front::FrontRow;
use super::receivers::{PlannedReceiver, planned_receivers};
use super::stated::Unstated;
use crate::contact::cells::gaps::PLACES;
use crate::radiation::draft::{DraftError, DraftErrors};
use crate::radiation::gap::patch::GapChannel;
use crate::radiation::stored::StoredTransfers;
use crate::radiation::{Air, RadiatingBody, RadiationError};
use crate::response::ThirdOctaveBand;
use crate::response::pressure::{PressureModel, PressureStream, TransferPath};
use crate::response::vibration::{Across, SegmentLayout};
use crate::results::pass_by::LISTENED;
use crate::results::sound::SoundError;
use crate::scene::{Groove, Radiation, RadiationQuality, ReceiverPlace, Scene, Tyre, Zone};
use crate::sound::pass_by::STENCIL;
use crate::sound::receivers::{Beside, standard};
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
/// Error of a third octave at the default nodes per wavelength \[dB\]: the worst of single waves (9 against 14 nodes).
/// With 7 nodes it is 0.5 dB, so it falls with about the sixth power. `tyrewave sweep` over `nodes_per_wavelength`,
/// `frequency_tolerance` and `lateral_waves` measures all three.
const ELEMENTS_ERROR: f64 = 0.1;
/// Error of a third octave by interpolation, as a part of the frequencies' tolerance, which is met with intervals of
/// twice the length: 0.009 dB found at 0.2 dB against 0.02 dB (default tyre, coast-by and cpx, to 2.5 kHz).
const FREQUENCIES_ERROR: f64 = 0.05;
/// Error of a third octave at the default lateral waves \[dB\]: 0.009 found against 24 waves, 0.016 with four, 0.004
/// with eight (the same runs), so it falls with about their number's square.
const WAVES_ERROR: f64 = 0.01;
/// Error of a third octave by the rings of a flank that radiates \[dB\]: 1.7 % of the pressure found against boundary
/// elements of the whole body moving up, where the road cuts the shoulders; 0.2 % for breathing.
const RINGS_ERROR: f64 = 0.15;
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

    /// True if pressures are stored over time, for sound files, passages or intensities.
    pub(crate) fn is_stored(&self) -> bool {
        let audio = self.path.radiation.audio;
        self.receivers.iter().any(|receiver| receiver.is_passed() || receiver.standard().is_stored(audio))
    }

    /// For so many samples of all points at a speed \[m/s\]: the number of samples that are stored, and the number of
    /// samples of passages that are computed.
    pub(crate) fn recorded_samples(&self, samples: usize, speed: f64) -> [f64; 2] {
        let stored = self.stored_samples().min(samples) as f64;
        let one = |receiver: &PlannedReceiver| {
            if !receiver.is_passed() {
                let recorded = receiver.standard().is_stored(self.path.radiation.audio);
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

impl Sound {
    /// Errors of the levels, at the receiver where the transfer's is largest.
    pub(crate) fn error(&self) -> SoundError {
        let all = self.receivers.iter().map(|receiver| self.error_at(receiver));
        let worst = all.reduce(|a, b| if b.way > a.way { b } else { a });
        worst.unwrap_or_else(|| self.with_path(0.0, 0.0, 0.0))
    }

    pub(crate) fn error_at(&self, receiver: &PlannedReceiver) -> SoundError {
        let Radiation { quality, nodes_per_wavelength, frequency_tolerance, lateral_waves, .. } = self.path.radiation;
        let waves = WAVES_ERROR * (Radiation::default().lateral_waves as f64 / lateral_waves as f64).powi(2);
        match quality {
            RadiationQuality::Full => {
                let fineness = Radiation::default().nodes_per_wavelength / nodes_per_wavelength;
                let elements = ELEMENTS_ERROR * fineness.powi(6);
                let frequencies = FREQUENCIES_ERROR * frequency_tolerance;
                let rings = if self.path.bead.is_some() { RINGS_ERROR } else { 0.0 };
                let of_path =
                    [elements, frequencies, waves, rings].into_iter().map(|error| error * error).sum::<f64>().sqrt();
                self.with_path(of_path, of_path, 0.0)
            }
            RadiationQuality::Draft => {
                let points = self.path.positions.get(receiver.points.clone()).unwrap_or_default();
                let DraftError { band, from, level } = self.draft_error(&receiver.place, points);
                self.with_path(band + waves, level + waves, from)
            }
        }
    }

    /// Error of a draft over the points of a receiver; infinite where none is stated, which scenes refuse.
    fn draft_error(&self, place: &ReceiverPlace, points: &[[f64; 3]]) -> DraftError {
        let none = DraftError { band: f64::INFINITY, from: 0.0, level: f64::INFINITY };
        let Some(errors) = self.draft else { return none };
        if standard(place).has_stated_draft() {
            return errors.of_standards;
        }
        let all = points.iter().map(|&point| errors.at(point).unwrap_or(none));
        all.reduce(|a, b| if b.band > a.band { b } else { a }).unwrap_or(none)
    }

    /// Errors of forces and transfer path together; `of_path` is the path's for third octaves from a frequency \[Hz\]
    /// on, `of_path_a` that for the A-weighted level \[dB\].
    fn with_path(&self, of_path: f64, of_path_a: f64, from: f64) -> SoundError {
        let (of_forces, forces) = self.stated.ok().unzip();
        let [band, level_a] = [of_path, of_path_a].map(|of_path| forces.map(|forces| forces + of_path));
        SoundError { forces, way: of_path, band, from: from.max(of_forces.unwrap_or(0.0)), level_a }
    }
}

impl Plan {
    /// Body that radiates. Its patch is as long as the scene says, or as that of the static contact \[m\] in steps of a
    /// hundredth of the radius, so that runs of one tyre share its transfers.
    ///
    /// # Errors
    /// Sizes that do not fit each other.
    pub(crate) fn radiating_body(&self, radiation: &Radiation, at_rest: f64) -> Result<RadiatingBody, RadiationError> {
        let patch = self.patch_length(radiation, at_rest);
        let width = self.scene.tyre.width + 2.0 * radiation.shoulder;
        RadiatingBody::standing_tyre(self.radius, width, radiation.shoulder, 0.5 * patch)?
            .with_gap(radiation.acoustic_gap)
    }

    /// Length of the patch of the body that radiates, given that of the static contact \[m\].
    fn patch_length(&self, radiation: &Radiation, at_rest: f64) -> f64 {
        let step = PATCH_STEP * self.radius;
        radiation.patch_length.unwrap_or_else(|| (at_rest / step).round().max(1.0) * step)
    }

    /// Blocks of the forces; columns, phase and first position are set by the run.
    pub(crate) fn sound_layout(&self) -> SegmentLayout {
        let revolution = self.steps_per_revolution() as f64 * self.time_step;
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
                (SegmentLayout { across: Across::Resolved { components, values: 0 }, ..layout }, lateral)
            }
        }
    }

    /// Transfer path of a tyre to the points of some receivers, for forces as a layout and a number of lateral waves
    /// have them; `None` in air that cannot be.
    pub(crate) fn transfer_path(
        &self,
        tyre: &Tyre,
        radiation: Radiation,
        (positions, receivers): (Vec<[f64; 3]>, Vec<Range<usize>>),
        (layout, lateral): (SegmentLayout, usize),
    ) -> Option<TransferPath> {
        let arc = tyre.sidewall_arc(0.0).filter(|_| radiation.hears_sides(tyre));
        Some(TransferPath {
            air: Air::at(radiation.temperature)?,
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
        let path = self.transfer_path(tyre, radiation, (positions, points), followed)?;
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
        let (range, at_rest, step) = (path.range(), self.expected().length, PATCH_STEP * self.radius);
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
pub(crate) fn channels(scene: &Scene) -> Vec<GapChannel> {
    if taken_pattern(scene).is_none() {
        return Vec::new();
    }
    let channel = |groove: &Groove| GapChannel { position: groove.position, width: groove.width, depth: groove.depth };
    scene.open_grooves().iter().filter(|groove| groove.depth > 0.0).map(channel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counters::Counter;
    use crate::scene::{DEFAULT, Preset, Receiver, StandardReceiver, Switch, Vehicle};
    use crate::test_models::on_springs;

    fn coast_by(vehicle: Option<Vehicle>) -> StandardReceiver {
        let (distance, height) = (StandardReceiver::DISTANCE, StandardReceiver::HEIGHT);
        StandardReceiver::CoastBy { distance, height, vehicle, passage: None }
    }

    #[test]
    fn half_a_minute_of_a_vehicle_takes_less_than_1_1_gigabytes() {
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
    fn as_many_blocks_wait_as_the_remaining_memory_allows() {
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
    fn a_drafts_error_depends_on_place_and_is_the_stated_sum() {
        let mut scene = Scene::from_str(DEFAULT, "default").unwrap().scene;
        let at = |place| Receiver { name: String::new(), place };
        let [beside, ahead] = [[0.0, 2.0, 0.3], [2.0, 0.0, 0.3]].map(|position| ReceiverPlace::Position { position });
        scene.receivers = vec![at(ReceiverPlace::Standard(StandardReceiver::Cpx)), at(beside), at(ahead)];
        scene.radiation.quality = RadiationQuality::Draft;
        (scene.numerics.preset, scene.numerics.fmax) = (Some(Preset::Standard), Some(1000.0));
        let sound = Plan::new(&scene).sound().unwrap();
        let [cpx, beside, ahead] = [0, 1, 2].map(|receiver| sound.error_at(&sound.receivers[receiver]));
        assert!(cpx.band < beside.band && beside.band < ahead.band, "{cpx:?} {beside:?} {ahead:?}");
        assert_eq!(sound.error(), ahead, "the worst stands for all");
        for error in [cpx, beside, ahead] {
            assert_eq!(error.forces, Some(1.0));
            let [band, level] = [error.band, error.level_a].map(Option::unwrap);
            assert!((band - (1.0 + error.way)).abs() < 1e-12 && level < band, "{error:?}");
        }
        scene.numerics.preset = None;
        let error = Plan::new(&scene).sound().unwrap().error();
        assert_eq!((error.forces, error.band, error.level_a), (None, None, None), "that of the forces is not known");
        assert!(error.way > 0.0);
        assert!((cpx.way - sound.draft.unwrap().of_standards.band - WAVES_ERROR).abs() < 1e-12, "{cpx:?}");
    }

    #[test]
    fn standard_receivers_are_in_the_air_and_none_means_no_sound() {
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
