//! Receivers of a plan, with their points and names.

use std::ops::Range;

use crate::scene::{Receiver, ReceiverPlace, Vehicle};
use crate::sound::receivers::{Beside, Standard, standard};

/// A `[[receiver]]` with its points.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedReceiver {
    /// Name in the scene, or that of its standard; unique.
    pub name: String,
    /// Name as part of file names; unique.
    pub file: String,
    /// Place in the scene.
    pub place: ReceiverPlace,
    /// Its points among those of all receivers.
    pub points: Range<usize>,
}

impl PlannedReceiver {
    /// Microphones of its standard.
    pub(crate) fn standard(&self) -> Box<dyn Standard> {
        standard(&self.place)
    }

    /// Length of the passage \[m\], if the tyre passes it.
    pub(crate) fn passage(&self) -> Option<f64> {
        self.standard().passage()
    }

    pub(crate) fn is_passed(&self) -> bool {
        self.passage().is_some()
    }

    /// Vehicle whose four tyres it receives, if more than one.
    pub(crate) fn vehicle(&self) -> Option<Vehicle> {
        self.standard().vehicle()
    }

    /// Number of tyres that it receives.
    pub(crate) fn tyres(&self) -> usize {
        self.vehicle().map_or(1, |_| Vehicle::TYRES)
    }

    /// Lines of points along which a microphone beside the road glides, as many points each: that of the tyre, or of a
    /// vehicle's left tyres and then of its right ones, which are farther away. None for a receiver that moves with the
    /// tyre.
    pub(crate) fn lines(&self) -> Vec<Range<usize>> {
        let sides = match (self.is_passed(), self.vehicle()) {
            (false, _) => 0,
            (true, None) => 1,
            (true, Some(_)) => 2,
        };
        let length = self.points.len() / sides.max(1);
        let first = |side: usize| self.points.start + side * length;
        (0..sides).map(|side| first(side)..first(side + 1)).collect()
    }
}

/// Receivers of a scene, and the positions of the points of all \[m\].
pub(super) fn planned_receivers(receivers: &[Receiver], beside: &Beside<'_>) -> (Vec<PlannedReceiver>, Vec<[f64; 3]>) {
    let mut positions = Vec::new();
    let mut names: Vec<String> = receivers.iter().map(|receiver| receiver.name.clone()).collect();
    let mut files: Vec<String> = Vec::new();
    let planned = receivers.iter().enumerate().map(|(index, receiver)| {
        let (first, microphones) = (positions.len(), standard(&receiver.place));
        positions.extend(microphones.points(beside));
        if receiver.name.is_empty() {
            let name = match receiver.place {
                ReceiverPlace::Position { .. } => format!("{}-{}", microphones.name(), index + 1),
                ReceiverPlace::Standard(_) => microphones.name().to_owned(),
            };
            names[index] = unlike(&name, index, &names);
        }
        let name = names[index].clone();
        let plain = name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '-' });
        let file = unlike(&plain.collect::<String>(), index, &files);
        files.push(file.clone());
        PlannedReceiver { name, file, place: receiver.place, points: first..positions.len() }
    });
    (planned.collect(), positions)
}

/// The name of receiver number `index`, with a number appended where another has the same, also on file systems that
/// ignore case.
fn unlike(name: &str, index: usize, others: &[String]) -> String {
    let taken = |name: &str| others.iter().any(|other| other.eq_ignore_ascii_case(name));
    let numbered = (index + 1..).map(|number| format!("{name}-{number}"));
    std::iter::once(name.to_owned()).chain(numbered).find(|name| !taken(name)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::StandardReceiver;

    fn coast_by(vehicle: Option<Vehicle>) -> StandardReceiver {
        let (distance, height) = (StandardReceiver::DISTANCE, StandardReceiver::HEIGHT);
        StandardReceiver::CoastBy { distance, height, vehicle, passage: None }
    }

    fn planned(receivers: &[Receiver]) -> (Vec<PlannedReceiver>, Vec<[f64; 3]>) {
        planned_receivers(receivers, &Beside { half_width: 0.1, patch_length: &|| 0.1 })
    }

    #[test]
    fn a_vehicle_has_a_line_for_either_side_beyond_both_axles() {
        let vehicle = Vehicle { wheelbase: 2.7, track: 1.5 };
        let place = |vehicle| Receiver { name: String::new(), place: ReceiverPlace::Standard(coast_by(vehicle)) };
        let receivers = [place(None), place(Some(vehicle)), place(Some(Vehicle { wheelbase: 2.0, ..vehicle }))];
        let (receivers, positions) = planned(&receivers);
        let [one, four, short] = [0, 1, 2].map(|receiver| &receivers[receiver]);
        // Three times 7.595 m, and 6 m for the detector before them: 116 steps of 0.25 m, and 92 behind.
        assert_eq!((one.points.clone(), one.lines().len(), one.tyres()), (0..209, 1, 1));
        assert_eq!((positions[0], positions[208]), ([29.0, 7.5, 1.2], [-23.0, 7.5, 1.2]));
        // Half of 2.7 m more at either end.
        assert_eq!((four.points.clone(), four.tyres()), (209..647, 4));
        assert_eq!(four.lines(), [209..428, 428..647]);
        assert_eq!((positions[209], positions[427]), ([30.25, 6.75, 1.2], [-24.25, 6.75, 1.2]));
        assert_eq!((positions[428], positions[646]), ([30.25, 8.25, 1.2], [-24.25, 8.25, 1.2]));
        assert_eq!(short.points.len(), 2 * 217);
        // Each tyre finds the microphone on its side's line, up to the ends of the passage of one tyre.
        for x in [22.7, -22.7] {
            for (tyre, [ahead, aside, _]) in vehicle.seen_from_tyres([x, 7.5, 1.2]).into_iter().enumerate() {
                let line = &positions[four.lines()[tyre % 2].clone()];
                let along = line[line.len() - 1][0]..=line[0][0];
                assert!(along.contains(&ahead) && (aside - line[0][1]).abs() < 1e-12, "tyre {tyre}: {ahead}");
            }
        }
        let files: Vec<&str> = receivers.iter().map(|receiver| receiver.file.as_str()).collect();
        assert_eq!(files, ["coast-by", "coast-by-2", "coast-by-3"]);
    }

    #[test]
    fn names_and_files_of_receivers_never_meet() {
        let receiver =
            |name: &&str| Receiver { name: (*name).to_owned(), place: ReceiverPlace::Standard(coast_by(None)) };
        let receivers: Vec<Receiver> =
            ["a b", "a-b-3", "a.b", "", "", "A/B", "coast-by-5"].iter().map(receiver).collect();
        let (receivers, _) = planned(&receivers);
        let of = |field: fn(&PlannedReceiver) -> &str| receivers.iter().map(field).collect::<Vec<_>>();
        let names = of(|receiver| &receiver.name);
        assert_eq!(names, ["a b", "a-b-3", "a.b", "coast-by", "coast-by-6", "A/B", "coast-by-5"]);
        let files = of(|receiver| &receiver.file);
        assert_eq!(files, ["a-b", "a-b-3", "a-b-4", "coast-by", "coast-by-6", "A-B-6", "coast-by-5"]);
    }
}
