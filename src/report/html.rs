//! Text, tables and pictures as HTML, for self-contained pages. Pictures are SVG that draws and does nothing else.

use crate::results::table::{Report, ReportPart, TextTable};
use maud::{DOCTYPE, Markup, PreEscaped, html};

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
                @if !table.header.is_empty() {
                    thead { tr { @for (column, cell) in table.header.iter().enumerate() {
                        th class=[class(column)] { (cell) }
                    } } }
                }
                tbody { @for row in &table.rows {
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

/// The elements that pictures consist of.
const ELEMENTS: [&str; 10] = ["svg", "g", "path", "rect", "line", "polyline", "polygon", "circle", "text", "title"];

/// The picture, if it consists of drawn elements alone, without script, link, or anything else that a page would fetch
/// or execute; `None` otherwise. A results folder may come from a stranger.
pub(super) fn harmless(svg: &str) -> Option<&str> {
    let mut rest = svg.trim();
    let whole = rest;
    if !rest.starts_with("<svg ") || !rest.ends_with("</svg>") {
        return None;
    }
    while let Some(start) = rest.find('<') {
        let tag = &rest[start + 1..];
        let end = tag.find('>')?;
        let (tag, after) = (&tag[..end], &tag[end + 1..]);
        let mut words = tag.trim_matches('/').split(|letter: char| letter.is_whitespace());
        if !ELEMENTS.contains(&words.next()?) {
            return None;
        }
        let forbidden = |word: &str| {
            let word = word.to_ascii_lowercase();
            word.starts_with("on") || word.contains("href") || word.contains("url(") || word.starts_with("style")
        };
        if words.any(forbidden) {
            return None;
        }
        rest = after;
    }
    Some(whole)
}

#[cfg(test)]
mod tests {
    use crate::results::plots::{Axis, LinePlot, Series};

    use super::*;

    #[test]
    fn own_pictures_are_embedded_and_active_ones_refused() {
        let plot = LinePlot {
            title: "a < b",
            x: Axis::linear("x", 0.0..1.0),
            y: Axis::linear("y", 0.0..1.0),
            series: vec![Series { name: "one", points: vec![(0.0, 0.1), (0.5, 0.9), (1.0, 0.3)] }],
        };
        let svg = plot.to_svg();
        assert_eq!(harmless(&svg), Some(svg.trim()));
        for wrong in [
            "<svg ><script>alert(1)</script></svg>",
            "<svg ><rect onload=\"x\"/></svg>",
            "<svg ><rect\tONclick=\"x\"/></svg>",
            "<svg ><path fill=\"url(http://x)\"/></svg>",
            "<svg ><image href=\"http://x\"/></svg>",
            "<svg ><foreignObject></foreignObject></svg>",
            "<svg ><style>x</style></svg>",
            "<svg ><g",
            "<html></html>",
            "",
        ] {
            assert_eq!(harmless(wrong), None, "{wrong}");
        }
    }
}
