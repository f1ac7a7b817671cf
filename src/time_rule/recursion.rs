//! One pole under a time rule: the recursion to which convolution quadrature reduces for H_n(s) = R/(s - lambda).
//!
//! With b = R a for a' = lambda a + F, and with g, w depending on pole, rule and time step only:
//!
//! | rule | b_l | g | w |
//! |---|---|---|---|
//! | bdf1 | g b_(l-1) + w F_l | 1/(1 - lambda dt) | R dt/(1 - lambda dt) |
//! | bdf2 | g (b_(l-1) - b_(l-2)/4) + w F_l | 2/(3/2 - lambda dt) | R dt/(3/2 - lambda dt) |
//! | sdirk2, sdirk3, stage i | g base_i + w F_i | 1/(1 - gamma lambda dt) | g R gamma dt |
//!
//! base_i is a fixed sum of b at the step's beginning and of the earlier stages ([`super::RungeKutta::bases`]);
//! the last stage is the step's end.
//!
//! A step is one linear map of b, whatever its stages: b at its end is R b + sum of W_i F_i, and u_old at the instant
//! of stage i, as if the step had no forces, Re(A_i b). R, W_i and A_i follow from g and w; [`Recursion`] goes through
//! blocks of steps with them. What the forces of a step do within the step and later, instant by instant, is the table
//! itself: [`TimeRule::impulse_response`].
//!
//! Forces of a wavenumber are complex: their real and imaginary parts drive two real systems with the same
//! conjugate-symmetric poles, so that a pair is stored once and u = 2 Re b. An *instant* is a time at which forces are
//! solved for: a step, or a stage of a Runge-Kutta rule.
//!
//! With rotation, H_n = E_n + i O_n, the odd part O_n has the same poles and other residues: R' = q R. Its
//! displacements are Re(q b) over the states of E_n, [`Recursion::predict_both`], and go from one system to the
//! other: Re u = E Re F - O Im F, Im u = E Im F + O Re F.

#![expect(clippy::needless_range_loop, reason = "an iterator over vectors costs a call wherever it is not inlined")]

use num_complex::Complex64;
use pulp::{Scalar, Simd};

use super::TimeRule;
use crate::numeric::Element;

/// Most stages of any rule.
pub(crate) const MOST_STAGES: usize = 3;
/// Part of b_(l-2) that bdf2 takes from b_(l-1).
const BEFORE_LAST: f64 = 0.25;

/// One number per lane: real and imaginary part, or of real poles the real part alone.
pub(crate) type Number<E, S, const PARTS: usize> = [<E as Element>::Vector<S>; PARTS];

/// g and w of vectors of poles.
#[derive(Clone, Copy)]
pub(crate) struct Poles<E: Element, S: Simd, const PARTS: usize> {
    /// g.
    pub g: Number<E, S, PARTS>,
    /// w.
    pub w: Number<E, S, PARTS>,
}

/// State of vectors of poles driven by one real force.
#[derive(Clone, Copy)]
pub(crate) struct PoleState<E: Element, S: Simd, const PARTS: usize> {
    /// b at the end of the last step.
    pub end: Number<E, S, PARTS>,
    /// b at its beginning, for a rule that [looks back](Recursion::LOOKS_BACK).
    pub before: Number<E, S, PARTS>,
}

/// Maps of a pole over a step, see the module.
#[derive(Clone, Copy)]
pub(crate) struct StepMaps<E: Element, S: Simd, const PARTS: usize> {
    /// R.
    whole: Number<E, S, PARTS>,
    /// W of every instant: what a unit force there adds to b at the step's end.
    inputs: [Number<E, S, PARTS>; MOST_STAGES],
    /// A of every instant; the last stage ends the step, its A is R.
    outputs: [Number<E, S, PARTS>; MOST_STAGES],
}

impl<E: Element, S: Simd, const PARTS: usize> StepMaps<E, S, PARTS> {
    #[inline(always)]
    fn of_one(Poles { g, w }: Poles<E, S, PARTS>) -> Self {
        Self { whole: g, inputs: [w; MOST_STAGES], outputs: [g; MOST_STAGES] }
    }
}

/// One value per instant of a step.
pub(crate) type Instants<E, S> = [<E as Element>::Vector<S>; MOST_STAGES];

/// How a rule goes from one step to the next.
pub(crate) trait Recursion: Copy + Send + Sync {
    /// Instants of a step, [`MOST_STAGES`] at most.
    const STAGES: usize;
    /// True if the recursion needs b of two steps.
    const LOOKS_BACK: bool = false;

    /// Maps of a step from g and w.
    fn maps<E: Element, S: Simd, const P: usize>(self, simd: S, poles: Poles<E, S, P>) -> StepMaps<E, S, P>;

    /// Advances the state by a step without forces; returns Re b at its instants.
    fn predict<E: Element, S: Simd, const P: usize>(
        simd: S,
        maps: &StepMaps<E, S, P>,
        state: &mut PoleState<E, S, P>,
    ) -> Instants<E, S>;

    /// Factors of an odd part at every instant, from q: its displacement is the real part of their product with the
    /// state at which [`Self::predict_both`] takes it.
    #[inline(always)]
    fn odd_outputs<E: Element, S: Simd, const P: usize>(
        _: S,
        _: &StepMaps<E, S, P>,
        q: Number<E, S, P>,
    ) -> [Number<E, S, P>; MOST_STAGES] {
        [q; MOST_STAGES]
    }

    /// As [`Self::predict`], but returns Re b, then Re(q b).
    #[inline(always)]
    fn predict_both<E: Element, S: Simd, const P: usize>(
        simd: S,
        maps: &StepMaps<E, S, P>,
        odd: &[Number<E, S, P>; MOST_STAGES],
        state: &mut PoleState<E, S, P>,
    ) -> [Instants<E, S>; 2] {
        let even = Self::predict(simd, maps, state);
        [even, [real_part::<E, _, _>(simd, odd[0], state.end); MOST_STAGES]]
    }

    /// Advances both states by `steps` steps without forces.
    #[inline(always)]
    fn skip<E: Element, S: Simd, const P: usize>(
        simd: S,
        maps: &StepMaps<E, S, P>,
        states: [&mut PoleState<E, S, P>; 2],
        steps: usize,
    ) {
        for state in states {
            for _ in 0..steps {
                Self::predict(simd, maps, state);
            }
        }
    }

    /// Advances the state by a step with forces.
    #[inline(always)]
    fn take_in<E: Element, S: Simd, const P: usize>(
        simd: S,
        maps: &StepMaps<E, S, P>,
        forces: Instants<E, S>,
        state: &mut PoleState<E, S, P>,
    ) {
        Self::predict(simd, maps, state);
        for stage in 0..Self::STAGES {
            add::<E, _, _>(simd, forces[stage], maps.inputs[stage], &mut state.end);
        }
    }
}

/// g x. Plain loops here and below: what a closure does with vectors is only as fast as the compiler is willing to
/// inline it.
#[inline(always)]
fn times<E: Element, S: Simd, const PARTS: usize>(
    simd: S,
    g: Number<E, S, PARTS>,
    x: Number<E, S, PARTS>,
) -> Number<E, S, PARTS> {
    let mut product = x;
    for part in &mut product {
        *part = E::mul(simd, g[0], *part);
    }
    if PARTS == 2 {
        product[0] = E::negate_mul_add(simd, g[PARTS - 1], x[PARTS - 1], product[0]);
        product[PARTS - 1] = E::mul_add(simd, g[PARTS - 1], x[0], product[PARTS - 1]);
    }
    product
}

#[inline(always)]
fn real_part<E: Element, S: Simd, const PARTS: usize>(
    simd: S,
    g: Number<E, S, PARTS>,
    x: Number<E, S, PARTS>,
) -> E::Vector<S> {
    let product = E::mul(simd, g[0], x[0]);
    if PARTS == 2 { E::negate_mul_add(simd, g[PARTS - 1], x[PARTS - 1], product) } else { product }
}

/// y += factor x.
#[inline(always)]
fn add<E: Element, S: Simd, const PARTS: usize>(
    simd: S,
    factor: E::Vector<S>,
    x: Number<E, S, PARTS>,
    y: &mut Number<E, S, PARTS>,
) {
    for part in 0..PARTS {
        y[part] = E::mul_add(simd, factor, x[part], y[part]);
    }
}

/// b_l = g (b_(l-1) - b_(l-2)/4) + w F_l.
#[derive(Clone, Copy)]
pub(crate) struct Bdf2;

impl Recursion for Bdf2 {
    const STAGES: usize = 1;
    const LOOKS_BACK: bool = true;

    #[inline(always)]
    fn maps<E: Element, S: Simd, const P: usize>(self, _: S, poles: Poles<E, S, P>) -> StepMaps<E, S, P> {
        StepMaps::of_one(poles)
    }

    #[inline(always)]
    fn predict<E: Element, S: Simd, const P: usize>(
        simd: S,
        maps: &StepMaps<E, S, P>,
        state: &mut PoleState<E, S, P>,
    ) -> Instants<E, S> {
        let mut y = state.end;
        add::<E, _, _>(simd, E::splat(simd, E::rounded(-BEFORE_LAST)), state.before, &mut y);
        state.before = state.end;
        state.end = times::<E, _, _>(simd, maps.whole, y);
        [state.end[0]; MOST_STAGES]
    }
}

/// b_i = g base_i + w F_i, base_i a sum of b at the step's beginning and of the stages before; with one stage b_l = g
/// b_(l-1) + w F_l. Holds the coefficients of the bases.
#[derive(Clone, Copy)]
pub(crate) struct Stages<const COUNT: usize>(pub [[f64; 3]; 3]);

impl<const COUNT: usize> Recursion for Stages<COUNT> {
    const STAGES: usize = COUNT;

    #[inline(always)]
    fn maps<E: Element, S: Simd, const P: usize>(self, simd: S, poles: Poles<E, S, P>) -> StepMaps<E, S, P> {
        let mut outputs = [poles.g; MOST_STAGES];
        let mut inputs = [poles.w; MOST_STAGES];
        // 1. A_i = g base_i for b = 1 at the step's beginning.
        for stage in 1..COUNT {
            let mut base = [E::splat(simd, E::rounded(0.0)); P];
            base[0] = E::splat(simd, E::rounded(self.0[stage][0]));
            let (earlier, later) = outputs.split_at_mut(stage);
            for (&output, &part) in earlier.iter().zip(&self.0[stage][1..]) {
                add::<E, _, _>(simd, E::splat(simd, E::rounded(part)), output, &mut base);
            }
            later[0] = times::<E, _, _>(simd, poles.g, base);
        }
        // 2. W_i: b at the last stage after a unit force at stage i, w there, g base in the stages after it.
        for (force, input) in inputs.iter_mut().enumerate().take(COUNT) {
            let mut stages = [poles.w; MOST_STAGES];
            for stage in force + 1..COUNT {
                let mut base = [E::splat(simd, E::rounded(0.0)); P];
                let (earlier, later) = stages.split_at_mut(stage);
                for (&b, &part) in earlier.iter().zip(&self.0[stage][1..]).skip(force) {
                    add::<E, _, _>(simd, E::splat(simd, E::rounded(part)), b, &mut base);
                }
                later[0] = times::<E, _, _>(simd, poles.g, base);
            }
            *input = stages[COUNT - 1];
        }
        StepMaps { whole: outputs[COUNT - 1], inputs, outputs }
    }

    #[inline(always)]
    fn predict<E: Element, S: Simd, const P: usize>(
        simd: S,
        maps: &StepMaps<E, S, P>,
        state: &mut PoleState<E, S, P>,
    ) -> Instants<E, S> {
        let mut displaced = [state.end[0]; MOST_STAGES];
        for stage in 0..COUNT - 1 {
            displaced[stage] = real_part::<E, _, _>(simd, maps.outputs[stage], state.end);
        }
        state.end = times::<E, _, _>(simd, maps.whole, state.end);
        displaced[COUNT - 1] = state.end[0];
        displaced
    }

    /// q A of the stages, for the step's beginning; q for its end.
    #[inline(always)]
    fn odd_outputs<E: Element, S: Simd, const P: usize>(
        simd: S,
        maps: &StepMaps<E, S, P>,
        q: Number<E, S, P>,
    ) -> [Number<E, S, P>; MOST_STAGES] {
        let mut outputs = [q; MOST_STAGES];
        for stage in 0..COUNT - 1 {
            outputs[stage] = times::<E, _, _>(simd, q, maps.outputs[stage]);
        }
        outputs
    }

    #[inline(always)]
    fn predict_both<E: Element, S: Simd, const P: usize>(
        simd: S,
        maps: &StepMaps<E, S, P>,
        odd: &[Number<E, S, P>; MOST_STAGES],
        state: &mut PoleState<E, S, P>,
    ) -> [Instants<E, S>; 2] {
        let mut displaced = [state.end[0]; MOST_STAGES];
        for stage in 0..COUNT - 1 {
            displaced[stage] = real_part::<E, _, _>(simd, odd[stage], state.end);
        }
        let even = Self::predict(simd, maps, state);
        displaced[COUNT - 1] = real_part::<E, _, _>(simd, odd[COUNT - 1], state.end);
        [even, displaced]
    }

    /// Applies R^`steps`, by repeated squaring.
    #[inline(always)]
    fn skip<E: Element, S: Simd, const P: usize>(
        simd: S,
        maps: &StepMaps<E, S, P>,
        [re, im]: [&mut PoleState<E, S, P>; 2],
        steps: usize,
    ) {
        let (mut square, mut remaining) = (maps.whole, steps);
        while remaining > 0 {
            if remaining % 2 == 1 {
                (re.end, im.end) = (times::<E, _, _>(simd, square, re.end), times::<E, _, _>(simd, square, im.end));
            }
            remaining /= 2;
            if remaining > 0 {
                square = times::<E, _, _>(simd, square, square);
            }
        }
    }
}

/// Maps of one pole over a step: b at its end is `whole` b + sum of `inputs` F, u_old at its instants Re(`outputs` b).
pub(crate) struct StepMap {
    /// R: b at the step's end per b at its beginning.
    pub whole: Complex64,
    /// W by instant.
    pub inputs: [Complex64; MOST_STAGES],
    /// A by instant.
    pub outputs: [Complex64; MOST_STAGES],
}

/// [`StepMap`] of g and w.
struct OfPole(Complex64, Complex64);

impl WithRecursion for OfPole {
    type Output = StepMap;

    fn with<R: Recursion>(self, recursion: R) -> StepMap {
        let Self(g, w) = self;
        let poles = Poles::<f64, Scalar, 2> { g: [g.re, g.im], w: [w.re, w.im] };
        let StepMaps { whole, inputs, outputs } = recursion.maps(Scalar::new(), poles);
        let number = |[re, im]: [f64; 2]| Complex64::new(re, im);
        StepMap { whole: number(whole), inputs: inputs.map(number), outputs: outputs.map(number) }
    }
}

/// Work to be done with a rule's recursion.
pub(crate) trait WithRecursion {
    /// Result of the work.
    type Output;

    fn with<R: Recursion>(self, recursion: R) -> Self::Output;
}

impl TimeRule {
    /// g and w of a pole; w carries the factor 2 of a pair if the residue does.
    pub(crate) fn coefficients(self, pole: Complex64, residue: Complex64, time_step: f64) -> (Complex64, Complex64) {
        let z = pole * time_step;
        let implicit = |delta: f64| {
            let inverse = (delta - z).inv();
            (inverse, inverse * residue * time_step)
        };
        match self {
            Self::Bdf1 => implicit(1.0),
            Self::Bdf2 => {
                let (inverse, w) = implicit(1.5);
                (2.0 * inverse, w)
            }
            Self::Sdirk2 | Self::Sdirk3 => {
                let gamma = self.runge_kutta().map_or(1.0, |rule| rule.gamma);
                let g = (1.0 - gamma * z).inv();
                (g, g * residue * time_step * gamma)
            }
        }
    }

    /// Maps of a pole of unit residue over a step; `None` for a rule whose state is not b at the step's end.
    pub(crate) fn step_map(self, pole: Complex64, time_step: f64) -> Option<StepMap> {
        if self.looks_back() {
            return None;
        }
        let (g, w) = self.coefficients(pole, Complex64::ONE, time_step);
        Some(self.with_recursion(OfPole(g, w)))
    }

    /// Does the work with the rule's recursion. Every rule is named: a new one does not fall to the stages of another.
    pub(crate) fn with_recursion<W: WithRecursion>(self, work: W) -> W::Output {
        match self {
            Self::Sdirk2 => work.with(Stages::<2>(self.bases())),
            Self::Sdirk3 => work.with(Stages::<3>(self.bases())),
            Self::Bdf2 => work.with(Bdf2),
            Self::Bdf1 => work.with(Stages::<1>(self.bases())),
        }
    }

    /// Coefficients of the stages' bases, see [`super::RungeKutta::bases`]; a rule of one stage has the step's
    /// beginning.
    fn bases(self) -> [[f64; 3]; 3] {
        self.runge_kutta().map_or([[1.0, 0.0, 0.0]; 3], |method| method.bases())
    }

    pub(crate) const fn looks_back(self) -> bool {
        matches!(self, Self::Bdf2)
    }

    /// c of a rule of one stage, b_l = g (b_(l-1) - c b_(l-2)) + w F_l.
    pub(crate) const fn before_last(self) -> f64 {
        if self.looks_back() { BEFORE_LAST } else { 0.0 }
    }

    /// Number of products for passing over so many steps, for two states: step by step, or by squares of R.
    pub(crate) fn products_of_skip(self, steps: usize) -> usize {
        match self {
            Self::Bdf2 => 2 * steps,
            _ => steps.checked_ilog2().map_or(0, |squares| squares as usize + 2 * steps.count_ones() as usize),
        }
    }

    /// Adds to `response[p - 1]` the displacement of a pole of coefficients g and w, p instants after a unit force at
    /// a stage of a step: the module's table, instant by instant.
    pub(crate) fn impulse_response(self, [g, w]: [Complex64; 2], stage: usize, response: &mut [f64]) {
        let stages = self.stages();
        let bases = self.bases();
        // b at the step's beginning and at its stages so far; with bdf2 b of the two instants before.
        let mut of_step = [Complex64::ZERO; MOST_STAGES + 1];
        of_step[stage + 1] = w;
        let mut now = stage;
        let mut before = Complex64::ZERO;
        for value in response {
            let last = of_step[now + 1];
            now += 1;
            if now == stages {
                (now, of_step) = (0, [last, Complex64::ZERO, Complex64::ZERO, Complex64::ZERO]);
            }
            let base: Complex64 = bases[now].iter().zip(&of_step).map(|(part, b)| b * part).sum();
            let next = match self {
                Self::Bdf2 => g * (last - BEFORE_LAST * before),
                _ => g * base,
            };
            before = last;
            of_step[now + 1] = next;
            *value += next.re;
        }
    }
}
