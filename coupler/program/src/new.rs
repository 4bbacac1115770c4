//! `bedload new`: a folder with a commented scene to start from, and the commands that come next.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use coupler::failure::Failure;
use protocol::loudness::is_quiet;
use protocol::new_file::is_full;

/// How the commands of a template begin, in the comment at its head.
const COMMAND: &str = "#   bedload ";

/// `--like`.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Like {
    /// A sphere falls in oil; r–z
    Falling,
    /// A bead falls in oil and bounces; r–z
    Bounce,
    /// A bed of 300 discs under a lid that moves; plane
    Bed,
    /// A column of 150 discs collapses in oil; plane
    Column,
    /// 800 beads are poured into a silo, dry; space
    Silo,
    /// A disc migrates in a shear flow; plane
    Couette,
    /// 41 spheres in a shear flow; space
    Suspension,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct New {
    /// Folder to make
    name: PathBuf,
    /// What the scene is like
    #[arg(long, value_name = "KIND")]
    like: Like,
}

/// Names and texts of the files of a template; the commands stand at the head of the first.
macro_rules! files {
    ($folder:literal: $($name:literal),+) => {
        &[$(($name, include_str!(concat!("templates/", $folder, "/", $name)))),+]
    };
}

impl Like {
    fn files(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Falling => files!("falling": "falling.toml"),
            Self::Bounce => files!("bounce": "bounce.toml"),
            Self::Bed => files!("bed": "settle.toml", "shear.toml"),
            Self::Column => files!("column": "fill.toml", "collapse.toml"),
            Self::Silo => files!("silo": "silo.toml"),
            Self::Couette => files!("couette": "couette.toml"),
            Self::Suspension => files!("suspension": "shear.toml"),
        }
    }
}

/// Makes the folder, and prints its files and the next commands. Fails with [`Failure::Input`] if there is
/// something of that name, or if the folder cannot be made.
pub(crate) fn new(asked: &New) -> Result<(), Failure> {
    let folder = &asked.name;
    let files = asked.like.files();
    make(folder)?;
    let mut said = String::new();
    for (name, text) in files {
        let path = folder.join(name);
        std::fs::write(&path, text).map_err(|error| cannot(&path, &error))?;
        let _ = writeln!(said, "{}", path.display());
    }
    let _ = writeln!(said, "\nnext:\n  cd {}", quoted(&folder.display().to_string()));
    for command in files[0].1.lines().filter(|line| line.starts_with(COMMAND)) {
        let _ = writeln!(said, "  {}", command.trim_start_matches("#   "));
    }
    let said = if is_quiet() { folder.display().to_string() } else { said };
    protocol::show!("{}", said.trim_end());
    Ok(())
}

/// A new folder; one that is there is never touched.
fn make(folder: &Path) -> Result<(), Failure> {
    let parents = folder.parent().map_or(Ok(()), std::fs::create_dir_all);
    parents.and_then(|()| std::fs::create_dir(folder)).map_err(|error| cannot(folder, &error))
}

fn cannot(path: &Path, error: &std::io::Error) -> Failure {
    let remedy = match error.kind() {
        std::io::ErrorKind::AlreadyExists => "nothing is overwritten: choose another name",
        _ => "name a folder that can be made and written",
    };
    let what = format!("{}: cannot make it: {error}; remedy: {remedy}", path.display());
    if is_full(error) { Failure::Full(what) } else { Failure::Input(what) }
}

/// One word of a shell.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+".contains(c);
    if word.chars().all(plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}
