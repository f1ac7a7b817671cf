//! The curves of a road's slices as the tyre reaches them: block by block, each block the same whatever is requested
//! before, after and with it.
//!
//! A block presses more road than the slices it is asked for: [`BEYOND`] thicknesses of the tread on either side, so
//! that each slice is taken from the block in which it is farthest from an end. Blocks stand at fixed places of the
//! road; one that repeats is pressed in its first period, and beyond its end with its beginning. Where the road ends,
//! the block has a void.

use std::convert::Infallible;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::flat_tread::FlatTread;
use super::press::{APPROACHES, Press, TOP_PRESSURE};
use super::yielding::Yielding;
use crate::road::maker::{MakingError, StripCurves};
use crate::road::slices::{SliceError, StiffnessCurve};
use crate::road::{Lattice, RoadSurface};
use crate::scene::Tyre;
use crate::storage::cache::key;
use crate::storage::{Cache, CacheKind, Cached, Format};

/// Road that is pressed beyond either end of the slices that a block gives, in thicknesses of the tread: an end has
/// influence up to four of them away (p of two blocks then differs by some 0.01 mm, as their approaches do).
pub(crate) const BEYOND: f64 = 10.0;
/// Length of the slices that a block gives, in circumferences of the tyre.
const INNER: f64 = 0.4;

/// Elements whose slices a block gives, and those beyond them on either side, for a tyre's circumference, its tread's
/// thickness, and elements of a length \[m\].
pub(crate) fn block_elements(circumference: f64, thickness: f64, element: f64) -> [i64; 2] {
    let inner = INNER * circumference;
    [inner, (BEYOND * thickness).min(0.5 * inner)].map(|length| (length / element).round().max(1.0) as i64)
}

/// How the slices of a block yield, as it is cached on disk.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(crate) struct CachedBlock(Vec<Yielding>);

impl Cached for CachedBlock {
    const KIND: CacheKind =
        CacheKind { extension: "pressed", format: Format { magic: b"TWAVEPRS", version: 2, name: "a pressed road" } };

    fn is_valid(&self) -> bool {
        self.0.iter().all(Yielding::is_valid)
    }
}

/// The pressed curves of a road.
pub struct PressedRoad {
    tread: FlatTread,
    lattice: Lattice,
    crown: Vec<f64>,
    /// Elements whose slices a block gives.
    inner: i64,
    /// Elements beyond them on either side.
    beyond: i64,
    /// Made when a block is not on disk.
    press: Option<Press>,
    is_cached: bool,
    /// The last block: its first element, and the curves from there on.
    block: Option<(i64, Vec<StiffnessCurve>)>,
    heights: Vec<f64>,
}

impl PressedRoad {
    /// The road under a tyre's tread; `crown`: height of the tread above its middle by cell across \[m\]. `None` for a
    /// tyre without layers.
    pub fn new(tyre: &Tyre, lattice: Lattice, crown: Vec<f64>) -> Option<Self> {
        let tread = FlatTread::of(tyre)?;
        let [inner, beyond] = block_elements(tyre.circumference, tread.thickness(), lattice.dx);
        let heights = vec![0.0; (inner + 2 * beyond) as usize * lattice.cells()];
        Some(Self { tread, lattice, crown, inner, beyond, press: None, is_cached: true, block: None, heights })
    }

    /// The same without the cache on disk.
    #[must_use]
    pub fn uncached(self) -> Self {
        Self { is_cached: false, ..self }
    }

    /// Compliance c \[m/N\] with which the curves are given.
    pub fn spring(&self) -> f64 {
        self.tread.spring(self.lattice)
    }

    /// How the slices of a block yield: `count` of them from the element `first` on.
    fn yielding(&mut self, surface: &mut RoadSurface, first: i64, count: usize) -> Result<CachedBlock, MakingError> {
        self.read_heights(surface, first)?;
        let slices = self.beyond as usize..self.beyond as usize + count;
        let Self { tread, lattice, crown, press, heights, inner, beyond, .. } = self;
        let elements = (*inner + 2 * *beyond) as usize;
        let key =
            key::<CachedBlock>(&(&*tread, &*lattice, &*crown, APPROACHES, TOP_PRESSURE, slices.clone(), &*heights));
        let make = || {
            let press = press.get_or_insert_with(|| Press::new(tread, *lattice, crown.clone(), elements));
            Ok::<_, Infallible>(CachedBlock(press.press(heights, slices)))
        };
        let cache = if self.is_cached { Cache::open().ok() } else { None };
        let Ok(block) = match (cache, key) {
            (Some(cache), Ok(key)) => cache.fetch(&key, &mut Vec::new(), make),
            _ => make(),
        };
        Ok(block)
    }

    /// Reads the heights of a block, -infinity where there is no road.
    fn read_heights(&mut self, surface: &mut RoadSurface, first: i64) -> Result<(), MakingError> {
        let cells = self.lattice.cells();
        let window = first - self.beyond..first + self.inner + self.beyond;
        let (lowest, highest) = surface.elements().unwrap_or((i64::MIN, i64::MAX - 1));
        let there = window.start.max(lowest)..window.end.min(highest + 1);
        self.heights.fill(f64::NEG_INFINITY);
        if there.is_empty() {
            return Ok(());
        }
        let start = (there.start - window.start) as usize * cells;
        let count = (there.end - there.start) as usize;
        let heights = &mut self.heights[start..start + count * cells];
        surface.heights(there.start, count, heights)?;
        Ok(SliceError::refuse_holes(heights, cells)?)
    }

    /// Curve of an element; presses its block, or fetches it from disk, unless it is the last one.
    fn curve(&mut self, surface: &mut RoadSurface, element: i64) -> Result<StiffnessCurve, MakingError> {
        let period = surface.period();
        let element = period.map_or(element, |period| element.rem_euclid(period));
        let first = element.div_euclid(self.inner) * self.inner;
        if self.block.as_ref().is_none_or(|(of, _)| *of != first) {
            // A block at the end of a period gives fewer.
            let end = period.map_or(first + self.inner, |period| (first + self.inner).min(period));
            let CachedBlock(slices) = self.yielding(surface, first, (end - first) as usize)?;
            let spring = self.spring();
            self.block = Some((first, slices.iter().map(|slice| slice.curve(spring)).collect()));
        }
        let place = (element - first) as usize;
        let curve = self.block.as_ref().and_then(|(_, curves)| curves.get(place)).cloned();
        curve.ok_or(MakingError::Slices(SliceError::Empty))
    }
}

impl StripCurves for PressedRoad {
    fn curves(&mut self, surface: &mut RoadSurface, elements: Range<i64>) -> Result<Vec<StiffnessCurve>, MakingError> {
        elements.map(|element| self.curve(surface, element)).collect()
    }
}
