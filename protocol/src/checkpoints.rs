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

/// Removes the checkpoints in `parent` but for `kept`. A leftover costs room on the disk, nothing else: the
/// newest whole one counts.
pub fn remove_others(parent: &Path, kept: Option<&Path>) {
    for (_, path) in folders(parent).into_iter().filter(|(_, path)| Some(path.as_path()) != kept) {
        let _ = std::fs::remove_dir_all(path);
    }
}

/// Folders named by a step.
fn folders(parent: &Path) -> Vec<(u64, PathBuf)> {
    let Ok(entries) = std::fs::read_dir(parent) else { return Vec::new() };
    let step_of = |path: &Path| -> Option<u64> {
        let name = path.file_name()?.to_str()?;
        (name.len() == 10 && path.is_dir()).then(|| name.parse().ok())?
    };
    entries.flatten().filter_map(|entry| step_of(&entry.path()).map(|step| (step, entry.path()))).collect()
}
