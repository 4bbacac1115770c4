//! Options of a run, the same for `bedload`, `bedload-fluid` and `bedload-dem`.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use bedload_output::{OutputError, OutputFolder};
use bedload_scene::{CheckedScene, SceneError, SceneSource};

/// `run SCENE [--out DIR] [--until T] [--set KEY=VALUE]… [--threads N] [--resume] [--no-record]`.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
pub struct RunOptions {
    /// Scene file (TOML)
    pub scene: PathBuf,
    /// Output folder; by default out/SCENE
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// End of the run, s, instead of the scene's `until`
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub until: Option<f64>,
    /// Override any key of the scene, such as `grains[0].density=2.0`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Threads per solver; by default as many as the machine offers
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZeroUsize>,
    /// Go on from the checkpoint in the output folder
    #[arg(long)]
    pub resume: bool,
    /// Replace a finished run in the output folder
    #[arg(long, conflicts_with = "resume")]
    pub overwrite: bool,
    /// Do not record the exchange (no exchange.mcap)
    #[arg(long)]
    pub no_record: bool,
    /// Time between field files where the scene names none, s: `bedload` chooses it.
    #[arg(long, hide = true, value_name = "T")]
    pub fields_every: Option<f64>,
    /// Are commands that the scene names left alone? Those who only look at a scene start nothing.
    #[arg(skip)]
    pub no_commands: bool,
}

/// An end of the run, s, as `--set` takes it.
pub fn until_as_set(until: f64) -> String {
    format!("until={}", toml::Value::Float(until))
}

impl RunOptions {
    /// Options that ask for nothing but a scene.
    pub fn of_scene(scene: &Path) -> Self {
        Self { scene: scene.to_owned(), ..Self::default() }
    }

    /// The scene, with `--set` and then `--until` applied, read and checked, and with the time between field
    /// files that `bedload` chose.
    ///
    /// # Errors
    /// [`SceneError`] at the first fault.
    pub fn read_scene(&self) -> Result<CheckedScene, SceneError> {
        let mut scene = CheckedScene::new(SceneSource::read(&self.scene, &self.all_overrides())?)?;
        let observe = &mut scene.scene.observe;
        observe.fields_every = observe.fields_every.or(self.fields_every);
        Ok(scene)
    }

    /// `--set` as given, then `--until` as `until=T`: what a solver process needs to read
    /// the same scene.
    pub fn all_overrides(&self) -> Vec<String> {
        let mut all = self.overrides.clone();
        all.extend(self.until.map(until_as_set));
        all
    }

    /// Path of the output folder: `--out`, or `out/<name of the scene>`.
    pub fn out_path(&self) -> PathBuf {
        let name = self.scene.file_stem().unwrap_or("scene".as_ref());
        self.out.clone().unwrap_or_else(|| Path::new("out").join(name))
    }

    /// The output folder: opened with `--resume`, else new or emptied of the last run.
    ///
    /// # Errors
    /// [`OutputError`] if it cannot be made, is in use, holds foreign files, a finished run, or nothing to
    /// resume.
    pub fn folder(&self, scene: &CheckedScene) -> Result<OutputFolder, OutputError> {
        if self.resume {
            return OutputFolder::resume(&self.out_path());
        }
        OutputFolder::create(&self.out_path(), scene, self.overwrite)
    }

    /// Number of threads: `--threads`, or as many as the machine offers.
    pub fn threads(&self) -> usize {
        let offered = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
        self.threads.map_or_else(offered, NonZeroUsize::get)
    }
}
