//! Sound files: WAV, 24 bit or 32 bit floats, with their calibration.
//!
//! Players expect samples from -1 to 1. The pressure that corresponds to 1 is in the file itself, in a LIST chunk of
//! kind INFO behind the samples (Microsoft and IBM, *Multimedia Programming Interface and Data Specifications 1.0*,
//! 1991), which players show or skip:
//!
//! - `ISFT`: the program;
//! - `ICMT`: `full scale = 2 Pa; ` and a description of the sound. The number is written so that it is read back to the
//!   last bit.
//!
//! A sample s of a 24-bit file is s/2^23 of full scale; a float is a fraction of full scale.

use std::io::{self, Cursor};
use std::path::Path;

use hound::{WavReader, WavSpec, WavWriter};
use thiserror::Error;

use crate::storage::PendingFile;

/// Format of the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SampleFormat {
    /// Integers of 24 bits: read by every player; rounding noise 146 dB below full scale.
    #[default]
    Integer24,
    /// Floats of 32 bits: nothing is cut off above full scale.
    Float32,
}

/// Error of a sound file.
#[derive(Debug, Error)]
pub enum WavError {
    /// No channel, more than a file can have, or channels of different lengths.
    #[error("a sound file needs one channel or several of the same length, not lengths {lengths:?}")]
    Channels {
        /// Number of samples of each channel.
        lengths: Vec<usize>,
    },
    /// A full scale that is not a positive pressure.
    #[error("full scale must be a positive pressure, not {full_scale} Pa")]
    FullScale {
        /// Value given \[Pa\].
        full_scale: f64,
    },
    /// A pressure that is not finite, or beyond full scale in integers.
    #[error("sample {sample} of channel {channel} is {pressure} Pa, full scale is {full_scale} Pa")]
    Overload {
        /// Index of the channel, from 0.
        channel: usize,
        /// Index of the sample, from 0.
        sample: usize,
        /// Pressure of the sample \[Pa\].
        pressure: f64,
        /// Full scale of the file \[Pa\].
        full_scale: f64,
    },
    /// More than the 4 GiB that the format allows.
    #[error("a sound file cannot hold {bytes} bytes")]
    TooLong {
        /// Size of the file \[bytes\].
        bytes: u64,
    },
    /// Error of the encoder.
    #[error("the sound file cannot be made")]
    Encode(#[from] hound::Error),
    /// Error of the file system.
    #[error("the sound file cannot be written")]
    Write(#[from] io::Error),
}

/// A sound and its calibration.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Samples a second.
    pub rate: u32,
    /// Pressures of each channel \[Pa\]: one, or left and right.
    pub channels: Vec<Vec<f64>>,
    /// Pressure that is 1 in the file \[Pa\].
    pub full_scale: f64,
    /// Format of the samples.
    pub format: SampleFormat,
    /// Description of the sound for the comment of the file: ASCII, no line breaks.
    pub description: String,
}

/// Full scale as an integer of 24 bits.
const SCALE_24: f64 = 8_388_608.0;

/// Begin of `ICMT`.
const CALIBRATION: &str = "full scale = ";

/// Smallest of 1, 2, 5, 10, ... Pa (and their decimal parts) that holds pressures up to a peak \[Pa\]: files of similar
/// sounds get the same, and can be compared by ear. 1 Pa for silence.
pub fn full_scale_for(peak: f64) -> f64 {
    if !(peak.is_finite() && peak > 0.0) {
        return 1.0;
    }
    // Slightly above the peak: 24 bits cannot hold +1.
    let peak = peak * (1.0 + 1e-6);
    let power = peak.log10().floor() as i32;
    let decade = |power: i32| if power < 0 { 1.0 / 10.0_f64.powi(-power) } else { 10.0_f64.powi(power) };
    let steps = [decade(power), 2.0 * decade(power), 5.0 * decade(power)];
    steps.into_iter().find(|step| *step >= peak).unwrap_or(decade(power + 1))
}

impl Recording {
    /// Content of the file.
    ///
    /// # Errors
    /// [`WavError`], but not [`WavError::Write`].
    pub fn to_bytes(&self) -> Result<Vec<u8>, WavError> {
        let lengths: Vec<usize> = self.channels.iter().map(Vec::len).collect();
        let channels = u16::try_from(lengths.len()).ok().filter(|_| lengths.windows(2).all(|pair| pair[0] == pair[1]));
        let (Some(channels), Some(&samples)) = (channels, lengths.first()) else {
            return Err(WavError::Channels { lengths });
        };
        let full_scale = self.full_scale;
        if !(full_scale.is_finite() && full_scale > 0.0) {
            return Err(WavError::FullScale { full_scale });
        }
        let (bits_per_sample, sample_format) = match self.format {
            SampleFormat::Integer24 => (24, hound::SampleFormat::Int),
            SampleFormat::Float32 => (32, hound::SampleFormat::Float),
        };
        let information = information(full_scale, &self.description);
        // 1024 bytes are more than all headers.
        let bytes = samples as u64 * u64::from(channels) * u64::from(bits_per_sample / 8) + information.len() as u64;
        if bytes > u64::from(u32::MAX - 1024) {
            return Err(WavError::TooLong { bytes });
        }
        let spec = WavSpec { channels, sample_rate: self.rate, bits_per_sample, sample_format };
        let mut file = Cursor::new(Vec::new());
        let mut writer = WavWriter::new(&mut file, spec)?;
        for sample in 0..samples {
            for (channel, pressures) in self.channels.iter().enumerate() {
                let pressure = pressures[sample];
                let part = pressure / full_scale;
                let overload = WavError::Overload { channel, sample, pressure, full_scale };
                match self.format {
                    SampleFormat::Integer24 => {
                        let value = (part * SCALE_24).round();
                        if !(-SCALE_24..SCALE_24).contains(&value) {
                            return Err(overload);
                        }
                        writer.write_sample(value as i32)?;
                    }
                    SampleFormat::Float32 => {
                        if !part.is_finite() {
                            return Err(overload);
                        }
                        writer.write_sample(part as f32)?;
                    }
                }
            }
        }
        writer.finalize()?;
        Ok(with_chunk(file.into_inner(), &information))
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// [`WavError`].
    pub fn write(&self, path: &Path) -> Result<(), WavError> {
        let bytes = self.to_bytes()?;
        Ok(PendingFile::create(path)?.complete(bytes)?)
    }
}

/// A file of [`Recording::to_bytes`] with another full scale \[Pa\], which must be large enough for its peak; `None`
/// for any other file.
pub(crate) fn rescaled(file: &[u8], full_scale: f64) -> Option<Result<Vec<u8>, WavError>> {
    Some(Recording { full_scale, ..recording(file)? }.to_bytes())
}

/// Reads a file of [`Recording::to_bytes`]; `None` for any other file.
pub(crate) fn recording(file: &[u8]) -> Option<Recording> {
    let full_scale = full_scale_of(file)?;
    let comment = chunk(chunk(file.get(12..)?, b"LIST")?.strip_prefix(b"INFO")?, b"ICMT")?;
    let description = std::str::from_utf8(comment).ok()?.split_once("; ")?.1.trim_end_matches('\0').to_owned();
    let mut reader = WavReader::new(file).ok()?;
    let WavSpec { channels, sample_rate: rate, sample_format, .. } = reader.spec();
    let (format, parts) = match sample_format {
        hound::SampleFormat::Int => {
            let parts = reader.samples::<i32>().map(|sample| Some(f64::from(sample.ok()?) / SCALE_24));
            (SampleFormat::Integer24, parts.collect::<Option<Vec<f64>>>()?)
        }
        hound::SampleFormat::Float => {
            let parts = reader.samples::<f32>().map(|sample| Some(f64::from(sample.ok()?)));
            (SampleFormat::Float32, parts.collect::<Option<Vec<f64>>>()?)
        }
    };
    let channel = |number: usize| {
        parts.iter().skip(number).step_by(usize::from(channels)).map(|part| full_scale * part).collect::<Vec<f64>>()
    };
    let channels = (0..usize::from(channels)).map(channel).collect();
    Some(Recording { rate, channels, full_scale, format, description })
}

/// Pressure of full scale \[Pa\] from the content of a file; `None` without a calibration in the form of
/// `super::wav`.
pub fn full_scale_of(file: &[u8]) -> Option<f64> {
    let list = chunk(file.get(12..)?, b"LIST")?;
    let comment = chunk(list.strip_prefix(b"INFO")?, b"ICMT")?;
    let text = std::str::from_utf8(comment).ok()?;
    text.strip_prefix(CALIBRATION)?.split(" Pa").next()?.parse().ok()
}

/// Content of the LIST chunk of kind INFO.
fn information(full_scale: f64, description: &str) -> Vec<u8> {
    let plain: String = description.chars().map(|c| if c.is_ascii() && !c.is_control() { c } else { '?' }).collect();
    let comment = format!("{CALIBRATION}{full_scale} Pa; {plain}");
    let program = concat!("tyrewave ", env!("CARGO_PKG_VERSION"));
    let mut content = b"INFO".to_vec();
    for (name, text) in [(b"ISFT", program), (b"ICMT", comment.as_str())] {
        // Texts end with a zero, which counts.
        push_chunk(&mut content, name, &[text.as_bytes(), b"\0"].concat());
    }
    content
}

/// The file with a LIST chunk at its end, and its size corrected.
fn with_chunk(mut file: Vec<u8>, content: &[u8]) -> Vec<u8> {
    // Chunks begin at even offsets.
    if file.len() % 2 == 1 {
        file.push(0);
    }
    push_chunk(&mut file, b"LIST", content);
    let size = (file.len() - 8) as u32;
    file[4..8].copy_from_slice(&size.to_le_bytes());
    file
}

fn push_chunk(file: &mut Vec<u8>, name: &[u8; 4], content: &[u8]) {
    file.extend(name);
    file.extend((content.len() as u32).to_le_bytes());
    file.extend(content);
    if content.len() % 2 == 1 {
        file.push(0);
    }
}

/// Content of the first chunk of a name; `None` if there is none, or it is cut off.
fn chunk<'a>(mut chunks: &'a [u8], name: &[u8; 4]) -> Option<&'a [u8]> {
    loop {
        let (head, rest) = chunks.split_first_chunk::<4>()?;
        let (size, rest) = rest.split_first_chunk::<4>()?;
        let size = u32::from_le_bytes(*size) as usize;
        let content = rest.get(..size)?;
        if head == name {
            return Some(content);
        }
        chunks = rest.get(size + size % 2..)?;
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn recording(format: SampleFormat, channels: usize, samples: usize) -> Recording {
        let tone =
            |channel: usize| (0..samples).map(|n| 1.5 * (TAU * n as f64 * 0.01 * (channel + 1) as f64).sin()).collect();
        Recording {
            rate: 48_000,
            channels: (0..channels).map(tone).collect(),
            full_scale: 2.0,
            format,
            description: "a tone at 7.5 m".into(),
        }
    }

    #[test]
    fn a_file_is_read_back_with_its_pressures_and_its_calibration() {
        for (format, error) in [(SampleFormat::Integer24, 2.0 / SCALE_24), (SampleFormat::Float32, 2e-7)] {
            // 333 samples of three bytes: an odd number, which needs padding before the calibration.
            for channels in [1, 2] {
                let recording = recording(format, channels, 333);
                let bytes = recording.to_bytes().unwrap();
                assert_eq!(bytes.len() % 2, 0);
                assert_eq!(u32::from_le_bytes(bytes[4..8].try_into().unwrap()) as usize + 8, bytes.len());
                let mut reader = hound::WavReader::new(Cursor::new(&bytes)).unwrap();
                assert_eq!((reader.spec().channels as usize, reader.spec().sample_rate), (channels, 48_000));
                let full_scale = full_scale_of(&bytes).unwrap();
                assert_eq!(full_scale.to_bits(), 2.0_f64.to_bits());
                let read: Vec<f64> = match format {
                    SampleFormat::Integer24 => {
                        assert_eq!(reader.spec().bits_per_sample, 24);
                        reader.samples::<i32>().map(|s| f64::from(s.unwrap()) / SCALE_24 * full_scale).collect()
                    }
                    SampleFormat::Float32 => {
                        reader.samples::<f32>().map(|s| f64::from(s.unwrap()) * full_scale).collect()
                    }
                };
                assert_eq!(read.len(), 333 * channels);
                for (place, pressure) in read.into_iter().enumerate() {
                    let exact = recording.channels[place % channels][place / channels];
                    assert!((pressure - exact).abs() <= 0.5 * error, "{place}: {pressure} for {exact}");
                }
            }
        }
    }

    #[test]
    fn a_calibration_survives_and_its_absence_is_reported() {
        for full_scale in [0.1, 1.0 / 3.0, 6.02e-3, 20.0, 1e-12] {
            let recording = Recording { full_scale, ..recording(SampleFormat::Float32, 1, 8) };
            let found = full_scale_of(&recording.to_bytes().unwrap()).unwrap();
            assert_eq!(found.to_bits(), full_scale.to_bits());
        }
        let bytes = recording(SampleFormat::Integer24, 1, 8).to_bytes().unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.contains("full scale = 2 Pa; a tone at 7.5 m") && text.contains("ISFT"));
        for end in 0..bytes.len() - 24 {
            assert_eq!(full_scale_of(&bytes[..end]), None, "cut after {end} bytes");
        }
    }

    #[test]
    fn another_full_scale_has_the_same_pressures_and_words() {
        for format in [SampleFormat::Integer24, SampleFormat::Float32] {
            let recording = recording(format, 2, 333);
            let again = rescaled(&recording.to_bytes().unwrap(), 5.0).unwrap().unwrap();
            assert!(full_scale_of(&again).is_some_and(|scale| (scale - 5.0).abs() < 1e-12));
            assert!(String::from_utf8_lossy(&again).contains("full scale = 5 Pa; a tone at 7.5 m\0"));
            let mut reader = hound::WavReader::new(Cursor::new(&again)).unwrap();
            let parts: Vec<f64> = match format {
                SampleFormat::Integer24 => reader.samples::<i32>().map(|s| f64::from(s.unwrap()) / SCALE_24).collect(),
                SampleFormat::Float32 => reader.samples::<f32>().map(|s| f64::from(s.unwrap())).collect(),
            };
            assert_eq!(parts.len(), 666);
            for (place, part) in parts.into_iter().enumerate() {
                let exact = recording.channels[place % 2][place / 2];
                assert!((5.0 * part - exact).abs() < 1e-6, "{place}: {part} for {exact} Pa");
            }
        }
        assert!(rescaled(b"RIFF", 5.0).is_none());
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let loud = Recording { full_scale: 1.4, ..recording(SampleFormat::Integer24, 1, 100) };
        let error = loud.to_bytes().unwrap_err();
        assert!(matches!(error, WavError::Overload { channel: 0, sample: 20, .. }), "{error}");
        assert!(Recording { format: SampleFormat::Float32, ..loud.clone() }.to_bytes().is_ok());
        let broken = Recording { channels: vec![vec![f64::NAN]], ..loud.clone() };
        for format in [SampleFormat::Float32, SampleFormat::Integer24] {
            let broken = Recording { format, ..broken.clone() };
            assert!(matches!(broken.to_bytes(), Err(WavError::Overload { .. })));
        }
        for channels in [vec![], vec![vec![0.0; 2], vec![0.0; 3]]] {
            let wrong = Recording { channels, ..loud.clone() };
            assert!(matches!(wrong.to_bytes(), Err(WavError::Channels { .. })));
        }
        for full_scale in [0.0, -1.0, f64::NAN] {
            let wrong = Recording { full_scale, ..loud.clone() };
            assert!(matches!(wrong.to_bytes(), Err(WavError::FullScale { .. })));
        }
    }

    #[test]
    fn full_scale_goes_in_steps_that_hold_the_peak() {
        for (peak, step) in
            [(0.9, 1.0), (1.0, 2.0), (1.1, 2.0), (3.0, 5.0), (7.0, 10.0), (0.013, 0.02), (0.07, 0.1), (45.0, 50.0)]
        {
            let found = full_scale_for(peak);
            assert!((found / step - 1.0).abs() < 1e-12, "{peak} Pa: {found} Pa");
        }
        for silence in [0.0, f64::NAN] {
            assert!((full_scale_for(silence) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_file_is_written_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tone.wav");
        let loud = Recording { full_scale: 1.0, ..recording(SampleFormat::Integer24, 2, 100) };
        assert!(loud.write(&path).is_err() && std::fs::read_dir(folder.path()).unwrap().next().is_none());
        let recording = recording(SampleFormat::Integer24, 2, 100);
        recording.write(&path).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), recording.to_bytes().unwrap());
        assert!(matches!(recording.write(&folder.path().join("none/tone.wav")), Err(WavError::Write(_))));
    }
}
