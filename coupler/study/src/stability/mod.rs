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
mod ends;
mod map;
mod page;
mod region;
pub mod runs;
pub mod section;
pub mod table;
pub mod verdict;

use std::path::{Path, PathBuf};

use bedload_output::atomic_write;
use bedload_scene::{CheckedScene, SceneSource};

use crate::folder::{self, Options, SCENE, content, cores};
use coupler::failure::Failure;
use map::Frame;
use section::MapPlan;
use table::{Counts, Table, columns, read_table};

/// Makes the runs that are not there yet, judges all, and writes table, map and page.
///
/// # Errors
/// [`Failure`]: a wrong section, runs that cannot begin, or a bound that lets failures pass.
pub fn stability(options: &Options) -> Result<(), Failure> {
    let scene = CheckedScene::new(SceneSource::read(&options.scene, &[])?)?;
    let plan = MapPlan::read(&scene)?;
    let out = options.folder("stability");
    let _claim = folder::open(&out, &scene)?;
    let jobs = options.jobs.map_or_else(cores, usize::from);
    let rows = runs::rows(&plan, &options.scene, &out, jobs)?;
    let keys = plan.sweep.columns.iter().map(|column| column.key.clone()).collect();
    let table = Table { keys, columns: columns(), rows };
    atomic_write(&out.join(TABLE), table.csv().as_bytes())?;
    let page = write(&out, &scene, &plan, &table)?;
    let counts = Counts::of(&table.rows);
    println!("{counts}\n{}", page.display());
    if counts.failed_accepted > 0 {
        let (failed, page) = (counts.failed_accepted, page.display());
        let what = format!("`check` accepts {failed} of {} runs that failed; see {page}", counts.runs);
        return Err(Failure::Run(what));
    }
    Ok(())
}

/// The table of a map: what makes a folder one.
pub(crate) const TABLE: &str = "stability.csv";

/// Makes map and page of a finished sweep anew, from its table; returns the page.
///
/// # Errors
/// [`Failure`] if the folder holds no plan.
pub(crate) fn redraw(dir: &Path) -> Result<PathBuf, Failure> {
    let scene = CheckedScene::new(SceneSource::read(&dir.join(SCENE), &[])?)?;
    let plan = MapPlan::read(&scene)?;
    let table = read_table(&dir.join(TABLE))?;
    let keys: Vec<&String> = plan.sweep.columns.iter().map(|column| &column.key).collect();
    if table.keys.iter().collect::<Vec<_>>() != keys {
        let what = format!("has the keys {:?}, but {SCENE} beside it varies {keys:?}", table.keys);
        return Err(content(&dir.join(TABLE))(what));
    }
    write(dir, &scene, &plan, &table)
}

/// Writes `stability.svg` and `stability.html`.
fn write(out: &Path, scene: &CheckedScene, plan: &MapPlan, table: &Table) -> Result<PathBuf, Failure> {
    let section = &plan.section;
    let title = if section.title.is_empty() { &scene.scene.title } else { &section.title };
    let name = |column: usize| plan.sweep.columns[column].name.as_str();
    let frame = Frame { title, x: (plan.x, name(plan.x)), y: (plan.y, name(plan.y)), bound: &section.bound };
    let map = map::draw(table, &frame)?;
    atomic_write(&out.join("stability.svg"), map.as_bytes())?;
    let page = out.join("stability.html");
    atomic_write(&page, page::page(table, &frame, &section.about, &map)?.as_bytes())?;
    Ok(page)
}
