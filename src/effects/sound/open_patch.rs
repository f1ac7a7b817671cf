//! Air under the patch: the field in grooves that run round the tyre, in place of the zeros of G.

use num_complex::Complex64;

use super::planned::Sound;
use crate::numeric::{in_parallel, lagrange, single};
use crate::plan::Plan;
use crate::radiation::gap::GapAir;
use crate::radiation::gap::patch::{Channel, PatchSheet};
use crate::radiation::gap::resonance::Resonance;
use crate::radiation::transfer::contact_distance;
use crate::radiation::{Body, FrequencyTransfers, RadiationError, TransferSet};
use crate::response::pressure::UnderPatch;
use crate::results::table::{csv, optional, row};
use crate::sound::Air;

/// File of the grooves' fields and resonances.
pub(super) const GAP_FILE: &str = "gap.csv";
/// Largest height of the gap at the sheet's ends, in wavelengths of the highest frequency.
const HIGHEST: f64 = 1.0 / 6.0;
/// Least distance between frequencies \[Hz\].
const FINEST: f64 = 6.0;

/// Grooves through the patch of a body.
pub(super) struct OpenPatch<'a> {
    body: &'a Body,
    sheet: PatchSheet,
    channels: &'a [Channel],
    air: GapAir,
    /// Largest error of the interpolation between frequencies \[dB\].
    tolerance: f64,
}

/// Fields in the grooves of a run.
#[derive(Clone, Debug)]
pub(crate) struct GrooveFields {
    /// By groove; none where the response has no peak.
    resonances: Vec<Option<Resonance>>,
    frequencies: Vec<f64>,
    /// |G| amid the groove by point, frequency and groove \[1/m\].
    amid: Vec<Vec<Vec<f64>>>,
}

/// Work and memory of an open patch, before it is solved.
pub(super) struct OpenAmounts {
    /// Complex multiply-adds.
    pub(super) multiply_adds: f64,
    /// Bytes that stay.
    pub(super) bytes: f64,
}

impl OpenAmounts {
    /// Forecasts an open patch of a length \[m\]; `None` of a sealed one, or for a body or air that the run will refuse.
    pub(super) fn of(plan: &Plan, sound: &Sound, at_rest: f64) -> Option<Self> {
        if sound.channels.is_empty() {
            return None;
        }
        let body = plan.radiating_body(&sound.radiation, at_rest).ok()?;
        let air = Air::at(sound.radiation.temperature)?;
        let OpenPatch { sheet, .. } = OpenPatch::of(sound, &body, &air)?;
        let (points, intervals) = (sound.points() as f64, 2 * (sound.range(&air).first().len() - 1));
        // Of the frequencies of boundary elements, and as many middles as are tried, or found wanting.
        let [known, tried] = [FOUND_WANTING * intervals as f64, (2.0 + FOUND_WANTING) * intervals as f64];
        let solved = tried * sheet.sheet.multiply_adds(1) + known * sheet.sheet.multiply_adds(sound.points());
        let values = (2 * sheet.cells * sheet.sheet.cells()[1] + Sound::GRID.around * Sound::GRID.across) as f64;
        let factors = (rayon::current_num_threads() * sheet.sheet.bytes()) as f64;
        Some(Self { multiply_adds: solved, bytes: 8.0 * points * known * values + factors })
    }
}

/// Frequencies over those of boundary elements: where grooves resonate some more are taken.
const FOUND_WANTING: f64 = 1.3;

/// Transfers with frequencies that the grooves ask for, the field by point, and its figures.
pub(super) struct Opened {
    pub(super) set: TransferSet,
    pub(super) under: Vec<UnderPatch>,
    pub(super) fields: GrooveFields,
}

impl<'a> OpenPatch<'a> {
    /// Makes the patch of a body; `None` where it is sealed.
    pub(super) fn of(sound: &'a Sound, body: &'a Body, air: &Air) -> Option<Self> {
        if sound.channels.is_empty() {
            return None;
        }
        let sheet = PatchSheet::new(body, Sound::GRID, &sound.channels)?;
        let tolerance = sound.radiation.frequency_tolerance;
        Some(Self { body, sheet, channels: &sound.channels, air: air.in_gap(), tolerance })
    }

    /// Returns the highest frequency up to which the gap is thin where the sheet ends \[Hz\].
    pub(super) fn highest(&self) -> f64 {
        HIGHEST * self.air.sound_speed / self.sheet.height_at_ends()
    }

    /// Computes the responses amid all grooves to a field that is the same before and behind the tyre.
    fn responses(&self, frequency: f64) -> Result<Vec<Complex64>, RadiationError> {
        let factored = self.sheet.factorise(&self.air, self.wavenumber(frequency))?;
        let field = factored.between_equal_ends();
        Ok(self.channels.iter().map(|channel| self.sheet.amid(&field, channel.position)).collect())
    }

    fn wavenumber(&self, frequency: f64) -> f64 {
        std::f64::consts::TAU * frequency / self.air.sound_speed
    }

    /// Finds the responses at known frequencies, and at as many between them as keep the tolerance.
    fn frequencies(&self, known: &[f64]) -> Result<Vec<(f64, Vec<Complex64>)>, RadiationError> {
        let solve = |wanted: &[f64]| -> Result<Vec<(f64, Vec<Complex64>)>, RadiationError> {
            let found = in_parallel::map(wanted, |&frequency| Ok((frequency, self.responses(frequency)?)));
            found.into_iter().collect()
        };
        let mut found = solve(known)?;
        let mut open: Vec<[f64; 2]> = known.windows(2).map(|ends| [ends[0], ends[1]]).collect();
        while !open.is_empty() {
            let wanted: Vec<f64> = open.iter().map(|[low, high]| 0.5 * (low + high)).collect();
            let middles = solve(&wanted)?;
            let at: Vec<f64> = found.iter().map(|(frequency, _)| *frequency).collect();
            let is_off = |(frequency, exact): &(f64, Vec<Complex64>)| {
                let near = lagrange::cubic_neighbours(&at, *frequency);
                let weights: Vec<f64> = lagrange::weights(&at[near.clone()], *frequency).collect();
                let one = |(groove, exact): (usize, &Complex64)| {
                    let known = found[near.clone()].iter().zip(&weights);
                    let guess: Complex64 = known.map(|((_, values), weight)| values[groove] * weight).sum();
                    20.0 * (1.0 + (guess - exact).norm() / exact.norm()).log10()
                };
                exact.iter().enumerate().map(one).fold(0.0, f64::max) > self.tolerance
            };
            let mut next = Vec::new();
            let mut more = Vec::new();
            for ([low, high], middle) in open.iter().zip(middles) {
                if is_off(&middle) {
                    if high - low >= 4.0 * FINEST {
                        next.extend([[*low, middle.0], [middle.0, *high]]);
                    }
                    more.push(middle);
                }
            }
            found.extend(more);
            found.sort_by(|one, other| one.0.total_cmp(&other.0));
            open = next;
        }
        Ok(found)
    }

    /// Solves for the field of all transfers of a set.
    ///
    /// # Errors
    /// [`RadiationError::Singular`].
    pub(super) fn open(&self, set: TransferSet) -> Result<Opened, RadiationError> {
        let known: Vec<f64> = set.frequencies().iter().map(|found| found.frequency).collect();
        let points = set.frequencies().first().map_or(0, |found| found.transfers.len());
        let responses = self.frequencies(&known)?;
        let missing: Vec<f64> =
            responses.iter().map(|(frequency, _)| *frequency).filter(|frequency| !known.contains(frequency)).collect();
        let between = in_parallel::map(&missing, |&frequency| FrequencyTransfers {
            frequency,
            transfers: (0..points).filter_map(|point| set.at(self.body, point, frequency)).collect(),
        });
        let mut all = set.into_frequencies();
        all.extend(between);
        let set = TransferSet::new(all);
        let fields = in_parallel::map(set.frequencies(), |found| self.field(found));
        let fields: Vec<Vec<Vec<Complex64>>> = fields.into_iter().collect::<Result<_, _>>()?;
        let mut under: Vec<UnderPatch> = (0..points)
            .map(|_| UnderPatch { cells: self.sheet.cells, ends: self.sheet.sheet.y.clone(), values: Vec::new() })
            .collect();
        let mut amid = vec![Vec::new(); points];
        for (found, fields) in set.frequencies().iter().zip(fields) {
            for (point, (field, transfer)) in fields.into_iter().zip(&found.transfers).enumerate() {
                let one = |channel: &Channel| self.sheet.amid(&field, channel.position).norm();
                amid[point].push(self.channels.iter().map(one).collect());
                let late = transfer.wavenumber * contact_distance(self.body, transfer.receiver);
                let turn = Complex64::from_polar(1.0, late);
                let values = self.sheet.on_grid(&field).into_iter().map(|value| single(turn * value));
                under[point].values.push(values.collect());
            }
        }
        let of = |groove: usize| {
            let response: Vec<(f64, f64)> = responses.iter().map(|(f, values)| (*f, values[groove].norm())).collect();
            Resonance::of(&response)
        };
        let resonances = (0..self.channels.len()).map(of).collect();
        let frequencies = set.frequencies().iter().map(|found| found.frequency).collect();
        Ok(Opened { set, under, fields: GrooveFields { resonances, frequencies, amid } })
    }

    /// Solves for the field of the transfers at a frequency, by point, on the sheet's cells.
    fn field(&self, found: &FrequencyTransfers) -> Result<Vec<Vec<Complex64>>, RadiationError> {
        let factored = self.sheet.factorise(&self.air, self.wavenumber(found.frequency))?;
        Ok(factored.solve(&found.transfers))
    }
}

impl GrooveFields {
    /// Lists grooves that resonate within a part of a frequency \[Hz\] that something passes at.
    pub(super) fn near(&self, passing: f64) -> Vec<String> {
        let one = |(groove, found): (usize, &Option<Resonance>)| {
            let Resonance { frequency, .. } = (*found)?;
            let is_near = (passing / frequency - 1.0).abs() <= NEAR;
            is_near.then(|| {
                format!("pitches pass at {passing:.0} Hz, and tread_pattern.grooves[{groove}] resonates at {frequency:.0} Hz")
            })
        };
        self.resonances.iter().enumerate().filter_map(one).collect()
    }

    /// Returns the table of the grooves: resonances, and |G| amid them by receiver, at its first point.
    pub(super) fn to_csv(&self, sound: &Sound) -> String {
        let mut rows = Vec::new();
        for (groove, (channel, found)) in sound.channels.iter().zip(&self.resonances).enumerate() {
            let resonance = optional(found.map(|found| found.frequency));
            let quality = optional(found.map(|found| found.quality));
            for heard in &sound.heard {
                for (frequency, amid) in self.frequencies.iter().zip(&self.amid[heard.points.start]) {
                    let Channel { position, width, depth } = channel;
                    let level = amid[groove];
                    rows.push(row([
                        &groove,
                        position,
                        width,
                        depth,
                        &resonance,
                        &quality,
                        &heard.name,
                        frequency,
                        &level,
                    ]));
                }
            }
        }
        let header = [
            "groove",
            "position_m",
            "width_m",
            "depth_m",
            "resonance_hz",
            "quality",
            "receiver",
            "frequency_hz",
            "green_1_per_m",
        ];
        csv(header, rows)
    }
}

/// Part of a groove's resonance within which what passes excites it.
const NEAR: f64 = 0.1;
