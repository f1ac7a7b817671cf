//! Transfers of a body that earlier runs, or this one before it was stopped, have stored on disk: one entry for each
//! receiver of the scene and frequency.

use std::sync::atomic::{AtomicBool, Ordering};

use num_complex::Complex32;
use serde::{Deserialize, Serialize};

use super::planned::Sound;
use crate::numeric::in_parallel;
use crate::plan::Plan;
use crate::radiation::{FrequencyRange, FrequencyTransfers, Transfer, TransferProblem};
use crate::scene::RadiationQuality;
use crate::sound::Air;
use crate::storage::{Cache, CacheError, Cached, Format, Kind};

/// Cache entry: G of the points of a receiver at a frequency.
#[derive(Deserialize, Serialize)]
pub(crate) struct KeptReceiver {
    /// Frequency \[Hz\].
    frequency: f64,
    /// By point, in the order of a transfer's values \[1/m\].
    values: Vec<Vec<Complex32>>,
}

impl Cached for KeptReceiver {
    const KIND: Kind =
        Kind { extension: "radiation", format: Format { magic: b"TWAVERAD", version: 1, name: "radiation transfers" } };

    fn is_valid(&self) -> bool {
        self.frequency.is_finite()
            && self.values.iter().flatten().all(|value| value.re.is_finite() && value.im.is_finite())
    }
}

/// Largest relative error of the expected patch length before the static contact is solved.
const PATCH_ERROR: f64 = 0.2;

impl Plan {
    /// Frequencies that are stored for the sound of the run \[Hz\]; none without receivers, or where no equations are
    /// solved. The static contact is not solved yet: entries of a patch about as long as expected are taken for the
    /// run's.
    pub(super) fn frequencies_on_disk(&self) -> Vec<f64> {
        let solved = |sound: &Sound| sound.radiation.quality == RadiationQuality::Full;
        let Some(sound) = self.sound().filter(solved) else { return Vec::new() };
        let Some(air) = Air::at(sound.radiation.temperature) else { return Vec::new() };
        let range = sound.range(&air);
        let at_rest = self.expected().length;
        let step = self.patch_step();
        let reach = (PATCH_ERROR * at_rest / step) as i64;
        // The nearest first; a patch length that the scene gives is the same for all of them.
        let mut tried: Vec<i64> = (-reach..=reach).collect();
        tried.sort_by_key(|steps| steps.abs());
        let mut found = tried.into_iter().filter_map(|steps| {
            let body = self.radiating_body(&sound.radiation, at_rest + steps as f64 * step).ok()?;
            let problem = sound.problem(&body, self.scene.numerics.memory_bytes());
            let kept = KeptTransfers::open(&problem, &range, &sound, &mut Vec::new());
            let first = range.first();
            kept.holds(first[0]).then(|| range.candidates().into_iter().filter(|&found| kept.holds(found)).collect())
        });
        found.next().unwrap_or_default()
    }
}

/// Cache entries of a problem.
pub(crate) struct KeptTransfers<'a> {
    cache: Option<Cache>,
    /// True if the cache has failed and is not used any more.
    failed: AtomicBool,
    problem: &'a TransferProblem<'a>,
    range: &'a FrequencyRange,
    sound: &'a Sound,
}

impl<'a> KeptTransfers<'a> {
    /// Entries in the user's cache; none, with a warning, where there is no cache.
    pub(crate) fn open(
        problem: &'a TransferProblem<'a>,
        range: &'a FrequencyRange,
        sound: &'a Sound,
        warnings: &mut Vec<String>,
    ) -> Self {
        let cache = Cache::open().map_err(|error| warnings.push(format!("no cache of radiation: {error}"))).ok();
        Self { cache, failed: AtomicBool::new(false), problem, range, sound }
    }

    /// Key of a receiver's points at a frequency; `None` where it cannot be formed.
    fn key(&self, receiver: usize, frequency: f64) -> Option<[u8; 32]> {
        let TransferProblem { body, grid, flank, resolution, .. } = self.problem;
        let points = &self.sound.positions[self.sound.receivers[receiver].points.clone()];
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
            (sides, Some(flank)) => crate::storage::cache::key::<KeptReceiver>(&(content, sides, flank.bead)),
            (1, None) => crate::storage::cache::key::<KeptReceiver>(&content),
            (sides, None) => crate::storage::cache::key::<KeptReceiver>(&(content, sides)),
        };
        key.ok()
    }

    /// True if there is an entry of a frequency for every receiver; its content is not checked.
    fn holds(&self, frequency: f64) -> bool {
        let entry = |receiver: usize| {
            let (cache, key) = self.cache.as_ref().zip(self.key(receiver, frequency))?;
            Some(cache.path::<KeptReceiver>(&key).exists())
        };
        (0..self.sound.receivers.len()).all(|receiver| entry(receiver).unwrap_or(false))
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
        for receiver in 0..self.sound.receivers.len() {
            let Some(key) = self.key(receiver, frequency) else { return Ok(Ok(None)) };
            match cache.load::<KeptReceiver>(&key)? {
                Some(Ok(kept)) => transfers.extend(self.restored(receiver, kept)),
                Some(Err(reason)) => {
                    let path = cache.path::<KeptReceiver>(&key);
                    return Ok(Err(format!("cache entry {} is made anew: {reason}", path.display())));
                }
                None => return Ok(Ok(None)),
            }
        }
        let whole = transfers.len() == self.sound.points();
        Ok(Ok(whole.then_some(FrequencyTransfers { frequency, transfers })))
    }

    fn restored(&self, receiver: usize, kept: KeptReceiver) -> Vec<Transfer> {
        let points = &self.sound.positions[self.sound.receivers[receiver].points.clone()];
        let (grid, sides, values_of_each) = (self.problem.grid, self.problem.sides(), self.problem.values());
        let wavenumber = self.range.wavenumber(kept.frequency);
        let transfer = |(values, position): (Vec<Complex32>, &[f64; 3])| Transfer {
            receiver: *position,
            wavenumber,
            grid,
            sides,
            values,
        };
        let whole = |(values, _): &(Vec<Complex32>, &[f64; 3])| values.len() == values_of_each;
        kept.values.into_iter().zip(points).filter(whole).map(transfer).collect()
    }

    /// Stores a finished frequency, receiver by receiver; a failure gives one warning, and ends the use of the cache.
    pub(crate) fn store(&self, found: &FrequencyTransfers, warnings: &mut Vec<String>) {
        for (index, receiver) in self.sound.receivers.iter().enumerate() {
            let Some((cache, key)) = self.usable().zip(self.key(index, found.frequency)) else { return };
            let transfers = found.transfers[receiver.points.clone()].iter();
            let values = transfers.map(|transfer| transfer.values.clone()).collect();
            if let Err(error) = cache.store(&key, &KeptReceiver { frequency: found.frequency, values }) {
                warnings.push(format!("cache not written: {error}"));
                self.failed.store(true, Ordering::Relaxed);
            }
        }
    }
}
