//! The checkpoints of a run: a folder for each, named by its step. One is whole when the file that is written
//! last is there, so that a run that is killed while it writes one still has the one before.

use std::path::{Path, PathBuf};

use crate::checkpoint;

/// Role of the file of a checkpoint that is written last, and makes it whole: that of the run loop.
pub const LAST: &str = "loop";

/// Newest whole checkpoint in `parent`, the folder `checkpoint` of a run.
pub fn newest(parent: &Path) -> Option<PathBuf> {
    let mut found = folders(parent);
    found.retain(|(_, path)| checkpoint::path(path, LAST).is_file());
    found.sort();
    found.pop().map(|(_, path)| path)
}

/// Folder of the newest whole checkpoint of a run, alone or coupled, in its output folder `out`; where it
/// left none, the folder in which it would lie.
pub fn newest_of_run(out: &Path) -> PathBuf {
    let parent = out.join("checkpoint");
    newest(&parent).unwrap_or(parent)
}

/// File that says of a checkpoint that a log begins there: without it that log drives no solver.
const BEGINS_LOG: &str = "begins-log";

/// Keeps a checkpoint as long as the run is there, as a log begins at it.
///
/// # Errors
/// Of the system.
pub fn keep(folder: &Path) -> std::io::Result<()> {
    std::fs::write(folder.join(BEGINS_LOG), [])
}

/// Removes the checkpoints in `parent` but for `newest` and those that are kept; without a newest one, all. A
/// leftover costs room on the disk, nothing else: the newest whole one counts.
pub fn remove_others(parent: &Path, newest: Option<&Path>) {
    for (_, path) in folders(parent) {
        let kept = newest.is_some_and(|newest| newest == path || path.join(BEGINS_LOG).exists());
        if !kept {
            let _ = std::fs::remove_dir_all(path);
        }
    }
}

/// Step of a checkpoint, by the name of its folder.
pub fn step_of(folder: &Path) -> Option<u64> {
    let name = folder.file_name()?.to_str()?;
    (name.len() == 10).then(|| name.parse().ok())?
}

/// Folders named by a step.
fn folders(parent: &Path) -> Vec<(u64, PathBuf)> {
    let Ok(entries) = std::fs::read_dir(parent) else { return Vec::new() };
    let paths = entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir());
    paths.filter_map(|path| step_of(&path).map(|step| (step, path))).collect()
}
