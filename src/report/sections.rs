//! Sections of a page on one result, in the order of the computation.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

use super::compare::figures_of;
use super::html::{figure, report, table};
use super::road::{description, map, texture_spectrum};
use crate::effects::stored::Stored;
use crate::effects::{Figure, ReportError, SectionBlock};
use crate::plan::Plan;
use crate::results::cost::cost_table;
use crate::results::plots::four_digits;
use crate::results::table::{TextTable, aligned, row, words};
use crate::run::road::described;
use crate::scene::{Axle, Road, Scene, Zone};

/// Larger sound files stay in their folder \[bytes\].
const MOST_SOUND: usize = 16 << 20;

/// Table of the effects: which are simulated, how and why.
pub(crate) fn decision_table(plan: &Plan) -> TextTable {
    let effects = plan.decisions.rows.iter().map(|decision| {
        let state = if decision.on { "on" } else { "off" };
        row([&decision.effect, &state, &decision.form, &decision.reason])
    });
    words(["effect", "", "how", "why"], effects)
}

/// The scene in a few sentences.
pub(super) fn in_words(stored: &Stored) -> String {
    let Plan { scene, element, time_step, .. } = &stored.plan;
    let Scene { tyre, rolling, contact, numerics, .. } = scene;
    let mut form = vec![if tyre.curvature { "curved" } else { "flat" }.to_owned()];
    form.extend(tyre.inflation.as_ref().map(|inflation| format!("inflated to {:.0} kPa", 1e-3 * inflation.pressure)));
    form.extend(tyre.cavity.as_ref().map(|_| "its air a resonator".to_owned()));
    let road = match &scene.road {
        Road::Smooth => "a smooth road".to_owned(),
        Road::Made(made) => format!("a made road (seed {})", made.seed),
        Road::Profile(_) | Road::OpenCrg(_) | Road::Grid(_) => {
            let file = scene.road.file().and_then(|file| file.file_name()).unwrap_or_default();
            format!("the measured road {}", file.to_string_lossy())
        }
    };
    let axle = match &rolling.axle {
        Axle::Indentation { indentation, .. } => format!("its axle {:.2} mm into the road", 1e3 * indentation),
        other => match other.load() {
            Some((load, _)) => format!("under a load of {load:.0} N"),
            None => "on an axle of its own".to_owned(),
        },
    };
    let zone = match contact.zone {
        Zone::Slices => "slices of the road, one an element",
        Zone::Cells => "every cell of the contact strip",
    };
    format!(
        "A tyre of {:.3} m round and {:.0} mm across ({}) rolls at {} km/h over {road}, {axle}, for {} s after {} s of \
         warm-up. The contact is that of {zone}: {} elements of {:.2} mm, time steps of {:.1} us by {}.",
        tyre.circumference,
        1e3 * tyre.width,
        form.join(", "),
        rolling.speed_kmh,
        rolling.duration,
        rolling.warm_up,
        numerics.elements,
        1e3 * element,
        1e6 * time_step,
        numerics.time_rule.name(),
    )
}

/// Figures of the run.
pub(super) fn figures(stored: &Stored) -> Markup {
    let outcome = &stored.summary.outcome;
    let wall = stored.summary.cost.wall_seconds;
    html! {
        dl.figures {
            @for Figure { name, unit, value, total } in figures_of(stored) {
                @if let Some(level) = total {
                    div { dt { (name) ", " (level.range()) } dd { (level.text()) " " (unit) } }
                } @else {
                    div { dt { (name) } dd { (four_digits(value)) " " (unit) } }
                }
            }
            @if wall > 0.0 {
                div { dt { "speed of the run" } dd { (four_digits(outcome.simulated_time / wall)) " x real time" } }
            }
        }
        @if let Some(load) = outcome.load { p class=[(!load.met).then_some("warning")] { (load) "." } }
    }
}

pub(super) fn warnings(stored: &Stored) -> Markup {
    let summary = &stored.summary;
    html! {
        @if !summary.complete {
            p.warning { "The run was interrupted: figures and spectra are of the part that was rolled." }
        }
        @if !summary.warnings.is_empty() { ul { @for warning in &summary.warnings { li { (warning) } } } }
    }
}

/// The plan: which effects, why, and up to which frequency levels are valid.
pub(super) fn plan(stored: &Stored) -> Markup {
    let of = &stored.plan;
    html! {
        (table(&decision_table(of)))
        p {
            "Elements and time steps are good for levels up to " (format!("{:.0}", of.valid_to))
            " Hz; a road that ends before lowers that. Bands beyond are grey."
        }
        @if !stored.summary.notes.is_empty() { ul { @for note in &stored.summary.notes { li { (note) } } } }
    }
}

/// The road in colours, its texture spectrum and its measures.
pub(super) fn road(stored: &Stored) -> Result<Markup, ReportError> {
    let scene = &stored.plan.scene;
    if let Some(file) = scene.road.file().filter(|_| !stored.knows_road) {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        return Ok(html! {
            p {
                "The road is measured, and its file, " (name) ", is not among the results. " code { "tyrewave road" }
                " shows it; " code { "tyrewave run --report" } " shows it here."
            }
        });
    }
    let road = match described(&stored.plan) {
        Ok(road) => road,
        Err(error) => return Ok(html! { p.warning { "The road cannot be shown: " (error) "." } }),
    };
    let heights = (!road.sample.heights.is_empty()).then(|| map("Heights of the road", &road)).transpose()?;
    let spectrum = texture_spectrum("Texture of the road, third octaves", &road);
    Ok(html! {
        @if let Some(heights) = heights { (figure(&heights, "The first metre of the road under the tyre.")) }
        @if let Some(spectrum) = spectrum {
            (figure(&spectrum, "Texture spectrum: energy mean over the contact width, on the road's own lattice."))
        }
        (report(&description(&road)))
    })
}

/// Residuals of the contact conditions.
pub(super) fn residuals(stored: &Stored) -> Markup {
    let of = &stored.summary.contact;
    let share = |what: &str, value: f64| row([&what, &format!("{value:.1e}")]);
    let mut residuals = vec![
        share("tension, of the peak force", of.tension),
        share("penetration left, of the largest", of.penetration),
        share("complementarity", of.complementarity),
    ];
    residuals.extend(of.local_compliance.map(|kappa| row([&"kappa [m/Pa]", &format!("{kappa:.3e}")])));
    html! {
        p { "How well the conditions of contact were met, over all steps:" }
        (table(&aligned([""; 0], residuals)))
    }
}

/// Blocks of an effect's section.
pub(super) fn blocks(blocks: &[SectionBlock]) -> Markup {
    html! {
        @for block in blocks {
            @match block {
                SectionBlock::Picture([svg, caption]) => (figure(svg, caption)),
                SectionBlock::Levels(levels) => details { summary { "The levels as a table" } (table(levels)) },
                SectionBlock::List(named) => ul { @for [name, text] in named { li { strong { (name) } ": " (text) } } },
                SectionBlock::Sound { words, file, bytes } => p {
                    (words)
                    @if bytes.len() <= MOST_SOUND {
                        (player(bytes))
                    } @else { (file) " is too long to be played here." }
                },
            }
        }
    }
}

/// Player of a WAV file, embedded.
pub(super) fn player(bytes: &[u8]) -> Markup {
    html! { audio controls src=(format!("data:audio/wav;base64,{}", STANDARD.encode(bytes))) {} }
}

pub(super) fn cost(stored: &Stored) -> Markup {
    report(&cost_table(&stored.summary.cost))
}

/// Everything needed to repeat the run.
pub(super) fn repeat(stored: &Stored) -> Result<Markup, ReportError> {
    let summary = &stored.summary;
    let scene = toml::to_string_pretty(&summary.settings).unwrap_or_default();
    Ok(html! {
        p {
            "tyrewave " (summary.version) ", " (summary.cost.threads) " threads; their number changes no result. The "
            "settings have the SHA-256 " code { (summary.scene_sha256) } "."
        }
        p {
            "The scene with every default filled in; saved as " code { "scene.toml" } ", "
            code { "tyrewave run scene.toml" } " gives the same bytes. A measured road is named relative to where the "
            "scene was."
        }
        pre { code { (scene) } }
    })
}
