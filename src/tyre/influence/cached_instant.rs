//! Influence between cells within an instant, cached on disk by earlier runs: a table of kilobytes instead of a sum of
//! seconds.

use std::convert::Infallible;

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
        let make = || Ok::<_, Infallible>(self.instant(s, columns));
        let Ok(influence) = match (Cache::open(), key::<CellInfluence>(&(self.identity(), s, columns))) {
            (Ok(cache), Ok(key)) => cache.fetch(&key, &mut Vec::new(), make),
            _ => make(),
        };
        influence
    }

    /// [`Self::blended_instant`] from the cache; `name` stands for the `share`.
    pub(crate) fn cached_blended_instant(
        &self,
        s: f64,
        columns: usize,
        other: &Self,
        (name, share): (&str, &(dyn Fn(f64, f64) -> f64 + Sync)),
    ) -> CellInfluence {
        let make = || Ok::<_, Infallible>(self.blended_instant(s, columns, other, share));
        let Ok(influence) =
            match (Cache::open(), key::<CellInfluence>(&(self.identity(), other.identity(), name, s, columns))) {
                (Ok(cache), Ok(key)) => cache.fetch(&key, &mut Vec::new(), make),
                _ => make(),
            };
        influence
    }
}
