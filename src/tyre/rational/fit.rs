//! All wavenumbers of a tyre.
//!
//! Poles vary smoothly with n. The wavenumbers are visited level by level, 0 and N/2 first, then in halved strides, each started from the nearer finished ones: a binary
//! tree. All wavenumbers of a level are independent (rayon), and who starts from whom does not depend on the number of threads: same bits for any number of them.

use std::f64::consts::PI;

use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

use super::ladder::Ladder;
use super::model::RationalModel;
use super::sampled::Rung;
use super::wavenumber::{Fitted, Refusal, RefusalReason, Start, Target, fit_wavenumber};
use crate::numeric::rational::partial_fractions::order;
use crate::scene::{Law, Tyre};
use crate::tyre::influence::{Field, InfluenceSum, Projection, Truncation};
use crate::tyre::influence_batch::FaceValues;

/// Samples beyond the number of poles that a fit starts with.
const SPARE_SAMPLES: usize = 16;

/// What a model has to be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FitOptions {
    /// Elements N round the tyre; even.
    pub elements: usize,
    /// Where the force acts: [`Field::Surface`], or [`Field::UnderTread`] for a bedding.
    pub driven: Field,
    /// Top of the band \[rad/s\].
    pub top: f64,
    /// Largest error relative to the largest |H_n| over the band.
    pub tolerance: f64,
    /// Relative tolerance of the sums over m and over aliases.
    pub influence_tolerance: f64,
    /// Most poles of one wavenumber, conjugates counted.
    pub most_poles: usize,
    /// Whether a constant is fitted. Measured: it does not save a pole at 1e-6, and without it H_n vanishes at infinity as it should.
    pub constant: bool,
}

impl FitOptions {
    /// The same with another tolerance; the sums are made a hundred times as accurate, so that the fit sees no noise.
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, influence_tolerance: (0.01 * tolerance).clamp(1e-12, 1e-4), ..self }
    }

    /// Defaults for N elements: 1e-6 up to 20 kHz, or as far as a second-order rule reaches (|s| <= 4/dt) at `highest_speed` \[m/s\] with one step an element.
    pub fn new(tyre: &Tyre, elements: usize, highest_speed: f64) -> Self {
        let reach = 4.0 * highest_speed * elements as f64 / tyre.circumference;
        Self {
            elements,
            driven: Field::Surface,
            top: reach.max(2.0 * PI * 20e3),
            tolerance: 1e-6,
            influence_tolerance: 1e-8,
            most_poles: 160,
            constant: false,
        }
    }
}

/// A model that was refused.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FitError {
    /// One wavenumber did not reach the tolerance.
    #[error(
        "wavenumber {wavenumber}: a rational model with {order} poles reaches {error:.1e}, wanted {tolerance:.1e}: {reason}"
    )]
    Refused {
        /// n.
        wavenumber: usize,
        /// Smallest error reached.
        error: f64,
        /// What was wanted.
        tolerance: f64,
        /// Poles in use, conjugates counted.
        order: usize,
        /// Why it ended.
        reason: RefusalReason,
    },
    /// A material that answers before it is pushed: on a finite band a stable model can be made to follow it, but not a passive tyre.
    #[error(
        "layer '{layer}': the law 'hysteretic' is not causal and has no time-domain model; use 'power-law', 'prony' or 'elastic'"
    )]
    NotCausal {
        /// Name of the layer.
        layer: String,
    },
    /// Options out of range.
    #[error("{what} = {value} is out of range: {wanted}")]
    Options {
        /// Which one.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What would be right.
        wanted: &'static str,
    },
}

impl std::fmt::Display for RefusalReason {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Poles => "the largest number of poles is reached; allow more, or a larger tolerance",
            Self::Resolution => {
                "resonances are sharper than the sampling can follow; more damping or a lower top frequency is needed"
            }
            Self::Rounds => "neither more poles nor more samples helped; resonances too sharp and too many for this tolerance, or a law that is not causal",
            Self::Passivity => "the fit would generate energy; a smaller tolerance may mend that",
            Self::NotATransferFunction => "a sample is not finite",
        })
    }
}

fn check(options: &FitOptions) -> Result<(), FitError> {
    let range = |what, value, wanted, ok| if ok { Ok(()) } else { Err(FitError::Options { what, value, wanted }) };
    let n = options.elements;
    range("elements", n as f64, "an even number of at least 4", n >= 4 && n.is_multiple_of(2))?;
    range("top", options.top, "positive and finite", options.top > 0.0 && options.top.is_finite())?;
    let tolerance = options.tolerance;
    range("tolerance", tolerance, "from 1e-10 to 0.1", (1e-10..=0.1).contains(&tolerance))?;
    range("most_poles", options.most_poles as f64, "at least 4", options.most_poles >= 4)
}

/// Fits all wavenumbers n = 0..=N/2.
pub fn fit(tyre: &Tyre, options: &FitOptions) -> Result<RationalModel, FitError> {
    check(options)?;
    if let Some(layer) = tyre.layers.iter().find(|layer| layer.material.law == Law::Hysteretic) {
        return Err(FitError::NotCausal { layer: layer.name.clone() });
    }
    let projection = Projection::new(tyre, options.elements);
    let sum = InfluenceSum::with(tyre, projection, Truncation::Tail, options.influence_tolerance, options.top);
    let ladder = Ladder::new(&sum, options.top);
    let last = options.elements / 2;
    let mut done: Vec<Option<Fitted>> = vec![None; last + 1];
    let target = Target {
        tolerance: options.tolerance,
        most_poles: options.most_poles,
        constant: options.constant,
        bottom_scale: 0.0,
        removals: 8,
        removal_below: 1.0,
    };
    let one = |n: usize, start: &Start, target: &Target| {
        let mut sample =
            |rungs: &[Rung], values: &mut Vec<FaceValues>| sample(&sum, &ladder, options.driven, n, rungs, values);
        fit_wavenumber(&ladder, target, start, &mut sample).map_err(|refusal| refused(n, options, &refusal))
    };
    // The belt follows most at n = 0: the scale of its errors.
    let first = one(0, &Start::default(), &target)?;
    let target = Target { bottom_scale: first.scales[1], ..target };
    done[0] = Some(first);
    let mut stride = last.next_power_of_two();
    while stride > 0 {
        let level: Vec<usize> = (0..=last).step_by(stride).filter(|&n| done[n].is_none()).collect();
        let fitted: Vec<(usize, Result<Fitted, FitError>)> = level
            .into_par_iter()
            .map(|n| {
                // Far from its start a fit is worth tidying; close to it, its start was tidy.
                let (removals, removal_below) = if stride > 4 { (6, 0.7) } else { (2, 0.3) };
                let target = Target { removals, removal_below, ..target };
                let start = start_of(&done, n, stride);
                // A start that leads nowhere is not held against the function.
                let fitted = one(n, &start, &target).or_else(|error| {
                    if start.poles.is_empty() { Err(error) } else { one(n, &Start::default(), &target) }
                });
                (n, fitted)
            })
            .collect();
        for (n, fitted) in fitted {
            done[n] = Some(fitted?);
        }
        stride /= 2;
    }
    let entries = done.into_iter().flatten().map(|fitted| fitted.entry);
    Ok(RationalModel::assemble(options.elements, options.driven, options.top, options.tolerance, entries))
}

/// Poles and rungs of the finished neighbour: the one above where there is one (functions become smoother with n), else the one below.
fn start_of(done: &[Option<Fitted>], n: usize, stride: usize) -> Start {
    let neighbour = |n: usize| done.get(n).and_then(Option::as_ref);
    let from = n.checked_sub(stride).and_then(neighbour).or_else(|| neighbour(n + stride));
    match from {
        Some(fitted) => {
            let poles = fitted.entry.poles.clone();
            Start { grid: thinned(&fitted.grid, order(&poles) + SPARE_SAMPLES), poles }
        }
        None => Start::default(),
    }
}

/// As dense a grid relative to itself, with no more than `most` rungs: what the neighbour needed on its way need not be needed again.
fn thinned(grid: &[usize], most: usize) -> Vec<usize> {
    if grid.len() <= most || most < 2 {
        return grid.to_vec();
    }
    (0..most).map(|i| grid[i * (grid.len() - 1) / (most - 1)]).collect()
}

fn refused(n: usize, options: &FitOptions, refusal: &Refusal) -> FitError {
    FitError::Refused {
        wavenumber: n,
        error: refusal.error,
        tolerance: options.tolerance,
        order: refusal.order,
        reason: refusal.reason,
    }
}

/// Exact values of both faces on rungs.
fn sample(sum: &InfluenceSum, ladder: &Ladder, driven: Field, n: usize, rungs: &[Rung], values: &mut Vec<FaceValues>) {
    let at = rungs.iter().map(|rung| match *rung {
        Rung::Axis(rung) => &ladder.axis_at[rung],
        Rung::Real(rung) => &ladder.real_at[rung],
    });
    sum.faces(n, at, driven, values);
}
