//! Findings and actions of opening a road.

use std::collections::BTreeMap;

use serde::Serialize;
use thiserror::Error;

use super::texture::BandFit;
use crate::scene::NamedTexture;

/// Information for the user about the road, as written to `road.json`; lengths in m.
#[derive(Clone, Debug, Error, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "note")]
pub(crate) enum RoadNote {
    /// Missing heights were interpolated.
    #[error("{missing} of {total} heights ({:.1} %) are missing and were interpolated", percent(*missing, *total))]
    Filled { missing: usize, total: usize },
    /// Words that mark missing heights, and how often.
    #[error("words stand for missing heights: {}", in_words(words))]
    WordsForMissing { words: BTreeMap<String, usize> },
    /// Heights equal to a number, in the file's unit, by which the scene marks missing ones.
    #[error("{count} heights are {value}, which stands for a missing height (road.missing)")]
    NamedMissing { value: f64, count: usize },
    /// Heights equal to one number, in the file's unit, far from all others, were taken as missing.
    #[error(
        "{count} heights are exactly {value} and far from all others: they were taken for missing (road.missing = \
         {value} says so without this warning, road.missing = [] that they are heights)"
    )]
    TakenForMissing { value: f64, count: usize },
    /// The same, for a number that the scene does not mark as missing.
    #[error("{count} heights are exactly {value}, far from the others, and road.missing does not name this value")]
    NotNamedMissing { value: f64, count: usize },
    /// Points of a profile farther than `limit` from the median were taken as dropouts.
    #[error("{count} points more than {:.1} mm from the median were taken for dropouts", 1e3 * limit)]
    Outliers { count: usize, limit: f64 },
    /// Heights that differ from their neighbours by at least three times the distance were interpolated.
    #[error(
        "{count} of {total} heights ({:.1} %) are spikes by ISO 13473-1, steeper than 3 : 1, and were interpolated",
        percent(*count, *total)
    )]
    Spikes { count: usize, total: usize },
    /// Columns that were read, with their titles and units.
    #[error("read: {columns}")]
    FileColumns { columns: String },
    /// A column without a title (from 1) that counts 0, 1, 2, 3, read in the unit that the scene states.
    #[error(
        "column {column} counts (0, 1, 2, 3) and has no title: it was read in {unit}, as stated; are these lengths, or \
         numbers of the points?"
    )]
    Counts { column: usize, unit: &'static str },
    /// A road narrower than the contact strip, described in its width \[m\].
    #[error(
        "the road is {:.1} mm wide, narrower than the contact strip of {:.1} mm: described as it is; a run needs \
         road.widen = \"mirror\" or a narrower strip", 1e3 * available, 1e3 * needed
    )]
    Narrow { available: f64, needed: f64 },
    /// Mirror images continue the measured width to the needed one \[m\].
    #[error(
        "measured {:.1} mm wide and continued to {:.1} mm by mirror images: it is assumed that the road beside is \
         like it",
        1e3 * measured, 1e3 * needed
    )]
    Mirrored { measured: f64, needed: f64 },
    /// Root-mean-square height of a measured road that is smoother than any in use.
    #[error(
        "the heights vary by {:.2} um (rms) only, less than on any road in use: is their unit right?", 1e6 * rms
    )]
    AlmostFlat { rms: f64 },
    /// The smallest step between heights that differ \[m\], of heights that were rounded.
    #[error(
        "the heights are in steps of {} mm: levels and depth are those of the rounded heights",
        (1e6 * step).round() / 1e3
    )]
    InSteps { step: f64 },
    /// Many heights are equal to the lowest or to the highest one \[m\].
    #[error(
        "{count} of {total} heights ({:.1} %) are exactly {:.3} mm, and none is beyond: are they cut off there?",
        percent(*count, *total), 1e3 * height
    )]
    CutOff { count: usize, total: usize, height: f64 },
    /// Only part of the profile is used, in the file's coordinate; `dropped` points were left out.
    #[error("used from {from:.4} to {to:.4} m of the file, {dropped} points left out")]
    Cut { from: f64, to: f64, dropped: usize },
    /// Distances were not in rising order: `steps` of them went back.
    #[error("distances went back {steps} times; the points were sorted")]
    Unsorted { steps: usize },
    /// Points at one distance were averaged; `merged` is by how many there are fewer.
    #[error("{merged} points at the distance of another one were averaged with it")]
    Duplicates { merged: usize },
    /// Points at distances from `smallest` to `largest` were interpolated linearly to one spacing.
    #[error(
        "points {:.4} to {:.4} mm apart were interpolated to {:.4} mm", 1e3 * smallest, 1e3 * largest, 1e3 * spacing
    )]
    Resampled { smallest: f64, largest: f64, spacing: f64 },
    /// Mean \[m\] and slopes of all heights were removed; no slope across of a road that is level across.
    #[error("removed: a mean of {:.4} mm, a slope of {:.4} % along{}", 1e3 * mean, 1e2 * along, in_percent(*across))]
    Levelled { mean: f64, along: f64, across: Option<f64> },
    /// The mean \[m\] was removed, not the slopes.
    #[error("removed: a mean of {:.4} mm; slopes were kept (road.level)", 1e3 * mean)]
    MeanRemoved { mean: f64 },
    /// Nothing was removed.
    #[error("mean and slopes were kept (road.level)")]
    NotLevelled,
    /// Longer wavelengths than this were removed.
    #[error("wavelengths longer than {longest_wavelength} m were removed")]
    Detrended { longest_wavelength: f64 },
    /// Columns outside the contact strip, or not measured, were not used; `incomplete` ones lack heights,
    /// `missing_points` of the file's `total_points`. `lateral_position` is v of the tyre's middle.
    #[error(
        "{used} of {total} columns used, around v = {lateral_position:.3} m; {incomplete} columns lack heights \
         ({missing_points} of {total_points} points, {:.1} %)", percent(*missing_points, *total_points)
    )]
    Columns {
        total: usize,
        used: usize,
        incomplete: usize,
        missing_points: usize,
        total_points: usize,
        lateral_position: f64,
    },
    /// Columns at explicit positions were interpolated linearly to a uniform spacing.
    #[error("uneven columns were interpolated linearly to {spacing:.4} m")]
    UnevenColumns { spacing: f64 },
    /// Section and key of an entry that has no influence on heights along the reference line, or is unknown.
    #[error("{key} has no effect here")]
    Ignored { key: String },
    /// Missing heights were set as the file's modifiers say: to `zero`, or to the `nearest across`.
    #[error("{count} missing heights were set ({mode}) as the file's modifiers say")]
    MissingByModifier { count: usize, mode: &'static str },
    /// The road's spacing is coarser than the run's elements.
    #[error(
        "the road is known every {:.3} mm only, the run resolves {:.3} mm: shorter wavelengths are absent",
        1e3 * spacing, 1e3 * run
    )]
    Coarse { spacing: f64, run: f64 },
    /// Heights span more than that of a texture.
    #[error("the heights span {span:.3} m: this is more than texture")]
    LargeSpan { span: f64 },
    /// The root-mean-square step from the last row to the first, where a repeated road starts again.
    #[error("the repeated road steps by {:.3} mm (rms) where it starts again", 1e3 * step)]
    Joint { step: f64 },
    /// No isotropic surface has the wanted spectrum; the nearest one deviates most \[dB\] at `wavelength`.
    #[error(
        "no isotropic surface has this profile spectrum; the nearest one deviates by up to {deviation:.1} dB, at \
         {:.1} mm", 1e3 * wavelength
    )]
    NotRealisable { deviation: f64, wavelength: f64 },
    /// A texture given by its name: its mean profile depth, the tolerance of that, and the source of depth and levels;
    /// lengths in m.
    #[error("texture {texture}, mean profile depth {:.2} +- {:.2} mm: {origin}", 1e3 * depth, 1e3 * within)]
    NamedTexture { texture: &'static str, depth: f64, within: f64, origin: &'static str },
    /// The scene names no texture, and takes one that was another road until version 0.3.0.
    #[error(
        "road.texture is not given: {:?}, smoother than the default until version 0.3.0, which is called {:?} now",
        NamedTexture::DEFAULT.name(), NamedTexture::RoughAsphalt.name()
    )]
    DefaultTexture,
    /// The profile's spectrum was measured, and an isotropic surface is made from it between two wavelengths.
    #[error(
        "an isotropic surface with the profile's levels between {:.1} and {:.1} mm and random phases",
        1e3 * longest, 1e3 * shortest
    )]
    MadeIsotropic { longest: f64, shortest: f64 },
}

impl RoadNote {
    /// True if the results may be affected in a way that the user did not ask for.
    pub(crate) fn is_warning(&self) -> bool {
        matches!(
            self,
            Self::Filled { .. }
                | Self::TakenForMissing { .. }
                | Self::NotNamedMissing { .. }
                | Self::Outliers { .. }
                | Self::Counts { .. }
                | Self::Spikes { .. }
                | Self::AlmostFlat { .. }
                | Self::Narrow { .. }
                | Self::Mirrored { .. }
                | Self::Coarse { .. }
                | Self::LargeSpan { .. }
                | Self::Joint { .. }
                | Self::NotRealisable { .. }
                | Self::DefaultTexture
                | Self::Ignored { .. }
                | Self::MissingByModifier { .. }
        )
    }
}

fn in_words(words: &BTreeMap<String, usize>) -> String {
    words.iter().map(|(word, count)| format!("{word:?} ({count})")).collect::<Vec<_>>().join(", ")
}

fn in_percent(across: Option<f64>) -> String {
    across.map_or(String::new(), |slope| format!(", of {:.4} % across", 1e2 * slope))
}

fn percent(part: usize, whole: usize) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}

/// Facts about an opened road.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RoadReport {
    /// Length of the measured road \[m\]; absent for endless roads.
    pub length: Option<f64>,
    /// Spacing of the road's data along \[m\]; absent for the plane.
    pub spacing: Option<f64>,
    /// Spacing of the road's data across \[m\]; absent for a road that is level across and for the plane.
    pub lateral_spacing: Option<f64>,
    /// Number of heights in the file.
    pub points: usize,
    /// Number of missing heights in the file.
    pub missing: usize,
    /// Shortest wavelength that the road has on the run's elements \[m\]; absent for the plane.
    pub shortest_wavelength: Option<f64>,
    /// Made roads: levels wanted and levels of the surface.
    pub(crate) bands: Vec<BandFit>,
    /// All further information, in the order in which it was found.
    pub(crate) notes: Vec<RoadNote>,
}

impl RoadReport {
    /// Highest frequency \[Hz\] that the road excites at a speed \[m/s\]; `None` for the plane.
    pub fn highest_frequency(&self, speed: f64) -> Option<f64> {
        self.shortest_wavelength.map(|wavelength| speed / wavelength)
    }
}
