//! The output folder: where every file of a run lies, and how it is made without harm.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::claim::Claim;
use crate::columns::observed_grains;
use crate::error::OutputError;
use crate::file::atomic_write;
use bedload_scene::{CheckedScene, SceneError};

/// First words of the `scene.toml` of an output folder: how Bedload knows its own.
const MARKER: &str = "# Bedload output:";

/// What stands before [`CheckedScene::state_sha256`] in that file, on a line of its own.
const STATE: &str = "# sha256 of what it says, its end aside: ";

/// The files that a run writes in the folder itself, a method for the path of each.
macro_rules! files {
    ($($(#[$doc:meta])* $method:ident = $name:literal;)*) => {
        const FILES: &[&str] = &[$($name),*];

        impl OutputFolder {
            $($(#[$doc])*
            pub fn $method(&self) -> PathBuf {
                self.root.join($name)
            })*
        }
    };
}

files! {
    /// The scene as a solver of another is given it: `scene-in-full.toml`.
    scene_in_full = "scene-in-full.toml";
    /// `summary.json`.
    summary = "summary.json";
    /// `series.csv`.
    series = "series.csv";
    /// The grains as a run of a DEM alone leaves them, `grains.csv`.
    grains = "grains.csv";
    /// Coarse-grained profile at the end of a run of a DEM alone, `profile.csv`.
    profile = "profile.csv";
    /// Mean over time of the averages over planes, `planes.csv`.
    planes = "planes.csv";
    /// The log of the exchange, `exchange.mcap`.
    log = "exchange.mcap";
    /// The plan that the coupler checked, `plan.json`.
    plan = "plan.json";
    /// `report.html`.
    report = "report.html";
    /// `film.gif`.
    film = "film.gif";
    /// `film.mp4`.
    film_mp4 = "film.mp4";
}

/// Those of metrics, of comparisons and of averages.
const TABLES: [&str; 7] = [
    "divergence.csv",
    "divergence.svg",
    "oblique.csv",
    "deposit.csv",
    "heap.csv",
    "coarse-grain.csv",
    "coarse-grain.vti",
];

/// What a start leaves that was killed before `scene.toml` stood: the file that was to take its place.
const BEGUN: &str = "scene.toml.tmp";

/// What a run writes in its sub-folders: by extension in `fields/`, by first word in `checkpoint/`.
const FIELD_EXTENSIONS: [&str; 8] = ["vtr", "pvtr", "vtu", "vtp", "vti", "pvd", "csv", "tmp"];
const CHECKPOINT_NAMES: [&str; 4] = ["fluid", "dem", "coupler", "loop"];

/// What the fluid, the DEM and the coupler made of their sections of a scene; one that is not given stays as
/// the user wrote it.
pub type Sections<'a> = [Option<&'a toml::Table>; 3];

/// The folder of one run.
#[derive(Clone, Debug)]
pub struct OutputFolder {
    root: PathBuf,
    /// Held as long as a run writes there.
    claim: Option<Arc<Claim>>,
}

impl OutputFolder {
    /// Makes the folder, or empties it of an earlier run, and puts the scene in.
    ///
    /// An earlier run is replaced only in a folder that Bedload wrote, and only its own files:
    /// whatever else lies there stays. One that is finished, or was interrupted, is replaced only where that
    /// is asked for.
    ///
    /// # Errors
    /// [`OutputError::InUse`], [`OutputError::Foreign`] if the folder holds other things,
    /// [`OutputError::Finished`], [`OutputError::Begun`], [`OutputError::Link`], [`OutputError::File`].
    pub fn create(root: &Path, scene: &CheckedScene, overwrite: bool) -> Result<Self, OutputError> {
        fs::create_dir_all(root).map_err(|source| OutputError::Place { path: root.to_owned(), source })?;
        let folder = Self::claimed(root)?;
        if !folder.is_empty()? {
            folder.require_marker()?;
            if !overwrite && folder.is_finished() {
                return Err(OutputError::Finished(root.to_owned()));
            }
            if !overwrite && folder.can_go_on() {
                return Err(OutputError::Begun(root.to_owned()));
            }
            folder.refuse_needed(scene)?;
            folder.remove_run()?;
        }
        // First, so that the folder is known for ours whenever this ends.
        folder.write_scene(scene, [None; 3])?;
        folder.with_its_folders()
    }

    /// Makes the folders in it that are not there.
    fn with_its_folders(self) -> Result<Self, OutputError> {
        for path in [self.fields(), self.checkpoint()] {
            fs::create_dir_all(&path).map_err(OutputError::file("make the folder", &path))?;
        }
        Ok(self)
    }

    /// A run that the scene starts from, or a table that it reads, would be emptied with the folder.
    fn refuse_needed(&self, scene: &CheckedScene) -> Result<(), OutputError> {
        let Ok(root) = self.root.canonicalize() else { return Ok(()) };
        let inside = |path: &Path| path.canonicalize().is_ok_and(|path| path.starts_with(&root));
        let needed = scene.source.files().into_iter().find(|(_, path)| inside(path));
        let Some((key, needed)) = needed else { return Ok(()) };
        Err(OutputError::Needed { path: self.root.clone(), key, needed })
    }

    /// Does the folder that this process claimed still stand at its path? Where another was put there, such
    /// as a link into a folder of somebody else's, nothing may be written.
    ///
    /// # Errors
    /// [`OutputError::Gone`].
    pub fn check_place(&self) -> Result<(), OutputError> {
        match &self.claim {
            Some(claim) if !claim.is_at(&self.root) => Err(OutputError::Gone(self.root.clone())),
            _ => Ok(()),
        }
    }

    /// Opens the folder of an earlier run, to read it or to add to it.
    ///
    /// # Errors
    /// [`OutputError::NoRun`] if there is none.
    pub fn open(root: &Path) -> Result<Self, OutputError> {
        let folder = Self { root: root.to_owned(), claim: None };
        folder.require_marker().map_err(|_| OutputError::NoRun(root.to_owned()))?;
        folder.with_its_folders()
    }

    /// Opens the folder of an earlier run, to go on with it.
    ///
    /// # Errors
    /// [`OutputError::NothingToResume`], [`OutputError::InUse`].
    pub fn resume(root: &Path) -> Result<Self, OutputError> {
        Self::open(root).map_err(|error| match error {
            OutputError::NoRun(root) => OutputError::NothingToResume(root),
            other => other,
        })?;
        Self::claimed(root)
    }

    fn claimed(root: &Path) -> Result<Self, OutputError> {
        Ok(Self { root: root.to_owned(), claim: Some(Arc::new(Claim::of(root)?)) })
    }

    /// Writes `scene.toml` with every default written out.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn write_scene(&self, scene: &CheckedScene, sections: Sections) -> Result<(), OutputError> {
        let path = self.scene();
        let body = resolved_scene(scene, sections)
            .map_err(|error| OutputError::Content { path: path.clone(), what: error.to_string() })?;
        // A name with a line break would end the comment.
        let name = scene.source.file.replace(['\n', '\r'], " ");
        let text = format!(
            "{MARKER} {name} with every default written out\n# sha256 of the scene as read: {}\n{STATE}{}\n\n{body}",
            scene.sha256(),
            scene.state_sha256()
        );
        atomic_write(&path, text.as_bytes())
    }

    /// Writes `scene-in-full.toml`: `scene.toml` with every grain written out as `[[grains]]`, insertions
    /// aside, so that a solver of another need not know how grains are laid out.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn write_scene_in_full(&self, scene: &CheckedScene, sections: Sections) -> Result<(), OutputError> {
        let path = self.scene_in_full();
        let body = resolved_scene(&in_full(scene), sections)
            .map_err(|error| OutputError::Content { path: path.clone(), what: error.to_string() })?;
        atomic_write(&path, body.as_bytes())
    }

    /// Did the run in the folder come to its end?
    pub fn is_finished(&self) -> bool {
        self.status().as_deref() == Some("completed")
    }

    /// Was the run interrupted or killed, with a checkpoint to go on from?
    fn can_go_on(&self) -> bool {
        let ended = self.status().is_some_and(|status| status != "interrupted");
        !ended && protocol::checkpoints::newest(&self.checkpoint()).is_some()
    }

    /// How the run ended, as `summary.json` of whatever version says; none where it was killed.
    fn status(&self) -> Option<String> {
        let text = protocol::input_file::read_text(&self.summary()).ok()?;
        let summary: serde_json::Value = serde_json::from_str(&text).ok()?;
        Some(summary["status"].as_str()?.to_owned())
    }

    /// Did it come to its end, and does the scene ask for no later one?
    pub fn is_finished_to(&self, until: f64) -> bool {
        let text = protocol::input_file::read_text(&self.scene()).unwrap_or_default();
        let old: toml::Table = toml::from_str(&text).unwrap_or_default();
        let number = |value: &toml::Value| value.as_float().or(value.as_integer().map(|whole| whole as f64));
        self.is_finished() && old.get("until").and_then(number).is_some_and(|end| until <= end)
    }

    /// Removes the summary of the run that now goes on: it speaks of what has been, not of what will be.
    ///
    /// # Errors
    /// [`OutputError::File`].
    pub fn remove_summary(&self) -> Result<(), OutputError> {
        remove("replace", &self.summary())?;
        remove("replace", &self.grains())
    }

    fn is_empty(&self) -> Result<bool, OutputError> {
        let mut entries =
            fs::read_dir(&self.root).map_err(OutputError::file("read the folder", &self.root))?;
        Ok(entries.all(|entry| entry.is_ok_and(|entry| entry.file_name() == BEGUN)))
    }

    fn require_marker(&self) -> Result<(), OutputError> {
        match protocol::input_file::read(&self.scene()) {
            Ok(bytes) if bytes.starts_with(MARKER.as_bytes()) => Ok(()),
            _ => Err(OutputError::Foreign { path: self.root.clone(), marker: MARKER }),
        }
    }

    /// Removes the files of the last run, but for `scene.toml`, which marks the folder as ours and is
    /// replaced.
    fn remove_run(&self) -> Result<(), OutputError> {
        for path in [self.fields(), self.checkpoint(), self.frames()] {
            if fs::symlink_metadata(&path).is_ok_and(|data| data.is_symlink()) {
                return Err(OutputError::Link(path));
            }
        }
        remove_files(&self.fields(), |path| {
            path.extension().is_some_and(|end| FIELD_EXTENSIONS.iter().any(|known| end == *known))
        })?;
        remove_files(&self.checkpoint(), |path| {
            let name = path.file_stem().and_then(|name| name.to_str()).unwrap_or("");
            CHECKPOINT_NAMES.iter().any(|known| name.split(['.', '-', '_']).next() == Some(known))
        })?;
        self.remove_frames()?;
        // Frames of the user's own stay, and the folder with them.
        let _ = fs::remove_dir(self.frames());
        self.remove_grids()?;
        self.remove_log_parts();
        protocol::checkpoints::remove_others(&self.checkpoint(), None);
        let mut files = FILES.iter().chain(&TABLES);
        files.try_for_each(|name| remove("replace the last run's", &self.root.join(name)))
    }

    /// Writes a file in the folder itself, whole or not at all ([`atomic_write`]), under a name that is not
    /// of Bedload's choosing.
    ///
    /// # Errors
    /// [`OutputError::Outside`] if the name is not that of a file in the folder, [`OutputError::File`].
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), OutputError> {
        write_in(&self.root, name, bytes)
    }

    /// Writes a file in the folder of the field files, as [`OutputFolder::write`] does.
    ///
    /// # Errors
    /// As of [`OutputFolder::write`].
    pub fn write_field(&self, name: &str, bytes: &[u8]) -> Result<(), OutputError> {
        write_in(&self.fields(), name, bytes)
    }

    /// The folder itself.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The scene as it was run.
    pub fn scene(&self) -> PathBuf {
        self.root.join("scene.toml")
    }

    /// Path of part `part` of the log, counted from 1: a resume begins a new one.
    pub fn log_part(&self, part: u32) -> PathBuf {
        match part {
            1 => self.log(),
            _ => self.root.join(format!("exchange.{part}.mcap")),
        }
    }

    /// The first part of the log that is not there yet.
    pub fn next_log_part(&self) -> u32 {
        (1..u32::MAX).find(|part| !self.log_part(*part).exists()).unwrap_or(u32::MAX)
    }

    /// Removes the parts that resumes of an earlier run left.
    fn remove_log_parts(&self) {
        let Ok(entries) = fs::read_dir(&self.root) else { return };
        for path in entries.flatten().map(|entry| entry.path()) {
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or("");
            let middle = name.strip_prefix("exchange.").and_then(|rest| rest.strip_suffix(".mcap"));
            if middle.is_some_and(|part| part.parse::<u32>().is_ok()) {
                // One that cannot be removed is overwritten or left: it harms no new run.
                let _ = fs::remove_file(&path);
            }
        }
    }

    /// Removes the runs on coarser grids that `run --verify` leaves in its folder, `verify-1` and so on. One
    /// in which something else lies stays a folder of ours, with that.
    fn remove_grids(&self) -> Result<(), OutputError> {
        let Ok(entries) = fs::read_dir(&self.root) else { return Ok(()) };
        for entry in entries.flatten() {
            let (name, grid) = (entry.file_name(), Self { root: entry.path(), claim: None });
            let number = name.to_str().and_then(|name| name.strip_prefix("verify-"));
            let numbered = number.is_some_and(|number| number.parse::<u32>().is_ok());
            let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
            if !(numbered && is_folder && grid.require_marker().is_ok()) {
                continue;
            }
            grid.remove_run()?;
            let _ = fs::remove_dir(grid.fields()).and(fs::remove_dir(grid.checkpoint()));
            if fs::read_dir(&grid.root).is_ok_and(|left| left.count() == 1) {
                remove("replace the last run's", &grid.scene())?;
                fs::remove_dir(&grid.root)
                    .map_err(OutputError::file("replace the last run's", &grid.root))?;
            }
        }
        Ok(())
    }

    /// Folder of the field files.
    pub fn fields(&self) -> PathBuf {
        self.root.join("fields")
    }

    /// Folder of the frames of a film.
    pub fn frames(&self) -> PathBuf {
        self.root.join("film")
    }

    /// Path of a frame, counted from 0.
    pub fn frame(&self, number: usize) -> PathBuf {
        self.frames().join(format!("frame_{number:05}.png"))
    }

    /// Removes the frames of an earlier film.
    ///
    /// # Errors
    /// [`OutputError::File`].
    pub fn remove_frames(&self) -> Result<(), OutputError> {
        remove_files(&self.frames(), |path| {
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or("");
            name.starts_with("frame_") && name.ends_with(".png")
        })
    }

    /// Folder of the checkpoint.
    pub fn checkpoint(&self) -> PathBuf {
        self.root.join("checkpoint")
    }
}

fn write_in(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), OutputError> {
    if !bedload_scene::is_file_name(name.strip_suffix(".csv").unwrap_or(name)) {
        return Err(OutputError::Outside { folder: folder.to_owned(), name: name.to_owned() });
    }
    atomic_write(&folder.join(name), bytes)
}

/// [`CheckedScene::state_sha256`] of the scene from which a run was made, which the checkpoint of a solver
/// alone and of the coupler bear, from the text of the `scene.toml` in its output folder; none if another
/// program or an earlier version wrote that.
pub fn state_of(scene: &str) -> Option<&str> {
    let mut head = scene.lines().take_while(|line| line.starts_with('#'));
    head.next().filter(|line| line.starts_with(MARKER))?;
    head.find_map(|line| line.strip_prefix(STATE)).map(str::trim)
}

/// Refuses tables that were changed since the run whose `scene.toml` has the text `written`.
///
/// # Errors
/// [`SceneError`] at the first file that the scene reads.
pub fn refuse_changed_files(scene: &CheckedScene, written: &str) -> Result<(), SceneError> {
    state_of(written).map_or(Ok(()), |state| scene.refuse_changed_files(state))
}

/// Removes a file, if it is there.
fn remove(action: &'static str, path: &Path) -> Result<(), OutputError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(OutputError::file(action, path)(error))
        }
        _ => Ok(()),
    }
}

/// Removes the plain files of `folder` that `ours` knows; links and folders stay.
fn remove_files(folder: &Path, ours: impl Fn(&Path) -> bool) -> Result<(), OutputError> {
    let Ok(entries) = fs::read_dir(folder) else { return Ok(()) };
    for entry in entries.flatten() {
        let path = entry.path();
        if entry.file_type().is_ok_and(|kind| kind.is_file()) && ours(&path) {
            fs::remove_file(&path).map_err(OutputError::file("replace the last run's", &path))?;
        }
    }
    Ok(())
}

/// The scene with every grain that is there from the start as one of `grains`.
pub fn in_full(scene: &CheckedScene) -> CheckedScene {
    let mut full = scene.clone();
    full.scene.grains = scene.grains[..scene.present()].to_vec();
    full.scene.grain_files.clear();
    full.scene.rough_walls.clear();
    full.scene.groups.clear();
    full
}

/// The scene as TOML with every default written out: the shared part from its types, the sections
/// of the solvers and of the coupler from what they resolved.
///
/// # Errors
/// If a value has no TOML form.
pub fn resolved_scene(scene: &CheckedScene, sections: Sections) -> Result<String, toml::ser::Error> {
    let mut resolved = scene.scene.clone();
    resolved.observe.grains = Some(observed_grains(scene));
    resolved.observe.fields_every.get_or_insert(0.0);
    let written = [&mut resolved.fluid, &mut resolved.dem, &mut resolved.coupling];
    for (written, section) in written.into_iter().zip(sections) {
        section.iter().for_each(|section| written.clone_from(section));
    }
    toml::to_string_pretty(&resolved)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_a_run_is_known_to_the_scene_as_taken() {
        let own = [BEGUN, "scene.toml", "fields", "checkpoint", "film"];
        for name in FILES.iter().chain(&TABLES).chain(&own) {
            assert!(bedload_scene::OUTPUT_FILES.contains(name), "{name}");
        }
    }

    #[test]
    fn a_folder_that_another_took_the_place_of_is_known() {
        let outer = std::env::temp_dir().join(format!("bedload-place-{}", std::process::id()));
        let (root, moved) = (outer.join("out"), outer.join("moved"));
        fs::create_dir_all(&root).unwrap();
        let folder = OutputFolder::claimed(&root).unwrap();
        folder.check_place().unwrap();
        fs::rename(&root, &moved).unwrap();
        assert!(matches!(folder.check_place(), Err(OutputError::Gone(_))));
        fs::create_dir_all(outer.join("other")).unwrap();
        std::os::unix::fs::symlink(outer.join("other"), &root).unwrap();
        assert!(matches!(folder.check_place(), Err(OutputError::Gone(_))));
        fs::remove_dir_all(outer).unwrap();
    }

    #[test]
    fn no_name_leads_out_of_the_folder() {
        let outer = std::env::temp_dir().join(format!("bedload-inside-{}", std::process::id()));
        let root = outer.join("out");
        fs::create_dir_all(root.join("fields")).unwrap();
        let folder = OutputFolder { root, claim: None };
        let away = outer.join("away.csv").display().to_string();
        for name in ["../away.csv", "fields/../../away.csv", &away, "..", "", ".csv", "fields/u.csv"] {
            for written in [folder.write(name, b"x"), folder.write_field(name, b"x")] {
                assert!(matches!(written, Err(OutputError::Outside { .. })), "{name}: {written:?}");
            }
        }
        folder.write("u.csv", b"x").unwrap();
        folder.write_field("at_0.1.csv", b"x").unwrap();
        assert!(folder.root().join("u.csv").exists() && folder.fields().join("at_0.1.csv").exists());
        assert_eq!(fs::read_dir(&outer).unwrap().count(), 1);
        fs::remove_dir_all(outer).unwrap();
    }
}
