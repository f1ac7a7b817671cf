//! The sound of a tyre rolling on a rough road, from the road's texture to the forces in the contact patch and the
//! vibration of belt and tread.
//!
//! The recommended route: read a [`scene`] (TOML: tyre, road, speed, load), make its [`Plan`] (every number of the run,
//! without computing anything), let it [`run`]. In memory, step by step:
//!
//! ```
//! use std::sync::atomic::AtomicBool;
//! use tyrewave::scene::DEFAULT;
//! use tyrewave::{Plan, Scene, Simulation};
//!
//! let mut scene = Scene::from_str(DEFAULT, "small")?;
//! scene.scene.numerics.elements = 64;
//! scene.scene.rolling.duration = 0.2;
//! let plan = Plan::of(&scene)?;
//! plan.check(&scene)?;
//! let mut run = Simulation::begin(&scene, &plan, &AtomicBool::new(false))?;
//! while let Some(step) = run.step()? {
//!     assert!(step.total_force >= 0.0);
//! }
//! let results = run.finish();
//! assert!(results.mean_force.is_some_and(|force| (2500.0..4500.0).contains(&force)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The receivers of the scene record the sound, the vibration is followed, and an observer of yours sees every step:
//!
//! ```
//! use std::sync::atomic::AtomicBool;
//! use tyrewave::counters::Meter;
//! use tyrewave::scene::DEFAULT;
//! use tyrewave::{Error, Observer, Plan, Scene, Simulation, Step};
//!
//! /// Largest force of a run \[N\].
//! struct Peak(f64);
//!
//! impl Observer for Peak {
//!     fn observe(&mut self, step: &Step<'_>, _: &mut Meter) -> Result<(), Error> {
//!         self.0 = self.0.max(step.total_force);
//!         Ok(())
//!     }
//! }
//!
//! let mut scene = Scene::from_str(DEFAULT, "small")?;
//! scene.scene.numerics.elements = 64;
//! scene.scene.rolling.duration = 0.1;
//! let plan = Plan::of(&scene)?;
//! let mut run = Simulation::begin(&scene, &plan, &AtomicBool::new(false))?.with(Peak(0.0));
//! while run.step()?.is_some() {}
//! assert!(run.observer::<Peak>().is_some_and(|peak| peak.0 > 2500.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`run::run()`] does the same into a folder of results, [`run::resume`] continues one that was stopped; [`report`]
//! makes a page of it. Parts can be used alone: [`tyre::Stack`] and [`tyre::wave_compliance`] give compliances,
//! [`tyre::InfluenceSum`] influence functions, [`road::RoadSurface`] heights, [`road::SliceBuilder`] road slices and
//! their stiffness under a tread, [`half_space::indent`] the contact of a rough body, [`response`] spectra, [`sound`]
//! levels and sound files. The folder `examples` has programs for all of these.
//!
//! The modules, public and private, are ordered as the data flows; each knows only those before it: `scene` -> `tyre`
//! and `road` -> `contact` -> `response` -> `sound` -> `results` -> `plan` -> `effects` -> `planning` -> `run` ->
//! `study` -> `report` -> `performance` -> `cli` and `python`.
//!
//! `numeric`, `counters` and `storage`, which keeps states and caches in files, know no physics and serve all of them;
//! `half_space`, the contact of rough surfaces on an elastic half-space, knows no tyre and serves the road's slices;
//! `radiation` knows bodies and air alone; `sidewall` knows inflated arcs alone, whose statics the scene uses and whose
//! impedance the tyre uses; `time_rule` is how a run goes from one step to the next, a choice that a scene names. `cli`
//! is the command line, the whole program except its allocator; `python`, present with the feature of that name, is the
//! Python package's extension module. `test_models` has tyres and scenes for tests and benchmarks; `internals` hands
//! parts to benchmarks and to the tests of the folder `tests`, and is not part of the interface.
//!
//! SI units throughout; the time factor is exp(+s t); a contact force F >= 0 pushes the tread inwards and a
//! displacement u > 0 is inwards.

mod cli;
mod contact;
pub mod counters;
mod effects;
pub mod half_space;
#[doc(hidden)]
pub mod internals;
mod numeric;
mod performance;
mod plan;
mod planning;
#[cfg(feature = "python")]
mod python;
mod radiation;
pub mod report;
pub mod response;
pub mod results;
pub mod road;
pub mod run;
pub mod scene;
mod sidewall;
pub mod sound;
mod storage;
mod study;
mod test_models;
mod time_rule;
pub mod tyre;

pub use cli::command_line;
pub use effects::channel::{Channel, RowShape, RowTimes};
pub use effects::observer::{Observer, Step};
pub use plan::Plan;
pub use run::{Progress, Results, RunError as Error, Simulation};
pub use scene::{LoadedScene, Scene, SceneError};
