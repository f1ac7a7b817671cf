//! Influence functions by wavenumber summation.
//!
//! From waves to tables:
//!
//! - [`Waves`]: the tyre's wavenumbers, and the weights of a strip for them across the width;
//! - `kernel`: C and D of one wave (n, m) at s, the only place where the tyre's shape is asked for;
//! - `curved_waves`: those of a curved tyre, prepared once for all s;
//! - `short_waves`: the effect of curvature on those that are evaluated as flat;
//! - `projection`: weights of a contact element for the waves;
//! - `moments`, `half_space_bands`, `half_space_tail`: contribution of the short waves, without evaluations;
//! - [`folded_sum`]: the sums Ht_n(s), `bounded_sum`: without a tail, the reference, `lane_sum`: for many s at once;
//! - [`convolution_quadrature`]: from the sums to weights in the time domain;
//! - [`mobility`]: the driving-point mobility of patches;
//! - [`CellGrid`], [`CellSums`]: the same between cells of the contact strip, wave by wave and for an instant, and
//!   [`CellInfluence`], their table;
//! - `traction_sums`: the same for all components of traction and displacement, `traction_influence`, their table, and
//!   `traction_waves`, single waves over frequency;
//! - [`SurfaceWaves`]: the surface wave by wave, not summed; `flank_waves`: the volume that the sidewalls sweep with
//!   it.

mod bounded_sum;
mod cached_instant;
mod cell_grid;
mod cell_influence;
pub(crate) mod cell_sums;
pub(crate) mod cell_waves;
pub(crate) mod convolution_quadrature;
mod curved_waves;
mod flank_waves;
pub(crate) mod folded_sum;
mod half_space_bands;
mod half_space_tail;
pub(in crate::tyre) mod kernel;
pub(in crate::tyre) mod lane_sum;
pub(crate) mod mobility;
mod moments;
pub(in crate::tyre) mod parts;
pub(in crate::tyre) mod projection;
mod short_waves;
mod surface_waves;
mod tail_sum;
mod traction_influence;
mod traction_sums;
mod traction_waves;
pub(crate) mod wave_compliance;
mod waves;

pub use cell_grid::CellGrid;
pub(crate) use cell_grid::carried;
pub use cell_influence::CellInfluence;
#[cfg(test)]
pub(crate) use cell_influence::OddInfluence;
pub(crate) use cell_influence::WaveValues;
pub(crate) use cell_sums::{CellSums, CellSumsAt};
pub(crate) use cell_waves::{CellRow, CellTruncation, CellWave, WaveBand};
pub(crate) use curved_waves::{steep_bytes, wave_bytes, wave_count};
pub use folded_sum::{InfluenceSum, InfluenceValue, SumAt, Truncation};
pub use kernel::Field;
pub(crate) use lane_sum::FaceValues;
pub use projection::Projection;
pub(crate) use surface_waves::SurfaceWaves;
pub use traction_influence::COMPONENTS;
pub(crate) use traction_influence::TractionInfluence;
#[cfg(test)]
pub(crate) use traction_influence::{PairTables, UniformTables};
pub use traction_sums::traction_shape;
pub(crate) use traction_sums::{PAIRS, TractionParts, folded_traction_shape};
pub(crate) use traction_waves::{TractionLines, TractionWaves};
pub(crate) use waves::Waves;
