//! `[rolling]`.

use super::super::Rolling;
use super::super::kind::Bounds;
use super::super::table::{Nested, Table};
use super::axle::AXLE;

pub(super) const ROLLING: Nested<Rolling> =
    Nested { title: "[rolling]", wanted: "the table [rolling] with speed_kmh, duration and axle", read: rolling };

fn rolling(table: &mut Table<'_>) -> Option<Rolling> {
    let speed_kmh = table.required("speed_kmh", &Bounds::positive("km/h"));
    let duration = table.required("duration", &Bounds::positive("s"));
    let warm_up = table.or("warm_up", &Bounds::not_negative("s"), Rolling::WARM_UP);
    let start = table.optional("start", &Bounds::any("m"));
    let axle = table.required("axle", &AXLE);
    Some(Rolling { speed_kmh: speed_kmh?, duration: duration?, warm_up: warm_up?, start: start?, axle: axle? })
}
