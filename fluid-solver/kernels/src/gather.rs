//! Fields whose planes several ranks have, brought together on the first one.

use crate::field::own_planes;
use crate::grid::Grid;
use std::ops::Range;

/// Where the planes of rank `rank` lie in a field.
fn place<const D: usize>(grid: &Grid<D>, rank: usize) -> Range<usize> {
    let planes = grid.division.of(rank);
    grid.planes(planes.start as isize, planes.end as isize)
}

/// Every field whole on the first rank, in its own memory; says whether this is it.
pub fn to_first<'a, const D: usize>(grid: &Grid<D>, fields: impl Iterator<Item = &'a mut Vec<f64>>) -> bool {
    let ranks = grid.division.ranks();
    for field in fields {
        if !ranks.is_first() {
            ranks.exchange(&[(0, &field[own_planes(grid)])], &mut []);
            continue;
        }
        for rank in 1..ranks.size() {
            ranks.exchange(&[], &mut [(rank, &mut field[place(grid, rank)])]);
        }
    }
    ranks.is_first()
}
