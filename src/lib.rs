//! `tyrewave`: the sound of a tyre rolling on a rough road.
//!
//! The data's way is also the order of the modules; each knows only what lies before it:
//! [`scene`] -> [`tyre`] and [`road`] -> [`contact`] -> [`response`] -> [`results`] -> [`plan`] -> [`run`] -> [`study`]
//! -> [`performance`].
//!
//! [`numeric`], [`counters`] and [`storage`], which keeps states and caches in files, know no physics and serve all of
//! them; [`half_space`], the contact of rough surfaces on an elastic half-space, knows no tyre and serves the road's
//! slices; [`time_rule`] is how a run goes from one step to the next, a choice that a scene names. The command line is
//! the program's own and uses what everybody can; `test_models` is for tests alone.
//!
//! SI units throughout; the time factor is exp(+s t); a contact force F >= 0 pushes the tread inwards and a
//! displacement u > 0 is inwards.

pub mod contact;
pub mod counters;
pub mod half_space;
pub mod numeric;
pub mod performance;
pub mod plan;
pub mod response;
pub mod results;
pub mod road;
pub mod run;
pub mod scene;
pub mod storage;
pub mod study;
#[doc(hidden)]
pub mod test_models;
pub mod time_rule;
pub mod tyre;
