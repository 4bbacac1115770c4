//! Studies: a scene and keys that vary, runs that are never repeated once finished, a judgement of
//! each, and what comes of them as table, figure and page.
//!
//! | file | what it holds |
//! |---|---|
//! | [`chart`] | `bedload chart`: error against cost |
//! | [`stability`] | `bedload stability`: where each method fails, beside the bound |
//! | [`validate`] | `bedload validate`: published cases and their references |
//! | [`report`] | `bedload report`: the HTML page of a run |
//! | `film` | `bedload film`: a plane of the flow with its grains, frame by frame |
//! | `vary`, `sweep` | varied keys as the scene writes them, and all their combinations as runs with `--set` |
//! | `resolution` | the grid of a scene with another D/Δx |
//! | `folder` | what a study is asked for, and its output folder |
//! | `runs` | runs as child processes, several at a time, resumable |
//! | `table` | `chart.csv`, `stability.csv`: a row per run |
//! | `divergence` | the figure of `bedload replay --compare` |
//! | `plot` | plots: lines, points, axes, legends |
//! | `page` | HTML, SVG and text from templates |
//! | [`sections`] | the sections of a scene that only studies read |
//! | `snapshot`, `grain_pictures` | grains at an instant, and their pictures coloured by speed |

pub mod chart;
pub mod divergence;
pub mod film;
mod folder;
mod grain_pictures;
#[cfg(test)]
mod made;
mod page;
mod plot;
pub mod report;
mod resolution;
mod runs;
pub mod sections;
mod snapshot;
pub mod stability;
mod sweep;
mod table;
pub mod validate;
mod vary;

pub use folder::Options;
pub(crate) use runs::{Outcome, Reuse, Task, run_all};
pub use sweep::{Column, Point, Sweep};
pub use table::Table;
pub(crate) use table::cell;
#[cfg(test)]
pub(crate) use table::parse_csv;
pub use vary::{SingleRun, Vary};
