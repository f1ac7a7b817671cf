//! Table and picture of the force and the sound by order of the revolution.

use crate::effects::ReceiverOrders;
use crate::response::Order;
use crate::results::plots::{Axis, LinePlot, Series};
use crate::results::table::csv;

/// Range of levels that is drawn, below the highest \[dB\].
const DEPTH: f64 = 80.0;

/// Table with a row for each order: the force, and the pressures at some receivers.
pub(super) fn to_csv(orders: &[Order], receivers: &[ReceiverOrders]) -> String {
    let pressures = receivers.iter().map(|of| format!("pressure_pa_{}", of.receiver));
    let header = ["order", "frequency_hz", "force_n", "repeated_force_n"].map(str::to_owned);
    let header: Vec<String> = header.into_iter().chain(pressures).collect();
    let line = |of: &Order| {
        let pressures = receivers.iter().map(|receiver| receiver.pressures.get(of.order).copied().unwrap_or_default());
        [of.order as f64, of.frequency, of.all, of.repeated].into_iter().chain(pressures).collect::<Vec<f64>>()
    };
    csv(header.iter().map(String::as_str), orders.iter().map(line))
}

/// Picture of the forces over the order.
pub(super) fn picture(orders: &[Order], title: &str) -> String {
    // Orders above a kilohertz or two are in the table alone.
    let shown = &orders[1..orders.len().min(1 + orders.len() / 2)];
    let level = |force: f64| 20.0 * force.max(f64::MIN_POSITIVE).log10();
    let highest = shown.iter().map(|of| level(of.all)).fold(-DEPTH, f64::max);
    let lowest = highest - DEPTH;
    let series = |name, value: fn(&Order) -> f64| Series {
        name,
        points: shown.iter().map(|of| (of.order as f64, level(value(of)).max(lowest))).collect(),
    };
    LinePlot {
        title,
        x: Axis::linear("Order of the revolution", 0.0..shown.len() as f64),
        y: Axis::linear("Contact force [dB re 1 N]", lowest..highest + 5.0),
        series: vec![series("all", |of| of.all), series("repeated", |of| of.repeated)],
    }
    .to_svg()
}
