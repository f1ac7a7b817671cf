//! Sound of a planned run: receivers, block length, highest frequency, errors.

use std::ops::Range;

use crate::contact::cells::gaps::PLACES;
use crate::numeric::SplitRule;
use crate::plan::Plan;
use crate::plan::decisions::taken_pattern;
use crate::plan::front::FrontRow;
use crate::plan::settle::Choice;
use crate::plan::stated::Unstated;
use crate::radiation::draft::{self, DraftError, DraftErrors};
use crate::radiation::gap::patch::Channel;
use crate::radiation::{
    Block, Body, Cost, Flank, FrequencyRange, RadiationError, Resolution, SetUpCost, TransferGrid, TransferProblem,
};
use crate::response::ThirdOctaveBand;
use crate::response::pressure::{PressureModel, PressureStream};
use crate::response::vibration::{Across, SegmentLayout};
use crate::results::pass_by::LISTENED;
use crate::results::sound::SoundError;
use crate::scene::{Groove, Numerics, Radiation, RadiationQuality, ReceiverPlace, Scene, Tyre, Vehicle, Zone};
use crate::sound::Air;
use crate::sound::pass_by::STENCIL;
use crate::sound::receivers::{Beside, Standard, standard};
use crate::sound::resample::FILE_RATE;
use crate::tyre::influence::Waves;

/// Least length of the blocks in which forces are transformed \[s\]: the tyre's lowest modes ring out within it.
const BLOCK: f64 = 0.5;
/// Length of the segments for averaged spectra of sound \[s\]: a resolution of 1 Hz in the lowest bands, which are 5 Hz
/// wide, and rise by 10 dB from one to the next.
pub(super) const SOUND_SEGMENT: f64 = 1.0;
/// Time over which a record fades in and out before its spectrum is taken \[s\].
pub(super) const SOUND_FADE: f64 = 0.25;
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
/// Cost of a draft's four monopoles in kernels of boundary elements.
const DRAFT_KERNELS: f64 = 30.0;
/// Step to which patch lengths are rounded, as a part of the tyre's radius.
const PATCH_STEP: f64 = 0.01;

/// A `[[receiver]]` with its points.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedReceiver {
    /// Name in the scene, or that of its standard; unique.
    pub name: String,
    /// Name as part of file names; unique.
    pub file: String,
    /// Place in the scene.
    pub place: ReceiverPlace,
    /// Its points among those of all receivers.
    pub points: Range<usize>,
}

impl PlannedReceiver {
    /// Microphones of its standard.
    pub(crate) fn standard(&self) -> Box<dyn Standard> {
        standard(&self.place)
    }

    /// Length of the passage \[m\], if the tyre passes it.
    pub(crate) fn passage(&self) -> Option<f64> {
        self.standard().passage()
    }

    pub(crate) fn is_passed(&self) -> bool {
        self.passage().is_some()
    }

    /// Vehicle whose four tyres it receives, if more than one.
    pub(crate) fn vehicle(&self) -> Option<Vehicle> {
        self.standard().vehicle()
    }

    /// Number of tyres that it receives.
    pub(crate) fn tyres(&self) -> usize {
        self.vehicle().map_or(1, |_| Vehicle::TYRES)
    }

    /// Lines of points along which a microphone beside the road glides, as many points each: that of the tyre, or of a
    /// vehicle's left tyres and then of its right ones, which are farther away. None for a receiver that moves with the
    /// tyre.
    pub(crate) fn lines(&self) -> Vec<Range<usize>> {
        let sides = match (self.is_passed(), self.vehicle()) {
            (false, _) => 0,
            (true, None) => 1,
            (true, Some(_)) => 2,
        };
        let length = self.points.len() / sides.max(1);
        let first = |side: usize| self.points.start + side * length;
        (0..sides).map(|side| first(side)..first(side + 1)).collect()
    }
}

/// Sound of a run, as planned.
#[derive(Clone, Debug, PartialEq)]
pub struct Sound {
    /// Settings, with a highest frequency that the time step can represent.
    pub radiation: Radiation,
    /// Receivers.
    pub receivers: Vec<PlannedReceiver>,
    /// Positions of the points of all receivers \[m\], in the frame of [`crate::scene::Receiver`].
    pub positions: Vec<[f64; 3]>,
    /// Frequency from which on the error of the forces' third octaves holds that `preset` or `accuracy` states \[Hz\],
    /// and that error \[dB\], or the reason why none is stated.
    pub stated: Result<(f64, f64), Unstated>,
    /// Blocks of the forces; columns, phase and first position are set by the run.
    pub layout: SegmentLayout,
    /// Number of lateral waves, from the lowest on: of those that a strip excites, or of all.
    pub lateral: usize,
    /// Radius of the bead \[m\], where the sidewalls radiate.
    pub bead: Option<f64>,
    /// Errors of a draft round this tyre, where they are stated.
    pub draft: Option<DraftErrors>,
    /// Grooves with air through the patch; empty where it is sealed.
    pub channels: Vec<Channel>,
    /// Number of places of the run whose voids between tread and road are open, or 1.
    pub places: usize,
    /// True if blocks squeeze volume into the voids beside them.
    pub squeezes: bool,
}

impl Sound {
    /// Cells round the tyre, and points across half of it, on which G is known.
    pub(crate) const GRID: TransferGrid = TransferGrid { around: 512, across: 4 };

    /// Number of points of all receivers.
    pub(crate) fn points(&self) -> usize {
        self.positions.len()
    }

    /// Number of points whose pressures are computed: those of all receivers, for each place, and one in the middle of
    /// each groove.
    pub(crate) fn streamed(&self) -> usize {
        self.spectra() + self.channels.len()
    }

    /// Number of spectra of pressures: of all points, place by place.
    pub(crate) fn spectra(&self) -> usize {
        self.points() * self.places
    }

    /// Index of the spectrum for the pressures of a streamed point; `None` for one in a groove.
    pub(crate) fn spectrum_of(&self, streamed: usize) -> Option<usize> {
        let others = self.points() + self.channels.len();
        (streamed < self.points()).then_some(streamed).or_else(|| Some(streamed.checked_sub(others)? + self.points()))
    }

    /// Transfers from a body to all points, to be solved for.
    pub(crate) fn problem<'a>(&'a self, body: &'a Body, memory_limit: u64) -> TransferProblem<'a> {
        TransferProblem {
            body,
            receivers: &self.positions,
            grid: Self::GRID,
            flank: self.flank(body),
            resolution: Resolution::of(self.radiation.nodes_per_wavelength),
            blocks: self.blocks(),
            memory_limit,
        }
    }

    /// Part of a body that radiates in addition to its tread.
    pub(super) fn flank(&self, body: &Body) -> Option<Flank> {
        Flank::new(body, self.bead?)
    }

    /// Number of G's integrals per wavenumber.
    pub(super) fn integrals(&self) -> usize {
        let rings = if self.bead.is_some() { SplitRule::POINTS } else { 0 };
        let driven = match self.layout.across {
            Across::Even => self.lateral,
            Across::Resolved { components, .. } => components,
        };
        PressureModel::integrals(self.radiation.air, PressureModel::shape_count(self.layout.across, driven, rings))
    }

    /// Lateral numbers of the waves that radiate.
    pub(crate) fn lateral_numbers(&self, tyre: &Tyre) -> Vec<usize> {
        let waves = Waves::new(tyre);
        match self.layout.across {
            Across::Even => waves.lateral_numbers().take(self.lateral).collect(),
            Across::Resolved { .. } => (waves.first_lateral_number()..).take(self.lateral).collect(),
        }
    }

    /// Symmetries of the fields: forces on cells are not even across.
    fn blocks(&self) -> &'static [Block] {
        match self.layout.across {
            Across::Even => &Block::EVEN_ACROSS,
            Across::Resolved { .. } => &Block::ALL,
        }
    }

    /// Range of frequencies of the transfers in some air.
    pub(crate) fn range(&self, air: &Air) -> FrequencyRange {
        FrequencyRange::up_to(self.radiation.fmax, self.radiation.frequency_tolerance, air.sound_speed)
    }

    /// Expected cost of the transfers that are not stored, for a patch of a length \[m\]; `None` for a body, positions
    /// or air that the run will refuse.
    pub(crate) fn expected(&self, plan: &Plan, at_rest: f64) -> Option<SetUpCost> {
        let body = plan.radiating_body(&self.radiation, at_rest).ok()?;
        let problem = self.problem(&body, plan.scene.numerics.memory_bytes());
        let range = self.range(&Air::at(self.radiation.temperature)?);
        if self.radiation.quality == RadiationQuality::Draft {
            let values = (self.points() * problem.values()) as u64;
            let frequencies = draft::frequencies(&range).len() as u64;
            let far_evaluations = DRAFT_KERNELS * (values * frequencies) as f64;
            let cost = Cost { far_evaluations, ..Cost::default() };
            return Some(SetUpCost { frequencies: 0, cost, bytes_kept: 8 * values * frequencies });
        }
        SetUpCost::expected(&problem, &range, &plan.kept_frequencies).ok()
    }

    /// Mid-frequency of the highest third octave that is radiated as a whole \[Hz\]; 0 where there is none.
    pub(crate) fn complete_to(&self) -> f64 {
        let whole = ThirdOctaveBand::within(1.0..PressureModel::flat_to(self.radiation.fmax));
        whole.last().map_or(0.0, |band| band.mid_frequency())
    }

    /// Errors of the levels, at the receiver where the transfer's is largest.
    pub(crate) fn error(&self) -> SoundError {
        let all = self.receivers.iter().map(|receiver| self.error_at(receiver));
        let worst = all.reduce(|a, b| if b.way > a.way { b } else { a });
        worst.unwrap_or_else(|| self.with_way(0.0, 0.0, 0.0))
    }

    /// Errors of the levels at a receiver.
    pub(crate) fn error_at(&self, receiver: &PlannedReceiver) -> SoundError {
        let Radiation { quality, nodes_per_wavelength, frequency_tolerance, lateral_waves, .. } = self.radiation;
        let waves = WAVES_ERROR * (Radiation::default().lateral_waves as f64 / lateral_waves as f64).powi(2);
        match quality {
            RadiationQuality::Full => {
                let fineness = Radiation::default().nodes_per_wavelength / nodes_per_wavelength;
                let elements = ELEMENTS_ERROR * fineness.powi(6);
                let frequencies = FREQUENCIES_ERROR * frequency_tolerance;
                let rings = if self.bead.is_some() { RINGS_ERROR } else { 0.0 };
                let way =
                    [elements, frequencies, waves, rings].into_iter().map(|error| error * error).sum::<f64>().sqrt();
                self.with_way(way, way, 0.0)
            }
            RadiationQuality::Draft => {
                let points = self.positions.get(receiver.points.clone()).unwrap_or_default();
                let DraftError { band, from, level } = self.draft_error(&receiver.place, points);
                self.with_way(band + waves, level + waves, from)
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

    /// Errors of forces and transfer path together; `way` is that of third octaves from a frequency \[Hz\] on, `way_a`
    /// that of the A-weighted level \[dB\].
    fn with_way(&self, way: f64, way_a: f64, from: f64) -> SoundError {
        let (of_forces, forces) = self.stated.ok().unzip();
        let [band, level_a] = [way, way_a].map(|way| forces.map(|forces| forces + way));
        SoundError { forces, way, band, from: from.max(of_forces.unwrap_or(0.0)), level_a }
    }

    /// Largest number of samples of a point's pressure that are stored.
    pub(crate) fn kept_samples(&self) -> usize {
        (LISTENED / self.layout.time_step) as usize
    }
}

impl Sound {
    /// Length of a line of points that is passed \[m\].
    fn line_length(&self, receiver: &PlannedReceiver) -> f64 {
        let line = receiver.lines().first().cloned().and_then(|line| self.positions.get(line));
        line.and_then(|line| Some(line.first()?[0] - line.last()?[0])).unwrap_or(0.0)
    }

    /// Shortest `rolling.duration` that gives so many samples of pressure, rounded up to the next hundredth \[s\]:
    /// pressures come in blocks.
    pub(crate) fn duration_for(&self, samples: u64) -> f64 {
        let (length, hop) = (self.layout.length() as u64, self.layout.hop() as u64);
        let steps = length + samples.saturating_sub(1) / hop * hop;
        debug_assert!(PressureStream::samples(&self.layout, steps) >= samples);
        (100.0 * steps as f64 * self.layout.time_step + 1e-6).ceil() / 100.0
    }

    /// Shortest `rolling.duration` at a speed \[m/s\] that gives sound, a passage at every receiver that is passed
    /// included \[s\]; the propagation from the ends of a line counts as the whole line at 343 m/s.
    pub(crate) fn least_duration(&self, speed: f64) -> f64 {
        let lines =
            self.receivers.iter().filter(|receiver| receiver.is_passed()).map(|receiver| self.line_length(receiver));
        let longest = lines.fold(0.0, f64::max);
        let seconds = longest / speed + longest / 343.0;
        let ends = if longest > 0.0 { 2.0 * EXCERPT_ENDS } else { 0.0 };
        self.duration_for((seconds / self.layout.time_step + ends) as u64 + 1)
    }

    /// For so many samples of all points at a speed \[m/s\]: the number of samples that are stored, and the number of
    /// samples of passages that are computed.
    pub(crate) fn recorded_samples(&self, samples: usize, speed: f64) -> [f64; 2] {
        let kept = self.kept_samples().min(samples) as f64;
        let one = |receiver: &PlannedReceiver| {
            if !receiver.is_passed() {
                let recorded = receiver.standard().is_kept(self.radiation.audio);
                return [if recorded { kept * receiver.points.len() as f64 } else { 0.0 }, 0.0];
            }
            let lines = receiver.lines();
            let points = lines.first().map_or(0, ExactSizeIterator::len) as f64;
            let length = self.line_length(receiver);
            let seconds = length / speed;
            let passages = (kept * self.layout.time_step / seconds).floor();
            let spacing = length / (points - 1.0);
            let excerpt = STENCIL as f64 * spacing / speed / self.layout.time_step + EXCERPT_ENDS;
            [points * excerpt, seconds * FILE_RATE].map(|samples| lines.len() as f64 * passages * samples)
        };
        self.receivers.iter().map(one).fold([0.0; 2], |[kept, read], [k, r]| [kept + k, read + r])
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
    pub(super) fn radiating_waves(&self) -> Option<Choice> {
        let sound = self.sound().filter(|_| self.decisions.zone == Zone::Cells)?;
        Some(Choice {
            key: "radiation.lateral_waves",
            value: sound.radiation.lateral_waves.to_string(),
            reason: format!("even waves across; with the odd ones between them {} radiate", sound.lateral),
        })
    }

    /// Sound of the run; `None` without receivers.
    #[doc(hidden)]
    pub fn sound(&self) -> Option<Sound> {
        let Scene { tyre, receivers, radiation, .. } = &self.scene;
        if receivers.is_empty() {
            return None;
        }
        let fmax = radiation.fmax.min(BELOW_NYQUIST * 0.5 / self.time_step);
        let radiation = Radiation { fmax, ..radiation.clone() };
        let (layout, lateral) = self.followed(radiation.lateral_waves);
        let mut positions = Vec::new();
        let mut names: Vec<String> = receivers.iter().map(|receiver| receiver.name.clone()).collect();
        let mut files: Vec<String> = Vec::new();
        let patch_length = || self.patch_length(&radiation, self.expected().length);
        let beside = Beside { half_width: 0.5 * tyre.width + radiation.shoulder, patch_length: &patch_length };
        let planned = receivers.iter().enumerate().map(|(index, receiver)| {
            let (first, microphones) = (positions.len(), standard(&receiver.place));
            positions.extend(microphones.points(&beside));
            if receiver.name.is_empty() {
                let name = match receiver.place {
                    ReceiverPlace::Position { .. } => format!("{}-{}", microphones.name(), index + 1),
                    ReceiverPlace::Standard(_) => microphones.name().to_owned(),
                };
                names[index] = unlike(&name, index, &names);
            }
            let name = names[index].clone();
            let plain = name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '-' });
            let file = unlike(&plain.collect::<String>(), index, &files);
            files.push(file.clone());
            PlannedReceiver { name, file, place: receiver.place, points: first..positions.len() }
        });
        let planned: Vec<PlannedReceiver> = planned.collect();
        let stated = FrontRow::stated_error(&self.scene);
        let draft = DraftErrors::of(self.radius, tyre.width + 2.0 * radiation.shoulder);
        let arc = tyre.sidewall_arc(0.0).filter(|_| radiation.hears_sides(tyre));
        let bead = arc.map(|arc| arc.bead_radius());
        let channels = channels(&self.scene);
        let squeezes = self.scene.squeezes_blocks();
        let places = if self.scene.opens_voids() { PLACES } else { 1 };
        Some(Sound {
            radiation,
            receivers: planned,
            positions,
            stated,
            layout,
            lateral,
            bead,
            draft,
            channels,
            places,
            squeezes,
        })
    }
}

/// Grooves of a scene with air through the patch.
pub(super) fn channels(scene: &Scene) -> Vec<Channel> {
    if taken_pattern(scene).is_none() {
        return Vec::new();
    }
    let channel = |groove: &Groove| Channel { position: groove.position, width: groove.width, depth: groove.depth };
    scene.open_grooves().iter().filter(|groove| groove.depth > 0.0).map(channel).collect()
}

/// Lateral waves that resolve the steps of a field between grooves: twice the strip's width over that of the narrowest
/// rib or groove, or of a cell where voids are open on so many cells across.
pub(super) fn waves_for(channels: &[Channel], contact_width: f64, voids: Option<usize>) -> usize {
    if let Some(cells) = voids {
        return 2 * cells;
    }
    let mut sides = vec![-0.5 * contact_width, 0.5 * contact_width];
    sides.extend(
        channels.iter().flat_map(|Channel { position, width, .. }| [-0.5, 0.5].map(|half| position + half * width)),
    );
    sides.sort_by(f64::total_cmp);
    let widths = sides.windows(2).map(|ends| ends[1] - ends[0]).filter(|width| *width > 1e-9 * contact_width);
    (2.0 * contact_width / widths.fold(contact_width, f64::min) - 1e-9).ceil() as usize
}

/// The name of receiver number `index`, with a number appended where another has the same, also on file systems that
/// ignore case.
fn unlike(name: &str, index: usize, others: &[String]) -> String {
    let taken = |name: &str| others.iter().any(|other| other.eq_ignore_ascii_case(name));
    let numbered = (index + 1..).map(|number| format!("{name}-{number}"));
    std::iter::once(name.to_owned()).chain(numbered).find(|name| !taken(name)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counters::Counter;
    use crate::scene::{DEFAULT, Preset, Receiver, StandardReceiver, Switch};
    use crate::test_models::on_springs;

    fn coast_by(vehicle: Option<Vehicle>) -> StandardReceiver {
        let (distance, height) = (StandardReceiver::DISTANCE, StandardReceiver::HEIGHT);
        StandardReceiver::CoastBy { distance, height, vehicle, passage: None }
    }

    #[test]
    fn a_vehicle_is_heard_along_a_line_for_either_side_that_reaches_past_both_axles() {
        let mut scene = Scene::from_str(DEFAULT, "default").unwrap().scene;
        let vehicle = Vehicle { wheelbase: 2.7, track: 1.5 };
        let place = |vehicle| Receiver { name: String::new(), place: ReceiverPlace::Standard(coast_by(vehicle)) };
        scene.receivers = vec![place(None), place(Some(vehicle)), place(Some(Vehicle { wheelbase: 2.0, ..vehicle }))];
        let sound = Plan::new(&scene).sound().unwrap();
        let [one, four, short] = [0, 1, 2].map(|receiver| &sound.receivers[receiver]);
        // Three times 7.595 m, and 6 m for the detector before them: 116 steps of 0.25 m, and 92 behind.
        assert_eq!((one.points.clone(), one.lines().len(), one.tyres()), (0..209, 1, 1));
        assert_eq!((sound.positions[0], sound.positions[208]), ([29.0, 7.5, 1.2], [-23.0, 7.5, 1.2]));
        // Half of 2.7 m more at either end.
        assert_eq!((four.points.clone(), four.tyres()), (209..647, 4));
        assert_eq!(four.lines(), [209..428, 428..647]);
        assert_eq!((sound.positions[209], sound.positions[427]), ([30.25, 6.75, 1.2], [-24.25, 6.75, 1.2]));
        assert_eq!((sound.positions[428], sound.positions[646]), ([30.25, 8.25, 1.2], [-24.25, 8.25, 1.2]));
        assert_eq!(short.points.len(), 2 * 217);
        // Each tyre finds the microphone on its side's line, up to the ends of the passage of one tyre.
        for x in [22.7, -22.7] {
            for (tyre, [ahead, aside, _]) in vehicle.seen_from_tyres([x, 7.5, 1.2]).into_iter().enumerate() {
                let line = &sound.positions[four.lines()[tyre % 2].clone()];
                let along = line[line.len() - 1][0]..=line[0][0];
                assert!(along.contains(&ahead) && (aside - line[0][1]).abs() < 1e-12, "tyre {tyre}: {ahead}");
            }
        }
        let files: Vec<&str> = sound.receivers.iter().map(|receiver| receiver.file.as_str()).collect();
        assert_eq!(files, ["coast-by", "coast-by-2", "coast-by-3"]);
    }

    #[test]
    fn names_and_files_of_receivers_never_meet() {
        let mut scene = Scene::from_str(DEFAULT, "default").unwrap().scene;
        let receiver =
            |name: &&str| Receiver { name: (*name).to_owned(), place: ReceiverPlace::Standard(coast_by(None)) };
        scene.receivers = ["a b", "a-b-3", "a.b", "", "", "A/B", "coast-by-5"].iter().map(receiver).collect();
        let sound = Plan::new(&scene).sound().unwrap();
        let of = |field: fn(&PlannedReceiver) -> &str| sound.receivers.iter().map(field).collect::<Vec<_>>();
        let names = of(|receiver| &receiver.name);
        assert_eq!(names, ["a b", "a-b-3", "a.b", "coast-by", "coast-by-6", "A/B", "coast-by-5"]);
        let files = of(|receiver| &receiver.file);
        assert_eq!(files, ["a-b", "a-b-3", "a-b-4", "coast-by", "coast-by-6", "A-B-6", "coast-by-5"]);
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
                (plan.sound().unwrap().points(), plan.amounts().memory_on(2))
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
            let blocks = PressureStream::blocks(&plan.sound().unwrap().layout, plan.steps - plan.warm_up_steps);
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
    fn the_error_of_a_draft_goes_with_the_place_and_is_the_sum_it_states() {
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
        let body = plan.radiating_body(&sound.radiation, 0.11).unwrap();
        for &position in &sound.positions {
            assert_eq!(body.check_receiver(position), Ok(()), "{position:?}");
        }
        let front = sound.positions[sound.receivers[1].points.start];
        assert!((body.depth(front) + 0.2).abs() < 1e-12, "0.2 m from the sidewall: {}", body.depth(front));
        assert_eq!(sound.receivers.last().map(|receiver| receiver.points.end), Some(sound.points()));
    }
}
