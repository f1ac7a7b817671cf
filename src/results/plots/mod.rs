//! Pictures in SVG: forces over patch and time, third-octave spectra, curves, heights.
//!
//! Each picture is a plain value with a `to_svg`; [`super::files::ResultFiles::write_text`] or the caller writes the
//! text.

pub(crate) mod axis;
mod canvas;
mod colour;
pub(crate) mod comparison;
pub(crate) mod force_map;
pub(crate) mod heat_map;
mod layout;
pub(crate) mod lines;
pub(crate) mod patch_map;
pub(crate) mod points;
pub(crate) mod polar;
mod road_map;
pub(crate) mod share_map;
pub(crate) mod third_octaves;
pub(crate) mod wavenumber_map;
pub(crate) mod work_precision;

pub(crate) use axis::Axis;
pub use axis::four_digits;
pub use canvas::PlotError;
pub(crate) use comparison::{ComparisonPanel, ComparisonPlot};
pub(crate) use force_map::ForceMap;
pub(crate) use heat_map::{Colours, HeatMap};
pub(crate) use lines::{LinePlot, Series};
pub(crate) use patch_map::PatchMap;
pub(crate) use points::{PointPlot, PointSeries};
pub(crate) use polar::PolarPlot;
pub(crate) use road_map::road_map;
pub(crate) use share_map::ShareMap;
pub use third_octaves::ThirdOctavePlot;
pub(crate) use wavenumber_map::WavenumberPlot;
pub(crate) use work_precision::{WorkPrecisionPanel, WorkPrecisionPlot};
