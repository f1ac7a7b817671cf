//! Forces on the cells of a window, resolved into the tyre's lateral waves.

use crate::tyre::influence::{CellGrid, traction_shape};

/// F_m = sum_j s_m(y_j) F_j of every column, for some lateral numbers m. Even and odd shapes see only the sums or the
/// differences of opposite cells, which halves the work.
#[derive(Clone, Debug)]
pub(crate) struct LateralForces {
    across: usize,
    numbers: Vec<usize>,
    /// Shapes of normal and longitudinal forces.
    normal: Shapes,
    /// Shapes of lateral forces, where there are tangential forces.
    lateral: Option<Shapes>,
    /// Sums and differences of opposite cells of a column.
    sides: [Vec<f64>; 2],
    /// By channel and column.
    components: Vec<f64>,
}

#[derive(Clone, Debug)]
struct Shapes {
    /// s_m(y_j) by m, j up to the middle.
    values: Vec<f64>,
    /// True if a wave is even about mid-width, by m.
    even: Vec<bool>,
}

impl Shapes {
    fn of(
        grid: &CellGrid,
        numbers: &[usize],
        shape: impl Fn(usize, usize) -> f64,
        even: impl Fn(usize) -> bool,
    ) -> Self {
        let half = grid.across.div_ceil(2);
        let shape = &shape;
        let values = numbers.iter().flat_map(|&m| (0..half).map(move |j| shape(m, j))).collect();
        Self { values, even: numbers.iter().map(|&m| even(m)).collect() }
    }

    /// Components of the forces of a window's columns, given cell by cell, column by column; by number m and column.
    fn resolve(
        &self,
        forces: impl Fn(usize) -> f64,
        across: usize,
        [sums, differences]: &mut [Vec<f64>; 2],
        components: &mut [f64],
    ) {
        let (half, columns) = (sums.len(), components.len() / self.even.len());
        for column in 0..columns {
            let cell = |j: usize| forces(column * across + j);
            for j in 0..half {
                // The middle one of an odd number of cells counts once.
                let other = if 2 * j + 1 == across { 0.0 } else { cell(across - 1 - j) };
                (sums[j], differences[j]) = (cell(j) + other, cell(j) - other);
            }
            for (index, (shape, &even)) in self.values.chunks_exact(half).zip(&self.even).enumerate() {
                let side = if even { &*sums } else { &*differences };
                components[index * columns + column] = shape.iter().zip(side).map(|(s, force)| s * force).sum();
            }
        }
    }
}

impl LateralForces {
    /// Resolution of normal forces into the lateral numbers `numbers`.
    pub(crate) fn new(grid: &CellGrid, numbers: Vec<usize>) -> Self {
        let is_even = |m: usize| grid.waves().is_even(m);
        Self {
            across: grid.across,
            normal: Shapes::of(grid, &numbers, |m, j| grid.shape(m, j), is_even),
            lateral: None,
            sides: [(); 2].map(|()| vec![0.0; grid.across.div_ceil(2)]),
            components: Vec::new(),
            numbers,
        }
    }

    /// The same for tangential forces too, if `are_there`.
    pub(crate) fn with_tangential(self, grid: &CellGrid, are_there: bool) -> Self {
        // A sine across is even about the middle where the cosine is odd; m = 0 has no lateral motion.
        let is_even = |m: usize| !grid.waves().is_even(m);
        let shapes = || Shapes::of(grid, &self.numbers, |m, j| traction_shape(grid, 1, m, j), is_even);
        Self { lateral: are_there.then(shapes), ..self }
    }

    pub(crate) fn count(&self) -> usize {
        self.numbers.len()
    }

    /// Components of a step's forces \[N\]. Forces are given stage after stage by cell, in windows of `columns`
    /// columns; components come stage after stage and number m by m, by column.
    pub(crate) fn of(&mut self, forces: &[f64], columns: usize) -> &[f64] {
        let Self { across, numbers, normal, sides, components, .. } = self;
        let count = numbers.len();
        components.resize(forces.len() / *across * count, 0.0);
        let stages = forces.chunks_exact(columns * *across).zip(components.chunks_exact_mut(count * columns));
        for (forces, components) in stages {
            normal.resolve(|cell| forces[cell], *across, sides, components);
        }
        components
    }

    /// Components of an instant's forces \[N\], with the tangential ones by cell where there are such: those of normal,
    /// then of longitudinal, then of lateral forces.
    pub(crate) fn of_all(&mut self, forces: &[f64], tangential: Option<&[[f64; 2]]>, columns: usize) -> &[f64] {
        if self.lateral.is_none() {
            return self.of(forces, columns);
        }
        let Self { across, numbers, normal, lateral, sides, components } = self;
        let of_component = numbers.len() * columns;
        components.clear();
        components.resize(3 * of_component, 0.0);
        let (of_normal, of_tangential) = components.split_at_mut(of_component);
        let (along, aside) = of_tangential.split_at_mut(of_component);
        normal.resolve(|cell| forces[cell], *across, sides, of_normal);
        if let Some((lateral, tangential)) = lateral.as_ref().zip(tangential) {
            normal.resolve(|cell| tangential[cell][0], *across, sides, along);
            lateral.resolve(|cell| tangential[cell][1], *across, sides, aside);
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
