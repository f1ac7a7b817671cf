//! Tables of contact over cells, default tyre at 80 km/h on four roads: what refining cells and steps changes, and what
//! slices give instead. Both hold the axle where it carries 3400 N at rest on cells of 4 mm.

use toml::{Table, Value};
use tyrewave::internals::{CHIP_SEAL, reference, scene_text, with_all_terms};

use crate::common::run;

/// Elements of 2 mm, and steps on each.
const FINE: [usize; 2] = [1024, 1];
/// Levels that are compared \[Hz\].
const BANDS: std::ops::RangeInclusive<f64> = 63.0..=2000.0;

/// Names of the roads, and what a scene says of them.
fn roads() -> Vec<(&'static str, String)> {
    let chippings = "kind = \"made\"\npower_law = { rms = 0.0012, exponent = 2.0, longest = 0.1, shortest = 0.005 }";
    let chip_seal = reference(CHIP_SEAL).display().to_string();
    let cobbles = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/roads/cobbles.crg");
    vec![
        ("dense asphalt", "kind = \"made\"\nseed = 1".to_owned()),
        ("chippings", chippings.to_owned()),
        ("CAPTIF 10", format!("kind = \"profile\"\nfile = '{chip_seal}'\nlateral = \"isotropic\"")),
        ("cobbles", format!("kind = \"opencrg\"\nfile = '{cobbles}'\nmissing = []\nat_end = \"mirror\"")),
    ]
}

/// Findings of a run.
struct Found {
    levels: Vec<(f64, f64)>,
    mean: f64,
    rms: f64,
    length: f64,
    area: Option<f64>,
    resistance: Option<f64>,
    /// kappa of slices \[m/Pa\].
    local_compliance: Option<f64>,
}

impl Found {
    /// Largest difference of a third octave \[dB\], and its band.
    fn worst(&self, other: &Self) -> (f64, f64) {
        let differences = self.levels.iter().zip(&other.levels).map(|((f, a), (_, b))| ((a - b).abs(), *f));
        differences.fold((0.0, 0.0), |worst, next| if next.0 > worst.0 { next } else { worst })
    }
}

fn rolled(road: &str, [elements, substeps]: [usize; 2], rule: &str, contact: &str) -> Found {
    let rolling = "speed_kmh = 80.0\nwarm_up = 0.2\nduration = 0.4\naxle = { indentation = 0.0168, ramp = 0.05 }";
    let numerics = format!("substeps = {substeps}\ntime_rule = \"{rule}\"\npole_tolerance = 1e-4\ntime_limit = 100.0");
    let more = format!("[contact]\n{contact}\n[outputs]\nplots = false");
    let text = with_all_terms(&scene_text(elements, road, rolling, &numerics, &more));
    let table = |text: &str| text.parse::<Table>().unwrap();
    let mut scene = table(&text);
    scene.insert("tyre".into(), Value::Table(table(include_str!("../../scenes/tyres/car.toml"))));
    let results = run(&scene.to_string());
    let summary = results.summary();
    let outcome = &summary["outcome"];
    let number = |value: &serde_json::Value| value.as_f64();
    let levels = results.force_levels();
    let bands = levels.iter().filter(|band| BANDS.contains(&band.band.nominal_frequency()));
    let counters = &summary["cost"]["counters"];
    assert_eq!(counters["fallbacks"], 0, "{contact} on {road}");
    results.assert_window_held(&format!("{contact} on {road}"));
    Found {
        levels: bands.map(|band| (band.band.nominal_frequency(), 10.0 * band.mean_square.log10())).collect(),
        mean: number(&outcome["mean_force"]).unwrap(),
        rms: number(&outcome["rms_force_variation"]).unwrap(),
        length: number(&outcome["mean_contact_length"]).unwrap(),
        area: number(&outcome["cells"]["mean_area"]),
        resistance: number(&outcome["rolling_resistance"]["coefficient"]),
        local_compliance: number(&summary["contact"]["local_compliance"]),
    }
}

fn cells(across: usize) -> String {
    format!("zone = \"cells\"\ncells_across = {across}")
}

#[test]
#[ignore = "an hour"]
fn tables_of_refinement_in_cells() {
    for (name, road) in roads() {
        // As many steps each.
        let sizes = [(256, 15, 8), (512, 30, 4), (1024, 60, 2), (2048, 120, 1)];
        let found: Vec<Found> =
            sizes.iter().map(|&(n, across, q)| rolled(&road, [n, q], "sdirk2", &cells(across))).collect();
        let finest = &found[found.len() - 1];
        println!("{name}: cells of            levels      mean force        rms       area");
        for ((n, ..), of) in sizes.iter().zip(&found) {
            let ((worst, band), area) = (of.worst(finest), of.area.unwrap() / finest.area.unwrap() - 1.0);
            println!(
                "  {:5.2} mm  {worst:6.2} dB at {band:5} Hz  {:8.1} N  {:7.2} N  {:+6.1} %",
                1950.0 / *n as f64,
                of.mean,
                of.rms,
                100.0 * area
            );
        }
        for rule in ["bdf2", "sdirk2"] {
            let found: Vec<Found> = [1, 2, 4].iter().map(|&q| rolled(&road, [FINE[0], q], rule, &cells(60))).collect();
            let steps = found.windows(2).map(|pair| {
                let (worst, band) = pair[0].worst(&pair[1]);
                let area = pair[1].area.unwrap() / pair[0].area.unwrap() - 1.0;
                format!("{worst:.3} dB ({band} Hz), {:+.3} N, {:+.3} %", pair[1].mean - pair[0].mean, 100.0 * area)
            });
            println!("  {rule}, 2 mm, q = 1, 2, 4: {}", steps.collect::<Vec<_>>().join("; "));
        }
    }
}

#[test]
#[ignore = "ten minutes"]
fn tables_of_slices_against_cells() {
    let springs = |factor: f64, kappa: f64| format!("slices = \"winkler\"\nlocal_compliance = {:e}", factor * kappa);
    for (name, road) in roads() {
        let exact = rolled(&road, FINE, "sdirk2", &cells(60));
        let line = |law: &str, of: &Found| {
            println!(
                "  {law:28} {:7.1} N  {:6.2} N  {:6.1} mm  {:.4}   {}",
                of.mean,
                of.rms,
                1e3 * of.length,
                of.resistance.unwrap_or(f64::NAN),
                of.levels
                    .iter()
                    .zip(&exact.levels)
                    .map(|((_, a), (_, b))| format!("{:+5.1}", a - b))
                    .collect::<String>()
            );
        };
        let bands: String = exact.levels.iter().map(|(f, _)| format!("{f:5}")).collect();
        println!("{name}:                       mean     rms      length     RR       {bands}");
        line("cells of 2 mm", &exact);
        let formula = rolled(&road, FINE, "sdirk2", "slices = \"winkler\"");
        let kappa = formula.local_compliance.unwrap();
        line(&format!("springs, kappa {kappa:.2e}"), &formula);
        for factor in [0.5, 0.25] {
            line(&format!("{factor} of that"), &rolled(&road, FINE, "sdirk2", &springs(factor, kappa)));
        }
        line("half-space slices", &rolled(&road, FINE, "sdirk2", "slices = \"half-space\""));
    }
}
