//! Heights of a road in colours (Larsson's figure 3).

use ndarray::ArrayView2;

use super::axis::Axis;
use super::canvas::PlotError;
use super::heat_map::{Colours, HeatMap};

/// Smallest and largest height over width; beyond these a picture is not true to scale, since 1:1 would be a thread.
const ASPECTS: (f64, f64) = (0.22, 0.9);

/// The picture as SVG: along the road horizontally, height in mm as colour. True to scale unless it would be too flat
/// or too tall. `heights` \[m\] are \[points along x, points across y\], NaN where there is none; the first row is at
/// the road coordinate `start` \[m\], the columns are centred on the tyre; `dx` and `dy` are the spacings along and
/// across \[m\].
///
/// # Errors
/// [`PlotError::Shape`] without points, [`PlotError::Draw`].
pub(crate) fn road_map(
    title: &str,
    heights: ArrayView2<'_, f64>,
    start: f64,
    [dx, dy]: [f64; 2],
) -> Result<String, PlotError> {
    let (along, across) = heights.dim();
    let length = along as f64 * dx;
    let half_width = 0.5 * across as f64 * dy;
    let millimetres = heights.t().mapv(|height| height * 1e3);
    // Points are the middles of their cells.
    let begin = start - 0.5 * dx;
    HeatMap {
        title,
        x: Axis::linear("Along the road [m]", begin..begin + length),
        y: Axis::linear("Across [mm]", -half_width * 1e3..half_width * 1e3),
        quantity: "Height [mm]",
        values: millimetres.view(),
        colours: Colours::Extent,
        aspect: Some((2.0 * half_width / length).clamp(ASPECTS.0, ASPECTS.1)),
    }
    .to_svg()
}

#[cfg(test)]
mod tests {
    use ndarray::Array2;

    use super::*;

    #[test]
    fn holes_and_flat_roads_are_drawn_and_nothing_is_refused() {
        let mut heights = Array2::zeros((100, 10));
        let road = |heights: &Array2<f64>| road_map("r", heights.view(), 1.0, [0.01, 0.02]);
        assert!(road(&heights).is_ok());
        heights[[3, 4]] = f64::NAN;
        assert!(road(&heights).unwrap().contains("#C8C8C8"), "a hole is grey");
        heights.fill(f64::NAN);
        assert!(road(&heights).is_ok());
        assert!(matches!(road(&Array2::zeros((0, 3))), Err(PlotError::Shape { .. })));
    }
}
