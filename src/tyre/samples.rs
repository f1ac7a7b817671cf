//! A tyre to test with.

use crate::scene::{DEFAULT, Scene, Tyre};

/// The default tyre with a tread of the given loss factor, layers of one density and a wider strip.
pub fn tyre(loss_factor: f64) -> Tyre {
    let mut tyre = Tyre { contact_width: 0.15, ..Scene::from_str(DEFAULT, "default").unwrap().scene.tyre };
    tyre.layers.iter_mut().for_each(|layer| layer.material.density = 1200.0);
    tyre.layers[1].material.loss_factor = loss_factor;
    tyre
}
