//! `[outputs.vibration]`.

use super::super::kind::{Bounds, Count, Flag, Numbers, OneOf};
use super::super::table::{Nested, Table};
use super::super::{Frames, Problem, Scene, Tread, Vibration};

pub(super) const VIBRATION: Nested<Vibration> =
    Nested { title: "[outputs.vibration]", wanted: "the table [outputs.vibration]", read: vibration };

fn vibration(table: &mut Table<'_>) -> Option<Vibration> {
    let default = Vibration::default();
    let tread = table.or("tread", &Flag, default.tread);
    let belt = table.or("belt", &Flag, default.belt);
    let tangential = table.or("tangential", &Flag, default.tangential);
    let frames = table.or("frames", &OneOf::<Frames>::new(), default.frames);
    let points = table.optional("points", &Numbers(Bounds::any("m")));
    let elements = table.optional("elements", &Numbers(Count(0)));
    let map = table.or("map", &Flag, default.map);
    let segment = table.or("segment", &Bounds::positive("s"), default.segment);
    let read = Vibration {
        tread: tread?,
        belt: belt?,
        tangential: tangential?,
        frames: frames?,
        points: points?.unwrap_or_default(),
        elements: elements?.unwrap_or_default(),
        map: map?,
        segment: segment?,
    };
    if !(read.tread || read.belt || read.tangential) {
        let wrong = "neither tread, belt nor tangential velocity is wanted";
        let right = "tread = true, belt = true or tangential = true, or leave the table out";
        return table.complain_here(Problem::new(wrong, right));
    }
    if !read.points.is_empty() && !read.frames.non_rotating() {
        let right = "frames = \"both\" or \"non-rotating\", or leave the points out";
        return table.complain("points", Problem::does_not_belong("frames = \"material\"", right));
    }
    if !read.elements.is_empty() && !read.frames.material() {
        let right = "frames = \"both\" or \"material\", or leave the elements out";
        return table.complain("elements", Problem::does_not_belong("frames = \"non-rotating\"", right));
    }
    Some(read)
}

/// Complains about what the tyre or the tread law cannot give; `None` then.
pub(super) fn check(scene: &Scene, table: &Table<'_>) -> Option<()> {
    let Some(vibration) = &scene.outputs.vibration else { return Some(()) };
    let half = 0.5 * scene.tyre.circumference;
    let outside = vibration.points.iter().enumerate().filter(|(_, position)| position.abs() > half);
    let mut fits = true;
    for (index, position) in outside {
        let wrong = format!("{position} m is outside the tyre, which reaches {half} m to either side of the axle");
        let right = format!("write a position from -{half} to {half} m along the circumference");
        table.complain::<()>(&format!("outputs.vibration.points[{index}]"), Problem::new(wrong, right));
        fits = false;
    }
    if vibration.tangential && scene.contact.tread == Tread::Bedding {
        let wrong = "a bedding's springs have no tangential motion";
        let right = "tangential = false, or contact.tread = \"elastic\"";
        return table.complain("outputs.vibration.tangential", Problem::new(wrong, right));
    }
    fits.then_some(())
}
