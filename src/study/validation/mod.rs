//! Validation: a scene compared with published values.
//!
//! 1. [`Published`] holds the values, embedded with source, number of sets and spread; ranges follow from them alone.
//! 2. [`measure()`] rolls the scene's tyre on the named roads at some speeds, by [`Trials`](super::trial::Trials), and
//!    looks at it standing: [`Measured`].
//! 3. [`rows`] compares the two, without rolling anything: a [`ValidationRow`] has the computed value, its numerical
//!    error, how far it may lie off on roads as they may be ([`road_spread`]), the range, how far outside it is, and
//!    the [`Missing`] physics that could explain it.

mod compare;
mod measure;
mod missing;
mod published;
mod road_case;
mod road_spread;
mod row;

pub(crate) use compare::{TyreLevels, levels_of_one_tyre};
pub use measure::{Measured, StandingTyre};
pub(crate) use measure::{Options, ValidationError, ValidationRun, base_scene, measure};
pub use missing::Lacks;
pub(crate) use missing::Missing;
pub use published::Published;
pub(crate) use published::{FLEET_ROADS, PUBLISHED_SPEEDS, ROADS, bands};
pub use road_spread::rows;
pub(crate) use row::{Group, GroupSummary, ValidationRow, Verdict, summaries};
