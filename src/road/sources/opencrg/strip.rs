//! The strip of an OpenCRG road that a tyre rolls on.
//!
//! 1. Columns complete along the whole road are usable; if these are not wide enough together, columns that lack at
//!    most a tenth of their heights are usable, too, and interpolated along.
//! 2. The tyre's middle is at `lateral_position`, by default in the middle of the widest run of usable columns.
//! 3. Columns within the strip, and some beside it for the interpolation, become a height map; uneven columns are first
//!    interpolated linearly to their smallest spacing.

use super::file::Crg;
use crate::numeric::windowed_sinc::WindowedSinc;
use crate::road::error::RoadError;
use crate::road::lattice::same;
use crate::road::report::{RoadNote, RoadReport};
use crate::road::sources::height_map::{self, RoadHeightMap, fill_missing};
use crate::road::texture::HeightOrigin;
use crate::scene::{OpenCrgRoad, Widen};

/// Largest part of a column's heights that is interpolated.
const MISSING_ALLOWED: f64 = 0.1;

/// Reads a file and cuts the strip of `contact_width` \[m\].
///
/// # Errors
/// As [`Crg::read`]; no usable columns of the strip's width, or a position that leaves them.
pub(crate) fn read(
    spec: &OpenCrgRoad,
    contact_width: f64,
    limit: u64,
    report: &mut RoadReport,
) -> Result<RoadHeightMap, RoadError> {
    let crg = Crg::read(&spec.file, limit, spec.missing.as_deref())?;
    report.notes.extend(crg.notes.iter().cloned());
    cut(&crg, spec, contact_width, report)
}

fn cut(crg: &Crg, spec: &OpenCrgRoad, contact_width: f64, report: &mut RoadReport) -> Result<RoadHeightMap, RoadError> {
    let path = &spec.file;
    let columns = crg.v.len();
    let missing: Vec<usize> = (0..columns)
        .map(|column| crg.grid.iter().skip(column).step_by(columns).filter(|height| height.is_nan()).count())
        .collect();
    let allowed = (MISSING_ALLOWED * crg.rows() as f64) as usize;
    let needed = contact_width * (1.0 - 1e-9);
    // Step 1. Indices of the first and last column of the run that holds the strip, and of the widest run.
    let mut narrow = None;
    let mut found = None;
    for most in [0, allowed] {
        for run in runs(&missing, most) {
            let (from, to) = (crg.v[run.0], crg.v[run.1]);
            let holds = match spec.lateral_position {
                Some(v) => v - 0.5 * needed >= from && v + 0.5 * needed <= to,
                None => to - from >= needed,
            };
            let width = |run: (usize, usize)| crg.v[run.1] - crg.v[run.0];
            if holds && found.is_none_or(|best| width(run) > width(best)) {
                found = Some(run);
            }
            if narrow.is_none_or(|best| width(run) > width(best)) {
                narrow = Some(run);
            }
        }
        if found.is_some() {
            break;
        }
    }
    if found.is_none() && spec.widen == Widen::Mirror {
        let inside = |run: &(usize, usize)| {
            run.0 < run.1 && spec.lateral_position.is_none_or(|v| (crg.v[run.0]..=crg.v[run.1]).contains(&v))
        };
        found = narrow.filter(inside);
        let mirrored =
            |run: (usize, usize)| RoadNote::Mirrored { measured: crg.v[run.1] - crg.v[run.0], needed: contact_width };
        report.notes.extend(found.map(mirrored));
    }
    let Some((first, last)) = found else {
        let (from, to) = narrow.map_or((0.0, 0.0), |run| (crg.v[run.0], crg.v[run.1]));
        return Err(match spec.lateral_position {
            Some(position) => {
                RoadError::LateralPosition { path: path.clone(), position, width: contact_width, available: (from, to) }
            }
            None => RoadError::Narrow { path: path.clone(), needed: contact_width, available: to - from },
        });
    };
    // Step 2.
    let middle = spec.lateral_position.unwrap_or(0.5 * (crg.v[first] + crg.v[last]));
    // Step 3.
    let spacing = crg.v[first..=last].windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let uneven = crg.v[first..=last].windows(2).any(|pair| (pair[1] - pair[0] - spacing).abs() > 1e-6 * spacing);
    // As many columns beside the strip as the interpolation reaches, if they exist.
    let beside = WindowedSinc::resampling().half_width * spacing.max(0.5 * contact_width);
    let from = crg.v[first..=last].partition_point(|&v| v < middle - 0.5 * contact_width - beside) + first;
    let to = crg.v[first..=last].partition_point(|&v| v <= middle + 0.5 * contact_width + beside) + first - 1;
    let v = &crg.v[from..=to];
    let mut heights: Vec<f64> = (0..crg.rows())
        .flat_map(|row| (from..=to).map(move |column| (row, column)))
        .map(|(row, column)| crg.elevation(row, column))
        .collect();
    let origins = height_map::origins(&heights);
    fill_missing(path, &mut heights, v.len(), MISSING_ALLOWED, &mut report.notes)?;
    report.points = crg.grid.len();
    report.missing = missing.iter().sum();
    let half = 0.5 * contact_width + 1e-9;
    report.notes.push(RoadNote::Columns {
        total: columns,
        used: v.iter().filter(|&&v| (v - middle).abs() <= half).count(),
        incomplete: missing.iter().filter(|&&count| count > 0).count(),
        missing_points: report.missing,
        total_points: report.points,
        lateral_position: middle,
    });
    let mut map = RoadHeightMap {
        path: path.clone(),
        dx: crg.increment,
        dy: spacing,
        first_y: v[0] - middle,
        columns: v.len(),
        heights,
        origins,
    };
    if uneven {
        map = even(&map, v, middle);
        report.notes.push(RoadNote::UnevenColumns { spacing });
    }
    Ok(map)
}

/// First and last column of every run of columns with at most `most` missing heights.
fn runs(missing: &[usize], most: usize) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (column, _) in missing.iter().enumerate().filter(|&(_, &count)| count <= most) {
        match runs.last_mut() {
            Some(run) if run.1 + 1 == column => run.1 = column,
            _ => runs.push((column, column)),
        }
    }
    runs
}

/// The map whose columns are at `v`, interpolated linearly to its even `dy`.
fn even(map: &RoadHeightMap, v: &[f64], middle: f64) -> RoadHeightMap {
    let width = v[v.len() - 1] - v[0];
    let intervals = (width / map.dy * (1.0 + 1e-9)).floor().max(1.0);
    let dy = if same(intervals * map.dy, width) { map.dy } else { width / intervals };
    let columns = intervals as usize + 1;
    let place = |column: usize| {
        let place = v[0] + column as f64 * dy;
        let above = v.partition_point(|&v| v <= place).clamp(1, v.len() - 1);
        (above, ((place - v[above - 1]) / (v[above] - v[above - 1])).min(1.0))
    };
    let between = |row: &[f64], (above, part): (usize, f64)| row[above - 1] + part * (row[above] - row[above - 1]);
    let rows = map.heights.chunks_exact(map.columns);
    let heights = rows.flat_map(|row| (0..columns).map(move |column| between(row, place(column)))).collect();
    // An interpolated height counts as measured only if both of its neighbours were.
    let worse = |row: &[HeightOrigin], (above, _): (usize, f64)| match row[above - 1] {
        HeightOrigin::Measured => row[above],
        other => other,
    };
    let rows = map.origins.chunks_exact(map.columns);
    let origins = rows.flat_map(|row| (0..columns).map(move |column| worse(row, place(column)))).collect();
    RoadHeightMap { path: map.path.clone(), dx: map.dx, dy, first_y: v[0] - middle, columns, heights, origins }
}
