//! What a run's sound is written as: tables, pictures, files to listen to, the summary.

use crate::plan::Heard;
use crate::response::{PowerSpectrum, SpectrumAccumulator};
use crate::results::ResultsError;
use crate::results::folder::ResultsFolder;
use crate::results::sound::{
    AudioSummary, PassBySummary, ReceiverSpectrum, ReceiverSummary, SOUND_FILE, SOUND_NARROW_FILE, SoundSummary,
    sound_levels_csv, sound_narrow_csv,
};
use crate::results::spectra::LOWEST_FREQUENCY;
use crate::results::table::csv;
use crate::run::error::RunError;
use crate::run::sound::SoundRecorder;
use crate::run::sound::passages::Passages;
use crate::run::sound::pictures::{draw_directivity, draw_levels, draw_pass_by};
use crate::scene::{LoadedScene, ReceiverPlace, StandardReceiver};
use crate::sound::detector::meter_levels;
use crate::sound::levels::{REFERENCE_PRESSURE, energetic_mean, mean_square};
use crate::sound::power::{Iso3744, power_level};
use crate::sound::receivers::COAST_BY_HALF_LENGTH;
use crate::sound::resample::{FILE_RATE, resample};
use crate::sound::wav::{SampleFormat, WavError, full_scale_for};
use crate::sound::{FrequencyWeighting, Recording, SoundLevels, TimeWeighting};

/// Points of a pass-by's level that are written and drawn, a second.
const LEVELS_A_SECOND: f64 = 200.0;

impl SoundRecorder {
    /// Writes levels, pictures and sounds of a complete run; what the summary says of them.
    ///
    /// # Errors
    /// Of the files and pictures.
    pub fn write(&self, loaded: &LoadedScene, folder: &ResultsFolder) -> Result<SoundSummary, RunError> {
        let points = self.point_spectra()?;
        let spectra = self.receiver_spectra(&points);
        let error = self.sound.error();
        folder.write_text(SOUND_FILE, &sound_levels_csv(&spectra, LOWEST_FREQUENCY, &error))?;
        folder.write_text(SOUND_NARROW_FILE, &sound_narrow_csv(&spectra))?;
        let mut receivers = Vec::new();
        for (heard, spectrum) in self.sound.heard.iter().zip(&spectra) {
            let summary = self.receiver(loaded, heard, &spectrum.spectrum, &points, folder)?;
            receivers.push(summary);
        }
        if loaded.scene.outputs.plots {
            draw_levels(loaded, &spectra, folder)?;
        }
        Ok(SoundSummary {
            reference: REFERENCE_PRESSURE,
            highest: self.sound.radiation.fmax,
            body: self.way.body.clone(),
            error,
            receivers,
        })
    }

    /// Spectra at all points.
    pub(super) fn point_spectra(&self) -> Result<Vec<PowerSpectrum>, RunError> {
        let finished = |spectrum: &SpectrumAccumulator| spectrum.clone().finish();
        let all: Result<Vec<_>, _> = self.spectra.iter().map(finished).collect();
        Ok(all?.into_iter().map(|spectrum| spectrum.valid_to(self.valid_to)).collect())
    }

    /// By receiver the mean over its points.
    pub(super) fn receiver_spectra(&self, points: &[PowerSpectrum]) -> Vec<ReceiverSpectrum> {
        let receivers = self.sound.heard.iter().filter_map(|heard| Some((heard, mean(&points[heard.points.clone()])?)));
        receivers.map(|(heard, spectrum)| ReceiverSpectrum { name: heard.name.clone(), spectrum }).collect()
    }

    fn receiver(
        &self,
        loaded: &LoadedScene,
        heard: &Heard,
        spectrum: &PowerSpectrum,
        points: &[PowerSpectrum],
        folder: &ResultsFolder,
    ) -> Result<ReceiverSummary, RunError> {
        let levels = vouched(spectrum);
        let mut summary = ReceiverSummary {
            name: heard.name.clone(),
            points: heard.points.len(),
            level: levels.overall,
            level_a: levels.overall_a,
            level_a_error: self.sound.error().level_a,
            power_level_a: None,
            pass_by: None,
            no_pass_by: None,
            audio: None,
        };
        let audio = self.sound.radiation.audio;
        match heard.place {
            ReceiverPlace::Standard(StandardReceiver::Hemisphere { radius }) => {
                let squares: Vec<f64> =
                    points[heard.points.clone()].iter().map(|point| mean_square(vouched(point).overall_a)).collect();
                summary.power_level_a = Some(power_level(Iso3744::power(&squares, radius, &self.way.air)));
            }
            ReceiverPlace::Standard(StandardReceiver::Circle { .. }) => {
                if loaded.scene.outputs.plots {
                    let levels = points[heard.points.clone()].iter().map(|point| vouched(point).overall_a);
                    draw_directivity(loaded, heard, &levels.collect::<Vec<_>>(), folder)?;
                }
            }
            ReceiverPlace::Standard(StandardReceiver::CoastBy { .. }) => {
                let kept = self.signals[heard.points.start].len();
                summary.no_pass_by =
                    self.passages(loaded, heard).and_then(|passages| passages.missing(&self.sound, kept));
                if let Some((pass_by, sound)) = self.pass_by(loaded, heard, folder)? {
                    summary.pass_by = Some(pass_by);
                    if audio {
                        summary.audio = Some(write_audio(folder, &heard.file, vec![sound], "a tyre passing by")?);
                    }
                }
            }
            ReceiverPlace::Position { .. } | ReceiverPlace::Standard(StandardReceiver::Cpx) => {
                if audio {
                    let channels: Vec<Vec<f64>> = heard.points.clone().map(|point| self.at_file_rate(point)).collect();
                    summary.audio = Some(write_audio(folder, &heard.file, channels, "a tyre, heard moving along")?);
                }
            }
        }
        Ok(summary)
    }

    fn at_file_rate(&self, point: usize) -> Vec<f64> {
        let signal: Vec<f64> = self.signals[point].iter().map(|&pressure| f64::from(pressure)).collect();
        resample(&signal, 1.0 / self.sound.layout.time_step, FILE_RATE)
    }

    fn passages(&self, loaded: &LoadedScene, heard: &Heard) -> Option<Passages> {
        Passages::of(&self.sound, &self.way, heard, loaded.scene.rolling.speed())
    }

    /// All passages that the kept pressures hold, one after the other: levels against time are written and drawn; the
    /// maxima, and what is heard of the first passage.
    fn pass_by(
        &self,
        loaded: &LoadedScene,
        heard: &Heard,
        folder: &ResultsFolder,
    ) -> Result<Option<(PassBySummary, Vec<f64>)>, RunError> {
        let Some(passages) = self.passages(loaded, heard) else { return Ok(None) };
        let passing = &passages.passing;
        let kept = self.signals[heard.points.start].len();
        let mut levels: Vec<Vec<f64>> = Vec::new();
        let mut sound = Vec::new();
        for passage in 0..passages.within(kept) {
            let pressures = passing.synthesise(|receiver, _| {
                let signal = &self.signals[heard.points.start + receiver];
                signal[passages.samples(passage, receiver)].iter().map(|&pressure| f64::from(pressure)).collect()
            });
            let Ok(pressures) = pressures else { return Ok(None) };
            // The line begins 6 m before what is read: at 80 km/h the detector is half a decibel from settled there.
            let shown = meter_levels(&pressures, FILE_RATE, FrequencyWeighting::A, TimeWeighting::Fast);
            let Ok(shown) = shown else { return Ok(None) };
            levels.push(shown);
            if sound.is_empty() {
                sound = pressures;
            }
        }
        if levels.is_empty() {
            return Ok(None);
        }
        let maxima: Vec<f64> =
            levels.iter().filter_map(|levels| Some(passing.highest(levels, COAST_BY_HALF_LENGTH)?.1)).collect();
        let maximum = maxima.iter().sum::<f64>() / maxima.len() as f64;
        let spread = maxima.iter().map(|level| (level - maximum).powi(2)).sum::<f64>();
        let deviation = if maxima.len() > 1 { (spread / (maxima.len() - 1) as f64).sqrt() } else { 0.0 };
        let every = (FILE_RATE / LEVELS_A_SECOND) as usize;
        let told: Vec<[f64; 3]> = (0..passing.samples())
            .step_by(every)
            .map(|sample| {
                let mean = energetic_mean(levels.iter().map(|levels| levels[sample]));
                [passing.time(sample), passing.place(sample), mean]
            })
            .collect();
        let rows = told.iter().map(|&[time, place, level]| [time, -place, level]);
        let text = csv(["time_s", "tyre_ahead_of_microphone_m", "level_db_a_fast"], rows);
        folder.write_text(&format!("pass_by_{}.csv", heard.file), &text)?;
        if loaded.scene.outputs.plots {
            draw_pass_by(loaded, heard, &told, folder)?;
        }
        Ok(Some((PassBySummary { passages: levels.len(), maximum, deviation }, sound)))
    }
}

/// Levels, the overall ones of what the run vouches for.
fn vouched(spectrum: &PowerSpectrum) -> SoundLevels {
    SoundLevels::of(spectrum, LOWEST_FREQUENCY..f64::INFINITY).vouched()
}

/// The mean of spectra over the same frequencies; `None` of none.
fn mean(spectra: &[PowerSpectrum]) -> Option<PowerSpectrum> {
    let mut mean = spectra.first()?.clone();
    for (bin, power) in mean.power.iter_mut().enumerate() {
        *power = spectra.iter().map(|spectrum| spectrum.power[bin]).sum::<f64>() / spectra.len() as f64;
    }
    Some(mean)
}

fn write_audio(
    folder: &ResultsFolder,
    name: &str,
    channels: Vec<Vec<f64>>,
    description: &str,
) -> Result<AudioSummary, RunError> {
    let peak = channels.iter().flatten().fold(0.0_f64, |peak, pressure| peak.max(pressure.abs()));
    let seconds = channels.first().map_or(0, Vec::len) as f64 / FILE_RATE;
    let file = format!("sound_{name}.wav");
    let recording = Recording {
        rate: FILE_RATE as u32,
        channels,
        full_scale: full_scale_for(peak),
        format: SampleFormat::Integer24,
        description: description.to_owned(),
    };
    let path = folder.path(&file);
    recording.write(&path).map_err(|source| match source {
        WavError::Write(source) => ResultsError::Write { path, source },
        other => ResultsError::Audio { path, source: Box::new(other) },
    })?;
    Ok(AudioSummary { file, full_scale: recording.full_scale, seconds })
}
