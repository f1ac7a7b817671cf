//! Modified proportioning with reduced gradient projections (Dostal & Schoeberl 2005, *Comput. Optim. Appl.* 30, 23).
//!
//! Minimises F.G F/2 - d.F over F >= 0. Gradient g = u - d; phi is its part where F > 0, beta its negative part where
//! F = 0. Each step is one of three: of conjugate gradients in the face F > 0; as far along as it goes and then a
//! projected one of fixed length, where such a step leaves F >= 0; or, where |beta|^2 exceeds phi's reduced product,
//! one along beta. With a length of at most 1/|G| (2/|G| would do) the error falls by a factor that the
//! condition number of G bounds, whatever the set of cells does: the method always ends.

use super::instant::InstantCells;

/// Steps without a smaller worst miss, after which rounding is taken to limit it.
const PATIENCE: u64 = 1000;

pub(super) struct Proportioning {
    gradient: Vec<f64>,
    direction: Vec<f64>,
    response: Vec<f64>,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Proportioned {
    /// Steps.
    pub iterations: u64,
    /// Products with G.
    pub products: u64,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum: f64, (a, b)| a.mul_add(*b, sum))
}

#[derive(Default)]
struct Standing {
    /// The worst miss.
    worst: f64,
    /// phi.phi.
    free: f64,
    /// phi's reduced product.
    reduced: f64,
    /// beta.beta.
    chopped: f64,
}

impl Proportioning {
    pub(super) fn new(cells: usize) -> Self {
        let zeros = || vec![0.0; cells];
        Self { gradient: zeros(), direction: zeros(), response: zeros() }
    }

    fn standing(&self, forces: &[f64], step: f64) -> Standing {
        let mut standing = Standing::default();
        for (&force, &g) in forces.iter().zip(&self.gradient) {
            if force > 0.0 {
                standing.worst = standing.worst.max(g.abs());
                standing.free += g * g;
                standing.reduced += g * (force / step).min(g);
            } else {
                standing.worst = standing.worst.max(-g);
                standing.chopped += g.min(0.0) * g.min(0.0);
            }
        }
        standing
    }

    /// Forces for `required` d, which has to be finite, to within `goal` \[m\] or what rounding allows.
    pub(super) fn run(
        &mut self,
        cells: &mut InstantCells,
        required: &[f64],
        forces: &mut [f64],
        goal: f64,
    ) -> Proportioned {
        let step = cells.norm_bound().recip();
        let mut done = Proportioned::default();
        let (mut least, mut patience) = (f64::INFINITY, PATIENCE);
        // None: u and the direction are to be restarted.
        let mut last: Option<f64> = None;
        loop {
            if last.is_none() {
                cells.symmetric_displacement(forces, &mut self.gradient);
                done.products += 1;
                self.gradient.iter_mut().zip(required).for_each(|(g, d)| *g -= d);
            }
            let Standing { worst, free, reduced, chopped } = self.standing(forces, step);
            if worst < least {
                (least, patience) = (worst, PATIENCE);
            } else {
                patience -= 1;
            }
            if worst <= goal || patience == 0 {
                // What conjugate gradients have summed up counts only after u = G F is evaluated anew.
                if last.is_none() || patience == 0 {
                    return done;
                }
                last = None;
                continue;
            }
            done.iterations += 1;
            let Self { gradient, direction, response } = self;
            if chopped > reduced {
                for (force, &g) in forces.iter_mut().zip(&*gradient).filter(|(force, _)| **force <= 0.0) {
                    *force = (-step * g).max(0.0);
                }
                last = None;
                continue;
            }
            let beta = last.map_or(0.0, |last| free / last);
            for ((t, &force), &g) in direction.iter_mut().zip(&*forces).zip(&*gradient) {
                *t = if force > 0.0 { beta.mul_add(*t, g) } else { 0.0 };
            }
            cells.symmetric_displacement(direction, response);
            done.products += 1;
            let best = dot(gradient, direction) / dot(direction, response);
            let falling = forces.iter().zip(&*direction).filter(|(force, t)| **force > 0.0 && **t > 0.0);
            let feasible = falling.fold(f64::INFINITY, |least, (force, t)| least.min(force / t));
            let length = best.min(feasible);
            for ((force, &t), (g, &q)) in forces.iter_mut().zip(&*direction).zip(gradient.iter_mut().zip(&*response)) {
                *force = (-length).mul_add(t, *force).max(0.0);
                *g = (-length).mul_add(q, *g);
            }
            last = Some(free);
            if best > feasible {
                for (force, &g) in forces.iter_mut().zip(&*gradient).filter(|(force, _)| **force > 0.0) {
                    *force = (-step).mul_add(g, *force).max(0.0);
                }
                last = None;
            }
        }
    }
}
