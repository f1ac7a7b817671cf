//! A MATLAB file of all arrays and tables of a run; `scipy.io.loadmat` and Octave read it as well.
//!
//! An array is a matrix named after its file, a table a struct of its columns, whose names contain their units. A sound
//! is a matrix of pressures over time, a column per channel, at `run.sample_rate`. The struct `units` has the units of
//! the arrays and of the figures in the struct `run`.

use super::error::ExportError;
use super::mat_file::{self, Value};
use crate::effects::channel;
use crate::effects::stored::Stored;
use crate::results::read_table::StoredColumn;
use crate::sound::wav;

/// Begin of every exported file, by which an earlier export is recognised.
pub const MAT_HEAD: &str = "MATLAB 5.0 MAT-file, Platform: tyrewave,";

/// Content of the file.
///
/// # Errors
/// [`ExportError`].
pub(crate) fn mat(stored: &Stored) -> Result<Vec<u8>, ExportError> {
    let mut variables = Vec::new();
    let (mut run, mut units) = figures(stored);
    let mut sample_rate = None;
    for file in &stored.summary.files {
        let (stem, extension) = file.rsplit_once('.').unwrap_or((file, ""));
        match extension {
            "npy" => {
                let Some(array) = stored.array(file)? else { continue };
                let name = free(&variables, stem);
                let unit = channel(stem).map_or("", |channel| channel.unit);
                let shape = [array.shape.first().copied().unwrap_or(1), array.shape.iter().skip(1).product()];
                units.push((name.clone(), Value::Text(unit.into())));
                variables.push((name, Value::Numbers(array.values, shape)));
            }
            "csv" => {
                let Some(table) = stored.table(file)? else { continue };
                let mut fields = Vec::new();
                for (column, cells) in table.columns {
                    let value = match cells {
                        StoredColumn::Numbers(numbers) => Value::column(numbers),
                        StoredColumn::Words(words) => Value::Cells(words.into_iter().map(Value::Text).collect()),
                    };
                    fields.push((free(&fields, &column), value));
                }
                variables.push((free(&variables, stem), Value::Struct(fields)));
            }
            "wav" => {
                let Some(sound) = wav::recording(&stored.bytes(file)?) else { continue };
                let name = free(&variables, stem);
                let shape = [sound.channels.first().map_or(0, Vec::len), sound.channels.len()];
                let row = |sample: usize| sound.channels.iter().map(move |channel| channel[sample]);
                let values = (0..shape[0]).flat_map(row).collect();
                units.push((name.clone(), Value::Text("Pa".into())));
                variables.push((name, Value::Numbers(values, shape)));
                sample_rate = Some(f64::from(sound.rate));
            }
            _ => {}
        }
    }
    if let Some(rate) = sample_rate {
        run.push(("sample_rate".into(), Value::column(vec![rate])));
        units.push(("sample_rate".into(), Value::Text("Hz".into())));
    }
    variables.push(("run".into(), Value::Struct(run)));
    variables.push(("units".into(), Value::Struct(units)));
    let about = format!("{} {}, {}", "version", stored.summary.version, stored.name());
    mat_file::file(MAT_HEAD, &about, &variables)
}

type Fields = Vec<(String, Value)>;

/// Single numbers and texts beside the arrays, and their units.
fn figures(stored: &Stored) -> (Fields, Fields) {
    let plan = &stored.plan;
    let mut run: Fields = [
        ("name", stored.name()),
        ("title", stored.summary.title.clone()),
        ("version", stored.summary.version.clone().into_owned()),
    ]
    .map(|(name, text)| (name.to_owned(), Value::Text(text)))
    .into();
    let mut units = Fields::new();
    for (name, unit, number) in [
        ("time_step", "s", plan.time_step),
        ("warm_up", "s", plan.scene.rolling.warm_up),
        ("speed", "m/s", plan.speed),
        ("element_length", "m", plan.element),
        ("circumference", "m", plan.scene.tyre.circumference),
        ("contact_width", "m", plan.scene.tyre.contact_width),
        ("mean_force", "N", stored.summary.outcome.mean_force.unwrap_or(f64::NAN)),
    ] {
        run.push((name.into(), Value::column(vec![number])));
        units.push((name.into(), Value::Text(unit.into())));
    }
    (run, units)
}

/// A valid name made from the text that none of the others has.
fn free(taken: &[(String, Value)], text: &str) -> String {
    let is_free = |name: &String| taken.iter().all(|(other, _)| other != name);
    let first = mat_file::name(text);
    let more = (2_usize..).map(|count| mat_file::name(&format!("x{count}_{text}")));
    std::iter::once(first.clone()).chain(more).find(is_free).unwrap_or(first)
}
