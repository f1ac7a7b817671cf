//! Pitches round the tyre, and the spectrum of one unit pulse per pitch.
//!
//! P pulses at X_j have the amplitudes
//!
//! ```text
//! A_k = (1/P) sum over j of exp(-2 pi i k X_j/L)
//! ```
//!
//! at the orders k of the revolution, k V/L in frequency. Equal pitches have the lines k = P, 2 P ... alone.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::scene::Pitches;

/// Pitches that fill the circumference.
#[derive(Clone, Debug, PartialEq)]
pub struct PitchTrain {
    /// Circumference L \[m\].
    pub circumference: f64,
    /// Beginnings X_j \[m\].
    pub starts: Vec<f64>,
    /// Lengths, scaled to fill the circumference \[m\].
    pub lengths: Vec<f64>,
    /// Factor by which the lengths were scaled; 1 of equal pitches.
    pub scale: f64,
}

impl PitchTrain {
    pub(crate) fn new(pitches: &Pitches, circumference: f64) -> Self {
        let count = match pitches {
            Pitches::Equal(count) => *count,
            Pitches::Varied(varied) => return Self::of_lengths(&varied.in_order(), circumference),
        };
        // Each beginning by itself: sums of equal lengths would drift.
        let starts = (0..count).map(|j| circumference * j as f64 / count as f64).collect();
        Self { circumference, starts, lengths: vec![circumference / count as f64; count], scale: 1.0 }
    }

    fn of_lengths(given: &[f64], circumference: f64) -> Self {
        let scale = circumference / given.iter().sum::<f64>();
        let lengths: Vec<f64> = given.iter().map(|length| scale * length).collect();
        let ends = lengths.iter().scan(0.0, |end, length| {
            *end += length;
            Some(*end)
        });
        let starts = std::iter::once(0.0).chain(ends).take(lengths.len()).collect();
        Self { circumference, starts, lengths, scale }
    }

    /// Number P of pitches.
    pub(crate) fn count(&self) -> usize {
        self.starts.len()
    }

    /// Index of the pitch at a place \[m\], and how far on in it, in parts of its length.
    pub(super) fn within(&self, x: f64) -> (usize, f64) {
        let pitch = self.starts.partition_point(|start| *start <= x).saturating_sub(1);
        (pitch, (x - self.starts[pitch]) / self.lengths[pitch])
    }

    /// Amplitude A_k of the order k.
    pub fn amplitude(&self, order: usize) -> Complex64 {
        amplitude(&self.starts, self.circumference, order)
    }
}

/// A_k of pulses at some places \[m\] round a circumference.
pub(crate) fn amplitude(places: &[f64], circumference: f64, order: usize) -> Complex64 {
    // The fraction of a turn first: the phase keeps its digits at any order.
    let turn = |place: &f64| (order as f64 * (place / circumference)).fract();
    let sum: Complex64 = places.iter().map(|place| Complex64::cis(-TAU * turn(place))).sum();
    sum / places.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::reference;

    #[test]
    fn amplitudes_are_those_of_the_reference() {
        let text = std::fs::read_to_string(reference("tread/ref_pitch.json")).unwrap();
        let known: serde_json::Value = serde_json::from_str(&text).unwrap();
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        let (length, count) = (number(&known["L"]), known["P"].as_u64().unwrap() as usize);
        let equal = PitchTrain::new(&Pitches::Equal(count), length);
        for order in 0..=4 * count {
            let expected = if order % count == 0 { 1.0 } else { 0.0 };
            assert!((equal.amplitude(order) - expected).norm() < 1e-12, "{order}: {}", equal.amplitude(order));
        }
        let sinusoidal = &known["sinusoidal"];
        let (shift, waves) = (number(&sinusoidal["D"]), number(&sinusoidal["m"]));
        let places: Vec<f64> = (0..count)
            .map(|j| j as f64 / count as f64)
            .map(|turn| length * (turn + shift * (TAU * waves * turn).sin()))
            .collect();
        let orders = sinusoidal["orders"].as_array().unwrap();
        assert!(orders.len() > 50);
        for line in orders {
            let order = line[0].as_u64().unwrap() as usize;
            let expected = Complex64::new(number(&line[1]), number(&line[2]));
            let found = amplitude(&places, length, order);
            assert!((found - expected).norm() < 1e-12, "{order}: {found} and {expected}");
        }
    }

    #[test]
    fn a_train_fills_the_circumference_in_its_order() {
        let train = PitchTrain::of_lengths(&[0.02, 0.03, 0.05], 0.11);
        assert!((train.scale - 1.1).abs() < 1e-15 && (train.lengths.iter().sum::<f64>() - 0.11).abs() < 1e-15);
        assert!(train.starts.iter().zip([0.0, 0.022, 0.055]).all(|(start, expected)| (start - expected).abs() < 1e-15));
    }
}
