//! Pieces of a road, made periodic, to be pressed into a half-space.
//!
//! 1. A piece is drawn with a border more than it needs along and across; its mean plane is removed.
//! 2. The border beyond the end fades into the beginning: z = sin(t) z_begin + cos(t) z_beyond, t from 0 to pi/2,
//!    keeps the mean square of uncorrelated heights.
//! 3. Along, the cells divide the run's elements, so that elements can be cut out of the piece.

use std::f64::consts::FRAC_PI_2;

use crate::half_space::rough::{Extent, HeightMap};
use crate::numeric::transform_length;
use crate::road::sources::height_map::remove_plane;
use crate::road::{Lattice, Limits, RoadError, RoadSurface};
use crate::scene::Road;

/// Length and width of a patch \[m\]: about those of a tyre's contact.
const SIZE: f64 = 0.12;
/// Cells along and across \[m\]: a third of the shortest wave that counts.
const CELL: f64 = 0.00125;
/// Length over which a patch fades into its beginning \[m\].
const BORDER: f64 = 0.02;

/// Numbers and sizes of a patch's cells and elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PatchGrid {
    /// Elements along.
    pub elements: usize,
    /// Cells along an element.
    pub along: usize,
    /// Cells across.
    pub columns: usize,
    /// Length of a cell \[m\].
    pub dx: f64,
    /// Width of a cell \[m\].
    pub dy: f64,
}

impl PatchGrid {
    pub(crate) fn new(element: f64) -> Self {
        // Transforms are fast for small prime factors: twice such a number is a transform's length itself.
        let smooth = |n: usize| transform_length(2 * n) == 2 * n;
        let first = |from: f64, fits: &dyn Fn(usize) -> bool| -> usize {
            let mut n = from.round().max(1.0) as usize;
            while !fits(n) {
                n += 1;
            }
            n
        };
        let along = first(element / CELL, &smooth);
        let elements = first((SIZE / element).max(2.0), &|n| transform_length(n * along) == n * along);
        let columns = transform_length((SIZE / CELL).round() as usize);
        Self { elements, along, columns, dx: element / along as f64, dy: CELL }
    }

    /// Cells along the patch.
    pub(crate) fn rows(self) -> usize {
        self.elements * self.along
    }
}

/// Patches of a road, at most `most`, spread evenly over a road that ends, one behind the other on one that does not;
/// empty for a smooth road.
///
/// # Errors
/// Errors of the road; [`RoadError::Short`] for one without room for a patch.
pub(crate) fn patches(road: &Road, limits: Limits, grid: PatchGrid, most: usize) -> Result<Vec<HeightMap>, RoadError> {
    let border = |cell: f64| (BORDER / cell).round().max(1.0) as usize;
    let (rows, columns) = (grid.rows() + border(grid.dx), grid.columns + border(grid.dy));
    let lattice = Lattice { dx: grid.dx, dy: grid.dy, columns, along: 1 };
    let mut surface = RoadSurface::open(road, lattice, limits)?;
    if surface.is_smooth() {
        return Ok(Vec::new());
    }
    // A road that is repeated or mirrored holds no more than its length.
    let length = surface.extent().map(|(_, end)| end).or(surface.report().length);
    let (count, pitch) = match length.map(|length| (length / grid.dx + 1e-9).floor() as usize + 1) {
        None => (most, rows),
        Some(there) if there < rows => {
            let needed = (0.0, (rows - 1) as f64 * grid.dx);
            return Err(RoadError::Short { needed, available: (0.0, length.unwrap_or(0.0)) });
        }
        Some(there) => {
            let count = most.min(there / rows);
            (count, (there - rows).checked_div(count.max(2) - 1).unwrap_or(0))
        }
    };
    let mut heights = vec![0.0; rows * columns];
    let mut patches = Vec::with_capacity(count);
    for patch in 0..count {
        surface.heights((patch * pitch) as i64, rows, &mut heights)?;
        patches.push(periodic(&heights, (rows, columns), grid));
    }
    Ok(patches)
}

/// Steps 1 and 2 of the module: a patch of `rows` x `columns` heights, without its plane and its border.
fn periodic(heights: &[f64], (rows, columns): (usize, usize), grid: PatchGrid) -> HeightMap {
    let mut piece = heights.to_vec();
    remove_plane(&mut piece, columns);
    let extent = Extent { nx: grid.rows(), ny: grid.columns };
    let along: Vec<(f64, f64)> = fade(extent.nx, rows);
    let across: Vec<(f64, f64)> = fade(extent.ny, columns);
    let mut faded = Vec::with_capacity(extent.cells());
    for (i, &(here, beyond)) in along.iter().enumerate() {
        for (j, &(inside, other)) in across.iter().enumerate() {
            let row = |i: usize| {
                let row = &piece[i * columns..];
                inside * row[j] + if other > 0.0 { other * row[j + extent.ny] } else { 0.0 }
            };
            faded.push(here * row(i) + if beyond > 0.0 { beyond * row(i + extent.nx) } else { 0.0 });
        }
    }
    HeightMap { heights: faded, extent, dx: grid.dx, dy: grid.dy }
}

/// Weights of a height and of the one a period further on, for `period` of `all` heights.
fn fade(period: usize, all: usize) -> Vec<(f64, f64)> {
    let border = all - period;
    (0..period)
        .map(|i| {
            if i >= border {
                return (1.0, 0.0);
            }
            let phase = FRAC_PI_2 * (i as f64 + 0.5) / border as f64;
            (phase.sin(), phase.cos())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::road::texture::rms;
    use crate::scene::{MadeRoad, NamedTexture};

    #[test]
    fn cells_divide_elements_and_suit_transforms() {
        for (element, expected) in [(1.95 / 512.0, (32, 3, 96)), (1.95 / 256.0, (16, 6, 96)), (0.0015, (80, 1, 96))] {
            let grid = PatchGrid::new(element);
            assert_eq!((grid.elements, grid.along, grid.columns), expected);
            assert!((grid.dx * grid.along as f64 - element).abs() < 1e-15);
        }
        for element in [1e-4, 0.0087, 0.011, 0.05, 0.3] {
            let grid = PatchGrid::new(element);
            assert!(grid.elements >= 2 && transform_length(grid.rows()) == grid.rows(), "{element}: {grid:?}");
        }
    }

    #[test]
    fn patches_have_the_roads_roughness_and_no_seam() {
        let texture = Some(NamedTexture::RoughAsphalt);
        let road = Road::Made(MadeRoad { seed: 4, texture, ..MadeRoad::default() });
        let grid = PatchGrid::new(1.95 / 512.0);
        let found = patches(&road, Limits::default(), grid, 8).unwrap();
        assert_eq!(found.len(), 8);
        let (mut whole, mut seam, mut inside) = (0.0, 0.0, 0.0);
        for map in &found {
            let (nx, ny) = (map.extent.nx, map.extent.ny);
            whole += rms(&map.heights).powi(2) / 8.0;
            let step = |i: usize| -> f64 {
                (0..ny).map(|j| (map.heights[(i + 1) % nx * ny + j] - map.heights[i * ny + j]).powi(2)).sum()
            };
            seam += step(nx - 1);
            inside += step(nx / 2);
        }
        // Without waves longer than the patch, and 8 patches of some 20 waves each: 0.95 mm within a fifth.
        assert!((whole.sqrt() / 0.00080 - 1.0).abs() < 0.25, "{}", whole.sqrt());
        // Mean squares of 8 x 96 steps, correlated over some 5: within a third of each other.
        assert!((seam / inside).ln().abs() < 0.5, "{seam:e} at the seam, {inside:e} inside");
    }
}
