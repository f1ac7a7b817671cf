//! Constructed roads as they may be.

use crate::scene::NamedTexture;
use crate::study::sweep::corner_values;

/// A constructed road as it may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum RoadCase {
    /// As it is stated.
    Stated,
    /// With all levels off \[dB\].
    Offset(f64),
    /// With another skewness.
    Skewness(f64),
}

impl RoadCase {
    /// Cases of a road, that as stated first; none for a measured road.
    pub(super) fn of(texture: NamedTexture) -> Vec<Self> {
        let Some([offsets, skewness]) = corner_values(texture, [0.0, texture.moments()[0]]) else { return Vec::new() };
        let offsets = offsets.into_iter().skip(1).map(Self::Offset);
        let skewness = skewness.into_iter().skip(1).map(Self::Skewness);
        std::iter::once(Self::Stated).chain(offsets).chain(skewness).collect()
    }

    /// Keys of `[road]`, each with a comma before it.
    pub(super) fn keys(self) -> String {
        match self {
            Self::Stated => String::new(),
            Self::Offset(offset) => format!(", offset = {offset:?}"),
            Self::Skewness(skewness) => format!(", skewness = {skewness:?}"),
        }
    }

    /// The case after the name of its road.
    pub(super) fn text(self) -> String {
        match self {
            Self::Stated => " as stated".to_owned(),
            Self::Offset(offset) => format!(" {offset:+} dB"),
            Self::Skewness(skewness) => format!(" with skewness {skewness}"),
        }
    }

    pub(super) fn is_level(self) -> bool {
        matches!(self, Self::Offset(_))
    }
}
