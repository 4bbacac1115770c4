//! `bedload report`: one self-contained HTML page per run, chart or map, from the files in its folder.
//!
//! | file | what it holds |
//! |---|---|
//! | `command` | the command: which folder holds what |
//! | `page`, `split` | the page of a run, and the split of its cost |
//! | `run_files` | what is read of a run, and the scales of its pictures |
//! | `plots`, `curves` | what is drawn against time, and how |
//! | `contour`, `vorticity` | contours of fields, the panel of vorticity |

mod command;
mod contour;
mod curves;
pub mod page;
mod plots;
mod run_files;
mod split;
mod vorticity;

pub use command::report;
