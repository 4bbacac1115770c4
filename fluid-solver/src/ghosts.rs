//! The planes beside a rank's own ones, fetched from the ranks that own them.
//!
//! Fields have the indices of the whole grid, so a plane that is fetched goes where it stands there: on a periodic axis
//! the plane below the first is the last one.

use crate::division::Division;
use crate::grid::Grid;
use std::ops::Range;

/// What a rank needs to fetch planes.
#[derive(Clone, Debug)]
pub(crate) struct Ghosts {
    division: Division,
    planes: usize,
    periodic: bool,
    /// Where plane 0 begins in a field, and its length.
    first: usize,
    stride: usize,
}

/// On which sides of the own planes a field is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// Below.
    Below,
    /// Above.
    Above,
    /// Both.
    Both,
}

/// A field, and where it is wanted.
pub(crate) type Wanted<'a> = (&'a mut [f64], Side);

impl Ghosts {
    /// Of the planes of a grid.
    pub(crate) fn new<const D: usize>(grid: &Grid<D>) -> Self {
        Self {
            division: grid.division.clone(),
            planes: grid.cells[D - 1],
            periodic: grid.periodic(D - 1),
            first: grid.planes(0, 0).start,
            stride: grid.stride(D - 1),
        }
    }

    /// The same with `each` numbers for a plane, from the beginning of an array on.
    pub(crate) fn packed<const D: usize>(grid: &Grid<D>, each: usize) -> Self {
        Self { first: 0, stride: each, ..Self::new(grid) }
    }

    /// Where `width` planes from plane `k` on stand, counted round the axis.
    fn place(&self, k: usize, width: usize) -> Range<usize> {
        let first = self.first + k % self.planes * self.stride;
        first..first + width * self.stride
    }

    /// Sets the planes beside the own ones to zero.
    pub(crate) fn forget(&self, field: &mut [f64]) {
        if !self.division.ranks().is_alone() {
            let own = self.division.own();
            field[self.place(own.start + self.planes - 1, 1)].fill(0.0);
            field[self.place(own.end, 1)].fill(0.0);
        }
    }

    /// Fetches `width` planes of every field on the sides where it is wanted; no slab has fewer planes.
    pub(crate) fn fetch(&self, width: usize, fields: &mut [Wanted<'_>]) {
        let (ranks, own) = (self.division.ranks(), self.division.own());
        if ranks.is_alone() {
            return;
        }
        let places = [
            self.place(own.start + self.planes - width, width),
            self.place(own.end, width),
            self.place(own.end - width, width),
            self.place(own.start, width),
        ];
        let sides = [Side::Above, Side::Below];
        let wants = |side: Side, not: Side| side != not;
        // What goes up is wanted below the rank above.
        let pack = |place: &Range<usize>, not: Side| -> Vec<f64> {
            let wanted = fields.iter().filter(|(_, side)| wants(*side, not));
            wanted.flat_map(|(field, _)| &field[place.clone()]).copied().collect()
        };
        let [up, down] = [pack(&places[2], sides[0]), pack(&places[3], sides[1])];
        let mut into = [vec![0.0; up.len()], vec![0.0; down.len()]];
        let [below, above] = self.division.neighbours(self.periodic);
        let mut messages = Vec::new();
        messages.extend(below.filter(|_| !down.is_empty()).map(|rank| (rank, &down[..])));
        messages.extend(above.filter(|_| !up.is_empty()).map(|rank| (rank, &up[..])));
        let [from_below, from_above] = &mut into;
        let mut room = Vec::new();
        room.extend(above.filter(|_| !down.is_empty()).map(|rank| (rank, &mut from_above[..])));
        room.extend(below.filter(|_| !up.is_empty()).map(|rank| (rank, &mut from_below[..])));
        ranks.exchange(&messages, &mut room);
        for (from, (rank, (place, not))) in
            into.iter().zip([below, above].iter().zip(places.iter().zip(sides)))
        {
            let wanted = fields.iter_mut().filter(|(_, side)| rank.is_some() && wants(*side, not));
            for ((field, _), from) in wanted.zip(from.chunks(width * self.stride)) {
                field[place.clone()].copy_from_slice(from);
            }
        }
    }
}
