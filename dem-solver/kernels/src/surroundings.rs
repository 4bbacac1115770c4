//! What does not change over a run: walls, periods, the law of contact.

use crate::laws::rolling::Rolling;
use crate::laws::table::PairLaw;
use crate::laws::walls::Plane;
use crate::periods::Periods;

#[derive(Clone, Debug)]
pub(crate) struct Surroundings {
    pub(crate) walls: Vec<Plane>,
    pub(crate) periods: Periods,
    pub(crate) law: PairLaw,
    /// Resistance to rolling, if there is one.
    pub(crate) rolling: Option<Rolling>,
    /// Gap below which gaps are watched, m.
    pub(crate) range: f64,
}
