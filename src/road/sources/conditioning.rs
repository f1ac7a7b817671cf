//! Conditioning of measured heights, the same for every kind of road, once they are on a lattice.
//!
//! 1. Spikes (ISO 13473-1:2019, 7.5): neighbours that differ by at least three times their distance are interpolated,
//!    both; of a map along and across. On a lattice finer than the standard's (7.4), means over its spacing count, and
//!    each point against the median of those around it: in a mean, a spike of one point is lost.
//!    The standard looks once; here it is looked again until nothing more is found: a spike of several points hides
//!    those in its middle. A rise and a fall at most 5 mm apart take along what they enclose, where it stands out from
//!    its surroundings: stones of chip seals are as steep and as wide.
//! 2. Mean and slope, along and across, are subtracted as the scene says, then waves longer than it wants.
//! 3. Heights that still span more than a texture can are refused.

use std::path::Path;

use super::height_map::{LARGE_SPAN, RoadHeightMap, fill, remove_plane};
use crate::road::error::{RoadError, positive};
use crate::road::file_fault::FileFault;
use crate::road::report::{RoadNote, RoadReport};
use crate::road::texture::levels::remove_line;
use crate::road::texture::{HeightOrigin, rms};
use crate::scene::Levelling;

/// Slope from which on neighbouring heights are not those of a road.
pub(super) const STEEPEST: f64 = 3.0;
/// Finest spacing on which the standard compares neighbours \[m\].
const FINEST: f64 = 0.5e-3;
/// Largest width of what a rise and a fall enclose and take along \[m\].
const WIDEST_SPIKE: f64 = 5e-3;
/// Least height of it, in root mean squares of the surroundings up to a distance \[m\]. At 2.5 times, a hole of a
/// measured chip seal goes, at 3 times nothing of three such seals.
const STANDS_OUT: f64 = 3.0;
const SURROUNDINGS: f64 = 0.05;
/// Most searches for spikes: what is still there then is wider than a spike.
const MOST_PASSES: usize = 16;
/// Largest share of heights that may be spikes.
const SPIKES_ALLOWED: f64 = 0.25;

/// Removes spikes from a map, levels it, and removes long waves.
///
/// # Errors
/// Spikes nearly everywhere, a trend that cannot be removed, or an implausible span.
pub(crate) fn condition(
    map: &mut RoadHeightMap,
    level: Levelling,
    longest: Option<f64>,
    report: &mut RoadReport,
) -> Result<(), RoadError> {
    let notes = &mut report.notes;
    let as_read = map.plausible_span();
    let (spikes, total) = (drop_spikes(map), map.heights.len());
    note_spikes(&map.path, [spikes, total], as_read, notes)?;
    match level {
        Levelling::Slope => {
            let [mean, along, across] = remove_plane(&mut map.heights, map.columns);
            let across = (map.dy > 0.0).then(|| across / map.dy);
            notes.push(RoadNote::Levelled { mean, along: along / map.dx, across });
        }
        Levelling::Mean => {
            let mean = map.heights.iter().sum::<f64>() / total as f64;
            map.heights.iter_mut().for_each(|height| *height -= mean);
            notes.push(RoadNote::MeanRemoved { mean });
        }
        Levelling::Off => notes.push(RoadNote::NotLevelled),
    }
    if let Some(longest) = longest {
        positive("road.longest_wavelength", longest)?;
        map.remove_trend(longest)?;
        notes.push(RoadNote::Detrended { longest_wavelength: longest });
    }
    note_span(map.plausible_span()?, notes);
    Ok(())
}

/// Notes the spikes among so many heights; `as_read` is their span before.
///
/// # Errors
/// Too many of them.
pub(super) fn note_spikes(
    path: &Path,
    [spikes, total]: [usize; 2],
    as_read: Result<f64, RoadError>,
    notes: &mut Vec<RoadNote>,
) -> Result<(), RoadError> {
    if spikes as f64 > SPIKES_ALLOWED * total as f64 {
        // Heights in another unit are steep everywhere: in that case the span is the better complaint.
        as_read?;
        let fault = FileFault::TooManySpikes { spikes, total, allowed: SPIKES_ALLOWED };
        return Err(RoadError::file(path, fault));
    }
    notes.extend((spikes > 0).then_some(RoadNote::Spikes { count: spikes, total }));
    Ok(())
}

/// Notes a span \[m\] that is large for a texture.
pub(super) fn note_span(span: f64, notes: &mut Vec<RoadNote>) {
    notes.extend((span > LARGE_SPAN).then_some(RoadNote::LargeSpan { span }));
}

/// Interpolates spikes and marks them; returns their number.
pub(super) fn drop_spikes(map: &mut RoadHeightMap) -> usize {
    let (rows, columns) = (map.rows(), map.columns);
    if !may_have_spikes(map) {
        return 0;
    }
    let mut is_spike = vec![false; map.heights.len()];
    for _ in 0..MOST_PASSES {
        let mut found = false;
        let mut line = Vec::new();
        let mut search = |first: usize, step: usize, count: usize, spacing: f64| {
            line.clear();
            line.extend((0..count).map(|index| map.heights[first + index * step]));
            steep(&line, spacing, |index| {
                let spike = &mut is_spike[first + index * step];
                found |= !*spike;
                *spike = true;
            });
        };
        (0..columns).for_each(|column| search(column, columns, rows, map.dx));
        if map.dy > 0.0 {
            (0..rows).for_each(|row| search(row * columns, 1, columns, map.dy));
        }
        if !found {
            break;
        }
        // A height that was interpolated from a spike is interpolated again.
        let missing =
            map.origins.iter().map(|origin| *origin != HeightOrigin::Measured).chain(std::iter::repeat(false));
        for ((height, spike), missing) in map.heights.iter_mut().zip(&is_spike).zip(missing) {
            if *spike || missing {
                *height = f64::NAN;
            }
        }
        fill(&mut map.heights, columns);
    }
    let count = is_spike.iter().filter(|spike| **spike).count();
    if count > 0 {
        map.origins.resize(is_spike.len(), HeightOrigin::Measured);
        for (origin, _) in map.origins.iter_mut().zip(&is_spike).filter(|(_, spike)| **spike) {
            if *origin == HeightOrigin::Measured {
                *origin = HeightOrigin::Spike;
            }
        }
    }
    count
}

/// False if no neighbours differ as those of a spike do. Below the finest spacing means are compared, and it is true.
fn may_have_spikes(map: &RoadHeightMap) -> bool {
    let steepest = |spacing: f64| STEEPEST * (1.0 - 1e-9) * spacing;
    let [along, across] = [map.dx, map.dy].map(steepest);
    let rows = || map.heights.chunks_exact(map.columns);
    let is_steep = |a: f64, b: f64, least: f64| (b - a).abs() >= least;
    let steep_along =
        |(a, b): (&[f64], &[f64])| a.iter().zip(b).fold(false, |any, (a, b)| any | is_steep(*a, *b, along));
    let steep_across = |row: &[f64]| row.windows(2).fold(false, |any, pair| any | is_steep(pair[0], pair[1], across));
    let [is_fine_along, is_fine_across] = [map.dx, map.dy].map(|spacing| spacing < FINEST * (1.0 + 1e-9));
    is_fine_along
        || map.dy > 0.0 && (is_fine_across || rows().any(steep_across))
        || rows().zip(rows().skip(1)).any(steep_along)
}

/// Points that are compared as one, `from..to`, and their mean height \[m\].
struct Sample {
    from: usize,
    to: usize,
    height: f64,
}

/// Calls `call` with every point of a line whose height, or whose mean over the standard's spacing, differs from a
/// neighbour's by at least three times the distance, and with those between two such steps that form a spike.
fn steep(line: &[f64], spacing: f64, mut call: impl FnMut(usize)) {
    let slack = 1.0 - 1e-9;
    let mut samples: Vec<Sample> = Vec::new();
    let mut from = 0;
    while from < line.len() {
        let end = ((samples.len() + 1) as f64 * FINEST / spacing * slack).ceil() as usize;
        let to = end.min(line.len()).max(from + 1);
        samples.push(Sample { from, to, height: line[from..to].iter().sum::<f64>() / (to - from) as f64 });
        from = to;
    }
    let distance = |a: &Sample, b: &Sample| 0.5 * (b.from + b.to - a.from - a.to) as f64 * spacing;
    let is_steep = |a: &Sample, b: &Sample| (b.height - a.height).abs() >= STEEPEST * slack * distance(a, b);
    let steps: Vec<usize> = (1..samples.len()).filter(|&step| is_steep(&samples[step - 1], &samples[step])).collect();
    for step in &steps {
        (samples[step - 1].from..samples[*step].to).for_each(&mut call);
    }
    for pair in steps.windows(2) {
        let (first, last) = (pair[0] - 1, pair[1]);
        let is_narrow = distance(&samples[first], &samples[last - 1]) * slack <= WIDEST_SPIKE;
        if is_narrow && stands_out(&samples, first, last, FINEST.max(spacing)) {
            (samples[first].from..samples[last].to).for_each(&mut call);
        }
    }
    if spacing < FINEST * slack {
        lone(line, spacing, call);
    }
}

/// True if a rise behind one sample and a fall before another, or the reverse, enclose samples that all stand out from
/// the line through the two.
fn stands_out(samples: &[Sample], first: usize, last: usize, spacing: f64) -> bool {
    let height = |index: usize| samples[index].height;
    let [step, slope] = [height(first + 1) - height(first), (height(last) - height(first)) / (last - first) as f64];
    let above = |index: usize| (height(index) - height(first) - slope * (index - first) as f64) * step.signum();
    let least = (first + 1..last).map(above).fold(f64::INFINITY, f64::min);
    if step * (height(last) - height(last - 1)) >= 0.0 || least < STEEPEST * (1.0 - 1e-9) * spacing {
        return false;
    }
    let reach = (SURROUNDINGS / spacing) as usize;
    let around = (first.saturating_sub(reach)..=first).chain(last..samples.len().min(last + reach + 1));
    let mut around: Vec<f64> = around.map(height).collect();
    remove_line(&mut around);
    least >= STANDS_OUT * rms(&around)
}

/// Calls with every point of a fine line that differs from the median of the points within half of the standard's
/// spacing by at least three times that distance.
fn lone(line: &[f64], spacing: f64, mut call: impl FnMut(usize)) {
    let half = ((0.5 * FINEST / spacing).round() as usize).max(1);
    let (width, limit) = (2 * half + 1, STEEPEST * (1.0 - 1e-9) * half as f64 * spacing);
    let mut around = Vec::with_capacity(width);
    for (index, height) in line.iter().enumerate() {
        let from = index.saturating_sub(half).min(line.len().saturating_sub(width));
        let part = &line[from..(from + width).min(line.len())];
        // The median is computed only where it may matter.
        if part.iter().any(|other| (other - height).abs() >= limit) {
            around.clear();
            around.extend_from_slice(part);
            let median = *around.select_nth_unstable_by(part.len() / 2, f64::total_cmp).1;
            if (height - median).abs() >= limit {
                call(index);
            }
        }
    }
}
