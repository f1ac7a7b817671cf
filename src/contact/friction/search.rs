//! Forces of an instant: which cells are open, stick or slip.
//!
//! 1. From the guess, semismooth Newton steps (Alart & Curnier 1991, *Comput. Methods Appl. Mech. Engrg.* 92, 353) on
//!    all three components together: states of the cells, their linear equations (module `linear`), the nearest
//!    feasible forces, u = G F. Each step is solved only as exactly as is of use; only columns that may touch are
//!    considered, and a few beside them;
//! 2. the end, if all conditions are met on the whole window; else steps go on with all of it;
//! 3. where a few steps do not make the best result better, sweeps from cell to cell (module `sweeps`) come before the
//!    next steps; uses are counted;
//! 4. an instant that has no end after [`MOST_ROUNDS`] of these is unsettled, and is reported so.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::conditions::{Conditions, length};
use super::linear::Equations;
use super::product::{Vector, WindowProduct};
use super::sweeps::sweep;
use crate::counters::Work;
use crate::storage::state::{Evolving, StateError, StateStream};
use crate::tyre::influence::TractionInfluence;

/// Newton steps without a better result before sweeps.
const PATIENCE: usize = 5;
/// Sweeps of the first round; each later one has twice as many.
const SWEEPS: usize = 8;
/// Rounds of sweeps before the search gives up.
const MOST_ROUNDS: usize = 9;
/// Most Newton steps at a time.
const MOST_STEPS: usize = 40;
/// Products that the linear equations of a step may take.
const MOST_PRODUCTS: u64 = 400;
/// Columns that are considered beside those that may touch.
const MARGIN: usize = 2;
/// Least and largest reduction of the residual of linear equations; between these it is the error of the conditions.
const FINE: f64 = 1e-4;
const COARSE: f64 = 0.1;

/// Work of a search over all instants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub(crate) struct FrictionCounts {
    /// Instants at which forces were searched for.
    pub solves: u64,
    /// Newton steps.
    pub steps: u64,
    /// Products with the influence.
    pub products: u64,
    /// Rounds of sweeps.
    pub rounds: u64,
    /// Work of all products.
    pub work: Work,
}

/// Distance from the conditions, relative to the largest force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrictionResiduals {
    /// Distance from the normal conditions.
    pub normal: f64,
    /// Distance from the tangential ones.
    pub tangential: f64,
    /// sum of mu F_z |g| + F_t.g over sum of mu F_z times the displacement by the largest force: 0 but for the error.
    pub dissipation: f64,
}

impl FrictionResiduals {
    fn worst(&self) -> f64 {
        self.normal.max(self.tangential)
    }
}

pub(crate) struct FrictionSearch {
    product: WindowProduct,
    /// Cells that are considered.
    part: Range<usize>,
    /// Influence of a cell in the middle on itself \[m/N\].
    diagonal: Vector,
    rigidity: Vector,
    tolerance: f64,
    equations: Equations,
    displacements: Vec<Vector>,
    best: Vec<Vector>,
    counts: FrictionCounts,
    is_unsettled: bool,
}

impl FrictionSearch {
    /// Search over the cells of a window. `tolerance` is how far forces may be off, relative to the largest.
    pub(crate) fn new(influence: TractionInfluence, tolerance: f64) -> Self {
        let cells = influence.cells();
        let middle = influence.columns / 2 * influence.across + influence.across / 2;
        let block = influence.block(middle, middle);
        let diagonal = [block[0][0], block[1][1], block[2][2]];
        let tangential = 1.0 / diagonal[0].max(diagonal[1]);
        Self {
            equations: Equations::new(&influence, diagonal),
            product: WindowProduct::new(influence),
            part: 0..cells,
            diagonal,
            rigidity: [tangential, tangential, 1.0 / diagonal[2]],
            tolerance,
            displacements: vec![[0.0; 3]; cells],
            best: vec![[0.0; 3]; cells],
            counts: FrictionCounts::default(),
            is_unsettled: false,
        }
    }

    /// Influence within an instant.
    pub(crate) fn influence(&self) -> &TractionInfluence {
        self.product.influence()
    }

    /// u = G F of the last solution \[m\].
    pub(crate) fn displacements(&self) -> &[Vector] {
        &self.displacements
    }

    /// True if the last search has ended without the forces.
    pub(crate) fn is_unsettled(&self) -> bool {
        self.is_unsettled
    }

    pub(crate) fn counts(&self) -> FrictionCounts {
        self.counts
    }

    /// u = G F of any forces \[m\], over the whole window.
    pub(crate) fn displace(&mut self, forces: &[Vector], out: &mut [Vector]) {
        self.counts.products += 1;
        self.product.displacement(&(0..forces.len()), forces, out);
        self.counts.work += self.product.take_work();
    }

    fn whole(&self) -> Range<usize> {
        0..self.displacements.len()
    }

    /// Part of the window that holds the cells which may touch near a guess, and a margin.
    fn near(&self, conditions: &Conditions<'_>, forces: &[Vector]) -> Range<usize> {
        let across = self.influence().across;
        let may_touch = |cell: &usize| forces[*cell][2] > 0.0 || conditions.required[*cell] > 0.0;
        let mut cells = self.whole();
        let columns = match (cells.clone().find(may_touch), cells.rfind(may_touch)) {
            (Some(first), Some(last)) => (first / across).saturating_sub(MARGIN)..last / across + 1 + MARGIN,
            _ => 0..0,
        };
        self.product.part(&columns)
    }

    /// How far forces and displacements are from the conditions.
    fn residuals(&self, conditions: &Conditions<'_>, forces: &[Vector]) -> FrictionResiduals {
        let (mut largest, mut normal, mut tangential) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut power = [0.0; 2];
        let considered = self.part.clone().zip(&forces[self.part.clone()]).zip(&self.displacements[self.part.clone()]);
        for ((cell, &force), &u) in considered {
            if conditions.required[cell] == f64::NEG_INFINITY {
                continue;
            }
            let [n, t] = conditions.missed(cell, force, u, self.rigidity);
            // A NaN stays.
            normal = if n > normal || n.is_nan() { n } else { normal };
            tangential = if t > tangential || t.is_nan() { t } else { tangential };
            largest = largest.max(force[2]);
            let slip @ [gx, gy] = conditions.slip(cell, u);
            let possible = conditions.friction[cell] * force[2] * length(slip);
            power[0] += conditions.friction[cell] * force[2];
            power[1] += possible + force[0] * gx + force[1] * gy;
        }
        let scale = if largest > 0.0 { largest } else { normal.max(f64::MIN_POSITIVE) };
        let dissipation = if power[0] > 0.0 { power[1] / (power[0] * self.diagonal[0] * largest) } else { 0.0 };
        FrictionResiduals { normal: normal / scale, tangential: tangential / scale, dissipation }
    }

    /// Finds the forces \[N\] that meet the conditions; `forces` comes in as the guess.
    pub(crate) fn solve(&mut self, conditions: &Conditions<'_>, forces: &mut [Vector]) -> FrictionResiduals {
        self.counts.solves += 1;
        self.is_unsettled = false;
        for (cell, force) in forces.iter_mut().enumerate() {
            *force = conditions.feasible(cell, *force);
        }
        self.part = self.near(conditions, forces);
        let mut best = self.evaluate(conditions, forces);
        self.best.copy_from_slice(forces);
        // True while `displacements` are those of the best forces.
        let mut is_known = true;
        for round in 0..=MOST_ROUNDS {
            let (mut waited, mut steps) = (0, 0);
            while best.worst() > self.tolerance && waited < PATIENCE && steps < MOST_STEPS {
                let now = self.newton_step(conditions, forces, best.worst());
                steps += 1;
                is_known = now.worst() < best.worst();
                if now.worst() < best.worst() {
                    if now.worst() < 0.7 * best.worst() {
                        waited = 0
                    } else {
                        waited += 1
                    };
                    best = now;
                    self.best.copy_from_slice(forces);
                } else {
                    waited += 1;
                }
            }
            forces.copy_from_slice(&self.best);
            let is_part = self.part != self.whole();
            if is_part {
                self.part = self.whole();
                best = self.evaluate(conditions, forces);
                is_known = true;
            }
            if best.worst() <= self.tolerance {
                break;
            }
            if is_part {
                continue;
            }
            if round == MOST_ROUNDS || best.worst().is_nan() {
                self.is_unsettled = true;
                break;
            }
            self.counts.rounds += 1;
            self.evaluate(conditions, forces);
            let may_touch =
                |cell: &usize| forces[*cell][2] > 0.0 || self.displacements[*cell][2] < conditions.required[*cell];
            let near: Vec<usize> = (0..forces.len()).filter(may_touch).collect();
            sweep(self.product.influence(), conditions, &near, forces, &mut self.displacements, SWEEPS << round);
            // Newton steps go on from here, better or not.
            best = self.evaluate(conditions, forces);
            self.best.copy_from_slice(forces);
            is_known = true;
        }
        if !is_known {
            self.evaluate(conditions, forces);
        }
        self.counts.work += self.product.take_work();
        best
    }

    /// Computes u = G F on the part that is considered; returns how far the conditions are missed there.
    fn evaluate(&mut self, conditions: &Conditions<'_>, forces: &[Vector]) -> FrictionResiduals {
        self.counts.products += 1;
        self.product.displacement(&self.part, forces, &mut self.displacements);
        self.residuals(conditions, forces)
    }

    /// Takes a Newton step; returns how far its forces miss the conditions.
    fn newton_step(&mut self, conditions: &Conditions<'_>, forces: &mut [Vector], missed: f64) -> FrictionResiduals {
        let (displacements, rigidity) = (&self.displacements, self.rigidity);
        let state = |cell: usize| (cell, conditions.state(cell, forces[cell], displacements[cell], rigidity));
        self.equations.set(&self.product, conditions, self.part.clone().map(state), self.diagonal);
        let largest = forces.iter().fold(0.0_f64, |largest, force| largest.max(force[2]));
        let exact = [missed.clamp(FINE, COARSE), 0.3 * self.tolerance * largest];
        let solved = self.equations.solve(&mut self.product, conditions, forces, exact, MOST_PRODUCTS);
        self.counts.products += solved.products;
        self.counts.steps += 1;
        for (cell, force) in forces.iter_mut().enumerate() {
            *force = conditions.feasible(cell, *force);
        }
        self.evaluate(conditions, forces)
    }
}

impl Evolving for FrictionSearch {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.value(&mut self.counts)
    }
}
