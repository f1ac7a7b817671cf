//! An OpenCRG road in memory: includes followed, grid assembled, slopes integrated.
//!
//! 1. Read the header; where it names another file (`$ROAD_CRG_FILE`, inside the scene's folder only), take data and
//!    parameters from there and modifiers from the outermost file that has a section of them.
//! 2. Number of rows round((u_end - u_start)/increment) + 1, lateral positions from the channels or from right, left,
//!    increment.
//! 3. z = grid + integrated slope + banking(u) v at the grid's points.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::data::{ABSURD, decode};
use super::header::{CrgChannel, CrgFormat, Header};
use crate::road::error::RoadError;
use crate::road::file_fault::{FileFault, LikelyCause};
use crate::road::report::RoadNote;
use crate::road::sources::height_map::{LARGEST_SPACING, plausible_spacing};
use crate::road::sources::missing;
use crate::road::sources::signature::refuse_other_kinds;
use crate::scene::MissingHeight;
use crate::storage::input;

/// Longest chain of includes.
const DEEPEST: usize = 8;

/// The elevations of an OpenCRG road.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Crg {
    /// Row spacing \[m\].
    pub increment: f64,
    /// Lateral positions of the columns, rising \[m\].
    pub v: Vec<f64>,
    /// Row-major grid elevations \[m\], rows x v.len(); NaN where missing.
    pub grid: Vec<f64>,
    /// Elevation of the reference line at each row \[m\]: start and integrated slope.
    pub line: Vec<f64>,
    /// Cross slope at each row.
    pub banking: Vec<f64>,
    /// Information for the report.
    pub notes: Vec<RoadNote>,
}

/// The file at the end of a chain of includes, which contains the data.
struct Last {
    path: PathBuf,
    header: Header,
    bytes: Vec<u8>,
}

/// Follows a chain of includes to its end; `pass` is called for each file, the last one included.
fn follow(path: &Path, limit: u64, mut pass: impl FnMut(&Path, &Header)) -> Result<Last, RoadError> {
    let mut chain: Vec<PathBuf> = Vec::new();
    let mut current = path.to_owned();
    let mut root = None;
    loop {
        let fault = |fault| RoadError::file(&current, fault);
        let bytes = input::read(&current, limit).map_err(|error| fault(error.into()))?;
        refuse_other_kinds(&bytes, "opencrg").map_err(fault)?;
        let header = Header::parse(&bytes).map_err(fault)?;
        pass(&current, &header);
        let Some(name) = &header.include else { return Ok(Last { path: current, header, bytes }) };
        let canonical = |path: &Path| {
            path.canonicalize().map_err(|source| fault(FileFault::Include { path: path.to_owned(), source }))
        };
        let here = canonical(&current)?;
        let folder = here.parent().unwrap_or(Path::new("/")).to_owned();
        let root = root.get_or_insert_with(|| folder.clone());
        let next = canonical(&folder.join(name))?;
        // Links are resolved on both sides: the real location counts.
        if !next.starts_with(&*root) {
            return Err(fault(FileFault::IncludeOutside { path: PathBuf::from(name), folder: root.clone() }));
        }
        chain.push(here);
        if chain.contains(&next) || chain.len() > DEEPEST {
            return Err(fault(FileFault::IncludeCycle { path: PathBuf::from(name) }));
        }
        current = next;
    }
}

/// Files that a file includes, directly or through others, as far as they can be followed.
pub(crate) fn included(path: &Path, limit: u64) -> Vec<PathBuf> {
    let mut files = Vec::new();
    // A fault is reported when the road is read.
    let _ = follow(path, limit, |file, _| files.push(file.to_owned()));
    files.split_off(1.min(files.len()))
}

impl Crg {
    /// Reads a file and what it includes. `limit` bounds the bytes of one file; `missing`: elevations in the file that
    /// mark missing ones.
    ///
    /// # Errors
    /// A file that cannot be read, includes from outside the file's folder, and every [`FileFault`] of OpenCRG.
    pub(crate) fn read(path: &Path, limit: u64, missing: Option<&[MissingHeight]>) -> Result<Self, RoadError> {
        let mut modifiers = None;
        let last = follow(path, limit, |_, header| modifiers = modifiers.take().or_else(|| header.modifiers.clone()))?;
        let Last { path, header, bytes } = last;
        Self::assemble(&header, &bytes, modifiers.unwrap_or_default(), missing)
            .map_err(|fault| RoadError::file(&path, fault))
    }

    /// Assembles the road from a header and the bytes of the whole file.
    fn assemble(
        header: &Header,
        bytes: &[u8],
        modifiers: BTreeMap<String, f64>,
        missing: Option<&[MissingHeight]>,
    ) -> Result<Self, FileFault> {
        let (offset, first_line) = header.data.ok_or(FileFault::NoData)?;
        if header.channels.is_empty() {
            return Err(FileFault::Missing { what: "data channels (D: lines in $KD_DEFINITION)" });
        }
        let key = |name: &str| header.road.get(name).copied();
        let start_u = key("reference_line_start_u").unwrap_or(0.0);
        let (increment, promised) = rows(key, start_u)?;
        let channels = header.channels.len();
        let format = header.format.unwrap_or(CrgFormat { aligned: false, double: false, text: false });
        let data = decode(&bytes[offset..], format, channels, promised, first_line)?;
        let rows = data.len() / channels;
        if rows < 2 {
            return Err(FileFault::Rows { expected: 2, found: rows as u64 });
        }
        let (v, columns) = lateral(header, key)?;
        let scale = |name: &str| modifiers.get(name).copied().unwrap_or(1.0);
        let column = |wanted: CrgChannel| {
            let place = header.channels.iter().position(|(channel, _)| *channel == wanted)?;
            Some(data.iter().skip(place).step_by(channels).copied().collect::<Vec<f64>>())
        };
        // Values complete from row `from` on, or the constant that the header gives for the start.
        let along = |wanted: CrgChannel, from: usize, name: &'static str, start: &str| match column(wanted) {
            Some(values) => match values[from..].iter().position(|value| value.is_nan()) {
                Some(row) => Err(FileFault::ReferenceLineHole { row: row + from, channel: name }),
                None => Ok(values),
            },
            None => Ok(vec![key(start).unwrap_or(0.0); rows]),
        };
        let slope = along(CrgChannel::Slope, 1, "reference line slope", "reference_line_start_s")?;
        let banking = along(CrgChannel::Banking, 0, "reference line banking", "reference_line_start_b")?;
        // The course of the line has no effect on heights, but a hole is damage. The first heading may be given as the
        // start's.
        if let Some(heading) = column(CrgChannel::Heading)
            && let Some(row) = heading[1..].iter().position(|heading| heading.is_nan())
        {
            let row = if row == 0 && key("reference_line_start_phi").is_none() { 0 } else { row + 1 };
            return Err(FileFault::ReferenceLineHole { row, channel: "reference line phi" });
        }
        let mut line = vec![key("reference_line_start_z").unwrap_or(0.0); rows];
        for row in 1..rows {
            line[row] = line[row - 1] + increment * slope[row] * scale("scale_slope");
        }
        let mut road = Self {
            increment: increment * scale("scale_length"),
            v: v.iter().map(|v| v * scale("scale_width")).collect(),
            grid: data.chunks_exact(channels).flat_map(|row| columns.iter().map(|&c| row[c])).collect(),
            line,
            banking: banking.iter().map(|banking| banking * scale("scale_banking")).collect(),
            notes: Vec::new(),
        };
        let columns = road.v.len();
        missing::mark(&mut road.grid, columns, |row| row as f64 * increment, 1.0, missing, &mut road.notes)?;
        road.apply(&modifiers);
        road.check()?;
        for (unknown, name) in &header.channels {
            if *unknown == CrgChannel::Unknown {
                road.notes.push(RoadNote::Ignored { key: format!("data channel {name:?}") });
            }
        }
        Ok(road)
    }

    /// Refuses impossible roads after all scaling: columns without width, elevations beyond all bounds.
    fn check(&self) -> Result<(), FileFault> {
        let narrowest = self.v.windows(2).map(|pair| pair[1] - pair[0]).fold(self.increment, f64::min);
        plausible_spacing(narrowest, LARGEST_SPACING)?;
        plausible_spacing(self.increment, LARGEST_SPACING)?;
        for (row, line) in self.grid.chunks_exact(self.v.len()).enumerate() {
            for (column, height) in line.iter().enumerate().filter(|(_, height)| !height.is_nan()) {
                let value = self.elevation(row, column);
                // Neither the sum nor the grid's part may be beyond the bounds, even if parts cancel.
                if !(value.abs() <= ABSURD && height.abs() <= ABSURD) {
                    return Err(FileFault::Absurd { row, channel: column + 1, value, hint: LikelyCause::Unknown });
                }
            }
        }
        Ok(())
    }

    /// Applies the modifiers for elevations and missing values.
    fn apply(&mut self, modifiers: &BTreeMap<String, f64>) {
        let value = |name: &str| modifiers.get(name).copied();
        let scale = value("scale_z_grid").unwrap_or(1.0);
        for height in &mut self.grid {
            *height *= scale;
        }
        let count = self.grid.iter().filter(|height| height.is_nan()).count();
        let offset = value("grid_nan_offset").unwrap_or(0.0);
        // Mode 0 keeps, 1 sets zero, 2 holds the nearest value across. Without a mode missing values are kept: texture
        // needs measured points only.
        let mode = value("grid_nan_mode").unwrap_or(0.0).round() as i64;
        if count > 0 && (mode == 1 || mode == 2) {
            let holes: Vec<usize> = (0..self.grid.len()).filter(|&index| self.grid[index].is_nan()).collect();
            for row in self.grid.chunks_exact_mut(self.v.len()) {
                if mode == 2 {
                    fill_nearest(row)
                } else {
                    row.iter_mut().filter(|height| height.is_nan()).for_each(|height| *height = 0.0)
                }
            }
            for index in holes {
                self.grid[index] += offset;
            }
            self.notes
                .push(RoadNote::MissingByModifier { count, mode: if mode == 1 { "zero" } else { "nearest across" } });
        }
        let known = [
            "scale_z_grid",
            "scale_slope",
            "scale_banking",
            "scale_length",
            "scale_width",
            "grid_nan_mode",
            "grid_nan_offset",
        ];
        for key in modifiers.keys().filter(|key| !known.contains(&key.as_str())) {
            self.notes.push(RoadNote::Ignored { key: format!("$ROAD_CRG_MODS {key}") });
        }
    }

    pub(crate) fn rows(&self) -> usize {
        self.line.len()
    }

    /// Elevation of the grid point (row, column) with slope and banking \[m\]; NaN if missing.
    pub(crate) fn elevation(&self, row: usize, column: usize) -> f64 {
        self.grid[row * self.v.len() + column] + self.line[row] + self.banking[row] * self.v[column]
    }
}

/// Fills missing values with the nearest valid one; a row without any becomes zero.
fn fill_nearest(row: &mut [f64]) {
    let valid: Vec<usize> = (0..row.len()).filter(|&column| !row[column].is_nan()).collect();
    if valid.is_empty() {
        row.fill(0.0);
    }
    for column in 0..row.len() {
        let nearest = valid.iter().min_by_key(|&&other| other.abs_diff(column));
        if let (true, Some(&nearest)) = (row[column].is_nan(), nearest) {
            row[column] = row[nearest];
        }
    }
}

/// The increment of u and, if the end is given, the number of rows.
fn rows(key: impl Fn(&str) -> Option<f64>, start: f64) -> Result<(f64, Option<u64>), FileFault> {
    let increment = key("reference_line_increment").ok_or(FileFault::Missing { what: "reference_line_increment" })?;
    if !(increment > 0.0 && increment.is_finite()) {
        return Err(FileFault::NotPositive { what: "reference_line_increment", value: increment });
    }
    let Some(end) = key("reference_line_end_u") else { return Ok((increment, None)) };
    let intervals = (end - start) / increment;
    let whole = intervals.round();
    if !(1.0..1e12).contains(&whole) || (intervals - whole).abs() >= 0.01 {
        return Err(FileFault::RowCount { start, end, increment });
    }
    Ok((increment, Some(whole as u64 + 1)))
}

/// The lateral positions, rising, and the channels that contain their elevations.
fn lateral(header: &Header, key: impl Fn(&str) -> Option<f64>) -> Result<(Vec<f64>, Vec<usize>), FileFault> {
    // 1. Sections by number or by position, not mixed, without gaps and repetitions.
    let mut sections: Vec<(f64, usize)> = Vec::new();
    let (mut by_number, mut by_position) = (false, false);
    for (index, (channel, _)) in header.channels.iter().enumerate() {
        match *channel {
            CrgChannel::Numbered(number) => {
                by_number = true;
                sections.push((number as f64, index));
            }
            CrgChannel::At(v) => {
                by_position = true;
                sections.push((v, index));
            }
            _ => {}
        }
    }
    let found = sections.len();
    if found == 0 {
        return Err(FileFault::Missing { what: "longitudinal sections (D:long section ... in $KD_DEFINITION)" });
    }
    sections.sort_by(|a, b| a.0.total_cmp(&b.0));
    let repeated = sections.windows(2).any(|pair| pair[1].0 <= pair[0].0);
    let gapless = sections.iter().enumerate().all(|(index, section)| section.0.round() as usize == index + 1);
    if (by_number && by_position) || repeated || (by_number && !gapless) {
        return Err(FileFault::Sections { sections: found });
    }
    let (mut v, columns): (Vec<f64>, Vec<usize>) = sections.into_iter().unzip();
    // 2. Positions of numbered sections from right, left and increment, of which some may lack.
    if by_number {
        let (right, left, given) =
            (key("long_section_v_right"), key("long_section_v_left"), key("long_section_v_increment"));
        let last = (found - 1) as f64;
        let increment = match (given, right, left) {
            (Some(increment), ..) => increment,
            (None, Some(right), Some(left)) if found > 1 => (left - right) / last,
            _ if found == 1 => 1.0,
            _ => return Err(FileFault::Missing { what: "long_section_v_increment" }),
        };
        if !(increment > 0.0 && increment.is_finite()) {
            return Err(FileFault::NotPositive { what: "long_section_v_increment", value: increment });
        }
        if let (Some(right), Some(left)) = (right, left) {
            let expected = (left - right) / increment + 1.0;
            if (expected - found as f64).abs() > 0.01 {
                return Err(FileFault::SectionCount { right, left, increment, expected, found });
            }
        }
        let first = right.or(left.map(|left| left - last * increment)).unwrap_or(-0.5 * last * increment);
        v = (0..found).map(|index| first + index as f64 * increment).collect();
    }
    Ok((v, columns))
}
