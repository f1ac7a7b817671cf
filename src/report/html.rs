//! Text, tables and pictures as HTML, for self-contained pages.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::picture::harmless;
use crate::results::table::{Report, ReportPart, TextTable};

/// Section of a page: heading, pictures with their captions, and tables.
pub(crate) struct Chapter<'a> {
    /// Title of the section.
    pub heading: &'a str,
    /// Pictures as SVG, each with its caption.
    pub pictures: Vec<[&'a str; 2]>,
    /// Text and tables below them.
    pub tables: &'a Report,
}

/// A whole page of sections, after an introduction.
pub(crate) fn chapters(title: &str, lead: &str, all: &[Chapter<'_>]) -> String {
    let section = |Chapter { heading, pictures, tables }: &Chapter<'_>| {
        let content = html! {
            @for [svg, caption] in pictures { (figure(svg, caption)) }
            (report(tables))
        };
        ((*heading).to_owned(), content)
    };
    document(title, &article(0, title, &html! { p { (lead) } }, all.iter().map(section)))
}

/// An article: its title, its contents, an introduction, and its sections under their headings; empty sections are left
/// out. `number` makes its anchors unique on the page.
pub(super) fn article(
    number: usize,
    title: &str,
    lead: &Markup,
    sections: impl IntoIterator<Item = (String, Markup)>,
) -> Markup {
    let sections: Vec<_> = sections.into_iter().filter(|(_, content)| !content.0.trim().is_empty()).collect();
    let id = |heading: &str| format!("{}-{number}", heading.to_ascii_lowercase().replace(' ', "-"));
    html! {
        article id=(format!("article-{number}")) {
            header {
                h1 { (title) }
                nav { ul {
                    @for (heading, _) in &sections { li { a href=(format!("#{}", id(heading))) { (heading) } } }
                } }
                (lead)
            }
            @for (heading, content) in &sections { section id=(id(heading)) { h2 { (heading) } (content) } }
        }
    }
}

/// A whole page: styles, the script that shows values at the pointer, and the content; nothing is fetched.
pub(crate) fn document(title: &str, content: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta name="generator" content="tyrewave";
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(include_str!("page.css"))) }
            }
            body {
                main {
                    (content)
                    footer { "Made by tyrewave " (env!("CARGO_PKG_VERSION")) ". SI units; levels as labelled." }
                }
                div #told role="status" hidden {}
                script { (PreEscaped(include_str!("page.js"))) }
            }
        }
    };
    page.into_string()
}

/// A report as HTML.
pub(super) fn report(report: &Report) -> Markup {
    html! {
        @for part in report.parts() {
            @match part {
                ReportPart::Text(text) => @for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
                    p { (line) }
                },
                ReportPart::Table(of) => (table(of)),
            }
        }
    }
}

/// A table, with numbers right-aligned.
pub(crate) fn table(table: &TextTable) -> Markup {
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

/// A figure of a picture and its caption; a picture that is not one of tyrewave's is replaced by a remark.
pub(crate) fn figure(svg: &str, caption: &str) -> Markup {
    html! {
        figure {
            @match harmless(svg) {
                Some(svg) => div.picture role="img" aria-label=(caption) { (PreEscaped(svg)) },
                None => p.warning { "This picture is not one of tyrewave's and is left out." },
            }
            figcaption { (caption) }
        }
    }
}
