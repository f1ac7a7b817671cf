//! Compliance of the section between motions and waves, without and with forces at its edges.
//!
//! A section that nothing holds moves as a rigid body: round the tyre, in its plane, sideways, tilting. Its compliance
//! is then without bound at rest, and the difference of large numbers that sidewalls make of it would be lost. So
//! springs hold it, whose forces are taken away again together with those of the edges: with Y the compliance on the
//! springs, K the stiffness at the edges less the springs,
//!
//! ```text
//! Y' = Y - Y_e^T K (1 + Y_ee K)^-1 Y_e.
//! ```
//!
//! Rigid motions of even parity are in the wave m = 0, whose V and w on the inner face they hold; those of odd parity
//! in the lifts without a rate, of which they hold V, P and w there.

use faer::Mat;
use faer::linalg::solvers::Solve;
use num_complex::Complex64;

use super::edge_stiffness::EDGES;
use crate::numeric::ComplexSymmetricMatrix;

/// Motions that springs hold: V, P, w.
pub(super) const HELD: usize = 3;
/// Motions in all: those of the edges, then those held.
pub(super) const MOTIONS: usize = EDGES + HELD;

/// Compliance on the springs.
#[derive(Clone, Debug)]
pub(super) struct SectionCompliance {
    /// -Y: motions, then amplitudes of the waves on the tread, without the diagonal of these waves alone.
    pub negative: ComplexSymmetricMatrix,
    /// Springs of the motions held \[N/(m rad)\].
    pub springs: [f64; HELD],
    /// Diagonal of the waves alone, on the springs \[m/(N/rad)\].
    pub held: Vec<Complex64>,
    /// Diagonal of the guided waves with spread sidewalls \[m/(N/rad)\].
    pub guided: Vec<Complex64>,
}

impl SectionCompliance {
    /// Y': without the springs, under forces at the edges.
    pub(super) fn under(&self, edges: &[[Complex64; EDGES]; EDGES]) -> Mat<Complex64> {
        let count = MOTIONS + self.held.len();
        let compliance = Mat::from_fn(count, count, |i, j| -self.negative.at(i, j));
        let stiffness = Mat::from_fn(MOTIONS, MOTIONS, |i, j| match (i.checked_sub(EDGES), j.checked_sub(EDGES)) {
            (None, None) => edges[i][j],
            (Some(held), Some(other)) if held == other => Complex64::from(-self.springs[held]),
            _ => Complex64::ZERO,
        });
        let motions = compliance.subrows(0, MOTIONS);
        let resisted = Mat::<Complex64>::identity(MOTIONS, MOTIONS) + motions.subcols(0, MOTIONS) * &stiffness;
        let forces = &stiffness * resisted.partial_piv_lu().solve(motions);
        let taken = motions.transpose() * forces;
        // Symmetric but for rounding: the mean.
        Mat::from_fn(count, count, |i, j| compliance[(i, j)] - 0.5 * (taken[(i, j)] + taken[(j, i)]))
    }
}
