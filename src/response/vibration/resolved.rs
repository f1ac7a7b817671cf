//! Velocities and power of laterally resolved forces, stored instead of products of the forces.
//!
//! The forces of a column are F_m = sum_j s_m(y_j) F_j, m by m. Waves of different m are different motions of the tyre,
//! so that every observed quantity is a sum over m: the mean velocity across the strip a coherent one,
//!
//! ```text
//! v_n = sum_m a_m Y_nm F_nm,   a_m = (1/M) sum_j s_m(y_j)
//! ```
//!
//! to which waves that are odd about mid-width add nothing; the power put in is a sum of powers, to which all do,
//!
//! ```text
//! P = sum_n sum_m Re Y_nm |F_nm|^2
//! ```
//!
//! or the rule's form of it in the stages' forces. (The part of the displacement that follows the forces at once,
//! beyond the waves that the run carries, puts nothing into waves: it is taken off the displacements before the power
//! is found.) The sums over m are taken segment by segment, where |v_n|^2 is one number for each field; the mean
//! products of all components would be as many as the square of their number. So the tyre's transfers must be known
//! before the first segment: in single precision, which changes a level by 1e-6 dB.
//!
//! The power's waves are those that the run itself carries, each on a separate ring ([`CarriedWaves`]), a whole part of
//! the tyre's: it has every part-th n.

use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use super::both_directions::BothDirections;
use super::layout::SegmentLayout;
use super::products;
use super::stage_transfer::ScaledModes;
use super::transfer::{TransferKind, Transfers, VibrationField};
use super::velocity_table::VelocityTable;
use crate::numeric::{double, single};
use crate::tyre::influence::CellRow;
use crate::tyre::poles::pole_model::PoleModel;

/// Quantities that are stored for each wavenumber at a bin.
pub enum ResolvedQuantities {
    /// |v_n|^2, field by field.
    Velocities(Vec<ResolvedVelocity>),
    /// Power that the forces put into the tyre.
    Power(ResolvedPower),
}

/// a_m Y_nm of a field, in single precision.
pub struct ResolvedVelocity {
    field: VibrationField,
    /// By |n| = 0..=N/2, bin of the material frame and channel.
    values: BothDirections<Vec<Complex32>>,
}

/// Waves that a run carries on one ring, and their poles.
#[derive(Clone, Debug)]
pub struct CarriedWaves {
    /// Cells of the ring.
    pub ring: usize,
    /// Waves by lateral number.
    pub rows: Vec<CellRow>,
    /// Poles and residues of the waves, in their order.
    pub model: PoleModel,
}

/// Quadratic forms of the power of all carried waves, by n = 0..=N/2.
pub struct ResolvedPower(Vec<Forms>);

/// Quadratic forms of the waves of one n.
struct Forms {
    /// Components of the forces that have a wave of this n.
    components: Vec<usize>,
    /// By bin of the material frame, entry of `components` and product of the stages' forces; summed over the rings.
    weights: BothDirections<Vec<f32>>,
}

impl ResolvedVelocity {
    /// From the transfers of a table, in another order.
    pub fn of(table: &VelocityTable, layout: &SegmentLayout) -> Self {
        let (bins, channels) = (layout.bins(), layout.channels());
        let values = table.values().map(|table| {
            let mut values = vec![Complex32::ZERO; table.len()];
            let width = bins * channels;
            for (values, rows) in values.chunks_exact_mut(width).zip(table.chunks_exact(width)) {
                for (bin, values) in values.chunks_exact_mut(channels).enumerate() {
                    let of_bin = values.iter_mut().enumerate();
                    of_bin.for_each(|(channel, value)| *value = single(rows[channel * bins + bin]));
                }
            }
            values
        });
        Self { field: table.field(), values }
    }

    /// Field whose velocities these are.
    pub fn field(&self) -> VibrationField {
        self.field
    }

    /// Memory \[bytes\] of one field; `turns` for a tyre that turns.
    pub fn bytes(layout: &SegmentLayout, turns: bool) -> f64 {
        0.5 * VelocityTable::bytes(layout, turns)
    }

    /// Adds |v_n|^2 of a bin.
    fn add(&self, layout: &SegmentLayout, bin: usize, row: &[Complex64], sums: &mut [f64]) {
        let (width, bins, channels) = (layout.wavenumbers(), layout.bins(), layout.channels());
        for (index, sum) in sums.iter_mut().enumerate() {
            let n = layout.wavenumber(index);
            let material = layout.material_bin(bin, n);
            let first = (n.unsigned_abs() as usize * bins + material.unsigned_abs() as usize) * channels;
            let values = self.values.of(n, material);
            // The sign of a transfer that is odd in n is the same for all components, and does not change the square.
            let velocity = values[first..first + channels].iter().enumerate().fold(
                Complex64::ZERO,
                |velocity, (channel, value)| {
                    let value = double(*value);
                    velocity + if material < 0 { value.conj() } else { value } * row[channel * width + index]
                },
            );
            *sum += velocity.norm_sqr();
        }
    }
}

impl ResolvedPower {
    /// Forms of all waves that a run carries, for forces whose components have the lateral numbers `numbers`.
    pub fn new(layout: &SegmentLayout, carried: &[CarriedWaves], numbers: &[usize]) -> Self {
        let transfers = Transfers::new(layout, TransferKind::Rule);
        let count = products::count(layout.stages());
        // By n, components with their waves.
        let mut waves: Vec<Vec<(usize, ScaledModes<'_>)>> = (0..=layout.elements / 2).map(|_| Vec::new()).collect();
        for CarriedWaves { ring, rows, model } in carried {
            let mut known = 0..model.len();
            for CellRow { m, first, waves: of_row, .. } in rows {
                let component = numbers.iter().position(|number| number == m);
                for ((place, _), wave) in of_row.iter().enumerate().zip(known.by_ref()) {
                    let modes =
                        ScaledModes { modes: model.wave(wave), scale: 1.0, added_compliance: 0.0, odd_constant: 0.0 };
                    let n = layout.elements / ring * (first + place);
                    waves[n].extend(component.map(|component| (component, modes)));
                }
            }
        }
        // Forms of one n: one per component, summed over the rings.
        let forms = |mut waves: Vec<(usize, ScaledModes<'_>)>| {
            waves.sort_by_key(|(component, _)| *component);
            let mut components: Vec<usize> = waves.iter().map(|(component, _)| *component).collect();
            components.dedup();
            let width = components.len() * count;
            let zeros = || vec![0.0_f32; width * layout.bins()];
            let turns = waves.iter().any(|(_, modes)| modes.turns());
            let mut weights = BothDirections { forwards: zeros(), backwards: turns.then(zeros) };
            let alike = waves.chunk_by(|(one, _), (other, _)| one == other);
            for (place, rings) in alike.enumerate() {
                let add = |weights: &mut [f32], forms: &[f64]| {
                    for (weights, forms) in weights.chunks_exact_mut(width).zip(forms.chunks_exact(count)) {
                        let weights = &mut weights[place * count..][..count];
                        weights.iter_mut().zip(forms).for_each(|(weight, form)| *weight += *form as f32);
                    }
                };
                for (_, modes) in rings {
                    let forms = transfers.forms_of_power(modes);
                    add(&mut weights.forwards, &forms.forwards);
                    if let Some(backwards) = &mut weights.backwards {
                        add(backwards, forms.backwards.as_ref().unwrap_or(&forms.forwards));
                    }
                }
            }
            Forms { components, weights }
        };
        Self(waves.into_par_iter().map(forms).collect())
    }

    /// Memory \[bytes\] of the forms of so many waves; `turns` for a tyre that turns.
    pub fn bytes(layout: &SegmentLayout, waves: f64, turns: bool) -> f64 {
        let ways = if turns { 2.0 } else { 1.0 };
        4.0 * ways * waves * (products::count(layout.stages()) * layout.bins()) as f64
    }

    /// Adds the power of a bin.
    fn add(&self, layout: &SegmentLayout, bin: usize, row: &[Complex64], sums: &mut [f64]) {
        let (stages, width, components) = (layout.stages(), layout.wavenumbers(), layout.components());
        let count = products::count(stages);
        for (index, sum) in sums.iter_mut().enumerate() {
            let n = layout.wavenumber(index);
            let material = layout.material_bin(bin, n);
            let forms = &self.0[n.unsigned_abs() as usize];
            let place = material.unsigned_abs() as usize * forms.components.len() * count;
            let weights = forms.weights.of(n, material)[place..].chunks_exact(count);
            for (component, weights) in forms.components.iter().zip(weights) {
                let force = |stage: usize| row[(stage * components + component) * width + index];
                let (mut numbers, mut doubles) = ([0.0; 9], [0.0; 9]);
                let power = |stage: usize| force(stage).norm_sqr();
                products::add(&mut numbers[..count], 1, stages, power, |i, j| force(i) * force(j).conj());
                doubles.iter_mut().zip(weights).for_each(|(double, weight)| *double = f64::from(*weight));
                *sum += products::form(stages, &doubles[..count], material < 0, |number| numbers[number]);
            }
        }
    }
}

impl ResolvedQuantities {
    /// Number of values that are stored for each wavenumber at a bin.
    pub fn count(&self) -> usize {
        match self {
            Self::Velocities(fields) => fields.len(),
            Self::Power(_) => 1,
        }
    }

    pub(super) fn is_velocity(&self) -> bool {
        matches!(self, Self::Velocities(_))
    }

    /// Adds the velocities or the power due to F_n at a bin, given by channel and wavenumber.
    pub(super) fn add(&self, layout: &SegmentLayout, bin: usize, row: &[Complex64], sums: &mut [f64]) {
        match self {
            Self::Velocities(fields) => {
                for (field, sums) in fields.iter().zip(sums.chunks_exact_mut(layout.wavenumbers())) {
                    field.add(layout, bin, row, sums);
                }
            }
            Self::Power(power) => power.add(layout, bin, row, sums),
        }
    }
}
