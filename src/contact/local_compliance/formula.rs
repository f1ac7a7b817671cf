//! The one parameter of the local contact law: how much a tread yields to the texture under a mean pressure.
//!
//! A wave of wavenumber k \[rad/m\] displaces the surface of a half-space by 2 p/(E* k). Averaged over the waves of a
//! road, weighted by their mean squares, the tread yields to the texture by
//!
//! ```text
//! kappa = 2/(E* <k>),   E* = |E(2 pi i f)|/(1 - nu^2).
//! ```
//!
//! On an isotropic road `<k>` = (pi/2) `<k_x>`, `<k_x>` being the mean wavenumber of its profiles: kappa E* =
//! (4/pi)/`<k_x>`. The height of the texture is not in it, nor the size of an element: an element dx by b has c =
//! kappa/(dx b) \[m/N\].
//!
//! The waves that count end at 4 mm (`SHORTEST` of the road's wavenumbers), whatever
//! the run's cells resolve: a convention of the law, not a property of the road. Shorter ones would raise `<k>` and
//! lower kappa, most on roads whose finest texture is strong.

use crate::road::{Lattice, Limits, RoadSurface};
use crate::scene::{Road, Scene, Tyre};
use crate::tyre::layers::material;

/// Frequency at which the tread's modulus is taken \[Hz\]: a road's texture loads and unloads a point within some
/// 10 ms.
const MODULUS_FREQUENCY: f64 = 100.0;

/// Uncertainty of the model: formula, approach and line pressure give kappa within a factor of two of each other.
pub(crate) const UNCERTAINTY: [(&str, f64); 2] = [("half", 0.5), ("twice", 2.0)];

/// kappa \[m/Pa\] by formula; `None` for a road without texture (a smooth one, an exactly level one) and a tyre
/// without layers.
pub fn local_compliance(tyre: &Tyre, road: &RoadSurface) -> Option<f64> {
    Some(compliance(tread_modulus(tyre)?, road.mean_wavenumber()?))
}

/// kappa \[m/Pa\] from the tread's effective modulus E* \[Pa\] and the road's mean wavenumber `<k>` \[rad/m\], both
/// positive.
fn compliance(effective_modulus: f64, mean_wavenumber: f64) -> f64 {
    2.0 / (effective_modulus * mean_wavenumber)
}

/// kappa \[m/Pa\] by formula for a scene; `None` where its road has no texture or cannot be opened.
pub(crate) fn formula_for(scene: &Scene) -> Option<f64> {
    let lattice = Lattice::choose(&scene.road, Road::CELL, scene.tyre.contact_width, None, None).ok()?;
    local_compliance(&scene.tyre, &RoadSurface::open(&scene.road, lattice, Limits::default()).ok()?)
}

/// E* \[Pa\] of the tyre's top layer at the formula's frequency; `None` for a tyre without layers.
pub fn tread_modulus(tyre: &Tyre) -> Option<f64> {
    let tread = tyre.layers.last()?;
    Some(material::effective_modulus(&tread.material, MODULUS_FREQUENCY))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::scene::{LoadedScene, PLATE};
    use crate::test_models::{self, CHIP_SEAL, reference};

    #[test]
    fn the_formula_gives_half_a_nanometre_a_pascal() {
        // Dense asphalt, `<k>` = 500 rad/m, under rubber of 7.3 MPa.
        assert!((compliance(7.3e6, 500.0) - 5.48e-10).abs() < 0.01e-10);
    }

    pub(crate) fn scene(road: &str) -> LoadedScene {
        test_models::scene(&test_models::with_road(PLATE, road))
    }

    pub(crate) fn surface(loaded: &LoadedScene) -> RoadSurface {
        let tyre = &loaded.scene.tyre;
        let lattice = Lattice::choose(&loaded.scene.road, 0.0038, tyre.contact_width, None, None).unwrap();
        RoadSurface::open(&loaded.scene.road, lattice, Limits::default()).unwrap()
    }

    #[test]
    fn rough_asphalt_has_the_known_compliance_at_any_level() {
        let default = scene("kind = \"made\"\nseed = 1\ntexture = \"rough-asphalt\"");
        let of = |loaded: &LoadedScene| local_compliance(&loaded.scene.tyre, &surface(loaded)).unwrap();
        let (kappa, modulus) = (of(&default), tread_modulus(&default.scene.tyre).unwrap());
        // The band of 125 mm, which the measured levels leave open, makes it 3 % longer than these alone.
        assert!((kappa * modulus / 4.0e-3 - 1.0).abs() < 0.05, "kappa E* = {}", kappa * modulus);
        assert!((kappa / 5.5e-10 - 1.0).abs() < 0.05, "{kappa:e}");
    }

    #[test]
    fn a_road_without_texture_has_none() {
        let smooth = scene("kind = \"smooth\"");
        assert_eq!(local_compliance(&smooth.scene.tyre, &surface(&smooth)), None);
    }

    #[test]
    fn measured_roads_keep_their_spacing_whatever_the_elements() {
        let file = reference(CHIP_SEAL);
        let of = |lateral: &str, element: f64| {
            let loaded = scene(&format!(
                "kind = \"profile\"\nfile = '{}'\nlateral = \"{lateral}\"\nat_end = \"mirror\"",
                file.display()
            ));
            let lattice =
                Lattice::choose(&loaded.scene.road, element, loaded.scene.tyre.contact_width, None, None).unwrap();
            RoadSurface::open(&loaded.scene.road, lattice, Limits::default()).unwrap().mean_wavenumber().unwrap()
        };
        let extruded = of("extruded", 0.0038);
        assert!((of("extruded", 0.0076) / extruded - 1.0).abs() < 1e-12);
        // The isotropic surface has the profile's levels of most bands, and its waves run under all angles.
        assert!((of("isotropic", 0.0038) / (0.5 * std::f64::consts::PI * extruded) - 1.0).abs() < 0.3);
    }
}
