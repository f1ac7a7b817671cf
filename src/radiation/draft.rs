//! Draft quality: the tread's cells as monopoles on the road, with a horn's gain in closed form; no equations.
//!
//! 1. G = exp(-ikR)/(4 pi R) of a cell's middle, plus that of the cell's image in the road: exact for a monopole over
//!    the rigid plane. The part of a cell within the patch counts as 0.
//! 2. Times 10^(g/20), g the horn's gain \[dB\], a real number: phases stay those of the monopoles.
//!
//!    g = A(k R, c) / (1 + (k R t/b)^q),   A = sum_ij a_ij c^i ln^j(k R/5)
//!
//!    t is the angle from the patch's edge, on the cell's side of the tyre, and c the cosine of the receiver's bearing
//!    from the rolling direction, seen from that side: 1 where the horn opens towards it. b, q and a_ij are a fit to
//!    the full method of this package, all third octaves from 125 to 2500 Hz on the coast-by line and at the cpx
//!    points, for waves that unit forces in the patch drive. The form is that of the asymptotic theories (Kuo, Graf,
//!    Dowling and Graham, J. Sound Vib. 256 (2002) 433-445): constant in the wedge up to a wavelength or so from the
//!    patch, ten decibels less to the side than ahead.
//!
//! Fitted on a tyre of radius 0.31 m, 0.176 m wide over shoulders of 0.02 m, with a sealed patch of 0.108 m. Other
//! radii scale; effects of another width, shoulder or patch are not in it. k R is limited to the fit's range. The error
//! depends on the place: [`DraftErrors`]. Above the tyre monopoles miss the shading by the body: up to 18 dB too loud.
//! No error is stated there.

use num_complex::Complex64;

use super::body::{RadiatingBody, Vector};
use super::elements::distance;
use super::error::RadiationError;
use super::frequencies::{FrequencyRange, FrequencyTransfers, TransferSet};
use super::transfer::{SurfaceTransfer, TransferProblem, across_points, half_tread};
use crate::numeric::{in_parallel, single};

/// Error bound of a draft, relative to the full method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DraftError {
    /// Error of a third octave up to 2000 Hz \[dB\].
    pub band: f64,
    /// Mid-frequency of the lowest third octave for which the bound holds \[Hz\].
    pub from: f64,
    /// Error of the A-weighted level \[dB(A)\].
    pub level: f64,
}

/// Errors of a draft round a tyre, where they were measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DraftErrors {
    /// Errors of the means over the coast-by line and over both cpx microphones.
    pub of_standards: DraftError,
    /// Errors at single places nearer to the axle's direction than to that of travel.
    pub beside: DraftError,
    /// Errors at the other places, ahead and behind.
    pub ahead: DraftError,
    /// Radius of the tyre \[m\].
    pub radius: f64,
}

/// Elevation of a place over the road, as seen from the contact, up to which an error is stated \[degrees\].
pub(crate) const MOST_ELEVATION: f64 = 25.0;
/// Least distance of a place from the contact, in radii of the tyre, for which an error is stated.
pub(crate) const LEAST_DISTANCE: f64 = 1.0;
/// Limits of a tyre's width, shoulders included, over its radius: the least width with a stated error, the largest one
/// with the errors of the fitted tyre, and the largest one with a stated error.
pub(crate) const WIDTHS: [f64; 3] = [0.5, 0.65, 0.8];
/// k R of the highest frequency: where the fit ends. The highest third octave below it, 2 kHz with a radius of 0.31 m,
/// is the highest in which errors were measured.
pub(crate) const HIGHEST: f64 = 14.4;
/// Within the third octave of 200 Hz, below its exact mid-frequency \[Hz\]. Below that band sound from both ends of the
/// patch cancels at single places, and errors of up to 16 dB were found.
const LOWEST: f64 = 190.0;
/// Likewise within the third octave of 63 Hz, for the standards' means: errors of up to 4.9 dB were found below it.
const LOWEST_OF_STANDARDS: f64 = 60.0;

impl DraftErrors {
    /// Errors for a tyre of a radius and a width with its shoulders \[m\]; `None` for a width that was not measured.
    pub fn of(radius: f64, width: f64) -> Option<Self> {
        let [least, fitted, most] = WIDTHS;
        let relative = width / radius;
        if !(least..=most).contains(&relative) {
            return None;
        }
        let error = |band, from, level| DraftError { band, from, level };
        let [of_standards, beside, ahead] = if relative <= fitted {
            [error(3.0, LOWEST_OF_STANDARDS, 1.5), error(6.0, LOWEST, 2.5), error(10.0, LOWEST, 6.0)]
        } else {
            [error(5.0, LOWEST_OF_STANDARDS, 3.5), error(7.0, LOWEST, 4.0), error(14.0, LOWEST, 6.0)]
        };
        Some(Self { of_standards, beside, ahead, radius })
    }

    /// Error at a place \[m\]; `None` where none is stated: too high above the road or too near to the contact.
    pub fn at(&self, [x, y, z]: Vector) -> Option<DraftError> {
        let away = x.hypot(y);
        let low = z.atan2(away).to_degrees() <= MOST_ELEVATION;
        let clear = away.hypot(z) >= LEAST_DISTANCE * self.radius;
        (low && clear).then_some(if x.abs() <= y.abs() { self.beside } else { self.ahead })
    }
}

/// a_ij, row by row of i.
const AMPLITUDES: [[f64; 4]; 4] = [
    [4.098, 0.952, -2.456, -0.867],
    [4.872, 1.303, -0.750, -0.596],
    [-1.608, 5.350, -0.107, -1.914],
    [6.653, 8.687, 0.808, -0.038],
];
/// b and q.
const DECAY: f64 = 2.761;
const STEEPNESS: f64 = 7.035;
/// k R at which the logarithm is 0, and the range of the fit.
const MIDDLE: f64 = 5.0;
const RANGE: [f64; 2] = [0.7, 14.2];

/// Gain of the horn \[dB\] for a wavenumber times the tyre's radius, the angle from the patch's edge \[rad\] and the
/// cosine of the receiver's bearing from the direction in which the horn opens.
pub(crate) fn horn_gain(wavenumber_radius: f64, angle: f64, bearing: f64) -> f64 {
    let logarithm = (wavenumber_radius.clamp(RANGE[0], RANGE[1]) / MIDDLE).ln();
    let polynomial = |row: &[f64; 4]| row.iter().rev().fold(0.0, |sum, coefficient| sum * logarithm + coefficient);
    let amplitude = AMPLITUDES.iter().rev().fold(0.0, |sum, row| sum * bearing + polynomial(row));
    amplitude / (1.0 + (wavenumber_radius * angle / DECAY).powf(STEEPNESS))
}

/// G of a monopole at a point over a rigid road \[1/m\].
pub(crate) fn monopole(point: Vector, receiver: Vector, wavenumber: f64) -> Complex64 {
    let one = |r: f64| Complex64::from_polar(1.0 / (4.0 * std::f64::consts::PI * r), -wavenumber * r);
    let [x, y, z] = receiver;
    one(distance(point, receiver)) + one(distance(point, [x, y, -z]))
}

/// Transfers of a problem at a wavenumber \[rad/m\]: the even part of a tyre that stands on the road, or both sides of
/// its tread, whose horn is then taken to be that of the even part.
pub fn transfers_at(problem: &TransferProblem<'_>, wavenumber: f64) -> Vec<SurfaceTransfer> {
    let TransferProblem { body, grid, receivers, .. } = *problem;
    let radius = body.radius();
    let edge = (body.half_patch() / radius).asin();
    let width = std::f64::consts::TAU / grid.around as f64;
    let rows = across_points(half_tread(body), grid.across);
    let cells: Vec<(f64, f64)> = (0..grid.around).map(|cell| cell_of(cell, grid.around, edge)).collect();
    let one = |&receiver: &Vector| {
        let [ahead, beside, _] = receiver;
        let bearing = ahead / ahead.hypot(beside).max(f64::MIN_POSITIVE);
        let gains: Vec<f64> = cells
            .iter()
            .zip(0..grid.around)
            .map(|(&(angle, share), cell)| {
                let towards = if 2 * cell < grid.around { bearing } else { -bearing };
                share * 10.0_f64.powf(0.05 * horn_gain(wavenumber * radius, angle, towards))
            })
            .collect();
        let sides = problem.sides();
        let mut values = Vec::with_capacity(sides * grid.across * grid.around);
        for (side, &[y, _]) in (0..sides).flat_map(|side| rows.iter().map(move |row| (side, row))) {
            for (cell, gain) in gains.iter().enumerate() {
                let theta = width * (cell as f64 + 0.5);
                let at = |y: f64| [radius * theta.sin(), y, body.middle() - radius * theta.cos()];
                let from = |y: f64| monopole(at(y), receiver, wavenumber);
                let pressure = match (sides, side) {
                    (1, _) => (from(y) + from(-y)) * (0.5 * gain),
                    (_, 0) => from(y) * *gain,
                    _ => from(-y) * *gain,
                };
                values.push(single(pressure));
            }
        }
        SurfaceTransfer { receiver, wavenumber, grid, sides, values }
    };
    receivers.iter().map(one).collect()
}

/// Angle of a cell's middle from the patch's edge \[rad\], and the share of the cell outside the patch.
fn cell_of(cell: usize, around: usize, edge: f64) -> (f64, f64) {
    let width = std::f64::consts::TAU / around as f64;
    // The cell's mirror fore-aft has the same distance.
    let index = cell.min(around - 1 - cell) as f64;
    (((index + 0.5) * width - edge).max(0.0), (index + 1.0 - edge / width).clamp(0.0, 1.0))
}

/// Transfers of a range: at the frequencies with which the full method begins, and at their midpoints.
///
/// # Errors
/// As [`TransferProblem::check`] and [`FrequencyRange::check`]; [`RadiationError::Height`] without a road,
/// [`RadiationError::Gap`] with a gap.
pub(crate) fn transfers(problem: &TransferProblem<'_>, range: &FrequencyRange) -> Result<TransferSet, RadiationError> {
    range.check()?;
    problem.check()?;
    check(problem.body)?;
    let at = |frequency: f64| {
        let transfers = transfers_at(problem, range.wavenumber(frequency));
        FrequencyTransfers { frequency, transfers }
    };
    Ok(TransferSet::new(in_parallel::map(&frequencies(range), |&frequency| at(frequency))))
}

/// Frequencies of the draft in a range, rising \[Hz\].
pub(crate) fn frequencies(range: &FrequencyRange) -> Vec<f64> {
    let first = range.first();
    let middles = first.windows(2).map(|ends| 0.5 * (ends[0] + ends[1]));
    let mut all: Vec<f64> = first.iter().copied().chain(middles).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Refuses bodies for which the fit does not hold.
fn check(body: &RadiatingBody) -> Result<(), RadiationError> {
    if body.half_patch() <= 0.0 {
        let (height, radius) = (body.middle(), body.radius());
        let why = "draft quality is for a tyre that stands on the road";
        return Err(RadiationError::Height { what: "a body", height, radius, why });
    }
    if body.gap() > 0.0 {
        return Err(RadiationError::Gap { gap: body.gap(), why: "draft quality is for sealed patches only" });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::double;
    use crate::radiation::{MeshResolution, ParityBlock, TransferGrid};

    fn problem<'a>(body: &'a RadiatingBody, receivers: &'a [Vector]) -> TransferProblem<'a> {
        TransferProblem {
            body,
            receivers,
            grid: TransferGrid { around: 512, across: 4 },
            flank: None,
            resolution: MeshResolution::of(6.0),
            blocks: &ParityBlock::EVEN_ACROSS,
            memory_limit: 1 << 30,
        }
    }

    #[test]
    fn a_monopole_over_a_rigid_plane_is_exact() {
        // On the plane the image doubles the free field; where the paths differ by half a wavelength it nearly cancels.
        let (k, source) = (20.0, [0.1, 0.05, 0.4]);
        let on_plane = monopole(source, [3.0, 1.0, 0.0], k);
        let r = distance(source, [3.0, 1.0, 0.0]);
        assert!((on_plane.norm() - 2.0 / (4.0 * std::f64::consts::PI * r)).abs() < 1e-15);
        let slope = |z: f64| {
            let step = 1e-6;
            (monopole(source, [3.0, 1.0, z + step], k) - monopole(source, [3.0, 1.0, z - step], k)) / (2.0 * step)
        };
        // The plane is rigid: dp/dz = 0 there, not elsewhere.
        assert!(slope(0.0).norm() < 1e-9 && slope(0.3).norm() > 1e-3, "{} {}", slope(0.0), slope(0.3));
        // Far from the patch's edge the tread consists of such monopoles.
        let body = RadiatingBody::standing_tyre(0.31, 0.176, 0.02, 0.054).unwrap();
        let receivers = [[0.0, 7.5, 1.2]];
        let found = transfers_at(&problem(&body, &receivers), k);
        let cell = 255;
        let theta = std::f64::consts::TAU * (cell as f64 + 0.5) / 512.0;
        let y = across_points(half_tread(&body), 4)[1][0];
        let at = |y: f64| [0.31 * theta.sin(), y, body.middle() - 0.31 * theta.cos()];
        let exact = 0.5 * (monopole(at(y), receivers[0], k) + monopole(at(-y), receivers[0], k));
        let value = double(found[0].values[found[0].index(0, 1, cell)]);
        assert!((value - exact).norm() < 2e-3 * exact.norm(), "{value} {exact}");
        assert_eq!(double(found[0].values[found[0].index(0, 0, 0)]), Complex64::ZERO, "within the patch nothing moves");
    }

    #[test]
    fn the_stated_error_holds_where_the_tyre_does_not_shade() {
        let body = RadiatingBody::standing_tyre(0.3103, 0.176, 0.02, 0.054).unwrap();
        let errors = DraftErrors::of(body.radius(), 0.176).unwrap();
        let receivers = [[0.5, 0.0, 0.2], [-0.5, 0.1, 0.2], [3.0, 0.5, 0.1], [0.1, 0.5, 0.1], [0.3, 0.0, 2.0]];
        let problem = problem(&body, &receivers);
        let wavenumber = std::f64::consts::TAU * 2000.0 / 343.2;
        let (full, _) = problem.solve(wavenumber).unwrap();
        for (full, draft) in full.iter().zip(&transfers_at(&problem, wavenumber)) {
            let error = level_near_the_patch(draft) - level_near_the_patch(full);
            match errors.at(full.receiver) {
                Some(stated) => assert!(error.abs() < stated.band, "{:?}: {error} dB", full.receiver),
                None => assert!(error > errors.ahead.band, "{:?}: {error} dB", full.receiver),
            }
        }
    }

    /// Level of the mean square over the strongest part of the vibration: the tread within 60 mm of the patch, both
    /// ends \[dB\].
    fn level_near_the_patch(transfer: &SurfaceTransfer) -> f64 {
        let value = |across: usize, cell: usize| double(transfer.values[transfer.index(0, across, cell)]);
        let cell = |cell: usize| (0..4).map(|across| value(across, cell).norm_sqr()).sum::<f64>();
        10.0 * (15..30).map(|index| cell(index) + cell(511 - index)).sum::<f64>().log10()
    }

    #[test]
    fn the_horn_agrees_with_the_full_method_within_the_stated_error() {
        let body = RadiatingBody::standing_tyre(0.3103, 0.176, 0.02, 0.054).unwrap();
        let stated = DraftErrors::of(body.radius(), 0.176).unwrap().of_standards.band;
        // Ahead and beside on the coast-by line, cpx in front.
        let receivers = [[8.0, 7.5, 1.2], [0.0, 7.5, 1.2], [0.2, 0.288, 0.1]];
        let problem = problem(&body, &receivers);
        for frequency in [500.0, 1000.0] {
            let wavenumber = std::f64::consts::TAU * frequency / 343.2;
            let (full, _) = problem.solve(wavenumber).unwrap();
            let draft = transfers_at(&problem, wavenumber);
            for (full, draft) in full.iter().zip(&draft) {
                let error = level_near_the_patch(draft) - level_near_the_patch(full);
                assert!(error.abs() < stated, "{frequency} Hz at {:?}: {error} dB", full.receiver);
            }
        }
    }
}
