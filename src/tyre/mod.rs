//! The tyre: a layered elastic plate under tension, and how it answers forces on its elements.
//!
//! In the order of the data's way:
//!
//! - [`layers`]: from materials to the compliance C(kx, ky, s) of the surface and its transfer D to the innermost face;
//! - [`influence`]: from compliances to influence functions H_n(s), sums over all waves that look like the wavenumber n
//!   on the elements;
//! - [`poles`]: from influence functions to rational models, poles and residues for each n: what a run takes;
//! - [`views`]: what there is to see of both;
//! - [`modes`]: resonances of single waves, poles of C; [`slowest_wave`]: up to which speed a tyre rolls steadily;
//!   [`critical_speed`]: up to which it is stable, and the speed of its tread's waves.

pub mod critical_speed;
pub mod influence;
pub mod layers;
pub mod modes;
pub mod poles;
pub mod slowest_wave;
pub mod views;
