//! Influence functions by wavenumber summation.
//!
//! In the order of the data's way:
//!
//! - [`Waves`]: their wavenumbers, and what a strip takes of them across the width;
//! - `kernel`: C and D of one wave (n, m) at s, the only place where the tyre's shape is asked for;
//! - `curved_waves`: those of a curved tyre, prepared once for all s;
//! - `short_waves`: what curvature does to those that are taken as flat;
//! - `projection`: what a contact element takes of a wave;
//! - `moments`, `half_space_bands`, `half_space_tail`: what short waves add together, without evaluations;
//! - [`folded_sum`]: the sums Ht_n(s), `bounded_sum`: without a tail, the reference, `lane_sum`: for many s at once;
//! - [`convolution_quadrature`]: from the sums to weights in the time domain;
//! - [`mobility`]: the driving-point mobility of patches;
//! - [`CellGrid`], [`CellSums`]: the same between cells of the contact strip, wave by wave and for an instant, and
//!   [`CellInfluence`], their table;
//! - [`SurfaceWaves`]: the surface wave by wave, not summed; `flank_waves`: what the sidewalls sweep with it.

mod bounded_sum;
mod cell_grid;
mod cell_influence;
mod cell_sums;
mod cell_waves;
pub mod convolution_quadrature;
mod curved_waves;
mod flank_waves;
pub mod folded_sum;
mod half_space_bands;
mod half_space_tail;
mod kept_instant;
pub(in crate::tyre) mod kernel;
pub(in crate::tyre) mod lane_sum;
pub mod mobility;
mod moments;
pub(in crate::tyre) mod parts;
pub(in crate::tyre) mod projection;
mod short_waves;
mod surface_waves;
mod tail_sum;
mod wave_compliance;
mod waves;

pub use cell_grid::CellGrid;
pub use cell_influence::{CellInfluence, OddInfluence, WaveValues};
pub use cell_sums::{CellSums, CellSumsAt};
pub use cell_waves::{CellRow, CellTruncation, CellWave, WaveBand};
pub use curved_waves::{steep_bytes, wave_bytes, wave_count};
pub use folded_sum::{InfluenceSum, InfluenceValue, SumAt, Truncation};
pub use kernel::Field;
pub use lane_sum::FaceValues;
pub use projection::Projection;
pub use surface_waves::SurfaceWaves;
pub use wave_compliance::wave_compliance;
pub use waves::Waves;
