//! From powers of the forces to velocities: spectra of both frames, maps, dissipated power.
//!
//! A wave of the non-rotating frame, exp(i (kx x + w t)), is a wave of the material one with w' = w - n Omega; its
//! velocity is that of the material, Y_n(w') = s H_n(s) times its force, in both frames. So every wave's power |Y_n|^2
//! |F_n|^2 belongs to one bin of each frame, and both sums are the same: the mean of v^2 over the circumference and
//! over time. Only the mean pattern differs: it stands still in the non-rotating frame, where it is at 0 Hz and no
//! vibration, and in the material frame has lines at the multiples of the rotation; it is listed by itself, and is a
//! part of the material frame's spectrum.
//!
//! Power: in the mean the forces put in sum_e F_e v_e = sum_n Re Y_n |F_n|^2, all of which the tyre dissipates. Where
//! it turns Y_n and Y_-n differ (`both_directions`); gyroscopic forces do no work.
//!
//! With the forces of several stages |Y_n|^2 and Re Y_n are quadratic forms of all of them (`stage_transfer`); the rest
//! is the same. For forces that are resolved across |v_n|^2 and the power are known already ([`super::resolved`]).

use super::accumulator::PatchSpectra;
use super::both_directions::BothDirections;
use super::layout::SegmentLayout;
use super::products;
use super::transfer::{Forms, TransferKind, Transfers, TyreResponse, VibrationField};
use crate::numeric::in_parallel;
use crate::response::PowerSpectrum;

/// Most rows of frequency in a map.
const MOST_ROWS: usize = 1024;
/// Number of wavenumbers whose transfers are in memory at once.
const BLOCK: usize = 32;

/// Fields whose spectra [`field_spectra`] computes, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectraRequest<'a> {
    /// Fields whose spectra are computed.
    pub fields: &'a [VibrationField],
    /// Transfer: that of the time rule or the exact one.
    pub kind: TransferKind,
    /// True if maps are computed.
    pub maps: bool,
}

/// Spectra of a field, means over the circumference \[m^2/s^2\]; the maps by frequency and wavenumber.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldSpectra {
    /// Field of the velocities.
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

#[derive(Clone, Debug, PartialEq)]
pub struct WavenumberMap {
    /// Wavenumbers -N/2..=N/2 of a row; n > 0 goes towards -x, against the rolling direction.
    pub wavenumbers: usize,
    /// Width of a row \[Hz\]; row i reaches from i to i + 1 of it.
    pub row_width: f64,
    /// Power spectral density \[m^2/s^2/Hz\], row by row of frequency.
    pub density: Vec<f64>,
}

/// Power that the tyre dissipates \[W\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dissipation {
    /// Power of the mean pattern: the loss of rolling on a smooth road \[W\].
    pub mean_pattern: f64,
    /// Power of the vibration \[W\].
    pub vibration: f64,
}

impl Dissipation {
    /// Sum of both \[W\].
    pub(crate) fn total(&self) -> f64 {
        self.mean_pattern + self.vibration
    }
}

/// Spectra of all fields, and the dissipated power; `None` where the response does not have a field.
pub fn field_spectra(
    patch: &PatchSpectra,
    response: &TyreResponse<'_>,
    request: &SpectraRequest<'_>,
) -> Option<(Vec<FieldSpectra>, Dissipation)> {
    let layout = &patch.layout;
    let transfers = Transfers::new(layout, request.kind);
    let mut dissipation = Dissipation::default();
    let mut spectra = Vec::with_capacity(request.fields.len());
    for &field in request.fields {
        let mut sums = FieldSpectra::zero(layout, field, request.maps);
        for first in (0..=layout.elements / 2).step_by(BLOCK) {
            let block = first..(first + BLOCK).min(layout.elements / 2 + 1);
            let forms = in_parallel::made(block.len(), |index| transfers.forms(response, first + index, field));
            let forms: Vec<BothDirections<Forms>> = forms.into_iter().collect::<Option<_>>()?;
            sums.add(patch, first, &forms, &mut dissipation);
        }
        sums.end_maps();
        spectra.push(sums);
    }
    Some((spectra, dissipation))
}

impl FieldSpectra {
    fn zero(layout: &SegmentLayout, field: VibrationField, maps: bool) -> Self {
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

    /// Adds the power of the wavenumbers +-n, from n = `first` on.
    fn add(
        &mut self,
        patch: &PatchSpectra,
        first: usize,
        forms: &[BothDirections<Forms>],
        dissipation: &mut Dissipation,
    ) {
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

    /// Adds the mean square velocity of a wave at a bin of the non-rotating frame; `material` is its bin of the
    /// material frame.
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

/// Values of a bin.
struct Line<'a> {
    bin: usize,
    row: &'a [f64],
    /// True for the mean pattern.
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

/// Spectra of fields whose velocities were stored for resolved forces, in their order.
pub(crate) fn resolved_spectra(patch: &PatchSpectra, fields: &[VibrationField], maps: bool) -> Vec<FieldSpectra> {
    let layout = &patch.layout;
    let width = layout.wavenumbers();
    let of_field = |(place, &field): (usize, &VibrationField)| {
        let mut sums = FieldSpectra::zero(layout, field, maps);
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

/// Power that resolved forces put in and the tyre dissipates.
pub(crate) fn resolved_dissipation(patch: &PatchSpectra) -> Dissipation {
    let layout = &patch.layout;
    let mut dissipation = Dissipation::default();
    for Line { bin, row, standing } in patch.lines() {
        for (index, power) in row.iter().enumerate() {
            dissipation.add(layout.sides(bin) * layout.share(index) * power, standing);
        }
    }
    dissipation
}

/// Number of bins in a map's row.
fn bins_of_row(layout: &SegmentLayout) -> usize {
    layout.bins().div_ceil(MOST_ROWS)
}

/// Spectrum of one-sided powers by bin.
fn spectrum(layout: &SegmentLayout, power: Vec<f64>) -> PowerSpectrum {
    PowerSpectrum::of_powers(power, layout.resolution(), 0.5 / layout.time_step)
}

fn one_sided(layout: &SegmentLayout, powers: &[f64]) -> PowerSpectrum {
    spectrum(layout, powers.iter().enumerate().map(|(bin, power)| layout.sides(bin) * power).collect())
}

/// Spectrum at a point of the non-rotating frame.
pub fn point_spectrum(patch: &PatchSpectra, point: usize) -> PowerSpectrum {
    one_sided(&patch.layout, &patch.points[point])
}

/// Spectrum at an element, without the mean pattern that passes it.
pub(crate) fn element_spectrum(patch: &PatchSpectra, point: usize) -> PowerSpectrum {
    one_sided(&patch.layout, &patch.elements[point])
}
