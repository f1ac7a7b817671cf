//! A field over the contact patch in colours.

use ndarray::ArrayView2;

use super::axis::Axis;
use super::canvas::PlotError;
use super::heat_map::{Colours, HeatMap};

/// Smallest and largest height over width; beyond these a picture is not true to scale.
const ASPECTS: (f64, f64) = (0.3, 1.2);

/// A field over the cells of the contact window.
#[derive(Clone, Debug)]
pub(crate) struct PatchMap<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// Quantity of the colours, unit included.
    pub quantity: &'a str,
    /// Values: \[cells along, cells across\], NaN where there is none.
    pub values: ArrayView2<'a, f64>,
    /// Position of the first cells along, relative to the axle \[m\].
    pub first_position: f64,
    /// Length and width of a cell \[m\].
    pub size: [f64; 2],
}

impl PatchMap<'_> {
    /// The picture as SVG, in mm from below the axle, true to scale unless it would be too flat or too tall.
    ///
    /// # Errors
    /// [`PlotError::Shape`] without cells, [`PlotError::Draw`].
    pub(crate) fn to_svg(&self) -> Result<String, PlotError> {
        let Self { title, quantity, values, first_position, size: [dx, dy] } = self;
        let (along, across) = values.dim();
        let begin = 1e3 * (first_position - 0.5 * dx);
        let (length, half_width) = (1e3 * along as f64 * dx, 0.5e3 * across as f64 * dy);
        HeatMap {
            title,
            x: Axis::linear("Along, from the axle [mm]", begin..begin + length),
            y: Axis::linear("Across [mm]", -half_width..half_width),
            quantity,
            values: values.t(),
            colours: Colours::Extent,
            aspect: Some((2.0 * half_width / length).clamp(ASPECTS.0, ASPECTS.1)),
        }
        .to_svg()
    }
}
