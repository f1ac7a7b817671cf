//! Model of the pressures at receivers except for the air's transfer G: the tyre, and the action of forces on it.

use std::ops::Range;
use std::sync::Arc;

use num_complex::Complex64;

use super::surface::Shape;
use crate::numeric::sinc;
use crate::response::vibration::{Across, SegmentLayout, TransferKind};
use crate::scene::AirMotion;
use crate::tyre::influence::{SurfaceWaves, TractionWaves};

/// Part of the band below the highest frequency over which the transfers fall to zero, so that they ring for a short
/// time only.
const TAPER: f64 = 0.05;

/// Ingredients of the transfers except G.
#[derive(Clone, Debug)]
pub(crate) struct PressureModel {
    /// Segments in which forces are transformed; whole revolutions.
    pub layout: SegmentLayout,
    /// Response of the tyre's surface to normal forces.
    pub waves: Arc<SurfaceWaves>,
    /// Response to tangential forces, where there are any.
    pub tangential: Option<Arc<TractionWaves>>,
    /// Factor of all compliances; 1 unless a bedding's carcass is scaled.
    pub scale: f64,
    /// Width b of the contact strip \[m\].
    pub contact_width: f64,
    /// Density of the air \[kg/m^3\].
    pub density: f64,
    /// Motion of the air along the tread.
    pub air: AirMotion,
    /// Highest frequency \[Hz\].
    pub highest: f64,
    /// By receiver, the propagation delay r0/c less whole time steps \[s\].
    pub delays: Vec<f64>,
    /// Ends of the cells across, rising \[m\], where a cell's inward volume \[m^3\] is given in place of each component
    /// of a force; `None` for forces, to which the tyre responds.
    pub strips: Option<Arc<[f64]>>,
}

impl PressureModel {
    /// Frequency \[Hz\] below which the transfers are not tapered, for a highest frequency \[Hz\].
    pub(crate) fn flat_to(highest: f64) -> f64 {
        (1.0 - TAPER) * highest
    }

    /// Number of bins of a segment that radiate, 0 to the highest frequency.
    pub(crate) fn bins(&self) -> usize {
        let last = (self.highest / self.layout.resolution()).floor() as usize;
        last.min(self.layout.length() / 2) + 1
    }

    /// (e_m/B) a_m of each wave's part in the strip's force, for each component of the forces. Forces that are resolved
    /// across contain their a_m already; for them it is the sign of the wave relative to cos(ky_m y) or sin(ky_m y).
    pub(super) fn strip(&self) -> Vec<f64> {
        if self.strips.is_some() {
            return vec![1.0; self.driven()];
        }
        let (tyre, across) = (self.waves.waves, self.layout.across);
        let part = |&m: &usize| {
            let share = match across {
                Across::Even => tyre.lateral_share(m, self.contact_width),
                Across::Resolved { .. } => tyre.sign_about_middle(m),
            };
            tyre.lateral_norm(m) * share
        };
        (0..self.forces()).flat_map(|_| self.waves.lateral.iter().map(part)).collect()
    }

    /// Number of components of a force: all three, or the normal one.
    fn forces(&self) -> usize {
        if self.tangential.is_some() { 3 } else { 1 }
    }

    /// Number of waves across that all components of the forces drive, or of the cells whose volumes are given.
    fn driven(&self) -> usize {
        match &self.strips {
            None => self.forces() * self.waves.lateral.len(),
            Some(ends) => ends.len() - 1,
        }
    }

    /// Number of rings of a flank that moves; given volumes move none.
    fn rings(&self) -> usize {
        if self.strips.is_some() { 0 } else { self.waves.pieces() }
    }

    /// Number of shapes of `lateral` lateral waves with `rings` rings on a flank that moves: the rings sum over the
    /// waves, or follow each of those that are resolved across.
    pub(crate) fn shape_count(across: Across, lateral: usize, rings: usize) -> usize {
        match across {
            Across::Even => lateral + rings,
            Across::Resolved { .. } => lateral * (1 + rings),
        }
    }

    /// Shapes with which G is integrated, component by component across.
    pub(super) fn shapes(&self) -> Vec<Shape> {
        if let Some(ends) = &self.strips {
            return ends.windows(2).map(|ends| Shape::Strip([ends[0], ends[1]])).collect();
        }
        let (lateral, rings) = (self.waves.lateral.iter(), self.rings());
        match self.layout.across {
            Across::Even => {
                let rings = (0..rings).map(|number| Shape::Ring { number, odd: false });
                lateral.map(|&m| Shape::Tread(m)).chain(rings).collect()
            }
            Across::Resolved { .. } => {
                let of = |&m: &usize| {
                    let odd = !self.waves.waves.is_even(m);
                    let rings = (0..rings).map(move |number| Shape::Ring { number, odd });
                    std::iter::once(Shape::Tread(m)).chain(rings)
                };
                (0..self.forces()).flat_map(|_| lateral.clone().flat_map(of)).collect()
            }
        }
    }

    /// Number of G's integrals per wavenumber for so many shapes: with one of the weights of G, or both.
    pub(crate) fn integrals(air: AirMotion, shapes: usize) -> usize {
        match air {
            AirMotion::Axle | AirMotion::WithTread => shapes,
            AirMotion::Road => 2 * shapes,
        }
    }

    pub(crate) fn integrals_of_wave(&self) -> usize {
        Self::shape_count(self.layout.across, self.driven(), self.rings()) * self.weights()
    }

    /// Number of [`super::surface::WEIGHTS`] that the air's motion needs.
    pub(super) fn weights(&self) -> usize {
        if self.strips.is_some() { 1 } else { Self::integrals(self.air, 1) }
    }

    /// Rates \[rad/s\] at which the air sees a wave of n periods move, at an angular frequency in the frame of the
    /// axle: factors of the wave's integrals with G, weight by weight.
    ///
    /// Under a stream U along the tread a displacement u moves the air with du/dt - U du/dx. From the axle, with the
    /// angle theta from the contact, U is 0, V or V cos(theta), V du/dx of the wave is i n Omega u, and
    /// w - n Omega cos(theta) = (w - n Omega) + n Omega (1 - cos(theta)).
    fn rates(&self, angular: f64, n: i64) -> [f64; 2] {
        let layout = &self.layout;
        let turned = std::f64::consts::TAU * n as f64 * layout.revolutions as f64 * layout.resolution();
        if self.strips.is_some() {
            // The volume of a cell changes in time as the material sees it. Between the steps it is the smooth
            // interpolation of its samples: nothing is above half of their rate.
            let material = angular - turned;
            let is_seen = material.abs() * layout.time_step <= std::f64::consts::PI * (1.0 + 1e-9);
            return [if is_seen { material } else { 0.0 }, 0.0];
        }
        match self.air {
            AirMotion::Axle => [angular, 0.0],
            AirMotion::WithTread => [angular - turned, 0.0],
            AirMotion::Road => [angular - turned, turned],
        }
    }

    /// Factor by which the force's mean over an element weakens a wave of n periods.
    pub(super) fn mean_over_element(&self, n: i64) -> f64 {
        let tyre = self.waves.waves;
        sinc(0.5 * tyre.kx(n) * tyre.circumference / self.layout.elements as f64)
    }

    /// Buffer for the flows of all lateral waves; empty without a flank that moves.
    pub(super) fn flow_buffer(&self) -> Vec<Complex64> {
        vec![Complex64::ZERO; self.driven() * self.rings()]
    }

    /// Factors from the integrals of G to the pressure at a bin, shape by shape, weight by weight, for unit amplitude
    /// of the forces' component n at each stage; `strip` is [`Self::strip`], `mean` [`Self::mean_over_element`],
    /// `flows` [`Self::flow_buffer`].
    pub(super) fn factors(
        &self,
        bin: usize,
        n: i64,
        mean: f64,
        strip: &[f64],
        flows: &mut [Complex64],
        out: &mut [Complex64],
    ) {
        let resolution = self.layout.resolution();
        let material = self.layout.material_bin(bin, n) as f64 * resolution;
        self.factors_at([bin as f64 * resolution, material], n, mean, strip, flows, out);
    }

    /// The same at any frequency in the frame of the road, and the frequency that this is to the material \[Hz\].
    pub(super) fn factors_at(
        &self,
        [frequency, material]: [f64; 2],
        n: i64,
        mean: f64,
        strip: &[f64],
        flows: &mut [Complex64],
        out: &mut [Complex64],
    ) {
        let layout = &self.layout;
        let angular = std::f64::consts::TAU * frequency;
        // p = i w rho Int G v dS, v = -i w u: outwards.
        let scale = if self.strips.is_some() { 1.0 } else { self.scale };
        let radiated = angular * self.density * self.taper(frequency) * scale;
        let factors = self.rates(angular, n).map(|rate| radiated * rate * mean / layout.circumference);
        let (weights, rings) = (self.weights(), self.rings());
        self.compliances(n, material, &mut out[..strip.len()], flows);
        let together = layout.across == Across::Even;
        let each = if together { weights } else { weights * (1 + rings) };
        // From the last on, since each compliance is overwritten by the factors of earlier waves' weights.
        for (m, strip) in strip.iter().enumerate().rev() {
            let compliance = out[m];
            for (out, factor) in out[m * each..][..weights].iter_mut().zip(factors) {
                *out = compliance * (factor * strip);
            }
        }
        for ring in 0..rings {
            let flow = |m: usize| flows[m * rings + ring] * strip[m];
            let mut put = |first: usize, flow: Complex64| {
                for (out, factor) in out[first + ring * weights..][..weights].iter_mut().zip(factors) {
                    *out = flow * factor;
                }
            };
            if together {
                put(strip.len() * weights, (0..strip.len()).map(flow).sum());
            } else {
                (0..strip.len()).for_each(|m| put(m * each + weights, flow(m)));
            }
        }
    }

    /// Phase factors of the fractional delays of some receivers at a bin.
    pub(super) fn late(&self, receivers: Range<usize>, bin: usize) -> impl Iterator<Item = Complex64> {
        let angular = self.layout.angular_frequency(bin);
        self.delays[receivers].iter().map(move |delay| Complex64::from_polar(1.0, -angular * delay))
    }

    /// C_nm at a frequency of the material, as the run's time rule sees it, for each component of the forces, and the
    /// flows of the sidewalls with them, if they radiate.
    fn compliances(&self, n: i64, frequency: f64, out: &mut [Complex64], flows: &mut [Complex64]) {
        if self.strips.is_some() {
            out.fill(Complex64::ONE);
            return;
        }
        let SegmentLayout { rule, time_step, .. } = self.layout;
        // The waves are tabulated on the imaginary axis; a multistep rule's s lies close to it.
        let seen = if rule.is_multistep() {
            TransferKind::Rule.symbol(rule, std::f64::consts::TAU * frequency, time_step).im / std::f64::consts::TAU
        } else {
            frequency
        };
        let (lateral, pieces) = (self.waves.lateral.len(), self.waves.pieces());
        let (by_normal, by_tangential) = out.split_at_mut(lateral);
        self.waves.at(n, seen, by_normal);
        let (flows, more_flows) = flows.split_at_mut(lateral * pieces);
        if !flows.is_empty() {
            self.waves.flows_at(n, seen, by_normal, flows);
        }
        let Some(waves) = &self.tangential else { return };
        let (along, aside) = by_tangential.split_at_mut(lateral);
        for (index, normal) in by_normal.iter().enumerate() {
            let answers = waves.at(n, seen, index);
            (along[index], aside[index]) = (answers[0], answers[1]);
            // The flows follow the surface's motion as they do under normal forces.
            for (force, answer) in answers.into_iter().enumerate() {
                let out = &mut more_flows[(force * lateral + index) * pieces..][..pieces];
                let known = &flows[index * pieces..][..pieces];
                let ratio = if normal.norm_sqr() > 0.0 { answer / normal } else { Complex64::ZERO };
                out.iter_mut().zip(known).for_each(|(out, flow)| *out = ratio * flow);
            }
        }
    }

    fn taper(&self, frequency: f64) -> f64 {
        let into = ((frequency / self.highest - (1.0 - TAPER)) / TAPER).clamp(0.0, 1.0);
        // Most frequencies are below the taper: saves the cosine.
        if into <= 0.0 {
            return 1.0;
        }
        0.5 * (1.0 + (std::f64::consts::PI * into).cos())
    }
}
