//! Polynomials through given values, by Lagrange's weights.

use std::ops::Range;

/// Lagrange weights: the polynomial through values f_j at `nodes` is sum of w_j f_j at `at`. Nodes must be distinct.
pub(crate) fn weights(nodes: &[f64], at: f64) -> impl Iterator<Item = f64> {
    nodes.iter().enumerate().map(move |(here, node)| {
        let others = nodes.iter().enumerate().filter(|(other, _)| *other != here);
        others.map(|(_, other)| (at - other) / (node - other)).product()
    })
}

/// [`weights`] for the nodes 0, 1, 2, 3.
pub(crate) fn uniform_cubic(at: f64) -> [f64; 4] {
    let [a, b, c, d] = [at, at - 1.0, at - 2.0, at - 3.0];
    [-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0]
}

/// Indices of up to four neighbours in rising numbers for a cubic at `at`: two on either side where there are as many,
/// else the outermost four.
pub(crate) fn cubic_neighbours(rising: &[f64], at: f64) -> Range<usize> {
    let count = rising.len().min(4);
    let above = rising.partition_point(|&number| number <= at);
    let first = above.saturating_sub(2).min(rising.len() - count);
    first..first + count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_met() {
        let cubic = |x: f64| 1.0 + x * (0.5 + x * (0.2 - 0.3 * x));
        let nodes = [-1.0, 0.5, 2.0, 3.5, 9.0];
        for at in [-1.5, 0.1, 2.0, 2.7, 8.0] {
            let near = cubic_neighbours(&nodes, at);
            assert_eq!(near.len(), 4);
            let value: f64 = weights(&nodes[near.clone()], at).zip(&nodes[near]).map(|(w, &x)| w * cubic(x)).sum();
            assert!((value - cubic(at)).abs() < 1e-12 * (1.0 + cubic(at).abs()), "{at}: {value}");
        }
        for at in [-0.4, 0.0, 1.3, 2.9] {
            for (short, long) in uniform_cubic(at).into_iter().zip(weights(&[0.0, 1.0, 2.0, 3.0], at)) {
                assert!((short - long).abs() < 1e-14, "{at}: {short} {long}");
            }
        }
        assert_eq!(cubic_neighbours(&nodes, 2.5), 1..5);
        assert_eq!(cubic_neighbours(&[7.0], 1.0), 0..1);
    }
}
