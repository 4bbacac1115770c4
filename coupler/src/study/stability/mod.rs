//! `bedload stability`: sweeps a scene, judges every run from its signal, and draws where each method
//! is stable, oscillates or fails, beside the bound that `bedload check` enforces.
//!
//! | file | what it holds |
//! |---|---|
//! | `section` | `[stability]`, read and checked |
//! | `runs` | what each run is told, and what became of it |
//! | `verdict` | stable, oscillating or failed, from a signal |
//! | `table` | `stability.csv`, and counts of refusals right and wrong |
//! | `ends` | where each method ends |
//! | `map`, `axis`, `region` | the map, its axes, what is refused in it |
//! | `page` | `stability.html` |

mod axis;
pub mod ends;
mod map;
mod page;
mod region;
pub mod runs;
pub mod section;
pub mod table;
pub mod verdict;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use bedload_output::{Claim, OutputError, atomic_write};
use protocol::scene::{CheckedScene, SceneError, SceneSource};

use crate::failure::Failure;
use crate::study::SweepError;
use map::Frame;
use section::Sweep;
use table::{Counts, Table};

/// What to sweep, and how.
#[derive(Clone, Debug)]
pub struct Options {
    /// Scene with a `[stability]` section.
    pub scene: PathBuf,
    /// Folder of runs, table, map and page; by default `out/SCENE-stability`.
    pub out: Option<PathBuf>,
    /// Runs at a time; by default as many as there are cores.
    pub jobs: Option<NonZeroUsize>,
}

/// Why there is no map, or what is wrong with it.
#[derive(Debug, thiserror::Error)]
pub enum StabilityError {
    /// The scene or its section is wrong.
    #[error(transparent)]
    Scene(#[from] Box<SceneError>),
    /// Runs could not be made, or a file not be used.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// A file of the output cannot be written or read.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A file does not hold what it should.
    #[error("{}: {what}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A run could not even begin.
    #[error("the run {label} could not be made: {what}")]
    Run {
        /// Its label.
        label: String,
        /// What it said.
        what: String,
    },
    /// A run could not be planned.
    #[error("the run {label} cannot be planned: {failure}")]
    Plan {
        /// Its label.
        label: String,
        /// Why.
        failure: Box<Failure>,
    },
    /// A thread that planned runs is gone.
    #[error("not every run was planned: report this as a fault")]
    Plans,
    /// The bound lets failures pass.
    #[error("`check` accepts {} of {} runs that failed; see {}", counts.failed_accepted, counts.runs, page.display())]
    TooWeak {
        /// Verdicts and refusals.
        counts: Counts,
        /// The page.
        page: PathBuf,
    },
}

impl From<SceneError> for StabilityError {
    fn from(error: SceneError) -> Self {
        Self::Scene(Box::new(error))
    }
}

impl From<StabilityError> for Failure {
    fn from(error: StabilityError) -> Self {
        match error {
            StabilityError::Scene(error) => Self::Scene(error),
            StabilityError::Output(error) => error.into(),
            StabilityError::TooWeak { .. } | StabilityError::Plans => Self::Run(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

/// Makes the runs that are not there yet, judges all, and writes table, map and page.
///
/// # Errors
/// [`StabilityError`]: a wrong section, runs that cannot begin, or a bound that lets failures pass.
pub fn stability(options: &Options) -> Result<(), StabilityError> {
    let scene = CheckedScene::new(SceneSource::read(&options.scene, &[])?)?;
    let sweep = Sweep::read(&scene)?;
    let out = options.out.clone().unwrap_or_else(|| {
        let name = options.scene.file_stem().unwrap_or("scene".as_ref()).to_string_lossy();
        Path::new("out").join(format!("{name}-stability"))
    });
    std::fs::create_dir_all(&out).map_err(SweepError::file("make", &out))?;
    let _claim = Claim::of(&out)?;
    atomic_write(&out.join(SCENE), scene.source.text.as_bytes())?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = options.jobs.map_or(cores, usize::from);
    let rows = runs::rows(&sweep, &options.scene, &out, jobs)?;
    let keys = sweep.ladder.columns.iter().map(|column| column.key.clone()).collect();
    let table = Table { keys, rows };
    atomic_write(&out.join(TABLE), table.to_csv().as_bytes())?;
    let page = write(&out, &scene, &sweep, &table)?;
    let counts = Counts::of(&table.rows);
    println!("{counts}\n{}", page.display());
    if counts.failed_accepted > 0 {
        return Err(StabilityError::TooWeak { counts, page });
    }
    Ok(())
}

/// The scene of a sweep, as it was read.
const SCENE: &str = "scene.toml";
/// Its table.
pub const TABLE: &str = "stability.csv";

/// Makes map and page of a finished sweep anew, from its table; returns the page.
///
/// # Errors
/// [`StabilityError`] if the folder holds no sweep.
pub fn report(dir: &Path) -> Result<PathBuf, StabilityError> {
    let scene = CheckedScene::new(SceneSource::read(&dir.join(SCENE), &[])?)?;
    let sweep = Sweep::read(&scene)?;
    let table = Table::read(&dir.join(TABLE))?;
    let keys: Vec<&String> = sweep.ladder.columns.iter().map(|column| &column.key).collect();
    if table.keys.iter().collect::<Vec<_>>() != keys {
        let what = format!("has the keys {:?}, but {SCENE} beside it varies {keys:?}", table.keys);
        return Err(StabilityError::Content { path: dir.join(TABLE), what });
    }
    write(dir, &scene, &sweep, &table)
}

/// Writes `stability.svg` and `stability.html`.
fn write(out: &Path, scene: &CheckedScene, sweep: &Sweep, table: &Table) -> Result<PathBuf, StabilityError> {
    let section = &sweep.section;
    let title = if section.title.is_empty() { &scene.scene.title } else { &section.title };
    let name = |column: usize| sweep.ladder.columns[column].name.as_str();
    let frame =
        Frame { title, x: (sweep.x, name(sweep.x)), y: (sweep.y, name(sweep.y)), bound: &section.bound };
    atomic_write(&out.join("stability.svg"), map::draw(table, &frame).as_bytes())?;
    let page = out.join("stability.html");
    atomic_write(&page, page::page(table, &frame, &section.about).as_bytes())?;
    Ok(page)
}
