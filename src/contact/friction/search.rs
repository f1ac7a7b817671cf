//! Forces of an instant: which cells are open, stick or slip.
//!
//! 1. From the guess, semismooth Newton steps (Alart & Curnier 1991, *Comput. Methods Appl. Mech. Engrg.* 92, 353) on
//!    all three components together: states of the cells, their linear equations (module `linear`), the nearest
//!    feasible forces, u = G F. Each step is solved as exactly as it can be of use;
//! 2. the end, if all conditions are met;
//! 3. where a few steps do not make the best result better, sweeps from cell to cell (module `sweeps`) come before the
//!    next steps; uses are counted;
//! 4. an instant that has no end after [`MOST_ROUNDS`] of these is unsettled, and is told so.

use serde::{Deserialize, Serialize};

use super::conditions::{Conditions, State};
use super::linear::Equations;
use super::product::{TractionProduct, Vector};
use super::sweeps::sweep;
use crate::counters::Work;
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
/// Least and largest reduction of the residual of linear equations; between these it is what is missed.
const FINE: f64 = 1e-4;
const COARSE: f64 = 0.1;

/// Work of a search over all instants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub(crate) struct FrictionCounts {
    /// Instants at which forces were sought.
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
    /// sum of mu F_z |g| + F_t.g over sum of mu F_z times the displacement by the largest force: 0 but for what is
    /// missed.
    pub dissipation: f64,
}

impl FrictionResiduals {
    fn worst(&self) -> f64 {
        self.normal.max(self.tangential)
    }
}

/// Search with its room.
pub(crate) struct FrictionSearch {
    influence: TractionInfluence,
    product: TractionProduct,
    /// Influence of a cell in the middle on itself \[m/N\].
    own: Vector,
    rigidity: Vector,
    tolerance: f64,
    equations: Equations,
    displacements: Vec<Vector>,
    best: Vec<Vector>,
    counts: FrictionCounts,
    is_unsettled: bool,
}

impl FrictionSearch {
    /// Makes a search over the cells of a window. `tolerance` is how far forces may be off, relative to the largest.
    pub(crate) fn new(influence: TractionInfluence, tolerance: f64) -> Self {
        let cells = influence.cells();
        let middle = influence.columns / 2 * influence.across + influence.across / 2;
        let block = influence.block(middle, middle);
        let own = [block[0][0], block[1][1], block[2][2]];
        let tangential = 1.0 / own[0].max(own[1]);
        let product = TractionProduct::new(&influence);
        Self {
            equations: Equations::new(&influence, &product, own),
            product,
            influence,
            own,
            rigidity: [tangential, tangential, 1.0 / own[2]],
            tolerance,
            displacements: vec![[0.0; 3]; cells],
            best: vec![[0.0; 3]; cells],
            counts: FrictionCounts::default(),
            is_unsettled: false,
        }
    }

    /// Returns the influence within an instant.
    pub(crate) fn influence(&self) -> &TractionInfluence {
        &self.influence
    }

    /// Returns u = G F of the last solution \[m\].
    pub(crate) fn displacements(&self) -> &[Vector] {
        &self.displacements
    }

    /// Tells whether the last search has ended without the forces.
    pub(crate) fn is_unsettled(&self) -> bool {
        self.is_unsettled
    }

    /// Returns the work counts so far.
    pub(crate) fn counts(&self) -> FrictionCounts {
        self.counts
    }

    /// Goes on from the counts of an equal search.
    pub(crate) fn set_counts(&mut self, counts: FrictionCounts) {
        self.counts = counts;
    }

    /// Finds u = G F of any forces \[m\].
    pub(crate) fn displace(&mut self, forces: &[Vector], out: &mut [Vector]) {
        self.counts.products += 1;
        self.counts.work += self.product.work();
        self.product.displacement(forces, out);
    }

    /// Tells how far forces and displacements are from the conditions.
    fn residuals(&self, conditions: &Conditions<'_>, forces: &[Vector]) -> FrictionResiduals {
        let (mut largest, mut normal, mut tangential) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut power = [0.0; 2];
        for (cell, (&force, &u)) in forces.iter().zip(&self.displacements).enumerate() {
            if conditions.required[cell] == f64::NEG_INFINITY {
                continue;
            }
            let [n, t] = conditions.missed(cell, force, u, self.rigidity);
            // A number that is none stays.
            normal = if n > normal || n.is_nan() { n } else { normal };
            tangential = if t > tangential || t.is_nan() { t } else { tangential };
            largest = largest.max(force[2]);
            let [gx, gy] = conditions.slip(cell, u);
            let possible = conditions.friction[cell] * force[2] * gx.hypot(gy);
            power[0] += conditions.friction[cell] * force[2];
            power[1] += possible + force[0] * gx + force[1] * gy;
        }
        let scale = if largest > 0.0 { largest } else { normal.max(f64::MIN_POSITIVE) };
        let dissipation = if power[0] > 0.0 { power[1] / (power[0] * self.own[0] * largest) } else { 0.0 };
        FrictionResiduals { normal: normal / scale, tangential: tangential / scale, dissipation }
    }

    /// Finds the forces that meet the conditions; `forces` comes in as the guess.
    pub(crate) fn solve(&mut self, conditions: &Conditions<'_>, forces: &mut [Vector]) -> FrictionResiduals {
        self.counts.solves += 1;
        self.is_unsettled = false;
        for (cell, force) in forces.iter_mut().enumerate() {
            *force = conditions.feasible(cell, *force);
        }
        self.look(forces);
        let mut best = self.residuals(conditions, forces);
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
            if best.worst() <= self.tolerance {
                break;
            }
            if round == MOST_ROUNDS || best.worst().is_nan() {
                self.is_unsettled = true;
                break;
            }
            self.counts.rounds += 1;
            self.look(forces);
            let may_touch =
                |cell: &usize| forces[*cell][2] > 0.0 || self.displacements[*cell][2] < conditions.required[*cell];
            let near: Vec<usize> = (0..forces.len()).filter(may_touch).collect();
            sweep(&self.influence, conditions, &near, forces, &mut self.displacements, SWEEPS << round);
            self.look(forces);
            // Newton steps go on from here, better or not.
            best = self.residuals(conditions, forces);
            self.best.copy_from_slice(forces);
            is_known = true;
        }
        if !is_known {
            self.look(forces);
        }
        best
    }

    /// Finds u = G F.
    fn look(&mut self, forces: &[Vector]) {
        self.counts.products += 1;
        self.counts.work += self.product.work();
        self.product.displacement(forces, &mut self.displacements);
    }

    /// Takes a Newton step; returns how far its forces miss the conditions.
    fn newton_step(&mut self, conditions: &Conditions<'_>, forces: &mut [Vector], missed: f64) -> FrictionResiduals {
        let (displacements, rigidity) = (&self.displacements, self.rigidity);
        let state =
            |(cell, (&force, &u)): (usize, (&Vector, &Vector))| -> State { conditions.state(cell, force, u, rigidity) };
        let states = forces.iter().zip(displacements).enumerate().map(state);
        self.equations.set(&self.influence, conditions, states, self.own);
        let largest = forces.iter().fold(0.0_f64, |largest, force| largest.max(force[2]));
        let exact = [missed.clamp(FINE, COARSE), 0.3 * self.tolerance * largest];
        let solved = self.equations.solve(conditions, forces, exact, MOST_PRODUCTS);
        self.counts.products += solved.products;
        self.counts.steps += 1;
        self.counts.work += self.equations.take_work();
        for (cell, force) in forces.iter_mut().enumerate() {
            *force = conditions.feasible(cell, *force);
        }
        self.look(forces);
        self.residuals(conditions, forces)
    }
}
