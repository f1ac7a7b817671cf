//! The tread's pattern on the points of a plan.

use super::Plan;
use super::decisions::{tread_blocks, tread_map};
use crate::tyre::tread_pattern::blocks::TreadBlocks;
use crate::tyre::tread_pattern::map::TreadMap;

impl Plan {
    /// Map of the tread, if the contact law takes it into account.
    #[doc(hidden)]
    pub fn tread_map(&self) -> Option<TreadMap> {
        tread_map(&self.scene, &self.decisions)?.ok()
    }

    /// Map of the tread and the blocks with a separate compliance; `None` for a level tread.
    #[doc(hidden)]
    pub fn tread(&self) -> Option<(TreadMap, Option<TreadBlocks>)> {
        let map = self.tread_map().filter(|map| !map.is_level())?;
        let blocks = tread_blocks(&self.scene, &map);
        Some((map, blocks))
    }
}
