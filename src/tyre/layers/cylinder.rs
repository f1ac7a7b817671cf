//! The curved tyre, wave by wave: whatever in C and D at (n, m) does not depend on s is computed once, so that a value
//! at s costs little more than the flat plate's.
//!
//! In each layer the displacements are polynomials in r (`super::radial_polynomials`), and the field equations of
//! [`super::curved`] hold in their weak form, with the energy
//!
//! ```text
//! int [lambda (e_r + e_t + e_y)^2 + 2 mu (e_r^2 + e_t^2 + e_y^2) + mu (g_rt^2 + g_ry^2 + g_ty^2)
//!      + S ((n^2 + 1)(V^2 + w^2) + 4 n V w + n^2 P^2)/r^2 + (rho s^2 + S_y k_y^2)(V^2 + P^2 + w^2)] r dr,
//! e_r = w',  e_t = (n V + w)/r,  e_y = k_y P,  g_rt = V' - (V + n w)/r,  g_ry = P' - k_y w,  g_ty = k_y V + n P/r.
//! ```
//!
//! lambda/mu is real, so that a layer is mu(s) K + rho s^2 M + G with real symmetric matrices. The eigenvectors of K
//! between held faces (M is the identity there) reduce it to its two faces (Craig & Bampton 1968, *AIAA J.* 6, 1313):
//!
//! ```text
//! Z(s) = mu K' + rho s^2 M' + G' - sum_j c_j c_j^T/(mu lambda_j + rho s^2 + gamma_j),   c_j = rho s^2 m_j + g_j.
//! ```
//!
//! No mode is left out. What is neglected: coupling of different modes by the prestress where mu(s) is not mu_0 (see
//! `super::layer_modes`), at most 5e-7 of C. The error of C is about the square of the displacement's, and falls with
//! the degree faster than any power.
//!
//! Cost: a wave takes an eigenvalue problem of some 40 unknowns per layer; a value two real products for each mode and
//! entry of a symmetric 6x6 matrix and one 3x3 inverse per layer.

use std::sync::{Arc, OnceLock};

use num_complex::Complex64;
use pulp::Simd;

use super::compliance::{Matrix3, NormalCompliance};
use super::curved::{CurvedStack, InnerFace};
use super::elasticity::{CordParts, ElasticityAt, MaterialRatios};
use super::faces::{Block, Climb, carrying, inverse, product, to_fields};
use super::layer_modes::{LayerModes, LayerValues};
use super::layer_wave::LayerWave;
use super::material;
use super::radial_polynomials::RadialProducts;
use crate::numeric::{ComplexField, Lanes, MOST_LANES};
use crate::scene::{Layer, MOST_CORD_LOSSES, Tyre};
use crate::sidewall::{BothWays, EdgeImpedance, SidewallAt};

/// |s| at which the prestress is part of the stiffness, over the largest |s|: modes matter where waves are short.
const REFERENCE: f64 = 0.3;
/// Bounds of the polynomials' degree across a layer.
const LEAST_DEGREE: usize = 6;
const HIGHEST_DEGREE: usize = 64;

/// A curved tyre as far as its waves need it: any of them can be prepared.
#[derive(Debug)]
pub struct Cylinder {
    stack: CurvedStack,
    layers: Vec<CurvedLayer>,
    tolerance: f64,
}

#[derive(Debug)]
struct CurvedLayer {
    layer: Layer,
    /// Radius of the inner face \[m\].
    from: f64,
    /// Square of the largest wavenumber of shear waves \[1/m^2\].
    shear_waves: f64,
    /// |mu| at [`REFERENCE`] times the largest |s| \[Pa\].
    shear: f64,
    /// Cords, and their f at the same |s|.
    cords: CordParts,
    fibres: [f64; MOST_CORD_LOSSES],
    /// Constants of the material over mu.
    ratios: MaterialRatios,
    /// Growth of displacements across the layer over that along it: see [`super::elasticity`].
    steepness: [f64; 2],
    /// S, S_y \[Pa\].
    prestress: [f64; 2],
    /// rho Omega^2 \[Pa/m^2\].
    softening: f64,
    /// True if s = 0 is the only s.
    at_rest: bool,
    /// By degree.
    products: Vec<OnceLock<RadialProducts>>,
}

/// Values that depend on s alone, at one s or at several in lockstep.
#[derive(Clone, Debug)]
pub struct CylinderAt<T = Complex64> {
    pub(super) layers: Vec<LayerValues<T>>,
    /// Tangential and normal stiffness of foundation and sidewalls, inertia included \[N/m^3\].
    pub(super) foundation: [T; 2],
    pub(super) s: T,
    /// Sidewalls as arcs, lane by lane; empty on a foundation.
    sidewalls: Vec<Arc<SidewallAt>>,
}

/// Motion under a normal traction of 1 Pa on the surface \[m/Pa\].
#[derive(Clone, Copy, Debug)]
pub struct EdgeMotion<T = Complex64> {
    /// Outward motion of the surface, C_zz.
    pub surface: T,
    /// Outward motion w of the inner face.
    pub radial: T,
    /// V of the inner face: its circumferential motion is -i V.
    pub circumferential: T,
}

/// A wave (n, m), prepared for any s.
#[derive(Clone, Debug)]
pub struct CylinderWave {
    layers: Vec<LayerModes>,
    inner: InnerFace,
    /// Radius of the outer face \[m\].
    radius: f64,
    turns: bool,
}

impl Cylinder {
    /// Bytes of the products of polynomials of all degrees in a layer.
    pub const PRODUCT_BYTES: f64 = RadialProducts::bytes(HIGHEST_DEGREE);

    /// For C up to |s| = `largest_s` \[1/s\] within a relative `tolerance`.
    pub fn new(tyre: &Tyre, largest_s: f64, tolerance: f64) -> Self {
        Self::of(CurvedStack::new(tyre), largest_s, tolerance)
    }

    /// As [`Self::new`], for a given stack.
    pub fn of(stack: CurvedStack, largest_s: f64, tolerance: f64) -> Self {
        let layers = stack.layers_by_radius().map(|(layer, from)| {
            let shear = material::shear_modulus(&layer.material, largest_s.into());
            let cords = CordParts::new(layer);
            CurvedLayer {
                fibres: cords.at((REFERENCE * largest_s).into()).map(|factor| factor.norm()),
                cords,
                ratios: MaterialRatios::new(layer),
                steepness: ElasticityAt::new(layer, (REFERENCE * largest_s).into()).steepness(),
                layer: layer.clone(),
                from,
                shear_waves: layer.material.density * largest_s * largest_s / shear.norm(),
                shear: material::shear_modulus(&layer.material, (REFERENCE * largest_s).into()).norm(),
                prestress: stack.rotation.prestress(layer, from),
                softening: stack.rotation.softening(layer.material.density),
                at_rest: largest_s <= 0.0,
                products: (0..=HIGHEST_DEGREE).map(|_| OnceLock::new()).collect(),
            }
        });
        Self { layers: layers.collect(), stack, tolerance }
    }

    /// Moduli, inertia, foundation and sidewalls at s \[1/s\].
    pub fn at(&self, s: Complex64) -> CylinderAt {
        let layers = self
            .layers
            .iter()
            .map(|CurvedLayer { layer, cords, .. }| LayerValues::new(layer, cords, &self.stack.rotation, s))
            .collect();
        let sidewall = self.stack.sidewall.as_ref().map(|sidewall| Arc::new(sidewall.at(s, self.stack.reach())));
        CylinderAt { layers, foundation: self.stack.foundation(s), s, sidewalls: sidewall.into_iter().collect() }
    }

    /// Wave of n periods round the tyre and of the lateral number m.
    pub fn wave(&self, n: i64, m: usize) -> CylinderWave {
        self.wave_on_ring(n as f64, m)
    }

    /// The same with any number of periods: air and sidewalls act as for the nearest whole one.
    pub(in crate::tyre) fn wave_on_ring(&self, n: f64, m: usize) -> CylinderWave {
        self.with_face(n, self.stack.inner_face(n.round() as i64, m))
    }

    /// Wave of any wavenumbers \[1/m\] on the outer face, so short that it hardly moves the inner one: the pressure
    /// there acts as for the nearest whole number of periods.
    pub fn short_wave(&self, kx: f64, ky: f64) -> CylinderWave {
        let n = kx * self.stack.radius;
        self.with_face(n, self.stack.face_of_short_wave(n.round() as i64, ky))
    }

    fn with_face(&self, n: f64, inner: InnerFace) -> CylinderWave {
        CylinderWave {
            layers: self.layers.iter().map(|layer| layer.modes(n, inner.ky, self.tolerance)).collect(),
            inner,
            radius: self.stack.radius,
            turns: self.stack.rotation.turns(),
        }
    }
}

impl CurvedLayer {
    /// Degree of the polynomials: displacements ~ exp(a x), x in (-1, 1), have Legendre coefficients of about
    /// (a/2)^p/p!, and the error of C is the square of the first omitted one. A thin layer's bending, which is soft
    /// beside its stretching, needs no less than the least degree. Cords make displacements steeper across the layer.
    fn degree(&self, n: f64, ky: f64, tolerance: f64) -> usize {
        let [along, across] = self.steepness;
        let k_squared = (along * n / self.from).powi(2) + (across * ky).powi(2);
        let a = 0.5 * self.layer.thickness * (k_squared + self.shear_waves).sqrt();
        let mut coefficient = 1.0;
        for degree in 1..HIGHEST_DEGREE {
            coefficient *= 0.5 * a / degree as f64;
            if degree as f64 > a && coefficient * coefficient < tolerance {
                return (degree + 1).clamp(LEAST_DEGREE, HIGHEST_DEGREE);
            }
        }
        HIGHEST_DEGREE
    }

    fn modes(&self, n: f64, ky: f64, tolerance: f64) -> LayerModes {
        let Self { layer, from, shear, .. } = self;
        let degree = self.degree(n, ky, tolerance);
        let products = self.products[degree].get_or_init(|| RadialProducts::new(*from, layer.thickness, degree));
        let poisson = layer.material.poisson;
        let lame_ratio = 2.0 * poisson / (1.0 - 2.0 * poisson);
        let wave = LayerWave {
            n,
            ky,
            lame_ratio,
            orthotropic: layer.orthotropic.as_ref().map(|_| self.ratios),
            prestress: self.prestress,
            softening: self.softening,
            cords: &self.cords.parts,
            fibres: self.fibres,
            shear: *shear,
            shear_waves: self.shear_waves,
            at_rest: self.at_rest,
        };
        LayerModes::new(&wave, products)
    }
}

impl<S: Simd> CylinderAt<Lanes<S>> {
    /// Several s side by side, as many as there are lanes.
    #[inline(always)]
    pub fn lanes(simd: S, single: [&CylinderAt; MOST_LANES]) -> Self {
        let pair = |of: &dyn Fn(&CylinderAt) -> [Complex64; 2]| {
            [0, 1].map(|place| Lanes::from_fn(simd, |lane| of(single[lane])[place]))
        };
        let layer = |layer: usize| {
            let value = |of: &dyn Fn(&LayerValues<Complex64>) -> Complex64| {
                Lanes::from_fn(simd, |lane| of(&single[lane].layers[layer]))
            };
            LayerValues {
                shear: value(&|at| at.shear),
                inertia: value(&|at| at.inertia),
                fibres: std::array::from_fn(|part| value(&|at| at.fibres[part])),
                coriolis: value(&|at| at.coriolis),
            }
        };
        Self {
            layers: (0..single[0].layers.len()).map(layer).collect(),
            foundation: pair(&|at| at.foundation),
            s: Lanes::from_fn(simd, |lane| single[lane].s),
            sidewalls: single.iter().flat_map(|at| &at.sidewalls).map(Arc::clone).collect(),
        }
    }
}

impl CylinderAt {
    /// A sidewall as an arc; `None` on a foundation.
    pub fn sidewall(&self) -> Option<&SidewallAt> {
        self.sidewalls.first().map(AsRef::as_ref)
    }
}

impl<T: ComplexField> CylinderAt<T> {
    /// Impedance of a sidewall's edge in a wave of n periods, one rotation or the other by `direction`.
    #[inline(always)]
    fn edge(&self, n: usize, direction: impl Fn(&BothWays) -> &EdgeImpedance) -> Option<EdgeImpedance<T>> {
        if self.sidewalls.is_empty() {
            return None;
        }
        let entry = |of: &dyn Fn(&EdgeImpedance) -> Complex64| {
            self.s.gathered(|lane| of(direction(self.sidewalls[lane].both_ways(n))))
        };
        Some(EdgeImpedance {
            radial: entry(&|edge| edge.radial),
            coupling: entry(&|edge| edge.coupling),
            circumferential: entry(&|edge| edge.circumferential),
            lateral: entry(&|edge| edge.lateral),
        })
    }
}

impl CylinderWave {
    /// C_zz of the surface and D_zz to the inner face for normal traction \[m/Pa\].
    #[inline(always)]
    pub fn normal<T: ComplexField>(&self, at: &CylinderAt<T>) -> NormalCompliance<T> {
        if self.turns {
            let [forwards, _] = self.normal_both_ways(at);
            return forwards;
        }
        self.normal_at_rest(at)
    }

    /// As [`Self::normal`], of a tyre at rest.
    #[inline(always)]
    pub fn normal_at_rest<T: ComplexField>(&self, at: &CylinderAt<T>) -> NormalCompliance<T> {
        self.normal_over(&self.climb(at, self.layers.len()))
    }

    /// As [`Self::normal`], of the waves n and -n.
    #[inline(always)]
    pub fn normal_both_ways<T: ComplexField>(&self, at: &CylinderAt<T>) -> [NormalCompliance<T>; 2] {
        let [forwards, backwards] = &self.climb_both_ways(at, self.layers.len());
        [self.normal_over(forwards), self.normal_over(backwards)]
    }

    /// Motion of the inner face, which the sidewalls' edges follow, in the waves n and -n (-n as n of -Omega).
    #[inline(always)]
    pub fn edge_both_ways<T: ComplexField>(&self, at: &CylinderAt<T>) -> [EdgeMotion<T>; 2] {
        if self.turns {
            let [forwards, backwards] = &self.climb_both_ways(at, self.layers.len());
            return [self.edge_over(forwards), self.edge_over(backwards)];
        }
        [self.edge_over(&self.climb(at, self.layers.len())); 2]
    }

    /// C and D \[m/Pa\]; order circumferential, lateral, radial outward.
    pub fn full(&self, at: &CylinderAt) -> (Matrix3, Matrix3) {
        if self.turns {
            let [forwards, _] = &self.climb_both_ways(at, self.layers.len());
            return self.full_over(forwards);
        }
        self.full_over(&self.climb(at, self.layers.len()))
    }

    /// As [`Self::full`], of the wave -n.
    pub fn full_backwards(&self, at: &CylinderAt) -> (Matrix3, Matrix3) {
        let (surface, bottom) = if self.turns {
            let [_, backwards] = &self.climb_both_ways(at, self.layers.len());
            self.full_over(backwards)
        } else {
            self.full(at)
        };
        (mirrored(surface), mirrored(bottom))
    }

    /// Driving-point compliance \[m/Pa\] for normal traction, per area of the surface, under the outermost layer,
    /// which is free on its outer face.
    #[inline(always)]
    pub fn under_tread<T: ComplexField>(&self, at: &CylinderAt<T>) -> T {
        if self.turns {
            let [forwards, _] = self.under_tread_both_ways(at);
            return forwards;
        }
        self.under_tread_at_rest(at)
    }

    /// As [`Self::under_tread`], of a tyre at rest.
    #[inline(always)]
    pub fn under_tread_at_rest<T: ComplexField>(&self, at: &CylinderAt<T>) -> T {
        let carcass = self.layers.len().saturating_sub(1);
        let mut impedance = self.climb(at, carcass).impedance;
        for (layer, at) in self.layers.iter().zip(&at.layers).skip(carcass) {
            impedance = carrying(&impedance, &layer.faces(at));
        }
        inverse(impedance)[2][2] * self.radius
    }

    /// As [`Self::under_tread`], of the waves n and -n.
    #[inline(always)]
    pub fn under_tread_both_ways<T: ComplexField>(&self, at: &CylinderAt<T>) -> [T; 2] {
        let carcass = self.layers.len().saturating_sub(1);
        let [mut forwards, mut backwards] = self.climb_both_ways(at, carcass).map(|climb| climb.impedance);
        for (layer, at) in self.layers.iter().zip(&at.layers).skip(carcass) {
            let faces = layer.faces_both_ways(at);
            forwards = carrying(&forwards, &faces[0]);
            backwards = carrying(&backwards, &faces[1]);
        }
        [inverse(forwards)[2][2] * self.radius, inverse(backwards)[2][2] * self.radius]
    }

    #[inline(always)]
    fn normal_over<T: ComplexField>(&self, climb: &Climb<T>) -> NormalCompliance<T> {
        let EdgeMotion { surface, radial, .. } = self.edge_over(climb);
        NormalCompliance { surface, bottom: radial }
    }

    #[inline(always)]
    fn edge_over<T: ComplexField>(&self, climb: &Climb<T>) -> EdgeMotion<T> {
        let [_, _, [a, b, c]] = inverse(climb.impedance);
        let [a, b, c] = [a * self.radius, b * self.radius, c * self.radius];
        let [circumferential, radial] = match climb.transfer {
            Some([first, _, last]) => [first, last].map(|[i, j, k]| i * a + j * b + k * c),
            None => [a, c],
        };
        EdgeMotion { surface: c, radial, circumferential }
    }

    fn full_over(&self, climb: &Climb<Complex64>) -> (Matrix3, Matrix3) {
        let surface = inverse(climb.impedance).map(|row| row.map(|entry| entry * self.radius));
        let bottom = climb.transfer.map_or(surface, |transfer| product(&transfer, &surface));
        (to_fields(surface), to_fields(bottom))
    }

    /// Goes through so many layers from the inner face: tractions times radius by displacements of the face that is
    /// reached, and displacements of the inner face by those.
    #[inline(always)]
    fn climb<T: ComplexField>(&self, at: &CylinderAt<T>, layers: usize) -> Climb<T> {
        at.s.outlined(
            #[inline(always)]
            || {
                let mut impedance = self.inner.impedance(at.s, at.foundation);
                if let Some(edge) = at.edge(self.inner.periods(), |both| &both.forwards) {
                    self.inner.hold(&mut impedance, &edge);
                }
                let mut climb = Climb::from(scaled(impedance, self.inner.radius));
                for (layer, at) in self.layers[..layers].iter().zip(&at.layers) {
                    climb = climb.through(&layer.faces(at));
                }
                climb
            },
        )
    }

    /// As [`Self::climb`], of the waves n and -n of a tyre that turns: layer by layer, since what is even in Omega
    /// serves both.
    #[inline(always)]
    fn climb_both_ways<T: ComplexField>(&self, at: &CylinderAt<T>, layers: usize) -> [Climb<T>; 2] {
        at.s.outlined(
            #[inline(always)]
            || {
                let (even, odd) = self.inner.turning_impedance(at.s, at.foundation);
                let (even, odd) = (scaled(even, self.inner.radius), (odd * self.inner.radius).times_i());
                let (mut forwards, mut backwards) = (even, even);
                for (row, column) in [(0, 2), (2, 0)] {
                    forwards[row][column] = even[row][column] + odd;
                    backwards[row][column] = even[row][column] - odd;
                }
                let n = self.inner.periods();
                if let (Some(forth), Some(back)) =
                    (at.edge(n, |both| &both.forwards), at.edge(n, |both| &both.backwards))
                {
                    self.inner.hold_scaled(&mut forwards, &forth, self.inner.radius);
                    self.inner.hold_scaled(&mut backwards, &back, self.inner.radius);
                }
                let (mut forwards, mut backwards) = (Climb::from(forwards), Climb::from(backwards));
                for (layer, at) in self.layers[..layers].iter().zip(&at.layers) {
                    let faces = layer.faces_both_ways(at);
                    forwards = forwards.through(&faces[0]);
                    backwards = backwards.through(&faces[1]);
                }
                [forwards, backwards]
            },
        )
    }
}

/// The wave -n of Omega is n of -Omega in a mirror, which reverses circumferential motion.
fn mirrored([[vv, vp, vw], [pv, pp, pw], [wv, wp, ww]]: Matrix3) -> Matrix3 {
    [[vv, -vp, -vw], [-pv, pp, pw], [-wv, wp, ww]]
}

#[inline(always)]
fn scaled<T: ComplexField>(mut block: Block<T>, factor: f64) -> Block<T> {
    for entry in block.as_flattened_mut() {
        *entry = *entry * factor;
    }
    block
}
