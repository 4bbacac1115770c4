//! Numbers for `summary.json`, accumulated window by window in constant memory.

mod accumulator;
mod deposit;
mod last;
mod line;
mod measure;
mod oblique;
mod subject;
mod touching;
mod trajectory;

pub use accumulator::{Accumulator, Passages};
pub use line::Line;
pub use measure::{Metrics, MetricsState};
pub use trajectory::{Crossing, Trajectory};
