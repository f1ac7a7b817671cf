//! What a run's sound is written as: tables, pictures, files to listen to, the summary.

use crate::numeric::in_parallel;
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
use crate::run::sound::passing::{HeardPassing, Passing};
use crate::run::sound::pictures::{draw_directivity, draw_levels, draw_pass_by};
use crate::scene::{LoadedScene, ReceiverPlace, StandardReceiver};
use crate::sound::levels::{REFERENCE_PRESSURE, energetic_mean, mean_square};
use crate::sound::power::{Iso3744, power_level};
use crate::sound::resample::{FILE_RATE, resample};
use crate::sound::wav::{SampleFormat, WavError, full_scale_for};
use crate::sound::{Recording, SoundLevels};

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
        folder.write_text(SOUND_FILE, &sound_levels_csv(&spectra, LOWEST_FREQUENCY))?;
        folder.write_text(SOUND_NARROW_FILE, &sound_narrow_csv(&spectra))?;
        let mut receivers = Vec::new();
        for (heard, spectrum) in self.sound.heard.iter().zip(&spectra) {
            let summary = self.receiver(loaded, heard, &spectrum.spectrum, &points, folder)?;
            receivers.push(summary);
        }
        if loaded.scene.outputs.plots {
            draw_levels(loaded, &spectra, &error, folder)?;
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
        let finished = |spectrum: &SpectrumAccumulator| Ok(spectrum.clone().finish()?.valid_to(self.valid_to));
        in_parallel::map(&self.spectra, finished).into_iter().collect()
    }

    /// By receiver the mean over its points, times the tyres that it hears: lines of points have as many each.
    pub(super) fn receiver_spectra(&self, points: &[PowerSpectrum]) -> Vec<ReceiverSpectrum> {
        let one = |heard: &Heard| {
            let mut spectrum = mean(&points[heard.points.clone()])?;
            let tyres = heard.tyres() as f64;
            spectrum.power.iter_mut().for_each(|power| *power *= tyres);
            Some(ReceiverSpectrum { name: heard.name.clone(), spectrum, error: self.sound.error_at(heard) })
        };
        self.sound.heard.iter().filter_map(one).collect()
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
            tyres: heard.vehicle().map(|_| heard.tyres()),
            level: levels.overall,
            level_a: levels.overall_a,
            level_a_error: self.sound.error_at(heard).level_a,
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
                let kept = self.sound.kept_samples().min(self.signals[heard.points.start].taken());
                let Some(passing) = Passing::of(&self.sound, &self.way, heard, loaded.scene.rolling.speed()) else {
                    return Ok(summary);
                };
                summary.no_pass_by = passing.missing(&self.sound, kept);
                if let Some(found) = passing.hear(kept, &self.signals) {
                    summary.pass_by = Some(write_pass_by(loaded, heard, &passing, &found.levels, folder)?);
                    if audio {
                        summary.audio = Some(write_passing_audio(folder, heard, found)?);
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
        let signal: Vec<f64> = self.signals[point].excerpt(0).collect();
        resample(&signal, 1.0 / self.sound.layout.time_step, FILE_RATE)
    }
}

/// Levels of all passages against time, written and drawn; their maxima.
fn write_pass_by(
    loaded: &LoadedScene,
    heard: &Heard,
    passing: &Passing,
    levels: &[Vec<f64>],
    folder: &ResultsFolder,
) -> Result<PassBySummary, RunError> {
    let maxima: Vec<f64> = levels.iter().filter_map(|levels| passing.highest(levels)).collect();
    let maximum = maxima.iter().sum::<f64>() / maxima.len() as f64;
    let spread = maxima.iter().map(|level| (level - maximum).powi(2)).sum::<f64>();
    let deviation = if maxima.len() > 1 { (spread / (maxima.len() - 1) as f64).sqrt() } else { 0.0 };
    let (every, middle) = ((FILE_RATE / LEVELS_A_SECOND) as usize, passing.middle());
    let told: Vec<[f64; 3]> = passing
        .samples()
        .step_by(every)
        .map(|sample| {
            let mean = energetic_mean(levels.iter().map(|levels| levels[sample]));
            [middle.time(sample), middle.place(sample), mean]
        })
        .collect();
    let who = if heard.vehicle().is_some() { "vehicle" } else { "tyre" };
    let place = format!("{who}_ahead_of_microphone_m");
    let rows = told.iter().map(|&[time, place, level]| [time, -place, level]);
    let text = csv(["time_s", &place, "level_db_a_fast"], rows);
    folder.write_text(&format!("pass_by_{}.csv", heard.file), &text)?;
    if loaded.scene.outputs.plots {
        draw_pass_by(loaded, heard, &told, folder)?;
    }
    Ok(PassBySummary { passages: levels.len(), maximum, deviation })
}

/// The file to listen to of a passage; of a vehicle it says how many tyres are in it.
fn write_passing_audio(
    folder: &ResultsFolder,
    heard: &Heard,
    HeardPassing { sound, sounding, .. }: HeardPassing,
) -> Result<AudioSummary, RunError> {
    let description = match (heard.vehicle(), sounding) {
        (None, _) => "a tyre passing by",
        (Some(_), 1) => "the front left tyre of a vehicle passing by: the run is too short for all four",
        (Some(_), _) => "the four tyres of a vehicle passing by, from four stretches of the run",
    };
    let audio = write_audio(folder, &heard.file, vec![sound], description)?;
    Ok(AudioSummary { tyres: heard.vehicle().map(|_| sounding), ..audio })
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
    Ok(AudioSummary { file, full_scale: recording.full_scale, seconds, tyres: None })
}
