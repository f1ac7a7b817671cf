//! Depths of the tread's cells, which are fixed to its material and turn with it by whole columns.
//!
//! Cell (i, j) has its middle at x = (i + 1/2) dx from the beginning of the first pitch and at y_j from the tyre's
//! middle. It is a void if its middle is. A sipe is narrower than a cell and no void: it lies between two cells and
//! divides them.

use super::PatternFault;
use super::pitches::PitchTrain;
use super::raster::Raster;
use super::share::{GrooveBand, covered};
use crate::scene::sizes::MOST_TREAD_CELLS;
use crate::scene::{
    DEEPEST_VOID, Groove, LateralGroove, Pitches, RasterPeriod, Scene, TreadPattern, Zone, deepest_groove, short,
};

/// Least number of cells of a pitch.
const CELLS_OF_PITCH: usize = 4;
/// Relative error of the void ratio on cells that is accepted.
const VOID_OFF: f64 = 0.05;
/// Largest void ratio: lugs of tyres for deep soil have a fifth of the strip.
const MOST_VOID: f64 = 0.85;
/// Multiples of the cells, round the tyre and at most across, that are tried for an acceptable void ratio.
const FINER: [usize; 3] = [1, 2, 4];
/// Most lattices that are tried.
const TRIED: usize = 100;

/// Number of a cut between two cells that are no void; 0: none.
pub(crate) type Cut = u32;
/// Cuts of a raster are not numbered.
const UNNUMBERED: Cut = u32::MAX;

/// Depths of a tread by cell.
#[derive(Clone, Debug, PartialEq)]
pub struct TreadMap {
    /// Cells round the tyre.
    pub columns: usize,
    /// Cells across the strip.
    pub across: usize,
    /// Size of a cell along and across \[m\].
    pub size: [f64; 2],
    /// Depths below the uncut surface, cell (i, j) at i x across + j \[m\].
    pub depths: Vec<f64>,
    /// Number of the groove to which each void belongs.
    pub groove_of: Vec<Cut>,
    /// Sipe between a cell and the next along, and between a cell and the next across.
    pub sipes: [Vec<Cut>; 2],
    /// Ends of the sipes, each x and y \[m\].
    pub sipe_lines: Vec<[[f64; 2]; 2]>,
    /// Depth \[m\] of each cut by number, and tangent of its angle to the direction across.
    pub cuts: Vec<[f64; 2]>,
    /// Pitches, where the pattern has some.
    pub train: Option<PitchTrain>,
    /// Void ratio of the grooves as they are given, in contrast to that on cells.
    pub exact_void: f64,
}

/// Lattice of cells for which depths are wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TreadCells {
    /// Cells round the tyre.
    pub columns: usize,
    /// Cells across the strip.
    pub across: usize,
}

impl TreadMap {
    /// Map of given depths \[m\], column by column, whose cells are of 1 m and have no cuts.
    #[cfg(test)]
    pub(crate) fn of_depths(columns: usize, across: usize, depths: Vec<f64>) -> Self {
        let none = || vec![0; depths.len()];
        Self {
            columns,
            across,
            size: [1.0; 2],
            groove_of: none(),
            sipes: [none(), none()],
            sipe_lines: Vec::new(),
            cuts: vec![[0.0; 2]],
            train: None,
            exact_void: 0.0,
            depths,
        }
    }

    /// Map of a scene's pattern; an error if the cells cannot represent it, or a file is no raster.
    pub(crate) fn new(pattern: &TreadPattern, scene: &Scene, cells: TreadCells) -> Result<Self, PatternFault> {
        let map = Self::laid(pattern, scene, cells)?;
        let key = if pattern.file.is_some() {
            "file"
        } else if pattern.laterals.is_empty() {
            "grooves"
        } else {
            "laterals"
        };
        map.check_columns(key)?;
        if map.exact_void > MOST_VOID {
            let wrong = format!("{:.1} % of the strip are void", 100.0 * map.exact_void);
            let right = format!("narrower grooves: at most {:.0} %", 100.0 * MOST_VOID);
            return Err(PatternFault::new(key, wrong, right));
        }
        if map.is_off() {
            let [exact, on_cells] = [map.exact_void, map.void()].map(|share| format!("{:.1} %", 100.0 * share));
            let wrong = format!("{exact} are void, on cells {on_cells}: 5 % of the void may be missed");
            return Err(PatternFault::new(key, wrong, Self::right_cells(pattern, scene, cells)));
        }
        Ok(map)
    }

    /// Remedy in words: the fewest finer cells on which the void ratio is acceptable.
    fn right_cells(pattern: &TreadPattern, scene: &Scene, cells: TreadCells) -> String {
        let most = cells.across * FINER[FINER.len() - 1];
        let finer = FINER.map(|times| {
            let columns = cells.columns * times;
            (cells.across..=most).map(move |across| TreadCells { columns, across })
        });
        let mut finer: Vec<TreadCells> = finer.into_iter().flatten().collect();
        finer.sort_by_key(|cells| cells.columns * cells.across);
        let holds = |cells: &TreadCells| Self::holds(pattern, scene, *cells);
        let Some(TreadCells { columns, across }) = finer.into_iter().take(TRIED).find(holds) else {
            return "finer cells, or grooves of whole cells".to_owned();
        };
        let round = match scene.contact.zone {
            Zone::Cells => format!("numerics.elements = {columns}"),
            Zone::Slices => format!("numerics.elements times contact.cells_along = {columns}"),
        };
        format!("contact.cells_across = {across} with {round}, or grooves of whole cells")
    }

    /// Fewest cells across, from those given to twice as many, on which the void ratio is acceptable; those given
    /// where there are none.
    pub(crate) fn fewest_across(pattern: &TreadPattern, scene: &Scene, cells: TreadCells) -> usize {
        let holds = |across: &usize| Self::holds(pattern, scene, TreadCells { across: *across, ..cells });
        (cells.across..=2 * cells.across).find(holds).unwrap_or(cells.across)
    }

    /// True if the void ratio on some cells is acceptable.
    fn holds(pattern: &TreadPattern, scene: &Scene, cells: TreadCells) -> bool {
        Self::laid(pattern, scene, cells).is_ok_and(|map| !map.is_off())
    }

    /// A scene's pattern on cells, whatever its void ratio there.
    fn laid(pattern: &TreadPattern, scene: &Scene, cells: TreadCells) -> Result<Self, PatternFault> {
        let TreadCells { columns, across } = cells;
        if columns.checked_mul(across).is_none_or(|all| all > MOST_TREAD_CELLS) {
            let wrong = format!("{columns} cells round the tyre and {across} across are too many to lay a pattern on");
            let right = format!("at most {MOST_TREAD_CELLS} in all: fewer elements, or fewer cells");
            return Err(PatternFault::new(if pattern.file.is_some() { "file" } else { "grooves" }, wrong, right));
        }
        let (around, width) = (scene.tyre.circumference, scene.tyre.contact_width);
        let train = pattern.pitches.as_ref().map(|pitches| PitchTrain::new(pitches, around));
        if let Some(train) = train.as_ref().filter(|train| train.count() * CELLS_OF_PITCH > columns) {
            let (count, most) = (train.count(), columns / CELLS_OF_PITCH);
            let wrong = format!("{count} pitches on {columns} cells round the tyre: a pitch needs four");
            return Err(PatternFault::new("pitches", wrong, format!("at most {most} pitches, or more elements")));
        }
        let mut map = Self {
            columns,
            across,
            size: [around / columns as f64, width / across as f64],
            depths: vec![0.0; columns * across],
            groove_of: vec![0; columns * across],
            sipes: [vec![0; columns * across], vec![0; columns * across]],
            sipe_lines: Vec::new(),
            cuts: vec![[0.0; 2]],
            train,
            exact_void: 0.0,
        };
        match &pattern.file {
            Some(file) => {
                let deepest = DEEPEST_VOID.min(deepest_groove(&scene.tyre));
                map.lay(Raster::read(file, pattern.depth, deepest)?, pattern.period)?;
            }
            None => map.cut(pattern)?,
        }
        Ok(map)
    }

    /// Position of the middle of a cell across \[m\], from the tyre's middle.
    pub(crate) fn y(&self, j: usize) -> f64 {
        (j as f64 + 0.5 - 0.5 * self.across as f64) * self.size[1]
    }

    /// True if all depths are 0 and nothing divides the cells.
    pub(crate) fn is_level(&self) -> bool {
        self.depths.iter().all(|depth| *depth <= 0.0) && self.sipes.iter().flatten().all(|cut| *cut == 0)
    }

    /// Void ratio of all cells.
    pub fn void(&self) -> f64 {
        self.depths.iter().filter(|depth| **depth > 0.0).count() as f64 / self.depths.len() as f64
    }

    /// Void ratio of each row of cells round the tyre.
    pub(crate) fn void_of_rows(&self) -> Vec<f64> {
        let of = |j| self.depths.iter().skip(j).step_by(self.across).filter(|depth| **depth > 0.0).count();
        (0..self.across).map(|j| of(j) as f64 / self.columns as f64).collect()
    }

    /// Bands of grooves across, pitch by pitch, with their indices in the list.
    fn bands<'a>(&'a self, of: &'a [LateralGroove]) -> impl Iterator<Item = (usize, GrooveBand)> + 'a {
        let pitches = self.train.iter().flat_map(|train| train.starts.iter().zip(&train.lengths));
        pitches.flat_map(move |(start, length)| {
            of.iter().enumerate().map(move |(number, groove)| {
                let place = groove.offset.mul_add(*length, *start).rem_euclid(self.size[0] * self.columns as f64);
                (number, GrooveBand::new(place, groove.width, groove.angle, [groove.from, groove.to]))
            })
        })
    }

    /// Samples a raster at the middles of the cells.
    fn lay(&mut self, raster: Raster, period: RasterPeriod) -> Result<(), PatternFault> {
        let Raster { rows, columns, depths } = raster;
        let [_, dy] = self.size;
        let (around, width) = (self.size[0] * self.columns as f64, dy * self.across as f64);
        let shown = match (period, &self.train) {
            (RasterPeriod::Pitch, Some(train)) => around / train.count() as f64,
            _ => around,
        };
        // A raster of the cells themselves need not have square points.
        let is_cells = rows == self.columns && columns == self.across && period == RasterPeriod::Circumference;
        let pixel = if is_cells { dy } else { shown / rows as f64 };
        let raster_width = pixel * columns as f64;
        if (raster_width - width).abs() > dy {
            let wrong = format!(
                "{rows} rows over {} m make the raster {} mm wide, the strip is {} mm",
                short((1e4 * shown).round() / 1e4),
                short((1e4 * raster_width).round() / 10.0),
                short((1e4 * width).round() / 10.0)
            );
            let right = format!("square points: {} of them across", (width / pixel).round());
            return Err(PatternFault::new("file", wrong, right));
        }
        for i in 0..self.columns {
            let x = (i as f64 + 0.5) * self.size[0];
            let part = match (period, &self.train) {
                (RasterPeriod::Pitch, Some(train)) => train.within(x).1,
                _ => x / around,
            };
            let row = ((part * rows as f64) as usize).min(rows - 1);
            for j in 0..self.across {
                let column = (self.y(j) + 0.5 * raster_width) / pixel;
                let column = (column.max(0.0) as usize).min(columns - 1);
                let depth = depths[row * columns + column];
                let cell = i * self.across + j;
                self.depths[cell] = depth;
                self.groove_of[cell] = if depth > 0.0 { UNNUMBERED } else { 0 };
            }
        }
        self.exact_void = depths.iter().filter(|depth| **depth > 0.0).count() as f64 / depths.len() as f64;
        Ok(())
    }

    /// Adds a cut of a depth \[m\] and a slope; returns its number.
    fn number(&mut self, depth: f64, slope: f64) -> Cut {
        self.cuts.push([depth, slope]);
        (self.cuts.len() - 1) as Cut
    }

    /// Makes a cell at least as deep as a groove.
    fn deepen(&mut self, cell: usize, depth: f64, number: Cut) {
        if depth > self.depths[cell] {
            (self.depths[cell], self.groove_of[cell]) = (depth, number);
        }
    }

    /// Cuts grooves and sipes.
    fn cut(&mut self, pattern: &TreadPattern) -> Result<(), PatternFault> {
        let TreadPattern { grooves, laterals, sipes, .. } = pattern;
        let [dx, dy] = self.size;
        let mm = |length: f64| short((1e5 * length).round() / 100.0);
        // 1. Grooves are at least a cell wide, sipes narrower.
        if let Some((n, Groove { width, .. })) = grooves.iter().enumerate().find(|(_, groove)| groove.width < dy) {
            let wrong = format!("a groove of {} mm is narrower than a cell, {} mm", mm(*width), mm(dy));
            let right = "wider grooves, finer cells, or, across, a sipe";
            return Err(PatternFault::new(format!("grooves[{n}].width"), wrong, right));
        }
        for (key, list, of_sipes) in [("laterals", laterals, false), ("sipes", sipes, true)] {
            for (n, groove) in list.iter().enumerate() {
                let (along, across) = extents(groove);
                // A steep one by its extent across.
                let is_narrow = if groove.angle.abs() > 45.0 { across < dy } else { along < dx };
                if is_narrow == of_sipes {
                    continue;
                }
                let (wrong, right) = if of_sipes {
                    ("as wide as a cell", "write it under `laterals`")
                } else {
                    ("narrower than a cell", "write it under `sipes`, or finer cells")
                };
                let wrong = format!("{} mm is {wrong}, {} mm by {} mm", mm(groove.width), mm(dx), mm(dy));
                return Err(PatternFault::new(format!("{key}[{n}].width"), wrong, right));
            }
        }
        // 2. Circumferential grooves.
        for &Groove { position, width, depth } in grooves {
            // Their sides run along: slope 0.
            let number = self.number(depth, 0.0);
            let rows: Vec<usize> = (0..self.across).filter(|&j| (self.y(j) - position).abs() < 0.5 * width).collect();
            for j in rows {
                for i in 0..self.columns {
                    self.deepen(i * self.across + j, depth, number);
                }
            }
        }
        // 3. Lateral grooves, pitch by pitch.
        let bands: Vec<(usize, GrooveBand)> = self.bands(laterals).collect();
        for (of, band) in &bands {
            let depth = laterals[*of].depth;
            let number = self.number(depth, band.slope);
            for j in 0..self.across {
                if !band.reaches(self.y(j)) {
                    continue;
                }
                let middle = band.middle(self.y(j));
                // Cells whose middles lie strictly within.
                let first = ((middle - band.half) / dx - 0.5).floor() as i64 + 1;
                let last = ((middle + band.half) / dx - 0.5).ceil() as i64 - 1;
                for i in first..=last {
                    let i = i.rem_euclid(self.columns as i64) as usize;
                    self.deepen(i * self.across + j, depth, number);
                }
            }
        }
        // 4. Sipes, pitch by pitch.
        let cuts: Vec<(usize, GrooveBand)> = self.bands(sipes).collect();
        for (of, band) in cuts {
            let number = self.number(sipes[of].depth, band.slope);
            self.sipe_lines.push(band.ends.map(|y| [band.middle(y), y]));
            self.divide(&band, number);
        }
        // 5. The exact void ratio; equal pitches have that of one, whose grooves enter it again at its other end.
        let repeats = match &pattern.pitches {
            Some(Pitches::Equal(count)) => *count,
            _ => 1,
        };
        let (along, half) = (dx * self.columns as f64 / repeats as f64, 0.5 * dy * self.across as f64);
        // A groove of no depth is none.
        let of_grooves: Vec<[f64; 2]> = grooves
            .iter()
            .filter(|groove| groove.depth > 0.0)
            .map(|groove| [groove.position - 0.5 * groove.width, groove.position + 0.5 * groove.width])
            .collect();
        let of_one = bands.len() / repeats;
        let of_laterals: Vec<GrooveBand> =
            bands.into_iter().take(of_one).filter(|(of, _)| laterals[*of].depth > 0.0).map(|(_, band)| band).collect();
        let area = covered(&of_laterals, &of_grooves, [0.0, along], [-half, half], true);
        self.exact_void = area / (2.0 * half * along);
        Ok(())
    }

    /// Divides the cells on either side of a sipe.
    fn divide(&mut self, sipe: &GrooveBand, number: Cut) {
        let (columns, across) = (self.columns as i64, self.across);
        let cell = |i: i64, j: usize| i.rem_euclid(columns) as usize * across + j;
        // Index of the last column whose middle is behind the line.
        let behind = |y: f64| (sipe.middle(y) / self.size[0] - 0.5).floor() as i64;
        let lines: Vec<Option<i64>> =
            (0..across).map(|j| self.y(j)).map(|y| sipe.reaches(y).then(|| behind(y))).collect();
        for (j, line) in lines.iter().enumerate() {
            let Some(line) = *line else { continue };
            self.sipes[0][cell(line, j)] = number;
            let Some(Some(next)) = lines.get(j + 1).copied() else { continue };
            for i in line.min(next) + 1..=line.max(next) {
                self.sipes[1][cell(i, j)] = number;
            }
        }
    }

    /// True if the void ratio on cells misses that of the grooves.
    fn is_off(&self) -> bool {
        (self.void() - self.exact_void).abs() > VOID_OFF * self.exact_void
    }

    /// Refuses columns without a solid cell.
    fn check_columns(&self, key: &str) -> Result<(), PatternFault> {
        let is_void = |column: &[f64]| column.iter().all(|depth| *depth > 0.0);
        if let Some(column) = self.depths.chunks_exact(self.across).position(is_void) {
            let wrong =
                format!("no cell of column {column}, {:.1} mm along, is solid", 1e3 * self.size[0] * column as f64);
            return Err(PatternFault::new(key, wrong, "leave some of the tread in each column across"));
        }
        Ok(())
    }
}

/// Extents \[m\] of a groove across on a line along and on a line across.
fn extents(groove: &LateralGroove) -> (f64, f64) {
    let (sine, cosine) = groove.angle.to_radians().sin_cos();
    (groove.width / cosine, groove.width / sine.abs().max(f64::MIN_POSITIVE))
}
