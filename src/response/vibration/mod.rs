//! Vibration of the tyre from its contact forces, in the frequency domain and per wavenumber.
//!
//! ```text
//! v_n(w') = i w' H_n(i w') F_n(w'),   F_n(w') = sum_e F_e(w') exp(-2 pi i n e/N)    material frame
//! v(x, w) = sum_n exp(i kx_n x) v_n(w - n Omega),   Omega = V/R        non-rotating frame, x from the axle
//! ```
//!
//! The velocity is that of the material, du/dt of an element, in both frames; seen from the road a wave of n periods
//! has its frequency shifted by n Omega and nothing else. (The rate at which the outline changes at a fixed x, which
//! moves air that does not turn with the tyre, is i w u_n instead of i w' u_n.)
//!
//! With rotation, H_n and H_-n differ. All of this is written for signed n and holds; `both_directions` defines which
//! of the two applies where. The velocity is still du/dt as the turning material sees it, without Omega x u, by which
//! the longitudinal and the outward direction turn.
//!
//! The run's time rule determines i w' and H_n. The displacement is that of the run's recursion for every rule; its
//! rate is the rule's difference quotient for a multistep rule, from which the work of the forces is computed too, and
//! i w' itself for a Runge-Kutta rule, whose displacements are those at the ends of the steps. At w dt = 1 the quotient
//! of `bdf2` is 1.9 dB more than i w', that of `bdf1` 0.4 dB less.
//!
//! In the order of the data flow:
//!
//! - [`layout`]: segments of whole revolutions, in which the shift is a whole number of bins;
//! - `products`: mean products of the forces of several stages, and forms quadratic in these forces;
//! - [`transfer`]: the velocity for unit force; `stage_transfer`: for the forces of a Runge-Kutta rule's stages;
//!   `both_directions`: for waves that run in either direction;
//! - [`velocity_table`]: the same of all wavenumbers, and for points beside the axle, coherent over n;
//! - [`tangential_forces`]: velocities by tangential forces;
//! - [`elements`]: velocities of points that turn with the tyre;
//! - [`resolved`]: velocities and power of forces that are resolved across the strip;
//! - `share`: a part of the bins with its sums, for a thread; [`accumulator`]: forces, step by step, to mean powers
//!   |F_n|^2 by bin, averaged over half overlapping segments (Welch 1967);
//! - [`spectra`]: spectra of the velocities, maps, dissipated power;
//! - [`contact_power`]: the power put in, in the time domain;
//! - [`dispersion`]: free waves of the tyre.
//!
//! Levels are means over segments and over the circumference, or at points. Forces are transformed by segments and the
//! response to each segment is taken as if it had begun at rest and rung out within, so |F_n|^2 is blurred by the
//! window, some 1.5 df wide, before |H_n|^2 multiplies it. The error falls with the square of the segment and is
//! largest where the tyre resonates.

pub(crate) mod accumulator;
mod both_directions;
pub(crate) mod contact_power;
pub(crate) mod dispersion;
pub(crate) mod elements;
pub(crate) mod layout;
mod products;
pub(crate) mod resolved;
mod share;
pub(crate) mod spectra;
mod stage_transfer;
pub(crate) mod tangential_forces;
#[cfg(test)]
mod tests;
pub(crate) mod transfer;
pub(crate) mod velocity_table;

use crate::scene::Vibration;

pub(crate) use accumulator::{PatchSpectra, VibrationAccumulator};
pub(crate) use contact_power::ContactPower;
pub(crate) use dispersion::{DispersionBranch, dispersion_branches};
pub(crate) use elements::ElementVelocities;
pub use layout::{Across, SegmentLayout};
pub(crate) use resolved::{CarriedWaves, ResolvedPower, ResolvedQuantities, ResolvedVelocity};
pub(crate) use spectra::{
    Dissipation, FieldSpectra, WavenumberMap, element_spectrum, resolved_dissipation, resolved_spectra,
};
pub use spectra::{SpectraRequest, field_spectra, point_spectrum};
pub(crate) use tangential_forces::TangentialForces;
pub use transfer::{TransferKind, TyreResponse, VibrationField};
pub use velocity_table::VelocityTable;

/// Memory \[bytes\] of the sums over the forces with the points and elements of so many fields; `turns` for a tyre that
/// turns.
pub(crate) fn point_bytes(layout: &SegmentLayout, fields: usize, vibration: &Vibration, turns: bool) -> f64 {
    let sums = VibrationAccumulator::bytes(layout, fields * vibration.points.len());
    match vibration.elements.len() {
        // A table is in memory while points are added.
        0 if vibration.points.is_empty() => sums,
        0 => sums + VelocityTable::bytes(layout, turns),
        elements => sums + ElementVelocities::bytes(layout, fields, elements, turns),
    }
}
