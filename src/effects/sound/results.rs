//! Results of a run's sound: tables, pictures, sound files, the summary.

use std::collections::BTreeMap;
use std::ops::Range;

use super::groove_fields::{GAP_FILE, VOIDS_FILE};
use crate::effects::error::RunError;
use crate::effects::sound::SoundObserver;
use crate::effects::sound::passing::{Passing, RecordedPassage};
use crate::effects::sound::pictures::{draw_directivity, draw_levels, draw_pass_by, draw_under_patch};
use crate::effects::sound::valid_levels::{over_valid_bands, standard_error_a};
use crate::numeric::in_parallel;
use crate::plan::receivers::PlannedReceiver;
use crate::plan::sound::{SOUND_FADE, SOUND_SEGMENT};
use crate::response::{
    BandGain, BandLevel, LevelErrors, PowerSpectrum, SliceErrors, SpectrumAccumulator, ThirdOctaveBand,
};
use crate::results::ResultsError;
use crate::results::files::ResultFiles;
use crate::results::pass_by::PassBySummary;
use crate::results::sound::{
    AudioSummary, IntensitySummary, RatedLevel, ReceiverSpectrum, ReceiverSummary, SOUND_FILE, SOUND_NARROW_FILE,
    SoundParts, SoundSummary, sound_levels_csv, sound_narrow_csv, spread,
};
use crate::results::spectra::LOWEST_FREQUENCY;
use crate::results::table::{csv, row};
use crate::scene::LoadedScene;
use crate::sound::band_pass::band_pass;
use crate::sound::intensity::Intensity;
use crate::sound::levels::{REFERENCE_PRESSURE, energetic_mean, mean_square};
use crate::sound::power::{Iso3744, power_level};
use crate::sound::receivers::{Finding, Probes};
use crate::sound::resample::{FILE_RATE, resample};
use crate::sound::wav::{SampleFormat, full_scale_for};
use crate::sound::{CoveredBands, Recording, SoundLevels, TotalLevel};

/// Points per second of a pass-by's level that are written and drawn.
const LEVELS_A_SECOND: f64 = 200.0;

impl SoundObserver {
    /// Writes levels, pictures and sounds of a complete run; returns their summary.
    ///
    /// # Errors
    /// Errors of the files and pictures.
    pub(super) fn write_all(&self, loaded: &LoadedScene, folder: &dyn ResultFiles) -> Result<SoundSummary, RunError> {
        let points = self.point_spectra()?;
        let spectra = self.receiver_spectra(&points)?;
        let error = self.sound.error();
        folder.write_text(SOUND_FILE, &sound_levels_csv(&spectra, LOWEST_FREQUENCY, self.slice_errors.as_ref()))?;
        folder.write_text(SOUND_NARROW_FILE, &sound_narrow_csv(&spectra))?;
        if let Some(grooves) = &self.grooves {
            if !self.sound.path.channels.is_empty() {
                folder.write_text(GAP_FILE, &grooves.to_csv(&self.sound, &self.middle_pressures))?;
            }
            if let Some(table) = grooves.voids_to_csv(&self.sound) {
                folder.write_text(VOIDS_FILE, &table)?;
            }
            let drawn = grooves.loudest.as_ref().zip(self.sound.receivers.first());
            if let Some((levels, receiver)) = drawn.filter(|_| loaded.scene.outputs.plots) {
                draw_under_patch(loaded, &receiver.name, levels, folder)?;
            }
        }
        let (mut receivers, mut recordings) = (Vec::new(), Vec::new());
        for (receiver, spectrum) in self.sound.receivers.iter().zip(&spectra) {
            let (summary, recording) = self.receiver(loaded, receiver, spectrum, &points, folder)?;
            recordings.extend(recording.map(|recording| (receivers.len(), recording)));
            receivers.push(summary);
        }
        let peak = recordings.iter().map(|(_, recording)| recording.peak()).fold(0.0, f64::max);
        let full_scale = self.sound.path.radiation.full_scale.unwrap_or_else(|| full_scale_for(peak));
        for (receiver, recording) in recordings {
            let file = format!("sound_{}.wav", self.sound.receivers[receiver].file);
            receivers[receiver].audio = Some(recording.write(folder, file, full_scale)?);
        }
        if loaded.scene.outputs.plots {
            draw_levels(loaded, &spectra, self.level_errors(error.of_bands()), folder)?;
        }
        Ok(SoundSummary {
            reference: REFERENCE_PRESSURE,
            highest: self.sound.path.radiation.fmax,
            body: self.body.clone(),
            error,
            receivers,
        })
    }

    /// Spectra at all points, averaged over places whose voids are open, with the gains of their receiver where levels
    /// are those of a finer mesh.
    pub(super) fn point_spectra(&self) -> Result<Vec<PowerSpectrum>, RunError> {
        let mut points = PowerSpectrum::means(self.place_spectra()?, self.sound.path.points());
        let corrections = self.corrections.iter().flat_map(|corrections| &corrections.receivers);
        for (receiver, correction) in self.sound.receivers.iter().zip(corrections) {
            let gains = self.mean_at(receiver, &points).map_or_else(Vec::new, |mean| correction.gains(&mean));
            points[receiver.points.clone()].iter_mut().for_each(|point| point.correct(&gains));
        }
        Ok(points)
    }

    /// Mean over the points of a receiver that count, times the number of its tyres.
    fn mean_at(&self, receiver: &PlannedReceiver, points: &[PowerSpectrum]) -> Option<PowerSpectrum> {
        let mut spectrum = PowerSpectrum::mean_of(self.sound.counted(receiver).map(|point| &points[point]))?;
        let tyres = receiver.tyres() as f64;
        spectrum.power.iter_mut().for_each(|power| *power *= tyres);
        Some(spectrum)
    }

    /// Spectra at all points, place by place.
    fn place_spectra(&self) -> Result<Vec<PowerSpectrum>, RunError> {
        let finished = |spectrum: &SpectrumAccumulator| Ok(spectrum.clone().finish()?.valid_to(self.valid_to));
        in_parallel::map(&self.spectra, finished).into_iter().collect()
    }

    /// For each receiver the mean over its points that count, times the number of its tyres: all lines of points have
    /// as many points.
    ///
    /// # Errors
    /// Too few samples for a spectrum.
    pub(super) fn receiver_spectra(&self, points: &[PowerSpectrum]) -> Result<Vec<ReceiverSpectrum>, RunError> {
        let count = self.sound.path.points();
        let parts = self.squeeze.as_ref().map(|squeeze| squeeze.spectra(count, self.valid_to)).transpose()?;
        let places = if self.sound.path.places > 1 { self.place_spectra()? } else { Vec::new() };
        let one = |receiver: &PlannedReceiver| {
            let spectrum = self.mean_at(receiver, points)?;
            // Parts and places have the gains of the whole.
            let at = |points: &[PowerSpectrum]| {
                let mut part = self.mean_at(receiver, points)?;
                part.correct(&spectrum.gains);
                Some(part)
            };
            let [vibration, squeeze] = [0, 1].map(|part| parts.as_ref().and_then(|parts| at(&parts[part])));
            Some(ReceiverSpectrum {
                name: receiver.name.clone(),
                parts: vibration.zip(squeeze).map(|(vibration, squeeze)| SoundParts { vibration, squeeze }),
                places: places.chunks_exact(count).filter_map(at).collect(),
                error: self.sound.error_at(receiver),
                spectrum,
            })
        };
        Ok(self.sound.receivers.iter().filter_map(one).collect())
    }

    fn receiver(
        &self,
        loaded: &LoadedScene,
        receiver: &PlannedReceiver,
        ReceiverSpectrum { spectrum, parts, places, .. }: &ReceiverSpectrum,
        points: &[PowerSpectrum],
        folder: &dyn ResultFiles,
    ) -> Result<(ReceiverSummary, Option<Audible>), RunError> {
        let levels = over_valid_bands(spectrum);
        let level_of =
            |part: fn(&SoundParts) -> &PowerSpectrum| Some(over_valid_bands(part(parts.as_ref()?)).overall_a);
        let (error, level_a_error) = (self.sound.error_at(receiver), self.level_a_error(receiver, &levels));
        let unknown = || match &self.sound.stated {
            Err(why) => why.to_string(),
            Ok(_) if self.by_slices && self.slice_errors.is_none() => "error by slices not known".to_owned(),
            Ok(_) => format!("error not known: no error is stated below {:.0} Hz, where the level lies", error.from),
        };
        let mut recording = None;
        let mut summary = ReceiverSummary {
            name: receiver.name.clone(),
            points: receiver.points.len(),
            tyres: receiver.vehicle().map(|_| receiver.tyres()),
            level: levels.overall,
            level_a: levels.overall_a,
            vibration_level_a: level_of(|parts| &parts.vibration),
            squeeze_level_a: level_of(|parts| &parts.squeeze),
            voids_spread_a: spread(places.iter().map(|place| over_valid_bands(place).overall_a)),
            level_a_error,
            no_level_a_error: level_a_error.is_none().then(unknown),
            standard_error_a: standard_error_a(spectrum, &levels),
            bands: levels.covered(),
            power_level_a: None,
            pass_by: None,
            no_pass_by: None,
            intensity: None,
            audio: None,
        };
        let audio = self.sound.path.radiation.audio;
        let standard = receiver.standard();
        match standard.finding() {
            Finding::SoundPower(radius) => {
                let squares: Vec<f64> = points[receiver.points.clone()]
                    .iter()
                    .map(|point| mean_square(over_valid_bands(point).overall_a))
                    .collect();
                summary.power_level_a = Some(power_level(Iso3744::power(&squares, radius, &self.sound.path.air)));
            }
            Finding::Directivity => {
                if loaded.scene.outputs.plots {
                    let levels = points[receiver.points.clone()].iter().map(|point| over_valid_bands(point).overall_a);
                    draw_directivity(loaded, receiver, &levels.collect::<Vec<_>>(), folder)?;
                }
            }
            Finding::Passage => {
                let passing = self.passing(receiver, &spectrum.gains);
                let Some((passing, found)) = passing else { return Ok((summary, None)) };
                match found {
                    Err(missing) => summary.no_pass_by = Some(missing),
                    Ok(found) => {
                        summary.pass_by = Some(write_pass_by(loaded, receiver, &passing, &found.levels, folder)?);
                        recording = audio.then(|| Audible::passing(receiver, found));
                    }
                }
            }
            Finding::Intensity(probes) => {
                summary.intensity = self.write_intensity(receiver, &probes, &spectrum.gains, folder)?
            }
            Finding::Level => {}
        }
        if audio && standard.is_recorded() {
            let channels = receiver.points.clone().map(|point| self.at_file_rate(point, &spectrum.gains)).collect();
            let description = "a tyre, at a microphone that moves along";
            recording = Some(Audible { channels, description, tyres: None });
        }
        Ok((summary, recording))
    }

    /// Error of the overall A-weighted level of a receiver \[dB(A)\], where it is known.
    fn level_a_error(&self, receiver: &PlannedReceiver, levels: &SoundLevels) -> Option<f64> {
        let error = self.sound.error_at(receiver);
        self.level_errors(error.of_bands()).overall(error.level_a, &levels.a_weighted)
    }

    pub(super) fn level_errors(&self, numerical: Option<(f64, f64)>) -> LevelErrors {
        LevelErrors::new(numerical, self.by_slices, self.slice_errors.as_ref(), SliceErrors::sound)
    }

    /// Writes the intensity by the pairs of a receiver, whose bands have some gains; `None` where too few pressures are
    /// stored.
    fn write_intensity(
        &self,
        receiver: &PlannedReceiver,
        probes: &Probes,
        gains: &[BandGain],
        folder: &dyn ResultFiles,
    ) -> Result<Option<IntensitySummary>, RunError> {
        let time_step = self.sound.path.layout.time_step;
        // Pressures are early by the whole time steps of each point's delay.
        let delays = receiver.points.clone().map(|point| self.delays[point]);
        let latest = delays.clone().max().unwrap_or(0);
        let signal = |point: usize| -> Vec<f64> {
            let early = latest - self.delays[receiver.points.start + point];
            let signal: Vec<f64> =
                self.signals[receiver.points.start + point].excerpt(0).skip(early as usize).collect();
            let all = LOWEST_FREQUENCY..0.5 / time_step;
            if gains.is_empty() { signal } else { band_pass(&signal, 1.0 / time_step, &all, gains) }
        };
        let (mut rows, mut levels, mut seconds, mut bands) = (Vec::new(), BTreeMap::new(), 0.0, None);
        for (name, [first, second]) in &probes.pairs {
            let signals = [signal(*first), signal(*second)];
            let found = Intensity::of(
                signals.each_ref().map(Vec::as_slice),
                time_step,
                probes.spacing,
                &self.sound.path.air,
                probes.frequencies.clone(),
                [SOUND_SEGMENT, SOUND_FADE],
                self.valid_to,
            );
            let Ok(found) = found else { return Ok(None) };
            seconds = signals[0].len() as f64 * time_step;
            levels.insert((*name).to_owned(), found.level_a());
            let valid: Vec<BandLevel> = found.a_weighted.iter().copied().filter(|band| band.valid).collect();
            bands = CoveredBands::of(&valid);
            for ((band, weighted), index) in found.bands.iter().zip(&found.a_weighted).zip(&found.index) {
                let valid = u8::from(band.valid);
                let middle = band.band.nominal_frequency();
                rows.push(row([name, &middle, &band.mean_square, &band.level, &weighted.level, index, &valid]));
            }
        }
        let header = [
            "probe",
            "nominal_hz",
            "intensity_w_per_m2",
            "level_db_re_1pw_per_m2",
            "level_db_a",
            "pressure_intensity_index_db",
            "valid",
        ];
        let file = format!("intensity_{}.csv", receiver.file);
        folder.write_text(&file, &csv(header, rows))?;
        let known = |level: f64| level.is_finite().then_some(level);
        let level_a = known(energetic_mean(levels.values().copied()));
        let probes = levels.into_iter().map(|(name, level)| (name, known(level))).collect();
        Ok(Some(IntensitySummary { file, level_a, probes, bands, seconds }))
    }

    /// Levels by which runs are compared.
    pub(super) fn rated(&self, spectra: &[ReceiverSpectrum]) -> Vec<RatedLevel> {
        let one = |(receiver, spectrum): (&PlannedReceiver, &ReceiverSpectrum)| {
            let levels = over_valid_bands(&spectrum.spectrum);
            let error = self.level_a_error(receiver, &levels);
            let level = levels.overall_a;
            let mean = TotalLevel::of(levels.a_weighted).map(|mean| TotalLevel { level, error, ..mean });
            let (level, pass_by) = match self.passing(receiver, &spectrum.spectrum.gains) {
                Some((passing, found)) => {
                    let pass_by = found.ok().map(|found| passing.summary(String::new(), &found.levels));
                    let level = mean.zip(pass_by.as_ref()).map(|(mean, pass_by)| mean.at_most(pass_by.maximum));
                    (level, pass_by)
                }
                None => (mean, None),
            };
            RatedLevel { name: receiver.name.clone(), passed: receiver.is_passed(), level, pass_by }
        };
        self.sound.receivers.iter().zip(spectra).map(one).collect()
    }

    /// A receiver that is passed, and its passages or the reason why there is none; `None` for one that is not passed.
    /// Pressures have the gains of their bands.
    fn passing(
        &self,
        receiver: &PlannedReceiver,
        gains: &[BandGain],
    ) -> Option<(Passing, Result<RecordedPassage, String>)> {
        let mut passing = Passing::of(&self.sound, &self.delays, receiver, self.speed, &self.band())?;
        passing.gains = gains.to_vec();
        let stored = self.sound.stored_samples().min(self.signals[receiver.points.start].taken);
        let missing = || passing.missing(&self.sound, stored).unwrap_or_else(|| "no passage".to_owned());
        let found = passing.record(stored, &self.signals).ok_or_else(missing);
        Some((passing, found))
    }

    /// Band of the valid third octaves \[Hz\], to which levels and sound files are restricted.
    pub(super) fn band(&self) -> Range<f64> {
        let bands = ThirdOctaveBand::within(LOWEST_FREQUENCY..0.5 / self.sound.path.layout.time_step);
        let last = bands.iter().rfind(|band| band.is_valid_up_to(self.valid_to));
        let edges = |(first, last): (&ThirdOctaveBand, &ThirdOctaveBand)| first.lower_edge()..last.upper_edge();
        bands.first().zip(last).map_or(LOWEST_FREQUENCY..LOWEST_FREQUENCY, edges)
    }

    fn at_file_rate(&self, point: usize, gains: &[BandGain]) -> Vec<f64> {
        let (signal, rate): (Vec<f64>, f64) =
            (self.signals[point].excerpt(0).collect(), 1.0 / self.sound.path.layout.time_step);
        resample(&band_pass(&signal, rate, &self.band(), gains), rate, FILE_RATE)
    }
}

/// Writes and draws the mean level of all passages over time; returns the summary of their maxima.
fn write_pass_by(
    loaded: &LoadedScene,
    receiver: &PlannedReceiver,
    passing: &Passing,
    levels: &[Vec<f64>],
    folder: &dyn ResultFiles,
) -> Result<PassBySummary, RunError> {
    let (every, middle) = ((FILE_RATE / LEVELS_A_SECOND) as usize, passing.middle());
    let reported: Vec<[f64; 3]> = passing
        .samples()
        .step_by(every)
        .map(|sample| {
            let mean = energetic_mean(levels.iter().map(|levels| levels[sample]));
            [middle.time(sample), middle.place(sample), mean]
        })
        .collect();
    let subject = if receiver.vehicle().is_some() { "vehicle" } else { "tyre" };
    let place = format!("{subject}_ahead_of_microphone_m");
    let rows = reported.iter().map(|&[time, place, level]| [time, -place, level]);
    let text = csv(["time_s", &place, "level_db_a_fast"], rows);
    let file = format!("pass_by_{}.csv", receiver.file);
    folder.write_text(&file, &text)?;
    if loaded.scene.outputs.plots {
        draw_pass_by(loaded, receiver, &reported, folder)?;
    }
    Ok(passing.summary(file, levels))
}

/// Sound of a receiver, before its full scale is known.
struct Audible {
    channels: Vec<Vec<f64>>,
    description: &'static str,
    /// Number of a vehicle's tyres in it.
    tyres: Option<usize>,
}

impl Audible {
    /// A passage; for a vehicle the description has the number of tyres in it.
    fn passing(receiver: &PlannedReceiver, RecordedPassage { sound, sounding, .. }: RecordedPassage) -> Self {
        let description = match (receiver.vehicle(), sounding) {
            (None, _) => "a tyre passing by",
            (Some(_), 1) => "the front left tyre of a vehicle passing by: the run is too short for all four",
            (Some(_), _) => "the four tyres of a vehicle passing by, from four stretches of the run",
        };
        Self { channels: vec![sound], description, tyres: receiver.vehicle().map(|_| sounding) }
    }

    /// Largest magnitude of the pressure \[Pa\].
    fn peak(&self) -> f64 {
        self.channels.iter().flatten().fold(0.0_f64, |peak, pressure| peak.max(pressure.abs()))
    }

    fn write(self, folder: &dyn ResultFiles, file: String, full_scale: f64) -> Result<AudioSummary, RunError> {
        let peak = self.peak();
        let louder = peak * (1.0 + 1e-6) > full_scale;
        let seconds = self.channels.first().map_or(0, Vec::len) as f64 / FILE_RATE;
        let recording = Recording {
            rate: FILE_RATE as u32,
            full_scale,
            format: if louder { SampleFormat::Float32 } else { SampleFormat::Integer24 },
            description: self.description.to_owned(),
            channels: self.channels,
        };
        let unusable = |source| ResultsError::Audio { path: file.clone().into(), source: Box::new(source) };
        folder.write(&file, &recording.to_bytes().map_err(unusable)?)?;
        Ok(AudioSummary { file, full_scale, peak: Some(peak), louder, seconds, tyres: self.tyres })
    }
}
