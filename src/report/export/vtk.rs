//! The contact patch over time for ParaView and other readers of VTK's XML: a file of polygons (`.vtp`) for each
//! instant and a collection (`.pvd`) that knows their times.
//!
//! A polygon is what the run has pressed individually: an element over the whole contact width, or a cell of the patch
//! where cells were written (`outputs.cells_every`). Points are in metres from the axle's foot: x along the road in the
//! direction of travel, y across, z = 0, which is the zero of the road's heights; where the force of a step is a mean
//! over it, as with `sdirk2`, they are those of the step's middle. Every polygon has its force \[N\] and its mean
//! pressure \[Pa\].

use std::fmt::Write;

use super::error::ExportError;
use crate::effects::stored::{Stored, StoredArray};

/// Begin of every exported file, by which an earlier export is recognised.
pub const VTK_HEAD: &str = "<?xml version=\"1.0\"?>\n<!-- A contact patch of tyrewave. -->\n";

/// Most instants of an export.
const MOST_FRAMES: usize = 400;

/// The contact patch over time.
pub(crate) struct Patch {
    /// Forces \[N\]: instants, then columns along, then cells across.
    force: StoredArray,
    /// Instants of the export: the row of `force`, the step of the run, and its time \[s\].
    frames: Vec<(usize, usize, f64)>,
    /// Number of requested instants beyond the most of an export.
    left_out: usize,
    /// Number of the first element of the window, for each step.
    first_element: Vec<f64>,
    /// Numbers of elements along the window, and of cells across.
    cells: [usize; 2],
    /// Size of a cell along and across \[m\].
    size: [f64; 2],
    speed: f64,
    /// Position of the axle at t = 0, in the road's coordinate \[m\].
    start: f64,
    /// Time from the instant at which a force acts to the end of its step \[s\].
    lag: f64,
}

impl Patch {
    /// Reads a patch: instants after the warm-up at least `every` \[s\] apart, or evenly over the run; 400 at most.
    ///
    /// # Errors
    /// [`ExportError`].
    pub(crate) fn open(stored: &Stored, every: Option<f64>) -> Result<Self, ExportError> {
        let plan = &stored.plan;
        let missing = || ExportError::Missing { what: "forces of the patch", key: "outputs.arrays" };
        let first_element = stored.column("patch_element.npy")?.ok_or_else(missing)?;
        let (file, force, steps) = match (stored.array("cells.npy")?, stored.column("cells_time.npy")?) {
            (Some(cells), Some(times)) => {
                let steps = times.iter().map(|time| (time / plan.time_step).round() as usize).collect();
                ("cells.npy", cells, steps)
            }
            _ => {
                let force = stored.array("patch_force.npy")?.ok_or_else(missing)?;
                ("patch_force.npy", force, (0..first_element.len()).collect::<Vec<_>>())
            }
        };
        let across = stored.summary.outcome.cells.filter(|_| file == "cells.npy").map_or(1, |cells| cells.across);
        let misfit = || ExportError::Shape { file };
        let &[rows, in_a_row] = &force.shape[..] else { return Err(misfit()) };
        if rows != steps.len() || !in_a_row.is_multiple_of(across) || in_a_row < across {
            return Err(misfit());
        }
        if steps.iter().any(|&step| step >= first_element.len()) {
            return Err(misfit());
        }
        let counted: Vec<(usize, usize, f64)> = steps
            .into_iter()
            .enumerate()
            .filter(|&(_, step)| step as u64 >= plan.warm_up_steps)
            .map(|(row, step)| (row, step, step as f64 * plan.time_step))
            .collect();
        let mut frames = apart(&counted, every);
        let left_out = frames.len().saturating_sub(MOST_FRAMES);
        frames.truncate(MOST_FRAMES);
        if frames.is_empty() {
            return Err(ExportError::Missing { what: "forces of the patch after the warm-up", key: "outputs.arrays" });
        }
        let start = start(stored, first_element[0], in_a_row / across);
        let patch = Self {
            cells: [in_a_row / across, across],
            size: [plan.element, plan.scene.tyre.contact_width / across as f64],
            speed: plan.speed,
            force,
            frames,
            left_out,
            first_element,
            start,
            lag: lag(stored),
        };
        Ok(patch)
    }

    /// Number of instants.
    pub(crate) fn len(&self) -> usize {
        self.frames.len()
    }

    /// Note on the instants that are left out; `None` if none is.
    pub(crate) fn note(&self) -> Option<String> {
        let last = self.frames.last().map_or(0.0, |frame| frame.2);
        let cut = || format!("{} instants after {last:.4} s are left out: {MOST_FRAMES} are the most", self.left_out);
        (self.left_out > 0).then(cut)
    }

    /// Name of an instant's file.
    pub(crate) fn file(frame: usize) -> String {
        format!("patch_{frame:04}.vtp")
    }

    /// Content of an instant's file.
    pub(crate) fn frame(&self, frame: usize) -> String {
        let (row, step, time) = self.frames[frame];
        let [along, across] = self.cells;
        let [dx, dy] = self.size;
        let force = &self.force.values[row * along * across..][..along * across];
        let face = dx * dy;
        let first = self.first_element[step];
        let axle = self.start + self.speed * (time - self.lag);
        let mut points = Vec::with_capacity(3 * (along + 1) * (across + 1));
        for column in 0..=along {
            let x = (first + column as f64 - 0.5) * dx - axle;
            for edge in 0..=across {
                points.extend([x, (edge as f64 - 0.5 * across as f64) * dy, 0.0]);
            }
        }
        let corner = |column: usize, edge: usize| column * (across + 1) + edge;
        let polygons = (0..along).flat_map(|column| (0..across).map(move |cell| (column, cell)));
        let corners = polygons.flat_map(|(column, cell)| {
            [corner(column, cell), corner(column + 1, cell), corner(column + 1, cell + 1), corner(column, cell + 1)]
        });
        let ends = (1..=along * across).map(|polygon| 4 * polygon);
        let elements = (0..along * across).map(|polygon| first as i64 + (polygon / across) as i64);
        let pressures = force.iter().map(|force| force / face);
        let counts = format!("NumberOfPoints=\"{}\" NumberOfPolys=\"{}\"", points.len() / 3, along * across);
        let mut text = opened("PolyData");
        text.push_str("<PolyData>\n<FieldData>\n");
        array(&mut text, "Float64", "TimeValue", "NumberOfTuples=\"1\"", [time]);
        let _ = writeln!(
            text,
            "</FieldData>\n<Piece {counts} NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\">"
        );
        text.push_str("<CellData Scalars=\"pressure_Pa\">\n");
        array(&mut text, "Float64", "force_N", "", force.iter().copied());
        array(&mut text, "Float64", "pressure_Pa", "", pressures);
        array(&mut text, "Int64", "element", "", elements);
        text.push_str("</CellData>\n<Points>\n");
        array(&mut text, "Float64", "Points", "NumberOfComponents=\"3\"", points);
        text.push_str("</Points>\n<Polys>\n");
        array(&mut text, "Int64", "connectivity", "", corners);
        array(&mut text, "Int64", "offsets", "", ends);
        text.push_str("</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n");
        text
    }

    /// Content of the collection of all instants.
    pub(crate) fn collection(&self) -> String {
        let mut text = opened("Collection");
        text.push_str("<Collection>\n");
        for (frame, (.., time)) in self.frames.iter().enumerate() {
            let _ = writeln!(text, "<DataSet timestep=\"{time}\" part=\"0\" file=\"{}\"/>", Self::file(frame));
        }
        text.push_str("</Collection>\n</VTKFile>\n");
        text
    }
}

/// Instants at least `every` \[s\] apart, or evenly over the run so that an export holds them.
fn apart(instants: &[(usize, usize, f64)], every: Option<f64>) -> Vec<(usize, usize, f64)> {
    let Some(every) = every else {
        return instants.iter().copied().step_by(instants.len().div_ceil(MOST_FRAMES).max(1)).collect();
    };
    let begin = instants.first().map_or(0.0, |instant| instant.2);
    let mut taken = Vec::new();
    let mut next = 0.0;
    for instant in instants {
        // The first instant of every interval of this length; the margin covers rounding of times.
        let passed = (instant.2 - begin) / every * (1.0 + 1e-9);
        if passed >= next {
            taken.push(*instant);
            next = passed.floor() + 1.0;
        }
    }
    taken
}

/// Position of the axle at t = 0 \[m\]. If the scene leaves it open, it is above the element in the middle of the first
/// window.
fn start(stored: &Stored, first: f64, columns: usize) -> f64 {
    let open = (first + (columns / 2) as f64 - 1.0) * stored.plan.element;
    stored.plan.scene.rolling.start.unwrap_or(open)
}

/// Time from the instant at which a force acts to the end of its step \[s\]: rules with several solves give a mean over
/// the step.
fn lag(stored: &Stored) -> f64 {
    let rule = stored.plan.scene.numerics.time_rule;
    let parts = rule.nodes().iter().zip(rule.weights());
    stored.plan.time_step * (1.0 - parts.map(|(node, weight)| node * weight).sum::<f64>())
}

fn opened(kind: &str) -> String {
    format!("{VTK_HEAD}<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n")
}

fn array(text: &mut String, kind: &str, name: &str, more: &str, numbers: impl IntoIterator<Item: std::fmt::Display>) {
    let _ = write!(text, "<DataArray type=\"{kind}\" Name=\"{name}\" {more} format=\"ascii\">");
    for number in numbers {
        let _ = write!(text, " {number}");
    }
    text.push_str(" </DataArray>\n");
}
