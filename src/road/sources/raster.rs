//! Height maps as text: clouds of points x, y, z on a grid, and ESRI ASCII grids.
//!
//! Both have x along the road and y across; what is not on their grid is refused, what is missing is NaN. A cloud's
//! points may stand in any order; its spacings are means of the usual steps between its different x and y.

use std::collections::BTreeMap;
use std::path::Path;

use super::columns::Fault;
use super::missing::is_word_for_none;
use super::signature::refuse_unreadable;
use super::table::Layout;
use super::titles::{ACROSS, DISTANCE, HEIGHT, Role};
use crate::road::error::RoadError;
use crate::road::file_fault::FileFault;
use crate::scene::{GridRoad, LengthUnit};
use crate::storage::input::excerpt;
use crate::storage::separated::{self, SeparatedTable};

/// Largest distance of a point from its place on the grid, in spacings.
const OFF_GRID: f64 = 0.2;
/// Coordinates that differ by less than this part of their range are the same.
const SAME: f64 = 1e-6;
/// Steps that differ by less than this share from the usual one differ by rounding.
const ROUNDED: f64 = 0.25;
/// Places of a grid for each point at most: most heights would be invented.
const MOST_PLACES: f64 = 2.0;

/// Heights on a grid, rows along x, columns across in the order of y.
#[derive(Debug)]
pub(super) struct HeightRaster {
    pub(super) dx: f64,
    pub(super) dy: f64,
    pub(super) columns: usize,
    /// Row-major heights \[m\]; NaN if missing.
    pub(super) heights: Vec<f64>,
    /// The file's unit of heights in metres.
    pub(super) unit: f64,
    /// Words that marked missing heights, and how often.
    pub(super) words: BTreeMap<String, usize>,
    /// Description of the columns or the grid read.
    pub(super) described: Option<String>,
}

/// Reads a grid given as text.
///
/// # Errors
/// For text that is neither kind of grid; units that are not stated; points off the grid; invalid numbers, with their
/// line.
pub(super) fn read(spec: &GridRoad, bytes: &[u8]) -> Result<HeightRaster, RoadError> {
    let path: &Path = &spec.file;
    refuse_unreadable(bytes).map_err(|fault| RoadError::file(path, fault))?;
    let text = separated::decoded(bytes);
    let is_esri = text.trim_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case("ncols"));
    let raster = if is_esri { esri(&text, spec) } else { cloud(bytes, spec) };
    raster.map_err(|fault| fault.at(path))
}

/// Reads x, y and z in each line.
fn cloud(bytes: &[u8], spec: &GridRoad) -> Result<HeightRaster, Fault> {
    // 1. Columns and points.
    let table = SeparatedTable::of(bytes);
    let layout = Layout::of(&table, 3)?;
    let roles: [Role; 3] = [DISTANCE, ACROSS, HEIGHT];
    let units = [spec.distance_unit, spec.distance_unit, spec.height_unit];
    let mut used = layout.columns(&table, roles, units, spec.columns.as_deref())?;
    used.missing = spec.missing.clone();
    let points: Vec<(u64, [f64; 3])> = layout.values(&table, &mut used).collect::<Result<_, _>>()?;
    // 2. The axes: usual steps between the coordinates.
    let axis = |axis: usize| Axis::of(points.iter().map(|(_, point)| point[axis]).collect(), roles[axis].name);
    let (along, across) = (axis(0)?, axis(1)?);
    let places = along.count * across.count;
    if places > MOST_PLACES * points.len() as f64 {
        return Err(FileFault::Scattered { points: points.len(), places }.into());
    }
    let columns = across.count as usize;
    // 3. Every point to its place.
    let mut heights = vec![f64::NAN; places as usize];
    let mut lines = vec![0_u64; places as usize];
    for &(line, [x, y, height]) in &points {
        let place = along.place(x, line)? * columns + across.place(y, line)?;
        if lines[place] > 0 {
            return Err(FileFault::SamePlace { line, other: lines[place] }.into());
        }
        (heights[place], lines[place]) = (height, line);
    }
    let (dx, dy, described) = (along.step, across.step, Some(used.described()));
    Ok(HeightRaster { dx, dy, columns, heights, unit: used.unit(), words: used.words, described })
}

/// Evenly spaced positions on a line \[m\].
struct Axis {
    first: f64,
    step: f64,
    /// A whole number.
    count: f64,
    name: &'static str,
}

impl Axis {
    fn of(mut places: Vec<f64>, name: &'static str) -> Result<Self, FileFault> {
        places.sort_by(f64::total_cmp);
        let (Some(&first), Some(&last)) = (places.first(), places.last()) else {
            return Err(FileFault::TooFewPoints { found: 0, needed: 2 });
        };
        let same = SAME * (last - first);
        let mut steps: Vec<f64> = places.windows(2).map(|pair| pair[1] - pair[0]).filter(|&step| step > same).collect();
        if steps.is_empty() {
            return Err(FileFault::OneLine { name });
        }
        let middle = steps.len() / 2;
        let usual = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
        let alike = steps.iter().filter(|&&step| (step - usual).abs() <= ROUNDED * usual);
        let (sum, count) = alike.fold((0.0, 0.0), |(sum, count), step| (sum + step, count + 1.0));
        let intervals = ((last - first) * count / sum).round().max(1.0);
        Ok(Self { first, step: (last - first) / intervals, count: intervals + 1.0, name })
    }

    /// Index of a position on the line; an error if it is off the grid.
    fn place(&self, at: f64, line: u64) -> Result<usize, FileFault> {
        let place = (at - self.first) / self.step;
        if (place - place.round()).abs() > OFF_GRID {
            return Err(FileFault::OffGrid { line, name: self.name, at, step: self.step });
        }
        Ok(place.round() as usize)
    }
}

/// Reads an ESRI grid: a header of keys and values, then rows from the highest y down; x is along the road.
fn esri(text: &str, spec: &GridRoad) -> Result<HeightRaster, Fault> {
    let unit = |unit: Option<LengthUnit>, key| unit.map(LengthUnit::metres).ok_or(Fault::Unit(key));
    // 1. Header.
    let mut header = BTreeMap::new();
    let mut lines = (1_u64..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty()).peekable();
    while let Some((line, text)) = lines.next_if(|(_, line)| line.trim_start().starts_with(char::is_alphabetic)) {
        let mut words = text.split_whitespace();
        let (key, value) = (words.next().unwrap_or_default().to_lowercase(), words.next().unwrap_or_default());
        let number = separated::any_number(value).or(is_word_for_none(value, None).then_some(f64::NAN));
        let Some(number) = number else {
            return Err(FileFault::HeaderNumber { line: line as usize, key, found: excerpt(value) }.into());
        };
        header.insert(key, number);
    }
    let given = |key: &str| header.get(key).copied();
    let needed = |key: &'static str| given(key).ok_or(FileFault::Missing { what: key });
    let size = |key: &'static str, what: &'static str| match needed(key)? {
        value if value >= 2.0 && value.fract() == 0.0 => Ok(value),
        value => Err(FileFault::NotPositive { what, value }),
    };
    let (rows, columns) = (size("ncols", "ncols")?, size("nrows", "nrows")?);
    let step = |key: &'static str| given(key).map_or_else(|| needed("cellsize"), Ok);
    let metres = unit(spec.distance_unit, "distance_unit")?;
    let (dx, dy) = (step("dx")? * metres, step("dy")? * metres);
    let unit = unit(spec.height_unit, "height_unit")?;
    let none = given("nodata_value");
    // Each number has a digit and a separator: a larger promise is refused before memory is allocated.
    let places = rows * columns;
    if places > text.len() as f64 {
        return Err(FileFault::Rows { expected: columns as u64, found: 0 }.into());
    }
    let (rows, columns) = (rows as usize, columns as usize);
    // 2. Numbers: the file's rows are our columns, the highest y first.
    let mut heights = vec![f64::NAN; rows * columns];
    let (mut found, mut words_for_none) = (0, BTreeMap::new());
    for (line, text) in lines {
        for (column, word) in (1..).zip(text.split_whitespace()) {
            let number = separated::any_number(word);
            if number.is_none() {
                if !is_word_for_none(word, spec.missing.as_deref()) {
                    return Err(FileFault::NotANumber { line, column, role: "height", found: excerpt(word) }.into());
                }
                *words_for_none.entry(word.to_owned()).or_default() += 1;
            }
            if found < heights.len() {
                let (y, x) = (columns - 1 - found / rows, found % rows);
                heights[x * columns + y] = number.filter(|&number| Some(number) != none).map_or(f64::NAN, |z| z * unit);
            }
            found += 1;
        }
    }
    if found != heights.len() {
        return Err(FileFault::Rows { expected: columns as u64, found: (found / rows) as u64 }.into());
    }
    let described = Some(format!("an ESRI grid, its {rows} columns along the road, its {columns} rows across"));
    Ok(HeightRaster { dx, dy, columns, heights, unit, words: words_for_none, described })
}
