//! Files of radiation cases: from bodies, wavenumbers and velocities or sources to pressures and powers.
//!
//! The format (JSON): `density` \[kg/m^3\], `sound_speed` \[m/s\], `nodes_per_wavelength`, and `cases`, a list of
//! - `name`, `wavenumber` \[rad/m\], `plane` (whether there is a rigid road z = 0);
//! - `body`: `{"shape": "sphere", "radius", "height"}`, height that of the middle (less than the radius: cut by the
//!   plane), or `{"shape": "tyre", "radius", "width", "shoulder", "height"}`, its axis along y, `width` that of the
//!   body with its shoulders. With a plane `height` is required; without one the middle is the origin, and `height`, if
//!   given, is where it is moved to;
//! - either `velocity`: `"uniform"`, and for a sphere `"heave"` (cos theta from +z), `"sway"` (sin theta cos phi), for
//!   a tyre `{"circumferential": m, "across": 1}` (cos(m phi) cos(pi y/width) on the straight tread, phi from +x, 0
//!   elsewhere), all of 1 m/s, with `receivers`: \[\[x, y, z\]\] \[m\], in the air or on the surface;
//! - or `source`: \[x, y, z\] with `points`: \[\[x, y, z\]\] on the surface.
//!
//! The results are `{"cases": [...]}` in that order: `pressure` \[\[re, im\]\] \[Pa\] and `power` \[W\], or `green`
//! \[1/m\].

use num_complex::Complex64;
use serde::Deserialize;
use serde_json::{Value, json};
use thiserror::Error;

use super::body::{BodyShape, RadiatingBody, Vector};
use super::chart::Chart;
use super::error::RadiationError;
use super::mesh::MeshResolution;
use super::parity::ParityBlock;
use super::solve::{Drive, RadiationProblem};

/// Errors of a file of cases.
#[derive(Debug, Error)]
pub enum RadiationCasesError {
    /// Not JSON, or not this format.
    #[error("not a file of radiation cases: {0}")]
    Format(#[from] serde_json::Error),
    /// A number out of range.
    #[error("{place}: {what}")]
    Range {
        /// Name of the case, or the file itself.
        place: String,
        /// Fault and remedy.
        what: &'static str,
    },
    /// A case that cannot be computed.
    #[error("{place}: {source}")]
    Case {
        /// Name of the case.
        place: String,
        /// Reason.
        source: RadiationError,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    density: f64,
    sound_speed: f64,
    nodes_per_wavelength: f64,
    cases: Vec<CaseEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseEntry {
    name: String,
    body: BodyEntry,
    plane: bool,
    wavenumber: f64,
    velocity: Option<VelocityEntry>,
    receivers: Option<Vec<Vector>>,
    source: Option<Vector>,
    points: Option<Vec<Vector>>,
}

#[derive(Deserialize)]
#[serde(tag = "shape", rename_all = "lowercase", deny_unknown_fields)]
enum BodyEntry {
    Sphere { radius: f64, height: Option<f64> },
    Tyre { radius: f64, width: f64, shoulder: f64, height: Option<f64> },
}

#[derive(Clone, Copy, Deserialize)]
#[serde(untagged)]
enum VelocityEntry {
    Named(Named),
    Wave(Wave),
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Named {
    Uniform,
    Heave,
    Sway,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct Wave {
    circumferential: u32,
    across: u32,
}

/// Highest order around a tyre: the mesh must resolve it.
const MOST_AROUND: u32 = 64;

enum Fault {
    Range(&'static str),
    Radiation(RadiationError),
}

impl From<RadiationError> for Fault {
    fn from(error: RadiationError) -> Self {
        Self::Radiation(error)
    }
}

/// Computes all cases of a file's text within a memory limit \[bytes\], unless it is interrupted.
///
/// # Errors
/// The first case that is wrong, by its name; `RadiationError::Interrupted` in the case where it was.
pub fn evaluate(text: &str, memory_limit: u64, interrupted: &dyn Fn() -> bool) -> Result<Value, RadiationCasesError> {
    let document: Document = serde_json::from_str(text)?;
    let positive = |value: f64| value > 0.0 && value.is_finite();
    let numbers = [document.density, document.sound_speed, document.nodes_per_wavelength];
    if !numbers.into_iter().all(positive) {
        return Err(RadiationCasesError::Range {
            place: "the file".to_owned(),
            what: "density, sound_speed and nodes_per_wavelength must be positive",
        });
    }
    let mut answers = Vec::with_capacity(document.cases.len());
    for (index, case) in document.cases.iter().enumerate() {
        let answer = answer(&document, case, memory_limit, interrupted).map_err(|fault| {
            let place = format!("case {index} '{}'", case.name);
            match fault {
                Fault::Range(what) => RadiationCasesError::Range { place, what },
                Fault::Radiation(source) => RadiationCasesError::Case { place, source },
            }
        })?;
        answers.push(answer);
    }
    Ok(json!({ "cases": answers }))
}

fn answer(
    document: &Document,
    case: &CaseEntry,
    memory_limit: u64,
    interrupted: &dyn Fn() -> bool,
) -> Result<Value, Fault> {
    let (shape, height) = match case.body {
        BodyEntry::Sphere { radius, height } => (BodyShape::Sphere { radius }, height),
        BodyEntry::Tyre { radius, width, shoulder, height } => (BodyShape::Tyre { radius, width, shoulder }, height),
    };
    if case.plane && height.is_none() {
        return Err(Fault::Range("with a plane the body must have a height"));
    }
    if height.is_some_and(|height| !height.is_finite()) {
        return Err(Fault::Range("height must be finite"));
    }
    let body = RadiatingBody::new(shape, height.filter(|_| case.plane))?;
    // Without a plane a body at a height is the same one at the origin with everything else moved.
    let shift = if case.plane { 0.0 } else { height.unwrap_or(0.0) };
    let moved = |points: &[Vector]| points.iter().map(|&[x, y, z]| [x, y, z - shift]).collect::<Vec<_>>();
    let resolution = MeshResolution::of(document.nodes_per_wavelength);
    let k = case.wavenumber;
    match case {
        CaseEntry { velocity: Some(velocity), receivers: Some(receivers), source: None, points: None, .. } => {
            let velocity = CaseMotion::of(*velocity, &body)?;
            let receivers = moved(receivers);
            let on_surface = |&point: &Vector| body.check_surface_point(point).is_ok();
            for receiver in &receivers {
                if !on_surface(receiver) {
                    body.check_receiver(*receiver)?;
                }
            }
            let finest = k.max(velocity.wavenumber(&body));
            let problem = RadiationProblem::new(&body, k, finest, &resolution, &ParityBlock::ALL, memory_limit)?;
            let impedance = document.density * document.sound_speed * k;
            let drive =
                |chart: &Chart, point: Vector| Complex64::new(0.0, impedance * velocity.at(&body, chart, point));
            let drives = [Drive::Velocity(&drive)];
            let mut solution = problem.solve_unless(&drives, interrupted)?;
            let mut pressures = vec![Complex64::ZERO; receivers.len()];
            for surface in [false, true] {
                let chosen: Vec<usize> =
                    (0..receivers.len()).filter(|&i| on_surface(&receivers[i]) == surface).collect();
                let points: Vec<Vector> = chosen.iter().map(|&index| receivers[index]).collect();
                if !points.is_empty() {
                    for (&index, &pressure) in chosen.iter().zip(&solution.field(&points, surface)[0]) {
                        pressures[index] = pressure;
                    }
                }
            }
            let power = solution.power(0, impedance);
            if !power.is_finite() {
                return Err(NOT_FINITE);
            }
            Ok(json!({ "pressure": numbers(&pressures)?, "power": power }))
        }
        CaseEntry { velocity: None, receivers: None, source: Some(source), points: Some(points), .. } => {
            let points = moved(points);
            for &point in &points {
                body.check_surface_point(point)?;
            }
            let problem = RadiationProblem::new(&body, k, k, &resolution, &ParityBlock::ALL, memory_limit)?;
            let drives = [Drive::Source(moved(&[*source])[0])];
            let mut solution = problem.solve_unless(&drives, interrupted)?;
            Ok(json!({ "green": numbers(&solution.field(&points, true)[0])? }))
        }
        _ => Err(Fault::Range("a case has either velocity and receivers, or source and points")),
    }
}

/// JSON has no such numbers, and would have `null` in their place.
const NOT_FINITE: Fault = Fault::Range("its field is not finite: its numbers are beyond all bounds");

fn numbers(values: &[Complex64]) -> Result<Vec<[f64; 2]>, Fault> {
    let finite = |value: &Complex64| value.is_finite().then_some([value.re, value.im]);
    values.iter().map(finite).collect::<Option<_>>().ok_or(NOT_FINITE)
}

/// Shape of a normal velocity of 1 m/s.
#[derive(Clone, Copy)]
enum CaseMotion {
    Uniform,
    Heave,
    Sway,
    Wave { around: f64, across: f64 },
}

impl CaseMotion {
    fn of(entry: VelocityEntry, body: &RadiatingBody) -> Result<Self, Fault> {
        match (entry, body.shape()) {
            (VelocityEntry::Named(Named::Uniform), _) => Ok(Self::Uniform),
            (VelocityEntry::Named(Named::Heave), BodyShape::Sphere { .. }) => Ok(Self::Heave),
            (VelocityEntry::Named(Named::Sway), BodyShape::Sphere { .. }) => Ok(Self::Sway),
            (VelocityEntry::Named(_), _) => Err(Fault::Range("heave and sway are motions of a sphere")),
            (VelocityEntry::Wave(Wave { circumferential, across }), BodyShape::Tyre { width, .. }) => {
                if across != 1 {
                    return Err(Fault::Range("across must be 1"));
                }
                if circumferential > MOST_AROUND {
                    return Err(Fault::Range("circumferential must be at most 64"));
                }
                Ok(Self::Wave { around: f64::from(circumferential), across: std::f64::consts::PI / width })
            }
            (VelocityEntry::Wave(_), _) => Err(Fault::Range("a velocity of waves is that of a tyre")),
        }
    }

    /// Wavenumber of the velocity, which the mesh must resolve \[rad/m\].
    fn wavenumber(&self, body: &RadiatingBody) -> f64 {
        match *self {
            Self::Wave { around, across } => (around / body.radius()).hypot(across),
            _ => 0.0,
        }
    }

    fn at(&self, body: &RadiatingBody, chart: &Chart, [x, y, z]: Vector) -> f64 {
        let z = z - body.middle();
        match *self {
            Self::Uniform => 1.0,
            Self::Heave => z / body.radius(),
            Self::Sway => x / body.radius(),
            Self::Wave { around, across } => match chart {
                Chart::Tread { .. } => (around * z.atan2(x)).cos() * (across * y).cos(),
                _ => 0.0,
            },
        }
    }
}
