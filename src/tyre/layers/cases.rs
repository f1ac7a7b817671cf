//! Files of compliance cases: tyres, wavenumbers and s in, the same with C and D out.
//!
//! The format (JSON): `tyres`: list of `name`, `layers` from the bottom to the top (`thickness`, `material`,
//! `tension_x`, `tension_y`) and `foundation`; `cases`: list of `tyre` (a name), `kx`, `ky`, `s` = \[re, im\]. Each
//! case gets `C` and `D`, 3x3 of \[re, im\]: displacement i \[m\] of the top and of the bottom face per unit traction j
//! \[Pa\] on the top face, z out of the tread, fields ~ exp(i(kx x + ky y) + s t).

use num_complex::Complex64;
use serde::Deserialize;
use serde_json::{Value, json};
use thiserror::Error;

use super::compliance::{Matrix3, Stack};
use crate::scene::{Foundation, Law, Layer, Material};

/// What can be wrong with a file of cases.
#[derive(Debug, Error)]
pub enum CasesError {
    /// Not JSON, or not this format.
    #[error("not a file of compliance cases: {0}")]
    Format(#[from] serde_json::Error),
    /// A case names a tyre that is not there.
    #[error("case {index} names the tyre '{name}', which `tyres` does not hold")]
    UnknownTyre {
        /// Position of the case, from 0.
        index: usize,
        /// The name.
        name: String,
    },
    /// A number out of range.
    #[error("{place}: {what}")]
    Range {
        /// Tyre or case.
        place: String,
        /// What is wrong and what would be right.
        what: &'static str,
    },
}

#[derive(Deserialize)]
struct TyreEntry {
    name: String,
    layers: Vec<LayerEntry>,
    #[serde(with = "FoundationEntry")]
    foundation: Foundation,
}

#[derive(Deserialize)]
#[serde(remote = "Foundation", deny_unknown_fields)]
struct FoundationEntry {
    normal: f64,
    tangential: f64,
    #[serde(default)]
    loss_factor: f64,
    #[serde(default = "reference_frequency")]
    reference_frequency: f64,
    #[serde(default = "corner_frequency")]
    corner_frequency: f64,
}

#[derive(Deserialize)]
#[serde(remote = "Material", deny_unknown_fields)]
struct MaterialEntry {
    law: Law,
    modulus: f64,
    #[serde(default)]
    loss_factor: f64,
    poisson: f64,
    density: f64,
    #[serde(default = "reference_frequency")]
    reference_frequency: f64,
    #[serde(default = "corner_frequency")]
    corner_frequency: f64,
    #[serde(default)]
    weights: Vec<f64>,
    #[serde(default)]
    times: Vec<f64>,
}

fn reference_frequency() -> f64 {
    Material::REFERENCE_FREQUENCY
}

fn corner_frequency() -> f64 {
    Material::CORNER_FREQUENCY
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerEntry {
    thickness: f64,
    #[serde(with = "MaterialEntry")]
    material: Material,
    #[serde(default)]
    tension_x: f64,
    #[serde(default)]
    tension_y: f64,
}

#[derive(Deserialize)]
struct CaseEntry {
    tyre: String,
    kx: f64,
    ky: f64,
    s: [f64; 2],
}

/// Evaluates every case of a file's text; the answer is the same document with its `C` and `D` replaced.
pub fn evaluate(text: &str) -> Result<Value, CasesError> {
    let mut document: Value = serde_json::from_str(text)?;
    let tyres: Vec<TyreEntry> = serde_json::from_value(document["tyres"].clone())?;
    let cases: Vec<CaseEntry> = serde_json::from_value(document["cases"].clone())?;
    let stacks = tyres.into_iter().map(stack).collect::<Result<Vec<_>, _>>()?;
    let mut answers = Vec::with_capacity(cases.len());
    for (index, case) in cases.iter().enumerate() {
        let Some((_, stack)) = stacks.iter().find(|(name, _)| *name == case.tyre) else {
            return Err(CasesError::UnknownTyre { index, name: case.tyre.clone() });
        };
        let finite = [case.kx, case.ky, case.s[0], case.s[1]].iter().all(|number| number.is_finite());
        if !finite || case.s[0] < 0.0 {
            let what = "kx, ky and s must be finite, with Re s >= 0";
            return Err(CasesError::Range { place: format!("case {index}"), what });
        }
        answers.push(stack.at(Complex64::new(case.s[0], case.s[1])).full(case.kx, case.ky));
    }
    if let Some(entries) = document["cases"].as_array_mut() {
        for (entry, (surface, bottom)) in entries.iter_mut().zip(answers) {
            entry["C"] = numbers(surface);
            entry["D"] = numbers(bottom);
        }
    }
    Ok(document)
}

fn numbers(matrix: Matrix3) -> Value {
    json!(matrix.map(|row| row.map(|entry| [entry.re, entry.im])))
}

fn stack(tyre: TyreEntry) -> Result<(String, Stack), CasesError> {
    let refuse = |what| CasesError::Range { place: format!("tyre '{}'", tyre.name), what };
    if tyre.layers.is_empty() {
        return Err(refuse("a tyre has at least one layer"));
    }
    for LayerEntry { thickness, material, .. } in &tyre.layers {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        if !positive(*thickness) || !positive(material.modulus) || !positive(material.density) {
            return Err(refuse("thickness, modulus and density must be positive"));
        }
        if !(material.poisson > -1.0 && material.poisson < 0.5) {
            return Err(refuse("poisson must be above -1 and below 0.5"));
        }
        if material.weights.len() != material.times.len() {
            return Err(refuse("weights and times must have the same length"));
        }
    }
    let layer = |LayerEntry { thickness, material, tension_x, tension_y }| Layer {
        name: String::new(),
        thickness,
        tension: [tension_x, tension_y],
        material,
    };
    Ok((tyre.name, Stack::of(tyre.layers.into_iter().map(layer).collect(), tyre.foundation)))
}
