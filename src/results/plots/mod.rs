//! Pictures in SVG: forces over patch and time, third-octave spectra, curves, heights.
//!
//! Each picture is a plain value with a `to_svg`; [`super::files::ResultFiles::write_text`] or the caller writes the
//! text.

pub mod axis;
mod canvas;
mod colour;
pub mod comparison;
pub mod force_map;
pub mod heat_map;
pub mod lines;
pub mod patch_map;
pub mod points;
pub mod polar;
mod road_map;
pub mod share_map;
pub mod third_octaves;
pub mod wavenumber_map;
pub mod work_precision;

pub use axis::{Axis, four_digits};
pub use canvas::PlotError;
pub use comparison::{ComparisonPanel, ComparisonPlot};
pub use force_map::ForceMap;
pub use heat_map::{Colours, HeatMap};
pub use lines::{LinePlot, Series};
pub use patch_map::PatchMap;
pub use points::{PointPlot, PointSeries};
pub use polar::PolarPlot;
pub use road_map::road_map;
pub use share_map::ShareMap;
pub use third_octaves::ThirdOctavePlot;
pub use wavenumber_map::WavenumberPlot;
pub use work_precision::{WorkPrecisionPanel, WorkPrecisionPlot};
