//! Prototype of contact on two scales: coarse cells carry the tyre's waves and their history, sub-cells touch the road.
//!
//! Sub-cells a have forces f_a. With weights P of an interpolation between the middles of coarse cells,
//!
//! ```text
//! u = P^T (G_c + history) P f + S (kappa_0 f + sum_r kappa_r e_r),   e_r + tau_r e_r' = f
//! ```
//!
//! - S = g - P^T g_c P, influences between sub-cells and between cells of a tread without inertia at the rule's first
//!   rate s0, not cut off; mu(s0)/mu(s) = kappa_0 + sum_r kappa_r/(1 + s tau_r).
//! - Within an instant, P^T (G_c - g_c) P is replaced by its mean over the places of sub-cells within a cell, the `share`
//!   of each wave. What is searched with is then an influence between sub-cells like any other, definite wave by wave.
//! - `TYREWAVE_TWO_SCALES_BOOST` raises the coarse waves by what the means over cells and P take from them, up to this
//!   percentage of the highest wavenumber on coarse cells, and leaves their aliases to S.
//!
//! Switched on by `TYREWAVE_TWO_SCALES` = sub-cells to a cell along and across, with `zone = "cells"`, `sdirk2`,
//! `history = "modal"`, a tread of the law `power-law`, and `outputs.plots = false`. The scene gives the coarse cells.
//!
//! Left to do: keys; plan (work, memory, errors stated); checkpoints (forces, e_r, the search); `bdf` and `sdirk3`
//! (`time_rule::recursion` has their recursions); other laws of the tread; outputs by cell, of which the rolling
//! resistance is wrong, since force and displacement are reported by coarse cell; vibration and sound, which have to take
//! P f and waves that are not raised; friction, voids and patterns, blocks; tests.

use std::f64::consts::PI;
use std::ops::Range;

use super::instant::InstantCells;
use super::product::CellProduct;
use super::search::{CellCounts, CellSearch};
use super::zone::CellHistory;
use crate::contact::complementarity::{Residuals, SearchCounts};
use crate::contact::error::ContactError;
use crate::contact::footprint::StageMut;
use crate::contact::tread::TreadSurface;
use crate::contact::zone::{ContactZone, Instant, Solved};
use crate::counters::{Meter, Stage, Work};
use crate::numeric::largest_or_zero;
use crate::road::strip::RoadStrip;
use crate::storage::state::{Evolving, StateError, StateStream};
use crate::time_rule::TimeRule;
use crate::tyre::influence::CellInfluence;

/// Sub-cells to a cell along and across: `TYREWAVE_TWO_SCALES`; `None` without.
pub(crate) fn refine() -> Option<usize> {
    number("TYREWAVE_TWO_SCALES").filter(|refine| *refine > 1)
}

/// Order of the interpolation: `TYREWAVE_TWO_SCALES_ORDER`, 3 by default.
pub(crate) fn order() -> usize {
    number("TYREWAVE_TWO_SCALES_ORDER").unwrap_or(3)
}

/// Factors of coarse waves by phase over a cell, 0 to pi, that make up for what cells and interpolation take from
/// them: with `TYREWAVE_TWO_SCALES_BOOST`, the percentage of pi up to which they do.
pub(crate) fn boost() -> Option<Vec<f64>> {
    const PLACES: usize = 400;
    let full = number("TYREWAVE_TWO_SCALES_BOOST")? as f64 / 100.0;
    let (order, refine) = (order(), refine()?);
    let end = (full + 0.25).min(0.97);
    let of = |place: usize| {
        let part = place as f64 / PLACES as f64;
        let phase = PI * part;
        let sinc = crate::numeric::sinc;
        let gain = sinc(0.5 * phase) * Interpolation::passed(order, refine, phase) / sinc(0.5 * phase / refine as f64);
        let fade = if part < full { 1.0 } else { (0.5 * PI * ((part - full) / (end - full)).min(1.0)).cos().powi(2) };
        if part < end { fade / (gain * gain) } else { 0.0 }
    };
    Some((0..=PLACES).map(of).collect())
}

/// Density of the tread that short waves have, relative to its own: `TYREWAVE_TWO_SCALES_DENSITY` in thousandths.
pub(crate) fn density() -> f64 {
    number("TYREWAVE_TWO_SCALES_DENSITY").unwrap_or(1) as f64 * 1e-3
}

fn number(name: &str) -> Option<usize> {
    std::env::var(name).ok()?.parse().ok()
}

/// Points of the interpolation along one direction: offset of the first from the cell that a sub-cell is in.
#[derive(Clone, Debug)]
struct Weights {
    first: i64,
    weights: Vec<f64>,
}

/// Weights at a distance t from a point, in cells, -1/2 < t < 1/2: 0 nearest, 1 linear, 3 cubic (Keys), 5 quintic
/// (Lagrange).
fn weights(order: usize, t: f64) -> Weights {
    let low = if t < 0.0 { -1 } else { 0 };
    let x = t - low as f64;
    match order {
        0 => Weights { first: 0, weights: vec![1.0] },
        1 => Weights { first: low, weights: vec![1.0 - x, x] },
        3 => {
            let (x2, x3) = (x * x, x * x * x);
            let weights = vec![
                -0.5 * x3 + x2 - 0.5 * x,
                1.5 * x3 - 2.5 * x2 + 1.0,
                -1.5 * x3 + 2.0 * x2 + 0.5 * x,
                0.5 * x3 - 0.5 * x2,
            ];
            Weights { first: low - 1, weights }
        }
        _ => {
            let half = (order as i64 + 1) / 2;
            let nodes: Vec<f64> = (1 - half..=half).map(|node| node as f64).collect();
            let basis = |k: usize| {
                let others = nodes.iter().enumerate().filter(|(l, _)| *l != k);
                others.fold(1.0, |product, (_, node)| product * (x - node) / (nodes[k] - node))
            };
            Weights { first: low + 1 - half, weights: (0..nodes.len()).map(basis).collect() }
        }
    }
}

/// Between coarse cells and sub-cells.
#[derive(Clone, Debug)]
pub(crate) struct Interpolation {
    pub(crate) refine: usize,
    columns: usize,
    across: usize,
    along: Vec<Weights>,
    /// By sub-cell across: coarse cells and weights.
    crosswise: Vec<Vec<(usize, f64)>>,
    line: Vec<f64>,
    lines: Vec<f64>,
}

/// Middle of a sub-cell from that of its cell, in cells.
fn place(refine: usize, sub: usize) -> f64 {
    (sub as f64 + 0.5) / refine as f64 - 0.5
}

impl Interpolation {
    pub(crate) fn new(order: usize, refine: usize, columns: usize, across: usize) -> Self {
        let along: Vec<Weights> = (0..refine).map(|sub| weights(order, place(refine, sub))).collect();
        let crosswise = (0..across * refine).map(|j| {
            let (cell, Weights { first, weights }) = (j / refine, &along[j % refine]);
            let mut all = vec![0.0; across];
            let mut add = |cell: i64, weight: f64| {
                let last = across as i64 - 1;
                // Beyond the edges the field goes on in a straight line.
                if cell < 0 {
                    all[0] += weight * (1 - cell) as f64;
                    all[1.min(last as usize)] += weight * cell as f64;
                } else if cell > last {
                    let beyond = cell - last;
                    all[last as usize] += weight * (1 + beyond) as f64;
                    all[(last - 1).max(0) as usize] -= weight * beyond as f64;
                } else {
                    all[cell as usize] += weight;
                }
            };
            for (offset, weight) in weights.iter().enumerate() {
                add(cell as i64 + first + offset as i64, *weight);
            }
            all.into_iter().enumerate().filter(|(_, weight)| weight.abs() > 0.0).collect()
        });
        Self {
            refine,
            columns,
            across,
            crosswise: crosswise.collect(),
            along,
            line: vec![0.0; across],
            lines: vec![0.0; columns * across * refine],
        }
    }

    /// P of a wave: the part of its amplitude that interpolation passes on.
    pub(crate) fn passed(order: usize, refine: usize, phase_of_cell: f64) -> f64 {
        let of_sub = |sub: usize| {
            let (t, Weights { first, weights }) = (place(refine, sub), weights(order, place(refine, sub)));
            let parts = weights
                .iter()
                .enumerate()
                .map(|(offset, weight)| weight * (phase_of_cell * (t - (first + offset as i64) as f64)).cos());
            parts.sum::<f64>()
        };
        (0..refine).map(of_sub).sum::<f64>() / refine as f64
    }

    /// P f.
    fn spread<T: Copy + Into<f64>>(&mut self, fine: &[T], coarse: &mut [f64]) {
        let Self { refine, columns, across, along, crosswise, line, .. } = self;
        coarse.fill(0.0);
        for (i, row) in fine.chunks_exact(*across * *refine).enumerate() {
            line.fill(0.0);
            let mut is_empty = true;
            for (force, weights) in row.iter().zip(&*crosswise) {
                let force: f64 = (*force).into();
                if force.abs() > 0.0 {
                    is_empty = false;
                    weights.iter().for_each(|(cell, weight)| line[*cell] += weight * force);
                }
            }
            if is_empty {
                continue;
            }
            let Weights { first, weights } = &along[i % *refine];
            for (offset, weight) in weights.iter().enumerate() {
                let column = ((i / *refine) as i64 + first + offset as i64).clamp(0, *columns as i64 - 1) as usize;
                let out = &mut coarse[column * *across..][..*across];
                out.iter_mut().zip(&*line).for_each(|(out, value)| *out += weight * value);
            }
        }
    }

    /// Adds P^T of a coarse field.
    fn add_interpolated(&mut self, coarse: &[f64], fine: &mut [f64]) {
        let Self { refine, columns, across, along, crosswise, lines, .. } = self;
        let width = *across * *refine;
        for (line, row) in lines.chunks_exact_mut(width).zip(coarse.chunks_exact(*across)) {
            for (out, weights) in line.iter_mut().zip(&*crosswise) {
                *out = weights.iter().map(|(cell, weight)| weight * row[*cell]).sum();
            }
        }
        for (i, out) in fine.chunks_exact_mut(width).enumerate() {
            let Weights { first, weights } = &along[i % *refine];
            for (offset, weight) in weights.iter().enumerate() {
                let column = ((i / *refine) as i64 + first + offset as i64).clamp(0, *columns as i64 - 1) as usize;
                out.iter_mut().zip(&lines[column * width..]).for_each(|(out, value)| *out += weight * value);
            }
        }
    }
}

/// kappa_r and tau_r of mu(s0)/mu(s) for mu ~ (s + corner)^exponent; kappa_0 is what the sum lacks to 1 at s0.
pub(crate) fn creep(exponent: f64, corner: f64, first_rate: f64) -> Vec<[f64; 2]> {
    /// Distance of rates, as logarithms: 0.7 % of the function.
    const SPACING: f64 = 2.0;
    /// Lowest rate \[1/s\]: a cell is in contact for 5 ms.
    const LOWEST: f64 = 5.0;
    let scale = (first_rate + corner).powf(exponent) * (PI * exponent).sin() / PI * SPACING;
    let mut parts = Vec::new();
    // x^-a = sin(pi a)/pi int t^(1 - a)/(t + x) d ln t.
    let mut rate = 15.0 * first_rate;
    while rate > LOWEST {
        let pole = rate + corner;
        parts.push([scale * rate.powf(1.0 - exponent) / pole, pole.recip()]);
        rate *= (-SPACING).exp();
    }
    parts
}

/// History of sub-cells: that of coarse cells, and the creep of the short waves.
pub(crate) struct TwoScaleHistory {
    pub(crate) coarse: Box<dyn CellHistory<1>>,
    pub(crate) between: Interpolation,
    /// g, on parts of the window.
    fine: InstantCells,
    coarse_product: CellProduct<f64>,
    /// kappa_r, tau_r.
    creep: Vec<[f64; 2]>,
    rule: TimeRule,
    time_step: f64,
    first_element: i64,
    /// Coarse columns whose sub-cells creep: those in contact and `AROUND`.
    active: Range<usize>,
    /// By part of the creep and sub-cell: e_r at the step's begin, what the stage begins with, its rate times the step.
    states: Vec<[Vec<f32>; 3]>,
    of_coarse: [Vec<f64>; 3],
    single: [Vec<f32>; 2],
}

/// Coarse columns on either side of those in contact whose sub-cells creep, and again whose displacements count.
const AROUND: usize = 2;

impl TwoScaleHistory {
    pub(crate) fn new(
        coarse: Box<dyn CellHistory<1>>,
        between: Interpolation,
        [quasi_fine, quasi_coarse]: [CellInfluence; 2],
        creep: Vec<[f64; 2]>,
        rule: TimeRule,
        time_step: f64,
    ) -> Self {
        let (coarse_cells, cells) =
            (quasi_coarse.columns * quasi_coarse.across, quasi_fine.columns * quasi_fine.across);
        let (zeros, coarse_zeros) = (|| vec![0.0_f32; cells], || vec![0.0; coarse_cells]);
        Self {
            coarse,
            between,
            coarse_product: CellProduct::whole(quasi_coarse.columns, &quasi_coarse),
            fine: InstantCells::new(quasi_fine),
            states: creep.iter().map(|_| [zeros(), zeros(), zeros()]).collect(),
            creep,
            rule,
            time_step,
            first_element: i64::MIN,
            active: 0..0,
            of_coarse: [coarse_zeros(), coarse_zeros(), coarse_zeros()],
            single: [zeros(), zeros()],
        }
    }

    /// Sub-cells of a coarse column.
    fn of_column(&self) -> usize {
        self.between.refine * self.between.refine * self.between.across
    }
}

impl Evolving for TwoScaleHistory {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        self.coarse.state(state)
    }
}

impl CellHistory<1> for TwoScaleHistory {
    fn add_displacement(&mut self, stage: usize, first_element: i64, out: &mut [[f64; 1]], meter: &mut Meter) {
        let out = out.as_flattened_mut();
        let (cells, of_column) = (out.len(), self.of_column());
        let shift = usize::try_from(first_element.saturating_sub(self.first_element)).unwrap_or(usize::MAX);
        let shift = shift.min(cells / of_column);
        self.first_element = first_element;
        self.active = self.active.start.saturating_sub(shift)..self.active.end.saturating_sub(shift);
        let shift = shift * of_column;
        let range = self.active.start * of_column..self.active.end * of_column;
        let matrix = self.rule.runge_kutta().map_or([[1.0; 3]; 3], |rule| rule.matrix());
        let Self { coarse, between, fine, coarse_product, of_coarse: [whole, first, second], .. } = self;
        // 1. Coarse cells.
        whole.fill(0.0);
        coarse.add_displacement(stage, first_element, whole.as_chunks_mut().0, meter);
        // 2. What short waves remember.
        let [e, displacement] = &mut self.single;
        e.fill(0.0);
        for ([state, begin, slope], [kappa, tau]) in self.states.iter_mut().zip(&self.creep) {
            if shift > 0 {
                state.copy_within(shift.., 0);
                state[cells - shift..].fill(0.0);
            }
            begin.fill(0.0);
            let factor = (kappa / (1.0 + matrix[0][0] * self.time_step / tau)) as f32;
            let (begin, state, slope) = (&mut begin[range.clone()], &state[range.clone()], &slope[range.clone()]);
            if stage > 0 {
                let before = matrix[1][0] as f32;
                begin
                    .iter_mut()
                    .zip(state)
                    .zip(slope)
                    .for_each(|((begin, state), slope)| *begin = state + before * slope);
            } else {
                begin.copy_from_slice(state);
            }
            e[range.clone()].iter_mut().zip(&*begin).for_each(|(e, begin)| *e += factor * begin);
        }
        if !range.is_empty() {
            let (refine, columns) = (between.refine, fine.columns());
            let start = self.active.start.saturating_sub(AROUND) * refine;
            let needed = ((self.active.end + AROUND) * refine).min(columns) - start;
            let length = fine.part(needed);
            let start = start.min(columns - length);
            let across = fine.across();
            let part = start * across..(start + length) * across;
            fine.single_displacement(&e[part.clone()], &mut displacement[part.clone()]);
            out[part.clone()].iter_mut().zip(&displacement[part]).for_each(|(out, u)| *out += f64::from(*u));
            between.spread(e, first);
            coarse_product.displacement(first, second);
            whole.iter_mut().zip(&*second).for_each(|(whole, u)| *whole -= u);
        }
        between.add_interpolated(whole, out);
    }

    fn push(&mut self, stage: usize, first_element: i64, forces: &[[f64; 1]]) -> bool {
        let forces = forces.as_flattened();
        let of_column = self.of_column();
        let columns = forces.len() / of_column;
        let is_touched = |force: &f64| *force > 0.0;
        if let (Some(first), Some(last)) = (forces.iter().position(is_touched), forces.iter().rposition(is_touched)) {
            let next = (first / of_column).saturating_sub(AROUND)..(last / of_column + 1 + AROUND).min(columns);
            let cells = |columns: Range<usize>| columns.start * of_column..columns.end.max(columns.start) * of_column;
            for [state, ..] in &mut self.states {
                state[cells(0..next.start)].fill(0.0);
                state[cells(next.end..columns)].fill(0.0);
            }
            self.active = next;
        }
        let range = self.active.start * of_column..self.active.end * of_column;
        let matrix = self.rule.runge_kutta().map_or([[1.0; 3]; 3], |rule| rule.matrix());
        let is_last = stage + 1 == self.rule.stages();
        for ([state, begin, slope], [_, tau]) in self.states.iter_mut().zip(&self.creep) {
            let per_step = (self.time_step / tau) as f32;
            let q = matrix[0][0] as f32 * per_step;
            let inverse = (1.0 + q).recip();
            let (state, begin, slope) = (&mut state[range.clone()], &begin[range.clone()], &mut slope[range.clone()]);
            let forces = &forces[range.clone()];
            if is_last {
                for ((state, begin), force) in state.iter_mut().zip(begin).zip(forces) {
                    let now = (begin + q * *force as f32) * inverse;
                    *state = if now.abs() > 1e-12 { now } else { 0.0 };
                }
            } else {
                for ((slope, begin), force) in slope.iter_mut().zip(begin).zip(forces) {
                    let force = *force as f32;
                    *slope = per_step * (force - (begin + q * force) * inverse);
                }
            }
        }
        let [coarse, ..] = &mut self.of_coarse;
        self.between.spread(forces, coarse);
        self.coarse.push(stage, first_element, coarse.as_chunks().0)
    }
}

/// The sub-cells of a window, column by column.
pub(crate) struct TwoScaleZone {
    refine: usize,
    /// Coarse cells across.
    across: usize,
    margin: usize,
    tread: TreadSurface,
    history: TwoScaleHistory,
    search: CellSearch,
    forces: Vec<f64>,
    first_element: i64,
    required: Vec<f64>,
    old: Vec<f64>,
    /// Forces, required and found displacements of coarse cells.
    coarse: [Vec<f64>; 3],
}

impl TwoScaleZone {
    pub(crate) fn new(
        instant: InstantCells,
        tread: TreadSurface,
        history: TwoScaleHistory,
        tolerance: f64,
        margin: usize,
    ) -> Self {
        let (cells, refine, across) = (instant.cells(), history.between.refine, history.between.across);
        let zeros = || vec![0.0; cells / (refine * refine)];
        Self {
            refine,
            across,
            margin,
            tread,
            history,
            search: CellSearch::new(instant, tolerance),
            forces: vec![0.0; cells],
            first_element: i64::MIN,
            required: vec![0.0; cells],
            old: vec![0.0; cells],
            coarse: [zeros(), zeros(), zeros()],
        }
    }
}

impl ContactZone for TwoScaleZone {
    fn solve(
        &mut self,
        at: Instant<'_>,
        road: &RoadStrip,
        mut output: StageMut<'_>,
        meter: &mut Meter,
    ) -> Result<Solved, ContactError> {
        let Instant { step, stage, first_element, indentation, rises } = at;
        let (refine, cells) = (self.refine, self.forces.len());
        let width = self.across * refine;
        let columns = cells / (width * refine);
        let mut laps = meter.laps();
        self.old.fill(0.0);
        self.history.add_displacement(stage, first_element, self.old.as_chunks_mut().0, meter);
        meter.lap(&mut laps, Stage::History);
        let crown = self.tread.row(0);
        for (column, (required, old)) in
            self.required.chunks_exact_mut(width * refine).zip(self.old.chunks_exact(width * refine)).enumerate()
        {
            let Some(heights) = road.heights(first_element + column as i64) else {
                required.fill(f64::NEG_INFINITY);
                continue;
            };
            // The circle between columns, as a parabola.
            let middle = column.clamp(1, columns - 2);
            let [before, here, after] = [rises[middle - 1], rises[middle], rises[middle + 1]];
            let rows = required.chunks_exact_mut(width).zip(old.chunks_exact(width)).zip(heights.chunks_exact(width));
            for (sub, ((required, old), heights)) in rows.enumerate() {
                let x = column as f64 - middle as f64 + place(refine, sub);
                let rise = here + 0.5 * x * (after - before) + 0.5 * x * x * (after - 2.0 * here + before);
                for (((required, old), height), crown) in required.iter_mut().zip(old).zip(heights).zip(crown) {
                    *required = indentation - rise - crown + height - old;
                }
            }
        }
        meter.add_work(Stage::Penetration, Work { multiply_adds: 4 * cells as u64, bytes: 40 * cells as u64 });
        meter.lap(&mut laps, Stage::Penetration);
        let shift = usize::try_from(first_element.saturating_sub(self.first_element)).unwrap_or(usize::MAX);
        let shift = shift.saturating_mul(width * refine).min(cells);
        if self.forces[..shift].iter().all(|force| *force <= 0.0) {
            self.search.advance(shift);
        }
        if shift > 0 {
            self.forces.copy_within(shift.., 0);
            self.forces[cells - shift..].fill(0.0);
        }
        self.first_element = first_element;
        let relative = self.search.solve(&self.required, &mut self.forces);
        if self.search.is_unsettled() {
            let points = self.forces.iter().filter(|force| **force > 0.0).count();
            return Err(ContactError::Unsettled { points, step });
        }
        let largest_displacement = largest_or_zero(&self.required);
        let largest_force = largest_or_zero(&self.forces);
        meter.lap(&mut laps, Stage::ActiveSet);
        let is_seen = self.history.push(stage, first_element, self.forces.as_chunks().0);
        meter.lap(&mut laps, Stage::History);
        // Coarse cells are reported.
        let (old, u) = (&self.old, self.search.displacement());
        let [forces, required, found] = &mut self.coarse;
        forces.fill(0.0);
        required.fill(0.0);
        found.fill(0.0);
        let mean = 1.0 / (refine * refine) as f64;
        for (cell, force) in self.forces.iter().enumerate() {
            let coarse = cell / (width * refine) * self.across + cell % width / refine;
            forces[coarse] += force;
            required[coarse] += mean * self.required[cell];
            found[coarse] += mean * (old[cell] + u[cell]);
        }
        let outside = self.margin * self.across;
        output.write(outside..forces.len() - outside, self.across, forces, required, |cell| found[cell]);
        let is_touched = |column: Option<&[f64]>| column.is_some_and(|cells| cells.iter().any(|&force| force > 0.0));
        let mut ends = forces.chunks_exact(self.across);
        let is_at_end = is_touched(ends.next()) || is_touched(ends.next_back()) || !is_seen;
        let residuals = Residuals {
            tension: relative.tension * largest_force,
            penetration: relative.penetration * largest_displacement,
            complementarity: relative.complementarity * largest_displacement * largest_force,
        };
        let has_no_nan = self.required.iter().all(|required| !required.is_nan());
        Ok(Solved { residuals, largest_force, largest_displacement, has_no_nan, is_at_end })
    }

    fn across(&self) -> usize {
        self.across
    }

    fn margin(&self) -> usize {
        self.margin
    }

    fn is_widened(&self) -> bool {
        true
    }

    fn first_weights(&self) -> &[f64] {
        self.search.cells().free_field()
    }

    fn search_counts(&self) -> SearchCounts {
        let CellCounts { iterations, fallbacks, work, .. } = self.search.counts();
        SearchCounts { solves: iterations, fallbacks, work, ..SearchCounts::default() }
    }
}

impl Evolving for TwoScaleZone {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        self.history.state(state)
    }
}
