//! The displacement curve S(y) of a slice, piecewise linear.

/// S(y) = integral of the normalised stiffness s over 0..y, for one slice. `y` is the penetration past the slice's highest point.
///
/// S(0) = 0; S is convex, non-decreasing, with slope s in \[0, 1\]. Past the last breakpoint the slope is `final_slope`.
#[derive(Clone, Debug, PartialEq)]
pub struct StiffnessCurve {
    /// Height of the slice's highest point above z = 0 \[m\].
    pub peak: f64,
    /// Breakpoints y_k, increasing, all >= 0 \[m\].
    pub penetration: Box<[f64]>,
    /// S(y_k) \[m\].
    pub displacement: Box<[f64]>,
    /// Slope past the last breakpoint; 1 when the whole width is in contact.
    pub final_slope: f64,
}

impl StiffnessCurve {
    /// A slice that is flat across: S(y) = y.
    pub fn flat(peak: f64) -> Self {
        Self { peak, penetration: Box::new([]), displacement: Box::new([]), final_slope: 1.0 }
    }

    /// S(y); for y <= 0 the gap y itself (no contact).
    pub fn displacement_at(&self, y: f64) -> f64 {
        if y <= 0.0 {
            return y;
        }
        let above = self.penetration.partition_point(|&breakpoint| breakpoint <= y);
        let (y0, s0) = match above {
            0 => (0.0, 0.0),
            k => (self.penetration[k - 1], self.displacement[k - 1]),
        };
        let slope = match (self.penetration.get(above), self.displacement.get(above)) {
            (Some(&y1), Some(&s1)) => (s1 - s0) / (y1 - y0),
            _ => self.final_slope,
        };
        s0 + slope * (y - y0)
    }
}
