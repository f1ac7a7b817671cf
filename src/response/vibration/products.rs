//! Mean products of the forces of a step's stages, and forms quadratic in these forces.
//!
//! A velocity is v = sum_i Y_i F_i over the stages i of a step, so |v|^2 needs the means of F_i conj F_j for all pairs
//! of stages. They are stored as planes of real numbers: |F_i|^2 of every stage, then for every pair i < j the real and
//! the imaginary part of F_i conj F_j: one number for a rule of one stage, four for two stages, nine for three. A form
//! that is quadratic in the forces, |v|^2 or a power, is a sum of these numbers times weights.

use num_complex::Complex64;

/// Number of real products for so many stages.
pub(super) const fn count(stages: usize) -> usize {
    stages * stages
}

/// Pairs of stages i < j in the order of their products.
fn pairs(stages: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..stages).flat_map(move |i| (i + 1..stages).map(move |j| (i, j)))
}

/// Adds the products of rows of `width` complex numbers, stage after stage, to as many planes: `power(a)` is |x_a|^2
/// and `cross(a, b)` is x_a conj x_b for the numbers a and b of the rows.
pub(super) fn add(
    planes: &mut [f64],
    width: usize,
    stages: usize,
    power: impl Fn(usize) -> f64,
    cross: impl Fn(usize, usize) -> Complex64,
) {
    let (powers, crosses) = planes.split_at_mut(stages * width);
    powers.iter_mut().enumerate().for_each(|(index, sum)| *sum += power(index));
    for ((i, j), parts) in pairs(stages).zip(crosses.chunks_exact_mut(2 * width)) {
        let (real, imaginary) = parts.split_at_mut(width);
        for (index, (real, imaginary)) in real.iter_mut().zip(imaginary).enumerate() {
            let product = cross(i * width + index, j * width + index);
            *real += product.re;
            *imaginary += product.im;
        }
    }
}

/// Weights of |sum_i Y_i F_i|^2.
pub(super) fn weights_of_square(stages: usize, transfer: impl Fn(usize) -> Complex64, out: &mut [f64]) {
    (0..stages).for_each(|i| out[i] = transfer(i).norm_sqr());
    for (slot, (i, j)) in pairs(stages).enumerate() {
        let cross = 2.0 * transfer(i) * transfer(j).conj();
        (out[stages + 2 * slot], out[stages + 2 * slot + 1]) = (cross.re, -cross.im);
    }
}

/// Weights of Re sum_ij conj F_i M_ij F_j.
pub(super) fn weights_of_power(stages: usize, matrix: impl Fn(usize, usize) -> Complex64, out: &mut [f64]) {
    (0..stages).for_each(|i| out[i] = matrix(i, i).re);
    for (slot, (i, j)) in pairs(stages).enumerate() {
        let cross = matrix(i, j) + matrix(j, i).conj();
        (out[stages + 2 * slot], out[stages + 2 * slot + 1]) = (cross.re, cross.im);
    }
}

/// Value of the form with these weights. At a negative frequency, where all transfers are conjugate, imaginary parts
/// have the opposite sign.
pub(super) fn form(stages: usize, weights: &[f64], negative: bool, product: impl Fn(usize) -> f64) -> f64 {
    let mut sum = weights[0] * product(0);
    for (number, weight) in weights.iter().enumerate().skip(1) {
        let imaginary = number >= stages && (number - stages) % 2 == 1;
        let share = weight * product(number);
        sum += if negative && imaginary { -share } else { share };
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_of_products_are_those_of_the_numbers() {
        let number = |seed: usize| Complex64::new((seed as f64).sin(), (2.0 * seed as f64).cos());
        for stages in 1..=3 {
            let width = 4;
            let rows: Vec<Complex64> = (0..stages * width).map(|k| number(k + 1)).collect();
            let mut planes = vec![0.0; count(stages) * width];
            add(&mut planes, width, stages, |a| rows[a].norm_sqr(), |a, b| rows[a] * rows[b].conj());
            let transfer = |stage: usize| number(stage + 50);
            let matrix = |i: usize, j: usize| number(70 + 3 * i + j);
            let mut weights = [vec![0.0; count(stages)], vec![0.0; count(stages)]];
            weights_of_square(stages, transfer, &mut weights[0]);
            weights_of_power(stages, matrix, &mut weights[1]);
            for index in 0..width {
                let force = |stage: usize| rows[stage * width + index];
                for negative in [false, true] {
                    let turned = |value: Complex64| if negative { value.conj() } else { value };
                    let sum: Complex64 = (0..stages).map(|i| turned(transfer(i)) * force(i)).sum();
                    let power: Complex64 = (0..count(stages))
                        .map(|k| (k / stages, k % stages))
                        .map(|(i, j)| force(i).conj() * turned(matrix(i, j)) * force(j))
                        .sum();
                    let found = weights
                        .each_ref()
                        .map(|weights| form(stages, weights, negative, |k| planes[k * width + index]));
                    assert!((found[0] - sum.norm_sqr()).abs() < 1e-14, "{stages}: {found:?} {sum}");
                    assert!((found[1] - power.re).abs() < 1e-14, "{stages}: {found:?} {power}");
                }
            }
        }
    }
}
