//! Fitted models in the cache on disk.

use std::sync::atomic::AtomicBool;

use super::fit::{FitError, FitOptions, FitTimes, fit_timed};
use super::model::RationalModel;
use crate::scene::Tyre;
use crate::storage::{Cache, CacheKind, Cached, Format};

/// A model and its origin.
#[derive(Debug)]
pub struct Fetched {
    /// The model, valid whatever the warnings.
    pub model: RationalModel,
    /// True if it was read from the cache.
    pub warm: bool,
    /// Times of the fit; `None` if the model was read.
    pub times: Option<FitTimes>,
    /// Faults of the cache.
    pub warnings: Vec<String>,
}

impl Cached for RationalModel {
    const KIND: CacheKind = CacheKind {
        extension: "influence",
        format: Format { magic: b"TWAVEINF", version: 12, name: "an influence model" },
    };

    fn is_valid(&self) -> bool {
        let rows = self.elements / 2 + 1;
        self.waves.fits(2) && [self.waves.len(), self.constants.len(), self.statistics.len()] == [rows; 3]
    }
}

/// Key of a model: all that it depends on.
///
/// # Errors
/// [`FitError::Options`] for a tyre whose numbers are not finite.
pub fn key(tyre: &Tyre, options: &FitOptions) -> Result<[u8; 32], FitError> {
    let not_finite = |_| FitError::Options { what: "tyre", value: f64::NAN, wanted: "finite numbers" };
    crate::storage::cache::key::<RationalModel>(&(tyre.levelled(), options)).map_err(not_finite)
}

/// The model from the cache if it is there and valid, else fitted, unless `stop` is set meanwhile, and stored. Faults
/// of the cache give warnings only.
///
/// # Errors
/// As `fit_timed`.
pub fn fetch(cache: &Cache, tyre: &Tyre, options: &FitOptions, stop: &AtomicBool) -> Result<Fetched, FitError> {
    let key = key(tyre, options)?;
    let mut warnings = Vec::new();
    let mut times = None;
    let model = cache.fetch(&key, &mut warnings, || {
        let (model, taken) = fit_timed(tyre, options, stop)?;
        times = Some(taken);
        Ok(model)
    })?;
    Ok(Fetched { model, warm: times.is_none(), times, warnings })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tyre::poles::turning_ring;

    #[test]
    fn a_cached_turning_model_is_refused_without_all_odd_parts() {
        let directory = tempfile::tempdir().unwrap();
        let cache = Cache::at(directory.path().to_path_buf(), u64::MAX);
        let model = turning_ring::model(16, -70.0);
        cache.store(&[7; 32], &model).unwrap();
        assert_eq!(cache.load::<RationalModel>(&[7; 32]).unwrap().unwrap().unwrap(), model);
        let mut short = model.clone();
        short.waves.residues[1][1].pop();
        assert!(model.is_valid() && !short.is_valid());
    }
}
