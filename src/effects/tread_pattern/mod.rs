//! Pattern of the tread: its map, its pitches' spectrum, and the contact force by order of the revolution.

use super::effect::{Effect, RunStart};
use super::error::RunError;
use super::observer::{EffectObserver, End, Found, Observer, ReceiverOrders, Step};
use super::section::{PageSection, ReportError, pictures};
use super::stored::Stored;
use crate::counters::{Job, Meter};
use crate::plan::decisions::{taken_pattern, takes_depths, tread_map};
use crate::plan::{Amounts, Decisions, Plan};
use crate::response::{Order, Orders};
use crate::results::files::ResultFiles;
use crate::results::plots::{Axis, LinePlot, Series};
use crate::results::table::csv;
use crate::results::tread_pattern::{pattern_csv, pitch_spectrum, tread_picture};
use crate::scene::{BlockModel, LoadedScene, Scene, SceneError, Switch, Zone};
use crate::storage::state::{Evolving, StateError, StateStream};

/// Range of levels that is drawn, below the highest \[dB\].
const DEPTH: f64 = 80.0;

pub(crate) struct TreadPatternEffect;

impl Effect for TreadPatternEffect {
    fn name(&self) -> &'static str {
        "tread_pattern"
    }

    fn check(&self, loaded: &LoadedScene, scene: &Scene) -> Result<(), SceneError> {
        let refuse = |key: &str, wrong: &str, right: &str| Err(SceneError::from(loaded.complain(key, wrong, right)));
        let Some(pattern) = scene.pattern() else { return Ok(()) };
        if !takes_depths(scene) {
            if scene.effects.tread_pattern == Switch::On {
                let wrong = "slices take depths of the tread by independent springs alone";
                let right = "contact.zone = \"cells\", or contact.slices = \"winkler\" with effects.texture = \"auto\"";
                return refuse("effects.tread_pattern", wrong, right);
            }
            return Ok(());
        }
        let is_pressed = scene.contact.zone == Zone::Cells && pattern.blocks == BlockModel::Compliant;
        if scene.has_tractions() && is_pressed {
            let wrong = "with friction, blocks can only be as stiff as the uncut tread";
            return refuse("tread_pattern.blocks", wrong, "blocks = \"continuum\", or remove [friction]");
        }
        match tread_map(scene, &Decisions::new(scene)) {
            Some(Err(fault)) => refuse(&format!("tread_pattern.{}", fault.key), &fault.wrong, &fault.right),
            _ => Ok(()),
        }
    }

    fn add_amounts(&self, plan: &Plan, amounts: &mut Amounts) {
        if taken_pattern(&plan.scene).is_some() {
            // Depths, crowns with depths, blocks and cuts of every cell.
            let cells = plan.scene.numerics.elements * plan.decisions.cells_across.unwrap_or(1);
            amounts.hold("depths of the tread", 40.0 * cells as f64);
        }
    }

    fn sections(&self, stored: &Stored, _: &[Stored]) -> Result<Vec<PageSection>, ReportError> {
        let named = [
            ["tread_pattern.svg", "Depth of the tread's cells round the tyre."],
            ["pitch_spectrum.svg", "Amplitudes of one unit pulse to each pitch by order of the revolution."],
            [
                "orders.svg",
                "Contact force by order of the revolution: of all of it, and of what comes again each time.",
            ],
        ];
        Ok(vec![PageSection { heading: "Tread pattern", blocks: pictures(stored, &named)? }])
    }

    fn begin(&self, begin: &mut RunStart<'_>, job: &mut Job<'_>) -> Result<Option<Box<dyn EffectObserver>>, RunError> {
        let RunStart { plan, .. } = *begin;
        if taken_pattern(&plan.scene).is_none() {
            return Ok(None);
        }
        let steps = plan.steps_per_revolution();
        let revolution = plan.time_step * steps as f64;
        if plan.steps - plan.warm_up_steps < steps as u64 {
            let warning = format!("the run is shorter than a revolution, {revolution:.3} s: there are no orders");
            job.warnings.push(warning);
        }
        Ok(Some(Box::new(PatternObserver { orders: Orders::new(steps) })))
    }
}

pub(crate) struct PatternObserver {
    orders: Orders,
}

impl Observer for PatternObserver {
    fn observe(&mut self, step: &Step<'_>, _: &mut Meter) -> Result<(), RunError> {
        if step.counts {
            self.orders.push(step.total_force);
        }
        Ok(())
    }
}

impl EffectObserver for PatternObserver {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        self.orders.state(state)
    }

    fn write(&self, end: &End<'_>, files: &dyn ResultFiles, found: &mut Found, _: &mut Meter) -> Result<(), RunError> {
        let Plan { scene, speed, .. } = end.plan;
        let Some(map) = end.plan.tread_map() else { return Ok(()) };
        files.write_text("pattern.csv", &pattern_csv(&map, *speed))?;
        let by_order = self.orders.found(speed / scene.tyre.circumference);
        if let Some(by_order) = &by_order {
            files.write_text("orders.csv", &orders_csv(by_order, &found.pressures_by_order))?;
        }
        if !scene.outputs.plots {
            return Ok(());
        }
        let title = end.loaded.title();
        files.write_text("tread_pattern.svg", &tread_picture(&map, &title)?)?;
        if let Some(train) = &map.train {
            files.write_text("pitch_spectrum.svg", &pitch_spectrum(train, *speed, &title))?;
        }
        if let Some(by_order) = &by_order {
            files.write_text("orders.svg", &orders_picture(by_order, &title))?;
        }
        Ok(())
    }
}

/// Table with a row for each order: the force, and the pressures at some receivers.
fn orders_csv(orders: &[Order], receivers: &[ReceiverOrders]) -> String {
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
fn orders_picture(orders: &[Order], title: &str) -> String {
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
