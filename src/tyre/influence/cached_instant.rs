//! Influence between cells within an instant, cached on disk by earlier runs: a table of kilobytes instead of a sum of
//! seconds.

use std::convert::Infallible;

use serde::Serialize;

use super::cell_influence::CellInfluence;
use super::cell_sums::CellSums;
use crate::storage::cache::key;
use crate::storage::{Cache, CacheKind, Cached, Format};

impl Cached for CellInfluence {
    const KIND: CacheKind = CacheKind {
        extension: "instant",
        format: Format { magic: b"TWAVECIN", version: 1, name: "an influence between cells" },
    };

    fn is_valid(&self) -> bool {
        let Self { columns, across, toeplitz, hankel, odd } = self;
        let fits = |toeplitz: &[f64], hankel: &[f64]| {
            Some(toeplitz.len()) == columns.checked_mul(*across)
                && Some(hankel.len()) == columns.checked_mul((2 * across).saturating_sub(1))
                && toeplitz.iter().chain(hankel).all(|value| value.is_finite())
        };
        fits(toeplitz, hankel) && odd.as_ref().is_none_or(|odd| fits(&odd.toeplitz, &odd.hankel))
    }
}

impl CellSums {
    /// [`Self::instant`] from the cache, computed and stored where it is not there, or where the cache cannot be used.
    pub fn cached_instant(&self, s: f64, columns: usize) -> CellInfluence {
        cached(&(self.identity(), s, columns), || self.instant(s, columns))
    }

    /// [`Self::short_waves`] in the same way.
    pub(super) fn cached_short_waves(&self, columns: usize, last: (i64, usize)) -> CellInfluence {
        cached(&(self.identity(), last, columns), || self.short_waves(columns, last))
    }

    /// [`Self::blended_instant`] in the same way; `name` stands for the `share`.
    pub(crate) fn cached_blended_instant(
        &self,
        s: f64,
        columns: usize,
        last: (i64, usize),
        (other, name, share): (&Self, &str, &(dyn Fn(f64, f64) -> f64 + Sync)),
    ) -> CellInfluence {
        let of = (self.identity(), other.identity(), name, last, s, columns);
        cached(&of, || self.blended_instant(s, columns, last, (other, share)))
    }
}

fn cached(of: &impl Serialize, make: impl Fn() -> CellInfluence) -> CellInfluence {
    let made = || Ok::<_, Infallible>(make());
    let Ok(influence) = match (Cache::open(), key::<CellInfluence>(of)) {
        (Ok(cache), Ok(key)) => cache.fetch(&key, &mut Vec::new(), made),
        _ => made(),
    };
    influence
}
