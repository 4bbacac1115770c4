//! What a run is, before it begins.

use std::time::Instant;

use bedload_output::{OutputFolder, Sides};
use bedload_scene::CheckedScene;
use protocol::participant::Role;

use crate::interrupts::Interrupts;

/// What is logged of a run.
#[derive(Clone, Debug)]
pub enum LogKind {
    /// Every message of a coupled run.
    Coupled {
        /// Command of the fluid; empty where none takes part.
        fluid: Vec<String>,
        /// Command of the DEM, likewise.
        dem: Vec<String>,
    },
    /// The order of every window, and what the solver of a role sent at each observation.
    Alone(Role),
}

/// What a run is.
pub struct Job<'a> {
    /// Name of the program, for messages.
    pub program: &'static str,
    /// The scene.
    pub scene: &'a CheckedScene,
    /// Its output folder.
    pub folder: &'a OutputFolder,
    /// Goes on from the checkpoint in the folder.
    pub resume: bool,
    /// Signals.
    pub interrupts: &'a Interrupts,
    /// Who takes part, for the columns.
    pub sides: Sides,
    /// Planned window, s.
    pub dt: f64,
    /// Shortest duration of a contact, s; infinite where nothing can touch.
    pub contact_time: f64,
    /// Wall time between checkpoints, s; 0: only at the end and on interruption.
    pub checkpoint_every: f64,
    /// What is logged; none: nothing.
    pub log: Option<LogKind>,
    /// Start of the run, for its wall time.
    pub begin: Instant,
}
