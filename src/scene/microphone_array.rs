//! Files of microphone positions: tables, and the XML that programs for microphone arrays exchange.
//!
//! A table has a line for each microphone; delimiter and decimal sign are recognised from its numbers. Either it has
//! titles (`name,x,y,z` in any order, units in the titles), or its columns are `x,y,z` or `name,x,y,z` in metres. XML
//! has elements with attributes `x`, `y`, `z` in metres, and possibly `Name`: `<MicArray><pos Name="a" x="0.5" y="0.4"
//! z="0.1"/></MicArray>`.

use std::ops::Range;

use roxmltree::{Attribute, Document, Node, ParsingOptions};

use super::Problem;
use super::problem::SourceText;
use crate::storage::separated::{Record, SeparatedTable};

/// Most microphones of a file.
pub(super) const MOST: usize = 1000;
/// Most nodes of XML that are parsed: elements, texts between them, comments.
const MOST_NODES: u32 = 20 * MOST as u32;
const AXES: [&str; 3] = ["x", "y", "z"];
/// Units of lengths in column titles \[m\].
const UNITS: [(&str, f64); 5] = [("m", 1.0), ("mm", 1e-3), ("cm", 1e-2), ("in", 0.0254), ("ft", 0.3048)];
const AS_ROW: &str = "write name,x,y,z: a name, and metres as numbers";
const AS_TITLES: &str = "begin the file with the line name,x,y,z";
const AS_ELEMENT: &str = "write <pos Name=\"a\" x=\"0.5\" y=\"0.4\" z=\"0.1\"/>, in metres";

/// A microphone, and its place in the text.
pub(super) struct Microphone {
    /// Name; empty if the file gives none.
    pub name: String,
    /// Position \[m\] in the coordinates of the file.
    pub position: [f64; 3],
    /// Range of the whole entry in the text.
    pub whole: Range<usize>,
    pub name_at: Range<usize>,
    pub position_at: [Range<usize>; 3],
}

/// Mistakes in a file: range in the text, and problem.
pub(super) type Mistakes = Vec<(Range<usize>, Problem)>;

/// Columns of a table: that of the name, if there is one, and those of the coordinates with their units \[m\].
struct Columns {
    name: Option<usize>,
    axes: [usize; 3],
    units: [f64; 3],
    /// Number of cells in a line.
    count: usize,
}

/// Reads the microphones of a file, or reports all mistakes in it.
pub(super) fn microphones(source: &SourceText) -> Result<Vec<Microphone>, Mistakes> {
    let text = source.text.trim_start_matches('\u{feff}').trim_start();
    let found = if text.starts_with('<') { of_xml(&source.text)? } else { of_table(&source.text)? };
    if found.is_empty() {
        let problem = if text.is_empty() { "the file is empty" } else { "the file names no microphone" };
        return Err(vec![(0..0, Problem::new(problem, AS_ROW))]);
    }
    Ok(found)
}

fn too_many() -> Problem {
    Problem::new(format!("the file has more than {MOST} rows"), "make several runs of it")
}

fn not_a_number(text: &str) -> String {
    if text.is_empty() { "a number is missing".to_owned() } else { format!("\"{text}\" is not a number") }
}

/// Range of a part within a text; empty, at its beginning, if it is not a part of it.
fn place(text: &str, part: &str) -> Range<usize> {
    let start = (part.as_ptr() as usize).wrapping_sub(text.as_ptr() as usize);
    let end = start.saturating_add(part.len());
    if end <= text.len() { start..end } else { 0..0 }
}

fn of_table(text: &str) -> Result<Vec<Microphone>, Mistakes> {
    let table = SeparatedTable::of(text.as_bytes());
    let (mut found, mut wrong) = (Vec::new(), Mistakes::new());
    let mut columns = None;
    for record in table.records() {
        let first = record.cells.first().map_or(0..0, |cell| place(text, cell));
        let whole = first.start..record.cells.last().map_or(first.end, |cell| place(text, cell).end).max(first.start);
        let columns = match &columns {
            Some(columns) => columns,
            None => {
                let (titled, is_titles) =
                    Columns::of(&table, &record).map_err(|problem| vec![(whole.clone(), problem)])?;
                columns = Some(titled);
                match &columns {
                    Some(columns) if !is_titles => columns,
                    _ => continue,
                }
            }
        };
        if found.len() == MOST {
            wrong.push((whole, too_many()));
            break;
        }
        if record.cells.len() != columns.count {
            let (count, wanted) = (record.cells.len(), columns.count);
            wrong.push((whole, Problem::new(format!("this row has {count} values, and {wanted} are needed"), AS_ROW)));
            continue;
        }
        let name = columns.name.map_or("", |name| record.cells[name]);
        let cells = columns.axes.map(|axis| record.cells[axis]);
        let mut position = [0.0; 3];
        for ((coordinate, cell), unit) in position.iter_mut().zip(cells).zip(columns.units) {
            match table.number(cell) {
                Some(number) => *coordinate = unit * number,
                None => wrong.push((place(text, cell), Problem::new(not_a_number(cell), AS_ROW))),
            }
        }
        let name_at = if name.is_empty() { whole.clone() } else { place(text, name) };
        let position_at = cells.map(|cell| place(text, cell));
        found.push(Microphone { name: name.to_owned(), position, whole, name_at, position_at });
    }
    if wrong.is_empty() { Ok(found) } else { Err(wrong) }
}

impl Columns {
    /// Reads the first line; true if it has titles, false if it is already a microphone.
    fn of(table: &SeparatedTable<'_>, first: &Record<'_>) -> Result<(Self, bool), Problem> {
        let is_number: Vec<bool> = first.cells.iter().map(|cell| table.number(cell).is_some()).collect();
        let untitled = |name, begin| {
            let axes = [begin, begin + 1, begin + 2];
            (Self { name, axes, units: [1.0; 3], count: begin + 3 }, false)
        };
        match is_number[..] {
            [true, true, true] => return Ok(untitled(None, 0)),
            [false, true, true, true] => return Ok(untitled(Some(0), 1)),
            [_, true, true, true] => {
                let wrong = "four numbers, and nothing says which are coordinates";
                return Err(Problem::new(wrong, AS_TITLES));
            }
            _ => {}
        }
        let titles: Vec<String> = first.cells.iter().map(|title| title.to_lowercase()).collect();
        let mut units = [1.0; 3];
        let mut axes = [0; 3];
        for ((axis, place), unit) in AXES.iter().zip(&mut axes).zip(&mut units) {
            let is_axis = |title: &String| unit_of(title, axis).is_some();
            let Some(column) = titles.iter().position(is_axis) else {
                let wrong = format!("this is not the line that names the columns: none is called {axis}");
                return Err(Problem::new(wrong, AS_TITLES));
            };
            let title = &titles[column];
            *unit = unit_of(title, axis).flatten().ok_or_else(|| {
                let known = UNITS.map(|(name, _)| name).join(", ");
                Problem::new(format!("the unit of \"{title}\" is not known"), format!("one of {known}"))
            })?;
            *place = column;
        }
        let name = titles.iter().position(|title| ["name", "label", "id", "microphone"].contains(&title.as_str()));
        let name = name.or_else(|| (0..titles.len()).find(|column| !axes.contains(column)));
        Ok((Self { name, axes, units, count: titles.len() }, true))
    }
}

/// Unit \[m\] in the title of an axis, `x`, `x (mm)` or `x_mm`: the outer `None` for another title, the inner one for
/// an unknown unit.
fn unit_of(title: &str, axis: &str) -> Option<Option<f64>> {
    let rest = title.strip_prefix(axis)?;
    if rest.starts_with(|sign: char| sign.is_alphanumeric()) {
        return None;
    }
    let unit = rest.trim_matches(|sign: char| " _()[]/".contains(sign));
    let known = UNITS.iter().find(|(name, _)| *name == unit).map(|pair| pair.1);
    Some(if unit.is_empty() { Some(1.0) } else { known })
}

fn of_xml(text: &str) -> Result<Vec<Microphone>, Mistakes> {
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        // Lines and columns count from 1.
        let line: usize =
            text.split_inclusive('\n').take(error.pos().row.saturating_sub(1) as usize).map(str::len).sum();
        let wrong = format!("this is not the XML of a microphone array: {error}");
        vec![(line..line, Problem::new(wrong, AS_ELEMENT))]
    })?;
    let (mut found, mut wrong) = (Vec::new(), Mistakes::new());
    for node in document.descendants() {
        let of = |name: &str| node.attributes().find(|attribute| attribute.name().eq_ignore_ascii_case(name));
        let axes = AXES.map(of);
        let start = node.range().start;
        let tag = start..text[start..].find(['>', '\n']).map_or(text.len(), |end| start + end);
        if axes.iter().all(Option::is_none) {
            continue;
        }
        if found.len() == MOST {
            wrong.push((tag, too_many()));
            break;
        }
        let [Some(x), Some(y), Some(z)] = axes else {
            let missing: Vec<&str> =
                AXES.into_iter().zip(&axes).filter(|(_, axis)| axis.is_none()).map(|pair| pair.0).collect();
            let problem = format!("this <{}> has no {}", node.tag_name().name(), missing.join(" and no "));
            wrong.push((tag, Problem::new(problem, AS_ELEMENT)));
            continue;
        };
        let mut position = [0.0; 3];
        for (coordinate, axis) in position.iter_mut().zip([x, y, z]) {
            match axis.value().trim().parse::<f64>().ok().filter(|number| number.is_finite()) {
                Some(number) => *coordinate = number,
                None => wrong.push((value_at(text, &axis), Problem::new(not_a_number(axis.value()), AS_ELEMENT))),
            }
        }
        found.push(Microphone {
            name: name_of(&node),
            position,
            name_at: of("name").map_or(tag.clone(), |name| value_at(text, &name)),
            whole: tag,
            position_at: [x, y, z].map(|axis| value_at(text, &axis)),
        });
    }
    if wrong.is_empty() { Ok(found) } else { Err(wrong) }
}

fn name_of(node: &Node<'_, '_>) -> String {
    let name = node.attributes().find(|attribute| attribute.name().eq_ignore_ascii_case("name"));
    name.map_or(String::new(), |name| name.value().trim().to_owned())
}

fn value_at(text: &str, attribute: &Attribute<'_, '_>) -> Range<usize> {
    let range = attribute.range_value();
    if text.get(range.clone()).is_some() { range } else { 0..0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<Microphone>, Mistakes> {
        microphones(&SourceText { name: "array".to_owned(), text: text.to_owned() })
    }

    #[test]
    fn the_same_two_microphones_are_read_from_every_kind_of_file() {
        for (text, named) in [
            (include_str!("../../tests/reference/arrays/two.xml"), true),
            ("<Array><Group><Mic X='0.5' Y='.4' Z='1e-1'/><Mic X='-0.5' Y='0.4' Z='0.1'/></Group></Array>", false),
            ("0.5,0.4,0.1\n-0.5,0.4,0.1\n", false),
            ("0.5 0.4 0.1\n-0.5 0.4 0.1\n", false),
            ("0,5;0,4;0,1\n-0,5;0,4;0,1\n", false),
            ("a;0,5;0,4;0,1\nb;-0,5;0,4;0,1\n", true),
            ("x\ty\tz\n0.5\t0.4\t0.1\n-0.5\t0.4\t0.1\n", false),
            ("\u{feff}z (mm); x (mm); y (mm); Name\r\n100; 500; 400; \"a\"\r\n100; -500; 400; b\r\n", true),
            ("# an array\nname,x,y,z\na,0.5,0.4,0.1\n\nb,-0.5,0.4,0.1\n", true),
        ] {
            let found = read(text).unwrap_or_else(|wrong| panic!("{text}: {wrong:?}"));
            let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15);
            assert!(found.len() == 2 && near(found[0].position, [0.5, 0.4, 0.1]), "{text}");
            assert!(near(found[1].position, [-0.5, 0.4, 0.1]), "{text}");
            assert_eq!([found[0].name.as_str(), &found[1].name], if named { ["a", "b"] } else { ["", ""] }, "{text}");
            assert!(!text[found[1].position_at[0].clone()].is_empty() && !text[found[1].whole.clone()].is_empty());
        }
    }

    #[test]
    fn hostile_xml_is_refused_at_once() {
        let entities = "<!DOCTYPE a [<!ENTITY b \"bbbbbbbb\"><!ENTITY c \"&b;&b;&b;\">]><a x='&c;' y='0' z='1'/>";
        let deep = "<a>".repeat(100_000);
        let wide = format!("<a>{}</a>", "<b/>".repeat(100_000));
        let long = format!("<a>{}</a>", "<b x='0' y='3' z='1'/>".repeat(MOST + 1));
        for (text, words) in [
            (entities, "not the XML of a microphone array"),
            ("<a x='&b;' y='0' z='1'/>", "not the XML of a microphone array"),
            (&deep, "not the XML of a microphone array"),
            (&wide, "not the XML of a microphone array"),
            (&long, "more than 1000 rows"),
            ("<a", "not the XML of a microphone array"),
            ("<a/>", "names no microphone"),
            ("<a><b x='0' y='1'/></a>", "this <b> has no z"),
            ("<a><b x='0' y='1' z='far'/></a>", "\"far\" is not a number"),
            ("<a><b x='0' y='1' z='inf'/></a>", "\"inf\" is not a number"),
        ] {
            let reported = read(text).err().unwrap()[0].1.to_string();
            assert!(reported.contains(words), "{words}: {reported}");
        }
    }
}
