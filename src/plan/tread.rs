//! The tread's pattern on the points of a plan.

use super::Plan;
use super::decisions::{tread_blocks, tread_map};
use crate::tyre::tread_pattern::blocks::Blocks;
use crate::tyre::tread_pattern::map::TreadMap;

impl Plan {
    /// Returns the map of the tread, where contact takes it in.
    pub(crate) fn tread_map(&self) -> Option<TreadMap> {
        tread_map(&self.scene, &self.decisions)?.ok()
    }

    /// Returns the map of the tread and the blocks that yield by themselves; `None` for a level one.
    pub(crate) fn tread(&self) -> Option<(TreadMap, Option<Blocks>)> {
        let map = self.tread_map().filter(|map| !map.is_level())?;
        let blocks = tread_blocks(&self.scene, &map);
        Some((map, blocks))
    }
}
