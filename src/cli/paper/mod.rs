//! `tyrewave paper`: the figures and statements of the paper that the model is from (K. Larsson, *Numerical modelling
//! of the tyre/road contact*, Chalmers), computed again. `recompute` does all of it, each [`Subject`] by one
//! function: here those without rolling, mobility of the tread (figure 2) and a rough road (figure 3).

mod rolling;
mod subject;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use crate::counters::{Job, Stage};
use crate::numeric::StraightLine;
use crate::plan::Plan;
use crate::report::html::{Chapter, chapters};
use crate::report::road::map;
use crate::report::tyre::{LEVEL, plot};
use crate::results::table::{Report, row, words};
use crate::run::road::{described, in_scene};
use crate::scene::{DEFAULT, LoadedScene, Scene, Tyre};
use crate::study::trial::{SETTLING, Trials};
use crate::tyre::influence::mobility::{driving_point, frequencies, level};
use clap::Args;
use serde_json::json;

use super::context::Context;
use super::error::CliError;
use super::side::Side;
use rolling::{HALVED_DURATION, HALVINGS, Rolling};
use subject::{Statement, Subject, Verdict};

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
    let mobility = mobility(&Plan::of(&loaded)?.decisions.tyre)?;
    job.progress.stage(Stage::Road);
    let road = road(&loaded)?;

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
    let mut report = Report::from(words(["statement", "paper", "found", "verdict"], rows));
    report.text(format!(
        "\n{} km/h, {} elements, {} s after the warm-up; equation 4 with half of the elements over \
         {HALVED_DURATION} s, the axle held.\n",
        scene.rolling.speed_kmh, scene.numerics.elements, scene.rolling.duration
    ));
    report
}

/// Sides of the square patches \[m\], falling.
const PATCHES: [f64; 4] = [0.05, 0.02, 0.01, 0.005];
/// Range of frequencies \[Hz\], and their number.
const BAND: [f64; 2] = [50.0, 3000.0];
const POINTS: u32 = 120;
/// Above this frequency the mobility of a small patch is a spring's \[Hz\].
const SPRING_FROM: f64 = 1000.0;
/// Share of the frequencies at which the level must rise: resonances of the tyre may hide it at the others.
const OFTEN: f64 = 0.9;

/// Figure 2: driving-point mobility of patches of several sizes.
fn mobility(tyre: &Tyre) -> Result<Subject, CliError> {
    let frequencies = frequencies(BAND[0], BAND[1], POINTS);
    let mobility = driving_point(tyre, &PATCHES, &frequencies);
    let levels: Vec<[f64; 4]> =
        mobility.values.iter().map(|row| std::array::from_fn(|patch| level(row[patch]))).collect();
    // 1. Rise of the level from each patch to the next smaller one.
    let count = levels.len() as f64;
    let rising =
        levels.iter().filter(|row| row.is_sorted_by(|larger, smaller| larger < smaller)).count() as f64 / count;
    let halvings = (PATCHES[0] / PATCHES[3]).log2();
    let per_halving = levels.iter().map(|row| row[3] - row[0]).sum::<f64>() / (count * halvings);
    // 2. Power of the frequency with which the mobility of the smallest patch grows.
    let values = frequencies.iter().zip(&mobility.values).filter(|(frequency, _)| **frequency >= SPRING_FROM);
    let smallest: Vec<(f64, f64)> = values.map(|(&frequency, row)| (frequency, row[3].norm())).collect();
    let exponent = StraightLine::power_law(&smallest).map_or(f64::NAN, |line| line.slope);
    let numbers =
        json!({ "patches": PATCHES, "rising": rising, "mean_rise_per_halving": per_halving, "exponent": exponent });
    let mut subject = Subject::new("Figure 2", "mobility", numbers);
    let share = 100.0 * rising;
    subject.state(
        ["mobility of the tread over the size of the patch", "the level rises as the patch shrinks"],
        format!(
            "{per_halving:.1} dB for half the side; at {share:.0} % of the frequencies from each patch to the next"
        ),
        (Verdict::of(rising >= OFTEN), format!("such a rise at {} % of the frequencies or more", 100.0 * OFTEN)),
    );
    let smallest = 1e3 * PATCHES[3];
    subject.state(
        ["mobility of a small patch", "grows like that of a spring above 400 to 1000 Hz"],
        format!("grows with the frequency to the power {exponent:.2} from {SPRING_FROM} Hz on, {smallest} mm"),
        (Verdict::of((exponent - 1.0).abs() < 0.5), "a power nearer to a spring's 1 than to a damper's 0"),
    );
    let names = PATCHES.map(|side| format!("{} mm", 1e3 * side));
    let picture = plot(&mobility, "Driving-point mobility of the tread", &names, LEVEL).to_svg();
    subject.pictures.push((["mobility.svg", "A square patch in the middle of the tread."], picture));
    Ok(subject)
}

/// Figure 3: a piece of the scene's road, and its measures.
fn road(loaded: &LoadedScene) -> Result<Subject, CliError> {
    let road = described(&Plan::new(&loaded.scene)).map_err(|error| in_scene(loaded, error))?;
    let depth = road.mean_profile_depth.as_ref().and_then(|depth| depth.mean);
    let numbers = json!({ "rms": road.rms, "mean_profile_depth": depth, "levels": road.levels });
    let mut subject = Subject::new("Figure 3", "road", numbers);
    let depth = depth.map_or_else(String::new, |depth| format!("mean profile depth {:.2} mm, ", 1e3 * depth));
    subject.state(
        ["a rough road", "a measured road in a picture"],
        format!("{depth}rms height {:.2} mm, {} third octaves", 1e3 * road.rms, road.levels.len()),
        (Verdict::NotComparable, "the heights of the paper's road are not given; this one is made"),
    );
    if !road.sample.heights.is_empty() {
        subject
            .pictures
            .push((["road.svg", "A piece of the road, its heights in colours."], map("A rough road", &road)?));
    }
    Ok(subject)
}
