//! What does not change over a run: walls, periods, laws.

use crate::laws::table::LawTable;
use crate::laws::walls::Plane;
use crate::periods::Periods;

/// What does not change over a run.
#[derive(Clone, Debug)]
pub struct Surroundings {
    /// Walls.
    pub walls: Vec<Plane>,
    /// Periodic directions.
    pub periods: Periods,
    /// Laws by materials.
    pub laws: LawTable,
    /// Gap below which gaps are watched, m.
    pub range: f64,
}
