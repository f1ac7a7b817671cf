//! Forces on the cells of a window, resolved into the tyre's lateral waves.

use crate::tyre::influence::CellGrid;

/// F_m = sum_j s_m(y_j) F_j of every column, for some lateral numbers m.
#[derive(Clone, Debug)]
pub(crate) struct LateralForces {
    across: usize,
    numbers: Vec<usize>,
    /// s_m(y_j) by m, j up to the middle.
    shapes: Vec<f64>,
    /// True if a wave is even about mid-width, by m.
    even: Vec<bool>,
    /// Sums and differences of opposite cells of a column.
    sides: [Vec<f64>; 2],
    /// By channel and column.
    components: Vec<f64>,
}

impl LateralForces {
    /// Makes the resolution into these numbers.
    pub(crate) fn new(grid: &CellGrid, numbers: Vec<usize>) -> Self {
        let half = grid.across.div_ceil(2);
        Self {
            across: grid.across,
            shapes: numbers.iter().flat_map(|&m| (0..half).map(move |j| grid.shape(m, j))).collect(),
            even: numbers.iter().map(|&m| grid.waves().is_even(m)).collect(),
            sides: [(); 2].map(|()| vec![0.0; half]),
            components: Vec::new(),
            numbers,
        }
    }

    /// Returns the components of a step's forces, stage after stage by cell, in windows of so many columns: stage after
    /// stage and m by m by column \[N\].
    pub(crate) fn of(&mut self, forces: &[f64], columns: usize) -> &[f64] {
        let Self { across, numbers, shapes, even, sides: [sums, differences], components } = self;
        let (across, half, count) = (*across, sums.len(), numbers.len());
        components.resize(forces.len() / across * count, 0.0);
        let stages = forces.chunks_exact(columns * across).zip(components.chunks_exact_mut(count * columns));
        for (forces, components) in stages {
            for (column, cells) in forces.chunks_exact(across).enumerate() {
                for j in 0..half {
                    // The middle one of an odd number of cells is there once.
                    let other = if 2 * j + 1 == across { 0.0 } else { cells[across - 1 - j] };
                    (sums[j], differences[j]) = (cells[j] + other, cells[j] - other);
                }
                for (index, (shape, &even)) in shapes.chunks_exact(half).zip(&*even).enumerate() {
                    let side = if even { &*sums } else { &*differences };
                    components[index * columns + column] = shape.iter().zip(side).map(|(s, force)| s * force).sum();
                }
            }
        }
        components
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DEFAULT, PLATE, Scene};

    #[test]
    fn components_are_the_sums_over_all_cells() {
        for scene in [PLATE, DEFAULT] {
            let tyre = Scene::from_str(scene, "scene").unwrap().scene.tyre;
            for across in [1, 4, 5] {
                let grid = CellGrid::new(&tyre, 64, across);
                let numbers: Vec<usize> = grid.lateral_numbers().take(7).collect();
                let mut lateral = LateralForces::new(&grid, numbers.clone());
                let (stages, columns) = (2, 3);
                let force = |cell: usize| (1.7 * cell as f64).sin();
                let forces: Vec<f64> = (0..stages * columns * across).map(force).collect();
                let found = lateral.of(&forces, columns);
                assert_eq!(found.len(), stages * columns * numbers.len());
                for (place, found) in found.iter().enumerate() {
                    let (column, channel) = (place % columns, place / columns);
                    let (stage, m) = (channel / numbers.len(), numbers[channel % numbers.len()]);
                    let cell = |j: usize| force((stage * columns + column) * across + j);
                    let exact: f64 = (0..across).map(|j| grid.shape(m, j) * cell(j)).sum();
                    // The middle cell of odd waves has a shape of the size of rounding.
                    assert!((found - exact).abs() < 1e-14, "{across}: {found} {exact}");
                }
            }
        }
    }
}
