//! Sums of windows of a row: what forces on elements do to their neighbours, influence being a function of the distance
//! only.

use pulp::{Arch, Simd, WithSimd};

/// out_i += sum over the windows (from, factor), in their order, of factor row_(from + i).
///
/// Every window lies within the row. Cost: one fused multiply-add for each window and entry of `out`. The result does
/// not depend on the width of the vectors.
pub fn add_windows(arch: Arch, out: &mut [f64], row: &[f64], windows: impl Iterator<Item = (usize, f64)> + Clone) {
    arch.dispatch(Windows { out, row, windows });
}

struct Windows<'a, W> {
    out: &'a mut [f64],
    row: &'a [f64],
    windows: W,
}

impl<W: Iterator<Item = (usize, f64)> + Clone> WithSimd for Windows<'_, W> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { out, row, windows } = self;
        // Vectors of `out` stay at hand while all windows pass: four of them, then two, then one.
        let done = add_kept::<S, 4>(simd, out, 0, row, windows.clone());
        let done = add_kept::<S, 2>(simd, out, done, row, windows.clone());
        let done = add_kept::<S, 1>(simd, out, done, row, windows.clone());
        let rest = &mut out[done..];
        if !rest.is_empty() {
            for (from, factor) in windows {
                for (out, &row) in rest.iter_mut().zip(&row[from + done..]) {
                    *out = row.mul_add(factor, *out);
                }
            }
        }
    }
}

/// Does as much of `out` from `done` on as whole groups of vectors cover; returns where it ends.
#[inline(always)]
fn add_kept<S: Simd, const KEPT: usize>(
    simd: S,
    out: &mut [f64],
    mut done: usize,
    row: &[f64],
    windows: impl Iterator<Item = (usize, f64)> + Clone,
) -> usize {
    let length = KEPT * S::F64_LANES;
    while let Some(kept) = out.get_mut(done..done + length) {
        let (kept, _) = S::as_mut_simd_f64s(kept);
        let Ok(kept) = <&mut [S::f64s; KEPT]>::try_from(kept) else { break };
        let mut sums = *kept;
        for (from, factor) in windows.clone() {
            let (row, _) = S::as_simd_f64s(&row[from + done..from + done + length]);
            let factor = simd.splat_f64s(factor);
            for (sum, &row) in sums.iter_mut().zip(row) {
                *sum = simd.mul_add_e_f64s(row, factor, *sum);
            }
        }
        *kept = sums;
        done += length;
    }
    done
}

/// out_i += sum over c of factor_c row_(first - c + i): as [`add_windows`], for factors side by side, whose windows
/// begin at `first`, one before it, and so on. `out` is whole vectors of any processor; what lies behind the row's last
/// window is part of the row.
#[inline(always)]
pub fn add_neighbours<S: Simd>(simd: S, out: &mut [f64], row: &[f64], first: usize, factors: &[f64]) {
    // From the last window's beginning on.
    let row = &row[first + 1 - factors.len()..];
    let done = add_neighbours_kept::<S, 4>(simd, out, 0, row, factors);
    let done = add_neighbours_kept::<S, 2>(simd, out, done, row, factors);
    add_neighbours_kept::<S, 1>(simd, out, done, row, factors);
}

/// As [`add_kept`].
#[inline(always)]
fn add_neighbours_kept<S: Simd, const KEPT: usize>(
    simd: S,
    out: &mut [f64],
    mut done: usize,
    row: &[f64],
    factors: &[f64],
) -> usize {
    let length = KEPT * S::F64_LANES;
    while let Some(kept) = out.get_mut(done..done + length) {
        let (kept, _) = S::as_mut_simd_f64s(kept);
        let Ok(kept) = <&mut [S::f64s; KEPT]>::try_from(kept) else { break };
        let mut sums = *kept;
        let row = &row[done..done + length + factors.len() - 1];
        for (window, &factor) in row.windows(length).rev().zip(factors) {
            let (window, _) = S::as_simd_f64s(window);
            let factor = simd.splat_f64s(factor);
            for (sum, &row) in sums.iter_mut().zip(window) {
                *sum = simd.mul_add_e_f64s(row, factor, *sum);
            }
        }
        *kept = sums;
        done += length;
    }
    done
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Neighbours<'a> {
        out: &'a mut [f64],
        row: &'a [f64],
        first: usize,
        factors: &'a [f64],
    }

    impl WithSimd for Neighbours<'_> {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            add_neighbours(simd, self.out, self.row, self.first, self.factors);
        }
    }

    #[test]
    fn neighbours_are_windows() {
        let row: Vec<f64> = (0..300).map(|i| (0.37 * f64::from(i)).sin()).collect();
        let factors = [1.5, -0.25, 0.0, 3.0, 0.125];
        for length in [8, 16, 24, 32, 40, 104, 200] {
            let (mut out, mut windows) = (vec![0.5; length], vec![0.5; length]);
            Arch::new().dispatch(Neighbours { out: &mut out, row: &row, first: 40, factors: &factors });
            let each = factors.iter().enumerate().map(|(c, &factor)| (40 - c, factor));
            add_windows(Arch::new(), &mut windows, &row, each);
            assert_eq!(out, windows, "{length}");
        }
    }

    #[test]
    fn windows_add_up_whatever_their_length() {
        let row: Vec<f64> = (0..300).map(|i| (0.37 * f64::from(i)).sin()).collect();
        let windows = [(0, 1.5), (17, -0.25), (99, 3.0), (3, 0.125)];
        for length in [0, 1, 7, 8, 31, 32, 33, 100, 201] {
            let mut out = vec![0.5; length];
            add_windows(Arch::new(), &mut out, &row, windows.into_iter());
            for (i, value) in out.iter().enumerate() {
                let exact = windows.iter().fold(0.5, |sum, &(from, factor)| row[from + i].mul_add(factor, sum));
                assert!((value - exact).abs() <= 0.0, "{length}, {i}: {value} {exact}");
            }
        }
    }
}
