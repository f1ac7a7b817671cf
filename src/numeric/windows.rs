//! Sums of windows of a row: what forces on elements do to their neighbours, influence being a function of the distance only.

use pulp::{Arch, Simd, WithSimd};

/// out_i += factor row_i, for rows at least as long.
#[inline(always)]
pub fn add_row<S: Simd>(simd: S, out: &mut [f64], row: &[f64], factor: f64) {
    let row = &row[..out.len()];
    let wide = simd.splat_f64s(factor);
    let (out, out_rest) = S::as_mut_simd_f64s(out);
    let (row, row_rest) = S::as_simd_f64s(row);
    for (out, &row) in out.iter_mut().zip(row) {
        *out = simd.mul_add_e_f64s(row, wide, *out);
    }
    for (out, &row) in out_rest.iter_mut().zip(row_rest) {
        *out = row.mul_add(factor, *out);
    }
}

/// out_i += sum over the windows (from, factor), in their order, of factor row_(from + i).
///
/// Every window lies within the row. Cost: one fused multiply-add for each window and entry of `out`. The result does not depend on the width of the vectors.
pub fn add_windows(arch: Arch, out: &mut [f64], row: &[f64], windows: impl Iterator<Item = (usize, f64)> + Clone) {
    arch.dispatch(Windows { out, row, windows });
}

struct Windows<'a, W> {
    out: &'a mut [f64],
    row: &'a [f64],
    windows: W,
}

/// Vectors of `out` that are kept while all windows pass.
const KEPT: usize = 4;

impl<W: Iterator<Item = (usize, f64)> + Clone> WithSimd for Windows<'_, W> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { out, row, windows } = self;
        let whole = out.len() / (KEPT * S::F64_LANES) * (KEPT * S::F64_LANES);
        let (kept, rest) = out.split_at_mut(whole);
        for (index, kept) in kept.chunks_exact_mut(KEPT * S::F64_LANES).enumerate() {
            let (kept, _) = S::as_mut_simd_f64s(kept);
            let Ok(kept) = <&mut [S::f64s; KEPT]>::try_from(kept) else { continue };
            let mut sums = *kept;
            for (from, factor) in windows.clone() {
                let begin = from + index * KEPT * S::F64_LANES;
                let (row, _) = S::as_simd_f64s(&row[begin..begin + KEPT * S::F64_LANES]);
                let factor = simd.splat_f64s(factor);
                for (sum, &row) in sums.iter_mut().zip(row) {
                    *sum = simd.mul_add_e_f64s(row, factor, *sum);
                }
            }
            *kept = sums;
        }
        for (from, factor) in windows {
            add_row(simd, rest, &row[from + whole..], factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
