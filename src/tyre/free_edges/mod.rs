//! The belt with free lateral edges: waves that guided sides would allow, and lifts that let the edges go.
//!
//! Guided sides hold q = 0 and the slopes of v and w at the belt's edges, y = +-B/2. A belt without such sides moves as
//! the waves m of one parity, each as on guided sides, plus lifts q = psi(y) f(r), v, w = chi(y) f(r), chi' = psi, that
//! are not 0 there. The sidewalls act at the edges, on the means over a zone of the inner face. The compliance
//! between waves is that of guided sides with spread sidewalls, which is diagonal, plus a correction of finite rank:
//!
//! - [`Parity`], `lateral_shapes`: waves and lifts across the tyre, their products and their values at the edges;
//! - [`FreeEdges`]: layers and sidewalls of such a belt;
//! - [`Section`]: the section in motion of n periods round the tyre, and its compliance at s;
//! - `section_compliance`: that compliance, held by springs so that rigid motions have one;
//! - `edge_stiffness`: sidewalls, pressure at the corners and cavity, as forces at the edges;
//! - [`EdgeCorrection`]: the difference to guided sides, between waves and on a strip;
//! - `cases`: belts in files of compliance cases;
//! - `strip`: the compliance of a strip, wave by wave: the reference path of the sum that the correction adds to.
//!
//! Fields and symbols as in `tyre::layers::curved`; energies and forces are per radian.

mod belt;
pub(in crate::tyre) mod cases;
mod correction;
mod edge_stiffness;
mod lateral_shapes;
mod section;
mod section_compliance;
mod strip;

#[cfg(test)]
mod limits_tests;
#[cfg(test)]
mod passivity_tests;
#[cfg(test)]
mod reference_models;
#[cfg(test)]
mod references_tests;

pub use belt::{FreeEdges, FreeEdgesError};
pub use correction::EdgeCorrection;
pub use lateral_shapes::Parity;
pub use section::Section;
