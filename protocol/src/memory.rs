//! Memory that this process has taken, and that it may still take: of the machine and of every
//! control group that it is in.

use std::path::{Path, PathBuf};

/// What there is, and who says so.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Available {
    /// Bytes.
    pub bytes: u64,
    /// The file that sets this limit.
    pub source: String,
}

/// The smallest of what the machine and the control groups can still give; none where no system tells.
pub fn available() -> Option<Available> {
    below(Path::new("/"))
}

/// [`available`] with `root` in place of `/`.
fn below(root: &Path) -> Option<Available> {
    let machine = machine(root);
    let groups = groups(root);
    machine.into_iter().chain(groups).min_by_key(|available| available.bytes)
}

/// `MemAvailable`: free memory, and what the system can reclaim without swapping.
fn machine(root: &Path) -> Option<Available> {
    let bytes = told_in(&root.join("proc/meminfo"), "MemAvailable:")?;
    Some(Available { bytes, source: "MemAvailable of /proc/meminfo".into() })
}

/// Bytes that a file of the system tells in kB behind `name`.
fn told_in(file: &Path, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// What each control group of this process, and each above it, still allows (versions 1 and 2).
fn groups(root: &Path) -> Vec<Available> {
    let text = std::fs::read_to_string(root.join("proc/self/cgroup")).unwrap_or_default();
    let of_line = |line: &str| -> Vec<Available> {
        let parts = line.split_once(':').and_then(|(_, rest)| rest.split_once(':'));
        let Some((controllers, path)) = parts else { return Vec::new() };
        let (mount, [limit, usage, cache]) = match controllers {
            "" => ("sys/fs/cgroup", ["memory.max", "memory.current", "inactive_file "]),
            v1 if v1.split(',').any(|name| name == "memory") => (
                "sys/fs/cgroup/memory",
                ["memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file "],
            ),
            _ => return Vec::new(),
        };
        let group = PathBuf::from(path.trim_start_matches('/'));
        // In a container its own group is mounted as the root, whatever the path says.
        let above = group.ancestors().map(|group| Path::new(mount).join(group));
        above.filter_map(|group| left(root, &group, limit, usage, cache)).collect()
    };
    text.lines().flat_map(of_line).collect()
}

/// Limit less usage, file caches that can go at once not counted as used.
fn left(root: &Path, group: &Path, limit: &str, usage: &str, cache: &str) -> Option<Available> {
    let read = |name: &str| std::fs::read_to_string(root.join(group).join(name)).ok();
    let number = |name: &str| read(name)?.trim().parse::<u64>().ok();
    // "max", or the largest number of pages: no limit.
    let most = number(limit).filter(|bytes| *bytes < 1 << 62)?;
    let statistics = read("memory.stat").unwrap_or_default();
    let cached = statistics.lines().find_map(|line| line.strip_prefix(cache)?.trim().parse().ok());
    let used = number(usage)?.saturating_sub(cached.unwrap_or(0));
    Some(Available {
        bytes: most.saturating_sub(used),
        source: format!("{limit} of the control group /{}", group.display()),
    })
}

/// Peak resident memory of this process, bytes; 0 where the system does not tell.
pub fn peak_rss_bytes() -> u64 {
    told_in(Path::new("/proc/self/status"), "VmHWM:").unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A root with files.
    fn root(name: &str, files: &[(&str, &str)]) -> PathBuf {
        let root = std::env::temp_dir().join(format!("bedload-memory-{name}-{}", std::process::id()));
        for (file, text) in files {
            let path = root.join(file);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
            std::fs::write(path, text).expect("written");
        }
        root
    }

    const MACHINE: (&str, &str) = ("proc/meminfo", "MemTotal: 4096 kB\nMemAvailable:    2048 kB\n");

    #[test]
    fn the_machine_alone() {
        let root = root("machine", &[MACHINE]);
        let available = below(&root).expect("told");
        assert_eq!(available.bytes, 2048 * 1024);
        assert!(available.source.contains("MemAvailable"));
        std::fs::remove_dir_all(root).expect("removed");
    }

    #[test]
    fn a_group_above_of_version_2() {
        let group = "sys/fs/cgroup/user/";
        let limit = [group, "memory.max"].concat();
        let usage = [group, "memory.current"].concat();
        let cache = [group, "memory.stat"].concat();
        let own = [group, "job/memory.max"].concat();
        let files = [
            MACHINE,
            ("proc/self/cgroup", "0::/user/job\n"),
            (&own, "max\n"),
            (&limit, "1000000\n"),
            (&usage, "700000\n"),
            (&cache, "anon 5\ninactive_file 100000\n"),
        ];
        let root = root("two", &files);
        let available = below(&root).expect("told");
        assert_eq!(available.bytes, 400_000);
        assert!(available.source.contains("memory.max") && available.source.contains("/user"));
        std::fs::remove_dir_all(root).expect("removed");
    }

    #[test]
    fn a_group_of_version_1_and_one_without_limit() {
        let files = [
            MACHINE,
            ("proc/self/cgroup", "5:cpu:/\n4:memory:/job\n"),
            ("sys/fs/cgroup/memory/job/memory.limit_in_bytes", "500000"),
            ("sys/fs/cgroup/memory/job/memory.usage_in_bytes", "600000"),
            ("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712"),
            ("sys/fs/cgroup/memory/memory.usage_in_bytes", "0"),
        ];
        let root = root("one", &files);
        assert_eq!(below(&root).expect("told").bytes, 0, "it may use less than it does already");
        std::fs::remove_dir_all(root).expect("removed");
    }

    #[test]
    fn nobody_tells() {
        assert_eq!(below(Path::new("/nowhere/at/all")), None);
    }
}
