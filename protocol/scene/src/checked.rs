//! A scene that passed every check.

use std::path::{Path, PathBuf};

use crate::error::SceneError;
use crate::form;
use crate::grains::{Grain, Motion};
use crate::insertions::Inserted;
use crate::layout;
use crate::over_time;
use crate::retired::Retired;
use crate::shared::Scene;
use crate::source::SceneSource;
use crate::validate;
use crate::walls::Wall;

/// Keys of the shared part that have another name now.
const RETIRED: [Retired; 3] = [
    Retired::key("pours", "[[insertions]]"),
    Retired::key("layers", "[[rough_walls]]"),
    Retired::key("grains[].oscillation", "velocity = { amplitude, frequency, phase, offset }"),
];

/// A scene that passed every check, with its grains laid out.
///
/// ```
/// use bedload_scene::{CheckedScene, SceneSource};
///
/// let text = r#"
///     until = 1.0
///     [domain]
///     geometry = "plane"
///     lower = [0.0, 0.0]
///     upper = [4.0, 4.0]
///     boundary = { x = "periodic", z = "no-slip" }
///     [[grains]]
///     position = [2.0, 0.0, 1.0]
///     radius = 0.5
///     density = 2500.0
/// "#;
/// let scene = CheckedScene::new(SceneSource { file: "disc.toml".into(), text: text.into() })?;
/// assert!(scene.has_free_grains());
///
/// let wrong = SceneSource { file: "disc.toml".into(), text: text.replace("0.5", "-0.5") };
/// assert_eq!(CheckedScene::new(wrong).unwrap_err().key, "grains[0].radius");
/// # Ok::<(), bedload_scene::SceneError>(())
/// ```
#[derive(Clone, Debug)]
pub struct CheckedScene {
    /// As written, defaults filled in.
    pub scene: Scene,
    /// Every grain, in message order: `grains`, `grain_files`, `rough_walls`, `groups`, `insertions`.
    pub grains: Vec<Grain>,
    /// Of the last of them: when they are inserted, ascending.
    pub inserted: Vec<Inserted>,
    /// The text, for errors of the sections.
    pub source: SceneSource,
    /// [`CheckedScene::state_sha256`] of the scene from which this one was written out; none where its text
    /// says it.
    pub written_from: Option<String>,
    /// SHA-256 of the grain tables and values over time that files hold; none where there are no such files.
    pub files_sha256: Option<String>,
    /// What the user should know though no rule is broken, such as columns of a table that are not read.
    pub notes: Vec<String>,
}

impl CheckedScene {
    /// Reads, types and checks the shared part.
    ///
    /// # Errors
    /// [`SceneError`] at the first fault.
    pub fn new(source: SceneSource) -> Result<Self, SceneError> {
        source.refuse_retired(&RETIRED)?;
        let mut scene: Scene = source.section()?;
        source.refuse_longer_lists(&scene)?;
        form::settle(&mut scene, &source)?;
        over_time::settle(&mut scene, &source)?;
        validate::shared(&scene, &source)?;
        let mut notes = Vec::new();
        let (grains, inserted) = layout::lay_out(&scene, &source, &mut notes)?;
        validate::grains(&scene, &grains, grains.len() - inserted.len(), &source)?;
        validate::metrics(&scene, grains.len(), &source)?;
        let files_sha256 = contents(&source);
        Ok(Self { scene, grains, inserted, source, written_from: None, files_sha256, notes })
    }

    /// Number of grains that are there from the start.
    pub fn present(&self) -> usize {
        self.grains.len() - self.inserted.len()
    }

    /// Is any grain free, so that a DEM is needed?
    pub fn has_free_grains(&self) -> bool {
        self.grains.iter().any(|grain| matches!(grain.motion, Motion::Free))
    }

    /// The planes that grains touch: explicit walls, then the domain's faces that are walls.
    pub fn contact_walls(&self) -> Vec<Wall> {
        let mut walls = self.scene.walls.clone();
        walls.extend(self.scene.domain.contact_faces());
        walls
    }

    /// Largest speed of the surface of those planes in the box up to `until`, s, in m/s.
    pub fn wall_speed(&self, until: f64) -> f64 {
        let walls = self.contact_walls();
        walls.iter().map(|wall| wall.largest_speed(&self.scene.domain, until)).fold(0.0, f64::max)
    }

    /// SHA-256 of the text, and of the files that it reads, in hexadecimal: the identity of the scene.
    /// `[chart]` and `[stability]` do not count: they say which other runs to make, and nothing about this
    /// one.
    pub fn sha256(&self) -> String {
        let (text, files) = (self.source.without_sweeps(), self.files_sha256.as_deref().unwrap_or_default());
        hexadecimal(format!("{text}{files}").as_bytes())
    }

    /// SHA-256 in hexadecimal of what the scene says, its end aside, and, behind a `-`, of the files that it
    /// reads: what a checkpoint is of. So a run goes on past the end that it had, and with other comments.
    pub fn state_sha256(&self) -> String {
        let of_text = || hexadecimal(self.source.without_end().as_bytes());
        self.written_from.clone().unwrap_or_else(|| match &self.files_sha256 {
            Some(files) => format!("{}-{files}", of_text()),
            None => of_text(),
        })
    }

    /// Refuses tables that are not those that a run read of which `state_sha256` is.
    ///
    /// # Errors
    /// At the first file that it reads.
    pub fn refuse_changed_files(&self, state_sha256: &str) -> Result<(), SceneError> {
        let then = state_sha256.split_once('-').map(|(_, files)| files);
        let files = counted(&self.source);
        let Some((key, _)) = files.first().filter(|_| then != self.files_sha256.as_deref()) else {
            return Ok(());
        };
        let names: Vec<String> = files.iter().map(|(_, path)| path.display().to_string()).collect();
        Err(self.source.error(
            &key.replace("[]", "[0]"),
            format!("the run read something else than what is there now: {}", names.join(", ")),
            "put back what the run read, or run the scene again",
        ))
    }

    /// SHA-256 of each file that does not count in [`sha256`](Self::sha256): the last states from which a run
    /// starts, and tables that metrics read. A run that goes on needs neither states nor their folders; one
    /// that ended is the same only if they are. Empty where one cannot be read.
    pub fn inputs_sha256(&self) -> Vec<String> {
        let files = self.source.files().into_iter().filter(|(key, _)| NO_STATE.contains(key));
        let of = |(key, path): (&str, PathBuf)| {
            input(key, &path).map_or_else(String::new, |bytes| hexadecimal(&bytes))
        };
        files.map(of).collect()
    }

    /// Refuses a step `dt`, s, that is so short that it changes no time near the end.
    ///
    /// # Errors
    /// At `key`.
    pub fn step_changes_time(&self, key: &str, dt: f64) -> Result<(), SceneError> {
        let until = self.scene.until;
        self.source.refuse_if(
            until + dt <= until,
            key,
            format_args!("makes steps of {dt:?} s; allowed: those that change a time of {until} s"),
            "give a longer step",
        )
    }

    /// Refuses to go on from `time`, s, if that is past the end.
    ///
    /// # Errors
    /// At `until`.
    pub fn goes_on_from(&self, time: f64) -> Result<(), SceneError> {
        let until = self.scene.until;
        self.source.refuse_if(
            time > until,
            "until",
            format_args!("is {until} s, but the run stands at t = {time} s already"),
            "give a later --until, or start anew without --resume",
        )
    }
}

/// SHA-256 of bytes.
fn hexadecimal(bytes: &[u8]) -> String {
    use sha2::Digest;
    sha2::Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of the files in which a scene keeps grains and values over time, one after the other.
fn contents(source: &SceneSource) -> Option<String> {
    let each: String = counted(source)
        .into_iter()
        .filter_map(|(_, path)| protocol::input_file::read(&path).ok())
        .map(|bytes| hexadecimal(&bytes))
        .collect();
    (!each.is_empty()).then(|| hexadecimal(each.as_bytes()))
}

/// Those files, with their keys.
fn counted(source: &SceneSource) -> Vec<(&'static str, PathBuf)> {
    source.files().into_iter().filter(|(key, _)| !NO_STATE.contains(key)).collect()
}

/// Files that a run does not read anew when it goes on, or that only its judge reads.
const NO_STATE: [&str; 3] = ["metrics[].file", STATE, FLOW];

/// The last state of the grains of another run.
const STATE: &str = "dem.initial_state";

/// That of its fluid.
const FLOW: &str = "medium.initial.folder";

/// What a run takes from such a file; of the output folder of another run: a state, and what says which
/// grains and which grid it is of.
fn input(key: &str, path: &Path) -> Option<Vec<u8>> {
    let (role, beside) = match key {
        STATE => ("dem", "grains.csv"),
        FLOW => ("fluid", "scene.toml"),
        _ => return protocol::input_file::read(path).ok(),
    };
    let state = protocol::checkpoint::digest(&protocol::checkpoints::newest_of_run(path), role)?;
    let beside = protocol::input_file::read(&path.join(beside)).unwrap_or_default();
    Some([&state[..], &beside].concat())
}
