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

/// Frequency at which the tread's modulus is taken \[Hz\]: a road's texture loads and unloads a point within some 10
/// ms.
pub(crate) const MODULUS_FREQUENCY: f64 = 100.0;

/// kappa \[m/Pa\] from the tread's effective modulus E* \[Pa\] and the road's mean wavenumber `<k>` \[rad/m\], both
/// positive.
///
/// ```
/// // Dense asphalt, `<k>` = 500 rad/m, under rubber of 7.3 MPa: the tread yields by 0.55 nm a pascal.
/// let kappa = tyrewave::contact::local_compliance::local_compliance(7.3e6, 500.0);
/// assert!((kappa - 5.48e-10).abs() < 0.01e-10);
/// ```
pub fn local_compliance(effective_modulus: f64, mean_wavenumber: f64) -> f64 {
    2.0 / (effective_modulus * mean_wavenumber)
}
