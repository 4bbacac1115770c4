//! Studies: a scene and keys that vary, runs that are never repeated once finished, and what comes of them as
//! table, figure and page. One format, one runner and one table for three kinds; reports and films of single
//! runs.
//!
//! | file | what it holds |
//! |---|---|
//! | [`section`] | a study as it is written: `[chart]`, `[stability]` or `[case]` |
//! | [`study`] | a study, checked, and its runs laid out |
//! | [`commands`] | `bedload chart`, `stability`, `validate` |
//! | [`ensemble`] | `bedload ensemble`: a scene, or a chain of them, once per seed |
//! | [`evidence`] | `bedload study`: the committed tables, made again, sampled, marked |
//! | `chart` | error against cost |
//! | [`stability`] | where each method fails, beside the bound |
//! | `case` | published cases and their references |
//! | [`report`] | `bedload report`: the HTML page of a run |
//! | [`film`] | `bedload film`: a plane of the flow with its grains, frame by frame |
//! | [`vary`], [`sweep`] | varied keys as the file writes them, and all their combinations as runs with `--set` |
//! | `resolution` | the grid of a scene with another D/Δx |
//! | `make`, `runs` | the runs of studies, as child processes, several at a time, resumable |
//! | [`table`] | a row per run, with build and machine |
//! | `folder` | the files of a study's folder |
//! | [`divergence`] | the figure of `bedload replay --compare` |
//! | `plot` | plots: lines, points, axes, legends |
//! | `page` | HTML, SVG and text from templates |
//! | `pictures` | fields and grains on a plane, drawn to scale |

mod case;
mod chart;
pub mod commands;
pub mod divergence;
pub mod ensemble;
pub mod evidence;
pub mod film;
mod folder;
pub mod kind;
#[cfg(test)]
mod made;
mod make;
mod page;
mod pictures;
mod plot;
pub mod report;
mod resolution;
mod runs;
pub mod section;
pub mod stability;
pub mod study;
pub mod sweep;
pub mod table;
pub mod vary;
