//! Values of successive sections of a road over the distance, with their standard errors as bands, in panels above each
//! other.

use super::axis::Axis;
use super::colour::{self, RANGE};
use super::layout::{EDGE, Key, width_beside};
use super::lines::STROKE;
use super::sheet::Sheet;

/// Height of a panel's frame in shown pixels.
const HEIGHT: f64 = 140.0;

/// Value of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StripSection {
    /// Begin and end of the section, in the unit of the horizontal axis.
    pub ends: [f64; 2],
    pub value: f64,
    /// Standard error of the value; 0 where it is not known.
    pub error: f64,
}

impl StripSection {
    fn range(&self) -> [f64; 2] {
        [self.value - self.error, self.value + self.error]
    }
}

/// A quantity along the road. A section without a value is left out, and interrupts the curve.
#[derive(Clone, Debug)]
pub(crate) struct StripSeries<'a> {
    /// Name in the panel's legend; not listed if it is empty.
    pub name: &'a str,
    pub sections: Vec<StripSection>,
}

#[derive(Clone, Debug)]
pub(crate) struct StripPanel<'a> {
    /// Quantity and unit.
    pub title: &'a str,
    pub series: Vec<StripSeries<'a>>,
}

/// Panels over a common distance. A panel without a value is not drawn.
#[derive(Clone, Debug)]
pub(crate) struct StripChart<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// Title of the horizontal axis, with its unit.
    pub along: &'a str,
    /// Panels, from the top.
    pub panels: Vec<StripPanel<'a>>,
}

impl StripChart<'_> {
    /// The picture as SVG; `None` without any value.
    pub(crate) fn to_svg(&self) -> Option<String> {
        let of_panel = |panel: &StripPanel<'_>| -> Vec<StripSection> {
            panel.series.iter().flat_map(|of| of.sections.clone()).collect()
        };
        let panels = self.panels.iter().map(|panel| (panel, of_panel(panel)));
        let panels: Vec<_> = panels.filter(|(_, all)| !all.is_empty()).collect();
        let places = || panels.iter().flat_map(|(_, all)| all.iter().flat_map(|section| section.ends));
        let along = places().reduce(f64::min)?..places().reduce(f64::max)?;
        let vertical = |(panel, all): &(&StripPanel<'_>, Vec<_>)| {
            Axis::linear_around(panel.title, all.iter().flat_map(StripSection::range))
        };
        let mut sheet = Sheet::default();
        sheet.left = panels.iter().map(|panel| width_beside(&vertical(panel), HEIGHT)).fold(0.0, f64::max);
        for (number, drawn @ (panel, _)) in panels.iter().enumerate() {
            let title = if number == 0 { self.title } else { "" };
            let below = if number + 1 == panels.len() { self.along } else { "" };
            let x = Axis::linear(below, along.clone());
            let y = vertical(drawn);
            let axes = sheet.axes(title, [&x, &y], HEIGHT, EDGE);
            for series in &panel.series {
                for stretch in stretches(&series.sections) {
                    let edge = |side: usize| stretch.iter().flat_map(move |of| of.ends.map(|x| (x, of.range()[side])));
                    let mut upper: Vec<_> = edge(1).collect();
                    upper.reverse();
                    let corners = edge(0).chain(upper).map(|corner| axes.within(corner));
                    sheet.band(&corners.collect::<Vec<_>>(), RANGE);
                }
            }
            for (index, series) in panel.series.iter().enumerate() {
                for stretch in stretches(&series.sections) {
                    let points: Vec<_> = stretch.iter().flat_map(|of| of.ends.map(|x| (x, of.value))).collect();
                    sheet.curve(&axes, &points, colour::line(index), STROKE);
                }
            }
            sheet.outline(axes.frame);
            let series = panel.series.iter().enumerate();
            sheet.legend(series.map(|(index, series)| (series.name, colour::line(index), Key::Line)));
        }
        Some(sheet.into_svg())
    }
}

/// Sections that follow each other without a gap.
fn stretches(sections: &[StripSection]) -> impl Iterator<Item = &[StripSection]> {
    sections.chunk_by(|a, b| b.ends[0] - a.ends[1] < 0.5 * (b.ends[1] - b.ends[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_interrupts_and_an_empty_panel_is_not_drawn() {
        let section = |n: i32| StripSection {
            ends: [20.0 * f64::from(n), 20.0 * f64::from(n + 1)],
            value: f64::from(n % 3),
            error: 0.5,
        };
        let sections = [0, 1, 2, 5, 6].map(section);
        assert_eq!(stretches(&sections).map(<[_]>::len).collect::<Vec<_>>(), [3, 2]);
        let series = |sections: &[StripSection]| vec![StripSeries { name: "cpx", sections: sections.to_vec() }];
        let panels = vec![
            StripPanel { title: "Sound [dB(A)]", series: series(&sections) },
            StripPanel { title: "Nothing", series: series(&[]) },
        ];
        let chart = StripChart { title: "t", along: "Distance [m]", panels };
        let svg = chart.to_svg().unwrap();
        assert_eq!(svg.matches("<polygon").count(), 2, "{svg}");
        for text in ["Sound", "Distance", ">cpx<", ">140<"] {
            assert!(svg.contains(text), "{text}: {svg}");
        }
        assert!(!svg.contains("Nothing"));
        assert_eq!(StripChart { panels: Vec::new(), ..chart }.to_svg(), None);
    }
}
