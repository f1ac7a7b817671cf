//! Tests of the whole: a module of the library, since they look at parts that are not public. Some run the program,
//! which `cargo test` builds beside.
//!
//! Tests that count allocations have programs of their own: whatever ran with them would be counted.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failing test may panic, in its helpers, too")]
#![allow(clippy::print_stdout, reason = "what was measured, and what was skipped, is printed")]

mod air_pumping;
mod archive;
mod arrays;
mod axle;
mod axle_mass;
mod bad_input;
mod catalogue;
mod cell_motion;
mod cell_sound;
mod cells;
mod cells_tables;
mod cells_window;
mod common;
mod compliance;
mod conditions;
mod convergence;
mod cords;
mod curved;
mod determinism;
mod emission;
mod export;
mod faults;
mod first_run;
mod fit_tyre;
mod friction;
mod friction_energy;
mod friction_motion;
mod fuzzing;
mod gallery;
mod half_space_closed_forms;
mod hard_cases;
mod histories;
mod hostile;
mod influence;
mod injection;
mod kept;
mod layers;
mod line_contact;
mod mistakes;
mod mobility;
mod pages;
mod performance;
mod plans;
mod presets;
mod pressed;
mod profile;
mod readme;
mod report;
mod resume;
mod rollout;
mod rotation_layers;
mod sidewall;
mod sidewall_tyre;
mod slice_errors;
mod slice_laws;
mod smooth;
mod sound;
mod spectra;
mod study;
mod sweep;
mod sweep_tasks;
mod time_rules;
mod tread_laws;
mod tread_measured;
mod tread_pattern;
mod turning_model;
mod tutorial;
mod tyre;
mod validate;
mod vibration;
