//! `bedload export`: where a run's files for viewers are. Runs write them as they go, so nothing is
//! converted; for ParaView there is a script that opens them.

use std::path::{Path, PathBuf};

use bedload_output::{OutputFolder, atomic_write};
use clap::Args;

use crate::failure::Failure;

/// The viewer that files are for, one of these.
#[derive(Clone, Copy, Debug, Args)]
#[group(required = true, multiple = false)]
pub struct Viewer {
    /// Fields for ParaView
    #[arg(long)]
    vtk: bool,
    /// A script that opens them in ParaView, with grains as spheres: paraview --script=FILE, or pvbatch FILE
    /// PICTURE.png
    #[arg(long)]
    paraview: bool,
    /// Tables
    #[arg(long)]
    csv: bool,
    /// The log, with channels for Foxglove, Lichtblick and Rerun
    #[arg(long)]
    foxglove: bool,
}

/// Prints the files of a run for `viewer`.
///
/// # Errors
/// [`Failure::Input`] if the folder is no run or has none of these files, with how to get them.
pub fn export(folder: &Path, viewer: Viewer) -> Result<(), Failure> {
    let folder = OutputFolder::open(folder)?;
    let of_log =
        "a fluid alone without grains exchanges nothing and has no log; others have one without --no-record";
    let of_fields = "ask for them with [observe] fields_at or fields_every, and run again";
    let (files, remedy) = match viewer {
        Viewer { vtk: true, .. } => (fields(&folder), of_fields),
        Viewer { paraview: true, .. } if fields(&folder).is_empty() => (Vec::new(), of_fields),
        Viewer { paraview: true, .. } => (vec![script(&folder)?], of_fields),
        Viewer { csv: true, .. } => {
            let tables = [folder.series(), folder.planes(), folder.profile(), folder.grains()];
            (existing(tables), "the run was killed before its first row")
        }
        // A resume begins a new part.
        _ => (existing((1..folder.next_log_part()).map(|part| folder.log_part(part))), of_log),
    };
    if files.is_empty() {
        return Err(Failure::Input(format!("{} holds no such files: {remedy}", folder.root().display())));
    }
    for file in files {
        println!("{}", file.display());
    }
    Ok(())
}

/// Writes `open_fields.py` into the output folder, which finds the fields by their place.
fn script(folder: &OutputFolder) -> Result<PathBuf, Failure> {
    let path = folder.root().join("open_fields.py");
    let root = std::path::absolute(folder.root()).unwrap_or_else(|_| folder.root().to_owned());
    // A string of JSON is one of Python.
    let text = include_str!("open_fields.py")
        .replace("\"FOLDER\"", &serde_json::json!(root.to_string_lossy()).to_string());
    atomic_write(&path, text.as_bytes())?;
    Ok(path)
}

fn existing(paths: impl IntoIterator<Item = PathBuf>) -> Vec<PathBuf> {
    paths.into_iter().filter(|path| path.is_file()).collect()
}

fn fields(folder: &OutputFolder) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder.fields()).into_iter().flatten().flatten();
    let is_field = |path: &PathBuf| {
        path.extension()
            .and_then(|end| end.to_str())
            .is_some_and(|end| end.starts_with("vt") || ["pvd", "pvtr"].contains(&end))
    };
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(is_field).collect();
    files.sort();
    files
}
