//! The log of a run, in parts: `exchange.mcap`, and `exchange.<n>.mcap` for each resume.

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
    Ok(Recorder::create(&folder.log_part(part), &manifest, RecorderOptions::default())?)
}
