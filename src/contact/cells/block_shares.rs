//! Contribution to a preconditioner of blocks, which yield beside the free field.
//!
//! With W the middle of the inverse of the free field's T, U_ib = 1 on part b of a block, and K how far parts yield
//! under forces on them, Woodbury's formula gives for (T + U K U^T)^-1 on a set A of cells
//!
//! ```text
//! W - W U C U^T W,   C = (K^-1 + S)^-1,   S = U^T W U on A.
//! ```
//!
//! U^T W is taken as U^T R, R the diagonal of W's sums over the active cells of the same block, and S as s = U^T R U:
//! the influence of one block on another is left out, and how far parts of a rib yield differs little from one to the
//! next. So one product with W does, W (1 - U C U^T R). It is not symmetric; directions are made conjugate by their
//! residuals. Then C = s^-1/2 (1 - (1 + B)^-1) s^-1/2 with the band matrix B = s^1/2 K s^1/2 of a rib, and K/(1 +
//! K s) of a block.

use super::blocks::BlockTerm;
use super::filter::Filter;

/// Least s, in parts of W for one cell.
const LEAST: f64 = 1e-3;

#[derive(Default)]
pub(super) struct BlockShares {
    /// Part of each cell, 0 for none, and the block of each part, 0 for part 0.
    of_cell: Vec<u32>,
    blocks: Vec<u32>,
    /// R of each cell, 0 off A.
    rows: Vec<f32>,
    /// Sums over the active cells of parts, and the number of these.
    sums: Vec<f64>,
    active: Vec<u32>,
    /// C of blocks by number of the part; 0 for parts of ribs and part 0.
    factors: Vec<f64>,
    ribs: Ribs,
    /// C U^T R r.
    yields: Vec<f64>,
    /// r - U C U^T R r.
    without_blocks: Vec<f32>,
}

/// Factorised band matrices of ribs, one behind the other.
#[derive(Default)]
struct Ribs {
    /// Number of rows and width of the band, by rib.
    shapes: Vec<[usize; 2]>,
    /// Number of the part and s^1/2, by row.
    rows: Vec<(u32, f64)>,
    /// Cholesky factor of 1 + B, row by row from the diagonal back.
    band: Vec<f64>,
    solution: Vec<f64>,
}

impl Ribs {
    fn clear(&mut self) {
        self.shapes.clear();
        self.rows.clear();
        self.band.clear();
    }

    /// Adds a rib of parts (number, s), `length` of which yield together with weights by place; `first` is the number
    /// of the rib's first part.
    fn add(&mut self, parts: impl Iterator<Item = (usize, f64)>, first: usize, length: usize, weights: &[f64]) {
        let (begin, from) = (self.rows.len(), self.band.len());
        self.rows.extend(parts.map(|(part, s)| (part as u32, s.sqrt())));
        let rows = &self.rows[begin..];
        self.band.resize(from + rows.len() * length, 0.0);
        let band = &mut self.band[from..];
        for (i, &(part, root)) in rows.iter().enumerate() {
            let place = part as usize - first;
            for k in (i + 1).saturating_sub(length)..=i {
                let (other, its_root) = rows[k];
                let other = other as usize - first;
                let both: f64 = weights.get(place..other + length).map_or(0.0, |weights| weights.iter().sum());
                let before = (i + 1).saturating_sub(length)..k;
                let known: f64 = before.map(|j| band[i * length + i - j] * band[k * length + k - j]).sum();
                let entry = root * its_root * both - known;
                band[i * length + i - k] =
                    if k == i { (1.0 + entry).max(f64::MIN_POSITIVE).sqrt() } else { entry / band[k * length] };
            }
        }
        self.shapes.push([rows.len(), length]);
    }

    /// Writes C times sums for the parts of ribs.
    fn apply(&mut self, sums: &[f64], yields: &mut [f64]) {
        let Self { shapes, rows, band, solution } = self;
        let (mut rows, mut band) = (rows.as_slice(), band.as_slice());
        for &[count, length] in &*shapes {
            let (rib_rows, rib_band);
            (rib_rows, rows) = rows.split_at(count);
            (rib_band, band) = band.split_at(count * length);
            solution.clear();
            for (i, &(part, root)) in rib_rows.iter().enumerate() {
                let before = (i + 1).saturating_sub(length)..i;
                let known: f64 = before.map(|j| rib_band[i * length + i - j] * solution[j]).sum();
                solution.push((sums[part as usize] / root - known) / rib_band[i * length]);
            }
            for i in (0..count).rev() {
                solution[i] /= rib_band[i * length];
                let value = solution[i];
                for j in (i + 1).saturating_sub(length)..i {
                    solution[j] -= rib_band[i * length + i - j] * value;
                }
            }
            for (&(part, root), value) in rib_rows.iter().zip(&*solution) {
                yields[part as usize] = (sums[part as usize] / root - value) / root;
            }
        }
    }
}

impl BlockShares {
    /// Finds C of the blocks on the cells of A, where `residual` is not 0.
    pub(super) fn take(&mut self, term: &BlockTerm, filter: &Filter<f32>, residual: &[f32]) {
        let Self { of_cell, blocks, rows, sums, active, factors, ribs, .. } = self;
        let Filter { across, radius, stencil, .. } = filter;
        let (across, radius, columns) = (*across, *radius, residual.len() / *across);
        // 1. Part of each cell and block of each part.
        of_cell.clear();
        of_cell.extend_from_slice(term.parts(residual.len()));
        blocks.clear();
        blocks.push(0);
        for (block, (numbers, ..)) in (1..).zip(term.spans()) {
            blocks.extend(numbers.map(|_| block));
        }
        // 2. R and s: sums of W's stencil over the active cells of the same block.
        rows.clear();
        rows.resize(residual.len(), 0.0);
        sums.clear();
        sums.resize(blocks.len(), 0.0);
        active.clear();
        active.resize(blocks.len(), 0);
        for (cell, &part) in of_cell.iter().enumerate().filter(|(cell, _)| residual[*cell].abs() > 0.0) {
            let (i, j) = (cell / across, cell % across);
            let block = blocks[part as usize];
            active[part as usize] += 1;
            for column in i.saturating_sub(radius)..(i + radius + 1).min(columns) {
                let weights = &stencil[column.abs_diff(i) * (radius + 1)..];
                for place in j.saturating_sub(radius)..(j + radius + 1).min(across) {
                    let other = column * across + place;
                    if blocks[of_cell[other] as usize] == block && residual[other].abs() > 0.0 {
                        rows[cell] += weights[place.abs_diff(j)];
                    }
                }
            }
            sums[part as usize] += f64::from(rows[cell]);
        }
        // 3. C: a number for each block, a band matrix for each rib.
        factors.clear();
        factors.resize(blocks.len(), 0.0);
        ribs.clear();
        let least = LEAST * f64::from(stencil[0]);
        for (numbers, length, weights) in term.spans() {
            if length == 1 {
                for (number, weight) in numbers.zip(weights) {
                    factors[number] = weight / (1.0 + weight * sums[number].max(0.0));
                }
            } else {
                let first = numbers.start;
                let parts = numbers.filter(|number| active[*number] > 0);
                ribs.add(parts.map(|number| (number, sums[number].max(least))), first, length, weights);
            }
        }
    }

    /// r - U C U^T R r on A: W times that is the preconditioned residual.
    pub(super) fn taken_off(&mut self, residual: &[f32]) -> &[f32] {
        let Self { of_cell, rows, sums, factors, yields, ribs, without_blocks, .. } = self;
        sums.fill(0.0);
        for ((row, residual), &part) in rows.iter().zip(residual).zip(&*of_cell) {
            sums[part as usize] += f64::from(row * residual);
        }
        yields.clear();
        yields.extend(sums.iter().zip(&*factors).map(|(sum, factor)| sum * factor));
        ribs.apply(sums, yields);
        without_blocks.clear();
        let pairs = residual.iter().zip(&*of_cell);
        without_blocks.extend(pairs.map(|(&residual, &part)| {
            if residual.abs() > 0.0 { residual - yields[part as usize] as f32 } else { 0.0 }
        }));
        without_blocks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rib_is_factorised_as_its_matrices_are() {
        // Six parts of which two are not active, three of which yield together.
        let (length, first) = (3, 4);
        let weights = [0.3, 0.5, 0.2, 0.4, 0.6, 0.1, 0.7, 0.2];
        let s = [2.0, 0.0, 1.5, 0.7, 0.0, 1.1];
        let active: Vec<usize> = (0..6).filter(|part| s[*part] > 0.0).collect();
        let mut ribs = Ribs::default();
        ribs.add(active.iter().map(|&part| (first + part, s[part])), first, length, &weights);
        let given = [0.0, 0.0, 0.0, 0.0, 0.8, 9.0, -0.3, 1.4, 9.0, 0.5];
        let mut found = vec![0.0; 10];
        ribs.apply(&given, &mut found);
        assert!(found[..4].iter().all(|value| *value == 0.0) && found[5] == 0.0 && found[8] == 0.0);
        // (K^-1 + S) x = y, that is x + K S x = K y.
        let kernel = |a: usize, b: usize| -> f64 {
            (0..weights.len())
                .filter(|t| (a..a + length).contains(t) && (b..b + length).contains(t))
                .map(|t| weights[t])
                .sum()
        };
        for &a in &active {
            let of = |value: &dyn Fn(usize) -> f64| active.iter().map(|&b| kernel(a, b) * value(b)).sum::<f64>();
            let left = found[first + a] + of(&|b| s[b] * found[first + b]);
            let right = of(&|b| given[first + b]);
            assert!((left - right).abs() < 1e-13, "{a}: {left} and {right}");
        }
    }
}
