//! The sections of a scene that only studies read.

use bedload_program::RunOptions;
use bedload_scene::SceneSource;
use coupler::failure::Failure;
use serde::Deserialize;

use crate::chart::Chart;
use crate::stability::section::Stability;

/// The sections of studies, as text.
#[derive(Deserialize)]
struct Sections {
    #[serde(default)]
    chart: toml::Table,
    #[serde(default)]
    stability: toml::Table,
}

/// Checks the sections of a scene that only studies read: what is wrong there is an error of every command.
///
/// # Errors
/// [`Failure::Scene`] at the key that is unknown, retired or of the wrong type.
pub fn check(options: &RunOptions) -> Result<(), Failure> {
    let source = SceneSource::read(&options.scene, &options.all_overrides())?;
    let Sections { chart, stability } = source.section()?;
    if !chart.is_empty() {
        Chart::of_text(&source)?;
    }
    if !stability.is_empty() {
        Stability::of_text(&source)?;
    }
    Ok(())
}
