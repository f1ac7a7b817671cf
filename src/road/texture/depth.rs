//! Mean profile depth by ISO 13473-1:2019, and the comparison with the reference surface of pass-by tests.
//!
//! 1. A Butterworth low-pass of second order at 2.40 mm is applied forward and backward, if the spacing is fine enough
//!    for the standard; a profile of finer spacing is not resampled.
//! 2. Segments of 100 mm: slope suppressed, the mean of the two halves' highest points above the segment's mean.
//! 3. A segment with more than 10 % of its points missing (7.3) or more than 5 % of them spikes (7.5) is not valid, nor
//!    one whose points that are either extend more than 5 mm into the profile from its end: there is nothing to
//!    interpolate to.

use std::f64::consts::{PI, SQRT_2};

use serde::Serialize;

use super::levels::remove_line;

/// Segment length \[m\].
const SEGMENT_LENGTH: f64 = 0.1;
/// Coarsest spacing that the standard allows \[m\].
const COARSEST: f64 = 1e-3;
/// Wavelength at which one pass of the low-pass attenuates by 3 dB \[m\].
const CUT_OFF: f64 = 2.4e-3;
/// Largest share of a segment's points that may be missing.
const MISSING_ALLOWED: f64 = 0.1;
/// Largest share of a segment's points that may be spikes.
const SPIKES_ALLOWED: f64 = 0.05;
/// Longest part at a profile's end in which a held height may replace measured ones \[m\].
const LONGEST_HELD: f64 = 5e-3;

/// Mean profile depth of the reference surface for pass-by tests (ISO 10844:2014), and its tolerance \[m\].
const REFERENCE_SURFACE: [f64; 2] = [0.5e-3, 0.2e-3];

/// Origin of a height.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HeightOrigin {
    /// Measured.
    #[default]
    Measured,
    /// Interpolated, as it is missing in the file.
    Missing,
    /// Interpolated, as it is a spike.
    Spike,
}

/// The mean profile depth of one or more profiles, with the numbers of segments that it is based on.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ProfileDepth {
    /// Mean of the valid segments' depths \[m\]; absent without one.
    pub mean: Option<f64>,
    /// Their standard deviation \[m\]; absent for fewer than two.
    pub deviation: Option<f64>,
    /// Standard error of the mean \[m\], by the scatter along the road of the depths averaged over the profiles, which
    /// neighbours have in common; absent for fewer than two.
    #[serde(skip)]
    pub standard_error: Option<f64>,
    /// Number of segments of 100 mm in all profiles.
    pub segments: usize,
    /// Number of valid ones.
    pub valid: usize,
    /// The profile's spacing is more than 1 mm, too coarse for the standard: peaks are missed, the depth is too small.
    pub too_coarse: bool,
    /// True if the depth is that of the reference surface of ISO 10844:2014, 0.5 mm within 0.2 mm; absent if there is
    /// no depth by the standard. Other properties of that surface are not checked here.
    pub reference_surface: Option<bool>,
}

impl ProfileDepth {
    /// Depth of profiles with points `spacing` \[m\] apart, each with its origin; without origins all were measured.
    pub(crate) fn of<'a>(profiles: impl IntoIterator<Item = (&'a [f64], &'a [HeightOrigin])>, spacing: f64) -> Self {
        let (mut segments, mut depths) = (0, Vec::new());
        // Sum and number of the depths beside each other.
        let mut along: Vec<(f64, f64)> = Vec::new();
        for (heights, origins) in profiles {
            let found = segment_depths(heights, origins, spacing);
            segments += found.len();
            along.resize(along.len().max(found.len()), (0.0, 0.0));
            for ((sum, count), depth) in along.iter_mut().zip(&found).filter_map(|(at, of)| Some((at, (*of)?))) {
                (*sum, *count) = (*sum + depth, *count + 1.0);
            }
            depths.extend(found.into_iter().flatten());
        }
        let valid = depths.len();
        let mean = (valid > 0).then(|| depths.iter().sum::<f64>() / valid as f64);
        let means: Vec<f64> = along.iter().filter(|(_, count)| *count > 0.0).map(|(sum, count)| sum / count).collect();
        let standard_error = deviation(&means).map(|deviation| deviation / (means.len() as f64).sqrt());
        let too_coarse = is_too_coarse(spacing);
        let [wanted, within] = REFERENCE_SURFACE;
        let agrees = |mean: f64| (mean - wanted).abs() <= within * (1.0 + 1e-9);
        let reference_surface = mean.filter(|_| !too_coarse).map(agrees);
        Self { mean, deviation: deviation(&depths), standard_error, segments, valid, too_coarse, reference_surface }
    }
}

/// Standard deviation of some values; `None` for fewer than two.
fn deviation(values: &[f64]) -> Option<f64> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    (count > 1.0).then(|| (squares / (count - 1.0)).sqrt())
}

fn is_too_coarse(spacing: f64) -> bool {
    spacing > COARSEST * (1.0 + 1e-9)
}

/// Depth of each segment of a profile \[m\]; `None` if it is not valid. No segments for a profile shorter than one, or
/// so coarse that half a segment has fewer than two points.
fn segment_depths(heights: &[f64], origins: &[HeightOrigin], spacing: f64) -> Vec<Option<f64>> {
    let per_segment = (SEGMENT_LENGTH / spacing).round() as usize;
    if per_segment < 4 {
        return Vec::new();
    }
    let mut profile = heights.to_vec();
    if !is_too_coarse(spacing) {
        low_pass(&mut profile, spacing);
    }
    // From both ends: number of points before the first that was measured.
    let is_measured = |origin: &HeightOrigin| *origin == HeightOrigin::Measured;
    let held = [origins.iter().position(is_measured), origins.iter().rev().position(is_measured)];
    let held = held.map(|points| points.unwrap_or(origins.len()));
    let valid = |number: usize| {
        let (from, to) = (number * per_segment, (number + 1) * per_segment);
        let part = origins.get(from..to).unwrap_or_default();
        let few = |wanted, allowed: f64| {
            part.iter().filter(|origin| **origin == wanted).count() as f64 <= allowed * per_segment as f64
        };
        let reaches = [from < held[0], to > heights.len() - held[1]];
        let unknown = (0..2).any(|end| reaches[end] && held[end] as f64 * spacing > LONGEST_HELD * (1.0 + 1e-9));
        few(HeightOrigin::Missing, MISSING_ALLOWED) && few(HeightOrigin::Spike, SPIKES_ALLOWED) && !unknown
    };
    let segments = profile.chunks_exact_mut(per_segment).enumerate();
    segments.map(|(number, segment)| valid(number).then(|| depth(segment))).collect()
}

/// Depth of one segment \[m\], from which its least-squares line is removed.
fn depth(segment: &mut [f64]) -> f64 {
    remove_line(segment);
    let (left, right) = segment.split_at(segment.len() / 2);
    let peak = |half: &[f64]| half.iter().fold(f64::NEG_INFINITY, |highest, &height| highest.max(height));
    0.5 * (peak(left) + peak(right))
}

/// Butterworth low-pass of second order by the bilinear transform, applied in both directions: no phase shift remains.
/// Each pass starts in the steady state of the first height that it meets.
fn low_pass(profile: &mut [f64], spacing: f64) {
    let warped = (PI * spacing / CUT_OFF).tan();
    let scale = 1.0 / (1.0 + SQRT_2 * warped + warped * warped);
    let forward = warped * warped * scale;
    let back = [2.0 * (warped * warped - 1.0) * scale, (1.0 - SQRT_2 * warped + warped * warped) * scale];
    for _ in 0..2 {
        profile.reverse();
        let first = profile.first().copied().unwrap_or_default();
        let (mut before, mut after) = ([first; 2], [first; 2]);
        for height in profile.iter_mut() {
            let input = *height;
            let output = forward * (input + 2.0 * before[0] + before[1]) - back[0] * after[0] - back[1] * after[1];
            (before, after) = ([input, before[0]], [output, after[0]]);
            *height = output;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cosine with its peaks in the middle between points, even about the middle of every segment.
    fn cosine(amplitude: f64, wavelength: f64, spacing: f64, points: usize) -> Vec<f64> {
        let phase = |i: usize| 2.0 * PI * (i as f64 + 0.5) * spacing / wavelength;
        (0..points).map(|i| amplitude * phase(i).cos()).collect()
    }

    fn of(heights: &[f64], origins: &[HeightOrigin], spacing: f64) -> ProfileDepth {
        ProfileDepth::of([(heights, origins)], spacing)
    }

    #[test]
    fn a_waves_depth_is_its_amplitude_less_what_the_low_pass_takes() {
        for (spacing, points) in [(1e-3, 1000), (0.5e-3, 2000), (0.1e-3, 10_000)] {
            let reported = of(&cosine(1e-3, 0.02, spacing, points), &[], spacing);
            let mean = reported.mean.unwrap();
            assert!((mean - 1e-3).abs() < 0.02e-3, "{spacing}: {mean}");
            assert!(reported.deviation.unwrap() < 0.01e-3, "{reported:?}");
            assert_eq!((reported.segments, reported.valid, reported.too_coarse), (10, 10, false), "{spacing}");
        }
        // Each pass attenuates by 3 dB at the cut-off: both leave half of the wave.
        let short = of(&cosine(1e-3, CUT_OFF, 0.1e-3, 10_000), &[], 0.1e-3).mean.unwrap();
        assert!((0.48e-3..0.52e-3).contains(&short), "{short}");
        assert!(of(&cosine(1e-3, 0.6e-3, 0.1e-3, 10_000), &[], 0.1e-3).mean.unwrap() < 0.01e-3);
    }

    #[test]
    fn slope_does_not_count_and_triangles_have_half_their_height() {
        let h = 2e-3;
        let profile: Vec<f64> =
            (0..1000).map(|i| h * (1.0 - ((i % 50) as f64 - 25.0).abs() / 25.0) + 1e-5 * i as f64).collect();
        let reported = of(&profile, &[], 1e-3);
        assert!((reported.mean.unwrap() - 0.5 * h).abs() < 0.05 * h, "{reported:?}");
        assert_eq!(of(&profile[..99], &[], 1e-3), ProfileDepth::default());
        assert_eq!(of(&profile, &[], 0.05).segments, 0);
        let coarse = of(&profile, &[], 2e-3);
        assert!(coarse.too_coarse && coarse.mean.is_some() && coarse.reference_surface.is_none());
    }

    #[test]
    fn profiles_that_are_alike_do_not_lower_the_standard_error() {
        let waves = [cosine(1e-3, 0.02, 1e-3, 1000), cosine(0.5e-3, 0.02, 1e-3, 1000)].concat();
        let none: &[HeightOrigin] = &[];
        let [one, four] = [1, 4].map(|count| ProfileDepth::of(std::iter::repeat_n((&waves[..], none), count), 1e-3));
        // Ten segments of either depth: a deviation of half their difference.
        let expected = 0.25e-3 * (20.0_f64 / 19.0).sqrt() / 20.0_f64.sqrt();
        assert!((one.standard_error.unwrap() / expected - 1.0).abs() < 0.03, "{one:?}");
        assert!((four.standard_error.unwrap() - one.standard_error.unwrap()).abs() < 1e-12 && four.valid == 80);
        assert_eq!(of(&waves[..100], none, 1e-3).standard_error, None);
    }

    #[test]
    fn segments_with_holes_or_without_an_end_are_not_valid() {
        let heights = cosine(1e-3, 0.02, 0.5e-3, 2000);
        let valid_with = |origin: HeightOrigin, holes: &[std::ops::Range<usize>]| {
            let mut origins = vec![HeightOrigin::Measured; heights.len()];
            holes.iter().for_each(|hole| origins[hole.clone()].fill(origin));
            let reported = of(&heights, &origins, 0.5e-3);
            assert_eq!(reported.segments, 10);
            reported.valid
        };
        let valid = |holes: &[std::ops::Range<usize>]| valid_with(HeightOrigin::Missing, holes);
        // 10 of 200 points are 5 %.
        assert_eq!(valid_with(HeightOrigin::Spike, &[300..310, 0..0]), 10);
        assert_eq!(valid_with(HeightOrigin::Spike, &[300..311, 0..0]), 9);
        // 20 of 200 points are a tenth.
        assert_eq!(valid(&[300..320, 0..0]), 10);
        assert_eq!(valid(&[300..321, 0..0]), 9);
        assert_eq!(valid(&[390..425, 0..0]), 9, "10 points in one segment, 25 in the other");
        // 10 points are the 5 mm that may be held at an end.
        assert_eq!(valid(&[0..10, 1990..2000]), 10);
        assert_eq!(valid(&[0..11, 1989..2000]), 8);
        assert_eq!(valid(&[0..2000, 0..0]), 0);
    }

    #[test]
    fn the_reference_surface_has_half_a_millimetre() {
        let agrees = |amplitude: f64| of(&cosine(amplitude, 0.02, 1e-3, 1000), &[], 1e-3).reference_surface;
        assert_eq!(
            [0.25e-3, 0.35e-3, 0.5e-3, 0.65e-3, 0.75e-3].map(agrees),
            [false, true, true, true, false].map(Some)
        );
    }
}
