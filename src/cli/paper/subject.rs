//! A figure or another subject of the paper: its statements beside the findings, pictures and numbers.

use std::fmt;

use serde::Serialize;
use serde_json::Value;

use crate::response::ThirdOctaveBand;
use crate::study::trial::{LOWEST_BAND, Trial, level_changes};

/// Levels that differ by less count as equal \[dB\]: the error that the accuracy `standard` states, and about the
/// smallest audible difference.
pub(super) const INSIGNIFICANT: f64 = 1.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Verdict {
    Agrees,
    Disagrees,
    /// The paper has no numbers to compare with, or the finding is too uncertain.
    NotComparable,
}

impl Verdict {
    pub(super) const fn of(agrees: bool) -> Self {
        if agrees { Self::Agrees } else { Self::Disagrees }
    }
}

/// A statement of the paper, or one of its figures, beside the finding.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Statement {
    pub place: String,
    pub subject: &'static str,
    pub paper: &'static str,
    pub found: String,
    pub verdict: Verdict,
    /// Criterion of agreement; or the reason why nothing can be compared.
    pub why: String,
}

impl Statement {
    /// Verdict with its criterion, worded the same for either verdict.
    pub(super) fn judgement(&self) -> String {
        match self.verdict {
            Verdict::Agrees => format!("agrees (criterion: {})", self.why),
            Verdict::Disagrees => format!("disagrees (criterion: {})", self.why),
            Verdict::NotComparable => format!("not comparable: {}", self.why),
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Subject {
    pub heading: &'static str,
    /// Key of the numbers in `paper.json`.
    pub key: &'static str,
    pub statements: Vec<Statement>,
    /// File, caption and SVG of each picture.
    pub pictures: Vec<([&'static str; 2], String)>,
    pub numbers: Value,
}

impl Subject {
    pub(super) fn new(heading: &'static str, key: &'static str, numbers: Value) -> Self {
        Self { heading, key, statements: Vec::new(), pictures: Vec::new(), numbers }
    }

    /// Adds a statement: its subject and what the paper says; the finding; the verdict with its criterion.
    pub(super) fn state(
        &mut self,
        [subject, paper]: [&'static str; 2],
        found: String,
        (verdict, why): (Verdict, impl Into<String>),
    ) {
        let place = self.heading.to_lowercase();
        self.statements.push(Statement { place, subject, paper, found, verdict, why: why.into() });
    }
}

/// Change of the level of a third octave.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Change {
    /// Nominal mid-frequency \[Hz\].
    pub frequency: f64,
    /// \[dB\]
    pub change: f64,
}

impl fmt::Display for Change {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:+.1} dB at {} Hz", self.change, self.frequency)
    }
}

/// Changes of the contact force's levels from those of another run, from 100 Hz up to the band that contains `highest`
/// \[Hz\]; bands without sound in one of them are left out.
pub(super) fn changes(found: &Trial, reference: &Trial, highest: f64) -> Vec<Change> {
    let highest = ThirdOctaveBand::containing(highest).map_or(highest, ThirdOctaveBand::upper_edge);
    level_changes(&found.levels, &reference.levels)
        .map(|(level, change)| Change { frequency: level.band.nominal_frequency(), change })
        .filter(|of| (LOWEST_BAND..=highest).contains(&of.frequency) && of.change.is_finite())
        .collect()
}

/// The change with the largest value of `measure`; NaN without any.
pub(super) fn largest(changes: &[Change], measure: fn(f64) -> f64) -> Change {
    let none = Change { frequency: f64::NAN, change: f64::NAN };
    changes.iter().copied().max_by(|a, b| measure(a.change).total_cmp(&measure(b.change))).unwrap_or(none)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_verdict_never_reads_as_its_opposite() {
        let mut subject = Subject::new("Figure 4", "slice", Value::Null);
        for verdict in [Verdict::of(false), Verdict::of(true), Verdict::NotComparable] {
            subject.state(["springs", "no difference"], "+4.6 dB".to_owned(), (verdict, "within 1 dB"));
        }
        let read: Vec<String> = subject.statements.iter().map(Statement::judgement).collect();
        let expected = ["disagrees (criterion: within 1 dB)", "agrees (criterion: within 1 dB)"];
        assert_eq!(read, [expected[0], expected[1], "not comparable: within 1 dB"]);
        assert!(subject.statements.iter().all(|of| of.place == "figure 4"));
        assert_eq!(serde_json::to_string(&Verdict::NotComparable).unwrap(), "\"not-comparable\"");
    }

    #[test]
    fn the_largest_change_is_that_of_its_measure() {
        let all = [(400.0, 2.0), (800.0, -7.0)].map(|(frequency, change)| Change { frequency, change });
        assert_eq!([largest(&all, f64::abs), largest(&all, |change| change)], [all[1], all[0]]);
        assert!(largest(&[], f64::abs).change.is_nan());
    }
}
