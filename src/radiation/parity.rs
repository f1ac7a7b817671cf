//! Parity: a field over a body that is mirror-symmetric fore-aft and across, as four fields on its quarter.
//!
//! With the mirrors g = (x -> -x if bit 0, y -> -y if bit 1) and chi_b(g) = +-1, a field f has the parts
//! f_b(x) = 1/4 sum_g chi_b(g) f(g x) on the quarter, f(g x) = sum_b chi_b(g) f_b(x). The boundary integral keeps the
//! parts apart: (K f)_b(x) = sum_g chi_b(g) int over the quarter of dG/dn'(g x, y) f_b(y) dS. One kernel each for the
//! four mirrors and for their images in the road serves all four blocks.

use super::body::Vector;

/// Mirrors of a point: none, fore-aft, across, both.
pub(crate) const MIRRORS: usize = 4;

/// Symmetry of a field: even or odd fore-aft and across.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ParityBlock {
    /// True if it changes its sign with x.
    pub fore_aft_odd: bool,
    /// True if it changes its sign with y.
    pub across_odd: bool,
}

impl ParityBlock {
    /// All four, those even across first.
    pub const ALL: [Self; 4] = [
        Self { fore_aft_odd: false, across_odd: false },
        Self { fore_aft_odd: true, across_odd: false },
        Self { fore_aft_odd: false, across_odd: true },
        Self { fore_aft_odd: true, across_odd: true },
    ];

    /// The two that are even across: enough for forces and vibration centred on the tread.
    pub const EVEN_ACROSS: [Self; 2] = [Self::ALL[0], Self::ALL[1]];

    /// chi of a mirror: 1 or -1.
    pub fn sign(&self, mirror: usize) -> f64 {
        let odd = (self.fore_aft_odd && mirror & 1 != 0) ^ (self.across_odd && mirror & 2 != 0);
        if odd { -1.0 } else { 1.0 }
    }

    /// Part of a function with this symmetry, at a point.
    pub fn part<T>(&self, point: Vector, function: impl Fn(Vector) -> T) -> T
    where
        T: std::ops::Mul<f64, Output = T> + std::iter::Sum,
    {
        (0..MIRRORS).map(|mirror| function(mirrored(point, mirror)) * (0.25 * self.sign(mirror))).sum()
    }
}

/// Mirror of a point: bit 0 fore-aft, bit 1 across, bit 2 in the road.
pub(crate) fn mirrored([x, y, z]: Vector, mirror: usize) -> Vector {
    let sign = |bit: usize| if mirror & bit == 0 { 1.0 } else { -1.0 };
    [sign(1) * x, sign(2) * y, sign(4) * z]
}
