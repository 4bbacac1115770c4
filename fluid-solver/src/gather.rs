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
pub(crate) fn to_first<'a, const D: usize>(
    grid: &Grid<D>,
    fields: impl Iterator<Item = &'a mut Vec<f64>>,
) -> bool {
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

/// A field as it is written: with what the other ranks have of it, which is fetched on the way.
pub(crate) struct Gathered<'a, const D: usize> {
    pub(crate) grid: &'a Grid<D>,
    pub(crate) field: &'a [f64],
}

impl<const D: usize> serde::Serialize for Gathered<'_, D> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeSeq;
        let Self { grid, field } = *self;
        let mut values = serializer.serialize_seq(Some(field.len()))?;
        let ranks = grid.division.ranks();
        let mut next = 0;
        let mut put = |part: &[f64]| part.iter().try_for_each(|value| values.serialize_element(value));
        if field.len() == grid.len() && !ranks.is_alone() {
            let mut room = Vec::new();
            for rank in 0..ranks.size() {
                let place = place(grid, rank);
                put(&field[next..place.start])?;
                next = place.end;
                if rank == 0 {
                    put(&field[place])?;
                    continue;
                }
                room.resize(place.len(), 0.0);
                ranks.exchange(&[], &mut [(rank, &mut room)]);
                ranks.check().map_err(serde::ser::Error::custom)?;
                put(&room)?;
            }
        }
        put(&field[next..])?;
        values.end()
    }
}

/// What the other ranks do while the first one writes [`Gathered`] fields.
pub(crate) fn send_to_first<'a, const D: usize>(grid: &Grid<D>, fields: impl Iterator<Item = &'a [f64]>) {
    let ranks = grid.division.ranks();
    for field in fields.filter(|field| field.len() == grid.len()) {
        ranks.exchange(&[(0, &field[own_planes(grid)])], &mut []);
    }
}
