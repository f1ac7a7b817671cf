//! `[[receiver]]` with a file of microphones: each row of the file is a receiver.
//!
//! The rows take the table's place before the scene is read. All that comes after, the recorded settings of a run and
//! their hash among it, has positions and no file; a file with other rows makes another scene. Complaints about a row
//! point into the file.

use std::ops::Range;
use std::sync::Arc;

use toml::de::{DeArray, DeTable, DeValue};
use toml::{Spanned, Value};

use super::diagnostic::Source;
use super::document::Document;
use super::{Diagnostic, Problem, SceneError};

/// Key of the array of tables, and of a file in one of them.
const RECEIVER: &str = "receiver";
const FILE: &str = "file";
/// First line of a file.
const HEADER: [&str; 4] = ["name", "x", "y", "z"];
/// Most rows of a file.
const MOST: usize = 1000;
const AS_HEADER: &str = "begin the file with the line name,x,y,z";
const AS_ROW: &str = "write name,x,y,z: a name without commas and quotes, and metres with a decimal point";

/// A row: where it, its name and its coordinates stand in the file.
struct Row {
    line: Range<usize>,
    name: Range<usize>,
    position: [Range<usize>; 3],
}

/// A file of microphones.
struct ReceiverFile {
    /// Number of the table that names it.
    item: usize,
    source: Arc<Source>,
    rows: Vec<Row>,
    /// The rows as tables `[[receiver]]`.
    tables: String,
}

/// All files of microphones that a scene names.
pub(super) struct ReceiverFiles(Vec<ReceiverFile>);

impl ReceiverFiles {
    /// Reads the files that the receivers of a scene name.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] with the mistakes in them, and in the tables that name them.
    pub(super) fn read(
        root: &DeTable<'_>,
        document: &Document,
        open: impl Fn(&str) -> Result<Arc<Source>, Problem>,
    ) -> Result<Self, SceneError> {
        let (mut files, mut wrong) = (Vec::new(), Vec::new());
        let items = root.get(RECEIVER).and_then(|receivers| receivers.get_ref().as_array());
        for (item, receiver) in items.into_iter().flatten().enumerate() {
            let Some(table) = receiver.get_ref().as_table() else { continue };
            let Some(path) = table.get(FILE).and_then(|file| file.get_ref().as_str()) else { continue };
            let key = |key: &str| format!("{RECEIVER}[{item}].{key}");
            for other in table.keys().map(|key| key.get_ref().as_ref()).filter(|other| *other != FILE) {
                wrong.push(document.diagnose(&key(other), Problem::does_not_belong(FILE, "leave this out")));
            }
            match open(path) {
                Err(problem) => wrong.push(document.diagnose(&key(FILE), problem)),
                Ok(source) => match rows(&source) {
                    Ok((rows, tables)) => files.push(ReceiverFile { item, source, rows, tables }),
                    Err(mistakes) => wrong.extend(mistakes.into_iter().map(|(span, problem)| {
                        let source = Arc::clone(&source);
                        Diagnostic { source, key: key(FILE), span, problem }
                    })),
                },
            }
        }
        if wrong.is_empty() { Ok(Self(files)) } else { Err(SceneError::invalid(wrong, 0)) }
    }

    /// Puts a table for each row in place of the tables that name the files, in the scene's tree and in its document.
    pub(super) fn put_into<'a>(&'a self, root: &mut DeTable<'a>, document: &mut Document) {
        let Some(DeValue::Array(receivers)) = root.get_mut(RECEIVER).map(Spanned::get_mut) else { return };
        if self.0.is_empty() {
            return;
        }
        let file_of = |item: usize| self.0.iter().find(|file| file.item == item);
        let (mut all, mut numbers) = (DeArray::new(), Vec::new());
        let mut placed = Vec::new();
        for (item, receiver) in std::mem::replace(receivers, DeArray::new()).into_iter().enumerate() {
            numbers.push(all.len());
            let Some(file) = file_of(item) else {
                all.push(receiver);
                continue;
            };
            let (tables, _) = DeTable::parse_recoverable(&file.tables);
            let tables = tables.into_inner().remove(RECEIVER).map(Spanned::into_inner);
            let Some(DeValue::Array(tables)) = tables else { continue };
            placed.push((all.len(), file));
            tables.into_iter().for_each(|table| all.push(table));
        }
        *receivers = all;
        document.renumber(RECEIVER, |item| file_of(item).is_none().then(|| numbers.get(item).copied())?);
        for (first, file) in placed {
            for (row, number) in file.rows.iter().zip(first..) {
                let key = format!("{RECEIVER}[{number}]");
                let [x, _, z] = &row.position;
                let mut add = |key: String, span: &Range<usize>| document.add(&file.source, key, span.clone());
                add(format!("{key}.name"), &row.name);
                add(format!("{key}.position"), &(x.start..z.end));
                for (part, span) in row.position.iter().enumerate() {
                    add(format!("{key}.position[{part}]"), span);
                }
                add(key, &row.line);
            }
        }
    }
}

/// Mistakes in a file: where, and what.
type Mistakes = Vec<(Range<usize>, Problem)>;

/// Takes a file of microphones apart, and writes its rows as tables of a scene.
fn rows(source: &Source) -> Result<(Vec<Row>, String), Mistakes> {
    let (mut rows, mut tables, mut wrong) = (Vec::new(), String::new(), Mistakes::new());
    let mut begin = 0;
    let mut header = false;
    for line in source.text.split_inclusive('\n') {
        let whole = within(&source.text, begin..begin + line.len());
        begin += line.len();
        if whole.is_empty() || source.text[whole.clone()].starts_with('#') {
            continue;
        }
        let fields = fields(&source.text, &whole);
        let text = |field: &Range<usize>| &source.text[field.clone()];
        if !header {
            if !fields.iter().map(text).eq(HEADER) {
                return Err(vec![(whole, Problem::new("this is not the line that names the columns", AS_HEADER))]);
            }
            header = true;
            continue;
        }
        if rows.len() == MOST {
            let problem = Problem::new(format!("the file has more than {MOST} rows"), "make several runs of it");
            wrong.push((whole, problem));
            break;
        }
        let Ok([name, position @ ..]) = <[Range<usize>; 4]>::try_from(fields) else {
            wrong.push((whole, Problem::new("this row has no four values", AS_ROW)));
            continue;
        };
        if text(&name).contains(['"', '\'']) {
            wrong.push((name.clone(), Problem::new("a name with quotes", AS_ROW)));
        }
        let mut coordinates = [0.0; 3];
        for (coordinate, field) in coordinates.iter_mut().zip(&position) {
            match text(field).parse() {
                Ok(number) => *coordinate = number,
                Err(_) => wrong.push((field.clone(), Problem::new(not_a_number(text(field)), AS_ROW))),
            }
        }
        let named = Value::from(text(&name));
        let position_there: Value = coordinates.map(Value::from).to_vec().into();
        tables.push_str(&format!("[[{RECEIVER}]]\nname = {named}\nposition = {position_there}\n"));
        rows.push(Row { line: whole, name, position });
    }
    if rows.is_empty() && wrong.is_empty() {
        let problem = if header { "the file names no microphone" } else { "the file is empty" };
        wrong.push((0..0, Problem::new(problem, AS_ROW)));
    }
    if wrong.is_empty() { Ok((rows, tables)) } else { Err(wrong) }
}

fn not_a_number(text: &str) -> String {
    if text.is_empty() { "a number is missing".to_owned() } else { format!("\"{text}\" is not a number") }
}

/// Returns a range of a text without the blanks at its ends, and without a mark of the byte order.
fn within(text: &str, range: Range<usize>) -> Range<usize> {
    let part = &text[range.clone()];
    let blank = |sign: char| sign.is_whitespace() || sign == '\u{feff}';
    let trimmed = part.trim_start_matches(blank);
    let start = range.end - trimmed.len();
    start..start + trimmed.trim_end_matches(blank).len()
}

/// Returns the fields of a line, between its commas.
fn fields(text: &str, line: &Range<usize>) -> Vec<Range<usize>> {
    let mut begin = line.start;
    let field = |field: &str| {
        let range = begin..begin + field.len();
        begin = range.end + 1;
        within(text, range)
    };
    text[line.clone()].split(',').map(field).collect()
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::super::tests::{BASE, Complaint, listed};
    use super::super::{LoadedScene, Reach, ReceiverPlace, Scene, Setting};
    use super::*;

    /// Returns a scene with receivers, and a file beside it.
    fn written(folder: &Path, receivers: &str, array: &str) -> Result<LoadedScene, SceneError> {
        fs::write(folder.join("array.csv"), array).unwrap();
        let path = folder.join("scene.toml");
        fs::write(&path, format!("{BASE}{receivers}")).unwrap();
        Scene::load(path)
    }

    /// Returns a scene with the file between two other receivers.
    fn load(array: &str) -> Result<LoadedScene, SceneError> {
        let folder = tempfile::tempdir().unwrap();
        let others = "[[receiver]]\nstandard = \"cpx\"\n[[receiver]]\nfile = \"array.csv\"\n[[receiver]]\n\
                      name = \"last\"\nposition = [0, 3, 1]\n";
        written(folder.path(), others, array)
    }

    fn complaints(array: &str) -> Vec<Complaint> {
        listed(&load(array).unwrap_err())
    }

    const ARRAY: &str = "\u{feff}name, x, y, z\r\n# front\r\nleft, .5, 7.5, 1.2\n\nright,-1e0,-7.5,+1.2\n";

    #[test]
    fn every_row_is_a_receiver_in_its_place() {
        let scene = load(ARRAY).unwrap().scene;
        let names: Vec<&str> = scene.receivers.iter().map(|receiver| receiver.name.as_str()).collect();
        assert_eq!(names, ["", "left", "right", "last"]);
        let place = |position| ReceiverPlace::Position { position };
        assert_eq!(scene.receivers[1].place, place([0.5, 7.5, 1.2]));
        assert_eq!(scene.receivers[2].place, place([-1.0, -7.5, 1.2]));
        assert_eq!(load("name,x,y,z\n,0,3,1").unwrap().scene.receivers[1].name, "", "named by its number later");
    }

    #[test]
    fn a_scene_is_that_of_the_files_contents_and_its_record_has_no_file() {
        let [one, same, other] =
            [ARRAY, "name,x,y,z\nleft,0.5,7.5,1.2\nright,-1,-7.5,1.2", "name,x,y,z\nleft,0.5,7.6,1.2"]
                .map(|array| load(array).unwrap());
        assert_eq!(one.hash().unwrap(), same.hash().unwrap());
        assert_ne!(one.hash().unwrap(), other.hash().unwrap());
        let record = one.written_toml().unwrap();
        assert!(!record.contains("array.csv"), "{record}");
        assert_eq!(LoadedScene::recorded(&record, "record").unwrap().scene, one.scene);
        // What a task takes along needs no file.
        let given = one.given().unwrap().to_string();
        assert_eq!(Scene::from_str(&given, "task").unwrap().scene, one.scene);
        let named = format!("{BASE}[[receiver]]\nfile = \"array.csv\"\n");
        let error = listed(&LoadedScene::recorded(&named, "record").unwrap_err());
        assert!(error[0].wrong.contains("not read") && error[0].key == "receiver[0].file", "{error:?}");
    }

    #[test]
    fn a_setting_may_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        written(folder.path(), "", ARRAY).unwrap();
        let setting = Setting::parse("receiver=[{ file = \"array.csv\" }]").unwrap();
        let loaded = Scene::load_with(folder.path().join("scene.toml"), &[setting], Reach::Folder).unwrap();
        assert_eq!(loaded.scene.receivers.len(), 2);
    }

    #[test]
    fn mistakes_are_told_with_their_place_in_the_file() {
        let many = format!("name,x,y,z\n{}", "a,0,3,1\n".repeat(MOST + 1));
        for (array, place, key, wrong, right) in [
            ("", (1, 1), "receiver[1].file", "the file is empty", "name,x,y,z"),
            ("name,x,y,z\n", (1, 1), "receiver[1].file", "names no microphone", "name,x,y,z"),
            ("left,0,7.5,1.2\n", (1, 1), "receiver[1].file", "names the columns", "begin the file with the line"),
            ("name,x,y\n", (1, 1), "receiver[1].file", "names the columns", "begin the file with the line"),
            ("name,x,y,z\na,0,3\n", (2, 1), "receiver[1].file", "no four values", "metres"),
            ("name,x,y,z\na,0,3,1\nb,0,3,1,5\n", (3, 1), "receiver[1].file", "no four values", "metres"),
            ("name,x,y,z\na,0,far,1\n", (2, 5), "receiver[1].file", "\"far\" is not a number", "decimal point"),
            ("name,x,y,z\na,0,,1\n", (2, 5), "receiver[1].file", "a number is missing", "decimal point"),
            ("name,x,y,z\n\"a\",0,3,1\n", (2, 1), "receiver[1].file", "a name with quotes", "without commas"),
            (&many, (MOST + 2, 1), "receiver[1].file", "more than 1000 rows", "several runs"),
            ("name,x,y,z\na,0,3,1\nb,0,NaN,1\n", (3, 5), "receiver[2].position[1]", "NaN", "at least -10000"),
            ("name,x,y,z\na,0,3,1\nb,0,3,-inf\n", (3, 7), "receiver[2].position[2]", "inf", "at least -10000"),
            ("name,x,y,z\na,0,7500,1\n", (2, 5), "receiver[1].position[1]", "hardly meant", "another unit"),
            ("name,x,y,z\na,0,3,1\nb,0,3,-0.1\n", (3, 3), "receiver[2].position", "below the road", "0 or more"),
            ("name,x,y,z\na,0.1,0,0.3\n", (2, 3), "receiver[1].position", "inside the tyre", "reaches 0.12 m"),
            ("name,x,y,z\na,0,3,1\na,0,4,1\n", (3, 1), "receiver[2].name", "the name of receiver[1], too", "no other"),
            ("name,x,y,z\n=a,0,3,1\n", (2, 1), "receiver[1].name", "for a formula", "does not begin with ="),
        ] {
            let found = complaints(array);
            let [first] = &found[..] else { panic!("one complaint: {found:?}") };
            assert_eq!(((first.line, first.column), first.key.as_str()), (place, key), "{first:?}");
            assert!(first.wrong.contains(wrong) && first.right.contains(right), "{first:?}");
            let told = load(array).unwrap_err().to_string();
            assert!(told.contains("array.csv:"), "{told}");
        }
        // Receivers behind the rows have other numbers, and their places in the scene still.
        let error = load("name,x,y,z\nlast,0,3,1\n").unwrap_err().to_string();
        assert!(
            error.contains("scene.toml:33:8: receiver[2].name: \"last\" is the name of receiver[1], too"),
            "{error}"
        );
        let found = complaints("name,x,y,z\na,0,3,b\nc,0\n");
        assert_eq!(found.iter().map(|found| found.line).collect::<Vec<_>>(), [2, 3], "all are told at once");
    }

    #[test]
    fn a_file_is_alone_in_its_table_and_in_the_scenes_folder() {
        let folder = tempfile::tempdir().unwrap();
        for (keys, key, wrong) in [
            ("file = \"array.csv\"\nname = \"a\"", ".name", "means nothing with file"),
            ("standard = \"cpx\"\nfile = \"array.csv\"", ".standard", "means nothing with file"),
            ("file = \"nowhere.csv\"", ".file", "there is no file"),
            ("file = \"/dev/null\"", ".file", "outside the scene's folder"),
            ("file = 3", ".file", "3 cannot stand here"),
        ] {
            let error = written(folder.path(), &format!("[[receiver]]\n{keys}\n"), ARRAY).unwrap_err();
            let first = &listed(&error)[0];
            assert!(first.key == format!("receiver[0]{key}") && first.wrong.contains(wrong), "{keys}: {first:?}");
        }
    }
}
