//! Sound power from the pressures on a hemisphere about the tyre, over the rigid road.
//!
//! W = Int p_rms^2/(rho c) dS, valid far from the source, at several tyre diameters and wavelengths, where the sound
//! travels outwards. [`Iso3744`] has the microphones of the standard, all of equal areas.

use std::f64::consts::TAU;

use super::frame::Position;
use crate::radiation::Air;

/// Reference power of levels \[W\] (ISO 1683).
pub(crate) const REFERENCE_POWER: f64 = 1e-12;

/// Level of a sound power \[W\] \[dB re 1 pW\].
pub(crate) fn power_level(power: f64) -> f64 {
    10.0 * (power / REFERENCE_POWER).log10()
}

/// Microphones of ISO 3744:2010, annex B, on a hemisphere over one reflecting plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Iso3744 {
    /// Table B.1, for any source: all heights differ, so that no interference of a tone with its image affects all of
    /// them.
    Tones,
    /// Table B.2, for sources without audible tones.
    Broadband,
}

/// Table B.1 in parts of the radius: ten key positions, then ten additional ones.
const TONES: [Position; 20] = [
    [0.16, -0.96, 0.22],
    [0.78, -0.60, 0.20],
    [0.78, 0.55, 0.31],
    [0.16, 0.90, 0.41],
    [-0.83, 0.32, 0.45],
    [-0.83, -0.40, 0.38],
    [-0.26, -0.65, 0.71],
    [0.74, -0.07, 0.67],
    [-0.26, 0.50, 0.83],
    [0.10, -0.10, 0.99],
    [0.91, -0.34, 0.22],
    [0.91, 0.38, 0.20],
    [-0.09, 0.95, 0.31],
    [-0.70, 0.59, 0.41],
    [-0.69, -0.56, 0.45],
    [-0.07, -0.92, 0.38],
    [0.43, -0.55, 0.71],
    [0.43, 0.61, 0.67],
    [-0.56, 0.02, 0.83],
    [0.14, 0.04, 0.99],
];

/// Table B.2, in the same form.
const BROADBAND: [Position; 20] = [
    [-0.99, 0.0, 0.15],
    [0.50, -0.86, 0.15],
    [0.50, 0.86, 0.15],
    [-0.45, 0.77, 0.45],
    [-0.45, -0.77, 0.45],
    [0.89, 0.0, 0.45],
    [0.33, 0.57, 0.75],
    [-0.66, 0.0, 0.75],
    [0.33, -0.57, 0.75],
    [0.0, 0.0, 1.0],
    [0.99, 0.0, 0.15],
    [-0.50, 0.86, 0.15],
    [-0.50, -0.86, 0.15],
    [0.45, -0.77, 0.45],
    [0.45, 0.77, 0.45],
    [-0.89, 0.0, 0.45],
    [-0.33, -0.57, 0.75],
    [0.66, 0.0, 0.75],
    [-0.33, 0.57, 0.75],
    [0.0, 0.0, 1.0],
];

impl Iso3744 {
    /// The ten key positions or, with the additional ones, all twenty, on a hemisphere of a radius \[m\] about the
    /// origin. The tables are rounded to hundredths; the positions are moved onto the hemisphere along their radius.
    pub fn positions(self, radius: f64, additional: bool) -> Vec<Position> {
        let table = match self {
            Self::Tones => TONES,
            Self::Broadband => BROADBAND,
        };
        let onto_hemisphere = |position: &Position| {
            let length = position.iter().map(|part| part * part).sum::<f64>().sqrt();
            position.map(|part| part * radius / length)
        };
        table[..if additional { 20 } else { 10 }].iter().map(onto_hemisphere).collect()
    }

    /// Sound power \[W\] from the mean squares \[Pa^2\] at the positions of a radius \[m\]: their mean times the area,
    /// over the air's impedance. NaN without a position.
    pub fn power(mean_squares: &[f64], radius: f64, air: &Air) -> f64 {
        let mean = mean_squares.iter().sum::<f64>() / mean_squares.len() as f64;
        TAU * radius * radius * mean / air.impedance()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::numeric::legendre;

    /// A grid over a hemisphere about the origin: Gauss-Legendre nodes in height, even steps around; exact for
    /// directivities that it resolves.
    #[derive(Clone, Debug, PartialEq)]
    struct Hemisphere {
        /// Positions \[m\], ring by ring from the top, each from straight ahead by the left.
        positions: Vec<Position>,
        /// Area of each position \[m^2\].
        areas: Vec<f64>,
    }

    impl Hemisphere {
        /// Grid of `rings` rings of `around` positions each on a radius \[m\].
        fn new(radius: f64, rings: usize, around: usize) -> Self {
            let mut grid = Self { positions: Vec::new(), areas: Vec::new() };
            for [node, weight] in legendre::gauss(rings) {
                // Equal heights have equal areas (Archimedes): the rule on (-1, 1) goes to (0, 1).
                let height = 0.5 * (node + 1.0);
                let across = (1.0 - height * height).sqrt();
                for index in 0..around {
                    let (sin, cos) = (TAU * index as f64 / around as f64).sin_cos();
                    grid.positions.push([radius * across * cos, radius * across * sin, radius * height]);
                    grid.areas.push(PI * radius * radius * weight / around as f64);
                }
            }
            grid
        }

        /// Sound power \[W\] from the mean squares \[Pa^2\] at the positions.
        fn power(&self, mean_squares: &[f64], air: &Air) -> f64 {
            self.areas.iter().zip(mean_squares).map(|(area, square)| area * square).sum::<f64>() / air.impedance()
        }
    }

    #[test]
    fn tables_are_whole_and_lie_on_the_hemisphere() {
        for table in [TONES, BROADBAND] {
            for position in table {
                let length = position.iter().map(|part| part * part).sum::<f64>().sqrt();
                // Three numbers rounded to hundredths.
                assert!((length - 1.0).abs() < 0.015, "{position:?}: {length}");
            }
            // Equal areas: the mean height of a hemisphere's surface is half of its radius, its middle is on the axis.
            for positions in [&table[..10], &table[..]] {
                let mean =
                    |part: usize| positions.iter().map(|position| position[part]).sum::<f64>() / positions.len() as f64;
                assert!(mean(0).abs() < 0.065 && mean(1).abs() < 0.065 && (mean(2) - 0.5).abs() < 0.02);
            }
        }
        // The additional positions are the key positions, turned about the vertical.
        for (table, angle) in [(TONES, 60.0_f64), (BROADBAND, 180.0)] {
            let (sin, cos) = angle.to_radians().sin_cos();
            for (key, additional) in table[..10].iter().zip(&table[10..]) {
                let turned = [key[0] * cos - key[1] * sin, key[0] * sin + key[1] * cos, key[2]];
                let off = turned.iter().zip(additional).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < 0.02, "{key:?} turns to {turned:?}, the table has {additional:?}");
            }
        }
        // The heights of the ten key positions for tones all differ.
        let mut heights: Vec<f64> = TONES[..10].iter().map(|position| position[2]).collect();
        heights.sort_by(f64::total_cmp);
        assert!(heights.windows(2).all(|pair| pair[1] - pair[0] > 0.009));
        let positions = Iso3744::Tones.positions(2.0, true);
        assert!(positions.len() == 20 && positions.iter().all(|[x, y, z]| (x.hypot(*y).hypot(*z) - 2.0).abs() < 1e-12));
    }

    #[test]
    fn power_of_a_monopole_at_the_origin_is_that_of_its_pressure() {
        // p = 1 Pa at 1 m on a rigid plane: W = 2 pi/(rho c).
        let air = Air::at(20.0).unwrap();
        let exact = TAU / air.impedance();
        let grid = Hemisphere::new(3.0, 4, 6);
        for power in [Iso3744::power(&[1.0 / 9.0; 10], 3.0, &air), grid.power(&[1.0 / 9.0; 24], &air)] {
            assert!((power / exact - 1.0).abs() < 1e-12);
        }
        assert!((power_level(1e-9) - 30.0).abs() < 1e-12);
    }

    #[test]
    fn the_grid_integrates_a_directivity_exactly() {
        // Int (1 + 2 x^2 z + 3 y^2) dS over the unit hemisphere = 2 pi (1 + 2/8 + 1).
        let square = |[x, y, z]: &Position| 1.0 + 2.0 * x * x * z + 3.0 * y * y;
        let exact = TAU * 2.25;
        let air = Air::at(20.0).unwrap();
        let grid = Hemisphere::new(1.0, 3, 6);
        let squares: Vec<f64> = grid.positions.iter().map(square).collect();
        assert!((grid.power(&squares, &air) * air.impedance() / exact - 1.0).abs() < 1e-12);
        for table in [Iso3744::Tones, Iso3744::Broadband] {
            for additional in [false, true] {
                let squares: Vec<f64> = table.positions(1.0, additional).iter().map(square).collect();
                let off = 10.0 * (Iso3744::power(&squares, 1.0, &air) * air.impedance() / exact).log10();
                assert!(off.abs() < 0.3, "{table:?}, {additional}: {off} dB");
            }
        }
    }
}
