//! Numbers for `summary.json`, accumulated window by window in constant memory.
//!
//! | file | what it holds |
//! |---|---|
//! | `measure` | all metrics of a scene, fed window by window |
//! | `accumulator`, `line`, `trajectory`, `subject`, `outcome` | what they keep, and what it comes to |
//! | `last` | metrics of the last state of all grains |
//! | `bounce` | a sphere that settles and bounces |
//! | `course` | a published course of a column |
//! | `deposit`, `touching` | heaps and collapsed columns |
//! | `haff` | a cooling granular gas |
//! | `oblique` | oblique collisions |
//! | `shields` | a bed under shear |

mod accumulator;
mod bounce;
mod course;
mod deposit;
mod haff;
mod last;
mod line;
mod measure;
mod oblique;
mod outcome;
mod shields;
mod subject;
mod touching;
mod trajectory;

pub use accumulator::{Accumulator, Passages};
pub use course::Course;
pub use line::Line;
pub use measure::{Metrics, MetricsState};
pub use trajectory::{Crossing, Trajectory};
