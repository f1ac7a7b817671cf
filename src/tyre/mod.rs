//! The tyre: layers under tension, flat or as a hollow cylinder, and its response to forces on its elements.
//!
//! From materials to what a run takes:
//!
//! - `layers`: from materials to the compliance C(kx, ky, s) of the surface and its transfer D to the innermost face;
//! - `influence`: from compliances to influence functions H_n(s), sums over all waves that look like the wavenumber n
//!   on the elements;
//! - [`free_edges`]: the belt with free lateral edges, as a correction of these waves;
//! - `poles`: from influence functions to rational models, poles and residues for each n: the input of a run;
//! - `impulse_response`: influence over distance and time, for Python;
//! - `tread_pattern`: depths of the tread's cells, and the blocks between its cuts;
//! - `modes`: resonances of single waves, poles of C; `slowest_wave`: up to which speed a tyre rolls steadily;
//!   `critical_speed`: up to which it is stable, and the speed of its tread's waves.

pub(crate) mod critical_speed;
pub mod free_edges;
#[cfg(any(feature = "python", test))]
pub(crate) mod impulse_response;
pub(crate) mod influence;
pub(crate) mod layers;
pub(crate) mod modes;
pub(crate) mod poles;
pub(crate) mod slowest_wave;
pub(crate) mod tread_pattern;

pub use influence::lane_sum::FaceValues;
pub use influence::wave_compliance::wave_compliance;
pub use influence::{Field, InfluenceSum, InfluenceValue, Projection, SumAt, Truncation};
pub use layers::compliance::{NormalCompliance, Stack, StackAt};
