//! `[[receiver]]` with a file of microphones: each of them is a receiver.
//!
//! They replace the table before the scene is read, turned and shifted as the table says. All later stages, the
//! recorded settings of a run and their hash among them, see positions and no file; a file with other rows makes
//! another scene. Complaints about a microphone point into the file.

use std::ops::Range;
use std::sync::Arc;

use toml::de::{DeArray, DeTable, DeValue};
use toml::{Spanned, Value};

use super::document::{Complaints, Document};
use super::microphone_array::{Microphone, microphones};
use super::model::array_placement;
use super::problem::SourceText;
use super::table::Table;
use super::{Diagnostic, Problem, SceneError};

/// Key of the receivers' array, of a file in one of them, and of the keys that place its microphones.
const RECEIVER: &str = "receiver";
const FILE: &str = "file";
const PLACING: [&str; 2] = ["offset", "rotation_deg"];

struct ReceiverFile {
    /// Index of the table that names it.
    item: usize,
    source: Arc<SourceText>,
    microphones: Vec<Microphone>,
    /// The microphones as tables `[[receiver]]`.
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
        open: impl Fn(&str) -> Result<Arc<SourceText>, Problem>,
    ) -> Result<Self, SceneError> {
        let (mut files, mut wrong) = (Vec::new(), Vec::new());
        let items = root.get(RECEIVER).and_then(|receivers| receivers.get_ref().as_array());
        for (item, receiver) in items.into_iter().flatten().enumerate() {
            let Some(table) = receiver.get_ref().as_table() else { continue };
            let Some(path) = table.get(FILE).and_then(|file| file.get_ref().as_str()) else { continue };
            let key = |key: &str| format!("{RECEIVER}[{item}].{key}");
            let belongs = |key: &&str| *key == FILE || PLACING.contains(key);
            for other in table.keys().map(|key| key.get_ref().as_ref()).filter(|key| !belongs(key)) {
                wrong.push(document.diagnose(&key(other), Problem::does_not_belong(FILE, "leave this out")));
            }
            let complaints = Complaints::new(document, 1.0);
            let placement =
                array_placement(&mut Table::new(&complaints, format!("{RECEIVER}[{item}]"), "a file", table));
            wrong.extend(complaints.finish().0);
            match open(path) {
                Err(problem) => wrong.push(document.diagnose(&key(FILE), problem)),
                Ok(source) => match microphones(&source) {
                    Ok(microphones) => {
                        let [offset, rotation] = placement.unwrap_or_default();
                        let tables = microphones.iter().map(|microphone| {
                            let position = placed(microphone.position, rotation, offset);
                            let position: Value = position.map(Value::from).to_vec().into();
                            let name = Value::from(microphone.name.as_str());
                            format!("[[{RECEIVER}]]\nname = {name}\nposition = {position}\n")
                        });
                        files.push(ReceiverFile { item, source, tables: tables.collect(), microphones });
                    }
                    Err(mistakes) => wrong.extend(mistakes.into_iter().map(|(span, problem)| {
                        let source = Arc::clone(&source);
                        Diagnostic { source, key: key(FILE), span, problem }
                    })),
                },
            }
        }
        if wrong.is_empty() { Ok(Self(files)) } else { Err(SceneError::invalid(wrong, 0)) }
    }

    /// Replaces the tables that name files by one table for each microphone, in the scene's tree and in its document.
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
            for (microphone, number) in file.microphones.iter().zip(first..) {
                let key = format!("{RECEIVER}[{number}]");
                let [x, y, z] = &microphone.position_at;
                let all: Range<usize> = x.start.min(y.start).min(z.start)..x.end.max(y.end).max(z.end);
                let mut add = |key: String, span: &Range<usize>| document.add(&file.source, key, span.clone());
                add(format!("{key}.name"), &microphone.name_at);
                add(format!("{key}.position"), &all);
                for (part, span) in microphone.position_at.iter().enumerate() {
                    add(format!("{key}.position[{part}]"), span);
                }
                add(key, &microphone.whole);
            }
        }
    }
}

/// Rotates a position by angles \[degrees\] about the x, y and z axes of the scene, in this order, then shifts it
/// \[m\].
fn placed(position: [f64; 3], rotation: [f64; 3], offset: [f64; 3]) -> [f64; 3] {
    let mut at = position;
    for (axis, degrees) in rotation.into_iter().enumerate() {
        // Quarter turns keep coordinates exact.
        let (sine, cosine) = match degrees.rem_euclid(360.0) {
            0.0 => continue,
            90.0 => (1.0, 0.0),
            180.0 => (0.0, -1.0),
            270.0 => (-1.0, 0.0),
            other => other.to_radians().sin_cos(),
        };
        let [next, last] = [(axis + 1) % 3, (axis + 2) % 3];
        (at[next], at[last]) = (cosine * at[next] - sine * at[last], sine * at[next] + cosine * at[last]);
    }
    std::array::from_fn(|axis| at[axis] + offset[axis])
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::super::microphone_array::MOST;
    use super::super::tests::{BASE, Complaint, listed};
    use super::super::{LoadedScene, Reach, ReceiverPlace, Scene, Setting};
    use super::*;

    /// The base scene with receivers, and a file of microphones beside it.
    fn written(folder: &Path, receivers: &str, array: &str) -> Result<LoadedScene, SceneError> {
        fs::write(folder.join("array.csv"), array).unwrap();
        let path = folder.join("scene.toml");
        fs::write(&path, format!("{BASE}{receivers}")).unwrap();
        Scene::load(path)
    }

    /// The base scene with the file between two other receivers.
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
    fn a_scene_holds_the_contents_of_its_files_and_no_paths() {
        let [one, same, other] =
            [ARRAY, "name,x,y,z\nleft,0.5,7.5,1.2\nright,-1,-7.5,1.2", "name,x,y,z\nleft,0.5,7.6,1.2"]
                .map(|array| load(array).unwrap());
        assert_eq!(one.hash().unwrap(), same.hash().unwrap());
        assert_ne!(one.hash().unwrap(), other.hash().unwrap());
        let record = one.written_toml().unwrap();
        assert!(!record.contains("array.csv"), "{record}");
        assert_eq!(LoadedScene::recorded(&record, "record").unwrap().scene, one.scene);
        // A task is sent without the file.
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
    fn mistakes_are_reported_with_their_place_in_the_file() {
        let many = format!("name,x,y,z\n{}", "a,0,3,1\n".repeat(MOST + 1));
        for (array, place, key, wrong, right) in [
            ("", (1, 1), "receiver[1].file", "the file is empty", "name,x,y,z"),
            ("name,x,y,z\n", (1, 1), "receiver[1].file", "names no microphone", "name,x,y,z"),
            ("1,0,7.5,1.2\n", (1, 1), "receiver[1].file", "four numbers", "begin the file with the line"),
            ("name,x (km),y,z\na,0,3,1\n", (1, 1), "receiver[1].file", "unit of \"x (km)\"", "one of m, mm"),
            (
                "<a><pos x='0' y='3' z='1'/>\n<pos x='0' y='3' z='-1'/></a>",
                (2, 9),
                "receiver[2].position",
                "below",
                "0",
            ),
            ("name,x,y\n", (1, 1), "receiver[1].file", "names the columns", "begin the file with the line"),
            ("name,x,y,z\na,0,3\n", (2, 1), "receiver[1].file", "3 values, and 4 are", "metres"),
            ("name,x,y,z\na,0,3,1\nb,0,3,1,5\n", (3, 1), "receiver[1].file", "5 values, and 4 are", "metres"),
            ("name,x,y,z\na,0,far,1\n", (2, 5), "receiver[1].file", "\"far\" is not a number", "metres"),
            ("name,x,y,z\na,0,,1\n", (2, 5), "receiver[1].file", "a number is missing", "metres"),
            (&many, (MOST + 2, 1), "receiver[1].file", "more than 1000 rows", "several runs"),
            ("name,x,y,z\na,0,3,1\nb,0,NaN,1\n", (3, 5), "receiver[1].file", "\"NaN\" is not a number", "metres"),
            ("name,x,y,z\na,0,3,1\nb,0,3,-1e5\n", (3, 7), "receiver[2].position[2]", "-1", "at least -10000"),
            ("name,x,y,z\na,0,7500,1\n", (2, 5), "receiver[1].position[1]", "implausible", "another unit"),
            ("name,x,y,z\na,0,3,1\nb,0,3,-0.1\n", (3, 3), "receiver[2].position", "below the road", "0 or more"),
            ("name,x,y,z\na,0.1,0,0.3\n", (2, 3), "receiver[1].position", "inside the tyre", "reaches 0.12 m"),
            ("name,x,y,z\na,0,3,1\na,0,4,1\n", (3, 1), "receiver[2].name", "the name of receiver[1], too", "no other"),
            ("name,x,y,z\n=a,0,3,1\n", (2, 1), "receiver[1].name", "for a formula", "does not begin with ="),
        ] {
            let found = complaints(array);
            let [first] = &found[..] else { panic!("one complaint: {found:?}") };
            assert_eq!(((first.line, first.column), first.key.as_str()), (place, key), "{first:?}");
            assert!(first.wrong.contains(wrong) && first.right.contains(right), "{first:?}");
            let reported = load(array).unwrap_err().to_string();
            assert!(reported.contains("array.csv:"), "{reported}");
        }
        // Receivers behind the rows have other numbers, and their places in the scene still.
        let error = load("name,x,y,z\nlast,0,3,1\n").unwrap_err().to_string();
        assert!(
            error.contains("scene.toml:33:8: receiver[2].name: \"last\" is the name of receiver[1], too"),
            "{error}"
        );
        let found = complaints("name,x,y,z\na,0,3,b\nc,0\n");
        assert_eq!(found.iter().map(|found| found.line).collect::<Vec<_>>(), [2, 3], "all are reported at once");
    }

    #[test]
    fn an_array_is_turned_about_the_scenes_axes_then_shifted() {
        let folder = tempfile::tempdir().unwrap();
        let place = |keys: &str| {
            let receivers = format!("[[receiver]]\nfile = \"array.csv\"\n{keys}\n");
            let scene =
                written(folder.path(), &receivers, "a,1,2,0.5\n").unwrap_or_else(|error| panic!("{error}")).scene;
            let ReceiverPlace::Position { position } = scene.receivers[0].place else { panic!() };
            position
        };
        // An array that stands upright beside the road: its y becomes the height. One angle is about the vertical;
        // turns about x come before those about z. Quarter turns are exact.
        for (keys, expected) in [
            ("", [1.0, 2.0, 0.5]),
            ("offset = [0.5, -4, 1]", [1.5, -2.0, 1.5]),
            ("rotation_deg = [90, 0, 0]", [1.0, -0.5, 2.0]),
            ("rotation_deg = [0, 90, 0]\noffset = [0, 0, 1]", [0.5, 2.0, 0.0]),
            ("rotation_deg = 90", [-2.0, 1.0, 0.5]),
            ("rotation_deg = [90, 0, -90]\noffset = [0, 1, 0]", [-0.5, 0.0, 2.0]),
        ] {
            let found = place(keys);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < f64::MIN_POSITIVE), "{keys}: {found:?}");
        }
        let turned = place("rotation_deg = 30");
        let expected = [3.0_f64.sqrt() / 2.0 - 1.0, 0.5 + 3.0_f64.sqrt(), 0.5];
        assert!(turned.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{turned:?}");
        for (keys, key, wrong) in [
            ("file = \"array.csv\"\noffset = [0, 1]", ".offset", "2 values"),
            ("file = \"array.csv\"\noffset = 3", ".offset", "3 is not allowed here"),
            ("file = \"array.csv\"\nrotation_deg = 1000", ".rotation_deg", "1000"),
            ("file = \"array.csv\"\nrotation_deg = [0, 0, nan]", ".rotation_deg[2]", "NaN"),
            ("position = [0, 3, 1]\noffset = [0, 0, 1]", ".offset", "does not apply with position"),
            ("standard = \"cpx\"\nrotation_deg = 9", ".rotation_deg", "does not apply with standard"),
        ] {
            let error = written(folder.path(), &format!("[[receiver]]\n{keys}\n"), ARRAY).unwrap_err();
            let first = &listed(&error)[0];
            assert!(first.key == format!("receiver[0]{key}") && first.wrong.contains(wrong), "{keys}: {first:?}");
        }
    }

    #[test]
    fn a_file_is_alone_in_its_table_and_in_the_scenes_folder() {
        let folder = tempfile::tempdir().unwrap();
        for (keys, key, wrong) in [
            ("file = \"array.csv\"\nname = \"a\"", ".name", "does not apply with file"),
            ("standard = \"cpx\"\nfile = \"array.csv\"", ".standard", "does not apply with file"),
            ("file = \"nowhere.csv\"", ".file", "there is no file"),
            ("file = \"/dev/null\"", ".file", "outside the scene's folder"),
            ("file = 3", ".file", "3 is not allowed here"),
        ] {
            let error = written(folder.path(), &format!("[[receiver]]\n{keys}\n"), ARRAY).unwrap_err();
            let first = &listed(&error)[0];
            assert!(first.key == format!("receiver[0]{key}") && first.wrong.contains(wrong), "{keys}: {first:?}");
        }
    }
}
