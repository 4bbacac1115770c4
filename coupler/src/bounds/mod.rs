//! Every bound on stability and accuracy that a plan is checked by.
//!
//! What depends on the exchange or on the scene alone is checked here, one model a file; what depends on a
//! solver's insides the solver says itself ([`protocol::facts::SolverBound`]). `bedload check` prints each
//! with its margin, and a run refuses to start while one of level [`Level::Refuse`] is broken and not forced.

mod bound;
pub(crate) mod drag;
mod facts;
pub(crate) mod names;
mod resolution;
mod speeds;
mod steps;

pub use bound::Bound;
pub use drag::{Drag, DragChart, DragError, DragGrid};
pub use facts::{Facts, TimeSteps};
pub use names::NAMES;
pub use protocol::facts::{Level, Side};
pub(crate) use speeds::{MOST_OVERLAP, largest_overlap};

/// Every bound that applies to a plan, the coupler's and the solvers', in the order of [`NAMES`]; `drag`:
/// what the chart says of its scene.
pub fn all(facts: &Facts<'_>, drag: Option<&Drag>) -> Vec<Bound> {
    let mut bounds = Vec::new();
    steps::add(facts, &mut bounds);
    resolution::add(facts, &mut bounds);
    bounds.extend(drag.and_then(Drag::bound));
    speeds::add(facts, &mut bounds);
    let fluid = facts.fluid.into_iter().flat_map(|fluid| &fluid.bounds);
    let dem = facts.dem.into_iter().flat_map(|dem| &dem.bounds);
    let own = fluid.chain(dem).map(|bound| speeds::with_speeds(bound, facts));
    bounds.extend(own.filter_map(|bound| Bound::of_solver(&bound, facts.scheme, &facts.steps)));
    // Names of foreign solvers come last, as the solver has them.
    bounds.sort_by_key(|bound| NAMES.iter().position(|name| *name == bound.name).unwrap_or(NAMES.len()));
    bounds
}
