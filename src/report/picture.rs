//! Pictures in a page: SVG that draws and does nothing else.

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
    use super::*;
    use crate::results::plots::{Axis, LinePlot, Series};

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
