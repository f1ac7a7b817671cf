//! Boundary meshes: bodies cut into patches by nodes per wavelength, finer where body and road form a wedge.
//!
//! 1. The body's quarter is a few blocks, each a rectangle of a chart's parameters with at most one side bent along the
//!    road's cut.
//! 2. A block is cut into rings along the meridian, each ring along the turn, by as many patches as it needs at its own
//!    width: neighbouring rings need not match, since elements are not connected.
//! 3. The side of a patch is p wavelengths/nodes, at most 45 degrees of turn, and near the road at most `wedge` times
//!    (l + distance from the wedge's edge), l being half the patch's length, or sqrt(2 R clearance) for a body that is
//!    clear of the road: the length over which the gap between body and road changes. Across the straight tread nothing
//!    changes: there the wavelength alone counts (measured: no larger error, a quarter fewer unknowns).
//! 4. Over a slit the patches on both sides of the slit's edge shrink towards it to `wedge` times the length over which
//!    the slit's height doubles outside, gap R/a.
//!
//! Rings and patches are counted before they are made: a mesh of more than [`MOST_PATCHES`] is refused.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use super::body::{BodyShape, RadiatingBody};
use super::chart::Chart;
use super::elements::{Cut, Mesh, SurfacePatch};
use super::error::{RadiationError, positive};

/// Fineness of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshResolution {
    /// Nodes along a side of an element: 3 or 4.
    pub order: usize,
    /// Nodes per wavelength along a side.
    pub nodes_per_wavelength: f64,
    /// Side of the elements at the wedge between body and road, relative to the length over which the gap changes.
    pub wedge: f64,
}

impl MeshResolution {
    /// Elements of 4 x 4 nodes with so many nodes per wavelength.
    pub fn of(nodes_per_wavelength: f64) -> Self {
        Self { order: 4, nodes_per_wavelength, wedge: Self::WEDGE }
    }

    /// Default of [`Self::wedge`], chosen by measured convergence.
    pub const WEDGE: f64 = 0.8;

    /// Default number of nodes per wavelength. Measured on a standing tyre up to 2.5 kHz against twice the mesh, waves
    /// of orders 0 to 40 around the tread at receivers near and far: 9 keep 0.02 dB, 0.15 dB in a receiver's nulls; 7
    /// keep 0.1 dB, 0.5 dB for slow waves and 3 dB in nulls; errors are multiplied because slow waves' sums cancel.
    pub const NODES: f64 = 9.0;

    /// Checks that elements of this resolution exist.
    ///
    /// # Errors
    /// [`RadiationError::Order`], [`RadiationError::NotPositive`].
    pub fn check(&self) -> Result<(), RadiationError> {
        positive("the number of nodes per wavelength", self.nodes_per_wavelength)?;
        positive("the size of elements at the wedge", self.wedge)?;
        if matches!(self.order, 3 | 4) { Ok(()) } else { Err(RadiationError::Order { order: self.order }) }
    }
}

impl Default for MeshResolution {
    fn default() -> Self {
        Self::of(Self::NODES)
    }
}

/// Most patches of a quarter. With 4 x 4 nodes each they are 1e5 unknowns: 160 GB for the matrix of each block.
pub(crate) const MOST_PATCHES: usize = 6250;

/// Largest turn of a patch \[rad\].
const MOST_TURN: f64 = FRAC_PI_4;

/// Smallest length over which a gap changes, relative to the body's radius: the mesh of a body that touches in a point
/// is graded down to it.
const LEAST_SCALE: f64 = 0.02;

/// Sizes of patches by place.
struct Sizes {
    body: RadiatingBody,
    largest: f64,
    wedge: f64,
    scale: f64,
    /// With a gap the length from the patch's edge over which the slit's height doubles \[m\], else infinity.
    slit: f64,
}

/// Sides of a patch that run across the contact patch's edge, and so are refined towards that of a gap.
#[derive(Clone, Copy)]
struct PatchSides {
    meridian: bool,
    turn: bool,
}

impl PatchSides {
    const NEITHER: Self = Self { meridian: false, turn: false };
    const MERIDIAN: Self = Self { meridian: true, turn: false };
    const TURN: Self = Self { meridian: false, turn: true };
    const BOTH: Self = Self { meridian: true, turn: true };
}

impl Sizes {
    fn at(&self, chart: &Chart, meridian: f64, turn: f64, across: bool) -> f64 {
        if !self.body.on_road() {
            return self.largest;
        }
        let [x, y, z] = chart.point(meridian, turn).position;
        let out = match self.body.shape() {
            BodyShape::Sphere { .. } => x.hypot(y),
            BodyShape::Tyre { .. } => x,
        };
        if matches!(chart, Chart::Tread { .. }) && !across {
            return self.largest;
        }
        let half = self.body.half_patch();
        let distance = (out - half).max(0.0).hypot((z - self.body.gap()).max(0.0));
        let size = self.largest.min(self.wedge * (self.scale + distance));
        if !across || self.slit.is_infinite() {
            return size;
        }
        let distance = match chart {
            Chart::Underside { .. } | Chart::UndersideEdge { .. } => {
                let width = match self.body.shape() {
                    BodyShape::Tyre { radius, width, shoulder } => {
                        let edge = 0.5 * width - shoulder;
                        let round = Chart::Shoulder {
                            radius,
                            shoulder,
                            edge,
                            middle: self.body.height().unwrap_or(0.0),
                            gap: 0.0,
                        };
                        edge + shoulder * round.cut_meridian(0.0).sin()
                    }
                    BodyShape::Sphere { .. } => half,
                };
                (half - x).min(width - y).max(0.0)
            }
            _ => distance,
        };
        size.min(self.wedge * (self.slit + distance))
    }
}

/// Patches of a body's quarter for a wavenumber \[rad/m\].
///
/// # Errors
/// Refusals of [`MeshResolution::check`]; a wavenumber that is not positive; [`RadiationError::Patches`].
pub(crate) fn patches(
    body: &RadiatingBody,
    wavenumber: f64,
    resolution: &MeshResolution,
) -> Result<Vec<SurfacePatch>, RadiationError> {
    resolution.check()?;
    positive("the wavenumber", wavenumber)?;
    let radius = body.radius();
    let clearance = body.height().map_or(radius, |height| (height - radius).max(0.0));
    let scale = match body.shape() {
        BodyShape::Sphere { .. } => body.half_patch() * body.middle() / radius,
        BodyShape::Tyre { .. } => body.half_patch(),
    };
    let sizes = Sizes {
        body: *body,
        largest: resolution.order as f64 * TAU / (wavenumber * resolution.nodes_per_wavelength),
        wedge: resolution.wedge,
        scale: scale.max((2.0 * radius * clearance).sqrt()).max(LEAST_SCALE * radius),
        slit: if body.gap() > 0.0 { body.gap() * radius / body.half_patch() } else { f64::INFINITY },
    };
    let mut blocks = Blocks { sizes, patches: Vec::new() };
    match body.shape() {
        BodyShape::Sphere { radius } => {
            let chart = Chart::Sphere { radius, middle: body.middle() };
            let start = (body.middle() / radius).min(1.0).acos();
            let start = if body.on_road() { start } else { 0.0 };
            blocks.fill(chart, [start, PI], [0.0, FRAC_PI_2], Cut::None, PatchSides::NEITHER)?;
        }
        BodyShape::Tyre { radius, width, shoulder } => {
            if let Some(charts) = Chart::of_tyre(body) {
                blocks.tyre(body, charts, radius, width, shoulder)?;
            }
        }
    }
    Ok(blocks.patches)
}

/// Mesh of a body's quarter for a wavenumber \[rad/m\].
///
/// # Errors
/// As [`patches`].
pub(crate) fn mesh(body: &RadiatingBody, wavenumber: f64, resolution: &MeshResolution) -> Result<Mesh, RadiationError> {
    Ok(Mesh::new(patches(body, wavenumber, resolution)?, resolution.order, body.on_road()))
}

struct Blocks {
    sizes: Sizes,
    patches: Vec<SurfacePatch>,
}

impl Blocks {
    fn tyre(
        &mut self,
        body: &RadiatingBody,
        [tread, round, side]: [Chart; 3],
        radius: f64,
        width: f64,
        shoulder: f64,
    ) -> Result<(), RadiationError> {
        let (middle, gap) = (body.height().unwrap_or(0.0), body.gap());
        let edge = 0.5 * width - shoulder;
        let rim = radius - shoulder;
        let depth = if body.on_road() { (radius - middle).max(0.0) } else { 0.0 };
        let start = if depth > 0.0 { tread.cut_turn(0.0) } else { 0.0 };
        if edge > 0.0 {
            self.fill(tread, [0.0, edge], [start, PI], Cut::None, PatchSides::TURN)?;
        }
        if shoulder > 0.0 {
            if depth <= 0.0 {
                self.fill(round, [0.0, FRAC_PI_2], [0.0, PI], Cut::None, PatchSides::NEITHER)?;
            } else if depth < shoulder {
                // The cut is nearly an ellipse in the shoulder's parameters: split where it runs slantwise, so that
                // each part's bent side is smooth.
                let split = round.cut_meridian(0.0) * std::f64::consts::FRAC_1_SQRT_2;
                let turn = round.cut_turn(split);
                let end = (2.5 * start).max(start + 2.0 * shoulder / radius).min(0.5 * PI);
                self.fill(round, [0.0, split], [0.0, 1.0], Cut::Turn { end }, PatchSides::TURN)?;
                self.fill(round, [0.0, 1.0], [0.0, turn], Cut::Meridian { end: FRAC_PI_2 }, PatchSides::MERIDIAN)?;
                self.fill(round, [split, FRAC_PI_2], [turn, end], Cut::None, PatchSides::NEITHER)?;
                self.fill(round, [0.0, FRAC_PI_2], [end, PI], Cut::None, PatchSides::NEITHER)?;
            } else {
                self.fill(round, [0.0, FRAC_PI_2], [0.0, 1.0], Cut::Turn { end: PI }, PatchSides::NEITHER)?;
            }
        }
        if depth > shoulder {
            let turn = side.cut_turn(rim);
            self.fill(side, [0.0, 1.0], [0.0, turn], Cut::Meridian { end: 0.0 }, PatchSides::NEITHER)?;
            self.fill(side, [rim, 0.0], [turn, PI], Cut::None, PatchSides::NEITHER)?;
        } else {
            self.fill(side, [rim, 0.0], [0.0, PI], Cut::None, PatchSides::NEITHER)?;
        }
        if gap > 0.0 {
            let half = body.half_patch();
            let below = Chart::UndersideEdge { radius, shoulder, edge, middle, gap };
            self.fill(Chart::Underside { gap }, [0.0, edge], [0.0, half], Cut::None, PatchSides::BOTH)?;
            self.fill(below, [0.0, 1.0], [0.0, FRAC_PI_2], Cut::None, PatchSides::MERIDIAN)?;
        }
        Ok(())
    }

    /// Cuts a block into rings and these into patches; [`RadiationError::Patches`].
    fn fill(
        &mut self,
        chart: Chart,
        meridian: [f64; 2],
        turn: [f64; 2],
        cut: Cut,
        across: PatchSides,
    ) -> Result<(), RadiationError> {
        // Meaning of a pair of parameters: meridian, turn, and the lengths of a unit of each.
        let meaning = |m: f64, t: f64| match cut {
            Cut::None => (m, t, chart.meridian_length(), chart.axis_distance(m)),
            Cut::Turn { end } => {
                let start = chart.cut_turn(m);
                (m, start + t * (end - start), chart.meridian_length(), (end - start) * chart.axis_distance(m))
            }
            Cut::Meridian { end } => {
                let start = chart.cut_meridian(t);
                let m = start + m * (end - start);
                (m, t, (end - start).abs() * chart.meridian_length(), chart.axis_distance(m))
            }
        };
        let sizes = &self.sizes;
        // 1. Rings, by the size at the begin of the turn.
        let rings = graded(meridian, |m| {
            let (m, t, length, _) = meaning(m, turn[0]);
            let turned = if matches!(chart, Chart::Sphere { .. }) { 1.0 / MOST_TURN } else { 0.0 };
            (length / sizes.at(&chart, m, t, across.meridian)).max(turned)
        })?;
        // 2. Patches of each ring, by its width where it is widest.
        for ring in rings.windows(2) {
            let [inner, outer] = [ring[0], ring[1]];
            let middle = 0.5 * (inner + outer);
            let parts = graded(turn, |t| {
                let wide = [inner, middle, outer].map(|m| meaning(m, t).3).into_iter().fold(0.0, f64::max);
                let (m, angle, ..) = meaning(middle, t);
                let unit = match (cut, chart) {
                    (_, Chart::Underside { .. }) => 0.0,
                    (Cut::Turn { end }, _) => end - chart.cut_turn(m),
                    _ => 1.0,
                };
                (wide / sizes.at(&chart, m, angle, across.turn)).max(unit / MOST_TURN)
            })?;
            counted((self.patches.len() + parts.len() - 1) as f64)?;
            let patch = |part: &[f64]| SurfacePatch { chart, meridian: [inner, outer], turn: [part[0], part[1]], cut };
            self.patches.extend(parts.windows(2).map(patch));
        }
        Ok(())
    }
}

/// Refuses more patches than a mesh may have, and NaN.
fn counted(patches: f64) -> Result<(), RadiationError> {
    if patches <= MOST_PATCHES as f64 {
        return Ok(());
    }
    // Infinity is given as a thousand million.
    Err(RadiationError::Patches { patches: patches.min(1e9) as usize, most: MOST_PATCHES })
}

/// Points at which `density` (parts per unit) is summed.
const STEPS: usize = 256;

/// Cuts a range into the fewest parts none of which holds more than one by `density`, equally full;
/// [`RadiationError::Patches`] before any part is made.
fn graded([from, to]: [f64; 2], density: impl Fn(f64) -> f64) -> Result<Vec<f64>, RadiationError> {
    let step = (to - from) / STEPS as f64;
    let mut sums = vec![0.0];
    let mut sum = 0.0;
    for index in 0..STEPS {
        sum += density(from + (index as f64 + 0.5) * step) * step.abs();
        sums.push(sum);
    }
    counted(sum)?;
    // Equal parts of the sum, interpolated linearly between its points.
    let parts = (sum - 1e-9).ceil().max(1.0) as usize;
    let mut breaks = vec![from];
    let mut index = 0;
    for part in 1..parts {
        let wanted = sum * part as f64 / parts as f64;
        while sums[index + 1] < wanted {
            index += 1;
        }
        let fraction = (wanted - sums[index]) / (sums[index + 1] - sums[index]);
        breaks.push(from + (index as f64 + fraction) * step);
    }
    breaks.push(to);
    Ok(breaks)
}
