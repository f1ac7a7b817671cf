//! Neighbouring waves side by side in the lanes of vectors: the channels of their tractions, and a pass over them.
//!
//! A channel is driven by one sum of the forces and displaces all components. In a block of [`STEPS`] steps channels
//! are gone through once: forces of the block before the last are taken in, and displacements of this block are
//! predicted as if no more forces came. The response to the forces of the previous block and of this one is summed with
//! the first weights of the recursion. Most channels have decayed by then, and are left out of the pass (module
//! `late`).
//!
//! b_l = g (b_(l-1) - c b_(l-2)) + w F_l, with c = 1/4 of bdf2 and 0 of bdf1; forces and displacements have the phases
//! of `tyre::poles::tractions`. Odd parts go from the real to the imaginary system and back.
//!
//! On a ring shorter than the tyre a force is forgotten some blocks after it was taken in: the remainder of its effect
//! is subtracted from the states, r_l F and r_(l-1) F with the response r = 1, g, ... of a channel.

use std::ops::Range;

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use super::late::late_channels;
use crate::contact::history::add_responses;
use crate::contact::history::wavenumber_group::put_parts;
use crate::counters::Work;
use crate::numeric::Element;
use crate::storage::state::{Evolving, StateError, StateStream};
use crate::time_rule::{Advance, TimeRule};
use crate::tyre::influence::{COMPONENTS, PAIRS};
use crate::tyre::poles::WaveModes;
use crate::tyre::poles::traction_model::{PoleChannel, TractionModel};

/// Steps of a block.
pub(crate) const STEPS: usize = 8;
/// Blocks whose forces are stored.
const BLOCKS: usize = 3;
/// Lags of the first weights: to the first step of the previous block.
const LAGS: usize = 2 * STEPS - 1;
/// Real and imaginary system.
const SYSTEMS: usize = 2;
/// Vectors of all components of a step.
const FIELD: usize = COMPONENTS * SYSTEMS;
/// Part of the tolerance below which the remainder of a force, relative to its beginning, need not be subtracted.
const FORGOTTEN: f64 = 1e-2;

/// Channels of one kind, pairs (PARTS = 2) or real ones (1): the r-th of every wave side by side. By channel g,
/// inputs, outputs, odd outputs where the tyre turns, states of both systems: this step, the previous one.
#[derive(Clone, Debug, Default)]
struct Channels<E, const PARTS: usize> {
    numbers: Vec<E>,
    turns: bool,
    /// Response when a force is forgotten, and one step before it, of the first channels: those that need it.
    remainder: Vec<E>,
}

/// Rule, time step and the other parameters of a history by poles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stepping {
    /// Time rule.
    pub rule: TimeRule,
    /// Time step \[s\].
    pub time_step: f64,
    /// How far the window moves on in a step.
    pub advance: Advance,
    /// Tolerance of the poles, relative to each wave's influence.
    pub tolerance: f64,
    /// Steps after which forces are forgotten, of which whole blocks count, one at least; `None`: never.
    pub forgotten_after: Option<usize>,
}

impl Stepping {
    /// Blocks after which forces are forgotten; 0: never.
    pub(super) fn remembered_blocks(&self) -> usize {
        self.forgotten_after.map_or(0, |steps| (steps / STEPS).max(1))
    }
}

struct Coefficients {
    g: Complex64,
    /// Response when forces are forgotten, and one step before it; 0 where it is too small to be subtracted.
    remainder: [Complex64; 2],
    input: [Complex64; COMPONENTS],
    output: [Complex64; COMPONENTS],
    odd: [Complex64; COMPONENTS],
}

impl<E: Element, const PARTS: usize> Channels<E, PARTS> {
    /// Where inputs, outputs, odd outputs and states of a channel begin, and the length of all.
    const fn places(turns: bool) -> [usize; 5] {
        let (input, of_vector) = (PARTS, COMPONENTS * PARTS);
        let odd = input + 2 * of_vector;
        let states = if turns { odd + of_vector } else { odd };
        [input, input + of_vector, odd, states, states + SYSTEMS * 2 * PARTS]
    }

    /// Arranges the channels of neighbouring waves, those first that forget.
    fn new(mut waves: Vec<Vec<Coefficients>>, turns: bool) -> Self {
        let forgets = |channel: &Coefficients| channel.remainder[0] != Complex64::ZERO;
        waves.iter_mut().for_each(|channels| channels.sort_by_key(|channel| !forgets(channel)));
        let count = waves.iter().map(Vec::len).max().unwrap_or(0);
        let forgetting =
            waves.iter().map(|channels| channels.iter().filter(|channel| forgets(channel)).count()).max().unwrap_or(0);
        let mut remainder = vec![E::default(); forgetting * 2 * PARTS * E::MOST_LANES];
        for (number, record) in remainder.chunks_exact_mut(2 * PARTS * E::MOST_LANES).enumerate() {
            for (lane, channels) in waves.iter().enumerate() {
                let Some(channel) = channels.get(number) else { continue };
                put_parts::<E, PARTS>(record, 0, lane, &channel.remainder);
            }
        }
        let [input, output, odd, _, length] = Self::places(turns);
        let mut numbers = vec![E::default(); count * length * E::MOST_LANES];
        for (number, record) in numbers.chunks_exact_mut(length * E::MOST_LANES).enumerate() {
            for (lane, channels) in waves.iter().enumerate() {
                let Some(channel) = channels.get(number) else { continue };
                let mut put = |place, values: &[Complex64]| put_parts::<E, PARTS>(record, place, lane, values);
                put(0, &[channel.g]);
                put(input, &channel.input);
                put(output, &channel.output);
                if turns {
                    put(odd, &channel.odd);
                }
            }
        }
        Self { numbers, turns, remainder }
    }

    /// States, channel by channel.
    fn states_mut(&mut self) -> impl Iterator<Item = &mut [E]> {
        let [.., states, length] = Self::places(self.turns);
        self.numbers.chunks_exact_mut(length * E::MOST_LANES).map(move |record| &mut record[states * E::MOST_LANES..])
    }
}

/// Neighbouring waves, as many as the widest vector has numbers.
pub(super) struct WaveGroup<E> {
    pub(super) waves: Range<usize>,
    pairs: Channels<E, 2>,
    reals: Channels<E, 1>,
    /// c.
    before: f64,
    /// First weights by lag, pair and part \[m/N\].
    within: Vec<E>,
    turns: bool,
    /// Forces of the steps of the block before the last, of the last and of this one \[N\], and displacements predicted
    /// \[m\]: by component, real parts, imaginary parts.
    forces: Vec<E>,
    predicted: Vec<E>,
    /// Forces of the blocks that are not forgotten yet, block by block.
    remembered: Vec<E>,
    /// Displacements of the coming step \[m\].
    sum: Vec<E>,
}

impl<E: Element> WaveGroup<E> {
    /// Group of waves of a model, at rest.
    pub(super) fn new(model: &TractionModel, waves: Range<usize>, stepping: Stepping) -> Self {
        let Stepping { rule, time_step, tolerance, .. } = stepping;
        let blocks = stepping.remembered_blocks();
        let (mut pairs, mut reals) = (Vec::new(), Vec::new());
        for wave in waves.clone() {
            let (poles, of_pairs, channels) = model.wave(wave);
            let channel =
                |(index, (&pole, &PoleChannel { input, output, odd })): (usize, (&Complex64, &PoleChannel))| {
                    let times = if index < of_pairs { 2.0 } else { 1.0 };
                    let (g, w) = rule.coefficients(pole, Complex64::new(times, 0.0), time_step);
                    let remainder = match blocks {
                        0 => [Complex64::ZERO; 2],
                        _ => remainder_after(g, rule.before_last(), blocks * STEPS, FORGOTTEN * tolerance),
                    };
                    Coefficients {
                        g,
                        remainder,
                        input,
                        output: output.map(|value| value * w),
                        odd: odd.map(|value| value * w),
                    }
                };
            let late = late_channels(model, wave, rule, time_step, STEPS, tolerance);
            let all = poles.iter().zip(channels).enumerate();
            let (paired, others): (Vec<_>, Vec<_>) =
                all.filter(|(index, _)| late[*index]).partition(|(index, _)| *index < of_pairs);
            pairs.push(paired.into_iter().map(channel).collect());
            reals.push(others.into_iter().map(channel).collect());
        }
        let turns = model.turns();
        let mut this = Self {
            waves,
            pairs: Channels::new(pairs, turns),
            reals: Channels::new(reals, turns),
            before: rule.before_last(),
            within: Vec::new(),
            turns,
            forces: vec![E::default(); BLOCKS * STEPS * FIELD * E::MOST_LANES],
            predicted: vec![E::default(); STEPS * FIELD * E::MOST_LANES],
            remembered: vec![E::default(); blocks * STEPS * FIELD * E::MOST_LANES],
            sum: vec![E::default(); FIELD * E::MOST_LANES],
        };
        this.within = this.first_weights(model, rule, time_step);
        this
    }

    /// Number of parts of a pair of components: even, and odd where the tyre turns.
    fn parts(&self) -> usize {
        if self.turns { 2 } else { 1 }
    }

    /// First weights, 1 to [`LAGS`] steps after a force \[m/N\].
    fn first_weights(&self, model: &TractionModel, rule: TimeRule, time_step: f64) -> Vec<E> {
        let parts = self.parts();
        let mut within = vec![E::default(); LAGS * PAIRS * parts * E::MOST_LANES];
        for (lane, wave) in self.waves.clone().enumerate() {
            let (poles, pairs, _) = model.wave(wave);
            for pair in 0..PAIRS {
                let of_pair = model.residues(wave, pair / COMPONENTS, pair % COMPONENTS);
                for (part, residues) in of_pair.iter().enumerate().take(parts) {
                    let modes = WaveModes { poles, residues, odd: &[], pairs, constant: 0.0 };
                    let mut response = [0.0; LAGS];
                    add_responses(&modes, residues, rule, time_step, LAGS, &mut response);
                    for (lag, value) in response.into_iter().enumerate() {
                        within[((lag * PAIRS + pair) * parts + part) * E::MOST_LANES + lane] = E::rounded(value);
                    }
                }
            }
        }
        within
    }

    /// Work of a step.
    pub(super) fn work(&self) -> Work {
        let (numbers, within) = (self.pairs.numbers.len() + self.reals.numbers.len(), self.within.len());
        let multiply_adds = self.multiply_adds() / STEPS + 2 * within;
        let bytes = (numbers / STEPS + within) * size_of::<E>();
        Work { multiply_adds: multiply_adds as u64, bytes: bytes as u64 }
    }

    /// Multiply-adds of a pass.
    fn multiply_adds(&self) -> usize {
        let of_kind = |numbers: usize, length: usize, parts: usize| {
            let of_step = SYSTEMS * (3 * parts * parts + 3 * parts + COMPONENTS * parts * (1 + self.parts()));
            numbers / length * STEPS * of_step
        };
        let [.., of_pair] = Channels::<E, 2>::places(self.turns);
        let [.., of_real] = Channels::<E, 1>::places(self.turns);
        let forgetting = |remainder: usize, parts: usize| remainder * STEPS * SYSTEMS * (COMPONENTS + parts) / 2;
        of_kind(self.pairs.numbers.len(), of_pair, 2)
            + of_kind(self.reals.numbers.len(), of_real, 1)
            + forgetting(self.pairs.remainder.len(), 2)
            + forgetting(self.reals.remainder.len(), 1)
    }

    /// Real and imaginary parts of a component in the forces of a step of the block, to be written.
    pub(super) fn force_mut(&mut self, step: usize, component: usize) -> [&mut [E]; SYSTEMS] {
        let step = (BLOCKS - 1) * STEPS + step;
        let force = &mut self.forces[(step * FIELD + component * SYSTEMS) * E::MOST_LANES..][..SYSTEMS * E::MOST_LANES];
        let (re, im) = force.split_at_mut(E::MOST_LANES);
        [re, im]
    }

    /// Displacements of a component at the coming step: real and imaginary parts.
    pub(super) fn displacement(&self, component: usize) -> [&[E]; SYSTEMS] {
        let (re, im) =
            self.sum[component * SYSTEMS * E::MOST_LANES..][..SYSTEMS * E::MOST_LANES].split_at(E::MOST_LANES);
        [re, im]
    }

    /// Finds the displacements at a step of the block; at the first one it passes over all channels before, and block
    /// `forgotten` of the remembered ones is forgotten.
    pub(super) fn advance(&mut self, arch: Arch, step: usize, forgotten: usize) {
        arch.dispatch(Step { group: self, step, forgotten });
    }
}

impl<E: Element + Evolving> Evolving for WaveGroup<E> {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.forces, &mut self.predicted, &mut self.remembered])?;
        self.pairs.states_mut().chain(self.reals.states_mut()).try_for_each(|states| state.list(states))
    }
}

struct Step<'a, E> {
    group: &'a mut WaveGroup<E>,
    step: usize,
    /// Block that is forgotten.
    forgotten: usize,
}

impl<E: Element> WithSimd for Step<'_, E> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let WaveGroup { pairs, reals, before, within, turns, forces, predicted, remembered, sum, .. } = self.group;
        let of_block = STEPS * FIELD * E::MOST_LANES;
        if self.step == 0 {
            forces.copy_within(of_block.., 0);
            let taken = E::vectors::<S>(&forces[..of_block]);
            let old: &mut [E] =
                if remembered.is_empty() { &mut [] } else { &mut remembered[self.forgotten * of_block..][..of_block] };
            let predicted = E::vectors_mut::<S>(predicted);
            predicted.fill(E::splat(simd, E::default()));
            let before = E::splat(simd, E::rounded(*before));
            let fields = [taken, E::vectors::<S>(old)];
            if *turns {
                pass_all::<E, S, 2, true>(simd, pairs, before, fields, predicted);
                pass_all::<E, S, 1, true>(simd, reals, before, fields, predicted);
            } else {
                pass_all::<E, S, 2, false>(simd, pairs, before, fields, predicted);
                pass_all::<E, S, 1, false>(simd, reals, before, fields, predicted);
            }
            old.iter_mut().zip(&*forces).for_each(|(old, force)| *old = *force);
        }
        let of_step = FIELD * E::MOST_LANES;
        sum.copy_from_slice(&predicted[self.step * of_step..][..of_step]);
        let (sum, within) = (E::vectors_mut::<S>(sum), E::vectors::<S>(within));
        let forces = E::vectors::<S>(&forces[of_block..]);
        if *turns {
            add_within::<E, S, true>(simd, within, forces, self.step, sum);
        } else {
            add_within::<E, S, false>(simd, within, forces, self.step, sum);
        }
    }
}

/// Adds the displacements by the forces of the previous block and by the earlier ones of this block.
#[inline(always)]
fn add_within<E: Element, S: Simd, const TURNS: bool>(
    simd: S,
    within: &[E::Vector<S>],
    forces: &[E::Vector<S>],
    step: usize,
    sum: &mut [E::Vector<S>],
) {
    let (vectors, parts) = (E::MOST_LANES / E::lanes::<S>(), if TURNS { 2 } else { 1 });
    let now = STEPS + step;
    for earlier in 0..now {
        let weights = &within[(now - earlier - 1) * PAIRS * parts * vectors..][..PAIRS * parts * vectors];
        let force = &forces[earlier * FIELD * vectors..][..FIELD * vectors];
        for v in 0..vectors {
            for a in 0..COMPONENTS {
                let (mut re, mut im) = (sum[2 * a * vectors + v], sum[(2 * a + 1) * vectors + v]);
                for b in 0..COMPONENTS {
                    let (f_re, f_im) = (force[2 * b * vectors + v], force[(2 * b + 1) * vectors + v]);
                    let place = (COMPONENTS * a + b) * parts * vectors + v;
                    re = E::mul_add(simd, weights[place], f_re, re);
                    im = E::mul_add(simd, weights[place], f_im, im);
                    if TURNS {
                        let odd = weights[place + vectors];
                        re = E::negate_mul_add(simd, odd, f_im, re);
                        im = E::mul_add(simd, odd, f_re, im);
                    }
                }
                (sum[2 * a * vectors + v], sum[(2 * a + 1) * vectors + v]) = (re, im);
            }
        }
    }
}

/// g (end - c before).
#[inline(always)]
fn stepped<E: Element, S: Simd, const PARTS: usize>(
    simd: S,
    g: [E::Vector<S>; PARTS],
    c: E::Vector<S>,
    [end, before]: [[E::Vector<S>; PARTS]; 2],
) -> [E::Vector<S>; PARTS] {
    let mut base = end;
    for part in 0..PARTS {
        base[part] = E::negate_mul_add(simd, c, before[part], end[part]);
    }
    let mut next = base;
    if PARTS == 1 {
        next[0] = E::mul(simd, g[0], base[0]);
    } else {
        next[0] = E::negate_mul_add(simd, g[PARTS - 1], base[PARTS - 1], E::mul(simd, g[0], base[0]));
        next[PARTS - 1] = E::mul_add(simd, g[PARTS - 1], base[0], E::mul(simd, g[0], base[PARTS - 1]));
    }
    next
}

/// Adds Re(a b), or subtracts it.
#[inline(always)]
fn add_real<E: Element, S: Simd, const PARTS: usize, const ADDS: bool>(
    simd: S,
    a: [E::Vector<S>; PARTS],
    b: [E::Vector<S>; PARTS],
    to: E::Vector<S>,
) -> E::Vector<S> {
    let mut sum = to;
    for part in 0..PARTS {
        // The product of the imaginary parts is negative.
        sum = if (part == 0) == ADDS {
            E::mul_add(simd, a[part], b[part], sum)
        } else {
            E::negate_mul_add(simd, a[part], b[part], sum)
        };
    }
    sum
}

/// Remainder of a unit state after `steps` steps, and one step before; 0 if it is less than `least`.
fn remainder_after(g: Complex64, before: f64, steps: usize, least: f64) -> [Complex64; 2] {
    let (mut now, mut last) = (Complex64::ONE, Complex64::ZERO);
    for _ in 0..steps {
        (now, last) = (g * (now - before * last), now);
    }
    if now.norm().max(last.norm()) < least { [Complex64::ZERO; 2] } else { [now, last] }
}

/// Subtracts factor b from a.
#[inline(always)]
fn take_off<E: Element, S: Simd, const PARTS: usize>(
    simd: S,
    a: &mut [E::Vector<S>; PARTS],
    factor: [E::Vector<S>; PARTS],
    b: [E::Vector<S>; PARTS],
) {
    a[0] = E::negate_mul_add(simd, factor[0], b[0], a[0]);
    if PARTS == 2 {
        a[0] = E::mul_add(simd, factor[PARTS - 1], b[PARTS - 1], a[0]);
        a[PARTS - 1] = E::negate_mul_add(simd, factor[0], b[PARTS - 1], a[PARTS - 1]);
        a[PARTS - 1] = E::negate_mul_add(simd, factor[PARTS - 1], b[0], a[PARTS - 1]);
    }
}

/// Passes over all channels of a kind.
#[inline(always)]
fn pass_all<E: Element, S: Simd, const PARTS: usize, const TURNS: bool>(
    simd: S,
    channels: &mut Channels<E, PARTS>,
    c: E::Vector<S>,
    [forces, old]: [&[E::Vector<S>]; 2],
    predicted: &mut [E::Vector<S>],
) {
    let [.., length] = Channels::<E, PARTS>::places(TURNS);
    let Channels { numbers, remainder, .. } = channels;
    let (forgetting, others) = numbers.split_at_mut(remainder.len() / (2 * PARTS) * length);
    let remainder = E::vectors::<S>(remainder);
    pass::<E, S, PARTS, TURNS, true>(simd, forgetting, c, (forces, old, remainder), predicted);
    pass::<E, S, PARTS, TURNS, false>(simd, others, c, (forces, &[], &[]), predicted);
}

/// Vectors of the forces of a block, of those that are forgotten, and the remainders of these.
type Taken<'a, V> = (&'a [V], &'a [V], &'a [V]);

/// Takes in the forces of the block before the last, and predicts this one.
#[inline(always)]
fn pass<E: Element, S: Simd, const PARTS: usize, const TURNS: bool, const FORGETS: bool>(
    simd: S,
    numbers: &mut [E],
    c: E::Vector<S>,
    (forces, old, remainder): Taken<'_, E::Vector<S>>,
    predicted: &mut [E::Vector<S>],
) {
    let vectors = E::MOST_LANES / E::lanes::<S>();
    let [input, output, odd, states, length] = Channels::<E, PARTS>::places(TURNS);
    for (number, record) in E::vectors_mut::<S>(numbers).chunks_exact_mut(length * vectors).enumerate() {
        for v in 0..vectors {
            let zero = [E::splat(simd, E::default()); PARTS];
            let (mut g, mut inputs, mut outputs, mut odds) =
                (zero, [zero; COMPONENTS], [zero; COMPONENTS], [zero; COMPONENTS]);
            let mut systems = [[zero; 2]; SYSTEMS];
            for part in 0..PARTS {
                g[part] = record[part * vectors + v];
                for a in 0..COMPONENTS {
                    inputs[a][part] = record[(input + a * PARTS + part) * vectors + v];
                    outputs[a][part] = record[(output + a * PARTS + part) * vectors + v];
                    if TURNS {
                        odds[a][part] = record[(odd + a * PARTS + part) * vectors + v];
                    }
                }
                for which in 0..2 * SYSTEMS {
                    systems[which / 2][which % 2][part] = record[(states + which * PARTS + part) * vectors + v];
                }
            }
            let mut gone = [zero; 2];
            if FORGETS {
                for which in 0..2 * PARTS {
                    gone[which / PARTS][which % PARTS] = remainder[(2 * PARTS * number + which) * vectors + v];
                }
            }
            // 1. Forces of the block before the last, less the remainder of those that are forgotten.
            for step in 0..STEPS {
                let place = |a: usize, system: usize| (step * FIELD + SYSTEMS * a + system) * vectors + v;
                for system in 0..SYSTEMS {
                    let mut last = systems[system][0];
                    let mut next = stepped::<E, S, PARTS>(simd, g, c, systems[system]);
                    for a in 0..COMPONENTS {
                        let force = forces[place(a, system)];
                        for part in 0..PARTS {
                            next[part] = E::mul_add(simd, inputs[a][part], force, next[part]);
                        }
                    }
                    if FORGETS {
                        let mut forgotten = zero;
                        for a in 0..COMPONENTS {
                            let force = old[place(a, system)];
                            for part in 0..PARTS {
                                forgotten[part] = E::mul_add(simd, inputs[a][part], force, forgotten[part]);
                            }
                        }
                        take_off::<E, S, PARTS>(simd, &mut next, gone[0], forgotten);
                        take_off::<E, S, PARTS>(simd, &mut last, gone[1], forgotten);
                    }
                    systems[system] = [next, last];
                }
            }
            for part in 0..PARTS {
                for which in 0..2 * SYSTEMS {
                    record[(states + which * PARTS + part) * vectors + v] = systems[which / 2][which % 2][part];
                }
            }
            // 2. The block between, without forces.
            for _ in 0..STEPS {
                for system in &mut systems {
                    *system = [stepped::<E, S, PARTS>(simd, g, c, *system), system[0]];
                }
            }
            // 3. Displacements of this block.
            for step in predicted.chunks_exact_mut(FIELD * vectors) {
                for system in &mut systems {
                    *system = [stepped::<E, S, PARTS>(simd, g, c, *system), system[0]];
                }
                let [[re, _], [im, _]] = systems;
                for a in 0..COMPONENTS {
                    let place = SYSTEMS * a * vectors + v;
                    let mut value = add_real::<E, S, PARTS, true>(simd, outputs[a], re, step[place]);
                    if TURNS {
                        value = add_real::<E, S, PARTS, false>(simd, odds[a], im, value);
                    }
                    step[place] = value;
                    let mut value = add_real::<E, S, PARTS, true>(simd, outputs[a], im, step[place + vectors]);
                    if TURNS {
                        value = add_real::<E, S, PARTS, true>(simd, odds[a], re, value);
                    }
                    step[place + vectors] = value;
                }
            }
        }
    }
}
