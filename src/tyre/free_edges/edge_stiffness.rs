//! Forces at the edges of the belt: sidewalls, the pressure at the corners, and the cavity.
//!
//! The sidewalls act on the means of v, q and w over a zone of the inner face next to each edge, by the 3 x 3 of one
//! arc, per metre of edge, over (w, q, V), v = -i V and q outwards. The pressure on the face, -p R_i int (dw q_y + dq_y
//! w) dy for a variation dw, dq, is that of a follower but for a point force at the corner. For it there is p between
//! q_c, at the corner, and w_c, the end of the straight line fitted to w over the zone, and -p/2 between q_e and w_e of
//! the arc. With these terms the form is symmetric and has a limit for fine meshes. The cavity acts on the mean of w
//! over the width, less the volume that the arcs sweep (`crate::sidewall`):
//!
//! ```text
//! g = mean w - (2 N_b/(p B)) (cos a_b w_e - sin a_b q_e),   stiffness z B R_i.
//! ```
//!
//! Guided sides have both sidewalls spread over the width instead, and the cavity by a share of it
//! (`crate::tyre::layers::curved`): per width and radian R_i 2/B of the arc over (w, V), and R_i z (B_e/B)^2 in m = 0.

use num_complex::Complex64;

use super::belt::FreeEdges;
use crate::sidewall::FreeEdgeImpedance;
use crate::tyre::layers::curved::air_stiffness;

/// Number of motions on which forces at the edges act.
pub(super) const EDGES: usize = 6;
/// v_e, q_e, w_e: means over the zone.
pub(super) const CIRCUMFERENTIAL: usize = 0;
pub(super) const LATERAL: usize = 1;
pub(super) const RADIAL: usize = 2;
/// q_c, w_c at the corner.
pub(super) const CORNER_LATERAL: usize = 3;
pub(super) const CORNER_RADIAL: usize = 4;
/// g.
pub(super) const SWEPT: usize = 5;

/// Forces of sidewalls, corners and cavity.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeForces {
    /// Forces by motions of both edges together \[N/(m rad)\].
    pub stiffness: [[Complex64; EDGES]; EDGES],
    /// On guided sides: VV, wV, ww per width \[N/(m^2 rad)\].
    pub spread: [Complex64; 3],
    /// Addition to ww of m = 0 by the cavity.
    pub spread_air: Complex64,
}

/// Factors of w_e and q_e in g; 0 without sidewalls.
pub(super) fn swept_by_edges(edges: &FreeEdges) -> [f64; 2] {
    let Some((sidewall, statics)) = edges.sidewall() else { return [0.0; 2] };
    let share = 2.0 * statics.tension / (sidewall.arc().pressure * edges.stack.width);
    [-share * statics.angle.cos(), share * statics.angle.sin()]
}

impl EdgeForces {
    pub(super) const NONE: Self = Self {
        stiffness: [[Complex64::ZERO; EDGES]; EDGES],
        spread: [Complex64::ZERO; 3],
        spread_air: Complex64::ZERO,
    };

    /// Forces in motion of n periods round the tyre; those of the cavity where it is moved.
    pub(super) fn new(edges: &FreeEdges, n: i64, moves_air: bool, s: Complex64) -> Self {
        let (inner, width) = (edges.stack.inner_radius(), edges.stack.width);
        let mut forces = Self::NONE;
        let mut put = |row: usize, column: usize, value: Complex64| {
            forces.stiffness[row][column] = value;
            forces.stiffness[column][row] = value;
        };
        if let Some((sidewall, _)) = edges.sidewall() {
            let both = 2.0 * inner;
            let pressure = sidewall.arc().pressure;
            let FreeEdgeImpedance { guided, radial_lateral, lateral_circumferential } = sidewall.free_edge(n, s);
            put(CIRCUMFERENTIAL, CIRCUMFERENTIAL, both * guided.circumferential);
            put(LATERAL, LATERAL, both * guided.lateral);
            put(RADIAL, RADIAL, both * guided.radial);
            put(CIRCUMFERENTIAL, RADIAL, both * guided.coupling);
            put(CIRCUMFERENTIAL, LATERAL, both * lateral_circumferential);
            put(LATERAL, RADIAL, both * (radial_lateral - 0.5 * pressure));
            put(CORNER_LATERAL, CORNER_RADIAL, Complex64::from(both * pressure));
            forces.spread =
                [guided.circumferential, guided.coupling, guided.radial].map(|entry| entry * (both / width));
        }
        if moves_air && let Some(cavity) = &edges.stack.cavity {
            let air = air_stiffness(cavity, n, s) * inner;
            forces.stiffness[SWEPT][SWEPT] = air * width;
            forces.spread_air = air * edges.swept_share().powi(2);
        }
        forces
    }
}
