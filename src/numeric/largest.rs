//! The largest of many numbers.

/// Numbers compared side by side.
const LANES: usize = 8;

/// The largest number, 0 if none is positive; NaN is passed over.
pub(crate) fn largest_or_zero(values: &[f64]) -> f64 {
    largest_above(0.0, values)
}

/// The largest of `least` and the numbers; NaN is passed over.
pub(crate) fn largest_above(least: f64, values: &[f64]) -> f64 {
    // Lanes, because in a single chain every comparison would wait for the last.
    let mut lanes = [least; LANES];
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let (whole, rest) = values.as_chunks::<LANES>();
    for values in whole {
        lanes.iter_mut().zip(values).for_each(|(lane, &value)| *lane = larger(*lane, value));
    }
    lanes.iter_mut().zip(rest).for_each(|(lane, &value)| *lane = larger(*lane, value));
    lanes.into_iter().fold(least, larger)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_is_looked_at() {
        for length in [1, 7, 8, 9, 30] {
            for place in 0..length {
                let mut values = vec![f64::NEG_INFINITY; length];
                values[place] = 2.5;
                values[(place + 1) % length] = if length > 1 { f64::NAN } else { 2.5 };
                assert!((largest_or_zero(&values) - 2.5).abs() <= 0.0, "{length}, {place}");
            }
        }
        assert!(largest_or_zero(&[-1.0, f64::NAN]).abs() <= 0.0);
    }
}
