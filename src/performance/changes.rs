//! Comparison of the counters of two records.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::storage::input::{self, TABLE_BYTES};

/// Accepted change of a counter, with its reason.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AcceptedChange {
    /// Name of the workload.
    pub workload: String,
    /// Name of the counter.
    pub counter: String,
    /// Value before; 0 if it did not exist.
    pub from: u64,
    /// Value after; 0 if it no longer exists.
    pub to: u64,
    /// Why the change is right.
    pub reason: String,
}

/// Reads the file of accepted changes, tables `[[change]]`; a missing file accepts nothing.
///
/// # Errors
/// A file that cannot be read, or has no such tables.
pub fn read_accepted(path: &Path) -> io::Result<Vec<AcceptedChange>> {
    let text = match input::read_text(path, TABLE_BYTES).map_err(io::Error::from) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        text => text?,
    };
    let right = "tables [[change]] with workload, counter, from, to and a reason in words";
    let tables: Result<BTreeMap<String, Vec<AcceptedChange>>, _> = toml::from_str(&text);
    let mut tables = tables.map_err(|error| io::Error::other(format!("{error}; it should have {right}")))?;
    let changes = tables.remove("change").unwrap_or_default();
    if let Some(other) = tables.keys().next() {
        return Err(io::Error::other(format!("`{other}` is not known; it should have {right}")));
    }
    match changes.iter().find(|change| change.reason.trim().is_empty()) {
        Some(AcceptedChange { counter, workload, .. }) => {
            Err(io::Error::other(format!("{counter} of {workload} has no reason; it should have {right}")))
        }
        None => Ok(changes),
    }
}

/// Reasons of a chain of changes of a counter from one value to another, each beginning where the one before ended;
/// `None` if there is no such chain.
fn reasons(accepted: &[AcceptedChange], workload: &str, counter: &str, from: u64, to: u64) -> Option<String> {
    let (mut at, mut reasons) = (from, Vec::new());
    for change in accepted.iter().filter(|change| change.workload == workload && change.counter == counter) {
        if at != to && change.from == at {
            at = change.to;
            reasons.push(change.reason.as_str());
        }
    }
    (at == to).then(|| reasons.join("; "))
}

/// A counter whose value has changed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CounterDifference {
    /// Name of the counter.
    pub counter: String,
    /// Value in the first record; 0 if missing.
    pub from: u64,
    /// Value in the second record; 0 if missing.
    pub to: u64,
    /// Reason, if the change is accepted.
    pub explained: Option<String>,
}

/// Counters that depend on which points are found in contact, or on what a fit converges to: another instruction set
/// rounds differently and may find one point more.
const ROUNDED: [&str; 10] = [
    "poles",
    "solves",
    "factorisations",
    "bands",
    "refactorisations",
    "cache_hits",
    "cache_misses",
    "neighbours",
    "cache_evictions",
    "compliance_evaluations",
];
/// Largest relative difference of such counters, and of the work that follows from them, between instruction sets.
const ROUNDING: f64 = 0.01;

/// Counters of a workload that differ. With `other_instructions` those that depend on rounding may differ by a
/// hundredth.
pub fn differences(
    workload: &str,
    first: &BTreeMap<String, u64>,
    second: &BTreeMap<String, u64>,
    accepted: &[AcceptedChange],
    other_instructions: bool,
) -> Vec<CounterDifference> {
    let names: BTreeSet<&String> = first.keys().chain(second.keys()).collect();
    let mut found = Vec::new();
    for counter in names {
        let [from, to] = [first, second].map(|counts| counts.get(counter).copied().unwrap_or(0));
        let rounds = ROUNDED.contains(&counter.as_str()) || counter.contains('.') || counter.ends_with("multiply_adds");
        let rounding = if other_instructions && rounds { ROUNDING * from.max(to).max(100) as f64 } else { 0.0 };
        if from.abs_diff(to) as f64 > rounding {
            let explained = reasons(accepted, workload, counter, from, to);
            found.push(CounterDifference { counter: counter.clone(), from, to, explained });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn with(counters: &[(&str, u64)]) -> BTreeMap<String, u64> {
        counters.iter().map(|&(name, amount)| (name.to_owned(), amount)).collect()
    }

    fn change(from: u64, to: u64) -> AcceptedChange {
        let [workload, counter, reason] = ["rough", "solves", "because"].map(str::to_owned);
        AcceptedChange { workload, counter, from, to, reason }
    }

    #[test]
    fn every_changed_counter_is_reported_and_explained() {
        let (a, b) = (with(&[("steps", 10), ("solves", 20), ("poles", 5)]), with(&[("steps", 10), ("solves", 23)]));
        let none = [];
        let found = differences("rough", &a, &b, &none, false);
        let reported: Vec<_> =
            found.iter().map(|d| (d.counter.as_str(), d.from, d.to, d.explained.is_some())).collect();
        assert_eq!(reported, [("poles", 5, 0, false), ("solves", 20, 23, false)]);
        let chain = [change(20, 21), change(21, 23)];
        let found = differences("rough", &a, &b, &chain, false);
        assert_eq!(found[1].explained.as_deref(), Some("because; because"));
        for other in [change(20, 22), change(21, 23), change(23, 20)] {
            assert!(differences("rough", &a, &b, &[other], false)[1].explained.is_none());
        }
        assert!(differences("smooth", &a, &b, &chain, false)[1].explained.is_none());
        assert!(differences("rough", &a, &a, &none, false).is_empty());
    }

    #[test]
    fn other_instructions_may_round_but_not_step_differently() {
        let a = with(&[("steps", 1000), ("solves", 1000), ("active_set.bytes", 100_000)]);
        let b = with(&[("steps", 1000), ("solves", 1009), ("active_set.bytes", 100_500)]);
        let none = [];
        assert!(differences("rough", &a, &b, &none, true).is_empty());
        assert_eq!(differences("rough", &a, &b, &none, false).len(), 2);
        let c = with(&[("steps", 1001), ("solves", 1020), ("active_set.bytes", 100_500)]);
        assert_eq!(differences("rough", &a, &c, &none, true).len(), 2);
    }

    #[test]
    fn the_file_wants_reasons_and_may_be_missing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("accepted.toml");
        assert_eq!(read_accepted(&path).unwrap(), []);
        let text = "[[change]]\nworkload = \"rough\"\ncounter = \"solves\"\nfrom = 20\nto = 21\nreason = \"because\"\n";
        fs::write(&path, text).unwrap();
        assert_eq!(read_accepted(&path).unwrap(), [change(20, 21)]);
        let without = text.replace("reason = \"because\"", "");
        let others = text.replace("[[change]]", "[[changes]]");
        for wrong in
            [others, without, text.replace("because", " "), text.replace("from", "form"), "change = 3".to_owned()]
        {
            fs::write(&path, &wrong).unwrap();
            let error = read_accepted(&path).unwrap_err().to_string();
            assert!(error.contains("it should have tables [[change]]"), "{wrong}: {error}");
        }
    }
}
