//! Files of compliance cases: tyres, wavenumbers and s in, the same with C and D out.
//!
//! The format (JSON): `tyres`: list of `name`, `layers` from the bottom to the top (`thickness`, `material`,
//! `tension_x`, `tension_y`) and `foundation`; `cases`: list of `tyre` (a name), `kx`, `ky`, `s` = \[re, im\]. Each
//! case gets `C` and `D`, 3x3 of \[re, im\]: displacement i \[m\] of the top and of the bottom face per unit traction j
//! \[Pa\] on the top face, z out of the tread, fields ~ exp(i(kx x + ky y) + s t).
//!
//! A tyre with `"curved": true` is a hollow cylinder (see `super::curved`): `circumference` of the tread's surface,
//! `width`, `pressure`, `sidewall_mass`, `foundation`, `cavity` (`radius`, `depth`, `density`, `sound_speed`,
//! `relaxation`) and `layers` of `thickness`, `modulus`, `loss_factor`, `poisson`, `density` and `tension` = \[theta,
//! y\], of power-law materials. A layer may have `cords`, a list of `stiffness` \[Pa\], `angle_deg` and
//! `loss_factor`, or `orthotropic` in place of `modulus` and `poisson`: `E_theta`, `E_y`, `E_r`, `G_y_r`, `G_theta_r`,
//! `G_theta_y`, `nu_theta_y`, `nu_theta_r`, `nu_y_r`. It may turn, towards growing theta: `speed` \[m/s\] of the
//! tread's surface; `tension` is that at rest then and grows as `super::rotation` has it, or with
//! `"centrifugal_tension": "given"` that of the turning tyre. A tyre's `resolved` is not read. Cases have `n` and `m`;
//! their order is circumferential, lateral, radial outward.
//!
//! A curved tyre with `"sides": "free"` has free lateral edges: see `crate::tyre::free_edges::cases`. Sidewalls are
//! beside tyres, or without any: see `crate::sidewall::cases`.

use std::borrow::Cow;

use num_complex::Complex64;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use thiserror::Error;

use super::compliance::{Matrix3, Stack};
use super::curved::{CurvedStack, FINE_STEP};
use super::rotation::Rotation;
use crate::scene::{Cavity, Cords, Foundation, Layer, MOST_CORD_LOSSES, Material, Orthotropic};
use crate::sidewall::cases::SidewallEntry;
use crate::sidewall::{self, Sidewall};
use crate::tyre::free_edges::Parity;
use crate::tyre::free_edges::cases::{EdgesEntry, FreeTyre};

/// Most steps through the layers of a curved tyre: ten times those of the shortest waves of interest.
const MOST_STEPS: f64 = 1e4;

/// Errors of a file of cases.
#[derive(Debug, Error)]
pub enum CasesError {
    /// Not JSON, or not this format.
    #[error("not a file of compliance cases: {0}")]
    Format(#[from] serde_json::Error),
    /// A case names a tyre that is not there.
    #[error("case {index} names the tyre '{name}', which `tyres` does not hold")]
    UnknownTyre {
        /// Position of the case, counted from 0.
        index: usize,
        /// Name of the tyre.
        name: String,
    },
    /// A case names a sidewall that is not there.
    #[error("case {index} names the sidewall '{name}', which `sidewalls` does not hold")]
    UnknownSidewall {
        /// Position of the case, counted from 0.
        index: usize,
        /// Name of the sidewall.
        name: String,
    },
    /// A number out of range.
    #[error("{place}: {what}")]
    Range {
        /// Tyre, sidewall or case.
        place: String,
        /// Fault and remedy, for the message.
        what: Cow<'static, str>,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TyreEntry {
    name: String,
    #[serde(default, rename = "curved")]
    _curved: bool,
    #[serde(default)]
    speed: f64,
    layers: Vec<LayerEntry>,
    foundation: Foundation,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerEntry {
    thickness: f64,
    material: Material,
    #[serde(default)]
    tension_x: f64,
    #[serde(default)]
    tension_y: f64,
    #[serde(default)]
    cords: Vec<CordsEntry>,
    #[serde(skip)]
    orthotropic: Option<Orthotropic>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct CordsEntry {
    stiffness: f64,
    angle_deg: f64,
    #[serde(default)]
    loss_factor: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CurvedLayerEntry {
    thickness: f64,
    modulus: Option<f64>,
    #[serde(default)]
    loss_factor: f64,
    poisson: Option<f64>,
    density: f64,
    #[serde(default)]
    tension: [f64; 2],
    #[serde(default)]
    cords: Vec<CordsEntry>,
    orthotropic: Option<Orthotropic>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CurvedEntry {
    name: String,
    #[serde(default, rename = "curved")]
    _curved: bool,
    /// Numbers that another program has found; not read.
    #[serde(default, rename = "resolved")]
    _resolved: Value,
    #[serde(default)]
    speed: f64,
    centrifugal_tension: Option<CentrifugalTension>,
    circumference: f64,
    width: f64,
    #[serde(default)]
    pressure: f64,
    #[serde(default)]
    sidewall_mass: f64,
    foundation: Foundation,
    #[serde(default)]
    cavity: Option<Cavity>,
    layers: Vec<CurvedLayerEntry>,
}

/// How the tension of a tyre that turns is given.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum CentrifugalTension {
    /// The layers' tension includes the centrifugal one.
    Given,
}

#[derive(Deserialize)]
struct CaseEntry {
    tyre: Option<String>,
    sidewall: Option<String>,
    kx: Option<f64>,
    ky: Option<f64>,
    n: Option<i64>,
    m: Option<usize>,
    parity: Option<Parity>,
    waves: Option<Vec<usize>>,
    #[serde(default)]
    speed: f64,
    s: [f64; 2],
}

enum Answer {
    Faces(Box<(Matrix3, Matrix3)>),
    Edge([[[f64; 2]; 2]; 2]),
    Free(Value, Option<Value>),
}

/// Tyre of a case.
enum Asked {
    Flat(Stack),
    Curved(CurvedStack),
    Free(Box<FreeTyre>),
}

/// Evaluates every case of a file's text; returns the same document with `C` and `D`, or `K`, in its cases.
pub fn evaluate(text: &str) -> Result<Value, CasesError> {
    // 1. Tyres and sidewalls by name, and the cases.
    let mut document: Value = serde_json::from_str(text)?;
    let sidewalls: Vec<SidewallEntry> = list(&document, "sidewalls")?.unwrap_or_default();
    let tyres: Vec<Value> = match list(&document, "tyres")? {
        None if sidewalls.is_empty() => serde_json::from_value(document["tyres"].clone())?,
        tyres => tyres.unwrap_or_default(),
    };
    let cases: Vec<CaseEntry> = serde_json::from_value(document["cases"].clone())?;
    let tyres = tyres.into_iter().map(asked).collect::<Result<Vec<_>, _>>()?;
    let sidewalls = sidewalls.into_iter().map(sidewall).collect::<Result<Vec<_>, _>>()?;
    let mut answers = Vec::with_capacity(cases.len());
    // 2. Each case.
    for (index, case) in cases.iter().enumerate() {
        let refuse = |what: &'static str| CasesError::Range { place: format!("case {index}"), what: what.into() };
        let finite = case.s.iter().chain(&case.kx).chain(&case.ky).all(|number| number.is_finite());
        if !finite || case.s[0] < 0.0 {
            return Err(refuse("kx, ky and s must be finite, with Re s >= 0"));
        }
        if case.speed != 0.0 {
            return Err(refuse("a case has no speed: the tyre has"));
        }
        let s = Complex64::new(case.s[0], case.s[1]);
        let name = match (&case.tyre, &case.sidewall) {
            (Some(name), None) => name,
            (None, Some(name)) => {
                let Some((_, sidewall)) = sidewalls.iter().find(|(known, _)| known == name) else {
                    return Err(CasesError::UnknownSidewall { index, name: name.clone() });
                };
                let Some(n) = case.n else { return Err(refuse("a case of a sidewall has n")) };
                answers.push(Answer::Edge(sidewall::cases::answer(sidewall, n, s).map_err(refuse)?));
                continue;
            }
            _ => return Err(refuse("a case names either a tyre or a sidewall")),
        };
        let Some((_, asked)) = tyres.iter().find(|(known, _)| known == name) else {
            return Err(CasesError::UnknownTyre { index, name: name.clone() });
        };
        let answer = match (asked, case) {
            (Asked::Flat(stack), CaseEntry { kx: Some(kx), ky: Some(ky), .. }) => stack.at(s).full(*kx, *ky),
            (Asked::Curved(stack), CaseEntry { n: Some(n), m: Some(m), .. }) => {
                check_steps(stack.steps(*n, *m, s, FINE_STEP)).map_err(refuse)?;
                stack.compliance(*n, *m, s, FINE_STEP)
            }
            (Asked::Free(tyre), CaseEntry { n: Some(n), parity: Some(parity), waves: Some(waves), .. }) => {
                let shortest = waves.iter().copied().max().unwrap_or(0);
                check_steps(tyre.stack().steps(*n, shortest, s, FINE_STEP)).map_err(refuse)?;
                let (waves, strip) = tyre.answer(*n, *parity, waves, s).map_err(refuse)?;
                answers.push(Answer::Free(waves, strip));
                continue;
            }
            (Asked::Free(_), _) => return Err(refuse("a case of a tyre with free edges has n, parity and waves")),
            (Asked::Flat(_), _) => return Err(refuse("a case of a flat tyre has kx and ky")),
            (Asked::Curved(_), _) => return Err(refuse("a case of a curved tyre has n and m")),
        };
        let (surface, bottom) = &answer;
        if !surface.iter().chain(bottom).flatten().all(|entry| entry.is_finite()) {
            return Err(refuse("its compliance is not finite: its numbers are beyond all bounds, or nothing holds it"));
        }
        answers.push(Answer::Faces(Box::new(answer)));
    }
    // 3. The answers into the document.
    if let Some(entries) = document["cases"].as_array_mut() {
        for (entry, answer) in entries.iter_mut().zip(answers) {
            match answer {
                Answer::Faces(faces) => {
                    let (surface, bottom) = *faces;
                    entry["C"] = numbers(surface);
                    entry["D"] = numbers(bottom);
                }
                Answer::Edge(impedance) => entry["K"] = json!(impedance),
                Answer::Free(waves, strip) => {
                    entry["C_waves"] = waves;
                    if let Some(strip) = strip {
                        entry["H_strip"] = strip;
                    }
                }
            }
        }
    }
    Ok(document)
}

/// Refuses a wave that needs too many steps through the layers.
fn check_steps(steps: f64) -> Result<(), &'static str> {
    if steps.is_nan() || steps > MOST_STEPS {
        return Err("its wave is too short for its layers: there are thousands in their thickness");
    }
    Ok(())
}

fn list<T: DeserializeOwned>(document: &Value, key: &str) -> Result<Option<Vec<T>>, serde_json::Error> {
    document.get(key).map(|list| serde_json::from_value(list.clone())).transpose()
}

fn sidewall(entry: SidewallEntry) -> Result<(String, Sidewall), CasesError> {
    let name = entry.name().to_owned();
    let refuse = |what: &'static str| CasesError::Range { place: format!("sidewall '{name}'"), what: what.into() };
    let sidewall = entry.sidewall().map_err(refuse)?;
    Ok((name, sidewall))
}

/// The curved tyres of a file of cases, by name, without those on free edges.
pub fn curved_tyres(text: &str) -> Result<Vec<(String, CurvedStack)>, CasesError> {
    let document: Value = serde_json::from_str(text)?;
    let tyres: Vec<Value> = serde_json::from_value(document["tyres"].clone())?;
    let is_curved = |entry: &Value| entry["curved"].as_bool() == Some(true) && entry.get("sides").is_none();
    tyres.into_iter().filter(is_curved).map(|entry| curved(serde_json::from_value(entry)?)).collect()
}

fn numbers(matrix: Matrix3) -> Value {
    json!(matrix.map(|row| row.map(|entry| [entry.re, entry.im])))
}

fn asked(entry: Value) -> Result<(String, Asked), CasesError> {
    if entry.get("sides").is_some() {
        return free(entry);
    }
    if entry["curved"].as_bool() == Some(true) {
        let (name, tyre) = curved(serde_json::from_value(entry)?)?;
        return Ok((name, Asked::Curved(tyre)));
    }
    let (name, tyre) = stack(serde_json::from_value(entry)?)?;
    Ok((name, Asked::Flat(tyre)))
}

/// A tyre with free edges.
fn free(mut entry: Value) -> Result<(String, Asked), CasesError> {
    let edges = EdgesEntry::taken_from(&mut entry)?;
    let entry: CurvedEntry = serde_json::from_value(entry)?;
    let name = entry.name.clone();
    let refuse = |what: Cow<'static, str>| CasesError::Range { place: format!("tyre '{name}'"), what };
    if entry.speed != 0.0 && entry.centrifugal_tension.is_none() {
        return Err(refuse("one with free edges that turns has \"centrifugal_tension\": \"given\"".into()));
    }
    let (_, stack) = curved(entry)?;
    let tyre = edges.tyre(stack).map_err(|what| refuse(what.into()))?;
    Ok((name, Asked::Free(Box::new(tyre))))
}

fn curved(entry: CurvedEntry) -> Result<(String, CurvedStack), CasesError> {
    let CurvedEntry { name, circumference, width, pressure, sidewall_mass, foundation, cavity, layers, .. } = entry;
    let CurvedEntry { speed, centrifugal_tension, .. } = entry;
    let refuse =
        |name: &str, what: &'static str| CasesError::Range { place: format!("tyre '{name}'"), what: what.into() };
    let positive = |value: &f64| *value > 0.0 && value.is_finite();
    if !positive(&circumference) || !positive(&width) {
        return Err(refuse(&name, "circumference and width must be positive"));
    }
    if let Some(Cavity { radius, depth, density, sound_speed, relaxation }) = &cavity
        && !([radius, depth, density, sound_speed].into_iter().all(positive) && *relaxation >= 0.0)
    {
        return Err(refuse(&name, "radius, depth, density and sound_speed of a cavity must be positive"));
    }
    if !(speed >= 0.0 && speed.is_finite()) {
        return Err(refuse(&name, "speed must be a number that is not negative: the tyre turns towards growing theta"));
    }
    let layer = |layer| {
        let CurvedLayerEntry { thickness, loss_factor, density, tension: [along, across], cords, .. } = layer;
        let (modulus, poisson) = match (&layer.orthotropic, layer.modulus, layer.poisson) {
            (Some(moduli), None, None) if cords.is_empty() => moduli.measure(),
            (None, Some(modulus), Some(poisson)) => (modulus, poisson),
            _ => return Err(refuse(&name, "a layer has modulus and poisson, or orthotropic without cords")),
        };
        let material = Material::power_law(modulus, loss_factor, poisson, density);
        Ok(LayerEntry {
            thickness,
            material,
            tension_x: along,
            tension_y: across,
            cords,
            orthotropic: layer.orthotropic,
        })
    };
    let layers = layers.into_iter().map(layer).collect::<Result<_, _>>()?;
    let (name, flat) = stack(TyreEntry { name, _curved: true, speed: 0.0, layers, foundation })?;
    let Stack { layers, foundation } = flat;
    let radius = circumference / std::f64::consts::TAU;
    if layers.iter().map(|layer| layer.thickness).sum::<f64>() >= radius {
        return Err(refuse(&name, "the layers must be thinner than the radius"));
    }
    let rotation = Rotation::default();
    let sidewall = None;
    let resting =
        CurvedStack { layers, foundation, radius, width, sidewall, pressure, sidewall_mass, cavity, rotation };
    let rotation = match centrifugal_tension {
        Some(CentrifugalTension::Given) => Rotation::of_given_tension(speed / radius),
        None => resting.turning(speed / radius),
    };
    Ok((name, CurvedStack { rotation, ..resting }))
}

fn stack(tyre: TyreEntry) -> Result<(String, Stack), CasesError> {
    let refuse = |what: &'static str| CasesError::Range { place: format!("tyre '{}'", tyre.name), what: what.into() };
    if tyre.speed != 0.0 {
        return Err(refuse("a flat tyre has no speed: one that turns is curved"));
    }
    if tyre.layers.is_empty() {
        return Err(refuse("a tyre has at least one layer"));
    }
    for LayerEntry { thickness, material, cords, orthotropic, .. } in &tyre.layers {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        if !positive(*thickness) || !positive(material.modulus) || !positive(material.density) {
            return Err(refuse("thickness, modulus and density must be positive"));
        }
        if !(material.poisson > -1.0 && material.poisson < 0.5) {
            return Err(refuse("poisson must be above -1 and below 0.5"));
        }
        let fits =
            |cords: &CordsEntry| positive(cords.stiffness) && cords.angle_deg.is_finite() && cords.loss_factor >= 0.0;
        if !cords.iter().all(fits) {
            return Err(refuse("cords have a positive stiffness, an angle and no negative loss factor"));
        }
        if Cords::losses(&made(cords)) > MOST_CORD_LOSSES {
            return Err(refuse("the cords of a layer have at most three different loss factors"));
        }
        if let Some(moduli) = orthotropic {
            let Orthotropic { e_theta, e_y, e_r, g_y_r, g_theta_r, g_theta_y, .. } = *moduli;
            if ![e_theta, e_y, e_r, g_y_r, g_theta_r, g_theta_y].into_iter().all(positive) {
                return Err(refuse("the moduli of an orthotropic layer must be positive"));
            }
            if !moduli.is_positive_definite() {
                return Err(refuse("an orthotropic layer must store energy in every strain: smaller nu, or other E"));
            }
        }
        if material.weights.len() != material.times.len() {
            return Err(refuse("weights and times must have the same length"));
        }
    }
    let layer = |layer: LayerEntry| Layer {
        name: String::new(),
        thickness: layer.thickness,
        tension: [layer.tension_x, layer.tension_y],
        material: layer.material,
        cords: made(&layer.cords),
        orthotropic: layer.orthotropic,
    };
    Ok((tyre.name, Stack::of(tyre.layers.into_iter().map(layer).collect(), tyre.foundation)))
}

fn made(cords: &[CordsEntry]) -> Vec<Cords> {
    cords.iter().map(|cords| Cords::new(cords.stiffness, cords.angle_deg, cords.loss_factor)).collect()
}
