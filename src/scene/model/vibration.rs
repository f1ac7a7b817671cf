//! Vibration of the tyre: what is wanted of it.

use serde::{Deserialize, Serialize};

/// Which velocities are computed from the contact forces, and how they are shown. A scene without this table computes
/// none.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Vibration {
    /// Normal velocity of the tread surface, local deformation included.
    pub tread: bool,
    /// Normal velocity of the belt's inner face.
    pub belt: bool,
    /// Tangential velocity of the tread surface under the normal forces.
    pub tangential: bool,
    /// The frames of the spectra.
    pub frames: Frames,
    /// Positions along the circumference from the axle, positive in the rolling direction, at which spectra of the
    /// non-rotating frame are wanted \[m\].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<f64>,
    /// Numbers 0..N of elements at which spectra of the material frame are wanted: points that turn with the tyre. The
    /// element e meets the road at the distance e dx from its beginning.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub elements: Vec<usize>,
    /// Maps over wavenumber and frequency.
    pub map: bool,
    /// Length of the averaged segments, brought to whole revolutions \[s\].
    pub segment: f64,
}

impl Vibration {
    /// Default length of the averaged segments \[s\]: a resolution of 1 Hz, fine beside any resonance of rubber.
    pub const SEGMENT: f64 = 1.0;
}

impl Default for Vibration {
    fn default() -> Self {
        Self {
            tread: true,
            belt: true,
            tangential: false,
            frames: Frames::Both,
            points: Vec::new(),
            elements: Vec::new(),
            map: false,
            segment: Self::SEGMENT,
        }
    }
}

/// Who looks at the tyre.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Frames {
    /// Both of the following.
    #[default]
    Both,
    /// Somebody on the tread.
    Material,
    /// Somebody beside the road who moves along with the axle.
    NonRotating,
}

impl Frames {
    /// Whether spectra in the material frame are wanted.
    pub const fn material(self) -> bool {
        matches!(self, Self::Both | Self::Material)
    }

    /// Whether spectra in the non-rotating frame are wanted.
    pub const fn non_rotating(self) -> bool {
        matches!(self, Self::Both | Self::NonRotating)
    }
}
