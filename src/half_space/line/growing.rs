//! A rigid profile pushed into a row of cells: the whole load curve by one growing Cholesky factor.
//!
//! Cells in contact carry G_AA p = y 1 - d_A (penetration y, depth d_i of cell i below the highest point). While the
//! contact set A only grows ([`LineInfluence::only_grows`]) the curve is followed from one new cell to the next. The
//! order in which cells touch is taken as the pivot order of a Cholesky factorisation G = L L^T; of the triangular
//! solves only the forward ones are needed, and these come with the factor:
//!
//! 1. For cells not in contact keep a_i = 1 - G_iA G_AA^-1 1 and b_i = d_i - G_iA G_AA^-1 d_A: the gap is b_i - y a_i,
//!    so cell i touches at y_i = b_i/a_i. At first a = 1, b = d.
//! 2. The next cell k is the one of least y_k. Its column of the Schur complement, s_i = G_ik - sum_j L_ij L_kj over
//!    the cells in contact, for the cells not yet in contact, is one left-looking Cholesky column.
//! 3. a_i -= s_i a_k/s_k and b_i -= s_i b_k/s_k; the force grows by w_k max(0, y - y_k) with w_k = a_k^2/s_k.
//!
//! So F(y) = sum_k w_k max(0, y - y_k) exactly, w_k > 0, sum w_k = 1^T G^-1 1. Step 2 costs n^3/6 multiply-adds for the
//! whole curve, one factorisation; the rest is O(n^2). The lower triangle is packed by columns and rows change place
//! with their pivots, so that the inner loop runs over contiguous cells with sums held in registers.

use pulp::{Arch, NullaryFnOnce, Simd, WithSimd};

use super::influence::LineInfluence;

/// Most cells whose sums are held in registers together: eight registers of eight lanes.
const WIDE: usize = 64;

/// Load curve of one profile after [`Self::follow`]; its work arrays serve the next one. Sized on first use.
#[derive(Clone, Debug, Default)]
pub struct GrowingContact {
    /// Column j of L: rows j.. in pivot order, from `offset(j)`; slack at the end so that wide reads may pass it.
    factor: Vec<f64>,
    /// Cells in pivot order: the order in which they touch.
    cells: Vec<usize>,
    a: Vec<f64>,
    b: Vec<f64>,
    /// Penetration y_i = b_i/a_i at which cell i touches.
    touch: Vec<f64>,
    /// Row of the pivot in L.
    pivot: Vec<f64>,
    column: Vec<f64>,
    /// Forward solutions L^-1 1 and L^-1 d.
    forward: Vec<(f64, f64)>,
    events: Vec<(f64, f64)>,
    multiply_adds: u64,
}

impl GrowingContact {
    /// Follows a profile until every cell is in contact.
    ///
    /// `depths`: depth >= 0 of each cell below the highest \[m\], one per cell of `line`; finite. Meaningful where
    /// [`LineInfluence::only_grows`] holds.
    pub fn follow(&mut self, line: &LineInfluence, depths: &[f64]) {
        debug_assert_eq!(depths.len(), line.cells());
        let (n, arch) = (depths.len(), Arch::new());
        self.prepare(n, depths);
        let mut last = 0.0;
        let (mut next, mut touch) = first_least(&self.touch);
        for k in 0..n {
            // Ties may come out of order by rounding.
            let y = f64::max(touch, last);
            if touch.is_infinite() {
                break;
            }
            // The next cell to touch becomes pivot k.
            last = y;
            // Step 2 of the head, then step 3 for the cells left.
            self.exchange(n, k, k + next);
            self.schur_column(arch, line.row(), n, k);
            let s = self.column[0];
            let (a, b) = (self.a[k], self.b[k]);
            self.events.push((y, a * a / s));
            let root = s.sqrt();
            self.forward.push((a / root, b / root));
            let start = offset(n, k);
            let update = Update {
                column: &self.column[1..n - k],
                factor: &mut self.factor[start + 1..start + n - k],
                a: &mut self.a[k + 1..],
                b: &mut self.b[k + 1..],
                touch: &mut self.touch[k + 1..],
                steps: [1.0 / root, a / s, b / s],
            };
            arch.dispatch(update);
            self.factor[start] = root;
            (next, touch) = first_least(&self.touch[k + 1..]);
        }
    }

    /// (y_k, w_k) of each cell in the order of touching: penetration \[m\] and stiffness gained \[1/m\], force in
    /// units of E* times the cell's area.
    pub fn events(&self) -> &[(f64, f64)] {
        &self.events
    }

    /// Multiply-adds of all factor columns since creation.
    pub fn multiply_adds(&self) -> u64 {
        self.multiply_adds
    }

    /// Pressure/E* of every cell at penetration `y` >= 0 \[m\], for the profile followed last.
    ///
    /// `pressure`: one per cell, overwritten. Cost: n^2/2 multiply-adds for n cells in contact.
    pub fn pressure_at(&self, y: f64, pressure: &mut [f64]) {
        let n = self.cells.len();
        pressure.fill(0.0);
        let touched = self.events.partition_point(|&(touch, _)| touch <= y);
        // L^T p = y L^-1 1 - L^-1 d, from the last touched cell up.
        for j in (0..touched).rev() {
            let column = &self.factor[offset(n, j)..];
            let below: f64 = (j + 1..touched).map(|i| column[i - j] * pressure[self.cells[i]]).sum();
            let (one, depth) = self.forward[j];
            pressure[self.cells[j]] = ((y * one - depth - below) / column[0]).max(0.0);
        }
    }

    fn prepare(&mut self, n: usize, depths: &[f64]) {
        let size = offset(n, n) + WIDE;
        if self.factor.len() < size {
            self.factor.resize(size, 0.0);
        }
        self.cells.clear();
        self.cells.extend(0..n);
        self.a.clear();
        self.a.resize(n, 1.0);
        self.b.clear();
        self.b.extend_from_slice(depths);
        self.touch.clear();
        self.touch.extend_from_slice(depths);
        self.pivot.resize(n, 0.0);
        self.column.resize(n + WIDE, 0.0);
        self.forward.clear();
        self.events.clear();
    }

    /// Swaps two cells in everything that is in pivot order; leaves row `other` of L, before the swap, in `pivot`.
    fn exchange(&mut self, n: usize, k: usize, other: usize) {
        let mut rest = &mut self.factor[..];
        for (j, pivot) in self.pivot[..k].iter_mut().enumerate() {
            let (column, following) = rest.split_at_mut(n - j);
            *pivot = column[other - j];
            column[other - j] = column[k - j];
            column[k - j] = *pivot;
            rest = following;
        }
        self.cells.swap(k, other);
        self.a.swap(k, other);
        self.b.swap(k, other);
        self.touch.swap(k, other);
    }

    /// s_i = G_ik - sum_j L_ij L_kj for the cells i from the pivot `k` on, into `column`.
    fn schur_column(&mut self, arch: Arch, row: &[f64], n: usize, k: usize) {
        let cell = self.cells[k];
        for (s, &other) in self.column.iter_mut().zip(&self.cells[k..]) {
            *s = row[cell.abs_diff(other)];
        }
        self.multiply_adds += (k * (n - k)) as u64;
        let (factor, pivot, column) = (&self.factor[..], &self.pivot[..k], &mut self.column[..]);
        arch.dispatch(SchurColumn { factor, pivot, column, n });
    }
}

/// Index and value of the first least number; (0, infinity) if there is none.
fn first_least(values: &[f64]) -> (usize, f64) {
    // In lanes: a running index would make the loop scalar.
    let mut lanes = [f64::INFINITY; 8];
    let (chunks, rest) = values.as_chunks::<8>();
    for chunk in chunks {
        for (lane, &value) in lanes.iter_mut().zip(chunk) {
            *lane = if value < *lane { value } else { *lane };
        }
    }
    let least = lanes.iter().chain(rest).copied().fold(f64::INFINITY, f64::min);
    (values.iter().position(|&value| value <= least).unwrap_or(0), least)
}

/// Start of column `j` of the packed lower triangle of order `n`.
fn offset(n: usize, j: usize) -> usize {
    j * n - j * j.saturating_sub(1) / 2
}

/// Step 2: column_i -= sum over j of L_ij pivot_j, rows from `pivot.len()` on.
struct SchurColumn<'a> {
    factor: &'a [f64],
    pivot: &'a [f64],
    column: &'a mut [f64],
    n: usize,
}

impl WithSimd for SchurColumn<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let k = self.pivot.len();
        let mut registers = (self.n - k).div_ceil(S::F64_LANES);
        let mut i = k;
        while registers > 8 {
            self.rows::<S, 8>(simd, i);
            i += 8 * S::F64_LANES;
            registers -= 8;
        }
        match registers {
            8 => self.rows::<S, 8>(simd, i),
            7 => self.rows::<S, 7>(simd, i),
            6 => self.rows::<S, 6>(simd, i),
            5 => self.rows::<S, 5>(simd, i),
            4 => self.rows::<S, 4>(simd, i),
            3 => self.rows::<S, 3>(simd, i),
            2 => self.rows::<S, 2>(simd, i),
            _ => self.rows::<S, 1>(simd, i),
        }
    }
}

impl SchurColumn<'_> {
    /// Computes the rows from `i` on that fill `R` registers; lanes past the last row hold what follows in memory and
    /// are not used.
    #[inline(always)]
    fn rows<S: Simd, const R: usize>(&mut self, simd: S, i: usize) {
        let width = R * S::F64_LANES;
        let mut sums = [simd.splat_f64s(0.0); R];
        let mut start = i;
        for (j, &pivot) in self.pivot.iter().enumerate() {
            let Some(rows) = self.factor.get(start..start + width) else { break };
            let Ok(rows) = <&[S::f64s; R]>::try_from(S::as_simd_f64s(rows).0) else { break };
            let pivot = simd.splat_f64s(pivot);
            for r in 0..R {
                sums[r] = simd.mul_add_e_f64s(rows[r], pivot, sums[r]);
            }
            // From (i, j) to (i, j + 1): column j holds n - j rows.
            start += self.n - j - 1;
        }
        let first = i - self.pivot.len();
        let Some(column) = self.column.get_mut(first..first + width) else { return };
        for (value, sum) in S::as_mut_simd_f64s(column).0.iter_mut().zip(sums) {
            *value = simd.sub_f64s(*value, sum);
        }
    }
}

/// Step 3 for the cells not in contact, and their next touch.
struct Update<'a> {
    column: &'a [f64],
    factor: &'a mut [f64],
    a: &'a mut [f64],
    b: &'a mut [f64],
    touch: &'a mut [f64],
    /// 1/sqrt(s_k), a_k/s_k, b_k/s_k.
    steps: [f64; 3],
}

impl NullaryFnOnce for Update<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { column, factor, a, b, touch, steps: [scale, step_a, step_b] } = self;
        let count = column.len();
        // Equal lengths known beforehand let the loop run in lanes.
        let (factor, a, b, touch) = (&mut factor[..count], &mut a[..count], &mut b[..count], &mut touch[..count]);
        for i in 0..count {
            let s = column[i];
            factor[i] = s * scale;
            a[i] -= step_a * s;
            b[i] -= step_b * s;
            touch[i] = if a[i] > 0.0 { b[i] / a[i] } else { f64::INFINITY };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks a cylinder: the load per length of a line contact has no finite penetration, so the half-width is
    /// compared, a^2 = 4 f R/(pi E*) (Johnson 1985, eq. 4.43), on a strip much longer than the contact is wide.
    #[test]
    fn a_cylinder_converges_to_hertz() {
        let (radius, width): (f64, f64) = (0.02, 4e-3);
        let mut errors = Vec::new();
        for cells in [101usize, 201, 401, 801] {
            let pitch = width / cells as f64;
            let line = LineInfluence::love(cells, 2.0, pitch);
            let y: Vec<f64> = (0..cells).map(|i| (i as f64 - 0.5 * (cells as f64 - 1.0)) * pitch).collect();
            let depths: Vec<f64> = y.iter().map(|y| y * y / (2.0 * radius)).collect();
            let mut growing = GrowingContact::default();
            growing.follow(&line, &depths);
            // Penetration at which the pressure has Hertz's half-width a = 1 mm: load per length f = pi a^2 E*/(4 R).
            let half_width = 1e-3;
            let force = std::f64::consts::PI * half_width * half_width / (4.0 * radius);
            let events = growing.events();
            let load = |level: f64| pitch * events.iter().map(|&(touch, w)| w * (level - touch).max(0.0)).sum::<f64>();
            let (mut low, mut high) = (0.0, events[cells - 1].0);
            for _ in 0..200 {
                let middle = 0.5 * (low + high);
                if load(middle) < force { low = middle } else { high = middle }
            }
            let mut pressure = vec![0.0; cells];
            growing.pressure_at(low, &mut pressure);
            let exact = |y: f64| (half_width * half_width - y * y).max(0.0).sqrt() / (2.0 * radius);
            let error: f64 = pressure.iter().zip(&y).map(|(p, &y)| (p - exact(y)).abs() * pitch).sum();
            errors.push(error / force);
        }
        let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
        println!("L1 errors {errors:?}, orders {orders:?}");
        assert!(errors[3] < 1e-4, "{errors:?}");
        // A kink of the pressure at the edge of contact limits the order to 1.5.
        assert!(orders.iter().sum::<f64>() / 3.0 > 1.2, "{orders:?}");
    }

    #[test]
    fn a_spike_stands_alone_until_its_neighbours_touch() {
        let line = LineInfluence::love(50, 4e-3, 2e-3);
        let mut depths = vec![5e-3; 50];
        depths[20] = 0.0;
        let mut growing = GrowingContact::default();
        growing.follow(&line, &depths);
        let events = growing.events();
        assert!((events[0].1 * line.row()[0] - 1.0).abs() < 1e-14);
        // The spike's dent holds its neighbours off longer than the far cells.
        assert!(events[1].0 > 5e-3);
        let total: f64 = events.iter().map(|(_, w)| w).sum();
        assert!((total / line.flat_stiffness() - 1.0).abs() < 1e-12);
    }
}
