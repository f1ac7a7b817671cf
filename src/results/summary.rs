//! `summary.json`: what was run, its results and its cost, for people and for scripts.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

pub(crate) use super::cost::{Planned, RunCost};
use super::error::ResultsError;
use super::inputs::Input;
use super::sound::SoundSummary;
use super::vibration::VibrationSummary;
use crate::response::SliceErrors;
use crate::scene::settings_hash;
use crate::storage::input::{self, TABLE_BYTES};

pub(crate) const SUMMARY_FILE: &str = "summary.json";

/// The summary of a results folder as a value of any type; `None` if it cannot be read as one.
pub(crate) fn read_summary<T: DeserializeOwned>(folder: &Path) -> Option<T> {
    serde_json::from_slice(&input::read(&folder.join(SUMMARY_FILE), TABLE_BYTES).ok()?).ok()
}

/// Value of `format` in every summary.
pub(crate) const FORMAT: &str = "tyrewave results";
/// Version of the layout of the results folder; raised when older readers would fail.
pub(crate) const FORMAT_VERSION: u32 = 1;

/// Content of `summary.json`. Numbers that do not exist (no load given, nothing counted yet) are `null`.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Summary {
    /// Always `tyrewave results`.
    pub format: Cow<'static, str>,
    /// Version of the layout of the folder.
    pub format_version: u32,
    /// Version of tyrewave.
    pub version: Cow<'static, str>,
    /// True if the run reached its end; false for an interrupted one, whose arrays are shorter.
    pub complete: bool,
    /// Title of the scene.
    pub title: String,
    /// SHA-256 of the scene as it was run, in hexadecimal.
    pub scene_sha256: String,
    /// Files that the scene reads, where it reads any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<Input>,
    /// Results of the run.
    pub outcome: Outcome,
    /// Residuals of the contact conditions.
    pub contact: ContactQuality,
    /// Vibration of the tyre, where it was requested and the run was long enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) vibration: Option<VibrationSummary>,
    /// Sound at the receivers, where there are any and the run was long enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sound: Option<SoundSummary>,
    /// Finer mesh whose levels are reported, where they are not those of the run's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub levels: Option<FinerMesh>,
    /// Warnings that the user should act on.
    pub warnings: Vec<String>,
    /// Settings that were chosen, and results that the run leaves out.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Cost of the run.
    pub(crate) cost: RunCost,
    /// The effective settings: the scene with every default filled in.
    pub settings: serde_json::Value,
    /// Names of all files in the folder; filled in when it is completed.
    pub files: Vec<String>,
}

/// Mesh to which the levels of a run are corrected.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct FinerMesh {
    /// Its elements round the tyre.
    pub elements: usize,
    /// Time that it and the run's mesh have both rolled after the warm-up \[s\].
    pub seconds: f64,
    /// Standard error wanted of third octaves \[dB\].
    pub standard_error: f64,
    /// Segments of the run's road that were rolled side by side.
    #[serde(default = "one")]
    pub segments: usize,
}

fn one() -> usize {
    1
}

/// Results after the warm-up.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Outcome {
    /// Number of time steps, warm-up included: the rows of the arrays.
    pub steps: u64,
    /// Time step \[s\].
    pub time_step: f64,
    /// Time simulated, warm-up included \[s\].
    pub simulated_time: f64,
    /// Mean total contact force \[N\].
    pub mean_force: Option<f64>,
    /// Root mean square of the force less its mean \[N\].
    pub rms_force_variation: Option<f64>,
    /// Mean length of the contact patch \[m\].
    pub mean_contact_length: Option<f64>,
    /// Road texture and axle: indentation of the rigid tyre into z = 0 \[m\].
    pub indentation: Option<f64>,
    /// Given load, and how closely it was met.
    pub load: Option<LoadResult>,
    /// Motion of an axle that has a mass.
    pub axle: Option<AxleMotion>,
    /// Rolling resistance; `None` where the tread law has none.
    pub rolling_resistance: Option<RollingResistance>,
    /// Patch of contact over cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells: Option<CellsSummary>,
    /// Tangential forces, where the contact has friction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<FrictionSummary>,
}

/// Patch of contact over cells, means after the warm-up.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct CellsSummary {
    /// Number of cells across.
    pub across: usize,
    /// Area of the cells that carry force \[m^2\].
    pub mean_area: f64,
    /// Force over that area \[Pa\].
    pub mean_pressure: f64,
    /// Mean over time of the largest pressure on a cell \[Pa\].
    pub mean_peak_pressure: f64,
}

/// Mean power that the contact puts into the tyre, which dissipates it, as a resistance to rolling.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct RollingResistance {
    /// Resistance force over the mean contact force.
    pub coefficient: f64,
    /// Resistance force: power over the speed \[N\].
    pub force: f64,
    /// Power: mean of forces times velocities \[W\].
    pub power: f64,
}

impl RollingResistance {
    /// Names of its columns in tables.
    pub const COLUMNS: [&str; 3] = ["rolling_resistance", "rolling_resistance_n", "rolling_resistance_w"];

    /// Its cells in tables, in the order of [`Self::COLUMNS`], written so that reading gives the same bits; empty for
    /// `None`.
    pub fn cells(resistance: Option<Self>) -> [String; 3] {
        resistance.map_or_else(Default::default, |Self { coefficient, force, power }| {
            [coefficient, force, power].map(|number| number.to_string())
        })
    }
}

/// Height of an axle that moves, after the warm-up.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct AxleMotion {
    /// Mean indentation of the rigid tyre into z = 0 \[m\].
    pub mean: f64,
    /// Root mean square of the indentation less its mean \[m\].
    pub rms_variation: f64,
}

/// Given axle load, and the mean force that was reached.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct LoadResult {
    /// Given load \[N\].
    pub wanted: f64,
    /// (mean force - load)/load.
    pub relative_error: f64,
    /// Tolerance of the relative error.
    pub tolerance: f64,
    /// True if the error is within the tolerance.
    pub met: bool,
}

impl fmt::Display for LoadResult {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { wanted, relative_error, tolerance, .. } = self;
        let [off, allowed] = [relative_error, tolerance].map(|share| 100.0 * share);
        write!(formatter, "the mean force is {off:+.2} % off the load of {wanted} N (tolerance {allowed} %)")
    }
}

/// Tangential forces of a contact with friction, means after the warm-up.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct FrictionSummary {
    /// Mean longitudinal force on the tyre, forward above 0 \[N\].
    pub mean_longitudinal_force: f64,
    /// Mean lateral force on the tyre, to the left above 0 \[N\].
    pub mean_lateral_force: f64,
    /// Mean moment about the vertical under the axle \[N m\].
    pub mean_aligning_moment: f64,
    /// Mean power that friction dissipates \[W\].
    pub mean_slip_power: f64,
    /// Mean share of the pressed cells that slip.
    pub slipping_share: f64,
    /// Rolling resistance by slip: slip power over speed and mean force. Together with that by hysteresis,
    /// `rolling_resistance`, it is the whole resistance.
    pub slip_resistance: f64,
    /// Mean longitudinal creep.
    #[serde(default)]
    pub mean_creep: f64,
    /// Mean torque of the contact about the axle, positive for a forward force \[N m\].
    #[serde(default)]
    pub mean_torque: f64,
    /// Free rolling, where the scene asks for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub free: Option<FreeRolling>,
}

/// Free rolling of a wheel, after the warm-up.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct FreeRolling {
    /// Mean longitudinal creep.
    pub creep: f64,
    /// Mean torque over that of full sliding: coefficient of friction times mean force times radius.
    pub relative_torque: f64,
    /// Largest magnitude of the relative torque.
    pub tolerance: f64,
    /// True if the torque is within it.
    pub met: bool,
}

impl fmt::Display for FreeRolling {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { relative_torque, tolerance, .. } = self;
        write!(
            formatter,
            "the wheel does not roll freely: its mean torque is {relative_torque:+.1e} of that of sliding, bound \
             {tolerance:.0e}; a longer rolling.duration brings it down"
        )
    }
}

/// Largest residuals of the three conditions of the contact problem over all steps, and the work of the search.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct ContactQuality {
    /// F >= 0: largest tension, relative to the peak force.
    pub tension: f64,
    /// u >= d: largest penetration, relative to the largest required indentation.
    pub penetration: f64,
    /// F.(u - d) = 0: largest violation, relative to the peaks of both.
    pub complementarity: f64,
    /// Largest difference of a slice's curve from that of all its cells, due to breakpoints that are left out \[m\].
    pub slice_error: f64,
    /// kappa \[m/Pa\] of the local law: a slice yields like a spring of compliance kappa/(dx b). `None` for the laws of
    /// the paper.
    pub local_compliance: Option<f64>,
    /// Errors of levels by slices compared with cells; `None` where they are not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) slices: Option<SliceErrors>,
    /// Number of aborted searches: always 0, or the run has failed.
    pub aborted_searches: u64,
    /// Number of steps by the number of linear solves that they took.
    pub solves_per_step: BTreeMap<u32, u64>,
}

impl Summary {
    /// Summary of a run that has begun: the first fields filled in, no results, not complete.
    pub(crate) fn begun(title: &str, settings: serde_json::Value, cost: RunCost) -> Self {
        Self {
            format: FORMAT.into(),
            format_version: FORMAT_VERSION,
            version: env!("CARGO_PKG_VERSION").into(),
            complete: false,
            title: title.to_owned(),
            scene_sha256: settings_hash(&settings),
            inputs: Vec::new(),
            outcome: Outcome::default(),
            contact: ContactQuality::default(),
            vibration: None,
            sound: None,
            levels: None,
            warnings: Vec::new(),
            notes: Vec::new(),
            cost,
            settings,
            files: Vec::new(),
        }
    }

    /// Pretty-printed JSON with a newline at the end; keys in a fixed order, those of the settings sorted.
    ///
    /// # Errors
    /// [`ResultsError::Json`], which names `path`.
    pub fn to_json(&self, path: &Path) -> Result<String, ResultsError> {
        let mut text = serde_json::to_string_pretty(self)
            .map_err(|source| ResultsError::Json { path: path.to_owned(), source })?;
        text.push('\n');
        Ok(text)
    }
}

/// Part of a summary by which a results folder is recognised as one that may be replaced.
#[derive(Debug, Deserialize)]
pub(super) struct Marker {
    pub(super) format: String,
    #[serde(default)]
    pub(super) complete: bool,
    #[serde(default)]
    pub(super) files: Vec<String>,
}

#[cfg(test)]
pub(super) mod tests {
    use std::time::Duration;

    use serde_json::{Value, json};

    use super::*;
    use crate::counters::{Counter, Meter, Stage};

    pub(in crate::results) fn example() -> Summary {
        let mut meter = Meter::default();
        meter.add_time(Stage::Influence, Duration::from_millis(1250));
        meter.add_time(Stage::History, Duration::from_millis(40));
        meter.add_time(Stage::History, Duration::from_millis(2));
        meter.count(Counter::Steps, 1234);
        Summary::begun(
            "A \"title\"",
            json!({"tyre": {"width": 0.2}, "rolling": {"speed_kmh": 80.0}}),
            RunCost::new(&meter, 1.5, 2),
        )
    }

    #[test]
    fn says_what_it_must_in_a_fixed_order() {
        let mut summary = example();
        summary.outcome.mean_force = Some(3924.0);
        summary.outcome.load =
            Some(LoadResult { wanted: 3900.0, relative_error: 24.0 / 3900.0, tolerance: 0.01, met: true });
        summary.contact.solves_per_step = [(1, 900), (2, 300), (11, 34)].into();
        let text = summary.to_json(Path::new("summary.json")).unwrap();
        assert_eq!(text, summary.clone().to_json(Path::new("x")).unwrap());
        let keys: Vec<&str> =
            text.lines().filter(|l| l.starts_with("  \"")).filter_map(|l| l.split('"').nth(1)).collect();
        let expected = "format format_version version complete title scene_sha256 outcome contact warnings notes \
                        cost settings files";
        assert_eq!(keys.join(" "), expected);
        let value: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(value["complete"], json!(false));
        assert_eq!(value["cost"]["stages"]["history"]["calls"], json!(2));
        assert_eq!(value["cost"]["stages"]["influence"]["seconds"], json!(1.25));
        assert_eq!(value["cost"]["counters"]["steps"], json!(1234));
        assert_eq!(value["contact"]["solves_per_step"]["11"], json!(34));
        assert_eq!(value["outcome"]["mean_contact_length"], Value::Null);
        assert!(
            text.find("\"influence\"") < text.find("\"history\""),
            "stages in the data's order, not the alphabet's"
        );
        assert!(text.ends_with("}\n"));
    }

    #[test]
    fn the_hash_knows_the_settings_not_their_order() {
        let one: Value = serde_json::from_str(r#"{"a": 1.5, "b": {"c": 2, "d": 3}}"#).unwrap();
        let two: Value = serde_json::from_str(r#"{"b": {"d": 3, "c": 2}, "a": 1.5}"#).unwrap();
        let other: Value = serde_json::from_str(r#"{"b": {"d": 3, "c": 2}, "a": 1.25}"#).unwrap();
        assert_eq!(settings_hash(&one), settings_hash(&two));
        assert_ne!(settings_hash(&one), settings_hash(&other));
        // sha256sum of the two bytes "{}".
        assert_eq!(settings_hash(&json!({})), "44136fa355b3678a1146ad16f7e8649e94fb4fc21fe77e8310c060f61caaff8a");
    }
}
