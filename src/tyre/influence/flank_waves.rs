//! Flow of the sidewalls by wave and frequency: the volume that a wave of the tread makes them sweep.
//!
//! A force on the tread moves the belt's edges by w and V, and these the sidewall, which sweeps the flow Q_k in each
//! of its pieces ([`crate::sidewall::Pieces`]). H = Q_k(n, m)/C_zz is tabulated at the frequencies of
//! [`super::SurfaceWaves`], and interpolated by cubics: where the tyre resonates Q and C do together; where the
//! sidewall would, its edge stands still. The error is below 3e-3 of the wave's largest value (measured; the test
//! bounds it).
//!
//! Waves too short to reach the inner face, those with more periods than sidewalls resolve, and those of a flat layer
//! move no sidewall.

use std::ops::Range;

use num_complex::{Complex32, Complex64};
use serde::{Deserialize, Serialize};

use super::kernel::KernelAt;
use super::waves::Waves;
use crate::numeric::{MOST_LANES, SplitRule, in_parallel};
use crate::sidewall::{BothWays, Flow, Pieces};
use crate::tyre::layers::cylinder::EdgeMotion;

pub(super) const PIECES: usize = SplitRule::POINTS;

/// Flows of the waves n = 0..`around` and some lateral numbers, in single precision: its rounding is far below the
/// error of interpolation.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(super) struct FlankWaves {
    /// Number of waves round the tyre.
    around: usize,
    /// Number of lateral numbers.
    lateral: usize,
    /// Number of frequencies.
    points: usize,
    /// Q/C_zz by n, m, frequency, piece \[m\].
    flows: Vec<Complex32>,
    /// Those of the waves -n; empty at rest.
    backwards: Vec<Complex32>,
}

/// Flows of the sidewall by its edge's motion, wave by wave.
pub(super) type ByEdge = Vec<BothWays<Flow>>;

/// Bytes of the flows of so many waves and lateral numbers at so many frequencies, those by the edge's motion
/// included.
pub(super) fn bytes(around: usize, lateral: usize, points: f64, turns: bool) -> f64 {
    let by_edge = around.next_multiple_of(MOST_LANES) * size_of::<BothWays<Flow>>();
    let ways = if turns { 2 } else { 1 };
    points * (by_edge + ways * around * lateral * PIECES * size_of::<Complex32>()) as f64
}

/// Flows by the edge's motion at each s of `at`, for all waves that sidewalls resolve; empty without sidewalls.
pub(super) fn by_edge(at: &[KernelAt], rule: &SplitRule, most_around: usize) -> Vec<ByEdge> {
    let pieces = Pieces::new(rule.clone());
    in_parallel::map(at, |at| {
        let Some(sidewall) = at.sidewall() else { return Vec::new() };
        let around = sidewall.largest().min(most_around) + 1;
        let blocks = (0..around).step_by(MOST_LANES);
        let mut flows: ByEdge = blocks.flat_map(|first| sidewall.flows(first, &pieces)).collect();
        flows.truncate(around);
        flows
    })
}

impl FlankWaves {
    /// Zeros for so many lateral numbers at as many frequencies as `by_edge` has.
    pub(super) fn new(by_edge: &[ByEdge], lateral: usize, turns: bool) -> Self {
        let (points, around) = (by_edge.len(), by_edge.first().map_or(0, Vec::len));
        let flows = vec![Complex32::ZERO; around * lateral * points * PIECES];
        let backwards = if turns { flows.clone() } else { Vec::new() };
        Self { around, lateral, points, flows, backwards }
    }

    /// The rows of each n, forwards and backwards; the latter are empty at rest.
    pub(super) fn rows(&mut self) -> Vec<[&mut [Complex32]; 2]> {
        let width = (self.lateral * self.points * PIECES).max(1);
        let mut backwards = self.backwards.chunks_mut(width);
        self.flows.chunks_mut(width).map(|row| [row, backwards.next().unwrap_or_default()]).collect()
    }

    /// Q/C_zz \[m\] of the pieces of a wave, interpolated with `weights` between four frequencies from `first` on;
    /// zero for n beyond the table.
    pub(super) fn at(
        &self,
        [n, index]: [usize; 2],
        runs_backwards: bool,
        first: usize,
        weights: &[f64; 4],
    ) -> [Complex64; PIECES] {
        let mut sums = [Complex64::ZERO; PIECES];
        if n < self.around {
            let table = if runs_backwards { &self.backwards } else { &self.flows };
            let row = &table[((n * self.lateral + index) * self.points + first) * PIECES..][..4 * PIECES];
            for (known, weight) in row.chunks_exact(PIECES).zip(weights) {
                let flows = known.iter().map(|flow| Complex64::new(flow.re.into(), flow.im.into()));
                sums.iter_mut().zip(flows).for_each(|(sum, flow)| *sum += flow * weight);
            }
        }
        sums
    }

    /// True if numbers read from a file are finite and fit each other.
    pub(super) fn is_valid(&self) -> bool {
        let numbers = self.around * self.lateral * self.points * PIECES;
        let flows = self.flows.iter().chain(&self.backwards);
        self.flows.len() == numbers
            && [0, numbers].contains(&self.backwards.len())
            && flows.into_iter().all(|flow| flow.is_finite())
    }
}

/// Writes the flows of a wave (n, m) at the frequencies `places` into the rows of n, from the motions of its edge.
pub(super) fn put(
    rows: &mut [&mut [Complex32]; 2],
    waves: Waves,
    [n, m]: [usize; 2],
    places: Range<usize>,
    by_edge: &[ByEdge],
    motion: [[EdgeMotion; MOST_LANES]; 2],
) {
    let side = waves.at_side(m);
    let ways: [fn(&BothWays<Flow>) -> &Flow; 2] = [|both| &both.forwards, |both| &both.backwards];
    for ((row, motion), way) in rows.iter_mut().zip(motion).zip(ways).filter(|((row, _), _)| !row.is_empty()) {
        let row = row[places.start * PIECES..places.end * PIECES].chunks_exact_mut(PIECES);
        for ((out, by_edge), edge) in row.zip(by_edge).zip(motion) {
            let EdgeMotion { surface, radial, circumferential } = edge;
            let [w, v] = [radial, circumferential].map(|motion| motion * side / surface);
            for (out, [by_w, by_v]) in out.iter_mut().zip(way(&by_edge[n])) {
                let flow = w * by_w + v * by_v;
                *out = Complex32::new(flow.re as f32, flow.im as f32);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, Tyre};
    use crate::sidewall::Sidewall;
    use crate::tyre::influence::SurfaceWaves;
    use crate::tyre::layers::curved::{CurvedStack, FINE_STEP};

    const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/tyres/car.toml");

    /// Flows of a signed wave of the tyre as it turns, by the reference values of stack and arc.
    fn exact(tyre: &Tyre, rule: &SplitRule, n: i64, m: usize, frequency: f64) -> Vec<Complex64> {
        let s = Complex64::new(0.0, std::f64::consts::TAU * frequency);
        let (_, bottom) = CurvedStack::new(tyre).compliance(n, m, s, FINE_STEP);
        let arc = tyre.sidewall_arc(tyre.angular_velocity).unwrap();
        let flow = Sidewall::new(arc).flow(n, s, rule, 256);
        // v = -i V.
        let [w, v] = [bottom[2][2], Complex64::i() * bottom[0][2]];
        let side = Waves::new(tyre).at_side(m);
        flow.iter().map(|[by_w, by_v]| (w * by_w + v * by_v) * side).collect()
    }

    #[test]
    fn flows_of_waves_both_ways_are_those_of_stack_and_arc() {
        let rule = SplitRule::new(0.26);
        let (lateral, mut worst) = (vec![0, 1, 2, 6], 0.0_f64);
        for angular_velocity in [0.0, -71.6] {
            let tyre = Tyre { angular_velocity, ..Scene::with_tyre(PATH, &[]).unwrap().scene.tyre };
            let table = SurfaceWaves::with_flank(&tyre, 40, lateral.clone(), [1500.0, 1e-6], Some(&rule));
            let count = lateral.len() * PIECES;
            let mut flows = vec![Complex64::ZERO; count];
            let mut compliances = vec![Complex64::ZERO; lateral.len()];
            for n in [0, 2, 11, 40] {
                // The largest flow of a wave over frequency.
                let mut largest = vec![0.0_f64; count];
                for point in 0..300 {
                    let frequency = 5.0 * f64::from(point);
                    table.at(n, frequency, &mut compliances);
                    table.flows_at(n, frequency, &compliances, &mut flows);
                    largest.iter_mut().zip(&flows).for_each(|(largest, flow)| *largest = largest.max(flow.norm()));
                }
                for (n, frequency) in [n, -n].iter().flat_map(|&n| [31.3, -101.7, 338.0, 1203.0].map(|f| (n, f))) {
                    table.at(n, frequency, &mut compliances);
                    table.flows_at(n, frequency, &compliances, &mut flows);
                    for (index, &m) in lateral.iter().enumerate() {
                        let exact = exact(&tyre, &rule, n, m, frequency);
                        let places = index * PIECES..(index + 1) * PIECES;
                        let size = largest[places.clone()].iter().fold(0.0_f64, |a, &b| a.max(b));
                        for (found, exact) in flows[places].iter().zip(exact) {
                            let error = (found - exact).norm() / size;
                            worst = worst.max(error);
                            assert!(error < 3e-3, "{angular_velocity}/s, ({n}, {m}), {frequency} Hz: {error:.1e}");
                        }
                    }
                }
            }
            // Past the waves that sidewalls resolve nothing moves.
            table.flows_at(41, 100.0, &compliances, &mut flows);
            assert!(flows.iter().all(|flow| flow.norm() == 0.0));
        }
        println!("flows of waves: {worst:.1e} of the largest");
    }

    #[test]
    fn waves_are_the_same_bits_with_flows_and_without() {
        let tyre = Tyre { angular_velocity: -71.6, ..Scene::with_tyre(PATH, &[]).unwrap().scene.tyre };
        let rule = SplitRule::new(0.26);
        let [without_sides, with_sides] =
            [None, Some(&rule)].map(|rule| SurfaceWaves::with_flank(&tyre, 20, vec![0, 2], [600.0, 1e-4], rule));
        assert_eq!([without_sides.pieces(), with_sides.pieces()], [0, PIECES]);
        let mut values = [[Complex64::ZERO; 2]; 2];
        for (n, frequency) in [(0, 30.0), (7, 333.0), (-7, 333.0), (20, 599.0)] {
            without_sides.at(n, frequency, &mut values[0]);
            with_sides.at(n, frequency, &mut values[1]);
            assert_eq!(values[0], values[1], "n = {n}, {frequency} Hz");
        }
    }
}
