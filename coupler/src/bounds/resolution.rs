//! The grid against the grains, and memory against the machine.

use protocol::facts::Side;

use super::bound::Bound;
use super::facts::Facts;
use crate::resolution::LEAST;

pub(super) fn add(facts: &Facts<'_>, bounds: &mut Vec<Bound>) {
    // What a cell does to a grain was measured with our fluid; another one may have none.
    if facts.fluid.is_some_and(|fluid| !fluid.foreign) {
        add_resolution(facts, bounds);
    }
    add_memory(facts, bounds);
}

fn add_resolution(facts: &Facts<'_>, bounds: &mut Vec<Bound>) {
    let Some(cells) = crate::resolution::of(facts.scene) else { return };
    bounds.push(Bound::new("resolution", "D/Δx", cells, Side::AtLeast, LEAST).because(
        "nothing was measured on coarser grids; a rebound at 5 is already 28 % too high",
        "docs/numerics.md, Resolution",
        "refine domain.cells, or enlarge the smallest grain",
    ));
    bounds.push(Bound::new("resolution-accuracy", "D/Δx", cells, Side::AtLeast, 8.0).warning().because(
        "slow drag is right to a few per cent from 8 cells per diameter on",
        "docs/numerics.md, Resolution",
        "refine domain.cells",
    ));
}

fn add_memory(facts: &Facts<'_>, bounds: &mut Vec<Bound>) {
    let needed = facts.fluid.map_or(0, |fluid| fluid.memory) + facts.dem.map_or(0, |dem| dem.memory);
    let Some(available) = facts.memory.filter(|_| needed > 0) else { return };
    bounds.push(Bound::new("memory", "bytes", needed as f64, Side::AtMost, available as f64).because(
        "the machine has not that much memory to give: it would swap, or kill a solver",
        "MemAvailable, limits of control groups",
        "coarsen domain.cells, take fewer grains, or a larger machine",
    ));
}
