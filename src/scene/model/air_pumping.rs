//! `[air_pumping]`: the air under the contact patch.

use serde::{Deserialize, Serialize};

use crate::scene::keys::{is_default, keys};
use crate::scene::kind::{Flag, OneOf};
use crate::scene::table::Nested;

/// Paths of the air under the patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PatchAir {
    /// None: the patch is sealed all over.
    #[default]
    Sealed,
    /// The grooves that run round the tyre; the ribs between them are sealed.
    Grooves,
    /// All voids between tread and road, those of grooves and of the road's texture, as they stand at some places.
    Voids,
}

keys! {
    /// Air under the contact patch.
    #[derive(Clone, Debug, PartialEq, Eq, Serialize)]
    pub AirPumping {
        /// Paths of the air under the patch: none, the grooves of `[tread_pattern]` that run round the tyre, or all
        /// voids between tread and road.
        patch: PatchAir = PatchAir::Sealed => OneOf::new(),
        /// True if compliant blocks of `[tread_pattern]` press air into the voids beside them, as much as the volume of
        /// their compression.
        #[serde(skip_serializing_if = "is_default")]
        squeeze: bool = false => Flag,
    }
}

pub(in crate::scene) const AIR_PUMPING: Nested<AirPumping> =
    Nested::new("[air_pumping]", "the table [air_pumping] with patch = \"sealed\", \"grooves\" or \"voids\"");
