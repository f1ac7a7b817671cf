//! Where the tyre's elements stand over the road.
//!
//! Element e meets the road slice at road coordinate e dx, always. The axle stands over `start` + V t; at step l that
//! is `start` + l dx/q, or `start` + l s dx. The window is a run of elements round the axle that holds every point that
//! can touch.

use std::f64::consts::PI;

use crate::time_rule::Advance;

/// Positions of the elements of the contact window, exact in integers.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Element length dx \[m\].
    pub element: f64,
    /// Number of elements N round the tyre.
    pub elements: usize,
    /// How far the tyre rolls in a step: dx/q, or s dx.
    pub advance: Advance,
    /// Radius R = L/(2 pi) \[m\].
    pub radius: f64,
    /// Road coordinate under the axle at t = 0 \[m\].
    pub start: f64,
    /// Columns of the window.
    pub columns: usize,
    /// Columns in front of (at smaller x than) the element under the axle.
    half: i64,
    /// floor(start/dx) and floor(q frac(start/dx)).
    origin: (i64, i64),
}

impl Geometry {
    /// Window of elements with |x| <= `reach` \[m\] (at most the whole tyre).
    pub fn new(circumference: f64, elements: usize, advance: impl Into<Advance>, start: f64, reach: f64) -> Self {
        let advance = advance.into();
        let element = circumference / elements as f64;
        let half = ((reach / element).ceil() as i64).clamp(1, (elements as i64 - 1) / 2);
        let units = start / element;
        // A start on an element, up to rounding, counts as on it.
        let whole = (units + 1e-9).floor();
        let part = ((units - whole).max(0.0) * advance.substeps as f64 + 1e-9).floor();
        // One more column than symmetry requires: between two elements the axle has one on either side.
        let columns = (2 * half as usize + 2).min(elements);
        Self {
            element,
            elements,
            advance,
            radius: circumference / (2.0 * PI),
            start,
            columns,
            half,
            origin: (whole as i64, part as i64),
        }
    }

    /// The same with a window that is longer by `margin` columns at either end.
    pub(crate) fn wider(&self, margin: usize) -> Self {
        Self { columns: self.columns + 2 * margin, half: self.half + margin as i64, ..self.clone() }
    }

    /// Element number e of the window's first column at a step.
    pub fn first_element(&self, step: u64) -> i64 {
        self.origin.0 + self.advance.elements(self.origin.1 + step as i64) - self.half
    }

    /// Number of steps since the window last moved on, 0..q.
    pub fn substep(&self, step: u64) -> usize {
        (self.origin.1 + step as i64).rem_euclid(self.advance.substeps as i64) as usize
    }

    /// Coordinate x of element e in the patch at a step \[m\].
    pub fn position(&self, e: i64, step: u64) -> f64 {
        self.position_between(e, step as f64)
    }

    /// Coordinate x of the window's first column when the window has just moved on \[m\]: the same whichever step
    /// that is.
    pub fn first_position(&self) -> f64 {
        let aligned = (0..self.advance.substeps as u64).find(|&step| self.substep(step) == 0).unwrap_or(0);
        self.position(self.first_element(aligned), aligned)
    }

    /// Coordinate x of element e in the patch at a time in steps \[m\].
    pub(crate) fn position_between(&self, e: i64, steps: f64) -> f64 {
        let Advance { substeps, elements_per_step } = self.advance;
        let rolled = steps * (elements_per_step as f64 * self.element) / substeps as f64;
        e as f64 * self.element - (self.start + rolled)
    }

    /// Height of the undeformed tread above the tyre's lowest point at x: R - sqrt(R^2 - x^2), without cancellation
    /// \[m\]; R where |x| >= R.
    pub fn rise(&self, x: f64) -> f64 {
        let ratio = x / self.radius;
        let square = ratio * ratio;
        if square >= 1.0 {
            return self.radius;
        }
        x * ratio / (1.0 + (1.0 - square).sqrt())
    }

    /// [`Self::rise`] of every column of the window at nodes of a step \[m\], for all substeps, after which they
    /// repeat: (substep x nodes + node) x columns + column.
    pub(crate) fn rises(&self, nodes: &[f64]) -> Vec<f64> {
        let instants =
            (0..self.advance.substeps as i64).flat_map(|substep| nodes.iter().map(move |node| (substep, node)));
        let of_instant = |(substep, node): (i64, &f64)| {
            let steps = (substep - self.origin.1 - 1) as f64 + node;
            let elements = (0..self.columns as i64).map(|column| self.origin.0 - self.half + column);
            elements.map(move |e| self.rise(self.position_between(e, steps)))
        };
        instants.flat_map(of_instant).collect()
    }

    /// Half the chord that a rigid tyre cuts from a plane at a depth \[m\], the depth being clamped to 0..=`radius`.
    pub(crate) fn half_chord(radius: f64, depth: f64) -> f64 {
        let depth = depth.clamp(0.0, radius);
        (depth * (2.0 * radius - depth)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Substeps and elements per step, start.
    const CASES: [(Advance, f64); 5] = [
        (Advance::within(1), 0.0),
        (Advance::within(3), 0.1234),
        (Advance::within(4), -0.05),
        (Advance::over(2), 0.1234),
        (Advance::over(4), -0.05),
    ];

    #[test]
    fn the_window_moves_as_the_tyre_rolls_with_the_axle_inside() {
        for (advance, start) in CASES {
            let geometry = Geometry::new(1.95, 512, advance, start, 0.05);
            for step in 0..100 {
                let first = geometry.first_element(step);
                let later = geometry.first_element(step + advance.substeps as u64);
                assert_eq!(later, first + advance.elements_per_step as i64);
                let moved = first > geometry.first_element(step.saturating_sub(1));
                assert!(step == 0 || moved == (geometry.substep(step) == 0));
                assert!(geometry.position(first, step) <= -0.05 + geometry.element);
                assert!(geometry.position(first + geometry.columns as i64 - 1, step) >= 0.05 - geometry.element);
            }
        }
    }

    #[test]
    fn rises_return_with_every_move() {
        for (advance, start) in CASES {
            let geometry = Geometry::new(1.95, 512, advance, start, 0.05);
            let nodes = [0.3, 1.0];
            let rises = geometry.rises(&nodes);
            for step in 0..50 {
                let rows = rises[geometry.substep(step) * nodes.len() * geometry.columns..].chunks(geometry.columns);
                for (row, node) in rows.zip(nodes) {
                    for (column, rise) in row.iter().enumerate() {
                        let e = geometry.first_element(step) + column as i64;
                        let direct = geometry.rise(geometry.position_between(e, step as f64 - 1.0 + node));
                        assert!((rise - direct).abs() < 1e-15, "{rise} {direct}");
                    }
                }
            }
        }
    }

    #[test]
    fn rise_is_the_circle() {
        let geometry = Geometry::new(1.95, 512, 1, 0.0, 0.05);
        let x = 0.04_f64;
        let direct = geometry.radius - (geometry.radius * geometry.radius - x * x).sqrt();
        assert!((geometry.rise(x) - direct).abs() < 1e-15);
        assert!((Geometry::half_chord(geometry.radius, geometry.rise(x)) - x).abs() < 1e-14);
    }
}
