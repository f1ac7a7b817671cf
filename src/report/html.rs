//! Text, tables and pictures as HTML.

use maud::{Markup, PreEscaped, html};

use super::picture::harmless;
use crate::results::table::{Part, Report, Table};

/// A report for the terminal, as a page has it.
pub(super) fn report(report: &Report) -> Markup {
    html! {
        @for part in report.parts() {
            @match part {
                Part::Text(text) => @for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
                    p { (line) }
                },
                Part::Table(of) => (table(of)),
            }
        }
    }
}

/// A table, numbers to the right.
pub(super) fn table(table: &Table) -> Markup {
    let class = |column: usize| table.is_number(column).then_some("number");
    html! {
        div.table {
            table {
                @if !table.header().is_empty() {
                    thead { tr { @for (column, cell) in table.header().iter().enumerate() {
                        th class=[class(column)] { (cell) }
                    } } }
                }
                tbody { @for row in table.rows() {
                    tr { @for (column, cell) in row.iter().enumerate() { td class=[class(column)] { (cell) } } }
                } }
            }
        }
    }
}

/// A picture and what it shows.
pub(super) fn figure(svg: &str, caption: &str) -> Markup {
    html! {
        figure {
            @match harmless(svg) {
                Some(svg) => div.picture { (PreEscaped(svg)) },
                None => p.warning { "This picture is not one of tyrewave's and is left out." },
            }
            figcaption { (caption) }
        }
    }
}
