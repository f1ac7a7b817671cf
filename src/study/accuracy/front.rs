//! The Pareto front of points with a cost and an error.

/// Indices of the non-dominated points (cost, error), by rising cost: no other point has both a lower cost and a lower
/// error; of equal points the first. Points that are not finite are left out.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&i| points[i].0.is_finite() && points[i].1.is_finite()).collect();
    order.sort_by(|&i, &j| points[i].0.total_cmp(&points[j].0).then(points[i].1.total_cmp(&points[j].1)));
    let mut least = f64::INFINITY;
    order.retain(|&i| {
        let better = points[i].1 < least;
        least = least.min(points[i].1);
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [(1.0, 5.0), (2.0, 3.0), (3.0, 4.0), (4.0, 1.0), (4.0, 2.0), (2.0, 3.0), (0.5, f64::NAN)];
        assert_eq!(front(&points), [0, 1, 3]);
        assert_eq!(front(&[]), [0; 0]);
    }

    proptest! {
        #[test]
        fn everything_is_on_the_front_or_beaten_by_it(
            points in prop::collection::vec((0.0..9.0_f64, 0.0..9.0_f64), 1..40),
        ) {
            let on = front(&points);
            for pair in on.windows(2) {
                prop_assert!(points[pair[0]].0 < points[pair[1]].0 && points[pair[0]].1 > points[pair[1]].1);
            }
            for (index, point) in points.iter().enumerate() {
                let is_dominated = on.iter().any(|&i| i != index && points[i].0 <= point.0 && points[i].1 <= point.1);
                prop_assert!(is_dominated || on.contains(&index));
            }
        }
    }
}
