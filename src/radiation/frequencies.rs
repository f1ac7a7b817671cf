//! The frequencies of a tyre's transfers, chosen by checked midpoints, and transfers at any frequency between them.
//!
//! With exp(-i k r0) taken out, r0 from the receiver to the contact's centre, G_N changes slowly with frequency;
//! between the known frequencies it is a polynomial of degree 3 through the four nearest.
//!
//! 1. Start with intervals of at most `coarsest` \[Hz\].
//! 2. In every open interval compute the middle; compare it with the interpolation between the frequencies known
//!    before. The error is the root mean square of the difference over the tread's grid relative to that of G_N, for
//!    the worst receiver.
//! 3. Within the tolerance both halves are closed, else both are open; not below `finest` \[Hz\].
//!
//! The computed middle stays, so the remaining error is that of intervals half as long as those that passed: for degree
//! 3 some sixteenth of the tolerance where the function is smooth.
//!
//! Transfers are in single precision, in which they are stored: one that was stored has the same bits as one that was
//! just solved for.
//!
//! Frequencies of one round are spread over threads, as many at once as the memory limit allows, the costly ones first,
//! so that no thread is left with a long one when the others have finished; each is sequential in itself, and the
//! choice depends on values alone: same bits for any number of threads.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use num_complex::Complex64;

use super::body::{RadiatingBody, Vector};
use super::cost::RadiationCost;
use super::elements::distance;
use super::error::{RadiationError, positive};
use super::solve::SolveReport;
use super::transfer::{SurfaceTransfer, TransferProblem, contact_distance};
use crate::numeric::{double, in_parallel, lagrange, single};

/// Range of frequencies, and the rule by which they are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrequencyRange {
    /// Lowest \[Hz\].
    pub lowest: f64,
    /// Highest \[Hz\].
    pub highest: f64,
    /// Largest interval to start with \[Hz\].
    pub coarsest: f64,
    /// Smallest interval \[Hz\]: not halved below.
    pub finest: f64,
    /// Error of an interpolated middle that is accepted \[dB\].
    pub tolerance: f64,
    /// Speed of sound \[m/s\].
    pub sound_speed: f64,
}

impl FrequencyRange {
    /// From 25 Hz up to a highest frequency, with intervals from 100 Hz down to 6 Hz.
    pub(crate) fn up_to(highest: f64, tolerance: f64, sound_speed: f64) -> Self {
        Self { lowest: 25.0, highest, coarsest: 100.0, finest: 6.0, tolerance, sound_speed }
    }

    /// [`RadiationError::NotPositive`] for an empty range or a number that is not positive.
    pub(crate) fn check(&self) -> Result<(), RadiationError> {
        positive("the lowest frequency", self.lowest)?;
        positive("the highest frequency less the lowest", self.highest - self.lowest)?;
        positive("the coarsest frequency step", self.coarsest)?;
        positive("the finest frequency step", self.finest)?;
        positive("the tolerance", self.tolerance)?;
        positive("the speed of sound", self.sound_speed)
    }

    /// Wavenumber of a frequency \[rad/m\].
    pub(crate) fn wavenumber(&self, frequency: f64) -> f64 {
        std::f64::consts::TAU * frequency / self.sound_speed
    }

    /// All frequencies that may be chosen, rising \[Hz\].
    pub(crate) fn candidates(&self) -> Vec<f64> {
        let mut candidates = self.first();
        while candidates[1] - candidates[0] >= 2.0 * self.finest {
            let middles: Vec<f64> = candidates.windows(2).map(|ends| 0.5 * (ends[0] + ends[1])).collect();
            candidates.extend(middles);
            candidates.sort_by(f64::total_cmp);
        }
        candidates
    }

    /// Frequencies of the first round, evenly spaced \[Hz\].
    pub(crate) fn first(&self) -> Vec<f64> {
        let parts = ((self.highest - self.lowest) / self.coarsest - 1e-9).ceil().max(1.0) as usize;
        (0..=parts).map(|i| self.lowest + (self.highest - self.lowest) * i as f64 / parts as f64).collect()
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SetUpCost {
    /// Frequencies to be solved for: those of the first round and their midpoints. Where these do not keep the
    /// tolerance there are more: 15 % for a standing tyre at 0.2 dB and intervals of 100 Hz.
    pub frequencies: usize,
    /// Sums over these; patches, unknowns, points and bytes are those of the highest frequency.
    pub cost: RadiationCost,
    /// Memory of the stored transfers \[bytes\].
    pub bytes_stored: u64,
}

impl SetUpCost {
    /// Expected cost of a problem over a range of frequencies, of which some are known.
    ///
    /// # Errors
    /// As [`TransferProblem::check`] and [`FrequencyRange::check`].
    pub(crate) fn expected(
        problem: &TransferProblem<'_>,
        range: &FrequencyRange,
        known: &[f64],
    ) -> Result<Self, RadiationError> {
        range.check()?;
        problem.check()?;
        let first = range.first();
        let middles = first.windows(2).map(|ends| 0.5 * (ends[0] + ends[1]));
        let mut all: Vec<f64> = first.iter().copied().chain(middles).collect();
        all.sort_by(f64::total_cmp);
        let count = all.len();
        all.retain(|&frequency| !known.iter().any(|&known| same(frequency, known)));
        let mut sum = RadiationCost::default();
        for &frequency in &all {
            let k = range.wavenumber(frequency);
            let cost = RadiationCost::expected(problem.body, k, k, &problem.resolution, problem.blocks)?;
            sum = RadiationCost {
                far_evaluations: sum.far_evaluations + cost.far_evaluations,
                near_evaluations: sum.near_evaluations + cost.near_evaluations,
                factor_operations: sum.factor_operations + cost.factor_operations,
                ..cost
            };
        }
        let values = problem.receivers.len() * problem.values();
        Ok(Self { frequencies: all.len(), cost: sum, bytes_stored: 8 * (values * count) as u64 })
    }
}

/// Transfers to all receivers at one frequency.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FrequencyTransfers {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Transfer by receiver.
    pub transfers: Vec<SurfaceTransfer>,
}

/// Progress of the work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrequencyProgress {
    /// Finished frequencies, those known before included.
    pub finished: usize,
    /// Frequencies of this round that are still to come.
    pub open: usize,
    /// Number of the round; 0 for the first frequencies.
    pub round: usize,
}

/// Report on the choice of frequencies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FrequencyReport {
    /// Number of frequencies.
    pub count: usize,
    /// Number solved now, not known before.
    pub solved: usize,
    /// Largest error of an interpolated middle that was accepted \[dB\].
    pub largest_passed: f64,
    /// Largest error of a middle in intervals that were too short to halve \[dB\]; 0 if there is none.
    pub largest_unhalved: f64,
    /// Smallest reciprocal condition number of those solved now.
    pub reciprocal_condition: f64,
    /// Sums over those solved now: assembly work, operations and seconds; unknowns and points are the largest.
    pub solve: SolveReport,
}

/// Callbacks of a set-up.
pub(crate) struct FrequencyWatch<'a> {
    /// Asked for stored transfers at some frequencies, for instance of a set-up that was stopped; those of the same
    /// receivers and grid are not solved again.
    pub known: &'a mut dyn FnMut(&[f64]) -> Vec<FrequencyTransfers>,
    /// Called with each frequency as it is finished, in any order; its error ends the work.
    pub sink: &'a mut dyn FnMut(&FrequencyTransfers) -> Result<(), RadiationError>,
    /// Called after each frequency.
    pub progress: &'a mut dyn FnMut(FrequencyProgress),
    /// Asked before each element and each factorisation; true stops the work.
    pub interrupted: &'a (dyn Fn() -> bool + Sync),
}

#[derive(Clone, Debug, Default)]
pub(crate) struct TransferSet {
    /// By rising frequency.
    found: Vec<FrequencyTransfers>,
}

impl TransferSet {
    /// From finished frequencies in any order; of equal ones the first is used.
    pub(crate) fn new(mut found: Vec<FrequencyTransfers>) -> Self {
        found.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        found.dedup_by(|a, b| same(a.frequency, b.frequency));
        Self { found }
    }

    /// Transfers by rising frequency.
    pub(crate) fn frequencies(&self) -> &[FrequencyTransfers] {
        &self.found
    }

    pub(crate) fn into_frequencies(self) -> Vec<FrequencyTransfers> {
        self.found
    }

    /// Grid of G_N of a receiver at any frequency \[Hz\] within the range; beyond its ends it is extrapolated from the
    /// nearest. `None` where nothing is known.
    pub(crate) fn at(&self, body: &RadiatingBody, receiver: usize, frequency: f64) -> Option<SurfaceTransfer> {
        let known: Vec<f64> = self.found.iter().map(|entry| entry.frequency).collect();
        let near = lagrange::cubic_neighbours(&known, frequency);
        let first = self.found.get(near.start)?;
        let nearest = first.transfers.get(receiver)?;
        let wavenumber = nearest.wavenumber * (frequency / first.frequency);
        let mut sums = vec![Complex64::ZERO; nearest.values.len()];
        let weights = lagrange::weights(&known[near.clone()], frequency);
        for (entry, weight) in self.found[near].iter().zip(weights) {
            let known = &entry.transfers[receiver];
            let turn = (known.wavenumber - wavenumber) * contact_distance(body, known.receiver);
            let factor = Complex64::from_polar(weight, turn);
            for (sum, value) in sums.iter_mut().zip(&known.values) {
                *sum += double(*value) * factor;
            }
        }
        let values = sums.into_iter().map(single).collect();
        Some(SurfaceTransfer { wavenumber, values, ..*nearest })
    }
}

/// True if equal up to rounding.
fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

/// Transfers of a range, with at most `threads` frequencies at a time.
///
/// # Errors
/// As [`TransferProblem::solve`] and [`FrequencyRange::check`]; [`RadiationError::Interrupted`]; the sink's. More
/// memory than the limit for the highest frequency is refused before anything is solved.
pub(crate) fn transfers(
    problem: &TransferProblem<'_>,
    range: &FrequencyRange,
    threads: usize,
    watch: &mut FrequencyWatch<'_>,
) -> Result<(TransferSet, FrequencyReport), RadiationError> {
    range.check()?;
    problem.check()?;
    let highest = range.wavenumber(range.highest);
    let cost = RadiationCost::expected(problem.body, highest, highest, &problem.resolution, problem.blocks)?;
    cost.check(problem.memory_limit)?;
    // 1. As many frequencies at once as fit into memory: the highest one is the largest.
    let at_once = (problem.memory_limit / cost.bytes.max(1)).max(1) as usize;
    let mut search = Search {
        problem,
        range,
        at_once: at_once.min(threads.max(1)),
        report: FrequencyReport { reciprocal_condition: f64::INFINITY, ..FrequencyReport::default() },
        round: 0,
        finished: 0,
    };
    // 2. The first round, and then the middles of all open intervals.
    let mut wanted = range.first();
    let mut open: Vec<[f64; 2]> = wanted.windows(2).map(|ends| [ends[0], ends[1]]).collect();
    let mut set = TransferSet::new(search.solve(&wanted, watch)?);
    while !open.is_empty() {
        search.round += 1;
        wanted = open.iter().map(|[low, high]| 0.5 * (low + high)).collect();
        let found = search.solve(&wanted, watch)?;
        let mut next = Vec::new();
        for ([low, high], middle) in open.iter().zip(&found) {
            let error = error(problem.body, &set, middle);
            if error <= range.tolerance {
                search.report.largest_passed = search.report.largest_passed.max(error);
            } else if 0.5 * (high - low) < 2.0 * range.finest {
                search.report.largest_unhalved = search.report.largest_unhalved.max(error);
            } else {
                next.extend([[*low, middle.frequency], [middle.frequency, *high]]);
            }
        }
        let mut all = set.found;
        all.extend(found);
        set = TransferSet::new(all);
        open = next;
    }
    search.report.count = set.found.len();
    Ok((set, search.report))
}

/// Error of the interpolation at a computed frequency \[dB\]: 20 log10(1 + relative error), of the worst receiver.
fn error(body: &RadiatingBody, set: &TransferSet, middle: &FrequencyTransfers) -> f64 {
    let one = |(receiver, exact): (usize, &SurfaceTransfer)| {
        let guess = set.at(body, receiver, middle.frequency)?;
        let pairs = guess.values.iter().zip(&exact.values);
        let difference: f64 = pairs.map(|(guess, exact)| double(guess - exact).norm_sqr()).sum();
        let size: f64 = exact.values.iter().map(|exact| double(*exact).norm_sqr()).sum();
        Some(20.0 * (1.0 + (difference / size).sqrt()).log10())
    };
    let of = |receiver: usize| one((receiver, &middle.transfers[receiver])).unwrap_or(f64::INFINITY);
    in_parallel::made(middle.transfers.len(), of).into_iter().fold(0.0, f64::max)
}

struct Search<'a> {
    problem: &'a TransferProblem<'a>,
    range: &'a FrequencyRange,
    at_once: usize,
    report: FrequencyReport,
    round: usize,
    finished: usize,
}

impl Search<'_> {
    /// Transfers at all wanted frequencies, in their order: stored ones read, the others solved for.
    fn solve(
        &mut self,
        wanted: &[f64],
        watch: &mut FrequencyWatch<'_>,
    ) -> Result<Vec<FrequencyTransfers>, RadiationError> {
        // 1. What is stored.
        let mut known = (watch.known)(wanted);
        let mut found: Vec<_> = wanted.iter().map(|&frequency| self.lookup(&mut known, frequency)).collect();
        drop(known);
        self.finished += found.iter().flatten().count();
        let mut missing: Vec<usize> = (0..wanted.len()).filter(|&index| found[index].is_none()).collect();
        missing.sort_by(|&a, &b| wanted[b].total_cmp(&wanted[a]));
        // 2. The rest on threads, each taking the next frequency, the highest first.
        let mut reports = vec![SolveReport::default(); wanted.len()];
        let (problem, range, interrupted) = (self.problem, self.range, watch.interrupted);
        let mut open = missing.len();
        (watch.progress)(FrequencyProgress { finished: self.finished, open, round: self.round });
        let next = AtomicUsize::new(0);
        let (give, take) = mpsc::channel();
        std::thread::scope(|scope| {
            for _ in 0..self.at_once.min(open) {
                let (give, next, missing) = (give.clone(), &next, &missing);
                scope.spawn(move || {
                    while let Some(&index) = missing.get(next.fetch_add(1, Ordering::Relaxed)) {
                        let solved = problem.solve_unless(range.wavenumber(wanted[index]), interrupted);
                        // The receiver is gone once something has failed.
                        if give.send((index, solved)).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(give);
            for (index, solved) in take {
                let (transfers, report) = solved?;
                let entry = FrequencyTransfers { frequency: wanted[index], transfers };
                (watch.sink)(&entry)?;
                (reports[index], found[index]) = (report, Some(entry));
                self.finished += 1;
                open -= 1;
                (watch.progress)(FrequencyProgress { finished: self.finished, open, round: self.round });
            }
            Ok(())
        })?;
        // 3. Reports are summed in the order of frequency, whichever was finished first.
        missing.sort_unstable();
        missing.iter().for_each(|&index| self.add(&reports[index]));
        Ok(found.into_iter().flatten().collect())
    }

    /// Takes a frequency known before, if it is of the same receivers and grid.
    fn lookup(&self, known: &mut Vec<FrequencyTransfers>, frequency: f64) -> Option<FrequencyTransfers> {
        let problem = self.problem;
        let (sides, values) = (problem.sides(), problem.values());
        let fits = |transfer: &SurfaceTransfer, receiver: &Vector| {
            transfer.grid == problem.grid
                && (transfer.sides, transfer.values.len()) == (sides, values)
                && distance(transfer.receiver, *receiver) <= 0.0
        };
        let index = known.iter().position(|entry| {
            same(entry.frequency, frequency)
                && entry.transfers.len() == problem.receivers.len()
                && entry.transfers.iter().zip(problem.receivers).all(|(transfer, receiver)| fits(transfer, receiver))
        })?;
        Some(FrequencyTransfers { frequency, ..known.swap_remove(index) })
    }

    fn add(&mut self, report: &SolveReport) {
        let sum = &mut self.report.solve;
        sum.unknowns = sum.unknowns.max(report.unknowns);
        sum.interior_points = sum.interior_points.max(report.interior_points);
        sum.work.add(&report.work);
        sum.factor_operations += report.factor_operations;
        sum.assembly_seconds += report.assembly_seconds;
        sum.factor_seconds += report.factor_seconds;
        self.report.reciprocal_condition = self.report.reciprocal_condition.min(report.reciprocal_condition);
        sum.reciprocal_condition = self.report.reciprocal_condition;
        self.report.solved += 1;
    }
}
