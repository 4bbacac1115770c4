//! Pictures of the grains of a run, as one SVG file.

use std::path::{Path, PathBuf};

use super::case::{Case, Pictures};
use super::runs::Outcome;
use crate::failure::Failure;
use crate::study::folder::{content, files};
use crate::study::grain_pictures;
use crate::study::snapshot::Snapshot;

/// The pictures, or nothing if the run was not made or left no grains. `runs` is the folder of the runs'
/// output folders.
pub(super) fn draw(
    case: &Case,
    wanted: &Pictures,
    outcomes: &[Outcome],
    runs: &Path,
) -> Result<Option<String>, Failure> {
    let mut made = case.runs.iter().zip(outcomes);
    if !made.any(|(run, outcome)| run.label == wanted.run && matches!(outcome, Outcome::Done(_))) {
        return Ok(None);
    }
    let fields = runs.join(&wanted.run).join("fields");
    let all = files(&fields, "grains_", ".vtp");
    let chosen = match &wanted.files {
        None => all,
        Some(places) => places.iter().map(|place| chosen(&all, *place, &fields)).collect::<Result<_, _>>()?,
    };
    let read = |path: &PathBuf| Snapshot::read(path).map_err(content(path));
    let snapshots: Vec<Snapshot> = chosen.iter().map(read).collect::<Result<_, _>>()?;
    Ok(grain_pictures::draw(&snapshots))
}

fn chosen(all: &[PathBuf], place: usize, fields: &Path) -> Result<PathBuf, Failure> {
    all.get(place).cloned().ok_or_else(|| {
        let there = all.len();
        content(fields)(format!(
            "has {there} files of grains, and the pictures ask for number {place} from 0"
        ))
    })
}
