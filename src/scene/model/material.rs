//! Viscoelastic materials of a tyre's layers.

use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};

use crate::scene::Problem;
use crate::scene::keys::keys;
use crate::scene::kind::{Bounds, NumberList, OneOf};
use crate::scene::table::{Keys, Kind, Nested, Table};

pub(super) const LOSS: Bounds = Bounds::not_negative("").plausible(1e-9, 10.0);
/// The corner frequency must not be 0: a power law would then have no static stiffness.
pub(super) const FREQUENCY: Bounds = Bounds::positive("Hz").plausible(1e-6, 1e7);
pub(super) const MODULUS: Bounds = Bounds::positive("Pa").plausible(1e4, 1e12);
pub(super) const POISSON: Bounds = Bounds::inside(-1.0, 0.5, "");
const WEIGHTS: NumberList = NumberList(Bounds::positive("").plausible(1e-9, 1e6));
const TIMES: NumberList = NumberList(Bounds::positive("s").plausible(1e-9, 1e6));

keys! {
    /// An isotropic viscoelastic material.
    ///
    /// Keys that have no meaning under its law keep their defaults and are neither read nor written.
    #[derive(Clone, Debug, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    pub Material {
        /// How the modulus depends on frequency.
        law: Law = Law::default() => OneOf::new(),
        /// Young's modulus \[Pa\]: at the reference frequency (`power-law`), at rest (`prony`), or at all frequencies.
        modulus: f64 = f64::NAN => MODULUS,
        /// Poisson's ratio, frequency independent. At -1 the shear modulus of an isotropic material is infinite, at 0.5
        /// its compressional one.
        poisson: f64 = f64::NAN => POISSON,
        /// Density \[kg/m^3\].
        density: f64 => Bounds::positive("kg/m^3").plausible(1.0, 3e4),
        /// Loss factor eta (`power-law`, `hysteretic`) \[1\].
        #[serde(default)]
        loss_factor: f64 = 0.0 => LOSS,
        /// Frequency at which the modulus is as given (`power-law`) \[Hz\].
        #[serde(default = "reference_frequency")]
        reference_frequency: f64 = Material::REFERENCE_FREQUENCY => FREQUENCY,
        /// Frequency below which the modulus levels off (`power-law`) \[Hz\].
        #[serde(default = "corner_frequency")]
        corner_frequency: f64 = Material::CORNER_FREQUENCY => FREQUENCY,
        /// Relative strengths g_j (`prony`).
        #[serde(default)]
        weights: Vec<f64> = Vec::new() => WEIGHTS,
        /// Relaxation times tau_j (`prony`) \[s\].
        #[serde(default)]
        times: Vec<f64> = Vec::new() => TIMES,
    }
}

/// Viscoelastic law; see [`crate::tyre`] for the formulas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// E(s) = E.
    Elastic,
    /// E(s) = E ((s + wc)/w0)^(2 atan(eta)/pi): causal and passive.
    #[default]
    PowerLaw,
    /// E(s) = E (1 + sum g_j s tau_j/(1 + s tau_j)): causal and passive.
    Prony,
    /// E (1 + i eta): not causal, for frequency-domain results only.
    Hysteretic,
}

pub(super) fn reference_frequency() -> f64 {
    Material::REFERENCE_FREQUENCY
}

pub(super) fn corner_frequency() -> f64 {
    Material::CORNER_FREQUENCY
}

impl Material {
    /// Default frequency at which a power-law modulus is as given \[Hz\].
    pub const REFERENCE_FREQUENCY: f64 = 1000.0;
    /// Default frequency below which a power-law modulus levels off \[Hz\]: low enough not to show in a spectrum, high
    /// enough for the mean force to settle within a second.
    pub const CORNER_FREQUENCY: f64 = 1.0;

    /// A power law at the default frequencies: modulus \[Pa\], loss factor, Poisson's ratio, density \[kg/m^3\].
    pub fn power_law(modulus: f64, loss_factor: f64, poisson: f64, density: f64) -> Self {
        Self {
            law: Law::PowerLaw,
            modulus,
            loss_factor,
            poisson,
            density,
            reference_frequency: Self::REFERENCE_FREQUENCY,
            corner_frequency: Self::CORNER_FREQUENCY,
            weights: Vec::new(),
            times: Vec::new(),
        }
    }
}

impl Law {
    /// Its word, and the keys that only some laws have.
    const fn word_and_keys(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Elastic => ("elastic", &[]),
            Self::PowerLaw => ("power-law", &["loss_factor", "reference_frequency", "corner_frequency"]),
            Self::Prony => ("prony", &["weights", "times"]),
            Self::Hysteretic => ("hysteretic", &["loss_factor"]),
        }
    }
}

/// A material as it is written: without modulus and Poisson's ratio if the layer is orthotropic.
pub(super) struct WrittenMaterial<'a> {
    pub(super) material: &'a Material,
    pub(super) isotropic: bool,
}

impl Serialize for WrittenMaterial<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { material, isotropic } = *self;
        let (word, keys) = material.law.word_and_keys();
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("law", word)?;
        for (key, value, written) in [
            ("modulus", material.modulus, isotropic),
            ("loss_factor", material.loss_factor, keys.contains(&"loss_factor")),
            ("poisson", material.poisson, isotropic),
            ("density", material.density, true),
            ("reference_frequency", material.reference_frequency, keys.contains(&"reference_frequency")),
            ("corner_frequency", material.corner_frequency, keys.contains(&"corner_frequency")),
        ] {
            if written {
                map.serialize_entry(key, &value)?;
            }
        }
        if material.law == Law::Prony {
            map.serialize_entry("weights", &material.weights)?;
            map.serialize_entry("times", &material.times)?;
        }
        map.end()
    }
}

impl Serialize for Material {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        WrittenMaterial { material: self, isotropic: true }.serialize(serializer)
    }
}

pub(super) const MATERIAL: Nested<Material> =
    Nested::new("a material", "a table, { law = ..., modulus = ..., loss_factor = ..., poisson = ..., density = ... }")
        .read_by(material);

fn material(table: &mut Table<'_>) -> Option<Material> {
    let law = table.peek("law", &OneOf::<Law>::new()).map(Option::unwrap_or_default);
    if law.is_none() {
        table.be_lenient();
    }
    let of_losses = match law {
        Some(Law::Prony) => "remove it: weights and times describe the losses of a prony material",
        _ => "remove it, or choose law = \"power-law\" for a material with losses",
    };
    let of_power_law = "remove it, or choose law = \"power-law\"";
    let of_prony = "remove it, or choose law = \"prony\"";
    for (key, right) in [
        ("loss_factor", of_losses),
        ("reference_frequency", of_power_law),
        ("corner_frequency", of_power_law),
        ("weights", of_prony),
        ("times", of_prony),
    ] {
        match law.map(Law::word_and_keys) {
            None => table.pass(&[key]),
            Some((word, keys)) if !keys.contains(&key) => table.refuse(&[key], &format!("law = \"{word}\""), right),
            Some(_) => {}
        }
    }
    let mut complete = Some(());
    if law == Some(Law::Prony) {
        for (key, kind) in [("weights", WEIGHTS), ("times", TIMES)].into_iter().filter(|(key, _)| !table.has(key)) {
            complete = table.complain(key, Problem::missing(&kind.wanted()));
        }
    }
    let read = Material::read(table)?;
    complete?;
    if read.weights.len() != read.times.len() {
        let problem = Problem::length_mismatch(read.times.len(), "weights", read.weights.len());
        return table.complain("times", problem);
    }
    Some(read)
}
