//! The paper computed again, as a page and as a table.

use crate::report::html::{document, figure, table};
use crate::results::table::{Table, aligned, row, words};
use crate::scene::Scene;
use maud::{Markup, html};

use super::levels::Change;
use super::pictures::Picture;
use super::recompute::Paper;
use super::search::Solves;
use super::statement::{Statement, Verdict};

/// Table of the paper's statements beside the findings.
pub(super) fn statement_table(statements: &[Statement]) -> Table {
    let rows = statements.iter().map(|of| {
        let statement = format!("{}: {}", of.place, of.subject);
        row([&statement, &of.paper, &of.found, &of.judgement()])
    });
    words(["statement", "paper", "found", "verdict"], rows)
}

/// Settings of the computation, in words.
pub(super) fn settings(paper: &Paper, scene: &Scene) -> String {
    let of = &paper.options;
    format!(
        "{} km/h; figures 4 to 6 with {} elements, time steps an element: {}, over {} s after {} s of warm-up, {}; \
         equation 4 with {} elements over {} s, the axle held; third octaves from 100 to {} Hz.",
        scene.rolling.speed_kmh,
        of.elements,
        scene.numerics.substeps,
        of.duration,
        scene.rolling.warm_up,
        scene.numerics.time_rule.name(),
        of.coarse_elements,
        of.coarse_duration,
        of.highest
    )
}

/// Changes by halving the step, coupling by coupling.
fn halving_table(paper: &Paper) -> Table {
    let of = &paper.equation_4;
    let steps = of.steps.iter().take(of.steps.len().saturating_sub(1));
    let header = std::iter::once("from a step of".to_owned()).chain(steps.map(|step| format!("{:.3} ms", 1e3 * step)));
    let rows = of.couplings.iter().map(|refined| {
        let found = refined.differences.iter().zip(&refined.levels);
        let cells = found.map(|(difference, level)| format!("{difference:.4} ({level:.2} dB)"));
        std::iter::once(refined.name.to_owned()).chain(cells).collect::<Vec<_>>()
    });
    aligned(header, rows)
}

/// Changes of the levels by laws of tread and slices.
fn law_table(paper: &Paper) -> Table {
    let [_, bedding, uncoupled] = &paper.tread_laws.laws;
    let cell = |changes: &[Change], frequency: f64| {
        let found = changes.iter().find(|change| (change.frequency / frequency - 1.0).abs() < 1e-9);
        found.map_or(String::new(), |found| format!("{:+.2}", found.change))
    };
    let rows = bedding.changes.iter().map(|change| {
        let frequency = change.frequency;
        [
            format!("{frequency}"),
            format!("{:+.2}", change.change),
            cell(&uncoupled.changes, frequency),
            cell(&paper.slice.local.changes, frequency),
            cell(&paper.slice.equation_4.changes, frequency),
        ]
    });
    aligned(["Hz", "bedding [dB]", "uncoupled [dB]", "half-space slices [dB]", "the same, equation 4 [dB]"], rows)
}

/// Numbers of instants by number of solves.
fn solves_table(paper: &Paper) -> Table {
    let of = &paper.search;
    let most = of.local.histogram.keys().chain(of.equation_4.histogram.keys()).max().copied().unwrap_or(0);
    let rows = (0..=most).map(|solves| {
        let count = |found: &Solves| found.histogram.get(&solves).copied().unwrap_or(0);
        [u64::from(solves), count(&of.local), count(&of.equation_4)]
    });
    aligned(["solves", "instants, local law", "instants, equation 4"], rows)
}

/// HTML page of everything, self-contained.
pub(super) fn page(paper: &Paper, scene: &Scene, pictures: &[Picture]) -> String {
    let mut places: Vec<&str> = Vec::new();
    for of in &paper.statements {
        if !places.contains(&of.place) {
            places.push(of.place);
        }
    }
    let more = |place: &str| -> Markup {
        match place {
            "figure 6" => html! { details { summary { "Changes of the levels by laws" } (table(&law_table(paper))) } },
            "contact search" => html! { (table(&solves_table(paper))) },
            "equation 4" => html! { (table(&halving_table(paper))) },
            _ => html! {},
        }
    };
    let content = html! {
        article {
            header {
                h1 { "The paper, computed again" }
                p {
                    "K. Larsson, " em { "Numerical modelling of the tyre/road contact" } " (Chalmers): its figures and \
                     its statements on performance, each computed again and held against what it says."
                }
                p { (settings(paper, scene)) }
                p { (tally(&paper.statements)) }
            }
            (table(&statement_table(&paper.statements)))
            @for place in &places {
                section id=(place.replace(' ', "-")) {
                    h2 { (capital(place)) }
                    @for of in paper.statements.iter().filter(|of| of.place == *place) {
                        p {
                            (capital(of.subject)) ". The paper: " (of.paper) ". Found: " (of.found) ". "
                            strong class=[(of.verdict == Verdict::Disagrees).then_some("warning")] {
                                (capital(&of.judgement())) "."
                            }
                        }
                    }
                    @for picture in pictures.iter().filter(|picture| picture.place == *place) {
                        (figure(&picture.svg, &picture.caption))
                    }
                    (more(place))
                }
            }
        }
    };
    document("The paper, computed again", &content)
}

/// Numbers of statements by verdict, in words.
pub(super) fn tally(statements: &[Statement]) -> String {
    let count = |verdict| statements.iter().filter(|of| of.verdict == verdict).count();
    format!(
        "{} agree, {} disagree, {} cannot be compared.",
        count(Verdict::Agrees),
        count(Verdict::Disagrees),
        count(Verdict::NotComparable)
    )
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
