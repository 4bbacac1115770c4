//! Pictures of the grains of a run, as one SVG file.

use std::path::{Path, PathBuf};

use crate::folder::{content, files};
use crate::make::Made;
use crate::pictures::sheet_of_grains;
use crate::section::Pictures;
use coupler::failure::Failure;

/// The pictures, or nothing if the run was not made or left no grains.
pub(super) fn draw(made: &Made<'_>, wanted: &Pictures) -> Result<Option<String>, Failure> {
    if made.result(&wanted.run).is_none() {
        return Ok(None);
    }
    let fields = made.folder.join(&wanted.run).join("fields");
    let all = files(&fields, "grains_", ".vtp");
    let chosen = match &wanted.files {
        None => all,
        Some(places) => places.iter().map(|place| chosen(&all, *place, &fields)).collect::<Result<_, _>>()?,
    };
    if chosen.is_empty() {
        return Err(content(&fields)("has no files of grains, or the pictures choose none".to_owned()));
    }
    let mut sheet = sheet_of_grains(&chosen)?;
    sheet.faults.pop().map_or(Ok(sheet.pictures), |fault| Err(Failure::Input(fault)))
}

fn chosen(all: &[PathBuf], place: usize, fields: &Path) -> Result<PathBuf, Failure> {
    all.get(place).cloned().ok_or_else(|| {
        let there = all.len();
        content(fields)(format!(
            "has {there} files of grains, and the pictures ask for number {place} from 0"
        ))
    })
}
