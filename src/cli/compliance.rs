//! `tyrewave compliance`: the layered tyre's compliance for a file of cases.

use std::path::PathBuf;

use clap::Args;

const EXAMPLES: &str = "\
The file has the format of the reference values: every case names its layers, wavenumbers and complex frequency s. The same JSON is printed with the \
computed 3x3 surface compliance C and belt transfer D in place of the file's.

Examples:
  tyrewave compliance cases.json > computed.json";

/// Arguments of `tyrewave compliance`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ComplianceArguments {
    /// The cases, a JSON file.
    pub cases: PathBuf,
}
