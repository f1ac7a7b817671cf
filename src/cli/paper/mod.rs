//! `tyrewave paper`: the figures and statements of the paper that the model is from (K. Larsson, *Numerical modelling
//! of the tyre/road contact*, Chalmers), computed again. `recompute` does all of it, each [`Subject`] by one function.

mod rolling;
mod standing;
mod subject;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use crate::counters::{Job, Stage};
use crate::plan::Plan;
use crate::report::html::{Chapter, chapters};
use crate::results::table::{Report, row, words};
use crate::scene::{DEFAULT, LoadedScene, Scene};
use crate::study::trial::{SETTLING, Trials};
use clap::Args;
use serde_json::json;

use super::context::Context;
use super::error::CliError;
use super::side::Side;
use rolling::{HALVED_DURATION, HALVINGS, Rolling};
use subject::{Statement, Subject};

const EXAMPLES: &str = "\
K. Larsson, Numerical modelling of the tyre/road contact (Chalmers): its figures 2 to 6 and its statements, computed \
again with the default tyre on the default road, each beside what the paper says. Mobility of patches, a rough road, a \
slice and its stiffness by both laws, forces over contact and time, tread laws at the same contact stiffness, solves \
of the contact search, and the limit of equation 4 for small time steps. Takes about a minute.

Results: paper.html with everything in it, paper.json with all numbers, and the pictures.

Examples:
  tyrewave paper                        results/paper
  tyrewave paper --out showcase         then open showcase/paper.html";

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct PaperArguments {
    /// Results folder; default: results/paper.
    #[arg(long, short, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

/// Simulated time after the warm-up \[s\]: a minute or less of computing on two cores.
const DURATION: f64 = 4.0;
/// Highest frequency compared \[Hz\].
const HIGHEST: f64 = 1000.0;

impl PaperArguments {
    /// Computes, writes the page, the numbers and the pictures, prints the table.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let target = self.out.unwrap_or_else(|| Path::new("results").join("paper"));
        let mut side = Side::new(Scene::from_str(DEFAULT, "default")?, target)?;
        let mut scene = side.loaded.scene.clone();
        scene.rolling.duration = DURATION;
        let subjects = recompute(&scene, HIGHEST, context.job(&mut context.progress()))?;
        let statements: Vec<&Statement> = subjects.iter().flat_map(|subject| &subject.statements).collect();
        let report = report(&statements, &scene);
        let mut numbers = json!({ "statements": statements });
        side.file("paper.html", page(&subjects, &report));
        for subject in subjects {
            numbers[subject.key] = subject.numbers;
            subject.pictures.into_iter().for_each(|([file, _], svg)| side.file(file, svg));
        }
        side.json("paper.json", &numbers);
        side.settings = json!({ "scene": scene });
        side.finish(context, &report)
    }
}

/// Computes the paper's figures and statements again for a scene's tyre and road, up to `highest` \[Hz\].
fn recompute(scene: &Scene, highest: f64, job: Job<'_>) -> Result<Vec<Subject>, CliError> {
    let mut scene = scene.clone();
    scene.numerics.forget_wishes();
    scene.outputs.vibration = None;
    let loaded = LoadedScene::from_scene(&scene, "paper")?;

    // 1. Everything without rolling.
    job.progress.stage(Stage::Influence);
    let mobility = standing::mobility(&Plan::of(&loaded)?.decisions.tyre)?;
    job.progress.stage(Stage::Road);
    let road = standing::road(&loaded)?;

    // 2. One run with the scene's laws; the other laws of tread and slices beside it; equation 4 and the local law with
    //    ever smaller time steps.
    let of_laws = 6.0 * (scene.rolling.warm_up + scene.rolling.duration);
    let halved = 2.0 * f64::from(HALVINGS + 1) * (SETTLING + HALVED_DURATION);
    let mut trials = Trials::new(of_laws + halved, job);
    let (run, recorder) = trials.roll_with(&scene, rolling::Recorder::new(&scene))?;
    let mut rolling = Rolling { loaded: &loaded, run, highest, trials: &mut trials };
    let patch_forces = rolling.patch_forces(&recorder)?;
    let tread_laws = rolling.tread_laws()?;
    let (slices, equation_4) = rolling.slices()?;
    let search = rolling.search(&equation_4);
    let equation_4 = rolling.equation_4()?;
    trials.finish();
    Ok(vec![mobility, road, slices, patch_forces, tread_laws, search, equation_4])
}

/// Page of everything, after a table of all statements.
fn page(subjects: &[Subject], statements: &Report) -> String {
    let nothing = Report::default();
    let mut sections = vec![Chapter { heading: "Statements", pictures: Vec::new(), tables: statements }];
    sections.extend(subjects.iter().map(|of| Chapter {
        heading: of.heading,
        pictures: of.pictures.iter().map(|([_, caption], svg)| [svg.as_str(), *caption]).collect(),
        tables: &nothing,
    }));
    let lead = "K. Larsson, Numerical modelling of the tyre/road contact (Chalmers): its figures and statements, \
                computed again and compared with what it says.";
    chapters("The paper, computed again", lead, &sections)
}

/// Table of all statements, and the settings of the computation.
fn report(statements: &[&Statement], scene: &Scene) -> Report {
    let rows = statements.iter().map(|of| {
        let statement = format!("{}: {}", of.place, of.subject);
        row([&statement, &of.paper, &of.found, &of.judgement()])
    });
    let mut report = Report::default();
    report.table(words(["statement", "paper", "found", "verdict"], rows));
    report.text(format!(
        "\n{} km/h, {} elements, {} s after the warm-up; equation 4 with half of the elements over \
         {HALVED_DURATION} s, the axle held.\n",
        scene.rolling.speed_kmh, scene.numerics.elements, scene.rolling.duration
    ));
    report
}
