//! `tyrewave validate`: a scene compared with published values.

use std::path::{Path, PathBuf};

use crate::report::validation;
use crate::scene::{LoadedScene, Setting};
use crate::study::validation::{
    Options, PUBLISHED_SPEEDS, Published, ROADS, base_scene, levels_of_one_tyre, measure, rows,
};
use clap::Args;

use super::context::{Context, SceneFile, print};
use super::error::CliError;
use super::side::Side;

const EXAMPLES: &str = "\
Without a scene the default car tyre is compared with published values, with numerical settings for up to 2 kHz. A \
scene is used without its road, receivers, speed and duration: its tyre rolls 165 m on dac-11 and sma-8 at each speed \
and on other named roads (road.texture) at 80 km/h, with microphones at the coast-by position and close to the tyre, \
and stands on a smooth road. Seeds are fixed: the same program gives the same numbers. A first run also fits the tyre \
at each speed, and solves its radiation (minutes).

Compared: stiffness, patch and modes; third octaves relative to the energy sum of 200 to 2000 Hz and their growth; \
levels, cpx less coast-by; differences of roads; rolling resistance. A row has the computed value, its numerical \
error, the published range, the number of sets, how far outside the value is, and possible explanations. Ranges follow \
from the published values alone (src/study/validation/data). Rows that need a road or a speed that is left out are not \
computed.

Nobody published the spectrum of a named asphalt: levels and skewness of constructed roads are uncertain. Each of them \
is rolled four times more, over 22 m: levels lower and higher by their uncertainty, skewness 0 and -1.85. A value that \
lies inside the range on some of these roads, outside on others, cannot be told. --roads-as-stated leaves these runs \
out and takes half the time.

Results: validate.txt (the table), validate.json (all numbers, with sources), validate.md (a section for a README), \
validate.html (a page with the table, each published set and the pictures); shape_50.svg, shape_80.svg, shape_110.svg, \
growth.svg, levels_80.svg, roads.svg, textures.svg.

Examples:
  tyrewave validate
  tyrewave validate scenes/default.toml --speeds 80 --roads dac-11
  tyrewave validate --markdown -q
  tyrewave validate --set contact.zone=cells --set numerics.preset=draft
  tyrewave validate --json -q > validate.json
  tyrewave validate --set tyre=scenes/tyres/isotropic.toml --out isotropic";

const NAMES: [&str; 5] = [ROADS[0].name(), ROADS[1].name(), ROADS[2].name(), ROADS[3].name(), ROADS[4].name()];

#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct ValidateArguments {
    /// The scene, a TOML file; without it the default car tyre is validated.
    scene: Option<PathBuf>,
    /// Set a key in place of the scene's value, such as contact.zone=cells; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = Setting::parse)]
    settings: Vec<Setting>,
    /// Results folder; default: results/NAME-validate, with the name of the scene's file.
    #[arg(long, short, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Speeds in km/h; published values exist for 50, 80, 110.
    #[arg(long, value_name = "SPEEDS", value_delimiter = ',', default_value = "50,80,110", value_parser = speed)]
    speeds: Vec<f64>,
    /// Roads by name of their texture.
    #[arg(long, value_name = "ROADS", value_delimiter = ',', default_values = NAMES, value_parser = NAMES)]
    roads: Vec<String>,
    /// Roll the roads only as they are stated: half the time, and verdicts without the uncertainty of the roads.
    #[arg(long)]
    roads_as_stated: bool,
    /// Print only the section for a README.
    #[arg(long)]
    markdown: bool,
}

fn speed(text: &str) -> Result<f64, String> {
    let speed = text.trim().parse().ok().filter(|speed| PUBLISHED_SPEEDS.iter().any(|of| f64::abs(of - speed) < 1e-9));
    speed.ok_or_else(|| format!("{text} km/h has no published values: 50, 80 and 110 have"))
}

impl ValidateArguments {
    pub(crate) fn execute(self, context: &Context) -> Result<(), CliError> {
        let Self { scene, settings, out, speeds, roads, roads_as_stated, markdown } = self;
        let given = scene.is_some();
        let file = SceneFile { scene: scene.unwrap_or_else(|| "default.toml".into()), settings };
        let target = out.unwrap_or_else(|| {
            let mut name = file.name();
            name.push("-validate");
            Path::new("results").join(name)
        });
        let loaded: LoadedScene = if given { context.load(&file)? } else { base_scene(&file.settings)? };
        let mut side = Side::new(loaded.clone(), target)?;
        let textures = ROADS.into_iter().filter(|texture| roads.iter().any(|road| road == texture.name()));
        let options = Options { speeds: ordered(speeds), textures: textures.collect(), with_cases: !roads_as_stated };
        let measured = measure(&loaded, &options, context.job(&mut context.progress()))?;
        let published = Published::embedded();
        let (rows, levels) = (rows(&measured, &published), levels_of_one_tyre(&measured, &published));
        let title =
            format!("Validation: {}", if given { side.loaded.title() } else { "the default car tyre".to_owned() });
        let report = validation::report(&title, &rows);
        let section = validation::markdown(&rows);
        let pictures = validation::pictures(&rows, &measured, &levels);
        side.file("validate.txt", report.to_string());
        side.file("validate.md", section.clone());
        side.file("validate.html", validation::page(&title, &rows, &levels, &pictures));
        side.json("validate.json", &validation::record(&title, &rows, &measured));
        for (name, picture, _) in pictures {
            side.file(name, picture);
        }
        if markdown {
            side.write(context)?;
            return print(&section);
        }
        side.finish(context, &report)
    }
}

/// Distinct speeds, rising.
fn ordered(mut speeds: Vec<f64>) -> Vec<f64> {
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    speeds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_speeds_with_published_values_are_taken_each_once() {
        assert!(speed("80").is_ok() && speed(" 110 ").is_ok());
        let refusal = speed("81").unwrap_err();
        assert!(refusal.contains("81 km/h has no published values"), "{refusal}");
        assert!(speed("fast").is_err());
        assert_eq!(ordered(vec![80.0, 50.0, 80.0]), [50.0, 80.0]);
    }
}
