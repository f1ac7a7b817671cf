//! `tyrewave completions` and `tyrewave man`: descriptions of the commands for a shell.

use std::fs;
use std::path::PathBuf;

use crate::results::ResultsError;
use clap::Args;
use clap_complete::Shell;

use super::context::{Context, print};
use super::error::CliError;

const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  tyrewave completions bash > ~/.local/share/bash-completion/completions/tyrewave
  tyrewave completions zsh > ~/.zfunc/_tyrewave
  tyrewave completions fish > ~/.config/fish/completions/tyrewave.fish";

/// Arguments of `tyrewave completions`.
#[derive(Clone, Debug, Args)]
#[command(after_help = COMPLETIONS_EXAMPLES)]
pub(crate) struct CompletionsArguments {
    /// The shell.
    shell: Shell,
}

impl CompletionsArguments {
    /// Prints the completions of the whole program.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let mut text = Vec::new();
        clap_complete::generate(self.shell, &mut (context.program)(), "tyrewave", &mut text);
        print(&String::from_utf8_lossy(&text))
    }
}

const MAN_EXAMPLES: &str = "\
Examples:
  tyrewave man ~/.local/share/man/man1
  man tyrewave-run";

/// Arguments of `tyrewave man`.
#[derive(Clone, Debug, Args)]
#[command(after_help = MAN_EXAMPLES)]
pub(crate) struct ManArguments {
    /// The folder for the pages, one for each command; created if it does not exist.
    folder: PathBuf,
}

impl ManArguments {
    /// Writes the pages of the whole program.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        fs::create_dir_all(&self.folder).map_err(ResultsError::creating(&self.folder))?;
        let failed = ResultsError::writing(&self.folder);
        clap_mangen::generate_to((context.program)(), &self.folder).map_err(failed)?;
        Ok(())
    }
}
