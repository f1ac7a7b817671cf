//! A universal file (UFF): a header (data set 151), SI units (164), then functions (data sets 58, text): total force
//! over time, third octaves and narrow-band spectra of force, velocities and sound, sound pressure over time.
//!
//! Third octaves are auto spectra: mean squares of bands over their exact mid-frequencies, those bands left out that
//! that are not valid. Narrow bands are power spectral densities. The step of evenly spaced abscissas has seven digits
//! in this format.

use std::ops::Range;

use super::error::ExportError;
use crate::effects::stored::Stored;
use crate::results::sound::{SOUND_FILE, SOUND_NARROW_FILE};
use crate::results::spectra::SPECTRA_FILE;
use crate::results::vibration::{VIBRATION_FILE, VIBRATION_NARROW_FILE};
use crate::sound::levels::mean_square;
use crate::sound::wav::recording;

/// Begin of every exported file, by which an earlier export is recognised.
pub const UFF_HEAD: &str = "    -1\n   151\ntyrewave results";

/// Smaller magnitudes are written as zero: their exponents would not fit.
const SMALLEST: f64 = 1e-99;

/// Types of functions, and of data on their axes, by number.
mod kind {
    pub(super) const TIME_RESPONSE: u32 = 1;
    pub(super) const AUTO_SPECTRUM: u32 = 2;
    pub(super) const POWER_SPECTRAL_DENSITY: u32 = 9;

    pub(super) const DISPLACEMENT: u32 = 8;
    pub(super) const REACTION_FORCE: u32 = 9;
    pub(super) const VELOCITY: u32 = 11;
    pub(super) const PRESSURE: u32 = 15;
    pub(super) const TIME: u32 = 17;
    pub(super) const FREQUENCY: u32 = 18;
}

/// Direction numbers: none, and upwards.
const SCALAR: i32 = 0;
const UPWARDS: i32 = 3;

/// A table of spectra, and the type of the functions that are made of it.
struct Source {
    file: &'static str,
    what: &'static str,
    function: u32,
    /// Columns of abscissas and ordinates.
    columns: [&'static str; 2],
    /// Conversion of the second column to the unit.
    scale: fn(f64) -> f64,
    quantity: (u32, &'static str, &'static str),
    direction: i32,
}

const SPECTRA: [Source; 5] = [
    Source {
        file: SPECTRA_FILE,
        what: "Total contact force, third octaves",
        function: kind::AUTO_SPECTRUM,
        columns: ["mid_frequency_hz", "mean_square_n2"],
        scale: |square| square,
        quantity: (kind::REACTION_FORCE, "Force", "N^2"),
        direction: UPWARDS,
    },
    Source {
        file: VIBRATION_FILE,
        what: "Velocity, third octaves",
        function: kind::AUTO_SPECTRUM,
        columns: ["mid_frequency_hz", "mean_square_m2_s2"],
        scale: |square| square,
        quantity: (kind::VELOCITY, "Velocity", "(m/s)^2"),
        direction: SCALAR,
    },
    Source {
        file: VIBRATION_NARROW_FILE,
        what: "Velocity, narrow band",
        function: kind::POWER_SPECTRAL_DENSITY,
        columns: ["frequency_hz", "density_m2_s2_hz"],
        scale: |density| density,
        quantity: (kind::VELOCITY, "Velocity", "(m/s)^2/Hz"),
        direction: SCALAR,
    },
    Source {
        file: SOUND_FILE,
        what: "Sound pressure, third octaves",
        function: kind::AUTO_SPECTRUM,
        columns: ["mid_frequency_hz", "level_db_re_20upa"],
        // The level of silence is an empty cell.
        scale: |level| if level.is_nan() { 0.0 } else { mean_square(level) },
        quantity: (kind::PRESSURE, "Sound pressure", "Pa^2"),
        direction: SCALAR,
    },
    Source {
        file: SOUND_NARROW_FILE,
        what: "Sound pressure, narrow band",
        function: kind::POWER_SPECTRAL_DENSITY,
        columns: ["frequency_hz", "density_pa2_hz"],
        scale: |density| density,
        quantity: (kind::PRESSURE, "Sound pressure", "Pa^2/Hz"),
        direction: SCALAR,
    },
];

/// Abscissas of a function.
enum Abscissas<'a> {
    /// Evenly spaced: first, step \[s\].
    Even(f64, f64),
    /// At these \[Hz\].
    Uneven(&'a [f64]),
}

/// A function of data set 58.
struct Function<'a> {
    what: &'a str,
    /// Function type, and number of the node.
    kind: u32,
    node: usize,
    direction: i32,
    abscissas: Abscissas<'a>,
    /// Specific data type, label and unit of both axes.
    axes: [(u32, &'a str, &'a str); 2],
    ordinates: &'a [f64],
}

/// Text of the file.
///
/// # Errors
/// [`ExportError`]; [`ExportError::Missing`] if the run has written neither arrays nor spectra.
pub(crate) fn uff(stored: &Stored) -> Result<String, ExportError> {
    let mut text = header(stored);
    let mut nodes = 0;
    let time_step = stored.plan.time_step;
    for (file, what, quantity) in [
        ("total_force.npy", "Total contact force", (kind::REACTION_FORCE, "Force", "N")),
        ("axle.npy", "Indentation of the rigid tyre", (kind::DISPLACEMENT, "Indentation", "m")),
    ] {
        let Some(values) = stored.column(file)?.filter(|values| !values.is_empty()) else { continue };
        nodes += 1;
        let function = Function {
            what,
            kind: kind::TIME_RESPONSE,
            node: nodes,
            direction: UPWARDS,
            abscissas: Abscissas::Even(0.0, time_step),
            axes: [(kind::TIME, "Time", "s"), quantity],
            ordinates: &values,
        };
        function.write(&mut text, stored);
    }
    for source in &SPECTRA {
        let Some(table) = stored.table(source.file)? else { continue };
        let [abscissas, ordinates] = source.columns.map(|name| table.numbers(name));
        let (Some(abscissas), Some(ordinates)) = (abscissas, ordinates) else {
            return Err(ExportError::Shape { file: source.file });
        };
        let valid = table.numbers("valid");
        for (name, rows) in table.signals() {
            nodes += 1;
            source.write(&mut text, stored, &name, nodes, [abscissas, ordinates], valid, rows);
        }
    }
    for receiver in stored.summary.sound.iter().flat_map(|sound| &sound.receivers) {
        let Some(audio) = &receiver.audio else { continue };
        let Some(sound) = recording(&stored.bytes(&audio.file)?) else { continue };
        for (channel, pressures) in sound.channels.iter().enumerate() {
            nodes += 1;
            let number = if sound.channels.len() > 1 { format!(", channel {}", channel + 1) } else { String::new() };
            let function = Function {
                what: &format!("Sound pressure: {}{number}", receiver.name),
                kind: kind::TIME_RESPONSE,
                node: nodes,
                direction: SCALAR,
                abscissas: Abscissas::Even(0.0, 1.0 / f64::from(sound.rate)),
                axes: [(kind::TIME, "Time", "s"), (kind::PRESSURE, "Sound pressure", "Pa")],
                ordinates: pressures,
            };
            function.write(&mut text, stored);
        }
    }
    let missing = ExportError::Missing { what: "a force over time or a spectrum", key: "outputs.arrays" };
    if nodes == 0 { Err(missing) } else { Ok(text) }
}

impl Source {
    /// Writes one signal of the table, without bands that are not valid.
    #[allow(clippy::too_many_arguments, reason = "columns of one table")]
    fn write(
        &self,
        text: &mut String,
        stored: &Stored,
        name: &str,
        node: usize,
        [abscissas, ordinates]: [&[f64]; 2],
        valid: Option<&[f64]>,
        rows: Range<usize>,
    ) {
        let is_valid = |row: &usize| valid.is_none_or(|valid| valid[*row] > 0.0);
        let rows: Vec<usize> = rows.filter(is_valid).collect();
        let abscissas: Vec<f64> = rows.iter().map(|&row| abscissas[row]).collect();
        let ordinates: Vec<f64> = rows.iter().map(|&row| (self.scale)(ordinates[row])).collect();
        let what = if name.is_empty() { self.what.to_owned() } else { format!("{}: {name}", self.what) };
        let function = Function {
            what: &what,
            kind: self.function,
            node,
            direction: self.direction,
            abscissas: Abscissas::Uneven(&abscissas),
            axes: [(kind::FREQUENCY, "Frequency", "Hz"), self.quantity],
            ordinates: &ordinates,
        };
        function.write(text, stored);
    }
}

impl Function<'_> {
    fn write(&self, text: &mut String, stored: &Stored) {
        let Self { what, kind, node, direction, abscissas, axes, ordinates } = self;
        let program = format!("tyrewave {}; time step {} s", stored.summary.version, stored.plan.time_step);
        begin(text, 58);
        for id in [what, &stored.name()[..], "NONE", &stored.summary.title, &program] {
            line(text, &field(id, 80));
        }
        let (response, reference) = (field("TYRE", 10), field("NONE", 10));
        let places = format!(" {response}{node:10}{direction:4} {reference}{0:10}{0:4}", 0);
        line(text, &format!("{kind:5}{node:10}{0:5}{0:10}{places}", 0));
        // Real numbers in double precision.
        let (even, first, step) = match abscissas {
            Abscissas::Even(first, step) => (1, *first, *step),
            Abscissas::Uneven(_) => (0, 0.0, 0.0),
        };
        let numbers = [first, step, 0.0].map(|number| scientific(number, 13, 6)).concat();
        line(text, &format!("{:10}{:10}{even:10}{numbers}", 4, ordinates.len()));
        let none = (0, "NONE", "NONE");
        for (kind, label, unit) in [axes[0], axes[1], none, none] {
            line(text, &format!("{kind:10}{0:5}{0:5}{0:5} {1} {2}", 0, field(label, 20), field(unit, 20)));
        }
        let written: Vec<String> = match abscissas {
            Abscissas::Even(..) => ordinates.iter().map(|&ordinate| scientific(ordinate, 20, 11)).collect(),
            Abscissas::Uneven(abscissas) => abscissas
                .iter()
                .zip(*ordinates)
                .map(|(&abscissa, &ordinate)| scientific(abscissa, 13, 5) + &scientific(ordinate, 20, 11))
                .collect(),
        };
        let in_a_line = if matches!(abscissas, Abscissas::Even(..)) { 4 } else { 2 };
        written.chunks(in_a_line).for_each(|numbers| line(text, &numbers.concat()));
        end(text);
    }
}

/// Header and SI units. Without dates: the same results give the same bytes.
fn header(stored: &Stored) -> String {
    let mut text = String::new();
    begin(&mut text, 151);
    for about in ["tyrewave results", &stored.name(), "tyrewave"] {
        line(&mut text, &field(about, 80));
    }
    line(&mut text, &format!("{1:20}{0:10}{0:10}{0:10}", 0, ""));
    line(&mut text, &field("", 20));
    line(&mut text, &field(&format!("tyrewave {}", stored.summary.version), 80));
    line(&mut text, &field("", 20));
    end(&mut text);
    begin(&mut text, 164);
    line(&mut text, &format!("{:10}{}{:10}", 1, field("SI", 20), 2));
    let factor = |number: f64| scientific(number, 25, 17).replace('E', "D");
    line(&mut text, &[1.0, 1.0, 1.0].map(factor).concat());
    line(&mut text, &factor(273.15));
    end(&mut text);
    text
}

fn begin(text: &mut String, data_set: u32) {
    line(text, &format!("{:6}", -1));
    line(text, &format!("{data_set:6}"));
}

fn end(text: &mut String) {
    line(text, &format!("{:6}", -1));
}

fn line(text: &mut String, content: &str) {
    text.push_str(content);
    text.push('\n');
}

/// Text of exactly this width; characters outside printable ASCII become question marks.
fn field(text: &str, width: usize) -> String {
    let plain = |letter: char| if letter.is_ascii() && !letter.is_ascii_control() { letter } else { '?' };
    let text: String = text.chars().take(width).map(plain).collect();
    format!("{text:width$}")
}

/// A number in Fortran's E format, right-aligned in the width.
fn scientific(number: f64, width: usize, decimals: usize) -> String {
    let number = if number.abs() < SMALLEST { 0.0 } else { number };
    let text = format!("{number:.decimals$E}");
    let (digits, exponent) = text.split_once('E').unwrap_or((&text, "0"));
    let (sign, exponent) = exponent.strip_prefix('-').map_or(('+', exponent), |exponent| ('-', exponent));
    format!("{:>width$}", format!("{digits}E{sign}{exponent:0>2}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_words_have_the_width_of_their_fields() {
        assert_eq!(scientific(-3321.25, 20, 11), "  -3.32125000000E+03");
        assert_eq!(scientific(1.0 / 7.0, 13, 6), " 1.428571E-01");
        assert_eq!(scientific(1e-300, 13, 5), "  0.00000E+00");
        assert_eq!(scientific(2.5e123, 20, 11).len(), 20);
        assert_eq!(field("Br\u{fc}cke\n", 10), "Br?cke?   ");
        assert_eq!(field(&"x".repeat(99), 80).len(), 80);
    }
}
