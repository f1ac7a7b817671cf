//! Curves over axes: cut at the frame, interrupted where they have no position, and thinned if they are long.

use super::colour::Colour;
use super::layout::Axes;
use super::sheet::{Point, Sheet};

/// Curves with more than four times as many points are thinned to the extremes in each of so many columns, which does
/// not change the picture.
const COLUMNS: usize = 2000;

impl Sheet {
    /// Draws what lies inside the frame of a curve that is given in the units of the axes.
    pub(super) fn curve(&mut self, axes: &Axes<'_>, points: &[(f64, f64)], colour: Colour, width: f64) {
        for piece in axes.pieces(points) {
            self.line(&piece, colour, width);
        }
    }
}

impl Axes<'_> {
    /// Parts of a curve on the sheet, in as many pieces as it has interruptions.
    pub(super) fn pieces(&self, points: &[(f64, f64)]) -> Vec<Vec<Point>> {
        let placed: Vec<Point> = points.iter().map(|&(x, y)| (self.x.place(x), self.y.place(y))).collect();
        placed
            .chunk_by(|a, b| has_position(*a) && has_position(*b))
            .filter(|stretch| stretch.len() > 1)
            .flat_map(|stretch| cut(&thinned(stretch)))
            .map(|piece| piece.into_iter().map(|(x, y)| (self.frame.across(x), self.frame.up(y))).collect())
            .collect()
    }
}

/// False for NaN and infinite values, which a logarithm of 0 has too.
pub(super) fn has_position((x, y): (f64, f64)) -> bool {
    x.is_finite() && y.is_finite()
}

/// Parts of a curve inside the unit square; where it crosses an edge it gets a point there.
fn cut(points: &[Point]) -> Vec<Vec<Point>> {
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    for pair in points.windows(2) {
        let Some((from, to)) = clipped(pair[0], pair[1]) else { continue };
        match pieces.last_mut() {
            Some(open) if open.last() == Some(&from) => open.push(to),
            _ => pieces.push(vec![from, to]),
        }
    }
    pieces
}

/// Part of a segment inside the unit square (Liang and Barsky 1984).
fn clipped(a: Point, b: Point) -> Option<(Point, Point)> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (slope, distance) in [(-dx, a.0), (dx, 1.0 - a.0), (-dy, a.1), (dy, 1.0 - a.1)] {
        if slope < 0.0 {
            enter = enter.max(distance / slope);
        } else if slope > 0.0 {
            leave = leave.min(distance / slope);
        } else if distance < 0.0 {
            return None;
        }
    }
    // Unchanged ends are returned without arithmetic, so that neighbours join without rounding.
    let at = |t: f64| (a.0 + t * dx, a.1 + t * dy);
    let start = if enter > 0.0 { at(enter) } else { a };
    let end = if leave < 1.0 { at(leave) } else { b };
    (enter <= leave).then_some((start, end))
}

/// First, lowest, highest and last point of each column of the picture, in their order.
fn thinned(points: &[Point]) -> Vec<Point> {
    if points.len() <= 4 * COLUMNS {
        return points.to_vec();
    }
    let column = |point: &Point| (point.0 * COLUMNS as f64).floor();
    let mut few = Vec::with_capacity(4 * COLUMNS);
    for chunk in points.chunk_by(|a, b| column(a).total_cmp(&column(b)).is_eq()) {
        let extreme = |sign: f64| (0..chunk.len()).max_by(|&i, &j| (sign * chunk[i].1).total_cmp(&(sign * chunk[j].1)));
        let mut chosen = vec![0, extreme(-1.0).unwrap_or(0), extreme(1.0).unwrap_or(0), chunk.len() - 1];
        chosen.sort_unstable();
        chosen.dedup();
        few.extend(chosen.into_iter().map(|index| chunk[index]));
    }
    few
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_cut_at_the_frame() {
        let inside = cut(&[(0.0, 0.5), (0.5, 1.5), (1.0, 0.5)]);
        assert_eq!(inside, vec![vec![(0.0, 0.5), (0.25, 1.0)], vec![(0.75, 1.0), (1.0, 0.5)]]);
        assert!(cut(&[(0.0, 2.0), (1.0, 2.0)]).is_empty());
        assert_eq!(cut(&[(-1.0, 0.5), (2.0, 0.5)]), vec![vec![(0.0, 0.5), (1.0, 0.5)]]);
    }

    #[test]
    fn thinning_keeps_spikes() {
        let mut points: Vec<(f64, f64)> = (0..100_000).map(|n| (f64::from(n) / 1e5, 0.5)).collect();
        points[54_321].1 = 0.9;
        points[12_345].1 = 0.1;
        let few = thinned(&points);
        assert!(few.len() <= 4 * COLUMNS);
        assert!(few.contains(&points[54_321]) && few.contains(&points[12_345]));
        assert_eq!((few.first(), few.last()), (points.first(), points.last()));
        assert!(few.windows(2).all(|pair| pair[0].0 <= pair[1].0));
    }
}
