//! Third-octave spectra as steps over a logarithmic axis with the nominal frequencies (Larsson's figure 6).

use super::PlotError;
use super::axis::{Axis, four_digits};
use super::colour::{self, INK};
use super::layout::{EDGE, Key};
use super::sheet::{Frame, Point, Sheet};
use crate::response::third_octave::ThirdOctaveBand;
use crate::response::{BandLevel, LevelErrors};

/// Height of the frame in shown pixels.
const HEIGHT: f64 = 280.0;
/// Levels further below the highest than this do not widen the axis \[dB\].
const DEEPEST: f64 = 90.0;

/// One or several spectra over common bands.
#[derive(Clone, Debug)]
pub struct ThirdOctavePlot<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// Quantity of the levels, reference included: `Force level [dB re 1 N]`.
    pub quantity: &'a str,
    /// Name for the legend (may be empty) and levels, bands rising without a gap.
    pub spectra: Vec<(&'a str, &'a [BandLevel])>,
    /// Errors of valid levels, for all spectra.
    pub errors: LevelErrors,
}

impl ThirdOctavePlot<'_> {
    /// The picture as SVG: one spectrum as bars, several as steps; grey for levels that are not valid.
    ///
    /// # Errors
    /// [`PlotError`] without a band.
    pub fn to_svg(&self) -> Result<String, PlotError> {
        self.to_svg_with(&vec![&self.errors; self.spectra.len()])
    }

    /// The same picture for spectra with separate errors, in their order.
    ///
    /// # Errors
    /// As [`Self::to_svg`].
    pub(crate) fn to_svg_with(&self, errors: &[&LevelErrors]) -> Result<String, PlotError> {
        let bands = || self.spectra.iter().flat_map(|(_, levels)| levels.iter()).map(|level| level.band.0);
        let (Some(first), Some(last)) = (bands().min(), bands().max()) else {
            return Err(PlotError { picture: "a third-octave spectrum", quantity: "levels", expected: 1, got: 0 });
        };
        let (x, y) = (frequency_axis(first, last), self.level_axis());
        let mut sheet = Sheet::default();
        let axes = sheet.axes(self.title, [&x, &y], HEIGHT, EDGE);
        let one = self.spectra.len() == 1;
        for (index, (_, levels)) in self.spectra.iter().enumerate() {
            let colour = colour::line(index);
            // Levels of silence have no end.
            let ends = |level: &BandLevel, half: f64| -> [Point; 2] {
                let top = level.level.max(y.range.start);
                [-half, half].map(|side| axes.within((f64::from(level.band.0) + side, top)))
            };
            let steps = |levels: &[BandLevel]| levels.iter().flat_map(|level| ends(level, 0.5)).collect::<Vec<_>>();
            if one {
                for level in *levels {
                    let [(left, top), (right, _)] = ends(level, 0.42);
                    let bar = Frame { left, top, width: right - left, height: axes.frame.up(0.0) - top };
                    sheet.fill(bar, if level.valid { colour } else { colour::INVALID });
                }
            } else {
                // All bands in grey where some are not valid; the valid ones lie over it.
                if levels.iter().any(|level| !level.valid) {
                    sheet.line(&steps(levels), colour::INVALID, 2.0);
                }
                for valid in levels.chunk_by(|a, b| a.valid == b.valid).filter(|chunk| chunk[0].valid) {
                    sheet.line(&steps(valid), colour, 2.0);
                }
            }
            // Error bars of several spectra are beside each other within a band.
            let beside = (index as f64 + 1.0) / (self.spectra.len() as f64 + 1.0) - 0.5;
            for level in *levels {
                let Some(error) = error_of(level, errors.get(index)) else { continue };
                let end = |off: f64| axes.within((f64::from(level.band.0) + beside, level.level + off));
                sheet.line(&[end(-error), end(error)], if one { INK } else { colour }, 1.25);
            }
        }
        for band in first..=last {
            let across = [-0.5, 0.5].map(|side| x.place(f64::from(band) + side));
            sheet.value(axes.frame.strip(across), &self.value(band, errors));
        }
        sheet.outline(axes.frame);
        let spectra = self.spectra.iter().enumerate();
        sheet.legend(spectra.map(|(index, (name, _))| (*name, colour::line(index), Key::Line)));
        Ok(sheet.into_svg())
    }

    /// Text with the values of the spectra in a band.
    fn value(&self, band: i32, errors: &[&LevelErrors]) -> String {
        let mut text = format!("{} Hz", ThirdOctaveBand(band).label());
        for (index, (name, levels)) in self.spectra.iter().enumerate() {
            if let Some(level) = levels.iter().find(|level| level.band.0 == band) {
                let name = if name.is_empty() { self.quantity } else { name };
                let error = error_of(level, errors.get(index)).map_or(String::new(), |error| format!(" ± {error:.1}"));
                let mark = if level.valid { "" } else { ", not valid" };
                text.push_str(&format!("\n{name}: {}{error} dB{mark}", four_digits(level.level)));
            }
        }
        text
    }

    fn level_axis(&self) -> Axis {
        let levels = || self.spectra.iter().flat_map(|(_, levels)| levels.iter()).map(|band| band.level);
        let highest = levels().filter(|level| level.is_finite()).fold(f64::NEG_INFINITY, f64::max);
        Axis::linear_around(self.quantity, levels().filter(|&level| level >= highest - DEEPEST))
    }
}

/// Known error of a valid level \[dB\].
fn error_of(level: &BandLevel, errors: Option<&&LevelErrors>) -> Option<f64> {
    errors?.total(level.band).filter(|_| level.valid)
}

/// Axis of bands, evenly spaced as on a logarithmic axis: their numbers are its coordinate. With many bands only
/// octaves are labelled, from 1 kHz.
fn frequency_axis(first: i32, last: i32) -> Axis {
    let every = if last - first < 15 { 1 } else { 3 };
    let label = |band: i32| (band.rem_euclid(every) == 0).then(|| ThirdOctaveBand(band).label());
    let range = f64::from(first) - 0.5..f64::from(last) + 0.5;
    let ticks = (first..=last).map(|band| (f64::from(band), label(band)));
    Axis::with_ticks("Third-octave mid-frequency [Hz]", range, ticks)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(from: i32, values: &[f64]) -> Vec<BandLevel> {
        let level = |(k, &level): (usize, &f64)| BandLevel {
            band: ThirdOctaveBand(from + k as i32),
            mean_square: 10.0_f64.powf(level / 10.0),
            level,
            valid: k < 20,
        };
        values.iter().enumerate().map(level).collect()
    }

    #[test]
    fn bands_that_are_not_valid_are_grey() {
        let mut one = levels(-4, &[40.0; 6]);
        let other = levels(-4, &[50.0; 6]);
        for band in [0, 3, 5] {
            one[band].valid = false;
        }
        let plot = ThirdOctavePlot {
            title: "t",
            quantity: "q",
            spectra: vec![("a", &one), ("b", &other)],
            errors: LevelErrors::default(),
        };
        let svg = plot.to_svg().unwrap();
        let bands = |colour: &str| -> Vec<usize> {
            let drawn = svg.lines().filter(|line| line.contains("<polyline") && line.contains(colour));
            drawn.filter_map(|line| Some(line.split("points=\"").nth(1)?.matches(',').count() / 2)).collect()
        };
        // Two corners a band; the legend's line comes last.
        assert_eq!(bands("#0072B2"), [2, 1, 1], "{svg}");
        assert_eq!((bands("#BEBEBE"), bands("#D55E00")), (vec![6], vec![6, 1]), "{svg}");
    }

    #[test]
    fn every_spectrum_has_the_bars_of_its_errors() {
        let (one, other) = (levels(-4, &[40.0; 6]), levels(-4, &[50.0; 6]));
        let errors = LevelErrors::default();
        let plot = ThirdOctavePlot { title: "t", quantity: "q", spectra: vec![("a", &one), ("b", &other)], errors };
        let known = LevelErrors { numerical: Some((0.0, 1.0)), ..LevelErrors::default() };
        let svg = plot.to_svg_with(&[&known, &LevelErrors::default()]).unwrap();
        let lines =
            |colour: &str| svg.lines().filter(|line| line.contains("<polyline") && line.contains(colour)).count();
        // The spectrum and its entry in the legend, and six bars.
        assert_eq!((lines("#0072B2"), lines("#D55E00")), (2 + 6, 2), "{svg}");
        assert!(svg.contains("a: 40.00 ± 1.0 dB") && svg.contains("b: 50.00 dB"), "{svg}");
    }

    #[test]
    fn labels_are_nominal_and_silence_is_no_bar_without_end() {
        let spectrum = levels(-16, &[40.0; 24].map(|x| x + 0.0));
        let axis = frequency_axis(-16, 7);
        let labels: Vec<&str> = axis.ticks().map(|(_, label)| label).collect();
        assert_eq!(labels, ["31.5", "63", "125", "250", "500", "1k", "2k", "4k"]);
        let mut silent = spectrum.clone();
        silent[3].level = f64::NEG_INFINITY;
        let plot = ThirdOctavePlot {
            title: "t",
            quantity: "Level [dB]",
            spectra: vec![("", &silent)],
            errors: LevelErrors::default(),
        };
        let range = plot.level_axis().range;
        assert!(range.start > 30.0 && range.end < 50.0, "{range:?}");
        assert!(plot.to_svg().unwrap().contains("31.5"));
        let empty =
            ThirdOctavePlot { title: "t", quantity: "Level [dB]", spectra: vec![], errors: LevelErrors::default() };
        assert!(matches!(empty.to_svg(), Err(PlotError { quantity: "levels", .. })));
        let nothing = levels(0, &[f64::NEG_INFINITY; 3]);
        assert!(
            ThirdOctavePlot {
                title: "t",
                quantity: "q",
                spectra: vec![("a", &nothing), ("b", &nothing)],
                errors: LevelErrors::default(),
            }
            .to_svg()
            .is_ok()
        );
    }
}
