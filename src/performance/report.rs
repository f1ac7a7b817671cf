//! A verdict in words.

use std::fmt::Write;

use super::ratio::Ratio;
use super::verdict::{Change, DOUBT, MARGIN, StageVerdict, Verdict, WorkloadVerdict};
use crate::results::table::aligned;

const HEADER: [&str; 7] = ["workload", "stage", "share", "time, first", "ratio", "interval", "verdict"];

/// Begin of a verdict in Markdown, by which an earlier one is recognised.
pub(crate) const MARKDOWN_HEAD: &str = "# Performance\n\n";
/// Begin of a verdict in JSON, by which an earlier one is recognised.
pub(crate) const JSON_HEAD: &str = "{\n  \"first\": \"";

impl Verdict {
    /// The verdict as JSON, for programs.
    pub(crate) fn json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// The verdict as text, for the terminal.
    pub(crate) fn text(&self) -> String {
        let mut text = format!("{} held against {}\n", self.second.display(), self.first.display());
        let rows = self.table();
        if !rows.is_empty() {
            let _ = write!(text, "\n{}\n{}", aligned(HEADER, rows), self.resolution());
        }
        text.push('\n');
        self.conclusions(&mut text);
        text
    }

    /// The verdict as Markdown, for a page.
    pub(crate) fn markdown(&self) -> String {
        let line = |cells: &[&str]| format!("| {} |\n", cells.join(" | "));
        let mut text = format!("{MARKDOWN_HEAD}{} held against {}\n", self.second.display(), self.first.display());
        let rows = self.table();
        if !rows.is_empty() {
            let _ = write!(text, "\n{}{}", line(&HEADER), line(&["---"; HEADER.len()]));
            rows.iter().for_each(|row| text.push_str(&line(&row.each_ref().map(String::as_str))));
            let _ = write!(text, "\n{}", self.resolution());
        }
        let mut conclusions = String::new();
        self.conclusions(&mut conclusions);
        let items = conclusions.lines().filter(|line| !line.is_empty()).map(|line| format!("- {line}\n"));
        format!("{text}\n{}", items.collect::<String>())
    }

    /// Rows by workload and stage, then the pooled stages.
    fn table(&self) -> Vec<[String; 7]> {
        let mut rows = Vec::new();
        for WorkloadVerdict { workload, whole, stages, .. } in &self.workloads {
            if let Some(whole) = *whole {
                rows.push(row(workload, "all", 1.0, whole, ""));
                rows.extend(stages.iter().map(|stage| of_stage("", stage)));
            }
        }
        for (index, stage) in self.stages.iter().enumerate() {
            rows.push(of_stage(if index == 0 { "pooled" } else { "" }, stage));
        }
        rows
    }

    fn resolution(&self) -> String {
        let judged = self.rows().filter(|stage| stage.change != Change::NotJudged);
        let mut all: Vec<f64> = judged.map(|stage| stage.resolution).collect();
        let worst = all.iter().copied().fold(0.0, f64::max);
        let median = super::ratio::median(&mut all);
        let smallest = if worst.is_finite() {
            let [median, worst] = [median, worst].map(|resolution| 100.0 * (resolution + MARGIN));
            format!("{median:.1} % for half of the stages, {worst:.1} % for the worst")
        } else {
            "none, for want of pairs".to_owned()
        };
        format!(
            "Intervals hold the median ratio with a probability of {:.1} %; \
             a stage is called changed if two batches in a row lie beyond {:.0} %.\n\
             Smallest change that shows here and now: {smallest}.\n",
            100.0 * (1.0 - DOUBT),
            100.0 * MARGIN,
        )
    }

    fn conclusions(&self, text: &mut String) {
        for workload in &self.workloads {
            let name = &workload.workload;
            for difference in &workload.differences {
                if let Some(reason) = &difference.explained {
                    let (counter, from, to) = (&difference.counter, difference.from, difference.to);
                    let _ = writeln!(text, "{name}: counter {counter} went from {from} to {to}: {reason}");
                }
            }
            if let Some((from, to)) = workload.instructions {
                let _ = writeln!(text, "{name}: {to} instructions, {from} before");
            }
            for words in workload.complaints().into_iter().chain(workload.praise()) {
                let _ = writeln!(text, "{name}: {words}");
            }
        }
        for words in self.pooled(Change::Slower).chain(self.pooled(Change::Faster)) {
            let _ = writeln!(text, "all: {words}");
        }
        let (counted, evidence) = (self.workloads.len(), &self.evidence);
        let failed = self.workloads.iter().filter(|workload| !workload.complaints().is_empty()).count();
        let _ = match (self.passes(), self.times_judged) {
            (true, true) => {
                writeln!(text, "{counted} workloads: results right, counters as they should be; no stage slower")
            }
            (true, false) if self.is_undecided => {
                writeln!(text, "{counted} workloads: results right, counters as they should be; times undecided")
            }
            (true, false) => writeln!(text, "{counted} workloads: results right, counters as they should be"),
            (false, _) if failed == 0 => writeln!(text, "worse, all workloads together"),
            (false, _) => writeln!(text, "{failed} of {counted} workloads are worse"),
        };
        let _ = writeln!(text, "judged by {evidence}");
    }
}

fn row(name: &str, stage: &str, share: f64, ratio: Ratio, verdict: &str) -> [String; 7] {
    let Ratio { median, low, high, seconds, .. } = ratio;
    let (share, time) = (format!("{:.0} %", 100.0 * share), format!("{:.1} ms", 1e3 * seconds));
    let (median, interval) = (format!("{median:.3}"), format!("{low:.3} - {high:.3}"));
    [name.to_owned(), stage.to_owned(), share, time, median, interval, verdict.to_owned()]
}

fn of_stage(name: &str, stage: &StageVerdict) -> [String; 7] {
    let verdict = match stage.change {
        Change::None => "same",
        Change::Slower => "SLOWER",
        Change::Faster => "faster",
        Change::NotJudged => "small",
    };
    row(name, &stage.stage, stage.share, stage.ratio, verdict)
}
