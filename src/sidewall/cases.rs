//! Sidewalls in files of compliance cases.
//!
//! `sidewalls`: list of `name`, `radius`, `angle` (half the arc's), `pressure`, `mass`, `shear`, `hoop` (4 `shear`
//! where it is left out), `edge_radius`, `omega` \[rad/s\], `relaxation`: list of \[g, T\]. A case of `sidewall` (a
//! name), `n` and `s` gets `K`: \[\[ww, wV\], \[wV, VV\]\] in N/m^2, of one sidewall, per metre of the belt's edge
//! (see [`EdgeImpedance`](super::EdgeImpedance)).

use num_complex::Complex64;
use serde::Deserialize;

use super::{Arc, Relaxation, Sidewall};

/// Most steps along an arc: they serve waves ten times shorter than any of interest.
const MOST_STEPS: f64 = 1e5;

/// A sidewall of a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SidewallEntry {
    name: String,
    radius: f64,
    angle: f64,
    pressure: f64,
    mass: f64,
    #[serde(default)]
    shear: f64,
    hoop: Option<f64>,
    edge_radius: f64,
    #[serde(default)]
    omega: f64,
    #[serde(default)]
    relaxation: Vec<[f64; 2]>,
}

impl SidewallEntry {
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The sidewall, or an error with its remedy.
    pub(crate) fn sidewall(self) -> Result<Sidewall, &'static str> {
        let Self { radius, angle, pressure, mass, shear, edge_radius, omega, relaxation, .. } = self;
        let positive = |value: f64| value > 0.0 && value.is_finite();
        if ![radius, pressure, mass, edge_radius].into_iter().all(positive) {
            return Err("radius, pressure, mass and edge_radius must be positive");
        }
        if !(angle > 0.0 && angle < std::f64::consts::PI) {
            return Err("angle, half the arc's, must be above 0 and below pi rad");
        }
        let hoop = self.hoop.unwrap_or(Arc::HOOP_OVER_SHEAR * shear);
        if !(shear >= 0.0 && hoop >= 0.0 && shear.is_finite() && hoop.is_finite()) {
            return Err("shear and hoop must not be negative");
        }
        if !omega.is_finite() {
            return Err("omega must be a finite number");
        }
        if !relaxation.iter().all(|&[strength, time]| strength >= 0.0 && strength.is_finite() && positive(time)) {
            return Err("relaxation holds pairs of a strength that is not negative and a positive time");
        }
        let relaxation = Relaxation { terms: relaxation };
        let arc = Arc { radius, angle, pressure, mass, shear, hoop, edge_radius, angular_velocity: omega, relaxation };
        if arc.bead_radius() <= 0.0 {
            return Err("the arc must end above the axle: edge_radius must be above 2 radius sin(angle)");
        }
        let sidewall = Sidewall::new(arc);
        if sidewall.edge().is_none() {
            return Err("it has no steady shape: a smaller angle, a lower omega or a higher pressure");
        }
        Ok(sidewall)
    }
}

/// K of a case, each entry \[re, im\], or an error.
pub(crate) fn answer(sidewall: &Sidewall, n: i64, s: Complex64) -> Result<[[[f64; 2]; 2]; 2], &'static str> {
    let steps = sidewall.reference_steps(n, s);
    if steps.is_nan() || steps > MOST_STEPS {
        return Err("its wave is too short for its arc: there are thousands along it");
    }
    let found = sidewall.reference(n, s);
    let [ww, wv, vv] = [found.radial, found.coupling, found.circumferential].map(|entry| [entry.re, entry.im]);
    if !ww.iter().chain(&wv).chain(&vv).all(|number| number.is_finite()) {
        return Err("its impedance is not finite: its numbers are beyond all bounds");
    }
    Ok([[ww, wv], [wv, vv]])
}
