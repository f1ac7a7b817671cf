//! The table of the hard cases: what each test of the name `hard_case_N...` bounds, and what it measures.
//!
//! A test says its measured values here, beside its assertions: they are printed, and with `TYREWAVE_HARD_CASES=1` they
//! replace the test's rows of the table.

use std::fmt::Display;
use std::fs;
use std::sync::{Mutex, PoisonError};

/// The table's file.
pub(crate) const TABLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/profiles/HARD_CASES.md");

/// Head over the rows.
const HEAD: &str = "\
# Hard cases

The hard cases by their numbers, each with the test that asserts its bound and what it measured last.
Made by `TYREWAVE_HARD_CASES=1 cargo test hard_case -- --include-ignored`, on two threads or more.

| case | test | what | bound | measured |
|---|---|---|---|---|
";

static WRITING: Mutex<()> = Mutex::new(());

/// The number of the hard case that a test's name begins with.
pub(crate) fn number(test: &str) -> Option<u32> {
    let name = test.rsplit("::").next()?;
    let rest = name.strip_prefix("hard_case_").or_else(|| name.strip_prefix("hard_cases_"))?;
    rest.split('_').next()?.parse().ok()
}

/// States what the running test measures and by which bound; nothing in a test that is no hard case.
pub(crate) fn measured(what: impl Display, bound: impl Display, measured: impl Display) {
    let thread = std::thread::current();
    let Some((test, number)) = thread.name().and_then(|name| Some((name, number(name)?))) else { return };
    println!("hard case {number}: {what} | {bound} | {measured}");
    if std::env::var_os("TYREWAVE_HARD_CASES").is_none() {
        return;
    }
    let _one = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    let old = fs::read_to_string(TABLE).unwrap_or_default();
    let start = format!("| {number} | `{test}` | {what} |");
    let others = old.lines().skip(HEAD.lines().count()).filter(|row| !row.starts_with(&start)).map(str::to_owned);
    let mut rows: Vec<String> = others.chain([format!("{start} {bound} | {measured} |")]).collect();
    rows.sort();
    fs::write(TABLE, HEAD.to_owned() + &rows.join("\n") + "\n").unwrap();
}
