//! Pictures of the grains of a run, as one SVG file.

use std::path::{Path, PathBuf};

use super::ValidateError;
use super::case::{Case, Pictures};
use super::runs::Outcome;
use crate::study::report::sheet::sheet;
use crate::study::report::snapshot::{Snapshot, files};

/// The sheet, or nothing if the run was not made or left no grains. `runs` is the folder of the runs'
/// output folders.
pub(super) fn draw(
    case: &Case,
    wanted: &Pictures,
    outcomes: &[Outcome],
    runs: &Path,
) -> Result<Option<String>, ValidateError> {
    let mut made = case.runs.iter().zip(outcomes);
    if !made.any(|(run, outcome)| run.label == wanted.run && matches!(outcome, Outcome::Done(_))) {
        return Ok(None);
    }
    let fields = runs.join(&wanted.run).join("fields");
    let all = files(&fields);
    let chosen = match &wanted.files {
        None => all,
        Some(places) => places.iter().map(|place| chosen(&all, *place, &fields)).collect::<Result<_, _>>()?,
    };
    let read = |path: &PathBuf| {
        Snapshot::read(path).map_err(|what| ValidateError::Case { path: path.clone(), what })
    };
    let snapshots: Vec<Snapshot> = chosen.iter().map(read).collect::<Result<_, _>>()?;
    Ok(sheet(&snapshots))
}

fn chosen(all: &[PathBuf], place: usize, fields: &Path) -> Result<PathBuf, ValidateError> {
    all.get(place).cloned().ok_or_else(|| ValidateError::Case {
        path: fields.to_owned(),
        what: format!("has {} files of grains, and the pictures ask for number {place} from 0", all.len()),
    })
}
