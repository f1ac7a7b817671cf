//! One scene of a folder of tasks, with everything needed to run it, and reasons why such a folder cannot be used.

use std::io;
use std::path::{Path, PathBuf};

use crate::numeric::digest::sha256;
use crate::plan::{Plan, unit};
use crate::results::ResultsError;
use crate::results::inputs::{Input, Inputs, changed};
use crate::scene::{Scene, SceneError, Setting};
use crate::storage::Unusable;
use crate::study::sweep::variants::{Label, Variant};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A task: beside it only its input files and the program are needed.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct Task {
    /// SHA-256 of scene and inputs: an identity by content.
    pub id: String,
    /// Name, group and choices in the tables.
    pub label: Label,
    /// The scene as TOML: open where the sweep's scene is open, its tyre included, the paths of its inputs absolute.
    scene: String,
    /// Files that the scene reads.
    inputs: Vec<Input>,
    /// Wall time that the plan expects on one thread \[s\].
    pub seconds: f64,
    /// Largest memory that the plan expects, the program itself not included \[bytes\].
    pub memory: f64,
    /// True if it gets all threads: what several tasks at a time would each solve is solved once and cached.
    pub alone: bool,
}

impl Task {
    /// Task of a variant that reads these files.
    ///
    /// # Errors
    /// A scene that TOML cannot hold.
    pub(super) fn of(variant: &Variant, inputs: Vec<Input>) -> Result<Self, TaskError> {
        let Variant { label, loaded, plan } = variant;
        let scene = loaded.given().map_err(failed(&label.name))?.to_string();
        let digests = inputs.iter().map(|input| input.sha256.as_str());
        let forecast = plan.clone().with_cached_model().forecast(&unit::known(), 1, 0.0);
        Ok(Self {
            id: sha256(&[[scene.as_str(), "\n"].to_vec(), digests.collect()].concat()),
            label: label.clone(),
            scene,
            inputs,
            seconds: forecast.wall_seconds,
            memory: forecast.memory,
            alone: !plan.scene.receivers.is_empty(),
        })
    }

    /// The task's variant again. Without arrays and pictures in its results folder unless those are retained: they are
    /// most of its bytes, and the tables do not need them.
    ///
    /// # Errors
    /// [`TaskError::Input`] for a file whose content has changed, [`TaskError::Read`], [`TaskError::Scene`].
    pub(super) fn variant(&self, keep_results: bool) -> Result<Variant, TaskError> {
        let name = &self.label.name;
        let settings = if keep_results { &[][..] } else { &["outputs.arrays=false", "outputs.plots=false"] };
        let settings: Vec<Setting> = settings.iter().filter_map(|setting| Setting::parse(setting).ok()).collect();
        let loaded = Scene::from_str_with(&self.scene, name, &settings).map_err(failed(name))?;
        let plan = Plan::of(&loaded).map_err(failed(name))?;
        let inputs = inputs_of(&plan.scene, &mut Inputs::default())?;
        if let Some(path) = changed(&self.inputs, &inputs) {
            return Err(TaskError::Input { task: name.clone(), path: path.to_owned() });
        }
        Ok(Variant { label: self.label.clone(), loaded, plan })
    }
}

pub(super) fn inputs_of(scene: &Scene, known: &mut Inputs) -> Result<Vec<Input>, TaskError> {
    known.of(scene).map_err(|(path, source)| TaskError::Read { path, source })
}

fn failed(name: &str) -> impl Fn(SceneError) -> TaskError + use<'_> {
    |source| TaskError::Scene { task: name.to_owned(), source }
}

#[cfg(test)]
impl Task {
    /// A task that is never done, of an invalid scene.
    pub(super) fn example(scene: &str) -> Self {
        Self {
            id: sha256(&[scene]),
            label: Label { name: scene.to_owned(), group: String::new(), speed: 80.0, choices: Vec::new() },
            scene: scene.to_owned(),
            inputs: Vec::new(),
            seconds: 1.0,
            memory: 1e6,
            alone: false,
        }
    }
}

/// Reasons why tasks cannot be written, done or collected.
#[derive(Debug, Error)]
pub(crate) enum TaskError {
    /// There is no manifest.
    #[error("no tasks: there is no {} (`tyrewave sweep SCENE --speed ... --tasks DIR` writes tasks)", path.display())]
    NoTasks {
        /// The manifest.
        path: PathBuf,
    },
    /// Manifest or tasks are damaged.
    #[error(
        "{} cannot be used: {reason}; delete it, and the command that wrote the tasks writes it again (what is done \
         stays, for outcomes are known by their scenes)",
        path.display()
    )]
    Unusable {
        /// The file.
        path: PathBuf,
        /// Fault of the file.
        reason: Unusable,
    },
    /// Tasks of another version of the program.
    #[error(
        "tyrewave {found} has written the tasks in {}, this is {}; the same bits cannot be promised: use that version, \
         or write the tasks into another folder",
        path.display(),
        env!("CARGO_PKG_VERSION")
    )]
    Program {
        /// The folder.
        path: PathBuf,
        /// The version found.
        found: String,
    },
    /// The folder holds other tasks.
    #[error("{} holds {count} other tasks (\"{title}\"); they are left alone: choose another folder", path.display())]
    Others {
        /// The folder.
        path: PathBuf,
        /// Number of its tasks.
        count: u64,
        /// Title of their scene.
        title: String,
    },
    /// No task has the number.
    #[error("there is no task {number} in {}: they have the numbers 0 to {last}", path.display())]
    Number {
        /// The folder.
        path: PathBuf,
        /// The number asked for.
        number: u64,
        /// Number of the last task.
        last: u64,
    },
    /// A file that the scene reads has changed.
    #[error("task {task}: the file {} has changed since the tasks were written", path.display())]
    Input {
        /// Name of the task.
        task: String,
        /// The file.
        path: PathBuf,
    },
    /// The scene of a task.
    #[error("task {task}: {source}")]
    Scene {
        /// Name of the task.
        task: String,
        /// Fault of the scene.
        source: SceneError,
    },
    /// A file that cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// A file that cannot be written.
    #[error(transparent)]
    Results(#[from] ResultsError),
}

impl TaskError {
    /// Constructor of the error that reading `path` failed, for `map_err`.
    pub(super) fn reading(path: &Path) -> impl FnOnce(io::Error) -> Self + use<'_> {
        move |source| Self::Read { path: path.to_owned(), source }
    }
}

#[cfg(test)]
mod tests {
    use crate::study::sweep::variants::{Axes, variants};
    use crate::test_models::edit;

    use super::*;

    #[test]
    fn a_task_is_its_variant_again() {
        // A preset chooses anew at every speed; what the scene leaves open stays open.
        let draft = ("numerics", "{ preset = \"draft\", fmax = 1000.0 }");
        let base = Scene::from_str(&edit(crate::scene::PLATE, &[draft]), "draft").unwrap();
        let made = variants(&base, &Axes { speeds: vec![50.0, 80.0], ..Axes::default() }).unwrap();
        for variant in &made {
            let task = Task::of(variant, Vec::new()).unwrap();
            let again = task.variant(true).unwrap();
            assert_eq!(again.loaded.scene, variant.loaded.scene);
            assert_eq!(again.plan.scene, variant.plan.scene);
            assert_eq!(again.label, variant.label);
            assert_eq!(again.loaded.hash().unwrap(), variant.loaded.hash().unwrap());
            assert!(task.seconds > 0.0 && task.memory > 0.0);
            let light = task.variant(false).unwrap();
            assert!(!light.plan.scene.outputs.arrays && !light.plan.scene.outputs.plots);
            assert_eq!(light.plan.scene.numerics, variant.plan.scene.numerics);
        }
        assert_ne!(made[0].plan.scene.numerics.elements, made[1].plan.scene.numerics.elements);
    }
}
