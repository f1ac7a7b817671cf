//! A sidewall with its meridian, and its impedances at one s.

use std::sync::{Arc as Shared, OnceLock};

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::arc::Arc;
use super::edge::{
    EdgeImpedance, FEWEST_STEPS, FINE_STEP, FreeEdgeImpedance, STEP, Wave, edge_impedance, edge_response,
    free_edge_impedance, wavenumber,
};
use super::meridian::{EdgeStatics, Meridian, MeridianPoint};
use super::swept::{self, Weights};
use crate::numeric::lanes::dispatch;
use crate::numeric::{Lanes, MOST_LANES, SplitRule};

/// Numbers of steps along the arc; waves that need more than the most get the most.
const LADDER: [usize; 11] = [FEWEST_STEPS, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024];
/// Most steps on account of s: the arc changes little within any of them, which is where their error comes from
/// (1e-6 at 16 kHz).
const MOST_FOR_TIME: f64 = 96.0;

/// K, or flows, of a wave n for the given rotation and for the opposite one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BothWays<T = EdgeImpedance> {
    /// K(n; Omega).
    pub forwards: T,
    /// K(n; -Omega), which is K(-n; Omega) with its coupling negative.
    pub backwards: T,
}

/// Flow of each piece of a sidewall per radian, by the edge's motions w and V \[m^2\]: its [`SplitRule`] runs from the
/// belt to the bead.
pub(crate) type Flow = [[Complex64; 2]; SplitRule::POINTS];

/// A sidewall with its steady state, for the impedance of any wave.
#[derive(Debug)]
pub struct Sidewall {
    arc: Arc,
    /// The same for either direction of rotation; `None`: no steady state, no impedance.
    meridian: Option<Meridian>,
    /// Points along the arc, by number of steps.
    points: [OnceLock<Vec<[MeridianPoint; 3]>>; LADDER.len()],
}

/// Pieces of a sidewall into which its flow is resolved.
#[derive(Debug)]
pub struct Pieces {
    rule: SplitRule,
    /// Weights of the flow, by number of steps.
    weights: [OnceLock<Vec<Weights>>; LADDER.len()],
}

impl Pieces {
    /// Pieces by a rule over 0 (belt) to 1 (bead).
    pub fn new(rule: SplitRule) -> Self {
        Self { rule, weights: std::array::from_fn(|_| OnceLock::new()) }
    }
}

impl PartialEq for Sidewall {
    fn eq(&self, other: &Self) -> bool {
        self.arc == other.arc
    }
}

/// Bytes of the impedances of so many waves at one s.
pub(crate) fn table_bytes(waves: usize) -> f64 {
    (waves.div_ceil(MOST_LANES) * (size_of::<OnceLock<Box<BothWays>>>() + MOST_LANES * size_of::<BothWays>())) as f64
}

impl Sidewall {
    /// Finds the steady state; without one, impedances are NaN.
    pub fn new(arc: Arc) -> Self {
        let meridian = Meridian::new(&arc);
        Self { arc, meridian, points: std::array::from_fn(|_| OnceLock::new()) }
    }

    /// Dimensions and properties of the sidewall.
    pub fn arc(&self) -> &Arc {
        &self.arc
    }

    /// Tension and angle at the ends; `None` where the arc has no steady state.
    pub fn edge(&self) -> Option<EdgeStatics> {
        self.meridian.as_ref().map(Meridian::edge)
    }

    /// Width of the belt on which the pressure alone would act as pressure and sidewalls do: B_e = B - 2 N_b
    /// cos(a_b)/p \[m\] for a belt of the width B = `width` \[m\]; `None` where the arc has no steady state.
    pub fn effective_width(&self, width: f64) -> Option<f64> {
        self.edge().map(|edge| width - 2.0 * edge.pull() / self.arc.pressure)
    }

    /// Number of steps that [`Self::reference`] takes.
    pub fn reference_steps(&self, n: i64, s: Complex64) -> f64 {
        let steps = self.arc.length() * wavenumber(&self.arc, n as f64, s) / FINE_STEP;
        steps.ceil().max(2.0 * FEWEST_STEPS as f64)
    }

    /// K(n, s) with steps so fine that its error is below 1e-7 of its largest entry, a wave at a time; NaN where the
    /// arc has no steady state.
    pub fn reference(&self, n: i64, s: Complex64) -> EdgeImpedance {
        let Some(meridian) = &self.meridian else { return NOTHING };
        let points = meridian.points(self.reference_steps(n, s) as usize);
        let wave = self.wave(n as f64, s);
        edge_impedance(&self.arc, &meridian.edge(), &points, &wave, &wave)
    }

    /// K(n, s) with the steps of runs, within 1e-5 of its largest entry; NaN where the arc has no steady state.
    pub fn impedance(&self, n: i64, s: Complex64) -> EdgeImpedance {
        let Some((meridian, place)) = self.steps(n as f64, s) else { return NOTHING };
        let wave = self.wave(n as f64, s);
        edge_impedance(&self.arc, &meridian.edge(), self.points(meridian, place), &wave, &wave)
    }

    /// As [`Self::impedance`], of an edge that also moves across.
    pub fn free_edge(&self, n: i64, s: Complex64) -> FreeEdgeImpedance {
        let Some((meridian, place)) = self.steps(n.unsigned_abs() as f64, s) else { return NOTHING_FREE };
        let wave = self.wave(n as f64, s);
        free_edge_impedance(&self.arc, &meridian.edge(), self.points(meridian, place), &wave)
    }

    /// Flow of a wave by a given number of steps; NaN where the arc has no steady state.
    pub fn flow(&self, n: i64, s: Complex64, rule: &SplitRule, steps: usize) -> Flow {
        let Some(meridian) = &self.meridian else { return NO_FLOW };
        let (points, weights) = (meridian.points(steps), swept::weights(meridian, rule, steps));
        let wave = self.wave(n as f64, s);
        edge_response(&self.arc, &meridian.edge(), &points, &weights, &wave, &wave).1
    }

    /// Waves n = 0 ..= `largest` at s, found when asked for; a wave above the largest is taken for the largest.
    pub fn at(self: &Shared<Self>, s: Complex64, largest: usize) -> SidewallAt {
        let blocks = (0..=largest / MOST_LANES).map(|_| OnceLock::new());
        SidewallAt { sidewall: Shared::clone(self), s, largest, blocks: blocks.collect() }
    }

    fn wave(&self, n: f64, s: Complex64) -> Wave<Complex64> {
        Wave { n: n.into(), s, loss: self.arc.relaxation.at(s) }
    }

    /// The meridian, and the index in [`LADDER`] of the number of steps for waves up to n.
    fn steps(&self, n: f64, s: Complex64) -> Option<(&Meridian, usize)> {
        let meridian = self.meridian.as_ref()?;
        let steps = |n: f64, s: Complex64| self.arc.length() * wavenumber(&self.arc, n, s) / STEP;
        let wanted = steps(0.0, s).min(MOST_FOR_TIME).max(steps(n, Complex64::ZERO));
        let place = LADDER.iter().position(|&steps| steps as f64 >= wanted).unwrap_or(LADDER.len() - 1);
        Some((meridian, place))
    }

    fn points(&self, meridian: &Meridian, place: usize) -> &[[MeridianPoint; 3]] {
        self.points[place].get_or_init(|| meridian.points(LADDER[place]))
    }
}

/// Impedance of a sidewall without a steady state.
const NOTHING: EdgeImpedance = {
    let none = Complex64::new(f64::NAN, f64::NAN);
    EdgeImpedance { radial: none, coupling: none, circumferential: none, lateral: none }
};

const NOTHING_FREE: FreeEdgeImpedance =
    FreeEdgeImpedance { guided: NOTHING, radial_lateral: NOTHING.radial, lateral_circumferential: NOTHING.radial };

const NO_FLOW: Flow = [[NOTHING.radial; 2]; SplitRule::POINTS];

/// A sidewall at one s: its waves are found when they are first asked for, some neighbours together.
#[derive(Debug)]
pub struct SidewallAt {
    sidewall: Shared<Sidewall>,
    s: Complex64,
    largest: usize,
    blocks: Vec<OnceLock<Box<[BothWays; MOST_LANES]>>>,
}

impl SidewallAt {
    /// K of the wave n >= 0 for both directions of rotation.
    pub fn both_ways(&self, n: usize) -> &BothWays {
        let n = n.min(self.largest);
        let block = n / MOST_LANES;
        &self.blocks[block].get_or_init(|| Box::new(self.block(block * MOST_LANES)))[n % MOST_LANES]
    }

    /// Largest wave n; it stands for those above it.
    pub fn largest(&self) -> usize {
        self.largest
    }

    /// Flows of [`MOST_LANES`] waves from `first` on, a multiple of these; their K is found with them.
    pub fn flows(&self, first: usize, pieces: &Pieces) -> [BothWays<Flow>; MOST_LANES] {
        let (mut found, mut flows) = ([BothWays::of(NOTHING); MOST_LANES], [BothWays::of(NO_FLOW); MOST_LANES]);
        if let Some((meridian, place)) = self.sidewall.steps((first + MOST_LANES - 1) as f64, self.s) {
            let Pieces { rule, weights } = pieces;
            let weights = weights[place].get_or_init(|| swept::weights(meridian, rule, LADDER[place]));
            self.fill(first, meridian, place, weights, |lane, backwards, (impedance, flow)| {
                found[lane].put(backwards, impedance);
                flows[lane].put(backwards, flow);
            });
        }
        if let Some(block) = self.blocks.get(first / MOST_LANES) {
            block.get_or_init(|| Box::new(found));
        }
        flows
    }

    /// K of [`MOST_LANES`] waves from `first` on.
    fn block(&self, first: usize) -> [BothWays; MOST_LANES] {
        let mut found = [BothWays::of(NOTHING); MOST_LANES];
        if let Some((meridian, place)) = self.sidewall.steps((first + MOST_LANES - 1) as f64, self.s) {
            self.fill(first, meridian, place, &vec![[]; LADDER[place]], |lane, backwards, (impedance, _)| {
                found[lane].put(backwards, impedance);
            });
        }
        found
    }

    /// Gives K and sums of the arc's motion of waves from `first` on, lane by lane, for both directions of rotation.
    fn fill<const K: usize>(
        &self,
        first: usize,
        meridian: &Meridian,
        place: usize,
        sums: &[[[f64; 2]; K]],
        mut give: impl FnMut(usize, bool, Response<K>),
    ) {
        let Self { sidewall, s, .. } = self;
        let (edge, points) = (meridian.edge(), sidewall.points(meridian, place));
        let widest = sidewall.wave((first + MOST_LANES - 1) as f64, *s);
        let mut put = |arc: &Arc, ways: &[bool]| {
            let mut values = [(NOTHING, [[Complex64::ZERO; 2]; K]); MOST_LANES];
            dispatch(Neighbours { arc, edge: &edge, points, sums, widest: &widest, first, values: &mut values });
            for (lane, value) in values.into_iter().enumerate() {
                ways.iter().for_each(|&backwards| give(lane, backwards, value));
            }
        };
        let arc = &sidewall.arc;
        if arc.angular_velocity == 0.0 {
            put(arc, &[false, true]);
            return;
        }
        put(arc, &[false]);
        put(&Arc { angular_velocity: -arc.angular_velocity, ..arc.clone() }, &[true]);
    }
}

/// K, and sums of the arc's motion by w and V of the edge.
type Response<const K: usize> = (EdgeImpedance, [[Complex64; 2]; K]);

impl<T: Copy> BothWays<T> {
    const fn of(value: T) -> Self {
        Self { forwards: value, backwards: value }
    }

    fn put(&mut self, backwards: bool, value: T) {
        *(if backwards { &mut self.backwards } else { &mut self.forwards }) = value;
    }
}

/// Neighbouring waves in lockstep. A type, not a closure: it has to be inlined into the dispatch to be compiled for
/// its instructions.
struct Neighbours<'a, const K: usize> {
    arc: &'a Arc,
    edge: &'a EdgeStatics,
    points: &'a [[MeridianPoint; 3]],
    sums: &'a [[[f64; 2]; K]],
    widest: &'a Wave<Complex64>,
    first: usize,
    values: &'a mut [Response<K>; MOST_LANES],
}

impl<const K: usize> WithSimd for Neighbours<'_, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { arc, edge, points, sums, widest, first, values } = self;
        for (group, values) in values.chunks_mut(S::F64_LANES).enumerate() {
            let from = first + group * S::F64_LANES;
            let wave = Wave {
                n: Lanes::from_fn(simd, |lane| ((from + lane) as f64).into()),
                s: Lanes::from_fn(simd, |_| widest.s),
                loss: Lanes::from_fn(simd, |_| widest.loss),
            };
            let (found, moved) = edge_response(arc, edge, points, sums, &wave, widest);
            let (radial, coupling) = (found.radial.to_array(), found.coupling.to_array());
            let (circumferential, lateral) = (found.circumferential.to_array(), found.lateral.to_array());
            for (lane, (value, _)) in values.iter_mut().enumerate() {
                *value = EdgeImpedance {
                    radial: radial[lane],
                    coupling: coupling[lane],
                    circumferential: circumferential[lane],
                    lateral: lateral[lane],
                };
            }
            for (k, moved) in moved.into_iter().enumerate() {
                for (way, moved) in moved.into_iter().enumerate() {
                    for ((_, value), moved) in values.iter_mut().zip(moved.to_array()) {
                        value[k][way] = moved;
                    }
                }
            }
        }
    }
}
