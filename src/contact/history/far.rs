//! Displacements by the forces up to the last block in the block after the coming one: the pass over the states of all
//! poles.

use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

use num_complex::Complex64;
use pulp::Arch;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use super::block_pass::pass;
use super::wavenumber_group::WavenumberGroup;
use crate::contact::cells::ring_waves::{allowed_rounding, by_precision, is_slow};
use crate::counters::{Clock, CpuClock, Meter, Spent, Stage, Work};
use crate::numeric::background::BackgroundTask;
use crate::numeric::{Element, transform_multiply_adds};
use crate::storage::state::evolving;
use crate::time_rule::recursion::{Recursion, WithRecursion};
use crate::time_rule::{Advance, TimeRule};
use crate::tyre::influence::Field;
use crate::tyre::poles::{RationalModel, WaveModes};

/// Single precision of the poles of those waves whose displacement it changes by less than a tenth of a tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SinglePrecision {
    /// Tolerance of the poles, relative to each wave's influence.
    pub tolerance: f64,
    /// How far the tyre rolls in a step.
    pub advance: Advance,
}

/// States of all poles, and the input and output of a pass over them.
pub(super) struct Far {
    rule: TimeRule,
    groups: Vec<WavenumberGroup<f32>>,
    /// Those whose poles are too slow for single precision, or all of them.
    precise: Vec<WavenumberGroup<f64>>,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    /// On the ring at every instant of a block: forces \[N\] before the pass, displacements \[m\] after it.
    pub rings: Vec<Vec<f64>>,
    /// The same by wavenumber.
    spectra: Vec<Vec<Complex64>>,
    scratch: Vec<Complex64>,
    /// Clock of processor time in addition to wall time, if there is one.
    pub cpu: Option<CpuClock>,
    /// Sums and transforms of a pass.
    work: [Work; 2],
    /// Times of the last pass likewise.
    times: [Spent; 2],
    /// True if the last pass ran in the background.
    in_background: bool,
    arch: Arch,
}

impl Far {
    /// States at rest, for blocks of `instants` instants, in double precision unless `single` is given; `None` if the
    /// model does not hold the field.
    pub(super) fn new(
        model: &RationalModel,
        field: Field,
        rule: TimeRule,
        time_step: f64,
        instants: usize,
        single: Option<SinglePrecision>,
    ) -> Option<Self> {
        let elements = model.elements;
        let modes: Vec<_> = (0..=elements / 2).map(|n| model.modes(n, field)).collect::<Option<_>>()?;
        let needs_double = |n: usize| {
            single.is_none_or(|SinglePrecision { tolerance, advance }| {
                // A deformation at rest on the road moves through the tyre with the window.
                let rate = TAU * n as f64 / elements as f64 / advance.time_of_element(time_step);
                is_slow(&modes[n], time_step, rate, allowed_rounding(Some(tolerance)))
            })
        };
        let [single, double] = by_precision::<f32>(modes.len(), needs_double);
        let groups = all_of(single, &modes, rule, time_step, instants);
        let precise = all_of(double, &modes, rule, time_step, instants);
        // Two real transforms for each instant: as much as a complex one. Their input, output and scratch.
        let transforms = Work {
            multiply_adds: (instants as f64 * transform_multiply_adds(elements)) as u64,
            bytes: (2 * instants * 3 * 8 * elements) as u64,
        };
        let mut sums = Work::default();
        groups.iter().for_each(|group| sums += group.work());
        precise.iter().for_each(|group| sums += group.work());
        let mut planner = RealFftPlanner::<f64>::new();
        let (forward, inverse) = (planner.plan_fft_forward(elements), planner.plan_fft_inverse(elements));
        Some(Self {
            rule,
            groups,
            precise,
            rings: vec![forward.make_input_vec(); instants],
            spectra: vec![forward.make_output_vec(); instants],
            scratch: vec![Complex64::ZERO; forward.get_scratch_len().max(inverse.get_scratch_len())],
            forward,
            inverse,
            cpu: None,
            work: [sums, transforms],
            times: Default::default(),
            in_background: false,
            arch: Arch::new(),
        })
    }

    /// Reports the time of the last pass: in the background, or within the history of the step under way.
    pub(super) fn report(&self, meter: &mut Meter) {
        let [sums, transforms] = self.times;
        if self.in_background {
            meter.add_background(Stage::History, sums.wall);
            meter.add_background(Stage::Transforms, transforms.wall);
        }
        meter.lap_within(Stage::Transforms, if self.in_background { Spent::default() } else { transforms });
        meter.add_work(Stage::History, self.work[0]);
        meter.add_work(Stage::Transforms, self.work[1]);
    }
}

/// Groups of these wavenumbers, at rest.
fn all_of<E: Element>(
    ranges: Vec<Range<usize>>,
    modes: &[WaveModes<'_>],
    rule: TimeRule,
    time_step: f64,
    instants: usize,
) -> Vec<WavenumberGroup<E>> {
    let group = |range: Range<usize>| {
        WavenumberGroup::new(range.start, modes[range].iter().copied(), rule, time_step, instants)
    };
    ranges.into_iter().map(group).collect()
}

evolving!(Far: rings, groups, precise);

impl BackgroundTask for Far {
    fn carry_out(&mut self, in_background: bool) {
        self.in_background = in_background;
        self.rule.with_recursion(OverAllPoles(self));
    }
}

struct OverAllPoles<'a>(&'a mut Far);

impl WithRecursion for OverAllPoles<'_> {
    type Output = ();

    fn with<R: Recursion>(self, recursion: R) {
        let Far { groups, precise, forward, inverse, rings, spectra, scratch, cpu, times, arch, .. } = self.0;
        let mut clock = Clock::start(*cpu);
        // Planned lengths; the forces are real and so is the displacement: nothing to refuse.
        // 1. Forces from the ring to wavenumbers.
        for (ring, spectrum) in rings.iter_mut().zip(&mut *spectra) {
            let _ = forward.process_with_scratch(ring, spectrum, scratch);
        }
        times[1] = clock.lap();
        // 2. The pass, group by group.
        groups.iter_mut().for_each(|group| predict(group, spectra, *arch, recursion));
        precise.iter_mut().for_each(|group| predict(group, spectra, *arch, recursion));
        times[0] = clock.lap();
        // 3. Displacements back to the ring; of the waves that are their own mirror the imaginary part is rounding.
        for (ring, spectrum) in rings.iter_mut().zip(spectra) {
            let last = spectrum.len() - 1;
            (spectrum[0].im, spectrum[last].im) = (0.0, 0.0);
            let _ = inverse.process_with_scratch(spectrum, ring, scratch);
        }
        times[1] += clock.lap();
    }
}

/// Passes over a group: takes its part of the forces from the spectra, and writes the displacements in their place.
fn predict<E: Element, R: Recursion>(
    group: &mut WavenumberGroup<E>,
    spectra: &mut [Vec<Complex64>],
    arch: Arch,
    recursion: R,
) {
    for (instant, spectrum) in spectra.iter().enumerate() {
        let forces = &spectrum[group.wavenumbers()];
        group.take_forces(instant, forces.iter().map(|force| [force.re, force.im].map(E::rounded)));
    }
    pass(group, arch, recursion);
    for (instant, spectrum) in spectra.iter_mut().enumerate() {
        let displaced = spectrum[group.wavenumbers()].iter_mut().zip(group.displacement(instant));
        displaced.for_each(|(out, [re, im])| *out = Complex64::new(re.double(), im.double()));
    }
}
