//! Options that every command takes.

use std::io::IsTerminal;
use std::process::ExitCode;

use clap::builder::styling::{AnsiColor, Style};
use clap::error::{ContextKind, ContextValue};
use clap::{Args, ColorChoice};

use super::error::{CliError, NOT_WRITABLE, USAGE, write_message};

/// A larger number is taken for a typing error.
const MOST_THREADS: u16 = 1024;
/// Environment variable with the number of threads, used if no option gives it.
const THREADS_VARIABLE: &str = "RAYON_NUM_THREADS";

/// Options that every command takes, before or after its name.
#[derive(Clone, Debug, Args)]
pub(crate) struct GlobalOptions {
    /// Number of threads; default: the environment variable RAYON_NUM_THREADS, or one per processor. The results do not
    /// depend on it, not even in the last bit.
    #[arg(long, global = true, value_name = "N")]
    #[arg(value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS.into()), allow_negative_numbers = true)]
    pub threads: Option<u16>,
    /// Print only errors and the requested output.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Print JSON instead of text and tables.
    #[arg(long, global = true)]
    pub json: bool,
    /// Allow a scene to use a tyre and a road outside its own folder.
    #[arg(long, global = true)]
    pub allow_outside: bool,
    /// When to colour messages; auto: on a terminal, unless the environment variable NO_COLOR is set.
    #[arg(long, global = true, value_name = "WHEN", default_value_t = ColorChoice::Auto)]
    pub color: ColorChoice,
}

impl GlobalOptions {
    /// Number of threads: never zero, and an error if the environment asks for more than [`MOST_THREADS`].
    pub(crate) fn threads(&self) -> Result<usize, CliError> {
        match self.threads {
            Some(threads) => Ok(threads.into()),
            None => {
                let variable = std::env::var_os(THREADS_VARIABLE).unwrap_or_default();
                let variable = variable.to_string_lossy();
                let threads = default_threads(&variable)?;
                if !self.quiet && !is_number_of_threads(&variable) {
                    write_message(&format!(
                        "warning: {THREADS_VARIABLE} is \"{variable}\", which is not a number of threads: {threads} \
                         are used, one per processor"
                    ));
                }
                Ok(threads)
            }
        }
    }
}

/// True if a value of the environment variable is a number of threads; an empty one, and 0, leave it open.
fn is_number_of_threads(variable: &str) -> bool {
    variable.trim().is_empty() || variable.trim().parse::<usize>().is_ok()
}

/// Threads for a value of the environment variable; 0 and anything that is no number mean one per processor, as for
/// rayon.
fn default_threads(variable: &str) -> Result<usize, CliError> {
    match variable.trim().parse::<usize>() {
        Ok(threads) if threads > MOST_THREADS.into() => Err(CliError::Usage(format!(
            "{THREADS_VARIABLE} is {threads}: at most {MOST_THREADS} threads are possible"
        ))),
        Ok(threads) if threads > 0 => Ok(threads),
        _ => {
            let processors = std::thread::available_parallelism().map_or(1, usize::from);
            Ok(processors.min(MOST_THREADS.into()))
        }
    }
}

/// Former commands, with what replaces each.
const FORMER: [[&str; 2]; 3] = [
    [
        "influence",
        "`tyrewave tyre` and `tyrewave mobility` show how the tyre responds, `tyrewave paper` its influence \
         functions, and Scene.influence in Python returns them",
    ],
    [
        "rules",
        "docs/theory.md, section 4, has the time rules side by side, `tyrewave study SCENE` their errors against their \
         work on a scene",
    ],
    [
        "slice",
        "`tyrewave slices SCENE --penetrations Y1,Y2,...` presses a slice of a scene's road, tyrewave.slice_curve in \
         Python any heights",
    ],
];

/// Prints the answer of the argument parser, help or an error, and returns its exit code.
pub(super) fn answered(answer: &clap::Error) -> ExitCode {
    if let Some(ContextValue::String(command)) = answer.get(ContextKind::InvalidSubcommand)
        && let Some([_, instead]) = FORMER.iter().find(|[former, _]| former == command)
    {
        write_message(&error_line(&format!("`{command}` has been removed: {instead}"), false));
        return ExitCode::from(USAGE);
    }
    match answer.print() {
        Err(_) if !answer.use_stderr() => ExitCode::from(NOT_WRITABLE),
        _ => ExitCode::from(u8::try_from(answer.exit_code()).unwrap_or(USAGE)),
    }
}

/// Parser of a value by its name.
pub(super) fn by_name<T: Copy, const COUNT: usize>(
    values: [T; COUNT],
    name: fn(T) -> &'static str,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let found = values.into_iter().find(|&value| name(value) == text.trim());
        found.ok_or_else(|| format!("expected one of: {}", values.map(name).join(", ")))
    }
}

/// Parses a finite number above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err(format!("\"{}\" is not a positive number", text.trim())),
    }
}

/// Parses the side of a patch in millimetres; `fit-tyre` takes metres.
pub(super) fn patch_side(text: &str) -> Result<f64, String> {
    match positive(text)? {
        side if side < 0.5 => Err(format!("{side} mm is implausible: the side is in mm, at least 0.5")),
        side => Ok(side),
    }
}

/// Parses a finite number.
pub(super) fn finite(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| format!("\"{}\" is not a finite number", text.trim()))
}

/// Parses a Poisson's ratio: in (-1, 0.5\].
pub(super) fn poisson_ratio(text: &str) -> Result<f64, String> {
    let ratio = finite(text)?;
    let lies = ratio > -1.0 && ratio <= 0.5;
    if lies { Ok(ratio) } else { Err("Poisson's ratio must be above -1 and at most 0.5".to_owned()) }
}

/// True if messages on standard error are coloured.
pub(super) fn allows_colour(choice: ColorChoice) -> bool {
    match choice {
        ColorChoice::Always => true,
        ColorChoice::Never => false,
        ColorChoice::Auto => {
            let unwanted = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
            !unwanted && std::io::stderr().is_terminal()
        }
    }
}

/// `error: message`, as clap and rustc write it. A message with a heading (a report on a scene) stays as it is.
pub(super) fn error_line(message: &str, colour: bool) -> String {
    // A rendered report starts with its heading, possibly behind an escape sequence.
    if message.starts_with("error") || message.starts_with('\u{1b}') {
        return message.to_owned();
    }
    let style = if colour { AnsiColor::Red.on_default().bold() } else { Style::new() };
    format!("{style}error:{style:#} {message}")
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        options: GlobalOptions,
    }

    #[test]
    fn a_thread_count_is_a_small_positive_number() {
        let threads = |text: &str| {
            Line::try_parse_from(["tyrewave", &format!("--threads={text}")]).map(|line| line.options.threads)
        };
        assert_eq!(threads("2").unwrap(), Some(2));
        for text in ["0", "-1", "two", "1000000", ""] {
            assert!(threads(text).is_err(), "{text}");
        }
        let message = Line::try_parse_from(["tyrewave", "--threads", "-1"]).err().unwrap().to_string();
        assert!(message.contains("-1 is not in 1..=1024"), "{message}");
    }

    #[test]
    fn the_environment_does_not_start_thousands_of_threads() {
        let processors = default_threads("").unwrap();
        assert!((1..=1024).contains(&processors));
        for (text, threads) in [("3", 3), (" 1024 ", 1024), ("0", processors), ("many", processors), ("-1", processors)]
        {
            assert_eq!(default_threads(text).unwrap(), threads, "{text}");
        }
        for (text, is_number) in [("", true), (" 3 ", true), ("0", true), ("x", false), ("-1", false), ("2.5", false)] {
            assert_eq!(is_number_of_threads(text), is_number, "{text}");
        }
        for text in ["1025", "100000"] {
            let error = default_threads(text).unwrap_err();
            assert!(error.to_string().contains(text) && error.exit_code() == USAGE, "{error}");
        }
    }

    #[test]
    fn errors_are_headed_once() {
        assert_eq!(error_line("it broke", false), "error: it broke");
        assert_eq!(error_line("error: unknown key", false), "error: unknown key");
        assert!(error_line("it broke", true).starts_with("\u{1b}[1m\u{1b}[31merror:\u{1b}[0m "));
        assert!(allows_colour(ColorChoice::Always) && !allows_colour(ColorChoice::Never));
    }
}
