//! A map: every run is stable, oscillating or failed by its signal; where each method ends, beside the bound
//! that `bedload check` enforces.
//!
//! | file | what it holds |
//! |---|---|
//! | `check` | the `[stability]` section against its scene |
//! | `runs` | what every run sets, and what became of it |
//! | `classify` | stable, oscillating or failed, from a signal |
//! | `counts` | counts of refusals right and wrong |
//! | `ends` | where each method ends |
//! | `map` | the map, its axes, what is refused in it |
//! | `page` | `stability.html` |

pub(crate) mod check;
pub mod classify;
pub mod counts;
mod ends;
mod map;
mod page;
pub mod runs;

use std::path::{Path, PathBuf};

use bedload_output::atomic_write;
use bedload_scene::{CheckedScene, SceneSource};

use crate::folder::{SCENE, content};
use crate::kind::Kind;
use crate::section::Section;
use crate::sweep::Sweep;
use crate::table::Table;
use coupler::failure::Failure;
use map::Frame;

/// Makes map and page of a folder from its table and scene; returns the page.
pub(crate) fn draw(dir: &Path) -> Result<PathBuf, Failure> {
    let scene = CheckedScene::new(SceneSource::read(&dir.join(SCENE), &[])?)?;
    let section = Section::of_text(&scene.source, Kind::Stability)?;
    let (name, Section { vary, runs, .. }) = (Kind::Stability.name(), &section);
    let columns = Sweep::columns((&scene, &dir.join(SCENE)), &scene.source, name, vary, runs)?;
    let path = dir.join(Kind::Stability.table());
    let table = Table::read(&path)?;
    let keys: Vec<&String> = columns.iter().map(|column| &column.key).collect();
    if table.keys.iter().collect::<Vec<_>>() != keys {
        let what = format!("has the keys {:?}, but {SCENE} beside it varies {keys:?}", table.keys);
        return Err(content(&path)(what));
    }
    let (x, y) = check::axes(&section, &columns, &scene.source)?;
    let title = if section.title.is_empty() { &scene.scene.title } else { &section.title };
    let frame = Frame { title, x: (x, &columns[x].name), y: (y, &columns[y].name), bound: &section.bound };
    let map = map::draw(&table, &frame);
    atomic_write(&dir.join("stability.svg"), map.as_bytes())?;
    let page = dir.join("stability.html");
    atomic_write(&page, page::page(&table, &frame, &section.about, &map)?.as_bytes())?;
    Ok(page)
}
