//! A field over a piece of road or over the contact patch in colours (Larsson's figure 3).

use ndarray::ArrayView2;

use super::PlotError;
use super::axis::Axis;
use super::heat_map::{Colours, HeatMap};

/// Smallest and largest height over width; beyond these a picture is not true to scale, since 1:1 would be a thread.
const ASPECTS: (f64, f64) = (0.22, 1.2);

/// A field over a lattice of points, each in the middle of its cell; across, they are centred on the tyre.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceMap<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// Title of the horizontal axis, without its unit.
    pub along: &'a str,
    /// Quantity of the colours, unit included.
    pub quantity: &'a str,
    /// Values: \[points along, points across\], NaN where there is none.
    pub values: ArrayView2<'a, f64>,
    /// Position of the first points along \[m\].
    pub first_position: f64,
    /// Length and width of a cell \[m\].
    pub size: [f64; 2],
}

impl SurfaceMap<'_> {
    /// The picture as SVG, true to scale unless it would be too flat or too tall.
    ///
    /// # Errors
    /// [`PlotError`] without points.
    pub(crate) fn to_svg(&self) -> Result<String, PlotError> {
        let Self { title, along, quantity, values, first_position, size: [dx, dy] } = self;
        let [length, width] = [values.nrows() as f64 * dx, values.ncols() as f64 * dy];
        let (unit, scale) = if length < 1.0 { ("mm", 1e3) } else { ("m", 1.0) };
        let begin = first_position - 0.5 * dx;
        HeatMap {
            title,
            x: Axis::linear(format!("{along} [{unit}]"), scale * begin..scale * (begin + length)),
            y: Axis::linear("Across [mm]", -500.0 * width..500.0 * width),
            quantity,
            values: values.t(),
            colours: Colours::Extent,
            aspect: Some((width / length).clamp(ASPECTS.0, ASPECTS.1)),
        }
        .to_svg()
    }
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use super::*;

    #[test]
    fn holes_and_flat_roads_are_drawn_and_nothing_is_refused() {
        let mut heights = Array2::zeros((100, 10));
        let road = |heights: &Array2<f64>| {
            let (title, along, quantity) = ("r", "Along", "Height [mm]");
            let values = heights.view();
            SurfaceMap { title, along, quantity, values, first_position: 1.0, size: [0.01, 0.02] }.to_svg()
        };
        assert!(road(&heights).unwrap().contains("Along [m]"));
        heights[[3, 4]] = f64::NAN;
        assert!(road(&heights).unwrap().contains("#C8C8C8"), "a hole is grey");
        heights.fill(f64::NAN);
        assert!(road(&heights).is_ok());
        assert!(road(&Array2::zeros((50, 10))).unwrap().contains("Along [mm]"));
        assert!(matches!(road(&Array2::zeros((0, 3))), Err(PlotError { .. })));
    }
}
