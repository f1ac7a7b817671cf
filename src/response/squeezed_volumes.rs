//! Volumes that forces on the cells of a window displace at blocks and at the voids beside them.
//!
//! A block gives c_b F_b: its cells go in by equal parts of it, and the void cells beside it come out by equal parts.
//! A rib gives the mean over all places of a block on it. The sum over all cells is 0. Cells are material; a wider
//! window than that of the forces holds whole blocks.

use crate::contact::geometry::Geometry;
use crate::tyre::tread_pattern::block_window::{BlockWindow, spread_from_places, sum_over_places};
use crate::tyre::tread_pattern::squeeze::Squeeze;

/// Displaced volumes over the cells of a window, with the buffers of their computation.
#[derive(Clone, Debug)]
pub(crate) struct SqueezedVolumes {
    squeeze: Squeeze,
    /// Window of the volumes.
    geometry: Geometry,
    /// Columns of this window on either side of the window of the forces.
    margin: usize,
    window: BlockWindow,
    /// Force by number of a part.
    forces: Vec<f64>,
    /// Forces by place of averaging, those times one of the shares, and volumes by part, of one block.
    places: Vec<f64>,
    shared: Vec<f64>,
    parts: Vec<f64>,
    /// By channel and column \[m^3\].
    volumes: Vec<f64>,
}

impl SqueezedVolumes {
    /// For forces in the window `forces`; the window of the volumes is wider by the reach of a block.
    pub(crate) fn new(squeeze: Squeeze, forces: &Geometry) -> Self {
        let margin = Self::margin(&squeeze, forces.columns);
        let geometry = forces.wider(margin);
        let window = BlockWindow::new(&squeeze.blocks, squeeze.across, geometry.columns);
        let none = Vec::new;
        Self {
            squeeze,
            geometry,
            margin,
            window,
            forces: none(),
            places: none(),
            shared: none(),
            parts: none(),
            volumes: none(),
        }
    }

    /// Columns by which a window of so many is extended at either end: the reach of a block, or half of what is left of
    /// the circumference.
    pub(crate) fn margin(squeeze: &Squeeze, columns: usize) -> usize {
        squeeze.reach().min(squeeze.columns.saturating_sub(columns) / 2)
    }

    pub(crate) fn window(&self) -> &Geometry {
        &self.geometry
    }

    /// Volumes \[m^3\] by which cells go in under a step's forces, which are given stage after stage by cell. In the
    /// order: stage, cell across, column of the wider window.
    pub(crate) fn of(&mut self, step: u64, forces: &[f64]) -> &[f64] {
        let Self { squeeze, geometry, margin, window, forces: of_part, places, shared, parts, volumes } = self;
        let (around, across, columns) = (squeeze.columns as i64, squeeze.across, geometry.columns);
        let first = geometry.first_element(step);
        window.place(first);
        let cells = (columns - 2 * *margin) * across;
        volumes.clear();
        volumes.resize(forces.len() / cells * across * columns, 0.0);
        for (forces, volumes) in forces.chunks_exact(cells).zip(volumes.chunks_exact_mut(across * columns)) {
            // 1. Force on each part of a block.
            of_part.clear();
            of_part.resize(window.count(), 0.0);
            for (force, &part) in forces.iter().zip(&window.cells()[*margin * across..]) {
                of_part[part as usize] += force;
            }
            // 2. Mean over the places of a block on its rib, times its shares, spread back to parts and cells.
            for span in window.spans() {
                let forces = &of_part[span.numbers()];
                if forces.iter().all(|force| *force == 0.0) {
                    continue;
                }
                sum_over_places(forces, span.length, places);
                parts.resize(forces.len(), 0.0);
                // Cells of the block go in, voids beside it come out.
                for (share, sign) in [1.0, -1.0].into_iter().enumerate() {
                    shared.clear();
                    let weights = window.places(span).map(|place| squeeze.shares[place][share]);
                    shared.extend(places.iter().zip(weights).map(|(force, weight)| sign * weight * force));
                    spread_from_places(shared, span.length, parts);
                    for (part, &volume) in window.parts(span).zip(&*parts) {
                        let cells = if share == 0 { squeeze.block_cells(part) } else { squeeze.voids(part) };
                        for cell in cells.iter().map(|cell| *cell as usize) {
                            let column = ((cell / across) as i64 - first).rem_euclid(around) as usize;
                            if column < columns {
                                volumes[cell % across * columns + column] += volume;
                            }
                        }
                    }
                }
            }
        }
        volumes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tyre::tread_pattern::blocks::{NO_BLOCK, TreadBlocks};

    const AROUND: usize = 24;
    const ACROSS: usize = 4;

    /// Blocks of two columns and two cells, a column of void between them and two rows of it beside.
    fn squeeze() -> Squeeze {
        let block = |i: usize, j: usize| if i % 3 < 2 && j < 2 { (i / 3) as u32 } else { NO_BLOCK };
        let of_cell = (0..AROUND).flat_map(|i| (0..ACROSS).map(move |j| block(i, j))).collect();
        let count = AROUND / 3;
        let compliance: Vec<f64> = (0..count).map(|block| 1e-10 * (1.0 + block as f64)).collect();
        Squeeze::new(&TreadBlocks::whole(of_cell, &compliance), ACROSS)
    }

    #[test]
    fn volumes_are_conserved_and_move_with_their_cells() {
        let forces = Geometry::new(2.4, AROUND, 2, 0.03, 0.2);
        let mut volumes = SqueezedVolumes::new(squeeze(), &forces);
        let (margin, columns) = (squeeze().reach(), volumes.window().columns);
        assert_eq!((margin, columns), (3, forces.columns + 6));
        for step in [0, 1, 2, 7, 40, 95] {
            let first = forces.first_element(step);
            let cell = |element: i64, j: usize| 10.0 + (1.3 * element as f64 + 0.7 * j as f64).sin();
            let elements = first..first + forces.columns as i64;
            // Two instants, the second of half the force.
            let one: Vec<f64> = elements.clone().flat_map(|e| (0..ACROSS).map(move |j| cell(e, j))).collect();
            let both: Vec<f64> = one.iter().copied().chain(one.iter().map(|force| 0.5 * force)).collect();
            let found = volumes.of(step, &both).to_vec();
            assert_eq!(found.len(), 2 * ACROSS * columns);
            for (stage, found) in found.chunks_exact(ACROSS * columns).enumerate() {
                let scale = found.iter().map(|volume| volume.abs()).sum::<f64>();
                assert!(scale > 0.0 && found.iter().sum::<f64>().abs() < 1e-14 * scale, "{step}");
                let part = [1.0, 0.5][stage];
                for (place, volume) in found.iter().enumerate() {
                    let (j, element) = (place / columns, first - margin as i64 + (place % columns) as i64);
                    let around = AROUND as i64;
                    let of_block = |block: i64| {
                        let cells = (3 * block..3 * block + 2).flat_map(|e| [(e, 0), (e, 1)]);
                        let turned = |e: i64| elements.clone().find(|element| (element - e).rem_euclid(around) == 0);
                        let force = cells.filter_map(|(e, j)| Some(cell(turned(e)?, j))).sum::<f64>();
                        part * force * 1e-10 * (1.0 + block as f64)
                    };
                    let block = element.rem_euclid(around) / 3;
                    let expected = match (element.rem_euclid(3), j) {
                        // Four cells of the block itself; two beside it in the groove, two before and two behind.
                        (0 | 1, 0 | 1) => of_block(block) / 4.0,
                        (0 | 1, 2) => -of_block(block) / 6.0,
                        (2, 0 | 1) => -(of_block(block) + of_block((block + 1) % (around / 3))) / 6.0,
                        _ => 0.0,
                    };
                    assert!((volume - expected).abs() < 1e-22, "{step} {element} {j}: {volume:e} {expected:e}");
                }
            }
        }
        assert!(volumes.of(0, &vec![0.0; forces.columns * ACROSS]).iter().all(|volume| *volume == 0.0));
    }
}
