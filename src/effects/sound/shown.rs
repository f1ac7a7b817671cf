//! Sound of a run on a page: levels at the receivers, sounds to play, spectra and pictures.

use crate::effects::section::{Block, Figure, ReportError, levels, pictures, pictures_of};
use crate::effects::stored::Stored;
use crate::results::sound::SOUND_LEVEL;
use crate::sound::wav::rescaled;

/// Tells the levels at the receivers.
pub(super) fn figures(stored: &Stored) -> Vec<Figure> {
    let mut figures = Vec::new();
    for heard in stored.summary.sound.iter().flat_map(|sound| &sound.receivers) {
        let rated = heard.rated();
        figures.extend(Figure::of(format!("level at {}", rated.label()), "dB(A)", rated.level));
        if rated.passed {
            let name = format!("mean along the line at {}", heard.name);
            figures.extend(Figure::of(name, "dB(A)", Some(heard.level_a)));
        }
    }
    figures
}

/// Shows the sound. What is louder in one run of the page than in another is so when it is played.
pub(super) fn blocks(stored: &Stored, all: &[Stored]) -> Result<Vec<Block>, ReportError> {
    let Some(sound) = &stored.summary.sound else { return Ok(Vec::new()) };
    let every = all.iter().filter_map(|stored| stored.summary.sound.as_ref()).flat_map(|sound| &sound.receivers);
    let scales = every.filter_map(|receiver| receiver.audio.as_ref()).map(|audio| audio.full_scale);
    let full_scale = scales.fold(0.0, f64::max);
    let levels_at = sound.receivers.iter().map(|heard| [heard.name.clone(), heard.text()]);
    let mut blocks = vec![Block::List(levels_at.collect())];
    for heard in &sound.receivers {
        let Some(audio) = &heard.audio else { continue };
        let mut bytes = stored.bytes(&audio.file)?;
        if audio.full_scale < full_scale
            && let Some(Ok(shared)) = rescaled(&bytes, full_scale)
        {
            bytes = shared;
        }
        let words = format!("{}, {:.1} s, full scale {full_scale} Pa: ", heard.name, audio.seconds);
        blocks.push(Block::Sound { words, file: audio.file.clone(), bytes });
    }
    blocks.extend(levels(stored, SOUND_LEVEL, "Sound pressure at the receivers, A-weighted third octaves")?);
    let under = "|G| under the patch at the frequency at which a groove has most: ribs are sealed.";
    blocks.extend(pictures(stored, &[["gap.svg", under]])?);
    blocks.extend(pictures_of(stored, "pass_by_", "level while the tyre passes")?);
    blocks.extend(pictures_of(stored, "directivity_", "level over the angle from straight ahead")?);
    Ok(blocks)
}
