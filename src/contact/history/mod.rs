//! Displacement by past forces.
//!
//! - `direct`: the convolution sum in the contact frame, over a memory of stated length: the reference;
//! - `modes`: one recursion per pole of the rational model: exact for the time rule, without a memory to choose;
//! - `near`: displacements by the latest forces, which the pass has not taken in yet;
//! - `far`: the pass over all poles, in double or single precision, in the background where there is another thread;
//! - `wavenumber_group`: the poles of neighbouring wavenumbers, side by side in vectors, and their `block_pass`;
//! - `transfer`: the transfer function of such a recursion.
//!
//! A third method, convolution by FFT in partitions (Gardner 1995, *J. Audio Eng. Soc.* 43, 127), was considered and
//! is
//! not built, because it wins nowhere. For N = 1024 and the default tyre at 80 km/h, transforms over the elements left
//! out, a step takes 0.44 M flops with 1024 lags, which leave out more than 1e-2 of H_n, and 0.98 M with 16384, which
//! leave out 4e-6; poles take 0.55 M and leave out the fit's tolerance, 1e-5; the direct sum takes 150 M with 8192
//! lags. Only where a memory of less than about 0.1 s would do are its flops fewer, and its weights need the sums over
//! wavenumbers that the fit avoids.

pub(super) mod block_pass;
mod direct;
mod far;
mod modes;
mod near;
pub(super) mod transfer;
#[cfg(test)]
mod turning_tests;
pub(super) mod wavenumber_group;

pub use direct::{DirectHistory, LagKernel};
pub use far::SinglePrecision;
pub use modes::{INSTANTS, ModalHistory};
pub(crate) use transfer::add_responses;
pub(crate) use wavenumber_group::expected_multiply_adds;

use crate::counters::Meter;
use crate::storage::state::Evolving;

/// A history of forces: displacements by those of past steps.
pub trait ForceHistory: Evolving + Send {
    /// Writes u_old \[m\] at the step about to be done, for the elements from `first_element` on, into `out`. It is
    /// called once for every stage of a step, and the caller times it as
    /// [`Stage::History`](crate::counters::Stage::History): `meter` is for its work, and for the times of its parts.
    fn displacement(&mut self, first_element: i64, out: &mut [f64], meter: &mut Meter);

    /// Takes the stage's forces \[N\], from element `first_element` on.
    fn push(&mut self, first_element: i64, forces: &[f64]);
}
