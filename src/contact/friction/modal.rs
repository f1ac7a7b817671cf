//! Past of tractions carried by poles: all waves, block by block (module `wave_group`), long ones on the whole tyre,
//! those that are damped out within a few elements on a shorter ring, which is seen from the part of the window about
//! the contact.

use num_complex::{Complex, Complex64};
use pulp::Arch;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::product::Vector;
use super::wave_group::{STEPS, Stepping, WaveGroup};
use crate::contact::cells::CellPast;
use crate::contact::cells::component_transforms::ComponentTransforms;
use crate::contact::cells::ring_waves::{allowed_rounding, by_precision, is_slow};
use crate::contact::cells::short_ring::Seen;
use crate::contact::cells::wave_transform::WaveNumber;
use crate::counters::{Meter, Stage, Work};
use crate::numeric::Element;
use crate::storage::state::{StateError, StateReader, StateWriter};
use crate::tyre::influence::COMPONENTS;
use crate::tyre::poles::Modes;
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

/// Waves of all rings and their past, in single or double precision.
pub(crate) struct TractionWaves<R: WaveNumber = f64> {
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

/// State of [`TractionWaves`] between two steps.
#[derive(Deserialize, Serialize)]
struct TractionWavesState {
    /// Step of the block.
    step: usize,
    /// By ring: element that is seen first, and the block that is forgotten next.
    places: Vec<(i64, usize)>,
    /// Numbers that evolve.
    numbers: Vec<f64>,
}

impl<R: WaveNumber> Ring<R> {
    fn new(parts: TractionRing<'_, R>) -> Self {
        let TractionRing { model, transform, seen, stepping } = parts;
        let Stepping { time_step, substeps, tolerance, .. } = stepping;
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
        let [fast, slow] = by_precision::<R>(model.len(), is_slow_wave);
        let groups = fast.into_par_iter().map(|waves| WaveGroup::new(model, waves, stepping)).collect();
        let precise = slow.into_par_iter().map(|waves| WaveGroup::new(model, waves, stepping)).collect();
        let seen = seen.map(|across| Seen::new(COMPONENTS * across, COMPONENTS * transform.cells()));
        Self { transform, groups, precise, seen, blocks: stepping.remembered_blocks(), earliest: 0 }
    }

    /// Work of a step.
    fn work(&self) -> Work {
        let mut work = self.transform.work() * 2;
        let of_pass = self.groups.iter().map(WaveGroup::work).chain(self.precise.iter().map(WaveGroup::work));
        of_pass.for_each(|own| work += own);
        work
    }

    /// Adds the displacements at a step of the block \[m\].
    fn add_displacement(&mut self, arch: Arch, step: usize, first_element: i64, out: &mut [Vector]) {
        let Self { transform, groups, precise, seen, blocks, earliest } = self;
        let forgotten = *earliest;
        groups.par_iter_mut().with_min_len(TOGETHER).for_each(|group| group.go_on(arch, step, forgotten));
        precise.par_iter_mut().with_min_len(TOGETHER).for_each(|group| group.go_on(arch, step, forgotten));
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

    /// Takes the forces of a step of the block \[N\]; returns whether there is room for all of them.
    fn push(&mut self, step: usize, first_element: i64, forces: &[Vector]) -> bool {
        let Self { transform, groups, precise, seen, .. } = self;
        let mut has_room = true;
        match seen {
            None => transform.forward(first_element, forces),
            Some(seen) => {
                has_room = seen.take(first_element, forces.as_flattened());
                transform.forward(seen.first, seen.cells.as_chunks().0);
            }
        }
        for (component, spectrum) in transform.spectra().into_iter().enumerate() {
            groups.iter_mut().for_each(|group| take(group, step, component, spectrum));
            precise.iter_mut().for_each(|group| take(group, step, component, spectrum));
        }
        has_room
    }

    /// All numbers that evolve, those in single precision (double where that is R) and those of slow poles.
    fn evolving_mut(&mut self) -> (impl Iterator<Item = &mut R>, impl Iterator<Item = &mut f64>) {
        let single = self.groups.iter_mut().flat_map(WaveGroup::evolving_mut).flatten();
        (single, self.precise.iter_mut().flat_map(WaveGroup::evolving_mut).flatten())
    }
}

impl<R: WaveNumber> TractionWaves<R> {
    pub(crate) fn new<'m>(rings: impl IntoIterator<Item = TractionRing<'m, R>>) -> Self {
        let rings: Vec<Ring<R>> = rings.into_iter().map(Ring::new).collect();
        let mut work = Work::default();
        rings.iter().for_each(|ring| work += ring.work());
        Self { rings, step: 0, work, arch: Arch::new() }
    }
}

impl<R: WaveNumber> CellPast<COMPONENTS> for TractionWaves<R> {
    fn add_displacement(&mut self, _: usize, first_element: i64, out: &mut [Vector], meter: &mut Meter) {
        let Self { rings, step, arch, work } = self;
        meter.add_work(Stage::History, *work);
        rings.iter_mut().for_each(|ring| ring.add_displacement(*arch, *step, first_element, out));
    }

    fn push(&mut self, _: usize, first_element: i64, forces: &[Vector]) -> bool {
        let step = self.step;
        self.step = (step + 1) % STEPS;
        let mut has_room = true;
        self.rings.iter_mut().for_each(|ring| has_room &= ring.push(step, first_element, forces));
        has_room
    }

    fn save(&self, state: &mut StateWriter) -> Result<(), StateError> {
        let mut numbers = Vec::new();
        for Ring { groups, precise, .. } in &self.rings {
            numbers.extend(groups.iter().flat_map(WaveGroup::evolving).flatten().map(|value| value.double()));
            numbers.extend(precise.iter().flat_map(WaveGroup::evolving).flatten());
        }
        let place = |ring: &Ring<R>| (ring.seen.as_ref().map_or(0, |seen| seen.first), ring.earliest);
        state.put(&TractionWavesState { step: self.step, places: self.rings.iter().map(place).collect(), numbers })
    }

    fn restore(&mut self, state: &mut StateReader<'_>) -> Result<(), StateError> {
        let TractionWavesState { step, places, numbers } = state.take()?;
        let count = |ring: &mut Ring<R>| {
            let (single, precise) = ring.evolving_mut();
            single.count() + precise.count()
        };
        let own: usize = self.rings.iter_mut().map(count).sum();
        let is_known = |(ring, (_, earliest)): (&Ring<R>, &(i64, usize))| *earliest < ring.blocks.max(1);
        let are_known = places.len() == self.rings.len() && self.rings.iter().zip(&places).all(is_known);
        if own != numbers.len() || step >= STEPS || !are_known {
            return Err(StateError::Value);
        }
        self.step = step;
        let mut numbers = numbers.into_iter();
        for (ring, (first, earliest)) in self.rings.iter_mut().zip(places) {
            ring.earliest = earliest;
            ring.seen.iter_mut().for_each(|seen| seen.first = first);
            let (single, precise) = ring.evolving_mut();
            single.for_each(|own| *own = numbers.next().map_or(*own, R::rounded));
            precise.for_each(|own| *own = numbers.next().unwrap_or(*own));
        }
        Ok(())
    }
}

/// Writes the displacements of a group to their spectrum; those across and normal times -i, see
/// `tyre::poles::tractions`.
fn give<E: Element, R: WaveNumber>(group: &WaveGroup<E>, component: usize, spectrum: &mut [Complex<R>]) {
    let [re, im] = group.displacement(component);
    let own = spectrum[group.waves.clone()].iter_mut();
    for (value, (re, im)) in own.zip(re.iter().zip(im)) {
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
