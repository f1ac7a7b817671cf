//! Sheet of air under a tyre: its channels through the patch, and the wedges up to where the field outside takes over.
//!
//! Along, the sheet has the cells of a transfer's grid, to [`REACH`] beyond the patch. Across, it is the straight
//! tread, cut at the sides of the channels. Its height is the rise of the round tyre over the road, plus the depth of
//! the channels; the ribs between them are closed within the patch. With the total Green function G of the sealed body
//! the edges are
//!
//! ```text
//! p_n + (i k + h'/(2 h) + 1/(2 X_o)) p = the same of G     before and behind, |x| = X_o
//! p + 0.85 h p_n = the same of G                           at the sides
//! ```
//!
//! so that a sheet without channels has G again, but for the thin gap's approximation. Only the field that channels add
//! to G depends on the edges: at the ends it runs out along a horn whose height grows as h, spreading across by
//! 1/sqrt(X_o), and at the sides as from a slot. h' is that of the parabola (x^2 - a^2)/(2 R).

use num_complex::Complex64;

use super::medium::GapAir;
use super::sheet::{Edge, Edges, FactoredSheet, Sheet, SheetDrive};
use crate::numeric::{double, lagrange};
use crate::radiation::body::RadiatingBody;
use crate::radiation::error::RadiationError;
use crate::radiation::transfer::{SurfaceTransfer, TransferGrid, across_points, half_tread};

/// Reach of the sheet beyond the patch, before and behind it \[m\]: there the gap of a car tyre is an eighth of the
/// wavelength at 2.5 kHz.
pub(crate) const REACH: f64 = 0.06;
/// Largest width of a cell across \[m\].
const ACROSS: f64 = 3e-3;
/// The same where cells of contact give the heights: these cells are halved only if they are wider.
const ROUGH_ACROSS: f64 = 4e-3;
/// Fewest cells across a channel or a rib.
const LEAST_ACROSS: usize = 2;
/// End correction of the slot at the sides relative to its height: that of a slot between the road and a wall.
const SIDE_CORRECTION: f64 = 0.85;

/// Channel through the patch: a circumferential groove.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapChannel {
    /// Distance of its middle from mid-width, positive to the left \[m\].
    pub position: f64,
    /// Width \[m\].
    pub width: f64,
    /// Depth \[m\].
    pub depth: f64,
}

/// Heights of the gap under a tyre on a road that is not smooth.
pub(crate) struct RoughGap<'a> {
    /// Ends of the contact's cells across \[m\].
    pub ends: &'a [f64],
    /// Height \[m\] at a distance ahead of the contact's centre and to the left, 0 where tread and road touch; `None`
    /// where it is not known: there it is that over a smooth road.
    pub height: &'a dyn Fn(f64, f64) -> Option<f64>,
}

/// Sheet under a tyre, without the air's frequency.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PatchSheet {
    /// Sheet; its x is the horizontal distance from the contact's centre.
    pub sheet: Sheet,
    /// Number of the grid's cells that it covers to either side of the contact's centre.
    pub cells: usize,
    /// By cell, the open part: all of a channel, of ribs the part beyond the patch.
    open: Vec<f64>,
    /// By cell along, the height under ribs \[m\].
    ribs: Vec<f64>,
    grid: TransferGrid,
    half_width: f64,
    half_patch: f64,
}

/// Sheet under a tyre at a frequency, its equations factorised.
pub(crate) struct FactoredPatch<'a> {
    patch: &'a PatchSheet,
    factored: FactoredSheet,
    wavenumber: f64,
}

impl PatchSheet {
    /// Sheet of a tyre that stands on the road, for transfers on a grid; `None` for other bodies.
    pub(crate) fn new(
        body: &RadiatingBody,
        grid: TransferGrid,
        channels: &[GapChannel],
        rough: Option<&RoughGap<'_>>,
    ) -> Option<Self> {
        let (radius, half_patch, half_width) = (body.radius(), body.half_patch(), half_tread(body));
        if half_patch <= 0.0 || half_width <= 0.0 {
            return None;
        }
        // 1. Cells: along those of the grid, across between the cuts.
        let turn = std::f64::consts::TAU / grid.around as f64;
        let outer = (half_patch + REACH).min(radius * FLATTEST);
        let cells = ((outer / radius).asin() / turn - 1e-9).ceil().max(1.0) as usize;
        let x: Vec<f64> = (-(cells as i64)..=cells as i64).map(|end| radius * (end as f64 * turn).sin()).collect();
        let y = across(half_width, channels, rough.map_or(&[], |rough| rough.ends));
        // 2. Heights over a smooth road, and the open parts.
        let rise = |x: f64| {
            let x = x.abs();
            if x <= half_patch {
                0.0
            } else {
                (radius.powi(2) - half_patch.powi(2)).sqrt() - (radius.powi(2) - x * x).sqrt()
            }
        };
        let mean_rise = |ends: &[f64]| -> f64 {
            MEAN.iter().map(|[node, weight]| weight * rise(ends[0] + node * (ends[1] - ends[0]))).sum()
        };
        let beyond = |ends: &[f64]| {
            let closed = (ends[1].min(half_patch) - ends[0].max(-half_patch)).max(0.0);
            1.0 - closed / (ends[1] - ends[0])
        };
        let depth = |ends: &[f64]| {
            let middle = 0.5 * (ends[0] + ends[1]);
            let holds = |channel: &&GapChannel| (middle - channel.position).abs() < 0.5 * channel.width;
            channels.iter().filter(holds).map(|channel| channel.depth).fold(0.0, f64::max)
        };
        let depths: Vec<f64> = y.windows(2).map(depth).collect();
        let ribs: Vec<f64> = x.windows(2).map(mean_rise).collect();
        let mut heights: Vec<f64> = ribs.iter().flat_map(|rise| depths.iter().map(move |depth| rise + depth)).collect();
        let beyond = x.windows(2).map(beyond);
        let part = |beyond: f64| depths.iter().map(move |depth| if *depth > 0.0 { 1.0 } else { beyond });
        let mut open: Vec<f64> = beyond.flat_map(part).collect();
        // 3. Known heights replace them.
        if let Some(rough) = rough {
            let middles =
                |ends: &[f64]| -> Vec<f64> { ends.windows(2).map(|ends| 0.5 * (ends[0] + ends[1])).collect() };
            let (x, y) = (middles(&x), middles(&y));
            let places = x.iter().flat_map(|x| y.iter().map(move |y| (*x, *y)));
            for ((place, height), open) in places.zip(&mut heights).zip(&mut open) {
                if let Some(known) = (rough.height)(place.0, place.1) {
                    (*height, *open) = (known, f64::from(u8::from(known > 0.0)));
                }
            }
        }
        Some(Self { sheet: Sheet { x, y, heights }, cells, open, ribs, grid, half_width, half_patch })
    }

    /// Distance from the contact's centre at which the sheet ends, X_o \[m\].
    pub(crate) fn reach(&self) -> f64 {
        self.sheet.x.last().copied().unwrap_or(0.0)
    }

    /// Height under the ribs at the sheet's ends, its largest \[m\].
    pub(crate) fn height_at_ends(&self) -> f64 {
        self.sheet
            .heights
            .iter()
            .rev()
            .take(self.sheet.cells()[1])
            .fold(f64::INFINITY, |least, &height| least.min(height))
    }

    /// Decay rate of a wave that runs out at the sheet's ends \[1/m\]: by the horn's flare, half of h'/h, and by its
    /// width.
    fn spreading(&self) -> f64 {
        let (reach, half_patch) = (self.reach(), self.half_patch);
        reach / (reach.powi(2) - half_patch.powi(2)) + 0.5 / reach
    }

    /// Conditions of the edges at a wavenumber \[rad/m\].
    pub(crate) fn edges(&self, wavenumber: f64) -> Edges {
        let end = Edge {
            pressure: Complex64::new(self.spreading(), wavenumber),
            slope: Complex64::ONE,
            slope_by_height: 0.0,
        };
        let side = Edge { slope_by_height: SIDE_CORRECTION, ..Edge::OPEN };
        [end, end, side, side]
    }

    /// Factorises the sheet's equations at a wavenumber \[rad/m\]; [`RadiationError::Singular`].
    pub(crate) fn factorise(&self, air: &GapAir, wavenumber: f64) -> Result<FactoredPatch<'_>, RadiationError> {
        let factored = self.sheet.factorise(air, wavenumber * air.sound_speed, &self.edges(wavenumber))?;
        Ok(FactoredPatch { patch: self, factored, wavenumber })
    }

    /// Drive of the edges by a transfer of the sealed body.
    pub(crate) fn drive(&self, transfer: &SurfaceTransfer) -> SheetDrive {
        let edges = self.edges(transfer.wavenumber);
        let radius_turn = |cell: i64| {
            // Middles of cells by the horizontal distance from the contact's centre.
            let turn = std::f64::consts::TAU / self.grid.around as f64;
            self.radius() * ((cell as f64 + 0.5) * turn).sin()
        };
        let end = |inner: i64, outer: i64, edge: &Edge| -> Vec<Complex64> {
            let way = (radius_turn(outer) - radius_turn(inner)).abs();
            let [inside, outside] = [inner, outer].map(|cell| self.across(transfer, cell));
            let value = |(inside, outside): (Complex64, Complex64)| {
                (outside - inside) / way * edge.slope + 0.5 * (inside + outside) * edge.pressure
            };
            inside.into_iter().zip(outside).map(value).collect()
        };
        let cells = self.cells as i64;
        let along = self.sheet.cells()[0];
        // G and its outward derivative at a side: G's polynomial across is a cubic, so the difference is nearly exact.
        let side = |y: f64, edge: &Edge| -> Vec<Complex64> {
            let near = [y, y * (1.0 - SIDE_STEP), y * (1.0 + SIDE_STEP)].map(|y| self.weights(transfer, y));
            let value = |place: usize| {
                let cell = place as i64 - cells;
                let [on, inside, outside] = near.each_ref().map(|weights| self.at(transfer, cell, weights));
                let slope = (outside - inside) / (2.0 * SIDE_STEP * self.half_width);
                on * edge.pressure + slope * (edge.slope_by_height * self.ribs[place])
            };
            (0..along).map(value).collect()
        };
        SheetDrive {
            edges: [
                end(-cells, -cells - 1, &edges[0]),
                end(cells - 1, cells, &edges[1]),
                side(-self.half_width, &edges[2]),
                side(self.half_width, &edges[3]),
            ],
            sources: Vec::new(),
        }
    }

    /// Rows of a transfer, with the weights by which their sum is G at a distance across.
    fn weights(&self, transfer: &SurfaceTransfer, y: f64) -> Vec<(usize, f64)> {
        let places: Vec<f64> = across_points(self.half_width, self.grid.across).iter().map(|[y, _]| *y).collect();
        let side = if transfer.sides == 2 && y < 0.0 { 1 } else { 0 };
        let row = |(row, weight)| (transfer.index(side, row, 0), weight);
        lagrange::weights(&places, y.abs()).enumerate().map(row).collect()
    }

    /// G of a cell of the grid, counted from the contact's centre.
    fn at(&self, transfer: &SurfaceTransfer, cell: i64, weights: &[(usize, f64)]) -> Complex64 {
        let cell = cell.rem_euclid(self.grid.around as i64) as usize;
        weights.iter().map(|&(row, weight)| double(transfer.values[row + cell]) * weight).sum()
    }

    /// G of a cell of the grid at the middles of the sheet's cells across.
    fn across(&self, transfer: &SurfaceTransfer, cell: i64) -> Vec<Complex64> {
        let middle = |ends: &[f64]| self.weights(transfer, 0.5 * (ends[0] + ends[1]));
        self.sheet.y.windows(2).map(|ends| self.at(transfer, cell, &middle(ends))).collect()
    }

    /// G of the sealed body on the grid's cells, cell by cell across, as [`Self::on_grid`].
    #[cfg(test)]
    pub(crate) fn outside(&self, transfer: &SurfaceTransfer) -> Vec<Complex64> {
        let cells = self.cells as i64;
        (-cells..cells).flat_map(|cell| self.across(transfer, cell)).collect()
    }

    fn radius(&self) -> f64 {
        self.reach() / (std::f64::consts::TAU * self.cells as f64 / self.grid.around as f64).sin()
    }

    /// Means over the grid's cells of values on the sheet's: ribs closed by the road count as 0, as in a transfer.
    pub(crate) fn on_grid(&self, values: &[Complex64]) -> Vec<Complex64> {
        values.iter().zip(&self.open).map(|(value, open)| value * open).collect()
    }

    /// Values of the sheet's cells within the patch, 0 where it is closed, and their areas \[m^2\].
    pub(crate) fn within<'a>(&'a self, values: &'a [Complex64]) -> impl Iterator<Item = (Complex64, f64)> {
        let size = |ends: &[f64]| ends[1] - ends[0];
        let across = self.sheet.cells()[1];
        let columns = self.sheet.x.windows(2).zip(values.chunks_exact(across)).zip(self.open.chunks_exact(across));
        let within = columns.filter(|((ends, _), _)| (0.5 * (ends[0] + ends[1])).abs() < self.half_patch);
        within.flat_map(move |((ends, values), open)| {
            let widths = self.sheet.y.windows(2).map(size);
            values.iter().zip(open).zip(widths).map(move |((value, open), width)| (value * open, size(ends) * width))
        })
    }

    /// The two cells of the sheet in the middle of the patch at a distance across.
    fn middle_cells(&self, y: f64) -> [usize; 2] {
        let [along, across] = self.sheet.cells();
        let j = self.sheet.y.partition_point(|&end| end <= y).clamp(1, across) - 1;
        [along / 2 - 1, along / 2].map(|i| i * across + j)
    }

    /// Pressure in the middle of the patch at a distance across, from values on the sheet's cells.
    pub(crate) fn in_middle(&self, values: &[Complex64], y: f64) -> Complex64 {
        let [one, other] = self.middle_cells(y);
        0.5 * (values[one] + values[other])
    }
}

impl FactoredPatch<'_> {
    /// Field in the sheet for some transfers of the sealed body, each on the sheet's cells.
    pub(crate) fn solve(&self, transfers: &[SurfaceTransfer]) -> Vec<Vec<Complex64>> {
        let drives: Vec<SheetDrive> = transfers.iter().map(|transfer| self.patch.drive(transfer)).collect();
        debug_assert!(transfers.iter().all(|transfer| (transfer.wavenumber / self.wavenumber - 1.0).abs() < 1e-9));
        self.factored.solve(&drives)
    }

    /// G of a point in the middle of the patch at a distance across, on the sheet's cells \[1/m\]: by reciprocity the
    /// field of a source there that radiates through the edges.
    pub(crate) fn sourced_in_middle(&self, y: f64) -> Vec<Complex64> {
        let [along, across] = self.patch.sheet.cells();
        let mut sources = vec![Complex64::ZERO; along * across];
        for cell in self.patch.middle_cells(y) {
            sources[cell] = Complex64::new(-0.5 / self.factored.area(cell), 0.0);
        }
        self.factored.solve(&[SheetDrive { sources, ..SheetDrive::default() }]).remove(0)
    }

    /// Field of both ends driven by 1 \[1/m\] in phase, on the sheet's cells.
    pub(crate) fn between_equal_ends(&self) -> Vec<Complex64> {
        let ends = vec![Complex64::ONE; self.patch.sheet.cells()[1]];
        let drive = SheetDrive { edges: [ends.clone(), ends, Vec::new(), Vec::new()], sources: Vec::new() };
        self.factored.solve(&[drive]).remove(0)
    }
}

/// Step over which G's derivative at the sides is taken, relative to the tread's half width.
const SIDE_STEP: f64 = 1e-3;

/// Largest distance of the sheet's ends from the contact's centre, relative to the radius.
const FLATTEST: f64 = 0.8;

/// Three Gauss points on (0, 1) with their weights.
const MEAN: [[f64; 2]; 3] =
    [[0.112_701_665_379_258_3, 5.0 / 18.0], [0.5, 8.0 / 18.0], [0.887_298_334_620_741_7, 5.0 / 18.0]];

/// Ends of the cells across a tread, cut at the sides of the channels and at other places \[m\].
fn across(half_width: f64, channels: &[GapChannel], other: &[f64]) -> Vec<f64> {
    let mut cuts = vec![-half_width, half_width];
    cuts.extend(other.iter().map(|y| y.clamp(-half_width, half_width)));
    for GapChannel { position, width, .. } in channels {
        cuts.extend([position - 0.5 * width, position + 0.5 * width].map(|y| y.clamp(-half_width, half_width)));
    }
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|next, one| (*next - *one).abs() < 1e-9);
    let mut ends = vec![-half_width];
    for pair in cuts.windows(2) {
        let (largest, least) = if other.is_empty() { (ACROSS, LEAST_ACROSS) } else { (ROUGH_ACROSS, 1) };
        let parts = ((pair[1] - pair[0]) / largest).ceil().max(least as f64) as usize;
        ends.extend((1..=parts).map(|part| pair[0] + (pair[1] - pair[0]) * part as f64 / parts as f64));
    }
    ends
}
