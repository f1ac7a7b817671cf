//! A field over the contact patch in colours.

use ndarray::ArrayView2;

use super::axis::Axis;
use super::canvas::PlotError;
use super::heat_map::{Colours, HeatMap};

/// A picture flatter or taller than this is stretched.
const ASPECTS: (f64, f64) = (0.3, 1.2);

/// A field over the cells of the contact window.
#[derive(Clone, Debug)]
pub(crate) struct PatchMap<'a> {
    /// Title over the picture.
    pub title: &'a str,
    /// Quantity of the colours, unit included.
    pub quantity: &'a str,
    /// The values: \[cells along, cells across\], NaN where there is none.
    pub values: ArrayView2<'a, f64>,
    /// Where the first cells along are from the axle on \[m\].
    pub first_position: f64,
    /// Size of a cell along and across \[m\].
    pub size: [f64; 2],
}

impl PatchMap<'_> {
    /// Returns the picture as SVG, in mm from the axle's foot, true to scale unless the stretch is too long for that.
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
