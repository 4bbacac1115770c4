//! Studies: a scene and keys that vary, runs that are never repeated once finished, a judgement of
//! each, and what comes of them as table, figure and page.
//!
//! | file | what it holds |
//! |---|---|
//! | [`chart`] | `bedload chart`: error against cost |
//! | [`stability`] | `bedload stability`: where each method fails, beside the bound |
//! | [`validate`] | `bedload validate`: published cases and their references |
//! | [`report`] | `bedload report`: the HTML page of a run |
//! | `vary`, `points` | varied keys as the scene writes them, and all their combinations as runs with `--set` |
//! | `resolution` | D/Δx of a scene, and the grid that has another one |
//! | `folder` | what a study is asked for, and its output folder |
//! | `runs` | runs as child processes, several at a time, resumable |
//! | `table` | `chart.csv`, `stability.csv`: a row per run |
//! | `plot` | plots: lines, points, axes, legends |
//! | `page`, `numbers` | HTML from templates, and how numbers are written |
//! | `vtk_file`, `snapshot`, `grain_pictures` | grains at an instant, and their pictures coloured by speed |

pub mod chart;
mod folder;
mod grain_pictures;
mod numbers;
mod page;
mod plot;
mod points;
pub mod report;
pub(crate) mod resolution;
mod runs;
mod snapshot;
pub mod stability;
mod table;
pub mod validate;
mod vary;
mod vtk_file;

pub use folder::Options;
pub use points::{Column, Ladder, Point};
pub use runs::{Keep, Outcome, Task, run_all};
pub use table::{Table, cell, parse_csv};
pub use vary::{SingleRun, Vary};
