//! `tyrewave paper`: the figures and statements of the paper that the model is from, computed again.
//!
//! `recompute` computes all of it, each figure and each subject in a separate file; `page` and `pictures` show it.

mod equation_4;
mod influence;
mod levels;
mod mobility;
mod page;
mod patch_force;
mod pictures;
mod recompute;
mod road;
mod search;
mod slice;
mod statement;
#[cfg(test)]
mod tests;
mod tread_laws;

use std::path::{Path, PathBuf};

use crate::results::table::Report;
use crate::scene::{DEFAULT, Scene};
use clap::Args;
use serde_json::json;

use super::context::Context;
use super::error::CliError;
use super::side::Side;
use page::{page, settings, statement_table, tally};
use pictures::pictures;
use recompute::{PaperOptions, recompute};

const EXAMPLES: &str = "\
K. Larsson, Numerical modelling of the tyre/road contact (Chalmers): its figures 2 to 6 and what it says on \
performance, computed again with the default tyre on the default road, each beside what the paper says. Mobility of \
patches, a rough road, a slice and its stiffness by both laws, forces over contact and time, tread laws at the same \
contact stiffness, solves of the contact search, the time that influence functions take by sums and by poles, and what \
equation 4 becomes as the time step falls. Takes about a minute; times are this machine's.

Results: paper.html with everything in it, paper.json with all numbers, and the pictures.

Examples:
  tyrewave paper                        results/paper
  tyrewave paper --out showcase         then open showcase/paper.html";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct PaperArguments {
    /// Results folder; default: results/paper.
    #[arg(long, short, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

impl PaperArguments {
    /// Computes, writes the page, the numbers and the pictures, prints the table.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let target = self.out.unwrap_or_else(|| Path::new("results").join("paper"));
        let mut side = Side::new(Scene::from_str(DEFAULT, "default")?, target)?;
        let options = PaperOptions::default();
        let mut progress = context.progress();
        let paper = recompute(&side.loaded, &options, context.interrupt.flag(), &mut progress)?;
        drop(progress);
        let drawn = pictures(&paper)?;
        let scene = &side.loaded.scene;
        let (html, settings) = (page(&paper, scene, &drawn), settings(&paper, scene));
        side.file("paper.html", html);
        for picture in drawn {
            side.file(picture.file, picture.svg);
        }
        side.json("paper.json", &json!(paper));
        side.settings = json!({ "scene": side.settings, "options": options });
        let mut report = Report::default();
        report.table(statement_table(&paper.statements));
        report.text(format!("\n{}\n{settings}\n", tally(&paper.statements)));
        side.finish(context, &report)
    }
}
