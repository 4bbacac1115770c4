//! Memory of a run, estimated before anything is laid out.

use crate::grid::Grid;
use crate::methods::calibrated::room;
use crate::methods::needs::Needs;
use bedload_scene::{CheckedScene, SceneError};
use protocol::memory::Available;

/// Program, grains, lines and planes of working memory, bytes: measured, at most 12 MiB below 10⁶ cells.
const BASE: u64 = 12 << 20;

/// The MPI library and more of the program, for each of several ranks, bytes: measured with Open MPI 4.1.
const RANK: u64 = 21 << 20;

/// Planes of each field that a rank touches beside its own: those of its neighbours, beyond walls, what is
/// sent.
const BESIDE: usize = 6;

/// Planes of numbers that a rank keeps for each edge that it sends with implicit viscosity. These are upper
/// bounds of the resident memory measured at 128³ and 192³ on 2, 4 and 8 ranks.
const EDGES: usize = 40;

/// Which ranks the memory of a machine must do for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// Ranks on the machine.
    pub ranks: usize,
    /// Planes of the one that has most; zero: there is one process, which has all.
    pub planes: usize,
    /// Edges that the one with most sends.
    pub edges: usize,
}

impl Share {
    /// One process has all.
    pub const WHOLE: Self = Self { ranks: 1, planes: 0, edges: 0 };
}

/// What decides the number of fields.
#[derive(Clone, Copy, Debug)]
pub struct Demand {
    /// What the method keeps.
    pub needs: Needs,
    /// Whether viscosity is implicit.
    pub implicit: bool,
    /// Whether windows are repeated, from a copy of the state at their start.
    pub repeated: bool,
    /// Kept of what the grains hold of the grid, bytes.
    pub held: u64,
    /// Kept of convection near grains, bytes: a rank has the part of its planes.
    pub near: u64,
    /// Fields of the run that this one starts from, which every rank reads whole, bytes.
    pub start: u64,
}

/// Bytes that a run takes on a machine.
///
/// In fields of the grid, each with its pads: velocity, history, pressure and the carried force, once more
/// where windows are repeated, and the working memory of the step. The latter is measured, as resident
/// memory, at 128³ and 1448² cells: 1 field in space, 3 more with implicit viscosity; on two axes 7, and 10
/// more for the factors of the viscous solvers. A rank has its planes and some beside them; what is kept of
/// the grains is counted whole for each, as are the fields of a run that this one starts from, though they go
/// before the first window.
pub fn estimate<const D: usize>(grid: &Grid<D>, demand: Demand, share: Share) -> u64 {
    let Demand { needs, implicit, repeated, held, near, start } = demand;
    let axes = D as u64;
    let kept = axes * (2 + u64::from(needs.force) + u64::from(needs.transport.is_some())) + 1;
    let work = match (D, implicit) {
        (2, false) => 7,
        (2, true) => 17,
        (_, false) => 1,
        (_, true) => 4,
    };
    // φ of what is projected.
    let jumps = u64::from(needs.jumps && D == 3);
    let fields = (1 + u64::from(repeated)) * kept + work + room(&needs, D) as u64 + jumps;
    if share.planes == 0 {
        return BASE + held + near + start + 8 * grid.len() as u64 * fields;
    }
    let edges = if implicit { EDGES * share.edges } else { 0 } as u64;
    let near = near * (share.planes + 2) as u64 / grid.cells[D - 1] as u64;
    let planes = (share.planes + BESIDE) as u64 * fields + edges;
    share.ranks as u64 * (BASE + RANK + held + near + start + 8 * planes * grid.stride(D - 1) as u64)
}

/// Refuses, at `domain.cells`, what does not fit, where the system tells what there is.
pub fn check(scene: &CheckedScene, needed: u64, available: Option<&Available>) -> Result<(), SceneError> {
    let Some(available) = available.filter(|available| needed > available.bytes) else { return Ok(()) };
    let domain = &scene.scene.domain;
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    // Per axis, in proportion: what would fit into nine tenths.
    let shrink = (0.9 * available.bytes as f64 / needed as f64).powf(1.0 / domain.dimensions() as f64);
    let fitting: Vec<u64> = domain.cells.iter().map(|n| (*n as f64 * shrink) as u64).collect();
    Err(scene.source.error(
        "domain.cells",
        format!(
            "asks for {:?} cells, which take {:.2} GiB; this machine has {:.2} GiB to give ({})",
            domain.cells,
            gib(needed),
            gib(available.bytes),
            available.source
        ),
        &format!(
            "coarsen the grid ({fitting:?} would fit), shrink the box, use a plane or axisymmetric geometry, \
             or free memory"
        ),
    ))
}
