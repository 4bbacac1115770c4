//! What does not change over a run: walls, periods, laws.

use crate::laws::table::LawTable;
use crate::laws::walls::Plane;
use crate::periods::Periods;

/// What does not change over a run.
#[derive(Clone, Debug)]
pub(crate) struct Surroundings {
    /// Walls.
    pub(crate) walls: Vec<Plane>,
    /// Periodic directions.
    pub(crate) periods: Periods,
    /// Laws by materials.
    pub(crate) laws: LawTable,
    /// Gap below which gaps are watched, m.
    pub(crate) range: f64,
}
