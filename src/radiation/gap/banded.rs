//! LU factors of a complex band matrix, with partial pivoting within the band.

use num_complex::Complex64;

/// Band matrix; after [`Self::factorise`] its factors.
#[derive(Clone, Debug)]
pub(crate) struct Banded {
    size: usize,
    /// Largest distance of an entry from the diagonal.
    band: usize,
    /// Row by row, columns from `row - band` to `row + 2 band`: pivoting fills the last `band` of them.
    entries: Vec<Complex64>,
    /// By column, the row in which its pivot stood.
    pivots: Vec<usize>,
    /// By row, the last column whose entry may not be zero.
    ends: Vec<usize>,
    /// By row, the factor that brought its largest entry to 1.
    scales: Vec<f64>,
}

impl Banded {
    pub(crate) fn zeros(size: usize, band: usize) -> Self {
        let entries = vec![Complex64::ZERO; size * (3 * band + 1)];
        let ends = (0..size).map(|row| (row + band).min(size - 1)).collect();
        Self { size, band, entries, pivots: Vec::new(), ends, scales: Vec::new() }
    }

    /// Memory \[bytes\] of such a matrix.
    pub(crate) fn bytes(size: usize, band: usize) -> usize {
        16 * size * (3 * band + 1)
    }

    /// Number of complex multiply-adds for the factors and for so many right sides.
    pub(crate) fn multiply_adds(size: usize, band: usize, rights: usize) -> f64 {
        // Rows are hardly ever exchanged: the upper factor keeps the band.
        size as f64 * (band * band + 2 * band * rights) as f64
    }

    fn place(&self, row: usize, column: usize) -> usize {
        row * (3 * self.band + 1) + column + self.band - row
    }

    /// Adds to an entry within the band.
    pub(crate) fn add(&mut self, row: usize, column: usize, value: Complex64) {
        let place = self.place(row, column);
        self.entries[place] += value;
    }

    /// Factorises in place, rows scaled by their largest entry; false if a pivot is zero or not finite.
    pub(crate) fn factorise(&mut self) -> bool {
        let (size, band, width) = (self.size, self.band, 3 * self.band + 1);
        self.scales = self
            .entries
            .chunks_exact(width)
            .map(|row| row.iter().map(|entry| entry.norm()).fold(0.0, f64::max).recip())
            .collect();
        for (row, scale) in self.entries.chunks_exact_mut(width).zip(&self.scales) {
            row.iter_mut().for_each(|entry| *entry *= scale);
        }
        self.pivots.clear();
        // Column by column: the pivot, its exchange with the row of the column, elimination below.
        for column in 0..size {
            let last = (column + band).min(size - 1);
            let mut pivot = (column, 0.0);
            for row in column..=last {
                let found = self.entries[self.place(row, column)].norm_sqr();
                if found > pivot.1 {
                    pivot = (row, found);
                }
            }
            if !(pivot.1 > 0.0 && pivot.1.is_finite()) {
                return false;
            }
            self.pivots.push(pivot.0);
            let longest = self.ends[column].max(self.ends[pivot.0]);
            self.ends.swap(column, pivot.0);
            let end = self.ends[column];
            let diagonal = self.place(column, column);
            let (upper, lower) = self.entries.split_at_mut(diagonal + longest - column + 1);
            let pivot_row = &mut upper[diagonal..];
            // `lower` begins behind the entries of `upper`.
            let begin = column * width + band + longest - column + 1;
            let below = |row: usize| row * width + column + band - row - begin;
            if pivot.0 != column {
                pivot_row.swap_with_slice(&mut lower[below(pivot.0)..][..longest - column + 1]);
            }
            let inverse = pivot_row[0].inv();
            for number in column + 1..=last {
                let row = &mut lower[below(number)..][..end - column + 1];
                if row[0] == Complex64::ZERO {
                    continue;
                }
                self.ends[number] = self.ends[number].max(end);
                let factor = row[0] * inverse;
                row[0] = factor;
                for (entry, above) in row[1..].iter_mut().zip(&pivot_row[1..]) {
                    entry.re -= factor.re * above.re - factor.im * above.im;
                    entry.im -= factor.re * above.im + factor.im * above.re;
                }
            }
        }
        true
    }

    /// Solves in place for `count` right sides, given row by row.
    pub(crate) fn solve(&self, rights: &mut [Complex64], count: usize) {
        if count == 0 {
            return;
        }
        // By row, all real parts, then all imaginary ones: the loops over right sides vectorise.
        let width = 2 * count;
        let mut parts = vec![0.0; self.size * width];
        for ((row, parts), scale) in rights.chunks_exact(count).zip(parts.chunks_exact_mut(width)).zip(&self.scales) {
            let (re, im) = parts.split_at_mut(count);
            for ((re, im), value) in re.iter_mut().zip(im).zip(row) {
                (*re, *im) = (value.re * scale, value.im * scale);
            }
        }
        // 1. Forwards through the lower factor, with the exchanges.
        for column in 0..self.size {
            let (above, below) = parts.split_at_mut((column + 1) * width);
            let pivot_row = &mut above[column * width..];
            let pivot = self.pivots[column];
            if pivot != column {
                pivot_row.swap_with_slice(&mut below[(pivot - column - 1) * width..][..width]);
            }
            let last = (column + self.band).min(self.size - 1);
            for (row, into) in (column + 1..=last).zip(below.chunks_exact_mut(width)) {
                take(into, pivot_row, self.entries[self.place(row, column)]);
            }
        }
        // 2. Backwards through the upper factor.
        for row in (0..self.size).rev() {
            let (above, below) = parts.split_at_mut((row + 1) * width);
            let solution = &mut above[row * width..];
            for (column, from) in (row + 1..=self.ends[row]).zip(below.chunks_exact(width)) {
                take(solution, from, self.entries[self.place(row, column)]);
            }
            let inverse = self.entries[self.place(row, row)].inv();
            let (re, im) = solution.split_at_mut(count);
            for (re, im) in re.iter_mut().zip(im) {
                (*re, *im) = (*re * inverse.re - *im * inverse.im, *re * inverse.im + *im * inverse.re);
            }
        }
        for (row, parts) in rights.chunks_exact_mut(count).zip(parts.chunks_exact(width)) {
            let (re, im) = parts.split_at(count);
            for ((value, re), im) in row.iter_mut().zip(re).zip(im) {
                *value = Complex64::new(*re, *im);
            }
        }
    }
}

/// Subtracts a row times a factor from another row, real parts before imaginary ones in both.
fn take(into: &mut [f64], from: &[f64], factor: Complex64) {
    let count = into.len() / 2;
    let ((into_re, into_im), (from_re, from_im)) = (into.split_at_mut(count), from.split_at(count));
    for (((into_re, into_im), from_re), from_im) in into_re.iter_mut().zip(into_im).zip(from_re).zip(from_im) {
        *into_re -= factor.re * from_re - factor.im * from_im;
        *into_im -= factor.re * from_im + factor.im * from_re;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_that_need_pivots_are_solved_to_rounding() {
        let (size, band) = (40, 5);
        let mut random = 1_u64;
        let mut next = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let mut matrix = Banded::zeros(size, band);
        let mut dense = vec![Complex64::ZERO; size * size];
        for row in 0..size {
            for column in row.saturating_sub(band)..=(row + band).min(size - 1) {
                // Small diagonals, and rows of very different sizes.
                let scale = if row == column { 1e-9 } else { 1.0 } * 10.0_f64.powi(3 * (row % 4) as i32);
                let value = Complex64::new(next(), next()) * scale;
                matrix.add(row, column, value);
                dense[row * size + column] = value;
            }
        }
        let exact: Vec<Complex64> = (0..2 * size).map(|_| Complex64::new(next(), next())).collect();
        let mut rights = vec![Complex64::ZERO; 2 * size];
        for row in 0..size {
            for column in 0..size {
                for right in 0..2 {
                    rights[2 * row + right] += dense[row * size + column] * exact[2 * column + right];
                }
            }
        }
        assert!(matrix.factorise());
        matrix.solve(&mut rights, 2);
        let worst = rights.iter().zip(&exact).map(|(found, exact)| (found - exact).norm()).fold(0.0, f64::max);
        assert!(worst < 1e-10, "{worst:e}");
        assert!(!Banded::zeros(3, 1).factorise(), "a matrix of zeros");
    }
}
