//! The log of a run, in parts: `exchange.mcap`, and `exchange.<n>.mcap` for each resume.

use std::path::{Path, PathBuf};

use bedload_output::OutputFolder;
use protocol::log::{LogError, Manifest, Recorder, RecorderOptions};
use protocol::new_file::is_full;

use crate::failure::Failure;
use crate::prepare::Prepared;

impl From<LogError> for Failure {
    fn from(error: LogError) -> Self {
        match &error {
            LogError::File { source, .. } if is_full(source) => Self::Full(error.to_string()),
            _ => Self::Run(error.to_string()),
        }
    }
}

/// Path of part `part`, counted from 1.
#[must_use]
pub(crate) fn log_path(folder: &OutputFolder, part: u32) -> PathBuf {
    match part {
        1 => folder.log(),
        _ => folder.root().join(format!("exchange.{part}.mcap")),
    }
}

/// The first part that is not there yet.
#[must_use]
pub(crate) fn next_part(folder: &OutputFolder) -> u32 {
    (1..u32::MAX).find(|part| !log_path(folder, *part).exists()).unwrap_or(u32::MAX)
}

/// Removes the parts that resumes of an earlier run left in the folder.
pub(crate) fn remove_parts(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or("");
        let middle = name.strip_prefix("exchange.").and_then(|rest| rest.strip_suffix(".mcap"));
        if middle.is_some_and(|part| part.parse::<u32>().is_ok()) {
            // One that cannot be removed is overwritten or left: it harms no new run.
            let _ = std::fs::remove_file(&path);
        }
    }
}

/// Opens the log of a run that begins with window `step` at `time`.
///
/// # Errors
/// [`Failure::Run`] if the file cannot be written.
pub(crate) fn open(
    prepared: &Prepared,
    folder: &OutputFolder,
    part: u32,
    step: u64,
    time: f64,
) -> Result<Recorder, Failure> {
    let path = folder.scene();
    let scene = std::fs::read_to_string(&path)
        .map_err(|error| Failure::Run(format!("cannot read {}: {error}", path.display())))?;
    let radii = prepared.scene.grains.iter().map(|grain| grain.radius).collect();
    let plan = &prepared.plan;
    let mut manifest =
        Manifest::new(&prepared.scene.scene.title, &scene, radii, plan.steps.dt_fluid, plan.until);
    manifest.first_step = step;
    manifest.first_time = time;
    if let Some(fluid) = &prepared.fluid {
        manifest.fluid_command.clone_from(&fluid.solver.command);
    }
    if let Some(dem) = &prepared.dem {
        manifest.dem_command.clone_from(&dem.solver.command);
    }
    Ok(Recorder::create(&log_path(folder, part), &manifest, RecorderOptions::default())?)
}
