//! Velocities of selected elements, which turn with the tyre.
//!
//! ```text
//! v_E(w') = sum_e T_(E - e)(w') F_e(w'),
//! T_d(w') = sum_n exp(2 pi i n d/N) Y_n(w'),   n = -N/2...N/2 with half of either end
//! ```
//!
//! 1. The forces of every element over a segment, which are zero except during its passages through the patch, less the
//!    mean pattern as it passes, weighted and transformed over time: N real transforms of length K, for any number of
//!    points, and as many more for each further channel of a step.
//! 2. For every point and bin the sum over all e, and over the channels.
//! 3. The mean pattern of the whole record is known at its end. The correction then depends only on the point's place
//!    at the segment's begin, of which there are two, half a circumference apart where a segment is an odd number of
//!    revolutions: two sums of v are stored for that, by bin, and |v|^2 becomes that of v less its mean-pattern share
//!    in every bin.
//!
//! The mean pattern itself passes all elements alike: its lines are those of the mean over the circumference.

use std::ops::Range;
use std::sync::Arc;

use num_complex::Complex64;
use rayon::prelude::*;
use realfft::{RealFftPlanner, RealToComplex};

use super::layout::SegmentLayout;
use super::velocity_table::VelocityTable;
use crate::storage::state::evolving;

/// Parts into which the elements are divided: enough for the threads of a desktop computer, and the same for any number
/// of threads, so that results do not depend on it.
const PARTS: usize = 16;

/// Sums of the velocities at some elements, for one or several fields.
pub struct ElementVelocities {
    layout: SegmentLayout,
    /// Element in the window's first column at the first step of a segment: of even and of odd segments.
    first: [i64; 2],
    tables: Vec<VelocityTable>,
    elements: Vec<usize>,
    parts: Vec<Part>,
    /// Velocities of the last segment: points x bins.
    velocities: Vec<Complex64>,
    /// Number of even and of odd segments.
    segments: [u64; 2],
    /// Sums of v over the even and over the odd segments: points x bins.
    sums: [Vec<Complex64>; 2],
    /// Sums of |v|^2: points x bins.
    powers: Vec<f64>,
}

impl ElementVelocities {
    /// Sums at `elements` (of 0..N) of each table's field, field by field; `first_element` is in the window's first
    /// column at the record's first step. The tables are turned from wavenumbers to distances.
    pub fn new(
        layout: &SegmentLayout,
        first_element: i64,
        mut tables: Vec<VelocityTable>,
        elements: Vec<usize>,
    ) -> Self {
        tables.iter_mut().for_each(VelocityTable::turn_to_distances);
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(layout.length());
        let points = tables.len() * elements.len();
        let all = points * layout.bins();
        let part = |part: usize| layout.elements * part / PARTS..layout.elements * (part + 1) / PARTS;
        Self {
            first: [first_element, first_element + layout.advance.elements(layout.hop() as i64)],
            parts: (0..PARTS)
                .map(part)
                .filter(|range| !range.is_empty())
                .map(|range| Part::new(layout, range, transform.clone(), points))
                .collect(),
            velocities: vec![Complex64::ZERO; all],
            segments: [0; 2],
            sums: [(); 2].map(|()| vec![Complex64::ZERO; all]),
            powers: vec![0.0; all],
            layout: *layout,
            tables,
            elements,
        }
    }

    /// Memory \[bytes\] for so many elements of so many fields, the tables included; `turns` for a tyre that turns.
    pub fn bytes(layout: &SegmentLayout, fields: usize, elements: usize, turns: bool) -> f64 {
        let (bins, length) = (layout.bins() as f64, layout.length() as f64);
        let points = (fields * elements) as f64;
        let parts = PARTS.min(layout.elements) as f64 * (3.0 * length + 2.0 * points * bins);
        fields as f64 * VelocityTable::bytes(layout, turns) + 8.0 * (parts + 7.0 * points * bins)
    }

    /// Number of multiply-adds per segment: a real transform takes about 5/4 K log2 K, a complex sum four.
    pub fn multiply_adds(layout: &SegmentLayout, points: usize) -> f64 {
        let length = layout.length() as f64;
        let transform = 1.25 * length * length.log2();
        (layout.channels() * layout.elements) as f64 * (transform + 4.0 * (points * layout.bins()) as f64)
    }

    /// Number of Fourier transforms per segment.
    pub fn transforms(layout: &SegmentLayout) -> u64 {
        (layout.channels() * layout.elements) as u64
    }

    /// Adds a segment: `force(step, column)` is the force in its window \[N\], the mean pattern of the first segment
    /// taken off; columns are counted through all channels.
    pub(super) fn add(&mut self, force: impl Fn(usize, usize) -> f64 + Copy + Sync) {
        let kind = self.segments.iter().sum::<u64>() as usize % 2;
        self.segments[kind] += 1;
        let mut velocities = std::mem::take(&mut self.velocities);
        self.parts.par_iter_mut().for_each(|part| part.add(self.first[kind], &self.tables, &self.elements, force));
        together(&self.parts, &mut velocities);
        for ((power, sum), value) in self.powers.iter_mut().zip(&mut self.sums[kind]).zip(&velocities) {
            *power += value.norm_sqr();
            *sum += value;
        }
        self.velocities = velocities;
    }

    /// For each point the sums over the segments of |v|^2 without the rest of the mean pattern: `offset(step, column)`
    /// is that rest \[N\].
    pub(super) fn finish(&self, offset: impl Fn(usize, usize) -> f64 + Copy + Sync) -> Vec<Vec<f64>> {
        let mut powers = self.powers.clone();
        let mut parts = self.parts.clone();
        let mut velocities = vec![Complex64::ZERO; powers.len()];
        for ((&first, sums), &segments) in self.first.iter().zip(&self.sums).zip(&self.segments) {
            if segments == 0 {
                continue;
            }
            parts.par_iter_mut().for_each(|part| part.add(first, &self.tables, &self.elements, offset));
            together(&parts, &mut velocities);
            for ((power, sum), off) in powers.iter_mut().zip(sums).zip(&velocities) {
                *power += segments as f64 * off.norm_sqr() - 2.0 * (off.conj() * sum).re;
            }
        }
        powers.chunks_exact(self.layout.bins()).map(<[f64]>::to_vec).collect()
    }
}

evolving!(ElementVelocities: segments, sums, powers);

/// Adds up the parts' velocities, always in the same order.
fn together(parts: &[Part], velocities: &mut [Complex64]) {
    velocities.fill(Complex64::ZERO);
    for part in parts {
        velocities.iter_mut().zip(&part.velocities).for_each(|(sum, value)| *sum += value);
    }
}

/// Elements whose forces one thread works on at a time.
#[derive(Clone)]
struct Part {
    range: Range<usize>,
    layout: SegmentLayout,
    transform: Arc<dyn RealToComplex<f64>>,
    /// Velocities due to the forces of these elements: points x bins.
    velocities: Vec<Complex64>,
    series: Vec<f64>,
    spectrum: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

impl Part {
    fn new(layout: &SegmentLayout, range: Range<usize>, transform: Arc<dyn RealToComplex<f64>>, points: usize) -> Self {
        Self {
            range,
            layout: *layout,
            velocities: vec![Complex64::ZERO; points * layout.bins()],
            series: transform.make_input_vec(),
            spectrum: transform.make_output_vec(),
            scratch: transform.make_scratch_vec(),
            transform,
        }
    }

    fn add(&mut self, first: i64, tables: &[VelocityTable], elements: &[usize], force: impl Fn(usize, usize) -> f64) {
        self.velocities.fill(Complex64::ZERO);
        let bins = self.layout.bins();
        let SegmentLayout { columns, .. } = self.layout;
        let channels = 0..self.layout.channels();
        for (element, channel) in
            self.range.clone().flat_map(|element| channels.clone().map(move |channel| (element, channel)))
        {
            self.passages(element, first, |step, column| force(step, channel * columns + column));
            // The only error is a wrong length; all have the planned length.
            let _ = self.transform.process_with_scratch(&mut self.series, &mut self.spectrum, &mut self.scratch);
            let points = tables.iter().flat_map(|table| elements.iter().map(move |&point| (table, point)));
            for ((table, point), velocities) in points.zip(self.velocities.chunks_exact_mut(bins)) {
                let (factor, transfers) = table.over_distance(channel, point as i64 - element as i64);
                for ((sum, transfer), force) in velocities.iter_mut().zip(transfers).zip(&self.spectrum) {
                    *sum += factor * transfer * force;
                }
            }
        }
    }

    /// Fills the series with the weighted forces of an element over the segment.
    fn passages(&mut self, element: usize, first: i64, force: impl Fn(usize, usize) -> f64) {
        let SegmentLayout { elements, advance, revolutions, columns, phase, .. } = self.layout;
        self.series.fill(0.0);
        for column in 0..columns {
            // Number of elements by which the window has moved on when the element is in the column.
            let moved = (element as i64 - first - column as i64).rem_euclid(elements as i64) as usize;
            if !moved.is_multiple_of(advance.elements_per_step) {
                continue;
            }
            for shift in (0..=revolutions).map(|revolution| advance.steps(moved + revolution * elements)) {
                for step in (shift..shift + advance.substeps).filter_map(|step| step.checked_sub(phase)) {
                    if let Some(entry) = self.series.get_mut(step) {
                        *entry = self.layout.weight(step) * force(step, column);
                    }
                }
            }
        }
    }
}
