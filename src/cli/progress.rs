//! Progress on the terminal, in lines of at most 80 columns: simulated time, real-time factor, time to go. Without a
//! terminal a line is written every ten seconds.

use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::counters::Stage;
use crate::run::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use super::error::write_message;
use super::progress_log::{Doing, Pace, ProgressLog, in_words};

/// Interval of the spinner while a stage reports nothing.
const TICK: Duration = Duration::from_millis(120);
/// Resolution of a share of all work on the bar.
const SHARES: u64 = 1000;

/// A line on standard error that is redrawn; if that is not a terminal, a line every ten seconds.
#[derive(Debug)]
pub(crate) struct TerminalProgress {
    bar: ProgressBar,
    quiet: bool,
    /// The present stage.
    stage: Option<Stage>,
    /// Pace of the steps.
    pace: Arc<Mutex<Pace>>,
    /// Writer of lines, if nothing is drawn.
    log: Option<ProgressLog>,
}

impl TerminalProgress {
    /// A line that is not drawn yet; with `quiet` it never is.
    pub(crate) fn new(quiet: bool) -> Self {
        let mut progress = Self::with_target(quiet, ProgressDrawTarget::stderr());
        progress.log = (!quiet && !std::io::stderr().is_terminal()).then(ProgressLog::start);
        progress
    }

    fn with_target(quiet: bool, target: ProgressDrawTarget) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { target };
        let bar = ProgressBar::with_draw_target(None, target);
        let pace = Arc::new(Mutex::new(Pace::after(0)));
        Self { bar, quiet, stage: None, pace, log: None }
    }

    /// Sets the text of the next line, if lines are written.
    fn log(&self, doing: impl FnOnce() -> Doing) {
        if let Some(log) = &self.log {
            log.set(doing());
        }
    }

    /// Writes something above the line.
    fn print_above(&self, kind: &str, text: &str) {
        if !self.quiet {
            self.bar.suspend(|| write_message(&format!("{kind}: {text}")));
        }
    }
}

impl Progress for TerminalProgress {
    fn stage(&mut self, stage: Stage) {
        self.stage = Some(stage);
        self.bar.set_style(style("{spinner} {msg} ({elapsed})"));
        self.bar.set_message(stage.title());
        self.log(|| Doing::Named(stage.title().to_owned()));
        if !self.bar.is_hidden() {
            self.bar.enable_steady_tick(TICK);
        }
    }

    fn pieces(&mut self, done: usize, open: usize) {
        let stage = self.stage.map_or("", Stage::title);
        let message = format!("{stage}: {done} frequencies done, {open} to go");
        self.log(|| Doing::Named(message.clone()));
        self.bar.set_message(message);
    }

    fn share(&mut self, done: f64, doing: &str) {
        self.bar.disable_steady_tick();
        if self.bar.length() != Some(SHARES) {
            self.bar.set_length(SHARES);
            self.bar.set_style(style("{bar:20} {percent:>3} %, {elapsed}, {wide_msg}"));
        }
        self.bar.set_position((done * SHARES as f64) as u64);
        self.bar.set_message(doing.to_owned());
        self.log(|| Doing::Share(done, doing.to_owned()));
    }

    fn march(&mut self, done: u64, steps: u64, time_step: f64) {
        self.bar.disable_steady_tick();
        self.bar.set_length(steps);
        self.bar.reset();
        self.bar.set_position(done);
        self.bar.set_message("rolling");
        // Steps per second of this process: those of an earlier one do not count.
        let pace = Arc::new(Mutex::new(Pace::after(done)));
        self.pace = Arc::clone(&pace);
        self.log(|| Doing::Steps { all: steps, time_step, pace: Arc::clone(&pace) });
        let of_time = Arc::clone(&pace);
        let style = style("{msg} {bar:12} {percent:>3} %, {simulated}, {factor}{remaining}")
            .with_key("simulated", move |state: &ProgressState, out: &mut dyn Write| {
                let all = state.len().unwrap_or(0) as f64 * time_step;
                // Nothing can be done about a line that cannot be drawn.
                let _ = write!(out, "{:.2} of {all:.2} s", state.pos() as f64 * time_step);
            })
            .with_key("factor", move |state: &ProgressState, out: &mut dyn Write| {
                let pace = lock(&of_time);
                let rolled = state.pos().saturating_sub(done) as f64 * time_step;
                let _ = match pace.stage {
                    Some(stage) => out.write_str(stage.title()),
                    None => write!(out, "{:.3} x real time", rolled / pace.now().max(f64::MIN_POSITIVE)),
                };
            })
            .with_key("remaining", move |state: &ProgressState, out: &mut dyn Write| {
                let pace = lock(&pace);
                if let Some(seconds) = pace.seconds_remaining(pace.now(), state.len().unwrap_or(0)) {
                    let _ = write!(out, ", {} to go", in_words(seconds));
                }
            });
        self.bar.set_style(style);
    }

    fn blocks(&mut self, remaining: u64, stage: Option<Stage>) {
        let mut pace = lock(&self.pace);
        let (now, before) = (pace.now(), pace.stage);
        pace.blocks(now, remaining, stage);
        drop(pace);
        // Nothing else redraws the line during a block.
        match (before, stage) {
            (None, Some(_)) if !self.bar.is_hidden() => self.bar.enable_steady_tick(TICK),
            (Some(_), None) => self.bar.disable_steady_tick(),
            _ => {}
        }
    }

    fn step(&mut self, done: u64) {
        self.bar.set_position(done);
        let mut pace = lock(&self.pace);
        let now = pace.now();
        pace.mark(now, done);
    }

    fn note(&mut self, text: &str) {
        self.print_above("note", text);
    }

    fn warning(&mut self, text: &str) {
        self.print_above("warning", text);
    }

    fn finish(&mut self) {
        self.bar.finish_and_clear();
        self.log(|| Doing::Named("writing results".to_owned()));
    }
}

impl Drop for TerminalProgress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// A bar on standard error over `pieces` equal pieces of work, with a message for each; with `quiet` it is not drawn.
pub(super) fn pieces(quiet: bool, title: &str, pieces: u64) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    ProgressBar::with_draw_target(Some(pieces), target)
        .with_prefix(title.to_owned())
        .with_style(style("{prefix} {bar:20} {percent:>3} %, {elapsed}, {msg}"))
}

fn lock(pace: &Mutex<Pace>) -> MutexGuard<'_, Pace> {
    pace.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A style from a template; indicatif's default if it should refuse the template.
fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use indicatif::TermLike;

    use super::*;

    /// Records everything that is drawn.
    #[derive(Clone, Debug, Default)]
    struct Paper(Arc<Mutex<String>>);

    impl TermLike for Paper {
        fn width(&self) -> u16 {
            120
        }
        fn move_cursor_up(&self, _: usize) -> std::io::Result<()> {
            Ok(())
        }
        fn move_cursor_down(&self, _: usize) -> std::io::Result<()> {
            Ok(())
        }
        fn move_cursor_right(&self, _: usize) -> std::io::Result<()> {
            Ok(())
        }
        fn move_cursor_left(&self, _: usize) -> std::io::Result<()> {
            Ok(())
        }
        fn write_line(&self, text: &str) -> std::io::Result<()> {
            self.write_str(text)
        }
        fn write_str(&self, text: &str) -> std::io::Result<()> {
            self.0.lock().unwrap().push_str(text);
            Ok(())
        }
        fn clear_line(&self) -> std::io::Result<()> {
            Ok(())
        }
        fn flush(&self) -> std::io::Result<()> {
            Ok(())
        }
    }

    fn watch(progress: &mut TerminalProgress) {
        progress.stage(Stage::Influence);
        progress.march(100, 1000, 1e-3);
        progress.step(250);
        progress.bar.tick();
        progress.finish();
    }

    #[test]
    fn shows_the_stage_that_stops_the_steps() {
        let paper = Paper::default();
        let target = ProgressDrawTarget::term_like_with_hz(Box::new(paper.clone()), 255);
        let mut progress = TerminalProgress::with_target(false, target);
        progress.march(0, 1000, 1e-3);
        progress.blocks(3, Some(Stage::Sound));
        progress.step(250);
        // During a block the line is drawn by a thread.
        let text = || paper.0.lock().unwrap().clone();
        let is_drawn = || text().contains("0.25 of 1.00 s, transform to sound");
        let begin = std::time::Instant::now();
        while !is_drawn() && begin.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(5));
        }
        assert!(is_drawn(), "{}", text());
        progress.finish();
    }

    #[test]
    fn shows_simulated_time_and_speed() {
        let paper = Paper::default();
        let target = ProgressDrawTarget::term_like_with_hz(Box::new(paper.clone()), 255);
        let mut progress = TerminalProgress::with_target(false, target);
        watch(&mut progress);
        let text = paper.0.lock().unwrap().clone();
        assert!(text.contains("0.25 of 1.00 s") && text.contains(" 25 %") && text.contains("x real time"), "{text}");
        assert!(!text.contains("to go"), "a moment foretells nothing: {text}");
    }

    #[test]
    fn shows_the_share_of_all_work_and_what_is_being_done() {
        let paper = Paper::default();
        let target = ProgressDrawTarget::term_like_with_hz(Box::new(paper.clone()), 255);
        let mut progress = TerminalProgress::with_target(false, target);
        progress.share(0.0, "reference");
        progress.share(0.37, "elements 256");
        progress.bar.tick();
        let text = paper.0.lock().unwrap().clone();
        assert!(text.contains(" 37 %") && text.contains("elements 256"), "{text}");
        progress.finish();
    }

    /// A terminal that fails all writes.
    #[derive(Debug)]
    struct Gone;

    macro_rules! fails {
        ($($name:ident($($of:ty),*)),*) => {$(
            fn $name(&self, $(_: $of),*) -> std::io::Result<()> {
                Err(std::io::ErrorKind::BrokenPipe.into())
            }
        )*};
    }

    impl TermLike for Gone {
        fn width(&self) -> u16 {
            80
        }
        fails!(move_cursor_up(usize), move_cursor_down(usize), move_cursor_right(usize), move_cursor_left(usize));
        fails!(write_line(&str), write_str(&str), clear_line(), flush());
    }

    #[test]
    fn a_terminal_that_has_gone_away_stops_nobody() {
        let mut progress = TerminalProgress::with_target(false, ProgressDrawTarget::term_like(Box::new(Gone)));
        watch(&mut progress);
        progress.note("nobody hears this");
        let bar = pieces(true, "piece", 3);
        bar.set_draw_target(ProgressDrawTarget::term_like(Box::new(Gone)));
        bar.inc(1);
        bar.tick();
        bar.finish_and_clear();
    }

    #[test]
    fn quiet_is_quiet() {
        let paper = Paper::default();
        let target = ProgressDrawTarget::term_like_with_hz(Box::new(paper.clone()), 255);
        watch(&mut TerminalProgress::with_target(true, target));
        assert_eq!(*paper.0.lock().unwrap(), "");
    }
}
