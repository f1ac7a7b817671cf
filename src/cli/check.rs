//! `tyrewave check`: whether scenes can be run.

use crate::plan::Plan;
use crate::planning::foreseen;
use crate::results::table::{Report, row, words};
use crate::run::prepare::checked;
use crate::scene::Setting;
use clap::Args;

use super::context::{Context, SceneFile};
use super::error::CliError;

const EXAMPLES: &str = "\
Checks everything that can be checked without a run: keys and values, the tyre's file, keys that exclude each other, \
memory and time against their limits, the road's file and its length. A warning is given if the run would be too short \
for sound or too fast for its tyre. The files may also be tyres: a tyre is checked in the default scene. Nothing is \
written. The exit code is 2 if a scene has a mistake.

Examples:
  tyrewave check scenes/default.toml
  tyrewave check scenes/default.toml scenes/sound.toml scenes/tyres/*.toml
  tyrewave check scenes/sound.toml --set numerics.preset=draft --set numerics.fmax=1000";

/// Arguments of `tyrewave check`.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct CheckArguments {
    /// The scenes: TOML files.
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<std::path::PathBuf>,
    /// Set a key, in place of the scenes' own value: see tyrewave help run; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = Setting::parse)]
    settings: Vec<Setting>,
}

impl CheckArguments {
    /// Checks one scene after the other, up to the first with a mistake.
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let mut rows = Vec::new();
        let mut notes = Report::default();
        for path in &self.scenes {
            let file = SceneFile { scene: path.clone(), settings: self.settings.clone() };
            let (loaded, is_tyre) = context.load_scene_or_tyre(&file)?;
            if is_tyre {
                loaded.check_time_domain()?;
                Plan::of(&loaded)?;
                rows.push(row([&path.display(), &"a tyre, can be rolled", &"", &"", &""]));
                continue;
            }
            let plan = checked(&loaded)?;
            let effects = plan.decisions.rows.iter().filter(|decision| decision.on).map(|decision| decision.effect);
            let effects = effects.collect::<Vec<_>>().join(", ");
            rows.push(row([&path.display(), &"can be run", &plan.scene.numerics.elements, &plan.steps, &effects]));
            let path = path.display();
            foreseen(&plan).iter().for_each(|warning| notes.text(format!("{path}: warning: {warning}\n")));
            plan.notes().for_each(|note| notes.text(format!("{path}: {note}\n")));
        }
        let mut report = Report::from(words(["scene", "", "elements", "steps", "effects"], rows));
        report.append(notes);
        if context.options.quiet { Ok(()) } else { context.print_report(&report) }
    }
}
