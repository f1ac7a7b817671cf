//! Interior points: they keep the equations unique at the resonances of the body's inside.
//!
//! The boundary integral equation has other solutions where the inside resonates with zero pressure on its surface. At
//! points inside the body the representation formula must give zero (H. A. Schenck, J. Acoust. Soc. Am. 44 (1968)
//! 41-58); these equations are added as constraints with multipliers (see [`super::solve`]). With a road the inside is
//! the body's part above it: the image's field is in the operator.

use std::f64::consts::PI;

use super::body::{BodyShape, RadiatingBody, Vector};

/// Least depth of a point below the surface, relative to the body's smallest half size.
const LEAST_DEPTH: f64 = 0.12;

/// Number of points for a wavenumber \[rad/m\], in each of the four blocks.
///
/// The body's inside resonates first at k d = pi at the earliest, d being its smallest size; below 80 % of that no
/// points are needed. Above, the number of resonances of one parity within a band of k grows with k^2.
pub(crate) fn interior_points(body: &RadiatingBody, wavenumber: f64) -> usize {
    let size = match body.shape() {
        BodyShape::Sphere { radius } => 2.0 * radius,
        BodyShape::Tyre { radius, width, .. } => width.min(2.0 * radius),
    };
    let size = if body.on_road() { 2.0 * size } else { size };
    if wavenumber * size < 0.8 * PI {
        return 0;
    }
    let modes = (wavenumber * body.radius()).powi(2) * FEW;
    LEAST.saturating_add(modes.ceil() as usize).min(MOST)
}

/// Points per (k R)^2.
const FEW: f64 = 0.06;
/// Number of points at the lowest wavenumbers that need any.
const LEAST: usize = 8;
/// Most points of a block.
const MOST: usize = 48;

/// So many points of the quarter of the body's inside, spread by Halton's sequence.
pub(crate) fn points(body: &RadiatingBody, count: usize) -> Vec<Vector> {
    let radius = body.radius();
    let half_width = match body.shape() {
        BodyShape::Sphere { radius } => radius,
        BodyShape::Tyre { width, .. } => 0.5 * width,
    };
    let least = LEAST_DEPTH * half_width.min(radius);
    let floor = if body.on_road() { body.middle().min(radius) } else { radius };
    let mut found = Vec::with_capacity(count);
    let mut index = 1;
    while found.len() < count && index < 1_000_000 {
        let [u, v, w] = [2, 3, 5].map(|base| halton(index, base));
        let z = body.middle() - floor + w * (radius + floor);
        let point = [u * radius, v * half_width, z];
        let floor = if body.gap() > 0.0 { body.gap() + least } else { 0.0 };
        if body.depth(point) > least && (!body.on_road() || z > floor) {
            found.push(point);
        }
        index += 1;
    }
    found
}

/// Element of Halton's sequence: the digits of an index mirrored at the point.
fn halton(index: usize, base: usize) -> f64 {
    let (mut rest, mut digit, mut value) = (index, 1.0 / base as f64, 0.0);
    while rest > 0 {
        value += digit * (rest % base) as f64;
        rest /= base;
        digit /= base as f64;
    }
    value
}
