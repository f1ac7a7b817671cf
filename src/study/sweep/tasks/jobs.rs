//! Job files for batch systems.
//!
//! An element of a job array does a chunk of tasks, as many at a time as it has processors. Systems limit the number of
//! elements (Slurm's `MaxArraySize` is 1001 unless set otherwise), and each costs a fraction of a second: so chunks
//! take a minute, and more where there would be too many elements.

use std::path::Path;

use crate::study::sweep::tasks::folder::Written;

/// Most elements of a job array.
const MOST_ELEMENTS: u64 = 1000;
/// Least time of an element \[s\].
const ELEMENT_SECONDS: f64 = 60.0;
/// Margin of an element's time limit and memory over what the plan expects: unit costs of another machine, a slow disk.
const TIME_MARGIN: f64 = 3.0;
const MEMORY_MARGIN: f64 = 1.5;
/// Allowance of every element, for fitting the tyre anew and starting the program \[s\], \[MB\].
const START_SECONDS: f64 = 300.0;
const START_MEGABYTES: f64 = 128.0;
/// Notice that an element gets before it is ended, for its checkpoints \[s\].
const NOTICE_SECONDS: u64 = 60;
/// How often HyperQueue restarts an element whose worker was lost.
const CRASH_LIMIT: u32 = 20;
/// Parts of Slurm's script before and after the program. Slurm's signal (at a time limit, or for a job of higher
/// priority) may reach the shell alone; and an element that ends within its notice counts as failed: Slurm does not
/// requeue it.
const SLURM_AROUND: [&str; 2] = [
    r#"# The program receives the signal, writes its checkpoints and ends with 130.
trap 'told=yes; kill -TERM $(jobs -p) 2> /dev/null' TERM
"#,
    r#" &
# A wait that was interrupted is begun again.
while told=; wait "$!"; ended=$?; [ -n "$told" ]; do :; done
# Unless it was cancelled, the element goes back into the queue, and continues from its checkpoints.
element=${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID
if [ "$ended" -eq 130 ] && [ "$(squeue --noheader --jobs="$element" --format=%T)" = RUNNING ]; then
    echo "back into the queue"
    exec scontrol requeue "$element"
fi
exit "$ended""#,
];
/// First lines of the files.
pub(crate) const HEAD: &str = "#!/bin/bash\n# tyrewave sweep: ";
/// Name of the file that lists the elements with missing tasks.
pub(crate) const MISSING: &str = "missing";
/// Folder of the job's messages.
pub(crate) const LOGS: &str = "logs";

/// Distribution of tasks over a batch system's elements.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jobs<'a> {
    /// The program, as an absolute path.
    pub program: &'a Path,
    /// The folder of tasks, as an absolute path.
    pub folder: &'a Path,
    /// Number of tasks.
    pub count: u64,
    /// Tasks of an element.
    pub chunk: u64,
    /// Processors of an element.
    pub threads: usize,
    /// Tasks that an element does at a time.
    pub at_a_time: usize,
    /// Most elements at a time.
    pub at_once: u64,
    /// Longest time of a task \[s\].
    pub seconds: f64,
    /// Largest memory of a task \[bytes\].
    pub memory: f64,
    /// True if results folders are retained.
    pub keep_results: bool,
}

/// Number of tasks of an element, unless the user chooses it, for `count` tasks of at most `seconds` \[s\], `threads`
/// at a time.
pub(crate) fn chunk(count: u64, seconds: f64, threads: usize) -> u64 {
    let in_time = (ELEMENT_SECONDS / seconds.max(1e-3)).ceil() as u64 * threads as u64;
    in_time.min(count).max(count.div_ceil(MOST_ELEMENTS)).max(1)
}

impl<'a> Jobs<'a> {
    /// Jobs of tasks that were written; `program` and `folder` are absolute paths.
    pub(crate) fn of(written: &Written, program: &'a Path, folder: &'a Path, threads: usize) -> Self {
        let Written { folder: tasks, seconds, memory, alone, .. } = written;
        let (count, chunk) = (tasks.manifest.count, tasks.manifest.chunk);
        let at_a_time = if *alone { 1 } else { threads };
        let (at_once, seconds, memory, keep_results) = (MOST_ELEMENTS, seconds[0], *memory, false);
        Self { program, folder, count, chunk, threads, at_a_time, at_once, seconds, memory, keep_results }
    }

    /// Number of elements of the array.
    pub(crate) fn elements(&self) -> u64 {
        self.count.div_ceil(self.chunk)
    }

    /// Time limit of an element, in whole minutes.
    fn minutes(&self) -> u64 {
        let rounds = self.chunk.div_ceil(self.at_a_time as u64) as f64;
        ((rounds * self.seconds * TIME_MARGIN + START_SECONDS) / 60.0).ceil() as u64
    }

    /// Memory of an element \[MB\].
    fn megabytes(&self) -> u64 {
        let at_a_time = self.chunk.min(self.at_a_time as u64) as f64;
        (at_a_time * self.memory / 1e6 * MEMORY_MARGIN + START_MEGABYTES).ceil() as u64
    }

    /// Commands of an element, in bash: `variable` holds its number, `does` goes before the program, `ends` after it.
    fn element(&self, variable: &str, [does, ends]: [&str; 2]) -> String {
        let Self { chunk, threads, count, .. } = self;
        let [program, folder] = [self.program, self.folder].map(quoted);
        let keep = if self.keep_results { " --keep-results" } else { "" };
        format!(
            "first=$(({variable} * {chunk}))\nlast=$((first + {}))\nif [ \"$last\" -gt {last} ]; then last={last}; fi\n\
             {does}{program} sweep --task {folder} \"$first..$last\" --threads {threads}{keep}{ends}\n",
            chunk - 1,
            last = count.saturating_sub(1),
        )
    }

    /// Head of a file: how to submit it and the reasons of its limits, as comments.
    fn reasons(&self, how: &str) -> String {
        let Self { count, chunk, at_a_time, seconds, memory, .. } = self;
        format!(
            "{HEAD}{count} tasks, {chunk} to an element of the array, {at_a_time} at a time.\n# {how}\n\
             # The plan expects at most {seconds:.1} s and {:.0} MB of a task. The limits are {TIME_MARGIN} times the \
             time and {START_SECONDS:.0} s,\n# {MEMORY_MARGIN} times the memory and {START_MEGABYTES:.0} MB.\n",
            memory / 1e6
        )
    }

    /// Job array for Slurm's `sbatch`.
    pub(crate) fn slurm(&self) -> String {
        let last = self.elements().saturating_sub(1);
        let path = |name: &str| quoted(&self.folder.join(name));
        format!(
            "{reasons}#SBATCH --job-name=tyrewave\n#SBATCH --array=0-{last}%{at_once}\n#SBATCH --ntasks=1\n\
             #SBATCH --cpus-per-task={threads}\n#SBATCH --mem={megabytes}M\n#SBATCH --time={minutes}\n\
             #SBATCH --requeue\n#SBATCH --signal=B:TERM@{NOTICE_SECONDS}\n#SBATCH --open-mode=append\n\
             #SBATCH --output=\"{logs}/%a.txt\"\n\n{element}",
            reasons = self.reasons(&format!(
                "Submit with: sbatch {0}; what is missing then: sbatch --array=$(cat {1}) {0}",
                path("job.slurm"),
                path(MISSING)
            )),
            at_once = self.at_once,
            threads = self.threads,
            megabytes = self.megabytes(),
            minutes = self.minutes(),
            logs = self.folder.join(LOGS).display().to_string().replace('%', "%%").replace('"', "\\\""),
            element = self.element("SLURM_ARRAY_TASK_ID", SLURM_AROUND),
        )
    }

    /// Script that submits an array to HyperQueue.
    pub(crate) fn hyperqueue(&self) -> String {
        let last = self.elements().saturating_sub(1);
        let (minutes, path) = (self.minutes(), |name: &str| quoted(&self.folder.join(name)));
        let usage =
            format!("Submit with: bash {0}; what is missing then: bash {0} $(cat {1})", path("job.hq"), path(MISSING));
        format!(
            "{reasons}exec hq submit --name tyrewave --array \"${{1:-0-{last}}}\" --cpus {threads} --resource \
             mem={megabytes} \\\n  --time-request {minutes}min --time-limit {minutes}min --crash-limit {CRASH_LIMIT} \
             --stream {logs} \\\n  -- bash -c {element}\n",
            reasons = self.reasons(&usage),
            threads = self.threads,
            megabytes = self.megabytes(),
            logs = path(LOGS),
            // The program replaces the shell, and so receives the signals that the shell is sent.
            element = shell_word(&self.element("HQ_TASK_ID", ["exec ", ""])),
        )
    }
}

fn quoted(path: &Path) -> String {
    shell_word(&path.display().to_string())
}

/// Quotes a text as one word of the shell, whatever it contains.
fn shell_word(text: &str) -> String {
    format!("'{}'", text.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jobs() -> Jobs<'static> {
        Jobs {
            program: Path::new("/opt/tyre wave/tyrewave"),
            folder: Path::new("/data/it's 5%"),
            count: 2500,
            chunk: 4,
            threads: 2,
            at_a_time: 2,
            at_once: 100,
            seconds: 50.0,
            memory: 100e6,
            keep_results: false,
        }
    }

    #[test]
    fn chunks_keep_arrays_short_and_elements_long() {
        for (count, seconds, threads, wanted) in [
            (200, 120.0, 1, 1),
            (200, 20.0, 1, 3),
            (200, 20.0, 8, 24),
            (200, 0.01, 1, 200),
            (1000, 3600.0, 1, 1),
            (1001, 3600.0, 1, 2),
            (1_000_000, 3600.0, 64, 1000),
            (0, 0.0, 1, 1),
        ] {
            assert_eq!(chunk(count, seconds, threads), wanted, "{count} tasks of {seconds} s");
        }
    }

    #[test]
    fn a_slurm_job_has_the_plans_limits() {
        let job = jobs().slurm();
        for line in [
            "#!/bin/bash",
            "#SBATCH --array=0-624%100",
            "#SBATCH --cpus-per-task=2",
            // Two at a time of 100 MB, 1.5 times, and 128 MB; two rounds of 50 s, three times, and 300 s.
            "#SBATCH --mem=428M",
            "#SBATCH --time=10",
            "#SBATCH --requeue",
            "#SBATCH --signal=B:TERM@60",
            "#SBATCH --output=\"/data/it's 5%%/logs/%a.txt\"",
            "first=$((SLURM_ARRAY_TASK_ID * 4))",
            "last=$((first + 3))",
            "if [ \"$last\" -gt 2499 ]; then last=2499; fi",
            "'/opt/tyre wave/tyrewave' sweep --task '/data/it'\\''s 5%' \"$first..$last\" --threads 2 &",
        ] {
            assert!(job.lines().any(|other| other == line), "{line}\n{job}");
        }
        assert!(job.starts_with(HEAD) && Jobs { keep_results: true, ..jobs() }.slurm().contains(" --keep-results &\n"));
    }

    #[test]
    fn a_hyperqueue_job_is_one_submission_of_the_same() {
        let job = jobs().hyperqueue();
        assert!(job.starts_with(HEAD) && job.contains("--array \"${1:-0-624}\" --cpus 2 --resource mem=428 "), "{job}");
        assert!(job.contains("--time-limit 10min --crash-limit 20"), "{job}");
    }

    #[test]
    #[cfg(unix)]
    fn the_shell_reads_what_was_meant() {
        // `printf` shows its arguments, one per line.
        let jobs = Jobs { program: Path::new("/usr/bin/printf"), ..jobs() };
        let element = jobs.element("NUMBER", ["exec ", ""]).replace("sweep --task", "'%s|' sweep --task");
        let of = |number: &str, script: &str| {
            let shell = std::process::Command::new("bash").args(["-c", script]).env("NUMBER", number).output();
            shell.map(|output| String::from_utf8_lossy(&output.stdout).into_owned())
        };
        let Ok(answer) = of("3", &element) else {
            return;
        };
        assert_eq!(answer, "sweep|--task|/data/it's 5%|12..15|--threads|2|");
        let within = format!("bash -c {}", shell_word(&element));
        assert_eq!(of("624", &within).unwrap(), "sweep|--task|/data/it's 5%|2496..2499|--threads|2|");
    }

    #[test]
    #[cfg(unix)]
    fn an_ended_element_of_slurm_returns_to_the_queue() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let program = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, format!("#!/bin/bash\n{text}\n")).unwrap();
            std::fs::set_permissions(&path, PermissionsExt::from_mode(0o755)).unwrap();
            path
        };
        // A program that ends with 130 on a signal, a shell that is signalled twice, and Slurm's two commands.
        let signals = "kill -TERM $PPID; sleep 0.1; kill -TERM $PPID; for n in {1..100}; do sleep 0.05; done; exit 7";
        let told = program("told", &format!("trap 'sleep 0.3; exit 130' TERM\n{signals}"));
        let failed = program("failed", "exit 3");
        program("squeue", "echo ${STATE:?}");
        program("scontrol", "echo scontrol \"$@\"");
        let end_of = |program: &Path, state: &str| {
            let script = Jobs { program, ..jobs() }.slurm();
            let path = format!("{}:/usr/bin:/bin", folder.path().display());
            let mut shell = std::process::Command::new("bash");
            shell.args(["-c", &script]).env("PATH", path).env("STATE", state);
            let output = shell.env("SLURM_ARRAY_JOB_ID", "17").env("SLURM_ARRAY_TASK_ID", "0").output().ok()?;
            let printed = String::from_utf8_lossy(&output.stdout).into_owned();
            Some((output.status.code(), printed.lines().last().unwrap_or_default().to_owned()))
        };
        // Where there is no bash there is no Slurm.
        let Some(back) = end_of(&told, "RUNNING") else { return };
        assert_eq!(back, (Some(0), "scontrol requeue 17_0".to_owned()));
        assert_eq!(end_of(&told, "COMPLETING"), Some((Some(130), String::new())), "cancelled");
        assert_eq!(end_of(&failed, "RUNNING"), Some((Some(3), String::new())));
    }
}
