//! Processes of a run, and what they have in shared memory.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::harness::{descendants, is_alive};

/// Living processes whose command line names the folder.
pub(super) fn processes(home: &Path) -> Vec<u32> {
    let named = format!("{}/", home.display());
    let own = std::process::id();
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let pids = entries.filter_map(|entry| entry.file_name().to_str()?.parse::<u32>().ok());
    let of_run = |pid: &u32| *pid != own && command_line(*pid).contains(&named) && is_alive(*pid);
    pids.filter(of_run).collect()
}

fn command_line(pid: u32) -> String {
    let bytes = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The solver of a role that `parent`, or what it started, has started for a run; one that only checks the
/// scene has gone before a signal reaches it.
pub(super) fn solver_of(parent: u32, role: &str) -> Option<u32> {
    let program = format!("bedload-{role}");
    let is_solver = |pid: &u32| {
        let line = command_line(*pid);
        let mut words = line.split('\0');
        words.next().is_some_and(|word| word.ends_with(&program))
            && words.next().is_some_and(|word| word != "check")
            && is_alive(*pid)
    };
    descendants(parent).into_iter().find(is_solver)
}

/// What a run has in shared memory: its folder, and the prefix of its segments.
#[derive(Debug, Default)]
pub(super) struct Traces {
    roots: BTreeSet<PathBuf>,
}

impl Traces {
    /// Of processes that live: the lock that each of them holds lies in the run's folder.
    pub(super) fn of(family: &BTreeSet<u32>) -> Self {
        let mut roots = BTreeSet::new();
        for pid in family {
            let files = std::fs::read_dir(format!("/proc/{pid}/fd")).into_iter().flatten().flatten();
            for path in files.filter_map(|file| std::fs::read_link(file.path()).ok()) {
                let in_memory = path.starts_with("/dev/shm") && path.ends_with("run.lock");
                roots.extend(in_memory.then(|| path.parent().map(Path::to_owned)).flatten());
            }
        }
        Self { roots }
    }

    /// What of it is still there.
    pub(super) fn left(&self) -> Vec<PathBuf> {
        let mut left: Vec<PathBuf> = self.roots.iter().filter(|root| root.exists()).cloned().collect();
        let prefixes: Vec<String> = self
            .roots
            .iter()
            .filter_map(|root| Some(format!("bl{}_", root.file_name()?.to_str()?)))
            .collect();
        let segments =
            std::fs::read_dir("/dev/shm").into_iter().flatten().flatten().map(|entry| entry.path());
        let of_run = |path: &PathBuf| {
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            prefixes.iter().any(|prefix| name.starts_with(prefix))
        };
        left.extend(segments.filter(of_run));
        left
    }
}
