//! The section of a belt with free edges in motion of n periods round the tyre, and its compliance at s.
//!
//! Unknowns are the amplitudes of waves and lifts ([`super::lateral_shapes`]) by polynomials across the layers, and
//! their energy is that of [`lateral_split`](crate::tyre::layers::lateral_split). With a wave's matrix K_m over (V, P,
//! w), D_m = S + k_m S_PP the force on it by the slope of P, and f the amplitudes of the first family of q lifts, a
//! wave is moved by N_m beta_m D_m f and by nothing else of the lifts. So the lifts have
//!
//! ```text
//! Z = Z_lifts - sum_m N_m beta_m^2 D_m^T K_m^-1 D_m        (first family of q),
//! Z_lifts: q, q: int psi psi U + int psi' psi' S,    w, v: int chi chi U + int psi psi T,
//!          w or v, q: int chi psi' S - int psi psi T,
//! ```
//!
//! and a functional that is p_m on wave m and l on the lifts is d = l - sum_m beta_m p_m^T K_m^-1 D_m on the lifts
//! after the waves are eliminated. The compliance between functionals is sum_m p_m^T K_m^-1 p_m/N_m + d^T Z^-1 d.
//!
//! 1. each wave: its layers without their interior, then its faces, are eliminated: p_m^T K_m^-1 p_m, D_m^T K_m^-1 D_m
//!    and p_m^T K_m^-1 D_m remain;
//! 2. lifts: layer by layer all interior polynomials but those of the first family of q, which the waves couple;
//! 3. the rest: functionals remain.
//!
//! Error against finite elements of the section (`references_tests`), with the resolution of runs and of reference
//! values (`super::belt`): at most 3e-3 and 8e-4 of C between waves m <= 8, 1.4e-3 and 3e-4 of a strip's. Edge layers
//! are as thin as the layers, which waves up to M = 16 do not resolve: hence the families with rates.
//!
//! Cost with the resolution of runs: 0.7 million complex multiplications and the sidewall's edge, together 0.8 ms.

use num_complex::Complex64;

use super::belt::FreeEdges;
use super::correction::EdgeCorrection;
use super::edge_stiffness::{
    CIRCUMFERENTIAL, CORNER_LATERAL, CORNER_RADIAL, EDGES, EdgeForces, LATERAL, RADIAL, SWEPT, swept_by_edges,
};
use super::lateral_shapes::{LateralShapes, LateralWave, Parity};
use super::section_compliance::{HELD, MOTIONS, SectionCompliance};
use crate::numeric::ComplexSymmetricMatrix;
use crate::tyre::layers::lateral_split::{Component, LateralSplit, LateralSplitAt};

/// Angular frequency of a rigid belt on the springs that hold it \[1/s\]: that of a tyre on its sidewalls.
const HELD_RATE: f64 = 600.0;

/// Families of v lifts: edge layers have hardly any motion round the tyre.
const CIRCUMFERENTIAL_FAMILIES: usize = 1;

/// The section in motion of n periods round the tyre and of one parity across, for any s.
#[derive(Debug)]
pub struct Section<'a> {
    edges: &'a FreeEdges,
    n: i64,
    parity: Parity,
    layers: Vec<LateralSplit>,
}

/// Places of the unknowns that lifts of all layers share: functionals come before them.
struct SharedPlaces {
    functionals: usize,
    /// Number of faces, those inside counted once.
    faces: usize,
    /// Number of polynomials of the first family of q.
    first_family: usize,
    /// Unknowns of a face past the first family of q.
    others: Vec<(Component, usize)>,
}

impl FreeEdges {
    /// The section in motion of n periods round the tyre, n of either sign, and of one parity.
    pub fn section(&self, n: i64, parity: Parity) -> Section<'_> {
        Section { edges: self, n, parity, layers: self.layers(n) }
    }
}

impl SharedPlaces {
    fn count(&self) -> usize {
        self.functionals + self.first_family + self.faces * self.others.len()
    }

    /// Place of an unknown of a face past the first family of q.
    fn on_face(&self, face: usize, other: usize) -> usize {
        self.functionals + self.first_family + face * self.others.len() + other
    }

    fn on_face_of(&self, face: usize, component: Component, family: usize) -> Option<usize> {
        if (component, family) == (Component::Lateral, 0) {
            return Some(self.functionals + face);
        }
        self.others.iter().position(|&other| other == (component, family)).map(|other| self.on_face(face, other))
    }
}

impl Section<'_> {
    /// Difference between free edges and guided sides with spread sidewalls, at s \[1/s\].
    pub fn at(&self, s: Complex64) -> EdgeCorrection {
        let forces = EdgeForces::new(self.edges, self.n, self.parity == Parity::Even, s);
        let compliance = self.compliance(s, &forces);
        EdgeCorrection::new(self.edges.stack.width, self.edges.shapes(self.parity), &compliance, &forces)
    }

    /// Compliance between the edges' motions and the waves' amplitudes on the tread, without forces at the edges; of
    /// `forces`, the guided waves take the spread ones.
    pub(super) fn compliance(&self, s: Complex64, forces: &EdgeForces) -> SectionCompliance {
        let shapes = self.edges.shapes(self.parity);
        let layers = self.layers_at(s);
        let places = self.places(shapes);
        let mut matrix = ComplexSymmetricMatrix::zeros(places.count());
        let springs = self.springs();
        self.add_functionals(shapes, &places, springs, &mut matrix);
        let waves = shapes.waves.iter().enumerate();
        let alone = waves.map(|wave| self.add_wave(&layers, &places, wave, forces, &mut matrix));
        let (held, guided) = alone.collect();
        for (index, layer) in layers.iter().enumerate() {
            self.add_lifts(shapes, &places, index, layer, &mut matrix);
        }
        matrix.eliminate(places.functionals);
        SectionCompliance { negative: matrix, springs, held, guided }
    }

    /// Springs that hold V, P and w: with them a rigid belt oscillates at [`HELD_RATE`].
    fn springs(&self) -> [f64; HELD] {
        let width = self.edges.stack.width;
        let sideways = self.edges.mass() * width * HELD_RATE * HELD_RATE;
        match self.parity {
            Parity::Even => [sideways, 0.0, sideways],
            // Of the lifts y, 1, y.
            Parity::Odd => [sideways * width * width / 12.0, sideways, sideways * width * width / 12.0],
        }
    }

    /// Energy of the layers, that of foundation and pressure on the inner face included.
    fn layers_at(&self, s: Complex64) -> Vec<LateralSplitAt> {
        let stack = &self.edges.stack;
        let mut layers: Vec<LateralSplitAt> = self.layers.iter().map(|layer| layer.at(s)).collect();
        let foundation = stack.foundation(s);
        let face = |ky: f64| stack.face_of_short_wave(self.n, ky).impedance(s, foundation);
        let (still, strained) = (face(0.0), face(1.0));
        if let Some(inner) = layers.first_mut() {
            for row in 0..3 {
                for column in 0..=row {
                    let value = still[row][column];
                    inner.uniform.add(row, column, value * stack.inner_radius());
                    inner.strained.add(row, column, (strained[row][column] - value) * stack.inner_radius());
                }
            }
        }
        layers
    }

    fn places(&self, shapes: &LateralShapes) -> SharedPlaces {
        let families = shapes.lifts.len();
        let others = (1..families)
            .map(|family| (Component::Lateral, family))
            .chain((0..families).map(|family| (Component::Radial, family)))
            .chain((0..CIRCUMFERENTIAL_FAMILIES).map(|family| (Component::Circumferential, family)));
        let faces = self.layers.len() + 1;
        let interior: usize = self.layers.iter().map(|layer| layer.polynomials() - 2).sum();
        SharedPlaces {
            functionals: MOTIONS + shapes.waves.len(),
            faces,
            first_family: faces + interior,
            others: others.collect(),
        }
    }

    /// Place among the first family of q of a polynomial of a layer.
    fn in_first_family(&self, layer: usize, polynomial: usize) -> usize {
        if polynomial < 2 {
            return layer + polynomial;
        }
        let before: usize = self.layers[..layer].iter().map(|layer| layer.polynomials() - 2).sum();
        self.layers.len() + 1 + before + polynomial - 2
    }

    /// Motions of the edges by the lifts on the inner face, and springs there.
    fn add_functionals(
        &self,
        shapes: &LateralShapes,
        places: &SharedPlaces,
        springs: [f64; HELD],
        matrix: &mut ComplexSymmetricMatrix,
    ) {
        let [by_radial, by_lateral] = swept_by_edges(self.edges);
        for (family, zone) in shapes.lifts.iter().enumerate() {
            let corner = if family == 0 { 1.0 } else { 0.0 };
            for (component, motion, value) in [
                (Component::Circumferential, CIRCUMFERENTIAL, zone.mean),
                (Component::Lateral, LATERAL, zone.lateral),
                (Component::Lateral, CORNER_LATERAL, corner),
                (Component::Lateral, SWEPT, by_lateral * zone.lateral),
                (Component::Radial, RADIAL, zone.mean),
                (Component::Radial, CORNER_RADIAL, zone.at_edge),
                (Component::Radial, SWEPT, by_radial * zone.mean),
            ] {
                if let Some(place) = places.on_face_of(0, component, family) {
                    matrix.add(motion, place, value.into());
                }
            }
        }
        if self.parity == Parity::Odd {
            for component in [Component::Circumferential, Component::Lateral, Component::Radial] {
                if let Some(place) = places.on_face_of(0, component, 0) {
                    matrix.add(EDGES + component as usize, place, Complex64::ONE);
                    matrix.add(place, place, springs[component as usize].into());
                }
            }
        }
    }

    /// Motions of the edges, and those held, by V, P, w of a wave on the inner face.
    fn edge_motions(&self, wave: &LateralWave) -> [[f64; 3]; MOTIONS] {
        let [by_radial, by_lateral] = swept_by_edges(self.edges);
        let zone = wave.zone;
        // The mean over the width.
        let mean = if wave.number == 0 { 1.0 } else { 0.0 };
        let mut motions = [[0.0; 3]; MOTIONS];
        motions[CIRCUMFERENTIAL] = [zone.mean, 0.0, 0.0];
        motions[LATERAL] = [0.0, zone.lateral, 0.0];
        motions[RADIAL] = [0.0, 0.0, zone.mean];
        motions[CORNER_RADIAL] = [0.0, 0.0, zone.at_edge];
        motions[SWEPT] = [0.0, by_lateral * zone.lateral, mean + by_radial * zone.mean];
        if wave.number == 0 {
            motions[EDGES + Component::Circumferential as usize] = [1.0, 0.0, 0.0];
            motions[EDGES + Component::Radial as usize] = [0.0, 0.0, 1.0];
        }
        motions
    }

    /// Adds a wave, eliminated; returns its compliance alone, per force on its amplitude: on the springs, and with
    /// spread sidewalls.
    fn add_wave(
        &self,
        layers: &[LateralSplitAt],
        places: &SharedPlaces,
        (index, wave): (usize, &LateralWave),
        forces: &EdgeForces,
        matrix: &mut ComplexSymmetricMatrix,
    ) -> (Complex64, Complex64) {
        // Motions, V and w of the inner face, w on the tread; then the first family of q, then V, P, w of each face.
        let (inner, tread) = ([MOTIONS, MOTIONS + 1], MOTIONS + 2);
        let functionals = tread + 1;
        let faces = functionals + places.first_family;
        let mut whole = ComplexSymmetricMatrix::zeros(faces + 3 * places.faces);
        // 1. Functionals, and the springs.
        for (motion, values) in self.edge_motions(wave).into_iter().enumerate() {
            for (component, value) in values.into_iter().enumerate() {
                whole.add(motion, faces + component, value.into());
            }
        }
        whole.add(tread, faces + 3 * places.faces - 1, Complex64::ONE);
        let spring = if wave.number == 0 { self.springs()[Component::Radial as usize] / wave.norm } else { 0.0 };
        for (functional, component) in inner.into_iter().zip([Component::Circumferential, Component::Radial]) {
            let place = faces + component as usize;
            whole.add(functional, place, Complex64::ONE);
            whole.add(place, place, spring.into());
        }
        // 2. Layers, without their interior.
        for (layer, (split, at)) in self.layers.iter().zip(layers).enumerate() {
            let polynomials = split.polynomials();
            let mut part = wave_of_layer(split, at, wave);
            part.eliminate(polynomials + 6);
            let q = (0..polynomials).map(|polynomial| functionals + self.in_first_family(layer, polynomial));
            let on_faces = (0..6).map(|row| faces + 3 * layer + row);
            whole.add_at(&q.chain(on_faces).collect::<Vec<_>>(), &part);
        }
        // 3. Faces. The result is negative: -p^T K^-1 p and so on.
        whole.eliminate(faces);
        let scale = |row: usize| if row < functionals { wave.norm.recip() } else { wave.boundary };
        let place = |row: usize| match row {
            row if row < MOTIONS => row,
            row if row == tread => MOTIONS + index,
            row => places.functionals + row - functionals,
        };
        let rows = || (0..faces).filter(|row| !inner.contains(row));
        for row in rows() {
            for column in rows().take_while(|&column| column <= row) {
                if (row, column) != (tread, tread) {
                    // Products of 1/N_m and beta_m, times N_m.
                    let scale = scale(row) * scale(column) * wave.norm;
                    matrix.add(place(row), place(column), whole.at(row, column) * scale);
                }
            }
        }
        // 4. The wave alone: with forces F on V and w of the inner face, C - c^T F (1 + Y F)^-1 c.
        let [circumferential, coupling, radial] = forces.spread;
        let radial = if wave.number == 0 { radial + forces.spread_air } else { radial };
        let force = [[circumferential - spring, coupling], [coupling, radial - spring]];
        let [y_v, y_vw, y_w] = [[0, 0], [0, 1], [1, 1]].map(|[i, j]| -whole.at(inner[i], inner[j]));
        let [c_v, c_w] = inner.map(|row| -whole.at(row, tread));
        let resisted = [
            [1.0 + y_v * force[0][0] + y_vw * force[1][0], y_v * force[0][1] + y_vw * force[1][1]],
            [y_vw * force[0][0] + y_w * force[1][0], 1.0 + y_vw * force[0][1] + y_w * force[1][1]],
        ];
        let determinant = resisted[0][0] * resisted[1][1] - resisted[0][1] * resisted[1][0];
        let moved = [
            (resisted[1][1] * c_v - resisted[0][1] * c_w) / determinant,
            (resisted[0][0] * c_w - resisted[1][0] * c_v) / determinant,
        ];
        let held = -whole.at(tread, tread);
        let given = [0, 1].map(|row| force[row][0] * moved[0] + force[row][1] * moved[1]);
        let guided = held - c_v * given[0] - c_w * given[1];
        (held / wave.norm, guided / wave.norm)
    }

    /// Adds the lifts of a layer, without interior polynomials past the first family of q.
    fn add_lifts(
        &self,
        shapes: &LateralShapes,
        places: &SharedPlaces,
        index: usize,
        at: &LateralSplitAt,
        matrix: &mut ComplexSymmetricMatrix,
    ) {
        let split = &self.layers[index];
        let polynomials = split.polynomials();
        let others = &places.others;
        // 1. Unknowns in the order of elimination, the last first; places of those that stay.
        let first = (0..polynomials).map(|polynomial| (Component::Lateral, 0, polynomial));
        let rest = (0..polynomials)
            .flat_map(|polynomial| others.iter().map(move |&(component, family)| (component, family, polynomial)));
        let unknowns: Vec<(Component, usize, usize)> = first.chain(rest).collect();
        let kept = polynomials + 2 * others.len();
        let first = (0..polynomials).map(|polynomial| places.functionals + self.in_first_family(index, polynomial));
        let on_faces = (0..2).flat_map(|face| (0..others.len()).map(move |other| places.on_face(index + face, other)));
        let kept_places: Vec<usize> = first.chain(on_faces).collect();
        // 2. Energy.
        let mut part = ComplexSymmetricMatrix::zeros(unknowns.len());
        let rows: Vec<usize> =
            unknowns.iter().map(|&(component, _, polynomial)| split.place(component, polynomial)).collect();
        for (row, &(component, family, _)) in unknowns.iter().enumerate() {
            for (column, &(other_component, other_family, _)) in unknowns[..=row].iter().enumerate() {
                let (i, j) = (rows[row], rows[column]);
                let is_lateral = [component, other_component].map(|component| component == Component::Lateral);
                let value = match is_lateral {
                    [true, true] => {
                        let [uniform, strained] =
                            shapes.lateral.each_ref().map(|products| products[(family, other_family)]);
                        at.uniform.at(i, j) * uniform + at.strained.at(i, j) * strained
                    }
                    [false, false] => {
                        let [uniform, tilted] =
                            shapes.radial.each_ref().map(|products| products[(family, other_family)]);
                        at.uniform.at(i, j) * uniform + at.tilted.at(i, j) * tilted
                    }
                    [is_first_lateral, _] => {
                        let (radial, lateral) =
                            if is_first_lateral { (other_family, family) } else { (family, other_family) };
                        let [strained, tilted] = shapes.mixed.each_ref().map(|products| products[(radial, lateral)]);
                        at.strained.at(i, j) * strained - at.tilted.at(i, j) * tilted
                    }
                };
                part.add(row, column, value);
            }
        }
        // 3. Elimination.
        part.eliminate(kept);
        matrix.add_at(&kept_places, &part);
    }
}

/// A wave in a layer: forces by the first family of q, faces, interior.
fn wave_of_layer(split: &LateralSplit, at: &LateralSplitAt, wave: &LateralWave) -> ComplexSymmetricMatrix {
    let (polynomials, ky) = (split.polynomials(), wave.wavenumber);
    let mut part = ComplexSymmetricMatrix::zeros(4 * polynomials);
    let components = [Component::Circumferential, Component::Lateral, Component::Radial];
    let unknowns = components.into_iter().flat_map(|component| (0..polynomials).map(move |a| (component, a)));
    let unknowns: Vec<(bool, usize)> = unknowns
        .map(|(component, polynomial)| (component == Component::Lateral, split.place(component, polynomial)))
        .collect();
    // 1. K_m.
    for &(is_lateral, i) in &unknowns {
        for &(is_other_lateral, j) in unknowns.iter().filter(|&&(_, j)| j <= i) {
            let slope = if is_lateral == is_other_lateral { ky * ky } else { ky };
            let sloped = (at.strained.at(i, j) + at.tilted.at(i, j)) * slope;
            let value = at.uniform.at(i, j) + sloped;
            // A wave that is uniform across has no P: it is held, by a unit stiffness.
            let value = match (wave.number == 0, is_lateral || is_other_lateral, i == j) {
                (true, true, true) => Complex64::ONE,
                (true, true, false) => Complex64::ZERO,
                _ => value,
            };
            part.add(polynomials + i, polynomials + j, value);
        }
    }
    // 2. D_m.
    for &(is_lateral, i) in &unknowns {
        for polynomial in 0..polynomials {
            let strained = at.strained.at(i, split.place(Component::Lateral, polynomial));
            part.add(polynomials + i, polynomial, if is_lateral { strained * ky } else { strained });
        }
    }
    part
}
