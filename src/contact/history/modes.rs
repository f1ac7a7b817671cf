//! The past carried by poles: convolution quadrature as a recursion.
//!
//! For H_n(s) = c + sum_r R_r/(s - lambda_r) the quadrature sum_p w_p F_(l-p) is exactly the same rule stepping a' = lambda a + F for every pole
//! (MODEL: section 4). With b = R a, and with g, w depending on pole, rule and time step only:
//!
//! | rule | b_l | g | w |
//! |---|---|---|---|
//! | bdf1 | g b_(l-1) + w F_l | 1/(1 - lambda dt) | g R dt |
//! | bdf2 | g (2 b_(l-1) - b_(l-2)/2) + w F_l | 1/(3/2 - lambda dt) | g R dt |
//! | trapezoidal | g b_(l-1) + w (F_l + F_(l-1)) | (2 + lambda dt)/(2 - lambda dt) | R dt/(2 - lambda dt) |
//! | sdirk2, sdirk3, stage i | g base_i + w F_i | 1/(1 - gamma lambda dt) | g R gamma dt |
//! | first-order-hold | g b_(l-1) + v F_(l-1) + w F_l | exp(lambda dt) | see [`FirstOrderHold`] |
//!
//! base_i is a fixed sum of b at the step's beginning and of the earlier stages ([`crate::scene::RungeKutta::bases`]); the last stage is the step's end. The first-order hold
//! steps as bdf1 with last step's force weighted w + v/g instead of w.
//!
//! Forces are real in the element frame, complex in wavenumber space; their real and imaginary parts drive two real systems with the same
//! conjugate-symmetric poles, so a pair is stored once and u = 2 Re b.
//!
//! Every step, in one pass over the poles of each wavenumber:
//! 1. the last step's forces (real FFT) are added: b = (part without F) + w F;
//! 2. the part without today's force follows, summed to u_old,n;
//! 3. an inverse real FFT gives u_old on all elements, in the material frame: nothing moves but the elements that are looked at.
//!
//! Cost: about 40 flops and 96 bytes for a pair of poles, two FFTs of length N; independent of the memory. Wavenumbers are independent: any
//! split over threads gives the same bits.

use std::sync::Arc;

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use super::PastForces;
use super::transfer::{FirstOrderHold, first_weight};
use crate::numeric::{StateError, StateReader, StateWriter};
use crate::scene::TimeRule;
use crate::tyre::influence::Field;
use crate::tyre::rational::RationalModel;

/// Poles are padded to whole vectors of this many.
const LANES: usize = 8;

/// Below this many padded poles one thread is faster than handing work to a second one: a hand-over costs some 15 us of a processor twice a step. Measured on two cores at
/// N = 1024, 12 000 padded poles: 65 us a step on one thread, 79 us on two.
const PARALLEL_FROM: usize = 32_768;

/// Recursion coefficients and states of the poles of a run of wavenumbers, as structure of arrays.
#[derive(Clone, Debug, Default)]
struct Block {
    /// First wavenumber.
    first: usize,
    /// Position of the first pole of each wavenumber of the block; one more at the end. Multiples of [`LANES`].
    offsets: Vec<usize>,
    /// g, real and imaginary.
    g: [Vec<f64>; 2],
    /// w, real and imaginary; pairs carry the factor 2 of u = 2 Re b.
    w: [Vec<f64>; 2],
    /// b without the last step's force, for the real and the imaginary part of the forces.
    ahead: [[Vec<f64>; 2]; 2],
    /// b of the step before; for a Runge-Kutta rule b at the step's beginning.
    behind: [[Vec<f64>; 2]; 2],
    /// b of a Runge-Kutta rule's first stage; empty otherwise. Written before it is read within every step.
    first_stage: [[Vec<f64>; 2]; 2],
}

/// The recursion over all poles of a model.
pub struct ModalHistory {
    elements: usize,
    rule: TimeRule,
    /// Stage of the step that comes next.
    stage: usize,
    /// Sums that the bases of the stages are, see [`RungeKutta::bases`].
    bases: Option<[[f64; 3]; 3]>,
    blocks: Vec<Block>,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    /// Last step's forces on the ring of elements.
    forces: Vec<f64>,
    /// Last step's forces by wavenumber.
    force_spectrum: Vec<Complex64>,
    /// u_old by wavenumber.
    spectrum: Vec<Complex64>,
    ring: Vec<f64>,
    scratch: Vec<Complex64>,
    parallel: bool,
    arch: Arch,
    multiply_adds: u64,
}

/// g and w of a pole.
fn coefficients(rule: TimeRule, pole: Complex64, residue: Complex64, time_step: f64) -> (Complex64, Complex64) {
    let z = pole * time_step;
    let implicit = |delta: f64| {
        let g = (delta - z).inv();
        (g, g * residue * time_step)
    };
    match rule {
        TimeRule::Bdf1 => implicit(1.0),
        TimeRule::Bdf2 => implicit(1.5),
        TimeRule::Trapezoidal => {
            let g = (2.0 - z).inv();
            (g * (2.0 + z), g * residue * time_step)
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

impl ModalHistory {
    /// Everything at rest; `None` if the model does not hold the field.
    pub fn new(model: &RationalModel, field: Field, rule: TimeRule, time_step: f64) -> Option<Self> {
        let elements = model.elements;
        let wavenumbers = elements / 2 + 1;
        let blocks = rayon::current_num_threads().clamp(1, 64);
        let per_block = wavenumbers.div_ceil(blocks);
        let blocks: Option<Vec<Block>> = (0..wavenumbers)
            .step_by(per_block)
            .map(|first| Block::new(model, field, rule, time_step, first..(first + per_block).min(wavenumbers)))
            .collect();
        let blocks = blocks?;
        let mut planner = RealFftPlanner::<f64>::new();
        let (forward, inverse) = (planner.plan_fft_forward(elements), planner.plan_fft_inverse(elements));
        let scratch = forward.get_scratch_len().max(inverse.get_scratch_len());
        let poles: usize = blocks.iter().map(|block| block.g[0].len()).sum();
        Some(Self {
            elements,
            rule,
            stage: 0,
            bases: rule.runge_kutta().map(|rule| rule.bases()),
            blocks,
            forces: forward.make_input_vec(),
            force_spectrum: forward.make_output_vec(),
            spectrum: inverse.make_input_vec(),
            ring: inverse.make_output_vec(),
            scratch: vec![Complex64::ZERO; scratch],
            forward,
            inverse,
            parallel: poles >= PARALLEL_FROM,
            arch: Arch::new(),
            multiply_adds: 20 * poles as u64,
        })
    }

    /// First weights w_(n,0) of the quadrature, n = 0..=N/2: the model at delta(0)/dt \[m/N\].
    pub fn first_weights(model: &RationalModel, field: Field, rule: TimeRule, time_step: f64) -> Option<Vec<f64>> {
        (0..=model.largest_wavenumber())
            .map(|n| model.modes(n, field).map(|modes| first_weight(&modes, rule, time_step)))
            .collect()
    }
}

impl PastForces for ModalHistory {
    fn displacement(&mut self, first_element: i64, out: &mut [f64]) -> u64 {
        // Planned lengths; the forces are real and so is the displacement: nothing to refuse.
        let _ = self.forward.process_with_scratch(&mut self.forces, &mut self.force_spectrum, &mut self.scratch);
        let (arch, forces) = (self.arch, &self.force_spectrum);
        let rule = match self.bases {
            Some(bases) => Recursion::Stage { stage: self.stage, base: bases[self.stage] },
            None => Recursion::of(self.rule),
        };
        self.stage = (self.stage + 1) % self.rule.nodes().len();
        let per_block = self.blocks[0].offsets.len() - 1;
        let advance =
            |block: &mut Block, spectrum: &mut [Complex64]| arch.dispatch(Advance { block, rule, forces, spectrum });
        if self.parallel {
            self.blocks.par_iter_mut().zip(self.spectrum.par_chunks_mut(per_block)).for_each(|(b, s)| advance(b, s));
        } else {
            self.blocks.iter_mut().zip(self.spectrum.chunks_mut(per_block)).for_each(|(b, s)| advance(b, s));
        }
        let last = self.spectrum.len() - 1;
        (self.spectrum[0].im, self.spectrum[last].im) = (0.0, 0.0);
        let _ = self.inverse.process_with_scratch(&mut self.spectrum, &mut self.ring, &mut self.scratch);
        let first = first_element.rem_euclid(self.elements as i64) as usize;
        for (index, value) in out.iter_mut().enumerate() {
            *value = self.ring[(first + index) % self.elements];
        }
        self.multiply_adds
    }

    fn push(&mut self, first_element: i64, forces: &[f64]) {
        self.forces.fill(0.0);
        let first = first_element.rem_euclid(self.elements as i64) as usize;
        for (index, &force) in forces.iter().enumerate() {
            self.forces[(first + index) % self.elements] = force;
        }
    }

    fn save(&self, state: &mut StateWriter) {
        state.numbers(&self.forces);
        // List by list through all blocks: how wavenumbers are split over threads does not show.
        for list in 0..self.blocks[0].states().len() {
            state.count(self.blocks.iter().map(|block| block.states()[list].len() as u64).sum());
            self.blocks.iter().flat_map(|block| block.states()[list]).for_each(|&value| state.number(value));
        }
    }

    fn restore(&mut self, state: &mut StateReader<'_>) -> Result<(), StateError> {
        state.numbers_into(&mut self.forces)?;
        for list in 0..self.blocks[0].states().len() {
            let values = state.numbers()?;
            let expected = self.blocks.iter().map(|block| block.states()[list].len()).sum();
            if values.len() != expected {
                return Err(StateError::Length { expected, found: values.len() });
            }
            let mut rest = values.as_slice();
            for block in &mut self.blocks {
                let target = &mut block.states_mut()[list];
                let (own, others) = rest.split_at(target.len());
                target.copy_from_slice(own);
                rest = others;
            }
        }
        Ok(())
    }
}

impl Block {
    fn new(
        model: &RationalModel,
        field: Field,
        rule: TimeRule,
        time_step: f64,
        wavenumbers: std::ops::Range<usize>,
    ) -> Option<Self> {
        let mut block = Self { first: wavenumbers.start, offsets: vec![0], ..Self::default() };
        for n in wavenumbers {
            let modes = model.modes(n, field)?;
            for (index, (&pole, &residue)) in modes.poles.iter().zip(modes.residues).enumerate() {
                let factor = if index < modes.pairs { 2.0 } else { 1.0 };
                let (g, w) = coefficients(rule, pole, residue * factor, time_step);
                block.g[0].push(g.re);
                block.g[1].push(g.im);
                block.w[0].push(w.re);
                block.w[1].push(w.im);
            }
            let padded = block.g[0].len().next_multiple_of(LANES);
            for values in block.g.iter_mut().chain(&mut block.w) {
                values.resize(padded, 0.0);
            }
            block.offsets.push(padded);
        }
        let zeros = || vec![0.0; block.g[0].len()];
        let state = [[zeros(), zeros()], [zeros(), zeros()]];
        let first_stage = if rule.runge_kutta().is_some() { state.clone() } else { Default::default() };
        Some(Self { ahead: state.clone(), behind: state, first_stage, ..block })
    }

    /// All that evolves, list by list.
    fn states(&self) -> Vec<&Vec<f64>> {
        self.ahead.iter().chain(&self.behind).flatten().collect()
    }

    /// As [`Self::states`], to be changed.
    fn states_mut(&mut self) -> Vec<&mut Vec<f64>> {
        self.ahead.iter_mut().chain(&mut self.behind).flatten().collect()
    }
}

/// What a call does with b of the step or stage before, x, to find b without today's force.
#[derive(Clone, Copy)]
enum Recursion {
    /// g x.
    Last,
    /// g (2 x - b/2).
    Bdf2,
    /// g x + w F.
    Trapezoidal,
    /// g times the stage's base.
    Stage { stage: usize, base: [f64; 3] },
}

impl Recursion {
    fn of(rule: TimeRule) -> Self {
        match rule {
            TimeRule::Bdf2 => Self::Bdf2,
            TimeRule::Trapezoidal => Self::Trapezoidal,
            _ => Self::Last,
        }
    }
}

/// One step of a block.
struct Advance<'a> {
    block: &'a mut Block,
    rule: Recursion,
    /// Last step's forces, all wavenumbers.
    forces: &'a [Complex64],
    /// u_old of the block's wavenumbers.
    spectrum: &'a mut [Complex64],
}

impl WithSimd for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { block, rule, forces, spectrum } = self;
        for (index, out) in spectrum.iter_mut().enumerate() {
            let range = block.offsets[index]..block.offsets[index + 1];
            let force = forces[block.first + index];
            let [ahead_re, ahead_im] = &mut block.ahead;
            let [behind_re, behind_im] = &mut block.behind;
            let poles = Poles {
                g: [&block.g[0][range.clone()], &block.g[1][range.clone()]],
                w: [&block.w[0][range.clone()], &block.w[1][range.clone()]],
            };
            *out = if let Recursion::Stage { stage, base } = rule {
                let [first_re, first_im] = &mut block.first_stage;
                let re = staged(simd, (stage, base), &poles, force.re, [ahead_re, behind_re, first_re], range.clone());
                let im = staged(simd, (stage, base), &poles, force.im, [ahead_im, behind_im, first_im], range);
                Complex64::new(re, im)
            } else {
                let re = driven(simd, rule, &poles, force.re, ahead_re, behind_re, range.clone());
                let im = driven(simd, rule, &poles, force.im, ahead_im, behind_im, range);
                Complex64::new(re, im)
            };
        }
    }
}

/// Coefficients of one wavenumber's poles.
struct Poles<'a> {
    g: [&'a [f64]; 2],
    w: [&'a [f64]; 2],
}

/// The system driven by one real force: adds last step's force, moves on, returns u_old.
#[inline(always)]
fn driven<S: Simd>(
    simd: S,
    rule: Recursion,
    poles: &Poles<'_>,
    force: f64,
    ahead: &mut [Vec<f64>; 2],
    behind: &mut [Vec<f64>; 2],
    range: std::ops::Range<usize>,
) -> f64 {
    let [ahead_re, ahead_im] = ahead;
    let [behind_re, behind_im] = behind;
    let (ahead_re, _) = S::as_mut_simd_f64s(&mut ahead_re[range.clone()]);
    let (ahead_im, _) = S::as_mut_simd_f64s(&mut ahead_im[range.clone()]);
    let (behind_re, _) = S::as_mut_simd_f64s(&mut behind_re[range.clone()]);
    let (behind_im, _) = S::as_mut_simd_f64s(&mut behind_im[range]);
    let (g_re, g_im) = (S::as_simd_f64s(poles.g[0]).0, S::as_simd_f64s(poles.g[1]).0);
    let (w_re, w_im) = (S::as_simd_f64s(poles.w[0]).0, S::as_simd_f64s(poles.w[1]).0);
    let force = simd.splat_f64s(force);
    let (two, half) = (simd.splat_f64s(2.0), simd.splat_f64s(-0.5));
    let mut sum = simd.splat_f64s(0.0);
    let states = ahead_re.iter_mut().zip(ahead_im).zip(behind_re.iter_mut().zip(behind_im));
    let coefficients = g_re.iter().zip(g_im).zip(w_re.iter().zip(w_im));
    for (((a_re, a_im), (b_re, b_im)), ((&g_re, &g_im), (&w_re, &w_im))) in states.zip(coefficients) {
        // b of the last step, complete.
        let (x_re, x_im) = (simd.mul_add_e_f64s(w_re, force, *a_re), simd.mul_add_e_f64s(w_im, force, *a_im));
        let (y_re, y_im) = match rule {
            Recursion::Bdf2 => (
                simd.mul_add_e_f64s(half, *b_re, simd.mul_f64s(two, x_re)),
                simd.mul_add_e_f64s(half, *b_im, simd.mul_f64s(two, x_im)),
            ),
            _ => (x_re, x_im),
        };
        let next_re = simd.sub_f64s(simd.mul_f64s(g_re, y_re), simd.mul_f64s(g_im, y_im));
        let next_im = simd.mul_add_e_f64s(g_re, y_im, simd.mul_f64s(g_im, y_re));
        let (next_re, next_im) = match rule {
            // Half of today's drive is last step's force.
            Recursion::Trapezoidal => {
                (simd.mul_add_e_f64s(w_re, force, next_re), simd.mul_add_e_f64s(w_im, force, next_im))
            }
            _ => (next_re, next_im),
        };
        (*b_re, *b_im) = (x_re, x_im);
        (*a_re, *a_im) = (next_re, next_im);
        sum = simd.add_f64s(sum, next_re);
    }
    simd.reduce_sum_f64s(sum)
}

/// One stage of a Runge-Kutta rule, driven by one real force: adds the force of the stage before, moves on, returns u_old. `states`: b without the last force, b at the
/// step's beginning, b of the first stage.
#[inline(always)]
fn staged<S: Simd>(
    simd: S,
    (stage, base): (usize, [f64; 3]),
    poles: &Poles<'_>,
    force: f64,
    states: [&mut [Vec<f64>; 2]; 3],
    range: std::ops::Range<usize>,
) -> f64 {
    let [[ahead_re, ahead_im], [begin_re, begin_im], [first_re, first_im]] = states;
    let (ahead_re, _) = S::as_mut_simd_f64s(&mut ahead_re[range.clone()]);
    let (ahead_im, _) = S::as_mut_simd_f64s(&mut ahead_im[range.clone()]);
    let (begin_re, _) = S::as_mut_simd_f64s(&mut begin_re[range.clone()]);
    let (begin_im, _) = S::as_mut_simd_f64s(&mut begin_im[range.clone()]);
    let (first_re, _) = S::as_mut_simd_f64s(&mut first_re[range.clone()]);
    let (first_im, _) = S::as_mut_simd_f64s(&mut first_im[range]);
    let (g_re, g_im) = (S::as_simd_f64s(poles.g[0]).0, S::as_simd_f64s(poles.g[1]).0);
    let (w_re, w_im) = (S::as_simd_f64s(poles.w[0]).0, S::as_simd_f64s(poles.w[1]).0);
    let force = simd.splat_f64s(force);
    // The last of the base's numbers that counts belongs to the stage just done.
    let latest = simd.splat_f64s(base[stage]);
    let [from_begin, from_first, _] = base.map(|factor| simd.splat_f64s(factor));
    let mut sum = simd.splat_f64s(0.0);
    let states = ahead_re.iter_mut().zip(ahead_im).zip(begin_re.iter_mut().zip(begin_im));
    let coefficients = g_re.iter().zip(g_im).zip(w_re.iter().zip(w_im));
    let firsts = first_re.iter_mut().zip(first_im);
    for ((((a_re, a_im), (b_re, b_im)), (f_re, f_im)), ((&g_re, &g_im), (&w_re, &w_im))) in
        states.zip(firsts).zip(coefficients)
    {
        let (x_re, x_im) = (simd.mul_add_e_f64s(w_re, force, *a_re), simd.mul_add_e_f64s(w_im, force, *a_im));
        let (y_re, y_im) = match stage {
            0 => {
                (*b_re, *b_im) = (x_re, x_im);
                (x_re, x_im)
            }
            1 => {
                (*f_re, *f_im) = (x_re, x_im);
                (
                    simd.mul_add_e_f64s(from_begin, *b_re, simd.mul_f64s(latest, x_re)),
                    simd.mul_add_e_f64s(from_begin, *b_im, simd.mul_f64s(latest, x_im)),
                )
            }
            _ => {
                let re = simd.mul_add_e_f64s(from_first, *f_re, simd.mul_f64s(latest, x_re));
                let im = simd.mul_add_e_f64s(from_first, *f_im, simd.mul_f64s(latest, x_im));
                (simd.mul_add_e_f64s(from_begin, *b_re, re), simd.mul_add_e_f64s(from_begin, *b_im, im))
            }
        };
        let next_re = simd.sub_f64s(simd.mul_f64s(g_re, y_re), simd.mul_f64s(g_im, y_im));
        let next_im = simd.mul_add_e_f64s(g_re, y_im, simd.mul_f64s(g_im, y_re));
        (*a_re, *a_im) = (next_re, next_im);
        sum = simd.add_f64s(sum, next_re);
    }
    simd.reduce_sum_f64s(sum)
}
