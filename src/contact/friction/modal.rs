//! Past of tractions carried by poles: all waves, block by block (module `wave_group`), long ones on the whole tyre,
//! those that are damped out within a few elements on a shorter ring, which is seen from the part of the window about
//! the contact.

use num_complex::{Complex, Complex64};
use pulp::Arch;
use rayon::prelude::*;

use super::product::Vector;
use super::wave_group::{STEPS, Stepping, WaveGroup};
use crate::contact::cells::CellHistory;
use crate::contact::cells::component_transforms::ComponentTransforms;
use crate::contact::cells::ring_waves::{allowed_rounding, by_precision, is_slow};
use crate::contact::cells::short_ring::Seen;
use crate::contact::cells::wave_transform::WaveNumber;
use crate::counters::{Meter, Stage, Work};
use crate::numeric::Element;
use crate::storage::state::{Evolving, StateError, StateStream, ensure};
use crate::tyre::influence::COMPONENTS;
use crate::tyre::poles::WaveModes;
use crate::tyre::poles::traction_model::TractionModel;

/// Least number of groups that a thread takes at a time.
const TOGETHER: usize = 16;

/// Waves of one ring.
struct Ring<R: WaveNumber> {
    transform: ComponentTransforms<R, COMPONENTS>,
    groups: Vec<WaveGroup<R>>,
    /// Those whose poles are too slow for single precision.
    precise: Vec<WaveGroup<f64>>,
    /// Forces, then displacements, on the part of the window that a short ring sees; `None`: all of the window.
    seen: Option<Seen>,
    /// Blocks that are remembered, and the earliest of them, which is forgotten next.
    blocks: usize,
    earliest: usize,
}

/// Waves of all rings and their history, in single or double precision.
pub(crate) struct TractionHistory<R: WaveNumber = f64> {
    rings: Vec<Ring<R>>,
    /// Step of the block that comes next.
    step: usize,
    work: Work,
    arch: Arch,
}

/// One ring: the waves that it carries.
pub(crate) struct TractionRing<'m, R: WaveNumber> {
    /// Their poles and channels.
    pub model: &'m TractionModel,
    /// From cells to waves and back.
    pub transform: ComponentTransforms<R, COMPONENTS>,
    /// Cells across, if the transform sees a part of the window.
    pub seen: Option<usize>,
    /// Rule and time step of this ring.
    pub stepping: Stepping,
}

impl<R: WaveNumber> Ring<R> {
    fn new(parts: TractionRing<'_, R>) -> Self {
        let TractionRing { model, transform, seen, stepping } = parts;
        let Stepping { time_step, advance, tolerance, .. } = stepping;
        let angles = transform.angles();
        let allowed = allowed_rounding(Some(tolerance));
        let is_slow_wave = |wave: usize| {
            let (poles, pairs, _) = model.wave(wave);
            let rate = angles[wave] / advance.time_of_element(time_step);
            (0..COMPONENTS).any(|component| {
                let [even, _] = model.residues(wave, component, component);
                let modes = WaveModes { poles, residues: &even, odd: &[], pairs, constant: 0.0 };
                even.iter().any(|residue| residue.norm() > 0.0) && is_slow(&modes, time_step, rate, allowed)
            })
        };
        let [fast, slow] = by_precision::<R>(model.len(), is_slow_wave);
        let groups = fast.into_par_iter().map(|waves| WaveGroup::new(model, waves, stepping)).collect();
        let precise = slow.into_par_iter().map(|waves| WaveGroup::new(model, waves, stepping)).collect();
        let seen = seen.map(|across| Seen::new(COMPONENTS * across, COMPONENTS * transform.cells()));
        Self { transform, groups, precise, seen, blocks: stepping.remembered_blocks(), earliest: 0 }
    }

    fn work(&self) -> Work {
        let mut work = self.transform.work() * 2;
        let of_pass = self.groups.iter().map(WaveGroup::work).chain(self.precise.iter().map(WaveGroup::work));
        of_pass.for_each(|count| work += count);
        work
    }

    /// Adds the displacements at a step of the block \[m\].
    fn add_displacement(&mut self, arch: Arch, step: usize, first_element: i64, out: &mut [Vector]) {
        let Self { transform, groups, precise, seen, blocks, earliest } = self;
        let forgotten = *earliest;
        groups.par_iter_mut().with_min_len(TOGETHER).for_each(|group| group.advance(arch, step, forgotten));
        precise.par_iter_mut().with_min_len(TOGETHER).for_each(|group| group.advance(arch, step, forgotten));
        if step == 0 && *blocks > 0 {
            *earliest = (*earliest + 1) % *blocks;
        }
        for (component, spectrum) in transform.spectra_mut().into_iter().enumerate() {
            groups.iter().for_each(|group| give(group, component, spectrum));
            precise.iter().for_each(|group| give(group, component, spectrum));
        }
        match seen {
            None => transform.add_inverse(first_element, out),
            Some(seen) => {
                seen.cells.fill(0.0);
                transform.add_inverse(seen.first, seen.cells.as_chunks_mut().0);
                seen.add_to(first_element, out.as_flattened_mut());
            }
        }
    }

    /// Takes the forces of a step of the block \[N\]; returns whether all of them fit.
    fn push(&mut self, step: usize, first_element: i64, forces: &[Vector]) -> bool {
        let Self { transform, groups, precise, seen, .. } = self;
        let mut fits = true;
        match seen {
            None => transform.forward(first_element, forces),
            Some(seen) => {
                fits = seen.take(first_element, forces.as_flattened());
                transform.forward(seen.first, seen.cells.as_chunks().0);
            }
        }
        for (component, spectrum) in transform.spectra().into_iter().enumerate() {
            groups.iter_mut().for_each(|group| take(group, step, component, spectrum));
            precise.iter_mut().for_each(|group| take(group, step, component, spectrum));
        }
        fits
    }
}

impl<R: WaveNumber> Evolving for Ring<R> {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        if let Some(seen) = &mut self.seen {
            state.value(&mut seen.first)?;
        }
        state.all([&mut self.earliest, &mut self.groups, &mut self.precise])?;
        ensure(self.earliest < self.blocks.max(1))
    }
}

impl<R: WaveNumber> TractionHistory<R> {
    pub(crate) fn new<'m>(rings: impl IntoIterator<Item = TractionRing<'m, R>>) -> Self {
        let rings: Vec<Ring<R>> = rings.into_iter().map(Ring::new).collect();
        let mut work = Work::default();
        rings.iter().for_each(|ring| work += ring.work());
        Self { rings, step: 0, work, arch: Arch::new() }
    }
}

impl<R: WaveNumber> CellHistory<COMPONENTS> for TractionHistory<R> {
    fn add_displacement(&mut self, _: usize, first_element: i64, out: &mut [Vector], meter: &mut Meter) {
        let Self { rings, step, arch, work } = self;
        meter.add_work(Stage::History, *work);
        rings.iter_mut().for_each(|ring| ring.add_displacement(*arch, *step, first_element, out));
    }

    fn push(&mut self, _: usize, first_element: i64, forces: &[Vector]) -> bool {
        let step = self.step;
        self.step = (step + 1) % STEPS;
        let mut fits = true;
        self.rings.iter_mut().for_each(|ring| fits &= ring.push(step, first_element, forces));
        fits
    }
}

impl<R: WaveNumber> Evolving for TractionHistory<R> {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.step, &mut self.rings])?;
        ensure(self.step < STEPS)
    }
}

/// Writes the displacements of a group to their spectrum; those across and normal times -i, see
/// `tyre::poles::tractions`.
fn give<E: Element, R: WaveNumber>(group: &WaveGroup<E>, component: usize, spectrum: &mut [Complex<R>]) {
    let [re, im] = group.displacement(component);
    let waves = spectrum[group.waves.clone()].iter_mut();
    for (value, (re, im)) in waves.zip(re.iter().zip(im)) {
        let (re, im) = (R::rounded(re.double()), R::rounded(im.double()));
        *value = if component == 0 { Complex::new(re, im) } else { Complex::new(im, -re) };
    }
}

/// Reads the forces of a group from their spectrum; those across and normal times i likewise.
fn take<E: Element, R: WaveNumber>(group: &mut WaveGroup<E>, step: usize, component: usize, spectrum: &[Complex<R>]) {
    let range = group.waves.clone();
    let [re, im] = group.force_mut(step, component);
    for ((re, im), value) in re.iter_mut().zip(im).zip(&spectrum[range]) {
        let value = Complex64::new(value.re.double(), value.im.double());
        let value = if component == 0 { value } else { Complex64::new(-value.im, value.re) };
        (*re, *im) = (E::rounded(value.re), E::rounded(value.im));
    }
}
