//! Love's solution: the surface displacement of an elastic half-space under a uniformly loaded rectangle.
//!
//! A pressure p on the rectangle |x| <= a, |y| <= b displaces the surface point (x, y) inwards by
//! u = p/(pi E*) I(x, y), I = integral over the rectangle of 1/distance, E* = E/(1 - nu^2)
//! (A. E. H. Love, Phil. Trans. R. Soc. A 228 (1929) 377-420; K. L. Johnson, Contact Mechanics (1985), eq. 3.25).
//! The closed form is a difference of four corner terms each of which grows with the distance while the result falls:
//! it loses digits like the distance squared. Therefore:
//!
//! 1. Within ten half-sides of the middle in both directions: the closed form, corner terms x asinh(y/|x|) + y
//!    asinh(x/|y|) that vanish smoothly on the axes (no logarithm of zero anywhere).
//! 2. Farther out: the inner integral along one side is exact, a difference of two asinh rewritten as one `ln_1p`
//!    without cancellation; the outer one, along the direction in which the point lies farther out, is Gauss-Legendre:
//!    the integrand's singularity is at least ten half-sides away, so the error of n points falls like 20^(-2n).
//!
//! Relative error everywhere below 1e-13.

use std::f64::consts::PI;

/// Distance from the middle, in half-sides, beyond which the closed form is not used.
const FAR: f64 = 10.0;

/// Nodes and weights of the non-negative half of the three-, four- and six-point Gauss-Legendre rules on (-1, 1), and
/// the least distance, in half-sides, at which each is exact to rounding.
const GAUSS: [(f64, &[(f64, f64)]); 3] = [
    (
        300.0,
        // Both halves of the rule visit the middle node: its weight 8/9 is halved.
        &[(0.0, 4.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)],
    ),
    (60.0, &[(0.339_981_043_584_856_3, 0.652_145_154_862_546_1), (0.861_136_311_594_052_6, 0.347_854_845_137_453_86)]),
    (
        FAR,
        &[
            (0.238_619_186_083_196_9, 0.467_913_934_572_691_04),
            (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
            (0.932_469_514_203_152, 0.171_324_492_379_170_36),
        ],
    ),
];

/// Inward displacement \[m\] at (`x`, `y`) \[m\] for a pressure of E* (1 Pa per 1 Pa of modulus) on a rectangle of
/// sides `side_x`, `side_y` \[m\] around the origin: I(x, y)/pi. Multiply by p/E* for a pressure p.
///
/// Even in x and in y. Sides must be positive.
pub fn displacement(x: f64, y: f64, side_x: f64, side_y: f64) -> f64 {
    let (a, b) = (0.5 * side_x, 0.5 * side_y);
    let (x, y) = (x.abs(), y.abs());
    let (ratio_x, ratio_y) = (x / a, y / b);
    let integral = if ratio_x.max(ratio_y) <= FAR {
        near(x, y, a, b)
    } else if ratio_x >= ratio_y {
        far(x, y, a, b)
    } else {
        far(y, x, b, a)
    };
    integral / PI
}

/// The closed form: I(x, y).
fn near(x: f64, y: f64, a: f64, b: f64) -> f64 {
    corner(x + a, y + b) - corner(x - a, y + b) - corner(x + a, y - b) + corner(x - a, y - b)
}

/// Integral of 1/distance from the origin over the rectangle between the origin and (x, y), signed.
fn corner(x: f64, y: f64) -> f64 {
    term(x, y) + term(y, x)
}

/// x asinh(y/|x|), 0 for x = 0.
fn term(x: f64, y: f64) -> f64 {
    // Compared by magnitude: y/|x| must not overflow, and x ln(1/x) is far below rounding there.
    if x.abs() < f64::MIN_POSITIVE { 0.0 } else { x * (y / x.abs()).asinh() }
}

/// I(x, y), exact along y, by quadrature along x, for x > `FAR` a and y >= 0.
fn far(x: f64, y: f64, a: f64, b: f64) -> f64 {
    let mut sum = 0.0;
    for (least, rule) in GAUSS {
        if x >= least * a {
            for &(node, weight) in rule {
                sum += weight * (line(x + a * node, y, b) + line(x - a * node, y, b));
            }
            break;
        }
    }
    a * sum
}

/// Integral of 1/distance from a point at distance x > 0 over a line segment from y - b to y + b, y >= 0:
/// ln((q + r_q)/(p + r_p)), q = y + b, p = y - b.
fn line(x: f64, y: f64, b: f64) -> f64 {
    let (p, q) = (y - b, y + b);
    let (r_p, r_q) = (p.hypot(x), q.hypot(x));
    // r_q - r_p = (q^2 - p^2)/(r_q + r_p); and p + r_p = x^2/(r_p - p) where p is negative.
    let excess = 2.0 * b + 4.0 * y * b / (r_q + r_p);
    let start = if p < 0.0 { x * x / (r_p - p) } else { p + r_p };
    (excess / start).ln_1p()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::half_space::reference;

    /// The integral to 17 digits by mpmath: (x, y, side_x, side_y, pi u).
    const PRECISE: [(f64, f64, f64, f64, f64); 55] = [
        (0.0, 0.0, 1.0, 1.0, 3.525494348078172),
        (1.0, 0.0, 1.0, 1.0, 1.038049735904756),
        (0.5, 0.5, 1.0, 1.0, 1.762747174039086),
        (3.0, 4.0, 1.0, 1.0, 0.20033757227705412),
        (4.9, 4.9, 1.0, 1.0, 0.14443363707271434),
        (5.1, 0.25, 1.0, 1.0, 0.196155248897199),
        (12.0, 7.0, 1.0, 1.0, 0.07199713480302991),
        (0.0, 31.0, 1.0, 1.0, 0.032259463021463625),
        (160.0, 3.0, 1.0, 1.0, 0.0062489118239107185),
        (1000.0, 1000.0, 1.0, 1.0, 0.0007071067959179414),
        (1000000.0, 1.0, 1.0, 1.0, 9.999999999995417e-07),
        (0.0, 0.0, 1.0, 10.0, 7.9931274785800905),
        (1.0, 0.0, 1.0, 10.0, 4.716856152639772),
        (0.5, 0.5, 1.0, 10.0, 6.601924820703891),
        (3.0, 4.0, 1.0, 10.0, 2.15358912045031),
        (4.9, 4.9, 1.0, 10.0, 1.4750700053583534),
        (5.1, 0.25, 1.0, 10.0, 1.7374171924576756),
        (12.0, 7.0, 1.0, 10.0, 0.7156821607240732),
        (0.0, 31.0, 1.0, 10.0, 0.3254076588634603),
        (160.0, 3.0, 1.0, 10.0, 0.062479067610991784),
        (1000.0, 1000.0, 1.0, 10.0, 0.007071075251132664),
        (1000000.0, 1.0, 1.0, 10.0, 9.999999999954166e-06),
        (0.0, 0.0, 4.0, 1.0, 6.16915678690031),
        (1.0, 0.0, 4.0, 1.0, 5.893266279558736),
        (0.5, 0.5, 4.0, 1.0, 4.754800338960618),
        (3.0, 4.0, 4.0, 1.0, 0.8017298452155684),
        (4.9, 4.9, 4.0, 1.0, 0.5812551165684834),
        (5.1, 0.25, 4.0, 1.0, 0.8256676573947034),
        (12.0, 7.0, 4.0, 1.0, 0.2891450117306056),
        (0.0, 31.0, 4.0, 1.0, 0.12895405725383313),
        (160.0, 3.0, 4.0, 1.0, 0.024996866821565905),
        (1000.0, 1000.0, 4.0, 1.0, 0.0028284276256128507),
        (1000000.0, 1.0, 4.0, 1.0, 4.000000000003167e-06),
        (0.0, 0.0, 0.001, 1.0, 0.017201805085750796),
        (1.0, 0.0, 0.001, 1.0, 0.0009624237172012537),
        (0.5, 0.5, 0.001, 1.0, 0.0014436356540642986),
        (3.0, 4.0, 0.001, 1.0, 0.00020030572350286926),
        (4.9, 4.9, 0.001, 1.0, 0.00014436979558468332),
        (5.1, 0.25, 0.001, 1.0, 0.00019553385813843045),
        (12.0, 7.0, 0.001, 1.0, 7.197786412439521e-05),
        (0.0, 31.0, 0.001, 1.0, 3.226086221682208e-05),
        (160.0, 3.0, 0.001, 1.0, 6.248891500401496e-06),
        (1000.0, 1000.0, 0.001, 1.0, 7.071067885522496e-07),
        (1000000.0, 1.0, 0.001, 1.0, 9.999999999994583e-10),
        (0.0, 0.0, 2.0, 2000.0, 34.40361017150159),
        (1.0, 0.0, 2.0, 2000.0, 31.63102244926068),
        (0.5, 0.5, 2.0, 2000.0, 33.88036177773721),
        (3.0, 4.0, 2.0, 2000.0, 26.085821004937124),
        (4.9, 4.9, 2.0, 2000.0, 24.074765536144312),
        (5.1, 0.25, 2.0, 2000.0, 23.912606232270434),
        (12.0, 7.0, 2.0, 2000.0, 20.46866888999622),
        (0.0, 31.0, 2.0, 2000.0, 34.40168724835103),
        (160.0, 3.0, 2.0, 2000.0, 10.128281281254482),
        (1000.0, 1000.0, 2.0, 2000.0, 2.8872713081285974),
        (1000000.0, 1.0, 2.0, 2000.0, 0.003999999333332967),
    ];

    #[test]
    fn agrees_with_arbitrary_precision() {
        for (x, y, side_x, side_y, integral) in PRECISE {
            let error = PI * displacement(x, y, side_x, side_y) / integral - 1.0;
            assert!(error.abs() < 2e-13, "({x}, {y}) under {side_x} x {side_y}: relative error {error:.1e}");
        }
    }

    #[test]
    fn agrees_with_the_established_codes() {
        for name in ["ref_G0_halfspace_1x1mm", "ref_G0_halfspace_1x10mm"] {
            let case = reference::Case::open(name);
            let [dx, dy, modulus] = ["dx", "dy", "E_star"].map(|key| case.scalar(key));
            let (shape, expected) = case.array("G");
            for (place, &expected) in expected.iter().enumerate() {
                let (i, j) = (place / shape[1], place % shape[1]);
                let u = displacement(i as f64 * dx, j as f64 * dy, dx, dy) / modulus;
                // The reference is the plain closed form: its digits are lost like distance squared / cell area.
                let distance_squared = (i as f64 * dx).powi(2) + (j as f64 * dy).powi(2);
                let lost = 1e-15 * (1.0 + distance_squared / (dx * dy));
                assert!((u / expected - 1.0).abs() < 1e-12f64.max(10.0 * lost), "{name} ({i}, {j}): {u} {expected}");
            }
        }
    }

    #[test]
    fn is_continuous_where_the_rules_change() {
        for (side_x, side_y) in [(1.0, 1.0), (0.01, 1.0), (1e-4, 3.0)] {
            for limit in [FAR, 60.0, 300.0] {
                for y in [0.0, 0.3, 0.5, 2.0] {
                    let x = 0.5 * side_x * limit;
                    let at = |factor: f64| displacement(x * factor, y * side_y, side_x, side_y);
                    let (inside, outside) = (at(1.0 - 1e-15), at(1.0 + 1e-15));
                    assert!((inside / outside - 1.0).abs() < 1e-12, "x = {x}, y = {y}, sides {side_x}, {side_y}");
                }
            }
        }
    }

    #[test]
    fn becomes_boussinesqs_point_force_far_away() {
        // The next term of the multipole series is (side/r)^2/12 or less.
        for r in [1e3, 1e5, 1e9] {
            let u = displacement(0.6 * r, 0.8 * r, 1.0, 1.0);
            assert!((u * PI * r - 1.0).abs() < 0.1 / (r * r) + 1e-14);
        }
    }

    #[test]
    fn is_finite_on_edges_and_corners() {
        for (x, y) in [(0.5, 0.0), (0.5, 0.25), (0.0, 0.25), (0.0, 0.0), (f64::MIN_POSITIVE, 0.25)] {
            let u = displacement(x, y, 1.0, 0.5);
            assert!(u.is_finite() && u > 0.0, "({x}, {y}): {u}");
        }
    }
}
