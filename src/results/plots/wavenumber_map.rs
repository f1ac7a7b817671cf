//! Vibration over wavenumber and frequency, with the tyre's free waves drawn over it.

use ndarray::ArrayView2;

use super::PlotError;
use super::axis::Axis;
use super::heat_map::{Colours, HeatMap};
use crate::response::vibration::{DispersionBranch, WavenumberMap};
use crate::tyre::poles::Direction;

/// Largest number of waves round the tyre that is drawn: shorter ones are local deformation, and no free waves.
const MOST_WAVES: usize = 100;
/// Highest frequency that is drawn \[Hz\].
const HIGHEST: f64 = 2000.0;
/// Range of the colours, below the highest level \[dB\].
const DEEPEST: f64 = 70.0;

/// A map, and what is needed to position it.
#[derive(Clone, Debug)]
pub(crate) struct WavenumberPlot<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// Power by frequency and wavenumber.
    pub map: &'a WavenumberMap,
    /// Free waves of the tyre in the material frame.
    pub branches: &'a [DispersionBranch],
    /// Shift of a wave's frequency by each period round the tyre \[Hz\]: 0 in the material frame, the revolutions per
    /// second in the non-rotating one.
    pub rotation: f64,
}

impl WavenumberPlot<'_> {
    /// The picture as SVG: waves round the tyre horizontally, frequency upwards, spectral density as colour.
    ///
    /// # Errors
    /// [`PlotError`] for a map without cells.
    pub(crate) fn to_svg(&self) -> Result<String, PlotError> {
        let picture = "a map over wavenumber and frequency";
        let WavenumberMap { wavenumbers, row_width, ref density } = *self.map;
        let rows = density.len() / wavenumbers.max(1);
        let whole = ArrayView2::from_shape((rows, wavenumbers), density).map_err(|_| PlotError {
            picture,
            quantity: "the density",
            expected: rows * wavenumbers,
            got: density.len(),
        })?;
        let half = wavenumbers / 2;
        let shown = half.min(MOST_WAVES);
        let rows_shown = rows.min((HIGHEST / row_width).ceil() as usize);
        let part = whole.slice_axis(ndarray::Axis(0), (..rows_shown).into());
        let part = part.slice_axis(ndarray::Axis(1), (half - shown..=half + shown).into());
        let levels = part.mapv(|density| 10.0 * density.max(f64::MIN_POSITIVE).log10());
        let highest = levels.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let edge = shown as f64 + 0.5;
        let map = HeatMap {
            title: self.title,
            x: Axis::linear(
                "Waves round the tyre, positive: against the rolling direction; white: free waves of the tyre",
                -edge..edge,
            ),
            y: Axis::linear("Frequency [Hz]", 0.0..rows_shown as f64 * row_width),
            quantity: "Velocity density [dB re 1 m2/s2/Hz]",
            values: levels.view(),
            colours: Colours::Between(highest - DEEPEST..highest),
            aspect: Some(0.8),
        };
        map.to_svg_under(&self.curves())
    }

    /// Curves of each branch in its direction, with the rotation to the right, or in both; where the rotation turns a
    /// wave's frequency negative, it appears as its mirror image.
    fn curves(&self) -> Vec<Vec<(f64, f64)>> {
        let curve = |branch: &DispersionBranch, direction: f64| {
            let waves = (branch.first..).map(|n| direction * n as f64);
            waves.zip(&branch.frequencies).map(|(n, frequency)| (n, frequency + n * self.rotation)).collect::<Vec<_>>()
        };
        let signs = |branch: &DispersionBranch| {
            let shown = |direction| branch.direction.is_none_or(|of_branch| of_branch == direction);
            let both = [(Direction::Forwards, 1.0), (Direction::Backwards, -1.0)];
            both.into_iter().filter(move |(direction, _)| shown(*direction)).map(|(_, sign)| sign).collect::<Vec<_>>()
        };
        let mirrored = |curve: &Vec<(f64, f64)>| curve.iter().map(|&(n, frequency)| (-n, -frequency)).collect();
        let both: Vec<Vec<(f64, f64)>> =
            self.branches.iter().flat_map(|branch| signs(branch).into_iter().map(|sign| curve(branch, sign))).collect();
        both.iter().map(mirrored).chain(both.iter().cloned()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_are_shifted_by_the_rotation_and_drawn_once_above_zero() {
        let branches = [DispersionBranch { direction: None, first: 1, frequencies: vec![30.0, 35.0] }];
        let map = WavenumberMap { wavenumbers: 9, row_width: 5.0, density: vec![1e-6; 9 * 40] };
        let plot = WavenumberPlot { title: "t", map: &map, branches: &branches, rotation: 20.0 };
        let curves = plot.curves();
        assert!(curves.contains(&vec![(1.0, 50.0), (2.0, 75.0)]));
        assert!(curves.contains(&vec![(-1.0, 10.0), (-2.0, -5.0)]), "above the speed of the wave it turns round");
        assert!(curves.contains(&vec![(1.0, -10.0), (2.0, 5.0)]));
        assert!(plot.to_svg().unwrap().contains("</svg>"));
        let still = WavenumberPlot { rotation: 0.0, ..plot.clone() };
        assert!(still.curves().contains(&vec![(-1.0, 30.0), (-2.0, 35.0)]));
        let towards = |direction| [DispersionBranch { direction: Some(direction), ..branches[0].clone() }];
        let [with, against] = [towards(Direction::Forwards), towards(Direction::Backwards)];
        let [with, against] = [&with, &against].map(|branches| WavenumberPlot { branches, ..plot.clone() }.curves());
        assert!(with.contains(&vec![(1.0, 50.0), (2.0, 75.0)]) && !against.contains(&vec![(1.0, 50.0), (2.0, 75.0)]));
        assert_eq!([with.len(), against.len()], [2, 2]);
        assert!(against.contains(&vec![(-1.0, 10.0), (-2.0, -5.0)]));
        let wrong = WavenumberMap { density: Vec::new(), ..map.clone() };
        assert!(WavenumberPlot { map: &wrong, ..plot }.to_svg().is_err());
    }
}
