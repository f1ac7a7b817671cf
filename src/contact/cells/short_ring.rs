//! Waves of a ring shorter than the tyre, between cells and waves in the background.
//!
//! Short waves are damped out within a few elements, so they are seen from a part of the window that goes with the
//! contact. The displacements by the last forces, all that the march has to wait for, come from a product between
//! cells ([`NextInstant`]); those by earlier forces are brought to cells in the background ([`ShortRing`]).

use num_complex::Complex;

use super::product::CellProduct;
use super::ring_waves::RingWaves;
use super::wave_transform::{WaveNumber, WaveTransform};
use crate::counters::Work;
use crate::numeric::Element;
use crate::storage::state::{Evolving, StateError, StateStream, evolving};
use crate::tyre::influence::CellInfluence;

/// Values on the cells of a part of a window, which goes with the contact.
pub(crate) struct Seen {
    /// Numbers of a column: cells across times components.
    column: usize,
    /// Element that they begin with.
    pub first: i64,
    /// Column by column.
    pub cells: Vec<f64>,
}

impl Seen {
    /// Zeros in columns of `column` numbers.
    pub(crate) fn new(column: usize, numbers: usize) -> Self {
        Self { column, first: 0, cells: vec![0.0; numbers] }
    }

    /// Takes over another of the same length.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.first = other.first;
        self.cells.copy_from_slice(&other.cells);
    }

    /// Takes the forces \[N\] of the window that begins with `first_element`, contact in the middle of the part;
    /// returns whether all of them fit.
    pub(crate) fn take(&mut self, first_element: i64, forces: &[f64]) -> bool {
        let [columns, seen] = [forces.len(), self.cells.len()].map(|numbers| numbers / self.column);
        let most = columns.saturating_sub(seen);
        let is_touched = |force: &f64| force.abs() > 0.0;
        let ends = forces.iter().position(is_touched).zip(forces.iter().rposition(is_touched));
        let (first, fits) = match ends.map(|(start, end)| (start / self.column, end / self.column)) {
            None => (most / 2, true),
            Some((start, end)) => {
                let free = seen.checked_sub(end - start + 1);
                (start.saturating_sub(free.unwrap_or(0) / 2).min(most), free.is_some())
            }
        };
        self.first = first_element + first as i64;
        self.cells.iter_mut().zip(&forces[first * self.column..]).for_each(|(cell, force)| *cell = *force);
        fits
    }

    /// Adds values on these cells to the window that begins with `first_element`.
    fn add_moved<N: Element>(&self, values: &[N], first_element: i64, out: &mut [f64]) {
        let later = first_element.saturating_sub(self.first).saturating_mul(self.column as i64);
        let skipped = |places: i64, of: usize| usize::try_from(places).unwrap_or(0).min(of);
        let (first, skipped) = (skipped(later.saturating_neg(), out.len()), skipped(later, values.len()));
        out[first..].iter_mut().zip(&values[skipped..]).for_each(|(out, value)| *out += value.double());
    }

    /// Adds the values to the window that begins with `first_element`.
    pub(crate) fn add_to(&self, first_element: i64, out: &mut [f64]) {
        self.add_moved(&self.cells, first_element, out);
    }
}

evolving!(Seen: first, cells);

/// Displacements by the forces of an instant at the next one, in a part of the window that goes with the contact.
pub(super) struct NextInstant<N> {
    /// By stage of the forces.
    products: Vec<CellProduct<N>>,
    forces: Vec<N>,
    displacement: Vec<N>,
    /// Forces of the last instant \[N\].
    pub last: Seen,
}

impl<N: WaveNumber> NextInstant<N> {
    /// Plans displacements by the influence of each stage's forces, of windows as long as the part.
    pub(super) fn new(influences: &[CellInfluence]) -> Self {
        let (columns, across) = influences.first().map_or((0, 0), |first| (first.columns, first.across));
        let products = influences.iter().map(|influence| CellProduct::whole(columns, influence)).collect();
        let zeros = || vec![N::default(); columns * across];
        Self { products, forces: zeros(), displacement: zeros(), last: Seen::new(across, columns * across) }
    }

    /// Work of a step.
    pub(super) fn work(&self) -> Work {
        let mut work = Work::default();
        self.products.iter().for_each(|product| work += product.work());
        work
    }

    /// Adds the displacements by the forces of a stage at the next instant to the window that begins with
    /// `first_element`.
    pub(super) fn add_displacement(&mut self, stage: usize, first_element: i64, out: &mut [f64]) {
        let Self { products, forces, displacement, last } = self;
        forces.iter_mut().zip(&last.cells).for_each(|(rounded, force)| *rounded = N::rounded(*force));
        products[stage].displacement(forces, displacement);
        last.add_moved(displacement, first_element, out);
    }
}

/// The ring in the background.
pub(super) struct ShortRing<N: WaveNumber> {
    transform: WaveTransform<N>,
    spectrum: Vec<Complex<N>>,
    /// Forces of the last instant \[N\].
    pub last: Seen,
    /// Displacements at the coming instant by all forces but those \[m\].
    pub field: Seen,
}

/// The last forces come anew from the march.
impl<N: WaveNumber> Evolving for ShortRing<N> {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        self.field.state(state)
    }
}

impl<N: WaveNumber> ShortRing<N> {
    pub(super) fn new(transform: WaveTransform<N>) -> Self {
        let seen = || Seen::new(transform.across(), transform.cells());
        let spectrum = vec![Complex::new(N::default(), N::default()); transform.waves()];
        Self { last: seen(), field: seen(), spectrum, transform }
    }

    /// Transforms the forces of the last instant, the number of which in its block is `instant`, to their waves.
    pub(super) fn take_forces(&mut self, instant: usize, waves: &mut RingWaves<N>) {
        self.transform.forward(self.last.first, &self.last.cells, &mut self.spectrum);
        waves.take_forces(instant, &self.spectrum);
    }

    /// Brings the displacements of waves at the coming instant to the cells about the last forces.
    pub(super) fn find_field(&mut self, waves: &RingWaves<N>) {
        waves.displacement(&mut self.spectrum);
        self.field.first = self.last.first;
        self.field.cells.fill(0.0);
        self.transform.add_inverse(&self.spectrum, self.field.first, &mut self.field.cells);
    }
}
