//! From the forces' powers to velocities: spectra of both frames, maps, dissipated power.
//!
//! A wave of the non-rotating frame, exp(i (kx x + w t)), is a wave of the material one with w' = w - n Omega; its
//! velocity is that of the material, Y_n(w') = s H_n(s) times its force, in both frames. So every wave's power
//! |Y_n|^2 |F_n|^2 belongs to one bin of each frame, and both sums are the same: the mean of v^2 over the circumference
//! and over time. Only the mean pattern, which stands in the non-rotating frame, is there 0 Hz and no vibration, in the
//! material frame lines at the multiples of the rotation; it is listed by itself, and is a part of the material frame's
//! spectrum.
//!
//! Power: the forces put in sum_e F_e v_e = sum_n Re Y_n |F_n|^2 in the mean, all of which the tyre dissipates. Where
//! it turns Y_n and Y_-n differ (`both_ways`); gyroscopic forces do no work.
//!
//! With the forces of several stages |Y_n|^2 and Re Y_n are forms of all of them (`stage_transfer`); the rest
//! is the same. Of forces that are resolved across |v_n|^2 and the power are there already ([`super::heard`]).

use super::accumulator::PatchSpectra;
use super::both_ways::BothWays;
use super::layout::SegmentLayout;
use super::products;
use super::transfer::{Forms, TransferKind, Transfers, TyreResponse, VibrationField};
use crate::numeric::in_parallel;
use crate::response::PowerSpectrum;

/// Most rows of frequency that a map has.
const MOST_ROWS: usize = 1024;
/// Wavenumbers whose transfers are in memory at once.
const BLOCK: usize = 32;

/// Selection of spectra.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SpectraRequest<'a> {
    /// The fields.
    pub fields: &'a [VibrationField],
    /// Meaning of s.
    pub kind: TransferKind,
    /// True if maps are made.
    pub maps: bool,
}

/// Spectra of a field, means over the circumference; (m/s)^2, two-dimensional by frequency and wavenumber in the maps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FieldSpectra {
    /// The field.
    pub field: VibrationField,
    /// In the material frame, the mean pattern's lines included.
    pub material: PowerSpectrum,
    /// In the material frame without the mean pattern.
    pub material_varying: PowerSpectrum,
    /// In the non-rotating frame, at frequencies above 0: without the mean pattern.
    pub non_rotating: PowerSpectrum,
    /// Mean square velocity of the mean pattern \[m^2/s^2\].
    pub mean_pattern: f64,
    /// Maps of the material and of the non-rotating frame.
    pub maps: Option<[WavenumberMap; 2]>,
}

/// Power by frequency and wavenumber.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WavenumberMap {
    /// Wavenumbers -N/2..=N/2 of a row; n > 0 goes towards -x, against the rolling direction.
    pub wavenumbers: usize,
    /// Width of a row \[Hz\]; row i reaches from i to i + 1 of it.
    pub row_width: f64,
    /// Power spectral density \[m^2/s^2/Hz\], rows of frequency.
    pub density: Vec<f64>,
}

/// Dissipated power \[W\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Dissipation {
    /// Power of the mean pattern: the cost of rolling on a smooth road.
    pub mean_pattern: f64,
    /// Power of the vibration.
    pub vibration: f64,
}

impl Dissipation {
    /// Returns both together.
    pub(crate) fn total(&self) -> f64 {
        self.mean_pattern + self.vibration
    }
}

/// Returns the spectra of all fields, and the power that the forces' work dissipates; `None` where the response does
/// not have a field.
pub(crate) fn field_spectra(
    patch: &PatchSpectra,
    response: &TyreResponse<'_>,
    request: &SpectraRequest<'_>,
) -> Option<(Vec<FieldSpectra>, Dissipation)> {
    let layout = &patch.layout;
    let transfers = Transfers::new(layout, request.kind);
    let mut dissipation = Dissipation::default();
    let mut spectra = Vec::with_capacity(request.fields.len());
    for &field in request.fields {
        let mut sums = FieldSpectra::silent(layout, field, request.maps);
        for first in (0..=layout.elements / 2).step_by(BLOCK) {
            let block = first..(first + BLOCK).min(layout.elements / 2 + 1);
            let forms = in_parallel::made(block.len(), |index| transfers.forms(response, first + index, field));
            let forms: Vec<BothWays<Forms>> = forms.into_iter().collect::<Option<_>>()?;
            sums.add(patch, first, &forms, &mut dissipation);
        }
        sums.end_maps();
        spectra.push(sums);
    }
    Some((spectra, dissipation))
}

impl FieldSpectra {
    fn silent(layout: &SegmentLayout, field: VibrationField, maps: bool) -> Self {
        let silence = || spectrum(layout, vec![0.0; layout.bins()]);
        let map = || WavenumberMap {
            wavenumbers: layout.wavenumbers(),
            row_width: bins_of_row(layout) as f64 * layout.resolution(),
            density: vec![0.0; layout.bins().div_ceil(bins_of_row(layout)) * layout.wavenumbers()],
        };
        Self {
            field,
            material: silence(),
            material_varying: silence(),
            non_rotating: silence(),
            mean_pattern: 0.0,
            maps: maps.then(|| [map(), map()]),
        }
    }

    /// Adds the power of the wavenumbers +-n, n = first...
    fn add(&mut self, patch: &PatchSpectra, first: usize, forms: &[BothWays<Forms>], dissipation: &mut Dissipation) {
        let layout = &patch.layout;
        let (half, width, stages) = (layout.elements / 2, layout.wavenumbers(), layout.stages());
        let count = products::count(stages);
        let indices = |n: usize| [Some(half + n), (n > 0).then(|| half - n)].into_iter().flatten();
        for Line { bin, row, standing } in patch.lines() {
            for (n, forms) in (first..).zip(forms) {
                for index in indices(n) {
                    let counts = layout.sides(bin) * layout.share(index);
                    let wavenumber = layout.wavenumber(index);
                    let material = layout.material_bin(bin, wavenumber);
                    let forms = forms.of(wavenumber, material);
                    let place = material.unsigned_abs() as usize;
                    let value = |weights: &[f64]| {
                        let product = |number: usize| counts * row[number * width + index];
                        products::form(stages, weights, material < 0, product)
                    };
                    let weights = place * count..(place + 1) * count;
                    // Rounding may leave a square of several stages below zero.
                    let velocity = value(&forms.squares[weights.clone()]).max(0.0);
                    let power = forms.powers.get(weights).map_or(0.0, value);
                    dissipation.add(power, standing);
                    self.add_wave(layout, [bin, index], material, velocity, standing);
                }
            }
        }
    }

    /// Adds the mean square velocity of a wave at a bin, which is this one of the material frame.
    fn add_wave(
        &mut self,
        layout: &SegmentLayout,
        [bin, index]: [usize; 2],
        material: i64,
        velocity: f64,
        standing: bool,
    ) {
        let (width, bins_of_row) = (layout.wavenumbers(), bins_of_row(layout));
        let place = material.unsigned_abs() as usize;
        self.material.power[place] += velocity;
        if standing {
            self.mean_pattern += velocity;
            return;
        }
        self.material_varying.power[place] += velocity;
        self.non_rotating.power[bin] += velocity;
        if let Some([of_material, of_road]) = &mut self.maps {
            of_road.density[bin / bins_of_row * width + index] += velocity;
            // A negative frequency is the wave of -n.
            let index = if material < 0 { layout.elements - index } else { index };
            of_material.density[place / bins_of_row * width + index] += velocity;
        }
    }

    fn end_maps(&mut self) {
        for map in self.maps.iter_mut().flatten() {
            map.density.iter_mut().for_each(|power| *power /= map.row_width);
        }
    }
}

/// Kept values of a bin.
struct Line<'a> {
    bin: usize,
    row: &'a [f64],
    /// True if it is the mean pattern's.
    standing: bool,
}

impl PatchSpectra {
    fn lines(&self) -> impl Iterator<Item = Line<'_>> {
        let varying = (0..self.layout.bins()).map(|bin| Line { bin, row: self.row(bin), standing: false });
        varying.chain(self.mean_pattern.iter().map(|(bin, row)| Line { bin: *bin, row, standing: true }))
    }
}

impl Dissipation {
    fn add(&mut self, power: f64, standing: bool) {
        *(if standing { &mut self.mean_pattern } else { &mut self.vibration }) += power;
    }
}

/// Returns the spectra of the fields whose velocities were heard of resolved forces, in their order.
pub(crate) fn heard_spectra(patch: &PatchSpectra, fields: &[VibrationField], maps: bool) -> Vec<FieldSpectra> {
    let layout = &patch.layout;
    let width = layout.wavenumbers();
    let of_field = |(place, &field): (usize, &VibrationField)| {
        let mut sums = FieldSpectra::silent(layout, field, maps);
        for Line { bin, row, standing } in patch.lines() {
            for (index, square) in row[place * width..(place + 1) * width].iter().enumerate() {
                let counts = layout.sides(bin) * layout.share(index);
                let material = layout.material_bin(bin, layout.wavenumber(index));
                sums.add_wave(layout, [bin, index], material, counts * square, standing);
            }
        }
        sums.end_maps();
        sums
    };
    fields.iter().enumerate().map(of_field).collect()
}

/// Returns the power that resolved forces put in and the tyre dissipates.
pub(crate) fn heard_dissipation(patch: &PatchSpectra) -> Dissipation {
    let layout = &patch.layout;
    let mut dissipation = Dissipation::default();
    for Line { bin, row, standing } in patch.lines() {
        for (index, power) in row.iter().enumerate() {
            dissipation.add(layout.sides(bin) * layout.share(index) * power, standing);
        }
    }
    dissipation
}

/// Returns the bins of a map's row.
fn bins_of_row(layout: &SegmentLayout) -> usize {
    layout.bins().div_ceil(MOST_ROWS)
}

/// Returns the one-sided powers as a spectrum.
fn spectrum(layout: &SegmentLayout, power: Vec<f64>) -> PowerSpectrum {
    PowerSpectrum {
        mean: 0.0,
        resolution: layout.resolution(),
        power,
        nyquist: 0.5 / layout.time_step,
        valid_to: f64::INFINITY,
    }
}

fn one_sided(layout: &SegmentLayout, powers: &[f64]) -> PowerSpectrum {
    spectrum(layout, powers.iter().enumerate().map(|(bin, power)| layout.sides(bin) * power).collect())
}

/// Returns the spectrum at a point of the non-rotating frame.
pub(crate) fn point_spectrum(patch: &PatchSpectra, point: usize) -> PowerSpectrum {
    one_sided(&patch.layout, &patch.points[point])
}

/// Returns the spectrum at an element, the mean pattern that passes it left out.
pub(crate) fn element_spectrum(patch: &PatchSpectra, point: usize) -> PowerSpectrum {
    one_sided(&patch.layout, &patch.elements[point])
}
