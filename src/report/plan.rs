//! A plan as JSON, for scripts.

use serde_json::{Value, json};

use crate::plan::{Amounts, Forecast, Plan};
use crate::planning::foreseen;
use crate::scene::{LoadedScene, SceneError};

/// A plan as JSON: effects and choices with their reasons, sizes, work, memory and forecast.
///
/// # Errors
/// Settings that JSON cannot hold.
pub(crate) fn plan_record(
    loaded: &LoadedScene,
    plan: &Plan,
    amounts: &Amounts,
    forecast: &Forecast,
) -> Result<Value, SceneError> {
    let counter = |&(counter, amount)| json!({ "counter": counter, "amount": amount });
    let held = |&(what, bytes)| json!({ "what": what, "bytes": bytes });
    let counters: Vec<_> = amounts.counters.iter().map(counter).collect();
    let memory: Vec<_> = amounts.memory.iter().map(held).collect();
    Ok(json!({
        "title": loaded.title(),
        "scene_sha256": loaded.clone().settled(plan.scene.clone()).hash()?,
        "effects": plan.decisions.rows,
        "choices": plan.choices,
        "notes": plan.decisions.notes,
        "warnings": foreseen(plan),
        "sizes": {
            "speed": plan.speed,
            "elements": plan.scene.numerics.elements,
            "element": plan.element,
            "time_step": plan.time_step,
            "warm_up_steps": plan.warm_up_steps,
            "steps": plan.steps,
            "segments": plan.segment_count(),
            "expected": amounts.expected,
        },
        "slices": plan.slice_errors,
        "work": amounts.work,
        "counters": counters,
        "memory": memory,
        "result_bytes": amounts.result_bytes,
        "cache_bytes": amounts.cache_bytes,
        "forecast": forecast,
    }))
}
