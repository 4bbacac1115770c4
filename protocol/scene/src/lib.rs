//! The scene: the one file a user writes. Shared facts are typed here; `[fluid]`, `[dem]` and
//! `[coupling]` belong to their crates, which read them with [`SceneSource::section`].
//!
//! SI units, or any consistent set. `docs/scene.md` documents every key.

mod changing;
mod checked;
mod domain;
mod error;
mod file_names;
mod files;
mod form;
mod grain_table;
mod grains;
mod insertions;
mod layout;
mod metric;
mod observe;
mod open;
mod over_time;
mod random;
mod rest;
mod retired;
mod rough_walls;
mod shared;
mod source;
pub mod speeds;
pub mod table;
mod validate;
mod walls;
mod walls_in_box;

pub use bedload_outline::Outline;
pub use bedload_over_time::{OverTime, Sine, peak_of_sum};
pub use changing::{Changing, changing};
pub use checked::CheckedScene;
pub use domain::{
    Axis, Boundary, Domain, Face, Faces, FlowRate, Geometry, InflowProfile, InitialVelocity, Medium,
    Stretching, WallKind,
};
pub use error::SceneError;
pub use file_names::{FILE_NAME, OUTPUT_FILES, is_file_name};
pub use grains::{Freedom, Grain, GrainFile, Group, Motion, Shape};
pub use insertions::{Inserted, Insertion};
pub use metric::{
    Column, HeapEnd, HeapReference, HeapSlope, InRange, MeanFrom, MeanOf, MeanTest, Metric, MetricKind,
    OfColumn, OfComponent, OfGrain, OfSurface, SUPERFICIAL, Span,
};
pub use observe::{Observe, ObservedPlanes, ObservedSubsteps, ObservedTotals, Profile, Total};
pub use over_time::acts_along;
pub use random::SplitMix64;
pub use rest::Rest;
pub use retired::Retired;
pub use rough_walls::{Arrangement, RoughWall};
pub use shared::{Scene, StopWhen};
pub use source::{SceneSource, schema};
pub use walls::{Appearing, Servo, Wall};
