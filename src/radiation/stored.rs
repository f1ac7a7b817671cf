//! Transfers of a body that earlier runs, or this one before it was stopped, have stored on disk: one entry for each
//! receiver of the scene and frequency.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use num_complex::Complex32;
use serde::{Deserialize, Serialize};

use super::body::Vector;
use super::frequencies::{FrequencyRange, FrequencyTransfers};
use super::transfer::{SurfaceTransfer, TransferProblem};
use crate::numeric::in_parallel;
use crate::storage::{Cache, CacheError, CacheKind, Cached, Format, cache};

/// Cache entry: G of the points of a receiver at a frequency.
#[derive(Deserialize, Serialize)]
pub(crate) struct StoredReceiver {
    /// Frequency \[Hz\].
    frequency: f64,
    /// By point, in the order of a transfer's values \[1/m\].
    values: Vec<Vec<Complex32>>,
}

impl Cached for StoredReceiver {
    const KIND: CacheKind = CacheKind {
        extension: "radiation",
        format: Format { magic: b"TWAVERAD", version: 1, name: "radiation transfers" },
    };

    fn is_valid(&self) -> bool {
        self.frequency.is_finite()
            && self.values.iter().flatten().all(|value| value.re.is_finite() && value.im.is_finite())
    }
}

/// Cache entries of a problem.
pub(crate) struct StoredTransfers<'a> {
    cache: Option<Cache>,
    /// True if the cache has failed and is not used any more.
    failed: AtomicBool,
    problem: &'a TransferProblem<'a>,
    range: &'a FrequencyRange,
    /// By receiver of the scene, its points among the receivers of the problem.
    receivers: &'a [Range<usize>],
}

impl<'a> StoredTransfers<'a> {
    /// Entries in the user's cache; none, with a warning, where there is no cache.
    pub(crate) fn open(
        problem: &'a TransferProblem<'a>,
        range: &'a FrequencyRange,
        receivers: &'a [Range<usize>],
        warnings: &mut Vec<String>,
    ) -> Self {
        let cache = Cache::open().map_err(|error| warnings.push(format!("no cache of radiation: {error}"))).ok();
        Self { cache, failed: AtomicBool::new(false), problem, range, receivers }
    }

    /// Key of a receiver's points at a frequency; `None` where it cannot be formed.
    fn key(&self, receiver: usize, frequency: f64) -> Option<[u8; 32]> {
        let TransferProblem { body, grid, flank, resolution, .. } = self.problem;
        let points = self.points(receiver);
        // Frequencies that are equal but for rounding have the same key.
        let millihertz = (1e3 * frequency).round();
        let content = (
            format!("{body:?} {resolution:?}"),
            [grid.around, grid.across],
            self.range.sound_speed,
            points,
            millihertz,
        );
        let key = match (self.problem.sides(), flank) {
            (sides, Some(flank)) => cache::key::<StoredReceiver>(&(content, sides, flank.bead)),
            (1, None) => cache::key::<StoredReceiver>(&content),
            (sides, None) => cache::key::<StoredReceiver>(&(content, sides)),
        };
        key.ok()
    }

    fn points(&self, receiver: usize) -> &[Vector] {
        &self.problem.receivers[self.receivers[receiver].clone()]
    }

    /// Frequencies of the range that are stored \[Hz\]; `None` unless the first is.
    pub(crate) fn frequencies(&self) -> Option<Vec<f64>> {
        let first = self.range.first();
        let stored = || self.range.candidates().into_iter().filter(|&frequency| self.holds(frequency)).collect();
        self.holds(first[0]).then(stored)
    }

    /// True if there is an entry of a frequency for every receiver; its content is not checked.
    fn holds(&self, frequency: f64) -> bool {
        let entry = |receiver: usize| {
            let (cache, key) = self.cache.as_ref().zip(self.key(receiver, frequency))?;
            Some(cache.path::<StoredReceiver>(&key).exists())
        };
        (0..self.receivers.len()).all(|receiver| entry(receiver).unwrap_or(false))
    }

    /// The cache, unless it has failed.
    fn usable(&self) -> Option<&Cache> {
        self.cache.as_ref().filter(|_| !self.failed.load(Ordering::Relaxed))
    }

    /// Those of some frequencies that are stored for every receiver.
    pub(crate) fn load(&self, wanted: &[f64], warnings: &mut Vec<String>) -> Vec<FrequencyTransfers> {
        let Some(cache) = self.usable() else { return Vec::new() };
        let entries = in_parallel::map(wanted, |&frequency| self.at(cache, frequency));
        let mut found = Vec::new();
        for entry in entries {
            match entry {
                Ok(Ok(transfers)) => found.extend(transfers),
                Ok(Err(unusable)) => warnings.push(unusable),
                Err(error) => {
                    warnings.push(format!("cache not read: {error}"));
                    self.failed.store(true, Ordering::Relaxed);
                    break;
                }
            }
        }
        found
    }

    /// Transfers at a frequency if they are stored for every receiver, or a warning about an entry that cannot be used.
    fn at(&self, cache: &Cache, frequency: f64) -> Result<Result<Option<FrequencyTransfers>, String>, CacheError> {
        let mut transfers = Vec::new();
        for receiver in 0..self.receivers.len() {
            let Some(key) = self.key(receiver, frequency) else { return Ok(Ok(None)) };
            match cache.load::<StoredReceiver>(&key)? {
                Some(Ok(stored)) => transfers.extend(self.restored(receiver, stored)),
                Some(Err(reason)) => {
                    let path = cache.path::<StoredReceiver>(&key);
                    return Ok(Err(format!("cache entry {} is made anew: {reason}", path.display())));
                }
                None => return Ok(Ok(None)),
            }
        }
        let whole = transfers.len() == self.problem.receivers.len();
        Ok(Ok(whole.then_some(FrequencyTransfers { frequency, transfers })))
    }

    fn restored(&self, receiver: usize, stored: StoredReceiver) -> Vec<SurfaceTransfer> {
        let points = self.points(receiver);
        let (grid, sides, values_of_each) = (self.problem.grid, self.problem.sides(), self.problem.values());
        let wavenumber = self.range.wavenumber(stored.frequency);
        let transfer = |(values, position): (Vec<Complex32>, &Vector)| SurfaceTransfer {
            receiver: *position,
            wavenumber,
            grid,
            sides,
            values,
        };
        let whole = |(values, _): &(Vec<Complex32>, &Vector)| values.len() == values_of_each;
        stored.values.into_iter().zip(points).filter(whole).map(transfer).collect()
    }

    /// Stores a finished frequency, receiver by receiver; a failure gives one warning, and ends the use of the cache.
    pub(crate) fn store(&self, found: &FrequencyTransfers, warnings: &mut Vec<String>) {
        for (index, points) in self.receivers.iter().enumerate() {
            let Some((cache, key)) = self.usable().zip(self.key(index, found.frequency)) else { return };
            let transfers = found.transfers[points.clone()].iter();
            let values = transfers.map(|transfer| transfer.values.clone()).collect();
            if let Err(error) = cache.store(&key, &StoredReceiver { frequency: found.frequency, values }) {
                warnings.push(format!("cache not written: {error}"));
                self.failed.store(true, Ordering::Relaxed);
            }
        }
    }
}
