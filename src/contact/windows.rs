//! Sums of windows of a row: what forces on elements do to their neighbours, influence being a function of the distance
//! only.

use pulp::{Arch, Simd, WithSimd};

/// Adds windows of a row, each times its factor: out_i += sum over c of factor_c row_(first - c + i). The factors
/// stand side by side, and each factor's window of the row begins one entry before that of the previous one.
///
/// `out` is whole vectors of any processor (a multiple of eight), and every window lies within the row. Cost: one fused
/// multiply-add for each factor and entry of `out`. The result does not depend on the width of the vectors.
pub fn add_windows(arch: Arch, out: &mut [f64], row: &[f64], first: usize, factors: &[f64]) {
    arch.dispatch(Windows { out, row, first, factors });
}

struct Windows<'a> {
    out: &'a mut [f64],
    row: &'a [f64],
    first: usize,
    factors: &'a [f64],
}

impl WithSimd for Windows<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { out, row, first, factors } = self;
        add_windows_in(simd, out, row, first, factors);
    }
}

/// Adds windows as [`add_windows`], where vectors are in use already.
#[inline(always)]
pub(crate) fn add_windows_in<S: Simd>(simd: S, out: &mut [f64], row: &[f64], first: usize, factors: &[f64]) {
    if factors.is_empty() {
        return;
    }
    // From the last window's beginning on.
    let row = &row[first + 1 - factors.len()..];
    // Vectors of `out` stay in registers while all windows pass: four of them, then two, then one.
    let done = add_in_registers::<S, 4>(simd, out, 0, row, factors);
    let done = add_in_registers::<S, 2>(simd, out, done, row, factors);
    add_in_registers::<S, 1>(simd, out, done, row, factors);
}

/// Covers as much of `out` from `done` on as whole groups of `VECTORS` vectors do; returns where that ends.
#[inline(always)]
fn add_in_registers<S: Simd, const VECTORS: usize>(
    simd: S,
    out: &mut [f64],
    mut done: usize,
    row: &[f64],
    factors: &[f64],
) -> usize {
    let length = VECTORS * S::F64_LANES;
    while let Some(group) = out.get_mut(done..done + length) {
        let (group, _) = S::as_mut_simd_f64s(group);
        let Ok(group) = <&mut [S::f64s; VECTORS]>::try_from(group) else { break };
        let mut sums = *group;
        let row = &row[done..done + length + factors.len() - 1];
        for (window, &factor) in row.windows(length).rev().zip(factors) {
            let (window, _) = S::as_simd_f64s(window);
            let factor = simd.splat_f64s(factor);
            for (sum, &row) in sums.iter_mut().zip(window) {
                *sum = simd.mul_add_e_f64s(row, factor, *sum);
            }
        }
        *group = sums;
        done += length;
    }
    done
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_add_up_whatever_their_length() {
        let row: Vec<f64> = (0..300).map(|i| (0.37 * f64::from(i)).sin()).collect();
        let factors = [1.5, -0.25, 0.0, 3.0, 0.125];
        for length in [8, 16, 24, 32, 40, 104, 200] {
            for factors in [&factors[..], &factors[..1], &[]] {
                let mut out = vec![0.5; length];
                add_windows(Arch::new(), &mut out, &row, 40, factors);
                for (i, value) in out.iter().enumerate() {
                    let windows = factors.iter().enumerate();
                    let exact = windows.fold(0.5, |sum, (c, &factor)| row[40 - c + i].mul_add(factor, sum));
                    assert!((value - exact).abs() <= 0.0, "{length}, {i}: {value} {exact}");
                }
            }
        }
    }
}
