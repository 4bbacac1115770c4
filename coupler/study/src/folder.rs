//! The files of a study's folder.

use std::io;
use std::path::{Path, PathBuf};

use bedload_output::{Claim, atomic_write, points};
use bedload_scene::SceneSource;

use coupler::failure::Failure;
use protocol::new_file::is_full;

/// The file of the study, beside the table.
pub(super) const SCENE: &str = "scene.toml";

pub(super) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// First line of that file.
const MARKER: &str = "# A study by Bedload, of";

/// Makes and claims the folder, and leaves the scene in it. What holds files of others is left alone.
pub(super) fn open(folder: &Path, scene: &SceneSource) -> Result<Claim, Failure> {
    not_of_a_run(folder)?;
    let file = folder.join(SCENE);
    // a name with a line break would end the comment
    let name = scene.file.replace(['\n', '\r'], " ");
    if std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some()) {
        let there = read(&file).unwrap_or_default();
        let there = there.lines().next().and_then(|line| line.strip_prefix(MARKER)).map(str::trim);
        let base = |name| Path::new(name).file_name();
        let what = match there {
            None => Some("is not empty, and no folder of a study by Bedload".to_owned()),
            Some(other) if base(other) == base(name.trim()) => None,
            Some(other) => Some(format!("is the folder of another study, of {other}")),
        };
        if let Some(what) = what {
            let (folder, remedy) = (folder.display(), "nothing was changed; name another with --out");
            return Err(Failure::Input(format!("{folder} {what}: {remedy}")));
        }
    }
    make(folder)?;
    let claim = Claim::of(folder)?;
    let text = format!("{MARKER} {name}\n{}", scene.text_for_any_folder());
    atomic_write(&file, text.as_bytes())?;
    Ok(claim)
}

pub(super) fn not_of_a_run(folder: &Path) -> Result<(), Failure> {
    if folder.join("summary.json").exists() {
        return Err(content(folder)("is the output folder of a run; name another with --out".to_owned()));
    }
    Ok(())
}

/// Makes a folder and those above it.
pub(super) fn make(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(cannot("make", folder))
}

/// Removes a file, if it is there.
pub(super) fn remove(path: &Path) -> Result<(), Failure> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(cannot("remove", path)(error)),
        _ => Ok(()),
    }
}

pub(super) fn read(path: &Path) -> Result<String, Failure> {
    protocol::input_file::read_text(path).map_err(cannot("read", path))
}

/// Two columns of a CSV file.
pub(super) fn columns(path: &Path, x: &str, y: &str) -> Result<Vec<(f64, f64)>, Failure> {
    points(&read(path)?, x, y).map_err(content(path))
}

/// An error of the system at a path.
pub(super) fn cannot(action: &str, path: &Path) -> impl FnOnce(io::Error) -> Failure {
    move |error| {
        let what = format!("cannot {action} {}: {error}", path.display());
        if is_full(&error) { Failure::Full(what) } else { Failure::Input(what) }
    }
}

/// A file that does not hold what it should.
pub(super) fn content(path: &Path) -> impl FnOnce(String) -> Failure {
    move |what| Failure::Input(format!("{}: {what}", path.display()))
}

/// Files in a folder whose names begin and end so, by name; none where there is no folder.
pub(super) fn files(folder: &Path, begin: &str, end: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let ours = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or("");
        name.starts_with(begin) && name.ends_with(end)
    };
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(ours).collect();
    files.sort();
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_study_takes_its_own_folder_or_an_empty_one() {
        let root = std::env::temp_dir().join(format!("bedload-study-folder-{}", std::process::id()));
        let scene = SceneSource { file: "bed.toml".into(), text: "until = 1.0\n".into() };
        open(&root, &scene).map(drop).expect("a new one");
        open(&root, &scene).map(drop).expect("its own");
        std::fs::write(root.join("summary.json"), "{}").unwrap();
        assert!(open(&root, &scene).unwrap_err().to_string().contains("output folder of a run"));
        std::fs::remove_file(root.join("summary.json")).unwrap();
        std::fs::write(root.join(SCENE), &scene.text).unwrap();
        assert!(open(&root, &scene).unwrap_err().to_string().contains("nothing was changed"));
        assert_eq!(read(&root.join(SCENE)).unwrap(), scene.text);
        std::fs::remove_dir_all(&root).unwrap();
    }
}
