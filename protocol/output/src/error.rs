//! Why the output could not be written or read.

use std::path::{Path, PathBuf};

use protocol::participant::SolverError;

/// Why the output could not be written or read.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum OutputError {
    /// The system refused.
    #[error("cannot {action} {}: {source}", path.display())]
    File { action: &'static str, path: PathBuf, source: std::io::Error },
    /// The place takes no folder.
    #[error("cannot make the output folder {}: {source}; name another with --out", path.display())]
    Place { path: PathBuf, source: std::io::Error },
    /// The folder holds something else.
    #[error(
        "{} is not empty and not an output folder of Bedload (its scene.toml does not begin with \
         `{marker}`): nothing was changed; name an empty or new folder with --out",
        path.display()
    )]
    Foreign { path: PathBuf, marker: &'static str },
    /// Another process writes there.
    #[error("{} is in use by another process of Bedload: nothing was changed; wait until it ends, or name another \
             folder with --out", .0.display())]
    InUse(PathBuf),
    /// A finished run lies there.
    #[error("{} holds a finished run: nothing was changed; name another folder with --out, or replace the run with \
             --overwrite", .0.display())]
    Finished(PathBuf),
    /// A run lies there that can go on.
    #[error("{} holds a run that was interrupted: nothing was changed; go on with --resume, replace it with \
             --overwrite, or name another folder with --out", .0.display())]
    Begun(PathBuf),
    /// The scene needs what lies there.
    #[error("{} holds what the scene reads ({key} = {:?}): nothing was changed; name another folder with \
        --out", path.display(), needed.display().to_string())]
    Needed { path: PathBuf, key: &'static str, needed: PathBuf },
    /// A link stands where a folder should.
    #[error("{} is a symbolic link, which is not followed: nothing was changed; remove it, or name another folder with \
             --out", .0.display())]
    Link(PathBuf),
    /// A name would lead out of the folder.
    #[error("{name:?} is no name of a file in {}: nothing was written; allowed: {}; give another \
        name", folder.display(), bedload_scene::FILE_NAME)]
    Outside { folder: PathBuf, name: String },
    /// A file went away under the run.
    #[error("{} was removed, or another put in its place, while the run wrote it: nothing \
             more was written; start the run again, and leave its folder alone", .0.display())]
    Gone(PathBuf),
    /// The folder is no run's.
    #[error("{} is no output folder of a run: name one", .0.display())]
    NoRun(PathBuf),
    /// The run has not ended.
    #[error("{} has no summary.json yet, as the run is under way or was cut off: wait for its end, or go on with it \
             by --resume", .0.display())]
    NotEnded(PathBuf),
    /// There is nothing to resume.
    #[error("{} holds no run to resume: leave out --resume, or name the folder of the run with --out", .0.display())]
    NothingToResume(PathBuf),
    /// The scene asks for something that the run cannot observe.
    #[error(transparent)]
    Scene(#[from] Box<bedload_scene::SceneError>),
    /// A file does not hold what it should.
    #[error("{}: {what}", path.display())]
    Content { path: PathBuf, what: String },
}

impl From<OutputError> for SolverError {
    fn from(error: OutputError) -> Self {
        match error {
            OutputError::File { path, source, .. } => Self::File { path: path.display().to_string(), source },
            other => Self::Failed(other.to_string()),
        }
    }
}

impl OutputError {
    /// Was there no room for what was to be written?
    pub fn is_full(&self) -> bool {
        matches!(self, Self::File { source, .. } | Self::Place { source, .. } if protocol::new_file::is_full(source))
    }

    /// Wraps an error of the system.
    pub fn file(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File { action, path, source }
    }
}
