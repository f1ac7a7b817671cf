//! Long grids in arrays, read in pieces: memory does not grow with the road.
//!
//! 1. Opening reads all pieces, for the plane that is subtracted and the counts of what is missing or a spike; without
//!    these they are read once more, for the highest point and the spectrum ([`crate::road::piece_rows`]).
//! 2. Then piece after piece is read as the run needs it, each the same whenever it is read. A piece is treated with a
//!    margin at either end: spikes, missing heights and long waves depend on no heights beyond it.
//!
//! Differences from reading a grid as a whole: a number that seems to stand for missing heights has to be named, and
//! heights that look rounded or cut off are noted in the first piece alone.

use super::conditioning::{drop_spikes, note_span, note_spikes};
use super::grid::{MISSING_ALLOWED, check_width, open, spacings};
use super::height_map::{
    LARGEST_SPACING_OF_TABLE, RoadHeightMap, check_smoothness, fill, note_missing, origins, plausible_spacing,
    plausible_span,
};
use super::{missing, rounded};
use crate::numeric::windowed_sinc::WindowedSinc;
use crate::road::error::{RoadError, positive};
use crate::road::file_fault::FileFault;
use crate::road::report::{RoadNote, RoadReport};
use crate::road::texture::{HeightOrigin, line_of};
use crate::scene::{GridRoad, LengthUnit, Levelling};
use crate::storage::array::ArrayRows;

/// Grids of more bytes in memory are read in pieces, and how many bytes of heights a piece has, its margins apart.
pub(crate) const LONG_GRID: [u64; 2] = [200_000_000, 16_000_000];
/// Pieces in memory together: those kept for the contact and for the profiles, and two that are being made.
const IN_MEMORY: u64 = 6;
/// Least margin of a piece \[m\]: ten times the surroundings of a spike.
const MARGIN: f64 = 0.5;

/// A grid that is read in pieces. Clones share the file.
#[derive(Clone, Debug)]
pub(crate) struct GridStream {
    spec: GridRoad,
    array: ArrayRows,
    /// Spacings \[m\].
    dx: f64,
    dy: f64,
    /// Rows of a piece, and of its margins.
    piece: usize,
    margin: usize,
    /// Mean, and slopes per row and column, of the plane about the grid's middle.
    plane: [f64; 3],
}

/// Sums over a grid as read.
#[derive(Default)]
struct Sums {
    /// Sums of the rows' means, and of these times the row's distance from the middle.
    along: [f64; 2],
    /// Means by column.
    across: Vec<f64>,
    missing: usize,
    /// Numbers that the scene names for missing heights, and how often each occurs.
    named: Vec<(f64, usize)>,
    spikes: usize,
    lowest: f64,
    highest: f64,
}

impl GridStream {
    /// Opens a grid for reading in pieces; `None` for one that is short, or not stored row by row. Sizes in bytes are
    /// those of [`LONG_GRID`], and the limit of all pieces in memory.
    ///
    /// # Errors
    /// Those of a grid that is read whole; [`FileFault::StandsForNone`] for a number that has to be named.
    pub(crate) fn open(
        spec: &GridRoad,
        contact_width: f64,
        ([long, piece], limit): ([u64; 2], u64),
        report: &mut RoadReport,
    ) -> Result<Option<Self>, RoadError> {
        if !spec.is_array() {
            return Ok(None);
        }
        let path = &spec.file;
        let fault = |fault| RoadError::file(path, fault);
        let ((dx, dy), (array, (rows, columns))) = (spacings(spec)?, open(spec)?);
        let bytes_of_row = 8 * columns as u64;
        let is_long = (rows as u64).saturating_mul(bytes_of_row) > long.min(limit);
        if !is_long {
            return Ok(None);
        }
        let Some(array) = array.into_rows(path).map_err(|error| fault(error.into()))? else { return Ok(None) };
        let plausible = |spacing| plausible_spacing(spacing, LARGEST_SPACING_OF_TABLE).map_err(fault);
        [dx, dy].into_iter().try_for_each(plausible)?;
        check_width(spec, columns as f64 * dy, contact_width, &mut report.notes)?;
        // Waves are removed by a kernel of so many rows to either side, see `RoadHeightMap::remove_trend`.
        let longest = spec.longest_wavelength.unwrap_or(0.0);
        let margin = (MARGIN + 0.4 * longest * WindowedSinc::resampling().half_width) / dx + 1.0;
        let margin = margin.ceil() as usize;
        let piece = (piece / bytes_of_row.max(1)).max(1) as usize;
        let piece = piece.max(margin).max(8);
        let needed = IN_MEMORY * ((piece + 2 * margin) as u64).saturating_mul(bytes_of_row);
        if needed > limit {
            return Err(fault(FileFault::TooLarge { needed, limit }));
        }
        let mut stream = Self { spec: spec.clone(), array, dx, dy, piece, margin, plane: [0.0; 3] };
        stream.survey(report)?;
        Ok(Some(stream))
    }

    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.array.rows
    }

    /// Rows of a piece.
    pub(crate) fn rows_of_piece(&self) -> usize {
        self.piece
    }

    /// Spacing of the rows \[m\].
    pub(crate) fn spacing(&self) -> f64 {
        self.dx
    }

    /// Spacing of the columns \[m\].
    pub(crate) fn lateral_spacing(&self) -> f64 {
        self.dy
    }

    /// Number of pieces.
    pub(crate) fn pieces(&self) -> usize {
        self.rows().div_ceil(self.piece)
    }

    /// The rows of a piece, from 0, without margins, with all that is removed from the heights.
    ///
    /// # Errors
    /// Errors of the file.
    pub(crate) fn piece(&self, number: usize) -> Result<RoadHeightMap, RoadError> {
        let columns = self.array.columns;
        // Numbers that stand for missing heights are known by now: none, or those that are named.
        let named = self.spec.missing.as_deref().unwrap_or_default();
        let (mut map, before) = self.read(number, |heights, _| {
            let place = |row: usize| row as f64 * self.dx;
            missing::mark(heights, columns, place, self.unit(), Some(named), &mut Vec::new())
        })?;
        let first = number * self.piece;
        let [mean, along, across] = self.plane;
        let middle = [self.rows(), columns].map(|count| 0.5 * (count as f64 - 1.0));
        for (row, heights) in map.heights.chunks_exact_mut(columns).enumerate() {
            let level = mean + along * ((first + row) as f64 - before as f64 - middle[0]);
            for (column, height) in heights.iter_mut().enumerate() {
                *height -= level + across * (column as f64 - middle[1]);
            }
        }
        if let Some(longest) = self.spec.longest_wavelength {
            map.remove_trend(longest)?;
        }
        let inner = before..before + self.rows_in(number);
        map.heights = map.heights[inner.start * columns..inner.end * columns].to_vec();
        map.origins.clear();
        Ok(map)
    }

    /// Notes what the heights are once all is removed, by their span and root mean square \[m\].
    ///
    /// # Errors
    /// Heights that no texture has.
    pub(crate) fn check(&self, span: f64, rms: f64, report: &mut RoadReport) -> Result<(), RoadError> {
        note_span(plausible_span(&self.spec.file, span)?, &mut report.notes);
        check_smoothness(&self.spec.file, rms, self.spec.level == Levelling::Off, &mut report.notes)
    }

    fn unit(&self) -> f64 {
        self.spec.height_unit.map_or(1.0, LengthUnit::metres)
    }

    /// Rows of a piece, which the last one has fewer of.
    fn rows_in(&self, number: usize) -> usize {
        self.piece.min(self.rows() - number * self.piece)
    }

    /// Reads a piece with its margins, without missing heights and spikes; also returns the rows of its first margin.
    fn read(
        &self,
        number: usize,
        mark: impl FnOnce(&mut [f64], usize) -> Result<(), FileFault>,
    ) -> Result<(RoadHeightMap, usize), RoadError> {
        let (path, columns) = (&self.spec.file, self.array.columns);
        let first = number * self.piece;
        let from = first.saturating_sub(self.margin);
        let to = (first + self.rows_in(number) + self.margin).min(self.rows());
        let mut heights = self.array.read(from..to).map_err(|error| RoadError::file(path, error))?;
        if let Some(place) = heights.iter().position(|height| height.is_infinite()) {
            let (row, column) = (from + place / columns, place % columns);
            return Err(RoadError::file(path, FileFault::Infinite { row, column, value: heights[place] }));
        }
        let unit = self.unit();
        heights.iter_mut().for_each(|height| *height *= unit);
        mark(&mut heights, first - from).map_err(|fault| RoadError::file(path, fault))?;
        let origins = origins(&heights);
        if !origins.is_empty() {
            fill(&mut heights, columns);
        }
        let first_y = -0.5 * (columns as f64 - 1.0) * self.dy;
        let (dx, dy) = (self.dx, self.dy);
        let mut map = RoadHeightMap { path: path.clone(), dx, dy, first_y, columns, heights, origins };
        drop_spikes(&mut map);
        Ok((map, first - from))
    }

    /// Reads the whole grid once, for the plane and the notes.
    fn survey(&mut self, report: &mut RoadReport) -> Result<(), RoadError> {
        let (rows, columns) = (self.rows(), self.array.columns);
        let (unit, dx, spec) = (self.unit(), self.dx, self.spec.clone());
        let path = &spec.file;
        let mut sums = Sums { across: vec![0.0; columns], lowest: f64::MAX, highest: f64::MIN, ..Sums::default() };
        for number in 0..self.pieces() {
            let (mut notes, count) = (Vec::new(), self.rows_in(number));
            let (map, before) = self.read(number, |heights, before| {
                let named = spec.missing.as_deref();
                let inner = &heights[before * columns..(before + count) * columns];
                let counts = missing::named_counts(inner, unit, named);
                sums.named.resize(counts.len(), (0.0, 0));
                sums.named.iter_mut().zip(counts).for_each(|(sum, (value, count))| *sum = (value, sum.1 + count));
                missing::mark(heights, columns, |row| row as f64 * dx, unit, named, &mut notes)?;
                let inner = &heights[before * columns..(before + count) * columns];
                sums.missing += inner.iter().filter(|height| height.is_nan()).count();
                for height in inner.iter().filter(|height| !height.is_nan()) {
                    (sums.lowest, sums.highest) = (sums.lowest.min(*height), sums.highest.max(*height));
                }
                if number == 0 {
                    rounded::add_notes(inner.iter().copied(), &mut report.notes);
                }
                // Only the whole grid could tell whether other pieces have it.
                let taken = notes.iter().find_map(|note| match note {
                    RoadNote::TakenForMissing { value, count } => Some((*value, *count)),
                    _ => None,
                });
                taken.map_or(Ok(()), |(value, count)| Err(FileFault::StandsForNone { value, count }))
            })?;
            for note in notes.into_iter().filter(|note| !matches!(note, RoadNote::NamedMissing { .. })) {
                if !report.notes.contains(&note) {
                    report.notes.push(note);
                }
            }
            let inner = before * columns..(before + count) * columns;
            let is_spike = |origin: &&HeightOrigin| **origin == HeightOrigin::Spike;
            sums.spikes += map.origins.get(inner.clone()).unwrap_or_default().iter().filter(is_spike).count();
            for (row, heights) in map.heights[inner].chunks_exact(columns).enumerate() {
                let mean = heights.iter().sum::<f64>() / columns as f64;
                let distance = (number * self.piece + row) as f64 - 0.5 * (rows as f64 - 1.0);
                sums.along = [sums.along[0] + mean, sums.along[1] + distance * mean];
                sums.across.iter_mut().zip(heights).for_each(|(sum, height)| *sum += height / rows as f64);
            }
        }
        let named = sums.named.iter().map(|&(value, count)| RoadNote::NamedMissing { value, count });
        report.notes.extend(named);
        let total = rows * columns;
        (report.points, report.missing) = (total, sums.missing);
        note_missing(path, [sums.missing, total], MISSING_ALLOWED, &mut report.notes)?;
        let as_read = plausible_span(path, sums.highest - sums.lowest);
        note_spikes(path, [sums.spikes, total], as_read, &mut report.notes)?;
        let inertia = rows as f64 * ((rows * rows) as f64 - 1.0) / 12.0;
        let [mean, along] = [sums.along[0] / rows as f64, sums.along[1] / inertia];
        let across = line_of(&sums.across).1;
        let note = match spec.level {
            Levelling::Slope => {
                self.plane = [mean, along, across];
                RoadNote::Levelled { mean, along: along / dx, across: Some(across / self.dy) }
            }
            Levelling::Mean => {
                self.plane = [mean, 0.0, 0.0];
                RoadNote::MeanRemoved { mean }
            }
            Levelling::Off => RoadNote::NotLevelled,
        };
        report.notes.push(note);
        if let Some(longest_wavelength) = spec.longest_wavelength {
            positive("road.longest_wavelength", longest_wavelength)?;
            report.notes.push(RoadNote::Detrended { longest_wavelength });
        }
        Ok(())
    }
}
