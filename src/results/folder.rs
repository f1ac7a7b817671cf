//! The life of a results folder: under its final name there is a complete set of results or nothing of this run.
//!
//! 1. [`ResultsFolder::create`] makes `<final>.partial-<pid>` beside the final path, after checking that whatever is
//!    there already may be replaced: an empty folder, or an earlier results folder without foreign files. A file in it
//!    is locked as long as the process lives.
//! 2. Files are written there; from the first checkpoint on ([`ResultsFolder::keep_if_stopped`]) the folder outlives
//!    its process.
//! 3. [`ResultsFolder::finish`] writes the summary and brings it to the disk (as every writer does), exchanges its name
//!    with that of an older folder, deletes the older one, and last the checkpoint. If a process is killed in the
//!    middle of that, the next one tidies up (`placing`).
//! 4. An interrupted run ends with [`ResultsFolder::finish_partial`] instead: the same under `<final>.partial`. Where
//!    another process, or foreign files, prevent that, it keeps its present name.
//! 5. [`ResultsFolder::reopen`] finds an unfinished run by its final name, or by that of its folder, and continues in
//!    the same folder. A folder that another process has locked is refused.
//! 6. Dropped otherwise (an error, a panic) without a checkpoint to keep, the folder is deleted, together with parents
//!    that were created for it.

use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::checkpoint::CheckpointError;
use super::disk::{missing_parents, sync_folder, with_suffix, write_file};
use super::error::ResultsError;
use super::placing::{
    LOCK_FILE, PARTIAL, SERVICE_FILES, check_replaceable, final_name, in_use, lock, place, put_in_order, tidy_up,
    unfinished,
};
use super::summary::{SUMMARY_FILE, Summary};
use crate::storage::flat_folder::{self, entries};

/// A results folder to which a run writes.
#[derive(Debug)]
pub(crate) struct ResultsFolder {
    target: PathBuf,
    working: PathBuf,
    /// Parents that did not exist, innermost first.
    made_parents: Vec<PathBuf>,
    finished: bool,
    keep: bool,
    /// Held for its lock, which ends with it; never read.
    lock: Option<File>,
}

impl ResultsFolder {
    /// Begins results whose final path is `target`; missing parents are created.
    ///
    /// # Errors
    /// [`ResultsError::NotOurs`], [`ResultsError::ForeignEntry`] if something is there that must not be replaced,
    /// [`ResultsError::NoFolderName`], [`ResultsError::Create`].
    pub(crate) fn create(target: &Path) -> Result<Self, ResultsError> {
        if target.file_name().is_none() {
            return Err(ResultsError::NoFolderName { path: target.to_owned() });
        }
        put_in_order(target)?;
        check_replaceable(target)?;
        let made_parents = missing_parents(target);
        if let Some(parent) = made_parents.first() {
            fs::create_dir_all(parent).map_err(ResultsError::creating(parent))?;
        }
        let working = create_fresh(target)?;
        // A lock protects a checkpoint, and there is none yet: a file system without locks is no reason to refuse the
        // run.
        let lock = lock(&working).unwrap_or_default();
        Ok(Self { target: target.to_owned(), working, made_parents, finished: false, keep: false, lock })
    }

    /// Goes on with an unfinished run, given by its final path or by its folder.
    ///
    /// # Errors
    /// [`CheckpointError`] where there is none, more than one, none with a checkpoint, a link in it, or a process that
    /// still writes to it.
    pub(crate) fn reopen(path: &Path) -> Result<Self, CheckpointError> {
        let working = unfinished(path)?;
        flat_folder::without_links(&working).map_err(|source| CheckpointError::Io { path: working.clone(), source })?;
        let lock = lock(&working)?;
        let target = final_name(&working).unwrap_or_else(|| path.to_owned());
        Ok(Self { target, working, made_parents: Vec::new(), finished: false, keep: true, lock })
    }

    /// Tidies up after a process that was killed at the end of its run, given by the final path or that of the
    /// unfinished run; returns the path of whole results that have not been reported yet.
    ///
    /// # Errors
    /// If whole results cannot get their name.
    pub(crate) fn put_in_order(path: &Path) -> Result<Option<PathBuf>, ResultsError> {
        put_in_order(&final_name(path).unwrap_or_else(|| path.to_owned()))
    }

    /// Keeps the folder from now on if the process ends before the run does: it holds a checkpoint.
    pub(crate) fn keep_if_stopped(&mut self) {
        self.keep = true;
    }

    /// True if the folder holds a checkpoint from which the run can be resumed.
    pub(crate) fn holds_checkpoint(&self) -> bool {
        self.keep
    }

    /// Deletes the folder, whose run cannot be resumed.
    pub(crate) fn discard(mut self) {
        self.keep = false;
    }

    /// Present path of the folder.
    pub(crate) fn working(&self) -> &Path {
        &self.working
    }

    /// Final path of the results.
    #[cfg(test)]
    pub(crate) fn target(&self) -> &Path {
        &self.target
    }

    /// Present path of a file of that name.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.working.join(name)
    }

    /// Completes the results and returns their path. All writers must be finished.
    ///
    /// # Errors
    /// [`ResultsError::Overtaken`], [`ResultsError::Write`], [`ResultsError::Rename`]; an older folder is then where it
    /// was, and this one is deleted unless it is whole or holds a checkpoint.
    pub(crate) fn finish(mut self, summary: Summary) -> Result<PathBuf, ResultsError> {
        self.write_summary(Summary { complete: true, ..summary }, &SERVICE_FILES)?;
        // The path may have been taken during the run.
        check_replaceable(&self.target).map_err(|error| ResultsError::Overtaken(Box::new(error)))?;
        self.let_go();
        // Whole results stay from here on, whatever fails: a later process gives them their name.
        self.keep = true;
        place(&self.working, &self.target)?;
        self.finished = true;
        tidy_up(&self.target);
        Ok(self.target.clone())
    }

    /// Keeps the results of an interrupted run, as `<final>.partial` if that is free, and returns that path. All
    /// writers must be finished.
    ///
    /// # Errors
    /// [`ResultsError::Write`], [`ResultsError::Rename`].
    pub(crate) fn finish_partial(mut self, summary: Summary) -> Result<PathBuf, ResultsError> {
        self.write_summary(Summary { complete: false, ..summary }, &[LOCK_FILE])?;
        self.settle()
    }

    /// Keeps the folder with its checkpoint after a failure, as `<final>.partial` if that is free; returns its path.
    pub(crate) fn stay(mut self) -> PathBuf {
        self.settle().unwrap_or_else(|_| self.working.clone())
    }

    /// Takes the name `<final>.partial`, or keeps the present one where that belongs to another run.
    fn settle(&mut self) -> Result<PathBuf, ResultsError> {
        self.finished = true;
        let target = with_suffix(&self.target, PARTIAL);
        let free = target != self.working && check_replaceable(&target).is_ok() && !in_use(&target);
        if free {
            self.let_go();
            place(&self.working, &target)?;
            self.working = target;
        }
        let _ = fs::remove_file(self.path(LOCK_FILE));
        Ok(self.working.clone())
    }

    /// Releases the lock on Windows, which renames no folder in which a file is open.
    fn let_go(&mut self) {
        if cfg!(windows) {
            drop(self.lock.take());
        }
    }

    fn write_summary(&self, mut summary: Summary, but: &[&str]) -> Result<(), ResultsError> {
        let mut files = entries(&self.working).map_err(ResultsError::writing(&self.working))?;
        files.push(SUMMARY_FILE.to_owned());
        files.retain(|name| !but.contains(&name.as_str()));
        files.sort();
        files.dedup();
        summary.files = files;
        let summary_path = self.path(SUMMARY_FILE);
        write_file(&summary_path, summary.to_json(&summary_path)?.as_bytes())?;
        // Every writer has brought its file to the disk; only the names in the folder remain.
        sync_folder(&self.working).map_err(ResultsError::writing(&self.working))
    }
}

impl Drop for ResultsFolder {
    fn drop(&mut self) {
        if self.finished || self.keep {
            return;
        }
        // Frees a file descriptor: a process at its limit can then list the folder.
        drop(self.lock.take());
        // A failure cannot be handled here; the folder's name shows that it holds no results.
        let _ = flat_folder::remove(&self.working);
        for parent in &self.made_parents {
            if fs::remove_dir(parent).is_err() {
                break;
            }
        }
    }
}

/// Makes `<target>.partial-<pid>`, with a number appended if a dead process of the same id has left one.
fn create_fresh(target: &Path) -> Result<PathBuf, ResultsError> {
    let process = std::process::id();
    let mut attempt = 0_u32;
    loop {
        let suffix =
            if attempt == 0 { format!("{PARTIAL}-{process}") } else { format!("{PARTIAL}-{process}-{attempt}") };
        let path = with_suffix(target, &suffix);
        match fs::create_dir(&path) {
            Ok(()) => return Ok(path),
            Err(error) if error.kind() == ErrorKind::AlreadyExists && attempt < 1000 => attempt += 1,
            Err(source) => return Err(ResultsError::Create { path, source }),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::path::Path;
    use std::process::Command;

    use super::super::npy::{ArrayRow, NpyWriter};
    use super::super::summary::tests::example;
    use super::*;
    use crate::results::files::ResultFiles as _;

    /// Names in a folder, sorted.
    pub(in crate::results) fn names(folder: &Path) -> Vec<String> {
        let mut names = entries(folder).unwrap();
        names.sort();
        names
    }

    #[test]
    fn nothing_stands_under_the_final_name_before_the_end() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("deep/er/run");
        let folder = ResultsFolder::create(&target).unwrap();
        folder.write_text("spectra.csv", "a,b\n").unwrap();
        assert!(!target.exists());
        assert_eq!(folder.finish(example()).unwrap(), target);
        assert_eq!(names(&target), ["spectra.csv", "summary.json"]);
        assert_eq!(names(target.parent().unwrap()), ["run"], "nothing else is left");
        let summary: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(target.join("summary.json")).unwrap()).unwrap();
        assert_eq!(summary["complete"], serde_json::json!(true));
        assert_eq!(summary["files"], serde_json::json!(["spectra.csv", "summary.json"]));
    }

    #[test]
    fn a_failed_run_leaves_no_trace() {
        let place = tempfile::tempdir().unwrap();
        let folder = ResultsFolder::create(&place.path().join("results/run")).unwrap();
        folder.write_text("time.npy", "half").unwrap();
        drop(folder);
        assert!(names(place.path()).is_empty(), "parents that were made for it go, too");
    }

    #[test]
    fn a_failed_run_leaves_the_older_results_alone() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("run");
        let folder = ResultsFolder::create(&target).unwrap();
        folder.write_text("old", "old").unwrap();
        folder.finish(example()).unwrap();
        drop(ResultsFolder::create(&target).unwrap());
        assert_eq!(names(&target), ["old", "summary.json"]);
    }

    #[test]
    fn older_results_are_replaced_and_an_empty_folder_is_taken() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("run");
        fs::create_dir(&target).unwrap();
        for name in ["first", "second"] {
            let folder = ResultsFolder::create(&target).unwrap();
            folder.write_text(name, "").unwrap();
            folder.finish(example()).unwrap();
            assert_eq!(names(&target), [name, "summary.json"]);
        }
        assert_eq!(names(place.path()), ["run"]);
    }

    #[test]
    fn what_is_not_ours_is_refused_and_untouched() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("thesis");
        fs::create_dir(&target).unwrap();
        for summary in
            [None, Some("{}"), Some("not json"), Some(r#"{"format": "something else", "files": ["chapter.tex"]}"#)]
        {
            fs::write(target.join("chapter.tex"), "ten years of work").unwrap();
            if let Some(text) = summary {
                fs::write(target.join("summary.json"), text).unwrap();
            }
            assert!(matches!(ResultsFolder::create(&target), Err(ResultsError::NotOurs { .. })), "{summary:?}");
        }
        let file = place.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(matches!(ResultsFolder::create(&file), Err(ResultsError::NotOurs { .. })));
        assert_eq!(names(place.path()), ["file", "thesis"]);
        assert!(matches!(ResultsFolder::create(Path::new("/")), Err(ResultsError::NoFolderName { .. })));
    }

    #[test]
    fn a_results_folder_with_a_users_notes_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("run");
        ResultsFolder::create(&target).unwrap().finish(example()).unwrap();
        let second = ResultsFolder::create(&target).unwrap();
        fs::write(target.join("notes.txt"), "precious").unwrap();
        let error = second.finish(example()).unwrap_err();
        assert!(matches!(error, ResultsError::Overtaken(_)) && error.to_string().contains("notes.txt"), "{error}");
        assert!(ResultsFolder::create(&target).is_err());
        assert_eq!(names(&target), ["notes.txt", "summary.json"]);
        assert_eq!(names(place.path()), ["run"], "the refused results are gone");
    }

    #[cfg(unix)]
    #[test]
    fn an_unfinished_run_with_a_link_in_it_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("run");
        let victim = place.path().join("thesis.tex");
        fs::write(&victim, "ten years of work").unwrap();
        let working = place.path().join("run.partial");
        fs::create_dir(&working).unwrap();
        fs::write(working.join(super::super::checkpoint::CHECKPOINT_FILE), "").unwrap();
        for name in [LOCK_FILE, "time.npy"] {
            std::os::unix::fs::symlink(&victim, working.join(name)).unwrap();
            let error = ResultsFolder::reopen(&target).err().unwrap().to_string();
            assert!(error.contains("run.partial") && error.contains(&format!("{name} in it is a link")), "{error}");
            fs::remove_file(working.join(name)).unwrap();
        }
        assert_eq!(fs::read_to_string(victim).unwrap(), "ten years of work");
        assert!(ResultsFolder::reopen(&target).is_ok());
    }

    #[test]
    fn an_interrupted_run_is_named_as_such() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("run");
        for rows in [3_u32, 2] {
            let folder = ResultsFolder::create(&target).unwrap();
            let mut time = NpyWriter::<f64>::create(&folder.path("time.npy"), ArrayRow::Scalar).unwrap();
            for row in 0..rows {
                time.push(&[f64::from(row)]).unwrap();
            }
            time.finish().unwrap();
            let partial = folder.finish_partial(example()).unwrap();
            assert_eq!(partial, place.path().join("run.partial"));
            assert_eq!(names(place.path()), ["run.partial"]);
            let summary = fs::read_to_string(partial.join("summary.json")).unwrap();
            assert!(summary.contains("\"complete\": false"), "{summary}");
            let npy = npyz::NpyFile::new(File::open(partial.join("time.npy")).unwrap()).unwrap();
            assert_eq!(npy.shape(), [u64::from(rows)]);
        }
    }

    /// An unfinished run with a checkpoint, as a process that was killed leaves it.
    fn killed(target: &Path) -> PathBuf {
        let mut folder = ResultsFolder::create(target).unwrap();
        folder.write_text("time.npy", "half").unwrap();
        super::super::checkpoint::write(folder.working(), &"state").unwrap();
        folder.keep_if_stopped();
        let working = folder.working().to_owned();
        drop(folder);
        working
    }

    #[test]
    fn a_killed_run_is_found_and_finished_without_a_trace() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("run");
        assert!(matches!(ResultsFolder::reopen(&target), Err(CheckpointError::Nothing { .. })));
        let working = killed(&target);
        for name in [&target, &working] {
            let again = ResultsFolder::reopen(name).unwrap();
            assert_eq!((again.working(), again.target()), (working.as_path(), target.as_path()));
            // A second process is locked out, and so is an interrupted run that is to be given that name.
            assert!(matches!(ResultsFolder::reopen(&target), Err(CheckpointError::Running { .. })));
        }
        let again = ResultsFolder::reopen(&target).unwrap();
        let partial = again.finish_partial(example()).unwrap();
        assert_eq!(
            (partial.as_path(), names(place.path())),
            (place.path().join("run.partial").as_path(), vec!["run.partial".into()])
        );
        assert_eq!(names(&partial), ["checkpoint", "summary.json", "time.npy"]);
        let last = ResultsFolder::reopen(&target).unwrap();
        assert_eq!(last.finish(example()).unwrap(), target);
        assert_eq!(names(place.path()), ["run"]);
        assert_eq!(names(&target), ["summary.json", "time.npy"]);
        assert!(matches!(ResultsFolder::reopen(&target), Err(CheckpointError::Complete { .. })));
    }

    #[test]
    fn an_interrupted_run_leaves_one_that_is_being_resumed_alone() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("run");
        killed(&target);
        let resumed = ResultsFolder::reopen(&target).unwrap().finish_partial(example()).unwrap();
        let resumed = ResultsFolder::reopen(&resumed).unwrap();
        let other = killed(&target);
        let both = ResultsFolder::reopen(&target).unwrap_err();
        assert!(matches!(&both, CheckpointError::Several { found } if found.len() == 2), "{both}");
        let partial = ResultsFolder::reopen(&other).unwrap().finish_partial(example()).unwrap();
        assert_eq!(partial, other, "the name run.partial is taken");
        resumed.finish(example()).unwrap();
        assert!(names(&target).contains(&"time.npy".to_owned()));
    }

    #[test]
    fn two_runs_at_once_do_not_share_a_folder() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("run");
        let (one, two) = (ResultsFolder::create(&target).unwrap(), ResultsFolder::create(&target).unwrap());
        assert_ne!(one.path("x"), two.path("x"));
        one.finish(example()).unwrap();
        two.finish(example()).unwrap();
        assert_eq!(names(place.path()), ["run"]);
    }

    #[test]
    fn an_unwritable_place_is_named() {
        let error = ResultsFolder::create(Path::new("/proc/tyrewave/run")).unwrap_err();
        assert!(matches!(error, ResultsError::Create { .. }), "{error}");
        assert!(error.to_string().contains("/proc/tyrewave"), "{error}");
        let place = tempfile::tempdir().unwrap();
        fs::write(place.path().join("file"), "").unwrap();
        assert!(ResultsFolder::create(&place.path().join("file/run")).is_err());
        assert_eq!(names(place.path()), ["file"]);
    }

    #[test]
    fn a_full_disk_leaves_nothing() {
        let place = tempfile::tempdir().unwrap();
        let disk = place.path().join("disk");
        fs::create_dir(&disk).unwrap();
        let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"]).arg(&disk).output();
        if !mount.is_ok_and(|output| output.status.success()) {
            println!("skipped: may not mount a small file system here");
            return;
        }
        let outcome = (|| {
            let folder = ResultsFolder::create(&disk.join("run"))?;
            let mut force = NpyWriter::<f64>::create(&folder.path("patch_force.npy"), ArrayRow::Columns(72))?;
            for _ in 0..1000 {
                force.push(&[1.0; 72])?;
            }
            force.finish()?;
            folder.finish(example())
        })();
        let remaining = names(&disk);
        assert!(Command::new("umount").arg(&disk).status().unwrap().success());
        let error = outcome.unwrap_err();
        assert!(
            matches!(&error, ResultsError::Write { source, .. } if source.kind() == ErrorKind::StorageFull),
            "{error}"
        );
        assert!(error.to_string().contains("patch_force.npy"), "{error}");
        assert!(remaining.is_empty(), "{remaining:?}");
    }
}
