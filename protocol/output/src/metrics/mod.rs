//! Numbers for `summary.json`, accumulated window by window in constant memory.
//!
//! A kind of metric is a variant of [`bedload_scene::MetricKind`], with its keys and its definition, and a
//! rule in one of the files of kinds: what it keeps, what a window adds, what it comes to.
//!
//! | file | what it holds |
//! |---|---|
//! | `measure` | all metrics of a scene, fed window by window |
//! | `rule` | how one of them is measured |
//! | `bounce`, `column` | kinds: of a grain, of a column of `series.csv` |
//! | `heap`, `oblique`, `end` | kinds: of heaps, of collisions, of planes and solvers |
//! | `accumulator`, `course`, `line`, `trajectory`, `subject`, `last` | what they keep |
//! | `deposit`, `touching` | the profile of a heap, and which grains belong to it |

mod accumulator;
mod bounce;
mod column;
mod course;
mod deposit;
mod end;
mod heap;
mod last;
mod line;
mod measure;
mod oblique;
mod rule;
mod subject;
mod touching;
mod trajectory;

pub use accumulator::{Accumulator, Between, Passages};
pub use course::Course;
pub use line::Line;
pub use measure::{Metrics, MetricsState};
pub use trajectory::{Crossing, Trajectory};
