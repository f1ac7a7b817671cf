//! Exact void ratios: the part of a strip that bands across it and grooves along it cover.
//!
//! A band is |x - X - y tan(angle)| < half for y between two lines. At each y it covers an interval; between all
//! ends and crossings of edges the length of their union is linear in y, so that sums of trapezia are exact.

/// Band across the strip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GrooveBand {
    /// x at which its middle crosses y = 0, X \[m\].
    pub place: f64,
    /// Tangent of its angle to the direction across.
    pub slope: f64,
    /// Half of its width along x \[m\].
    pub half: f64,
    /// Ends y across \[m\].
    pub ends: [f64; 2],
}

impl GrooveBand {
    /// Band of a groove of a width \[m\] perpendicular to it, at an angle \[degrees\].
    pub(crate) fn new(place: f64, width: f64, degrees: f64, ends: [f64; 2]) -> Self {
        let angle = degrees.to_radians();
        Self { place, slope: angle.tan(), half: 0.5 * width / angle.cos(), ends }
    }

    /// x of its middle at y \[m\].
    pub(crate) fn middle(&self, y: f64) -> f64 {
        self.slope.mul_add(y, self.place)
    }

    /// True if it extends across y.
    pub(crate) fn reaches(&self, y: f64) -> bool {
        self.ends[0] < y && y < self.ends[1]
    }

    #[cfg(test)]
    pub(crate) fn covers(&self, x: f64, y: f64) -> bool {
        self.reaches(y) && (x - self.middle(y)).abs() < self.half
    }
}

/// Area \[m^2\] of a rectangle, along and across, that bands cover, `grooves` being intervals across that are covered
/// all along. Bands that leave a `closed` rectangle at one end along enter it at the other.
pub(crate) fn covered(
    bands: &[GrooveBand],
    grooves: &[[f64; 2]],
    [x0, x1]: [f64; 2],
    [y0, y1]: [f64; 2],
    closed: bool,
) -> f64 {
    // 1. All y at which the union's length may bend: ends, and crossings of edges with each other and, unless the
    // rectangle is closed, with the borders.
    let mut cuts = vec![y0, y1];
    cuts.extend(grooves.iter().chain(bands.iter().map(|band| &band.ends)).flatten());
    let edges: Vec<(f64, &GrooveBand)> =
        bands.iter().flat_map(|band| [(band.place - band.half, band), (band.place + band.half, band)]).collect();
    let length = x1 - x0;
    let mut crossing = |place: f64, slope: f64, [low, high]: [f64; 2]| {
        if low >= high || slope.abs() <= 0.0 {
            return;
        }
        // Images of a closed strip cross, too.
        let turn = |y: f64| if closed { (slope * y + place) / length } else { 0.0 };
        let (one, other) = (turn(low), turn(high));
        let turns = one.min(other).floor() as i64..=one.max(other).ceil() as i64;
        let all = turns.map(|turn| (turn as f64).mul_add(length, -place) / slope);
        cuts.extend(all.filter(|y| (low..=high).contains(y)));
    };
    for (number, &(place, band)) in edges.iter().enumerate() {
        for border in [x0, x1].into_iter().filter(|_| !closed) {
            crossing(place - border, band.slope, [y0, y1]);
        }
        for &(other, beside) in &edges[..number] {
            let [low, high] = [band.ends[0].max(beside.ends[0]), band.ends[1].min(beside.ends[1])];
            crossing(place - other, band.slope - beside.slope, [low.max(y0), high.min(y1)]);
        }
    }
    cuts.retain(|y| (y0..=y1).contains(y));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    // 2. Trapezia between them.
    let mut intervals = Vec::new();
    let mut area = 0.0;
    for pair in cuts.windows(2) {
        let (low, high) = (pair[0], pair[1]);
        let middle = 0.5 * (low + high);
        // The union is linear in between: its middle is its mean.
        let is_groove = grooves.iter().any(|&[right, left]| right < middle && middle < left);
        let across = if is_groove { length } else { union(bands, &mut intervals, middle, [x0, x1], closed) };
        area += (high - low) * across;
    }
    area
}

/// Length that bands cover at y \[m\].
fn union(bands: &[GrooveBand], intervals: &mut Vec<[f64; 2]>, y: f64, [x0, x1]: [f64; 2], closed: bool) -> f64 {
    let length = x1 - x0;
    intervals.clear();
    for band in bands.iter().filter(|band| band.reaches(y)) {
        let (from, to) = (band.middle(y) - band.half, band.middle(y) + band.half);
        if !closed {
            intervals.push([from.max(x0), to.min(x1)]);
        } else if to - from >= length {
            return length;
        } else {
            let start = x0 + (from - x0).rem_euclid(length);
            let end = start + (to - from);
            intervals.push([start, end.min(x1)]);
            intervals.push([x0, end - length]);
        }
    }
    intervals.retain(|[from, to]| to > from);
    intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut sum, mut reached) = (0.0, x0);
    for &[from, to] in &*intervals {
        sum += (to - from.max(reached)).max(0.0);
        reached = reached.max(to);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::reference;

    #[test]
    fn shares_of_cells_are_those_of_the_reference() {
        let text = std::fs::read_to_string(reference("tread/ref_pattern.json")).unwrap();
        let known: serde_json::Value = serde_json::from_str(&text).unwrap();
        let (cell, pitch) = (0.002, 0.03);
        let band = |turn: i32| GrooveBand::new(0.0101 + f64::from(turn) * pitch, 0.004, 30.0, [-1.0, 1.0]);
        let bands: Vec<GrooveBand> = (-2..=2).map(band).collect();
        let mut inspected = 0;
        for (i, row) in known["share"].as_array().unwrap().iter().enumerate() {
            for (j, share) in row.as_array().unwrap().iter().enumerate() {
                let (x, y) = (cell * i as f64, cell * j as f64);
                let area = covered(&bands, &[], [x, x + cell], [y, y + cell], false);
                assert!((area / (cell * cell) - share.as_f64().unwrap()).abs() < 1e-9, "{i}, {j}: {area:e}");
                let by_centre = bands.iter().any(|band| band.covers(x + 0.5 * cell, y + 0.5 * cell));
                assert_eq!(u64::from(by_centre), known["by_centre"][i][j].as_u64().unwrap(), "{i}, {j}");
                inspected += 1;
            }
        }
        assert_eq!(inspected, 150);
        // One band comes in again at the other end of its pitch.
        let all = covered(&bands[2..3], &[], [0.0, pitch], [0.0, 10.0 * cell], true) / (pitch * 10.0 * cell);
        assert!((all - known["void"].as_f64().unwrap()).abs() < 1e-9, "{all}");
    }

    #[test]
    fn equal_pitches_have_the_share_of_one_that_is_closed() {
        let (pitch, count) = (0.03, 7);
        let of = |turn: i32| {
            let start = f64::from(turn) * pitch;
            [(0.004, 62.0), (0.011, -70.0), (0.02, 15.0)]
                .map(|(place, angle)| GrooveBand::new(start + place, 0.002, angle, [-0.05, 0.04]))
        };
        let grooves = [[-0.02, -0.01]];
        let one = covered(&of(0), &grooves, [0.0, pitch], [-0.05, 0.05], true);
        let all: Vec<GrooveBand> = (0..count).flat_map(of).collect();
        let all = covered(&all, &grooves, [0.0, pitch * f64::from(count)], [-0.05, 0.05], true);
        assert!((all / (f64::from(count) * one) - 1.0).abs() < 1e-12, "{all} {one}");
    }

    #[test]
    fn what_is_covered_twice_counts_once() {
        let cross = [GrooveBand::new(0.5, 0.2, 45.0, [-0.5, 0.5]), GrooveBand::new(0.5, 0.2, -45.0, [-0.5, 0.5])];
        // Two bands of 1 m across and 0.2 sqrt(2) along less the square of 0.2 m where they cross; closed at the ends.
        let area = covered(&cross, &[], [0.0, 2.0], [-0.5, 0.5], true);
        assert!((area - (0.4 * 2.0_f64.sqrt() - 0.04)).abs() < 1e-12, "{area}");
        // A groove takes its part of both.
        let with = covered(&cross, &[[-0.5, -0.3]], [0.0, 2.0], [-0.5, 0.5], true);
        assert!((with - (area + 0.4 - 0.2 * 0.4 * 2.0_f64.sqrt())).abs() < 1e-12, "{with}");
    }
}
