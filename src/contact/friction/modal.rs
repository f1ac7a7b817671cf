//! Past of tractions carried by poles: all waves, block by block (module `wave_group`).

use num_complex::{Complex, Complex64};
use pulp::Arch;
use rayon::prelude::*;

use super::product::Vector;
use super::transform::TractionTransform;
use super::wave_group::{STEPS, Stepping, WaveGroup};
use crate::contact::cells::ring_waves::{allowed_rounding, is_slow};
use crate::contact::cells::wave_transform::WaveNumber;
use crate::counters::Work;
use crate::numeric::Element;
use crate::storage::state::StateError;
use crate::tyre::influence::COMPONENTS;
use crate::tyre::poles::Modes;
use crate::tyre::poles::traction_model::TractionModel;

/// Groups that a thread goes through at a time, at least.
const TOGETHER: usize = 16;

/// Waves on the whole tyre and their past, in single or double precision.
pub(crate) struct TractionWaves<R: WaveNumber = f64> {
    transform: TractionTransform<R>,
    groups: Vec<WaveGroup<R>>,
    /// Those whose poles are too slow for single precision.
    precise: Vec<WaveGroup<f64>>,
    /// Step of the block that comes next, and whether any has been.
    step: usize,
    work: Work,
    arch: Arch,
}

impl<R: WaveNumber> TractionWaves<R> {
    /// Makes a past at rest.
    pub(crate) fn new(model: &TractionModel, transform: TractionTransform<R>, stepping: Stepping) -> Self {
        let Stepping { time_step, substeps, tolerance, .. } = stepping;
        let (waves, lanes) = (model.len(), R::MOST_LANES);
        let angles = transform.angles();
        let allowed = allowed_rounding(Some(tolerance));
        let is_slow_wave = |wave: usize| {
            let (poles, pairs, _) = model.wave(wave);
            let rate = angles[wave] / (substeps as f64 * time_step);
            (0..COMPONENTS).any(|component| {
                let [even, _] = model.residues(wave, component, component);
                let modes = Modes { poles, residues: &even, odd: &[], pairs, constant: 0.0 };
                even.iter().any(|residue| residue.norm() > 0.0) && is_slow(&modes, time_step, rate, allowed)
            })
        };
        let starts: Vec<usize> = (0..waves).step_by(lanes).collect();
        let end_of = |first: usize| waves.min(first + lanes);
        let needs_double = |first: &usize| R::EPSILON > f64::EPSILON && (*first..end_of(*first)).any(is_slow_wave);
        let (slow, fast): (Vec<usize>, Vec<usize>) = starts.into_par_iter().partition(needs_double);
        let group = |first: usize| WaveGroup::new(model, [first, end_of(first) - first], stepping);
        let groups: Vec<WaveGroup<R>> = fast.into_par_iter().map(group).collect();
        let own = f64::MOST_LANES;
        let slow: Vec<usize> = slow.into_iter().flat_map(|first| (first..end_of(first)).step_by(own)).collect();
        let group = |first: usize| {
            let end = waves.min((first / lanes + 1) * lanes);
            WaveGroup::new(model, [first, own.min(end - first)], stepping)
        };
        let precise: Vec<WaveGroup<f64>> = slow.into_par_iter().map(group).collect();
        let mut work = transform.work() * 2;
        let of_pass = groups.iter().map(WaveGroup::work).chain(precise.iter().map(WaveGroup::work));
        of_pass.for_each(|own| work += own);
        Self { transform, groups, precise, step: 0, work, arch: Arch::new() }
    }

    /// Returns the work of a step.
    pub(crate) fn work(&self) -> Work {
        self.work
    }

    /// Adds the displacements by past forces at the coming step \[m\].
    pub(crate) fn add_displacement(&mut self, first_element: i64, out: &mut [Vector]) {
        let Self { transform, groups, precise, step, arch, .. } = self;
        let (step, arch) = (*step, *arch);
        groups.par_iter_mut().with_min_len(TOGETHER).for_each(|group| group.go_on(arch, step));
        precise.par_iter_mut().with_min_len(TOGETHER).for_each(|group| group.go_on(arch, step));
        for (component, spectrum) in transform.spectra_mut().enumerate() {
            groups.iter().for_each(|group| give(group, component, spectrum));
            precise.iter().for_each(|group| give(group, component, spectrum));
        }
        transform.add_inverse(first_element, out);
    }

    /// Takes the forces of the step \[N\].
    pub(crate) fn push(&mut self, first_element: i64, forces: &[Vector]) {
        self.transform.forward(first_element, forces);
        let spectra = self.transform.spectra();
        for (component, spectrum) in spectra.into_iter().enumerate() {
            self.groups.iter_mut().for_each(|group| take(group, self.step, component, spectrum));
            self.precise.iter_mut().for_each(|group| take(group, self.step, component, spectrum));
        }
        self.step = (self.step + 1) % STEPS;
    }

    /// Takes the state down: the step of the block, and the numbers that evolve.
    pub(crate) fn save(&self) -> (usize, Vec<f64>) {
        let single = self.groups.iter().flat_map(WaveGroup::evolving).flatten().map(|value| value.double());
        let precise = self.precise.iter().flat_map(WaveGroup::evolving).flatten().copied();
        (self.step, single.chain(precise).collect())
    }

    /// Goes on from the state of an equal past.
    ///
    /// # Errors
    /// [`StateError`].
    pub(crate) fn restore(&mut self, (step, values): &(usize, Vec<f64>)) -> Result<(), StateError> {
        let Self { groups, precise, .. } = self;
        let count = |group: &mut dyn Iterator<Item = usize>| group.sum::<usize>();
        let own = count(&mut groups.iter().flat_map(WaveGroup::evolving).map(<[R]>::len))
            + count(&mut precise.iter().flat_map(WaveGroup::evolving).map(<[f64]>::len));
        if own != values.len() || *step >= STEPS {
            return Err(StateError::Value);
        }
        self.step = *step;
        let mut values = values.iter().copied();
        for own in groups.iter_mut().flat_map(WaveGroup::evolving_mut).flatten() {
            *own = values.next().map_or(*own, R::rounded);
        }
        for own in precise.iter_mut().flat_map(WaveGroup::evolving_mut).flatten() {
            *own = values.next().unwrap_or(*own);
        }
        Ok(())
    }
}

/// Gives the displacements of a group to their spectrum; across and normal ones times -i, see `tyre::poles::tractions`.
fn give<E: Element, R: WaveNumber>(group: &WaveGroup<E>, component: usize, spectrum: &mut [Complex<R>]) {
    let [re, im] = group.displacement(component);
    let own = spectrum[group.first..group.first + group.count].iter_mut();
    for (value, (re, im)) in own.zip(re.iter().zip(im)) {
        let (re, im) = (R::rounded(re.double()), R::rounded(im.double()));
        *value = if component == 0 { Complex::new(re, im) } else { Complex::new(im, -re) };
    }
}

/// Takes the forces of a group from their spectrum, times i likewise.
fn take<E: Element, R: WaveNumber>(group: &mut WaveGroup<E>, step: usize, component: usize, spectrum: &[Complex<R>]) {
    let range = group.first..group.first + group.count;
    let [re, im] = group.force_mut(step, component);
    for ((re, im), value) in re.iter_mut().zip(im).zip(&spectrum[range]) {
        let value = Complex64::new(value.re.double(), value.im.double());
        let value = if component == 0 { value } else { Complex64::new(-value.im, value.re) };
        (*re, *im) = (E::rounded(value.re), E::rounded(value.im));
    }
}
