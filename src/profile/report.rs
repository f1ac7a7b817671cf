//! A verdict in words: tables for the terminal, Markdown for a page.

use std::fmt::Write;

use super::ratio::Ratio;
use super::verdict::{Change, DOUBT, MARGIN, StageVerdict, Verdict, WorkloadVerdict};
use crate::results::table::aligned;

const HEADER: [&str; 7] = ["workload", "stage", "share", "time, first", "ratio", "interval", "verdict"];

impl Verdict {
    /// For the terminal.
    pub fn text(&self) -> String {
        let mut text = self.title();
        if self.workloads.iter().any(|workload| workload.whole.is_some()) {
            let rows: Vec<[String; 7]> = self.workloads.iter().flat_map(rows).collect();
            let _ = write!(text, "\n{}\n{}", aligned(&HEADER, &rows), self.resolution());
        }
        text.push('\n');
        self.conclusions(&mut text, "");
        text
    }

    /// For a page.
    pub fn markdown(&self) -> String {
        let mut text = format!("# Performance\n\n{}", self.title());
        if self.workloads.iter().any(|workload| workload.whole.is_some()) {
            let line = |cells: &[&str]| format!("| {} |\n", cells.join(" | "));
            let _ = write!(text, "\n{}{}", line(&HEADER), line(&["---"; HEADER.len()]));
            for row in self.workloads.iter().flat_map(rows) {
                text.push_str(&line(&row.each_ref().map(String::as_str)));
            }
            let _ = write!(text, "\n{}", self.resolution());
        }
        text.push('\n');
        self.conclusions(&mut text, "- ");
        text
    }

    fn title(&self) -> String {
        format!("{} held against {}\n", self.second.display(), self.first.display())
    }

    fn resolution(&self) -> String {
        let judged = || {
            let stages = self.workloads.iter().flat_map(|workload| &workload.stages);
            stages.filter(|stage| stage.change != Change::NotJudged).map(|stage| stage.resolution)
        };
        let worst = judged().fold(0.0, f64::max);
        let mut all: Vec<f64> = judged().collect();
        let median = super::ratio::median(&mut all);
        format!(
            "Intervals hold the median ratio with a probability of {:.1} %; a stage is called changed if two batches in a row lie beyond {:.0} %.\n\
             Smallest change that shows here and now: {:.1} % for half of the stages, {:.1} % for the worst.\n",
            100.0 * (1.0 - DOUBT),
            100.0 * MARGIN,
            100.0 * (median + MARGIN),
            100.0 * (worst + MARGIN)
        )
    }

    fn conclusions(&self, text: &mut String, bullet: &str) {
        for workload in &self.workloads {
            let name = &workload.workload;
            for difference in &workload.differences {
                if let Some(reason) = &difference.explained {
                    let (counter, from, to) = (&difference.counter, difference.from, difference.to);
                    let _ = writeln!(text, "{bullet}{name}: counter {counter} went from {from} to {to}: {reason}");
                }
            }
            if let Some((from, to)) = workload.instructions {
                let _ = writeln!(text, "{bullet}{name}: {to} instructions, {from} before");
            }
            for words in workload.complaints().into_iter().chain(workload.praise()) {
                let _ = writeln!(text, "{bullet}{name}: {words}");
            }
        }
        let counted = self.workloads.len();
        let _ = match self.workloads.iter().filter(|workload| !workload.complaints().is_empty()).count() {
            0 => {
                let timed = self.workloads.iter().all(|workload| workload.whole.is_some());
                let times = if timed { "no stage slower" } else { "times are compared between two programs only" };
                writeln!(text, "{bullet}{counted} workloads: results right, counters as they should be; {times}")
            }
            failed => writeln!(text, "{bullet}{failed} of {counted} workloads are worse"),
        };
    }
}

fn rows(workload: &WorkloadVerdict) -> Vec<[String; 7]> {
    let Some(whole) = workload.whole else { return Vec::new() };
    let numbers = |ratio: Ratio| {
        let Ratio { median, low, high, seconds, .. } = ratio;
        [format!("{:.1} ms", 1e3 * seconds), format!("{median:.3}"), format!("{low:.3} - {high:.3}")]
    };
    let row = |name: &str, stage: &str, share: f64, ratio: Ratio, verdict: &str| {
        let [time, median, interval] = numbers(ratio);
        let share = format!("{:.0} %", 100.0 * share);
        [name.to_owned(), stage.to_owned(), share, time, median, interval, verdict.to_owned()]
    };
    let of_stage = |stage: &StageVerdict| {
        let verdict = match stage.change {
            Change::None => "same",
            Change::Slower => "SLOWER",
            Change::Faster => "faster",
            Change::NotJudged => "small",
        };
        row("", &stage.stage, stage.share, stage.ratio, verdict)
    };
    let head = row(&workload.workload, "all", 1.0, whole, "");
    std::iter::once(head).chain(workload.stages.iter().map(of_stage)).collect()
}
