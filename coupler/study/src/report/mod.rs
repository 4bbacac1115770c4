//! `bedload report`: one self-contained HTML page per run, chart or map, from the files in its folder.
//!
//! | file | what it holds |
//! |---|---|
//! | `command` | the command: which folder holds what |
//! | `page` | the page of a run |
//! | `run_files` | what is read of a run, and the scales of its pictures |
//! | `plots`, `curves` | what is drawn against time, and how |
//! | `bed` | totals of a bed, and profiles over its height |
//! | `panels` | pictures of vorticity and of grains |
//! | `player` | the film of the page: grains and a plane of the flow over time |

mod bed;
mod command;
mod curves;
pub mod page;
mod panels;
mod player;
mod plots;
mod run_files;

pub use command::report;
