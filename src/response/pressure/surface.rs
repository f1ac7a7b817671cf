//! G on the tread, and its integrals with the tread's waves.
//!
//! G is known as means over cells round the tyre, at Gauss points across half of the width (its even part, which is all
//! that a centred contact strip can feel), at some frequencies. With the delay r0/c removed it is smooth over
//! frequency and interpolated by cubics.

use num_complex::{Complex32, Complex64};
use rustfft::FftPlanner;

use crate::numeric::{lagrange, legendre, sinc, single};
use crate::tyre::influence::Waves;

/// G of one receiver.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceGreen {
    /// Frequencies, rising \[Hz\].
    pub frequencies: Vec<f64>,
    /// Cells round the whole tyre; the first begins under the axle, they follow each other in the rolling direction.
    pub around: usize,
    /// Distances from mid-width \[m\], rising; G is the polynomial through its values there.
    pub across: Vec<f64>,
    /// Half of the tread's width \[m\].
    pub half_width: f64,
    /// G exp(i k r0), frequency by frequency, point by point, cell by cell \[1/m\].
    pub values: Vec<Complex32>,
}

/// Int G exp(i kx_n x) cos(ky_m y) dS over the tread for the waves of a tyre, at every frequency of G.
#[derive(Clone, Debug)]
pub struct WaveIntegrals {
    frequencies: Vec<f64>,
    /// Largest |n|.
    most_around: usize,
    lateral: usize,
    /// Frequency, n = -most_around..=most_around, m \[m\].
    values: Vec<Complex32>,
}

impl WaveIntegrals {
    /// Of G with waves that have these lateral numbers. n goes as far as the cells can tell waves apart.
    pub fn new(green: &SurfaceGreen, waves: Waves, lateral: &[usize]) -> Self {
        let SurfaceGreen { frequencies, around, across, half_width, values } = green;
        let most_around = around / 2 - 1;
        let length = waves.circumference / *around as f64;
        // Both halves of the width.
        let shapes: Vec<Vec<f64>> = lateral.iter().map(|&m| cosine_weights(across, *half_width, waves.ky(m))).collect();
        let transform = FftPlanner::<f64>::new().plan_fft_inverse(*around);
        let width = (2 * most_around + 1) * lateral.len();
        let mut integrals = vec![Complex32::ZERO; frequencies.len() * width];
        let mut cells = vec![Complex64::ZERO; *around];
        let rows = values.chunks_exact(around * across.len());
        for (values, out) in rows.zip(integrals.chunks_exact_mut(width)) {
            for (index, shape) in shapes.iter().enumerate() {
                cells.fill(Complex64::ZERO);
                for (points, weight) in values.chunks_exact(*around).zip(shape) {
                    for (cell, value) in cells.iter_mut().zip(points) {
                        cell.re += weight * f64::from(value.re);
                        cell.im += weight * f64::from(value.im);
                    }
                }
                transform.process(&mut cells);
                for (row, n) in (-(most_around as i64)..=most_around as i64).enumerate() {
                    // The wave's mean over a cell, whose middle is half a cell from its beginning.
                    let half = 0.5 * waves.kx(n) * length;
                    let at_middle = Complex64::from_polar(length * sinc(half), half);
                    let value = at_middle * cells[n.rem_euclid(*around as i64) as usize];
                    out[row * lateral.len() + index] = single(value);
                }
            }
        }
        Self { frequencies: frequencies.clone(), most_around, lateral: lateral.len(), values: integrals }
    }

    /// Largest |n|.
    pub fn most_around(&self) -> usize {
        self.most_around
    }

    /// The integrals at a frequency \[Hz\], n by n, into `out`. Below the lowest frequency they are those at it.
    pub fn at(&self, frequency: f64, out: &mut [Complex64]) {
        let (first, weights) = interpolation(&self.frequencies, frequency);
        let width = (2 * self.most_around + 1) * self.lateral;
        out.fill(Complex64::ZERO);
        for (row, weight) in self.values[first * width..].chunks_exact(width).zip(weights) {
            for (sum, value) in out.iter_mut().zip(row) {
                sum.re += weight * f64::from(value.re);
                sum.im += weight * f64::from(value.im);
            }
        }
    }
}

/// Int cos(k y) L_j(y) dy over the whole width of polynomials that are 1 at one point and 0 at the others: weights that
/// are exact for the product of such a polynomial, even in y, with the wave.
fn cosine_weights(points: &[f64], half_width: f64, k: f64) -> Vec<f64> {
    // The product turns as often as the wave does within half of the width.
    let order = 16 + points.len() + (k * half_width) as usize;
    let mut sums = vec![0.0; points.len()];
    for [node, weight] in legendre::gauss(order) {
        let y = 0.5 * half_width * (1.0 + node);
        for (sum, share) in sums.iter_mut().zip(lagrange::weights(points, y)) {
            *sum += half_width * weight * (k * y).cos() * share;
        }
    }
    sums
}

/// The first of up to four neighbours of a frequency and the weights of the cubic through them.
fn interpolation(frequencies: &[f64], frequency: f64) -> (usize, Vec<f64>) {
    let within = frequency.clamp(frequencies[0], frequencies[frequencies.len() - 1]);
    let near = lagrange::cubic_neighbours(frequencies, within);
    (near.start, lagrange::weights(&frequencies[near], within).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Sides;

    #[test]
    fn integrals_of_a_wave_with_itself_and_of_others_are_known() {
        let waves = Waves { circumference: 2.0, width: 0.2, sides: Sides::Guided };
        let mut across: Vec<f64> = legendre::gauss(8).into_iter().map(|[node, _]| 0.05 * (1.0 + node)).collect();
        across.reverse();
        let around = 64;
        // Means over cells of exp(-i kx_5 x) cos(ky_2 y).
        let [kx, ky] = [waves.kx(5), waves.ky(2)];
        let length = 2.0 / around as f64;
        let mean = (0.5 * kx * length).sin() / (0.5 * kx * length);
        let values = across.iter().flat_map(|y| {
            let wave = |cell: usize| Complex64::from_polar(mean, -kx * (cell as f64 + 0.5) * length);
            (0..around).map(move |cell| wave(cell) * (ky * y).cos())
        });
        let values = values.map(|value| Complex32::new(value.re as f32, value.im as f32)).collect();
        let green = SurfaceGreen { frequencies: vec![100.0], around, across: across.clone(), half_width: 0.1, values };
        let integrals = WaveIntegrals::new(&green, waves, &[0, 2]);
        let mut out = vec![Complex64::ZERO; (2 * integrals.most_around() + 1) * 2];
        integrals.at(100.0, &mut out);
        for (row, n) in (-(integrals.most_around() as i64)..).zip(out.chunks_exact(2)).map(|(n, row)| (row, n)) {
            let expected = if n == 5 { mean * mean * 0.5 * 2.0 * 0.2 } else { 0.0 };
            assert!((row[1] - expected).norm() < 1e-6, "n = {n}: {}", row[1]);
            assert!(row[0].norm() < 1e-6, "n = {n}, m = 0: {}", row[0]);
        }
    }

    #[test]
    fn cubics_are_met_and_frequencies_outside_are_the_nearest() {
        let frequencies = [40.0, 90.0, 120.0, 200.0, 300.0, 320.0];
        let cubic = |f: f64| 1.0 + f * (0.01 + f * (1e-4 - 3e-7 * f));
        for frequency in [40.0, 55.0, 199.0, 250.0, 310.0, 320.0] {
            let (first, weights) = interpolation(&frequencies, frequency);
            let value: f64 = weights.iter().zip(&frequencies[first..]).map(|(w, &f)| w * cubic(f)).sum();
            assert!((value - cubic(frequency)).abs() < 1e-9, "{frequency}: {value}");
        }
        for (frequency, nearest) in [(1.0, 40.0), (500.0, 320.0)] {
            let (first, weights) = interpolation(&frequencies, frequency);
            let value: f64 = weights.iter().zip(&frequencies[first..]).map(|(w, &f)| w * cubic(f)).sum();
            assert!((value - cubic(nearest)).abs() < 1e-9);
        }
        assert_eq!(interpolation(&[70.0], 10.0), (0, vec![1.0]));
    }
}
