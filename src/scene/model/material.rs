//! Viscoelastic materials.

use serde::{Deserialize, Serialize, Serializer};

/// An isotropic viscoelastic material.
///
/// Keys that mean nothing under its law keep their defaults and are neither read nor written.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// How the modulus depends on frequency.
    pub law: Law,
    /// Young's modulus \[Pa\]: at the reference frequency (`power-law`), at rest (`prony`), or at all frequencies.
    pub modulus: f64,
    /// Loss factor eta (`power-law`, `hysteretic`) \[1\].
    pub loss_factor: f64,
    /// Poisson's ratio, frequency independent, in (-1, 0.5).
    pub poisson: f64,
    /// Density \[kg/m^3\].
    pub density: f64,
    /// Frequency at which the modulus is as given (`power-law`) \[Hz\].
    pub reference_frequency: f64,
    /// Frequency below which the modulus levels off (`power-law`) \[Hz\].
    pub corner_frequency: f64,
    /// Relative strengths g_j (`prony`).
    pub weights: Vec<f64>,
    /// Relaxation times tau_j (`prony`) \[s\].
    pub times: Vec<f64>,
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

impl Material {
    /// Default frequency at which a power-law modulus is as given \[Hz\].
    pub const REFERENCE_FREQUENCY: f64 = 1000.0;
    /// Default frequency below which a power-law modulus levels off \[Hz\]: low enough not to show in a spectrum, high
    /// enough for the mean force to settle within a second.
    pub const CORNER_FREQUENCY: f64 = 1.0;
}

/// A material as it is written: the keys of its law and no others.
#[derive(Serialize)]
#[serde(tag = "law", rename_all = "kebab-case")]
enum Written<'a> {
    Elastic {
        modulus: f64,
        poisson: f64,
        density: f64,
    },
    PowerLaw {
        modulus: f64,
        loss_factor: f64,
        poisson: f64,
        density: f64,
        reference_frequency: f64,
        corner_frequency: f64,
    },
    Prony {
        modulus: f64,
        poisson: f64,
        density: f64,
        weights: &'a [f64],
        times: &'a [f64],
    },
    Hysteretic {
        modulus: f64,
        loss_factor: f64,
        poisson: f64,
        density: f64,
    },
}

impl Serialize for Material {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { law, modulus, loss_factor, poisson, density, reference_frequency, corner_frequency, .. } = *self;
        match law {
            Law::Elastic => Written::Elastic { modulus, poisson, density },
            Law::PowerLaw => {
                Written::PowerLaw { modulus, loss_factor, poisson, density, reference_frequency, corner_frequency }
            }
            Law::Prony => Written::Prony { modulus, poisson, density, weights: &self.weights, times: &self.times },
            Law::Hysteretic => Written::Hysteretic { modulus, loss_factor, poisson, density },
        }
        .serialize(serializer)
    }
}
