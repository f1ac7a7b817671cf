//! One pole under a time rule: the recursion that convolution quadrature is for H_n(s) = R/(s - lambda).
//!
//! With b = R a for a' = lambda a + F, and with g, w depending on pole, rule and time step only:
//!
//! | rule | b_l | g | w |
//! |---|---|---|---|
//! | bdf1 | g b_(l-1) + w F_l | 1/(1 - lambda dt) | R dt/(1 - lambda dt) |
//! | bdf2 | g (b_(l-1) - b_(l-2)/4) + w F_l | 2/(3/2 - lambda dt) | R dt/(3/2 - lambda dt) |
//! | trapezoidal | g b_(l-1) + w (F_l + F_(l-1)) | (2 + lambda dt)/(2 - lambda dt) | R dt/(2 - lambda dt) |
//! | sdirk2, sdirk3, stage i | g base_i + w F_i | 1/(1 - gamma lambda dt) | g R gamma dt |
//! | first-order-hold | g b_(l-1) + v F_(l-1) + w F_l | exp(lambda dt) | see [`FirstOrderHold`] |
//!
//! base_i is a fixed sum of b at the step's beginning and of the earlier stages ([`crate::scene::RungeKutta::bases`]); the last stage is the step's end. The first-order hold
//! steps as bdf1 with last step's force weighted w + v/g instead of w.
//!
//! Forces of a wavenumber are complex: their real and imaginary parts drive two real systems with the same conjugate-symmetric poles, so that a pair is stored once and
//! u = 2 Re b. An *instant* is a time at which forces are solved for: a step, or a stage of a Runge-Kutta rule.

use num_complex::Complex64;
use pulp::{Scalar, Simd};

use super::transfer::FirstOrderHold;
use crate::scene::TimeRule;

/// g and w of a pole; w carries the factor 2 of a pair if the residue does.
pub fn coefficients(rule: TimeRule, pole: Complex64, residue: Complex64, time_step: f64) -> (Complex64, Complex64) {
    let z = pole * time_step;
    let implicit = |delta: f64| {
        let inverse = (delta - z).inv();
        (inverse, inverse * residue * time_step)
    };
    match rule {
        TimeRule::Bdf1 => implicit(1.0),
        TimeRule::Bdf2 => {
            let (inverse, w) = implicit(1.5);
            (2.0 * inverse, w)
        }
        TimeRule::Trapezoidal => {
            let (inverse, w) = implicit(2.0);
            (inverse * (2.0 + z), w)
        }
        TimeRule::Sdirk2 | TimeRule::Sdirk3 => {
            let gamma = rule.runge_kutta().map_or(1.0, |rule| rule.gamma);
            let g = (1.0 - gamma * z).inv();
            (g, g * residue * time_step * gamma)
        }
        TimeRule::FirstOrderHold => {
            let hold = FirstOrderHold::new(z);
            (hold.decay, residue * time_step * (hold.today + hold.yesterday / hold.decay))
        }
    }
}

/// g and w of vectors of poles: real and imaginary parts, or of real poles the one real part.
#[derive(Clone, Copy)]
pub struct Poles<S: Simd, const PARTS: usize> {
    /// g.
    pub g: [S::f64s; PARTS],
    /// w.
    pub w: [S::f64s; PARTS],
}

/// State of vectors of poles driven by one real force, in as many parts as the poles have.
#[derive(Clone, Copy)]
pub struct State<S: Simd, const PARTS: usize> {
    /// b at the coming instant without its force.
    pub ahead: [S::f64s; PARTS],
    /// b of the step before; for a Runge-Kutta rule b at the step's beginning.
    pub behind: [S::f64s; PARTS],
    /// b of a Runge-Kutta rule's first stage: written before it is read within every step.
    pub first_stage: [S::f64s; PARTS],
}

impl<S: Simd, const PARTS: usize> State<S, PARTS> {
    /// The state at the beginning of a step.
    #[inline(always)]
    pub fn new(simd: S, ahead: [S::f64s; PARTS], behind: [S::f64s; PARTS]) -> Self {
        Self { ahead, behind, first_stage: [simd.splat_f64s(0.0); PARTS] }
    }

    /// Takes in the force of the instant: b is complete.
    #[inline(always)]
    fn add(&mut self, simd: S, poles: &Poles<S, PARTS>, force: S::f64s) {
        for (ahead, &w) in self.ahead.iter_mut().zip(&poles.w) {
            *ahead = simd.mul_add_e_f64s(w, force, *ahead);
        }
    }
}

/// How a rule goes from one instant to the next.
pub trait Recursion: Copy + Send + Sync {
    /// Whether an instant's force also drives the next one directly.
    const FORCE_LASTS: bool = false;

    /// From b complete at an instant, which `state.ahead` holds, to b at the next one without its force; `stage` is the next instant's stage.
    fn next<S: Simd, const P: usize>(self, simd: S, stage: usize, poles: &Poles<S, P>, state: &mut State<S, P>);

    /// Takes in the instant's force and goes on to the next instant.
    #[inline(always)]
    fn driven<S: Simd, const P: usize>(
        self,
        simd: S,
        stage: usize,
        poles: &Poles<S, P>,
        force: S::f64s,
        state: &mut State<S, P>,
    ) {
        state.add(simd, poles, force);
        self.next(simd, stage, poles, state);
        if Self::FORCE_LASTS {
            state.add(simd, poles, force);
        }
    }
}

/// g x. Plain loops here and below: what a closure does with vectors is only as fast as the compiler is willing to inline it.
#[inline(always)]
fn times<S: Simd, const PARTS: usize>(simd: S, g: [S::f64s; PARTS], x: [S::f64s; PARTS]) -> [S::f64s; PARTS] {
    let mut product = x;
    for part in &mut product {
        *part = simd.mul_f64s(g[0], *part);
    }
    if PARTS == 2 {
        product[0] = simd.negate_mul_add_e_f64s(g[PARTS - 1], x[PARTS - 1], product[0]);
        product[PARTS - 1] = simd.mul_add_e_f64s(g[PARTS - 1], x[0], product[PARTS - 1]);
    }
    product
}

/// b_l = g b_(l-1) + w F_l.
#[derive(Clone, Copy)]
pub struct OneStep;

impl Recursion for OneStep {
    #[inline(always)]
    fn next<S: Simd, const P: usize>(self, simd: S, _: usize, poles: &Poles<S, P>, state: &mut State<S, P>) {
        state.ahead = times(simd, poles.g, state.ahead);
    }
}

/// b_l = g b_(l-1) + w (F_l + F_(l-1)).
#[derive(Clone, Copy)]
pub struct Trapezoidal;

impl Recursion for Trapezoidal {
    const FORCE_LASTS: bool = true;

    #[inline(always)]
    fn next<S: Simd, const P: usize>(self, simd: S, stage: usize, poles: &Poles<S, P>, state: &mut State<S, P>) {
        OneStep.next(simd, stage, poles, state);
    }
}

/// b_l = g (b_(l-1) - b_(l-2)/4) + w F_l.
#[derive(Clone, Copy)]
pub struct Bdf2;

impl Recursion for Bdf2 {
    #[inline(always)]
    fn next<S: Simd, const P: usize>(self, simd: S, _: usize, poles: &Poles<S, P>, state: &mut State<S, P>) {
        let quarter = simd.splat_f64s(-0.25);
        let mut y = state.ahead;
        for (y, &behind) in y.iter_mut().zip(&state.behind) {
            *y = simd.mul_add_e_f64s(quarter, behind, *y);
        }
        state.behind = state.ahead;
        state.ahead = times(simd, poles.g, y);
    }
}

/// b_i = g base_i + w F_i, base_i a sum of b at the step's beginning and of the stages before.
#[derive(Clone, Copy)]
pub struct Stages(pub [[f64; 3]; 3]);

impl Recursion for Stages {
    #[inline(always)]
    fn next<S: Simd, const P: usize>(self, simd: S, stage: usize, poles: &Poles<S, P>, state: &mut State<S, P>) {
        let x = state.ahead;
        // The last of the base's numbers that counts belongs to the stage just done.
        let [begin, first, _] = self.0[stage];
        let latest = simd.splat_f64s(self.0[stage][stage]);
        let (begin, first) = (simd.splat_f64s(begin), simd.splat_f64s(first));
        let mut base = x;
        if stage > 0 {
            for (part, base) in base.iter_mut().enumerate() {
                *base = simd.mul_add_e_f64s(begin, state.behind[part], simd.mul_f64s(latest, *base));
                if stage > 1 {
                    *base = simd.mul_add_e_f64s(first, state.first_stage[part], *base);
                }
            }
        }
        match stage {
            0 => state.behind = x,
            1 => state.first_stage = x,
            _ => {}
        }
        state.ahead = times(simd, poles.g, base);
    }
}

/// Work to be done with a rule's recursion.
pub trait WithRecursion {
    /// Does it.
    fn with<R: Recursion>(self, recursion: R);
}

/// Does the work with the recursion of a rule.
pub fn with_recursion(rule: TimeRule, work: impl WithRecursion) {
    match (rule, rule.runge_kutta()) {
        (_, Some(method)) => work.with(Stages(method.bases())),
        (TimeRule::Bdf2, _) => work.with(Bdf2),
        (TimeRule::Trapezoidal, _) => work.with(Trapezoidal),
        _ => work.with(OneStep),
    }
}

/// Adds to `response[p - 1]` the displacement of a pole, p instants after a unit force at a stage of a step.
pub struct ImpulseResponse<'a> {
    /// g and w.
    pub pole: (Complex64, Complex64),
    /// Stages of a step.
    pub stages: usize,
    /// Stage of the force.
    pub stage: usize,
    /// By lag.
    pub response: &'a mut [f64],
}

impl WithRecursion for ImpulseResponse<'_> {
    fn with<R: Recursion>(self, recursion: R) {
        let (g, w) = self.pole;
        let poles = Poles::<Scalar, 2> { g: [g.re, g.im], w: [w.re, w.im] };
        let mut state = State::new(Scalar, [0.0; 2], [0.0; 2]);
        for (lag, value) in self.response.iter_mut().enumerate() {
            let next = (self.stage + lag + 1) % self.stages;
            if lag == 0 {
                recursion.driven(Scalar, next, &poles, 1.0, &mut state);
            } else {
                recursion.next(Scalar, next, &poles, &mut state);
            }
            *value += state.ahead[0];
        }
    }
}
