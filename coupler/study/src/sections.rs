//! The sections of a scene that only studies read.

use bedload_program::RunOptions;
use bedload_scene::SceneSource;

use crate::kind::Kind;
use crate::section::Section;
use coupler::failure::Failure;

/// Checks those that a scene has: what is wrong there is an error of every command.
///
/// # Errors
/// [`Failure::Scene`] at the key that is unknown, retired or of the wrong type.
pub fn check(options: &RunOptions) -> Result<(), Failure> {
    let source = SceneSource::read(&options.scene, &options.all_overrides())?;
    for kind in Kind::ALL {
        Section::find(&source, kind)?;
    }
    Ok(())
}
