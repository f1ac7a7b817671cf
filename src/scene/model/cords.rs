//! Layers that are not isotropic: rubber with cords, and orthotropic materials.

use serde::{Deserialize, Serialize};

use super::material::LOSS;
use crate::scene::Problem;
use crate::scene::keys::{is_default, keys};
use crate::scene::kind::Bounds;
use crate::scene::problem::short;
use crate::scene::table::{Each, Keys, Nested, Table};

const STIFFNESS: Bounds = Bounds::positive("Pa").plausible(1e4, 1e12);
const MODULUS: Bounds = Bounds::positive("Pa").plausible(1e4, 1e13);
const RATIO: Bounds = Bounds::any("").plausible(1e-9, 1e3);

keys! {
    /// Cords in a layer's rubber, as many at the angle as at its negative. They resist stretching, and nothing else: K
    /// (cos^4, sin^4, cos^2 sin^2 of the angle) along, across and between. Either `stiffness` is given, or `spacing`,
    /// `area` and `modulus`.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    pub Cords {
        /// Stiffness K of the cords over the layer's thickness, at the material's reference frequency \[Pa\].
        stiffness?: f64 => STIFFNESS,
        /// Distance of neighbouring cords \[m\].
        spacing?: f64 => Bounds::positive("m").plausible(1e-5, 0.1),
        /// Cross-section of a cord \[m^2\].
        area?: f64 => Bounds::positive("m^2").plausible(1e-11, 1e-4),
        /// Young's modulus of a cord \[Pa\].
        modulus?: f64 => MODULUS,
        /// Angle from the circumference; 90 runs across (degrees).
        angle_deg: f64 => Bounds::between(-90.0, 90.0, "degrees").no_radians(90.0),
        /// Loss factor eta; the same power law as the material's, by its frequencies \[1\].
        #[serde(skip_serializing_if = "is_default")]
        loss_factor: f64 = 0.0 => LOSS,
    }
}

keys! {
    /// Moduli of an orthotropic layer along the circumference (theta), across (y) and outwards (r), at the material's
    /// reference frequency; all follow its law with one factor. nu_a_b is the contraction along b by a stress along a.
    #[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
    #[serde(deny_unknown_fields)]
    pub Orthotropic {
        /// Young's modulus along the circumference \[Pa\].
        #[serde(rename = "E_theta")]
        e_theta as "E_theta": f64 => MODULUS,
        /// Young's modulus across \[Pa\].
        #[serde(rename = "E_y")]
        e_y as "E_y": f64 => MODULUS,
        /// Young's modulus outwards \[Pa\].
        #[serde(rename = "E_r")]
        e_r as "E_r": f64 => MODULUS,
        /// Shear modulus across and outwards \[Pa\].
        #[serde(rename = "G_y_r")]
        g_y_r as "G_y_r": f64 => MODULUS,
        /// Shear modulus along and outwards \[Pa\].
        #[serde(rename = "G_theta_r")]
        g_theta_r as "G_theta_r": f64 => MODULUS,
        /// Shear modulus in the layer's plane \[Pa\].
        #[serde(rename = "G_theta_y")]
        g_theta_y as "G_theta_y": f64 => MODULUS,
        /// Contraction across by a stress along \[1\].
        nu_theta_y: f64 => RATIO,
        /// Contraction outwards by a stress along \[1\].
        nu_theta_r: f64 => RATIO,
        /// Contraction outwards by a stress across \[1\].
        nu_y_r: f64 => RATIO,
    }
}

/// Elastic constants of a layer, with the stress outwards sigma separated: with e the strains along and across, s_a =
/// sum Q_ab e_b + a_a sigma and e_r = sigma/C_rr - sum a_a e_a.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlaneConstants {
    /// Q_tt, Q_yy, Q_ty \[Pa\].
    pub plane: [f64; 3],
    /// a_t, a_y \[1\].
    pub contraction: [f64; 2],
    /// C_rr \[Pa\].
    pub radial: f64,
}

/// Most different loss factors of the cords in one layer.
pub(crate) const MOST_CORD_LOSSES: usize = 3;

impl Cords {
    /// Cords of a given stiffness K \[Pa\], at an angle from the circumference (degrees).
    pub fn new(stiffness: f64, angle_deg: f64, loss_factor: f64) -> Self {
        Self { stiffness: Some(stiffness), spacing: None, area: None, modulus: None, angle_deg, loss_factor }
    }

    /// Number of different loss factors.
    pub fn losses(cords: &[Self]) -> usize {
        let mut losses: Vec<f64> = cords.iter().map(|cords| cords.loss_factor).collect();
        losses.sort_by(f64::total_cmp);
        losses.dedup();
        losses.len()
    }

    /// Stiffness K of the cords in a layer of a given thickness \[m\]: E A/(spacing thickness) if it is not given
    /// itself \[Pa\].
    pub fn stiffness_in(&self, thickness: f64) -> f64 {
        let of_parts = || Some(self.modulus? * self.area? / (self.spacing? * thickness));
        self.stiffness.or_else(of_parts).unwrap_or(0.0)
    }

    /// K cos^4, K sin^4 and K cos^2 sin^2 in a layer of a given thickness \[m\]: the stiffness along, across, and for
    /// both coupling and shear \[Pa\].
    pub fn shares_in(&self, thickness: f64) -> [f64; 3] {
        let stiffness = self.stiffness_in(thickness);
        // The rounded cosine of 90 degrees is not 0.
        let cosine = if self.angle_deg.abs() < 90.0 { self.angle_deg.to_radians().cos() } else { 0.0 };
        let along = cosine * cosine;
        let across = 1.0 - along;
        [along * along, across * across, along * across].map(|share| stiffness * share)
    }
}

impl Orthotropic {
    /// Constants in the plane and outwards; not positive if no material can have these moduli.
    pub(crate) fn constants(&self) -> PlaneConstants {
        let Self { e_theta, e_y, e_r, nu_theta_y, nu_theta_r, nu_y_r, .. } = *self;
        let determinant = self.determinant();
        let plane = [e_theta / determinant, e_y / determinant, nu_theta_y * e_y / determinant];
        let [tt, yy, ty] = plane;
        let along = tt * nu_theta_r / e_theta + ty * nu_y_r / e_y;
        let across = ty * nu_theta_r / e_theta + yy * nu_y_r / e_y;
        let compliance = 1.0 / e_r - along * nu_theta_r / e_theta - across * nu_y_r / e_y;
        PlaneConstants { plane, contraction: [along, across], radial: compliance.recip() }
    }

    /// Modulus \[Pa\] and Poisson's ratio of the isotropic material of shear modulus G_theta_r, which serves as the
    /// scale of the moduli.
    pub fn measure(&self) -> (f64, f64) {
        (2.0 * self.g_theta_r, 0.0)
    }

    /// True if every strain stores energy, given positive moduli.
    pub fn is_positive_definite(&self) -> bool {
        self.determinant() > 0.0 && self.constants().radial > 0.0
    }

    /// D = 1 - nu_theta_y^2 E_y/E_theta, positive for any material.
    fn determinant(&self) -> f64 {
        1.0 - self.nu_theta_y * self.nu_theta_y * self.e_y / self.e_theta
    }
}

pub(super) const CORDS: Each<Cords> = Each(
    Nested::new("cords", "a list of tables, [{ stiffness = ..., angle_deg = ..., loss_factor = ... }]").read_by(cords),
);

pub(super) const ORTHOTROPIC: Nested<Orthotropic> =
    Nested::new("an orthotropic layer", ORTHOTROPIC_KEYS).read_by(orthotropic);
const ORTHOTROPIC_KEYS: &str = "a table, { E_theta = ..., E_y = ..., E_r = ..., G_y_r = ..., G_theta_r = ..., \
                                G_theta_y = ..., nu_theta_y = ..., nu_theta_r = ..., nu_y_r = ... }";
fn cords(table: &mut Table<'_>) -> Option<Cords> {
    let parts = ["spacing", "area", "modulus"];
    let given = parts.map(|key| table.has(key));
    let whole = if table.has("stiffness") {
        match parts.into_iter().zip(given).find(|(_, given)| *given) {
            Some((key, _)) => {
                let wrong = "stiffness is given as well, and says the same";
                table.complain(key, Problem::new(wrong, "leave out stiffness, or spacing, area and modulus"))
            }
            None => Some(()),
        }
    } else if given == [false; 3] {
        table.complain("stiffness", Problem::missing("a number above 0 Pa, or give spacing, area and modulus"))
    } else {
        let missing = parts.into_iter().zip(given).filter(|(_, given)| !given);
        let complain = |(key, _)| table.complain(key, Problem::missing("a positive number, or the cords' stiffness"));
        missing.map(complain).collect()
    };
    let read = Cords::read(table)?;
    whole?;
    Some(read)
}

fn orthotropic(table: &mut Table<'_>) -> Option<Orthotropic> {
    let read = Orthotropic::read(table)?;
    let determinant = read.determinant();
    if determinant <= 0.0 {
        let wrong = format!(
            "{} makes 1 - nu_theta_y^2 E_y/E_theta = {}: strain along and across would release energy",
            short(read.nu_theta_y),
            short(determinant)
        );
        let most = (read.e_theta / read.e_y).sqrt();
        return table.complain("nu_theta_y", Problem::new(wrong, format!("write a number between +-{}", short(most))));
    }
    let compliance = read.constants().radial.recip();
    if compliance <= 0.0 {
        let wrong = format!(
            "{} Pa makes the compliance outwards, with the strains along and across held, {} 1/Pa",
            short(read.e_r),
            short(compliance)
        );
        let most = (read.e_r.recip() - compliance).recip();
        let right = format!("write a number below {} Pa, or smaller nu_theta_r and nu_y_r", short(most));
        return table.complain("E_r", Problem::new(wrong, right));
    }
    Some(read)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The belt of the default tyre, steel cords in rubber, at 1 kHz.
    fn belt() -> Orthotropic {
        Orthotropic {
            e_theta: 1.566e9,
            e_y: 1.095e8,
            e_r: 1.716e8,
            g_y_r: 3.356e7,
            g_theta_r: 3.356e7,
            g_theta_y: 1.207e9,
            nu_theta_y: 3.201,
            nu_theta_r: -2.115,
            nu_y_r: 0.7456,
        }
    }

    #[test]
    fn constants_invert_the_compliances() {
        let belt = belt();
        let PlaneConstants { plane: [tt, yy, ty], contraction: [along, across], radial } = belt.constants();
        // Strains to stresses, and these back to strains.
        for strain in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            let [e, f, g] = strain;
            let outwards = radial * (g + along * e + across * f);
            let stress = [tt * e + ty * f + along * outwards, ty * e + yy * f + across * outwards, outwards];
            let [s, t, u] = stress;
            let [nty, ntr, nyr] = [belt.nu_theta_y, belt.nu_theta_r, belt.nu_y_r];
            let back = [
                s / belt.e_theta - nty / belt.e_theta * t - ntr / belt.e_theta * u,
                -nty / belt.e_theta * s + t / belt.e_y - nyr / belt.e_y * u,
                -ntr / belt.e_theta * s - nyr / belt.e_y * t + u / belt.e_r,
            ];
            for (found, wanted) in back.into_iter().zip(strain) {
                assert!((found - wanted).abs() < 1e-12, "{back:?} {strain:?}");
            }
        }
    }

    #[test]
    fn cords_along_and_across_bear_one_direction_each() {
        let at = |angle_deg| Cords::new(2.0, angle_deg, 0.0).shares_in(1e-3);
        for (angle_deg, wanted) in [(0.0, [2.0, 0.0, 0.0]), (90.0, [0.0, 2.0, 0.0]), (-90.0, [0.0, 2.0, 0.0])] {
            let found = at(angle_deg);
            assert!(found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-300), "{found:?}");
        }
        let of_parts = [1.1e-3, 0.22e-6, 200e9].map(Some);
        let [spacing, area, modulus] = of_parts;
        let parts = Cords { stiffness: None, spacing, area, modulus, ..Cords::new(0.0, 20.0, 0.0) };
        assert!((parts.stiffness_in(2e-3) / 2e10 - 1.0).abs() < 1e-12);
    }
}
