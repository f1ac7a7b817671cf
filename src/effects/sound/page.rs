//! Sound of a run on a page: levels at the receivers, sounds to play, spectra and pictures.

use crate::effects::section::{Figure, ReportError, SectionBlock, levels, pictures, pictures_of};
use crate::effects::stored::Stored;
use crate::results::sound::{AudioSummary, SOUND_LEVEL};
use crate::sound::wav::rescaled;

/// Peak of a receiver's loudest sound re full scale \[dB\]: as loud as possible with some reserve.
const PLAYED_PEAK: f64 = -3.0;

pub(super) fn figures(stored: &Stored) -> Vec<Figure> {
    let mut figures = Vec::new();
    for receiver in stored.summary.sound.iter().flat_map(|sound| &sound.receivers) {
        let bands = stored.spectrum(SOUND_LEVEL, &receiver.name).map_or(&[][..], |spectrum| &spectrum.levels);
        let rated = receiver.rated(bands);
        figures.extend(Figure::level(format!("level at {}", rated.label()), rated.level));
        if rated.passed {
            figures.extend(Figure::level(format!("mean along the line at {}", receiver.name), receiver.mean(bands)));
        }
    }
    figures
}

/// Full scale at which the sounds of one receiver are played \[Pa\]: the loudest has its peak at [`PLAYED_PEAK`].
fn played_full_scale<'a>(all: impl Iterator<Item = &'a AudioSummary>) -> f64 {
    // Files of earlier versions do not state their peak, which is no larger than their full scale.
    let loudest = all.map(|audio| audio.peak.unwrap_or(audio.full_scale)).fold(0.0, f64::max);
    if loudest > 0.0 { loudest * 10.0_f64.powf(-PLAYED_PEAK / 20.0) } else { 1.0 }
}

/// Blocks of the sound. A receiver has one full scale in all runs of the page, and the players state their gain over
/// the calibrated files: differences in loudness between runs are audible. Each receiver has a separate scale, since
/// levels beside the road are far below those close to the tyre.
pub(super) fn blocks(stored: &Stored, all: &[Stored]) -> Result<Vec<SectionBlock>, ReportError> {
    let Some(sound) = &stored.summary.sound else { return Ok(Vec::new()) };
    let levels_at = sound.receivers.iter().map(|receiver| [receiver.name.clone(), receiver.text()]);
    let mut blocks = vec![SectionBlock::List(levels_at.collect())];
    for receiver in &sound.receivers {
        let Some(audio) = &receiver.audio else { continue };
        let every = all.iter().filter_map(|stored| stored.summary.sound.as_ref()).flat_map(|sound| &sound.receivers);
        let here = every.filter(|other| other.name == receiver.name);
        let full_scale = played_full_scale(here.filter_map(|other| other.audio.as_ref()));
        let mut bytes = stored.bytes(&audio.file)?;
        let mut gain = 0.0;
        if let Some(Ok(shared)) = rescaled(&bytes, full_scale) {
            bytes = shared;
            gain = 20.0 * (audio.full_scale / full_scale).log10();
        }
        let words = format!(
            "{}, {:.1} s, {gain:+.1} dB over the calibrated {}, whose full scale is {} Pa: ",
            receiver.name, audio.seconds, audio.file, audio.full_scale
        );
        blocks.push(SectionBlock::Sound { words, file: audio.file.clone(), bytes });
    }
    blocks.extend(levels(stored, SOUND_LEVEL, "Sound pressure at the receivers, A-weighted third octaves")?);
    let under = "|G| under the patch at the frequency at which a groove has most: ribs are sealed.";
    blocks.extend(pictures(stored, &[["gap.svg", under]])?);
    blocks.extend(pictures_of(stored, "pass_by_", "level while the tyre passes")?);
    blocks.extend(pictures_of(stored, "directivity_", "level over the angle from straight ahead")?);
    Ok(blocks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sounds_of_a_receiver_are_played_at_one_scale() {
        let audio = |full_scale, peak| AudioSummary {
            file: String::new(),
            full_scale,
            peak,
            louder: false,
            seconds: 1.0,
            tyres: None,
        };
        // A coast-by at -28 dB re full scale beside a file at -10 dB.
        let quiet = audio(1.0, Some(0.04));
        let loud = audio(1.0, Some(0.316));
        let scale = played_full_scale([&quiet, &loud].into_iter());
        assert!((20.0 * (0.316 / scale).log10() + 3.0).abs() < 1e-9, "{scale}");
        assert!((20.0 * (0.04 / played_full_scale([&quiet].into_iter())).log10() + 3.0).abs() < 1e-9);
        assert!((played_full_scale([&audio(2.0, None)].into_iter()) - 2.0 * 10.0_f64.powf(0.15)).abs() < 1e-9);
        assert!((played_full_scale([].into_iter()) - 1.0).abs() < 1e-12);
    }
}
