//! Air under the patch: the field in circumferential grooves, in place of the zeros of G.

use std::cmp::Ordering;

use super::path::TransferPath;
use super::surface::{SurfaceGreen, UnderPatch};
use crate::contact::cells::gaps::GapMap;
use crate::numeric::{double, in_parallel, lagrange, single};
use crate::radiation::gap::GapAir;
use crate::radiation::gap::patch::{GapChannel, PatchSheet, RoughGap};
use crate::radiation::gap::resonance::Resonance;
use crate::radiation::transfer::contact_distance;
use crate::radiation::{FrequencyTransfers, RadiatingBody, RadiationError, SurfaceTransfer, TransferSet};
use num_complex::{Complex32, Complex64};

/// Largest height of the gap at the sheet's ends, in wavelengths of the highest frequency.
const HIGHEST: f64 = 1.0 / 6.0;
/// Smallest interval between frequencies \[Hz\].
const FINEST: f64 = 6.0;
/// Band in which grooves' resonances are searched before a run \[Hz\], and the number of frequencies solved at first.
const LOOKED_AT: [f64; 2] = [500.0, 2500.0];
const FIRST_LOOK: usize = 9;
/// Number of frequencies over that of the boundary elements: where grooves resonate more are needed.
const FOUND_WANTING: f64 = 1.3;
/// Number of times that the peak of the fitted parabola is solved for.
const REFINED: usize = 3;

pub(crate) struct OpenPatch<'a> {
    body: &'a RadiatingBody,
    /// The sheet over grooves alone, or one for each place at which voids are known.
    sheets: Vec<PatchSheet>,
    /// True if voids of the road are open, too.
    has_voids: bool,
    channels: &'a [GapChannel],
    air: GapAir,
    /// Largest error of the interpolation between frequencies \[dB\].
    tolerance: f64,
}

/// Field at a frequency.
struct Solved {
    /// Frequency \[Hz\].
    frequency: f64,
    /// By place, response in the middle of each groove, and, with voids, the mean over the patch.
    responses: Vec<Vec<Complex64>>,
    /// By place and point.
    fields: Vec<Vec<ReceiverField>>,
    /// By groove, G of the point in its middle on the grid's cells \[1/m\]; empty where no field is computed.
    of_middles: Vec<Vec<Complex32>>,
}

/// Field of a receiver's point.
struct ReceiverField {
    /// |G| in the middle of each groove \[1/m\].
    middle: Vec<f64>,
    /// Root mean square of G over the patch \[1/m\].
    mean: f64,
    /// G exp(i k r0) on the grid's cells \[1/m\].
    values: Vec<Complex32>,
}

/// Fields in the grooves of a run.
#[derive(Clone, Debug)]
pub(crate) struct GrooveFields {
    /// By groove; `None` where the response has no peak.
    pub resonances: Vec<Option<Resonance>>,
    pub frequencies: Vec<f64>,
    /// |G| in the middle of a groove by point, frequency and groove \[1/m\].
    pub middle: Vec<Vec<Vec<f64>>>,
    /// |G| at the first point, at the frequency at which it is largest in a groove; `None` without a point.
    pub loudest: Option<UnderPatchLevels>,
    /// Root mean square of G over the patch by point, frequency and place \[1/m\]; empty for grooves alone.
    pub of_places: Vec<Vec<Vec<f64>>>,
}

/// Field under the patch at a frequency.
#[derive(Clone, Debug)]
pub(crate) struct UnderPatchLevels {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// |G| cell by cell along, and in each strip by strip across \[1/m\].
    pub green: Vec<f64>,
    /// Ends of the strips across \[m\].
    pub ends: Vec<f64>,
}

impl<'a> OpenPatch<'a> {
    /// Expected work of the fields, in complex multiply-adds, and the memory that stays in use during the run
    /// \[bytes\].
    pub(crate) fn expected(&self, path: &TransferPath) -> [f64; 2] {
        let Some(PatchSheet { sheet, cells, .. }) = self.sheets.first() else { return [0.0; 2] };
        let intervals = 2 * (path.range().first().len() - 1);
        let known = FOUND_WANTING * intervals as f64;
        // The middle of each interval is tried, too.
        let one = sheet.multiply_adds(1) + sheet.multiply_adds(path.points() + 1);
        let on_grid = TransferPath::GRID.around * TransferPath::GRID.across;
        let values = (2 * cells * sheet.cells()[1] + on_grid) as f64;
        let factors = (rayon::current_num_threads() * sheet.bytes()) as f64;
        [known * path.places as f64 * one, 8.0 * path.streamed() as f64 * known * values + factors]
    }

    /// Patch of a body, with the gaps at places of the run where these are open; `None` where it is sealed.
    pub(crate) fn of(path: &'a TransferPath, body: &'a RadiatingBody, gaps: &[GapMap]) -> Option<Self> {
        if path.channels.is_empty() && path.places == 1 {
            return None;
        }
        let at_place = |gap: &GapMap| {
            let (ends, height): (Vec<f64>, _) = (gap.ends().collect(), |x: f64, y: f64| gap.height(x, y));
            PatchSheet::new(body, TransferPath::GRID, &path.channels, Some(&RoughGap { ends: &ends, height: &height }))
        };
        let sheets: Option<Vec<PatchSheet>> = match gaps {
            [] => PatchSheet::new(body, TransferPath::GRID, &path.channels, None).map(|sheet| vec![sheet]),
            gaps => gaps.iter().map(at_place).collect(),
        };
        let (channels, tolerance) = (path.channels.as_slice(), path.radiation.frequency_tolerance);
        Some(Self { body, sheets: sheets?, has_voids: !gaps.is_empty(), channels, air: path.air.in_gap(), tolerance })
    }

    /// Highest frequency at which the gap is thin where the sheet ends \[Hz\].
    pub(crate) fn highest(&self) -> f64 {
        let heights = self.sheets.iter().map(PatchSheet::height_at_ends);
        HIGHEST * self.air.sound_speed / heights.fold(0.0, f64::max)
    }

    /// Solves at a frequency for the responses in all grooves to fields that are equal before and behind the tyre, and
    /// for the fields of transfers.
    fn solve(&self, frequency: f64, transfers: &[SurfaceTransfer]) -> Result<Solved, RadiationError> {
        let (mut responses, mut fields, mut of_middles) = (Vec::new(), Vec::new(), Vec::new());
        for sheet in &self.sheets {
            let factored = sheet.factorise(&self.air, self.wavenumber(frequency))?;
            let middle = |field: &[Complex64]| -> Vec<Complex64> {
                self.channels.iter().map(|channel| sheet.in_middle(field, channel.position)).collect()
            };
            let driven = factored.between_equal_ends();
            let mut response = middle(&driven);
            if self.has_voids {
                let [sum, area] = sheet
                    .within(&driven)
                    .fold([Complex64::ZERO; 2], |[sum, all], (value, area)| [sum + value * area, all + area]);
                response.push(sum / area);
            }
            responses.push(response);
            let solved = factored.solve(transfers);
            let of_point = |(field, transfer): (&Vec<Complex64>, &SurfaceTransfer)| {
                let late = transfer.wavenumber * contact_distance(self.body, transfer.receiver);
                let turn = Complex64::from_polar(1.0, late);
                let squares = sheet.within(field).map(|(value, area)| [value.norm_sqr() * area, area]);
                let [square, area] = squares.fold([0.0; 2], |[sum, all], [square, area]| [sum + square, all + area]);
                ReceiverField {
                    middle: middle(field).into_iter().map(|value| value.norm()).collect(),
                    mean: (square / area).sqrt(),
                    values: sheet.on_grid(field).into_iter().map(|value| single(turn * value)).collect(),
                }
            };
            fields.push(solved.iter().zip(transfers).map(of_point).collect());
            // Pressures in the middle of grooves are computed at the first place.
            if of_middles.is_empty() && !transfers.is_empty() {
                let of_groove = |channel: &GapChannel| {
                    sheet.on_grid(&factored.sourced_in_middle(channel.position)).into_iter().map(single).collect()
                };
                of_middles = self.channels.iter().map(of_groove).collect();
            }
        }
        Ok(Solved { frequency, responses, fields, of_middles })
    }

    fn wavenumber(&self, frequency: f64) -> f64 {
        std::f64::consts::TAU * frequency / self.air.sound_speed
    }

    /// True if a cubic through responses at other frequencies misses a response by more than the tolerance.
    fn is_missed(&self, known: &[Solved], exact: &Solved) -> bool {
        let at: Vec<f64> = known.iter().map(|solved| solved.frequency).collect();
        let near = lagrange::cubic_neighbours(&at, exact.frequency);
        let weights: Vec<f64> = lagrange::weights(&at[near.clone()], exact.frequency).collect();
        let one = |place: usize, groove: usize| {
            let exact = exact.responses[place][groove];
            let pairs = known[near.clone()].iter().zip(&weights);
            let guess: Complex64 = pairs.map(|(known, weight)| known.responses[place][groove] * weight).sum();
            20.0 * (1.0 + (guess - exact).norm() / exact.norm().max(f64::MIN_POSITIVE)).log10()
        };
        let places = exact.responses.iter().enumerate();
        let all = places.flat_map(|(place, grooves)| (0..grooves.len()).map(move |groove| (place, groove)));
        all.map(|(place, groove)| one(place, groove)).fold(0.0, f64::max) > self.tolerance
    }

    /// Solves for the field of all transfers of a set, at its frequencies and at further ones between them, until
    /// cubics meet the grooves' responses: G by streamed point, and the fields' figures.
    ///
    /// # Errors
    /// [`RadiationError::Singular`].
    pub(super) fn open(&self, set: TransferSet) -> Result<(Vec<SurfaceGreen>, GrooveFields), RadiationError> {
        let points = set.frequencies().first().map_or(0, |found| found.transfers.len());
        // 1. Fields at the frequencies of the set.
        let at_known = in_parallel::map(set.frequencies(), |found| self.solve(found.frequency, &found.transfers));
        let mut known: Vec<Solved> = at_known.into_iter().collect::<Result<_, _>>()?;
        // 2. Halve intervals until cubics meet the middles' responses.
        let mut open: Vec<[f64; 2]> = known.windows(2).map(|ends| [ends[0].frequency, ends[1].frequency]).collect();
        let mut added = Vec::new();
        while !open.is_empty() {
            // Right sides of many points take longer than factors: only missed frequencies are solved for them, below.
            let middles = in_parallel::map(&open, |[low, high]| self.solve(0.5 * (low + high), &[]));
            let middles: Vec<Solved> = middles.into_iter().collect::<Result<_, _>>()?;
            let missed: Vec<bool> = middles.iter().map(|middle| self.is_missed(&known, middle)).collect();
            let mut next = Vec::new();
            for (([low, high], middle), _) in open.iter().zip(middles).zip(missed).filter(|(_, missed)| *missed) {
                if high - low >= 4.0 * FINEST {
                    next.extend([[*low, middle.frequency], [middle.frequency, *high]]);
                }
                added.push(middle.frequency);
                known.push(middle);
            }
            known.sort_by(|one, other| one.frequency.total_cmp(&other.frequency));
            open = next;
        }
        // 3. Fields at the frequencies added, of interpolated transfers.
        let between = in_parallel::map(&added, |&frequency| {
            let transfers: Vec<SurfaceTransfer> =
                (0..points).filter_map(|point| set.at(self.body, point, frequency)).collect();
            Ok((self.solve(frequency, &transfers)?, FrequencyTransfers { frequency, transfers }))
        });
        let between: Vec<(Solved, FrequencyTransfers)> = between.into_iter().collect::<Result<_, _>>()?;
        let (solved, more): (Vec<Solved>, Vec<FrequencyTransfers>) = between.into_iter().unzip();
        let mut all = set.into_frequencies();
        all.extend(more);
        // Replaces those between, which have no fields.
        known.retain(|known| !added.contains(&known.frequency));
        known.extend(solved);
        known.sort_by(|one, other| one.frequency.total_cmp(&other.frequency));
        Ok(self.opened(TransferSet::new(all), known, points))
    }

    /// Resonances of grooves in the range that is searched before a run, found with few solutions.
    ///
    /// # Errors
    /// [`RadiationError::Singular`].
    pub(crate) fn resonances(&self) -> Result<Vec<Option<Resonance>>, RadiationError> {
        let [low, high] = [LOOKED_AT[0], LOOKED_AT[1].min(self.highest())];
        let part = |step: usize| step as f64 / (FIRST_LOOK - 1) as f64;
        let mut wanted: Vec<f64> = (0..FIRST_LOOK).map(|step| low * (high / low).powf(part(step))).collect();
        let mut known: Vec<Solved> = Vec::new();
        for _ in 0..=REFINED {
            let solved = in_parallel::map(&wanted, |&frequency| self.solve(frequency, &[]));
            known.extend(solved.into_iter().collect::<Result<Vec<_>, _>>()?);
            known.sort_by(|one, other| one.frequency.total_cmp(&other.frequency));
            let is_new = |frequency: &f64| known.iter().all(|known| (known.frequency - frequency).abs() > 0.5 * FINEST);
            wanted = self.found(&known).into_iter().flatten().map(|found| found.frequency).filter(is_new).collect();
            wanted.sort_by(f64::total_cmp);
            wanted.dedup_by(|next, one| *next - *one < FINEST);
        }
        Ok(self.found(&known))
    }

    /// Resonances of the responses at rising frequencies, groove by groove.
    fn found(&self, known: &[Solved]) -> Vec<Option<Resonance>> {
        let of = |groove: usize| {
            let response: Vec<(f64, f64)> = known
                .iter()
                .map(|solved| (solved.frequency, root_mean(&solved.responses, |of| of[groove].norm())))
                .collect();
            Resonance::of(&response)
        };
        (0..self.channels.len()).map(of).collect()
    }

    /// Sorts the fields by points.
    fn opened(&self, set: TransferSet, known: Vec<Solved>, points: usize) -> (Vec<SurfaceGreen>, GrooveFields) {
        let resonances = self.found(&known);
        let frequencies = known.iter().map(|solved| solved.frequency).collect();
        let (ends, cells) = self.sheets.first().map_or((&[][..], 0), |sheet| (&sheet.sheet.y, sheet.cells));
        let sealed = || UnderPatch { cells, ends: ends.to_vec(), values: Vec::new() };
        let at_place = |_: &PatchSheet| (0..points).map(|_| sealed()).collect();
        let mut under: Vec<Vec<UnderPatch>> = self.sheets.iter().map(at_place).collect();
        let mut of_middles: Vec<UnderPatch> = self.channels.iter().map(|_| sealed()).collect();
        let loudest = {
            let first = |solved: &Solved| -> Option<f64> {
                let ReceiverField { middle, mean, .. } = solved.fields.first()?.first()?;
                Some(middle.iter().copied().reduce(f64::max).unwrap_or(*mean))
            };
            let of = known.iter().max_by(|one, other| first(one).partial_cmp(&first(other)).unwrap_or(Ordering::Equal));
            of.and_then(|solved| Some((solved.frequency, solved.fields.first()?.first()?))).map(|(frequency, field)| {
                let green = field.values.iter().map(|value| double(*value).norm()).collect();
                UnderPatchLevels { frequency, green, ends: ends.to_vec() }
            })
        };
        let [mut middle, mut of_places] =
            [vec![Vec::new(); points], vec![Vec::new(); if self.has_voids { points } else { 0 }]];
        for solved in known {
            of_middles.iter_mut().zip(solved.of_middles).for_each(|(under, values)| under.values.push(values));
            for (point, middle) in middle.iter_mut().enumerate() {
                let groove = |groove: usize| root_mean(&solved.fields, |points| points[point].middle[groove]);
                middle.push((0..self.channels.len()).map(groove).collect());
            }
            for (point, means) in of_places.iter_mut().enumerate() {
                means.push(solved.fields.iter().map(|points| points[point].mean).collect());
            }
            for (under, fields) in under.iter_mut().zip(solved.fields) {
                under.iter_mut().zip(fields).for_each(|(under, field)| under.values.push(field.values));
            }
        }
        // G by point: the first place, points in grooves, then the other places.
        let mut greens = SurfaceGreen::of_set(self.body, set);
        let mut under = under.into_iter();
        let first = under.next().unwrap_or_default();
        let sealed = if under.len() > 0 { greens.clone() } else { Vec::new() };
        // The pressures in grooves leave out sources beyond the sheet.
        let without_sources = greens.first().filter(|_| !of_middles.is_empty()).map(|first| {
            let values = first.values.iter().map(|values| vec![Complex32::ZERO; values.len()]).collect();
            SurfaceGreen { values, ..first.clone() }
        });
        greens.iter_mut().zip(first).for_each(|(green, under)| green.under_patch = Some(under));
        let of = |under| without_sources.clone().map(|green| SurfaceGreen { under_patch: Some(under), ..green });
        greens.extend(of_middles.into_iter().filter_map(of));
        // Then those of the other places, point by point.
        for under in under {
            let pairs = sealed.iter().cloned().zip(under);
            greens.extend(pairs.map(|(green, under)| SurfaceGreen { under_patch: Some(under), ..green }));
        }
        (greens, GrooveFields { resonances, frequencies, middle, loudest, of_places })
    }
}

/// Root mean square over places.
pub(crate) fn root_mean<T>(places: &[T], of: impl Fn(&T) -> f64) -> f64 {
    let sum: f64 = places.iter().map(|place| of(place).powi(2)).sum();
    (sum / places.len() as f64).sqrt()
}

/// Lateral waves that resolve the steps of a field between grooves: twice the strip's width over that of the narrowest
/// rib or groove, or of a cell where voids are open on so many cells across.
pub(crate) fn waves_for(channels: &[GapChannel], contact_width: f64, voids: Option<usize>) -> usize {
    if let Some(cells) = voids {
        return 2 * cells;
    }
    let mut sides = vec![-0.5 * contact_width, 0.5 * contact_width];
    sides.extend(
        channels.iter().flat_map(|GapChannel { position, width, .. }| [-0.5, 0.5].map(|half| position + half * width)),
    );
    sides.sort_by(f64::total_cmp);
    let widths = sides.windows(2).map(|ends| ends[1] - ends[0]).filter(|width| *width > 1e-9 * contact_width);
    (2.0 * contact_width / widths.fold(contact_width, f64::min) - 1e-9).ceil() as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radiation::Air;
    use crate::response::pressure::tests::layout;
    use crate::scene::{DEFAULT, Scene, TimeRule};

    #[test]
    fn frequencies_are_added_round_resonances_of_grooves() {
        let Scene { tyre, radiation, .. } = Scene::from_str(DEFAULT, "default").unwrap().scene;
        let shoulder = radiation.shoulder;
        let body = RadiatingBody::standing_tyre(tyre.radius(), tyre.width + 2.0 * shoulder, shoulder, 0.054).unwrap();
        let body = body.with_gap(radiation.acoustic_gap).unwrap();
        let path = TransferPath {
            radiation,
            air: Air::at(20.0).unwrap(),
            positions: vec![[0.0, 7.5, 1.2]],
            receivers: Vec::new(),
            layout: layout(TimeRule::Bdf2, 1),
            lateral: 1,
            has_tractions: false,
            bead: None,
            channels: vec![GapChannel { position: 0.0, width: 0.012, depth: 0.008 }],
            places: 1,
        };
        let open = OpenPatch::of(&path, &body, &[]).unwrap();
        assert!((3000.0..3700.0).contains(&open.highest()), "{}", open.highest());
        // A field of 1 everywhere, with the delay of the receiver.
        let (receiver, grid) = (path.positions[0], TransferPath::GRID);
        let late = contact_distance(&body, receiver);
        let at = |frequency: f64| {
            let wavenumber = open.wavenumber(frequency);
            let value = single(Complex64::from_polar(1.0, -wavenumber * late));
            let values = vec![value; grid.around * grid.across];
            let transfers = vec![SurfaceTransfer { receiver, wavenumber, grid, sides: 1, values }];
            FrequencyTransfers { frequency, transfers }
        };
        let known: Vec<f64> = (0..8).map(|step| 700.0 + 100.0 * f64::from(step)).collect();
        let set = TransferSet::new(known.iter().map(|&frequency| at(frequency)).collect());
        let (greens, fields) = open.open(set).unwrap();
        let frequencies = &fields.frequencies;
        assert!(frequencies.len() > known.len() && greens[0].frequencies == *frequencies);
        let resonance = fields.resonances[0].unwrap();
        assert!((1000.0..1200.0).contains(&resonance.frequency), "{resonance:?}");
        let under = greens[0].under_patch.as_ref().unwrap();
        let strips = under.ends.len() - 1;
        for frequency in [933.0, 1058.0, 1104.0, 1171.0, 1262.0] {
            let near = lagrange::cubic_neighbours(frequencies, frequency);
            let weights: Vec<f64> = lagrange::weights(&frequencies[near.clone()], frequency).collect();
            let exact = open.solve(frequency, &at(frequency).transfers).unwrap();
            let exact = &exact.fields[0][0].values;
            // In the middle of the patch, all across: 0 on ribs, and steps to the groove.
            let row = under.cells * strips..(under.cells + 1) * strips;
            let (mut off, mut size, mut ribs) = (0.0_f64, 0.0_f64, 0);
            for place in row {
                let known = under.values[near.clone()].iter().zip(&weights);
                let found: Complex64 = known.map(|(values, weight)| double(values[place]) * weight).sum();
                off = off.max((found - double(exact[place])).norm());
                size = size.max(double(exact[place]).norm());
                ribs += usize::from(exact[place] == Complex32::ZERO);
            }
            // The tolerance is 0.2 dB.
            assert!(off < 0.03 * size, "{frequency} Hz: {off} of {size}");
            assert!(ribs > strips / 2 && ribs < strips, "{ribs} of {strips}");
        }
        // Few frequencies before the run find the same.
        let clock = std::time::Instant::now();
        let early = open.resonances().unwrap()[0].unwrap();
        println!("{early:?} after {:?}, in the run {resonance:?}", clock.elapsed());
        assert!((early.frequency / resonance.frequency - 1.0).abs() < 0.01, "{early:?} {resonance:?}");
    }

    #[test]
    fn waves_across_follow_the_narrowest_rib_or_groove() {
        let channel = |position, width| GapChannel { position, width, depth: 0.008 };
        assert_eq!(waves_for(&[channel(0.0, 0.01)], 0.11, None), 22);
        // The rib beside it has 5 mm.
        assert_eq!(waves_for(&[channel(0.045, 0.01)], 0.11, None), 44);
        assert_eq!(waves_for(&[], 0.11, None), 2);
        assert_eq!(waves_for(&[channel(0.0, 0.01)], 0.11, Some(30)), 60);
    }
}
