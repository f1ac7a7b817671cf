//! Waves of a ring shorter than the tyre, between cells and waves behind the march.
//!
//! Short waves are damped out within a few elements, so they are seen from a part of the window that goes with the
//! contact. The displacements by the last forces, all that the march has to wait for, come from a product between
//! cells ([`NextInstant`]); those by earlier forces are brought to cells behind the march ([`ShortRing`]).

use num_complex::Complex;

use super::product::CellProduct;
use super::ring_waves::RingWaves;
use super::wave_transform::{WaveNumber, WaveTransform};
use crate::counters::Work;
use crate::numeric::Element;
use crate::storage::state::{Evolving, StateError, StateStream};
use crate::tyre::influence::CellInfluence;

/// Values of cells from an element on.
pub(super) struct Seen {
    /// Element that they begin with.
    pub first: i64,
    /// Column by column.
    pub cells: Vec<f64>,
}

impl Seen {
    pub(super) fn new(cells: usize) -> Self {
        Self { first: 0, cells: vec![0.0; cells] }
    }

    /// Takes over another of the same length.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.first = other.first;
        self.cells.copy_from_slice(&other.cells);
    }

    /// Adds the values to the cells of a window that begins with `first_element`.
    pub(super) fn add_to(&self, first_element: i64, across: usize, out: &mut [f64]) {
        add_moved(&self.cells, first_element.saturating_sub(self.first).saturating_mul(across as i64), out);
    }
}

impl Evolving for Seen {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        state.all([&mut self.first, &mut self.cells])
    }
}

/// Overlap of a row and another one that begins `later` places later: both from the same place on.
pub(crate) fn aligned<'a, N, M>(row: &'a [N], later: i64, other: &'a mut [M]) -> (&'a [N], &'a mut [M]) {
    let skipped = |places: i64, of: usize| usize::try_from(places).unwrap_or(0).min(of);
    let (first, skipped) = (skipped(later.saturating_neg(), other.len()), skipped(later, row.len()));
    (&row[skipped..], &mut other[first..])
}

/// Adds numbers to others that begin `later` places later.
fn add_moved<N: Element>(numbers: &[N], later: i64, out: &mut [f64]) {
    let (numbers, out) = aligned(numbers, later, out);
    out.iter_mut().zip(numbers).for_each(|(out, number)| *out += number.double());
}

/// Part of a window that goes with the contact.
pub(crate) struct Placed {
    /// Column of the window that it begins with.
    pub first: usize,
    /// True if there is room for all of the contact.
    pub has_room: bool,
}

impl Placed {
    /// Places the `seen` columns about those that are touched, in the middle if none is.
    pub(crate) fn about<F>(
        forces: &[F],
        across: usize,
        [columns, seen]: [usize; 2],
        is_touched: impl Fn(&F) -> bool,
    ) -> Self {
        let most = columns.saturating_sub(seen);
        let (start, end) = (forces.iter().position(&is_touched), forces.iter().rposition(&is_touched));
        let Some((start, end)) = start.zip(end) else { return Self { first: most / 2, has_room: true } };
        let free = seen.checked_sub(end / across - start / across + 1);
        let first = (start / across).saturating_sub(free.unwrap_or(0) / 2).min(most);
        Self { first, has_room: free.is_some() }
    }
}

/// Displacements by the forces of an instant at the next one, in a part of the window that goes with the contact.
pub(super) struct NextInstant<N> {
    across: usize,
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
        Self { across, products, forces: zeros(), displacement: zeros(), last: Seen::new(columns * across) }
    }

    pub(super) fn across(&self) -> usize {
        self.across
    }

    /// Work of a step.
    pub(super) fn work(&self) -> Work {
        let mut work = Work::default();
        self.products.iter().for_each(|product| work += product.work());
        work
    }

    /// Takes the forces of the window that begins with `first_element`, contact in the middle of the part; returns
    /// whether there is room for all of them.
    pub(super) fn push(&mut self, first_element: i64, forces: &[f64]) -> bool {
        let Self { across, last, .. } = self;
        let [columns, seen] = [forces.len(), last.cells.len()].map(|cells| cells / *across);
        let about = Placed::about(forces, *across, [columns, seen], |force| *force > 0.0);
        last.first = first_element + about.first as i64;
        last.cells.iter_mut().zip(&forces[about.first * *across..]).for_each(|(own, force)| *own = *force);
        about.has_room
    }

    /// Adds the displacements by the forces of a stage at the next instant to the window that begins with
    /// `first_element`.
    pub(super) fn add_displacement(&mut self, stage: usize, first_element: i64, out: &mut [f64]) {
        let Self { across, products, forces, displacement, last } = self;
        forces.iter_mut().zip(&last.cells).for_each(|(own, force)| *own = N::rounded(*force));
        products[stage].displacement(forces, displacement);
        add_moved(displacement, first_element.saturating_sub(last.first).saturating_mul(*across as i64), out);
    }
}

/// The ring behind the march.
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
        let seen = || Seen::new(transform.cells());
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
