//! Pictures in SVG: forces over patch and time, third-octave spectra, curves, heights.
//!
//! Each picture is a plain value with a `to_svg`; [`super::files::ResultFiles::write_text`] or the caller writes the
//! text.

pub(crate) mod axis;
mod colour;
pub(crate) mod comparison;
mod curve;
pub(crate) mod force_map;
pub(crate) mod heat_map;
mod layout;
pub(crate) mod lines;
pub(crate) mod points;
pub(crate) mod polar;
mod sheet;
pub(crate) mod strip_chart;
pub(crate) mod third_octaves;
pub(crate) mod wavenumber_map;
pub(crate) mod work_precision;

use thiserror::Error;

pub(crate) use axis::Axis;
pub use axis::four_digits;
pub(crate) use comparison::{ComparisonPanel, ComparisonPlot};
pub(crate) use force_map::ForceMap;
pub(crate) use heat_map::{Colours, HeatMap, ShareMap, SurfaceMap};
pub(crate) use lines::{LinePlot, Series};
pub(crate) use points::{PointPlot, PointSeries};
pub(crate) use polar::PolarPlot;
pub(crate) use strip_chart::{StripChart, StripPanel, StripSection, StripSeries};
pub use third_octaves::ThirdOctavePlot;
pub(crate) use wavenumber_map::WavenumberPlot;
pub(crate) use work_precision::{WorkPrecisionPanel, WorkPrecisionPlot};

/// Data of a picture whose lengths do not fit each other.
#[derive(Debug, Error)]
#[error("cannot draw {picture}: {got} values of {quantity} where {expected} are needed")]
pub struct PlotError {
    /// Kind of picture.
    pub picture: &'static str,
    /// Name of the data.
    pub quantity: &'static str,
    /// Length needed.
    pub expected: usize,
    /// Length given.
    pub got: usize,
}
