//! Contact at rest on a smooth road (s -> 0): where an axle stands, how far its tyre reaches, how stiff a tread law is.

use std::f64::consts::PI;

use super::complementarity::ActiveSet;
use super::error::ContactError;
use super::geometry::Geometry;
use crate::counters::Meter;
use crate::scene::Axle;

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
pub(crate) fn deepest(axle: &Axle, at_rest: f64) -> f64 {
    match axle {
        Axle::Indentation { .. } => at_rest,
        // Room for the corrections on a rough road.
        Axle::Load { .. } => 1.25 * at_rest,
        // A mass that lands comes down further.
        Axle::Mass { .. } => 2.0 * at_rest,
    }
}

/// Half the length of the window that holds every point that can touch \[m\], on a road up to `highest` \[m\] above
/// its plane.
pub(crate) fn window_reach(axle: &Axle, at_rest: f64, highest: f64, radius: f64, element: f64) -> f64 {
    1.05 * Geometry::half_chord(radius, deepest(axle, at_rest) + highest) + 2.0 * element
}

impl StaticTyre<'_> {
    /// Contact under an axle on a smooth road.
    ///
    /// # Errors
    /// As [`Self::at`], and [`ContactError::LoadNotReached`].
    pub fn under(&self, axle: &Axle) -> Result<StaticContact, ContactError> {
        match *axle {
            Axle::Load { load, .. } | Axle::Mass { load, .. } => self.under_load(load),
            Axle::Indentation { indentation, .. } => self.at(indentation),
        }
    }

    /// Contact on a smooth road at an indentation \[m\]; the stiffness is a backward difference over 1e-4 of it.
    pub fn at(&self, indentation: f64) -> Result<StaticContact, ContactError> {
        let elements = self.influence.len();
        let reach = Geometry::half_chord(self.circumference / (2.0 * PI), indentation);
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
                .search(&required, &mut forces, &mut Meter::default())
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

    /// Contact that carries a load \[N\], to 1e-9 of it.
    pub(crate) fn under_load(&self, load: f64) -> Result<StaticContact, ContactError> {
        carrying(load, self.circumference, 1e-9, |indentation| self.at(indentation))
    }
}

/// Contact that carries a load \[N\] within a relative tolerance, for a force that grows with the indentation; at most
/// half the radius is tried.
///
/// # Errors
/// [`ContactError::LoadNotReached`], and of `at`.
pub(super) fn carrying(
    load: f64,
    circumference: f64,
    tolerance: f64,
    mut at: impl FnMut(f64) -> Result<StaticContact, ContactError>,
) -> Result<StaticContact, ContactError> {
    // 1. Double the indentation until it carries the load.
    let mut deep = 1e-3;
    let deepest = 0.5 * circumference / (2.0 * PI);
    loop {
        let found = at(deep)?;
        if found.force >= load {
            break;
        }
        if deep >= deepest {
            return Err(ContactError::LoadNotReached { load, indentation: deep, force: found.force });
        }
        deep = (2.0 * deep).min(deepest);
    }
    // 2. Bisection between the last two.
    let mut shallow = 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (shallow + deep);
        let found = at(middle)?;
        if (found.force - load).abs() <= tolerance * load {
            return Ok(found);
        }
        if found.force < load { shallow = middle } else { deep = middle }
    }
    at(0.5 * (shallow + deep))
}

/// Parameter between two limits whose influence row has the force `wanted` at its indentation: bisection on its
/// logarithm, for a row that softens as the parameter grows.
///
/// # Errors
/// [`ContactError::NoEqualStiffness`] if no parameter between the limits has that force.
pub(crate) fn matched(
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
}
