//! What was found and done while a road was opened.

use std::fmt;

use serde::Serialize;

use super::made::BandFit;

/// Something that the user should know about the road.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "note")]
#[non_exhaustive]
pub enum RoadNote {
    /// Missing heights were interpolated.
    Filled {
        /// Missing heights.
        missing: usize,
        /// All heights.
        total: usize,
    },
    /// Points of a profile far outside all others were taken for dropouts.
    Spikes {
        /// How many.
        count: usize,
        /// Distance from the median beyond which a point is a spike \[m\].
        limit: f64,
    },
    /// Only part of the profile is used.
    Cut {
        /// From \[m, file coordinate\].
        from: f64,
        /// To \[m\].
        to: f64,
        /// Points left out.
        dropped: usize,
    },
    /// Distances were not in rising order.
    Unsorted {
        /// How many steps went back.
        steps: usize,
    },
    /// Several points at one distance; their heights were averaged.
    Duplicates {
        /// Points merged away.
        merged: usize,
    },
    /// Points not equally spaced; resampled by linear interpolation.
    Resampled {
        /// Smallest spacing \[m\].
        smallest: f64,
        /// Largest spacing \[m\].
        largest: f64,
        /// Uniform spacing \[m\].
        spacing: f64,
    },
    /// Mean and linear slope of the profile, or the plane of the strip, were removed.
    Levelled,
    /// Wavelengths longer than this were removed.
    Detrended {
        /// Longest wavelength that stays \[m\].
        longest_wavelength: f64,
    },
    /// Columns outside the contact strip, or not measured, were not used.
    Columns {
        /// Columns in the file.
        total: usize,
        /// Columns used.
        used: usize,
        /// Columns with missing heights.
        incomplete: usize,
        /// Missing heights in the file.
        missing_points: usize,
        /// All heights in the file.
        total_points: usize,
        /// v of the tyre's middle \[m\].
        lateral_position: f64,
    },
    /// Columns at explicit positions; interpolated linearly to a uniform spacing.
    UnevenColumns {
        /// Uniform spacing \[m\].
        spacing: f64,
    },
    /// The file asks for something that has no influence on heights along the reference line, or is unknown.
    Ignored {
        /// Section and key.
        key: String,
    },
    /// Missing heights were set as the file's modifiers say.
    MissingByModifier {
        /// How many.
        count: usize,
        /// `zero` or `nearest across`.
        mode: &'static str,
    },
    /// The road's own resolution is coarser than the run's.
    Coarse {
        /// The road's spacing \[m\].
        spacing: f64,
        /// The run's \[m\].
        run: f64,
    },
    /// Heights span more than a texture does.
    LargeSpan {
        /// Highest minus lowest \[m\].
        span: f64,
    },
    /// The step where a repeated road starts again.
    Joint {
        /// Root-mean-square difference between first and last row \[m\].
        step: f64,
    },
    /// The spectrum asked for belongs to no isotropic surface; the nearest one is used.
    NotRealisable {
        /// Largest deviation \[dB\].
        deviation: f64,
        /// Where \[m\].
        wavelength: f64,
    },
    /// The profile's spectrum was measured and an isotropic surface made from it.
    MadeIsotropic {
        /// Longest wavelength \[m\].
        longest: f64,
        /// Shortest wavelength \[m\].
        shortest: f64,
    },
}

impl RoadNote {
    /// Whether the results may be affected in a way that the user did not ask for.
    pub fn is_warning(&self) -> bool {
        matches!(
            self,
            Self::Filled { .. }
                | Self::Spikes { .. }
                | Self::Coarse { .. }
                | Self::LargeSpan { .. }
                | Self::Joint { .. }
                | Self::NotRealisable { .. }
                | Self::Ignored { .. }
                | Self::MissingByModifier { .. }
        )
    }
}

impl fmt::Display for RoadNote {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |part: usize, whole: usize| 100.0 * part as f64 / whole.max(1) as f64;
        match self {
            Self::Filled { missing, total } => {
                write!(
                    out,
                    "{missing} of {total} heights ({:.1} %) are missing and were interpolated",
                    percent(*missing, *total)
                )
            }
            Self::Spikes { count, limit } => {
                write!(out, "{count} points more than {:.1} mm from the median were taken for dropouts", 1e3 * limit)
            }
            Self::Cut { from, to, dropped } => {
                write!(out, "used from {:.4} to {:.4} m of the file, {dropped} points left out", from, to)
            }
            Self::Unsorted { steps } => write!(out, "distances went back {steps} times; the points were sorted"),
            Self::Duplicates { merged } => {
                write!(out, "{merged} points at the distance of another one were averaged with it")
            }
            Self::Resampled { smallest, largest, spacing } => write!(
                out,
                "points {:.4} to {:.4} mm apart were interpolated to {:.4} mm",
                1e3 * smallest,
                1e3 * largest,
                1e3 * spacing
            ),
            Self::Levelled => write!(out, "mean and linear slope were removed"),
            Self::Detrended { longest_wavelength } => {
                write!(out, "wavelengths longer than {longest_wavelength} m were removed")
            }
            Self::Columns { total, used, incomplete, missing_points, total_points, lateral_position } => write!(
                out,
                "{used} of {total} columns used, around v = {lateral_position:.3} m; {incomplete} columns lack heights ({missing_points} of {total_points} points, {:.1} %)",
                percent(*missing_points, *total_points)
            ),
            Self::UnevenColumns { spacing } => {
                write!(out, "uneven columns were interpolated linearly to {:.4} m", spacing)
            }
            Self::Ignored { key } => write!(out, "{key} has no effect here"),
            Self::MissingByModifier { count, mode } => {
                write!(out, "{count} missing heights were set ({mode}) as the file's modifiers say")
            }
            Self::Coarse { spacing, run } => write!(
                out,
                "the road is known every {:.3} mm only, the run resolves {:.3} mm: shorter wavelengths are absent",
                1e3 * spacing,
                1e3 * run
            ),
            Self::LargeSpan { span } => write!(out, "the heights span {span:.3} m: this is more than texture"),
            Self::Joint { step } => {
                write!(out, "the repeated road steps by {:.3} mm (rms) where it starts again", 1e3 * step)
            }
            Self::NotRealisable { deviation, wavelength } => write!(
                out,
                "no isotropic surface has this profile spectrum; the nearest one deviates by up to {deviation:.1} dB, at {:.1} mm",
                1e3 * wavelength
            ),
            Self::MadeIsotropic { longest, shortest } => write!(
                out,
                "an isotropic surface with the profile's levels between {:.1} and {:.1} mm and random phases",
                1e3 * longest,
                1e3 * shortest
            ),
        }
    }
}

/// What is known about an opened road.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RoadReport {
    /// Length of the measured road \[m\]; absent for endless roads.
    pub length: Option<f64>,
    /// The road's own spacing along \[m\]; absent for the plane.
    pub spacing: Option<f64>,
    /// The road's own spacing across \[m\]; absent where it is level across or the plane.
    pub lateral_spacing: Option<f64>,
    /// Heights in the file.
    pub points: usize,
    /// Missing heights in the file.
    pub missing: usize,
    /// Shortest wavelength that the road holds on the run's lattice \[m\]; absent for the plane.
    pub shortest_wavelength: Option<f64>,
    /// Made roads: levels asked for and levels of the surface.
    pub bands: Vec<BandFit>,
    /// Everything else, in the order in which it was found.
    pub notes: Vec<RoadNote>,
}

impl RoadReport {
    /// Highest frequency \[Hz\] that the road excites at a speed \[m/s\]; `None` for the plane.
    pub fn highest_frequency(&self, speed: f64) -> Option<f64> {
        self.shortest_wavelength.map(|wavelength| speed / wavelength)
    }
}
