//! The displacement curve S(y) of a slice, piecewise linear.

/// S(y) = integral of the normalised stiffness s over 0..y, for one slice. `y` is the penetration past the slice's
/// highest point.
///
/// S(0) = 0; S is convex, non-decreasing, with slope s in \[0, 1\]. Past the last breakpoint the slope is
/// `final_slope`.
#[derive(Clone, Debug, PartialEq)]
pub struct StiffnessCurve {
    /// Height of the slice's highest point above z = 0 \[m\].
    pub peak: f64,
    /// Breakpoints y_k, increasing, all >= 0 \[m\].
    pub penetration: Box<[f64]>,
    /// S(y_k) \[m\].
    pub displacement: Box<[f64]>,
    /// Slope past the last breakpoint; 1 when the whole slice is in contact.
    pub final_slope: f64,
    /// Largest difference from the curve of all cells due to omitted breakpoints \[m\]; 0 for that curve itself.
    pub error: f64,
}

/// A linear piece of a curve: S(y) = `slope` y + `intercept` for `from` <= y <= `to`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// The normalised stiffness s, in \[0, 1\].
    pub slope: f64,
    /// The line's value at y = 0, not positive but for rounding \[m\].
    pub intercept: f64,
    /// First y \[m\].
    pub from: f64,
    /// Last y \[m\]; infinite for the last piece.
    pub to: f64,
}

/// Breakpoints nearer than this are merged \[m\].
const CLOSEST: f64 = 1e-12;

impl StiffnessCurve {
    /// Curve of a flat slice: S(y) = y.
    pub fn flat(peak: f64) -> Self {
        Self { peak, penetration: Box::new([]), displacement: Box::new([]), final_slope: 1.0, error: 0.0 }
    }

    /// The curve S(y) = sum over k of w_k max(0, y - y_k), with the weights w_k summing to 1: the form of both slice
    /// laws.
    ///
    /// `events` are the pairs (y_k, w_k) by non-decreasing y_k >= 0 \[m\]; y_k that are equal, up to a picometre,
    /// become one breakpoint, as the slope between them would be rounding error; those at y_k = 0 only set the initial
    /// slope. The slope past the last one is set to 1 exactly: the weights' sum differs from it by rounding only.
    pub fn from_events(peak: f64, events: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let mut last = 0.0;
        let breakpoints = events
            .clone()
            .filter(|&(y, _)| {
                let new = y > last + CLOSEST;
                if new {
                    last = y;
                }
                new
            })
            .count();
        let mut penetration = Vec::with_capacity(breakpoints);
        let mut displacement = Vec::with_capacity(breakpoints);
        let (mut y, mut s, mut slope) = (0.0, 0.0, 0.0);
        for (event, weight) in events {
            if event > y + CLOSEST {
                s += slope * (event - y);
                y = event;
                penetration.push(y);
                displacement.push(s);
            }
            slope += weight;
        }
        Self { peak, penetration: penetration.into(), displacement: displacement.into(), final_slope: 1.0, error: 0.0 }
    }

    /// S(y) \[m\]; for y <= 0 the gap y itself (no contact).
    pub fn displacement_at(&self, y: f64) -> f64 {
        if y <= 0.0 {
            return y;
        }
        let (s0, y0, slope) = self.segment(self.segment_index(y));
        s0 + slope * (y - y0)
    }

    /// Normalised stiffness s(y) = dS/dy, in \[0, 1\]; at a breakpoint the one to its right, and 0 for y < 0.
    pub fn stiffness_at(&self, y: f64) -> f64 {
        if y < 0.0 { 0.0 } else { self.segment(self.segment_index(y)).2 }
    }

    /// Penetration y >= 0 at which S(y) has a value \[m\]: S^-1, and 0 for values of 0 or less.
    ///
    /// Where S is constant, which is possible by rounding only, the first such y.
    pub fn penetration_at(&self, displacement: f64) -> f64 {
        if displacement <= 0.0 {
            return 0.0;
        }
        let (s0, y0, slope) = self.segment(self.displacement.partition_point(|&s| s < displacement));
        if slope > 0.0 { y0 + (displacement - s0) / slope } else { y0 }
    }

    /// The linear piece of a number, see [`Self::segment_index`].
    #[doc(hidden)]
    pub fn piece(&self, number: usize) -> Piece {
        let (start, from, slope) = self.segment(number);
        let to = self.penetration.get(number).copied().unwrap_or(f64::INFINITY);
        Piece { slope, intercept: start - slope * from, from, to }
    }

    /// Number of the linear piece that contains `y`: the number of breakpoints at or below it.
    pub fn segment_index(&self, y: f64) -> usize {
        self.penetration.partition_point(|&breakpoint| breakpoint <= y)
    }

    /// As [`Self::segment_index`], searched from a piece near which it is likely: a few well predictable comparisons.
    pub fn segment_index_near(&self, y: f64, near: usize) -> usize {
        self.walk(near, |k| self.penetration[k] <= y)
    }

    /// Number of the piece that contains the penetration w at which w + `excess` S(w) = y > 0, `excess` > -1; searched
    /// from `near`.
    pub fn segment_index_in_series(&self, y: f64, excess: f64, near: usize) -> usize {
        // The left side increases with w, because no slope is above 1.
        self.walk(near, |k| self.penetration[k] + excess * self.displacement[k] <= y)
    }

    /// Number of breakpoints for which `passed` holds, from a guess; they must come first.
    fn walk(&self, guess: usize, passed: impl Fn(usize) -> bool) -> usize {
        let mut above = guess.min(self.penetration.len());
        while above < self.penetration.len() && passed(above) {
            above += 1;
        }
        while above > 0 && !passed(above - 1) {
            above -= 1;
        }
        above
    }

    /// Start value, start and slope of the piece before breakpoint `above`.
    fn segment(&self, above: usize) -> (f64, f64, f64) {
        let (y0, s0) = match above {
            0 => (0.0, 0.0),
            k => (self.penetration[k - 1], self.displacement[k - 1]),
        };
        let slope = match (self.penetration.get(above), self.displacement.get(above)) {
            (Some(&y1), Some(&s1)) => (s1 - s0) / (y1 - y0),
            _ => self.final_slope,
        };
        (s0, y0, slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_add_up_to_the_curve_they_describe() {
        let events = [(0.0, 0.25), (0.0, 0.25), (1e-3, 0.25), (3e-3, 0.125), (3e-3, 0.125)];
        let curve = StiffnessCurve::from_events(0.01, events.into_iter());
        assert_eq!(curve.penetration.len(), 2, "ties share a breakpoint and those at 0 need none");
        for y in [0.0, 1e-4, 1e-3, 2e-3, 3e-3, 0.1] {
            let direct: f64 = events.iter().map(|&(event, weight)| weight * (y - event).max(0.0)).sum();
            assert!((curve.displacement_at(y) - direct).abs() <= 1e-16, "S({y})");
            assert!((curve.penetration_at(direct) - y).abs() <= 1e-15, "S^-1(S({y}))");
        }
        assert!((curve.stiffness_at(5e-4) - 0.5).abs() < 1e-14);
        assert!((curve.stiffness_at(1e-3) - 0.75).abs() < 1e-12, "right-hand slope at a breakpoint");
        assert!((curve.displacement_at(-2e-3) + 2e-3).abs() <= 0.0);
    }

    #[test]
    fn pieces_are_the_curve() {
        let events = [(0.0, 0.25), (1e-3, 0.25), (3e-3, 0.5)];
        let curve = StiffnessCurve::from_events(0.0, events.into_iter());
        for y in [1e-4, 1e-3, 2.5e-3, 3e-3, 0.1] {
            let piece = curve.piece(curve.segment_index(y));
            assert!((piece.from..=piece.to).contains(&y), "{piece:?}");
            assert!((piece.slope * y + piece.intercept - curve.displacement_at(y)).abs() < 1e-17, "S({y})");
        }
        assert_eq!(
            StiffnessCurve::flat(0.0).piece(0),
            Piece { slope: 1.0, intercept: 0.0, from: 0.0, to: f64::INFINITY }
        );
    }

    #[test]
    fn a_flat_slice_follows_the_penetration() {
        let curve = StiffnessCurve::from_events(0.0, std::iter::repeat_n((0.0, 0.125), 8));
        assert_eq!(curve, StiffnessCurve::flat(0.0));
    }
}
