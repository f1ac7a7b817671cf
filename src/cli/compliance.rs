//! `tyrewave compliance`: the layered tyre's compliance, and its sidewalls' impedance, for a file of cases.

use std::path::PathBuf;

use crate::storage::input::{self, TABLE_BYTES};
use crate::tyre::layers::cases;
use clap::Args;

use super::context::{Context, print};
use super::error::CliError;

const EXAMPLES: &str = "\
The file has the format of the reference values: every case names its layers, wavenumbers and complex frequency s. \
The same JSON is printed with the computed 3x3 surface compliance C and belt transfer D in place of the file's.

A tyre with \"curved\": true is a layered hollow cylinder: circumference (of the tread's surface), width, pressure, \
foundation, cavity (radius, depth, density, sound_speed, relaxation) and layers of thickness, modulus, loss_factor, \
poisson, density and tension [along, across]; its cases have n and m. Order: circumferential, lateral, outward. A \
layer may have cords, a list of stiffness, angle_deg and loss_factor; or, in place of modulus and poisson, orthotropic \
with E_theta, E_y, E_r, G_y_r, G_theta_r, G_theta_y, nu_theta_y, nu_theta_r and nu_y_r. The field `resolved` of a tyre \
is not read.

A curved tyre with \"sides\": \"free\" has free lateral edges: contact_width, edge_zone (0.015 m if it is left out), \
sidewall (radius, angle, mass, shear, hoop, loss_factor; left out: none), tension as given and, with a speed, \
\"centrifugal_tension\": \"given\". Its cases have n, parity (\"even\" or \"odd\") and waves, a list of lateral \
numbers; they get C_waves, between these [m^2/(N/rad)], and if even H_strip, of the contact width [m/(N/rad)].

`sidewalls` beside `tyres`, or without them, is a list of name, radius, angle (half the arc's, rad), pressure, mass, \
shear, hoop (4 times shear if it is left out), edge_radius, omega (rad/s) and relaxation, pairs [g, T]. A case with \
the key `sidewall`, a name, has n and s, and gets K = [[ww, wV], [wV, VV]] of the belt's edge [N/m^2].

Examples:
  tyrewave compliance cases.json > computed.json";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ComplianceArguments {
    /// The cases, a JSON file.
    cases: PathBuf,
}

impl ComplianceArguments {
    pub(crate) fn execute(self, _: &Context) -> Result<(), CliError> {
        let path = self.cases;
        let text = input::read_text(&path, TABLE_BYTES).map_err(CliError::reading(&path))?;
        let answer = cases::evaluate(&text).map_err(|error| CliError::Usage(format!("{}: {error}", path.display())))?;
        print(&format!("{answer:#}\n"))
    }
}
