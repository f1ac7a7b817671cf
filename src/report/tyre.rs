//! A tyre as JSON, for scripts: modes, contact under loads, mobility; and a picture of the mobility of patches of the
//! tread (Larsson's figure 2).

use crate::contact::static_contact::StaticContact;
use crate::results::plots::{Axis, LinePlot, Series};
use crate::tyre::influence::mobility::{Mobility, level, phase};
use crate::tyre::modes::{Mode, Modes};
use num_complex::Complex64;
use serde_json::{Value, json};

/// Contact of a tyre under a load.
#[derive(Clone, Debug)]
pub(crate) struct UnderLoad {
    /// The load as given.
    pub label: String,
    /// Contact of the standing tyre.
    pub standing: StaticContact,
    /// Mean length of the rolling patch \[m\], if it was rolled.
    pub rolling: Option<f64>,
}

impl UnderLoad {
    /// Load over deflection \[N/m\].
    pub(crate) fn secant_stiffness(&self) -> f64 {
        self.standing.force / self.standing.indentation
    }

    fn to_json(&self) -> Value {
        json!({
            "load": self.standing.force,
            "deflection": self.standing.indentation,
            "secant_stiffness": self.secant_stiffness(),
            "tangent_stiffness": self.standing.stiffness,
            "patch_length": self.standing.length,
            "rolling_patch_length": self.rolling,
        })
    }
}

/// Everything on a tyre as JSON in SI units; `element` is the length of an element \[m\].
pub(crate) fn tyre_record(title: &str, element: f64, modes: &Modes, loads: &[UnderLoad], mobility: &Mobility) -> Value {
    let unconfirmed =
        modes.unconfirmed.iter().map(|(n, m, pole)| json!({ "n": n, "m": m, "pole": [pole.re, pole.im] }));
    json!({
        "title": title,
        "modes": modes.confirmed.iter().map(mode_json).collect::<Vec<_>>(),
        "unconfirmed": unconfirmed.collect::<Vec<_>>(),
        "element": element,
        "loads": loads.iter().map(UnderLoad::to_json).collect::<Vec<_>>(),
        "mobility": mobility_json(mobility),
    })
}

/// A mode as JSON: shares of the motion are circumferential, lateral and radial.
fn mode_json(mode: &Mode) -> Value {
    json!({
        "n": mode.n,
        "m": mode.m,
        "motion": mode.motion,
        "frequency": mode.frequency(),
        "damping": mode.damping(),
        "pole": [mode.pole.re, mode.pole.im],
        "shares": mode.shares,
    })
}

/// Frequencies \[Hz\] and, for each patch, its side \[m\], levels \[dB re 1 m/(N s)\] and phases \[degrees\].
fn mobility_json(mobility: &Mobility) -> Value {
    let of = |column: usize| mobility.values.iter().map(move |row| row[column]);
    let patches = mobility.patches.iter().enumerate().map(|(column, side)| {
        json!({
            "side": side,
            "level": of(column).map(level).collect::<Vec<_>>(),
            "phase": of(column).map(phase).collect::<Vec<_>>(),
        })
    });
    json!({ "frequencies": mobility.frequencies, "patches": patches.collect::<Vec<_>>() })
}

/// Title of the axis, and value of a mobility on it.
pub(crate) type Quantity = (&'static str, fn(Complex64) -> f64);

/// Level of the mobility.
pub(crate) const LEVEL: Quantity = ("Driving-point mobility [dB re 1 m/(N s)]", level);

/// Picture with a curve for each patch.
pub(crate) fn plot<'a>(
    mobility: &Mobility,
    title: &'a str,
    names: &'a [String],
    (quantity, shown): Quantity,
) -> LinePlot<'a> {
    let curves = names.iter().enumerate().map(|(column, name)| Series {
        name,
        points: mobility.frequencies.iter().zip(&mobility.values).map(|(&f, row)| (f, shown(row[column]))).collect(),
    });
    let values = mobility.values.iter().flatten().map(|&value| shown(value));
    LinePlot {
        title,
        x: Axis::logarithmic_around("Frequency [Hz]", mobility.frequencies.iter().copied(), [1.0, 1.0]),
        y: Axis::linear_around(quantity, values),
        series: curves.collect(),
    }
}
