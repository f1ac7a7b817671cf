//! Axle height: fixed, or found so that the mean force is the load.
//!
//! The static solution (s -> 0, smooth road) gives the start value; the height rises to it along a ramp. With a load,
//! the height is then corrected three times within the warm-up by (load - mean force)/stiffness and stays fixed
//! afterwards: what is left is reported as found, not hidden. An axle that has a mass moves on: [`super::moving_axle`].

use serde::{Deserialize, Serialize};

use super::active_set::ActiveSet;
use super::error::ContactError;
use super::geometry::Geometry;
use super::moving_axle::MovingAxle;
use crate::scene::Axle;
use crate::storage::StateError;

/// Static contact on a smooth road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaticContact {
    /// Indentation of the rigid tyre \[m\].
    pub indentation: f64,
    /// Force \[N\].
    pub force: f64,
    /// dF/d(indentation) \[N/m\].
    pub stiffness: f64,
    /// Length over which there is contact \[m\].
    pub length: f64,
}

/// Static influence of the element j further on, j = 0..N \[m/N\], with the tyre's geometry.
#[derive(Clone, Debug)]
pub struct StaticTyre<'a> {
    /// Influence row; springs added to entry 0 by the caller.
    pub influence: &'a [f64],
    /// Circumference \[m\].
    pub circumference: f64,
}

/// How far the rigid tyre may come down \[m\] under an axle that has it at `at_rest` \[m\] on a smooth road.
pub fn deepest(axle: &Axle, at_rest: f64) -> f64 {
    match axle {
        Axle::Indentation { .. } => at_rest,
        // Room for the corrections on a rough road.
        Axle::Load { .. } => 1.25 * at_rest,
        // A mass that lands comes down further.
        Axle::Mass { .. } => 2.0 * at_rest,
    }
}

/// Half the length of the window that holds every point that can touch \[m\], on a road up to `highest` \[m\] above its
/// plane.
pub fn window_reach(axle: &Axle, at_rest: f64, highest: f64, radius: f64, element: f64) -> f64 {
    1.05 * Geometry::half_chord(radius, deepest(axle, at_rest) + highest) + 2.0 * element
}

impl StaticTyre<'_> {
    /// The contact that an axle has on a smooth road.
    ///
    /// # Errors
    /// As [`Self::at`], and [`ContactError::LoadNotReached`].
    pub fn under(&self, axle: &Axle) -> Result<StaticContact, ContactError> {
        match *axle {
            Axle::Load { load, .. } | Axle::Mass { load, .. } => self.under_load(load),
            Axle::Indentation { indentation, .. } => self.at(indentation),
        }
    }

    /// Force on a smooth road at an indentation \[m\].
    pub fn at(&self, indentation: f64) -> Result<StaticContact, ContactError> {
        let elements = self.influence.len();
        let reach = Geometry::half_chord(self.circumference / (2.0 * std::f64::consts::PI), indentation);
        let geometry =
            Geometry::new(self.circumference, elements, 1, 0.0, reach + 2.0 * self.circumference / elements as f64);
        let columns = geometry.columns;
        let mut search = ActiveSet::new(self.influence[..columns].to_vec(), columns, 1e-13, 64);
        let first = geometry.first_element(0);
        let mut forces = vec![0.0; columns];
        let mut force_at = |indentation: f64| -> Result<(f64, usize), ContactError> {
            let required: Vec<f64> = (0..columns)
                .map(|column| indentation - geometry.rise(geometry.position(first + column as i64, 0)))
                .collect();
            search
                .search(&required, &mut forces)
                .map_err(|_| ContactError::SingularMatrix { points: columns, step: 0 })?;
            Ok((forces.iter().sum(), forces.iter().filter(|&&force| force > 0.0).count()))
        };
        let difference = 1e-4 * indentation;
        let below = force_at(indentation - difference)?.0;
        let (force, points) = force_at(indentation)?;
        Ok(StaticContact {
            indentation,
            force,
            stiffness: (force - below) / difference,
            length: points as f64 * geometry.element,
        })
    }

    /// The indentation that carries a load \[N\], to 1e-9 of it: bisection on a force that grows with the indentation.
    pub fn under_load(&self, load: f64) -> Result<StaticContact, ContactError> {
        let mut deep = 1e-3;
        let deepest = 0.5 * self.circumference / (2.0 * std::f64::consts::PI);
        loop {
            let found = self.at(deep)?;
            if found.force >= load {
                break;
            }
            if deep >= deepest {
                return Err(ContactError::LoadNotReached { load, indentation: deep, force: found.force });
            }
            deep = (2.0 * deep).min(deepest);
        }
        let mut shallow = 0.0;
        for _ in 0..200 {
            let middle = 0.5 * (shallow + deep);
            let found = self.at(middle)?;
            if (found.force - load).abs() <= 1e-9 * load {
                return Ok(found);
            }
            if found.force < load { shallow = middle } else { deep = middle }
        }
        self.at(0.5 * (shallow + deep))
    }
}

/// The parameter between two limits whose influence row has the force `wanted` at its indentation: bisection on its
/// logarithm, for a row that softens as the parameter grows.
///
/// # Errors
/// [`ContactError::NoEqualStiffness`] if no parameter between the limits has that force.
pub fn matched(
    (mut stiff, mut soft): (f64, f64),
    circumference: f64,
    wanted: StaticContact,
    row: impl Fn(f64) -> Vec<f64>,
) -> Result<f64, ContactError> {
    let force = |parameter: f64| -> Result<f64, ContactError> {
        Ok(StaticTyre { influence: &row(parameter), circumference }.at(wanted.indentation)?.force)
    };
    let (highest, lowest) = (force(stiff)?, force(soft)?);
    if !(lowest..=highest).contains(&wanted.force) {
        return Err(ContactError::NoEqualStiffness { force: wanted.force, lowest, highest });
    }
    for _ in 0..100 {
        let middle = (stiff * soft).sqrt();
        if force(middle)? > wanted.force {
            stiff = middle
        } else {
            soft = middle
        }
        if soft / stiff < 1.0 + 1e-12 {
            break;
        }
    }
    Ok((stiff * soft).sqrt())
}

/// Indentation step by step.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum AxleHeight {
    /// Rises linearly to a fixed value.
    Fixed {
        /// Final indentation \[m\].
        indentation: f64,
        /// Steps of the ramp.
        ramp: f64,
    },
    /// Corrected over the warm-up towards a load.
    Loaded(LoadControl),
    /// A mass that the forces move.
    Moving(Box<MovingAxle>),
}

impl AxleHeight {
    /// Indentation at a step \[m\].
    pub fn indentation(&self, step: u64) -> f64 {
        self.between(step as f64)
    }

    /// Indentation at a time in steps \[m\]; before t = 0 as at t = 0.
    pub fn between(&self, steps: f64) -> f64 {
        let steps = steps.max(0.0);
        match self {
            Self::Fixed { indentation, ramp } => {
                if steps < *ramp {
                    indentation * steps / ramp
                } else {
                    *indentation
                }
            }
            Self::Loaded(control) => control.indentation(steps),
            Self::Moving(axle) => axle.between(steps),
        }
    }

    /// Takes note of the force at a step.
    pub fn observe(&mut self, step: u64, force: f64) {
        match self {
            Self::Fixed { .. } => {}
            Self::Loaded(control) => control.observe(step, force),
            Self::Moving(axle) => axle.observe(step, force),
        }
    }

    /// Goes on as an axle held in the same way did.
    ///
    /// # Errors
    /// [`StateError`].
    pub fn restore(&mut self, state: Self) -> Result<(), StateError> {
        if std::mem::discriminant(self) != std::mem::discriminant(&state) {
            return Err(StateError::Value);
        }
        *self = state;
        Ok(())
    }
}

/// Height control towards a mean force.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct LoadControl {
    load: f64,
    stiffness: f64,
    /// Steps of the first ramp.
    ramp: u64,
    /// Steps of a window between corrections.
    window: u64,
    from: f64,
    to: f64,
    /// Step at which the way from `from` to `to` begins, and its length.
    turn: (u64, u64),
    sum: f64,
    count: u64,
    previous: Option<(f64, f64)>,
}

/// Corrections within the warm-up; one more window follows the last.
const CORRECTIONS: u64 = 3;

impl LoadControl {
    /// Control for a warm-up of so many steps, starting from the static solution.
    pub fn new(load: f64, start: StaticContact, warm_up: u64) -> Self {
        let ramp = warm_up * 3 / 20;
        Self {
            load,
            stiffness: start.stiffness,
            ramp,
            window: (warm_up - ramp) / (CORRECTIONS + 1),
            from: 0.0,
            to: start.indentation,
            turn: (0, ramp),
            sum: 0.0,
            count: 0,
            previous: None,
        }
    }

    /// Steps of the first ramp.
    pub(super) fn ramp(&self) -> u64 {
        self.ramp
    }

    /// Where the present ramp ends \[m\].
    pub(super) fn target(&self) -> f64 {
        self.to
    }

    pub(super) fn indentation(&self, steps: f64) -> f64 {
        let (begin, length) = self.turn;
        if steps >= (begin + length) as f64 {
            return self.to;
        }
        // A stage of the step in which a turn begins may lie before it, and a short warm-up has turns of no length.
        if steps <= begin as f64 {
            return self.from;
        }
        self.from + (self.to - self.from) * (steps - begin as f64) / length as f64
    }

    pub(super) fn observe(&mut self, step: u64, force: f64) {
        if self.window == 0 || step < self.ramp {
            return;
        }
        let (window, within) = ((step - self.ramp) / self.window, (step - self.ramp) % self.window);
        if window >= CORRECTIONS {
            return;
        }
        // The first part of a window is left to settle.
        if within * 5 >= self.window * 2 {
            self.sum += force;
            self.count += 1;
        }
        if within + 1 == self.window {
            let mean = self.sum / self.count.max(1) as f64;
            if let Some((height, force)) = self.previous {
                let secant = (mean - force) / (self.to - height);
                // A secant from two noisy means is trusted within a factor of two of the static stiffness.
                if secant.is_finite() && secant > 0.0 {
                    self.stiffness = secant.clamp(0.5 * self.stiffness, 2.0 * self.stiffness);
                }
            }
            self.previous = Some((self.to, mean));
            self.from = self.to;
            self.to += (self.load - mean) / self.stiffness;
            self.turn = (step + 1, self.window / 10);
            (self.sum, self.count) = (0.0, 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bed of springs without coupling: F = sum of (depth - rise)/c in closed form.
    #[test]
    fn static_load_is_that_of_independent_springs() {
        let mut influence = vec![0.0; 512];
        influence[0] = 2e-6;
        let tyre = StaticTyre { influence: &influence, circumference: 1.95 };
        let found = tyre.at(5e-3).unwrap();
        let geometry = Geometry::new(1.95, 512, 1, 0.0, 0.1);
        let exact: f64 = (-40..=40).map(|e| (5e-3 - geometry.rise(geometry.position(e, 0))).max(0.0) / 2e-6).sum();
        assert!((found.force - exact).abs() < 1e-9 * exact);
        let back = tyre.under_load(exact).unwrap();
        assert!((back.indentation - 5e-3).abs() < 1e-10);
    }

    #[test]
    fn a_spring_is_found_again_and_one_that_cannot_be_is_said() {
        let circumference = 1.95;
        let row = |spring: f64| {
            let mut row: Vec<f64> = (0..256).map(|j| 4e-6 * (-(f64::from(j.min(256 - j)) / 9.0)).exp()).collect();
            row[0] += spring;
            row
        };
        let at = |row: &[f64]| StaticTyre { influence: row, circumference }.at(0.012).unwrap();
        let wanted = at(&row(1e-6));
        let found = matched((1e-9, 1e-3), circumference, wanted, row).unwrap();
        assert!((found / 1e-6 - 1.0).abs() < 1e-9, "{found:e}");
        let stiffer = StaticContact { force: 1.1 * at(&row(0.0)).force, ..wanted };
        let refused = matched((1e-9, 1e-3), circumference, stiffer, row).unwrap_err();
        assert!(matches!(refused, ContactError::NoEqualStiffness { .. }), "{refused}");
    }

    #[test]
    fn a_turn_of_no_length_is_a_step_at_every_stage() {
        let start = StaticContact { indentation: 0.01, force: 4000.0, stiffness: 3e5, length: 0.08 };
        let mut height = AxleHeight::Loaded(LoadControl::new(4000.0, start, 36));
        for step in 0..40 {
            for node in [0.29, 0.5, 1.0] {
                let indentation = height.between(step as f64 - 1.0 + node);
                assert!(indentation.is_finite() && indentation >= 0.0, "step {step}: {indentation}");
            }
            height.observe(step, 3e5 * height.indentation(step));
        }
    }

    #[test]
    fn control_finds_the_load_of_a_linear_spring_whose_stiffness_it_was_told_wrong() {
        let start = StaticContact { indentation: 0.01, force: 4000.0, stiffness: 3e5, length: 0.08 };
        let mut height = AxleHeight::Loaded(LoadControl::new(4000.0, start, 1000));
        let mut force = 0.0;
        for step in 0..1200 {
            force = 4.5e5 * (height.indentation(step) - 0.001);
            height.observe(step, force);
        }
        assert!((force - 4000.0).abs() < 1.0, "{force}");
    }
}
