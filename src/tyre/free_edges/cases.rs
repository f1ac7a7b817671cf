//! Belts with free edges in files of compliance cases.
//!
//! A curved tyre with `"sides": "free"` has `contact_width`, `edge_zone` (0.015 m where it is left out), and
//! `sidewall`: `radius`, `angle` (half the arc's), `mass`, `shear`, `hoop` (4 `shear` where it is left out),
//! `loss_factor`; without it nothing acts at the edges. Its layers' `tension` is taken as given, across as along, and
//! where it turns it has `"centrifugal_tension": "given"`. A `foundation` acts on the inner face, and may be left out.
//! Cases have `n`, `s`, `parity` ("even" or "odd") and `waves`, a list of lateral numbers, and get
//!
//! - `C_waves`: int cos(k_i y') w dy for the normal load cos(k_j y') N/m per radian, by i and j \[m^2/(N/rad)\];
//! - `H_strip`, of even parity: mean of w over the strip of the contact width for a unit force per radian, uniform over
//!   the strip \[m/(N/rad)\].

use std::sync::Arc as Shared;

use num_complex::Complex64;
use serde::Deserialize;
use serde_json::{Value, json};

use super::belt::{FreeEdges, FreeEdgesError, Resolution};
use super::lateral_shapes::Parity;
use super::strip::explicit_waves;
use crate::sidewall::{Arc, Relaxation, Sidewall};
use crate::tyre::layers::curved::{CurvedStack, FINE_STEP};

/// Keys of a tyre that belong to its edges.
const KEYS: [&str; 4] = ["sides", "contact_width", "edge_zone", "sidewall"];
/// Zone at each edge on whose mean motion a sidewall acts \[m\].
const EDGE_ZONE: f64 = 0.015;
/// Most layers, lateral numbers of a case, and waves across that feel the layers: a case then takes seconds.
const MOST_LAYERS: usize = 16;
const MOST_WAVES: usize = 256;
const MOST_EXPLICIT: f64 = 1e4;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SidewallKeys {
    radius: f64,
    angle: f64,
    mass: f64,
    #[serde(default)]
    shear: f64,
    hoop: Option<f64>,
    #[serde(default)]
    loss_factor: f64,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Sides {
    Free,
}

/// Edges of a tyre of a file.
#[derive(Deserialize)]
pub(in crate::tyre) struct EdgesEntry {
    #[serde(rename = "sides")]
    _sides: Sides,
    contact_width: f64,
    edge_zone: Option<f64>,
    sidewall: Option<SidewallKeys>,
}

/// A belt of a file, and the width of its strip.
pub(in crate::tyre) struct FreeTyre {
    belt: FreeEdges,
    contact_width: f64,
}

impl EdgesEntry {
    /// Takes its keys out of the entry of a tyre.
    pub(in crate::tyre) fn taken_from(entry: &mut Value) -> Result<Self, serde_json::Error> {
        let mut own = serde_json::Map::new();
        if let Some(entry) = entry.as_object_mut() {
            own.extend(KEYS.into_iter().filter_map(|key| Some((key.to_owned(), entry.remove(key)?))));
            // Values of a foundation that is left out: none.
            entry.entry("foundation").or_insert_with(|| json!({ "normal": 0.0, "tangential": 0.0 }));
        }
        serde_json::from_value(Value::Object(own))
    }

    /// The belt of a stack without sidewalls, or an error with its remedy.
    pub(in crate::tyre) fn tyre(self, stack: CurvedStack) -> Result<FreeTyre, String> {
        let refuse = |what: &str| Err(what.to_owned());
        let Self { contact_width, edge_zone, sidewall, .. } = self;
        let positive = |value: f64| value > 0.0 && value.is_finite();
        if !(positive(contact_width) && contact_width <= stack.width) {
            return refuse("contact_width must be above 0 and at most the width");
        }
        if stack.layers.len() > MOST_LAYERS {
            return refuse("a belt with free edges has at most 16 layers");
        }
        if explicit_waves(&stack) > MOST_EXPLICIT {
            return refuse("the outermost layer is too thin for the width: there are thousands of waves across");
        }
        if stack.sidewall_mass.abs() > 0.0 {
            return refuse("free edges have the mass of the sidewalls in sidewall, not in sidewall_mass");
        }
        let sidewall = match sidewall {
            None => None,
            Some(SidewallKeys { radius, angle, mass, shear, hoop, loss_factor }) => {
                let hoop = hoop.unwrap_or(Arc::HOOP_OVER_SHEAR * shear);
                if ![radius, mass, stack.pressure].into_iter().all(positive) {
                    return refuse("radius and mass of a sidewall, and the pressure, must be positive");
                }
                if !(angle > 0.0 && angle < std::f64::consts::PI) {
                    return refuse("angle of a sidewall, half the arc's, must be above 0 and below pi rad");
                }
                let valid = |value: f64| value >= 0.0 && value.is_finite();
                if ![shear, hoop, loss_factor].into_iter().all(valid) {
                    return refuse("shear, hoop and loss_factor of a sidewall must not be negative");
                }
                let arc = Arc {
                    radius,
                    angle,
                    pressure: stack.pressure,
                    mass,
                    shear,
                    hoop,
                    edge_radius: stack.inner_radius(),
                    angular_velocity: stack.rotation.angular_velocity,
                    relaxation: Relaxation::of_loss_factor(loss_factor),
                };
                if arc.bead_radius() <= 0.0 {
                    return refuse("the sidewall must end above the axle: a smaller radius or angle");
                }
                Some(Shared::new(Sidewall::new(arc)))
            }
        };
        let stack = CurvedStack { sidewall, ..stack };
        let belt = FreeEdges::of(stack, edge_zone.unwrap_or(EDGE_ZONE), Resolution::FINE);
        Ok(FreeTyre { belt: belt.map_err(|error: FreeEdgesError| error.to_string())?, contact_width })
    }
}

impl FreeTyre {
    /// Layers without the sidewalls, for the number of steps of a wave.
    pub(in crate::tyre) fn stack(&self) -> &CurvedStack {
        &self.belt.stack
    }

    /// `C_waves` and `H_strip` of a case, numbers as \[re, im\], or an error.
    pub(in crate::tyre) fn answer(
        &self,
        n: i64,
        parity: Parity,
        waves: &[usize],
        s: Complex64,
    ) -> Result<(Value, Option<Value>), &'static str> {
        // 1. Checks.
        let odd = usize::from(parity == Parity::Odd);
        if waves.iter().any(|m| m % 2 != odd) {
            return Err("waves of even parity have even lateral numbers, those of odd parity odd ones");
        }
        if waves.len() > MOST_WAVES {
            return Err("a case has at most 256 waves");
        }
        // 2. Waves: beyond those that the edges correct they are guided ones.
        let correction = self.belt.section(n, parity).at(s);
        let stack = &self.belt.stack;
        let guided = self.belt.guided();
        let between = |m: usize, other: usize| match correction.compliance(m, other) {
            Some(compliance) => compliance,
            None if m == other => {
                let norm = if m == 0 { stack.width } else { 0.5 * stack.width };
                guided.compliance(n, m, s, FINE_STEP).0[2][2] * norm / stack.radius
            }
            None => Complex64::ZERO,
        };
        let rows: Vec<Vec<Complex64>> =
            waves.iter().map(|&m| waves.iter().map(|&other| between(m, other)).collect()).collect();
        // 3. The strip.
        let strip = (parity == Parity::Even).then(|| self.belt.strip(n, s, self.contact_width));
        if !rows.iter().flatten().chain(&strip).all(|value| value.is_finite()) {
            return Err("its compliance is not finite: its numbers are beyond all bounds, or nothing holds it");
        }
        let pair = |value: &Complex64| [value.re, value.im];
        let rows: Vec<Vec<[f64; 2]>> = rows.iter().map(|row| row.iter().map(pair).collect()).collect();
        Ok((json!(rows), strip.map(|strip| json!(pair(&strip)))))
    }
}
