//! Sections of a page on one result, in the order of the data's way.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

use super::compare::figures_of;
use super::error::ReportError;
use super::html::{figure, report, table};
use super::road::{description, map, texture_spectrum};
use super::stored::{Spectrum, Stored};
use crate::plan::Plan;
use crate::results::plots::{Axis, LinePlot, Series, ThirdOctavePlot, four_digits};
use crate::results::profile_table::cost_table;
use crate::results::sound::SOUND_LEVEL;
use crate::results::table::{Table, aligned, row, words};
use crate::road::describe;
use crate::run::road::road_limits;
use crate::scene::{Axle, Road, Scene, Zone};
use crate::sound::wav::rescaled;

/// Meaning of grey in pictures of levels.
pub(super) const GREY: &str = "Grey: bands that the run does not vouch for.";
/// Sound files longer than this are left in their folder \[bytes\].
const MOST_SOUND: usize = 16 << 20;

/// Which effects are simulated, how and why.
pub fn decision_table(plan: &Plan) -> Table {
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

/// Shows the findings, in figures.
pub(super) fn figures(stored: &Stored) -> Markup {
    let outcome = &stored.summary.outcome;
    let wall = stored.summary.cost.wall_seconds;
    html! {
        dl.figures {
            @for (name, unit, value) in figures_of(stored) {
                div { dt { (name) } dd { (four_digits(value)) " " (unit) } }
            }
            @if wall > 0.0 {
                div { dt { "speed of the run" } dd { (four_digits(outcome.simulated_time / wall)) " x real time" } }
            }
        }
        @if let Some(load) = outcome.load { p class=[(!load.met).then_some("warning")] { (load) "." } }
    }
}

/// Shows the warnings.
pub(super) fn warnings(stored: &Stored) -> Markup {
    let summary = &stored.summary;
    html! {
        @if !summary.complete {
            p.warning { "The run was interrupted: figures and spectra are of the part that was rolled." }
        }
        @if !summary.warnings.is_empty() { ul { @for warning in &summary.warnings { li { (warning) } } } }
    }
}

/// The plan: which effects, why, and up to where levels are good.
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
    let described = stored
        .plan
        .lattice()
        .and_then(|lattice| describe(&scene.road, lattice, scene.rolling.speed(), road_limits(scene)));
    let road = match described {
        Ok(road) => road,
        Err(error) => return Ok(html! { p.warning { "The road cannot be shown: " (error) "." } }),
    };
    let heights = (!road.sample.heights.is_empty()).then(|| map("Heights of the road", &road)).transpose()?;
    let spectrum = texture_spectrum("Texture of the road, third octaves", &road)?;
    Ok(html! {
        @if let Some(heights) = heights { (figure(&heights, "The first metre of the road under the tyre.")) }
        @if let Some(spectrum) = spectrum {
            (figure(&spectrum, "Texture spectrum: energy mean over the contact width, on the road's own lattice."))
        }
        (report(&description(&road)))
    })
}

/// Forces over patch and time.
pub(super) fn contact(stored: &Stored) -> Result<Markup, ReportError> {
    let mut shown = total_force(stored)?.into_iter().collect::<Vec<_>>();
    let pictures = [
        ("patch_force.svg", "Force of every element over patch and time; the axle is at 0, rolling to the right."),
        ("cells_pressure.svg", "Pressure of every cell at the last instant that was written."),
        ("cells_mean_pressure.svg", "Mean pressure of every cell."),
        ("cells_road.svg", "The road under the cells at that instant."),
    ];
    for (file, caption) in pictures {
        shown.extend(stored.text(file)?.map(|svg| figure(&svg, caption)));
    }
    let of = &stored.summary.contact;
    let share = |what: &str, value: f64| row([&what, &format!("{value:.1e}")]);
    let mut residuals = vec![
        share("tension, of the peak force", of.tension),
        share("penetration left, of the largest", of.penetration),
        share("complementarity", of.complementarity),
    ];
    residuals.extend(of.local_compliance.map(|kappa| row([&"kappa [m/Pa]", &format!("{kappa:.3e}")])));
    Ok(html! {
        @for figure in shown { (figure) }
        p { "How well the conditions of contact were met, over all steps:" }
        (table(&aligned([""; 0], residuals)))
    })
}

/// The total force over time.
fn total_force(stored: &Stored) -> Result<Option<Markup>, ReportError> {
    let (Some(time), Some(force)) = (stored.column("time.npy")?, stored.column("total_force.npy")?) else {
        return Ok(None);
    };
    let warm_up = stored.plan.scene.rolling.warm_up;
    let points: Vec<(f64, f64)> = time.into_iter().zip(force).filter(|(time, _)| *time >= warm_up).collect();
    let (Some((from, _)), Some((to, _))) = (points.first(), points.last()) else { return Ok(None) };
    let plot = LinePlot {
        title: "Total contact force",
        x: Axis::linear("Time [s]", *from..*to),
        y: Axis::linear_around("Force [N]", points.iter().map(|point| point.1)),
        series: vec![Series { name: "", points }],
    };
    Ok(Some(figure(&plot.to_svg()?, "Total contact force of every step after the warm-up.")))
}

/// Spectra of some quantity in one picture, and as a table.
pub(super) fn spectra(stored: &Stored, quantity: &str, title: &str) -> Result<Markup, ReportError> {
    let of: Vec<&Spectrum> = stored.spectra.iter().filter(|spectrum| spectrum.quantity == quantity).collect();
    let Some(first) = of.first() else { return Ok(html! {}) };
    let named = |spectrum: &&Spectrum| (spectrum.name.clone(), spectrum.levels.clone());
    let named: Vec<_> = of.iter().map(named).collect();
    let drawn: Vec<_> = named.iter().map(|(name, levels)| (name.as_str(), levels.as_slice())).collect();
    let plot = ThirdOctavePlot { title, quantity: first.quantity, spectra: drawn, error: first.error };
    let error = first.error.map_or(String::new(), |(from, error)| {
        let from = if from > 0.0 { format!(" from {from:.0} Hz on") } else { String::new() };
        format!(" Levels are within {error:.1} dB{from}, as far as the numerical solution goes.")
    });
    let caption = format!("{title}. {GREY}{error}");
    let rows = first.levels.iter().map(|level| {
        let cells = of.iter().map(|spectrum| {
            let found = spectrum.levels.iter().find(|other| other.band == level.band);
            found.map_or(String::new(), |found| {
                if found.valid { format!("{:.1}", found.level) } else { format!("({:.1})", found.level) }
            })
        });
        std::iter::once(level.band.label()).chain(cells).collect::<Vec<_>>()
    });
    let header = std::iter::once("Hz".to_owned()).chain(
        of.iter().map(|spectrum| if spectrum.name.is_empty() { "dB".to_owned() } else { spectrum.name.clone() }),
    );
    Ok(html! {
        (figure(&plot.to_svg()?, &caption))
        details { summary { "The levels as a table" } (table(&aligned(header, rows))) }
    })
}

/// Pictures of the folder whose names begin so, in the order of their names; what follows in the name says which.
pub(super) fn pictures(stored: &Stored, begin: &str, caption: &str) -> Result<Markup, ReportError> {
    let mut shown = Vec::new();
    for name in stored.summary.files.iter().filter(|name| name.starts_with(begin) && name.ends_with(".svg")) {
        shown.extend(stored.text(name)?.map(|svg| figure(&svg, &format!("{}: {caption}", shown_by(name, begin)))));
    }
    Ok(html! { @for figure in shown { (figure) } })
}

/// Receiver or field of a picture, from its file's name.
fn shown_by(name: &str, begin: &str) -> String {
    name.strip_prefix(begin).unwrap_or(name).trim_end_matches(".svg").replace('_', " ")
}

/// Levels at the receivers, and what they hear by one full scale \[Pa\].
pub(super) fn sound(stored: &Stored, full_scale: f64) -> Result<Markup, ReportError> {
    let Some(sound) = &stored.summary.sound else { return Ok(html! {}) };
    let mut players = Vec::new();
    for heard in &sound.receivers {
        let Some(audio) = &heard.audio else { continue };
        let mut bytes = stored.bytes(&audio.file)?;
        if audio.full_scale < full_scale
            && let Some(Ok(shared)) = rescaled(&bytes, full_scale)
        {
            bytes = shared;
        }
        let playable = bytes.len() <= MOST_SOUND;
        players.push(html! {
            p {
                (heard.name) ", " (format!("{:.1}", audio.seconds)) " s, full scale " (full_scale) " Pa: "
                @if playable {
                    audio controls src=(format!("data:audio/wav;base64,{}", STANDARD.encode(&bytes))) {}
                } @else { (audio.file) " is too long to be played here." }
            }
        });
    }
    Ok(html! {
        ul { @for heard in &sound.receivers { li { strong { (heard.name) } ": " (heard.text()) } } }
        @for player in players { (player) }
        (spectra(stored, SOUND_LEVEL, "Sound pressure at the receivers, A-weighted third octaves")?)
        (pictures(stored, "pass_by_", "level while the tyre passes")?)
        (pictures(stored, "directivity_", "level over the angle from straight ahead")?)
    })
}

/// Shows the cost.
pub(super) fn cost(stored: &Stored) -> Markup {
    report(&cost_table(&stored.summary.cost))
}

/// All that is needed to run it again.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_caption_names_its_receiver_once_and_as_the_scene_does() {
        assert_eq!(shown_by("pass_by_coast-by.svg", "pass_by_"), "coast-by");
        assert_eq!(shown_by("vibration_map_tread_non-rotating.svg", "vibration_map_"), "tread non-rotating");
    }
}
